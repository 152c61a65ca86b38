/* SPDX-License-Identifier: MIT */
/*
 * Pictures of voxels, whatever holds them, and buffers that pictures are drawn to: the host side of
 * kernels/rays/render.cl and view.cl.
 */
#include "rays/picture.h"

#include <math.h>
#include <stdio.h>

#include "core/device.h"
#include "core/struct_size.h"
#include "core/tree.h"
#include "rays/camera.h"
#include "rays/programs.h"
#include "rays/rays.h"
#include "shared/layout.h"

/* ---- pixels ---- */

#define TILE_EDGE 8u

_Static_assert(SVO_PICTURE_SAMPLES_MAX == SVO_PIXEL_SAMPLES_MAX, "kernels sample as often as trace.h says");

/* The linear light of a coded color. */
static float decode(svo_i_curve curve, float coded)
{
    switch (curve) {
    case SVO_I_CURVE_ROOT:
        return coded * coded;
    case SVO_I_CURVE_SRGB: /* IEC 61966-2-1 */
        return coded <= 0.04045F ? coded / 12.92F : (float)pow(((double)coded + 0.055) / 1.055, 2.4);
    default:
        return coded;
    }
}

static svo_status check_output(svo_device *device, const char *function, const char *argument,
                               const svo_picture_output *asked)
{
    if ((unsigned)asked->format > SVO_PIXELS_LINEAR || (unsigned)asked->background > SVO_BACKGROUND_TRANSPARENT) {
        const bool format = (unsigned)asked->format > SVO_PIXELS_LINEAR;
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: %s.output.%s %d is not in 0 .. %d", function,
                                 argument, format ? "format" : "background",
                                 format ? (int)asked->format : (int)asked->background,
                                 format ? (int)SVO_PIXELS_LINEAR : (int)SVO_BACKGROUND_TRANSPARENT);
    }
    for (int channel = 0; channel < 3; ++channel) {
        if (!(asked->background_color[channel] >= 0.0F && asked->background_color[channel] <= 1.0F)) {
            return svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                     "%s: %s.output.background_color[%d] %g is not in 0 .. 1", function, argument,
                                     channel, (double)asked->background_color[channel]);
        }
    }
    return asked->samples <= SVO_PICTURE_SAMPLES_MAX
               ? SVO_OK
               : svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: %s.output.samples %u is above %u", function,
                                   argument, asked->samples, SVO_PICTURE_SAMPLES_MAX);
}

svo_status svo_i_pixel_output_of(svo_device *device, const char *function, const char *argument,
                                 const svo_picture_output *asked, uint32_t samples, svo_i_curve curve,
                                 svo_i_pixel_output *out)
{
    SVO_I_TRY(check_output(device, function, argument, asked));
    const bool linear = asked->format == SVO_PIXELS_LINEAR;
    *out = (svo_i_pixel_output){.samples = asked->samples > 0 ? asked->samples : samples,
                                .flags = (linear ? SVO_PIXEL_LINEAR : 0u) |
                                         (asked->background == SVO_BACKGROUND_COLOR         ? SVO_PIXEL_COLOR
                                          : asked->background == SVO_BACKGROUND_TRANSPARENT ? SVO_PIXEL_TRANSPARENT
                                                                                            : 0u),
                                .pixel_bytes = linear ? 16u : 4u};
    for (int channel = 0; channel < 3; ++channel) {
        out->background[channel] = decode(curve, asked->background_color[channel]);
    }
    return SVO_OK;
}

svo_status svo_i_pixels_check(svo_device *device, const char *function, uint32_t width, uint32_t height,
                              uint32_t pixel_bytes, svo_i_pixels *given)
{
    if (given->buffer == NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: pixels is NULL", function);
    }
    SVO_I_TRY(svo_i_device_queue(device, function, given->queue, &given->queue));
    SVO_I_TRY(svo_i_device_check_wait(device, function, given->num_wait, given->wait));
    return svo_i_device_check_output(device, function, "pixels", given->buffer, (size_t)width * height * pixel_bytes);
}

static cl_uint count_tiles(const svo_i_tiles *tiles)
{
    return ((tiles->width + TILE_EDGE - 1) / TILE_EDGE) * ((tiles->height + TILE_EDGE - 1) / TILE_EDGE);
}

