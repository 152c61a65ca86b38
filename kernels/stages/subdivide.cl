/* SPDX-License-Identifier: MIT */
/*
 * Subdivision: nodes from the root down (after Crassin and Green, "Octree-Based Sparse Voxelization Using the GPU
 * Hardware Rasterizer", 2012, but three levels at a time, and nodes are allocated by a prefix sum, which makes their
 * order canonical).
 *
 * A block says which descendants of a node three levels down exist: 8^3 bits in Morton order, 16 words of 32 bits or 8
 * of 64. Each 64-bit word belongs to a child of the node, each byte is the mask of a grandchild. Blocks of a level lie
 * in the order of its nodes, so the number of bits before its own gives a node's block, or a leaf's place in the tree:
 * the word's rank, a prefix sum over the level's words that starts with the place of the first, and the bits below it
 * in its word.
 *
 *   bit of a block   [ child 3 bits ] [ grandchild 3 bits ] [ octant 3 bits ]
 *
 * Levels are counted from params.pad levels above the root, so that the leaves are on a multiple of three; above the
 * root there is only octant 0. Down to level params.dense all blocks are there that could have bits, also empty ones: a
 * fragment finds its own by its code. Blocks of lower levels exist for nodes alone, and a fragment finds its own by
 * ranks.
 *
 *   svo_k_take_count    once, in enqueued builds: the number of fragments
 *   svo_k_mark          for level params.dense and each below: every fragment sets its bit in its block
 *   svo_k_mark_above    for each level above that but the first: its blocks follow from those three levels down
 *   svo_k_make_top      once: all that follows, for the few blocks of the levels above params.dense
 *   svo_k_count_blocks  per other level of blocks: the nodes that each group's blocks stand for
 *   svo_k_scan_blocks   then: exclusive sums of that over the groups; where the next levels begin
 *   svo_k_make_nodes    then: masks, first_child and ranks, and empty blocks for the level of their great-grandchildren
 *   svo_k_find_leaves   once, where something reads the cursors: every fragment's leaf
 *
 * Launch: one work-item per fragment of a chunk or per block, rounded up to whole groups. Groups of the scan own
 * contiguous ranges of blocks; svo_k_make_top and svo_k_scan_blocks are one group. On CPUs (SVO_ONE_WORKER) the first
 * work-item marks and scans for its group.
 * Reads the fragments; writes masks, first_child, cursors, blocks, ranks, and counts and overflow of the state.
 * Atomics: atomic_or sets bits. Bits are never cleared, so a bit that is read as set needs no atomic. A block is final
 * once the launch that marks its level has ended.
 *
 * When the nodes of a level do not fit, state->overflow is set and later launches write nothing. The list may come from
 * a driver, so the first pass also rejects impossible fragments that way. (All work-items that set it there write the
 * same word.)
 */
#include "shared/calls.clh"
#include "shared/fragment.clh"
#include "shared/state.clh"

#define SVO_BLOCK_WORDS 16u /* of 32 bits */
#define SVO_BLOCK_RANKS 8u /* words of 64 bits, each with a rank */

/* A word in which other work-items may be setting bits. OpenCL C 1.2 has no atomic load, but a device with atomics on
   aligned words reads them whole. SVO_ATOMIC_READS, ten times as expensive, is for race detectors. */
static uint svo_read_marks(volatile __global uint *word)
{
#ifdef SVO_ATOMIC_READS
    return atomic_or(word, 0u);
#else
    return *word;
#endif
}

static ulong svo_block_word(__global const uint *words, size_t index)
{
    return (ulong)words[2u * index] | (ulong)words[2u * index + 1u] << 32;
}

/* The bit of a fragment in its block of a level. */
static uint svo_block_bit(svo_code code, uint level, svo_blocks_params params)
{
    return (uint)(code >> (3u * (params.depth + params.pad - 3u - level))) & 511u;
}

/* The place of the fragment's node three levels below a block: its block, or its leaf. */
static uint svo_below(__global const uint *blocks, __global const uint *ranks, uint block, uint bit)
{
    const size_t word = (size_t)block * SVO_BLOCK_RANKS + (bit >> 6);
    return ranks[word] + (uint)popcount(svo_block_word(blocks, word) & ((1UL << (bit & 63u)) - 1UL));
}

/* The fragment's block of level params.dense or one below. */
static uint svo_block_of(svo_code code, __global const uint *blocks, __global const uint *ranks,
                         svo_blocks_params params)
{
    uint block = params.dense_begin + (uint)((ulong)code >> (3u * (params.depth + params.pad - params.dense)));
    for (uint above = params.dense; above < params.level; above += 3u) {
        block = svo_below(blocks, ranks, block, svo_block_bit(code, above, params));
    }
    return block;
}

