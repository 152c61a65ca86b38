/* SPDX-License-Identifier: MIT */
/*
 * Building: plan + front end + queue -> tree.
 *
 * A front end makes fragments, one (voxel, triangle) pair each: with OpenCL alone (below), or with OpenGL's rasterizer
 * (gl.h). The build links, packs and filters them with OpenCL. The tree is the same, bit for bit, for every front end,
 * share path, device and run.
 */
#ifndef SVOCL_BUILD_H
#define SVOCL_BUILD_H

#include <stddef.h>
#include <stdint.h>

#include "svocl/plan.h"
#include "svocl/tree.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct svo_frontend svo_frontend;

/*
 * The front end of OpenCL alone, "cl": a kernel walks every triangle's voxels. Needs no OpenGL. Its share is "none": the
 * list is made where it is used.
 *
 * device: must outlive it; nothing is compiled yet. Returns SVO_INVALID_ARGUMENT, SVO_OUT_OF_HOST_MEMORY, or
 * SVO_UNSUPPORTED where the device has less than 17 KiB of local memory.
 */
SVO_API svo_status svo_frontend_create_cl(svo_device *device, svo_frontend **out);
/* Releases a front end that svo_frontend_create_cl made and sets *frontend to NULL; NULL and a pointer to NULL are allowed.
   One that another handle owns (svo_gl_frontend) is left alone. */
SVO_API void svo_frontend_destroy(svo_frontend **frontend);
/*
 * Whether OpenCL alone is the faster way for a plan because it is done before OpenGL would have started: not 0 if so. For
 * larger plans svo_gl_prefer (gl.h) compares the two. A rule of thumb: nothing is run.
 *
 * reason: receives one line that says why; NULL allowed.
 */
SVO_API int svo_frontend_cl_suffices(const svo_plan *plan, svo_message *reason);
SVO_API const char *svo_frontend_name(const svo_frontend *frontend); /* "cl", "gl-expand", "gl-hw"; static string */
SVO_API const char *svo_frontend_share(const svo_frontend *frontend); /* "none", "host", "copy"; static string */

typedef enum svo_stage {
    SVO_STAGE_GRID = 0, /* validate, snap, classify (svo_plan_create) */
    SVO_STAGE_COMPILE, /* kernels and shaders, whatever of it fell into this build */
    SVO_STAGE_VOXELIZE, /* triangles -> fragment list */
    SVO_STAGE_TRANSFER, /* list from GL to CL, host data to the device, counts back */
    SVO_STAGE_SUBDIVIDE, /* masks, scans, descents, all levels */
    SVO_STAGE_PACK, /* sorted leaf lists */
    SVO_STAGE_LINK, /* leaf lists linked by atomic exchange */
    SVO_STAGE_FILTER, /* payload: leaves, then level by level up */
    SVO_STAGE_COUNT
} svo_stage;
SVO_API const char *svo_stage_name(svo_stage stage); /* "grid", "compile", ...; static string */

typedef struct svo_stage_time {
    double ms;
    const char *clock; /* "wall", "cl-event" or "gl-timer"; NULL: the stage did not run */
} svo_stage_time;

typedef struct svo_build_report {
    size_t struct_size; /* sizeof(svo_build_report), set by the caller */
    svo_stage_time stages[SVO_STAGE_COUNT];
    uint64_t fragments;
    uint32_t list_chunks;
    uint32_t reruns; /* how often a capacity was too small and a second plan ran */
    const char *frontend; /* "cl", "gl-expand", "gl-hw"; static strings */
    const char *builder; /* "cl", "sorted"; "gl-compute" (svo_gl_build); static strings */
    const char *share; /* how the list got to OpenCL: "none" (it was made there), "sharing", "host", "copy" */
    const char *renderer; /* OpenGL's name of what rasterized; lives as long as the context; "" without OpenGL */
} svo_build_report;

/*
 * Builds the tree of a plan and waits for it. Grows capacities and reruns when they were too small, and reports that; a
 * second build of the plan starts with the first capacities again.
 *
 * plan: of the same device as frontend and queue; its list of buffers becomes what this build allocated.
 * queue: the caller's, on the device's context, in-order or out-of-order; stage times come from events if it has
 *        CL_QUEUE_PROFILING_ENABLE, else from the wall clock.
 * report: NULL allowed.
 * Returns SVO_OUT_OF_DEVICE_MEMORY with the needed bytes in the message, SVO_COMPILE_FAILED, SVO_CL_ERROR,
 * SVO_GL_ERROR, SVO_NO_GL (the context cannot be made current), SVO_UNSUPPORTED (a limit of the context),
 * SVO_OUT_OF_HOST_MEMORY, SVO_INVALID_ARGUMENT, SVO_INTERNAL.
 */
SVO_API svo_status svo_build(svo_plan *plan, svo_frontend *frontend, cl_command_queue queue, svo_tree **out,
                             svo_build_report *report);

#ifdef __cplusplus
}
#endif

#endif
