/* SPDX-License-Identifier: MIT */
/*
 * The front end "cl": uploads the mesh, launches the voxelizer for every draw of every chunk, and decides what that
 * leaves undecided. It is used without OpenGL, and on devices on which it is faster than OpenGL.
 */
#include "stages/voxelize.h"

#include "plan/chunking.h"
#include "plan/configuration.h"
#include "plan/estimate.h"
#include "plan/programs.h"
#include "plan/update.h"
#include "stages/inputs.h"
#include "stages/programs.h"

/* A work-item decides fragments of this many places of a chunk. */
#define DECIDE_RUN 256
/* Local memory of a work-group: for sums, and for notes and fragments. */
#define SCRATCH_BYTES (sizeof(cl_uint) * SVO_GROUP_ITEMS)

static size_t words_bytes(const svo_device *device)
{
    return sizeof(cl_uint) * (device->cpu_path ? SVO_VOXELIZE_STAGE_WORDS : SVO_VOXELIZE_NOTE_WORDS);
}

/* The state of one call of svo_i_voxelize. */
typedef struct run {
    svo_i_commands *commands;
    const svo_i_chunking *chunking;
    svo_i_build_mesh mesh; /* whose buffers stay those of commands->mesh */
    cl_mem items, counters;
    cl_kernel kernels[SVO_I_TEST_COUNT];
    cl_kernel decide, keep_decided;
    bool adds; /* to the fragments of chunks that others have drawn */
} run;

/* The overlap test for a class of triangles. Triangles inside one voxel need none; any variant works for them. */
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

/* The program with the kernel's variant for an overlap test. */
static svo_status get_program(svo_plan *plan, svo_i_test test, cl_program *out, bool *fresh)
{
    char defines[SVO_I_DEFINES_BYTES];
    svo_i_plan_test_defines(plan, test, defines, sizeof defines);
    return svo_i_program_get(plan->device, SVO_I_BUILD, &svo_i_program_voxelize, defines, out, fresh);
}

static svo_status get_decide_program(svo_plan *plan, cl_program *out, bool *fresh)
{
    char defines[SVO_I_DEFINES_BYTES];
    svo_i_plan_defines(plan, &svo_i_program_decide, defines, sizeof defines);
    return svo_i_program_get(plan->device, SVO_I_BUILD, &svo_i_program_decide, defines, out, fresh);
}

svo_status svo_i_voxelize_prepare(void *self, svo_plan *plan, svo_i_warm_up *warm_up)
{
    (void)self;
    cl_program decide = NULL;
    bool decide_fresh = false;
    if (svo_i_plan_needs_program(plan, &svo_i_program_decide)) {
        SVO_I_TRY(get_decide_program(plan, &decide, &decide_fresh));
    }
    if (decide_fresh) {
        SVO_I_TRY(svo_i_warm_up_add_program(warm_up, decide));
    }
    for (svo_i_test test = 0; test < SVO_I_TEST_COUNT; ++test) {
        cl_program program = NULL;
        bool fresh = false;
        if (plan->work.tests[test]) {
            SVO_I_TRY(get_program(plan, test, &program, &fresh));
        }
        if (fresh) {
            SVO_I_TRY(svo_i_warm_up_add_program(warm_up, program));
        }
    }
    return SVO_OK;
}

static svo_status create_kernels(run *r)
{
    if (!svo_i_commands_launch_kernels(r->commands)) {
        return SVO_OK;
    }
    for (svo_i_test test = 0; test < SVO_I_TEST_COUNT; ++test) {
        cl_program program = NULL;
        if (r->commands->plan->work.tests[test]) {
            SVO_I_TRY(get_program(r->commands->plan, test, &program, NULL));
            SVO_I_TRY(svo_i_commands_kernel(r->commands, program, "svo_k_voxelize", &r->kernels[test]));
        }
    }
    cl_program program = NULL;
    if (!svo_i_plan_needs_program(r->commands->plan, &svo_i_program_decide)) {
        return SVO_OK;
    }
    SVO_I_TRY(get_decide_program(r->commands->plan, &program, NULL));
    SVO_I_TRY(svo_i_commands_kernel(r->commands, program, "svo_k_decide", &r->decide));
    return svo_i_commands_kernel(r->commands, program, "svo_k_keep_decided", &r->keep_decided);
}

