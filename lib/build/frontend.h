/* SPDX-License-Identifier: MIT */
/*
 * The narrow interface between the builder and whatever makes the fragment list. A front end proposes any superset of
 * the touched voxels and lets the integer test decide, so no two front ends can differ.
 */
#ifndef SVO_LIB_BUILD_FRONTEND_H
#define SVO_LIB_BUILD_FRONTEND_H

#include "plan/plan.h"
#include "svocl/build.h"

/* One chunk of the list, readable by OpenCL. */
typedef struct svo_i_fragments {
    cl_mem buffer;
    uint64_t needed; /* fragments the chunk's draws make */
    uint64_t capacity; /* fragments the buffer holds; the list is whole when needed <= capacity */
    void *owner; /* the front end's */
} svo_i_fragments;

typedef struct svo_i_fragment_list {
    svo_i_fragments *chunks;
    uint32_t chunk_count;
} svo_i_fragment_list;

struct svo_i_build; /* build.h */

struct svo_frontend {
    const char *name; /* "cl", "gl-expand", ... */
    const char *share; /* "none", "host", ... */
    const char *renderer; /* OpenGL's; NULL without OpenGL */
    void *self;
    svo_device *device;
    uint64_t chunk_bytes_max; /* largest chunk the front end can write */

    /* Compiles what the plan's draws need. */
    svo_status (*prepare)(void *self, svo_plan *plan, cl_command_queue queue);
    /* Draws the layout into list->chunks (chunk_count entries, zeroed): one buffer per chunk, counted to the end
       whether or not it fits. Adds the times of drawing and of handing over to the report's stages, and OpenCL buffers
       of the front end's own to the plan's list. */
    svo_status (*voxelize)(void *self, svo_plan *plan, const svo_i_layout *layout, cl_command_queue queue,
                           svo_i_fragment_list *list, svo_build_report *report);
    /* NULL: it cannot. Otherwise the same for a build that does not wait: into build->list (as many chunks as the
       layout), in the build's own buffers, counted by build->counters alone. */
    svo_status (*enqueue)(struct svo_i_build *build, const svo_i_layout *layout);
    /* Releases the buffers of a list, also of one that voxelize left half done. */
    void (*release)(void *self, svo_i_fragment_list *list);
    /* Frees self, for svo_frontend_destroy; NULL where something else owns the front end. */
    void (*destroy)(void *self);

    /* NULL: OpenCL makes the tree of the list. Otherwise the front end does, of chunks that it kept to itself (their
       buffers may be NULL), into the tree's OpenCL buffers and its info; prepare has compiled what it needs. */
    svo_status (*make_tree)(void *self, struct svo_i_build *build);
    const char *builder; /* the name of that way, for the report */
};

/* Adds to a stage's time. clock: a static string. */
static inline void svo_i_report_add(svo_build_report *report, svo_stage stage, double ms, const char *clock)
{
    report->stage_times[stage].ms += ms;
    report->stage_times[stage].clock = clock;
}

#endif
