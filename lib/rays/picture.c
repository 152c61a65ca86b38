/* SPDX-License-Identifier: MIT */
/* Pictures of voxels, whatever holds them: the host side of kernels/rays/render.cl and view.cl. */
#include "rays/picture.h"

#include <math.h>
#include <stdio.h>

#include "core/device.h"
#include "core/struct_size.h"
#include "rays/camera.h"
#include "shared/layout.h"

_Static_assert((uint32_t)SVO_VIEW_NORMAL == SVO_VIEW_KIND_NORMAL && (uint32_t)SVO_VIEW_DEPTH == SVO_VIEW_KIND_DEPTH &&
                   (uint32_t)SVO_VIEW_STEPS == SVO_VIEW_KIND_STEPS && (uint32_t)SVO_VIEW_LEVEL == SVO_VIEW_KIND_LEVEL &&
                   (uint32_t)SVO_VIEW_TRIANGLES == SVO_VIEW_KIND_TRIANGLES,
               "svo_render_view and kernels/rays/view.cl number the views alike");

svo_status svo_i_picture_options(svo_device *device, const char *function, const svo_render_options *options,
                                 svo_render_options *out)
{
    SVO_I_TRY(svo_i_struct_read(&device->message, function, "options", options, out,
                                SVO_I_STRUCT_SIZES(svo_render_options, camera)));
    SVO_I_TRY(svo_i_camera_check(device, function, &out->camera, out->width, out->height));
    SVO_I_TRY(svo_i_clip_check(device, function, out->clip));
    if ((unsigned)out->view > SVO_VIEW_TRIANGLES) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.view %d is not in 0 .. %d", function,
                                 (int)out->view, (int)SVO_VIEW_TRIANGLES);
    }
    return SVO_OK;
}

/* Pictures show nodes of all levels. */
static svo_status check_payload(const svo_i_picture_source *source)
{
    const bool everywhere =
        (source->colors == NULL || source->one_color) && (source->normals == NULL || source->one_normal);
    if (source->payload_level == 0 || everywhere) {
        return SVO_OK;
    }
    return svo_i_device_fail(source->device, SVO_INVALID_ARGUMENT,
                             "%s: the tree has payload from level %u on only, and pictures need all levels",
                             source->function, source->payload_level);
}

/* What is written of each pixel. */
static svo_status describe_output(const svo_i_picture_source *source, const svo_render_options *options,
                                  svo_i_pixel_output *out)
{
    const bool shaded = options->view == SVO_VIEW_SHADED;
    return svo_i_pixel_output_of(source->device, source->function, "options", &options->output,
                                 shaded ? SVO_CAST_SAMPLES : 1u, shaded ? SVO_I_CURVE_ROOT : SVO_I_CURVE_NONE, out);
}

/* A plane of the world in voxels: its normal is as long as it was, and so is what it has above it, times voxels. */
static void fill_clip(const svo_i_picture_source *source, const float world[4], double voxels_per_unit,
                      svo_cast_params *params)
{
    double above = (double)world[3]; /* of the grid's corner */
    for (int axis = 0; axis < 3; ++axis) {
        above += (double)world[axis] * source->grid.origin[axis];
        params->clip[axis] = world[axis];
    }
    params->clip[3] = (float)(above * voxels_per_unit);
}

static svo_status fill_params(const svo_i_picture_source *source, const svo_render_options *options,
                              const svo_i_pixel_output *output, svo_cast_params *params)
{
    svo_i_pinhole hole;
    SVO_I_TRY(svo_i_pinhole_from_camera(source->device, source->function, &options->camera, options->width,
                                        options->height, &hole));
    const double voxels = (double)(1u << source->grid.depth);
    const double voxels_per_unit = source->grid.scale * voxels / (double)(1u << source->grid.snap_bits);
    double sun[3];
    svo_i_place_sun(&hole.view, hole.up, sun);
    for (int axis = 0; axis < 3; ++axis) {
        params->eye[axis] = (float)(((double)options->camera.eye[axis] - source->grid.origin[axis]) * voxels_per_unit);
        params->corner[axis] = hole.corner[axis];
        params->across[axis] = hole.across[axis];
        params->down[axis] = hole.down[axis];
        params->sun[axis] = (float)sun[axis];
        params->up[axis] = (float)hole.up[axis];
        params->background[axis] = output->background[axis];
    }
    fill_clip(source, options->clip, voxels_per_unit, params);
    params->samples = output->samples;
    params->pixel_flags = output->flags;
    params->footprint = (float)(hole.pixel / sqrt((double)output->samples));
    params->width = options->width;
    params->height = options->height;
    params->depth = source->grid.depth;
    params->occlusion_range = (float)(voxels / 14 + 2);
    return SVO_OK;
}

/* Buffers and kernel of one picture. */
typedef struct picture {
    svo_i_tiles tiles; /* its kernel: owned */
    cl_mem params; /* owned */
    cl_mem pixels;
} picture;

static const char *normal_defines(const svo_i_picture_source *source)
{
    return source->normals == NULL ? "" : source->one_normal ? " -DSVO_NORMAL -DSVO_ONE_NORMAL" : " -DSVO_NORMAL";
}

static const char *color_defines(const svo_i_picture_source *source)
{
    return source->colors == NULL ? "" : source->one_color ? " -DSVO_COLOR -DSVO_ONE_COLOR" : " -DSVO_COLOR";
}

