/* SPDX-License-Identifier: MIT */
/*
 * The payload, from the leaves up: mean color, mean normal and fill of every node, and the leaves' projected areas, in
 * integers.
 *
 *   svo_k_gather_level  per node of the deepest inner level: traverses its leaves' linked lists, sums each triangle's
 *                       contribution to the voxel, writes the leaves' payload and the node's sums. For lists of one
 *                       chunk
 *   svo_k_gather        per leaf of a chunk: the same into the leaf's sums, on top of those of earlier chunks
 *   svo_k_filter        per node of a level, from the deepest level upwards: writes its children's payload and its own
 *                       sums
 *   svo_k_round_areas   per leaf, after all chunks: writes the leaf's projected areas from their sums
 *
 * Invariant: sums are 64-bit and are passed up unrounded; each node rounds once, half up. So the result depends neither
 * on the order of the lists nor on how the fragments are cut into chunks. The plan chooses the unit of weight so that a
 * tree's weights add up to less than 2^46, which leaves headroom for the sums.
 *
 * Launch: one work-item per node or leaf, rounded up to whole groups. No atomics: one work-item writes a node's sums.
 * Buffers: sums of one level each: weights (ulong), color (4 ulong a node), normal (3 long a node); of the leaves, for
 * lists of several chunks: areas (6 ulong a leaf).
 */
#include "shared/fragment.clh"
#include "shared/state.clh"
#include "stages/area.clh"
#include "stages/attribute.clh"

#if defined(SVO_COLOR) || defined(SVO_NORMAL) || defined(SVO_FILL)
#define SVO_NODE_PAYLOAD
#endif

#if defined(SVO_NODE_PAYLOAD) || defined(SVO_AREAS)

/* A last argument, which only kernels with projected areas have. */
#ifdef SVO_AREAS
#define SVO_AND_AREAS(type, name) , __global type *name
#else
#define SVO_AND_AREAS(type, name)
#endif

/* The sums of a node; areas are those of leaves alone. */
typedef struct svo_sums {
    ulong weight;
#ifdef SVO_COLOR
    ulong4 color;
#endif
#ifdef SVO_NORMAL
    long x, y, z;
#endif
#ifdef SVO_AREAS
    svo_areas areas;
#endif
} svo_sums;

SVO_FUNCTION svo_sums svo_no_sums(void)
{
    svo_sums sums;
    sums.weight = 0;
#ifdef SVO_COLOR
    sums.color = (ulong4)(0);
#endif
#ifdef SVO_NORMAL
    sums.x = sums.y = sums.z = 0;
#endif
#ifdef SVO_AREAS
    sums.areas = svo_no_areas();
#endif
    return sums;
}

