/* SPDX-License-Identifier: MIT */
/* Known answers of kernels: buffers and comparisons for proofs; scans and arithmetic, which many programs have. */
#include "core/proof.h"

#include <math.h>
#include <string.h>

#include "shared/layout.h"

svo_status svo_i_proof_run(svo_device *device, const char *function, const svo_i_program_entry *made,
                           const char **wrong, size_t memory_bytes, svo_i_proof_steps *steps)
{
    svo_i_proof proof = {.defines = made->defines, .wrong = wrong};
    void *memory = NULL;
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_i_work_begin(device, function, NULL, &proof.work));
    proof.work.program = made->program;
    SVO_I_TRY_CLEANUP(svo_i_proof_alloc(&proof, memory_bytes, &memory));
    SVO_I_TRY_CLEANUP(steps(&proof, memory));
cleanup:
    svo_i_work_end(&proof.work);
    svo_i_free(memory);
    return status;
}

bool svo_i_proof_defines(const svo_i_proof *proof, const char *define)
{
    static const char option[] = " -D";
    const size_t length = strlen(define);
    const char *at = proof->defines;
    while ((at = strstr(at, option)) != NULL) {
        at += sizeof option - 1;
        if (strncmp(at, define, length) == 0 && (at[length] == ' ' || at[length] == '\0')) {
            return true;
        }
    }
    return false;
}

svo_status svo_i_proof_buffer(svo_i_proof *proof, const void *content, size_t bytes, cl_mem *out)
{
    SVO_I_TRY(svo_i_work_alloc(&proof->work, "proof", bytes, out));
    return svo_i_work_write(&proof->work, *out, content, bytes);
}

/* PoCL (3.1, lib/CL/devices/common.c) compiles for grids below 65536 work-items, and for any grid where one is larger;
   what it has for a larger grid it uses for a smaller one. */
#define LARGE_ITEMS 65536

svo_status svo_i_proof_launch(svo_i_proof *proof, const char *kernel, const svo_i_argument *arguments,
                              cl_uint argument_count, uint64_t elements)
{
    const bool is_small = proof->work.device->cpu_path && elements < LARGE_ITEMS;
    return svo_i_work_launch(&proof->work, kernel, arguments, argument_count, is_small ? LARGE_ITEMS : elements);
}

svo_status svo_i_proof_fail(svo_i_proof *proof, const char *kernel)
{
    *proof->wrong = kernel;
    return SVO_DEVICE_UNRELIABLE;
}

svo_status svo_i_proof_alloc(svo_i_proof *proof, size_t bytes, void **out)
{
    *out = svo_i_alloc_zeroed(&proof->work.device->memory, 1, bytes);
    if (*out == NULL) {
        (void)svo_i_device_fail(proof->work.device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory to test kernels with",
                                proof->work.function);
        return SVO_OUT_OF_HOST_MEMORY;
    }
    return SVO_OK;
}

svo_status svo_i_proof_expect(svo_i_proof *proof, const char *kernel, cl_mem buffer, const void *expected, size_t bytes)
{
    void *found = NULL;
    SVO_I_TRY(svo_i_proof_alloc(proof, bytes, &found));
    svo_status status = svo_i_work_read(&proof->work, buffer, 0, found, bytes);
    if (status == SVO_OK && memcmp(found, expected, bytes) != 0) {
        status = svo_i_proof_fail(proof, kernel);
    }
    svo_i_free(found);
    return status;
}

