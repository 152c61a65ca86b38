/* SPDX-License-Identifier: MIT */
/* Known answers of the kernels that sort fragments and pack leaf lists: sort.cl, pack.cl, and scan.cl for both. */
#include <stdlib.h>
#include <string.h>

#include "stages/programs.h"
#include "stages/proof_tree.h"
#include "stages/sort.h"

#define FRAGMENTS SVO_I_PROOF_FRAGMENTS
#define DEPTH     SVO_I_PROOF_DEPTH

/* ---- the sort ---- */

#define SORT_GROUPS 5
#define SORT_CELLS  (SORT_GROUPS * SVO_SORT_DIGITS)

/* One pass over a digit. */
typedef struct sort_case {
    svo_i_proof_tree tree;
    uint32_t counts[SORT_CELLS], before[SORT_CELLS]; /* by digit, then by block */
    uint32_t moved[FRAGMENTS * SVO_FRAGMENT_WORDS_48];
    svo_sort_params params;
} sort_case;

/* Gives codes and triangles the bits that they do not have in a tree of DEPTH levels: at the top of a triangle's word,
   and across the words of a long code. */
static void raise_words(svo_i_proof_tree *c, uint32_t shift, bool by_triangle)
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

static void fill_sort(const svo_i_proof_tree *c, sort_case *s)
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
        memcpy(s->moved + (size_t)place * c->word_count, c->words + (size_t)i * c->word_count,
               (size_t)4 * c->word_count);
    }
}

static svo_status prove_pass(svo_i_proof *proof, const svo_i_proof_tree *c, const sort_case *s)
{
    const uint64_t items = (uint64_t)SORT_GROUPS * SVO_GROUP_ITEMS;
    const svo_i_argument digits = SVO_I_LOCAL(svo_i_sort_local_bytes(proof->work.device));
    cl_mem list = NULL;
    cl_mem counts = NULL;
    cl_mem before = NULL;
    cl_mem moved = NULL;
    SVO_I_TRY(svo_i_proof_fragments(proof, c, &list));
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

static svo_status prove_sort(svo_i_proof *proof, void *memory)
{
    sort_case *s = memory;
    svo_i_proof_tree *c = &s->tree;
    svo_i_proof_tree_fill(proof, c);
    SVO_I_TRY(svo_i_prove_scans(proof));
    for (unsigned by_triangle = 0; by_triangle < 2; ++by_triangle) {
        const uint32_t shift = by_triangle == 0 && c->word_count == SVO_FRAGMENT_WORDS_48 ? 29 : 26;
        raise_words(c, shift, by_triangle != 0);
        s->params = (svo_sort_params){FRAGMENTS, shift, by_triangle, SVO_SORT_BITS};
        fill_sort(c, s);
        SVO_I_TRY(prove_pass(proof, c, s));
    }
    return SVO_OK;
}

svo_status svo_i_prove_sort(svo_device *device, const char *function, const svo_i_program_entry *made,
                            const char **wrong)
{
    return svo_i_proof_run(device, function, made, wrong, sizeof(sort_case), prove_sort);
}

/* ---- leaf lists ---- */

typedef struct lists_case {
    svo_i_proof_tree tree;
    uint32_t counts[FRAGMENTS], begins[FRAGMENTS + 1]; /* of the leaves */
    uint32_t list[FRAGMENTS]; /* of triangles: in the order of the fragments, then in that of each leaf */
    uint32_t order[FRAGMENTS]; /* of fragments */
    uint32_t crowded; /* the leaf of many */
    svo_build_state state;
    svo_filter_params params;
} lists_case;

static uint32_t leaf_of(const svo_i_proof_tree *c, uint32_t fragment)
{
    return c->cursors[fragment] - c->level_begin[DEPTH];
}

static void fill_lists(const svo_i_proof_tree *c, lists_case *l)
{
    uint32_t places[FRAGMENTS];
    const uint32_t leaves = svo_i_proof_level_count(c, DEPTH);
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
    qsort(list + l->begins[leaf], l->counts[leaf], sizeof *list, svo_i_proof_compare_words);
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

static svo_status prove_scatter(svo_i_proof *proof, const svo_i_proof_tree *c, const lists_case *l, cl_mem cursors,
                                cl_mem state)
{
    const bool lists = svo_i_proof_defines(proof, "SVO_LISTS");
    const bool orders = svo_i_proof_defines(proof, "SVO_ORDER");
    cl_mem fragments = NULL;
    cl_mem counts = NULL;
    cl_mem begins = NULL;
    cl_mem list = NULL;
    cl_mem order = NULL;
    SVO_I_TRY(svo_i_proof_fragments(proof, c, &fragments));
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

static svo_status prove_lists(svo_i_proof *proof, const svo_i_proof_tree *c, lists_case *l)
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

static svo_status prove_pack(svo_i_proof *proof, void *memory)
{
    lists_case *l = memory;
    svo_i_proof_tree_fill(proof, &l->tree);
    SVO_I_TRY(svo_i_prove_scans(proof));
    return prove_lists(proof, &l->tree, l);
}

svo_status svo_i_prove_pack(svo_device *device, const char *function, const svo_i_program_entry *made,
                            const char **wrong)
{
    return svo_i_proof_run(device, function, made, wrong, sizeof(lists_case), prove_pack);
}
