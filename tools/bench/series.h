/* SPDX-License-Identifier: MIT */
/*
 * The same mesh built by several ways interleaved: one build by each, then again, so that what disturbs the machine
 * disturbs all of them, and ratios are taken turn by turn.
 */
#ifndef SVOCL_TOOLS_BENCH_SERIES_H
#define SVOCL_TOOLS_BENCH_SERIES_H

#include "measure/spread.h"
#include "measure/suite.h"

/* One way from the mesh to the tree, and what came of it. */
typedef struct series_method {
    const char *name;
    svo_frontend *frontend; /* NULL: there is none, and the reason says why */
    bool in_gl; /* by OpenGL's compute shaders */
    svo_plan_options plan;
    bool for_rays; /* with the boxes that rays walk through: SERIES_RAYS */

    char reason[256]; /* not "": this way does not work here, or not at this size */
    double *times; /* [turn][SERIES_CLOCKS], the first turn apart at the front */
    size_t turns; /* after the first */
    svo_build_report report; /* of the last build */
    svo_tree_info info;
    uint64_t peak_bytes, list_bytes, tree_bytes; /* of device memory: at most at one time; the list; what remains */
    uint64_t ray_bytes; /* of the boxes */
} series_method;

/* Times of a build: the stages of the report, the wall clock around plan and build together, and the wall clock around
   svo_tree_prepare_rays. */
#define SERIES_WALL       SVO_STAGE_COUNT
#define SERIES_RAYS       (SVO_STAGE_COUNT + 1)
#define SERIES_CLOCKS     (SVO_STAGE_COUNT + 2)
#define SERIES_BIT(stage) (1u << (stage))
/* From the mesh on the host to the finished tree, without the compiler. */
#define SERIES_BUILD \
    (SERIES_BIT(SVO_STAGE_GRID) | SERIES_BIT(SVO_STAGE_VOXELIZE) | SERIES_BIT(SVO_STAGE_TRANSFER) | SERIES_TREE)
/* From the fragment list to the finished tree. */
#define SERIES_TREE                                                                              \
    (SERIES_BIT(SVO_STAGE_SUBDIVIDE) | SERIES_BIT(SVO_STAGE_LINK) | SERIES_BIT(SVO_STAGE_PACK) | \
     SERIES_BIT(SVO_STAGE_FILTER))

/* Adds a row for a way that works; first: the first way, which others are compared with. */
typedef void (*series_row)(result_table *table, const input *source, unsigned depth, const series_method *method,
                           const series_method *first);

/*
 * Builds the mesh by every way, the first turn and all->repeats more, and adds a row for each to the table of that id.
 * Why a way does not work goes into the table's note. Any other failure ends the bench, and so do ways that make
 * different numbers of fragments or nodes: one that makes something else is no faster way to the same tree.
 * Returns the exit code, its line printed. Nothing of the ways stays allocated.
 */
int series_run(suite *all, const char *table_id, const input *source, unsigned depth, series_method *methods,
               size_t method_count, series_row add_row);

/* The same in steps, for what takes turns with something else: room for all turns, false without memory; one turn of a
   way; the end of it. */
bool series_begin(const suite *all, series_method *methods, size_t method_count);
int series_turn(suite *all, const svo_mesh *mesh, unsigned depth, series_method *method, size_t round);
void series_release(series_method *methods, size_t method_count);

/* Milliseconds of the clocks in a set of SERIES_BITs, added up turn by turn. */
spread series_ms(const series_method *method, unsigned clocks);
/* In one turn of those that worked. */
double series_turn_ms(const series_method *method, size_t round, unsigned clocks);
/* In the first turn. NAN where the way does not work. */
double series_first_ms(const series_method *method, unsigned clocks);
/* How many times as long as another way, turn by turn. */
spread series_ratio(const series_method *method, const series_method *other, unsigned clocks);
/* "cl-event", "gl-timer" or "wall"; "" where the stage did not run. */
const char *series_clock(const series_method *method, svo_stage stage);

/* The front ends of the session: NULL with the reason in the way. */
void series_use_cl(suite *all, series_method *method);
void series_use_gl(suite *all, int frontend, int share, series_method *method);
/* The builder of OpenGL's compute shaders in place of OpenCL. */
void series_use_gl_compute(suite *all, series_method *method);

#endif