/* The counters: of what the chunks hold already. */
static svo_status upload_counters(run *r, const svo_i_fragment_list *list)
{
    const size_t words = ((size_t)r->chunking->chunk_count + 1) * SVO_COUNTER_WORDS;
    SVO_I_TRY(svo_i_commands_alloc(r->commands, "counters", words * sizeof(cl_uint), &r->counters));
    if (!r->adds) {
        return svo_i_commands_fill_zero(r->commands, r->counters, words * sizeof(cl_uint));
    }
    cl_uint *counters = svo_i_alloc_zeroed(&r->commands->device->memory, words, sizeof *counters);
    if (counters == NULL) {
        return svo_i_device_fail(r->commands->device, SVO_OUT_OF_HOST_MEMORY, "svo_build: no memory for %u counters",
                                 list->chunk_count);
    }
    for (uint32_t i = 0; i < list->chunk_count; ++i) {
        cl_uint *const own = counters + (size_t)SVO_COUNTER_WORDS * i;
        own[0] = (cl_uint)list->chunks[i].needed;
        own[1] = (cl_uint)(list->chunks[i].needed >> 32);
    }
    svo_status status = SVO_OK;
    SVO_I_TRY_CLEANUP(svo_i_commands_write(r->commands, r->counters, counters, words * sizeof *counters));
    SVO_I_TRY_CLEANUP(svo_i_commands_wait(r->commands));
cleanup:
    svo_i_free(counters);
    return status;
}

/* Uploads the mesh, and sets the counters. */
static svo_status upload(run *r, const svo_i_fragment_list *list)
{
    const svo_plan *plan = r->commands->plan;
    /* An updatable plan has one more, for tiles that are not used. */
    const uint64_t items = plan->class_begin[SVO_I_CLASS_COUNT] + (plan->update != NULL ? UINT64_C(1) : 0);
    svo_i_stage_begin(r->commands);
    SVO_I_TRY(svo_i_build_mesh_get(r->commands, &r->mesh));
    SVO_I_TRY(svo_i_commands_borrow(r->commands, "mesh_items", plan->items, plan->memory.items,
                                    items * sizeof(svo_draw_item), &r->items));
    SVO_I_TRY(upload_counters(r, list));
    return svo_i_stage_end(r->commands, SVO_STAGE_TRANSFER);
}

/* The work-items of a draw: one per triangle, in whole groups, then one per tile. */
static uint64_t ids_of_triangles(const svo_i_draw *draw)
{
    return ((uint64_t)draw->item_count + SVO_GROUP_ITEMS - 1) / SVO_GROUP_ITEMS * SVO_GROUP_ITEMS;
}

/* Restricts a launch to the work-items from begin, a multiple of the group, to end. */
static void cut_launch(svo_voxelize_params *params, uint64_t begin, uint64_t end)
{
    const uint64_t tile_id = params->first_tile_id; /* before the cut */
    const uint64_t items = params->item_count;
    params->first_item += (uint32_t)(begin < items ? begin : items);
    params->item_count = (uint32_t)((end < items ? end : items) - (begin < items ? begin : items));
    params->first_tile += (uint32_t)(begin > tile_id ? begin - tile_id : 0);
    params->tile_count = (uint32_t)(end > tile_id ? end - (begin > tile_id ? begin : tile_id) : 0);
    params->first_tile_id = (uint32_t)((end < tile_id ? end : begin > tile_id ? begin : tile_id) - begin);
}

