/* SPDX-License-Identifier: MIT */
/*
 * Known answers of the kernels that make nodes and leaf lists from fragments: sort.cl, subdivide.cl, pack.cl and the
 * scans between them. One list of fragments, with a leaf of many, serves all; the host makes its tree by sorting codes.
 */
#include <stdlib.h>
#include <string.h>

#include "core/proof.h"
#include "shared/layout.h"
#include "stages/programs.h"
#include "stages/sort.h"

#define FRAGMENTS 501
/* Three levels of blocks, of which the second has all blocks. */
#define DEPTH        9
#define DENSE_LEVEL  3
#define DENSE_BLOCKS 512
/* A leaf of four in seven fragments: more than a work-item sorts. */
#define CROWD_CODE 0x2345678u

/* A list of fragments, and its tree. */
typedef struct nodes_case {
    uint32_t codes[FRAGMENTS]; /* of 3 DEPTH bits */
    uint32_t triangles[FRAGMENTS];
    uint32_t words[FRAGMENTS * SVO_FRAGMENT_WORDS_48]; /* as kernels read them */
    uint32_t word_count; /* of a fragment */
    uint32_t level_codes[DEPTH + 1][FRAGMENTS]; /* of the nodes of each level, ascending */
    uint32_t level_begin[DEPTH + 2];
    uint8_t masks[DEPTH * FRAGMENTS]; /* of all inner nodes */
    uint32_t first_child[DEPTH * FRAGMENTS];
    uint32_t cursors[FRAGMENTS]; /* the leaf of each fragment */
} nodes_case;

static int compare_words(const void *a, const void *b)
{
    const uint32_t x = *(const uint32_t *)a;
    const uint32_t y = *(const uint32_t *)b;
    return x < y ? -1 : x > y ? 1 : 0;
}

static uint32_t level_count(const nodes_case *c, uint32_t level)
{
    return c->level_begin[level + 1] - c->level_begin[level];
}

/* The place of a code among those of its level. */
static uint32_t place_of(const nodes_case *c, uint32_t level, uint32_t code)
{
    const uint32_t *const codes = c->level_codes[level];
    const uint32_t *found = bsearch(&code, codes, level_count(c, level), sizeof *codes, compare_words);
    return (uint32_t)(found - codes);
}

static void fill_levels(nodes_case *c)
{
    uint32_t sorted[FRAGMENTS];
    memcpy(sorted, c->codes, sizeof sorted);
    qsort(sorted, FRAGMENTS, sizeof *sorted, compare_words);
    for (uint32_t level = 0; level <= DEPTH; ++level) {
        uint32_t count = 0;
        for (uint32_t i = 0; i < FRAGMENTS; ++i) {
            const uint32_t code = sorted[i] >> (3 * (DEPTH - level));
            if (count == 0 || c->level_codes[level][count - 1] != code) {
                c->level_codes[level][count++] = code;
            }
        }
        c->level_begin[level + 1] = c->level_begin[level] + count;
    }
}

static void fill_nodes(nodes_case *c)
{
    for (uint32_t level = 0; level < DEPTH; ++level) {
        for (uint32_t child = level_count(c, level + 1); child-- > 0;) {
            const uint32_t code = c->level_codes[level + 1][child];
            const uint32_t node = c->level_begin[level] + place_of(c, level, code >> 3);
            c->masks[node] |= (uint8_t)(1u << (code & 7u));
            c->first_child[node] = c->level_begin[level + 1] + child;
        }
    }
    for (uint32_t i = 0; i < FRAGMENTS; ++i) {
        c->cursors[i] = c->level_begin[DEPTH] + place_of(c, DEPTH, c->codes[i]);
    }
}

/* A code of DEPTH levels: at either end of the grid, in the crowd, or anywhere. */
static uint32_t code_of(uint32_t i, uint32_t random)
{
    const uint32_t last = (1u << (3 * DEPTH)) - 1u;
    const uint32_t codes[3] = {random & 15u, last - (random & 15u), CROWD_CODE};
    return i % 7 < 6 ? codes[i % 7 < 2 ? i % 7 : 2] : random & last;
}

