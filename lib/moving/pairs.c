/* SPDX-License-Identifier: MIT */
/*
 * Makes an object's pairs by the stages of a build: the front end "cl" and the sort of the builder "sorted". Then
 * kernels/moving/weigh.cl evaluates each pair once.
 */
#include "moving/pairs.h"

#include "moving/chain.h"
#include "pipeline/build.h"
#include "pipeline/run.h"
#include "plan/accounts.h"
#include "plan/chunking.h"
#include "plan/configuration.h"
#include "plan/estimate.h"
#include "stages/inputs.h"
#include "stages/sort.h"

/* ---- lists ---- */

void svo_i_kept_list_free(svo_i_kept_list *list)
{
    svo_i_buffer_release(&list->fragments);
    svo_i_buffer_release(&list->values);
    svo_i_buffer_release(&list->materials);
    svo_i_buffer_release(&list->areas);
    svo_i_buffer_release(&list->marks);
    svo_i_buffer_release(&list->counted);
    *list = (svo_i_kept_list){.count = 0};
}

static bool needs_materials(const svo_moving *moving)
{
    return (moving->whole.work.made & SVO_NEED_MATERIAL) != 0;
}

/* Makes the buffers of the values. */
static svo_status alloc_values(const svo_moving *moving, const char *function, uint64_t capacity, svo_i_kept_list *list)
{
    SVO_I_TRY(svo_i_device_buffer(moving->device, function, "values", CL_MEM_READ_WRITE,
                                  (size_t)capacity * SVO_KEPT_WORDS * sizeof(cl_uint), &list->values));
    if (svo_i_moving_has_areas(moving)) {
        SVO_I_TRY(svo_i_device_buffer(moving->device, function, "pair_areas", CL_MEM_READ_WRITE,
                                      (size_t)capacity * SVO_KEPT_AREA_WORDS * sizeof(cl_uint), &list->areas));
    }
    return needs_materials(moving) ? svo_i_device_buffer(moving->device, function, "pair_materials", CL_MEM_READ_WRITE,
                                                         (size_t)capacity * sizeof(cl_uint), &list->materials)
                                   : SVO_OK;
}

svo_status svo_i_kept_list_alloc(const svo_moving *moving, const char *function, uint64_t capacity,
                                 svo_i_kept_list *out)
{
    svo_status status = SVO_OK;
    svo_i_kept_list made = {.capacity = capacity};
    SVO_I_TRY_CLEANUP(svo_i_device_buffer(moving->device, function, "fragments", CL_MEM_READ_WRITE,
                                          (size_t)capacity * svo_i_plan_fragment_bytes(&moving->whole),
                                          &made.fragments));
    SVO_I_TRY_CLEANUP(alloc_values(moving, function, capacity, &made));
    SVO_I_TRY_CLEANUP(svo_i_device_buffer(moving->device, function, "pair_marks", CL_MEM_READ_WRITE,
                                          (size_t)svo_i_kept_list_marks(capacity) * sizeof(cl_uint), &made.marks));
    *out = made;
    return SVO_OK;
cleanup:
    svo_i_kept_list_free(&made);
    return status;
}

/* ---- voxelization ---- */

/* Takes the sorted list out of a build, which would release it. */
static void take_list(svo_i_build *build, svo_i_kept_list *out)
{
    out->fragments = build->list.chunks[0].buffer;
    out->count = build->fragment_count;
    out->capacity = build->fragment_count;
    build->list.chunks[0].buffer = NULL;
}

void svo_i_moving_remember(svo_i_moving_object *object, uint64_t fragments)
{
    uint64_t *capacity = &object->plan->options.fragment_capacity;
    const uint64_t wanted = fragments + fragments / 8 + 1024;
    const uint64_t room = wanted < SVO_I_FRAGMENTS_MAX ? wanted : SVO_I_FRAGMENTS_MAX;
    *capacity = *capacity > room ? *capacity : room;
}

/* The one chunk of a list whose count stays on the device. */
static svo_status make_chunk(const svo_moving *moving, svo_i_build *build, svo_i_chunking *chunking)
{
    svo_device *device = moving->device;
    const svo_plan *plan = build->commands.plan;
    SVO_I_TRY(svo_i_chunking_create(plan, svo_i_chunk_bytes_max(plan, build->frontend->chunk_bytes_max), chunking));
    if (chunking->chunk_count != 1) {
        return svo_i_device_fail(device, SVO_UNSUPPORTED,
                                 "svo_moving_update_enqueue: the pairs of an object do not fit one buffer of the "
                                 "device");
    }
    build->list.chunks = svo_i_alloc_zeroed(&device->memory, 1, sizeof *build->list.chunks);
    if (build->list.chunks == NULL) {
        return svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, "svo_moving_update_enqueue: no memory for a list");
    }
    build->list.chunk_count = 1;
    build->fragment_count = chunking->chunks[0].capacity;
    return SVO_OK;
}

