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
 * The front end of OpenCL alone, "cl": a kernel walks every triangle's voxels. Needs no OpenGL. Its share is "none":
 * the list is made where it is used.
 *
 * device: must outlive it; nothing is compiled yet. Returns SVO_INVALID_ARGUMENT, SVO_OUT_OF_HOST_MEMORY, or
 * SVO_UNSUPPORTED where the device has less than 17 KiB of local memory.
 */
SVO_API svo_status svo_frontend_create_cl(svo_device *device, svo_frontend **out);
/* Releases a front end that svo_frontend_create_cl made and sets *frontend to NULL; NULL and a pointer to NULL are
   allowed. One that another handle owns (svo_gl_frontend) is left alone. */
SVO_API void svo_frontend_destroy(svo_frontend **frontend);
/*
 * Whether OpenCL alone is the faster way for a plan because it is done before OpenGL would have started: not 0 if so.
 * For larger plans svo_gl_prefer (gl.h) compares the two. A rule of thumb: nothing is run.
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

/* Whether a build of the plan has that stage: not 0 if so. The grid and the compiler are part of every build. */
SVO_API int svo_plan_has_stage(const svo_plan *plan, svo_stage stage);

typedef struct svo_stage_time {
    double ms;
    const char *clock; /* "wall", "cl-event" or "gl-timer"; NULL: the stage did not run */
} svo_stage_time;

#define SVO_STAGE_CAPACITY 64
typedef struct svo_build_report {
    size_t struct_size; /* sizeof(svo_build_report), set by the caller */
    uint64_t fragments;
    uint64_t inner_nodes; /* of svo_tree_finish: see there; else 0 */
    uint32_t list_chunks;
    uint32_t reruns; /* how often a capacity was too small and a second plan ran */
    const char *frontend; /* "cl", "gl-expand", "gl-hw"; static strings */
    const char *builder; /* "cl", "sorted"; "gl-compute" (svo_gl_build); static strings */
    const char *share; /* how the list got to OpenCL: "none" (it was made there), "sharing", "host", "copy" */
    const char *renderer; /* OpenGL's name of what rasterized; lives as long as the context; "" without OpenGL */
    svo_stage_time stage_times[SVO_STAGE_CAPACITY]; /* read by svo_build_report_stage */
} svo_build_report;
#define SVO_BUILD_REPORT_INIT SVO_STRUCT_INIT(svo_build_report)

SVO_API size_t svo_build_report_stage(const svo_build_report *report, size_t index, svo_stage_time *time);

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

/*
 * Builds that do not wait. A workspace is all the memory that builds of one plan need, made once: svo_build_enqueue
 * then allocates nothing on the device, waits for nothing, and leaves the counting to the device.
 *
 *   svo_workspace_create     plan + front end -> scratch, in one piece, the caller's or its own
 *   svo_workspace_make_tree  a tree with room for the plan's capacities
 *   svo_build_enqueue        any number of times
 *   svo_tree_finish          waits, reads the counts, trims: now the tree is as svo_build makes it, bit for bit
 *
 * Thread-safety: a workspace belongs to its plan's device handle, and is used by one thread at a time.
 */
typedef struct svo_workspace svo_workspace;

typedef struct svo_workspace_options {
    size_t struct_size; /* sizeof(svo_workspace_options) */
    /* The caller's scratch: offset_bytes .. offset_bytes + svo_workspace_info.scratch_bytes of a buffer of the device's
       context, which is retained. offset_bytes is a multiple of scratch_alignment. It may be used for other things,
       also for other workspaces, whenever no build is in flight. NULL: the workspace makes a buffer. */
    cl_mem scratch;
    uint64_t offset_bytes;
} svo_workspace_options;
#define SVO_WORKSPACE_OPTIONS_INIT SVO_STRUCT_INIT(svo_workspace_options)

typedef struct svo_workspace_info {
    size_t struct_size; /* sizeof(svo_workspace_info) */
    uint64_t scratch_bytes; /* exact; buffers that are not needed at the same time share it */
    uint64_t scratch_alignment; /* bytes; CL_DEVICE_MEM_BASE_ADDR_ALIGN */
    uint64_t tree_bytes; /* of a tree with room for the capacities */
    uint64_t fragment_capacity, inner_capacity; /* fragments and inner nodes there is room for */
} svo_workspace_info;
#define SVO_WORKSPACE_INFO_INIT SVO_STRUCT_INIT(svo_workspace_info)

