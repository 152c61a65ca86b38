/* SPDX-License-Identifier: MIT */
/*
 * Photons that go on from where they are: through what shows in part, from triangles that emit, and from what they met.
 *
 *   svo_k_photon_through   per photon: whether it goes on behind what it met, and then its ray
 *   svo_k_photon_emit      per photon of the pieces of triangles that emit: its ray, and what it carries
 *   svo_k_photon_send      per photon: its next ray from what it met, with what the albedo leaves of its flux
 *   svo_k_photon_land      per photon: what it carries into the sums of its leaf
 *
 * What shows in part stops as many of a view's photons as its alpha tells: numbers of the photons decide, of the first
 * dimension of Sobol' (sobol.clh), so that of four photons in a row, two by two pixels, half an alpha stops two.
 *
 * A photon leaves a Lambertian surface with the density of the cosine: along the normal plus a point of the unit
 * sphere. Points follow the sequence of sobol.clh by the number of the photon; neighbors in it have well spread
 * directions. Pieces of triangles are in the order of their leaves, so each part of an emitter has such neighbors.
 *
 * Directions are integers, whose roots and quotients are exact; floats are added and multiplied alone, without
 * contraction. So photons are the same on every device.
 *
 * Launch: one work-item per photon, rounded up to whole groups. Atomics: photons are listed by a counter, whose order
 * does not matter, and counted by one atomic a group; the sums of photon_sums.clh. svo_k_photon_send has
 * SVO_GROUP_ITEMS words of local memory as an argument, see shared/group.clh.
 */
#include "light/albedo.clh"
#include "light/photon_sums.clh"
#include "light/photons.clh"
#include "light/sobol.clh"
#include "rays/alpha.clh"
#include "shared/group.clh"

/* 1 of a direction's component. */
#define SVO_WAY_ONE (1l << SVO_FLUX_UNIT_LOG2)
/* Of what is sent on, shorter sums of a normal and a point of the sphere have no direction: 2^-12. */
#define SVO_WAY_SHORTEST (1ul << (SVO_FLUX_UNIT_LOG2 - 12))
/* Photons of a view or piece are stopped like the rays of sets of so many. */
#define SVO_THROUGH_SET 256u

/* ---- through what shows in part ---- */

/* The alpha of a leaf, 0 .. 255. */
static uint svo_onward_alpha(__global const uchar *colors, uint leaf, const svo_onward_params *params)
{
    const size_t place = (params->flags & SVO_ONWARD_ONE_COLOR) != 0u ? 0u : (size_t)params->leaf_begin + leaf;
    return colors[4u * place + 3u];
}

/* Whether a photon stops at a leaf. */
static bool svo_onward_stops(uint alpha, uint photon, const svo_onward_params *params)
{
    const float place = svo_sobol_pair(photon, svo_hash(params->seed)).x;
    const svo_alpha_ray ray = {(uint)(place * (float)SVO_THROUGH_SET), SVO_THROUGH_SET};
    return (params->flags & SVO_ONWARD_LAST) != 0u || svo_alpha_shows(alpha, ray, 0u);
}

/* hits: of the photons; found: with SVO_ONWARD_LISTED, of the rays that were searched behind them, by the list. rays:
   of the photons. behind, next_list: receive the rays that go on, and their photons. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_photon_through(__global const uchar *child_mask, __global const uint *first_child,
                     __global const uint *list_begin, __global const uint *list, __global const int *vertices,
                     __global const uint *indices, __global const uint *triangle_ids, __global const uchar *colors,
                     __global const svo_ray *rays, __global svo_hit *hits, __global const svo_hit *found,
                     __global svo_ray *behind, __global const uint *listed, __global uint *next_list,
                     volatile __global uint *counters, __global const uint *groups, svo_photon_params params,
                     svo_onward_params onward, svo_light_view_params view)
{
    const uint item = (uint)get_global_id(0);
    if (item >= onward.count) {
        return;
    }
    const svo_list_tree tree = {child_mask, first_child, list_begin, list, vertices, indices, triangle_ids, params};
    const bool is_listed = (onward.flags & SVO_ONWARD_LISTED) != 0u;
    const uint photon = is_listed ? listed[item] : item;
    if (is_listed) {
        hits[photon] = found[item];
    }
    const svo_hit hit = hits[photon];
    svo_photon_place place;
    if (hit.triangle == SVO_NO_TRIANGLE) {
        return;
    }
    const uint leaf = svo_leaf_of_hit(&tree, hit.triangle, hit.u, hit.v, &place);
    const uint alpha = svo_is_leaf(leaf) ? svo_onward_alpha(colors, leaf, &onward) : 255u;
    if (svo_onward_stops(alpha, svo_photon_number(&view, groups, photon), &onward)) {
        return;
    }
    const uint to = atomic_inc(counters + SVO_PHOTON_THROUGH) - onward.through;
    svo_ray ray = rays[photon];
    ray.t_min = max(hit.t + onward.offset, as_float(as_uint(hit.t) + 1u));
    behind[to] = ray;
    next_list[to] = photon;
}

/* ---- directions ---- */

