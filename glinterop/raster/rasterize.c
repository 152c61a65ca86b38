/* SPDX-License-Identifier: MIT */
/*
 * Rasterizes a plan's triangles into the fragment list: one shared buffer per chunk, filled by OpenGL, then handed over
 * to OpenCL. The list is the input of the stages that build the tree. What the shaders leave undecided is decided in
 * between, by the mesh as it was given: by the builder's compute shaders, or by the host.
 */
#include "raster/rasterize.h"

#include "commands/commands.h"
#include "core/message.h"
#include "plan/accounts.h"
#include "plan/estimate.h"
#include "share/share.h"
#include "shared/decide.clh"
#include "stages/inputs.h"
#include "svocl/nodes.h"

/* Creates a chunk's buffer and gives it to OpenGL. */
static svo_status create_chunk(const svo_i_rasterizer *rasterizer, size_t bytes, cl_command_queue queue,
                               svo_i_fragments *chunk)
{
    svo_i_share_buffer *shared = chunk->owner;
    SVO_I_TRY(svo_i_share_buffer_create(rasterizer->device, rasterizer->context, rasterizer->share,
                                        bytes > 0 ? bytes : 4, shared));
    chunk->buffer = shared->memory;
    return svo_i_share_buffer_to_gl(shared, queue);
}

/* svo_i_rasterize_release frees the chunks, also after a failure. */
static svo_status create_chunks(const svo_i_rasterizer *rasterizer, const svo_plan *plan,
                                const svo_i_chunking *chunking, cl_command_queue queue, svo_i_fragment_list *list)
{
    const size_t fragment_bytes = svo_i_plan_fragment_bytes(plan);
    for (uint32_t i = 0; i < chunking->chunk_count; ++i) {
        svo_i_fragments *chunk = &list->chunks[i];
        chunk->owner = svo_i_alloc_zeroed(&rasterizer->device->memory, 1, sizeof(svo_i_share_buffer));
        if (chunk->owner == NULL) {
            return svo_i_device_fail(rasterizer->device, SVO_OUT_OF_HOST_MEMORY, "svo_build: no memory for %u chunks",
                                     chunking->chunk_count);
        }
        chunk->capacity = chunking->chunks[i].capacity;
        SVO_I_TRY(create_chunk(rasterizer, (size_t)chunk->capacity * fragment_bytes, queue, chunk));
    }
    return SVO_OK;
}

/* The voxels of a triangle's bounding box, one voxel wider on every side. */
static double box_voxels(const svo_plan *plan, uint32_t triangle)
{
    const uint32_t *corners = plan->indices + (size_t)triangle * 3;
    const int32_t width = 1 << plan->info.depth;
    double voxels = 1.0;
    for (unsigned axis = 0; axis < 3; ++axis) {
        int32_t low = width, high = -1;
        for (unsigned corner = 0; corner < 3; ++corner) {
            const int32_t voxel = plan->vertices[(size_t)corners[corner] * 3 + axis] >> plan->voxel_log2;
            low = voxel < low ? voxel : low;
            high = voxel > high ? voxel : high;
        }
        low = low > 0 ? low : 0;
        high = high < width ? high : width;
        voxels *= high >= low ? (double)(high - low) + 3.0 : 3.0;
    }
    return voxels;
}

/* What draws name. */
static const svo_draw_item *items_of(const svo_i_rasterizer *rasterizer, const svo_plan *plan)
{
    return rasterizer->rest != NULL ? rasterizer->rest->items : plan->items;
}

/* The most fragments that a chunk's triangles can touch. */
static double possible_fragments(const svo_i_rasterizer *rasterizer, const svo_plan *plan,
                                 const svo_i_chunking *chunking, const svo_i_chunk *chunk)
{
    const svo_draw_item *items = items_of(rasterizer, plan);
    double most = 0.0;
    for (uint32_t i = 0; i < chunk->draw_count; ++i) {
        const svo_i_draw *draw = &chunking->draws[chunk->first_draw + i];
        for (uint32_t item = 0; item < draw->item_count; ++item) {
            most += box_voxels(plan, items[draw->first_item + item].triangle);
        }
    }
    return most;
}

/* A chunk that was too small is allocated again with the driver's count, so an impossible count is an error. */
static svo_status check_count(const svo_i_rasterizer *rasterizer, const svo_plan *plan, const svo_i_chunking *chunking,
                              uint32_t chunk, uint64_t needed)
{
    if (needed <= chunking->chunks[chunk].capacity) {
        return SVO_OK;
    }
    const double most = possible_fragments(rasterizer, plan, chunking, &chunking->chunks[chunk]);
    if ((double)needed > most) {
        return svo_i_device_fail(
            rasterizer->device, SVO_GL_ERROR, "svo_build: %s counted %llu fragments where at most %.0f are possible",
            svo_i_gl_context_functions(rasterizer->context)->renderer, (unsigned long long)needed, most);
    }
    return SVO_OK;
}

