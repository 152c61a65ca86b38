/* SPDX-License-Identifier: MIT */
/* The calls that take an svo_target: they check it and pass it on to its room. */
#include "rays/target.h"

#include "core/device.h"
#include "core/opencl.h"

static svo_status refuse(svo_target target, const char *function)
{
    if (target.of_class == NULL || target.of == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    return svo_i_device_fail(target.of_class->device(target.of), SVO_UNSUPPORTED, "%s: not of a %s", function,
                             target.of_class->name);
}

/* Whether the target is one, and its class has the function of a field. */
#define CAN(target, field) ((target).of_class != NULL && (target).of != NULL && (target).of_class->field != NULL)

svo_status svo_render(svo_target target, const svo_render_options *options, svo_array pixels, const svo_submit *submit)
{
    return CAN(target, render) ? target.of_class->render(target.of, options, &pixels, submit)
                               : refuse(target, "svo_render");
}

svo_status svo_trace_triangles(svo_target target, svo_array rays, svo_array hits, size_t ray_count, uint32_t flags,
                               const svo_submit *submit)
{
    return CAN(target, trace_triangles)
               ? target.of_class->trace_triangles(target.of, &rays, &hits, ray_count, flags, submit)
               : refuse(target, "svo_trace_triangles");
}

svo_status svo_trace_voxels(svo_target target, svo_array rays, svo_array hits, size_t ray_count, float footprint,
                            uint32_t flags, const svo_submit *submit)
{
    return CAN(target, trace_voxels)
               ? target.of_class->trace_voxels(target.of, &rays, &hits, ray_count, footprint, flags, submit)
               : refuse(target, "svo_trace_voxels");
}

svo_status svo_camera_fit(svo_target target, float aspect, svo_camera *camera)
{
    return CAN(target, fit_camera) ? target.of_class->fit_camera(target.of, aspect, camera)
                                   : refuse(target, "svo_camera_fit");
}

const char *svo_kernel_source(svo_target target)
{
    return target.of_class != NULL && target.of_class->kernel_source != NULL ? target.of_class->kernel_source() : NULL;
}

const char *svo_kernel_options(svo_target target)
{
    return target.of_class != NULL && target.of_class->kernel_options != NULL
               ? target.of_class->kernel_options(target.of)
               : NULL;
}

svo_status svo_kernel_set_arguments(svo_target target, cl_kernel kernel, cl_uint first_index)
{
    static const char function[] = "svo_kernel_set_arguments";
    if (!CAN(target, set_kernel_arguments)) {
        return refuse(target, function);
    }
    svo_device *device = target.of_class->device(target.of);
    if (device == NULL) {
        return SVO_NOT_ON_DEVICE;
    }
    const char *wrong = kernel == NULL ? "is NULL" : svo_i_wrong_kernel(device->context, kernel);
    return wrong == NULL ? target.of_class->set_kernel_arguments(target.of, function, kernel, first_index)
                         : svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: kernel %s", function, wrong);
}
