/* SPDX-License-Identifier: MIT */
/*
 * Photons that are kept, so that few of them are shot again when a part of the tree has changed. Of each photon the
 * flux, the normal and the distance of what it met are kept, of each group of four the slots that it reaches; of each
 * slot the code of its leaf, how many groups reach it and its radiance (exchange.cl), which becomes stale where photons
 * come or go. Nodes are numbered anew when a tree changes, slots are not.
 *
 *   svo_k_photon_keep     per group: keeps what was shot
 *   svo_k_photon_cross    per group of a view: lists those that what changed may concern
 *   svo_k_photon_take     per listed group: takes its flux back from the sums of its slots
 *   svo_k_photon_weigh    per photon of listed groups: its weight, for the kernels that shoot
 *   svo_k_slot_places     per slot: where its leaf is in the new tree; lists the slots that no group reaches any more
 *   svo_k_slot_codes      per leaf: the code of its slot, where that is new; marks those whose radiance is
 *
 * A photon that what changed does not concern meets what it met: its ray misses the bounds of what changed, before and
 * after, up to the hit. And it reaches the leaves that it reached: only cells within these bounds gain or lose a leaf
 * or a triangle of its list, and its footprint lies outside. So all photons of a leaf whose payload changed are shot
 * again, and its radiance is stale. Both tests are in floats, with bounds that are widened by more than their error;
 * photons that are shot again without need get the same flux again.
 *
 * Launch: as above, rounded up to whole groups. Atomics: counters number groups and slots, whose order does not matter;
 * leaves set bits at their parents; the sums of photon_sums.clh. No local memory.
 */
#include "light/photon_sums.clh"
#include "light/photons.clh"
#include "light/spread.clh"
#include "shared/nodes.clh"

/* The code of a slot that has no leaf. */
#define SVO_NO_CODE 0xfffffffffffffffful

/* ---- what is kept ---- */

/* users: of each slot, groups. ends: normals, and distances where there is a hit, else INFINITY. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_photon_keep(__global const svo_photon_weight *weights, __global const svo_hit *hits,
                  __global const svo_photon_spread *spreads, __global const uint *slots,
                  __global svo_photon_weight *kept_weights, __global float4 *kept_ends,
                  __global svo_photon_spread *kept_spreads, volatile __global uint *users, __global uint *bits,
                  __global const uint *groups, svo_light_view_params view)
{
    const uint item = (uint)get_global_id(0);
    const uint first = item * SVO_ITEM_PHOTONS;
    if (first >= view.count) {
        return;
    }
    const size_t kept = (size_t)view.kept_first + svo_photon_number(&view, groups, first);
    __global svo_photon_spread *to = kept_spreads + kept / SVO_ITEM_PHOTONS;
    for (uint k = 0; k < SVO_ITEM_PHOTONS; ++k) {
        __global const svo_hit *hit = hits + first + k;
        const float t = hit->triangle != SVO_NO_TRIANGLE ? hit->t : INFINITY;
        kept_weights[kept + k] = weights[first + k];
        kept_ends[kept + k] = (float4)(hit->normal[0], hit->normal[1], hit->normal[2], t);
        to->parts[k] = spreads[item].parts[k];
    }
    for (uint place = 0; place < SVO_SPREAD_CELLS; ++place) {
        const uint leaf = spreads[item].leaves[place];
        const uint slot = svo_is_leaf(leaf) ? slots[leaf] : SVO_SLOT_NONE;
        to->leaves[place] = slot;
        if (slot != SVO_SLOT_NONE) {
            atomic_inc(users + slot);
            bits[slot] = SVO_SLOT_STALE;
        }
    }
}

/* ---- what changed ---- */

/* A ray, and 1 / its direction. Along an axis that it does not go it meets planes beyond all distances. */
typedef struct svo_kept_ray {
    float3 origin, along, inverse;
} svo_kept_ray;

static float svo_invert(float along)
{
    return fabs(along) < 0x1p-100f ? 0x1p100f : 1.0f / along;
}

/* Whether a ray meets a box, which is low x, y, z, high x, y, z, before t. */
static bool svo_meets_box(const svo_kept_ray *ray, float t, __global const float *box)
{
    const float3 a = (vload3(0, box) - ray->origin) * ray->inverse;
    const float3 b = (vload3(1, box) - ray->origin) * ray->inverse;
    const float3 near = min(a, b);
    const float3 far = max(a, b);
    return max(max(near.x, near.y), max(near.z, 0.0f)) <= min(min(far.x, far.y), min(far.z, t));
}

/* Whether a point is at most so far from a box along each axis. */
static bool svo_is_beside_box(float3 point, float3 reach, __global const float *box)
{
    const float3 low = vload3(0, box) - reach;
    const float3 high = vload3(1, box) + reach;
    return all(point >= low) && all(point <= high);
}