/* By Steele, Lea and Flood, "Fast Splittable Pseudorandom Number Generators", 2014. */
uint64_t svo_i_proof_next(uint64_t *state)
{
    uint64_t x = *state += UINT64_C(0x9e3779b97f4a7c15);
    x = (x ^ x >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    x = (x ^ x >> 27) * UINT64_C(0x94d049bb133111eb);
    return x ^ x >> 31;
}

/* ---- scans ---- */

/* Five tiles, among groups of two tiles, and among more groups than a group has work-items, most of which have none. */
#define NUMBERS     (4 * SVO_SCAN_TILE + 77)
#define TILES       5
#define GROUPS_MOST (SVO_GROUP_ITEMS + 3)
#define DEPTH       1 /* of a tree whose leaves the numbers are of */

typedef struct scan_case {
    uint32_t numbers[NUMBERS];
    uint32_t sums[NUMBERS + 1];
    uint32_t group_sums[GROUPS_MOST];
    svo_build_state state;
} scan_case;

/* The sums come close to 2^32. */
static void fill_scan(scan_case *c)
{
    uint64_t random = 1;
    for (uint32_t i = 0; i < NUMBERS; ++i) {
        const uint64_t x = svo_i_proof_next(&random);
        c->numbers[i] = x % 5 == 0 ? 0 : (uint32_t)(x >> 44);
        c->sums[i + 1] = c->sums[i] + c->numbers[i];
    }
    c->state.level_begin[DEPTH] = 1;
    c->state.level_begin[DEPTH + 1] = 1 + NUMBERS;
}

static void sum_groups(scan_case *c, uint32_t groups)
{
    const uint32_t numbers = (TILES + groups - 1) / groups * SVO_SCAN_TILE;
    for (uint32_t group = 0; group < groups; ++group) {
        const uint64_t begin = (uint64_t)group * numbers < NUMBERS ? (uint64_t)group * numbers : NUMBERS;
        const uint64_t end = begin + numbers < NUMBERS ? begin + numbers : NUMBERS;
        c->group_sums[group] = c->sums[end] - c->sums[begin];
    }
}

static svo_status prove_groups(svo_i_proof *proof, scan_case *c, cl_mem numbers, cl_mem state, uint32_t groups)
{
    static const char reduces[] = "svo_k_scan_lists_reduce";
    static const char adds[] = "svo_k_scan_lists_add";
    const svo_filter_params params = {.depth = DEPTH, .leaf_count = NUMBERS};
    const svo_i_argument scratch = SVO_I_LOCAL(SVO_GROUP_ITEMS * sizeof(cl_uint));
    cl_mem partials = NULL;
    cl_mem sums = NULL;
    sum_groups(c, groups);
    SVO_I_TRY(svo_i_work_alloc(&proof->work, "proof", groups * sizeof(cl_uint), &partials));
    SVO_I_TRY(svo_i_work_alloc(&proof->work, "proof", sizeof c->sums, &sums));
    const svo_i_argument reduce[] = {SVO_I_ARGUMENT(numbers), SVO_I_ARGUMENT(partials), SVO_I_ARGUMENT(state),
                                     SVO_I_ARGUMENT(params), scratch};
    const svo_i_argument add[] = {SVO_I_ARGUMENT(numbers), SVO_I_ARGUMENT(partials), SVO_I_ARGUMENT(sums),
                                  SVO_I_ARGUMENT(state),   SVO_I_ARGUMENT(params),   scratch};
    SVO_I_TRY(svo_i_work_launch(&proof->work, reduces, SVO_I_ARGUMENTS(reduce), (uint64_t)groups * SVO_GROUP_ITEMS));
    SVO_I_TRY(svo_i_proof_expect(proof, reduces, partials, c->group_sums, groups * sizeof(cl_uint)));
    SVO_I_TRY(svo_i_work_launch(&proof->work, adds, SVO_I_ARGUMENTS(add), (uint64_t)groups * SVO_GROUP_ITEMS));
    return svo_i_proof_expect(proof, adds, sums, c->sums, sizeof c->sums);
}

static svo_status prove_case(svo_i_proof *proof, scan_case *c)
{
    cl_mem numbers = NULL;
    cl_mem state = NULL;
    SVO_I_TRY(svo_i_work_constants(&proof->work, "proof", c->numbers, sizeof c->numbers, &numbers));
    SVO_I_TRY(svo_i_work_constants(&proof->work, "proof", &c->state, sizeof c->state, &state));
    SVO_I_TRY(prove_groups(proof, c, numbers, state, 3));
    return prove_groups(proof, c, numbers, state, GROUPS_MOST);
}

svo_status svo_i_prove_scans(svo_i_proof *proof)
{
    void *memory = NULL;
    SVO_I_TRY(svo_i_proof_alloc(proof, sizeof(scan_case), &memory));
    fill_scan(memory);
    const svo_status status = prove_case(proof, memory);
    svo_i_free(memory);
    return status;
}

/* ---- arithmetic ---- */

#define FACTORS (SVO_GROUP_ITEMS + 3) /* of four each */

typedef struct arithmetic_case {
    float factors[FACTORS * 4];
    uint32_t expected[FACTORS * SVO_ARITHMETIC_WORDS], found[FACTORS * SVO_ARITHMETIC_WORDS];
} arithmetic_case;

static uint32_t word_of(float x)
{
    uint32_t word = 0;
    memcpy(&word, &x, sizeof word);
    return word;
}

/* Products cancel but for what their rounding leaves. The library is compiled without contraction. */
static void expect_rounded(const float *f, uint32_t *to)
{
    const double a = (double)f[0];
    const double b = (double)f[1];
    const double c = (double)f[2];
    const double d = (double)f[3];
    const double difference = (a * a) * (b * b) - (c * c) * (d * d);
    uint64_t bits = 0;
    memcpy(&bits, &difference, sizeof bits);
    to[0] = word_of(f[0] * f[1] + f[2]);
    to[1] = word_of(f[0] * f[1] - f[2] * f[3]);
    to[2] = word_of(f[0] / f[1]);
    to[3] = word_of(sqrtf(f[0]));
    to[4] = (uint32_t)bits;
    to[5] = (uint32_t)(bits >> 32);
}

static void fill_arithmetic(arithmetic_case *c)
{
    uint64_t random = 9;
    for (size_t i = 0; i < FACTORS; ++i) {
        float *const f = c->factors + i * 4;
        f[0] = 1.0F + (float)(svo_i_proof_next(&random) >> 41) * 0x1p-23F;
        f[1] = 1.0F + (float)(svo_i_proof_next(&random) >> 41) * 0x1p-23F;
        f[2] = i % 3 == 0 ? -(f[0] * f[1]) : i % 3 == 1 ? f[0] : f[1];
        f[3] = i % 3 == 0 ? 1.0F : i % 3 == 1 ? f[1] : f[0];
        expect_rounded(f, c->expected + i * SVO_ARITHMETIC_WORDS);
    }
}

/* Takes over what was not asked of the device: doubles, quotients and roots. */
static void forgive(const svo_device *device, arithmetic_case *c)
{
    for (uint32_t i = 0; i < FACTORS * SVO_ARITHMETIC_WORDS; ++i) {
        const uint32_t word = i % SVO_ARITHMETIC_WORDS;
        const bool is_quotient = word == 2 || word == 3;
        if (is_quotient ? !device->rounds_quotients : word > 3 && !device->has_fp64) {
            c->expected[i] = c->found[i];
        }
    }
}

static svo_status prove_factors(svo_i_proof *proof, arithmetic_case *c)
{
    static const char kernel[] = "svo_k_arithmetic";
    const cl_uint count = FACTORS;
    cl_mem factors = NULL;
    cl_mem words = NULL;
    fill_arithmetic(c);
    SVO_I_TRY(svo_i_work_constants(&proof->work, "proof", c->factors, sizeof c->factors, &factors));
    SVO_I_TRY(svo_i_work_alloc(&proof->work, "proof", sizeof c->found, &words));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(factors), SVO_I_ARGUMENT(words), SVO_I_ARGUMENT(count)};
    SVO_I_TRY(svo_i_work_launch(&proof->work, kernel, SVO_I_ARGUMENTS(arguments), FACTORS));
    SVO_I_TRY(svo_i_work_read(&proof->work, words, 0, c->found, sizeof c->found));
    forgive(proof->work.device, c);
    return memcmp(c->found, c->expected, sizeof c->found) == 0 ? SVO_OK : svo_i_proof_fail(proof, kernel);
}

