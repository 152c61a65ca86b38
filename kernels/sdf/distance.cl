/* SPDX-License-Identifier: MIT */
/*
 * The distances of a brick's voxels, from its candidates (refine.cl). A work-item has the eight voxels of a cell two
 * voxels wide. It looks into the leaf that seems nearest, and then into all others that some voxel has nearer than what
 * it has found. Distances do not depend on the order: each is the least of numbers that a triangle and a voxel alone
 * determine, and what is left out is farther by more than their errors.
 *
 * Launch: svo_k_sdf_distance, one work-item per cell of a brick, rounded up to whole groups; distances of voxels
 * outside the band are infinite. svo_k_sdf_gather, the same: writes the voxels in the band, in Morton order. No
 * atomics, no local memory.
 */
#include "sdf/nearest.clh"
#include "shared/nodes.clh"

#ifdef cl_khr_fp64

/* Triangles that a work-item remembers, so that it does not take one again: a power of two. */
#define SVO_SDF_SEEN 8u

#define SVO_SDF_FLOAT_ERROR  0x1p-20f
#define SVO_SDF_FLOAT_MARGIN (1.0f + SVO_SDF_FLOAT_ERROR)

typedef struct svo_sdf_mesh {
    __global const uint *indices;
    __global const uint *positions;
    __global const uint *list_begin;
    __global const uint *list;
} svo_sdf_mesh;

typedef struct svo_sdf_cell {
    svo_sdf_search search;
    int4 corner; /* the first voxel; w: 0 */
    float8 limit; /* squared distances in voxels: what is farther is of no interest */
    float most; /* of limit */
    uint seen[SVO_SDF_SEEN];
} svo_sdf_cell;

/* Whether a squared distance is within its limit. */
static bool svo_sdf_is_within(float8 squared, float8 limit)
{
    const float8 over = squared - limit;
    const float4 four = min(over.lo, over.hi);
    const float2 two = min(four.lo, four.hi);
    return min(two.x, two.y) <= 0.0f;
}

/* Squared distances from the voxels to a leaf, in voxels. */
static float8 svo_sdf_near_voxels(const svo_sdf_cell *cell, int4 leaf)
{
    const float4 away = convert_float4(cell->corner - leaf);
    const float8 x =
        max(fabs(away.x + (float8)(0.0f, 1.0f, 0.0f, 1.0f, 0.0f, 1.0f, 0.0f, 1.0f)) - 0.5f, (float8)(0.0f));
    const float8 y =
        max(fabs(away.y + (float8)(0.0f, 0.0f, 1.0f, 1.0f, 0.0f, 0.0f, 1.0f, 1.0f)) - 0.5f, (float8)(0.0f));
    const float8 z =
        max(fabs(away.z + (float8)(0.0f, 0.0f, 0.0f, 0.0f, 1.0f, 1.0f, 1.0f, 1.0f)) - 0.5f, (float8)(0.0f));
    return x * x + y * y + z * z;
}

/* Whether a node may be near enough to a voxel of the cell: by the distance from the box of the voxels' centers. */
static bool svo_sdf_is_near(const svo_sdf_cell *cell, int4 node, uint node_log2)
{
    const float half_width = 0.5f * (float)(1u << node_log2);
    const float4 apart = fabs(convert_float4(cell->corner - (node << (int4)((int)node_log2))) + 1.0f - half_width);
    const float4 away = max(apart - (half_width + 0.5f), (float4)(0.0f));
    return away.x * away.x + away.y * away.y + away.z * away.z <= cell->most;
}

/* The squared distance from the middle of the cell to that of a node, in voxels. */
static float svo_sdf_apart(const svo_sdf_cell *cell, int4 node, uint node_log2)
{
    const float half_width = 0.5f * (float)(1u << node_log2);
    const float4 away = convert_float4(cell->corner - (node << (int4)((int)node_log2))) + 1.0f - half_width;
    return away.x * away.x + away.y * away.y + away.z * away.z;
}

static int4 svo_sdf_octant_of(int4 node, uint octant)
{
    return 2 * node + (int4)((int)(octant & 1u), (int)(octant >> 1 & 1u), (int)(octant >> 2), 0);
}

static void svo_sdf_set_limit(svo_sdf_cell *cell, float8 limit)
{
    const float4 four = max(limit.lo, limit.hi);
    const float2 two = max(four.lo, four.hi);
    cell->limit = limit;
    cell->most = max(two.x, two.y);
}

