/* SPDX-License-Identifier: MIT */
/*
 * What `svocl tune` may choose: the dimensions of --free, their values, and the settings that are their product. A
 * setting is a command line of svocl's, and fields of the C library's options.
 */
#ifndef SVOCL_TOOLS_TUNE_DIMENSIONS_H
#define SVOCL_TOOLS_TUNE_DIMENSIONS_H

#include <stdbool.h>
#include <stddef.h>

#include "support/program.h"
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
    DIMENSION_GATHER, /* cones, or minus the paths of rays; 0: nothing is gathered */
    DIMENSION_COUNT
} tune_dimension;

#define DIMENSION_VALUES_MAX 16u
#define TUNE_SETTINGS_MAX    1024u

/* Of each dimension the values that are tried, at least one. */
typedef struct tune_space {
    int values[DIMENSION_COUNT][DIMENSION_VALUES_MAX];
    size_t counts[DIMENSION_COUNT];
    bool is_free[DIMENSION_COUNT];
} tune_space;

typedef struct tune_setting {
    int values[DIMENSION_COUNT];
} tune_setting;

/* The names of dimensions, which --free and files have. */
const char *dimension_name(tune_dimension which);
/* The name of a value, "half-open" or "9"; cones and rays: "16 cones", "64 rays". */
void dimension_value(tune_dimension which, int value, char *text, size_t text_bytes);

/* What the options fix, and what --free lets vary: "depth:7-9,coverage,builder:cl+sorted,cones:5+16,rays". A name
   without values means all. Without --free depth, coverage, weights and builder are free. gathers: something is
   gathered, by some numbers of cones and rays if these are not named. depths: of a free depth without values; ends with
   0. Returns the exit code. */
int tune_space_read(program *state, const unsigned *depths, bool gathers, tune_space *space);

/* The settings, without those that are another one under a second name: the share path of a front end of OpenCL's, the
   light's form for rays. settings: room for TUNE_SETTINGS_MAX. Returns the exit code. */
int tune_space_list(program *state, const tune_space *space, tune_setting *settings, size_t *count);

/* The command that does what a setting does, for a shell: `svocl build` or, where something is gathered, `svocl
   gather`, with what else is on the command line of tune. */
void tune_setting_command(const program *state, const tune_setting *setting, text_list *out);
/* The same in C. */
void tune_setting_code(const tune_setting *setting, text_list *out);

#endif