static svo_status make_case(svo_i_proof *proof, nodes_case **out)
{
    uint64_t random = 2;
    void *memory = NULL;
    SVO_I_TRY(svo_i_proof_alloc(proof, sizeof(nodes_case), &memory));
    nodes_case *c = memory;
    c->word_count = svo_i_proof_defines(proof, "SVO_CODE48") ? SVO_FRAGMENT_WORDS_48 : SVO_FRAGMENT_WORDS_30;
    for (uint32_t i = 0; i < FRAGMENTS; ++i) {
        c->codes[i] = code_of(i, (uint32_t)svo_i_proof_next(&random));
        c->triangles[i] = i * 211 % FRAGMENTS;
        c->words[i * c->word_count] = c->codes[i];
        c->words[(i + 1) * c->word_count - 1] = c->triangles[i];
    }
    fill_levels(c);
    fill_nodes(c);
    *out = c;
    return SVO_OK;
}

static svo_status fragments_buffer(svo_i_proof *proof, const nodes_case *c, cl_mem *out)
{
    return svo_i_work_constants(&proof->work, "proof", c->words, (uint64_t)FRAGMENTS * c->word_count * 4, out);
}

/* ---- the sort ---- */

#define SORT_GROUPS 5
#define SORT_CELLS  (SORT_GROUPS * SVO_SORT_DIGITS)

/* One pass over a digit. */
typedef struct sort_case {
    uint32_t counts[SORT_CELLS], before[SORT_CELLS]; /* by digit, then by block */
    uint32_t moved[FRAGMENTS * SVO_FRAGMENT_WORDS_48];
    svo_sort_params params;
} sort_case;

/* Gives codes and triangles the bits that they do not have in a tree of DEPTH levels: at the top of a triangle's word,
   and across the words of a long code. */
static void raise_words(nodes_case *c, uint32_t shift, bool by_triangle)
{
    for (uint32_t i = 0; i < FRAGMENTS; ++i) {
        uint32_t *words = c->words + (size_t)i * c->word_count;
        const uint64_t raised = (uint64_t)(c->codes[i] % (SVO_SORT_DIGITS - 1)) << shift | i % 3;
        words[by_triangle ? c->word_count - 1 : 0] = (uint32_t)raised;
        if (!by_triangle && c->word_count == SVO_FRAGMENT_WORDS_48) {
            words[1] = (uint32_t)(raised >> 32);
        }
    }
}

static void fill_sort(const nodes_case *c, sort_case *s)
{
    const uint32_t length = FRAGMENTS / SORT_GROUPS + 1;
    uint32_t places[SORT_CELLS];
    memset(s->counts, 0, sizeof s->counts);
    for (uint32_t i = 0; i < FRAGMENTS; ++i) {
        ++s->counts[c->codes[i] % (SVO_SORT_DIGITS - 1) * SORT_GROUPS + i / length];
    }
    s->before[0] = 0;
    for (uint32_t cell = 1; cell < SORT_CELLS; ++cell) {
        s->before[cell] = s->before[cell - 1] + s->counts[cell - 1];
    }
    memcpy(places, s->before, sizeof places);
    for (uint32_t i = 0; i < FRAGMENTS; ++i) {
        const uint32_t place = places[c->codes[i] % (SVO_SORT_DIGITS - 1) * SORT_GROUPS + i / length]++;
        memcpy(s->moved + (size_t)place * c->word_count, c->words + (size_t)i * c->word_count, 4 * c->word_count);
    }
}

