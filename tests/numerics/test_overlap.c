/* SPDX-License-Identifier: MIT */
/*
 * T4 pairs, on the shared source itself: one definition of "touches" for C, OpenCL C and GLSL. The three agree bit for
 * bit with each other, and they agree with the exact references.
 *
 * The tests run kernels/shared/integer.clh and overlap.clh in each language on thousands of random and hard records, in
 * all three widths and in half-open, closed and thin coverage. agree/sample.h generates the records, agree/probe.clh
 * runs the functions. GLSL runs twice: with the language's 64-bit integers and with pairs of 32-bit words. Only the
 * spans may differ, since float arithmetic estimates them: they must contain every voxel that the integers accept.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "numerics/agree/probe.h"
#include "numerics/agree/sample.h"
#include "predicate.h"
#include "support/machine.h"
#include "support/suite.h"

enum { RECORDS = 16384, TEXT_BYTES = 400 };

#define SEED UINT64_C(20240229)

#define DEFINE_INT64 "#extension GL_ARB_gpu_shader_int64 : require\n#define SVO_INT64\n"

/* A variant of the shared source, with its records and the results of C. */
typedef struct variant {
    const char *name;
    const char *options; /* OpenCL C */
    const char *prologue; /* GLSL */
    probe_function *in_c;
    probe_column_function *column; /* overlap variants only */
    sample_width width;
    bool thin;
    sample *samples;
    probe_input *given;
    probe_output *expected;
} variant;

static variant variants[] = {
    {.name = "narrow",
     .options = "-cl-std=CL1.2 -DSVO_NARROW",
     .prologue = "#define SVO_NARROW\n",
     .in_c = probe_narrow,
     .column = probe_column_narrow,
     .width = SAMPLE_NARROW},
    {.name = "regular",
     .options = "-cl-std=CL1.2",
     .prologue = "",
     .in_c = probe_regular,
     .column = probe_column_regular,
     .width = SAMPLE_REGULAR},
    {.name = "wide",
     .options = "-cl-std=CL1.2 -DSVO_WIDE",
     .prologue = "#define SVO_WIDE\n",
     .in_c = probe_wide,
     .column = probe_column_wide,
     .width = SAMPLE_WIDE},
    {.name = "thin narrow",
     .options = "-cl-std=CL1.2 -DSVO_NARROW -DSVO_THIN",
     .prologue = "#define SVO_NARROW\n#define SVO_THIN\n",
     .in_c = probe_thin_narrow,
     .column = probe_column_thin_narrow,
     .width = SAMPLE_NARROW,
     .thin = true},
    {.name = "thin regular",
     .options = "-cl-std=CL1.2 -DSVO_THIN",
     .prologue = "#define SVO_THIN\n",
     .in_c = probe_thin_regular,
     .column = probe_column_thin_regular,
     .width = SAMPLE_REGULAR,
     .thin = true},
    {.name = "thin wide",
     .options = "-cl-std=CL1.2 -DSVO_WIDE -DSVO_THIN",
     .prologue = "#define SVO_WIDE\n#define SVO_THIN\n",
     .in_c = probe_thin_wide,
     .column = probe_column_thin_wide,
     .width = SAMPLE_WIDE,
     .thin = true},
};
enum { VARIANTS = sizeof variants / sizeof variants[0] };

static const char integer_options[] = "-cl-std=CL1.2 -DPROBE_INTEGERS";
static const char integer_prologue[] = "#define PROBE_INTEGERS\n";

static void *allocate(size_t bytes)
{
    void *memory = calloc(1, bytes);
    assert_non_null(memory);
    return memory;
}

static int make_variants(void **state)
{
    (void)state;
    for (size_t i = 0; i < VARIANTS; ++i) {
        variant *v = &variants[i];
        v->samples = allocate(RECORDS * sizeof *v->samples);
        v->given = allocate(RECORDS * sizeof *v->given);
        v->expected = allocate(RECORDS * sizeof *v->expected);
        for (uint32_t record = 0; record < RECORDS; ++record) {
            (v->thin ? sample_make_thin : sample_make)(v->width, SEED, record, &v->samples[record]);
            v->given[record] = v->samples[record].record;
        }
        v->in_c(v->given, v->expected, RECORDS);
    }
    return 0;
}