/* Makes a kernel of a program. first: defines besides those of normals and form. */
static svo_status make_kernel(const svo_i_picture_source *source, svo_i_program_kind kind, const char *first,
                              const char *name, cl_kernel *out)
{
    char defines[SVO_I_PROGRAM_DEFINES_BYTES];
    cl_program program = NULL;
    (void)snprintf(defines, sizeof defines, "%s%s%s", first, normal_defines(source), source->form_defines);
    SVO_I_TRY(svo_i_program_get(source->device, source->function, kind, defines, &program, NULL));
    return svo_i_kernel_create(source->device, source->function, program, name, out);
}

/* The kernel of an unlit view, with all arguments set but the first tile. */
static svo_status prepare_view(const svo_i_picture_source *source, const svo_render_options *options, picture *drawn)
{
    const cl_float4 eye = {{options->camera.eye[0], options->camera.eye[1], options->camera.eye[2], 0}};
    const cl_uint shown = options->view;
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(source->normals), SVO_I_ARGUMENT(drawn->params),
                                        SVO_I_ARGUMENT(eye), SVO_I_ARGUMENT(shown), SVO_I_ARGUMENT(drawn->pixels)};
    SVO_I_TRY(make_kernel(source, SVO_I_PROGRAM_VIEW, "", "svo_k_view", &drawn->tiles.kernel));
    drawn->tiles.items = SVO_GROUP_ITEMS;
    drawn->tiles.first_tile = source->tree.arguments + 5;
    SVO_I_TRY(source->tree.set(source->tree.of, source->function, drawn->tiles.kernel, 0));
    return svo_i_kernel_set_from(source->device, source->function, drawn->tiles.kernel, source->tree.arguments,
                                 arguments, 5);
}

/* The kernel of a shaded picture, with all arguments set but the first tile. */
static svo_status prepare_shaded(const svo_i_picture_source *source, picture *drawn)
{
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(source->colors), SVO_I_ARGUMENT(source->normals),
                                        SVO_I_ARGUMENT(drawn->params), SVO_I_ARGUMENT(drawn->pixels)};
    const bool tiles = source->device->cpu_path;
    char defines[64];
    (void)snprintf(defines, sizeof defines, "%s%s", tiles ? " -DSVO_CAST_TILES" : "", color_defines(source));
    SVO_I_TRY(make_kernel(source, SVO_I_PROGRAM_CAST, defines, "svo_k_cast", &drawn->tiles.kernel));
    drawn->tiles.items = tiles ? 1 : SVO_GROUP_ITEMS;
    drawn->tiles.first_tile = source->node_arguments + 4;
    for (cl_uint i = 0; i < source->node_arguments; ++i) {
        SVO_I_TRY(svo_i_kernel_set_from(source->device, source->function, drawn->tiles.kernel, i,
                                        &(svo_i_argument){sizeof(cl_mem), &source->nodes[i], true}, 1));
    }
    return svo_i_kernel_set_from(source->device, source->function, drawn->tiles.kernel, source->node_arguments,
                                 arguments, 4);
}

static svo_status enqueue(const svo_i_picture_source *source, const svo_render_options *options,
                          const svo_i_pixel_output *output, const svo_i_pixels *to)
{
    svo_cast_params params = {.depth = 0};
    picture drawn = {.tiles = {.width = options->width, .height = options->height}, .pixels = to->buffer};
    svo_status status = SVO_OK;
    SVO_I_TRY(fill_params(source, options, output, &params));
    SVO_I_TRY_CLEANUP(
        svo_i_device_constants(source->device, source->function, "camera", &params, sizeof params, &drawn.params));
    SVO_I_TRY_CLEANUP(options->view == SVO_VIEW_SHADED ? prepare_shaded(source, &drawn)
                                                       : prepare_view(source, options, &drawn));
    SVO_I_TRY_CLEANUP(svo_i_pixels_draw(source->device, source->function, &drawn.tiles, to));

cleanup:
    if (drawn.params != NULL) {
        clReleaseMemObject(drawn.params);
    }
    if (drawn.tiles.kernel != NULL) {
        clReleaseKernel(drawn.tiles.kernel);
    }
    return status;
}

svo_status svo_i_picture_enqueue(const svo_i_picture_source *source, const svo_render_options *options,
                                 svo_i_pixels *to)
{
    svo_i_pixel_output output;
    SVO_I_TRY(check_payload(source));
    SVO_I_TRY(describe_output(source, options, &output));
    SVO_I_TRY(
        svo_i_pixels_check(source->device, source->function, options->width, options->height, output.pixel_bytes, to));
    return enqueue(source, options, &output, to);
}

svo_status svo_i_picture_draw(const svo_i_picture_source *source, const svo_render_options *options,
                              cl_command_queue queue, uint8_t *rgba)
{
    svo_i_pixel_output output;
    svo_i_own_pixels own;
    svo_status status = SVO_OK;
    SVO_I_TRY(check_payload(source));
    SVO_I_TRY(describe_output(source, options, &output));
    SVO_I_TRY(svo_i_own_pixels_begin(source->device, source->function, options->width, options->height,
                                     output.pixel_bytes, queue, &own));
    SVO_I_TRY_CLEANUP(enqueue(source, options, &output, &own.to));
    SVO_I_TRY_CLEANUP(svo_i_own_pixels_read(&own, 0, options->height, rgba));

cleanup:
    svo_i_own_pixels_end(&own);
    return status;
}
