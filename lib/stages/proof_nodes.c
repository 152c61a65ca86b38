/* SPDX-License-Identifier: MIT */
/* Known answers of the kernels that make nodes: from the root down (subdivide.cl) and up (bottom_up.cl). */
#include <string.h>

#include "stages/programs.h"
#include "stages/proof_tree.h"

#define FRAGMENTS SVO_I_PROOF_FRAGMENTS
#define DEPTH     SVO_I_PROOF_DEPTH

/* ---- subdivision ---- */

#define DENSE_LEVEL  3
#define DENSE_BLOCKS 512
#define BLOCKS       (1 + DENSE_BLOCKS + FRAGMENTS)
#define BLOCK_WORDS  16 /* of 32 bits */
#define BLOCK_RANKS  8
#define SCAN_GROUPS  3
#define LAST_LEVEL   (DEPTH - 3) /* of blocks */

/* Four counts of a group of blocks: the nodes of their level and of the three below. */
typedef struct block_sums {
    uint32_t nodes[4];
} block_sums;

typedef struct blocks_case {
    svo_i_proof_tree tree;
    const svo_i_proof_tree *nodes; /* tree */
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
static uint32_t block_of(const svo_i_proof_tree *c, uint32_t level, uint32_t code)
{
    return level <= DENSE_LEVEL ? code : svo_i_proof_place_of(c, level, code);
}

static uint32_t block_count(const svo_i_proof_tree *c, uint32_t level)
{
    return level <= DENSE_LEVEL ? 1u << (3 * level) : svo_i_proof_level_count(c, level);
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
    const svo_i_proof_tree *c = b->nodes;
    for (uint32_t i = 0; i < svo_i_proof_level_count(c, level + 3); ++i) {
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
    SVO_I_TRY(svo_i_proof_launch(proof, "svo_k_mark", SVO_I_ARGUMENTS(arguments), FRAGMENTS));
    return expect_blocks(proof, b, "svo_k_mark", first_block(level) + block_count(b->nodes, level));
}

static svo_status prove_mark_above(svo_i_proof *proof, blocks_case *b)
{
    set_block_level(b, 0);
    mark_on_host(b, 0);
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(b->marks), SVO_I_ARGUMENT(b->params)};
    SVO_I_TRY(svo_i_proof_launch(proof, "svo_k_mark_above", SVO_I_ARGUMENTS(arguments), DENSE_BLOCKS / 8));
    return expect_blocks(proof, b, "svo_k_mark_above", 1);
}

/* What the blocks of each group of the scan stand for. */
static void sum_blocks(const blocks_case *b, block_sums sums[SCAN_GROUPS])
{
    const svo_i_proof_tree *c = b->nodes;
    const uint32_t tiles = (block_count(c, b->params.level) + SVO_GROUP_ITEMS - 1) / SVO_GROUP_ITEMS;
    const uint32_t group_blocks = (tiles + SCAN_GROUPS - 1) / SCAN_GROUPS * SVO_GROUP_ITEMS;
    memset(sums, 0, SCAN_GROUPS * sizeof *sums);
    for (uint32_t below = 0; below <= 3; ++below) {
        const uint32_t level = b->params.level + below;
        for (uint32_t i = 0; i < svo_i_proof_level_count(c, level); ++i) {
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

/* Where levels begin, once the nodes of a level of blocks are counted. */
static svo_status expect_levels(svo_i_proof *proof, blocks_case *b, const char *kernel)
{
    memcpy(b->state.level_begin, b->nodes->level_begin, (b->params.level + 5) * sizeof b->state.level_begin[0]);
    return svo_i_proof_expect(proof, kernel, b->on_device, &b->state, sizeof b->state);
}

static svo_status prove_scan(svo_i_proof *proof, blocks_case *b)
{
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
    return expect_levels(proof, b, "svo_k_scan_blocks");
}

/* The nodes of a level of blocks and of the two below. */
static svo_status expect_nodes(svo_i_proof *proof, const blocks_case *b, const char *kernel)
{
    const svo_i_proof_tree *c = b->nodes;
    const uint32_t nodes = c->level_begin[b->params.level + 3];
    SVO_I_TRY(svo_i_proof_expect(proof, kernel, b->masks, c->masks, nodes));
    return svo_i_proof_expect(proof, kernel, b->first_child, c->first_child, (size_t)nodes * 4);
}

/* Marks, counts and makes level 0 at once. */
static svo_status prove_top(svo_i_proof *proof, blocks_case *b)
{
    static const char kernel[] = "svo_k_make_top";
    set_block_level(b, 0);
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(b->marks),     SVO_I_ARGUMENT(b->ranks),
                                        SVO_I_ARGUMENT(b->masks),     SVO_I_ARGUMENT(b->first_child),
                                        SVO_I_ARGUMENT(b->on_device), SVO_I_ARGUMENT(b->params),
                                        SVO_I_ARGUMENT(b->params),    SVO_I_LOCAL(SVO_GROUP_ITEMS * sizeof(cl_uint4))};
    SVO_I_TRY(svo_i_work_launch(&proof->work, kernel, SVO_I_ARGUMENTS(arguments), SVO_GROUP_ITEMS));
    SVO_I_TRY(expect_blocks(proof, b, kernel, 1));
    SVO_I_TRY(expect_levels(proof, b, kernel));
    return expect_nodes(proof, b, kernel);
}

static svo_status prove_make(svo_i_proof *proof, blocks_case *b, uint32_t level)
{
    set_block_level(b, level);
    SVO_I_TRY(prove_scan(proof, b));
    const svo_i_argument arguments[] = {
        SVO_I_ARGUMENT(b->marks),       SVO_I_ARGUMENT(b->partials),
        SVO_I_ARGUMENT(b->ranks),       SVO_I_ARGUMENT(b->masks),
        SVO_I_ARGUMENT(b->first_child), SVO_I_ARGUMENT(b->on_device),
        SVO_I_ARGUMENT(b->params),      SVO_I_LOCAL(SVO_GROUP_ITEMS * sizeof(cl_uint4))};
    SVO_I_TRY(svo_i_work_launch(&proof->work, "svo_k_make_nodes", SVO_I_ARGUMENTS(arguments),
                                (uint64_t)SCAN_GROUPS * SVO_GROUP_ITEMS));
    return expect_nodes(proof, b, "svo_k_make_nodes");
}

static svo_status prove_find(svo_i_proof *proof, const blocks_case *b)
{
    cl_mem cursors = NULL;
    SVO_I_TRY(svo_i_work_alloc(&proof->work, "proof", sizeof b->nodes->cursors, &cursors));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(b->fragments), SVO_I_ARGUMENT(b->marks),
                                        SVO_I_ARGUMENT(b->ranks),     SVO_I_ARGUMENT(cursors),
                                        SVO_I_ARGUMENT(b->on_device), SVO_I_ARGUMENT(b->params)};
    SVO_I_TRY(svo_i_proof_launch(proof, "svo_k_find_leaves", SVO_I_ARGUMENTS(arguments), FRAGMENTS));
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
    SVO_I_TRY(svo_i_proof_fragments(proof, b->nodes, &b->fragments));
    SVO_I_TRY(svo_i_work_alloc(work, "proof", sizeof b->blocks, &b->marks));
    SVO_I_TRY(svo_i_work_fill(work, b->marks, 0xa5a5a5a5u, sizeof b->blocks));
    SVO_I_TRY(svo_i_work_fill_zero(work, b->marks, (1 + DENSE_BLOCKS) * sizeof b->blocks[0]));
    SVO_I_TRY(svo_i_work_alloc(work, "proof", sizeof(cl_uint) * BLOCKS * BLOCK_RANKS, &b->ranks));
    SVO_I_TRY(svo_i_work_alloc(work, "proof", SCAN_GROUPS * sizeof(cl_uint4), &b->partials));
    SVO_I_TRY(svo_i_work_alloc(work, "proof", inner, &b->masks));
    SVO_I_TRY(svo_i_work_alloc(work, "proof", (uint64_t)inner * 4, &b->first_child));
    return svo_i_proof_buffer(proof, &b->state, sizeof b->state, &b->on_device);
}

static svo_status prove_blocks(svo_i_proof *proof, void *memory)
{
    blocks_case *b = memory;
    svo_i_proof_tree_fill(proof, &b->tree);
    b->nodes = &b->tree;
    SVO_I_TRY(begin_blocks(proof, b));
    SVO_I_TRY(prove_mark(proof, b, DENSE_LEVEL));
    SVO_I_TRY(prove_mark_above(proof, b));
    SVO_I_TRY(prove_top(proof, b));
    SVO_I_TRY(prove_make(proof, b, DENSE_LEVEL)); /* and empty blocks, which held other words before */
    SVO_I_TRY(expect_blocks(proof, b, "svo_k_make_nodes", first_block(LAST_LEVEL) + block_count(b->nodes, LAST_LEVEL)));
    SVO_I_TRY(prove_mark(proof, b, LAST_LEVEL));
    SVO_I_TRY(prove_make(proof, b, LAST_LEVEL));
    return prove_find(proof, b);
}

svo_status svo_i_prove_subdivide(svo_device *device, const char *function, const svo_i_program_entry *made,
                                 const char **wrong)
{
    return svo_i_proof_run(device, function, made, wrong, sizeof(blocks_case), prove_blocks);
}

/* ---- from the leaves up ---- */

/* The fragments in the order of their codes, and what kernels make of them. */
typedef struct sorted_case {
    svo_i_proof_tree tree;
    uint32_t words[FRAGMENTS * SVO_FRAGMENT_WORDS_48];
    uint32_t codes[FRAGMENTS], triangles[FRAGMENTS];
    uint32_t level_counts[DEPTH + 2]; /* fragments by the first level on which they begin a node; impossible ones */
    uint32_t flags[FRAGMENTS], before[FRAGMENTS]; /* whether a leaf begins, and how many began before */
    uint32_t cursors[FRAGMENTS];
    uint32_t leaf_codes[2 * FRAGMENTS], parent_codes[2 * FRAGMENTS]; /* as kernels read them */
    uint32_t parent_flags[FRAGMENTS], parents_before[FRAGMENTS];
    uint32_t list_begin[FRAGMENTS + 1];
} sorted_case;

/* The codes of a level in words of their own. */
static void put_codes(const svo_i_proof_tree *c, uint32_t level, uint32_t *words)
{
    const uint32_t stride = c->word_count - 1;
    for (uint32_t i = 0; i < svo_i_proof_level_count(c, level); ++i) {
        words[(size_t)i * stride] = c->level_codes[level][i];
    }
}

/* Whether a node of the level above begins at each of the codes, and how many began before. */
static void flag_begins(const uint32_t *codes, uint32_t count, uint32_t shift, uint32_t *flags, uint32_t *before)
{
    uint32_t begun = 0;
    for (uint32_t i = 0; i < count; ++i) {
        flags[i] = i == 0 || codes[i] >> shift != codes[i - 1] >> shift ? 1 : 0;
        before[i] = begun;
        begun += flags[i];
    }
}

static void fill_sorted(const svo_i_proof_tree *c, sorted_case *s)
{
    uint32_t places[FRAGMENTS] = {0};
    uint32_t count = 0;
    for (uint32_t leaf = 0; leaf < svo_i_proof_level_count(c, DEPTH); ++leaf) {
        s->list_begin[leaf] = count;
        for (uint32_t i = 0; i < FRAGMENTS; ++i) {
            if (c->codes[i] == c->level_codes[DEPTH][leaf]) {
                places[count++] = i;
            }
        }
        s->list_begin[leaf + 1] = count;
    }
    for (uint32_t i = 0; i < FRAGMENTS; ++i) {
        s->codes[i] = c->codes[places[i]];
        s->triangles[i] = c->triangles[places[i]];
        s->cursors[i] = c->cursors[places[i]];
        memcpy(s->words + (size_t)i * c->word_count, c->words + (size_t)places[i] * c->word_count,
               (size_t)4 * c->word_count);
    }
    for (uint32_t level = 0; level <= DEPTH; ++level) {
        s->level_counts[level] =
            svo_i_proof_level_count(c, level) - (level > 0 ? svo_i_proof_level_count(c, level - 1) : 0);
    }
    put_codes(c, DEPTH, s->leaf_codes);
    put_codes(c, DEPTH - 1, s->parent_codes);
    flag_begins(s->codes, FRAGMENTS, 0, s->flags, s->before);
    flag_begins(c->level_codes[DEPTH], svo_i_proof_level_count(c, DEPTH), 3, s->parent_flags, s->parents_before);
}

static svo_status prove_level_counts(svo_i_proof *proof, const sorted_case *s, cl_mem fragments,
                                     const svo_bottom_up_params *params)
{
    static const char kernel[] = "svo_k_bottom_up_count";
    cl_mem counts = NULL;
    SVO_I_TRY(svo_i_work_alloc(&proof->work, "proof", sizeof s->level_counts, &counts));
    SVO_I_TRY(svo_i_work_fill_zero(&proof->work, counts, sizeof s->level_counts));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(fragments), SVO_I_ARGUMENT(counts), SVO_I_ARGUMENT(*params),
                                        SVO_I_LOCAL(sizeof s->level_counts)};
    SVO_I_TRY(svo_i_work_launch(&proof->work, kernel, SVO_I_ARGUMENTS(arguments), FRAGMENTS));
    return svo_i_proof_expect(proof, kernel, counts, s->level_counts, sizeof s->level_counts);
}

/* codes: the fragments, or the codes of the leaves. */
static svo_status prove_flags(svo_i_proof *proof, cl_mem codes, const svo_bottom_up_params *params,
                              const uint32_t *expected)
{
    static const char kernel[] = "svo_k_bottom_up_flags";
    cl_mem flags = NULL;
    SVO_I_TRY(svo_i_work_alloc(&proof->work, "proof", FRAGMENTS * sizeof(cl_uint), &flags));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(codes), SVO_I_ARGUMENT(flags), SVO_I_ARGUMENT(*params)};
    SVO_I_TRY(svo_i_work_launch(&proof->work, kernel, SVO_I_ARGUMENTS(arguments), params->count));
    return svo_i_proof_expect(proof, kernel, flags, expected, params->count * sizeof(cl_uint));
}

