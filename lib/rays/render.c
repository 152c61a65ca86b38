/* SPDX-License-Identifier: MIT */
/* Cameras and pictures: the host side of kernels/rays/render.cl and view.cl. */
#include "svocl/trace.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "core/device.h"
#include "core/message.h"
#include "core/program.h"
#include "core/struct_size.h"
#include "core/tree.h"
#include "rays/rays.h"
#include "shared/layout.h"
#include "svocl/plan.h"

_Static_assert((uint32_t)SVO_VIEW_NORMAL == SVO_VIEW_KIND_NORMAL && (uint32_t)SVO_VIEW_DEPTH == SVO_VIEW_KIND_DEPTH &&
                   (uint32_t)SVO_VIEW_STEPS == SVO_VIEW_KIND_STEPS && (uint32_t)SVO_VIEW_LEVEL == SVO_VIEW_KIND_LEVEL &&
                   (uint32_t)SVO_VIEW_TRIANGLES == SVO_VIEW_KIND_TRIANGLES,
               "svo_render_view and kernels/rays/view.cl number the views alike");

#define PICTURE_EDGE_MAX 16384u
/* The deepest level that is searched for the bounds of the occupied part. */
#define BOUNDS_LEVEL_MAX 6u
/* Rays along each side of a pixel. */
#define SAMPLES   2u
#define TILE_EDGE 8u

/* ---- vectors ---- */

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/* False, and out untouched, for a vector without a direction. */
static bool normalize(const double a[3], double out[3])
{
    const double length = sqrt(dot(a, a));
    if (!(length > 0) || !isfinite(length)) {
        return false;
    }
    for (int axis = 0; axis < 3; ++axis) {
        out[axis] = a[axis] / length;
    }
    return true;
}

/* An orthonormal camera frame. */
typedef struct view {
    double forward[3], right[3], up[3];
} view;

static bool view_from_camera(const svo_camera *camera, view *out)
{
    double towards[3];
    double up[3];
    for (int axis = 0; axis < 3; ++axis) {
        towards[axis] = (double)camera->target[axis] - (double)camera->eye[axis];
        up[axis] = camera->up[axis];
    }
    double right[3];
    if (!normalize(towards, out->forward) || !normalize(up, up)) {
        return false;
    }
    cross(out->forward, up, right);
    /* A millionth of a radian off parallel is enough for floats. */
    if (dot(right, right) < 1e-12 || !normalize(right, out->right)) {
        return false;
    }
    cross(out->right, out->forward, out->up);
    return true;
}

/* ---- framing ---- */

/* A box of cells on one level. */
typedef struct cell_bounds {
    uint32_t low[3], high[3]; /* high: one past the last cell */
} cell_bounds;

/* The tree's nodes on the host; NULL where the tree has no host arrays. */
typedef struct node_arrays {
    const uint8_t *child_mask;
    const uint32_t *first_child;
} node_arrays;

static void extend_bounds(const node_arrays *arrays, uint32_t node, uint32_t levels_left, const uint32_t cell[3],
                          cell_bounds *bounds)
{
    if (levels_left == 0) {
        for (int axis = 0; axis < 3; ++axis) {
            bounds->low[axis] = cell[axis] < bounds->low[axis] ? cell[axis] : bounds->low[axis];
            bounds->high[axis] = cell[axis] >= bounds->high[axis] ? cell[axis] + 1 : bounds->high[axis];
        }
        return;
    }
    uint32_t child = arrays->first_child[node];
    for (uint32_t octant = 0; octant < 8; ++octant) {
        if ((arrays->child_mask[node] >> octant & 1) != 0) {
            const uint32_t inner[3] = {2 * cell[0] + (octant & 1), 2 * cell[1] + (octant >> 1 & 1),
                                       2 * cell[2] + (octant >> 2)};
            extend_bounds(arrays, child, levels_left - 1, inner, bounds);
            ++child;
        }
    }
}