/* The blocks of a level. */
static uint svo_count_blocks(svo_blocks_params params, __global const svo_build_state *state)
{
    const uint level = params.level - min(params.level, params.pad);
    const uint nodes = state->level_begin[level + 1u] - state->level_begin[level];
    return state->overflow != 0u ? 0u : params.level <= params.dense ? 1u << (3u * level) : nodes;
}

/* Launch: one group, of which one work-item works; in builds whose fragments the host has not counted. counter: low
   word, high word. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_take_count(__global const uint *counter, __global svo_build_state *state, svo_blocks_params params)
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

/* Whether a fragment is impossible; the first launch finds out. */
static bool svo_is_damaged(__global const uint *fragments, size_t index, __global const svo_build_state *state,
                           svo_blocks_params params)
{
    return params.level == params.dense && ((uint)(svo_fragment_code(fragments, index) >> (3u * params.depth)) != 0u ||
                                            svo_fragment_triangle(fragments, index) >= state->triangle_count);
}

/* A bit of a block: its word, and the bit in it. */
typedef struct svo_mark {
    size_t word;
    uint bit;
} svo_mark;

static svo_mark svo_mark_of(__global const uint *fragments, size_t index, __global const uint *blocks,
                            __global const uint *ranks, svo_blocks_params params)
{
    const svo_code code = svo_fragment_code(fragments, index);
    const uint place = svo_block_bit(code, params.level, params);
    const svo_mark mark = {(size_t)svo_block_of(code, blocks, ranks, params) * SVO_BLOCK_WORDS + (place >> 5),
                           1u << (place & 31u)};
    return mark;
}

#ifdef SVO_ONE_WORKER

/* Marks the fragments from first to end, at most SVO_GROUP_ITEMS. Two loops, because whether a bit is missing cannot be
   predicted: the first has no branch that depends on it. */
SVO_CALLED void svo_mark_batch(__global const uint *fragments, size_t first, size_t end, volatile __global uint *blocks,
                               __global const uint *ranks, __global svo_build_state *state, svo_blocks_params params)
{
    svo_mark missing[SVO_GROUP_ITEMS + 1];
    uint count = 0;
    for (size_t index = first; index < end; ++index) {
        if (svo_is_damaged(fragments, index, state, params)) {
            state->overflow = SVO_DAMAGED_LIST;
            return;
        }
        const svo_mark mark = svo_mark_of(fragments, index, (__global const uint *)blocks, ranks, params);
        missing[count] = mark;
        count += (svo_read_marks(blocks + mark.word) & mark.bit) == 0u ? 1u : 0u;
    }
    for (uint k = 0; k < count; ++k) {
        atomic_or(blocks + missing[k].word, missing[k].bit);
    }
}

#endif

/* params.level: of the blocks that are marked. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_mark(__global const uint *fragments, volatile __global uint *blocks, __global const uint *ranks,
           __global svo_build_state *state, svo_blocks_params params)
{
    const size_t index = get_global_id(0);
    const size_t count = svo_count_fragments(params.fragment_count, state);
    if (index >= count || (params.level > params.dense && state->overflow != 0u)) {
        return;
    }
#ifdef SVO_ONE_WORKER
    if (get_local_id(0) == 0) {
        svo_mark_batch(fragments, index, min(index + SVO_GROUP_ITEMS, count), blocks, ranks, state, params);
    }
#else
    if (svo_is_damaged(fragments, index, state, params)) {
        state->overflow = SVO_DAMAGED_LIST;
        return;
    }
    const svo_mark mark = svo_mark_of(fragments, index, (__global const uint *)blocks, ranks, params);
    if ((svo_read_marks(blocks + mark.word) & mark.bit) == 0u) {
        atomic_or(blocks + mark.word, mark.bit);
    }
#endif
}

/* The bytes of a level's blocks that may have bits. Each stands for 8 blocks three levels down. */
static uint svo_count_bytes(svo_blocks_params params)
{
    return params.depth == 0u ? 0u : 1u << (3u * (params.level + 2u - params.pad));
}