/* Whether what a triangle has in a leaf may be near enough: by the box that is the leaf's and the triangle's. a, b, c:
   relative to the center of the first voxel, raised. offset: from there to the leaf's low corner, in voxels. */
static bool svo_sdf_part_is_near(const svo_sdf_cell *cell, float4 offset, double4 a, double4 b, double4 c)
{
    const float voxel = (float)cell->search.voxel;
    const float per_voxel = 1.0f / voxel;
    const float4 low = convert_float4(min(a, min(b, c))) * per_voxel;
    const float4 high = convert_float4(max(a, max(b, c))) * per_voxel;
    const float4 from = max(offset, low - fabs(low) * SVO_SDF_FLOAT_ERROR);
    const float4 to = min(offset + 1.0f, high + fabs(high) * SVO_SDF_FLOAT_ERROR);
    const float8 vx = (float8)(0.0f, 1.0f, 0.0f, 1.0f, 0.0f, 1.0f, 0.0f, 1.0f);
    const float8 vy = (float8)(0.0f, 0.0f, 1.0f, 1.0f, 0.0f, 0.0f, 1.0f, 1.0f);
    const float8 vz = (float8)(0.0f, 0.0f, 0.0f, 0.0f, 1.0f, 1.0f, 1.0f, 1.0f);
    const float8 x = max(max(from.x - vx, vx - to.x), (float8)(0.0f));
    const float8 y = max(max(from.y - vy, vy - to.y), (float8)(0.0f));
    const float8 z = max(max(from.z - vz, vz - to.z), (float8)(0.0f));
    return svo_sdf_is_within(x * x + y * y + z * z, cell->limit);
}

/* leaf: w: its index. */
static void svo_sdf_take_leaf(svo_sdf_cell *cell, const svo_sdf_mesh *mesh, int4 leaf, const svo_sdf_params *params)
{
    svo_sdf_search *search = &cell->search;
    const float4 offset = convert_float4(leaf - cell->corner) - 0.5f;
    const uint first = (uint)leaf.w - params->leaf_begin;
    const uint end = mesh->list_begin[first + 1u];
    bool found = false;
    for (uint i = mesh->list_begin[first]; i < end; ++i) {
        const uint triangle = mesh->list[i];
        if (cell->seen[triangle % SVO_SDF_SEEN] == triangle) {
            continue;
        }
        const uint3 corners = vload3(triangle, mesh->indices);
        const double4 a = svo_sdf_relative(search, svo_sdf_corner(mesh->positions, corners.x, params));
        const double4 b = svo_sdf_relative(search, svo_sdf_corner(mesh->positions, corners.y, params));
        const double4 c = svo_sdf_relative(search, svo_sdf_corner(mesh->positions, corners.z, params));
        if (svo_sdf_part_is_near(cell, offset, a, b, c)) {
            cell->seen[triangle % SVO_SDF_SEEN] = triangle;
            svo_sdf_take(search, a, b, c);
            found = true;
        }
    }
    if (found) {
        const float8 squared = convert_float8(search->best / (search->voxel * search->voxel));
        svo_sdf_set_limit(cell, min(squared * SVO_SDF_FLOAT_MARGIN, (float8)(params->reach * params->reach)));
    }
}

/* Takes the leaves below a node two voxels wide. */
static void svo_sdf_take_pair(svo_sdf_cell *cell, const svo_sdf_mesh *mesh, __global const uchar *child_mask,
                              __global const uint *first_child, int4 node, const svo_sdf_params *params)
{
    const uint mask = child_mask[node.w];
    int index = (int)first_child[node.w];
    for (uint octant = 0; octant < 8u; ++octant) {
        if ((mask >> octant & 1u) == 0u) {
            continue;
        }
        int4 leaf = svo_sdf_octant_of(node, octant);
        leaf.w = index++;
        if (svo_sdf_is_within(svo_sdf_near_voxels(cell, leaf), cell->limit)) {
            svo_sdf_take_leaf(cell, mesh, leaf, params);
        }
    }
}