/* Launches the band that begins with a tile. */
static svo_status draw_band(svo_device *device, const char *function, const svo_i_tiles *tiles, cl_uint first,
                            const svo_i_pixels *to)
{
    const cl_uint count = count_tiles(tiles);
    const cl_uint band = count - first < device->band_tiles ? count - first : device->band_tiles;
    const size_t global = band * tiles->items;
    SVO_I_TRY(svo_i_kernel_set_from(device, function, tiles->kernel, tiles->first_tile, &SVO_I_ARGUMENT(first), 1));
    const cl_int error = clEnqueueNDRangeKernel(to->queue, tiles->kernel, 1, NULL, &global, &tiles->items, to->num_wait,
                                                to->wait, to->event);
    return error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(device, function, "clEnqueueNDRangeKernel", error);
}

svo_status svo_i_pixels_draw(svo_device *device, const char *function, const svo_i_tiles *tiles, const svo_i_pixels *to)
{
    const cl_uint count = count_tiles(tiles);
    cl_event previous = NULL;
    svo_status status = SVO_OK;
    for (cl_uint first = 0; first < count; first += device->band_tiles) {
        const bool is_last = count - first <= device->band_tiles;
        cl_event drawn = NULL;
        svo_i_pixels band = *to;
        band.event = is_last ? to->event : &drawn;
        /* Each band waits for the previous one, since the queue may be out-of-order. */
        if (previous != NULL) {
            band.num_wait = 1;
            band.wait = &previous;
        }
        SVO_I_TRY_CLEANUP(draw_band(device, function, tiles, first, &band));
        if (previous != NULL) {
            clReleaseEvent(previous);
        }
        previous = drawn;
    }

cleanup:
    if (previous != NULL) {
        (void)svo_i_event_settle(previous); /* nothing is in progress after a failure */
        clReleaseEvent(previous);
    }
    return status;
}

svo_status svo_i_own_pixels_begin(svo_device *device, const char *function, uint32_t width, uint32_t height,
                                  uint32_t pixel_bytes, cl_command_queue queue, svo_i_own_pixels *out)
{
    *out = (svo_i_own_pixels){.device = device, .function = function, .row_bytes = width * pixel_bytes};
    out->to.event = &out->drawn;
    SVO_I_TRY(svo_i_device_queue(device, function, queue, &out->to.queue));
    return svo_i_device_buffer(device, function, "picture", CL_MEM_WRITE_ONLY, (size_t)width * height * pixel_bytes,
                               &out->to.buffer);
}

svo_status svo_i_own_pixels_read(const svo_i_own_pixels *own, uint32_t first_row, uint32_t row_count, uint8_t *rgba)
{
    const size_t row_bytes = own->row_bytes;
    const cl_int error = clEnqueueReadBuffer(own->to.queue, own->to.buffer, CL_TRUE, row_bytes * first_row,
                                             row_bytes * row_count, rgba, 1, &own->drawn, NULL);
    return error == CL_SUCCESS ? SVO_OK
                               : svo_i_device_fail_cl(own->device, own->function, "clEnqueueReadBuffer", error);
}

void svo_i_own_pixels_end(svo_i_own_pixels *own)
{
    if (own->drawn != NULL) {
        (void)svo_i_event_settle(own->drawn);
        clReleaseEvent(own->drawn);
    }
    if (own->to.buffer != NULL) {
        clReleaseMemObject(own->to.buffer);
    }
    *own = (svo_i_own_pixels){.device = NULL};
}

/* ---- pictures ---- */

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
static svo_status make_kernel(const svo_i_picture_source *source, const svo_i_program *which, const char *first,
                              const char *name, cl_kernel *out)
{
    char defines[SVO_I_PROGRAM_DEFINES_BYTES];
    cl_program program = NULL;
    (void)snprintf(defines, sizeof defines, "%s%s%s", first, normal_defines(source), source->form_defines);
    SVO_I_TRY(svo_i_program_get(source->device, source->function, which, defines, &program, NULL));
    return svo_i_kernel_create(source->device, source->function, program, name, out);
}