/* Fills a byte of the blocks of params.level from those three levels down. */
static void svo_mark_byte(__global uint *blocks, uint item, svo_blocks_params params)
{
    uint mask = 0;
    for (uint k = 0; k < 8u; ++k) {
        __global const uint *block = blocks + (size_t)(params.next_begin + item * 8u + k) * SVO_BLOCK_WORDS;
        uint any = 0;
        for (uint word = 0; word < SVO_BLOCK_WORDS; ++word) {
            any |= block[word];
        }
        mask |= any != 0u ? 1u << k : 0u;
    }
    __global uint *words = blocks + (size_t)params.block_begin * SVO_BLOCK_WORDS;
    if (mask != 0u) {
        atomic_or(words + item / 4u, mask << (8u * (item & 3u)));
    }
}

/* params.level: of the blocks that are filled. Launch: a work-item per byte. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void svo_k_mark_above(__global uint *blocks,
                                                                                            svo_blocks_params params)
{
    const uint item = (uint)get_global_id(0);
    if (item < svo_count_bytes(params)) {
        svo_mark_byte(blocks, item, params);
    }
}

/* What a block stands for. x: its node, y, z, w: nodes one, two and three levels below. */
static uint4 svo_count_nodes(__global const uint *blocks, uint block)
{
    uint4 nodes = (uint4)(0u);
    for (uint child = 0; child < SVO_BLOCK_RANKS; ++child) {
        const ulong word = svo_block_word(blocks, (size_t)block * SVO_BLOCK_RANKS + child);
        ulong masks = word | word >> 4;
        masks |= masks >> 2;
        masks |= masks >> 1;
        nodes += (uint4)(0u, word != 0UL ? 1u : 0u, (uint)popcount(masks & 0x0101010101010101UL), (uint)popcount(word));
    }
    nodes.x = min(nodes.y, 1u);
    return nodes;
}

/* The blocks of a group of the scan: first and one past the last, in whole groups of work-items. */
static uint2 svo_group_blocks(uint count)
{
    const uint tiles = (count + SVO_GROUP_ITEMS - 1u) / SVO_GROUP_ITEMS;
    const uint groups = (uint)get_num_groups(0);
    const uint tiles_per_group = (tiles + groups - 1u) / groups;
    const uint begin = min((uint)get_group_id(0) * tiles_per_group * SVO_GROUP_ITEMS, count);
    return (uint2)(begin, min(begin + tiles_per_group * SVO_GROUP_ITEMS, count));
}

/* The work-items of a group that scan. On CPUs the first alone is faster, and needs no barriers. */
#ifdef SVO_ONE_WORKER
#define SVO_WORKERS 1u
#define SVO_WORKER  0u
#define SVO_WORK    SVO_CALLED
#else
#define SVO_WORKERS SVO_GROUP_ITEMS
#define SVO_WORKER  ((uint)get_local_id(0))
#define SVO_WORK    SVO_INLINED
#endif

static bool svo_is_worker(void)
{
    return SVO_WORKERS == SVO_GROUP_ITEMS || get_local_id(0) == 0;
}

/* Exclusive prefix sum over the group's workers (see shared/group.clh); *total receives the sum of all. */
SVO_INLINED uint4 svo_group_exclusive4(uint4 value, __local uint4 *scratch, uint4 *total)
{
#ifdef SVO_ONE_WORKER
    (void)scratch;
    *total = value;
    return (uint4)(0u);
#else
    const uint item = (uint)get_local_id(0);
    uint4 sum = value;
    scratch[item] = sum;
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint reach = 1; reach < SVO_GROUP_ITEMS; reach *= 2) {
        const uint4 before = item >= reach ? scratch[item - reach] : (uint4)(0u);
        barrier(CLK_LOCAL_MEM_FENCE);
        sum += before;
        scratch[item] = sum;
        barrier(CLK_LOCAL_MEM_FENCE);
    }
    *total = scratch[SVO_GROUP_ITEMS - 1];
    barrier(CLK_LOCAL_MEM_FENCE);
    return sum - value;
#endif
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_count_blocks(__global const uint *blocks, __global uint4 *partials, __global const svo_build_state *state,
                   svo_blocks_params params, __local uint4 *scratch)
{
    if (!svo_is_worker()) {
        return;
    }
    const uint2 range = svo_group_blocks(svo_count_blocks(params, state));
    uint4 sum = (uint4)(0u);
    for (uint i = range.x + (uint)get_local_id(0); i < range.y; i += SVO_WORKERS) {
        sum += svo_count_nodes(blocks, params.block_begin + i);
    }
    uint4 total;
    (void)svo_group_exclusive4(sum, scratch, &total);
    if (get_local_id(0) == 0) {
        partials[get_group_id(0)] = total;
    }
}

