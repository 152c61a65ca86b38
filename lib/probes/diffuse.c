/* SPDX-License-Identifier: MIT */
/* Diffuse light of probes for batches of points; rays/batch.c launches kernels/probes/gather.cl. */
#include "probes/programs.h"
#include "probes/source.h"

static svo_status check(const svo_probes *probes, const char *function)
{
    return (probes->params.flags & SVO_PROBES_FLAG_DIFFUSE) != 0
               ? SVO_OK
               : svo_i_device_fail(probes->device, SVO_INVALID_ARGUMENT,
                                   "%s: the probes were made without diffuse maps", function);
}

static svo_i_batch batch_of(svo_probes *probes, const char *function, size_t point_count)
{
    return (svo_i_batch){.device = probes->device,
                         .function = function,
                         .target = svo_i_probes_target(probes),
                         .program = &svo_i_program_probe_gather,
                         .kernel_name = "svo_k_probe_gather",
                         .defines = "",
                         .input_name = "points",
                         .output_name = "results",
                         .input_bytes = sizeof(svo_gather_point),
                         .output_bytes = sizeof(svo_probe_irradiance),
                         .count = point_count,
                         .per_item = 1};
}

svo_status svo_probes_irradiance_enqueue(svo_probes *probes, cl_mem points, cl_mem results, size_t point_count,
                                         cl_command_queue queue, cl_uint num_wait, const cl_event *wait,
                                         cl_event *event)
{
    static const char function[] = "svo_probes_irradiance_enqueue";
    if (probes == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    SVO_I_TRY(check(probes, function));
    const svo_i_batch asked = batch_of(probes, function, point_count);
    return svo_i_batch_enqueue(&asked, points, results, queue, num_wait, wait, event);
}

svo_status svo_probes_irradiance(svo_probes *probes, const svo_gather_point *points, svo_probe_irradiance *results,
                                 size_t point_count, cl_command_queue queue)
{
    static const char function[] = "svo_probes_irradiance";
    if (probes == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    SVO_I_TRY(check(probes, function));
    const svo_i_batch asked = batch_of(probes, function, point_count);
    return svo_i_batch_run(&asked, points, results, queue);
}
