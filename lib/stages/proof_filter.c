/* SPDX-License-Identifier: MIT */
/*
 * Known answers of the kernels that sum up the payload of nodes (kernels/stages/filter.cl): sums of 64 bits, and means
 * that are rounded half up, of sums that lie at halves and a unit beside them. The host divides 64-bit integers.
 */
#include <string.h>

#include "core/proof.h"
#include "shared/layout.h"
#include "stages/programs.h"

/* More nodes than a group has work-items; from one to eight children each. */
#define NODES        (SVO_GROUP_ITEMS + 3)
#define CHILDREN_MAX (8 * NODES)
#define LEVEL        1 /* of the nodes; the root is above, and their children have payload */
#define FILL_SHIFT   9

typedef struct sums {
    uint64_t weights[CHILDREN_MAX];
    uint64_t colors[CHILDREN_MAX * 4];
    int64_t normals[CHILDREN_MAX * 3];
} sums;

typedef struct filter_case {
    uint8_t masks[1 + NODES];
    uint32_t first_child[1 + NODES];
    uint32_t child_count;
    sums children, nodes;
    uint32_t colors[CHILDREN_MAX]; /* of the children */
    int16_t normals[CHILDREN_MAX * 3];
    uint16_t fills[CHILDREN_MAX];
    svo_build_state state;
    svo_filter_params params;
} filter_case;

/* Buffers of the sums of one level. */
typedef struct sum_buffers {
    cl_mem weights, colors, normals;
} sum_buffers;

/* A weight on either side of where kernels choose between divisions, and up to 2^43. */
static uint64_t weight_of(uint64_t random)
{
    static const unsigned bits[] = {1, 14, 22, 34, 43};
    const uint64_t limit = UINT64_C(1) << bits[random % 5];
    return random % 3 == 0 ? limit : random % 3 == 1 ? limit - 1 : 1 + (random >> 16) % limit;
}

/* What a sum exceeds a multiple of its weight by. */
static uint64_t rest_of(uint64_t weight, uint64_t random)
{
    const uint64_t rests[] = {0, weight / 2, (weight - 1) / 2, weight - 1, (random >> 16) % weight};
    return rests[random % 5];
}

static uint16_t fill_of(uint64_t weight)
{
    const uint64_t fill = ((weight >> (FILL_SHIFT - 1)) + 1) >> 1;
    return (uint16_t)(fill < UINT16_MAX ? fill : UINT16_MAX);
}

static void fill_child(filter_case *c, uint32_t child, uint64_t *random)
{
    const uint64_t weight = weight_of(svo_i_proof_next(random));
    c->children.weights[child] = weight;
    c->fills[child] = fill_of(weight);
    uint64_t by = weight; /* of alpha, then alpha's sum; nothing is seen without */
    for (unsigned k = 4; k-- > 0;) {
        const uint64_t x = svo_i_proof_next(random);
        const uint64_t sum = by > 0 ? (x >> 40) % 255 * by + rest_of(by, x) : 0;
        c->children.colors[(size_t)child * 4 + k] = sum;
        uint32_t mean = by > 0 ? (uint32_t)((2 * sum + by) / (2 * by)) : 0;
        if (k == 3) {
            mean = sum != 0 && mean == 0 ? 1 : sum != 255 * by && mean == 255 ? 254 : mean;
            by = sum;
        }
        c->colors[child] |= mean << 8 * k;
    }
    for (unsigned k = 0; k < 3; ++k) {
        const uint64_t x = svo_i_proof_next(random);
        const int64_t mean = (int64_t)(x >> 40) % 65534 - 32767;
        const int64_t sum = mean * (int64_t)weight + (int64_t)rest_of(weight, x);
        const uint64_t shifted = (uint64_t)(2 * sum + (int64_t)weight + (int64_t)(weight << 16));
        c->children.normals[(size_t)child * 3 + k] = sum;
        c->normals[(size_t)child * 3 + k] = (int16_t)((int64_t)(shifted / (2 * weight)) - 32768);
    }
}

static void add_child(filter_case *c, uint32_t node, uint32_t child)
{
    c->nodes.weights[node] += c->children.weights[child];
    for (unsigned k = 0; k < 4; ++k) {
        c->nodes.colors[(size_t)node * 4 + k] += c->children.colors[(size_t)child * 4 + k];
    }
    for (unsigned k = 0; k < 3; ++k) {
        c->nodes.normals[(size_t)node * 3 + k] += c->children.normals[(size_t)child * 3 + k];
    }
}

static void fill_filter(filter_case *c)
{
    uint64_t random = 5;
    for (uint32_t node = 0; node < NODES; ++node) {
        const uint32_t mask = 1 + (uint32_t)(svo_i_proof_next(&random) % 255);
        c->masks[1 + node] = (uint8_t)mask;
        c->first_child[1 + node] = 1 + NODES + c->child_count;
        for (uint32_t bits = mask; bits != 0; bits &= bits - 1) {
            fill_child(c, c->child_count, &random);
            add_child(c, node, c->child_count++);
        }
    }
    const uint32_t end = 1 + NODES + c->child_count;
    memcpy(c->state.level_begin, (const uint32_t[]){0, 1, 1 + NODES, end, end}, 5 * sizeof(uint32_t));
    c->state.fragment_limit = UINT32_MAX;
    c->params =
        (svo_filter_params){.depth = LEVEL + 2, .level = LEVEL, .payload_level = LEVEL + 1, .fill_shift = FILL_SHIFT};
}

