/* SPDX-License-Identifier: MIT */
/*
 * One build in progress: what the OpenCL stages (subdivide.c, sorted.c, pack.c, material.c, filter.c) share. build.c
 * runs them in order; commands.c has what they ask of OpenCL, list.c makes the list they start from.
 *
 * Every launch waits for the one before it by an event, so the caller's queue may be out-of-order.
 */
#ifndef SVO_LIB_BUILD_BUILD_H
#define SVO_LIB_BUILD_BUILD_H

#include "build/allocations.h"
#include "build/frontend.h"
#include "core/program.h"
#include "core/tree.h"
#include "plan/tiles.h"

/* How far a build goes. The stages are the same; commands.c makes the difference. */
typedef enum svo_i_build_mode {
    SVO_I_BUILD_RUNS = 0, /* allocates, launches, waits for counts, grows where there was too little room */
    SVO_I_BUILD_MEASURES, /* writes down what it would allocate; nothing is launched, and counts are capacities */
    SVO_I_BUILD_ENQUEUES /* launches in memory that is there and never waits; counts are capacities */
} svo_i_build_mode;

/* The large triangles' tiles of a list of one chunk, found once for all builds that are enqueued. */
typedef struct svo_i_kept_tiles {
    svo_i_tiles tiles;
    size_t *begin; /* per draw, and the end; NULL: not found yet */
} svo_i_kept_tiles;

/* The launches of one stage, to be timed when they are done. */
typedef struct svo_i_span {
    svo_stage stage;
    cl_event first, last; /* owned */
} svo_i_span;
#define SVO_I_SPANS_MAX 24

typedef struct svo_i_build {
    svo_i_build_mode mode;
    svo_device *device;
    svo_plan *plan;
    cl_command_queue queue;
    bool profiling; /* the queue has CL_QUEUE_PROFILING_ENABLE */
    cl_program program;
    svo_build_report *report;

    svo_i_fragment_list list;
    bool owns_list; /* the build's own, else the front end's */
    uint64_t fragment_count; /* in all chunks */

    cl_event last; /* the newest launch; NULL at first */
    cl_event stage_first; /* the first launch of the open stage */
    double stage_start_ms; /* wall clock when it was opened */

    /* Measuring and enqueuing. */
    bool in_place; /* nodes stay where they were made, in arrays as large as the capacities */
    svo_i_allocations *allocations;
    size_t next_allocation;
    svo_i_kept_tiles *kept; /* NULL: the number of tiles is estimated */
    svo_i_span spans[SVO_I_SPANS_MAX];
    size_t span_count;

    /* Scratch. */
    cl_mem counters; /* of the front end, low and high word per chunk, where only the device has them */
    cl_mem *cursors; /* one per chunk */
    cl_mem state, partials;
    svo_build_state host_state; /* what state was filled from */
    uint64_t inner_capacity;

    /* The tree in the making. */
    svo_tree *tree;
} svo_i_build;

/* svo_build's name, for messages. */
#define SVO_I_BUILD "svo_build"

SVO_I_SHARED_BEGIN

/* Allocation that keeps the plan's list of buffers; release knows the bytes from the buffer itself. */
svo_status svo_i_build_alloc(svo_i_build *build, const char *name, uint64_t bytes, cl_mem *out);
/* The same, filled from the host. */
svo_status svo_i_build_upload(svo_i_build *build, const char *name, const void *data, uint64_t bytes, cl_mem *out);
/* Writes to the start of a buffer that is there. */
svo_status svo_i_build_write(svo_i_build *build, cl_mem buffer, const void *data, uint64_t bytes);
void svo_i_build_free(svo_i_build *build, cl_mem *buffer);

svo_status svo_i_build_fill(svo_i_build *build, cl_mem buffer, const void *pattern, size_t pattern_bytes,
                            uint64_t bytes);
svo_status svo_i_build_fill_zero(svo_i_build *build, cl_mem buffer, uint64_t bytes);
/* Copies bytes from the start of one buffer to an offset of another. */
svo_status svo_i_build_copy(svo_i_build *build, cl_mem from, cl_mem to, uint64_t to_offset, uint64_t bytes);
/* Waits for what was launched. */
svo_status svo_i_build_wait(svo_i_build *build);
/* list.c: has the front end make the list, until it is whole. */
svo_status svo_i_build_make_list(svo_i_build *build, svo_frontend *frontend);
/* Releases the list, whosever it is. */
void svo_i_build_release_list(svo_i_build *build, svo_frontend *frontend);
/* The status and the message for a list with fragments that none can be. */
svo_status svo_i_build_fail_damaged(svo_i_build *build);
/* Puts levels into the state on the device, which is made if there is none. */
svo_status svo_i_build_put_state(svo_i_build *build, const uint32_t level_begin[SVO_LEVELS_MAX]);
/* Cursors for the list's fragments, one buffer per chunk. */
svo_status svo_i_build_alloc_cursors(svo_i_build *build);
/* Waits, and reads bytes from the start of the buffer. */
svo_status svo_i_build_read(svo_i_build *build, cl_mem buffer, void *to, size_t bytes);

