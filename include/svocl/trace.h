/* SPDX-License-Identifier: MIT */
/** \file
 * Rays on the device: pictures of a tree's voxels, batches of rays against its triangles, nearest triangles to points,
 * and all of that in kernels of the caller's own.
 *
 * Rays traverse an 8-wide BVH that references each triangle once. The BVH is separate from the octree: it is no part of
 * a build nor of the plan's buffers. The first function that needs it makes it, on the device, and keeps it with the
 * tree. Such functions take a tree that is not const and need exclusive use of it. svo_tree_make_bvh makes it at a time
 * and in a quality of the caller's choosing.
 */
#ifndef SVOCL_TRACE_H
#define SVOCL_TRACE_H

#include <stdint.h>

#include "svocl/ray_types.h"
#include "svocl/submit.h"
#include "svocl/tree.h"

#ifdef __cplusplus
extern "C" {
#endif

/** What rays meet and pictures show: a handle together with what its room does with it. Its fields are the library's.
 *  It lives as long as the handle. */
typedef struct svo_target {
    const struct svo_target_class *of_class; /**< of the kind of handle */
    void *of; /**< the handle */
} svo_target;

/** A tree as a target: svo_render, svo_trace_triangles, svo_trace_voxels, svo_camera_fit and kernels of the caller's.
 *  compact.h, scene.h, light.h and probes.h have those of other handles. A program that makes none holds no kernel of
 *  rays.
 *
 * svo_kernel_source declares of a tree
 *
 *     SVO_TREE_PARAMETERS    among a kernel's parameters, SVO_TREE_ARGUMENTS of them
 *     SVO_TREE_MAKE(tree)    an svo_tree from these parameters
 *     svo_ray, svo_hit, svo_voxel_hit    as in ray_types.h
 *     svo_node, svo_build_state    as in tree_types.h
 *     bool svo_trace_closest(const svo_tree *, const svo_ray *, svo_hit *)    the first triangle
 *     bool svo_trace_any(const svo_tree *, const svo_ray *, svo_hit *)        any triangle: for shadows
 *     uint svo_trace_count(const svo_tree *, const svo_ray *, svo_hit *)      how many, and the first
 *     void svo_trace_rays(const svo_tree *, global const svo_ray *, global svo_hit *, uint ray_count, bool any)
 *         svo_trace_closest, or any: svo_trace_any, for an array of rays by one work-item. On CPUs the option
 *         -DSVO_RAY_STREAMS makes it trace them as svo_trace_triangles does, in packets of coherent rays and streams of
 *         others: best hundreds at once. The hits are the same. On GPUs leave the option out, and trace a ray by a
 *         work-item
 *     bool svo_trace_voxel(const svo_tree *, const svo_ray *, float footprint, svo_voxel_hit *)
 *         the first leaf, or the first larger node that a pixel of that footprint covers; works without lists too
 *
 * and, as nodes.h has them for the host, with coordinates in arrays of three and points as three floats
 *
 *     float svo_node_edge(const svo_tree *, uint level)
 *     void svo_node_box(const svo_tree *, const svo_node *, float *low, float *high)
 *     bool svo_cell_of_point(const svo_tree *, uint level, float x, float y, float z, uint *cell)
 *     bool svo_find_cell(const svo_tree *, uint level, const uint *cell, svo_node *)    whether it is occupied
 *     bool svo_find_point(const svo_tree *, float x, float y, float z, svo_node *)    whether there is a leaf
 *     bool svo_find_node(const svo_tree *, uint index, svo_node *)    whether the tree has that node
 *     ulong svo_cell_to_code(const uint *cell)
 *     void svo_code_to_cell(ulong code, uint *cell)
 *
 * Its other names begin with svo_ or SVO_.
 *
 * \param tree NULL: calls are refused, but svo_kernel_source and svo_kernel_options answer
 * \returns the target. */
SVO_API svo_target svo_tree_target(svo_tree *tree);

/** A pinhole camera in world coordinates. */
typedef struct svo_camera {
    float eye[3]; /**< position */
    float target[3]; /**< a point in the middle of the picture */
    float up[3]; /**< not parallel to target - eye */
    float vertical_fov; /**< radians, above 0 and below pi */
} svo_camera;

/** Framing looks at no deeper level: what it takes for occupied are the cells of this one. */
#define SVO_FRAME_LEVEL_MAX 7u

/** Moves a camera to where what is framed fills its picture and all of it is in view, with a margin of two hundredths
 *  of the picture at least: of a tree, of a compact one, or of a light's, the occupied part; of a scene the boxes of
 *  all instances. The camera's direction of sight, its up and its angle stay. Its target becomes the point in the
 *  middle of the picture that is as far away as the middle of what is framed.
 *
 * \param target a tree, a compact tree, a light or a scene. Of a tree without host arrays the whole grid is framed; one
 *        that is on no device will do
 * \param aspect width / height, above 0; anything else counts as 1
 * \param camera is moved. Where eye and target are the same it looks from the front, a little from the right and from
 *        above, turned with up; up zero: y; vertical_fov zero: 0.56. So all zero frames from the front, and succeeds
 * \returns SVO_INVALID_ARGUMENT, and leaves the camera, if a coordinate is not finite, up is along the line of sight,
 *          or vertical_fov is not below pi; SVO_UNSUPPORTED if the target is of another kind. */
SVO_API svo_status svo_camera_fit(svo_target target, float aspect, svo_camera *camera);

/** What a picture shows. Trees have the first six; compact and paged trees those but SVO_VIEW_TRIANGLES; scenes the
 *  first; lights the first and the last four. */
typedef enum svo_render_view {
    SVO_VIEW_SHADED = 0, /**< light, shadows, colors; of a light all that it brings, and emission */
    SVO_VIEW_NORMAL = 1, /**< x, y, z as red, green, blue: the voxel's normal, or without one its face's */
    SVO_VIEW_DEPTH = 2, /**< near is bright */
    SVO_VIEW_STEPS = 3, /**< cells that the ray visited, from blue to red at 64 */
    SVO_VIEW_LEVEL = 4, /**< a color for the level of the node that was hit */
    SVO_VIEW_TRIANGLES = 5, /**< a color for each triangle; needs SVO_NEED_RAYS, coverage half-open or closed */
    SVO_VIEW_AO = 6, /**< ambient occlusion: open is white */
    SVO_VIEW_DIRECT = 7, /**< the sources alone, with exact shadows */
    SVO_VIEW_INDIRECT = 8, /**< what cones bring alone, on the surfaces' colors */
    SVO_VIEW_SPECULAR = 9 /**< specular cones alone */
} svo_render_view;

/** What a picture has of each pixel. */
typedef enum svo_pixel_format {
    /** Bytes: red, green, blue and alpha as a screen shows them; colors are not multiplied by alpha. */
    SVO_PIXELS_BYTES = 0,
    /** Floats: red, green, blue and alpha. Light is linear, as it is before the tone curve, and multiplied by alpha.
     *  Views that are no light have numbers, which are not: SVO_VIEW_NORMAL x, y and z; SVO_VIEW_DEPTH the distance
     *  from the eye, world units; SVO_VIEW_STEPS cells; SVO_VIEW_LEVEL levels; SVO_VIEW_TRIANGLES positions in the
     *  mesh, which floats hold up to 2^24. They are means of the rays that met something, 0 without one, and alpha is
     *  the share of those. */
    SVO_PIXELS_LINEAR = 1
} svo_pixel_format;

/** What is behind everything in a picture. */
typedef enum svo_background {
    /** The picture's own: of shaded pictures a gray gradient, of lit ones the sky, of views white. */
    SVO_BACKGROUND_OWN = 0,
    SVO_BACKGROUND_COLOR = 1, /**< svo_picture_output.background_color */
    SVO_BACKGROUND_TRANSPARENT = 2 /**< nothing: alpha is the share of a pixel's rays that met something */
} svo_background;

#define SVO_PICTURE_SAMPLES_MAX 4096u /**< most rays of a pixel */

/** How the pixels of a picture are sampled and written. All zero: bytes, an own background, the picture's own number of
 *  rays. */
typedef struct svo_picture_output {
    svo_pixel_format format; /**< bytes or floats; a pixel takes 4 or 16 bytes. Floats are aligned as float is */
    svo_background background; /**< numbers of SVO_PIXELS_LINEAR have none */
    float background_color[3]; /**< red, green, blue from 0 to 1, which are 0 to 255 in bytes; floats get the light */
    /** Rays of a pixel, 1 .. SVO_PICTURE_SAMPLES_MAX, in the middles of cells of equal area: rows divide the pixel, and
     *  columns the rows. What they see is averaged as linear light. 0: 4, and 1 in views that are no light */
    uint32_t samples;
} svo_picture_output;

/** Options of a picture. What only scenes and only lights have is refused elsewhere, unless it is 0. Arrays and structs
 *  are borrowed for the call. */
typedef struct svo_render_options {
    size_t struct_size; /**< sizeof(svo_render_options) */
    uint32_t width; /**< pixels, 1 .. 16384 */
    uint32_t height; /**< pixels, 1 .. 16384 */
    svo_camera camera; /**< the view */
    svo_render_view view; /**< what to show */
    uint32_t light_count; /**< of a scene, at most SVO_SCENE_LIGHTS_MAX; 0: the light of a tree's picture */
    svo_picture_output output; /**< what of each pixel is written; all zero: bytes */
    /** A plane in world coordinates: where clip[0] x + clip[1] y + clip[2] z + clip[3] is below 0 the picture shows
     *  nothing, and the sun and lights of scenes shine through; a light is that of the whole tree. Finite; all zero:
     *  nothing is cut away */
    float clip[4];
    const struct svo_scene_light *lights; /**< light_count; NULL when that is 0 */
    const struct svo_gather_options *gather; /**< of a light: how it is gathered; NULL: all defaults */
    /** Of a scene, world: the range within which neighbors darken a surface (ambient occlusion). 0: a fraction of an
     *  instance's mean width */
    float occlusion_range;
    float exposure; /**< of a light: radiance is multiplied by it before the tone curve, above 0; 0 means 1 */
    /** Of a light, the first row of a band of the picture: a multiple of SVO_LIGHT_BAND_ROWS below height. The band's
     *  rows are the same as in the whole picture. Host memory receives them alone; in a buffer they go to their places
     *  in the whole picture, and other rows stay as they are */
    uint32_t first_row;
    uint32_t row_count; /**< of the band, cut at the picture's end: a multiple as well; 0: all rows from first_row on */
} svo_render_options;

/** Everything zero; width, height and camera have to be set. */
#define SVO_RENDER_OPTIONS_INIT SVO_STRUCT_INIT(svo_render_options)

/** Draws a picture of a tree, a compact tree, a scene or a light.
 *
 * Of trees SVO_VIEW_SHADED shades voxels by normal (their own, else that of the face where the ray entered) and color
 * (their own, else clay of albedo 0.6), with the shadows of a sun behind the camera and a sky that neighbors darken, by
 * four rays for each pixel or as many as options ask for. Up to a half, 0.85 times the light is the share of white that
 * a pixel shows; above, highlights roll off as 1 - exp(1 - 2 light) / 2. Bytes are square roots of shares. A voxel that
 * shows in part takes as many of a pixel's rays as its alpha tells, and from an alpha of a half on it has a shadow.
 * svo_scene_target and svo_light_target say what others' pictures show. A picture is the same on every run.
 *
 * The first call of a device handle compiles the kernel, and views of a tree with triangles, all but SVO_VIEW_SHADED,
 * make its BVH, see the head of this file; that is waited for.
 *
 * \param target on a device, its colors and normals, if any, on all levels; stays as it is until the picture is drawn
 * \param options size, camera and view; not used after the call
 * \param pixels receives height rows of width * 4 bytes, top to bottom; of SVO_PIXELS_LINEAR width * 4 floats. A
 *        sub-buffer puts the picture somewhere else in a larger buffer
 * \param submit NULL: the device's own queue, and the call waits
 * \returns SVO_UNSUPPORTED (the target has no pictures, or its grid is beyond the range of floats), SVO_NOT_ON_DEVICE
 *          (without words, since there is no device to have them), SVO_COMPILE_FAILED, SVO_CL_ERROR,
 *          SVO_OUT_OF_DEVICE_MEMORY or SVO_INVALID_ARGUMENT on failure. After SVO_INVALID_ARGUMENT pixels are as
 *          before; after others they are undefined. */
SVO_API svo_status svo_render(svo_target target, const svo_render_options *options, svo_array pixels,
                              const svo_submit *submit);

/** How a BVH is made. Hits are the same. */
typedef enum svo_bvh_quality {
    SVO_BVH_BEST = 0, /**< splits by the surface area heuristic throughout: most rays per second */
    SVO_BVH_FAST = 1 /**< splits of triangles in Morton order: made in about half the time, for what changes often */
} svo_bvh_quality;

/** Makes the tree's BVH and waits for it, unless the tree has one of that quality. One of the other quality is
 *  replaced; on failure it stays. Without this call the first use makes one with SVO_BVH_BEST. It takes two buffers,
 *  ray_nodes and ray_leaves: 51 to 55 bytes per triangle in measurements of 8,000 triangles and more, at most 208 bytes
 *  per triangle plus 192. Where svo_tree_info.positions is not SVO_POSITIONS_FLOAT, leaves hold doubles too: 80 bytes
 *  more per triangle at most. While it is made, up to 140 bytes per triangle more are in use on the device.
 *
 * \param tree with SVO_NEED_RAYS, coverage half-open or closed, on a device; no batch of its rays may be in progress
 * \param quality an svo_bvh_quality
 * \param queue on the context of the tree's device; NULL: the device's own
 * \returns SVO_INVALID_ARGUMENT, SVO_COMPILE_FAILED, SVO_OUT_OF_HOST_MEMORY, SVO_OUT_OF_DEVICE_MEMORY, SVO_CL_ERROR or
 *          SVO_UNSUPPORTED (the device fuses multiplications and additions although the kernels forbid it, so rays
 *          could pass between triangles) on failure. */
SVO_API svo_status svo_tree_make_bvh(svo_tree *tree, svo_bvh_quality quality, cl_command_queue queue);

/** Fits the tree's BVH to a mesh that has moved (svo_plan_update), after a build into the tree. Allocates no device
 * memory, compiles nothing and waits for no build: enqueue it after svo_build_enqueue, with that call's event or on the
 * same in-order queue.
 *
 * The BVH keeps the triangles of each node, those of its first mesh, and gets new boxes and corners. Hits are those of
 * a new BVH; the further the mesh moves from the first, the more boxes overlap and the longer rays take. If a triangle
 * has left the grid, the first use of the BVH after svo_tree_finish makes a new one in its place. A BVH that can be
 * refit takes 140 bytes per triangle more.
 *
 * \param tree of a workspace of an updatable plan with positions in floats, not trimmed, with a BVH that was made while
 *        all its triangles were inside the grid. Rays of its old content come first, by wait or by an in-order queue
 * \param submit NULL: the device's own queue, and the call waits
 * \returns SVO_INVALID_ARGUMENT, SVO_CL_ERROR or SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_tree_refit_bvh(svo_tree *tree, const svo_submit *submit);

/** What a batch of rays asks for. */
typedef enum svo_trace_flags {
    /** The first triangle along each ray: least t as reported, then least position in the mesh. */
    SVO_TRACE_CLOSEST = 0,
    SVO_TRACE_ANY = 1, /**< whether there is a hit; the record is that of some triangle */
    SVO_TRACE_COUNT = 2 /**< the number of triangles hit, each counted once; the record is that of the first */
} svo_trace_flags;

/** Beside one of svo_trace_flags: rays and hits lie by field instead of by record, the layout of vectorized code. An
 *  array of ray_count words for the first of a record's eight words, then one for each other, in their order: of rays
 *  origin x, y, z, direction x, y, z, t_min, t_max; of hits t, triangle, u, v, normal x, y, z, count. The hits are the
 *  same. Of trees alone. */
#define SVO_TRACE_BY_FIELD 4u

#define SVO_TRACE_RAYS_MAX 0x7fffffffu /**< most rays or points in a batch */

/** Traces rays against the triangles of a tree or of a scene's trees: those of the mesh as it was given, as far as
 *  they lie inside the grid; of a tree with SVO_POSITIONS_ROUNDED those of the rounded mesh. On a caller's grid the
 *  hits of a triangle that has a voxel there may lie half a grid unit outside.
 *
 * Hit, t, u and v are computed in double precision and are the same on every device with cl_khr_fp64, whatever the
 * tree's depth; elsewhere the same watertight test runs in single precision, on vertices rounded to floats in grid
 * units, which are off by at most 2^-25 of the grid's width; and hits may lie outside the grid by 2^-19 more of the
 * largest coordinate, from the grid's corner, of a vertex or the ray's origin. t is that of the exact hit, rounded to
 * float, or next to it. Closed surfaces have no gaps: a ray through an edge or a corner hits one of the triangles
 * there. A ray with a number that is not finite (t_max excepted), without a direction, or with t_min above t_max hits
 * nothing.
 *
 * The first call of a device handle compiles the kernel; the first call for a tree makes its BVH. Later calls with
 * buffers allocate nothing on the device.
 *
 * \param target a tree with SVO_NEED_RAYS, coverage half-open or closed, on a device; or a scene of such trees
 * \param rays ray_count records of svo_ray; all zero allowed when that is 0
 * \param hits receives a record for each ray, in their order: svo_hit, of a scene svo_scene_triangle_hit
 * \param ray_count at most SVO_TRACE_RAYS_MAX
 * \param flags one of svo_trace_flags, SVO_TRACE_BY_FIELD added or not; of a scene svo_scene_flags
 * \param submit NULL: the device's own queue, and the call waits
 * \returns SVO_INVALID_ARGUMENT, SVO_UNSUPPORTED (the target has no triangles, or its grid is beyond the range of
 *          floats), SVO_COMPILE_FAILED, SVO_CL_ERROR, SVO_OUT_OF_DEVICE_MEMORY, or what svo_tree_make_bvh returns, on
 *          failure. */
SVO_API svo_status svo_trace_triangles(svo_target target, svo_array rays, svo_array hits, size_t ray_count,
                                       uint32_t flags, const svo_submit *submit);

/** Traces rays against the voxels of a tree, a compact tree or a scene: the first leaf along each ray, or the first
 *  larger node that a pixel of the footprint covers. Computed in single precision, by the traversal of svo_trace_voxel
 *  (svo_tree_target). compact.h and scene.h say what their hits are.
 *
 * \param target on a device; needs and coverage do not matter
 * \param rays see svo_trace_triangles
 * \param hits receives a record for each ray, in their order: svo_voxel_hit, of a scene svo_scene_hit
 * \param ray_count at most SVO_TRACE_RAYS_MAX
 * \param footprint width of a pixel's cone per unit of distance, finite and not negative; 0: leaves alone
 * \param flags of a scene svo_scene_flags; else 0
 * \param submit NULL: the device's own queue, and the call waits
 * \returns SVO_INVALID_ARGUMENT, SVO_UNSUPPORTED (the target has no voxels, or its grid is beyond the range of floats),
 *          SVO_COMPILE_FAILED, SVO_CL_ERROR or SVO_OUT_OF_DEVICE_MEMORY on failure. */
SVO_API svo_status svo_trace_voxels(svo_target target, svo_array rays, svo_array hits, size_t ray_count,
                                    float footprint, uint32_t flags, const svo_submit *submit);

/** Finds the nearest triangle to each point: least distance as reported, then least position in the mesh. The mesh is
 *  the one that rays meet. Distances are computed in double precision and rounded to float, on devices with
 *  cl_khr_fp64. Triangles must lie inside the grid, as all do on a fitted one. A point that is not finite, or without a
 *  triangle within its max_distance, has none.
 *
 * \param tree with SVO_NEED_RAYS, coverage half-open or closed, on a device
 * \param points point_count records of svo_query_point; all zero allowed when that is 0
 * \param results receives a record of svo_nearest for each point, in their order
 * \param point_count at most SVO_TRACE_RAYS_MAX
 * \param submit NULL: the device's own queue, and the call waits
 * \returns what svo_trace_triangles returns. */
SVO_API svo_status svo_tree_nearest(svo_tree *tree, svo_array points, svo_array results, size_t point_count,
                                    const svo_submit *submit);

/** Number of kernel arguments that SVO_TREE_PARAMETERS declares. */
#define SVO_TREE_ARGUMENTS 5u

/** OpenCL C 1.2 to put before the source of a kernel of the caller's, which then queries the target.
 *
 *     clCreateProgramWithSource(context, 2, (const char *[]){svo_kernel_source(target), mine}, NULL, &error)
 *     clBuildProgram(program, 1, &device, svo_kernel_options(target), NULL, NULL)
 *
 * What it declares is said at svo_tree_target, svo_compact_target, svo_light_target and svo_probes_target. Its other
 * names begin with svo_ or SVO_. One program may have the texts of a tree and a light, in any order.
 *
 * \param target its handle may be NULL
 * \returns a static string; NULL of a target without one. */
SVO_API const char *svo_kernel_source(svo_target target);

/** Compiler options for svo_kernel_source.
 *
 * \param target the one whose arguments are set: compact trees and lights of different forms have different options.
 *        Its handle may be NULL otherwise
 * \returns a static string; NULL of a target without a source, and where the handle is NULL but matters. */
SVO_API const char *svo_kernel_options(svo_target target);

/** Sets the kernel arguments that the source's macro of parameters declares: SVO_TREE_PARAMETERS,
 *  SVO_LIGHT_PARAMETERS or SVO_PROBES_PARAMETERS. Those of a light hold until svo_light_set_sources.
 *
 * \param target on a device; must outlive the kernel's launches. The triangles of a tree need SVO_NEED_RAYS and
 *        coverage half-open or closed; this call then makes the BVH
 * \param kernel of the caller's, of the context of the target's device
 * \param first_index of SVO_TREE_ARGUMENTS, SVO_COMPACT_ARGUMENTS, SVO_LIGHT_ARGUMENTS or SVO_PROBES_ARGUMENTS
 *        consecutive arguments
 * \returns SVO_INVALID_ARGUMENT, SVO_UNSUPPORTED, SVO_NOT_ON_DEVICE, SVO_OUT_OF_HOST_MEMORY,
 *          SVO_OUT_OF_DEVICE_MEMORY or SVO_CL_ERROR on failure. */
SVO_API svo_status svo_kernel_set_arguments(svo_target target, cl_kernel kernel, cl_uint first_index);

#ifdef __cplusplus
}
#endif

#endif
