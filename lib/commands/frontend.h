/* SPDX-License-Identifier: MIT */
/*
 * The narrow interface between a build and whatever makes the fragment list. A front end proposes any superset of the
 * touched voxels and lets the integer test decide, so no two front ends can differ.
 */
#ifndef SVO_LIB_COMMANDS_FRONTEND_H
#define SVO_LIB_COMMANDS_FRONTEND_H

#include "commands/commands.h"

/* One chunk of the list, readable by OpenCL. */
typedef struct svo_i_fragments {
    cl_mem buffer;
    uint64_t needed; /* fragments the chunk's draws make; their capacity where only the device has counted them */
    uint64_t capacity; /* fragments the buffer holds; the list is whole when needed <= capacity */
    void *owner; /* the front end's */
} svo_i_fragments;

typedef struct svo_i_fragment_list {
    svo_i_fragments *chunks;
    uint32_t chunk_count;
    cl_mem counters; /* a low and a high word per chunk, of a list that only the device has counted; else NULL */
} svo_i_fragment_list;

struct svo_i_build; /* stages/build_state.h */

struct svo_frontend {
    const char *name; /* "cl", "gl-expand", ... */
    const char *share; /* "none", "host", ... */
    const char *renderer; /* OpenGL's; NULL without OpenGL */
    void *self;
    svo_device *device;
    uint64_t chunk_bytes_max; /* largest chunk the front end can write */
    /* The list is made by commands of the build's: voxelize runs in every mode, and in those that do not wait the
       counts stay on the device. Otherwise it runs in SVO_I_MODE_RUN and SVO_I_MODE_ENQUEUE, at once, and counts on the
       host. */
    bool on_device;

    /* Compiles what the plan's draws need; adds fresh OpenCL programs to warm_up. */
    svo_status (*prepare)(void *self, svo_plan *plan, svo_i_warm_up *warm_up);
    /* Draws into list->chunks, as many as the chunking has, zeroed: one buffer per chunk, counted to the end whether or
       not it fits. Adds the times of drawing and of handing over to the report's stages, and OpenCL buffers of the
       front end's own to the plan's list; those of the chunks are listed by the caller in SVO_I_MODE_RUN. */
    svo_status (*voxelize)(void *self, svo_i_commands *commands, const svo_i_chunking *chunking,
                           svo_i_fragment_list *list);
    /* Releases the buffers of a list, also of one that voxelize left half done. */
    void (*release)(void *self, svo_i_fragment_list *list);
    /* Frees self, for svo_frontend_destroy; NULL where something else owns the front end. */
    void (*destroy)(void *self);

    /* NULL: OpenCL makes the tree of the list. Otherwise the front end does, of chunks that it kept to itself (their
       buffers may be NULL), into the tree's OpenCL buffers and its info; prepare has compiled what it needs. */
    svo_status (*make_tree)(void *self, struct svo_i_build *build);
    const char *builder; /* the name of that method, for the report */
};

#endif