/* The root of a number, rounded down; numbers: below 2^62. */
static ulong svo_whole_root(ulong number)
{
    ulong root = (ulong)sqrt((float)number);
    for (uint k = 0; k < 2u; ++k) {
        root = root > 0ul ? (root + number / root) / 2ul : 0ul;
    }
    while (root * root > number) {
        --root;
    }
    while ((root + 1ul) * (root + 1ul) <= number) {
        ++root;
    }
    return root;
}

/* Cosine and sine of a share of a turn, 2^24 = 1, from the middle of the first quarter: by their series, within
   2^-22. */
static float2 svo_turn(uint share)
{
    const float angle = ((float)(share & 0x3fffffu) * 0x1p-22f - 0.5f) * 1.57079632679f;
    const float square = angle * angle;
    const float sine = angle + angle * (square * (-1.6666667e-1f + square * (8.3333333e-3f - square * 1.984127e-4f)));
    const float cosine =
        1.0f + square * (-0.5f + square * (4.1666667e-2f + square * (-1.3888889e-3f + square * 2.4801587e-5f)));
    const uint quarter = share >> 22;
    const float x = (quarter & 1u) != 0u ? -sine : cosine;
    const float y = (quarter & 1u) != 0u ? cosine : sine;
    return (quarter & 2u) != 0u ? (float2)(-x, -y) : (float2)(x, y);
}

/* A direction from a surface with the density of the cosine. normal: unit; pair: of numbers below 2^24. */
SVO_INLINED void svo_find_way(const int *normal, uint2 pair, int *way)
{
    const long z = SVO_WAY_ONE - 2l * (long)pair.x - 1l;
    const float radius = (float)svo_whole_root((ulong)(SVO_WAY_ONE * SVO_WAY_ONE - z * z));
    const float2 across = rint(radius * svo_turn(pair.y));
    const long sum[3] = {(long)across.x + normal[0], (long)across.y + normal[1], z + normal[2]};
    const ulong size = svo_whole_root((ulong)(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]));
    const long above = sum[0] * normal[0] + sum[1] * normal[1] + sum[2] * normal[2];
    const bool has_one = size >= SVO_WAY_SHORTEST && above > 0l;
    for (uint axis = 0; axis < 3u; ++axis) {
        way[axis] = has_one ? (int)(sum[axis] * SVO_WAY_ONE / (long)size) : normal[axis];
    }
}

/* The ray of a photon from a point of a surface. */
SVO_INLINED void svo_set_onward(__global svo_ray *ray, float3 point, const int *normal, const int *way, float offset)
{
    for (uint axis = 0; axis < 3u; ++axis) {
        const float at = axis == 0u ? point.x : axis == 1u ? point.y : point.z;
        ray->origin[axis] = at + (float)normal[axis] * 0x1p-24f * offset;
        ray->direction[axis] = (float)way[axis] * 0x1p-24f;
    }
    ray->t_min = 0.0f;
    ray->t_max = INFINITY;
}

/* Numbers below 2^24 of the sequence of a photon. */
static uint2 svo_onward_pair(uint photon, uint seed)
{
    return convert_uint2(svo_sobol_pair(photon, svo_hash(seed)) * 0x1p24f);
}

/* ---- from triangles that emit ---- */

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_photon_emit(__global const svo_emitter_piece *pieces, __global svo_ray *rays,
                  __global svo_carried_photon *carried, svo_onward_params onward)
{
    const uint item = (uint)get_global_id(0);
    if (item >= onward.count) {
        return;
    }
    const uint photon = onward.first + item;
    uint low = 0u;
    uint high = onward.piece_count - 1u;
    while (low < high) {
        const uint middle = low + (high - low) / 2u;
        const bool is_before = pieces[middle].end <= photon;
        low = is_before ? middle + 1u : low;
        high = is_before ? high : middle;
    }
    __global const svo_emitter_piece *piece = pieces + low;
    const float2 square = svo_sobol_pair(photon, svo_hash(onward.seed + 1u));
    const float2 place = square.x + square.y > 1.0f ? 1.0f - square : square;
    const float3 point =
        vload3(0, piece->corner) + place.x * vload3(0, piece->first_edge) + place.y * vload3(0, piece->second_edge);
    const uint2 pair = svo_onward_pair(photon, onward.seed);
    const bool is_back = pair.x >= 1u << 23; /* both sides emit */
    int normal[3];
    int way[3];
    for (uint axis = 0; axis < 3u; ++axis) {
        normal[axis] = is_back ? -piece->normal[axis] : piece->normal[axis];
    }
    svo_find_way(normal, (uint2)(pair.x << 1 & 0xffffffu, pair.y), way);
    svo_set_onward(rays + item, point, normal, way, onward.offset);
    for (uint k = 0; k < 6u; ++k) {
        carried[item].flux[k] = piece->flux[k];
    }
    vstore3((int3)(way[0], way[1], way[2]), 0, carried[item].way);
}

/* ---- from what they met ---- */

