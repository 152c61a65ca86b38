/* SPDX-License-Identifier: MIT */
/*
 * Rays through a tree on the device: pictures of its voxels, batches of rays against its triangles, the nearest
 * triangle to points, and the same in a kernel of one's own.
 */
#ifndef SVOCL_TRACE_H
#define SVOCL_TRACE_H

#include <stdint.h>

#include "svocl/ray_types.h"
#include "svocl/tree.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A pinhole camera in world coordinates. */
typedef struct svo_camera {
    float eye[3];
    float target[3];
    float up[3]; /* not parallel to target - eye */
    float vertical_fov; /* radians, above 0 and below pi */
} svo_camera;

/* A camera that looks at the occupied part of the tree from the front, a little to the right and above, and frames it.
   aspect: width / height, above 0; anything else counts as 1. Needs the host arrays (svo_tree_download). */
SVO_API void svo_camera_frame(const svo_tree *tree, float aspect, svo_camera *camera);

/* What a picture shows. */
typedef enum svo_render_view {
    SVO_VIEW_SHADED = 0, /* light, shadows, colors */
    SVO_VIEW_NORMAL = 1, /* x, y, z as red, green, blue: the voxel's own, else its face's */
    SVO_VIEW_DEPTH = 2, /* near ones bright */
    SVO_VIEW_STEPS = 3, /* cells the ray looked into, from blue to red at 64 */
    SVO_VIEW_LEVEL = 4, /* a color for the level of the node it stopped at */
    SVO_VIEW_TRIANGLES = 5 /* a color for each triangle; needs SVO_NEED_RAYS */
} svo_render_view;

typedef struct svo_render_options {
    size_t struct_size; /* sizeof(svo_render_options) */
    uint32_t width, height; /* pixels, 1 .. 16384 */
    svo_camera camera;
    svo_render_view view;
} svo_render_options;
#define SVO_RENDER_OPTIONS_INIT SVO_STRUCT_INIT(svo_render_options)

/*
 * Draws the tree and waits for it, as options->view says. Shaded: voxels shaded by normal (their own, else the face the
 * ray entered by) and color (their own, else light gray), with soft shadowing from a second ray towards the light.
 *
 * tree: uploaded or built on device. rgba: height * width * 4 bytes, rows top to bottom, written whole on SVO_OK.
 * Returns SVO_INVALID_ARGUMENT, SVO_COMPILE_FAILED, SVO_CL_ERROR, SVO_OUT_OF_DEVICE_MEMORY.
 */
SVO_API svo_status svo_tree_render(svo_device *device, svo_tree *tree, const svo_render_options *options,
                                   cl_command_queue queue, uint8_t *rgba);

/*
 * Triangles are found through a BVH beside the octree, with each triangle of its lists once. It is made when
 * triangles are first asked for: by one of the functions below, by svo_tree_set_args, or by a picture of triangles.
 * That call makes it on the host, from vertices and indices that it reads back unless they are there, through a queue
 * of its own, and waits for that; what the caller's queue holds is not waited for. This function makes it at a time and
 * on a queue of one's choosing; later calls do nothing.
 *
 * It is no part of a build and of the plan's buffers: two buffers, ray_nodes and ray_leaves, of about 35 bytes a
 * triangle in all (measured: 34 to 53), and never above 208 bytes a triangle and 192.
 *
 * tree: with SVO_NEED_RAYS, coverage half-open or closed, uploaded or built on device. queue: on the context of the
 * tree's device.
 * Returns SVO_INVALID_ARGUMENT, SVO_OUT_OF_HOST_MEMORY, SVO_OUT_OF_DEVICE_MEMORY, SVO_CL_ERROR.
 */
SVO_API svo_status svo_tree_prepare_rays(svo_tree *tree, cl_command_queue queue);
/* Bytes it takes on the device; 0 before it is made. */
SVO_API uint64_t svo_tree_ray_bytes(const svo_tree *tree);

/* What a batch of rays asks for. */
typedef enum svo_trace_flags {
    SVO_TRACE_CLOSEST = 0, /* the first triangle along each ray: by t as reported, then by its position in the mesh */
    SVO_TRACE_ANY = 1, /* whether there is one: the record is of some triangle that the ray meets */
    SVO_TRACE_COUNT = 2 /* how many there are, each once; the record is of the first one */
} svo_trace_flags;

#define SVO_TRACE_RAYS_MAX 0x7fffffffu

