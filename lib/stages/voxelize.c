/* SPDX-License-Identifier: MIT */
/*
 * The front end of OpenCL alone: uploads the snapped mesh, and per chunk of the list launches kernels/voxelize.cl for
 * every draw. For machines without OpenGL, and for devices on which this is the faster way.
 *
 * Every launch waits for the one before it by an event, as in the builder, whose helpers it uses.
 */
#include <stdlib.h>

#include "build/build.h"
#include "plan/tiles.h"

/* Local memory of a work-group. */
#define NOTES_BYTES   (sizeof(cl_uint) * SVO_GROUP_ITEMS * (SVO_TILE_COLUMNS + 1))
#define SCRATCH_BYTES (sizeof(cl_uint) * SVO_GROUP_ITEMS)

/* One list in the making. */
typedef struct run {
    svo_i_build *build; /* queue, events, times, list of buffers */
    const svo_i_layout *layout;
    cl_mem vertices, indices, items, counters;
    cl_kernel kernels[SVO_I_TEST_COUNT];
} run;

/* The test of a class's triangles. Those inside one voxel are not tested, so the first there is will do for them. */
static svo_i_test test_of(const svo_plan *plan, svo_i_class class_id)
{
    static const svo_i_test tests[SVO_I_CLASS_COUNT] = {[SVO_I_CLASS_NARROW] = SVO_I_TEST_NARROW,
                                                        [SVO_I_CLASS_REGULAR] = SVO_I_TEST_REGULAR,
                                                        [SVO_I_CLASS_WIDE] = SVO_I_TEST_WIDE};
    svo_i_test test = tests[class_id];
    while (class_id == SVO_I_CLASS_POINT && !plan->work.tests[test] && test + 1 < SVO_I_TEST_COUNT) {
        ++test;
    }
    return test;
}

/* What the builder's helpers need; the list and the tree are not theirs here. */
static svo_i_build begin(svo_plan *plan, cl_command_queue queue, svo_build_report *report)
{
    return (svo_i_build){.device = plan->device,
                         .plan = plan,
                         .queue = queue,
                         .profiling = svo_i_queue_profiles(queue),
                         .report = report};
}

static void end(svo_i_build *build)
{
    if (build->last != NULL) {
        clWaitForEvents(1, &build->last);
        clReleaseEvent(build->last);
    }
    if (build->stage_first != NULL) {
        clReleaseEvent(build->stage_first);
    }
}

static svo_status get_program(svo_i_build *build, svo_i_test test, bool *fresh)
{
    char defines[SVO_I_DEFINES_BYTES];
    svo_i_plan_test_defines(build->plan, test, defines, sizeof defines);
    return svo_i_program_get(build->device, SVO_I_BUILD, SVO_I_PROGRAM_VOXELIZE, defines, &build->program, fresh);
}

static svo_status prepare(void *self, svo_plan *plan, cl_command_queue queue)
{
    (void)self;
    svo_build_report unread = {0};
    svo_i_build build = begin(plan, queue, &unread);
    svo_status status = SVO_OK;
    for (svo_i_test test = 0; test < SVO_I_TEST_COUNT && status == SVO_OK; ++test) {
        bool fresh = false;
        if (plan->work.tests[test]) {
            status = get_program(&build, test, &fresh);
        }
        if (status == SVO_OK && fresh) {
            status = svo_i_build_warm(&build, SVO_I_PROGRAM_VOXELIZE);
        }
    }
    end(&build);
    return status;
}

static svo_status create_kernels(run *r)
{
    svo_status status = SVO_OK;
    for (svo_i_test test = 0; test < SVO_I_TEST_COUNT && status == SVO_OK; ++test) {
        if (r->build->plan->work.tests[test]) {
            status = get_program(r->build, test, NULL);
            status = status == SVO_OK ? svo_i_build_kernel(r->build, "svo_k_voxelize", &r->kernels[test]) : status;
        }
    }
    return status;
}

