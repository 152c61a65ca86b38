/* SPDX-License-Identifier: MIT */
/* svo_plan_create and its twin for buffers: create a plan and predict what its build allocates. */
#include "core/struct_size.h"
#include "pipeline/measure.h"
#include "pipeline/stage_table.h"
#include "plan/accounts.h"
#include "plan/plan.h"

static svo_status check_arguments(svo_device *device, const char *function, const char *mesh_name, const void *mesh,
                                  svo_plan *const *out)
{
    return device != NULL && mesh != NULL && out != NULL
               ? SVO_OK
               : svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: %s is NULL", function,
                                   device == NULL ? "device"
                                   : mesh == NULL ? mesh_name
                                                  : "out");
}

static svo_status create(svo_device *device, const char *function, const svo_i_plan_input *input, unsigned depth,
                         const svo_plan_options *options, svo_plan **out)
{
    svo_i_stage_list stages = {0};
    svo_plan *plan = NULL;
    svo_status status = SVO_OK;
    stages.rows = svo_i_stage_table(&stages.count);
    SVO_I_TRY(svo_i_plan_new(device, function, input, depth, options, &stages, &plan));
    SVO_I_TRY_CLEANUP(svo_i_progress_reach(plan, SVO_STAGE_GRID, 1.0));
    SVO_I_TRY_CLEANUP(svo_i_predict(plan));
    SVO_I_TRY_CLEANUP(svo_i_progress_end(plan, SVO_STAGE_GRID));
    *out = plan;
    return SVO_OK;
cleanup:
    svo_plan_destroy(&plan);
    return status;
}

svo_status svo_plan_create(svo_device *device, const svo_mesh *mesh, unsigned depth, const svo_plan_options *options,
                           svo_plan **out)
{
    static const char function[] = "svo_plan_create";
    svo_i_plan_input input = {0};
    SVO_I_TRY(check_arguments(device, function, "mesh", mesh, out));
    SVO_I_TRY(svo_i_struct_read(&device->message, function, "mesh", mesh, &input.mesh,
                                SVO_I_STRUCT_SIZES(svo_mesh, triangle_count)));
    return create(device, function, &input, depth, options, out);
}

svo_status svo_plan_create_from_buffers(svo_device *device, const svo_mesh_buffers *buffers, unsigned depth,
                                        const svo_plan_options *options, cl_command_queue queue, cl_uint num_wait,
                                        const cl_event *wait, svo_plan **out)
{
    static const char function[] = "svo_plan_create_from_buffers";
    svo_mesh_buffers given;
    SVO_I_TRY(check_arguments(device, function, "buffers", buffers, out));
    SVO_I_TRY(svo_i_struct_read(&device->message, function, "buffers", buffers, &given,
                                SVO_I_STRUCT_SIZES(svo_mesh_buffers, indices)));
    const svo_i_plan_input input = {.mesh = {.vertex_count = given.vertex_count,
                                             .triangle_count = given.triangle_count,
                                             .materials = given.materials,
                                             .material_count = given.material_count,
                                             .textures = given.textures,
                                             .texture_count = given.texture_count},
                                    .buffers = &given,
                                    .queue = queue,
                                    .wait_count = num_wait,
                                    .wait = wait};
    return create(device, function, &input, depth, options, out);
}
