/* SPDX-License-Identifier: MIT */
/*
 * From the flux of leaves to their radiance. Lambertian surfaces reflect albedo / pi of their irradiance, so the
 * premultiplied radiance of a leaf of edge h for rays along e is the sum of albedo flux max(0, -m e) over pi h^2, where
 * m is the normal on the photon's side. Without directions it is albedo flux over pi times the surface's area in the
 * leaf. Leaves whose material emits add its radiance, times their opacity where radiance is premultiplied. Those that
 * shine (SVO_LIGHT_LOBES) add a lobe, see lobe.clh.
 *
 *   svo_k_emission_claim    per leaf: a slot if its material emits
 *   svo_k_lit_flags         per leaf: whether it has a slot; a scan makes places of that
 *   svo_k_lit_leaves        per leaf: the leaves that have one, in ascending order
 *   svo_k_radiance_bits     per lit leaf: the size of the largest radiance, from which the host finds a unit
 *   svo_k_radiance          per lit leaf: radiance in that unit, and its sums of flux
 *
 * Both of the last make what is stale anew, all of it where nothing is kept.
 *
 * Launch: as above, rounded up to whole groups. Integers alone. Atomics claim slots (photons.cl) and find a maximum; no
 * local memory.
 */
#include "light/leaf_surface.clh"
#include "light/sides.clh"
#include "light/slots.clh"
#include "light/sums.clh"

/* An opacity of 1: alpha times coverage. */
#define SVO_OPAQUE (255u * SVO_FACE_AREA)

#ifdef SVO_LIGHT_FACES
#define SVO_LEAF_DIRECTIONS 6u
#else
#define SVO_LEAF_DIRECTIONS 1u
#endif
/* Of radiance. */
#define SVO_LEAF_VALUES (3u * SVO_LEAF_DIRECTIONS)

/* ---- which leaves are lit ---- */

/* used: of each finish, whether a leaf has it. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_emission_claim(__global const ushort *materials, __global const uint *emits, volatile __global uint *used,
                     volatile __global uint *slots, volatile __global uint *counters, svo_exchange_params params)
{
    const uint leaf = (uint)get_global_id(0);
    if (leaf >= params.count) {
        return;
    }
    const uint finish = svo_leaf_finish(materials, leaf, &params);
    if (finish < params.finish_count && emits[finish] != 0u) {
        atomic_or(used + finish, 1u);
        svo_claim_slot(slots, counters, leaf);
    }
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_lit_flags(__global const uint *slots, __global uint *flags, svo_exchange_params params)
{
    const uint leaf = (uint)get_global_id(0);
    if (leaf < params.count) {
        flags[leaf] = slots[leaf] != SVO_SLOT_NONE ? 1u : 0u;
    }
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void svo_k_lit_leaves(__global const uint *slots,
                                                                                            __global const uint *places,
                                                                                            __global uint *leaves,
                                                                                            svo_exchange_params params)
{
    const uint leaf = (uint)get_global_id(0);
    if (leaf < params.count && slots[leaf] != SVO_SLOT_NONE) {
        leaves[places[leaf]] = leaf;
    }
}

/* ---- radiance ---- */

/* What a slot reflects for rays along a direction, over the share of the leaf's face where there are no directions.
   Sums are below 2^SVO_FLUX_TOTAL_LOG2 / 2, so this is below 2^63. */
static ulong svo_reflected(__global const uint *of_slot, uint direction, uint channel, const svo_leaf_surface *surface)
{
#ifdef SVO_LIGHT_FACES
    const ulong sum = svo_read_wide(of_slot + 2u * (SVO_FLUX_SUMS + 3u * direction + channel));
#else
    const ulong sum = svo_read_wide(of_slot + 2u * channel);
#endif
    ulong reflected = (ulong)svo_scale_wide(sum, (int)surface->albedo[channel], SVO_ALBEDO_UNIT_LOG2);
#ifdef SVO_LIGHT_LOBES
    const ulong flux = svo_read_wide(of_slot + 2u * channel);
    const ulong mirrored = (ulong)svo_scale_wide(flux, (int)surface->specular[channel], SVO_ALBEDO_UNIT_LOG2);
    reflected += (mirrored >> SVO_LOBE_BITS) * surface->shares[direction];
#endif
#ifdef SVO_LIGHT_FACES
    return reflected;
#else
    (void)direction;
    return reflected * SVO_FACE_AREA / surface->fill;
#endif
}

/* The bits of the largest value of a leaf. */
static uint svo_count_radiance_bits(const svo_surface_tree *tree, uint leaf, __global const uint *of_slot,
                                    const svo_exchange_params *params)
{
    svo_leaf_surface surface;
    svo_read_surface(tree, leaf, of_slot, params, &surface);
    ulong most = 0ul;
    for (uint k = 0; k < 3u * SVO_LEAF_DIRECTIONS; ++k) {
        most = max(most, svo_reflected(of_slot, k / 3u, k % 3u, &surface));
    }
    return 64u - (uint)clz(most);
}

