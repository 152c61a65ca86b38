/* SPDX-License-Identifier: MIT */
/*
 * The binary tree of SVO_BVH_FAST: items are sorted by the Morton codes of their centers once, and ranges are split
 * without moving items. Ranges of more than SVO_BVH_SWEEP_ITEMS are split where the highest bit of their codes changes
 * (Lauterbach et al., "Fast BVH Construction on GPUs", 2009); smaller ones where the surface area heuristic is least of
 * all places in this order.
 *
 *   svo_k_bvh_codes    per item: its code, as a fragment for sort.cl
 *   svo_k_bvh_gather   per place in the order: its item
 *   svo_k_bvh_top      splits large ranges; small ones become jobs
 *   svo_k_bvh_sweep    per job: splits it down to leaves
 *
 * Launch: as above, one dimension; top: one work-item per SVO_BVH_SWEEP_ITEMS items; sweep: a group of SVO_BVH_LANES
 * per job. Atomics: the order of jobs, which changes no result.
 */
#include "bvh/lanes.clh"
#include "shared/fragment.clh"

#define SVO_BVH_CODE_BITS 10 /* of an axis */

__kernel void svo_k_bvh_codes(__global const svo_bvh_range *root, __global const float8 *items,
                              __global uint *fragments, uint item_count)
{
    const uint i = (uint)get_global_id(0);
    if (i >= item_count) {
        return;
    }
    const svo_bvh_centers centers = svo_bvh_centers_of(root);
    const float4 scale = svo_bvh_cells_per_unit(centers, (float)(1 << SVO_BVH_CODE_BITS));
    const int4 cell = convert_int4((svo_bvh_center(items[i]) - centers.low) * scale);
    const svo_code code =
        svo_axis_code((uint)cell.x) | svo_axis_code((uint)cell.y) << 1 | svo_axis_code((uint)cell.z) << 2;
    svo_fragment_store(fragments, i, code, i);
}

__kernel void svo_k_bvh_gather(__global const uint *fragments, __global const float8 *items, __global float8 *sorted,
                               __global uint *order, uint item_count)
{
    const uint i = (uint)get_global_id(0);
    if (i < item_count) {
        const float8 item = items[svo_fragment_triangle(fragments, i)];
        sorted[i] = item;
        order[i] = svo_bvh_item_triangle(item);
    }
}

/* Half the area of a cell of the codes' first bits. */
static float svo_bvh_cell_area(svo_bvh_centers centers, uint bits)
{
    const float4 width = 0.5f * (centers.high - centers.low);
    const float x = width.x * as_float((127u - bits / 3u) << 23);
    const float y = width.y * as_float((127u - (bits + 1u) / 3u) << 23);
    const float z = width.z * as_float((127u - (bits + 2u) / 3u) << 23);
    return x * y + y * z + z * x;
}

/* The first place in a range whose code has a bit that the first code lacks. */
static uint svo_bvh_find_bit(__global const uint *fragments, uint first, uint count, uint bit)
{
    uint low = first;
    uint high = first + count - 1u;
    while (high - low > 1u) {
        const uint middle = low + (high - low) / 2u;
        if ((svo_fragment_code(fragments, middle) >> bit & 1u) != 0u) {
            high = middle;
        } else {
            low = middle;
        }
    }
    return high;
}

/* A split of a large range, and half the area of each part. */
typedef struct svo_bvh_code_split {
    uint at;
    float area;
} svo_bvh_code_split;

/* area: half that of the range. */
static svo_bvh_code_split svo_bvh_split_codes(__global const uint *fragments, svo_bvh_job range, float area,
                                              svo_bvh_centers centers)
{
    const uint differing = (uint)svo_fragment_code(fragments, range.first) ^
                           (uint)svo_fragment_code(fragments, range.first + range.count - 1u);
    svo_bvh_code_split split = {range.first + range.count / 2u, 0.5f * area};
    if (differing != 0u && svo_bvh_is_free(range.count, range.halvings)) {
        const uint bit = 31u - clz(differing);
        split.at = svo_bvh_find_bit(fragments, range.first, range.count, bit);
        split.area = svo_bvh_cell_area(centers, 3u * SVO_BVH_CODE_BITS - bit);
    }
    return split;
}

