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
 * Launch: as above, one dimension; top: one work-item. No atomics, no local memory.
 */
#include "bvh/ranges.clh"
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

/* Splits a large range and returns the place. */
static uint svo_bvh_split_codes(__global const uint *fragments, __global svo_bvh_branch *branches, svo_bvh_job range,
                                svo_bvh_centers centers)
{
    const uint differing = (uint)svo_fragment_code(fragments, range.first) ^
                           (uint)svo_fragment_code(fragments, range.first + range.count - 1u);
    uint split = range.first + range.count / 2u;
    float area = 0.5f * branches[range.link >> 1].area[range.link & 1u];
    if (differing != 0u && svo_bvh_is_free(range.count, range.halvings)) {
        const uint bit = 31u - clz(differing);
        split = svo_bvh_find_bit(fragments, range.first, range.count, bit);
        area = svo_bvh_cell_area(centers, 3u * SVO_BVH_CODE_BITS - bit);
    }
    svo_bvh_write_branch(branches, range.link, split, area, area);
    return split;
}

__kernel void svo_k_bvh_top(__global const svo_bvh_range *root, __global const uint *fragments,
                            __global svo_bvh_branch *branches, __global svo_bvh_job *jobs,
                            __global svo_bvh_state *state, uint item_count)
{
    const svo_bvh_centers centers = svo_bvh_centers_of(root);
    const svo_bvh_job all = {0u, item_count, root->halvings, 0u};
    svo_bvh_job stack[SVO_BVH_DEPTH_MAX + 1];
    uint height = 1u;
    uint job_count = 0u;
    stack[0] = all;
    while (height > 0u) {
        const svo_bvh_job range = stack[--height];
        if (range.count <= SVO_BVH_SWEEP_ITEMS) {
            jobs[job_count++] = range;
            continue;
        }
        const uint split = svo_bvh_split_codes(fragments, branches, range, centers);
        stack[height++] = svo_bvh_second_part(range, split);
        stack[height++] = svo_bvh_first_part(range, split);
    }
    state->job_count = job_count;
}

/* The best split of a range in its order, and half the areas of its parts. */
static uint svo_bvh_find_sweep(__global const float8 *items, uint count, float *areas, float *first_area)
{
    float8 sum = SVO_BVH_EMPTY_BOX;
    for (uint i = count - 1u; i > 0u; --i) {
        sum = min(sum, items[i]);
        areas[i] = svo_bvh_half_area(sum);
    }
    uint best = 0u;
    float least = 0.0f;
    sum = SVO_BVH_EMPTY_BOX;
    for (uint i = 1u; i < count; ++i) {
        sum = min(sum, items[i - 1u]);
        const float area = svo_bvh_half_area(sum);
        const float cost = area * (float)i + areas[i] * (float)(count - i);
        if (best == 0u || cost < least) {
            best = i;
            least = cost;
            *first_area = area;
        }
    }
    return best;
}

__kernel void svo_k_bvh_sweep(__global const svo_bvh_job *jobs, __global const float8 *items,
                              __global svo_bvh_branch *branches, uint job_count)
{
    if (get_global_id(0) >= job_count) {
        return;
    }
    float areas[SVO_BVH_SWEEP_ITEMS];
    svo_bvh_job stack[SVO_BVH_DEPTH_MAX + 1];
    uint height = 1u;
    stack[0] = jobs[get_global_id(0)];
    while (height > 0u) {
        const svo_bvh_job range = stack[--height];
        if (range.count <= SVO_RAY_LEAF_TRIANGLES) {
            branches[range.link >> 1].part[range.link & 1u] = 0u;
            continue;
        }
        float first_area = 0.5f * branches[range.link >> 1].area[range.link & 1u];
        float second_area = first_area;
        uint split = range.count / 2u;
        if (svo_bvh_is_free(range.count, range.halvings)) {
            split = svo_bvh_find_sweep(items + range.first, range.count, areas, &first_area);
            second_area = areas[split];
        }
        split += range.first;
        svo_bvh_write_branch(branches, range.link, split, first_area, second_area);
        stack[height++] = svo_bvh_second_part(range, split);
        stack[height++] = svo_bvh_first_part(range, split);
    }
}