svo_status svo_i_prove_rounding(svo_i_proof *proof)
{
    svo_device *device = proof->work.device;
    void *memory = NULL;
    if (device->arithmetic_is_tested) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_proof_alloc(proof, sizeof(arithmetic_case), &memory));
    const svo_status status = prove_factors(proof, memory);
    device->arithmetic_is_tested = status == SVO_OK;
    svo_i_free(memory);
    return status;
}

/* ---- programs ---- */

static svo_status prove_scanner(svo_i_proof *proof, void *memory)
{
    (void)memory;
    return svo_i_prove_scans(proof);
}

static svo_status prove_arithmetic(svo_i_proof *proof, void *memory)
{
    (void)memory;
    return svo_i_prove_rounding(proof);
}

static svo_status prove_both(svo_i_proof *proof, void *memory)
{
    SVO_I_TRY(prove_scanner(proof, memory));
    return prove_arithmetic(proof, memory);
}

svo_status svo_i_prove_scanner(svo_device *device, const char *function, const svo_i_program_entry *made,
                               const char **wrong)
{
    return svo_i_proof_run(device, function, made, wrong, 1, prove_scanner);
}

svo_status svo_i_prove_arithmetic(svo_device *device, const char *function, const svo_i_program_entry *made,
                                  const char **wrong)
{
    return svo_i_proof_run(device, function, made, wrong, 1, prove_arithmetic);
}

svo_status svo_i_prove_scanner_and_arithmetic(svo_device *device, const char *function, const svo_i_program_entry *made,
                                              const char **wrong)
{
    return svo_i_proof_run(device, function, made, wrong, 1, prove_both);
}
