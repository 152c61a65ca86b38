/* SPDX-License-Identifier: MIT */
/* Rays through probes: options and checks, then rays/batch.c launches kernels/probes/trace.cl. */
#include <math.h>

#include "core/struct_size.h"
#include "probes/programs.h"
#include "probes/source.h"

const char *svo_probe_choice_name(svo_probe_choice choice)
{
    static const char *const names[SVO_PROBE_CHOICE_COUNT] = {"field", "eight"};
    return (unsigned)choice < SVO_PROBE_CHOICE_COUNT ? names[choice] : "unknown choice";
}

/* The options, checked, with the defaults for 0. */
static svo_status read_options(const svo_probes *probes, const char *function, const svo_probe_trace_options *options,
                               svo_probe_trace_params *params)
{
    svo_probe_trace_options asked;
    SVO_I_TRY(svo_i_struct_read(svo_i_device_message(probes->device), function, "options", options, &asked,
                                SVO_I_STRUCT_SIZES(svo_probe_trace_options, thickness)));
    if ((unsigned)asked.choice >= SVO_PROBE_CHOICE_COUNT) {
        return svo_i_device_fail(probes->device, SVO_INVALID_ARGUMENT, "%s: options.choice %d is not in 0 .. %d",
                                 function, (int)asked.choice, (int)SVO_PROBE_CHOICE_COUNT - 1);
    }
    if (!(asked.thickness >= 0.0F) || !isfinite(asked.thickness)) {
        return svo_i_device_fail(probes->device, SVO_INVALID_ARGUMENT,
                                 "%s: options.thickness %g is negative or not finite", function,
                                 (double)asked.thickness);
    }
    *params = (svo_probe_trace_params){.choice = (cl_uint)asked.choice,
                                       .thickness = asked.thickness > 0.0F ? asked.thickness : 1.0F};
    return SVO_OK;
}

/* params: lives as long as the batch. */
static svo_i_batch batch_of(svo_probes *probes, const char *function, size_t ray_count,
                            const svo_probe_trace_params *params)
{
    return (svo_i_batch){.device = probes->device,
                         .function = function,
                         .target = svo_i_probes_target(probes),
                         .program = &svo_i_program_probe_trace,
                         .kernel_name = "svo_k_probe_trace",
                         .defines = "",
                         .input_name = "rays",
                         .output_name = "hits",
                         .input_bytes = sizeof(svo_ray),
                         .output_bytes = sizeof(svo_probe_hit),
                         .count = ray_count,
                         .per_item = 1,
                         .last_argument = {sizeof *params, params, false}};
}

/* Checks the options and fills the batch, which refers to params. */
static svo_status prepare(svo_probes *probes, const char *function, size_t ray_count,
                          const svo_probe_trace_options *options, svo_probe_trace_params *params, svo_i_batch *out)
{
    if (probes == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    SVO_I_TRY(read_options(probes, function, options, params));
    *out = batch_of(probes, function, ray_count, params);
    return SVO_OK;
}

svo_status svo_probes_trace_enqueue(svo_probes *probes, cl_mem rays, cl_mem hits, size_t ray_count,
                                    const svo_probe_trace_options *options, cl_command_queue queue, cl_uint num_wait,
                                    const cl_event *wait, cl_event *event)
{
    svo_probe_trace_params params;
    svo_i_batch asked;
    SVO_I_TRY(prepare(probes, "svo_probes_trace_enqueue", ray_count, options, &params, &asked));
    return svo_i_batch_enqueue(&asked, rays, hits, queue, num_wait, wait, event);
}

svo_status svo_probes_trace(svo_probes *probes, const svo_ray *rays, svo_probe_hit *hits, size_t ray_count,
                            const svo_probe_trace_options *options, cl_command_queue queue)
{
    svo_probe_trace_params params;
    svo_i_batch asked;
    SVO_I_TRY(prepare(probes, "svo_probes_trace", ray_count, options, &params, &asked));
    return svo_i_batch_run(&asked, rays, hits, queue);
}