static svo_status prove_pass(svo_i_proof *proof, const nodes_case *c, const sort_case *s)
{
    const uint64_t items = (uint64_t)SORT_GROUPS * SVO_GROUP_ITEMS;
    const svo_i_argument digits = SVO_I_LOCAL(svo_i_sort_local_bytes(proof->work.device));
    cl_mem list = NULL;
    cl_mem counts = NULL;
    cl_mem before = NULL;
    cl_mem moved = NULL;
    SVO_I_TRY(fragments_buffer(proof, c, &list));
    SVO_I_TRY(svo_i_work_alloc(&proof->work, "proof", sizeof s->counts, &counts));
    SVO_I_TRY(svo_i_work_constants(&proof->work, "proof", s->before, sizeof s->before, &before));
    SVO_I_TRY(svo_i_work_alloc(&proof->work, "proof", (uint64_t)FRAGMENTS * c->word_count * 4, &moved));
    const svo_i_argument count[] = {SVO_I_ARGUMENT(list), SVO_I_ARGUMENT(counts), SVO_I_ARGUMENT(s->params), digits};
    const svo_i_argument scatter[] = {SVO_I_ARGUMENT(list), SVO_I_ARGUMENT(moved), SVO_I_ARGUMENT(before),
                                      SVO_I_ARGUMENT(s->params), digits};
    SVO_I_TRY(svo_i_work_launch(&proof->work, "svo_k_sort_count", SVO_I_ARGUMENTS(count), items));
    SVO_I_TRY(svo_i_proof_expect(proof, "svo_k_sort_count", counts, s->counts, sizeof s->counts));
    SVO_I_TRY(svo_i_work_launch(&proof->work, "svo_k_sort_scatter", SVO_I_ARGUMENTS(scatter), items));
    return svo_i_proof_expect(proof, "svo_k_sort_scatter", moved, s->moved, (size_t)FRAGMENTS * c->word_count * 4);
}

static svo_status prove_sort(svo_i_proof *proof, nodes_case *c)
{
    void *memory = NULL;
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_i_proof_alloc(proof, sizeof(sort_case), &memory));
    sort_case *s = memory;
    for (unsigned by_triangle = 0; by_triangle < 2; ++by_triangle) {
        const uint32_t shift = by_triangle == 0 && c->word_count == SVO_FRAGMENT_WORDS_48 ? 29 : 26;
        raise_words(c, shift, by_triangle != 0);
        s->params = (svo_sort_params){FRAGMENTS, shift, by_triangle, SVO_SORT_BITS};
        fill_sort(c, s);
        SVO_I_TRY_CLEANUP(prove_pass(proof, c, s));
    }
cleanup:
    svo_i_free(s);
    return status;
}

svo_status svo_i_prove_sort(svo_device *device, const char *function, const svo_i_program_entry *made,
                            const char **wrong)
{
    svo_i_proof proof;
    nodes_case *c = NULL;
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_i_proof_begin(device, function, made, wrong, &proof));
    SVO_I_TRY_CLEANUP(make_case(&proof, &c));
    SVO_I_TRY_CLEANUP(svo_i_prove_scans(&proof));
    SVO_I_TRY_CLEANUP(prove_sort(&proof, c));
cleanup:
    svo_i_proof_end(&proof);
    svo_i_free(c);
    return status;
}

/* ---- subdivision ---- */

#define BLOCKS      (1 + DENSE_BLOCKS + FRAGMENTS)
#define BLOCK_WORDS 16 /* of 32 bits */
#define BLOCK_RANKS 8
#define SCAN_GROUPS 3
#define LAST_LEVEL  (DEPTH - 3) /* of blocks */

/* Four counts of a group of blocks: the nodes of their level and of the three below. */
typedef struct block_sums {
    uint32_t nodes[4];
} block_sums;

typedef struct blocks_case {
    const nodes_case *nodes;
    uint32_t blocks[BLOCKS][BLOCK_WORDS];
    svo_build_state state;
    cl_mem fragments, marks, ranks, partials, masks, first_child, on_device;
    svo_blocks_params params;
} blocks_case;

static uint32_t first_block(uint32_t level)
{
    return level == 0 ? 0 : level == DENSE_LEVEL ? 1 : 1 + DENSE_BLOCKS;
}

/* The block of a level, from the first of the level, that has nodes below the node with that code. */
static uint32_t block_of(const nodes_case *c, uint32_t level, uint32_t code)
{
    return level <= DENSE_LEVEL ? code : place_of(c, level, code);
}

static uint32_t block_count(const nodes_case *c, uint32_t level)
{
    return level <= DENSE_LEVEL ? 1u << (3 * level) : level_count(c, level);
}

static void set_block_level(blocks_case *b, uint32_t level)
{
    b->params.level = level;
    b->params.block_begin = first_block(level);
    b->params.next_begin = first_block(level + 3);
}

