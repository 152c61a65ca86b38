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
 * Four photons in a row are those of two by two pixels. They mostly share leaves; each of them takes one claim and one
 * addition. spread.clh says why a photon goes to several.
 *
 * A published system averages the photons of a leaf (Crassin et al., "Interactive Indirect Illumination Using Voxel
 * Cone Tracing", 2011), so brightness ignores the distance of the source; here flux is summed.
 *
 * Launch: as above, rounded up to whole groups. Atomics: a leaf's slot is claimed by a compare-and-swap and numbered by
 * a counter, so the numbers of slots differ from run to run; results name leaves, not slots. Sums are integers of 64
 * bits, two words with a carry: their order does not matter. Those that find have SVO_GROUP_ITEMS words of local memory
 * as an argument, see shared/group.clh.
 */
#include "light/photons.clh"
#include "light/slots.clh"
#include "light/spread.clh"
#include "light/sums.clh"
#include "shared/group.clh"

/* ---- leaves ---- */

/* Counts hits, one atomic for a group. All items of the group call it. */
static void svo_count_hits(uint hits, volatile __global uint *counters, __local uint *scratch)
{
    const uint sum = svo_group_sum(hits, scratch);
    if (get_local_id(0) == 0 && sum > 0u) {
        atomic_add(counters + SVO_PHOTON_HITS, sum);
    }
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
                  __local uint *scratch, svo_photon_params params, svo_light_view_params view)
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
    for (uint k = 0; k < count && params.spreads != 0u; ++k) {
        uint parts = 0u;
        if (own[k] < SVO_SPREAD_CELLS) {
            svo_footprint footprint;
            svo_find_footprint(&view, view.first + first + k, hits + first + k, params.cells, &footprint);
            parts = svo_spread_photon(&tree, &places[k], &footprint, own[k], &reach);
        }
        spreads[item].parts[k] = parts;
    }
    if (params.spreads != 0u && count > 0u) {
        svo_keep_reach(&reach, spreads + item, slots, counters);
    }
    svo_count_hits(params.spreads != 0u ? met : 0u, counters, scratch);
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
        if (params.spreads != 0u) {
            spreads[item].parts[k] = parts;
        }
    }
    if (params.spreads != 0u && count > 0u) {
        svo_keep_reach(&reach, spreads + item, slots, counters);
    }
    svo_count_hits(params.spreads != 0u ? met : 0u, counters, scratch);
}

/* ---- sums ---- */

/* Sums of a leaf that are not in memory yet. */
typedef struct svo_photon_sums {
    ulong flux[SVO_FLUX_SUMS]; /* two's complement where a direction is negative */
#ifdef SVO_LIGHT_FACES
    ulong faces[SVO_FACE_SUMS];
#endif
} svo_photon_sums;

static void svo_clear_sums(svo_photon_sums *sums)
{
    for (uint k = 0; k < SVO_FLUX_SUMS; ++k) {
        sums->flux[k] = 0ul;
    }
#ifdef SVO_LIGHT_FACES
    for (uint k = 0; k < SVO_FACE_SUMS; ++k) {
        sums->faces[k] = 0ul;
    }
#endif
}

/* Adds to a sum of two words, low word first. */
static void svo_add_wide(volatile __global uint *sum, ulong amount)
{
    if (amount == 0ul) {
        return;
    }
    const uint low = (uint)amount;
    const uint before = atomic_add(sum, low);
    const uint carry = low > UINT_MAX - before ? 1u : 0u;
    const uint high = (uint)(amount >> 32) + carry;
    if (high != 0u) {
        atomic_add(sum + 1, high);
    }
}

static void svo_store_sums(volatile __global uint *sums, uint slot, const svo_photon_sums *added)
{
    volatile __global uint *to = sums + (size_t)slot * SVO_LEAF_SUMS * 2;
    for (uint k = 0; k < SVO_FLUX_SUMS; ++k) {
        svo_add_wide(to + 2u * k, added->flux[k]);
    }
#ifdef SVO_LIGHT_FACES
    for (uint k = 0; k < SVO_FACE_SUMS; ++k) {
        svo_add_wide(to + 2u * (SVO_FLUX_SUMS + k), added->faces[k]);
    }
#endif
}

/* ---- photons ---- */

