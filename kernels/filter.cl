/* SPDX-License-Identifier: MIT */
/*
 * The payload, bottom up: mean colour and mean normal of every node, in integers.
 *
 *   svo_k_gather_level  per node of the deepest inner level: walks its leaves' linked lists, sums up what each triangle
 *                       contributes to the voxel, writes the leaves' payload and the node's sums. For lists of one chunk
 *   svo_k_gather        per leaf of a chunk: the same, but into sums of the leaf, on top of those of earlier chunks
 *   svo_k_filter        per node of a level, from the deepest one not done yet up: writes its children's payload and its
 *                       own sums
 *
 * Each (voxel, triangle) pair has weight 1. Sums are 64-bit, travel up unrounded, and each node rounds once, half up; so
 * the result depends neither on the order of the lists nor on how the fragments are cut into chunks.
 *
 * Launch: one work-item per node or leaf. No atomics: a node's sums are written by one work-item.
 * Buffers: sums of one level each, weights (uint), colour (4 ulong a node), normal (3 long a node).
 */
#include "attribute.clh"
#include "fragment.clh"

#if defined(SVO_COLOR) || defined(SVO_NORMAL)

/* What a node's sums are added up in. */
typedef struct svo_sums {
    uint weight;
#ifdef SVO_COLOR
    ulong4 color;
#endif
#ifdef SVO_NORMAL
    long x, y, z;
#endif
} svo_sums;

static svo_sums svo_no_sums(void)
{
    svo_sums sums;
    sums.weight = 0u;
#ifdef SVO_COLOR
    sums.color = (ulong4)(0);
#endif
#ifdef SVO_NORMAL
    sums.x = sums.y = sums.z = 0;
#endif
    return sums;
}

static svo_sums svo_load_sums(uint node, __global const uint *weights, __global const ulong *colors,
                              __global const long *normals)
{
    svo_sums sums;
    sums.weight = weights[node];
#ifdef SVO_COLOR
    sums.color = vload4(node, colors);
#endif
#ifdef SVO_NORMAL
    const long3 normal = vload3(node, normals);
    sums.x = normal.x;
    sums.y = normal.y;
    sums.z = normal.z;
#endif
    return sums;
}

static svo_sums svo_join_sums(svo_sums a, svo_sums b)
{
    a.weight += b.weight;
#ifdef SVO_COLOR
    a.color += b.color;
#endif
#ifdef SVO_NORMAL
    a.x += b.x;
    a.y += b.y;
    a.z += b.z;
#endif
    return a;
}

static void svo_store_sums(svo_sums sums, uint node, __global uint *weights, __global ulong *colors,
                           __global long *normals)
{
    weights[node] = sums.weight;
#ifdef SVO_COLOR
    vstore4(sums.color, node, colors);
#endif
#ifdef SVO_NORMAL
    vstore3((long3)(sums.x, sums.y, sums.z), node, normals);
#endif
}

#ifdef SVO_COLOR

/* (2 s + w) / (2 w), that is s / w rounded half up. Short lists, nearly all there are, divide in 32 bits. */
static uint4 svo_mean_color(ulong4 sum, uint weight)
{
    if (weight < 1u << 22) {
        return (2u * convert_uint4(sum) + weight) / (2u * weight);
    }
    return convert_uint4((2UL * sum + weight) / (2UL * weight));
}

#endif

#ifdef SVO_NORMAL

/* s / w rounded half up: floor((2 s + w) / (2 w)); the offset makes the dividend positive, since |s| <= 32768 w. */
static short svo_mean_normal(long sum, uint weight)
{
    if (weight < 1u << 14) {
        const uint dividend = (uint)((int)(2 * sum) + (int)weight + (int)(weight << 16));
        return (short)((int)(dividend / (2u * weight)) - 32768);
    }
    const ulong dividend = (ulong)(2 * sum + weight + ((long)weight << 16));
    return (short)((long)(dividend / (2UL * weight)) - 32768);
}

#endif

static void svo_store_payload(svo_sums sums, uint node, __global uint *colors, __global short *normals)
{
#ifdef SVO_COLOR
    const uint4 mean = svo_mean_color(sums.color, sums.weight);
    colors[node] = mean.x | mean.y << 8 | mean.z << 16 | mean.w << 24;
#endif
#ifdef SVO_NORMAL
    normals[3 * (size_t)node] = svo_mean_normal(sums.x, sums.weight);
    normals[3 * (size_t)node + 1] = svo_mean_normal(sums.y, sums.weight);
    normals[3 * (size_t)node + 2] = svo_mean_normal(sums.z, sums.weight);
#endif
}

/* No level above writes the root's payload: whoever sums up the root does. */
static void svo_store_root(svo_sums sums, uint node, __global uint *colors, __global short *normals)
{
    if (node == 0u && sums.weight != 0u) {
        svo_store_payload(sums, 0u, colors, normals);
    }
}

