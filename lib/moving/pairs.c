/* SPDX-License-Identifier: MIT */
/*
 * Makes an object's pairs by the stages of a build: the front end "cl" and the sort of the builder "sorted". Then
 * kernels/moving/weigh.cl evaluates each pair once.
 */
#include "moving/pairs.h"

#include <stdio.h>

#include "build/list.h"
#include "build/order.h"
#include "core/work.h"
#include "plan/buffers.h"
#include "plan/configuration.h"
#include "plan/estimate.h"
#include "stages/payload_params.h"
#include "stages/sort.h"

/* ---- lists ---- */

void svo_i_kept_list_free(svo_i_kept_list *list)
{
    svo_i_buffer_release(&list->fragments);
    svo_i_buffer_release(&list->values);
    svo_i_buffer_release(&list->materials);
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
    *out = (svo_i_kept_list){
        .fragments = build->list.chunks[0].buffer, .count = build->fragment_count, .capacity = build->fragment_count};
    build->list.chunks[0].buffer = NULL;
}

/* The next voxelization has room for as many fragments, and an eighth more. */
static void remember_room(svo_plan *plan, uint64_t fragments)
{
    const uint64_t room = fragments + fragments / 8 + 1024;
    plan->options.fragment_capacity = room < SVO_I_FRAGMENTS_MAX ? room : SVO_I_FRAGMENTS_MAX;
}

svo_status svo_i_moving_voxelize(svo_moving *moving, uint32_t index, cl_command_queue queue, svo_i_kept_list *out)
{
    svo_plan *plan = moving->objects[index].plan;
    svo_status status = SVO_OK;
    svo_build_report report = {0};
    svo_i_build build = {.commands = svo_i_commands_begin(plan, queue, &report), .frontend = moving->frontend};
    build.commands.untimed = true;
    char defines[SVO_I_DEFINES_BYTES];
    svo_i_plan_buffers_reset(plan);
    svo_i_plan_defines(plan, SVO_I_PROGRAM_SORT, defines, sizeof defines);
    SVO_I_TRY_CLEANUP(svo_i_program_get(moving->device, SVO_I_BUILD, SVO_I_PROGRAM_SORT, defines,
                                        &build.programs[SVO_I_PROGRAM_SORT], NULL));
    SVO_I_TRY_CLEANUP(svo_i_list_make(&build));
    remember_room(plan, build.fragment_count);
    SVO_I_TRY_CLEANUP(svo_i_sort(&build));
    SVO_I_TRY_CLEANUP(svo_i_commands_wait(&build.commands));
    take_list(&build, out);
cleanup:
    svo_i_commands_end(&build.commands);
    svo_i_stage_collect(&build.commands);
    svo_i_order_release_scratch(&build);
    return status;
}

/* ---- weights ---- */

svo_status svo_i_moving_program(const svo_moving *moving, const char *function, cl_program *out)
{
    char of_filter[SVO_I_DEFINES_BYTES] = "";
    char defines[SVO_I_DEFINES_BYTES + 16];
    svo_i_plan_defines(&moving->whole, SVO_I_PROGRAM_FILTER, of_filter, sizeof of_filter);
    (void)snprintf(defines, sizeof defines, " -DSVO_SORT%s", of_filter);
    return svo_i_program_get(moving->device, function, SVO_I_PROGRAM_MOVING, defines, out, NULL);
}

static svo_status launch_weigh(const svo_moving *moving, uint32_t index, svo_i_device_work *work,
                               const svo_i_kept_list *list)
{
    const svo_plan *plan = moving->objects[index].plan;
    const svo_i_plan_memory *memory = &plan->memory;
    const svo_filter_params filter = {
        .depth = plan->info.depth, .voxel_log2 = plan->voxel_log2, .weight_log2 = plan->weight_log2};
    const svo_moving_params params = {.count = (cl_uint)list->count, .object = index};
    const svo_i_argument arguments[] = {
        SVO_I_ARGUMENT(list->fragments), SVO_I_ARGUMENT(memory->vertices),  SVO_I_ARGUMENT(memory->indices),
        SVO_I_ARGUMENT(memory->records), SVO_I_ARGUMENT(memory->colors),    SVO_I_ARGUMENT(memory->normals),
        SVO_I_ARGUMENT(memory->uvs),     SVO_I_ARGUMENT(moving->materials), SVO_I_ARGUMENT(moving->texels),
        SVO_I_ARGUMENT(list->values),    SVO_I_ARGUMENT(list->materials),   SVO_I_ARGUMENT(filter),
        SVO_I_ARGUMENT(params)};
    const uint64_t per_item = plan->work.pair_lanes ? SVO_GROUP_ITEMS : 1;
    return svo_i_work_launch(work, "svo_k_moving_weigh", SVO_I_ARGUMENTS(arguments),
                             (list->count + per_item - 1) / per_item);
}

svo_status svo_i_moving_weigh(svo_moving *moving, const char *function, uint32_t index, cl_command_queue queue,
                              svo_i_kept_list *list)
{
    svo_status status = SVO_OK;
    svo_i_device_work work = {.device = NULL};
    SVO_I_TRY(svo_i_work_begin(moving->device, function, queue, &work));
    SVO_I_TRY_CLEANUP(svo_i_moving_program(moving, function, &work.program));
    SVO_I_TRY_CLEANUP(alloc_values(moving, function, list->count, list));
    SVO_I_TRY_CLEANUP(launch_weigh(moving, index, &work, list));
    SVO_I_TRY_CLEANUP(svo_i_work_wait(&work));
cleanup:
    svo_i_work_end(&work);
    return status;
}
