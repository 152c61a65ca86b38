/* SPDX-License-Identifier: MIT */
/*
 * Photons into leaves: which leaf each one belongs to, and the sums of flux of the leaves.
 *
 *   svo_k_photon_find    per four photons: their leaves, how they spread, and slots for leaves that have none
 *   svo_k_voxel_find     the same for hits of voxels
 *   svo_k_photon_add     per four photons: their flux into the sums of their leaves' slots
 *   svo_k_photon_total   per 64 slots: the flux of all of them
 *   svo_k_unmet_count    per leaf: whether a ray to its center (light_view.cl) met the leaf first
 *
 * Four photons in a row are a group, those of two by two pixels. They mostly share leaves; each of them takes one claim
 * and one addition. spread.clh says why a photon goes to several.
 *
 * A published system averages the photons of a leaf (Crassin et al., "Interactive Indirect Illumination Using Voxel
 * Cone Tracing", 2011), so brightness ignores the distance of the source; here flux is summed.
 *
 * Launch: as above, rounded up to whole groups. Atomics: a leaf's slot is claimed by a compare-and-swap and numbered by
 * a counter, so the numbers of slots differ from run to run; results name leaves, not slots. Those that find have
 * SVO_GROUP_ITEMS words of local memory as an argument, see shared/group.clh.
 */
#include "light/photon_sums.clh"
#include "light/photons.clh"
#include "light/slots.clh"
#include "light/spread.clh"
#include "shared/group.clh"

/* ---- leaves ---- */

/* Counts hits, one atomic for a group. All items of the group call it. */
SVO_INLINED void svo_count_hits(uint hits, volatile __global uint *counters, __local uint *scratch)
{
    const uint sum = svo_group_sum(hits, scratch);
    if (get_local_id(0) == 0 && sum > 0u) {
        atomic_add(counters + SVO_PHOTON_HITS, sum);
    }
}

static bool svo_counts_hits(const svo_photon_params *params)
{
    return params->spreads == SVO_SPREAD_VIEW || params->spreads == SVO_SPREAD_WHOLE;
}