static svo_status prove_leaves(svo_i_proof *proof, const svo_i_proof_tree *c, const sorted_case *s, cl_mem fragments,
                               const svo_bottom_up_params *params)
{
    static const char kernel[] = "svo_k_bottom_up_leaves";
    const size_t code_bytes = (size_t)svo_i_proof_level_count(c, DEPTH) * (c->word_count - 1) * 4;
    cl_mem before = NULL;
    cl_mem cursors = NULL;
    cl_mem codes = NULL;
    SVO_I_TRY(svo_i_work_constants(&proof->work, "proof", s->before, sizeof s->before, &before));
    SVO_I_TRY(svo_i_work_alloc(&proof->work, "proof", sizeof s->cursors, &cursors));
    SVO_I_TRY(svo_i_work_alloc(&proof->work, "proof", code_bytes, &codes));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(fragments), SVO_I_ARGUMENT(before), SVO_I_ARGUMENT(cursors),
                                        SVO_I_ARGUMENT(codes), SVO_I_ARGUMENT(*params)};
    SVO_I_TRY(svo_i_work_launch(&proof->work, kernel, SVO_I_ARGUMENTS(arguments), FRAGMENTS));
    SVO_I_TRY(svo_i_proof_expect(proof, kernel, cursors, s->cursors, sizeof s->cursors));
    return svo_i_proof_expect(proof, kernel, codes, s->leaf_codes, code_bytes);
}