/* Sets the bits of all nodes three levels below a level of blocks. */
static void mark_on_host(blocks_case *b, uint32_t level)
{
    const nodes_case *c = b->nodes;
    for (uint32_t i = 0; i < level_count(c, level + 3); ++i) {
        const uint32_t code = c->level_codes[level + 3][i];
        const uint32_t bit = code & 511u;
        b->blocks[first_block(level) + block_of(c, level, code >> 9)][bit / 32] |= 1u << bit % 32;
    }
}

static svo_status expect_blocks(svo_i_proof *proof, const blocks_case *b, const char *kernel, uint32_t count)
{
    return svo_i_proof_expect(proof, kernel, b->marks, b->blocks, count * sizeof b->blocks[0]);
}

static svo_status prove_mark(svo_i_proof *proof, blocks_case *b, uint32_t level)
{
    set_block_level(b, level);
    mark_on_host(b, level);
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(b->fragments), SVO_I_ARGUMENT(b->marks),
                                        SVO_I_ARGUMENT(b->ranks), SVO_I_ARGUMENT(b->on_device),
                                        SVO_I_ARGUMENT(b->params)};
    SVO_I_TRY(svo_i_work_launch(&proof->work, "svo_k_mark", SVO_I_ARGUMENTS(arguments), FRAGMENTS));
    return expect_blocks(proof, b, "svo_k_mark", first_block(level) + block_count(b->nodes, level));
}

static svo_status prove_mark_above(svo_i_proof *proof, blocks_case *b)
{
    set_block_level(b, 0);
    mark_on_host(b, 0);
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(b->marks), SVO_I_ARGUMENT(b->params)};
    SVO_I_TRY(svo_i_work_launch(&proof->work, "svo_k_mark_above", SVO_I_ARGUMENTS(arguments), DENSE_BLOCKS / 8));
    return expect_blocks(proof, b, "svo_k_mark_above", 1);
}

/* The blocks of the last level hold other words before. */
static svo_status prove_clear(svo_i_proof *proof, blocks_case *b)
{
    set_block_level(b, LAST_LEVEL);
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(b->marks), SVO_I_ARGUMENT(b->on_device),
                                        SVO_I_ARGUMENT(b->params)};
    SVO_I_TRY(svo_i_work_launch(&proof->work, "svo_k_clear_blocks", SVO_I_ARGUMENTS(arguments), SVO_GROUP_ITEMS));
    return expect_blocks(proof, b, "svo_k_clear_blocks", first_block(LAST_LEVEL) + block_count(b->nodes, LAST_LEVEL));
}

/* What the blocks of each group of the scan stand for. */
static void sum_blocks(const blocks_case *b, block_sums sums[SCAN_GROUPS])
{
    const nodes_case *c = b->nodes;
    const uint32_t tiles = (block_count(c, b->params.level) + SVO_GROUP_ITEMS - 1) / SVO_GROUP_ITEMS;
    const uint32_t group_blocks = (tiles + SCAN_GROUPS - 1) / SCAN_GROUPS * SVO_GROUP_ITEMS;
    memset(sums, 0, SCAN_GROUPS * sizeof *sums);
    for (uint32_t below = 0; below <= 3; ++below) {
        const uint32_t level = b->params.level + below;
        for (uint32_t i = 0; i < level_count(c, level); ++i) {
            const uint32_t block = block_of(c, b->params.level, c->level_codes[level][i] >> (3 * below));
            ++sums[block / group_blocks].nodes[below];
        }
    }
}

static void exclude(block_sums sums[SCAN_GROUPS])
{
    block_sums so_far = {{0}};
    for (uint32_t group = 0; group < SCAN_GROUPS; ++group) {
        const block_sums own = sums[group];
        sums[group] = so_far;
        for (unsigned k = 0; k < 4; ++k) {
            so_far.nodes[k] += own.nodes[k];
        }
    }
}