/* Completes the params of a draw. */
static void describe(const run *r, const svo_i_draw *draw, svo_voxelize_params *params)
{
    const svo_plan *plan = r->commands->plan;
    const uint32_t most = r->chunking->most_columns;
    params->depth = plan->info.depth;
    params->voxel_log2 = plan->voxel_log2;
    params->open = plan->info.coverage == SVO_COVERAGE_CLOSED ? 0 : 1;
    params->one_voxel = draw->class_id == SVO_I_CLASS_POINT;
    params->first_item = draw->first_item;
    params->item_count = draw->item_count;
    params->first_tile_id = (uint32_t)ids_of_triangles(draw);
    params->left = draw->tile_x;
    params->bottom = draw->tile_y;
    params->width = draw->tile_width;
    params->height = draw->tile_height;
    params->most_columns = most != 0 && most < SVO_TILE_COLUMNS ? most : SVO_TILE_COLUMNS;
}

static svo_status launch(run *r, const svo_i_draw *draw, svo_voxelize_params params, cl_mem tiles, cl_mem fragments)
{
    const uint64_t ids = ids_of_triangles(draw) + params.tile_count;
    describe(r, draw, &params);
    const uint64_t parts = svo_i_commands_parts(r->commands, ids);
    const size_t local_bytes = words_bytes(r->commands->device);
    for (uint64_t part = 0; part < parts; ++part) {
        const uint64_t begin = part * SVO_I_PART_ITEMS;
        const uint64_t end = part + 1 < parts ? begin + SVO_I_PART_ITEMS : ids;
        svo_voxelize_params cut = params;
        cut_launch(&cut, begin, end);
        const svo_i_argument arguments[] = {SVO_I_ARGUMENT(r->mesh.vertices),
                                            SVO_I_ARGUMENT(r->mesh.indices),
                                            SVO_I_ARGUMENT(r->items),
                                            SVO_I_ARGUMENT(tiles),
                                            SVO_I_ARGUMENT(r->counters),
                                            SVO_I_ARGUMENT(fragments),
                                            SVO_I_ARGUMENT(cut),
                                            SVO_I_LOCAL(local_bytes),
                                            SVO_I_LOCAL(SCRATCH_BYTES)};
        SVO_I_TRY(svo_i_commands_launch(r->commands, r->kernels[test_of(r->commands->plan, draw->class_id)],
                                        SVO_I_ARGUMENTS(arguments), end - begin));
    }
    return SVO_OK;
}

/* Finds the tiles of all draws of a chunk. tile_begin: index of each draw's first tile, and the end. */
static svo_status make_tiles(const run *r, const svo_i_chunk *chunk, svo_i_tiles *tiles, size_t *tile_begin)
{
    for (uint32_t i = 0; i < chunk->draw_count; ++i) {
        tile_begin[i] = tiles->count;
        if (!svo_i_tiles_of_draw(r->commands->plan, &r->chunking->draws[chunk->first_draw + i],
                                 r->chunking->most_columns, tiles)) {
            return svo_i_device_fail(r->commands->device, SVO_OUT_OF_HOST_MEMORY, "svo_build: no memory for %zu tiles",
                                     tiles->count);
        }
    }
    tile_begin[chunk->draw_count] = tiles->count;
    return SVO_OK;
}

/* Takes the tiles from the chunking's cache, or finds them and fills the cache. */
static svo_status get_tiles(const run *r, const svo_i_chunk *chunk, svo_i_tile_cache *found)
{
    svo_i_tile_cache *cache = r->chunking->tile_cache;
    if (cache != NULL && cache->begin != NULL) {
        *found = *cache;
        return SVO_OK;
    }
    found->begin = svo_i_alloc_zeroed(&r->commands->device->memory, chunk->draw_count + 1u, sizeof *found->begin);
    if (found->begin == NULL) {
        return svo_i_device_fail(r->commands->device, SVO_OUT_OF_HOST_MEMORY, "svo_build: no memory for %u draws",
                                 chunk->draw_count);
    }
    SVO_I_TRY(make_tiles(r, chunk, &found->tiles, found->begin));
    if (cache != NULL) {
        *cache = *found;
    }
    return SVO_OK;
}