/* The mesh, and two words per chunk to count in: the low half of the number of fragments, then the high half. */
static svo_status upload(run *r)
{
    const svo_plan *plan = r->build->plan;
    const uint64_t triangles = plan->triangle_count;
    const uint64_t counter_bytes = (r->layout->chunk_count + 1u) * 8ull;
    svo_i_build_stage_begin(r->build);
    svo_status status =
        svo_i_build_upload(r->build, "mesh_vertices", plan->vertices, (uint64_t)plan->vertex_count * 12, &r->vertices);
    if (status == SVO_OK) {
        status = svo_i_build_upload(r->build, "mesh_indices", plan->indices, triangles * 12, &r->indices);
    }
    if (status == SVO_OK) {
        status = svo_i_build_upload(r->build, "mesh_items", plan->items, triangles * sizeof(svo_draw_item), &r->items);
    }
    if (status == SVO_OK) {
        status = svo_i_build_alloc(r->build, "counters", counter_bytes, &r->counters);
    }
    if (status == SVO_OK) {
        status = svo_i_build_fill_zero(r->build, r->counters, counter_bytes);
    }
    return status == SVO_OK ? svo_i_build_stage_end(r->build, SVO_STAGE_TRANSFER) : status;
}

static svo_status launch(run *r, const svo_i_draw *draw, svo_voxelize_params params, cl_mem tiles, cl_mem fragments)
{
    const svo_plan *plan = r->build->plan;
    const uint64_t groups = ((uint64_t)draw->item_count + SVO_GROUP_ITEMS - 1) / SVO_GROUP_ITEMS;
    params.depth = plan->info.depth;
    params.voxel_log2 = plan->voxel_log2;
    params.open = plan->info.coverage == SVO_COVERAGE_CLOSED ? 0 : 1;
    params.one_voxel = draw->class_id == SVO_I_CLASS_POINT;
    params.first_item = draw->first_item;
    params.item_count = draw->item_count;
    params.first_tile_id = (uint32_t)(groups * SVO_GROUP_ITEMS);
    params.left = draw->tile_x;
    params.bottom = draw->tile_y;
    params.width = draw->tile_width;
    params.height = draw->tile_height;
    const svo_i_argument arguments[] = {
        SVO_I_ARGUMENT(r->vertices), SVO_I_ARGUMENT(r->indices),  SVO_I_ARGUMENT(r->items),
        SVO_I_ARGUMENT(tiles),       SVO_I_ARGUMENT(r->counters), SVO_I_ARGUMENT(fragments),
        SVO_I_ARGUMENT(params),      SVO_I_LOCAL(NOTES_BYTES),    SVO_I_LOCAL(SCRATCH_BYTES)};
    return svo_i_build_launch(r->build, r->kernels[test_of(plan, draw->class_id)], arguments,
                              sizeof arguments / sizeof arguments[0], groups * SVO_GROUP_ITEMS + params.tile_count);
}

/* The tiles of all draws of a chunk; tile_begin: where each draw's begin, and the end. */
static svo_status make_tiles(const run *r, const svo_i_chunk *chunk, svo_i_tiles *tiles, size_t *tile_begin)
{
    for (uint32_t i = 0; i < chunk->draw_count; ++i) {
        tile_begin[i] = tiles->count;
        if (!svo_i_tiles_of_draw(r->build->plan, &r->layout->draws[chunk->first_draw + i], tiles)) {
            return svo_i_device_fail(r->build->device, SVO_OUT_OF_HOST_MEMORY, "svo_build: no memory for %zu tiles",
                                     tiles->count);
        }
    }
    tile_begin[chunk->draw_count] = tiles->count;
    return SVO_OK;
}

/* The tiles that were found before, or those that are found now, into *found. */
static svo_status get_tiles(const run *r, const svo_i_chunk *chunk, svo_i_kept_tiles *found)
{
    svo_i_kept_tiles *kept = r->build->kept;
    if (kept != NULL && kept->begin != NULL) {
        *found = *kept;
        return SVO_OK;
    }
    found->begin = calloc(chunk->draw_count + 1u, sizeof *found->begin);
    if (found->begin == NULL) {
        return svo_i_device_fail(r->build->device, SVO_OUT_OF_HOST_MEMORY, "svo_build: no memory for %u draws",
                                 chunk->draw_count);
    }
    const svo_status status = make_tiles(r, chunk, &found->tiles, found->begin);
    if (status == SVO_OK && kept != NULL) {
        *kept = *found;
    }
    return status;
}

static void free_tiles(const run *r, svo_i_kept_tiles *found)
{
    if (r->build->kept == NULL || r->build->kept->begin != found->begin) {
        svo_i_tiles_free(&found->tiles);
        free(found->begin);
    }
}