static svo_status prove_scan(svo_i_proof *proof, blocks_case *b)
{
    const nodes_case *c = b->nodes;
    block_sums sums[SCAN_GROUPS];
    sum_blocks(b, sums);
    const svo_i_argument scratch = SVO_I_LOCAL(SVO_GROUP_ITEMS * sizeof(cl_uint4));
    const svo_i_argument count[] = {SVO_I_ARGUMENT(b->marks), SVO_I_ARGUMENT(b->partials), SVO_I_ARGUMENT(b->on_device),
                                    SVO_I_ARGUMENT(b->params), scratch};
    const svo_i_argument scan[] = {SVO_I_ARGUMENT(b->partials), SVO_I_ARGUMENT(b->on_device), SVO_I_ARGUMENT(b->params),
                                   scratch};
    SVO_I_TRY(svo_i_work_launch(&proof->work, "svo_k_count_blocks", SVO_I_ARGUMENTS(count),
                                (uint64_t)SCAN_GROUPS * SVO_GROUP_ITEMS));
    SVO_I_TRY(svo_i_proof_expect(proof, "svo_k_count_blocks", b->partials, sums, sizeof sums));
    exclude(sums);
    SVO_I_TRY(svo_i_work_launch(&proof->work, "svo_k_scan_blocks", SVO_I_ARGUMENTS(scan), SVO_GROUP_ITEMS));
    SVO_I_TRY(svo_i_proof_expect(proof, "svo_k_scan_blocks", b->partials, sums, sizeof sums));
    memcpy(b->state.level_begin, c->level_begin, (b->params.level + 5) * sizeof c->level_begin[0]);
    return svo_i_proof_expect(proof, "svo_k_scan_blocks", b->on_device, &b->state, sizeof b->state);
}

/* The nodes of a level of blocks and of the two below. */
static svo_status prove_make(svo_i_proof *proof, blocks_case *b, uint32_t level)
{
    const nodes_case *c = b->nodes;
    const uint32_t nodes = c->level_begin[level + 3];
    set_block_level(b, level);
    SVO_I_TRY(prove_scan(proof, b));
    const svo_i_argument arguments[] = {
        SVO_I_ARGUMENT(b->marks),       SVO_I_ARGUMENT(b->partials),
        SVO_I_ARGUMENT(b->ranks),       SVO_I_ARGUMENT(b->masks),
        SVO_I_ARGUMENT(b->first_child), SVO_I_ARGUMENT(b->on_device),
        SVO_I_ARGUMENT(b->params),      SVO_I_LOCAL(SVO_GROUP_ITEMS * sizeof(cl_uint4))};
    SVO_I_TRY(svo_i_work_launch(&proof->work, "svo_k_make_nodes", SVO_I_ARGUMENTS(arguments),
                                (uint64_t)SCAN_GROUPS * SVO_GROUP_ITEMS));
    SVO_I_TRY(svo_i_proof_expect(proof, "svo_k_make_nodes", b->masks, c->masks, nodes));
    return svo_i_proof_expect(proof, "svo_k_make_nodes", b->first_child, c->first_child, (size_t)nodes * 4);
}

static svo_status prove_find(svo_i_proof *proof, const blocks_case *b)
{
    cl_mem cursors = NULL;
    SVO_I_TRY(svo_i_work_alloc(&proof->work, "proof", sizeof b->nodes->cursors, &cursors));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(b->fragments), SVO_I_ARGUMENT(b->marks),
                                        SVO_I_ARGUMENT(b->ranks),     SVO_I_ARGUMENT(cursors),
                                        SVO_I_ARGUMENT(b->on_device), SVO_I_ARGUMENT(b->params)};
    SVO_I_TRY(svo_i_work_launch(&proof->work, "svo_k_find_leaves", SVO_I_ARGUMENTS(arguments), FRAGMENTS));
    return svo_i_proof_expect(proof, "svo_k_find_leaves", cursors, b->nodes->cursors, sizeof b->nodes->cursors);
}