static void svo_add_pair(svo_sums *sums, svo_surface surface, uint triangle, int3 centre)
{
    int3 weights = (int3)(SVO_WEIGHT_ONE, 0, 0);
    if ((surface.records[triangle].flags & SVO_TRIANGLE_FLAT) == 0u) {
        __global const uint *corner = surface.indices + (size_t)triangle * 3u;
        weights =
            svo_corner_weights(surface.vertices + (size_t)corner[0] * 3u, surface.vertices + (size_t)corner[1] * 3u,
                               surface.vertices + (size_t)corner[2] * 3u,
                               surface.records[triangle].flags >> SVO_TRIANGLE_AXIS_SHIFT, centre);
    }
    sums->weight += 1u;
#ifdef SVO_COLOR
    sums->color += convert_ulong4(svo_surface_color(surface, triangle, weights));
#endif
#ifdef SVO_NORMAL
    const int3 normal = svo_surface_normal(surface, triangle, weights);
    sums->x += normal.x;
    sums->y += normal.y;
    sums->z += normal.z;
#endif
}

static int3 svo_voxel_centre(svo_code code, uint voxel_log2)
{
    const int3 voxel = (int3)(svo_code_axis(code, 0), svo_code_axis(code, 1), svo_code_axis(code, 2));
    return (voxel << (int)voxel_log2) + (1 << (int)voxel_log2 >> 1);
}

/* The sums of a leaf's list, on top of sums. link: its first fragment plus one. */
static svo_sums svo_sum_list(svo_sums sums, svo_surface surface, __global const uint *fragments,
                             __global const uint *links, uint link, uint voxel_log2)
{
    if (link != 0u) {
        const int3 centre = svo_voxel_centre(svo_fragment_code(fragments, link - 1u), voxel_log2);
        while (link != 0u) {
            svo_add_pair(&sums, surface, svo_fragment_triangle(fragments, link - 1u), centre);
            link = links[link - 1u];
        }
    }
    return sums;
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_gather(__global const uint *fragments, __global const uint *links, __global const uint *heads,
             __global const int *vertices, __global const uint *indices, __global const svo_triangle_record *records,
             __global const uint *vertex_colors, __global const short *vertex_normals, __global const int *uvs,
             __global const svo_material_record *materials, __global const uint *texels, __global uint *weights,
             __global ulong *color_sums, __global long *normal_sums, svo_filter_params params)
{
    const uint leaf = (uint)get_global_id(0);
    if (leaf >= params.leaf_count) {
        return;
    }
    const svo_surface surface = {vertices, indices, records, vertex_colors, vertex_normals, uvs, materials, texels};
    svo_sums sums = svo_no_sums();
    if (params.first_chunk == 0u) {
        sums = svo_load_sums(leaf, weights, color_sums, normal_sums);
    }
    sums = svo_sum_list(sums, surface, fragments, links, heads[leaf], params.voxel_log2);
    svo_store_sums(sums, leaf, weights, color_sums, normal_sums);
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void svo_k_gather_level(
    __global const uint *fragments, __global const uint *links, __global const uint *heads,
    __global const int *vertices, __global const uint *indices, __global const svo_triangle_record *records,
    __global const uint *vertex_colors, __global const short *vertex_normals, __global const int *uvs,
    __global const svo_material_record *materials, __global const uint *texels, __global uint *weights,
    __global ulong *color_sums, __global long *normal_sums, __global const uchar *masks,
    __global const uint *first_child, __global uint *colors, __global short *normals, svo_filter_params params)
{
    const uint index = (uint)get_global_id(0);
    if (index >= params.level_count) {
        return;
    }
    const svo_surface surface = {vertices, indices, records, vertex_colors, vertex_normals, uvs, materials, texels};
    const uint node = params.level_begin + index;
    const uint begin = first_child[node];
    const uint end = begin + popcount((uint)masks[node]);
    svo_sums sums = svo_no_sums();
    for (uint leaf = begin; leaf < end; ++leaf) {
        const uint link = heads[leaf - params.leaf_begin];
        const svo_sums part = svo_sum_list(svo_no_sums(), surface, fragments, links, link, params.voxel_log2);
        svo_store_payload(part, leaf, colors, normals);
        sums = svo_join_sums(sums, part);
    }
    svo_store_sums(sums, index, weights, color_sums, normal_sums);
    svo_store_root(sums, node, colors, normals);
}

/* Sums are indexed from the first node of their level; payload by the whole tree. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_filter(__global const uchar *masks, __global const uint *first_child, __global const uint *child_weights,
             __global const ulong *child_color_sums, __global const long *child_normal_sums, __global uint *weights,
             __global ulong *color_sums, __global long *normal_sums, __global uint *colors, __global short *normals,
             svo_filter_params params)
{
    const uint index = (uint)get_global_id(0);
    if (index >= params.level_count) {
        return;
    }
    const uint node = params.level_begin + index;
    const uint begin = first_child[node];
    const uint end = begin + popcount((uint)masks[node]);
    svo_sums sums = svo_no_sums();
    for (uint child = begin; child < end; ++child) {
        const svo_sums part =
            svo_load_sums(child - params.child_begin, child_weights, child_color_sums, child_normal_sums);
        svo_store_payload(part, child, colors, normals);
        sums = svo_join_sums(sums, part);
    }
    svo_store_sums(sums, index, weights, color_sums, normal_sums);
    svo_store_root(sums, node, colors, normals);
}

#endif