/* The flux of a photon in a channel: that of a pixel of weight 1, times its weight, rounded down. */
static ulong svo_photon_flux(const svo_light_view_params *view, uint weight, uint channel)
{
    const ulong of_one = (ulong)view->flux[2u * channel + 1u] << 32 | view->flux[2u * channel];
    return mul_hi(of_one << 8, (ulong)weight << (64 - SVO_WEIGHT_UNIT_LOG2 - 8));
}

/* What the parts of a photon from first up to end have of its flux: over all parts, exactly all of it. */
static ulong svo_flux_of_parts(ulong flux, uint first, uint end)
{
    return flux * end / SVO_SPREAD_PARTS - flux * first / SVO_SPREAD_PARTS;
}

/* Adds the parts of a photon from parts.x up to parts.y. normal: of the surface, on either side. */
static void svo_sum_photon(const svo_light_view_params *view, uint photon, svo_photon_weight weight, float3 normal,
                           uint2 parts, svo_photon_sums *sums)
{
    float x;
    float y;
    svo_photon_pixel(view, photon, &x, &y);
    const float3 along = svo_photon_direction(view, x, y);
    const float scale = (float)weight.inverse_length * (0x1p-31f * (1u << SVO_FLUX_UNIT_LOG2));
    const float3 way = rint(along * scale);
    const int unit[3] = {(int)way.x, (int)way.y, (int)way.z};
    ulong all = 0ul;
    ulong flux[3];
    for (uint channel = 0; channel < 3u; ++channel) {
        flux[channel] = svo_flux_of_parts(svo_photon_flux(view, weight.flux, channel), parts.x, parts.y);
        sums->flux[channel] += flux[channel];
        all += flux[channel];
    }
    for (uint axis = 0; axis < 3u; ++axis) {
        sums->flux[3u + axis] += (ulong)svo_scale_wide(all, unit[axis], SVO_FLUX_UNIT_LOG2);
    }
#ifdef SVO_LIGHT_FACES
    /* The side that the photon came from. A ray along +x sees what faces it, where the normal's x is negative. */
    const float3 facing = along.x * normal.x + along.y * normal.y + along.z * normal.z > 0.0f ? -normal : normal;
    const float3 cosine = rint(facing * (float)(1u << SVO_COSINE_UNIT_LOG2));
    const int cosines[3] = {(int)cosine.x, (int)cosine.y, (int)cosine.z};
    for (uint axis = 0; axis < 3u; ++axis) {
        const uint direction = 2u * axis + (cosines[axis] > 0 ? 1u : 0u);
        const int size = abs(cosines[axis]);
        for (uint channel = 0; channel < 3u; ++channel) {
            sums->faces[3u * direction + channel] += (ulong)svo_scale_wide(flux[channel], size, SVO_COSINE_UNIT_LOG2);
        }
    }
#else
    (void)normal;
#endif
}

/* Flux that no leaf gets. */
static void svo_lose_photon(const svo_light_view_params *view, uint weight, volatile __global uint *counters)
{
    for (uint channel = 0; channel < 3u; ++channel) {
        svo_add_wide(counters + SVO_PHOTON_NO_LEAF + 2u * channel, svo_photon_flux(view, weight, channel));
    }
}

/* hits: of triangles or of voxels; both have the normal in words 4 to 6. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_photon_add(__global const svo_photon_weight *weights, __global const float8 *hits, __global const uint *leaves,
                 __global const svo_photon_spread *spreads, __global const uint *slots, volatile __global uint *sums,
                 volatile __global uint *counters, svo_light_view_params view)
{
    const uint item = (uint)get_global_id(0);
    const uint first = item * SVO_ITEM_PHOTONS;
    const uint count = first < view.count ? min(view.count - first, (uint)SVO_ITEM_PHOTONS) : 0u;
    uint given[SVO_ITEM_PHOTONS];
    for (uint k = 0; k < count; ++k) {
        given[k] = 0u;
        if (leaves[first + k] == SVO_PHOTON_LOST) {
            svo_lose_photon(&view, weights[first + k].flux, counters);
        }
    }
    for (uint place = 0; place < SVO_SPREAD_CELLS && count > 0u; ++place) {
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
                svo_sum_photon(&view, view.first + photon, weights[photon], hits[photon].s456,
                               (uint2)(before, given[k]), &added);
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
