/* SPDX-License-Identifier: MIT */
/** \file
 * Builds: plan + front end + queue -> tree.
 *
 * A front end makes fragments, one per (voxel, triangle) pair: with OpenCL alone (below), or with OpenGL's rasterizer
 * (gl.h). OpenCL makes nodes, leaf lists and payload from them. The tree is the same, bit for bit, for every front end,
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

/** What makes the fragment list. */
typedef struct svo_frontend svo_frontend;

/** Makes the front end "cl": a kernel visits every triangle's voxels. It does not need OpenGL. Its share is "none",
 *  since the list is made where it is used. Nothing is compiled yet.
 *
 * \param device must outlive the front end
 * \param out receives the front end
 * \returns SVO_INVALID_ARGUMENT, SVO_OUT_OF_HOST_MEMORY, or SVO_UNSUPPORTED where the device has less than 16.5 KiB of
 *          local memory. */
SVO_API svo_status svo_frontend_create_cl(svo_device *device, svo_frontend **out);

/** Destroys a front end of svo_frontend_create_cl. One that another handle owns (svo_gl_frontend) is left alone.
 *
 * \param frontend set to NULL; NULL and a pointer to NULL are allowed */
SVO_API void svo_frontend_destroy(svo_frontend **frontend);

/** Whether OpenCL alone finishes the plan's list before OpenGL would have started. A rule of thumb; nothing is run. For
 *  larger plans svo_gl_prefer (gl.h) compares the two.
 *
 * \param plan not NULL
 * \param reason receives one line; NULL allowed
 * \returns not 0 if so. */
SVO_API int svo_frontend_cl_suffices(const svo_plan *plan, svo_message *reason);

/** Name of a front end.
 *
 * \param frontend not NULL
 * \returns "cl", "gl-expand", "gl-hw", "gl-hybrid"; static string. */
SVO_API const char *svo_frontend_name(const svo_frontend *frontend);

/** How the list gets to OpenCL.
 *
 * \param frontend not NULL
 * \returns "none", "interop", "host", "copy"; static string. */
SVO_API const char *svo_frontend_share(const svo_frontend *frontend);

/** Whether a build of the plan runs a stage. Every build has a grid, a compile and a transfer stage.
 *
 * \param plan not NULL
 * \param stage any value
 * \returns not 0 if so. */
SVO_API int svo_plan_has_stage(const svo_plan *plan, svo_stage stage);

/** The time of one stage. This struct does not grow. */
typedef struct svo_stage_time {
    double ms; /**< milliseconds */
    const char *clock; /**< "wall", "cl-event" or "gl-timer", static; NULL: the stage did not run */
} svo_stage_time;

/** Stages that a report has room for. The number is fixed, so that a stage can be added without a change of layout; a
 *  report is a plain value that may be copied. */
#define SVO_STAGE_CAPACITY 64

/** What a build did. */
typedef struct svo_build_report {
    size_t struct_size; /**< sizeof(svo_build_report) */
    uint64_t fragments; /**< (voxel, triangle) pairs; without those that svo_plan_options.drop_alpha leaves out */
    /** Of the pairs that the front end proposed, those that rounded corners did not decide. 0 where the host does not
     *  read the counts: svo_build_enqueue. */
    uint64_t undecided;
    uint64_t inner_nodes; /**< of svo_tree_finish with SVO_CAPACITY_EXCEEDED: the room that is enough; else 0 */
    uint32_t list_chunks; /**< buffers of the fragment list */
    uint32_t reruns; /**< how often a capacity was too small and a stage ran again */
    const char *frontend; /**< "cl", "gl-expand", "gl-hw", "gl-hybrid", "none"; static string */
    const char *builder; /**< "cl", "sorted"; "gl-compute" (svo_gl_build), "edit" (svo_edit_commit); static string */
    const char *share; /**< how the list got to OpenCL: "none" (made there), "interop", "host", "copy" */
    const char *renderer; /**< OpenGL's name of the renderer; lives as long as the context; "" without OpenGL */
    svo_stage_time stage_times[SVO_STAGE_CAPACITY]; /**< by svo_stage; svo_build_report_stage says how many */
    uint64_t dropped; /**< (voxel, triangle) pairs that svo_plan_options.drop_alpha left out */
} svo_build_report;

/** An empty output. */
#define SVO_BUILD_REPORT_INIT SVO_STRUCT_INIT(svo_build_report)

/** The time of a stage in a report.
 *
 * \param report that a build has filled
 * \param index an svo_stage
 * \param time receives the time; clock is NULL for a stage that did not run or is not known. NULL allowed
 * \returns the number of stages that the library knows: SVO_STAGE_COUNT, or more than the caller's. */
SVO_API size_t svo_build_report_stage(const svo_build_report *report, size_t index, svo_stage_time *time);

