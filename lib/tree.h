/* SPDX-License-Identifier: MIT */
/* The tree's insides, for the builder, the files and the ray caster. */
#ifndef SVO_LIB_TREE_H
#define SVO_LIB_TREE_H

#include <stdbool.h>

#include "message.h"
#include "svocl/tree.h"

struct svo_tree {
    svo_tree_info info;
    svo_device *device; /* NULL: never on a device */
    cl_mem buffers[SVO_TREE_BUFFER_COUNT]; /* device copies, owned; NULL where absent */
    void *host[SVO_TREE_BUFFER_COUNT]; /* host copies by malloc, owned; NULL where absent or not downloaded */
    struct svo_i_ray_boxes *ray_boxes; /* rays.h; empty until rays are first asked for */
    bool downloaded; /* host[] is what the tree holds (an array of no element stays NULL) */
};

SVO_I_SHARED_BEGIN

/* An empty tree without arrays, or NULL when out of memory. Released by svo_tree_destroy. */
svo_tree *svo_i_tree_new(void);

/* Whether info says the tree holds the array, and its element count and element bytes. */
bool svo_i_tree_holds(const svo_tree_info *info, svo_tree_buffer buffer);
uint64_t svo_i_tree_element_count(const svo_tree_info *info, svo_tree_buffer buffer);
size_t svo_i_tree_element_bytes(svo_tree_buffer buffer);

SVO_I_SHARED_END

#endif