/* Takes the leaves below a node that may be near enough. */
static void svo_sdf_take_node(svo_sdf_cell *cell, const svo_sdf_mesh *mesh, __global const uchar *child_mask,
                              __global const uint *first_child, int4 node, const svo_sdf_params *params)
{
    if (!svo_sdf_is_near(cell, node, params->brick_log2)) {
        return;
    }
    if (params->brick_log2 == 1u) {
        svo_sdf_take_pair(cell, mesh, child_mask, first_child, node, params);
        return;
    }
    const uint mask = child_mask[node.w];
    int index = (int)first_child[node.w];
    for (uint octant = 0; octant < 8u; ++octant) {
        if ((mask >> octant & 1u) == 0u) {
            continue;
        }
        int4 pair = svo_sdf_octant_of(node, octant);
        pair.w = index++;
        if (svo_sdf_is_near(cell, pair, 1u)) {
            svo_sdf_take_pair(cell, mesh, child_mask, first_child, pair, params);
        }
    }
}

/* Takes the leaf that seems nearest: down from the nearest candidate, to the child whose middle is nearest. */
static void svo_sdf_take_first(svo_sdf_cell *cell, const svo_sdf_mesh *mesh, __global const uchar *child_mask,
                               __global const uint *first_child, int4 node, const svo_sdf_params *params)
{
    for (uint node_log2 = params->brick_log2; node_log2-- > 0u;) {
        const uint mask = child_mask[node.w];
        const int4 above = node;
        int index = (int)first_child[above.w];
        float least = INFINITY;
        for (uint octant = 0; octant < 8u; ++octant) {
            if ((mask >> octant & 1u) == 0u) {
                continue;
            }
            const int4 below = svo_sdf_octant_of(above, octant);
            const float apart = svo_sdf_apart(cell, below, node_log2);
            if (apart < least) {
                least = apart;
                node = below;
                node.w = index;
            }
            ++index;
        }
    }
    svo_sdf_take_leaf(cell, mesh, node, params);
}

static void svo_sdf_begin_cell(svo_sdf_cell *cell, int4 corner, const svo_sdf_params *params)
{
    svo_sdf_search *search = &cell->search;
    const double width = svo_sdf_double(params->voxel[0], params->voxel[1]);
    const double2 x = svo_sdf_center(svo_sdf_double(params->origin[0], params->origin[1]), width, (uint)corner.x);
    const double2 y = svo_sdf_center(svo_sdf_double(params->origin[2], params->origin[3]), width, (uint)corner.y);
    const double2 z = svo_sdf_center(svo_sdf_double(params->origin[4], params->origin[5]), width, (uint)corner.z);
    search->high = (double4)(x.x, y.x, z.x, 0.0);
    search->low = (double4)(x.y, y.y, z.y, 0.0);
    search->raise = svo_sdf_double(params->raise[0], params->raise[1]);
    search->voxel = width * search->raise;
    search->best = (double8)(INFINITY);
    cell->corner = corner;
    svo_sdf_set_limit(cell, (float8)(params->reach * params->reach));
    for (uint i = 0; i < SVO_SDF_SEEN; ++i) {
        cell->seen[i] = SVO_NO_TRIANGLE;
    }
}

/* Bit v: voxel v of the cell is inside. inside_mask: of empty children; inside_leaf: of leaves. */
static uint svo_sdf_inside(__global const uchar *child_mask, __global const uint *first_child,
                           __global const uchar *inside_mask, __global const uchar *inside_leaf, int4 corner,
                           const svo_sdf_params *params)
{
    const uint place[3] = {(uint)corner.x >> 1, (uint)corner.y >> 1, (uint)corner.z >> 1};
    svo_node node;
    svo_walk_down(child_mask, first_child, params->depth - 1u, place, &node);
    if (node.level + 1u < params->depth) {
        const uint shift = params->depth - 2u - node.level;
        const uint octant = (place[0] >> shift & 1u) | (place[1] >> shift & 1u) << 1 | (place[2] >> shift & 1u) << 2;
        return (inside_mask[node.index] >> octant & 1u) != 0u ? 255u : 0u;
    }
    const uint mask = child_mask[node.index];
    uint inside = inside_mask[node.index];
    uint leaf = first_child[node.index] - params->leaf_begin;
    for (uint octant = 0; octant < 8u; ++octant) {
        if ((mask >> octant & 1u) != 0u) {
            inside |= (inside_leaf[leaf++] != 0u ? 1u : 0u) << octant;
        }
    }
    return inside;
}

/* The first voxel of a work-item's cell. */
static int4 svo_sdf_corner_of(__global const int4 *bricks, uint item, const svo_sdf_params *params)
{
    const uint cells_log2 = 3u * (params->brick_log2 - 1u); /* cells of a brick */
    const int4 corner = bricks[item >> cells_log2] << (int4)((int)params->brick_log2);
    const int octant = (int)(item & ((1u << cells_log2) - 1u));
    return (int4)(corner.x + 2 * (octant & 1), corner.y + 2 * (octant >> 1 & 1), corner.z + 2 * (octant >> 2), 0);
}

