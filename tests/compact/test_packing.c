/* SPDX-License-Identifier: MIT */
/*
 * Packed payload (kernels/shared/packed.clh) on the host: exact arrays come back as they were, others within the error
 * that was asked for, and the head tells the errors that a count of them here finds.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "compact/packing.h"
#include "core/packed.h"
#include "support/meshes.h"
#include "support/suite.h"

#define COUNT_MAX 5000u

typedef enum pattern { EQUAL, RAMP, NOISE, EXTREMES, FEW, ONE_DIFFERS, PATCHES, SHADES, PATTERN_COUNT } pattern;

/* A component of an element, of 8 or 16 bits. */
static uint32_t component_of(pattern of, uint32_t index, uint32_t which, uint32_t most, uint64_t *seed)
{
    switch (of) {
    case EQUAL:
        return (77 + 50 * which) & most;
    case RAMP:
        return (index / 3 + 20 * which) & most;
    case NOISE:
        return (uint32_t)random_below(seed, most + 1);
    case EXTREMES:
        return (index * 7 + which) % 3 == 0 ? 0 : most;
    case FEW:
        return (index * index % 5 * 40 + which) & most;
    case ONE_DIFFERS:
        return index == 700 ? most : 3;
    case PATCHES:
        return (index / 100 * 9001 + which + (uint32_t)random_below(seed, 4)) & most;
    default: /* one color in many shades, with a little noise */
        return index * 37 % 101 * (2 + which) / 4 + (uint32_t)random_below(seed, 3);
    }
}

static uint32_t components_of(svo_compact_buffer buffer)
{
    return buffer == SVO_COMPACT_COLORS ? 4 : buffer == SVO_COMPACT_NORMALS ? 3 : 1;
}

/* The elements of an array; alpha is 255 but in NOISE and PATCHES. */
static void *make_elements(svo_compact_buffer buffer, pattern of, uint32_t count)
{
    const uint32_t components = components_of(buffer);
    uint64_t seed = 17 + (uint64_t)of;
    uint8_t *bytes = calloc(count, 8);
    uint16_t *halves = (uint16_t *)bytes;
    assert_non_null(bytes);
    for (uint32_t i = 0; i < count; ++i) {
        for (uint32_t c = 0; c < components; ++c) {
            if (buffer == SVO_COMPACT_COLORS) {
                const uint32_t value = component_of(of, i, c, 255, &seed);
                bytes[4 * i + c] = c == 3 && of != NOISE && of != PATCHES ? 255 : (uint8_t)value;
            } else {
                halves[components * i + c] = (uint16_t)component_of(of, i, c, 65535, &seed);
            }
        }
    }
    return bytes;
}

static size_t element_bytes(svo_compact_buffer buffer)
{
    return buffer == SVO_COMPACT_COLORS ? 4 : 2 * components_of(buffer);
}

