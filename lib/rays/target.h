/* SPDX-License-Identifier: MIT */
/* What a room does with its handles as svo_targets. Calls in trace.h that take one pass it on through this table, so
   they name no room, and a program has the kernels of the handles that it makes targets of. */
#ifndef SVO_LIB_RAYS_TARGET_H
#define SVO_LIB_RAYS_TARGET_H

#include "svocl/trace.h"

/* A function that is NULL is not there: the call is refused. of: the handle, not NULL. */
struct svo_target_class {
    const char *name; /* "tree", for messages */
    /* NULL for a handle without one. */
    svo_device *(*device)(const void *of);
    svo_status (*render)(void *of, const svo_render_options *options, const svo_array *pixels,
                         const svo_submit *submit);
    svo_status (*trace_triangles)(void *of, const svo_array *rays, const svo_array *hits, size_t ray_count,
                                  uint32_t flags, const svo_submit *submit);
    svo_status (*trace_voxels)(void *of, const svo_array *rays, const svo_array *hits, size_t ray_count,
                               float footprint, uint32_t flags, const svo_submit *submit);
    svo_status (*fit_camera)(const void *of, float aspect, svo_camera *camera);
    const char *(*kernel_source)(void);
    /* of: NULL is possible here. */
    const char *(*kernel_options)(const void *of);
    /* The handle is on a device, and the kernel is of its context. */
    svo_status (*set_kernel_arguments)(void *of, const char *function, cl_kernel kernel, cl_uint first_index);
};

/* svo_kernel_options where they do not depend on the handle. */
#define SVO_I_KERNEL_OPTIONS "-cl-std=CL1.2"

#endif