static svo_status prove_sorted_lists(svo_i_proof *proof, const sorted_case *s, cl_mem fragments,
                                     const svo_bottom_up_params *params)
{
    static const char kernel[] = "svo_k_bottom_up_lists";
    const size_t begin_bytes = ((size_t)params->child_begin + 1) * 4;
    cl_mem cursors = NULL;
    cl_mem begins = NULL;
    cl_mem list = NULL;
    SVO_I_TRY(svo_i_work_constants(&proof->work, "proof", s->cursors, sizeof s->cursors, &cursors));
    SVO_I_TRY(svo_i_work_alloc(&proof->work, "proof", begin_bytes, &begins));
    SVO_I_TRY(svo_i_work_alloc(&proof->work, "proof", sizeof s->triangles, &list));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(fragments), SVO_I_ARGUMENT(cursors), SVO_I_ARGUMENT(begins),
                                        SVO_I_ARGUMENT(list), SVO_I_ARGUMENT(*params)};
    SVO_I_TRY(svo_i_work_launch(&proof->work, kernel, SVO_I_ARGUMENTS(arguments), FRAGMENTS));
    SVO_I_TRY(svo_i_proof_expect(proof, kernel, begins, s->list_begin, begin_bytes));
    return svo_i_proof_expect(proof, kernel, list, s->triangles, sizeof s->triangles);
}