/* What a photon brought to where it is. */
static ulong svo_brought(const svo_light_view_params *view, __global const svo_photon_weight *weights,
                         __global const svo_carried_photon *carried, uint item, uint channel, bool of_view)
{
    return of_view ? svo_photon_flux(view, weights[item].flux, channel)
                   : svo_read_wide(carried[item].flux + 2u * channel);
}

static uint svo_onward_albedo(__global const uchar *colors, uint leaf, uint channel, const svo_onward_params *params)
{
    const size_t place = (params->flags & SVO_ONWARD_ONE_COLOR) != 0u ? 0u : (size_t)params->leaf_begin + leaf;
    return (params->flags & SVO_ONWARD_COLORS) != 0u ? svo_albedo_of_byte(colors[4u * place + channel])
                                                     : SVO_ALBEDO_UNKNOWN;
}

/* Ends a photon, or gives it what it carries on. Returns whether it goes on. */
SVO_INLINED bool svo_carry_on(const ulong *flux, const svo_onward_params *params, __global svo_carried_photon *to)
{
    const ulong least = (ulong)params->least[1] << 32 | params->least[0];
    const bool goes_on = max(flux[0], max(flux[1], flux[2])) >= max(least, 1ul);
    for (uint channel = 0; channel < 3u; ++channel) {
        const ulong left = goes_on ? flux[channel] : 0ul;
        to->flux[2u * channel] = (uint)left;
        to->flux[2u * channel + 1u] = (uint)(left >> 32);
    }
    return goes_on;
}

/* hits: of triangles or of voxels; both have the distance in word 0 and the normal in words 4 to 6. rays: that brought
   the photons; receive those that they leave by. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_photon_send(__global const svo_photon_weight *weights, __global const float8 *hits, __global const uint *leaves,
                  __global const uchar *colors, __global svo_ray *rays, __global svo_carried_photon *carried,
                  volatile __global uint *counters, __local uint *scratch, svo_onward_params onward,
                  svo_light_view_params view)
{
    const uint item = (uint)get_global_id(0);
    const bool has_leaf = item < onward.count && svo_is_leaf(leaves[min(item, onward.count - 1u)]);
    const bool of_view = (onward.flags & SVO_ONWARD_VIEW) != 0u;
    ulong flux[3] = {0ul, 0ul, 0ul};
    bool goes_on = false;
    for (uint channel = 0; channel < 3u && has_leaf; ++channel) {
        const ulong brought = svo_brought(&view, weights, carried, item, channel, of_view);
        const int albedo = (int)svo_onward_albedo(colors, leaves[item], channel, &onward);
        flux[channel] = (ulong)svo_scale_wide(brought, albedo, SVO_ALBEDO_UNIT_LOG2);
    }
    if (item < onward.count) {
        goes_on = svo_carry_on(flux, &onward, carried + item);
        rays[item].t_max = goes_on ? INFINITY : 0.0f;
        rays[item].t_min = goes_on ? 0.0f : 1.0f;
    }
    if (goes_on) {
        const float8 hit = hits[item];
        const float3 along = vload3(0, rays[item].direction);
        const float3 facing = svo_toward(along, hit.s456);
        const float3 unit = rint(facing * (float)SVO_WAY_ONE);
        const int normal[3] = {(int)unit.x, (int)unit.y, (int)unit.z};
        int way[3];
        svo_find_way(normal, svo_onward_pair(onward.first + item, onward.seed), way);
        svo_set_onward(rays + item, vload3(0, rays[item].origin) + hit.s0 * along, normal, way, onward.offset);
        vstore3((int3)(way[0], way[1], way[2]), 0, carried[item].way);
    }
    const uint sum = svo_group_sum(goes_on ? 1u : 0u, scratch);
    if (get_local_id(0) == 0 && sum > 0u) {
        atomic_add(counters + SVO_PHOTON_ON, sum);
    }
}

/* ---- into leaves ---- */

/* hits: as above. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_photon_land(__global const svo_carried_photon *carried, __global const float8 *hits, __global const uint *leaves,
                  __global const uint *slots, volatile __global uint *sums, volatile __global uint *counters,
                  svo_onward_params onward)
{
    const uint item = (uint)get_global_id(0);
    if (item >= onward.count || leaves[item] == SVO_PHOTON_MISSED) {
        return;
    }
    ulong flux[3];
    for (uint channel = 0; channel < 3u; ++channel) {
        flux[channel] = svo_read_wide(carried[item].flux + 2u * channel);
    }
    if (leaves[item] == SVO_PHOTON_LOST) {
        for (uint channel = 0; channel < 3u; ++channel) {
            svo_add_wide(counters + SVO_PHOTON_NO_LEAF + 2u * channel, flux[channel]);
        }
        return;
    }
    const int3 way = vload3(0, carried[item].way);
    const int unit[3] = {way.x, way.y, way.z};
    svo_photon_sums landed;
    svo_clear_sums(&landed);
    svo_sum_flux(flux, convert_float3(way), unit, hits[item].s456, &landed);
    svo_store_sums(sums, slots[leaves[item]], &landed);
}
