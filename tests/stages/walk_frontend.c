/* SPDX-License-Identifier: MIT */
/* Makes fragment lists on the host from the exact references' pairs. */
#include "walk_frontend.h"

#include <stdlib.h>

#include "commands/commands.h"
#include "oracle_exact.h"
#include "plan/estimate.h"
#include "support/meshes.h"

/* All pairs of a plan's kept triangles. */
typedef struct walk {
    const svo_plan *plan;
    oracle_pairs pairs; /* by code */
    const oracle_pair **by_triangle;
    size_t *triangle_begin; /* where each triangle's pairs begin in by_triangle; triangle_count + 1 are used */
} walk;

/* The fragments of one chunk, in the order in which they are found. */
typedef struct gathered {
    oracle_pair *pairs; /* capacity for all pairs of the plan */
    size_t count;
} gathered;

static svo_status no_memory(const svo_plan *plan)
{
    return svo_i_device_fail(plan->device, SVO_OUT_OF_HOST_MEMORY, "walk_frontend: no memory for the pairs");
}

static void walk_free(walk *w)
{
    oracle_pairs_free(&w->pairs);
    free(w->triangle_begin);
    free(w->by_triangle);
}

/* False: out of memory. */
static bool list_pairs(const svo_plan *plan, oracle_pairs *out)
{
    const svo_plan_info *info = &plan->info;
    const oracle_space space = {{info->origin[0], info->origin[1], info->origin[2]}, info->edge, info->depth};
    const size_t count = (size_t)plan->vertex_count * 3;
    double *positions = malloc((count + 1) * sizeof *positions);
    for (size_t i = 0; positions != NULL && i < count; ++i) {
        positions[i] = plan->positions_double != NULL ? plan->positions_double[i] : (double)plan->positions[i];
    }
    const oracle_positions mesh = {positions, plan->vertex_count, plan->indices, plan->triangle_count};
    const bool good = positions != NULL && oracle_exact_enumerate(&mesh, &space, (oracle_coverage)info->coverage, out);
    free(positions);
    return good;
}

static bool walk_make(const svo_plan *plan, walk *w)
{
    *w = (walk){.plan = plan};
    w->triangle_begin = calloc((size_t)plan->triangle_count + 2, sizeof *w->triangle_begin);
    if (w->triangle_begin == NULL || !list_pairs(plan, &w->pairs)) {
        return false;
    }
    w->by_triangle = calloc(w->pairs.count + 1, sizeof *w->by_triangle);
    if (w->by_triangle == NULL) {
        return false;
    }
    /* A counting sort. Counts are stored two elements later, begins one, so that placing the pairs moves each begin to
       its own element. */
    for (size_t i = 0; i < w->pairs.count; ++i) {
        ++w->triangle_begin[w->pairs.pairs[i].triangle + 2];
    }
    for (size_t t = 2; t <= plan->triangle_count; ++t) {
        w->triangle_begin[t] += w->triangle_begin[t - 1];
    }
    for (size_t i = 0; i < w->pairs.count; ++i) {
        w->by_triangle[w->triangle_begin[w->pairs.pairs[i].triangle + 1]++] = &w->pairs.pairs[i];
    }
    return true;
}

/* Every third bit of a code. */
static uint32_t coordinate(uint64_t code, unsigned axis)
{
    uint32_t value = 0;
    for (unsigned bit = 0; bit < SVO_DEPTH_MAX; ++bit) {
        value |= (uint32_t)(code >> (3 * bit + axis) & 1u) << bit;
    }
    return value;
}

/* Any projection along the item's axis will do, as long as every voxel lies in one pixel. */
static bool in_tile(const svo_i_draw *draw, unsigned axis, uint64_t code)
{
    return coordinate(code, (axis + 1) % 3) - draw->tile_x < draw->tile_width &&
           coordinate(code, (axis + 2) % 3) - draw->tile_y < draw->tile_height;
}

static void gather_draw(const walk *w, const svo_i_draw *draw, gathered *out)
{
    for (uint32_t k = 0; k < draw->item_count; ++k) {
        const svo_draw_item *item = &w->plan->items[draw->first_item + k];
        for (size_t i = w->triangle_begin[item->triangle]; i < w->triangle_begin[item->triangle + 1]; ++i) {
            const oracle_pair *pair = w->by_triangle[i];
            if (in_tile(draw, item->flags & SVO_DRAW_AXIS_MASK, pair->code)) {
                out->pairs[out->count++] = *pair;
            }
        }
    }
}

/* Fisher-Yates shuffle. */
static void shuffle(gathered *fragments, uint64_t *state)
{
    for (size_t left = fragments->count; left > 1; --left) {
        const size_t other = random_below(state, (uint32_t)left);
        const oracle_pair kept = fragments->pairs[left - 1];
        fragments->pairs[left - 1] = fragments->pairs[other];
        fragments->pairs[other] = kept;
    }
}