static svo_status alloc_sums(svo_i_proof *proof, uint32_t count, sum_buffers *out)
{
    SVO_I_TRY(svo_i_work_alloc(&proof->work, "proof", (uint64_t)count * 8, &out->weights));
    SVO_I_TRY(svo_i_work_alloc(&proof->work, "proof", (uint64_t)count * 32, &out->colors));
    return svo_i_work_alloc(&proof->work, "proof", (uint64_t)count * 24, &out->normals);
}

static svo_status write_sums(svo_i_proof *proof, const filter_case *c, const sum_buffers *to)
{
    const sums *from = &c->children;
    SVO_I_TRY(svo_i_work_write(&proof->work, to->weights, from->weights, (uint64_t)c->child_count * 8));
    SVO_I_TRY(svo_i_work_write(&proof->work, to->colors, from->colors, (uint64_t)c->child_count * 32));
    return svo_i_work_write(&proof->work, to->normals, from->normals, (uint64_t)c->child_count * 24);
}

/* The payload of the children and the sums of the nodes, of which the program makes what its defines name. */
static svo_status expect_filtered(svo_i_proof *proof, const filter_case *c, const char *kernel,
                                  const sum_buffers *nodes, const cl_mem payload[3])
{
    const size_t children = c->child_count;
    SVO_I_TRY(svo_i_proof_expect(proof, kernel, nodes->weights, c->nodes.weights, (size_t)NODES * 8));
    if (svo_i_proof_defines(proof, "SVO_COLOR")) {
        SVO_I_TRY(svo_i_proof_expect(proof, kernel, nodes->colors, c->nodes.colors, (size_t)NODES * 32));
        SVO_I_TRY(svo_i_proof_expect(proof, kernel, payload[0], c->colors, children * 4));
    }
    if (svo_i_proof_defines(proof, "SVO_NORMAL")) {
        SVO_I_TRY(svo_i_proof_expect(proof, kernel, nodes->normals, c->nodes.normals, (size_t)NODES * 24));
        SVO_I_TRY(svo_i_proof_expect(proof, kernel, payload[1], c->normals, children * 6));
    }
    return svo_i_proof_defines(proof, "SVO_FILL")
               ? svo_i_proof_expect(proof, kernel, payload[2], c->fills, children * 2)
               : SVO_OK;
}

/* per_node: one work-item each; else a group for all. */
static svo_status prove_kernel(svo_i_proof *proof, const filter_case *c, const char *kernel, bool per_node)
{
    svo_i_device_work *work = &proof->work;
    sum_buffers children = {NULL, NULL, NULL};
    sum_buffers nodes = {NULL, NULL, NULL};
    cl_mem payload[3] = {NULL, NULL, NULL};
    cl_mem tree[3] = {NULL, NULL, NULL};
    SVO_I_TRY(svo_i_work_constants(work, "proof", c->masks, sizeof c->masks, &tree[0]));
    SVO_I_TRY(svo_i_work_constants(work, "proof", c->first_child, sizeof c->first_child, &tree[1]));
    SVO_I_TRY(svo_i_work_constants(work, "proof", &c->state, sizeof c->state, &tree[2]));
    SVO_I_TRY(alloc_sums(proof, c->child_count, &children));
    SVO_I_TRY(write_sums(proof, c, &children));
    SVO_I_TRY(alloc_sums(proof, NODES, &nodes));
    SVO_I_TRY(svo_i_work_alloc(work, "proof", sizeof c->colors, &payload[0]));
    SVO_I_TRY(svo_i_work_alloc(work, "proof", sizeof c->normals, &payload[1]));
    SVO_I_TRY(svo_i_work_alloc(work, "proof", sizeof c->fills, &payload[2]));
    const svo_i_argument arguments[] = {
        SVO_I_ARGUMENT(tree[0]),         SVO_I_ARGUMENT(tree[1]),          SVO_I_ARGUMENT(children.weights),
        SVO_I_ARGUMENT(children.colors), SVO_I_ARGUMENT(children.normals), SVO_I_ARGUMENT(nodes.weights),
        SVO_I_ARGUMENT(nodes.colors),    SVO_I_ARGUMENT(nodes.normals),    SVO_I_ARGUMENT(payload[0]),
        SVO_I_ARGUMENT(payload[1]),      SVO_I_ARGUMENT(payload[2]),       SVO_I_ARGUMENT(tree[2]),
        SVO_I_ARGUMENT(c->params)};
    SVO_I_TRY(per_node ? svo_i_proof_launch(proof, kernel, SVO_I_ARGUMENTS(arguments), NODES)
                       : svo_i_work_launch(work, kernel, SVO_I_ARGUMENTS(arguments), SVO_GROUP_ITEMS));
    return expect_filtered(proof, c, kernel, &nodes, payload);
}

/* Programs without payload that goes up have neither kernel. */
static svo_status prove_levels(svo_i_proof *proof, void *memory)
{
    if (!svo_i_proof_defines(proof, "SVO_COLOR") && !svo_i_proof_defines(proof, "SVO_NORMAL") &&
        !svo_i_proof_defines(proof, "SVO_FILL")) {
        return SVO_OK;
    }
    fill_filter(memory);
    SVO_I_TRY(prove_kernel(proof, memory, "svo_k_filter", true));
    return prove_kernel(proof, memory, "svo_k_filter_top", false);
}

svo_status svo_i_prove_filter(svo_device *device, const char *function, const svo_i_program_entry *made,
                              const char **wrong)
{
    return svo_i_proof_run(device, function, made, wrong, sizeof(filter_case), prove_levels);
}