/* Adds a small part to the jobs. */
static void svo_bvh_add_job(svo_bvh_job part, __global svo_bvh_job *jobs, __global svo_bvh_state *state)
{
    if (part.count <= SVO_BVH_SWEEP_ITEMS) {
        jobs[atomic_inc(&state->job_count)] = part;
    }
}

/* Each work-item has an item, SVO_BVH_SWEEP_ITEMS after that of the one before, so that each large range has one. It
   follows the ranges with its item from the root down, and writes the splits of those where it is the first. */
__kernel void svo_k_bvh_top(__global const svo_bvh_range *root, __global const uint *fragments,
                            __global svo_bvh_branch *branches, __global svo_bvh_job *jobs,
                            __global svo_bvh_state *state, uint item_count)
{
    const uint item = (uint)get_global_id(0) * SVO_BVH_SWEEP_ITEMS;
    const svo_bvh_centers centers = svo_bvh_centers_of(root);
    svo_bvh_job range = {0u, item_count, root->halvings, 0u};
    svo_bvh_code_split split = {0u, branches[0].area[0]};
    if (item >= item_count) {
        return;
    }
    while (range.count > SVO_BVH_SWEEP_ITEMS) {
        split = svo_bvh_split_codes(fragments, range, split.area, centers);
        const svo_bvh_job first = svo_bvh_first_part(range, split.at);
        const svo_bvh_job second = svo_bvh_second_part(range, split.at);
        if (item - range.first < SVO_BVH_SWEEP_ITEMS) {
            svo_bvh_write_branch(branches, range.link, split.at, split.area, split.area);
            svo_bvh_add_job(first, jobs, state);
            svo_bvh_add_job(second, jobs, state);
        }
        range = item < split.at ? first : second;
    }
}

/* A split of a range in its order: the first item of the second part, 0: none; and half the area of the first part. */
typedef struct svo_bvh_place {
    uint at;
    float cost, first_area;
} svo_bvh_place;

/* Local memory of the lanes that sweep a job, SVO_BVH_SWEEP_BYTES. */
typedef struct svo_bvh_sweep_room {
    float8 before[SVO_GROUP_ITEMS],
        after[SVO_GROUP_ITEMS]; /* boxes of the strips of lanes up to each, and from it on */
    float areas[SVO_BVH_SWEEP_ITEMS]; /* half those of the boxes of the items from each on */
    svo_bvh_place places[SVO_GROUP_ITEMS]; /* the best split that a lane found */
    svo_bvh_job stack[SVO_BVH_DEPTH_MAX + 1];
} svo_bvh_sweep_room;
SVO_ASSERT_BYTES(svo_bvh_sweep_room, SVO_BVH_SWEEP_BYTES);

/* The boxes of all items before a lane's strip, and after it. lanes: how many have items. */
typedef struct svo_bvh_around {
    float8 before, after;
} svo_bvh_around;

SVO_INLINED void svo_bvh_box_around(__global const float8 *items, uint2 strip, uint lanes,
                                    __local svo_bvh_sweep_room *room, svo_bvh_around *around)
{
    const uint lane = svo_bvh_lane();
    float8 box = SVO_BVH_EMPTY_BOX;
    around->before = around->after = SVO_BVH_EMPTY_BOX;
    if (SVO_BVH_LANES == 1) {
        return;
    }
    for (uint i = strip.x; i < strip.y; ++i) {
        box = min(box, items[i]);
    }
    room->before[lane] = box;
    room->after[lane] = box;
    svo_bvh_meet();
    for (uint reach = 1u; reach < lanes; reach *= 2u) { /* see svo_group_exclusive */
        around->before = lane >= reach ? room->before[lane - reach] : SVO_BVH_EMPTY_BOX;
        around->after = lane + reach < SVO_BVH_LANES ? room->after[lane + reach] : SVO_BVH_EMPTY_BOX;
        svo_bvh_meet();
        room->before[lane] = min(room->before[lane], around->before);
        room->after[lane] = min(room->after[lane], around->after);
        svo_bvh_meet();
    }
    around->before = lane > 0u ? room->before[lane - 1u] : SVO_BVH_EMPTY_BOX;
    around->after = lane + 1u < SVO_BVH_LANES ? room->after[lane + 1u] : SVO_BVH_EMPTY_BOX;
}