/** Builds the tree of a plan and waits for it. A capacity that was too small is grown and reported; the next build of
 *  the plan starts with the plan's capacities again.
 *
 * \param plan its list of buffers becomes what this build allocated
 * \param frontend of the plan's device; NULL: "cl", made by the device handle on first use
 * \param queue on the device's context, in-order or out-of-order; stage times are those of events with
 *        CL_QUEUE_PROFILING_ENABLE, else of the wall clock. NULL: an in-order queue, made by the device handle on first
 *        use
 * \param out receives the tree
 * \param report receives what the build did, also on failure, unless an argument is refused; NULL allowed
 * \returns SVO_OUT_OF_DEVICE_MEMORY (the message says how many bytes are needed), SVO_COMPILE_FAILED, SVO_CL_ERROR,
 *          SVO_GL_ERROR, SVO_NO_GL (the context cannot be made current), SVO_UNSUPPORTED (a limit of the context),
 *          SVO_OUT_OF_HOST_MEMORY, SVO_INVALID_ARGUMENT, SVO_CANCELED (the plan's progress callback),
 *          SVO_CAPACITY_EXCEEDED (an updatable plan's mesh has outgrown max_area) or SVO_INTERNAL on failure. */
SVO_API svo_status svo_build(svo_plan *plan, svo_frontend *frontend, cl_command_queue queue, svo_tree **out,
                             svo_build_report *report);

/** Compiles the kernels that builds of a plan need with the front end of OpenCL, and launches each once on nothing,
 *  since some drivers compile at the first launch. A build of the plan, or of another with the same kernels
 *  (svo_plan_get_kernels), then compiles nothing. The shaders of OpenGL are not compiled.
 *
 * \param device of the plan
 * \param plan not NULL
 * \returns SVO_COMPILE_FAILED, SVO_CL_ERROR, SVO_UNSUPPORTED (see svo_frontend_create_cl), SVO_CANCELED,
 *          SVO_OUT_OF_HOST_MEMORY or SVO_INVALID_ARGUMENT on failure. */
SVO_API svo_status svo_device_warm(svo_device *device, svo_plan *plan);

/** All the memory that builds of one plan need, allocated once, for builds that do not wait:
 *
 *     svo_workspace_create     plan + front end -> scratch in one piece, the caller's or its own
 *     svo_workspace_make_tree  a tree with room for the plan's capacities
 *     svo_build_enqueue        any number of times; allocates nothing on the device and waits for nothing
 *     svo_tree_finish          waits, reads the counts and trims: now the tree is that of svo_build, bit for bit
 *
 * Thread-safety: a workspace belongs to its plan's device handle; one thread at a time may use it. */
typedef struct svo_workspace svo_workspace;

/** Options of a workspace. */
typedef struct svo_workspace_options {
    size_t struct_size; /**< sizeof(svo_workspace_options) */
    /** The caller's scratch: a buffer of the device's context, which is retained. Builds use svo_workspace_info's
     *  scratch_bytes from offset_bytes on. While no build is in flight the memory may be used for anything, other
     *  workspaces included. NULL: the workspace makes a buffer. */
    cl_mem scratch;
    uint64_t offset_bytes; /**< a multiple of scratch_alignment */
} svo_workspace_options;

/** All defaults. */
#define SVO_WORKSPACE_OPTIONS_INIT SVO_STRUCT_INIT(svo_workspace_options)

/** The sizes of a workspace. */
typedef struct svo_workspace_info {
    size_t struct_size; /**< sizeof(svo_workspace_info) */
    uint64_t scratch_bytes; /**< exact; buffers that are not needed at the same time share memory */
    uint64_t scratch_alignment; /**< bytes; CL_DEVICE_MEM_BASE_ADDR_ALIGN, at least 128 */
    uint64_t tree_bytes; /**< of a tree with room for the capacities */
    uint64_t fragment_capacity; /**< fragments there is room for */
    uint64_t inner_capacity; /**< inner nodes there is room for */
} svo_workspace_info;

/** An empty output. */
#define SVO_WORKSPACE_INFO_INIT SVO_STRUCT_INIT(svo_workspace_info)

/** The sizes of the workspace that svo_workspace_create would make. Leaves the plan as it is.
 *
 * \param plan see svo_workspace_create
 * \param frontend see svo_workspace_create
 * \param info receives the sizes
 * \returns what svo_workspace_create returns. */
SVO_API svo_status svo_workspace_measure(svo_plan *plan, svo_frontend *frontend, svo_workspace_info *info);

