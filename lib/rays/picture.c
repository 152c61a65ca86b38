/* SPDX-License-Identifier: MIT */
/* Pictures of voxels, whatever holds them: the host side of kernels/rays/render.cl and view.cl. */
#include "rays/picture.h"

#include <stdio.h>

#include "core/device.h"
#include "core/struct_size.h"
#include "rays/camera.h"
#include "shared/layout.h"

_Static_assert((uint32_t)SVO_VIEW_NORMAL == SVO_VIEW_KIND_NORMAL && (uint32_t)SVO_VIEW_DEPTH == SVO_VIEW_KIND_DEPTH &&
                   (uint32_t)SVO_VIEW_STEPS == SVO_VIEW_KIND_STEPS && (uint32_t)SVO_VIEW_LEVEL == SVO_VIEW_KIND_LEVEL &&
                   (uint32_t)SVO_VIEW_TRIANGLES == SVO_VIEW_KIND_TRIANGLES,
               "svo_render_view and kernels/rays/view.cl number the views alike");

#define TILE_EDGE 8u

svo_status svo_i_picture_options(svo_device *device, const char *function, const svo_render_options *options,
                                 svo_render_options *out)
{
    SVO_I_TRY(svo_i_struct_read(&device->message, function, "options", options, out,
                                SVO_I_STRUCT_SIZES(svo_render_options, camera)));
    SVO_I_TRY(svo_i_camera_check(device, function, &out->camera, out->width, out->height));
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

static svo_status fill_params(const svo_i_picture_source *source, const svo_render_options *options,
                              svo_cast_params *params)
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
    }
    params->footprint = (float)hole.pixel;
    params->width = options->width;
    params->height = options->height;
    params->depth = source->grid.depth;
    params->occlusion_range = (float)(voxels / 14 + 2);
    return SVO_OK;
}

/* Buffers and kernel of one picture. */
typedef struct picture {
    svo_i_tiles tiles;
    cl_mem params;
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
                                        SVO_I_ARGUMENT(eye), SVO_I_ARGUMENT(shown),
                                        SVO_I_ARGUMENT(drawn->tiles.pixels)};
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
                                        SVO_I_ARGUMENT(drawn->params), SVO_I_ARGUMENT(drawn->tiles.pixels)};
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

static svo_status prepare(const svo_i_picture_source *source, const svo_render_options *options, picture *out)
{
    const size_t pixel_bytes = (size_t)options->width * options->height * 4;
    out->tiles.width = options->width;
    out->tiles.height = options->height;
    SVO_I_TRY(svo_i_device_buffer(source->device, source->function, "camera", CL_MEM_READ_ONLY, sizeof(svo_cast_params),
                                  &out->params));
    SVO_I_TRY(svo_i_device_buffer(source->device, source->function, "picture", CL_MEM_WRITE_ONLY, pixel_bytes,
                                  &out->tiles.pixels));
    return options->view == SVO_VIEW_SHADED ? prepare_shaded(source, out) : prepare_view(source, options, out);
}

/* ---- tiles ---- */

/* Launches one band; *last becomes its event. Each command waits for the previous one, since the queue may be
   out-of-order. */
static svo_status draw_band(svo_device *device, const char *function, cl_command_queue queue, const svo_i_tiles *tiles,
                            cl_uint first, size_t count, cl_event *last)
{
    const size_t global = count * tiles->items;
    cl_event done = NULL;
    SVO_I_TRY(svo_i_kernel_set_from(device, function, tiles->kernel, tiles->first_tile, &SVO_I_ARGUMENT(first), 1));
    const cl_int error = clEnqueueNDRangeKernel(queue, tiles->kernel, 1, NULL, &global, &tiles->items,
                                                *last != NULL ? 1 : 0, *last != NULL ? last : NULL, &done);
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(device, function, "clEnqueueNDRangeKernel", error);
    }
    if (*last != NULL) {
        clReleaseEvent(*last);
    }
    *last = done;
    return SVO_OK;
}

svo_status svo_i_picture_draw_tiles(svo_device *device, const char *function, cl_command_queue queue,
                                    const svo_i_tiles *tiles, uint8_t *rgba)
{
    const cl_uint count = ((tiles->width + TILE_EDGE - 1) / TILE_EDGE) * ((tiles->height + TILE_EDGE - 1) / TILE_EDGE);
    const size_t pixel_bytes = (size_t)tiles->width * tiles->height * 4;
    cl_event last = NULL;
    svo_status status = SVO_OK;
    for (cl_uint first = 0; first < count; first += device->band_tiles) {
        const cl_uint rest = count - first;
        SVO_I_TRY_CLEANUP(draw_band(device, function, queue, tiles, first,
                                    rest < device->band_tiles ? rest : device->band_tiles, &last));
    }
    const cl_int error = clEnqueueReadBuffer(queue, tiles->pixels, CL_TRUE, 0, pixel_bytes, rgba, 1, &last, NULL);
    if (error != CL_SUCCESS) {
        status = svo_i_device_fail_cl(device, function, "clEnqueueReadBuffer", error);
    }

cleanup:
    if (last != NULL) {
        clReleaseEvent(last);
    }
    return status;
}

/* ---- pictures ---- */

static svo_status draw(const svo_i_picture_source *source, cl_command_queue queue, const picture *drawn,
                       const svo_cast_params *params, uint8_t *rgba)
{
    const cl_int error = clEnqueueWriteBuffer(queue, drawn->params, CL_TRUE, 0, sizeof *params, params, 0, NULL, NULL);
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(source->device, source->function, "clEnqueueWriteBuffer", error);
    }
    return svo_i_picture_draw_tiles(source->device, source->function, queue, &drawn->tiles, rgba);
}

svo_status svo_i_picture_draw(const svo_i_picture_source *source, const svo_render_options *options,
                              cl_command_queue queue, uint8_t *rgba)
{
    svo_cast_params params = {.depth = 0};
    picture drawn = {.params = NULL};
    svo_status status = SVO_OK;
    SVO_I_TRY(check_payload(source));
    SVO_I_TRY(fill_params(source, options, &params));
    SVO_I_TRY(svo_i_device_queue(source->device, source->function, queue, &queue));
    SVO_I_TRY_CLEANUP(prepare(source, options, &drawn));
    SVO_I_TRY_CLEANUP(draw(source, queue, &drawn, &params, rgba));

cleanup:
    if (drawn.tiles.pixels != NULL) {
        clReleaseMemObject(drawn.tiles.pixels);
    }
    if (drawn.params != NULL) {
        clReleaseMemObject(drawn.params);
    }
    if (drawn.tiles.kernel != NULL) {
        clReleaseKernel(drawn.tiles.kernel);
    }
    return status;
}
