/* SPDX-License-Identifier: MIT */
/*
 * Subdivision: nodes from the root down, level by level (after Crassin and Green, "Octree-Based Sparse Voxelization
 * Using the GPU Hardware Rasterizer", 2012, but nodes are allocated by a prefix sum, which makes their order
 * canonical).
 *
 *   svo_k_take_count  once, in enqueued builds: the number of fragments
 *   svo_k_mark        once: every fragment marks its octant in the root
 *   scan.cl           per level: the prefix sum of the masks' bit counts gives first_child and the next level's size
 *   svo_k_descend     per level: every fragment moves its cursor to the child and marks its octant there
 *
 * Launch: one work-item per fragment of a chunk, rounded up to whole groups.
 * Reads the fragments and first_child; writes masks, cursors and state->overflow.
 * Atomics: atomic_or sets mask bits. Bits are never cleared, so a bit that is read as set needs no atomic. A mask is
 * final once the launch that marks its level has ended. Four masks share a 32-bit word; byte k of word w is the mask of
 * node 4 w + k:
 *
 *   31      24 23      16 15       8 7        0
 *   [ node 3 ] [ node 2 ] [ node 1 ] [ node 0 ]
 *
 * Invariant: after descending from a level, each cursor is the index, in the whole tree, of the fragment's node on the
 * level below. When the nodes of a level do not fit, state->overflow is set and later launches write nothing. The list
 * may come from a driver, so the first pass also rejects impossible fragments that way. (All work-items that set it
 * there write the same word.)
 */
#include "shared/fragment.clh"
#include "shared/state.clh"

/* A word in which other work-items may be setting bits. OpenCL C 1.2 has no atomic load, but a device with atomics on
   aligned words reads them whole. SVO_ATOMIC_READS, ten times as expensive, is for race detectors. */
static uint svo_read_masks(volatile __global uint *word)
{
#ifdef SVO_ATOMIC_READS
    return atomic_or(word, 0u);
#else
    return *word;
#endif
}

static void svo_mark(volatile __global uint *masks, uint node, uint octant)
{
    const uint bit = 1u << (8u * (node & 3u) + octant);
    volatile __global uint *word = masks + (node >> 2);
    if ((svo_read_masks(word) & bit) == 0u) {
        atomic_or(word, bit);
    }
}

/* Launch: one group, of which one work-item works; in builds whose fragments the host has not counted. counter: low
   word, high word. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_take_count(__global const uint *counter, __global svo_build_state *state, svo_subdivide_params params)
{
    if (get_global_id(0) == 0) {
        const bool fits = counter[1] == 0u && counter[0] <= params.fragment_count;
        state->fragments_low = counter[0];
        state->fragments_high = counter[1];
        state->fragment_limit = fits ? counter[0] : 0u;
        if (!fits) {
            state->overflow = SVO_SHORT_LIST;
        }
    }
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void svo_k_mark(__global const uint *fragments,
                                                                                      volatile __global uint *masks,
                                                                                      __global svo_build_state *state,
                                                                                      svo_subdivide_params params)
{
    const size_t index = get_global_id(0);
    if (index < svo_count_fragments(params.fragment_count, state)) {
        const svo_code code = svo_fragment_code(fragments, index);
        svo_mark(masks, 0, svo_octant(code, params.depth, 0));
        if ((uint)(code >> (3 * params.depth)) != 0u ||
            svo_fragment_triangle(fragments, index) >= state->triangle_count) {
            state->overflow = SVO_DAMAGED_LIST;
        }
    }
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_descend(__global const uint *fragments, __global uint *cursors, volatile __global uint *masks,
              __global const uint *first_child, __global const svo_build_state *state, svo_subdivide_params params)
{
    const size_t index = get_global_id(0);
    if (index >= svo_count_fragments(params.fragment_count, state) || state->overflow != 0u) {
        return;
    }
    const svo_code code = svo_fragment_code(fragments, index);
    const uint node = params.level == 0u ? 0u : cursors[index];
    const uint mask = svo_read_masks(masks + (node >> 2)) >> (8u * (node & 3u)) & 255u;
    const uint octant = svo_octant(code, params.depth, params.level);
    const uint child = first_child[node] + popcount(mask & ((1u << octant) - 1u));
    cursors[index] = child;
    if (params.level + 1u < params.depth) {
        svo_mark(masks, child, svo_octant(code, params.depth, params.level + 1u));
    }
}