/* Finds the distances of a cell's voxels. */
static void svo_sdf_search_cell(svo_sdf_cell *cell, const svo_sdf_mesh *mesh, __global const uchar *child_mask,
                                __global const uint *first_child, __global const int4 *candidates, uint2 range,
                                const svo_sdf_params *params)
{
    float least = INFINITY;
    uint nearest = range.x;
    bool is_near = false;
    for (uint i = range.x; i < range.y; ++i) {
        const float apart = svo_sdf_apart(cell, candidates[i], params->brick_log2);
        is_near = is_near || svo_sdf_is_near(cell, candidates[i], params->brick_log2);
        nearest = apart < least ? i : nearest;
        least = min(least, apart);
    }
    if (!is_near) {
        return;
    }
    svo_sdf_take_first(cell, mesh, child_mask, first_child, candidates[nearest], params);
    for (uint i = range.x; i < range.y; ++i) {
        svo_sdf_take_node(cell, mesh, child_mask, first_child, candidates[i], params);
    }
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_sdf_distance(__global const uchar *child_mask, __global const uint *first_child, __global const uint *indices,
                   __global const uint *positions, __global const uint *list_begin, __global const uint *list,
                   __global const uchar *inside_mask, __global const uchar *inside_leaf, __global const int4 *bricks,
                   __global const uint *begin, __global const int4 *candidates, __global float *distances,
                   __global uint *counts, svo_sdf_params params)
{
    const uint item = (uint)get_global_id(0);
    const uint brick = item >> 3u * (params.brick_log2 - 1u);
    if (brick >= params.count) {
        return;
    }
    const svo_sdf_mesh mesh = {indices, positions, list_begin, list};
    const int4 corner = svo_sdf_corner_of(bricks, item, &params);
    svo_sdf_cell cell;
    svo_sdf_begin_cell(&cell, corner, &params);
    svo_sdf_search_cell(&cell, &mesh, child_mask, first_child, candidates, (uint2)(begin[brick], begin[brick + 1u]),
                        &params);
    const float8 away = convert_float8(sqrt(cell.search.best) / cell.search.raise);
    const int8 in_band = away < params.band;
    const uint inside = params.is_signed != 0u && any(in_band)
                            ? svo_sdf_inside(child_mask, first_child, inside_mask, inside_leaf, corner, &params)
                            : 0u;
    const int8 bits = (int8)(1, 2, 4, 8, 16, 32, 64, 128) & (int)inside;
    const float8 with_sign = select(away, -away, bits != 0);
    if (params.is_dense == 0u) {
        const int8 ones = in_band & 1;
        const int4 pairs = ones.lo + ones.hi;
        vstore8(select((float8)(INFINITY), with_sign, in_band), item, distances);
        counts[item] = (uint)(pairs.x + pairs.y + pairs.z + pairs.w);
        return;
    }
    const size_t row = (size_t)1 << params.depth;
    __global float *to = distances + (((size_t)corner.z * row + (size_t)corner.y) * row + (size_t)corner.x);
    vstore2(with_sign.s01, 0, to);
    vstore2(with_sign.s23, 0, to + row);
    vstore2(with_sign.s45, 0, to + row * row);
    vstore2(with_sign.s67, 0, to + row * row + row);
}

/* sums: of counts before each cell; first: of the batches before. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_sdf_gather(__global const int4 *bricks, __global const float *distances, __global const uint *sums,
                 __global ulong *codes, __global float *band, uint first, svo_sdf_params params)
{
    const uint item = (uint)get_global_id(0);
    if (item >> 3u * (params.brick_log2 - 1u) >= params.count || sums[item] == sums[item + 1u]) {
        return;
    }
    const int4 corner = svo_sdf_corner_of(bricks, item, &params);
    const uint place[3] = {(uint)corner.x, (uint)corner.y, (uint)corner.z};
    const ulong code = svo_interleave(place);
    size_t to = (size_t)first + sums[item];
    for (uint v = 0; v < 8u; ++v) {
        const float distance = distances[8u * (size_t)item + v];
        if (distance < INFINITY) {
            codes[to] = code | v;
            band[to++] = distance;
        }
    }
}

#endif