/* How far the leaves of a photon may lie from its hit: along each axis, world units. */
static float3 svo_find_reach(const svo_light_view_params *view, uint photon, float4 end,
                             const svo_crossing_params *params)
{
    svo_footprint footprint;
    svo_find_footprint(view, photon, end.xyz, end.w, params->cells, &footprint);
    float reach[3];
    for (uint axis = 0; axis < 3u; ++axis) {
        const uint widest = SVO_SPREAD_MIDDLE * (abs(footprint.right[axis]) + abs(footprint.up[axis]));
        reach[axis] = ((float)widest * (1.0f / (1u << SVO_PLACE_BITS)) + params->beside) / params->cells;
    }
    return (float3)(reach[0], reach[1], reach[2]);
}

/* At least as far, found sooner: a pixel's sides are laid along the ray at most 1 / its cosine times as far. */
static float svo_bound_reach(const svo_light_view_params *view, float3 along, float4 end,
                             const svo_crossing_params *params)
{
    const float cosine = fabs(svo_times(along, end.xyz)) - 0x1p-24f;
    const float length = fabs(along.x) + fabs(along.y) + fabs(along.z);
    const float steepest = 1.01f + 1.01f * length / max(cosine, 0x1p-30f);
    const float sides = (view->half_x + view->half_y) * (view->parallel != 0u ? 1.0f : end.w);
    const float cells = sides * params->cells * (2.0f * SVO_SPREAD_MIDDLE / SVO_SPREAD_PARTS) * steepest;
    const float most = 2.0f * SVO_SPREAD_MIDDLE * SVO_SPREAD_STEP_MAX / (1 << SVO_PLACE_BITS);
    return (min(cells, most) + params->beside + 0.01f) / params->cells;
}

static bool svo_is_concerned(const svo_light_view_params *view, uint photon, float4 end, __global const float *boxes,
                             const svo_crossing_params *params)
{
    svo_kept_ray ray;
    ray.along = svo_photon_ray(view, photon, &ray.origin);
    ray.inverse = (float3)(svo_invert(ray.along.x), svo_invert(ray.along.y), svo_invert(ray.along.z));
    const bool hits = end.w < INFINITY;
    const float bound = hits ? svo_bound_reach(view, ray.along, end, params) : 0.0f;
    const float3 point = hits ? ray.origin + ray.along * end.w : ray.origin;
    bool concerned = false;
    for (uint i = 0; i < params->box_count && !concerned; ++i) {
        __global const float *box = boxes + 6u * i;
        concerned = svo_meets_box(&ray, end.w, box) ||
                    (hits && svo_is_beside_box(point, (float3)(bound), box) &&
                     svo_is_beside_box(point, svo_find_reach(view, photon, end, params), box));
    }
    return concerned;
}

/* groups: receives the view's listed groups, from its first group on; counts: how many, by view. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_photon_cross(__global const svo_photon_weight *kept_weights, __global const float4 *kept_ends,
                   __global const float *boxes, __global uint *groups, volatile __global uint *counts,
                   svo_crossing_params params, svo_light_view_params view)
{
    const uint group = (uint)get_global_id(0);
    if (group >= params.group_count) {
        return;
    }
    bool concerned = false;
    for (uint k = 0; k < SVO_ITEM_PHOTONS && !concerned; ++k) {
        const uint photon = group * SVO_ITEM_PHOTONS + k;
        const size_t kept = (size_t)view.kept_first + photon;
        concerned = kept_weights[kept].flux != 0u && svo_is_concerned(&view, photon, kept_ends[kept], boxes, &params);
    }
    if (concerned) {
        groups[view.kept_first / SVO_ITEM_PHOTONS + atomic_inc(counts + params.view)] = group;
    }
}

/* ---- taking back ---- */

/* What the photons of a group gave to the slot at a place. given: of each photon, parts for places before; receives
   those for this one too. */
static void svo_sum_group(const svo_light_view_params *view, uint first, __global const svo_photon_weight *weights,
                          __global const float4 *ends, __global const svo_photon_spread *spread, uint place,
                          uint *given, svo_photon_sums *sums)
{
    svo_clear_sums(sums);
    for (uint k = 0; k < SVO_ITEM_PHOTONS; ++k) {
        const uint before = given[k];
        given[k] += spread->parts[k] >> 4u * place & 15u;
        if (given[k] > before) {
            svo_sum_photon(view, first + k, weights[k], ends[k].xyz, (uint2)(before, given[k]), sums);
        }
    }
}

static void svo_negate_sums(svo_photon_sums *sums)
{
    for (uint k = 0; k < SVO_FLUX_SUMS; ++k) {
        sums->flux[k] = 0ul - sums->flux[k];
    }
#ifdef SVO_LIGHT_FACES
    for (uint k = 0; k < SVO_FACE_SUMS; ++k) {
        sums->faces[k] = 0ul - sums->faces[k];
    }
#endif
}