/* Where the levels below begin, from their nodes. The root exists even without fragments. */
static void svo_begin_levels(uint4 nodes, __global svo_build_state *state, svo_blocks_params params)
{
    const uint counts[3] = {nodes.y, nodes.z, nodes.w};
    for (uint k = 0; k < 3u; ++k) {
        const uint padded = params.level + 1u + k;
        if (padded <= params.pad) {
            continue;
        }
        const uint level = padded - params.pad;
        const uint begin = state->level_begin[level];
        const uint end = begin + counts[k];
        state->level_begin[level + 1u] = end;
        if (end < begin ||
            (level < params.depth && (end > params.inner_capacity || counts[k] > params.level_capacity[k]))) {
            state->overflow = level;
            return;
        }
    }
}

/* The partials of the groups become exclusive sums. One group. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_scan_blocks(__global uint4 *partials, __global svo_build_state *state, svo_blocks_params params,
                  __local uint4 *scratch)
{
    if (!svo_is_worker()) {
        return;
    }
    uint4 sum = (uint4)(0u);
    for (uint first = 0; first < params.scan_groups; first += SVO_WORKERS) {
        const uint group = first + (uint)get_local_id(0);
        uint4 total;
        const uint4 before =
            svo_group_exclusive4(group < params.scan_groups ? partials[group] : (uint4)(0u), scratch, &total);
        if (group < params.scan_groups) {
            partials[group] = sum + before;
        }
        sum += total;
    }
    if (get_local_id(0) == 0 && state->overflow == 0u) {
        svo_begin_levels(sum, state, params);
    }
}

/* A node's mask and first child. level: of the node. */
static void svo_put_node(__global uchar *masks, __global uint *first_child, __global const svo_build_state *state,
                         uint level, uint index, uint mask, uint child)
{
    const uint node = state->level_begin[level] + index;
    masks[node] = (uchar)mask;
    first_child[node] = state->level_begin[level + 1u] + child;
}

/* The nodes of the block's own level and the two below. before: how many of each level, and of the third, precede. */
SVO_CALLED void svo_make_nodes(__global const uint *blocks, uint block, uint4 before, __global uint *ranks,
                               __global uchar *masks, __global uint *first_child, __global const svo_build_state *state,
                               svo_blocks_params params)
{
    const uint4 begin = before;
    const bool has_ranks = block < params.rank_blocks;
    const uint first_below =
        params.level + 3u == params.depth + params.pad ? state->level_begin[params.depth] : params.next_begin;
    uint mask = 0;
    for (uint child = 0; child < SVO_BLOCK_RANKS; ++child) {
        const size_t place = (size_t)block * SVO_BLOCK_RANKS + child;
        const ulong word = svo_block_word(blocks, place);
        if (word == 0UL) {
            continue;
        }
        const uint first = before.z;
        uint child_mask = 0;
        if (has_ranks) {
            ranks[place] = first_below + before.w;
        }
        for (uint grandchild = 0; grandchild < 8u; ++grandchild) {
            const uint grandchild_mask = (uint)(word >> (8u * grandchild)) & 255u;
            if (grandchild_mask != 0u) {
                child_mask |= 1u << grandchild;
                svo_put_node(masks, first_child, state, params.level + 2u - params.pad, before.z, grandchild_mask,
                             before.w);
                before.z += 1u;
                before.w += popcount(grandchild_mask);
            }
        }
        if (params.level + 1u >= params.pad) {
            svo_put_node(masks, first_child, state, params.level + 1u - params.pad, before.y, child_mask, first);
        }
        mask |= 1u << child;
        before.y += 1u;
    }
    if (params.level >= params.pad && mask != 0u) {
        svo_put_node(masks, first_child, state, params.level - params.pad, begin.x, mask, begin.y);
    }
}

/* What the nodes of a level are made of, and into. */
typedef struct svo_level {
    __global uint *blocks, *ranks;
    __global uchar *masks;
    __global uint *first_child;
} svo_level;

/* Adds up what the blocks of a range stand for, and makes their nodes unless the group only counts. before: what
   precedes the range. Of the group's workers. */
SVO_WORK uint4 svo_walk_blocks(svo_level level, uint2 range, uint4 before, bool makes,
                               __global const svo_build_state *state, svo_blocks_params params, __local uint4 *scratch)
{
    uint4 sum = before;
    for (uint tile = range.x; tile < range.y; tile += SVO_WORKERS) {
        const uint i = tile + SVO_WORKER;
        const uint block = params.block_begin + i;
        uint4 total;
        const uint4 offset =
            svo_group_exclusive4(i < range.y ? svo_count_nodes(level.blocks, block) : (uint4)(0u), scratch, &total);
        if (makes && i < range.y) {
            svo_make_nodes(level.blocks, block, sum + offset, level.ranks, level.masks, level.first_child, state,
                           params);
        }
        sum += total;
    }
    return sum;
}