/* slot_bits: where radiance is kept, of each slot. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_radiance_bits(__global const uint *leaves, __global const uint *slots, __global const uint *sums,
                    SVO_SURFACE_PARAMETERS, __global uint *slot_bits, volatile __global uint *counters,
                    svo_exchange_params params)
{
    const uint item = (uint)get_global_id(0);
    if (item >= params.count) {
        return;
    }
    SVO_SURFACE_MAKE(tree);
    const uint slot = slots[leaves[item]];
    const bool kept = params.kept != SVO_RADIANCE_OF_LEAVES;
    uint bits = kept ? slot_bits[slot] : SVO_SLOT_STALE;
    if ((bits & SVO_SLOT_STALE) != 0u) {
        bits = svo_count_radiance_bits(&tree, leaves[item], sums + (size_t)slot * SVO_LEAF_SUMS * 2, &params);
        if (kept) {
            slot_bits[slot] = bits | SVO_SLOT_STALE;
        }
    }
    bits &= SVO_SLOT_BITS;
    /* Few raise the maximum; an atomic for each would take most of the time. */
    if (bits > counters[SVO_PHOTON_BITS]) {
        atomic_max(counters + SVO_PHOTON_BITS, bits);
    }
}

/* reflected in the unit of radiance, rounded half up. */
static uint svo_to_unit(ulong reflected, const svo_exchange_params *params)
{
    const ulong factor = (ulong)params->factor_high << 32 | params->factor_low;
    const ulong scaled = mul_hi(reflected << 1, factor);
    return (uint)((scaled + (1ul << params->shift >> 1)) >> params->shift);
}

#ifdef SVO_LIGHT_FACES

/* How opaque a leaf is along a direction, SVO_OPAQUE = 1. */
static uint svo_leaf_opacity(__global const ushort *areas, uint leaf, uint direction, const svo_leaf_surface *surface,
                             const svo_exchange_params *params)
{
    const bool has_areas = (params->flags & SVO_EXCHANGE_AREAS) != 0u;
    const bool one_side = (params->flags & SVO_EXCHANGE_ONE_SIDE) != 0u;
    const uint area = has_areas ? svo_area_of_sides(areas, leaf, direction, one_side) : SVO_FACE_AREA;
    return surface->alpha * min(area, SVO_FACE_AREA);
}

#endif

/* The values of a leaf. */
static void svo_reflect(const svo_surface_tree *tree, __global const ushort *areas, uint leaf,
                        __global const uint *of_slot, const svo_exchange_params *params, __global uint *values)
{
    svo_leaf_surface surface;
    svo_read_surface(tree, leaf, of_slot, params, &surface);
    for (uint direction = 0; direction < SVO_LEAF_DIRECTIONS; ++direction) {
#ifdef SVO_LIGHT_FACES
        const uint opacity = svo_leaf_opacity(areas, leaf, direction, &surface, params);
#else
        const uint opacity = SVO_OPAQUE; /* the filter multiplies by it */
        (void)areas;
#endif
        for (uint channel = 0; channel < 3u; ++channel) {
            const ulong emitted = (ulong)surface.emission[channel] * opacity;
            const uint own = (uint)((emitted + SVO_OPAQUE / 2u) / SVO_OPAQUE);
            const ulong reflected = svo_reflected(of_slot, direction, channel, &surface);
            values[direction * 3u + channel] = own + svo_to_unit(reflected, params);
        }
    }
}

/* radiance: by slots where it is kept, else by lit leaves. flux: six sums of a lit leaf. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_radiance(__global const uint *leaves, __global const uint *slots, __global const uint *sums,
               SVO_SURFACE_PARAMETERS, __global const ushort *areas, __global uint *slot_bits, __global uint *radiance,
               __global uint *flux, svo_exchange_params params)
{
    const uint item = (uint)get_global_id(0);
    if (item >= params.count) {
        return;
    }
    SVO_SURFACE_MAKE(tree);
    const uint leaf = leaves[item];
    const uint slot = slots[leaf];
    __global const uint *of_slot = sums + (size_t)slot * SVO_LEAF_SUMS * 2;
    if (params.kept == SVO_RADIANCE_OF_LEAVES) {
        svo_reflect(&tree, areas, leaf, of_slot, &params, radiance + (size_t)item * SVO_LEAF_VALUES);
    } else if (params.kept == SVO_RADIANCE_OF_SLOTS || (slot_bits[slot] & SVO_SLOT_STALE) != 0u) {
        svo_reflect(&tree, areas, leaf, of_slot, &params, radiance + (size_t)slot * SVO_LEAF_VALUES);
        slot_bits[slot] = (slot_bits[slot] & SVO_SLOT_BITS) | SVO_SLOT_FRESH;
    } else {
        slot_bits[slot] &= SVO_SLOT_BITS;
    }
    for (uint k = 0; k < 2u * SVO_FLUX_SUMS; ++k) {
        flux[(size_t)item * 2u * SVO_FLUX_SUMS + k] = of_slot[k];
    }
}
