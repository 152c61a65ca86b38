/* SPDX-License-Identifier: MIT */
/* Sums of nodes above the parts, in 64-bit integers, rounded as the kernels round. */
#include "parts/sums.h"

#include <string.h>

#include "plan/plan_data.h"

#define RUN_SHIFT  48
#define RUN_WEIGHT ((UINT64_C(1) << RUN_SHIFT) - 1)

/* Merges two ascending lists of materials, and adds up the weights of those in both. Returns how many there are. */
static uint32_t merge_runs(const svo_i_part_root *a, const svo_i_part_root *b, uint64_t *out)
{
    uint32_t count = 0;
    uint32_t i = 0;
    uint32_t k = 0;
    while (i < a->run_count || k < b->run_count) {
        const uint64_t first = i < a->run_count ? a->runs[i] >> RUN_SHIFT : UINT64_MAX;
        const uint64_t second = k < b->run_count ? b->runs[k] >> RUN_SHIFT : UINT64_MAX;
        const uint64_t weights =
            (first <= second ? a->runs[i] & RUN_WEIGHT : 0) + (second <= first ? b->runs[k] & RUN_WEIGHT : 0);
        out[count++] = (first <= second ? first : second) << RUN_SHIFT | weights;
        i += first <= second ? 1u : 0u;
        k += second <= first ? 1u : 0u;
    }
    return count;
}

bool svo_i_part_join(svo_i_part_root *to, const svo_i_part_root *from)
{
    to->sums.weight += from->sums.weight;
    for (unsigned i = 0; i < 4; ++i) {
        to->sums.color[i] += from->sums.color[i];
    }
    for (unsigned i = 0; i < 3; ++i) {
        to->sums.normal[i] += from->sums.normal[i];
    }
    if (from->run_count == 0) {
        return true;
    }
    uint64_t *merged = svo_i_alloc(NULL, ((size_t)to->run_count + from->run_count) * sizeof *merged);
    if (merged == NULL) {
        return false;
    }
    const uint32_t count = merge_runs(to, from, merged);
    svo_i_free(to->runs);
    to->runs = merged;
    to->run_count = count;
    return true;
}

/* Equal weights: the smaller material. */
static uint16_t heaviest(const svo_i_part_root *root)
{
    uint64_t most = 0;
    uint64_t material = 0;
    for (uint32_t i = 0; i < root->run_count; ++i) {
        const uint64_t weight = root->runs[i] & RUN_WEIGHT;
        material = weight > most ? root->runs[i] >> RUN_SHIFT : material;
        most = weight > most ? weight : most;
    }
    return (uint16_t)material;
}

/* Surface in 4096ths of a node's face, rounded half up, 65535 at most. */
static uint16_t fill_of(uint64_t weight, uint32_t shift)
{
    const uint64_t fill = shift > 62 ? 0 : ((weight >> (shift - 1)) + 1) >> 1;
    return (uint16_t)(fill < UINT16_MAX ? fill : UINT16_MAX);
}

svo_i_part_payload svo_i_part_round(const svo_i_part_root *root, uint32_t face_log2)
{
    const uint64_t weight = root->sums.weight;
    svo_i_part_payload payload = {.material = heaviest(root)};
    if (weight == 0) {
        return payload;
    }
    for (unsigned i = 0; i < 4; ++i) {
        payload.color[i] = (uint8_t)((2 * root->sums.color[i] + weight) / (2 * weight));
    }
    /* The offset makes the dividend positive, since a sum is at most 32768 times the weight. */
    for (unsigned i = 0; i < 3; ++i) {
        const uint64_t shifted = 2 * (uint64_t)root->sums.normal[i] + weight + (weight << 16);
        payload.normal[i] = (int16_t)((int64_t)(shifted / (2 * weight)) - 32768);
    }
    payload.fill = face_log2 > SVO_I_FILL_LOG2 ? fill_of(weight, face_log2 - SVO_I_FILL_LOG2) : 0;
    return payload;
}