/* Waits for the chunks that were drawn, where somebody asks for the progress. part: of all chunks. */
static svo_status tell(const svo_i_rasterizer *rasterizer, svo_plan *plan, double part)
{
    if (plan->progress.callback == NULL) {
        return SVO_OK;
    }
    svo_i_gl_context_functions(rasterizer->context)->Finish();
    return svo_i_progress_reach(plan, SVO_STAGE_VOXELIZE, part);
}

/* ---- undecided fragments ---- */

/* Keeps those of the fragments that touch, in their order; *kept: how many. */
static svo_status keep_touching(const svo_i_rasterizer *rasterizer, const svo_plan *plan, uint32_t *words,
                                uint32_t count, uint32_t *kept)
{
    const svo_decide_params params = svo_i_decide_params(plan);
    const void *positions = params.is_double != 0 ? (const void *)plan->positions_double : plan->positions;
    const size_t width = svo_i_plan_fragment_bytes(plan) / sizeof *words;
    svo_decider decider = {.triangle = SVO_NO_TRIANGLE};
    *kept = 0;
    for (uint32_t i = 0; i < count; ++i) {
        const uint32_t *fragment = words + i * width;
        const uint32_t triangle = fragment[width - 1];
        uint32_t cell[3];
        const uint64_t code = fragment[0] | (width > SVO_FRAGMENT_WORDS_30 ? (uint64_t)fragment[1] << 32 : 0);
        svo_code_to_cell(code, cell);
        if (triangle >= plan->triangle_count) {
            return svo_i_device_fail(rasterizer->device, SVO_GL_ERROR, "svo_build: %s wrote triangle %u, not below %u",
                                     svo_i_gl_context_functions(rasterizer->context)->renderer, triangle,
                                     plan->triangle_count);
        }
        if (svo_decide(positions, plan->indices, triangle, cell, &params, &decider)) {
            memmove(words + *kept * width, fragment, width * sizeof *words);
            ++*kept;
        }
    }
    return SVO_OK;
}

/* On the host, what svo_i_decider.decide does. */
static svo_status decide_on_host(const svo_i_rasterizer *rasterizer, const svo_plan *plan,
                                 const svo_i_share_buffer *shared, uint32_t capacity, svo_i_raster_count count,
                                 uint32_t *kept)
{
    const size_t fragment_bytes = svo_i_plan_fragment_bytes(plan);
    const size_t bytes = count.undecided * fragment_bytes;
    uint32_t *words = svo_i_alloc(&rasterizer->device->memory, bytes);
    if (words == NULL) {
        return svo_i_device_fail(rasterizer->device, SVO_OUT_OF_HOST_MEMORY, "svo_build: no memory for %u fragments",
                                 count.undecided);
    }
    svo_status status = SVO_OK;
    SVO_I_TRY_CLEANUP(svo_i_share_buffer_read_gl(shared, capacity * fragment_bytes - bytes, bytes, words));
    SVO_I_TRY_CLEANUP(keep_touching(rasterizer, plan, words, count.undecided, kept));
    SVO_I_TRY_CLEANUP(
        svo_i_share_buffer_write_gl(shared, count.decided * fragment_bytes, *kept * fragment_bytes, words));
cleanup:
    svo_i_free(words);
    return status;
}

/* Decides the chunk's undecided fragments and moves those that touch to the others; chunk->needed: both. */
static svo_status decide(const svo_i_rasterizer *rasterizer, const svo_plan *plan, svo_i_fragments *chunk,
                         svo_i_raster_count count)
{
    const svo_i_decider *decider = &rasterizer->decider;
    const uint32_t capacity = (uint32_t)chunk->capacity;
    uint32_t kept = 0;
    chunk->needed = (uint64_t)count.decided + count.undecided;
    if (count.undecided == 0 || chunk->needed > chunk->capacity) {
        return SVO_OK;
    }
    SVO_I_TRY(decider->decide != NULL ? decider->decide(decider->self, plan, chunk->owner, capacity, count, &kept)
                                      : decide_on_host(rasterizer, plan, chunk->owner, capacity, count, &kept));
    chunk->needed = (uint64_t)count.decided + kept;
    return SVO_OK;
}