/* Fragments in the form that kernels read; allocated by malloc, NULL when out of memory. */
static uint32_t *encode(const walk *w, const gathered *fragments, size_t count)
{
    const bool long_code = w->plan->info.depth > SVO_CODE30_DEPTH_MAX;
    uint32_t *words = malloc(count * svo_i_plan_fragment_bytes(w->plan) + 1);
    uint32_t *next = words;
    for (size_t i = 0; words != NULL && i < count; ++i) {
        const oracle_pair *pair = &fragments->pairs[i];
        *next++ = (uint32_t)pair->code;
        if (long_code) {
            *next++ = (uint32_t)(pair->code >> 32);
        }
        *next++ = pair->triangle;
    }
    return words;
}

/* The buffer beyond the fragments is never written, so that a read past their end is detected. */
static svo_status upload(const walk *w, const gathered *fragments, cl_command_queue queue, svo_i_fragments *chunk)
{
    const size_t fragment_bytes = svo_i_plan_fragment_bytes(w->plan);
    svo_status status = svo_i_device_buffer(w->plan->device, "walk_frontend", "fragments", CL_MEM_READ_WRITE,
                                            (size_t)chunk->capacity * fragment_bytes, &chunk->buffer);
    const size_t held = chunk->needed < chunk->capacity ? (size_t)chunk->needed : (size_t)chunk->capacity;
    if (status != SVO_OK || held == 0) {
        return status;
    }
    uint32_t *words = encode(w, fragments, held);
    if (words == NULL) {
        return no_memory(w->plan);
    }
    const cl_int error =
        clEnqueueWriteBuffer(queue, chunk->buffer, CL_TRUE, 0, held * fragment_bytes, words, 0, NULL, NULL);
    free(words);
    return error == CL_SUCCESS ? SVO_OK
                               : svo_i_device_fail_cl(w->plan->device, "walk_frontend", "clEnqueueWriteBuffer", error);
}

static svo_status make_chunk(const walk *w, const svo_i_chunking *layout, const svo_i_chunk *drawn, uint64_t *state,
                             cl_command_queue queue, svo_i_fragments *chunk)
{
    gathered fragments = {.pairs = calloc(w->pairs.count + 1, sizeof *fragments.pairs)};
    if (fragments.pairs == NULL) {
        return no_memory(w->plan);
    }
    for (uint32_t i = 0; i < drawn->draw_count; ++i) {
        gather_draw(w, &layout->draws[drawn->first_draw + i], &fragments);
    }
    shuffle(&fragments, state);
    chunk->needed = fragments.count;
    chunk->capacity = drawn->capacity;
    const svo_status status = upload(w, &fragments, queue, chunk);
    free(fragments.pairs);
    return status;
}

static svo_status make_chunks(const walk *w, const svo_i_chunking *layout, uint64_t seed, cl_command_queue queue,
                              svo_i_fragment_list *list)
{
    for (uint32_t i = 0; i < layout->chunk_count; ++i) {
        SVO_I_TRY(make_chunk(w, layout, &layout->chunks[i], &seed, queue, &list->chunks[i]));
    }
    return SVO_OK;
}

static svo_status prepare(void *self, svo_plan *plan, svo_i_warm_up *warm_up)
{
    (void)warm_up;
    (void)self;
    (void)plan;
    return SVO_OK;
}

static svo_status voxelize(void *self, svo_i_commands *commands, const svo_i_chunking *layout,
                           svo_i_fragment_list *list)
{
    const svo_plan *plan = commands->plan;
    const double start_ms = svo_i_now_ms();
    svo_status status = SVO_OK;
    walk w;
    SVO_I_TRY_CLEANUP(walk_make(plan, &w) ? SVO_OK : no_memory(plan));
    SVO_I_TRY_CLEANUP(make_chunks(&w, layout, ((const walk_frontend *)self)->seed, commands->queue, list));
    svo_i_report_add(commands->report, SVO_STAGE_VOXELIZE, svo_i_now_ms() - start_ms, "wall");
cleanup:
    walk_free(&w);
    return status;
}

static void release(void *self, svo_i_fragment_list *list)
{
    (void)self;
    for (uint32_t i = 0; i < list->chunk_count; ++i) {
        if (list->chunks[i].buffer != NULL) {
            clReleaseMemObject(list->chunks[i].buffer);
        }
    }
    list->chunk_count = 0;
}

void walk_frontend_init(svo_device *device, uint64_t seed, walk_frontend *out)
{
    *out = (walk_frontend){.frontend = {.name = "walk",
                                        .share = "none",
                                        .self = out,
                                        .device = device,
                                        .chunk_bytes_max = UINT64_MAX,
                                        .prepare = prepare,
                                        .voxelize = voxelize,
                                        .release = release},
                           .seed = seed};
}
