/* SPDX-License-Identifier: MIT */
/* Cones for batches of points: options and checks, then rays/batch.c launches kernels/light/gather.cl. */
#include <math.h>

#include "core/struct_size.h"
#include "light/gather.h"
#include "light/programs.h"
#include "rays/batch.h"

#define CONES_DEFAULT   16u
#define CONES_PUBLISHED 5u
#define STEP_DEFAULT    0.5F
#define STEP_MIN        0.25F
#define STEP_MAX        1.0F

const char *svo_i_gather_defines(const svo_light *light)
{
    static const char *const defines[SVO_LIGHT_FORM_COUNT] = {" -DSVO_LIGHT_FACES", " -DSVO_LIGHT_BRICKS",
                                                              " -DSVO_LIGHT_VOXELS"};
    return defines[light->info.form];
}

/* ---- options ---- */

static bool is_set_of_cones(uint32_t cones)
{
    return cones == 1 || cones == 5 || cones == 6 || cones == 16 || cones == 64;
}

static svo_status check_march(const svo_light *light, const char *function, const svo_gather_options *options)
{
    if ((unsigned)options->march > SVO_MARCH_PUBLISHED) {
        return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT, "%s: options.march %d is not in 0 .. %d",
                                 function, (int)options->march, (int)SVO_MARCH_PUBLISHED);
    }
    if (options->march == SVO_MARCH_PUBLISHED && light->info.form != SVO_LIGHT_BRICKS) {
        return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT,
                                 "%s: options.march 1 (published) needs the form bricks, and the light has %s",
                                 function, svo_light_form_name(light->info.form));
    }
    if (options->march == SVO_MARCH_PUBLISHED && options->cones != CONES_PUBLISHED && options->cones != 0) {
        return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT,
                                 "%s: options.cones %u is not %u, which options.march 1 (published) takes", function,
                                 options->cones, CONES_PUBLISHED);
    }
    return options->cones == 0 || is_set_of_cones(options->cones)
               ? SVO_OK
               : svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT, "%s: options.cones %u is not 1, 5, 6, 16 or 64",
                                   function, options->cones);
}

static svo_status check_lengths(const svo_light *light, const char *function, const svo_gather_options *options)
{
    const bool step = options->step >= STEP_MIN && options->step <= STEP_MAX;
    if (!step && options->step != 0.0F) {
        return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT, "%s: options.step %g is not in %g .. %g",
                                 function, (double)options->step, (double)STEP_MIN, (double)STEP_MAX);
    }
    if (!(options->range >= 0.0F) || !isfinite(options->range)) {
        return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT, "%s: options.range %g is negative or not finite",
                                 function, (double)options->range);
    }
    return options->falloff >= 0.0F && isfinite(options->falloff)
               ? SVO_OK
               : svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT,
                                   "%s: options.falloff %g is negative or not finite", function,
                                   (double)options->falloff);
}

svo_status svo_i_gather_params(const svo_light *light, const char *function, const svo_gather_options *options,
                               svo_gather_params *params)
{
    svo_gather_options asked;
    SVO_I_TRY(svo_i_struct_read(svo_i_device_message(light->device), function, "options", options, &asked,
                                SVO_I_STRUCT_SIZES(svo_gather_options, no_light)));
    SVO_I_TRY(check_march(light, function, &asked));
    SVO_I_TRY(check_lengths(light, function, &asked));
    const bool published = asked.march == SVO_MARCH_PUBLISHED;
    *params = (svo_gather_params){.cones = published          ? CONES_PUBLISHED
                                           : asked.cones != 0 ? asked.cones
                                                              : CONES_DEFAULT,
                                  .published = published,
                                  .step = asked.step > 0.0F ? asked.step : STEP_DEFAULT,
                                  .range = asked.range,
                                  .falloff = asked.falloff,
                                  .with_light = asked.no_light == 0};
    return SVO_OK;
}

/* ---- batches ---- */

/* The checks of a batch need no more than a light. */
static svo_status check_target(void *of, const char *function)
{
    const svo_light *light = of;
    return svo_i_tree_check(light->tree, function);
}

static svo_status set_target(void *of, const char *function, cl_kernel kernel, cl_uint first_index)
{
    return svo_i_light_set_args(of, function, kernel, first_index);
}

/* params: lives as long as the batch. */
static svo_i_batch batch_of(svo_light *light, const char *function, size_t point_count, const svo_gather_params *params)
{
    return (svo_i_batch){.device = light->device,
                         .function = function,
                         .target = {light, SVO_LIGHT_ARGUMENTS, check_target, set_target},
                         .program = &svo_i_program_gather,
                         .kernel_name = "svo_k_gather",
                         .defines = svo_i_gather_defines(light),
                         .input_name = "points",
                         .output_name = "results",
                         .input_bytes = sizeof(svo_gather_point),
                         .output_bytes = sizeof(svo_gather_result),
                         .count = point_count,
                         .per_item = 1,
                         .last_argument = {sizeof *params, params, false}};
}

/* Checks the options and fills the batch, which refers to params. */
static svo_status prepare(svo_light *light, const char *function, size_t point_count, const svo_gather_options *options,
                          svo_gather_params *params, svo_i_batch *out)
{
    if (light == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    SVO_I_TRY(svo_i_gather_params(light, function, options, params));
    *out = batch_of(light, function, point_count, params);
    return SVO_OK;
}

svo_status svo_gather_enqueue(svo_light *light, cl_mem points, cl_mem results, size_t point_count,
                              const svo_gather_options *options, cl_command_queue queue, cl_uint num_wait,
                              const cl_event *wait, cl_event *event)
{
    svo_gather_params params;
    svo_i_batch asked;
    SVO_I_TRY(prepare(light, "svo_gather_enqueue", point_count, options, &params, &asked));
    return svo_i_batch_enqueue(&asked, points, results, queue, num_wait, wait, event);
}

svo_status svo_gather(svo_light *light, const svo_gather_point *points, svo_gather_result *results, size_t point_count,
                      const svo_gather_options *options, cl_command_queue queue)
{
    svo_gather_params params;
    svo_i_batch asked;
    SVO_I_TRY(prepare(light, "svo_gather", point_count, options, &params, &asked));
    return svo_i_batch_run(&asked, points, results, queue);
}
