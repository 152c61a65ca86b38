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
#include "rays/bounds.h"
#include "rays/camera.h"
#include "rays/rays.h"
#include "shared/layout.h"
#include "svocl/plan.h"

_Static_assert((uint32_t)SVO_VIEW_NORMAL == SVO_VIEW_KIND_NORMAL && (uint32_t)SVO_VIEW_DEPTH == SVO_VIEW_KIND_DEPTH &&
                   (uint32_t)SVO_VIEW_STEPS == SVO_VIEW_KIND_STEPS && (uint32_t)SVO_VIEW_LEVEL == SVO_VIEW_KIND_LEVEL &&
                   (uint32_t)SVO_VIEW_TRIANGLES == SVO_VIEW_KIND_TRIANGLES,
               "svo_render_view and kernels/rays/view.cl number the views alike");

#define PICTURE_EDGE_MAX 16384u
/* Rays along each side of a pixel. */
#define SAMPLES   2u
#define TILE_EDGE 8u

/* ---- framing ---- */

/* The occupied part in world coordinates; the whole grid without host arrays or leaves. */
static void occupied_bounds(const svo_tree *tree, double low[3], double high[3])
{
    svo_i_cell_bounds bounds;
    svo_i_occupied_cells(&tree->info, tree->host[SVO_TREE_CHILD_MASK], tree->host[SVO_TREE_FIRST_CHILD], &bounds);
    for (int axis = 0; axis < 3; ++axis) {
        low[axis] = tree->info.origin[axis] + tree->info.edge * bounds.low[axis] / bounds.cells;
        high[axis] = tree->info.origin[axis] + tree->info.edge * bounds.high[axis] / bounds.cells;
    }
}

void svo_camera_frame(const svo_tree *tree, float aspect, svo_camera *camera)
{
    double low[3];
    double high[3];
    occupied_bounds(tree, low, high);
    svo_i_camera_frame(low, high, aspect, camera);
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
    if (tree->pending != NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                 "svo_tree_render: the tree's build is in flight; call svo_tree_finish first");
    }
    if (tree->buffers[SVO_TREE_CHILD_MASK] == NULL || tree->buffers[SVO_TREE_FIRST_CHILD] == NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                 "svo_tree_render: the tree is not on a device; call svo_tree_upload first");
    }
    return SVO_OK;
}

static svo_status fill_params(svo_device *device, const svo_tree *tree, const svo_render_options *options,
                              svo_cast_params *params)
{
    svo_i_view looking = {{0}, {0}, {0}};
    if (!svo_i_view_from_camera(&options->camera, &looking)) {
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
    (void)svo_i_normalize(up, sky);
    svo_i_place_sun(&looking, sky, sun);
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
