/* SPDX-License-Identifier: MIT */
/* The factors of svocl bench gl-vs-cl, their values, and which are crossed. */
#ifndef SVOCL_TOOLS_BENCH_VERSUS_DESIGN_H
#define SVOCL_TOOLS_BENCH_VERSUS_DESIGN_H

#include "measure/suite.h"

/* The columns of cells: first the factors. */
typedef enum versus_column {
    VERSUS_SCENE,
    VERSUS_DEPTH,
    VERSUS_PATH,
    VERSUS_LIST,
    VERSUS_SHARE,
    VERSUS_BUILDER,
    VERSUS_NEED,
    VERSUS_WEIGHTS,
    VERSUS_COVERAGE,
    VERSUS_FACTORS,
    VERSUS_TRIANGLES = VERSUS_FACTORS,
    VERSUS_FRAGMENTS,
    VERSUS_NODES,
    VERSUS_PEAK,
    VERSUS_HASH,
    VERSUS_CLOCKS,
    VERSUS_REASON,
    VERSUS_COLUMNS
} versus_column;
#define VERSUS_BIT(factor) (1u << (factor))
#define VERSUS_METHOD \
    (VERSUS_BIT(VERSUS_PATH) | VERSUS_BIT(VERSUS_LIST) | VERSUS_BIT(VERSUS_SHARE) | VERSUS_BIT(VERSUS_BUILDER))
#define VERSUS_SETTING (VERSUS_BIT(VERSUS_FACTORS) - 1u - VERSUS_METHOD)

#define VERSUS_HYBRID_COLUMNS 64 /* of gl-hybrid, also by software, where the default rasterizes nothing */

/* A value of a factor, its name and the svo_path, option_frontend, svo_gl_share, builder, svo_need bits, svo_weights or
   svo_coverage. */
typedef struct versus_level {
    const char *name;
    int value;
} versus_level;
/* Of the factors from VERSUS_PATH on; ends with a name of NULL. */
const versus_level *versus_levels(versus_column factor);

typedef struct versus_cell {
    unsigned level[VERSUS_FACTORS]; /* of VERSUS_SCENE an index, of VERSUS_DEPTH the depth */
} versus_cell;

/* What is crossed: all scenes and depths, or the central ones. */
typedef struct versus_design {
    size_t scene_count;
    bool each_has_depths; /* each scene has all depths; else the first one */
    unsigned depth; /* central */
    unsigned depths[SUITE_LIST_MAX]; /* ends with 0 */
    bool full, quick;
    bool has_gpu_path; /* beside the device's own */
    unsigned own_path; /* level of it */
} versus_design;
/* Cells by malloc, each once, by scene, then by depth as the list has it; NULL when out of memory. */
versus_cell *versus_list(const versus_design *design, size_t *count);
/* Whether a cell has the central values of a set of VERSUS_BITs: the first scene, the central depth, first levels. */
bool versus_is_central(const versus_design *design, const versus_cell *cell, unsigned factors);

#endif