static svo_status begin_blocks(svo_i_proof *proof, blocks_case *b)
{
    svo_i_device_work *work = &proof->work;
    const uint32_t inner = b->nodes->level_begin[DEPTH];
    b->params = (svo_blocks_params){.depth = DEPTH,
                                    .fragment_count = FRAGMENTS,
                                    .inner_capacity = inner,
                                    .scan_groups = SCAN_GROUPS,
                                    .rank_blocks = BLOCKS,
                                    .level_capacity = {UINT32_MAX, UINT32_MAX, UINT32_MAX},
                                    .dense = DENSE_LEVEL,
                                    .dense_begin = first_block(DENSE_LEVEL)};
    b->state = (svo_build_state){.triangle_count = FRAGMENTS, .fragment_limit = FRAGMENTS};
    b->state.level_begin[1] = 1;
    SVO_I_TRY(fragments_buffer(proof, b->nodes, &b->fragments));
    SVO_I_TRY(svo_i_work_alloc(work, "proof", sizeof b->blocks, &b->marks));
    SVO_I_TRY(svo_i_work_fill(work, b->marks, 0xa5a5a5a5u, sizeof b->blocks));
    SVO_I_TRY(svo_i_work_fill_zero(work, b->marks, (1 + DENSE_BLOCKS) * sizeof b->blocks[0]));
    SVO_I_TRY(svo_i_work_alloc(work, "proof", BLOCKS * BLOCK_RANKS * sizeof(cl_uint), &b->ranks));
    SVO_I_TRY(svo_i_work_alloc(work, "proof", SCAN_GROUPS * sizeof(cl_uint4), &b->partials));
    SVO_I_TRY(svo_i_work_alloc(work, "proof", inner, &b->masks));
    SVO_I_TRY(svo_i_work_alloc(work, "proof", (uint64_t)inner * 4, &b->first_child));
    return svo_i_proof_buffer(proof, &b->state, sizeof b->state, &b->on_device);
}

static svo_status prove_blocks(svo_i_proof *proof, blocks_case *b)
{
    SVO_I_TRY(begin_blocks(proof, b));
    SVO_I_TRY(prove_mark(proof, b, DENSE_LEVEL));
    SVO_I_TRY(prove_mark_above(proof, b));
    SVO_I_TRY(prove_make(proof, b, 0));
    SVO_I_TRY(prove_make(proof, b, DENSE_LEVEL));
    SVO_I_TRY(prove_clear(proof, b));
    SVO_I_TRY(prove_mark(proof, b, LAST_LEVEL));
    SVO_I_TRY(prove_make(proof, b, LAST_LEVEL));
    return prove_find(proof, b);
}

svo_status svo_i_prove_subdivide(svo_device *device, const char *function, const svo_i_program_entry *made,
                                 const char **wrong)
{
    svo_i_proof proof;
    nodes_case *c = NULL;
    void *memory = NULL;
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_i_proof_begin(device, function, made, wrong, &proof));
    SVO_I_TRY_CLEANUP(make_case(&proof, &c));
    SVO_I_TRY_CLEANUP(svo_i_proof_alloc(&proof, sizeof(blocks_case), &memory));
    ((blocks_case *)memory)->nodes = c;
    SVO_I_TRY_CLEANUP(prove_blocks(&proof, memory));
cleanup:
    svo_i_proof_end(&proof);
    svo_i_free(memory);
    svo_i_free(c);
    return status;
}

/* ---- leaf lists ---- */

typedef struct lists_case {
    uint32_t counts[FRAGMENTS], begins[FRAGMENTS + 1]; /* of the leaves */
    uint32_t list[FRAGMENTS]; /* of triangles: in the order of the fragments, then in that of each leaf */
    uint32_t order[FRAGMENTS]; /* of fragments */
    uint32_t crowded; /* the leaf of many */
    svo_build_state state;
    svo_filter_params params;
} lists_case;

static uint32_t leaf_of(const nodes_case *c, uint32_t fragment)
{
    return c->cursors[fragment] - c->level_begin[DEPTH];
}