static int free_variants(void **state)
{
    (void)state;
    for (size_t i = 0; i < VARIANTS; ++i) {
        free(variants[i].samples);
        free(variants[i].given);
        free(variants[i].expected);
    }
    return 0;
}

/* Everything needed to reproduce the record. */
static const char *describe(const variant *v, uint32_t record, char text[TEXT_BYTES])
{
    const int32_t *w = v->given[record].words;
    (void)snprintf(text, TEXT_BYTES,
                   "%s, seed %llu, record %u (%s): triangle (%d %d %d) (%d %d %d) (%d %d %d), w %d, open %d, "
                   "box (%d %d %d), last %d",
                   v->name, (unsigned long long)SEED, record, sample_kind_name(v->samples[record].kind), w[0], w[1],
                   w[2], w[3], w[4], w[5], w[6], w[7], w[8], w[9], w[10], w[11], w[12], w[13], w[14]);
    return text;
}

static void c_agrees_with_the_exact_references(void **state)
{
    const variant *v = *state;
    char text[TEXT_BYTES];
    unsigned touched[SAMPLE_KINDS] = {0};
    for (uint32_t i = 0; i < RECORDS; ++i) {
        const sample *s = &v->samples[i];
        const bool first = v->thin ? oracle_thin_by_extents(&s->triangle, &s->box)
                                   : oracle_sat_touches(&s->triangle, &s->box, s->coverage);
        const bool second = v->thin ? oracle_thin_by_vertices(&s->triangle, &s->box)
                                    : oracle_clip_touches(&s->triangle, &s->box, s->coverage);
        if (sample_is_wrong(s, &v->expected[i], first) || first != second) {
            fail_msg("%s: C %d and %d, references %d and %d", describe(v, i, text), v->expected[i].words[PROBE_COLUMN],
                     v->expected[i].words[PROBE_VOXEL], first, second);
        }
        /* Thin is a subset of half-open, which is a subset of closed. */
        const bool half_open = oracle_sat_touches(&s->triangle, &s->box, ORACLE_HALF_OPEN);
        if ((v->thin && first && !half_open) ||
            (half_open && !oracle_sat_touches(&s->triangle, &s->box, ORACLE_CLOSED))) {
            fail_msg("%s: coverages do not nest", describe(v, i, text));
        }
        touched[s->kind] += first;
    }
    /* The records are not trivial: each kind has many hits and misses (a point meets all voxels of its bounds). */
    const unsigned kind_count = RECORDS / SAMPLE_KINDS;
    for (int kind = 0; kind < SAMPLE_KINDS; ++kind) {
        const unsigned most = kind == SAMPLE_POINT ? kind_count : kind_count - kind_count / 64;
        if (touched[kind] < kind_count / 64 || touched[kind] > most) {
            fail_msg("%s, %s: %u of %u records touch", v->name, sample_kind_name((sample_kind)kind), touched[kind],
                     kind_count);
        }
    }
}

/* Every voxel of the record's column that meets the triangle lies in the span, wherever the library uses spans. */
static void check_span(const variant *v, uint32_t record, const probe_output *found, const char *language)
{
    if (!v->samples[record].axis_is_longest) {
        return;
    }
    SVO_I32 first;
    SVO_I32 last;
    SVO_I32 decided;
    v->column(&v->given[record], &first, &last, &decided);
    const int32_t *span = found->words + PROBE_SPAN;
    const bool inside_column = span[0] >= 0 && span[1] <= v->given[record].words[14];
    if (!inside_column || (first <= last && (span[0] > first || span[1] < last))) {
        char text[TEXT_BYTES];
        fail_msg("%s: voxels %d .. %d meet, the span of %s is %d .. %d", describe(v, record, text), first, last,
                 language, span[0], span[1]);
    }
}

