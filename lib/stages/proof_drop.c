/* SPDX-License-Identifier: MIT */
/*
 * Known answers of the kernels that drop pairs by their alpha (kernels/stages/drop.cl): triangles whose attributes do
 * not vary, with the alpha of materials, and of corners and texels where the program reads them, around the least one.
 * What remains is compared without its order.
 */
#include <stdlib.h>
#include <string.h>

#include "core/proof.h"
#include "shared/layout.h"
#include "stages/programs.h"

/* More than three groups, and a last one that is not full. */
#define PAIRS     (3 * SVO_GROUP_ITEMS + 5)
#define ROOM      (PAIRS + 7)
#define TRIANGLES PAIRS
#define MATERIALS 6
#define DEPTH     4
#define LEAST     100

typedef struct drop_case {
    uint32_t indices[TRIANGLES * 3];
    svo_triangle_record records[TRIANGLES];
    svo_material_record materials[MATERIALS];
    uint32_t colors[TRIANGLES * 3];
    int32_t uvs[TRIANGLES * 6];
    uint32_t texels[2];
    uint32_t words[ROOM * SVO_FRAGMENT_WORDS_48]; /* the list, and then what it becomes */
    uint32_t word_count;
    uint32_t kept[PAIRS]; /* triangles of the pairs that remain, ascending */
    uint32_t kept_count;
    uint32_t counters[SVO_COUNTER_WORDS];
    uint32_t tally[3];
    bool has_colors, has_texels;
    svo_drop_params params;
} drop_case;

/* Rounded half up, as kernels multiply colors. */
static uint32_t times(uint32_t a, uint32_t b)
{
    return (2 * a * b + 255) / 510;
}

/* Materials on both sides of the least alpha; the last is textured, with a texel that shows and one that does not. */
static void fill_materials(drop_case *c)
{
    static const uint32_t alphas[MATERIALS] = {0, LEAST - 1, LEAST, 254, 255, 255};
    for (uint32_t i = 0; i < MATERIALS; ++i) {
        c->materials[i] = (svo_material_record){.rgba = alphas[i] << 24 | 0x102030, .least_alpha = alphas[i]};
    }
    if (c->has_texels) {
        c->materials[MATERIALS - 1].width = 2;
        c->materials[MATERIALS - 1].height = 1;
        c->materials[MATERIALS - 1].least_alpha = 0;
    }
    c->texels[0] = 0x00ffffffu;
    c->texels[1] = 0xffffffffu;
}

/* The alpha of a triangle, all of whose corners are alike. */
static uint32_t fill_triangle(drop_case *c, uint32_t triangle, uint64_t *random)
{
    static const uint32_t corner_alphas[] = {255, 255, 128, 101, 100};
    const uint32_t material = (uint32_t)(svo_i_proof_next(random) % MATERIALS);
    const uint32_t corner = corner_alphas[svo_i_proof_next(random) % 5];
    const uint32_t texel = (uint32_t)(svo_i_proof_next(random) % 2);
    for (uint32_t i = 3 * triangle; i < 3 * triangle + 3; ++i) {
        c->indices[i] = i;
        c->colors[i] = corner << 24;
        c->uvs[(size_t)2 * i] = texel != 0 ? 49152 : 16384; /* in the middle of the texel */
        c->uvs[(size_t)2 * i + 1] = 32768;
    }
    c->records[triangle] = (svo_triangle_record){.material = material, .normal_z_flags = SVO_TRIANGLE_FLAT};
    uint32_t alpha = c->materials[material].rgba >> 24;
    alpha = c->has_colors ? times(alpha, corner) : alpha;
    return c->materials[material].width != 0 && texel == 0 ? 0 : alpha;
}

/* Fills a case, and marks the pairs that are dropped in words, with what remains in kept. plain: receives the list
   before. */
static void fill_drop(drop_case *c, uint32_t *plain)
{
    uint64_t random = 6;
    fill_materials(c);
    c->kept_count = 0;
    memset(c->words, 0, sizeof c->words);
    for (uint32_t i = 0; i < PAIRS; ++i) {
        uint32_t *const words = c->words + (size_t)i * c->word_count;
        const bool shows = fill_triangle(c, i, &random) >= LEAST;
        words[0] = (7 * i) % (1u << (3 * DEPTH));
        words[c->word_count - 1] = i;
        memcpy(plain + (size_t)i * c->word_count, words, (size_t)c->word_count * 4);
        if (shows) {
            c->kept[c->kept_count++] = i;
        } else {
            words[c->word_count - 1] = SVO_NO_TRIANGLE;
        }
    }
}

static int compare_numbers(const void *a, const void *b)
{
    const uint32_t x = *(const uint32_t *)a;
    const uint32_t y = *(const uint32_t *)b;
    return x < y ? -1 : x > y ? 1 : 0;
}

