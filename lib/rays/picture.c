/* SPDX-License-Identifier: MIT */
/*
 * Pictures of voxels, whatever holds them, and what all pictures share: the host side of kernels/rays/render.cl and
 * view.cl.
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

static svo_status check_output(svo_device *device, const char *function, const svo_picture_output *asked)
{
    if ((unsigned)asked->format > SVO_PIXELS_LINEAR || (unsigned)asked->background > SVO_BACKGROUND_TRANSPARENT) {
        const bool format = (unsigned)asked->format > SVO_PIXELS_LINEAR;
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.output.%s %d is not in 0 .. %d", function,
                                 format ? "format" : "background", format ? (int)asked->format : (int)asked->background,
                                 format ? (int)SVO_PIXELS_LINEAR : (int)SVO_BACKGROUND_TRANSPARENT);
    }
    for (int channel = 0; channel < 3; ++channel) {
        if (!(asked->background_color[channel] >= 0.0F && asked->background_color[channel] <= 1.0F)) {
            return svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                     "%s: options.output.background_color[%d] %g is not in 0 .. 1", function, channel,
                                     (double)asked->background_color[channel]);
        }
    }
    return asked->samples <= SVO_PICTURE_SAMPLES_MAX
               ? SVO_OK
               : svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.output.samples %u is above %u", function,
                                   asked->samples, SVO_PICTURE_SAMPLES_MAX);
}

svo_status svo_i_pixel_output_of(svo_device *device, const char *function, const svo_picture_output *asked,
                                 uint32_t samples, svo_i_curve curve, svo_i_pixel_output *out)
{
    SVO_I_TRY(check_output(device, function, asked));
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

svo_status svo_i_tiles_draw(const svo_i_tiles *tiles, const svo_i_call *call)
{
    const size_t across = (tiles->width + TILE_EDGE - 1) / TILE_EDGE;
    const size_t down = (tiles->height + TILE_EDGE - 1) / TILE_EDGE;
    return svo_i_call_launch(call, &(svo_i_launch){.kernel = tiles->kernel,
                                                   .groups = across * down,
                                                   .group_items = tiles->items,
                                                   .band_groups = call->device->band_tiles});
}

/* ---- pictures ---- */

_Static_assert((uint32_t)SVO_VIEW_NORMAL == SVO_VIEW_KIND_NORMAL && (uint32_t)SVO_VIEW_DEPTH == SVO_VIEW_KIND_DEPTH &&
                   (uint32_t)SVO_VIEW_STEPS == SVO_VIEW_KIND_STEPS && (uint32_t)SVO_VIEW_LEVEL == SVO_VIEW_KIND_LEVEL &&
                   (uint32_t)SVO_VIEW_TRIANGLES == SVO_VIEW_KIND_TRIANGLES,
               "svo_render_view and kernels/rays/view.cl number the views alike");

/* The first field that is set and that the kind does not have; NULL: none. */
static const char *foreign_field(const svo_i_picture_kind *kind, const svo_render_options *options)
{
    const struct {
        const char *name;
        bool is_set, is_known;
    } fields[] = {{"light_count", options->light_count != 0, kind->lights},
                  {"lights", options->lights != NULL, kind->lights},
                  {"occlusion_range", options->occlusion_range != 0.0F, kind->lights},
                  {"gather", options->gather != NULL, kind->gathers},
                  {"exposure", options->exposure != 0.0F, kind->gathers},
                  {"first_row", options->first_row != 0, kind->gathers},
                  {"row_count", options->row_count != 0, kind->gathers}};
    for (size_t i = 0; i < sizeof fields / sizeof fields[0]; ++i) {
        if (fields[i].is_set && !fields[i].is_known) {
            return fields[i].name;
        }
    }
    return NULL;
}

svo_status svo_i_picture_options(svo_device *device, const char *function, const svo_i_picture_kind *kind,
                                 const svo_render_options *options, svo_render_options *out)
{
    if (options == NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options is NULL", function);
    }
    SVO_I_TRY(svo_i_struct_read(&device->message, function, "options", options, out,
                                SVO_I_STRUCT_SIZES(svo_render_options, camera)));
    SVO_I_TRY(svo_i_camera_check(device, function, &out->camera, out->width, out->height));
    SVO_I_TRY(svo_i_clip_check(device, function, out->clip));
    if ((unsigned)out->view > SVO_VIEW_SPECULAR || (kind->views >> out->view & 1u) == 0) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.view %d is none of a %s, which has %s",
                                 function, (int)out->view, kind->name, kind->view_names);
    }
    const char *foreign = foreign_field(kind, out);
    return foreign == NULL
               ? SVO_OK
               : svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.%s is not 0, and a %s has none", function,
                                   foreign, kind->name);
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
    return svo_i_pixel_output_of(source->device, source->function, &options->output, shaded ? SVO_CAST_SAMPLES : 1u,
                                 shaded ? SVO_I_CURVE_ROOT : SVO_I_CURVE_NONE, out);
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
    return source->normals == NULL  ? ""
           : source->one_normal     ? " -DSVO_NORMAL -DSVO_ONE_NORMAL"
           : source->packed_normals ? " -DSVO_NORMAL -DSVO_PACKED_NORMAL"
                                    : " -DSVO_NORMAL";
}