/* About how many bytes they take: a tile of a triangle's plane has some fragments per column. */
static uint64_t expected_tile_bytes(const run *r, const svo_i_chunk *chunk)
{
    double tiles = 0.0;
    for (uint32_t i = chunk->first_draw; i < chunk->first_draw + chunk->draw_count; ++i) {
        const svo_i_draw *draw = &r->layout->draws[i];
        for (uint32_t k = 0; k < draw->item_count; ++k) {
            const double fragments = (double)r->build->plan->item_fragments[draw->first_item + k];
            tiles += fragments > SVO_TILE_COLUMNS ? fragments * 4.0 / SVO_TILE_COLUMNS : 0.0;
        }
    }
    return (uint64_t)tiles * sizeof(svo_tile_item);
}

static svo_status launch_draws(run *r, uint32_t chunk_index, const size_t *tile_begin, cl_mem tiles, cl_mem fragments)
{
    const svo_i_chunk *chunk = &r->layout->chunks[chunk_index];
    svo_status status = SVO_OK;
    svo_i_build_stage_begin(r->build);
    for (uint32_t i = 0; i < chunk->draw_count && status == SVO_OK; ++i) {
        const svo_voxelize_params params = {.first_tile = (uint32_t)tile_begin[i],
                                            .tile_count = (uint32_t)(tile_begin[i + 1] - tile_begin[i]),
                                            .capacity = (uint32_t)chunk->capacity,
                                            .counter = chunk_index};
        status = launch(r, &r->layout->draws[chunk->first_draw + i], params, tiles, fragments);
    }
    return status == SVO_OK ? svo_i_build_stage_end(r->build, SVO_STAGE_VOXELIZE) : status;
}

/* The buffer of a chunk. A build that runs has it in its list already, as that of every front end. */
static svo_status alloc_fragments(run *r, svo_i_fragments *out)
{
    const uint64_t bytes = out->capacity * svo_i_plan_fragment_bytes(r->build->plan);
    return r->build->mode == SVO_I_BUILD_RUNS ? svo_i_device_buffer(r->build->device, SVO_I_BUILD, "fragments",
                                                                    CL_MEM_READ_WRITE, (size_t)bytes, &out->buffer)
                                              : svo_i_build_alloc(r->build, "fragments", bytes, &out->buffer);
}

/* Finding the tiles is counted as transfer, with the upload they are for. */
static svo_status draw_chunk(run *r, uint32_t chunk_index, svo_i_fragments *out)
{
    const svo_i_chunk *chunk = &r->layout->chunks[chunk_index];
    const bool guesses = r->build->mode == SVO_I_BUILD_MEASURES && r->build->kept == NULL;
    svo_i_kept_tiles found = {0};
    cl_mem tile_buffer = NULL;
    svo_status status = SVO_OK;
    const double start_ms = svo_i_now_ms();
    if (!guesses) {
        status = get_tiles(r, chunk, &found);
    }
    svo_i_report_add(r->build->report, SVO_STAGE_TRANSFER, svo_i_now_ms() - start_ms, "wall");
    svo_i_build_stage_begin(r->build);
    if (status == SVO_OK) {
        const uint64_t bytes = guesses ? expected_tile_bytes(r, chunk) : found.tiles.count * sizeof *found.tiles.items;
        status = svo_i_build_upload(r->build, "mesh_tiles", found.tiles.items, bytes, &tile_buffer);
    }
    status = status == SVO_OK ? svo_i_build_stage_end(r->build, SVO_STAGE_TRANSFER) : status;
    if (status == SVO_OK && r->build->mode != SVO_I_BUILD_MEASURES) {
        status = launch_draws(r, chunk_index, found.begin, tile_buffer, out->buffer);
    }
    svo_i_build_free(r->build, &tile_buffer);
    free_tiles(r, &found);
    return status;
}

static svo_status read_counters(run *r, svo_i_fragment_list *list)
{
    cl_uint *counters = calloc(list->chunk_count + 1u, 2 * sizeof *counters);
    if (counters == NULL) {
        return svo_i_device_fail(r->build->device, SVO_OUT_OF_HOST_MEMORY, "svo_build: no memory for %u counters",
                                 list->chunk_count);
    }
    svo_i_build_stage_begin(r->build);
    svo_status status =
        svo_i_build_read(r->build, r->counters, counters, ((size_t)list->chunk_count + 1) * 2 * sizeof *counters);
    status = status == SVO_OK ? svo_i_build_stage_end(r->build, SVO_STAGE_TRANSFER) : status;
    for (size_t i = 0; i < list->chunk_count; ++i) {
        list->chunks[i].needed = (uint64_t)counters[2 * i + 1] << 32 | counters[2 * i];
    }
    free(counters);
    return status;
}