/* How many blocks three levels down are to be emptied: those that are of nodes alone. */
static uint svo_count_below(__global const svo_build_state *state, svo_blocks_params params)
{
    const bool is_last = params.level + 3u == params.depth + params.pad;
    const bool are_dense = params.level < params.dense;
    params.level += 3u;
    return is_last || are_dense ? 0u : svo_count_blocks(params, state);
}

/* Empties some of them. */
static void svo_clear_below(__global uint *blocks, uint2 range, svo_blocks_params params)
{
    __global uint16 *cleared = (__global uint16 *)blocks + params.next_begin;
    for (uint i = range.x + SVO_WORKER; i < range.y; i += SVO_WORKERS) {
        cleared[i] = (uint16)(0u);
    }
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_make_nodes(__global uint *blocks, __global const uint4 *partials, __global uint *ranks, __global uchar *masks,
                 __global uint *first_child, __global const svo_build_state *state, svo_blocks_params params,
                 __local uint4 *scratch)
{
    if (!svo_is_worker()) {
        return;
    }
    const svo_level level = {blocks, ranks, masks, first_child};
    const uint2 range = svo_group_blocks(svo_count_blocks(params, state));
    (void)svo_walk_blocks(level, range, partials[get_group_id(0)], true, state, params, scratch);
    svo_clear_below(blocks, svo_group_blocks(svo_count_below(state, params)), params);
}

/* What one work-item of the group has written is seen by all. */
SVO_INLINED void svo_wait_for_workers(void)
{
#ifndef SVO_ONE_WORKER
    barrier(CLK_GLOBAL_MEM_FENCE);
#endif
}

/* The nodes of a level, by one group. */
SVO_WORK void svo_make_small_level(svo_level level, __global svo_build_state *state, svo_blocks_params params,
                                   __local uint4 *scratch)
{
    const uint2 range = (uint2)(0u, svo_count_blocks(params, state));
    const uint4 nodes = svo_walk_blocks(level, range, (uint4)(0u), false, state, params, scratch);
    svo_wait_for_workers(); /* all have read the state */
    if (SVO_WORKER == 0u && state->overflow == 0u) {
        svo_begin_levels(nodes, state, params);
    }
    svo_wait_for_workers();
    if (state->overflow == 0u) {
        (void)svo_walk_blocks(level, range, (uint4)(0u), true, state, params, scratch);
        svo_clear_below(level.blocks, (uint2)(0u, svo_count_below(state, params)), params);
    }
}

/* params: of level 0. second: of level 3, if that is above params.dense too; else of level 0. Launch: one group. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_make_top(__global uint *blocks, __global uint *ranks, __global uchar *masks, __global uint *first_child,
               __global svo_build_state *state, svo_blocks_params params, svo_blocks_params second,
               __local uint4 *scratch)
{
    if (!svo_is_worker()) {
        return;
    }
    const svo_level level = {blocks, ranks, masks, first_child};
    const uint bytes = params.dense > 0u ? svo_count_bytes(params) : 0u;
    for (uint item = (uint)get_local_id(0); item < bytes; item += SVO_WORKERS) {
        svo_mark_byte(blocks, item, params);
    }
    svo_wait_for_workers();
    svo_make_small_level(level, state, params, scratch);
    if (second.level > 0u) {
        svo_wait_for_workers();
        svo_make_small_level(level, state, second, scratch);
    }
    if (get_local_id(0) == 0 && state->level_begin[2] == 1u) {
        svo_put_node(masks, first_child, state, 0u, 0u, 0u, 0u); /* a root without children */
    }
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_find_leaves(__global const uint *fragments, __global const uint *blocks, __global const uint *ranks,
                  __global uint *cursors, __global const svo_build_state *state, svo_blocks_params params)
{
    const size_t index = get_global_id(0);
    if (index >= svo_count_fragments(params.fragment_count, state) || state->overflow != 0u) {
        return;
    }
    const svo_code code = svo_fragment_code(fragments, index);
    const uint block = svo_block_of(code, blocks, ranks, params);
    cursors[index] = svo_below(blocks, ranks, block, svo_block_bit(code, params.level, params));
}