/* The parents of the leaves. */
static svo_status prove_parents(svo_i_proof *proof, const svo_i_proof_tree *c, const sorted_case *s)
{
    static const char kernel[] = "svo_k_bottom_up_nodes";
    const uint32_t parents = svo_i_proof_level_count(c, DEPTH - 1);
    const svo_bottom_up_params params = {.depth = DEPTH,
                                         .count = svo_i_proof_level_count(c, DEPTH),
                                         .shift = 3,
                                         .node_begin = 0,
                                         .child_begin = c->level_begin[DEPTH]};
    cl_mem given[2] = {NULL, NULL};
    cl_mem made[3] = {NULL, NULL, NULL};
    SVO_I_TRY(svo_i_work_constants(&proof->work, "proof", s->leaf_codes, sizeof s->leaf_codes, &given[0]));
    SVO_I_TRY(svo_i_work_constants(&proof->work, "proof", s->parents_before, sizeof s->parents_before, &given[1]));
    SVO_I_TRY(svo_i_work_alloc(&proof->work, "proof", sizeof s->parent_codes, &made[0]));
    SVO_I_TRY(svo_i_work_alloc(&proof->work, "proof", parents, &made[1]));
    SVO_I_TRY(svo_i_work_alloc(&proof->work, "proof", (uint64_t)parents * 4, &made[2]));
    SVO_I_TRY(prove_flags(proof, given[0], &params, s->parent_flags));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(given[0]), SVO_I_ARGUMENT(given[1]), SVO_I_ARGUMENT(made[0]),
                                        SVO_I_ARGUMENT(made[1]),  SVO_I_ARGUMENT(made[2]),  SVO_I_ARGUMENT(params)};
    SVO_I_TRY(svo_i_work_launch(&proof->work, kernel, SVO_I_ARGUMENTS(arguments), params.count));
    SVO_I_TRY(svo_i_proof_expect(proof, kernel, made[0], s->parent_codes, (size_t)parents * (c->word_count - 1) * 4));
    SVO_I_TRY(svo_i_proof_expect(proof, kernel, made[1], c->masks + c->level_begin[DEPTH - 1], parents));
    return svo_i_proof_expect(proof, kernel, made[2], c->first_child + c->level_begin[DEPTH - 1], (size_t)parents * 4);
}