static void release_run(run *r)
{
    svo_i_build_free(r->build, &r->vertices);
    svo_i_build_free(r->build, &r->indices);
    svo_i_build_free(r->build, &r->items);
    for (svo_i_test test = 0; test < SVO_I_TEST_COUNT; ++test) {
        if (r->kernels[test] != NULL) {
            clReleaseKernel(r->kernels[test]);
        }
    }
}

/* The whole list, not yet counted by the host. */
static svo_status make_list(run *r, svo_i_fragment_list *list)
{
    svo_status status = r->build->mode != SVO_I_BUILD_MEASURES ? create_kernels(r) : SVO_OK;
    for (uint32_t i = 0; i < r->layout->chunk_count && status == SVO_OK; ++i) {
        list->chunks[i].capacity = r->layout->chunks[i].capacity;
        status = alloc_fragments(r, &list->chunks[i]);
    }
    status = status == SVO_OK ? upload(r) : status;
    for (uint32_t i = 0; i < r->layout->chunk_count && status == SVO_OK; ++i) {
        status = draw_chunk(r, i, &list->chunks[i]);
    }
    return status;
}

static svo_status voxelize(void *self, svo_plan *plan, const svo_i_layout *layout, cl_command_queue queue,
                           svo_i_fragment_list *list, svo_build_report *report)
{
    (void)self;
    svo_i_build build = begin(plan, queue, report);
    run r = {.build = &build, .layout = layout};
    svo_status status = make_list(&r, list);
    status = status == SVO_OK ? read_counters(&r, list) : status;
    end(&build);
    svo_i_build_free(&build, &r.counters);
    release_run(&r);
    return status;
}

svo_status svo_i_voxelize_enqueue(svo_i_build *build, const svo_i_layout *layout)
{
    run r = {.build = build, .layout = layout};
    cl_program kept = build->program;
    const svo_status status = make_list(&r, &build->list);
    build->program = kept;
    build->counters = r.counters;
    for (uint32_t i = 0; i < layout->chunk_count; ++i) {
        build->list.chunks[i].needed = layout->chunks[i].capacity;
    }
    release_run(&r);
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

svo_status svo_frontend_create_cl(svo_device *device, svo_frontend **out)
{
    if (device == NULL || out == NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "svo_frontend_create_cl: %s is NULL",
                                 device == NULL ? "device" : "out");
    }
    cl_ulong local_bytes = 0;
    clGetDeviceInfo(device->device, CL_DEVICE_LOCAL_MEM_SIZE, sizeof local_bytes, &local_bytes, NULL);
    if (local_bytes < NOTES_BYTES + SCRATCH_BYTES) {
        return svo_i_device_fail(device, SVO_UNSUPPORTED,
                                 "svo_frontend_create_cl: %s has %llu bytes of local memory, below %zu", device->name,
                                 (unsigned long long)local_bytes, NOTES_BYTES + SCRATCH_BYTES);
    }
    svo_frontend *frontend = calloc(1, sizeof *frontend);
    if (frontend == NULL) {
        return svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, "svo_frontend_create_cl: no memory for the handle");
    }
    *frontend = (svo_frontend){.name = "cl",
                               .share = "none",
                               .self = frontend,
                               .device = device,
                               .chunk_bytes_max = device->max_allocation_bytes,
                               .prepare = prepare,
                               .voxelize = voxelize,
                               .release = release,
                               .enqueue = svo_i_voxelize_enqueue,
                               .destroy = free};
    *out = frontend;
    return SVO_OK;
}

void svo_frontend_destroy(svo_frontend **frontend)
{
    if (frontend == NULL || *frontend == NULL) {
        return;
    }
    if ((*frontend)->destroy != NULL) {
        (*frontend)->destroy((*frontend)->self);
    }
    *frontend = NULL;
}

const char *svo_frontend_name(const svo_frontend *frontend)
{
    return frontend->name;
}

const char *svo_frontend_share(const svo_frontend *frontend)
{
    return frontend->share;
}
