/* SPDX-License-Identifier: MIT */
/*
 * Rays from a buffer, hits into a buffer: the batch side of rays.clh. Reads the tree, writes one record per ray;
 * -DSVO_COUNT_HITS counts all hits. No atomics, no local memory.
 *
 * A leaf's triangles are seldom in a processor's caches, and one ray alone waits for them. A work-item has
 * several rays under way: each walks to its next leaf and asks for what is there, and while that comes the others have
 * their turn. On GPUs other work-items do that, and one ray each is best. The hits are the same.
 *
 * Launch: one work-item per SVO_RAYS_PER_ITEM rays, one dimension, rounded up to whole groups.
 */
#include "svocl/layout.h"

#include "rays.clh"

#ifndef SVO_RAYS_PER_ITEM
#define SVO_RAYS_PER_ITEM 1 /* lib/rays_batch.c sets it for CPUs */
#endif

#if defined(__x86_64__) || defined(__aarch64__)
#define SVO_PREFETCH(address) __builtin_prefetch(address)
#else
#define SVO_PREFETCH(address) (void)(address)
#endif
/* Triangles of a leaf that are asked for in time; few leaves have more at the depth for rays. */
#define SVO_PREFETCH_WORDS4 24u
#define SVO_LINE_WORDS4     4u

#ifndef SVO_COUNT_HITS

/* Rays under way at a time. */
#define SVO_FLIGHTS (SVO_RAYS_PER_ITEM < 8 ? SVO_RAYS_PER_ITEM : 8)

/* A ray under way: it has come to a leaf and is to test what is there. */
typedef struct svo_flight {
    svo_ray given;
    svo_grid_ray ray;
    svo_search search;
    svo_ray_place at;
    svo_ray_stack stack;
    uint leaf;
    uint index; /* of the ray */
} svo_flight;

static void svo_prefetch_leaf(const svo_tree *tree, uint leaf)
{
    const size_t first = 3u * (size_t)tree->list_begin[leaf];
    const size_t end = min(3u * (size_t)tree->list_begin[leaf + 1u], first + SVO_PREFETCH_WORDS4);
    for (size_t word = first; word < end; word += SVO_LINE_WORDS4) {
        SVO_PREFETCH(&tree->triangles[word]);
    }
}

/* Takes a ray to its first leaf; false for one that comes to none, whose search then says so. What most rays of a picture
   need of the state stays in variables of this function. */
static bool svo_flight_start(const svo_tree *tree, const svo_ray *given, bool any, svo_flight *out)
{
    svo_grid_ray ray;
    svo_ray_place at;
    if (!svo_ray_to_grid(&tree->params, given, &ray)) {
        return false;
    }
    svo_ray_begin(tree, &ray, ray.last, &at);
    const uint leaf = svo_ray_next_leaf(tree, &ray, ray.last, &at, &out->stack);
    if (leaf == UINT_MAX) {
        return false;
    }
    svo_prefetch_leaf(tree, leaf);
    svo_search_begin(&ray, any, &out->search);
    out->given = *given;
    out->ray = ray;
    out->at = at;
    out->leaf = leaf;
    return true;
}

/* Tests the leaf and goes on to the next one; false when there is nothing more to find. */
static bool svo_flight_go_on(const svo_tree *tree, svo_flight *flight)
{
    ++flight->search.leaves;
    svo_ray_leaf(tree, &flight->given, &flight->ray, flight->leaf, &flight->search);
    if (flight->search.any && flight->search.triangle != UINT_MAX) {
        return false;
    }
    flight->leaf = svo_ray_next_leaf(tree, &flight->ray, flight->search.s_limit, &flight->at, &flight->stack);
    if (flight->leaf == UINT_MAX) {
        return false;
    }
    svo_prefetch_leaf(tree, flight->leaf);
    return true;
}

static void svo_trace_together(const svo_tree *tree, __global const svo_ray *rays, __global svo_hit *hits, uint count,
                               bool any)
{
    svo_flight flights[SVO_FLIGHTS];
    uint order[SVO_FLIGHTS]; /* the first ones are under way, the others free */
    uint under_way = 0u;
    uint next = 0u;
    for (uint i = 0u; i < SVO_FLIGHTS; ++i) {
        order[i] = i;
    }
    do {
        for (; next < count && under_way < SVO_FLIGHTS; ++next) {
            const svo_ray ray = rays[next];
            if (svo_flight_start(tree, &ray, any, &flights[order[under_way]])) {
                flights[order[under_way++]].index = next;
            } else {
                svo_hit nothing;
                svo_hit_miss(&nothing);
                hits[next] = nothing;
            }
        }
        for (uint i = 0u; i < under_way;) {
            const uint slot = order[i];
            if (svo_flight_go_on(tree, &flights[slot])) {
                ++i;
                continue;
            }
            svo_hit hit;
            svo_hit_from_search(tree, &flights[slot].search, &hit);
            hits[flights[slot].index] = hit;
            order[i] = order[--under_way];
            order[under_way] = slot;
        }
    } while (under_way > 0u || next < count);
}

#endif

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_trace(SVO_TREE_PARAMETERS, __global const svo_ray *rays, __global svo_hit *hits, uint ray_count, uint any)
{
    const uint first = (uint)get_global_id(0) * SVO_RAYS_PER_ITEM;
    if (first >= ray_count) {
        return;
    }
    SVO_TREE_MAKE(tree);
#ifdef SVO_COUNT_HITS
    (void)any;
    const svo_ray ray = rays[first];
    svo_hit hit;
    svo_trace_count(&tree, &ray, &hit);
    hits[first] = hit;
#else
    svo_trace_together(&tree, rays + first, hits + first, min(ray_count - first, (uint)SVO_RAYS_PER_ITEM), any != 0u);
#endif
}