static svo_status prove_bottom_up(svo_i_proof *proof, void *memory)
{
    sorted_case *s = memory;
    const svo_i_proof_tree *c = &s->tree;
    svo_i_proof_tree_fill(proof, &s->tree);
    svo_bottom_up_params params = {.depth = DEPTH,
                                   .count = FRAGMENTS,
                                   .of_fragments = 1,
                                   .node_begin = c->level_begin[DEPTH],
                                   .child_begin = svo_i_proof_level_count(c, DEPTH),
                                   .triangle_count = FRAGMENTS};
    cl_mem fragments = NULL;
    fill_sorted(c, s);
    SVO_I_TRY(
        svo_i_work_constants(&proof->work, "proof", s->words, (uint64_t)FRAGMENTS * c->word_count * 4, &fragments));
    SVO_I_TRY(prove_level_counts(proof, s, fragments, &params));
    SVO_I_TRY(prove_flags(proof, fragments, &params, s->flags));
    SVO_I_TRY(prove_leaves(proof, c, s, fragments, &params));
    SVO_I_TRY(prove_sorted_lists(proof, s, fragments, &params));
    return prove_parents(proof, c, s);
}

svo_status svo_i_prove_sorted_builder(svo_device *device, const char *function, const svo_i_program_entry *made,
                                      const char **wrong)
{
    SVO_I_TRY(svo_i_prove_sort(device, function, made, wrong));
    return svo_i_proof_run(device, function, made, wrong, sizeof(sorted_case), prove_bottom_up);
}
