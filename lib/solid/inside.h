/* SPDX-License-Identifier: MIT */
/* Which empty children of a tree's inner nodes are inside the mesh, and which leaves have their center inside. */
#ifndef SVO_LIB_SOLID_INSIDE_H
#define SVO_LIB_SOLID_INSIDE_H

#include "core/tree.h"
#include "core/work.h"
#include "svocl/solid.h"

/* The share of generalized winding numbers in the progress of svo_solid_create. */
#define SVO_I_INSIDE_BEGIN 0.1
#define SVO_I_INSIDE_END   0.95

/* What the device found. */
typedef struct svo_i_inside {
    cl_mem mask; /* scratch of the work: a byte per inner node, bit o for an empty child in octant o that is inside */
    cl_mem leaves; /* the same: a byte per leaf, 1 if its center is inside; NULL if nobody asked for it */
    uint64_t count; /* of those children */
    uint64_t level_count[SVO_LEVELS_MAX]; /* the same by their level */
} svo_i_inside;

/* Who is told how far a call is. */
typedef struct svo_i_solid_progress {
    svo_solid_progress_callback callback; /* NULL: nobody */
    void *user;
} svo_i_solid_progress;

/* Tells a part of svo_solid_create, 0 .. 1. Returns SVO_CANCELED, with a message, when the callback stops it. */
svo_status svo_i_solid_tell(const svo_i_solid_progress *progress, svo_device *device, double fraction);

/* Decides all empty children, and the leaves too if with_leaves, and waits for the counts. info: receives all fields
   but struct_size. progress: is told the parts from SVO_I_INSIDE_BEGIN to SVO_I_INSIDE_END by rules of the host; NULL:
   nobody is. */
svo_status svo_i_inside_find(svo_i_device_work *work, const svo_tree *tree, svo_solid_rule rule, bool with_leaves,
                             const svo_i_solid_progress *progress, svo_i_inside *out, svo_solid_info *info);

/* Refuses a tree whose lists do not hold all of the mesh: with coverage thin, without lists, or with triangles outside
   its grid, as far as the counts of tree->info tell. what: "a solid", for the message. */
svo_status svo_i_inside_check(const svo_tree *tree, const char *function, const char *what);

/* Refuses a tree with triangles that reach outside its grid. */
svo_status svo_i_inside_check_mesh(svo_i_device_work *work, const svo_tree *tree);

#endif