static void fill_lists(const nodes_case *c, lists_case *l)
{
    uint32_t places[FRAGMENTS];
    const uint32_t leaves = level_count(c, DEPTH);
    for (uint32_t i = 0; i < FRAGMENTS; ++i) {
        ++l->counts[leaf_of(c, i)];
    }
    for (uint32_t leaf = 0; leaf < leaves; ++leaf) {
        l->begins[leaf + 1] = l->begins[leaf] + l->counts[leaf];
        l->crowded = l->counts[leaf] > l->counts[l->crowded] ? leaf : l->crowded;
    }
    memcpy(places, l->begins, sizeof places);
    for (uint32_t i = 0; i < FRAGMENTS; ++i) {
        const uint32_t place = places[leaf_of(c, i)]++;
        l->list[place] = c->triangles[i];
        l->order[place] = i;
    }
    l->state = (svo_build_state){.triangle_count = FRAGMENTS, .fragment_limit = FRAGMENTS};
    memcpy(l->state.level_begin, c->level_begin, sizeof c->level_begin);
    l->params = (svo_filter_params){.depth = DEPTH,
                                    .leaf_begin = c->level_begin[DEPTH],
                                    .leaf_count = leaves,
                                    .fragment_count = FRAGMENTS,
                                    .digit_passes = 4};
}

static void sort_leaf(const lists_case *l, uint32_t leaf, uint32_t *list)
{
    qsort(list + l->begins[leaf], l->counts[leaf], sizeof *list, compare_words);
}

/* An array of the fragments' slots, in any order inside a leaf. */
static svo_status expect_slots(svo_i_proof *proof, const lists_case *l, cl_mem slots, const uint32_t *expected)
{
    uint32_t found[FRAGMENTS];
    uint32_t sorted[FRAGMENTS];
    SVO_I_TRY(svo_i_work_read(&proof->work, slots, 0, found, sizeof found));
    memcpy(sorted, expected, sizeof sorted);
    for (uint32_t leaf = 0; leaf < l->params.leaf_count; ++leaf) {
        sort_leaf(l, leaf, found);
        sort_leaf(l, leaf, sorted);
    }
    return memcmp(found, sorted, sizeof found) == 0 ? SVO_OK : svo_i_proof_fail(proof, "svo_k_scatter");
}

static svo_status prove_scatter(svo_i_proof *proof, const nodes_case *c, const lists_case *l, cl_mem cursors,
                                cl_mem state)
{
    const bool lists = svo_i_proof_defines(proof, "SVO_LISTS");
    const bool orders = svo_i_proof_defines(proof, "SVO_ORDER");
    cl_mem fragments = NULL;
    cl_mem counts = NULL;
    cl_mem begins = NULL;
    cl_mem list = NULL;
    cl_mem order = NULL;
    SVO_I_TRY(fragments_buffer(proof, c, &fragments));
    SVO_I_TRY(svo_i_proof_buffer(proof, l->counts, sizeof l->counts, &counts));
    SVO_I_TRY(svo_i_work_constants(&proof->work, "proof", l->begins, sizeof l->begins, &begins));
    SVO_I_TRY(svo_i_work_alloc(&proof->work, "proof", sizeof l->list, &list));
    SVO_I_TRY(svo_i_work_alloc(&proof->work, "proof", sizeof l->order, &order));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(fragments), SVO_I_ARGUMENT(cursors),  SVO_I_ARGUMENT(counts),
                                        SVO_I_ARGUMENT(begins),    SVO_I_ARGUMENT(list),     SVO_I_ARGUMENT(order),
                                        SVO_I_ARGUMENT(state),     SVO_I_ARGUMENT(l->params)};
    SVO_I_TRY(svo_i_work_launch(&proof->work, "svo_k_scatter", SVO_I_ARGUMENTS(arguments), FRAGMENTS));
    SVO_I_TRY(lists ? expect_slots(proof, l, list, l->list) : SVO_OK);
    return orders ? expect_slots(proof, l, order, l->order) : SVO_OK;
}