/* The occupied part in world coordinates; the whole grid without host arrays or leaves. */
static void occupied_bounds(const svo_tree *tree, double low[3], double high[3])
{
    const uint32_t level = tree->info.depth < BOUNDS_LEVEL_MAX ? tree->info.depth : BOUNDS_LEVEL_MAX;
    const uint32_t cells = 1u << level;
    cell_bounds bounds = {{0, 0, 0}, {cells, cells, cells}};
    const node_arrays arrays = {tree->host[SVO_TREE_CHILD_MASK], tree->host[SVO_TREE_FIRST_CHILD]};
    if (arrays.child_mask != NULL && arrays.first_child != NULL && tree->info.leaf_count > 0) {
        bounds = (cell_bounds){{cells, cells, cells}, {0, 0, 0}};
        const uint32_t root[3] = {0, 0, 0};
        extend_bounds(&arrays, 0, level, root, &bounds);
    }
    for (int axis = 0; axis < 3; ++axis) {
        low[axis] = tree->info.origin[axis] + tree->info.edge * bounds.low[axis] / cells;
        high[axis] = tree->info.origin[axis] + tree->info.edge * bounds.high[axis] / cells;
    }
}

/* A corner of a box as a camera at distance sees it: tangents to the right and upwards, and depth past the target. */
typedef struct seen_corner {
    double right, up, beyond;
} seen_corner;

static void see_corners(const view *camera_view, const double target[3], const double low[3], const double high[3],
                        seen_corner corners[8])
{
    for (int k = 0; k < 8; ++k) {
        double offset[3];
        for (int axis = 0; axis < 3; ++axis) {
            offset[axis] = ((k >> axis & 1) != 0 ? high[axis] : low[axis]) - target[axis];
        }
        corners[k].right = dot(offset, camera_view->right);
        corners[k].up = dot(offset, camera_view->up);
        corners[k].beyond = dot(offset, camera_view->forward);
    }
}

/* The least distance from which all corners are inside a view of these half tangents. */
static double framing_distance(const seen_corner corners[8], double tangent_right, double tangent_up)
{
    double distance = 0;
    for (int k = 0; k < 8; ++k) {
        distance = fmax(distance, fabs(corners[k].right) / tangent_right - corners[k].beyond);
        distance = fmax(distance, fabs(corners[k].up) / tangent_up - corners[k].beyond);
    }
    return distance;
}

/* Moves the target so that the corners are centered in the picture. */
static void center_target(const view *camera_view, const seen_corner corners[8], double distance, double target[3])
{
    double low[2] = {HUGE_VAL, HUGE_VAL};
    double high[2] = {-HUGE_VAL, -HUGE_VAL};
    for (int k = 0; k < 8; ++k) {
        const double depth = distance + corners[k].beyond;
        const double seen[2] = {corners[k].right / depth, corners[k].up / depth};
        for (int side = 0; side < 2; ++side) {
            low[side] = fmin(low[side], seen[side]);
            high[side] = fmax(high[side], seen[side]);
        }
    }
    for (int axis = 0; axis < 3; ++axis) {
        target[axis] += distance * 0.5 *
                        ((low[0] + high[0]) * camera_view->right[axis] + (low[1] + high[1]) * camera_view->up[axis]);
    }
}

void svo_camera_frame(const svo_tree *tree, float aspect, svo_camera *camera)
{
    const double shape = isfinite(aspect) && aspect > 0.0f ? (double)aspect : 1.0;
    const double half_fov = 0.28;
    const double margin = 1.04;
    double low[3];
    double high[3];
    occupied_bounds(tree, low, high);
    /* 26 degrees to the right and 22 above the z axis, which points to the viewer; y is up. */
    const svo_camera direction = {
        .eye = {0.406f, 0.375f, 0.833f}, .up = {0, 1, 0}, .vertical_fov = (float)(2 * half_fov)};
    view looking = {{0}, {0}, {0}};
    (void)view_from_camera(&direction, &looking);
    double target[3];
    for (int axis = 0; axis < 3; ++axis) {
        target[axis] = 0.5 * (low[axis] + high[axis]);
    }
    const double tangent_up = tan(half_fov) / margin;
    double distance = 0;
    for (int pass = 0; pass < 4; ++pass) {
        seen_corner corners[8];
        see_corners(&looking, target, low, high, corners);
        distance = framing_distance(corners, tangent_up * shape, tangent_up);
        if (pass < 3) {
            center_target(&looking, corners, distance, target);
        }
    }
    *camera = direction;
    for (int axis = 0; axis < 3; ++axis) {
        camera->target[axis] = (float)target[axis];
        camera->eye[axis] = (float)(target[axis] - distance * looking.forward[axis]);
    }
}