static void free_tiles(const run *r, svo_i_tile_cache *found)
{
    if (r->chunking->tile_cache == NULL || r->chunking->tile_cache->begin != found->begin) {
        svo_i_tiles_free(&found->tiles);
        svo_i_free(found->begin);
    }
}

/* An estimate of the bytes of a chunk's tiles. */
static uint64_t expected_tile_bytes(const run *r, const svo_i_chunk *chunk)
{
    double tiles = 0.0;
    for (uint32_t i = chunk->first_draw; i < chunk->first_draw + chunk->draw_count; ++i) {
        tiles += svo_i_tiles_expected(r->commands->plan, &r->chunking->draws[i]);
    }
    return (uint64_t)tiles * sizeof(svo_tile_item);
}

/* The predicted time of a work-item of a chunk. Chunks have about equal times. */
static double item_ns(const run *r, const svo_i_chunk *chunk, const size_t *tile_begin)
{
    uint64_t ids = tile_begin != NULL ? tile_begin[chunk->draw_count] : 0;
    for (uint32_t i = 0; i < chunk->draw_count; ++i) {
        ids += ids_of_triangles(&r->chunking->draws[chunk->first_draw + i]);
    }
    const double chunk_ns = r->commands->plan->progress.expected_ns[SVO_STAGE_VOXELIZE] / r->chunking->chunk_count;
    return ids > 0 ? chunk_ns / (double)ids : 0.0;
}

/* Decides a chunk's undecided fragments. */
static svo_status decide(run *r, uint32_t chunk_index, cl_mem fragments)
{
    const uint64_t capacity = r->chunking->chunks[chunk_index].capacity;
    if (!svo_i_plan_needs_program(r->commands->plan, &svo_i_program_decide)) {
        return SVO_OK;
    }
    svo_decide_params params = svo_i_decide_params(r->commands->plan);
    params.capacity = (cl_uint)capacity;
    params.counter = chunk_index;
    const svo_i_argument decides[] = {SVO_I_ARGUMENT(r->mesh.positions), SVO_I_ARGUMENT(r->mesh.indices),
                                      SVO_I_ARGUMENT(r->counters), SVO_I_ARGUMENT(fragments), SVO_I_ARGUMENT(params)};
    const svo_i_argument keeps[] = {SVO_I_ARGUMENT(r->counters), SVO_I_ARGUMENT(fragments), SVO_I_ARGUMENT(params),
                                    SVO_I_LOCAL(SCRATCH_BYTES)};
    SVO_I_TRY(svo_i_commands_launch(r->commands, r->decide, SVO_I_ARGUMENTS(decides), capacity / DECIDE_RUN + 1));
    return svo_i_commands_launch(r->commands, r->keep_decided, SVO_I_ARGUMENTS(keeps), SVO_GROUP_ITEMS);
}

/* Launches the draws of a chunk. tile_begin: NULL if there are no tiles. */
static svo_status launch_draws(run *r, uint32_t chunk_index, const size_t *tile_begin, cl_mem tiles, cl_mem fragments)
{
    const svo_i_chunk *chunk = &r->chunking->chunks[chunk_index];
    svo_i_commands_stage(r->commands, SVO_STAGE_VOXELIZE, item_ns(r, chunk, tile_begin));
    svo_i_stage_begin(r->commands);
    for (uint32_t i = 0; i < chunk->draw_count; ++i) {
        const size_t first = tile_begin != NULL ? tile_begin[i] : 0;
        const size_t end = tile_begin != NULL ? tile_begin[i + 1] : 0;
        const svo_voxelize_params params = {.first_tile = (uint32_t)first,
                                            .tile_count = (uint32_t)(end - first),
                                            .capacity = (uint32_t)chunk->capacity,
                                            .counter = chunk_index};
        SVO_I_TRY(launch(r, &r->chunking->draws[chunk->first_draw + i], params, tiles, fragments));
    }
    SVO_I_TRY(decide(r, chunk_index, fragments));
    return svo_i_stage_end(r->commands, SVO_STAGE_VOXELIZE);
}