/* Sorts l->list on the host too. */
static svo_status prove_sorted(svo_i_proof *proof, lists_case *l, cl_mem state)
{
    svo_i_device_work *work = &proof->work;
    cl_mem begins = NULL;
    cl_mem list = NULL;
    cl_mem spare = NULL;
    cl_mem long_leaves = NULL;
    SVO_I_TRY(svo_i_work_constants(work, "proof", l->begins, sizeof l->begins, &begins));
    SVO_I_TRY(svo_i_proof_buffer(proof, l->list, sizeof l->list, &list));
    SVO_I_TRY(svo_i_work_alloc(work, "proof", sizeof l->list, &spare));
    SVO_I_TRY(svo_i_work_alloc(work, "proof", 2 * sizeof(cl_uint), &long_leaves));
    const svo_i_argument of_short[] = {SVO_I_ARGUMENT(begins), SVO_I_ARGUMENT(list), SVO_I_ARGUMENT(long_leaves),
                                       SVO_I_ARGUMENT(state), SVO_I_ARGUMENT(l->params)};
    SVO_I_TRY(svo_i_work_launch(work, "svo_k_sort_short", SVO_I_ARGUMENTS(of_short), l->params.leaf_count));
    for (uint32_t leaf = 0; leaf < l->params.leaf_count; ++leaf) {
        if (leaf != l->crowded) {
            sort_leaf(l, leaf, l->list);
        }
    }
    SVO_I_TRY(svo_i_proof_expect(proof, "svo_k_sort_short", list, l->list, sizeof l->list));
    SVO_I_TRY(svo_i_proof_expect(proof, "svo_k_sort_short", long_leaves, &l->crowded, sizeof l->crowded));
    const svo_i_argument of_long[] = {SVO_I_ARGUMENT(begins),
                                      SVO_I_ARGUMENT(list),
                                      SVO_I_ARGUMENT(spare),
                                      SVO_I_ARGUMENT(long_leaves),
                                      SVO_I_ARGUMENT(state),
                                      SVO_I_ARGUMENT(l->params),
                                      SVO_I_LOCAL(sizeof(cl_uint) * SVO_DIGITS * SVO_GROUP_ITEMS),
                                      SVO_I_LOCAL(SVO_GROUP_ITEMS * sizeof(cl_uint))};
    SVO_I_TRY(svo_i_work_launch(work, "svo_k_sort_long", SVO_I_ARGUMENTS(of_long), SVO_GROUP_ITEMS));
    sort_leaf(l, l->crowded, l->list);
    return svo_i_proof_expect(proof, "svo_k_sort_long", list, l->list, sizeof l->list);
}

static svo_status prove_lists(svo_i_proof *proof, const nodes_case *c, lists_case *l)
{
    const bool lists = svo_i_proof_defines(proof, "SVO_LISTS");
    cl_mem cursors = NULL;
    cl_mem counts = NULL;
    cl_mem state = NULL;
    fill_lists(c, l);
    SVO_I_TRY(svo_i_work_constants(&proof->work, "proof", c->cursors, sizeof c->cursors, &cursors));
    SVO_I_TRY(svo_i_proof_buffer(proof, &l->state, sizeof l->state, &state));
    SVO_I_TRY(svo_i_work_alloc(&proof->work, "proof", sizeof l->counts, &counts));
    SVO_I_TRY(svo_i_work_fill_zero(&proof->work, counts, sizeof l->counts));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(cursors), SVO_I_ARGUMENT(counts), SVO_I_ARGUMENT(state),
                                        SVO_I_ARGUMENT(l->params)};
    SVO_I_TRY(svo_i_work_launch(&proof->work, "svo_k_count", SVO_I_ARGUMENTS(arguments), FRAGMENTS));
    SVO_I_TRY(svo_i_proof_expect(proof, "svo_k_count", counts, l->counts, sizeof l->counts));
    if (lists || svo_i_proof_defines(proof, "SVO_ORDER")) {
        SVO_I_TRY(prove_scatter(proof, c, l, cursors, state));
    }
    return lists ? prove_sorted(proof, l, state) : SVO_OK;
}

svo_status svo_i_prove_pack(svo_device *device, const char *function, const svo_i_program_entry *made,
                            const char **wrong)
{
    svo_i_proof proof;
    nodes_case *c = NULL;
    void *memory = NULL;
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_i_proof_begin(device, function, made, wrong, &proof));
    SVO_I_TRY_CLEANUP(make_case(&proof, &c));
    SVO_I_TRY_CLEANUP(svo_i_proof_alloc(&proof, sizeof(lists_case), &memory));
    SVO_I_TRY_CLEANUP(svo_i_prove_scans(&proof));
    SVO_I_TRY_CLEANUP(prove_lists(&proof, c, memory));
cleanup:
    svo_i_proof_end(&proof);
    svo_i_free(memory);
    svo_i_free(c);
    return status;
}