/* Draws all chunks; counts: of each; *undecided: of all. */
static svo_status draw_chunks(const svo_i_rasterizer *rasterizer, svo_plan *plan, const svo_i_chunking *chunking,
                              svo_i_fragment_list *list, svo_i_raster_count *counts, uint64_t *undecided)
{
    for (uint32_t i = 0; i < chunking->chunk_count; ++i) {
        svo_i_share_buffer_bind(list->chunks[i].owner, SVO_I_RASTER_FRAGMENTS);
        SVO_I_TRY(svo_i_raster_draw(rasterizer->raster, plan, chunking, i));
        SVO_I_TRY(tell(rasterizer, plan, (double)(i + 1) / chunking->chunk_count));
    }
    SVO_I_TRY(svo_i_raster_finish(rasterizer->raster, chunking->chunk_count, counts));
    *undecided = 0;
    for (uint32_t i = 0; i < chunking->chunk_count; ++i) {
        *undecided += counts[i].undecided;
        SVO_I_TRY(decide(rasterizer, plan, &list->chunks[i], counts[i]));
        SVO_I_TRY(check_count(rasterizer, plan, chunking, i, list->chunks[i].needed));
    }
    return SVO_OK;
}

static svo_status draw_list(const svo_i_rasterizer *rasterizer, svo_plan *plan, const svo_i_chunking *chunking,
                            svo_i_fragment_list *list, uint64_t *undecided)
{
    svo_i_raster_count *counts =
        svo_i_alloc_zeroed(&rasterizer->device->memory, chunking->chunk_count + 1u, sizeof *counts);
    if (counts == NULL) {
        return svo_i_device_fail(rasterizer->device, SVO_OUT_OF_HOST_MEMORY, "svo_build: no memory for %u counters",
                                 chunking->chunk_count);
    }
    const svo_status status = draw_chunks(rasterizer, plan, chunking, list, counts, undecided);
    svo_i_free(counts);
    return status;
}

/* Gives the written part of each chunk to OpenCL. */
static svo_status hand_over(const svo_plan *plan, cl_command_queue queue, svo_i_fragment_list *list)
{
    const size_t fragment_bytes = svo_i_plan_fragment_bytes(plan);
    for (uint32_t i = 0; i < list->chunk_count; ++i) {
        const svo_i_fragments *chunk = &list->chunks[i];
        const uint64_t held = chunk->needed < chunk->capacity ? chunk->needed : chunk->capacity;
        SVO_I_TRY(svo_i_share_buffer_to_cl(chunk->owner, (size_t)held * fragment_bytes, queue));
    }
    return SVO_OK;
}

/* Adds the time since *start_ms to a stage and starts anew. */
static void take_time(svo_build_report *report, svo_stage stage, double *start_ms)
{
    const double now_ms = svo_i_now_ms();
    svo_i_report_add(report, stage, now_ms - *start_ms, "wall");
    *start_ms = now_ms;
}

static svo_status make_list(const svo_i_rasterizer *rasterizer, svo_i_commands *commands,
                            const svo_i_chunking *chunking, svo_i_fragment_list *list)
{
    svo_plan *plan = commands->plan;
    double start_ms = svo_i_now_ms();
    SVO_I_TRY(create_chunks(rasterizer, plan, chunking, commands->queue, list));
    const uint32_t items =
        rasterizer->rest != NULL ? rasterizer->rest->item_count : plan->class_begin[SVO_I_CLASS_COUNT];
    SVO_I_TRY(svo_i_raster_upload(rasterizer->raster, plan, items_of(rasterizer, plan), items, chunking->chunk_count));
    take_time(commands->report, SVO_STAGE_TRANSFER, &start_ms);
    SVO_I_TRY(draw_list(rasterizer, plan, chunking, list, &commands->report->undecided));
    take_time(commands->report, SVO_STAGE_VOXELIZE, &start_ms);
    if (rasterizer->share != SVO_GL_SHARE_AUTO) {
        SVO_I_TRY(hand_over(plan, commands->queue, list));
    }
    take_time(commands->report, SVO_STAGE_TRANSFER, &start_ms);
    return SVO_OK;
}

svo_status svo_i_rasterize_list(const svo_i_rasterizer *rasterizer, svo_i_commands *commands,
                                const svo_i_chunking *chunking, svo_i_fragment_list *list)
{
    SVO_I_TRY(svo_i_gl_context_make_current(rasterizer->context, &rasterizer->device->message));
    const svo_status status = make_list(rasterizer, commands, chunking, list);
    svo_i_raster_drop(rasterizer->raster);
    svo_i_gl_context_release_current(rasterizer->context);
    return status;
}

void svo_i_rasterize_release(svo_i_fragment_list *list)
{
    for (uint32_t i = 0; i < list->chunk_count; ++i) {
        if (list->chunks[i].owner != NULL) {
            svo_i_share_buffer_destroy(list->chunks[i].owner);
            svo_i_free(list->chunks[i].owner);
        }
    }
    list->chunk_count = 0;
}
