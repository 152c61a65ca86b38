/* SPDX-License-Identifier: MIT */
/*
 * What `svocl tune` may choose: the dimensions of --free, their values, and the settings that are their product. A
 * setting is a command line of svocl's, and fields of the C library's options.
 */
#ifndef SVOCL_TOOLS_TUNE_DIMENSIONS_H
#define SVOCL_TOOLS_TUNE_DIMENSIONS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "support/program.h"
#include "svocl/mesh.h"
#include "tune/measures.h"
#include "tune/text_list.h"

typedef enum tune_dimension {
    DIMENSION_DEPTH = 0,
    DIMENSION_COVERAGE, /* svo_coverage */
    DIMENSION_WEIGHTS, /* svo_weights */
    DIMENSION_FRONTEND, /* option_frontend */
    DIMENSION_SHARE, /* svo_gl_share */
    DIMENSION_BUILDER, /* svo_builder or OPTION_BUILDER_GL_COMPUTE */
    DIMENSION_PATH, /* svo_path */
    DIMENSION_FORM, /* 0: the tree as it is built; else 1 + svo_form */
    DIMENSION_LIGHT_FORM, /* svo_light_form */
    DIMENSION_GATHER, /* GATHER_VALUE */
    DIMENSION_COUNT
} tune_dimension;

#define DIMENSION_VALUES_MAX 16u
#define TUNE_SETTINGS_MAX    1024u

/* How light is gathered. */
typedef enum tune_gather { GATHER_NOTHING = 0, GATHER_CONES, GATHER_RAYS, GATHER_PROBES } tune_gather;

/* count: cones; paths of rays; of probes GATHER_GRID: along an axis, and texels along a side of a map. Nothing is 0. */
#define GATHER_VALUE(how, count)   ((int)(how) << 24 | (int)(count))
#define GATHER_GRID(along, texels) ((along) << 12 | (texels))

static inline tune_gather gather_how(int value)
{
    return (tune_gather)(value >> 24);
}

static inline unsigned gather_count(int value)
{
    return (unsigned)value & 0xffffffu;
}

static inline unsigned gather_along(int value)
{
    return gather_count(value) >> 12;
}

static inline unsigned gather_texels(int value)
{
    return gather_count(value) & 0xfffu;
}

/* Sample points of what is gathered. */
#define GATHER_POINTS 512u

/* Of each dimension the values that are tried, at least one. */
typedef struct tune_space {
    int values[DIMENSION_COUNT][DIMENSION_VALUES_MAX];
    size_t counts[DIMENSION_COUNT];
    bool is_free[DIMENSION_COUNT];
} tune_space;

typedef struct tune_setting {
    int values[DIMENSION_COUNT];
    uint32_t need; /* svo_need bits of its tree; 0: occupancy alone */
    bool names_need; /* its command does: others choose the same by themselves */
} tune_setting;

/* The names of dimensions, which --free and files have. */
const char *dimension_name(tune_dimension which);
/* The name of a value, "half-open" or "9"; cones and rays: "16 cones", "64 rays". */
void dimension_value(tune_dimension which, int value, char *text, size_t text_bytes);

/* What something is gathered for without a way to do so in --free. */
typedef enum tune_wish {
    WISH_NONE = 0, /* nothing is gathered */
    WISH_GATHER, /* by some numbers of cones and rays */
    WISH_LIGHT /* and by some probes, which hold light alone */
} tune_wish;

/* What the options fix, and what --free lets vary: "depth:7-9,coverage,builder:cl+sorted,cones:5+16,rays,probes:4x64".
   A name without values means all. Without --free depth, coverage, weights and builder are free. depths: of a free
   depth without values; ends with 0. Returns the exit code. */
int tune_space_read(program *state, const unsigned *depths, tune_wish wish, tune_space *space);

/* The settings, without those that are another one under a second name: the share path of a front end of OpenCL's, the
   light's form for rays. settings: room for TUNE_SETTINGS_MAX. Returns the exit code. */
int tune_space_list(program *state, const tune_space *space, tune_setting *settings, size_t *count);

/* The svo_need bits that a way to gather adds to a tree of the mesh. */
uint32_t tune_gather_need(int gather, const svo_mesh *mesh);
/* "color,rays", as --need has it; "none". */
void tune_need_names(uint32_t need, text_list *out);

/* Why a setting has no value of a quantity, in some words; NULL: it has. */
const char *tune_setting_lacks(const tune_setting *setting, tune_quantity quantity);

/* The command that does what a setting does, for a shell: `svocl build` or, where something is gathered, `svocl gather`
   at the same points, or `svocl render` through probes, with what else is on the command line of tune. */
void tune_setting_command(const program *state, const tune_setting *setting, text_list *out);
/* The same in C. */
void tune_setting_code(const tune_setting *setting, text_list *out);
/* What the C options do and the command does not, in a sentence; "": it does all. */
const char *tune_setting_rest(const tune_setting *setting);

#endif
