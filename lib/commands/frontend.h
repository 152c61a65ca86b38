/* SPDX-License-Identifier: MIT */
/*
 * The interface between a build and its front end, which makes the fragment list. A front end may propose any superset
 * of the voxels that a triangle touches. An exact test accepts or rejects each, so all front ends make the same
 * fragments.
 */
#ifndef SVO_LIB_COMMANDS_FRONTEND_H
#define SVO_LIB_COMMANDS_FRONTEND_H

#include "commands/commands.h"

/* One chunk of the fragment list. */
typedef struct svo_i_fragments {
    cl_mem buffer;
    uint64_t needed; /* fragments that the chunk's draws make; the capacity if only the device knows the count */
    uint64_t capacity; /* fragments that the buffer can hold; the chunk is complete if needed <= capacity */
    void *owner; /* for use by the front end */
} svo_i_fragments;

typedef struct svo_i_fragment_list {
    svo_i_fragments *chunks;
    uint32_t chunk_count;
    cl_mem counters; /* low and high word of each chunk's count, if only the device knows the counts; else NULL */
} svo_i_fragment_list;

struct svo_i_build; /* stages/build_state.h */

struct svo_frontend {
    const char *name; /* "cl", "gl-expand", ... */
    const char *share; /* "none", "host", ... */
    const char *renderer; /* OpenGL's; NULL without OpenGL */
    void *self; /* first argument of the functions below */
    svo_device *device;
    uint64_t chunk_bytes_max; /* largest chunk that the front end can write */
    /* True: voxelize issues the build's own OpenCL commands. It runs in every mode. In modes that do not wait, the
       counts remain on the device. False: voxelize draws immediately and returns counts on the host. It runs in
       SVO_I_MODE_RUN and SVO_I_MODE_ENQUEUE only. */
    bool on_device;

    /* Compiles what the plan's draws need. Adds newly compiled OpenCL programs to warm_up. */
    svo_status (*prepare)(void *self, svo_plan *plan, svo_i_warm_up *warm_up);
    /* Draws the chunking's chunks into list->chunks, which the caller has allocated and zeroed. Each chunk gets one
       buffer. All its fragments are counted, even those that do not fit. Adds the times of drawing and of transfer to
       the report, and the front end's own OpenCL buffers to the plan's list. In SVO_I_MODE_RUN the caller lists the
       buffers of the chunks. */
    svo_status (*voxelize)(void *self, svo_i_commands *commands, const svo_i_chunking *chunking,
                           svo_i_fragment_list *list);
    /* Releases the buffers of a list, also after a voxelize that failed. */
    void (*release)(void *self, svo_i_fragment_list *list);
    /* Frees self, for svo_frontend_destroy; NULL if another object owns the front end. */
    void (*destroy)(void *self);

    /* NULL: the table of stages builds the tree with OpenCL. Otherwise this function builds it, from chunks whose
       buffers may be NULL, into the tree's OpenCL buffers and its info. prepare has compiled what it needs. */
    svo_status (*make_tree)(void *self, struct svo_i_build *build);
    const char *builder; /* name of the builder that make_tree is, for the report */
};

/* Calls voxelize. Front ends of OpenGL get the plan's arrays on the host first. */
svo_status svo_i_frontend_voxelize(svo_frontend *frontend, svo_i_commands *commands, const svo_i_chunking *chunking,
                                   svo_i_fragment_list *list);

#endif
