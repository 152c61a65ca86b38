/* SPDX-License-Identifier: MIT */
/* A list of fragments and its tree, for known answers: the host makes the tree by sorting codes. */
#include "stages/proof_tree.h"

#include <stdlib.h>
#include <string.h>

#define FRAGMENTS SVO_I_PROOF_FRAGMENTS
#define DEPTH     SVO_I_PROOF_DEPTH
/* A leaf of four in seven fragments. */
#define CROWD_CODE 0x2345678u

int svo_i_proof_compare_words(const void *a, const void *b)
{
    const uint32_t x = *(const uint32_t *)a;
    const uint32_t y = *(const uint32_t *)b;
    return x < y ? -1 : x > y ? 1 : 0;
}

uint32_t svo_i_proof_place_of(const svo_i_proof_tree *tree, uint32_t level, uint32_t code)
{
    const uint32_t *const codes = tree->level_codes[level];
    const uint32_t *found =
        bsearch(&code, codes, svo_i_proof_level_count(tree, level), sizeof *codes, svo_i_proof_compare_words);
    return (uint32_t)(found - codes);
}

static void fill_levels(svo_i_proof_tree *c)
{
    uint32_t sorted[FRAGMENTS];
    memcpy(sorted, c->codes, sizeof sorted);
    qsort(sorted, FRAGMENTS, sizeof *sorted, svo_i_proof_compare_words);
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

static void fill_nodes(svo_i_proof_tree *c)
{
    for (uint32_t level = 0; level < DEPTH; ++level) {
        for (uint32_t child = svo_i_proof_level_count(c, level + 1); child-- > 0;) {
            const uint32_t code = c->level_codes[level + 1][child];
            const uint32_t node = c->level_begin[level] + svo_i_proof_place_of(c, level, code >> 3);
            c->masks[node] |= (uint8_t)(1u << (code & 7u));
            c->first_child[node] = c->level_begin[level + 1] + child;
        }
    }
    for (uint32_t i = 0; i < FRAGMENTS; ++i) {
        c->cursors[i] = c->level_begin[DEPTH] + svo_i_proof_place_of(c, DEPTH, c->codes[i]);
    }
}

/* A code of DEPTH levels: at either end of the grid, in the crowd, or anywhere. */
static uint32_t code_of(uint32_t i, uint32_t random)
{
    const uint32_t last = (1u << (3 * DEPTH)) - 1u;
    const uint32_t codes[3] = {random & 15u, last - (random & 15u), CROWD_CODE};
    return i % 7 < 6 ? codes[i % 7 < 2 ? i % 7 : 2] : random & last;
}

void svo_i_proof_tree_fill(const svo_i_proof *proof, svo_i_proof_tree *tree)
{
    uint64_t random = 2;
    tree->word_count = svo_i_proof_defines(proof, "SVO_CODE48") ? SVO_FRAGMENT_WORDS_48 : SVO_FRAGMENT_WORDS_30;
    for (uint32_t i = 0; i < FRAGMENTS; ++i) {
        tree->codes[i] = code_of(i, (uint32_t)svo_i_proof_next(&random));
        tree->triangles[i] = i * 211 % FRAGMENTS;
        tree->words[(size_t)i * tree->word_count] = tree->codes[i];
        tree->words[(i + 1) * tree->word_count - 1] = tree->triangles[i];
    }
    fill_levels(tree);
    fill_nodes(tree);
}

svo_status svo_i_proof_fragments(svo_i_proof *proof, const svo_i_proof_tree *tree, cl_mem *out)
{
    return svo_i_work_constants(&proof->work, "proof", tree->words, (uint64_t)FRAGMENTS * tree->word_count * 4, out);
}