static uint32_t *pack(const svo_i_packing *what)
{
    svo_message message = {""};
    uint32_t *words = NULL;
    if (svo_i_pack_payload("test", what, NULL, &words, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    return words;
}

/* Whether a reader would take the words. */
static void check_words(uint32_t *words, const svo_i_packing *what)
{
    svo_message message = {""};
    svo_compact compact = {.info = {.payload_count = what->count}};
    compact.host[what->buffer] = words;
    compact.info.bytes[what->buffer] = svo_i_packed_bytes(words);
    if (svo_i_packed_check(&compact, what->buffer, "words", &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
}

static const uint32_t counts[] = {1, 7, 8, 9, 255, 256, 257, 1000, COUNT_MAX};

static void exact_arrays_come_back_as_they_were(void **state)
{
    (void)state;
    for (int k = 0; k < SVO_PAYLOAD_COUNT; ++k) {
        const svo_compact_buffer buffer = (svo_compact_buffer)(SVO_COMPACT_COLORS + k);
        for (int of = 0; of < PATTERN_COUNT; ++of) {
            for (size_t i = 0; i < sizeof counts / sizeof counts[0]; ++i) {
                void *elements = make_elements(buffer, (pattern)of, counts[i]);
                uint8_t *got = calloc(counts[i], 8);
                const svo_i_packing what = {.buffer = buffer, .elements = elements, .count = counts[i]};
                uint32_t *words = pack(&what);
                assert_non_null(got);
                check_words(words, &what);
                svo_i_packed_read(words, buffer, 0, counts[i], got);
                if (memcmp(elements, got, counts[i] * element_bytes(buffer)) != 0) {
                    fail_msg("%s, pattern %d, %u elements: not as before", svo_name(SVO_NAME_COMPACT_BUFFER, buffer),
                             of, counts[i]);
                }
                assert_int_equal(words[4] | words[5] | words[6], 0);
                free(got);
                free(elements);
                svo_i_free(words);
            }
        }
    }
}

/* The largest difference of a component and the sum of all. */
typedef struct errors {
    uint32_t largest, alpha;
    uint64_t sum;
} errors;

static errors compare(svo_compact_buffer buffer, const void *a, const void *b, uint32_t count)
{
    const uint32_t components = components_of(buffer);
    errors found = {0, 0, 0};
    for (uint32_t i = 0; i < count * components; ++i) {
        const int32_t off = buffer == SVO_COMPACT_COLORS    ? ((const uint8_t *)a)[i] - ((const uint8_t *)b)[i]
                            : buffer == SVO_COMPACT_NORMALS ? ((const int16_t *)a)[i] - ((const int16_t *)b)[i]
                                                            : ((const uint16_t *)a)[i] - ((const uint16_t *)b)[i];
        const uint32_t size = (uint32_t)(off < 0 ? -off : off);
        found.largest = size > found.largest ? size : found.largest;
        found.alpha |= buffer == SVO_COMPACT_COLORS && i % 4 == 3 ? size : 0;
        found.sum += size;
    }
    return found;
}

static void errors_stay_within_what_was_asked(void **state)
{
    static const uint32_t asked[] = {1, 2, 5, 16, 128, 255};
    uint64_t exact_bytes = 0;
    uint64_t lossy_bytes = 0;
    (void)state;
    for (int turn = 0; turn < 2; ++turn) {
        const svo_compact_buffer buffer = turn == 0 ? SVO_COMPACT_COLORS : SVO_COMPACT_FILLS;
        for (int of = 0; of < PATTERN_COUNT; ++of) {
            void *elements = make_elements(buffer, (pattern)of, COUNT_MAX);
            void *got = calloc(COUNT_MAX, 8);
            assert_non_null(got);
            for (size_t i = 0; i < sizeof asked / sizeof asked[0]; ++i) {
                const svo_i_packing what = {
                    .buffer = buffer, .elements = elements, .count = COUNT_MAX, .error = asked[i]};
                const svo_i_packing exact = {.buffer = buffer, .elements = elements, .count = COUNT_MAX};
                uint32_t *words = pack(&what);
                uint32_t *exactly = pack(&exact);
                check_words(words, &what);
                svo_i_packed_read(words, buffer, 0, COUNT_MAX, got);
                const errors found = compare(buffer, elements, got, COUNT_MAX);
                assert_in_range(found.largest, 0, asked[i]);
                assert_int_equal(found.alpha, 0);
                assert_int_equal(words[4], found.largest);
                assert_int_equal((uint64_t)words[6] << 32 | words[5], found.sum);
                assert_true(words[7] <= exactly[7] + 1); /* bits may be spent on smaller errors */
                exact_bytes += turn == 0 && asked[i] >= 5 ? svo_i_packed_bytes(exactly) : 0;
                lossy_bytes += turn == 0 && asked[i] >= 5 ? svo_i_packed_bytes(words) : 0;
                svo_i_free(words);
                svo_i_free(exactly);
            }
            free(got);
            free(elements);
        }
    }
    assert_true(2 * lossy_bytes < exact_bytes);
}

/* Shades of one color with a little noise are a line through the middle of the noise: weights of a few bits, where
   three channels would take more. */
static void shades_are_weights_on_a_line(void **state)
{
    (void)state;
    uint8_t colors[256][4];
    for (int i = 0; i < 256; ++i) {
        const int shade = i * 37 % 256;
        colors[i][0] = (uint8_t)(shade / 2 + 20 + i % 2 * 7);
        colors[i][1] = (uint8_t)(200 - shade / 4);
        colors[i][2] = (uint8_t)shade;
        colors[i][3] = 255;
    }
    const svo_i_packing what = {.buffer = SVO_COMPACT_COLORS, .elements = colors, .count = 256, .error = 9};
    uint32_t *words = pack(&what);
    uint8_t got[256][4];
    /* 14 levels of 19 would do; weights have 15 steps of 17, or for a bit more 31 of 8, with half of the errors. */
    assert_int_equal(words[8], 1);
    assert_int_equal(words[10] >> 14, 4 | 5 << 3);
    assert_int_equal(words[7], 10 + 1 + (48 + 5 * 256 + 31) / 32);
    svo_i_packed_read(words, SVO_COMPACT_COLORS, 0, 256, got);
    assert_in_range(compare(SVO_COMPACT_COLORS, colors, got, 256).largest, 1, 9);
    svo_i_free(words);
}

/* Closed forms: equal elements are a palette of one color for each 256; noise takes its own bits, the least, and the
   directory. */
static void sizes_are_those_of_the_layout(void **state)
{
    (void)state;
    uint64_t seed = 3;
    uint16_t equal[1024];
    uint8_t noise[1024][4];
    for (int i = 0; i < 1024; ++i) {
        equal[i] = 4711;
        for (int c = 0; c < 4; ++c) {
            noise[i][c] = (uint8_t)random_below(&seed, 256);
        }
    }
    const svo_i_packing materials = {.buffer = SVO_COMPACT_MATERIALS, .elements = equal, .count = 1024};
    const svo_i_packing colors = {.buffer = SVO_COMPACT_COLORS, .elements = noise, .count = 1024};
    uint32_t *words = pack(&materials);
    assert_int_equal(words[7], 8 + 4 * (2 + 1 + 1));
    svo_i_free(words);
    words = pack(&colors);
    assert_in_range(words[7], 8 + 4 * 2 + 1000, 8 + 4 * (2 + 1 + 2 + 256));
    svo_i_free(words);
}

/* Equal elements and noise behind them are blocks of their own: a color, and the least with 16 bits each. */
static void blocks_end_where_others_begin(void **state)
{
    (void)state;
    uint64_t seed = 29;
    uint16_t materials[256];
    for (int i = 0; i < 256; ++i) {
        materials[i] = (uint16_t)(i < 128 ? 4711 : random_below(&seed, 65536));
    }
    const svo_i_packing what = {.buffer = SVO_COMPACT_MATERIALS, .elements = materials, .count = 256};
    uint32_t *words = pack(&what);
    assert_int_equal(words[8], 1 | 1u << 16);
    assert_int_equal(words[7], 8 + 2 + 2 + (16 + 16 + 128 * 16) / 32);
    svo_i_free(words);
}

/* ---- octahedral normals ---- */

static void axes_and_nothing_are_exact(void **state)
{
    int16_t normals[7][3] = {{0}};
    int16_t got[7][3];
    (void)state;
    for (int i = 0; i < 6; ++i) {
        normals[i][i / 2] = (int16_t)(i % 2 == 0 ? 32767 : -32767);
    }
    for (uint32_t bits = 4; bits <= 8; ++bits) {
        const svo_i_packing what = {
            .buffer = SVO_COMPACT_NORMALS, .elements = normals, .count = 7, .normal_bits = bits};
        uint32_t *words = pack(&what);
        check_words(words, &what);
        svo_i_packed_read(words, SVO_COMPACT_NORMALS, 0, 7, got);
        assert_memory_equal(normals, got, sizeof got);
        assert_int_equal(words[4], 0);
        svo_i_free(words);
    }
}

/* Directions of all kinds, also shorter ones: a bit more halves the error. One is longer than lengths go. */
static void octahedral_normals_are_near(void **state)
{
    enum { NORMALS = 3000 };
    static int16_t normals[NORMALS][3];
    static int16_t got[NORMALS][3];
    uint64_t seed = 23;
    (void)state;
    for (int i = 0; i < NORMALS; ++i) {
        double part[3];
        double square = 0;
        for (int axis = 0; axis < 3; ++axis) {
            part[axis] = random_unit(&seed) * 2 - 1;
            square += part[axis] * part[axis];
        }
        const double length = (i % 4 == 0 ? random_unit(&seed) : 1.0) * 32767 / sqrt(square + 1e-9);
        for (int axis = 0; axis < 3; ++axis) {
            normals[i][axis] = (int16_t)(part[axis] * length);
        }
    }
    for (int axis = 0; axis < 3; ++axis) {
        normals[1][axis] = INT16_MIN;
    }
    for (uint32_t bits = 4; bits <= 8; ++bits) {
        const svo_i_packing what = {
            .buffer = SVO_COMPACT_NORMALS, .elements = normals, .count = NORMALS, .normal_bits = bits};
        uint32_t *words = pack(&what);
        check_words(words, &what);
        svo_i_packed_read(words, SVO_COMPACT_NORMALS, 0, NORMALS, got);
        const errors all = compare(SVO_COMPACT_NORMALS, normals, got, NORMALS);
        const errors usual = compare(SVO_COMPACT_NORMALS, normals[2], got[2], NORMALS - 2);
        assert_int_equal(words[4], all.largest);
        assert_int_equal((uint64_t)words[6] << 32 | words[5], all.sum);
        /* Half a step of u and v, which the faces' corners stretch by up to sqrt(3), and half one of the length. */
        const double step = 32767.0 / ((1u << (bits - 1)) - 1);
        assert_in_range(usual.largest, 1, (uint32_t)(1.3 * step + 100));
        assert_in_range(usual.sum / (3 * NORMALS), 1, (uint32_t)(0.35 * step + 50));
        svo_i_free(words);
    }
}

TEST_GROUP(packing)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(exact_arrays_come_back_as_they_were), cmocka_unit_test(errors_stay_within_what_was_asked),
        cmocka_unit_test(shades_are_weights_on_a_line),        cmocka_unit_test(sizes_are_those_of_the_layout),
        cmocka_unit_test(blocks_end_where_others_begin),       cmocka_unit_test(axes_and_nothing_are_exact),
        cmocka_unit_test(octahedral_normals_are_near)};
    return cmocka_run_group_tests_name("packing", tests, NULL, NULL);
}