static void compare_answers(const variant *v, const probe_output *found, const char *language)
{
    char text[TEXT_BYTES];
    for (uint32_t i = 0; i < RECORDS; ++i) {
        for (int word = 0; word < PROBE_SPAN; ++word) {
            if (found[i].words[word] != v->expected[i].words[word]) {
                fail_msg("%s: word %d (see agree/probe.clh) is %d in C, %d in %s", describe(v, i, text), word,
                         v->expected[i].words[word], found[i].words[word], language);
            }
        }
        check_span(v, i, &found[i], language);
    }
}

static void spans_of_c_contain_the_touched_voxels(void **state)
{
    const variant *v = *state;
    compare_answers(v, v->expected, "C");
}

static machine_job job_of(const probe_input *given, probe_output *found, uint32_t record_count)
{
    return (machine_job){.input = given,
                         .input_bytes = record_count * sizeof *given,
                         .output = found,
                         .output_bytes = record_count * sizeof *found,
                         .item_count = record_count};
}

static void opencl_agrees_with_c(void **state)
{
    const variant *v = *state;
    svo_device *device = machine_device_or_skip();
    probe_output *found = allocate(RECORDS * sizeof *found);
    const machine_job job = job_of(v->given, found, RECORDS);
    machine_run_kernel(device, probe_source_cl, v->options, "probe_all", &job);
    compare_answers(v, found, "OpenCL C");
    free(found);
    svo_device_destroy(&device);
}

/* Opens a context; skips the test if int64 is set and the context has no 64-bit integers. */
static svo_gl_context *context_or_skip(bool int64)
{
    svo_gl_context *context = machine_any_context_or_skip();
    if (int64 && !svo_i_gl_has_extension(svo_i_gl_context_functions(context), "GL_ARB_gpu_shader_int64")) {
        svo_gl_context_destroy(&context);
        print_message("skipped: the context has no GL_ARB_gpu_shader_int64\n");
        skip();
    }
    return context;
}

static void run_shader(svo_gl_context *context, bool int64, const char *defines, const machine_job *job)
{
    char prologue[200];
    (void)snprintf(prologue, sizeof prologue, "%s%s", int64 ? DEFINE_INT64 : "", defines);
    machine_run_shader(context, prologue, probe_source_gl, job);
}

static void check_glsl(const variant *v, bool int64)
{
    svo_gl_context *context = context_or_skip(int64);
    probe_output *found = allocate(RECORDS * sizeof *found);
    const machine_job job = job_of(v->given, found, RECORDS);
    run_shader(context, int64, v->prologue, &job);
    compare_answers(v, found, int64 ? "GLSL with int64" : "GLSL with two words");
    free(found);
    svo_gl_context_destroy(&context);
}

static void glsl_with_int64_agrees_with_c(void **state)
{
    check_glsl(*state, true);
}

static void glsl_with_two_words_agrees_with_c(void **state)
{
    check_glsl(*state, false);
}

/*
 * The integer operations themselves. The expected results are computed here in 128-bit and unsigned arithmetic.
 */

static int64_t from_words(const int32_t *words)
{
    const uint64_t bits = (uint64_t)(uint32_t)words[1] << 32 | (uint32_t)words[0];
    return bits <= INT64_MAX ? (int64_t)bits : -(int64_t)(UINT64_MAX - bits) - 1;
}

static void to_words(uint64_t bits, int32_t *words)
{
    const uint32_t halves[2] = {(uint32_t)bits, (uint32_t)(bits >> 32)};
    memcpy(words, halves, sizeof halves);
}