/* What svo_workspace_create would ask for, without changing the plan. frontend: see there. Returns what it returns. */
SVO_API svo_status svo_workspace_measure(svo_plan *plan, svo_frontend *frontend, svo_workspace_info *info);

/*
 * Makes a workspace, and compiles what the builds need.
 *
 * plan, frontend: must outlive it. The plan's capacities are its fragment_capacity, or what the fragment estimate
 * expects with an
 *        eighth to spare, or after svo_plan_count the real number; and nodes by the law, or by worst_case_nodes.
 *        The builder is SVO_BUILDER_CL. With a front end of OpenGL, svo_build_enqueue waits on the host for the wait
 *        list and for OpenGL, whose list is in memory of its own.
 * queue: for what the compiler needs to be launched; nothing stays in it.
 * options: NULL means all defaults.
 * Returns SVO_UNSUPPORTED for other builders, and for a list above the device's largest allocation;
 * SVO_INVALID_ARGUMENT (scratch that is too small, of another context or not aligned), SVO_OUT_OF_DEVICE_MEMORY,
 * SVO_COMPILE_FAILED, SVO_CL_ERROR, SVO_OUT_OF_HOST_MEMORY.
 */
SVO_API svo_status svo_workspace_create(svo_plan *plan, svo_frontend *frontend, cl_command_queue queue,
                                        const svo_workspace_options *options, svo_workspace **out);
/* Waits for builds in flight. NULL and a pointer to NULL are allowed. Trees made from it live on; those of builds in
   flight have to be finished first. */
SVO_API void svo_workspace_destroy(svo_workspace **workspace);
SVO_API svo_status svo_workspace_get_info(const svo_workspace *workspace, svo_workspace_info *info);

/* A tree without content, with room for the plan's capacities, for svo_build_enqueue alone. */
SVO_API svo_status svo_workspace_make_tree(svo_workspace *workspace, svo_tree **out);

/*
 * Enqueues a build into a tree. Builds of one workspace follow each other, whatever the queues: each waits for the one
 * before. Reads the plan's arrays until it is done.
 *
 * tree: of this workspace, and not trimmed. Until svo_tree_finish its info and arrays are undefined; its buffers may be
 *        given to kernels that wait for *event.
 * queue: in-order or out-of-order. num_wait, wait, event: as with OpenCL's own commands; event may be NULL.
 * Returns SVO_INVALID_ARGUMENT, SVO_OUT_OF_DEVICE_MEMORY, SVO_CL_ERROR, SVO_OUT_OF_HOST_MEMORY, at once as well: what
 * was enqueued until then runs to its end, and the next build waits for that. That a capacity was too small shows in
 * svo_tree_finish.
 */
SVO_API svo_status svo_build_enqueue(svo_workspace *workspace, svo_tree *tree, cl_command_queue queue, cl_uint num_wait,
                                     const cl_event *wait, cl_event *event);

/*
 * Waits for the build of a tree and reads its counts.
 *
 * trim: not 0: buffers are replaced by copies as large as the tree, and no further build goes into it.
 * queue: on the device's context; for the copies.
 * report: NULL allowed. Stage times are those of events, where svo_build_enqueue's queue has CL_QUEUE_PROFILING_ENABLE.
 * Returns SVO_CAPACITY_EXCEEDED when a capacity was too small: the tree stays undefined, report->fragments is the exact
 * number of fragments, report->inner_nodes the room for inner nodes that is enough for certain, and the message has
 * both. A plan with that fragment_capacity, and worst_case_nodes where nodes were short, fits. Otherwise as svo_build.
 */
SVO_API svo_status svo_tree_finish(svo_tree *tree, cl_command_queue queue, int trim, svo_build_report *report);

/*
 * Counts the fragments of a plan without keeping them: the plan's capacity becomes their number, and its list of
 * buffers exact where it follows from that. Costs about a voxelization.
 *
 * frontend, queue: as for svo_build.
 */
SVO_API svo_status svo_plan_count(svo_plan *plan, svo_frontend *frontend, cl_command_queue queue);

#ifdef __cplusplus
}
#endif

#endif