/* ---- rendering ---- */

static svo_status check_options(svo_device *device, const svo_tree *tree, const svo_render_options *options)
{
    SVO_I_TRY(svo_i_tree_check(tree, "svo_tree_render"));
    if (options->width < 1 || options->width > PICTURE_EDGE_MAX || options->height < 1 ||
        options->height > PICTURE_EDGE_MAX) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "svo_tree_render: %u x %u pixels are not within 1 .. %u",
                                 options->width, options->height, PICTURE_EDGE_MAX);
    }
    const double fov = (double)options->camera.vertical_fov;
    if (!(fov > 0) || !(fov < 3.14159265358979)) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                 "svo_tree_render: camera.vertical_fov %g is not between 0 and pi", fov);
    }
    if ((unsigned)options->view > SVO_VIEW_TRIANGLES) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "svo_tree_render: options.view %d is not in 0 .. %d",
                                 (int)options->view, (int)SVO_VIEW_TRIANGLES);
    }
    if (tree->device != NULL && tree->device != device) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "svo_tree_render: the tree is on another device");
    }
    if (tree->buffers[SVO_TREE_CHILD_MASK] == NULL || tree->buffers[SVO_TREE_FIRST_CHILD] == NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                 "svo_tree_render: the tree is not on a device; call svo_tree_upload first");
    }
    return SVO_OK;
}

/* Towards the light: high, and over the right shoulder of whoever looks along the view. */
static void place_sun(const view *looking, const double up[3], double sun[3])
{
    double raw[3];
    for (int axis = 0; axis < 3; ++axis) {
        raw[axis] = 0.85 * up[axis] + 0.50 * looking->right[axis] - 0.38 * looking->forward[axis];
    }
    if (!normalize(raw, sun)) {
        memcpy(sun, up, 3 * sizeof *sun);
    }
}

static svo_status fill_params(svo_device *device, const svo_tree *tree, const svo_render_options *options,
                              svo_cast_params *params)
{
    view looking = {{0}, {0}, {0}};
    if (!view_from_camera(&options->camera, &looking)) {
        return svo_i_device_fail(
            device, SVO_INVALID_ARGUMENT,
            "svo_tree_render: camera.eye, target and up are not finite, or up is along the line of sight");
    }
    const double tangent = tan(0.5 * (double)options->camera.vertical_fov);
    const double pixel = 2 * tangent / options->height;
    const double voxels = (double)(1u << tree->info.depth);
    const double voxels_per_unit = tree->info.scale * voxels / (double)(1u << tree->info.snap_bits);
    const double up[3] = {(double)options->camera.up[0], (double)options->camera.up[1], (double)options->camera.up[2]};
    double sky[3] = {0, 1, 0};
    double sun[3];
    (void)normalize(up, sky);
    place_sun(&looking, sky, sun);
    for (int axis = 0; axis < 3; ++axis) {
        params->eye[axis] = (float)(((double)options->camera.eye[axis] - tree->info.origin[axis]) * voxels_per_unit);
        params->corner[axis] = (float)(looking.forward[axis] + tangent * looking.up[axis] -
                                       0.5 * pixel * options->width * looking.right[axis]);
        params->across[axis] = (float)(pixel * looking.right[axis]);
        params->down[axis] = (float)(-pixel * looking.up[axis]);
        params->sun[axis] = (float)sun[axis];
        params->up[axis] = (float)sky[axis];
    }
    params->footprint = (float)pixel;
    params->width = options->width;
    params->height = options->height;
    params->depth = tree->info.depth;
    params->samples = SAMPLES;
    params->occlusion_range = (float)(voxels / 14 + 2);
    return SVO_OK;
}