/* Buffers for the tiles of large triangles of plans whose mesh the host does not see. */
typedef struct moving_tiles {
    cl_mem vertices, indices, items, counters;
    cl_mem tiles; /* has room for svo_i_update_tiles_max */
    cl_mem count;
} moving_tiles;

/* Lists the tiles of a draw in place of those before (kernels/plan/tiles.cl). params: of the draw; tile_count is the
   room. */
static svo_status list_tiles(svo_i_commands *commands, const moving_tiles *buffers, const svo_voxelize_params *params)
{
    cl_program program = NULL;
    const svo_tile_item unused = {commands->plan->class_begin[SVO_I_CLASS_COUNT], 0};
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(buffers->vertices),
                                        SVO_I_ARGUMENT(buffers->indices),
                                        SVO_I_ARGUMENT(buffers->items),
                                        SVO_I_ARGUMENT(buffers->tiles),
                                        SVO_I_ARGUMENT(buffers->count),
                                        SVO_I_ARGUMENT(buffers->counters),
                                        SVO_I_ARGUMENT(*params)};
    SVO_I_TRY(svo_i_program_get(commands->device, SVO_I_BUILD, &svo_i_program_plan, "", &program, NULL));
    SVO_I_TRY(svo_i_commands_fill(commands, buffers->tiles, &unused, sizeof unused,
                                  (uint64_t)params->tile_count * sizeof unused));
    SVO_I_TRY(svo_i_commands_fill_zero(commands, buffers->count, sizeof(cl_uint)));
    return svo_i_commands_run(commands, program, "svo_k_plan_tiles", SVO_I_ARGUMENTS(arguments), params->item_count);
}

/* Launches the draws of an updatable plan, each after its tiles. Triangles inside one voxel are never large. */
static svo_status launch_moving_draws(run *r, uint32_t chunk_index, uint64_t room, moving_tiles *tiles,
                                      cl_mem fragments)
{
    const svo_i_chunk *chunk = &r->chunking->chunks[chunk_index];
    svo_i_commands_stage(r->commands, SVO_STAGE_VOXELIZE, item_ns(r, chunk, NULL));
    svo_i_stage_begin(r->commands);
    for (uint32_t i = 0; i < chunk->draw_count; ++i) {
        const svo_i_draw *draw = &r->chunking->draws[chunk->first_draw + i];
        svo_voxelize_params params = {.tile_count = draw->class_id != SVO_I_CLASS_POINT ? (uint32_t)room : 0,
                                      .capacity = (uint32_t)chunk->capacity,
                                      .counter = chunk_index};
        describe(r, draw, &params);
        if (params.tile_count > 0) {
            SVO_I_TRY(list_tiles(r->commands, tiles, &params));
        }
        SVO_I_TRY(launch(r, draw, params, tiles->tiles, fragments));
    }
    SVO_I_TRY(decide(r, chunk_index, fragments));
    return svo_i_stage_end(r->commands, SVO_STAGE_VOXELIZE);
}

static svo_status draw_moving_chunk(run *r, uint32_t chunk_index, svo_i_fragments *out)
{
    svo_status status = SVO_OK;
    const uint64_t room = svo_i_update_tiles_max(r->chunking->chunks[chunk_index].capacity);
    moving_tiles tiles = {
        .vertices = r->mesh.vertices, .indices = r->mesh.indices, .items = r->items, .counters = r->counters};
    SVO_I_TRY_CLEANUP(svo_i_commands_alloc(r->commands, "mesh_tiles", room * sizeof(svo_tile_item), &tiles.tiles));
    SVO_I_TRY_CLEANUP(svo_i_commands_alloc(r->commands, "tile_count", sizeof(cl_uint), &tiles.count));
    SVO_I_TRY_CLEANUP(launch_moving_draws(r, chunk_index, room, &tiles, out->buffer));
cleanup:
    svo_i_commands_free(r->commands, &tiles.count);
    svo_i_commands_free(r->commands, &tiles.tiles);
    return status;
}