/* The best split of a range in its order that the lane finds. sum: the box of all items before its strip. */
static svo_bvh_place svo_bvh_sweep_strip(__global const float8 *items, uint count, uint2 strip, float8 sum,
                                         __local const svo_bvh_sweep_room *room)
{
    svo_bvh_place best = {0u, 0.0f, 0.0f};
    for (uint i = strip.x + 1u; i <= min(strip.y, count - 1u); ++i) {
        sum = min(sum, items[i - 1u]);
        const float area = svo_bvh_half_area(sum);
        const float cost = area * (float)i + room->areas[i] * (float)(count - i);
        if (best.at == 0u || cost < best.cost) {
            const svo_bvh_place found = {i, cost, area};
            best = found;
        }
    }
    return best;
}

/* The best split of a range in its order, for all lanes. */
SVO_INLINED void svo_bvh_find_sweep(__global const float8 *items, uint count, __local svo_bvh_sweep_room *room,
                                    svo_bvh_place *best)
{
    const uint2 strip = svo_bvh_strip(0u, count);
    const uint lanes = min(count, (uint)SVO_BVH_LANES);
    svo_bvh_around around;
    svo_bvh_box_around(items, strip, lanes, room, &around);
    float8 sum = around.after;
    for (uint i = strip.y; i > max(strip.x, 1u); --i) {
        sum = min(sum, items[i - 1u]);
        room->areas[i - 1u] = svo_bvh_half_area(sum);
    }
    svo_bvh_meet();
    *best = svo_bvh_sweep_strip(items, count, strip, around.before, room);
    if (SVO_BVH_LANES > 1) {
        room->places[svo_bvh_lane()] = *best;
        svo_bvh_meet();
        *best = room->places[0];
        for (uint i = 1; i < lanes; ++i) {
            const svo_bvh_place place = room->places[i];
            if (place.at != 0u && (best->at == 0u || place.cost < best->cost)) {
                *best = place;
            }
        }
    }
}

SVO_BVH_LANES_KERNEL svo_k_bvh_sweep(__global const svo_bvh_job *jobs, __global const float8 *items,
                                     __global svo_bvh_branch *branches, __local svo_bvh_sweep_room *room)
{
    const uint lane = svo_bvh_lane();
    uint height = 1u;
    if (lane == 0u) {
        room->stack[0] = jobs[get_group_id(0)];
    }
    svo_bvh_meet();
    while (height > 0u) {
        const svo_bvh_job range = room->stack[--height];
        if (range.count <= SVO_RAY_LEAF_TRIANGLES) {
            if (lane == 0u) {
                branches[range.link >> 1].part[range.link & 1u] = 0u;
            }
        } else {
            const float area = 0.5f * branches[range.link >> 1].area[range.link & 1u];
            float second_area = area;
            svo_bvh_place place = {range.count / 2u, 0.0f, area};
            if (svo_bvh_is_free(range.count, range.halvings)) {
                svo_bvh_find_sweep(items + range.first, range.count, room, &place);
                second_area = room->areas[place.at];
            }
            svo_bvh_meet();
            if (lane == 0u) {
                const uint split = range.first + place.at;
                svo_bvh_write_branch(branches, range.link, split, place.first_area, second_area);
                room->stack[height] = svo_bvh_second_part(range, split);
                room->stack[height + 1u] = svo_bvh_first_part(range, split);
            }
            height += 2u;
            svo_bvh_meet();
        }
    }
}