/* The places that svo_k_find_places must note, each kind ascending; returns how many of each. */
static uint32_t places_of(const drop_case *c, uint32_t *empty, uint32_t *behind)
{
    uint32_t counts[2] = {0, 0};
    for (uint32_t i = 0; i < PAIRS; ++i) {
        const bool is_dropped = c->words[(size_t)i * c->word_count + c->word_count - 1] == SVO_NO_TRIANGLE;
        if (is_dropped && i < c->kept_count) {
            empty[counts[0]++] = i;
        } else if (!is_dropped && i >= c->kept_count) {
            behind[counts[1]++] = i;
        }
    }
    return counts[0];
}

static svo_status check_places(svo_i_proof *proof, const drop_case *c, cl_mem places)
{
    uint32_t expected[2][PAIRS];
    uint32_t found[ROOM];
    const uint32_t count = places_of(c, expected[0], expected[1]);
    SVO_I_TRY(svo_i_work_read(&proof->work, places, 0, found, sizeof found));
    const uint32_t end = c->params.capacity;
    qsort(found, count, sizeof *found, compare_numbers);
    qsort(found + end - count, count, sizeof *found, compare_numbers);
    return memcmp(found, expected[0], count * sizeof *found) == 0 &&
                   memcmp(found + end - count, expected[1], count * sizeof *found) == 0
               ? SVO_OK
               : svo_i_proof_fail(proof, "svo_k_find_places");
}

/* Each triangle has one pair, whose code follows from it. */
static svo_status check_list(svo_i_proof *proof, const drop_case *c, cl_mem fragments)
{
    uint32_t words[ROOM * SVO_FRAGMENT_WORDS_48];
    uint32_t triangles[PAIRS];
    SVO_I_TRY(svo_i_work_read(&proof->work, fragments, 0, words, (size_t)ROOM * c->word_count * 4));
    bool right = true;
    for (uint32_t i = 0; i < c->kept_count; ++i) {
        triangles[i] = words[(size_t)i * c->word_count + c->word_count - 1];
        right = right && words[(size_t)i * c->word_count] == (7 * triangles[i]) % (1u << (3 * DEPTH));
    }
    qsort(triangles, c->kept_count, sizeof *triangles, compare_numbers);
    return right && memcmp(triangles, c->kept, c->kept_count * sizeof *triangles) == 0
               ? SVO_OK
               : svo_i_proof_fail(proof, "svo_k_move_pairs");
}

typedef struct drop_buffers {
    cl_mem vertices, remainders, indices, records, colors, normals, uvs, materials, texels;
    cl_mem fragments, counters, tally, places;
} drop_buffers;

static svo_status put_buffers(svo_i_proof *proof, const drop_case *c, const uint32_t *plain, drop_buffers *b)
{
    static const uint32_t zeros[ROOM] = {0};
    svo_i_device_work *work = &proof->work;
    SVO_I_TRY(svo_i_work_constants(work, "proof", c->indices, sizeof c->indices, &b->indices));
    SVO_I_TRY(svo_i_work_constants(work, "proof", c->records, sizeof c->records, &b->records));
    SVO_I_TRY(svo_i_work_constants(work, "proof", c->colors, sizeof c->colors, &b->colors));
    SVO_I_TRY(svo_i_work_constants(work, "proof", c->uvs, sizeof c->uvs, &b->uvs));
    SVO_I_TRY(svo_i_work_constants(work, "proof", c->materials, sizeof c->materials, &b->materials));
    SVO_I_TRY(svo_i_work_constants(work, "proof", c->texels, sizeof c->texels, &b->texels));
    SVO_I_TRY(svo_i_proof_buffer(proof, plain, (size_t)ROOM * c->word_count * 4, &b->fragments));
    SVO_I_TRY(svo_i_proof_buffer(proof, c->counters, sizeof c->counters, &b->counters));
    SVO_I_TRY(svo_i_proof_buffer(proof, zeros, sizeof c->tally, &b->tally));
    return svo_i_proof_buffer(proof, zeros, sizeof zeros, &b->places);
}

static void free_buffers(svo_i_proof *proof, drop_buffers *b)
{
    cl_mem *all[] = {&b->places,    &b->tally, &b->counters, &b->fragments, &b->texels,
                     &b->materials, &b->uvs,   &b->colors,   &b->records,   &b->indices};
    for (unsigned i = 0; i < sizeof all / sizeof all[0]; ++i) {
        svo_i_work_free(&proof->work, all[i]);
    }
}