/* The kernel of an unlit view, with all arguments set but the first tile. */
static svo_status prepare_view(const svo_i_picture_source *source, const svo_render_options *options, picture *drawn)
{
    const cl_float4 eye = {{options->camera.eye[0], options->camera.eye[1], options->camera.eye[2], 0}};
    const cl_uint shown = options->view;
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(source->normals), SVO_I_ARGUMENT(drawn->params),
                                        SVO_I_ARGUMENT(eye), SVO_I_ARGUMENT(shown), SVO_I_ARGUMENT(drawn->pixels)};
    SVO_I_TRY(make_kernel(source, &svo_i_program_view, "", "svo_k_view", &drawn->tiles.kernel));
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
    SVO_I_TRY(make_kernel(source, &svo_i_program_cast, defines, "svo_k_cast", &drawn->tiles.kernel));
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

/* ---- of trees ---- */

static svo_status check_tree(svo_device *device, const svo_tree *tree, const char *function)
{
    if (tree->device != NULL && tree->device != device) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: the tree is on another device", function);
    }
    if (tree->buffers[SVO_TREE_CHILD_MASK] == NULL || tree->buffers[SVO_TREE_FIRST_CHILD] == NULL) {
        return svo_i_device_fail(device, SVO_NOT_ON_DEVICE,
                                 "%s: the tree is not on a device; call svo_tree_upload first", function);
    }
    return SVO_OK;
}

static svo_status describe(svo_device *device, svo_tree *tree, const char *function, svo_i_picture_source *out)
{
    *out = (svo_i_picture_source){.device = device,
                                  .function = function,
                                  .form_defines = "",
                                  .nodes = {tree->buffers[SVO_TREE_CHILD_MASK], tree->buffers[SVO_TREE_FIRST_CHILD]},
                                  .node_arguments = 2,
                                  .tree = svo_i_rays_target(tree),
                                  .colors = tree->buffers[SVO_TREE_COLORS],
                                  .normals = tree->buffers[SVO_TREE_NORMALS],
                                  .one_color = svo_i_tree_is_constant(&tree->info, SVO_TREE_COLORS),
                                  .one_normal = svo_i_tree_is_constant(&tree->info, SVO_TREE_NORMALS),
                                  .payload_level = tree->info.payload_level};
    return svo_tree_get_grid(tree, &out->grid);
}

/* Checks what is asked for and describes what is drawn. */
static svo_status begin(svo_device *device, svo_tree *tree, const char *function, const svo_render_options *options,
                        svo_render_options *asked, svo_i_picture_source *source)
{
    if (tree == NULL || options == NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: %s is NULL", function,
                                 tree == NULL ? "tree" : "options");
    }
    SVO_I_TRY(svo_i_picture_options(device, function, options, asked));
    SVO_I_TRY(svo_i_tree_check(tree, function));
    SVO_I_TRY(check_tree(device, tree, function));
    if (asked->view == SVO_VIEW_TRIANGLES) {
        SVO_I_TRY(svo_i_rays_check(tree, function));
    }
    return describe(device, tree, function, source);
}

svo_status svo_tree_render_enqueue(svo_device *device, svo_tree *tree, const svo_render_options *options, cl_mem pixels,
                                   cl_command_queue queue, cl_uint num_wait, const cl_event *wait, cl_event *event)
{
    svo_i_pixels to = {pixels, queue, num_wait, wait, event};
    svo_render_options asked;
    svo_i_picture_source source;
    if (device == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    SVO_I_TRY(begin(device, tree, "svo_tree_render_enqueue", options, &asked, &source));
    return svo_i_picture_enqueue(&source, &asked, &to);
}

svo_status svo_tree_render(svo_device *device, svo_tree *tree, const svo_render_options *options,
                           cl_command_queue queue, uint8_t *rgba)
{
    static const char function[] = "svo_tree_render";
    svo_render_options asked;
    svo_i_picture_source source;
    if (device == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    if (rgba == NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: rgba is NULL", function);
    }
    SVO_I_TRY(begin(device, tree, function, options, &asked, &source));
    return svo_i_picture_draw(&source, &asked, queue, rgba);
}
