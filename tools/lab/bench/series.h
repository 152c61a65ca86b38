/* SPDX-License-Identifier: MIT */
/*
 * Builds one mesh by several methods, interleaved: each round builds once by every method, so that disturbances of the
 * machine affect all methods alike. Ratios are taken within a round.
 */
#ifndef SVOCL_TOOLS_BENCH_SERIES_H
#define SVOCL_TOOLS_BENCH_SERIES_H

#include "measure/spread.h"
#include "measure/suite.h"

/* One method to build the tree, and its results. */
typedef struct series_method {
    const char *name;
    svo_frontend *frontend; /* NULL: there is none, and the reason says why */
    bool in_gl; /* by OpenGL's compute shaders */
    svo_plan_options plan;
    bool for_rays; /* builds the BVH for rays as well: SERIES_RAYS */

    char reason[SVO_MESSAGE_BYTES]; /* not "": why the method does not work here, or not at this size */
    double *times; /* [round][SERIES_CLOCKS]; round 0 is the warm-up */
    size_t rounds; /* after the warm-up */
    svo_build_report report; /* of the last build */
    svo_tree_info info;
    uint64_t peak_bytes, list_bytes, tree_bytes; /* of device memory: peak; fragment list; finished tree */
    uint64_t ray_bytes; /* of the BVH */
} series_method;

/* Times of a build: the stages of the report, the wall clock around plan and build together, and the wall clock around
   svo_tree_make_bvh. */
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

/* Adds a row for a method that works. first: the method that the others are compared with. */
typedef void (*series_row)(result_table *table, const input *source, unsigned depth, const series_method *method,
                           const series_method *first);

/*
 * Builds the mesh by every method in a warm-up round and all->repeats measured ones, and adds a row for each method to
 * the table of that ID. The table's note says why a method does not work. Any other failure ends the run, and so do
 * methods with different numbers of fragments or nodes: their times cannot be compared. Returns the exit code, its line
 * printed, with everything of the methods released.
 */
int series_run(suite *all, const char *table_id, const input *source, unsigned depth, series_method *methods,
               size_t method_count, series_row add_row);

/* The same in steps, to interleave with something else: allocates the times of all rounds, false without memory; builds
   once in a round; releases the times. */
bool series_begin(const suite *all, series_method *methods, size_t method_count);
int series_run_round(suite *all, const svo_mesh *mesh, unsigned depth, series_method *method, size_t round);
void series_release(series_method *methods, size_t method_count);

/* Milliseconds of the clocks in a set of SERIES_BITs, summed in each round. */
spread series_ms(const series_method *method, unsigned clocks);
/* The same in one round. */
double series_round_ms(const series_method *method, size_t round, unsigned clocks);
/* The same in the warm-up round. NAN where the method does not work. */
double series_first_ms(const series_method *method, unsigned clocks);
/* Time relative to another method, round by round. */
spread series_ratio(const series_method *method, const series_method *other, unsigned clocks);
/* "cl-event", "gl-timer" or "wall"; "" where the stage did not run. */
const char *series_clock(const series_method *method, svo_stage stage);

/* Selects a front end of the session; on failure sets the method's reason. */
void series_use_cl(suite *all, series_method *method);
void series_use_gl(suite *all, int frontend, int share, series_method *method);
/* Selects the builder by OpenGL compute shaders. */
void series_use_gl_compute(suite *all, series_method *method);

#endif