/* Draws the list with the room that there is. The device counts, and fills up the room. */
static svo_status draw_later(svo_moving *moving, svo_i_build *build, svo_i_pair_count *later, svo_i_kept_list *out)
{
    svo_status status = SVO_OK;
    svo_i_commands *commands = &build->commands;
    svo_i_chunking chunking = {0};
    cl_program program = NULL;
    SVO_I_TRY_CLEANUP(svo_i_moving_program(moving, "svo_moving_update_enqueue", &program));
    SVO_I_TRY_CLEANUP(make_chunk(moving, build, &chunking));
    SVO_I_TRY_CLEANUP(svo_i_frontend_voxelize(build->frontend, commands, &chunking, &build->list));
    SVO_I_TRY_CLEANUP(svo_i_device_buffer(moving->device, "svo_moving_update_enqueue", "pair_count", CL_MEM_READ_WRITE,
                                          sizeof(cl_uint), &out->counted));
    const svo_moving_params params = {.count = (cl_uint)build->fragment_count};
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(build->list.counters),
                                        SVO_I_ARGUMENT(build->list.chunks[0].buffer), SVO_I_ARGUMENT(out->counted),
                                        SVO_I_ARGUMENT(params)};
    later->capacity = build->fragment_count;
    SVO_I_TRY_CLEANUP(svo_i_commands_read(commands, build->list.counters, later->words, sizeof later->words));
    SVO_I_TRY_CLEANUP(
        svo_i_commands_run(commands, program, "svo_k_moving_take", SVO_I_ARGUMENTS(arguments), params.count));
cleanup:
    svo_i_chunking_destroy(&chunking);
    return status;
}

static svo_status draw(svo_moving *moving, uint32_t index, svo_i_build *build)
{
    SVO_I_TRY(svo_i_list_make(build));
    svo_i_moving_remember(&moving->objects[index], build->fragment_count);
    return SVO_OK;
}

svo_status svo_i_moving_voxelize(svo_moving *moving, uint32_t index, svo_i_chain *chain, svo_i_pair_count *later,
                                 svo_i_kept_list *out)
{
    svo_plan *plan = moving->objects[index].plan;
    svo_status status = SVO_OK;
    svo_build_report report = {0};
    svo_i_build build = {.commands = svo_i_chain_begin_commands(chain, plan, &report), .frontend = moving->frontend};
    char defines[SVO_I_DEFINES_BYTES];
    svo_i_plan_buffers_reset(plan);
    svo_i_plan_defines(plan, SVO_I_PROGRAM_SORT, defines, sizeof defines);
    SVO_I_TRY_CLEANUP(svo_i_program_get(moving->device, SVO_I_BUILD, SVO_I_PROGRAM_SORT, defines,
                                        &build.programs[SVO_I_PROGRAM_SORT], NULL));
    SVO_I_TRY_CLEANUP(chain->waits ? draw(moving, index, &build) : draw_later(moving, &build, later, out));
    SVO_I_TRY_CLEANUP(svo_i_sort(&build));
    SVO_I_TRY_CLEANUP(svo_i_commands_wait(&build.commands));
    take_list(&build, out);
cleanup:
    svo_i_chain_end_commands(chain, &build.commands, status);
    svo_i_order_release_scratch(&build);
    return status;
}

/* ---- weights ---- */

static svo_status launch_weigh(const svo_moving *moving, uint32_t index, svo_i_device_work *work,
                               const svo_i_kept_list *list)
{
    const svo_plan *plan = moving->objects[index].plan;
    const svo_i_plan_memory *memory = &plan->memory;
    const svo_filter_params filter = {
        .depth = plan->info.depth, .voxel_log2 = plan->voxel_log2, .weight_log2 = plan->weight_log2};
    const svo_moving_params params = {.count = (cl_uint)list->count, .object = index};
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(list->fragments), SVO_I_ARGUMENT(memory->vertices),
                                        SVO_I_ARGUMENT(memory->indices), SVO_I_ARGUMENT(memory->records),
                                        SVO_I_ARGUMENT(memory->colors),  SVO_I_ARGUMENT(memory->normals),
                                        SVO_I_ARGUMENT(memory->uvs),     SVO_I_ARGUMENT(moving->materials),
                                        SVO_I_ARGUMENT(moving->texels),  SVO_I_ARGUMENT(list->values),
                                        SVO_I_ARGUMENT(list->materials), SVO_I_ARGUMENT(list->counted),
                                        SVO_I_ARGUMENT(filter),          SVO_I_ARGUMENT(params),
                                        SVO_I_ARGUMENT(list->areas)};
    const cl_uint count = (cl_uint)(sizeof arguments / sizeof arguments[0]) - (list->areas != NULL ? 0 : 1);
    const uint64_t per_item = plan->work.pair_lanes ? SVO_GROUP_ITEMS : 1;
    return svo_i_work_launch(work, "svo_k_moving_weigh", arguments, count, (list->count + per_item - 1) / per_item);
}

svo_status svo_i_moving_weigh(svo_moving *moving, uint32_t index, svo_i_chain *chain, svo_i_kept_list *list)
{
    svo_status status = SVO_OK;
    svo_i_device_work work = {.device = NULL};
    SVO_I_TRY(svo_i_chain_begin(chain, moving, &work));
    SVO_I_TRY_CLEANUP(alloc_values(moving, chain->function, list->count, list));
    SVO_I_TRY_CLEANUP(launch_weigh(moving, index, &work, list));
cleanup:
    return svo_i_chain_end(chain, &work, status);
}
