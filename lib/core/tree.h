/* SPDX-License-Identifier: MIT */
/* The tree's fields and the properties of its arrays, for builds, files and rays. */
#ifndef SVO_LIB_CORE_TREE_H
#define SVO_LIB_CORE_TREE_H

#include <stdbool.h>

#include "core/memory.h"
#include "core/message.h"
#include "shared/layout.h"
#include "svocl/part_types.h"
#include "svocl/tree.h"

struct svo_workspace;
struct svo_i_pending;

/* What a tree's arrays hold. Only those of a complete tree are defined. */
typedef enum svo_i_tree_content {
    SVO_I_TREE_COMPLETE = 0, /* built, or from a file */
    SVO_I_TREE_EMPTY, /* of a workspace; nothing was built yet */
    SVO_I_TREE_IN_FLIGHT, /* a build is pending */
    SVO_I_TREE_FAILED, /* the last build failed */
    SVO_I_TREE_ABANDONED /* the workspace was destroyed before the pending build was finished */
} svo_i_tree_content;

/* The sums of a node's payload, unrounded, as kernels/stages/sums.clh adds them up. */
typedef struct svo_i_node_sums {
    uint64_t weight;
    uint64_t color[4];
    int64_t normal[3];
} svo_i_node_sums;

/* Of a tree that is a part of a larger one; header.depth is 0 in whole trees. */
typedef struct svo_i_tree_part {
    svo_part_header header;
    uint32_t level;
    uint32_t run_count;
    uint64_t code;
    svo_i_node_sums root; /* where a level above has payload; else 0 */
    uint64_t *runs; /* the root's materials and their weights, as kernels/stages/material.cl has them; owned */
} svo_i_tree_part;

/* The name of svo_tree.build_state among the buffers of a plan. */
#define SVO_I_TREE_BUILD_STATE "build_state"

struct svo_tree {
    svo_tree_info info;
    svo_device *device; /* NULL: never on a device */
    svo_i_memory memory; /* of the tree and what is attached to it */
    svo_i_tree_content content;
    cl_mem buffers[SVO_TREE_BUFFER_COUNT]; /* device copies, owned; NULL where absent */
    cl_mem build_state; /* svo_build_state of the last enqueued build, owned; NULL for other trees */
    void *host[SVO_TREE_BUFFER_COUNT]; /* host copies by svo_i_alloc, owned; NULL where absent or not downloaded */
    svo_i_attachment *attachments; /* kept until the tree is destroyed */
    svo_i_attachment *derived; /* computed from the buffers, and outdated when they change */
    uint64_t ray_bytes; /* of the BVH among them, which keeps the number; 0: there is none */
    struct svo_workspace *workspace; /* whose builds fill it; NULL: none, or no longer */
    svo_tree *next; /* of the workspace's trees */
    struct svo_i_pending *pending; /* the build that is filling it; NULL: none */
    svo_i_tree_part part;
    bool moves; /* of an updatable plan: its BVH can follow */
    bool downloaded; /* host[] has all arrays of the tree (an empty array stays NULL) */
};

SVO_I_SHARED_BEGIN

/* An empty tree without arrays, or NULL when out of memory. Released by svo_tree_destroy. memory: NULL means malloc
   and free. */
svo_tree *svo_i_tree_new(const svo_i_memory *memory);

/* Why the tree's content is undefined, for a message; NULL for a complete tree. */
const char *svo_i_tree_undefined(const svo_tree *tree);

/* Releases the host arrays and what is derived from the buffers, which are about to change. */
void svo_i_tree_forget(svo_tree *tree);

/* The properties of an array that follow from info: whether the tree holds it, whether one element stands for all
   nodes, its element count, and the bytes of an element. They apply to the device and to files; host arrays have an
   element for every node. */
bool svo_i_tree_holds(const svo_tree_info *info, svo_tree_buffer buffer);
uint64_t svo_i_tree_payload_count(const svo_tree_info *info); /* nodes that have payload */
bool svo_i_tree_is_constant(const svo_tree_info *info, svo_tree_buffer buffer);
uint64_t svo_i_tree_element_count(const svo_tree_info *info, svo_tree_buffer buffer);
size_t svo_i_tree_element_bytes(svo_tree_buffer buffer);

/* Grows a constant array, by realloc, to an element for every node. Returns false, with the array unchanged, when out
   of memory. */
bool svo_i_tree_repeat(const svo_tree *tree, svo_tree_buffer buffer, void **array);

/* The grid that exact decisions take: of the whole tree, whose part has that level and code; part->depth is 0: there is
   no larger tree than that of depth, origin and edge. The other fields are 0. */
svo_decide_params svo_i_grid_params(const svo_part_header *part, uint32_t level, uint64_t code, uint32_t depth,
                                    const double origin[3], double edge);

SVO_I_SHARED_END

/* Refuses a tree that is NULL or not complete. function: for the message. */
svo_status svo_i_tree_check(const svo_tree *tree, const char *function);

/* The buffer of that name, which the tree of a workspace has: an array or its build state. */
cl_mem *svo_i_tree_slot(svo_tree *tree, const char *name);

#endif