/* Allocates the buffer of a chunk. In SVO_I_MODE_RUN the caller adds it to the plan's list, for every front end. */
static svo_status alloc_fragments(run *r, svo_i_fragments *out)
{
    const uint64_t bytes = out->capacity * svo_i_plan_fragment_bytes(r->commands->plan);
    return r->commands->mode == SVO_I_MODE_RUN ? svo_i_device_buffer(r->commands->device, SVO_I_BUILD, "fragments",
                                                                     CL_MEM_READ_WRITE, (size_t)bytes, &out->buffer)
                                               : svo_i_commands_alloc(r->commands, "fragments", bytes, &out->buffer);
}

/* Uploads a chunk's tiles and launches its draws. The time to find the tiles counts as transfer. A measuring build
   estimates their number, unless there is a cache. */
static svo_status draw_chunk(run *r, uint32_t chunk_index, svo_i_fragments *out)
{
    svo_status status = SVO_OK;
    const svo_i_chunk *chunk = &r->chunking->chunks[chunk_index];
    const bool estimates = r->commands->mode == SVO_I_MODE_MEASURE && r->chunking->tile_cache == NULL;
    svo_i_tile_cache found = {0};
    cl_mem tile_buffer = NULL;
    uint64_t bytes = estimates ? expected_tile_bytes(r, chunk) : 0;
    const double start_ms = svo_i_now_ms();
    if (!estimates) {
        SVO_I_TRY_CLEANUP(get_tiles(r, chunk, &found));
        bytes = found.tiles.count * sizeof *found.tiles.items;
    }
    svo_i_report_add(r->commands->report, SVO_STAGE_TRANSFER, svo_i_now_ms() - start_ms, "wall");
    svo_i_stage_begin(r->commands);
    SVO_I_TRY_CLEANUP(svo_i_commands_upload(r->commands, "mesh_tiles", found.tiles.items, bytes, &tile_buffer));
    SVO_I_TRY_CLEANUP(svo_i_stage_end(r->commands, SVO_STAGE_TRANSFER));
    SVO_I_TRY_CLEANUP(launch_draws(r, chunk_index, found.begin, tile_buffer, out->buffer));
    SVO_I_TRY_CLEANUP(svo_i_commands_wait(r->commands)); /* for the tiles' upload */
cleanup:
    if (status != SVO_OK && r->commands->mode == SVO_I_MODE_RUN && r->commands->last != NULL) {
        (void)svo_i_event_settle(r->commands->last);
    }
    svo_i_commands_free(r->commands, &tile_buffer);
    free_tiles(r, &found);
    return status;
}

/* Reads the counts, in SVO_I_MODE_RUN. */
static svo_status read_counters(run *r, svo_i_fragment_list *list)
{
    const size_t bytes = ((size_t)list->chunk_count + 1) * SVO_COUNTER_WORDS * sizeof(cl_uint);
    cl_uint *counters = svo_i_alloc_zeroed(&r->commands->device->memory, 1, bytes);
    if (counters == NULL) {
        return svo_i_device_fail(r->commands->device, SVO_OUT_OF_HOST_MEMORY, "svo_build: no memory for %u counters",
                                 list->chunk_count);
    }
    svo_i_stage_begin(r->commands);
    const svo_status status = svo_i_commands_read(r->commands, r->counters, counters, bytes);
    r->commands->report->undecided = r->adds ? r->commands->report->undecided : 0;
    for (size_t i = 0; i < list->chunk_count; ++i) {
        const cl_uint *own = counters + SVO_COUNTER_WORDS * i;
        list->chunks[i].needed = (uint64_t)own[1] << 32 | own[0];
        r->commands->report->undecided += (uint64_t)own[3] << 32 | own[2];
    }
    svo_i_free(counters);
    SVO_I_TRY(status);
    svo_i_commands_free(r->commands, &r->counters);
    return svo_i_stage_end(r->commands, SVO_STAGE_TRANSFER);
}