static svo_status launch_drop(svo_i_proof *proof, const drop_case *c, const drop_buffers *b)
{
    const svo_i_argument arguments[] = {
        SVO_I_ARGUMENT(b->fragments), SVO_I_ARGUMENT(b->vertices), SVO_I_ARGUMENT(b->remainders),
        SVO_I_ARGUMENT(b->indices),   SVO_I_ARGUMENT(b->records),  SVO_I_ARGUMENT(b->colors),
        SVO_I_ARGUMENT(b->normals),   SVO_I_ARGUMENT(b->uvs),      SVO_I_ARGUMENT(b->materials),
        SVO_I_ARGUMENT(b->texels),    SVO_I_ARGUMENT(b->counters), SVO_I_ARGUMENT(b->tally),
        SVO_I_ARGUMENT(c->params)};
    return svo_i_work_launch(&proof->work, "svo_k_drop_pairs", SVO_I_ARGUMENTS(arguments), c->params.capacity);
}

/* Launches the kernels one after the other; a chunk that does not fit stays as it is. */
static svo_status prove_chunk(svo_i_proof *proof, const drop_case *c, const uint32_t *plain, const drop_buffers *b)
{
    static const uint32_t nothing[3] = {0};
    svo_i_device_work *work = &proof->work;
    const bool fits = b->counters == NULL || c->counters[0] <= c->params.capacity;
    const size_t bytes = (size_t)ROOM * c->word_count * 4;
    const uint32_t after[SVO_COUNTER_WORDS] = {fits ? c->kept_count : c->counters[0], 0,
                                               fits ? c->tally[0] : c->counters[2], 0};
    const svo_i_argument moves[] = {SVO_I_ARGUMENT(b->fragments), SVO_I_ARGUMENT(b->counters), SVO_I_ARGUMENT(b->tally),
                                    SVO_I_ARGUMENT(b->places), SVO_I_ARGUMENT(c->params)};
    SVO_I_TRY(launch_drop(proof, c, b));
    SVO_I_TRY(svo_i_proof_expect(proof, "svo_k_drop_pairs", b->fragments, fits ? c->words : plain, bytes));
    SVO_I_TRY(svo_i_proof_expect(proof, "svo_k_drop_pairs", b->tally, fits ? c->tally : nothing, sizeof c->tally));
    SVO_I_TRY(svo_i_work_launch(work, "svo_k_find_places", SVO_I_ARGUMENTS(moves), c->params.capacity));
    SVO_I_TRY(fits ? check_places(proof, c, b->places) : SVO_OK);
    SVO_I_TRY(svo_i_work_launch(work, "svo_k_move_pairs", SVO_I_ARGUMENTS(moves), c->params.capacity / 2 + 1));
    SVO_I_TRY(fits ? check_list(proof, c, b->fragments)
                   : svo_i_proof_expect(proof, "svo_k_move_pairs", b->fragments, plain, bytes));
    return b->counters != NULL ? svo_i_proof_expect(proof, "svo_k_move_pairs", b->counters, after, sizeof after)
                               : SVO_OK;
}

/* has_counters: the device alone knows the count. capacity: of the chunk. */
static svo_status prove_case(svo_i_proof *proof, drop_case *c, bool has_counters, uint32_t capacity)
{
    uint32_t plain[ROOM * SVO_FRAGMENT_WORDS_48] = {0};
    drop_buffers b = {.counters = NULL};
    fill_drop(c, plain);
    c->params =
        (svo_drop_params){.capacity = capacity, .least_alpha = LEAST, .triangle_count = TRIANGLES, .depth = DEPTH};
    memcpy(c->counters, (const uint32_t[]){PAIRS, 0, 3, 0}, sizeof c->counters);
    c->tally[0] = PAIRS - c->kept_count;
    SVO_I_TRY(put_buffers(proof, c, plain, &b));
    drop_buffers given = b;
    given.counters = has_counters ? b.counters : NULL;
    given.colors = c->has_colors ? b.colors : NULL;
    given.texels = c->has_texels ? b.texels : NULL;
    SVO_I_TRY(prove_chunk(proof, c, plain, &given));
    free_buffers(proof, &b);
    return SVO_OK;
}

static svo_status prove_drop(svo_i_proof *proof, void *memory)
{
    drop_case *c = memory;
    c->word_count = svo_i_proof_defines(proof, "SVO_CODE48") ? SVO_FRAGMENT_WORDS_48 : SVO_FRAGMENT_WORDS_30;
    c->has_colors = svo_i_proof_defines(proof, "SVO_VERTEX_COLOR");
    c->has_texels = svo_i_proof_defines(proof, "SVO_TEXTURE");
    SVO_I_TRY(prove_case(proof, c, false, PAIRS));
    SVO_I_TRY(prove_case(proof, c, true, ROOM));
    return prove_case(proof, c, true, PAIRS - 1);
}

svo_status svo_i_prove_drop(svo_device *device, const char *function, const svo_i_program_entry *made,
                            const char **wrong)
{
    return svo_i_proof_run(device, function, made, wrong, sizeof(drop_case), prove_drop);
}