/* Buffers and kernel of one picture. */
typedef struct picture {
    cl_kernel kernel;
    cl_mem params, pixels;
} picture;

static const char *normal_defines(const svo_tree *tree)
{
    return tree->buffers[SVO_TREE_NORMALS] == NULL                 ? ""
           : svo_i_tree_is_constant(&tree->info, SVO_TREE_NORMALS) ? " -DSVO_NORMAL -DSVO_ONE_NORMAL"
                                                                   : " -DSVO_NORMAL";
}

static const char *color_defines(const svo_tree *tree)
{
    return tree->buffers[SVO_TREE_COLORS] == NULL                 ? ""
           : svo_i_tree_is_constant(&tree->info, SVO_TREE_COLORS) ? " -DSVO_COLOR -DSVO_ONE_COLOR"
                                                                  : " -DSVO_COLOR";
}

/* Pictures show nodes of all levels. */
static svo_status check_payload(svo_device *device, const svo_tree *tree)
{
    const uint32_t shown = (uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL;
    if (tree->info.payload_level == 0 || (tree->info.need & shown & ~tree->info.constant) == 0) {
        return SVO_OK;
    }
    return svo_i_device_fail(
        device, SVO_INVALID_ARGUMENT,
        "svo_tree_render: the tree has payload from level %u on only, and pictures need all levels",
        tree->info.payload_level);
}

/* The kernel of an unlit view, with all arguments set. */
static svo_status prepare_view(svo_device *device, svo_tree *tree, const svo_render_options *options,
                               const picture *drawn, cl_kernel *out)
{
    const cl_mem normals = tree->buffers[SVO_TREE_NORMALS];
    const cl_float4 eye = {{options->camera.eye[0], options->camera.eye[1], options->camera.eye[2], 0}};
    const cl_uint shown = options->view;
    cl_program program = NULL;
    if (options->view == SVO_VIEW_TRIANGLES) {
        SVO_I_TRY(svo_i_rays_check(tree, "svo_tree_render"));
    }
    SVO_I_TRY(svo_i_program_get(device, "svo_tree_render", SVO_I_PROGRAM_VIEW, normal_defines(tree), &program, NULL));
    SVO_I_TRY(svo_i_kernel_create(device, "svo_tree_render", program, "svo_k_view", out));
    SVO_I_TRY(svo_tree_set_args(tree, *out, 0));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(normals), SVO_I_ARGUMENT(drawn->params), SVO_I_ARGUMENT(eye),
                                        SVO_I_ARGUMENT(shown), SVO_I_ARGUMENT(drawn->pixels)};
    return svo_i_rays_set(tree, "svo_tree_render", *out, SVO_TREE_ARGUMENTS, arguments, 5);
}

/* The kernel of a shaded picture, with all arguments set. */
static svo_status prepare_shaded(svo_device *device, const svo_tree *tree, const picture *drawn, cl_kernel *out)
{
    const cl_mem colors = tree->buffers[SVO_TREE_COLORS];
    const cl_mem normals = tree->buffers[SVO_TREE_NORMALS];
    char defines[sizeof " -DSVO_COLOR -DSVO_ONE_COLOR -DSVO_NORMAL -DSVO_ONE_NORMAL"];
    cl_program program = NULL;
    (void)snprintf(defines, sizeof defines, "%s%s", color_defines(tree), normal_defines(tree));
    SVO_I_TRY(svo_i_program_get(device, "svo_tree_render", SVO_I_PROGRAM_CAST, defines, &program, NULL));
    SVO_I_TRY(svo_i_kernel_create(device, "svo_tree_render", program, "svo_k_cast", out));
    const svo_i_argument arguments[] = {
        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_CHILD_MASK]),
        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_FIRST_CHILD]),
        SVO_I_ARGUMENT(colors),
        SVO_I_ARGUMENT(normals),
        SVO_I_ARGUMENT(drawn->params),
        SVO_I_ARGUMENT(drawn->pixels),
    };
    return svo_i_kernel_set(device, "svo_tree_render", *out, arguments, sizeof arguments / sizeof arguments[0]);
}