/*
 * Traces rays against the triangles of the snapped mesh, as far as they lie inside the grid.
 *
 * Which triangle is hit, its t, u and v are decided in double and are the same on every device with cl_khr_fp64,
 * whatever the tree's depth. Closed surfaces have no gaps: a ray through an edge or a corner meets one of the triangles
 * that share it. Without cl_khr_fp64 the decision is made in float, by the same watertight test. A ray with a number
 * that is not finite, no direction or t_min above t_max meets nothing (t_max may be infinite).
 *
 * tree: with SVO_NEED_RAYS, coverage half-open or closed, uploaded or built on device. rays: ray_count records svo_ray
 * (ray_types.h). hits: ray_count records svo_hit, written whole, in the order of the rays. ray_count: at most
 * SVO_TRACE_RAYS_MAX. flags: one of svo_trace_flags. queue: on the context of the tree's device. num_wait, wait, event:
 * as in clEnqueueNDRangeKernel.
 *
 * The first call of a device handle compiles the kernel, and the first one of a tree makes its boxes
 * (svo_tree_prepare_rays); later ones allocate nothing on the device. Also returns what these two do.
 * Returns SVO_INVALID_ARGUMENT, SVO_UNSUPPORTED (the grid is beyond the range of floats), SVO_COMPILE_FAILED,
 * SVO_CL_ERROR.
 */
SVO_API svo_status svo_tree_trace_enqueue(svo_tree *tree, cl_mem rays, cl_mem hits, size_t ray_count, uint32_t flags,
                                          cl_command_queue queue, cl_uint num_wait, const cl_event *wait,
                                          cl_event *event);

/* The same over host arrays, and waits for it. Also returns SVO_OUT_OF_DEVICE_MEMORY. */
SVO_API svo_status svo_tree_trace(svo_tree *tree, const svo_ray *rays, svo_hit *hits, size_t ray_count, uint32_t flags,
                                  cl_command_queue queue);

/*
 * The nearest triangle of the snapped mesh to each point, by the distance as reported, then by its position in the
 * mesh. Distances are measured in double and rounded to float, on devices with cl_khr_fp64. For triangles that lie
 * inside the grid, as all do on a fitted one. A point that is not finite, or with nothing nearer than its farthest, has
 * none.
 *
 * points: point_count records svo_query_point (ray_types.h). results: point_count records svo_nearest, written whole. All
 * else as for svo_tree_trace_enqueue.
 */
SVO_API svo_status svo_tree_nearest_enqueue(svo_tree *tree, cl_mem points, cl_mem results, size_t point_count,
                                            cl_command_queue queue, cl_uint num_wait, const cl_event *wait,
                                            cl_event *event);
/* The same over host arrays, and waits for it. Also returns SVO_OUT_OF_DEVICE_MEMORY. */
SVO_API svo_status svo_tree_nearest(svo_tree *tree, const svo_query_point *points, svo_nearest *results,
                                    size_t point_count, cl_command_queue queue);

/*
 * Rays in a kernel of one's own. The source is a text in OpenCL C 1.2 to put before the kernel's:
 *
 *   clCreateProgramWithSource(context, 2, (const char *[]){svo_tree_kernel_source(), mine}, NULL, &error)
 *   clBuildProgram(program, 1, &device, svo_tree_kernel_options(), NULL, NULL)
 *
 * It declares what kernels need:
 *
 *   SVO_TREE_PARAMETERS    among the kernel's parameters, SVO_TREE_ARGUMENTS of them
 *   SVO_TREE_MAKE(tree)    an svo_tree from these parameters
 *   svo_ray, svo_hit, svo_voxel_hit    as in ray_types.h
 *   bool svo_trace_closest(const svo_tree *, const svo_ray *, svo_hit *)    the first triangle
 *   bool svo_trace_any(const svo_tree *, const svo_ray *, svo_hit *)        any triangle: for shadows
 *   uint svo_trace_count(const svo_tree *, const svo_ray *, svo_hit *)      how many, and the first
 *   bool svo_trace_voxel(const svo_tree *, const svo_ray *, float footprint, svo_voxel_hit *)
 *        the first leaf, or a larger node where a pixel of that footprint is larger still; for trees without lists too
 *
 * Other names it declares begin with svo_ or SVO_. Both strings are static.
 */
#define SVO_TREE_ARGUMENTS 5u
SVO_API const char *svo_tree_kernel_source(void);
SVO_API const char *svo_tree_kernel_options(void);

/* Sets the kernel's arguments first_index .. first_index + SVO_TREE_ARGUMENTS - 1, where SVO_TREE_PARAMETERS stand. The
   tree must be on a device and outlive the kernel's launches. Triangles need a tree with SVO_NEED_RAYS, coverage
   half-open or closed, whose boxes this call makes unless they are there (svo_tree_prepare_rays).
   Returns SVO_INVALID_ARGUMENT, SVO_UNSUPPORTED, SVO_OUT_OF_HOST_MEMORY, SVO_OUT_OF_DEVICE_MEMORY, SVO_CL_ERROR. */
SVO_API svo_status svo_tree_set_args(svo_tree *tree, cl_kernel kernel, cl_uint first_index);

#ifdef __cplusplus
}
#endif

#endif