/* Sets all arguments and launches enough groups for items work-items; nothing for none. */
svo_status svo_i_build_launch(svo_i_build *build, cl_kernel kernel, const svo_i_argument *arguments,
                              cl_uint argument_count, uint64_t items);
svo_status svo_i_build_kernel(svo_i_build *build, const char *name, cl_kernel *out);
/* Both, for a kernel that is launched once or a few times a build. */
svo_status svo_i_build_run(svo_i_build *build, const char *name, const svo_i_argument *arguments,
                           cl_uint argument_count, uint64_t items);

/* What is wrong with the queue, or NULL. */
const char *svo_i_wrong_queue(const svo_device *device, cl_command_queue queue);
/* Whether report, NULL allowed, can be written; and writes it. */
svo_status svo_i_report_check(svo_device *device, const char *function, const svo_build_report *report);
void svo_i_report_write(const svo_build_report *made, svo_build_report *report);
/* Whether the queue has CL_QUEUE_PROFILING_ENABLE. */
bool svo_i_queue_profiles(cl_command_queue queue);
/* What rays need of the mesh, into the tree. */
svo_status svo_i_keep_geometry(svo_i_build *build);

/* build.c: what a build of the plan allocates, into the plan's list of buffers; and into allocations, which may be
   NULL, what one that is enqueued does. frontend: NULL for that of OpenCL alone. kept: NULL allowed. */
svo_status svo_i_build_measure(svo_plan *plan, const svo_frontend *frontend, const svo_i_layout *layout,
                               svo_i_allocations *allocations, svo_i_kept_tiles *kept);
/* build.c: kernels and shaders, as far as this device and context have not compiled them before. */
svo_status svo_i_build_compile(svo_i_build *build, svo_frontend *frontend);
/* build.c: everything from the list on, by OpenCL. */
svo_status svo_i_build_make_arrays(svo_i_build *build, svo_frontend *frontend);
/* build.c: what the plan says of a tree; and, for those that do not wait, capacities in place of its counts. */
void svo_i_build_fill_info(svo_i_build *build);
void svo_i_build_assume_counts(svo_i_build *build);
/* commands.c: the times of the spans, into the report, and lets go of their events. */
void svo_i_build_take_spans(svo_i_build *build);

/* Launches between begin and end are counted to the stage. Stages may be entered several times. */
void svo_i_build_stage_begin(svo_i_build *build);
svo_status svo_i_build_stage_end(svo_i_build *build, svo_stage stage);

/* warm.c: launches every kernel of build->program that the plan needs once on nothing, so that the driver compiles it
   now.
   kind: of the program. */
svo_status svo_i_build_warm(svo_i_build *build, svo_i_program_kind kind);
/* subdivide.c: masks, first children and level counts; cursors end up at the leaves. *fits is false when the inner
   nodes did not fit. Fills tree->info.level_begin and the counts. */
svo_status svo_i_subdivide(svo_i_build *build, bool *fits);
/* sorted.c: compiles what the builder "sorted" needs; takes the list over from the front end and makes the nodes of it,
   the tree->info and the cursors; list_begin, and list if asked for, of the sorted list. */
svo_status svo_i_sorted_prepare(svo_i_build *build);
svo_status svo_i_sorted(svo_i_build *build, svo_frontend *frontend);
svo_status svo_i_sorted_lists(svo_i_build *build, bool with_lists);
/* What the device's counts say at the end of the subdivision: *fits, and then the tree's counts. */
svo_status svo_i_take_state(svo_i_build *build, const svo_build_state *state, bool *fits);
/* pack.c: list_begin; and list, if asked for. */
svo_status svo_i_pack(svo_i_build *build, bool with_lists);
/* Radix passes of four bits that tell the triangles apart, an even number so that the result ends where it began. */
uint32_t svo_i_digit_passes(uint32_t triangle_count);

/* The mesh's attributes on the device; NULL where the plan does not have them. */
typedef struct svo_i_surface {
    cl_mem vertices, indices;
    bool is_borrowed; /* those two are the tree's */
    cl_mem records, colors, normals, uvs, materials, texels;
} svo_i_surface;
/* surface.c. Free also after a failure, and before the tree. */
svo_status svo_i_surface_upload(svo_i_build *build, svo_i_surface *out);
void svo_i_surface_free(svo_i_build *build, svo_i_surface *surface);
/* filter.c: what the payload kernels' parameters have in common; and those for the nodes of a level. */
svo_filter_params svo_i_payload_params(const svo_i_build *build);
void svo_i_params_of_level(svo_filter_params *params, const svo_tree_info *info, uint32_t level);

/* voxelize.c: svo_frontend.enqueue of the front end of OpenCL alone. */
svo_status svo_i_voxelize_enqueue(svo_i_build *build, const svo_i_layout *layout);

/* material.c: the nodes' materials. Needs list_begin. */
svo_status svo_i_material(svo_i_build *build, const svo_i_surface *surface);
/* filter.c: links the leaves, which uses up the cursors, and makes colors, normals and fills. */
svo_status svo_i_filter(svo_i_build *build, const svo_i_surface *surface);

SVO_I_SHARED_END

#endif
