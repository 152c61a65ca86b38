/* SPDX-License-Identifier: MIT */
/* Probes in kernels: rays through them and their diffuse light, in batches that rays/batch.c launches
   (kernels/probes/trace.cl, gather.cl), and the caller's kernels. */
#include <math.h>

#include "core/struct_size.h"
#include "probes/handle.h"
#include "probes/programs.h"
#include "rays/batch.h"
#include "rays/target.h"

/* Of kernels/probes: choose.clh, diffuse.clh. */
extern const char svo_i_source_light_field[];

/* ---- the target ---- */

/* Batches read the probes alone, which were made whole. */
static svo_status check_target(void *of, const char *function)
{
    (void)of;
    (void)function;
    return SVO_OK;
}

static svo_status set_target(void *of, const char *function, cl_kernel kernel, cl_uint first_index)
{
    const svo_probes *probes = of;
    const svo_i_argument arguments[SVO_PROBES_ARGUMENTS] = {SVO_I_ARGUMENT(probes->buffers[SVO_PROBES_PLACES]),
                                                            SVO_I_ARGUMENT(probes->buffers[SVO_PROBES_TEXELS]),
                                                            SVO_I_ARGUMENT(probes->buffers[SVO_PROBES_LEAST]),
                                                            SVO_I_ARGUMENT(probes->buffers[SVO_PROBES_FIELD]),
                                                            SVO_I_ARGUMENT(probes->buffers[SVO_PROBES_IRRADIANCE]),
                                                            SVO_I_ARGUMENT(probes->buffers[SVO_PROBES_MOMENTS]),
                                                            SVO_I_ARGUMENT(probes->sky_map),
                                                            SVO_I_ARGUMENT(probes->params)};
    return svo_i_kernel_set_from(probes->device, function, kernel, first_index, arguments, SVO_PROBES_ARGUMENTS);
}

/* Probes as the target of batches. */
static svo_i_ray_target target_of(svo_probes *probes)
{
    return (svo_i_ray_target){probes, SVO_PROBES_ARGUMENTS, check_target, set_target};
}

/* ---- rays ---- */

/* The options, checked; thickness: with the default for 0. */
static svo_status read_options(const svo_probes *probes, const char *function, const svo_probe_trace_options *options,
                               cl_float *thickness)
{
    svo_probe_trace_options asked;
    SVO_I_TRY(svo_i_struct_read(svo_i_device_message(probes->device), function, "options", options, &asked,
                                SVO_I_STRUCT_SIZES(svo_probe_trace_options, thickness)));
    if (!(asked.thickness >= 0.0F) || !isfinite(asked.thickness)) {
        return svo_i_device_fail(probes->device, SVO_INVALID_ARGUMENT,
                                 "%s: options.thickness %g is negative or not finite", function,
                                 (double)asked.thickness);
    }
    *thickness = asked.thickness > 0.0F ? asked.thickness : 1.0F;
    return SVO_OK;
}

svo_status svo_probes_trace(svo_probes *probes, svo_array rays, svo_array hits, size_t ray_count,
                            const svo_probe_trace_options *options, const svo_submit *submit)
{
    static const char function[] = "svo_probes_trace";
    cl_float thickness = 0;
    if (probes == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    SVO_I_TRY(read_options(probes, function, options, &thickness));
    const svo_i_batch asked = {.device = probes->device,
                               .function = function,
                               .target = target_of(probes),
                               .program = &svo_i_program_probe_trace,
                               .kernel_name = "svo_k_probe_trace",
                               .defines = probes->sky_map != NULL ? " -DSVO_SKY_MAP" : "",
                               .input_name = "rays",
                               .output_name = "hits",
                               .input_bytes = sizeof(svo_ray),
                               .output_bytes = sizeof(svo_probe_hit),
                               .count = ray_count,
                               .last_argument = {sizeof thickness, &thickness, false}};
    return svo_i_batch_run(&asked, &rays, &hits, submit);
}

/* ---- diffuse light ---- */

svo_status svo_probes_irradiance(svo_probes *probes, svo_array points, svo_array results, size_t point_count,
                                 const svo_submit *submit)
{
    static const char function[] = "svo_probes_irradiance";
    if (probes == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    if ((probes->params.flags & SVO_PROBES_FLAG_DIFFUSE) == 0) {
        return svo_i_device_fail(probes->device, SVO_INVALID_ARGUMENT, "%s: the probes were made without diffuse maps",
                                 function);
    }
    const svo_i_batch asked = {.device = probes->device,
                               .function = function,
                               .target = target_of(probes),
                               .program = &svo_i_program_probe_gather,
                               .kernel_name = "svo_k_probe_gather",
                               .defines = "",
                               .input_name = "points",
                               .output_name = "results",
                               .input_bytes = sizeof(svo_gather_point),
                               .output_bytes = sizeof(svo_probe_irradiance),
                               .count = point_count};
    return svo_i_batch_run(&asked, &points, &results, submit);
}

/* ---- the class: the caller's kernels ---- */

static svo_device *device_of(const void *probes)
{
    return ((const svo_probes *)probes)->device;
}

static const char *kernel_source(void)
{
    return svo_i_source_light_field;
}

static const char *kernel_options(const void *of)
{
    const svo_probes *probes = of;
    return probes != NULL && probes->sky_map != NULL ? SVO_I_KERNEL_OPTIONS " -DSVO_SKY_MAP" : SVO_I_KERNEL_OPTIONS;
}

static const struct svo_target_class probes_class = {.name = "light field",
                                                     .device = device_of,
                                                     .kernel_source = kernel_source,
                                                     .kernel_options = kernel_options,
                                                     .set_kernel_arguments = set_target};

svo_target svo_probes_target(svo_probes *probes)
{
    return (svo_target){&probes_class, probes};
}
