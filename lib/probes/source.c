/* SPDX-License-Identifier: MIT */
/* Probes in kernels: the library's own and the caller's. */
#include "probes/source.h"

#include "core/opencl.h"

/* Of kernels/probes: choose.clh, diffuse.clh. */
extern const char svo_i_source_light_field[];

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
                                                            SVO_I_ARGUMENT(probes->params)};
    return svo_i_kernel_set_from(probes->device, function, kernel, first_index, arguments, SVO_PROBES_ARGUMENTS);
}

svo_i_ray_target svo_i_probes_target(svo_probes *probes)
{
    return (svo_i_ray_target){probes, SVO_PROBES_ARGUMENTS, check_target, set_target};
}

const char *svo_probes_kernel_source(void)
{
    return svo_i_source_light_field;
}

const char *svo_probes_kernel_options(const svo_probes *probes)
{
    return probes != NULL ? "-cl-std=CL1.2" : "";
}

svo_status svo_probes_set_args(svo_probes *probes, cl_kernel kernel, cl_uint first_index)
{
    static const char function[] = "svo_probes_set_args";
    if (probes == NULL || kernel == NULL) {
        return svo_i_device_fail(probes != NULL ? probes->device : NULL, SVO_INVALID_ARGUMENT, "%s: %s is NULL",
                                 function, probes == NULL ? "probes" : "kernel");
    }
    const char *wrong = svo_i_wrong_kernel(probes->device->context, kernel);
    if (wrong != NULL) {
        return svo_i_device_fail(probes->device, SVO_INVALID_ARGUMENT, "%s: kernel %s", function, wrong);
    }
    return set_target(probes, function, kernel, first_index);
}
