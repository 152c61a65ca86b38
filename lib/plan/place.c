/* SPDX-License-Identifier: MIT */
/* Chooses where a plan is made. Loading the kernels takes tens of milliseconds, so small meshes stay on the host. */
#include "plan/place.h"

#include "core/opencl.h"
#include "plan/attributes.h"
#include "plan/device_attributes.h"
#include "plan/device_grid.h"
#include "plan/grid.h"
#include "plan/host_copy.h"
#include "plan/part.h"
#include "plan/positions.h"
#include "plan/update_create.h"

const char *svo_place_name(svo_place place)
{
    static const char *const names[] = {"default", "host", "device"};
    return (unsigned)place <= SVO_PLACE_DEVICE ? names[place] : "unknown place";
}

/* Whether the device's doubles are those of the host: with denormals, rounded to nearest; floats with denormals. */
static svo_status find_doubles(svo_device *device, const char *function, bool *has_doubles)
{
    const cl_device_fp_config needed = CL_FP_DENORM | CL_FP_INF_NAN | CL_FP_ROUND_TO_NEAREST;
    cl_device_fp_config doubles = 0;
    cl_device_fp_config floats = 0;
    SVO_I_TRY(svo_i_device_property(device->device, CL_DEVICE_DOUBLE_FP_CONFIG, sizeof doubles, &doubles, function,
                                    &device->message));
    SVO_I_TRY(svo_i_device_property(device->device, CL_DEVICE_SINGLE_FP_CONFIG, sizeof floats, &floats, function,
                                    &device->message));
    *has_doubles = (doubles & needed) == needed && (floats & needed) == needed;
    return SVO_OK;
}

/* Whether kernels are likely quicker. A handle with a budget has its memory for builds. */
static bool prefers_kernels(svo_device *device, const char *function, uint64_t triangles)
{
    bool has_doubles = false;
    if (device->budget != NULL || triangles < SVO_I_KERNEL_TRIANGLES_MIN) {
        return false;
    }
    device->planned_triangles += triangles;
    return (svo_i_program_known(device, SVO_I_PROGRAM_PLAN, "") || device->planned_triangles >= SVO_I_LOAD_TRIANGLES) &&
           find_doubles(device, function, &has_doubles) == SVO_OK && has_doubles;
}

static svo_status take_on_host(svo_plan *plan, const svo_i_plan_input *input)
{
    plan->info.place = SVO_PLACE_HOST;
    SVO_I_TRY(svo_i_plan_grid(plan, &input->mesh));
    SVO_I_TRY(svo_i_plan_attributes(plan, &input->mesh));
    svo_i_part_name_triangles(plan);
    return svo_i_plan_positions(plan, &input->mesh);
}

static svo_status run_kernels(svo_plan *plan, svo_i_device_work *work, const svo_i_plan_input *input,
                              svo_i_device_mesh *mesh)
{
    SVO_I_TRY(svo_i_work_use(work, SVO_I_PROGRAM_PLAN, ""));
    SVO_I_TRY(svo_i_device_mesh_geometry(work, input, mesh));
    SVO_I_TRY(svo_i_device_grid(plan, work, input, mesh));
    return svo_i_device_attributes(plan, work, input, mesh);
}

static svo_status take_on_device(svo_plan *plan, const svo_i_plan_input *input)
{
    svo_i_device_work work;
    svo_i_device_mesh mesh = {0};
    bool has_doubles = false;
    plan->info.place = SVO_PLACE_DEVICE;
    SVO_I_TRY(find_doubles(plan->device, plan->progress.function, &has_doubles));
    if (!has_doubles) {
        return svo_i_device_fail(plan->device, SVO_UNSUPPORTED,
                                 "%s: %s has no doubles with denormals, which a plan's kernels need",
                                 plan->progress.function, plan->device->name);
    }
    SVO_I_TRY(svo_i_work_begin(plan->device, plan->progress.function, input->queue, &work));
    work.wait_count = input->wait_count;
    work.wait = input->wait;
    const svo_status status = plan->options.updatable != 0 ? svo_i_update_create(plan, &work, input, &mesh)
                                                           : run_kernels(plan, &work, input, &mesh);
    svo_i_work_end(&work);
    svo_i_device_mesh_free(&mesh);
    return status;
}

/* Frees what an attempt has left, and restores the plan from before it. */
static void start_over(svo_plan *plan, const svo_plan *before)
{
    const svo_i_progress progress = plan->progress;
    svo_i_plan_memory_free(&plan->memory);
    svo_i_free(plan->large);
    svo_i_free(plan->materials);
    svo_i_free(plan->texels);
    *plan = *before;
    plan->progress = progress;
}

svo_status svo_i_plan_take_mesh(svo_plan *plan, const svo_i_plan_input *input)
{
    const svo_plan before = *plan;
    if (plan->options.place == SVO_PLACE_DEVICE || plan->options.updatable != 0 || input->buffers != NULL) {
        return take_on_device(plan, input);
    }
    if (plan->options.place == SVO_PLACE_HOST || svo_i_plan_is_part(plan) ||
        !prefers_kernels(plan->device, plan->progress.function, input->mesh.triangle_count)) {
        return take_on_host(plan, input);
    }
    const svo_status status = take_on_device(plan, input);
    if (status != SVO_OUT_OF_DEVICE_MEMORY && status != SVO_COMPILE_FAILED) {
        return status;
    }
    start_over(plan, &before);
    return take_on_host(plan, input);
}