/* weights: NULL where only areas are made. */
SVO_FUNCTION svo_sums svo_load_sums(uint node, __global const ulong *weights, __global const ulong *colors,
                                    __global const long *normals)
{
    svo_sums sums = svo_no_sums();
    if (weights == 0) {
        return sums;
    }
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

SVO_FUNCTION svo_sums svo_join_sums(svo_sums a, svo_sums b)
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

/* weights: NULL where no level above needs the sums. */
static void svo_store_sums(svo_sums sums, uint node, __global ulong *weights, __global ulong *colors,
                           __global long *normals)
{
    if (weights == 0) {
        return;
    }
    weights[node] = sums.weight;
#ifdef SVO_COLOR
    vstore4(sums.color, node, colors);
#endif
#ifdef SVO_NORMAL
    vstore3((long3)(sums.x, sums.y, sums.z), node, normals);
#endif
}

#ifdef SVO_COLOR

/* (2 s + w) / (2 w), that is s / w rounded half up. Small weights divide in 32 bits. */
static uint4 svo_mean_color(ulong4 sum, ulong weight)
{
    if (weight < 1u << 22) {
        return (2u * convert_uint4(sum) + (uint)weight) / (2u * (uint)weight);
    }
    return convert_uint4((2UL * sum + weight) / (2UL * weight));
}

#endif

#ifdef SVO_NORMAL

/* s / w rounded half up: floor((2 s + w) / (2 w)); the offset makes the dividend positive, since |s| <= 32768 w. */
static short svo_mean_normal(long sum, ulong weight)
{
    if (weight < 1u << 14) {
        const uint dividend = (uint)((int)(2 * sum) + (int)weight + (int)(weight << 16));
        return (short)((int)(dividend / (2u * (uint)weight)) - 32768);
    }
    const ulong dividend = (ulong)(2 * sum) + weight + (weight << 16);
    return (short)((long)(dividend / (2UL * weight)) - 32768);
}

#endif

#ifdef SVO_FILL

/* Surface in 4096ths of a node's face, rounded half up, 65535 at most. shift: 0 < shift, the face's weight in bits less
   twelve. */
static ushort svo_fill_of(ulong weight, uint shift)
{
    return shift > 62u ? (ushort)0 : (ushort)min(((weight >> (shift - 1u)) + 1UL) >> 1, 65535UL);
}

#endif

/* The payload arrays that are written; NULL where a variant has none. */
typedef struct svo_payload {
    __global uint *colors;
    __global short *normals;
    __global ushort *fills;
} svo_payload;

/* node: counted from the first node that has payload. */
static void svo_store_payload(svo_sums sums, uint node, svo_payload payload, uint fill_shift)
{
    SVO_UNUSED(fill_shift);
#ifdef SVO_COLOR
    const uint4 mean = svo_mean_color(sums.color, sums.weight);
    payload.colors[node] = mean.x | mean.y << 8 | mean.z << 16 | mean.w << 24;
#endif
#ifdef SVO_NORMAL
    payload.normals[3 * (size_t)node] = svo_mean_normal(sums.x, sums.weight);
    payload.normals[3 * (size_t)node + 1] = svo_mean_normal(sums.y, sums.weight);
    payload.normals[3 * (size_t)node + 2] = svo_mean_normal(sums.z, sums.weight);
#endif
#ifdef SVO_FILL
    payload.fills[node] = svo_fill_of(sums.weight, fill_shift);
#endif
}

/* There is no level above to write the root's payload, so the work-item that sums up the root writes it. */
static void svo_store_root(svo_sums sums, uint node, svo_payload payload, uint fill_shift)
{
    if (node == 0u && sums.weight != 0) {
        svo_store_payload(sums, 0u, payload, fill_shift + 2u);
    }
}

static void svo_add_pair(svo_sums *sums, svo_surface surface, uint triangle, svo_code code, svo_filter_params params)
{
    const svo_share share = svo_pair_share(surface, triangle, code, params);
    sums->weight += share.weight;
#ifdef SVO_COLOR
    sums->color += (ulong)share.weight * convert_ulong4(svo_surface_color(surface, triangle, share.corners));
#endif
#ifdef SVO_NORMAL
    const int3 normal = svo_surface_normal(surface, triangle, share.corners);
    sums->x += (long)share.weight * normal.x;
    sums->y += (long)share.weight * normal.y;
    sums->z += (long)share.weight * normal.z;
#endif
#ifdef SVO_AREAS
    svo_add_areas(&sums->areas, surface, triangle, svo_pair_doubled_area(surface, triangle, code, share, params),
                  params.both_sides != 0u);
#endif
}

/* The sums of a leaf's list, on top of sums. link: its first fragment plus one. */
SVO_FUNCTION svo_sums svo_sum_list(svo_sums sums, svo_surface surface, __global const uint *fragments,
                                   __global const uint *links, uint link, svo_filter_params params)
{
    while (link != 0u) {
        svo_add_pair(&sums, surface, svo_fragment_triangle(fragments, link - 1u),
                     svo_fragment_code(fragments, link - 1u), params);
        link = links[link - 1u];
    }
    return sums;
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_gather(__global const uint *fragments, __global const uint *links, __global const uint *heads,
             __global const int *vertices, __global const uint *indices, __global const svo_triangle_record *records,
             __global const uint *vertex_colors, __global const short *vertex_normals, __global const int *uvs,
             __global const svo_material_record *materials, __global const uint *texels, __global ulong *weights,
             __global ulong *color_sums, __global long *normal_sums, __global const svo_build_state *state,
             svo_filter_params params SVO_AND_AREAS(ulong, area_sums))
{
    svo_make_current(&params, state);
    const uint leaf = params.first_index + (uint)get_global_id(0);
    if (leaf >= params.leaf_count) {
        return;
    }
    const svo_surface surface = {vertices, indices, records, vertex_colors, vertex_normals, uvs, materials, texels};
    svo_sums sums = svo_no_sums();
    if (params.first_chunk == 0u) {
        sums = svo_load_sums(leaf, weights, color_sums, normal_sums);
#ifdef SVO_AREAS
        sums.areas = svo_load_areas(leaf, area_sums);
#endif
    }
    sums = svo_sum_list(sums, surface, fragments, links, heads[leaf], params);
    svo_store_sums(sums, leaf, weights, color_sums, normal_sums);
#ifdef SVO_AREAS
    svo_keep_areas(sums.areas, leaf, area_sums);
#endif
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void svo_k_gather_level(
    __global const uint *fragments, __global const uint *links, __global const uint *heads,
    __global const int *vertices, __global const uint *indices, __global const svo_triangle_record *records,
    __global const uint *vertex_colors, __global const short *vertex_normals, __global const int *uvs,
    __global const svo_material_record *materials, __global const uint *texels, __global ulong *weights,
    __global ulong *color_sums, __global long *normal_sums, __global const uchar *masks,
    __global const uint *first_child, __global uint *colors, __global short *normals, __global ushort *fills,
    __global const svo_build_state *state, svo_filter_params params SVO_AND_AREAS(ushort, areas))
{
    svo_make_current(&params, state);
    const uint index = params.first_index + (uint)get_global_id(0);
    if (index >= params.level_count) {
        return;
    }
    const svo_surface surface = {vertices, indices, records, vertex_colors, vertex_normals, uvs, materials, texels};
    const svo_payload payload = {colors, normals, fills};
    const uint node = params.level_begin + index;
    const uint begin = first_child[node];
    const uint end = begin + popcount((uint)masks[node]);
    svo_sums sums = svo_no_sums();
    for (uint leaf = begin; leaf < end; ++leaf) {
        const uint link = heads[leaf - params.leaf_begin];
        const svo_sums part = svo_sum_list(svo_no_sums(), surface, fragments, links, link, params);
        svo_store_payload(part, leaf - params.payload_begin, payload, params.fill_shift);
#ifdef SVO_AREAS
        svo_store_areas(part.areas, leaf - params.leaf_begin, areas);
#endif
        sums = svo_join_sums(sums, part);
    }
    svo_store_sums(sums, index, weights, color_sums, normal_sums);
    if (params.payload_begin == 0u) {
        svo_store_root(sums, node, payload, params.fill_shift);
    }
}

#ifdef SVO_AREAS

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_round_areas(__global const ulong *area_sums, __global ushort *areas, __global const svo_build_state *state,
                  svo_filter_params params)
{
    svo_make_current(&params, state);
    const uint leaf = params.first_index + (uint)get_global_id(0);
    if (leaf < params.leaf_count) {
        svo_store_areas(svo_load_areas(leaf, area_sums), leaf, areas);
    }
}

#endif

#ifdef SVO_NODE_PAYLOAD

/* Sums are indexed from the first node of their level, payload from the first node that has payload. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_filter(__global const uchar *masks, __global const uint *first_child, __global const ulong *child_weights,
             __global const ulong *child_color_sums, __global const long *child_normal_sums, __global ulong *weights,
             __global ulong *color_sums, __global long *normal_sums, __global uint *colors, __global short *normals,
             __global ushort *fills, __global const svo_build_state *state, svo_filter_params params)
{
    svo_make_current(&params, state);
    const uint index = params.first_index + (uint)get_global_id(0);
    if (index >= params.level_count) {
        return;
    }
    const svo_payload payload = {colors, normals, fills};
    const uint node = params.level_begin + index;
    const uint begin = first_child[node];
    const uint end = begin + popcount((uint)masks[node]);
    svo_sums sums = svo_no_sums();
    for (uint child = begin; child < end; ++child) {
        const svo_sums part =
            svo_load_sums(child - params.child_begin, child_weights, child_color_sums, child_normal_sums);
        svo_store_payload(part, child - params.payload_begin, payload, params.fill_shift);
        sums = svo_join_sums(sums, part);
    }
    svo_store_sums(sums, index, weights, color_sums, normal_sums);
    if (params.payload_begin == 0u) {
        svo_store_root(sums, node, payload, params.fill_shift);
    }
}

#endif

#endif
