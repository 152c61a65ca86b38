/* SPDX-License-Identifier: MIT */
/* The tree's fields and what is known of its arrays, for the builder, the files and the rays. */
#ifndef SVO_LIB_CORE_TREE_H
#define SVO_LIB_CORE_TREE_H

#include <stdbool.h>

#include "core/attachment.h"
#include "core/message.h"
#include "svocl/tree.h"

struct svo_workspace;
struct svo_i_pending;

struct svo_tree {
    svo_tree_info info;
    svo_device *device; /* NULL: never on a device */
    cl_mem buffers[SVO_TREE_BUFFER_COUNT]; /* device copies, owned; NULL where absent */
    void *host[SVO_TREE_BUFFER_COUNT]; /* host copies by malloc, owned; NULL where absent or not downloaded */
    svo_i_attachment *attachments; /* kept until the tree is destroyed */
    svo_i_attachment *derived; /* made of the buffers, and released when they change */
    struct svo_workspace *workspace; /* whose builds go into it; NULL: none, or no more */
    svo_tree *next; /* of the workspace's trees */
    struct svo_i_pending *pending; /* the build that is filling it; NULL: none */
    bool downloaded; /* host[] is what the tree holds (an array of no element stays NULL) */
};

SVO_I_SHARED_BEGIN

/* An empty tree without arrays, or NULL when out of memory. Released by svo_tree_destroy. */
svo_tree *svo_i_tree_new(void);

/* The array of that name; SVO_TREE_BUFFER_COUNT: none. */
svo_tree_buffer svo_i_tree_buffer_named(const char *name);

/* Releases the host arrays and all that is derived from the buffers, which are about to change. */
void svo_i_tree_forget(svo_tree *tree);

/* What info says of an array: whether the tree holds it, whether as one element for all nodes, and its element count
   and bytes. They apply to the device and to files; on the host there is an element for every node. */
bool svo_i_tree_holds(const svo_tree_info *info, svo_tree_buffer buffer);
uint64_t svo_i_tree_payload_count(const svo_tree_info *info); /* nodes that have payload */
bool svo_i_tree_is_constant(const svo_tree_info *info, svo_tree_buffer buffer);
uint64_t svo_i_tree_element_count(const svo_tree_info *info, svo_tree_buffer buffer);
size_t svo_i_tree_element_bytes(svo_tree_buffer buffer);

/* Repeats the element of a constant array, by malloc, for every node. False when out of memory; the array stays as it
   was. */
bool svo_i_tree_repeat(const svo_tree *tree, svo_tree_buffer buffer, void **array);

SVO_I_SHARED_END

#endif