/** Makes a workspace and compiles what its builds need.
 *
 * There is room for the plan's fragment_capacity; without one, for the number that svo_plan_count has found, else for
 * the fragment estimate plus an eighth. Inner nodes follow from the fragment estimate, or from worst_case_nodes.
 *
 * \param plan with SVO_BUILDER_CL; must outlive the workspace
 * \param frontend not NULL; must outlive the workspace. With a front end of OpenGL, svo_build_enqueue waits on the host
 *        for its wait list and for OpenGL, whose list is in memory of its own
 * \param queue for launches that make the driver compile, and empty again when the function returns; NULL: the
 *        device's own
 * \param options NULL means all defaults
 * \param out receives the workspace
 * \returns SVO_UNSUPPORTED (another builder, or a list that does not fit one chunk), SVO_INVALID_ARGUMENT (scratch too
 *          small, of another context or not aligned), SVO_OUT_OF_DEVICE_MEMORY, SVO_COMPILE_FAILED, SVO_CL_ERROR or
 *          SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_workspace_create(svo_plan *plan, svo_frontend *frontend, cl_command_queue queue,
                                        const svo_workspace_options *options, svo_workspace **out);

/** Waits for builds in flight and destroys a workspace. Its trees live on. Finish those with a build in flight first:
 *  afterwards svo_tree_finish refuses them, and they can only be destroyed.
 *
 * \param workspace set to NULL; NULL and a pointer to NULL are allowed */
SVO_API void svo_workspace_destroy(svo_workspace **workspace);

/** The sizes of a workspace.
 *
 * \param workspace not NULL
 * \param info receives the sizes
 * \returns SVO_INVALID_ARGUMENT when info is NULL or its struct_size is too small. */
SVO_API svo_status svo_workspace_get_info(const svo_workspace *workspace, svo_workspace_info *info);

/** Makes a tree with room for the plan's capacities and without content, for svo_build_enqueue.
 *
 * \param workspace not NULL
 * \param out receives the tree
 * \returns SVO_OUT_OF_DEVICE_MEMORY, SVO_OUT_OF_HOST_MEMORY or SVO_INVALID_ARGUMENT on failure. */
SVO_API svo_status svo_workspace_make_tree(svo_workspace *workspace, svo_tree **out);

/** Enqueues a build into a tree. Each build of a workspace waits for the one before, whatever the queues. The plan's
 *  arrays are read until the build is done.
 *
 * A capacity that is too small shows in svo_tree_finish. After a failure here, commands that were enqueued until then
 * run to their end, and the next build waits for them.
 *
 * \param workspace not NULL
 * \param tree of this workspace, not trimmed. It has no content until svo_tree_finish, see tree.h; its buffers and its
 *        build state (SVO_TREE_BUILD_STATE) may be given to kernels that wait for the build's event. Commands that
 *        read its old content come first, by wait or by an in-order queue
 * \param submit NULL: the device's own queue, and the call waits for its commands
 * \returns SVO_INVALID_ARGUMENT, SVO_OUT_OF_DEVICE_MEMORY, SVO_CL_ERROR or SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_build_enqueue(svo_workspace *workspace, svo_tree *tree, const svo_submit *submit);

/** Waits for the build of a tree and reads its counts.
 *
 * \param tree with a build in flight, of a workspace that still exists
 * \param queue on the device's context; for the copies of a trim. NULL: the device's own
 * \param trim not 0: buffers are replaced by copies of the tree's exact size, and no more builds go into the tree
 * \param report receives what the build did; NULL allowed. Stage times need a queue with CL_QUEUE_PROFILING_ENABLE in
 *        svo_build_enqueue
 * \returns SVO_CAPACITY_EXCEEDED when a capacity was too small. The tree stays undefined. report->fragments is the
 *          capacity that suffices, report->inner_nodes the room for inner nodes that suffices, and the message has
 *          both. A plan with that fragment_capacity fits, with worst_case_nodes where nodes were short. Of an updatable
 *          plan it may be more, and the mesh may have outgrown max_area instead; other trees of the
 *          workspace keep their content.
 *          SVO_INVALID_ARGUMENT without a build in flight, or after svo_workspace_destroy. Otherwise as svo_build. */
SVO_API svo_status svo_tree_finish(svo_tree *tree, cl_command_queue queue, int trim, svo_build_report *report);

/** Counts the fragments of a plan without keeping them. Their number becomes the plan's capacity, and its list of
 *  buffers exact where it follows from that. Pairs that only the mesh as given decides (svo_build_report.undecided)
 *  count whether they touch or not, since a list has room for them until they are decided. Costs about a voxelization.
 *
 * \param plan not NULL
 * \param frontend as for svo_build
 * \param queue as for svo_build
 * \returns SVO_UNSUPPORTED for an updatable plan, or what svo_build returns. */
SVO_API svo_status svo_plan_count(svo_plan *plan, svo_frontend *frontend, cl_command_queue queue);

#ifdef __cplusplus
}
#endif

#endif