static const char *color_defines(const svo_i_picture_source *source)
{
    return source->colors == NULL  ? ""
           : source->one_color     ? " -DSVO_COLOR -DSVO_ONE_COLOR"
           : source->packed_colors ? " -DSVO_COLOR -DSVO_PACKED_COLOR"
                                   : " -DSVO_COLOR";
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
    char defines[96];
    (void)snprintf(defines, sizeof defines, "%s%s", tiles ? " -DSVO_CAST_TILES" : "", color_defines(source));
    SVO_I_TRY(make_kernel(source, &svo_i_program_cast, defines, "svo_k_cast", &drawn->tiles.kernel));
    drawn->tiles.items = tiles ? 1 : SVO_GROUP_ITEMS;
    for (cl_uint i = 0; i < source->node_arguments; ++i) {
        SVO_I_TRY(svo_i_kernel_set_from(source->device, source->function, drawn->tiles.kernel, i,
                                        &(svo_i_argument){sizeof(cl_mem), &source->nodes[i], true}, 1));
    }
    return svo_i_kernel_set_from(source->device, source->function, drawn->tiles.kernel, source->node_arguments,
                                 arguments, 4);
}

static svo_status enqueue(const svo_i_picture_source *source, const svo_render_options *options,
                          const svo_i_pixel_output *output, const svo_array *pixels, svo_i_call *call)
{
    svo_cast_params params = {.depth = 0};
    picture drawn = {.tiles = {.width = options->width, .height = options->height}};
    const size_t bytes = (size_t)options->width * options->height * output->pixel_bytes;
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_i_call_output(call, "pixels", pixels, bytes, 0, bytes, &drawn.pixels));
    SVO_I_TRY(fill_params(source, options, output, &params));
    SVO_I_TRY_CLEANUP(
        svo_i_device_constants(source->device, source->function, "camera", &params, sizeof params, &drawn.params));
    SVO_I_TRY_CLEANUP(options->view == SVO_VIEW_SHADED ? prepare_shaded(source, &drawn)
                                                       : prepare_view(source, options, &drawn));
    SVO_I_TRY_CLEANUP(svo_i_tiles_draw(&drawn.tiles, call));

cleanup:
    if (drawn.params != NULL) {
        clReleaseMemObject(drawn.params);
    }
    if (drawn.tiles.kernel != NULL) {
        clReleaseKernel(drawn.tiles.kernel);
    }
    return status;
}

svo_status svo_i_picture_draw(const svo_i_picture_source *source, const svo_render_options *options,
                              const svo_array *pixels, const svo_submit *submit)
{
    svo_i_pixel_output output;
    svo_i_call call;
    SVO_I_TRY(check_payload(source));
    SVO_I_TRY(describe_output(source, options, &output));
    SVO_I_TRY(svo_i_call_begin(source->device, source->function, submit, &call));
    return svo_i_call_end(&call, enqueue(source, options, &output, pixels, &call));
}

/* ---- of trees ---- */

static svo_status describe(svo_tree *tree, const char *function, svo_i_picture_source *out)
{
    *out = (svo_i_picture_source){.device = tree->device,
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

svo_status svo_i_tree_render(void *of, const svo_render_options *options, const svo_array *pixels,
                             const svo_submit *submit)
{
    static const char function[] = "svo_render";
    static const svo_i_picture_kind kind = {.name = "tree",
                                            .views = SVO_I_VOXEL_VIEWS | 1u << SVO_VIEW_TRIANGLES,
                                            .view_names = "SVO_VIEW_SHADED, NORMAL, DEPTH, STEPS, LEVEL and TRIANGLES"};
    svo_tree *tree = of;
    svo_render_options asked;
    svo_i_picture_source source;
    if (tree->device == NULL) {
        return SVO_NOT_ON_DEVICE;
    }
    SVO_I_TRY(svo_i_picture_options(tree->device, function, &kind, options, &asked));
    SVO_I_TRY(svo_i_tree_check(tree, function));
    if (asked.view == SVO_VIEW_TRIANGLES) {
        SVO_I_TRY(svo_i_rays_check(tree, function));
    }
    SVO_I_TRY(describe(tree, function, &source));
    return svo_i_picture_draw(&source, &asked, pixels, submit);
}