/* An extreme value, the neighbor of a power of two, or a random number of random length. */
static int64_t random_integer(uint64_t *random)
{
    static const int64_t edges[] = {0, 1, -1, INT64_MAX, INT64_MIN, INT64_MIN + 1};
    const uint64_t bits = sample_random(random);
    const unsigned length = (unsigned)(bits >> 8) % 63;
    int64_t value;
    if (bits % 4 == 0) {
        value = edges[(bits >> 16) % (sizeof edges / sizeof edges[0])];
    } else if (bits % 4 == 1) {
        value = (INT64_C(1) << length) - 1 + (int64_t)((bits >> 16) % 3);
    } else {
        value = (int64_t)(sample_random(random) >> 1 >> length);
    }
    return (bits & 0x40) != 0 && value != INT64_MIN ? -value : value;
}

static int32_t low_word(int64_t value)
{
    int32_t words[2];
    to_words((uint64_t)value, words);
    return words[0];
}

/* Whether the operations on a and b fit into 64 bits; only GLSL defines overflow. */
static bool sum_fits(int64_t a, int64_t b)
{
    int64_t ignored;
    return a != INT64_MIN && !__builtin_add_overflow(a, b, &ignored) && !__builtin_sub_overflow(a, b, &ignored);
}

static void make_integers(uint64_t *random, bool fitting, probe_input *out)
{
    int64_t a = random_integer(random);
    int64_t b = random_integer(random);
    int64_t m = random_integer(random);
    int64_t n = random_integer(random);
    int64_t ignored;
    while (fitting && !sum_fits(a, b)) {
        a = random_integer(random);
        b = random_integer(random);
    }
    while (fitting && __builtin_mul_overflow(m, n, &ignored)) {
        m = random_integer(random);
        n = random_integer(random);
    }
    *out = (probe_input){{0}};
    to_words((uint64_t)a, out->words);
    to_words((uint64_t)b, out->words + 2);
    to_words((uint64_t)m, out->words + 4);
    to_words((uint64_t)n, out->words + 6);
    out->words[8] = low_word(random_integer(random));
    out->words[9] = low_word(random_integer(random));
}

static void expect_integers(const probe_input *given, probe_output *out)
{
    const int64_t a = from_words(given->words);
    const uint64_t b = (uint64_t)from_words(given->words + 2);
    const uint64_t m = (uint64_t)from_words(given->words + 4);
    const uint64_t n = (uint64_t)from_words(given->words + 6);
    const int64_t p = given->words[8];
    const int64_t q = given->words[9];
    const int64_t unit = INT64_C(1) << 31;
    const int64_t low = (int64_t)((uint64_t)a % (uint64_t)unit);
    const int64_t high = a / unit - (a % unit < 0);
    *out = (probe_output){{0}};
    to_words((uint64_t)a + b, out->words + PROBE_ADD);
    to_words((uint64_t)a - b, out->words + PROBE_SUB);
    to_words(0 - (uint64_t)a, out->words + PROBE_NEG);
    to_words((uint64_t)(p * q), out->words + PROBE_MUL32);
    to_words(m * n, out->words + PROBE_MUL);
    to_words((uint64_t)high, out->words + PROBE_SHR31);
    to_words((uint64_t)low, out->words + PROBE_LOW31);
    to_words((uint64_t)p, out->words + PROBE_I64);
    out->words[PROBE_NOT_NEGATIVE] = a >= 0;
    out->words[PROBE_POSITIVE] = a > 0;
}

/* Two roundings of a float add up to at most 2^-23. */
static void check_float(const char *language, int64_t a, int32_t bits)
{
    float found;
    memcpy(&found, &bits, sizeof found);
    if (!(fabs((double)found - (double)a) <= fabs((double)a) * 0x1p-22)) {
        fail_msg("SVO_TO_F32(%lld) is %.9g in %s", (long long)a, (double)found, language);
    }
}