static void release_run(run *r)
{
    svo_i_build_mesh_listed(r->commands);
    svo_i_commands_free(r->commands, &r->items);
    for (svo_i_test test = 0; test < SVO_I_TEST_COUNT; ++test) {
        if (r->kernels[test] != NULL) {
            clReleaseKernel(r->kernels[test]);
        }
    }
    if (r->decide != NULL) {
        clReleaseKernel(r->decide);
    }
    if (r->keep_decided != NULL) {
        clReleaseKernel(r->keep_decided);
    }
}

/* Makes the list. Counts go to chunks[i].needed, or in modes that do not wait remain in the counters. */
static svo_status make_list(run *r, svo_i_fragment_list *list)
{
    SVO_I_TRY(create_kernels(r));
    for (uint32_t i = 0; i < r->chunking->chunk_count && !r->adds; ++i) {
        list->chunks[i].capacity = r->chunking->chunks[i].capacity;
        list->chunks[i].needed = list->chunks[i].capacity;
        SVO_I_TRY(alloc_fragments(r, &list->chunks[i]));
    }
    SVO_I_TRY(upload(r, list));
    for (uint32_t i = 0; i < r->chunking->chunk_count; ++i) {
        SVO_I_TRY(r->commands->plan->update != NULL ? draw_moving_chunk(r, i, &list->chunks[i])
                                                    : draw_chunk(r, i, &list->chunks[i]));
    }
    return r->commands->mode == SVO_I_MODE_RUN ? read_counters(r, list) : SVO_OK;
}

static svo_status voxelize(run *r, svo_i_fragment_list *list)
{
    svo_i_commands_stage(r->commands, SVO_STAGE_VOXELIZE, 0.0);
    const svo_status status = make_list(r, list);
    list->counters = r->counters;
    release_run(r);
    return status;
}

svo_status svo_i_voxelize(void *self, svo_i_commands *commands, const svo_i_chunking *chunking,
                          svo_i_fragment_list *list)
{
    (void)self;
    run r = {.commands = commands, .chunking = chunking};
    return voxelize(&r, list);
}

svo_status svo_i_voxelize_more(svo_i_commands *commands, const svo_i_chunking *chunking, svo_i_fragment_list *list)
{
    run r = {.commands = commands, .chunking = chunking, .adds = true};
    return voxelize(&r, list);
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
    const cl_int error =
        clGetDeviceInfo(device->device, CL_DEVICE_LOCAL_MEM_SIZE, sizeof local_bytes, &local_bytes, NULL);
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(device, "svo_frontend_create_cl", "clGetDeviceInfo", error);
    }
    const size_t needed = words_bytes(device) + SCRATCH_BYTES;
    if (local_bytes < needed) {
        return svo_i_device_fail(device, SVO_UNSUPPORTED,
                                 "svo_frontend_create_cl: %s has %llu bytes of local memory, below %zu", device->name,
                                 (unsigned long long)local_bytes, needed);
    }
    svo_frontend *frontend = svo_i_alloc_zeroed(&device->memory, 1, sizeof *frontend);
    if (frontend == NULL) {
        return svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, "svo_frontend_create_cl: no memory for the handle");
    }
    *frontend = (svo_frontend){.name = "cl",
                               .share = "none",
                               .self = frontend,
                               .device = device,
                               .chunk_bytes_max = device->max_allocation_bytes,
                               .prepare = svo_i_voxelize_prepare,
                               .on_device = true,
                               .voxelize = svo_i_voxelize,
                               .release = release,
                               .destroy = svo_i_free};
    *out = frontend;
    return SVO_OK;
}