/* Takes lost flux back, and counts the hits of a group. */
static void svo_take_hits(const svo_light_view_params *view, __global const svo_photon_weight *weights,
                          __global const float4 *ends, __global const svo_photon_spread *spread,
                          volatile __global uint *counters)
{
    uint hits = 0u;
    for (uint k = 0; k < SVO_ITEM_PHOTONS; ++k) {
        const bool hit = ends[k].w < INFINITY;
        hits += hit ? 1u : 0u;
        for (uint channel = 0; channel < 3u && hit && spread->parts[k] == 0u; ++channel) {
            svo_add_wide(counters + SVO_PHOTON_NO_LEAF + 2u * channel,
                         0ul - svo_photon_flux(view, weights[k].flux, channel));
        }
    }
    if (hits > 0u) {
        atomic_add(counters + SVO_PHOTON_TAKEN, hits);
    }
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_photon_take(__global const svo_photon_weight *kept_weights, __global const float4 *kept_ends,
                  __global const svo_photon_spread *kept_spreads, volatile __global uint *sums,
                  volatile __global uint *users, __global uint *bits, volatile __global uint *counters,
                  __global const uint *groups, svo_light_view_params view)
{
    const uint item = (uint)get_global_id(0);
    if (item * SVO_ITEM_PHOTONS >= view.count) {
        return;
    }
    const uint first = svo_photon_number(&view, groups, item * SVO_ITEM_PHOTONS);
    const size_t kept = (size_t)view.kept_first + first;
    __global const svo_photon_spread *spread = kept_spreads + kept / SVO_ITEM_PHOTONS;
    uint given[SVO_ITEM_PHOTONS] = {0u, 0u, 0u, 0u};
    for (uint place = 0; place < SVO_SPREAD_CELLS; ++place) {
        const uint slot = spread->leaves[place];
        svo_photon_sums taken;
        if (slot == SVO_SLOT_NONE) {
            continue;
        }
        svo_sum_group(&view, first, kept_weights + kept, kept_ends + kept, spread, place, given, &taken);
        svo_negate_sums(&taken);
        svo_store_sums(sums, slot, &taken);
        atomic_dec(users + slot);
        bits[slot] = SVO_SLOT_STALE;
    }
    svo_take_hits(&view, kept_weights + kept, kept_ends + kept, spread, counters);
}

/* ---- shooting again ---- */

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_photon_weigh(__global const svo_photon_weight *kept_weights, __global svo_photon_weight *weights,
                   __global const uint *groups, svo_light_view_params view)
{
    const uint item = (uint)get_global_id(0);
    if (item < view.count) {
        weights[item] = kept_weights[(size_t)view.kept_first + svo_photon_number(&view, groups, item)];
    }
}

/* Marks a leaf at the node above it. renewed: as renewed.cl has it; NULL: not wanted. */
static void svo_mark_renewed(__global const uchar *child_mask, __global const uint *first_child, ulong code, uint depth,
                             volatile __global uint *renewed)
{
    uint cell[3];
    svo_node node;
    if (renewed == NULL || code == SVO_NO_CODE) {
        return;
    }
    svo_deinterleave(code >> 3, cell);
    svo_walk_down(child_mask, first_child, depth - 1u, cell, &node);
    if (node.level == depth - 1u) {
        atomic_or(renewed + node.index, 1u << (uint)(code & 7ul));
    }
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_slot_places(__global const uchar *child_mask, __global const uint *first_child, __global const uint *users,
                  __global ulong *codes, __global uint *bits, __global uint *slots, volatile __global uint *renewed,
                  volatile __global uint *counters, svo_photon_params params)
{
    const uint slot = (uint)get_global_id(0);
    if (slot >= params.count) {
        return;
    }
    if (users[slot] == 0u) {
        svo_mark_renewed(child_mask, first_child, codes[slot], params.depth, renewed);
        codes[slot] = SVO_NO_CODE;
        bits[slot] = SVO_SLOT_STALE;
        counters[SVO_PHOTON_COUNTERS + atomic_inc(counters + SVO_PHOTON_FREE)] = slot;
        return;
    }
    uint cell[3];
    svo_node node;
    svo_deinterleave(codes[slot], cell);
    svo_walk_down(child_mask, first_child, params.depth, cell, &node);
    if (node.level == params.depth) {
        slots[node.index - params.leaf_begin] = slot;
    } else {
        atomic_inc(counters + SVO_PHOTON_GONE);
    }
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_slot_codes(__global const uchar *child_mask, __global const uint *first_child, __global const uint *slots,
                 __global ulong *codes, __global const uint *bits, volatile __global uint *renewed,
                 svo_photon_params params)
{
    const uint leaf = (uint)get_global_id(0);
    const uint slot = leaf < params.leaf_count ? slots[leaf] : SVO_SLOT_NONE;
    if (slot != SVO_SLOT_NONE && codes[slot] == SVO_NO_CODE) {
        svo_node node;
        svo_walk_up(child_mask, first_child, params.leaf_begin, params.leaf_begin + leaf, &node);
        codes[slot] = svo_interleave(node.cell);
    }
    if (slot != SVO_SLOT_NONE && (bits[slot] & SVO_SLOT_FRESH) != 0u) {
        svo_mark_renewed(child_mask, first_child, codes[slot], params.depth, renewed);
    }
}