static svo_status prepare(svo_device *device, svo_tree *tree, const svo_render_options *options, picture *out)
{
    const size_t pixel_bytes = (size_t)options->width * options->height * 4;
    SVO_I_TRY(svo_i_device_buffer(device, "svo_tree_render", "camera", CL_MEM_READ_ONLY, sizeof(svo_cast_params),
                                  &out->params));
    SVO_I_TRY(svo_i_device_buffer(device, "svo_tree_render", "picture", CL_MEM_WRITE_ONLY, pixel_bytes, &out->pixels));
    return options->view == SVO_VIEW_SHADED ? prepare_shaded(device, tree, out, &out->kernel)
                                            : prepare_view(device, tree, options, out, &out->kernel);
}

/* Each command waits for the previous one by an event, since the queue may be out-of-order. */
static svo_status draw(svo_device *device, cl_command_queue queue, const picture *drawn, const svo_cast_params *params,
                       uint8_t *rgba)
{
    const size_t tiles =
        (size_t)((params->width + TILE_EDGE - 1) / TILE_EDGE) * ((params->height + TILE_EDGE - 1) / TILE_EDGE);
    const size_t local = SVO_GROUP_ITEMS;
    const size_t global = tiles * local;
    const size_t pixel_bytes = (size_t)params->width * params->height * 4;
    cl_event cast = NULL;
    const char *call = "clEnqueueWriteBuffer";
    cl_int error = clEnqueueWriteBuffer(queue, drawn->params, CL_TRUE, 0, sizeof *params, params, 0, NULL, NULL);
    if (error == CL_SUCCESS) {
        call = "clEnqueueNDRangeKernel";
        error = clEnqueueNDRangeKernel(queue, drawn->kernel, 1, NULL, &global, &local, 0, NULL, &cast);
    }
    if (error == CL_SUCCESS) {
        call = "clEnqueueReadBuffer";
        error = clEnqueueReadBuffer(queue, drawn->pixels, CL_TRUE, 0, pixel_bytes, rgba, 1, &cast, NULL);
    }
    if (cast != NULL) {
        clReleaseEvent(cast);
    }
    return error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(device, "svo_tree_render", call, error);
}

svo_status svo_tree_render(svo_device *device, svo_tree *tree, const svo_render_options *options,
                           cl_command_queue queue, uint8_t *rgba)
{
    static const char function[] = "svo_tree_render";
    svo_render_options asked;
    svo_cast_params params = {.depth = 0};
    picture drawn = {NULL, NULL, NULL};
    svo_status status = SVO_OK;
    if (device == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    if (tree == NULL || options == NULL || rgba == NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: %s is NULL", function,
                                 tree == NULL      ? "tree"
                                 : options == NULL ? "options"
                                                   : "rgba");
    }
    SVO_I_TRY(svo_i_struct_read(&device->message, function, "options", options, &asked,
                                SVO_I_STRUCT_SIZES(svo_render_options, camera)));
    SVO_I_TRY(check_options(device, tree, &asked));
    SVO_I_TRY(check_payload(device, tree));
    SVO_I_TRY(fill_params(device, tree, &asked, &params));
    SVO_I_TRY(svo_i_device_queue(device, function, queue, &queue));
    SVO_I_TRY_CLEANUP(prepare(device, tree, &asked, &drawn));
    SVO_I_TRY_CLEANUP(draw(device, queue, &drawn, &params, rgba));

cleanup:
    if (drawn.pixels != NULL) {
        clReleaseMemObject(drawn.pixels);
    }
    if (drawn.params != NULL) {
        clReleaseMemObject(drawn.params);
    }
    if (drawn.kernel != NULL) {
        clReleaseKernel(drawn.kernel);
    }
    return status;
}