/* Gives slots to leaves, and stores them. */
static void svo_keep_reach(const svo_reach *reach, __global svo_photon_spread *spread, volatile __global uint *slots,
                           volatile __global uint *counters)
{
    for (uint place = 0; place < SVO_SPREAD_CELLS; ++place) {
        const uint leaf = place < reach->count ? reach->leaves[place] : SVO_PHOTON_LOST;
        spread->leaves[place] = leaf;
        if (svo_is_leaf(leaf)) {
            svo_claim_slot(slots, counters, leaf);
        }
    }
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_photon_find(__global const uchar *child_mask, __global const uint *first_child, __global const uint *list_begin,
                  __global const uint *list, __global const int *vertices, __global const uint *indices,
                  __global const uint *triangle_ids, __global const svo_hit *hits, __global uint *leaves,
                  __global svo_photon_spread *spreads, volatile __global uint *slots, volatile __global uint *counters,
                  __local uint *scratch, svo_photon_params params, __global const uint *groups,
                  svo_light_view_params view)
{
    const svo_list_tree tree = {child_mask, first_child, list_begin, list, vertices, indices, triangle_ids, params};
    const uint item = (uint)get_global_id(0);
    const uint first = item * SVO_ITEM_PHOTONS;
    const uint count = first < params.count ? min(params.count - first, (uint)SVO_ITEM_PHOTONS) : 0u;
    svo_photon_place places[SVO_ITEM_PHOTONS];
    uint own[SVO_ITEM_PHOTONS];
    uint met = 0;
    svo_reach reach;
    reach.count = 0u;
    for (uint k = 0; k < count; ++k) {
        __global const svo_hit *hit = hits + first + k;
        uint leaf = SVO_PHOTON_MISSED;
        if (hit->triangle != SVO_NO_TRIANGLE) {
            leaf = svo_leaf_of_hit(&tree, hit->triangle, hit->u, hit->v, &places[k]);
            ++met;
        }
        leaves[first + k] = leaf;
        own[k] = svo_is_leaf(leaf) ? svo_reach_own(leaf, places[k].cell, &reach) : SVO_SPREAD_CELLS;
    }
    for (uint k = 0; k < count && params.spreads == SVO_SPREAD_VIEW; ++k) {
        uint parts = 0u;
        if (own[k] < SVO_SPREAD_CELLS) {
            svo_footprint footprint;
            const uint photon = svo_photon_number(&view, groups, first + k);
            svo_find_footprint(&view, photon, vload3(0, hits[first + k].normal), hits[first + k].t, params.cells,
                               &footprint);
            parts = svo_spread_photon(&tree, &places[k], &footprint, own[k], &reach);
        }
        spreads[item].parts[k] = parts;
    }
    if (params.spreads != SVO_SPREAD_NOTHING && count > 0u) {
        svo_keep_reach(&reach, spreads + item, slots, counters);
    }
    svo_count_hits(svo_counts_hits(&params) ? met : 0u, counters, scratch);
}

/* Photons that meet voxels do not spread. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_voxel_find(__global const svo_voxel_hit *hits, __global uint *leaves, __global svo_photon_spread *spreads,
                 volatile __global uint *slots, volatile __global uint *counters, __local uint *scratch,
                 svo_photon_params params)
{
    const uint item = (uint)get_global_id(0);
    const uint first = item * SVO_ITEM_PHOTONS;
    const uint count = first < params.count ? min(params.count - first, (uint)SVO_ITEM_PHOTONS) : 0u;
    uint met = 0;
    svo_reach reach;
    reach.count = 0u;
    for (uint k = 0; k < count; ++k) {
        const uint node = hits[first + k].node;
        const uint leaf = node != SVO_NO_NODE ? node - params.leaf_begin : SVO_PHOTON_MISSED;
        leaves[first + k] = leaf;
        uint parts = 0u;
        if (svo_is_leaf(leaf)) {
            const uint nowhere[3] = {0u, 0u, 0u};
            parts = svo_some_parts(SVO_SPREAD_PARTS, svo_reach_own(leaf, nowhere, &reach));
            ++met;
        }
        if (params.spreads == SVO_SPREAD_VIEW) {
            spreads[item].parts[k] = parts;
        }
    }
    if (params.spreads != SVO_SPREAD_NOTHING && count > 0u) {
        svo_keep_reach(&reach, spreads + item, slots, counters);
    }
    svo_count_hits(svo_counts_hits(&params) ? met : 0u, counters, scratch);
}

/* ---- sums ---- */

/* hits: of triangles or of voxels; both have the normal in words 4 to 6. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_photon_add(__global const svo_photon_weight *weights, __global const float8 *hits, __global const uint *leaves,
                 __global const svo_photon_spread *spreads, __global const uint *slots, volatile __global uint *sums,
                 volatile __global uint *counters, __global const uint *groups, svo_light_view_params view)
{
    const uint item = (uint)get_global_id(0);
    const uint first = item * SVO_ITEM_PHOTONS;
    if (first >= view.count) {
        return;
    }
    const uint count = min(view.count - first, (uint)SVO_ITEM_PHOTONS);
    const uint number = svo_photon_number(&view, groups, first); /* those of one work-item are one group */
    uint given[SVO_ITEM_PHOTONS];
    for (uint k = 0; k < count; ++k) {
        given[k] = 0u;
        if (leaves[first + k] == SVO_PHOTON_LOST) {
            svo_lose_photon(&view, weights[first + k].flux, counters);
        }
    }
    for (uint place = 0; place < SVO_SPREAD_CELLS; ++place) {
        const uint leaf = spreads[item].leaves[place];
        svo_photon_sums added;
        if (!svo_is_leaf(leaf)) {
            continue;
        }
        svo_clear_sums(&added);
        for (uint k = 0; k < count; ++k) {
            const uint before = given[k];
            given[k] += spreads[item].parts[k] >> 4u * place & 15u;
            if (given[k] > before) {
                const uint photon = first + k;
                svo_sum_photon(&view, number + k, weights[photon], hits[photon].s456, (uint2)(before, given[k]),
                               &added);
            }
        }
        svo_store_sums(sums, slots[leaf], &added);
    }
}

/* ---- totals ---- */

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_photon_total(__global const uint *sums, volatile __global uint *counters, svo_photon_params params)
{
    const uint first = (uint)get_global_id(0) * SVO_GROUP_ITEMS;
    for (uint channel = 0; channel < 3u; ++channel) {
        ulong total = 0ul;
        for (uint slot = first; slot < min(first + SVO_GROUP_ITEMS, params.count); ++slot) {
            const size_t place = ((size_t)slot * SVO_LEAF_SUMS + channel) * 2;
            total += svo_read_wide(sums + place);
        }
        svo_add_wide(counters + SVO_PHOTON_IN_LEAF + 2u * channel, total);
    }
}

/* leaves: of the launch's rays, by svo_k_photon_find or svo_k_voxel_find; first: of the launch's leaves. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_unmet_count(__global const uint *leaves, volatile __global uint *unmet, volatile __global uint *counters,
                  uint first, uint count)
{
    const uint item = (uint)get_global_id(0);
    if (item < count && leaves[item] == first + item && atomic_xchg(unmet + first + item, 1u) == 0u) {
        atomic_inc(counters + SVO_PHOTON_UNMET);
    }
}