static void check_integers(const probe_input *given, const probe_output *found, const char *language)
{
    for (uint32_t i = 0; i < RECORDS; ++i) {
        const int32_t *w = given[i].words;
        probe_output expected;
        expect_integers(&given[i], &expected);
        for (int word = 0; word < PROBE_F32; ++word) {
            if (found[i].words[word] != expected.words[word]) {
                fail_msg("seed %llu, record %u: a %lld, b %lld, m %lld, n %lld, p %d, q %d: word %d (see "
                         "agree/probe.clh) is %d, in %s %d",
                         (unsigned long long)SEED, i, (long long)from_words(w), (long long)from_words(w + 2),
                         (long long)from_words(w + 4), (long long)from_words(w + 6), w[8], w[9], word,
                         expected.words[word], language, found[i].words[word]);
            }
        }
        check_float(language, from_words(w), found[i].words[PROBE_F32]);
    }
}

/* Records for the integer operations and memory for the results. */
typedef struct integer_records {
    probe_input *given;
    probe_output *found;
} integer_records;

static integer_records make_integer_records(bool fitting)
{
    uint64_t random = SEED;
    integer_records r = {.given = allocate(RECORDS * sizeof *r.given), .found = allocate(RECORDS * sizeof *r.found)};
    for (uint32_t i = 0; i < RECORDS; ++i) {
        make_integers(&random, fitting, &r.given[i]);
    }
    return r;
}

static void free_integer_records(integer_records *r)
{
    free(r->given);
    free(r->found);
}

static void integers_in_c(void **state)
{
    (void)state;
    integer_records r = make_integer_records(true);
    probe_integers(r.given, r.found, RECORDS);
    check_integers(r.given, r.found, "C");
    free_integer_records(&r);
}

static void integers_in_opencl(void **state)
{
    (void)state;
    svo_device *device = machine_device_or_skip();
    integer_records r = make_integer_records(true);
    const machine_job job = job_of(r.given, r.found, RECORDS);
    machine_run_kernel(device, probe_source_cl, integer_options, "probe_all", &job);
    check_integers(r.given, r.found, "OpenCL C");
    free_integer_records(&r);
    svo_device_destroy(&device);
}

/* GLSL defines what happens on overflow: the same bits with either kind of integers. */
static void check_integers_in_glsl(bool int64)
{
    svo_gl_context *context = context_or_skip(int64);
    for (int fitting = 0; fitting < 2; ++fitting) {
        integer_records r = make_integer_records(fitting != 0);
        const machine_job job = job_of(r.given, r.found, RECORDS);
        run_shader(context, int64, integer_prologue, &job);
        check_integers(r.given, r.found, int64 ? "GLSL with int64" : "GLSL with two words");
        free_integer_records(&r);
    }
    svo_gl_context_destroy(&context);
}

static void integers_in_glsl_with_int64(void **state)
{
    (void)state;
    check_integers_in_glsl(true);
}

static void integers_in_glsl_with_two_words(void **state)
{
    (void)state;
    check_integers_in_glsl(false);
}

#define VARIANT_TESTS(i)                                                                \
    cmocka_unit_test_prestate(c_agrees_with_the_exact_references, &variants[i]),        \
        cmocka_unit_test_prestate(spans_of_c_contain_the_touched_voxels, &variants[i]), \
        cmocka_unit_test_prestate(opencl_agrees_with_c, &variants[i]),                  \
        cmocka_unit_test_prestate(glsl_with_int64_agrees_with_c, &variants[i]),         \
        cmocka_unit_test_prestate(glsl_with_two_words_agrees_with_c, &variants[i])

TEST_GROUP(overlap)
{
    const struct CMUnitTest tests[] = {
        VARIANT_TESTS(0),
        VARIANT_TESTS(1),
        VARIANT_TESTS(2),
        VARIANT_TESTS(3),
        VARIANT_TESTS(4),
        VARIANT_TESTS(5),
        cmocka_unit_test(integers_in_c),
        cmocka_unit_test(integers_in_opencl),
        cmocka_unit_test(integers_in_glsl_with_int64),
        cmocka_unit_test(integers_in_glsl_with_two_words),
    };
    return cmocka_run_group_tests_name("overlap", tests, make_variants, free_variants);
}
