/* SPDX-License-Identifier: MIT */
/* Pictures of a lit tree, and its class of targets. */
#include <math.h>
#include <string.h>

#include "core/struct_size.h"
#include "core/submit.h"
#include "light/emitters.h"
#include "light/gather.h"
#include "light/programs.h"
#include "light/screen.h"
#include "rays/camera.h"
#include "rays/picture.h"
#include "rays/rays.h"
#include "rays/target.h"
#include "svocl/plan.h"

/* Made by cmake/embed.cmake. */
extern const char svo_i_source_cones[];

/* svo_render_view and kernels/light/picture.cl number the views of light in the same order. */
#define AHEAD ((uint32_t)SVO_VIEW_AO - SVO_LIT_VIEW_AO)
_Static_assert((uint32_t)SVO_VIEW_DIRECT == AHEAD + SVO_LIT_VIEW_DIRECT &&
                   (uint32_t)SVO_VIEW_INDIRECT == AHEAD + SVO_LIT_VIEW_INDIRECT &&
                   (uint32_t)SVO_VIEW_SPECULAR == AHEAD + SVO_LIT_VIEW_SPECULAR,
               "views of light follow each other");

#define TILE_EDGE SVO_LIGHT_BAND_ROWS
/* Camera rays of a pixel. */
#define SAMPLES 4u
/* Rays of a pixel to a source that has a size, at least. */
#define SOURCE_RAYS 16u
/* A tile takes as long as so many of other pictures. */
#define TILE_COST 16u

/* ---- pictures: kernels/light/picture.cl ---- */

static svo_status check_band(const svo_light *light, const char *function, const svo_render_options *options)
{
    if (options->first_row >= options->height || options->first_row % TILE_EDGE != 0) {
        return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT,
                                 "%s: options.first_row %u is not a multiple of %u below height %u", function,
                                 options->first_row, TILE_EDGE, options->height);
    }
    return options->row_count % TILE_EDGE == 0 ? SVO_OK
                                               : svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT,
                                                                   "%s: options.row_count %u is not a multiple of %u",
                                                                   function, options->row_count, TILE_EDGE);
}

static svo_status check_exposure(const svo_light *light, const char *function, const svo_render_options *options)
{
    return options->exposure >= 0.0F && isfinite(options->exposure)
               ? SVO_OK
               : svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT,
                                   "%s: options.exposure %g is negative or not finite", function,
                                   (double)options->exposure);
}

/* How wide the share of a camera ray is at distance 1 from the eye, in the middle of the picture. */
static float sample_width(const svo_i_pinhole *hole, const svo_render_options *options, uint32_t samples)
{
    double across = 0;
    double away = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double middle = (double)hole->corner[axis] + 0.5 * options->width * (double)hole->across[axis] +
                              0.5 * options->height * (double)hole->down[axis];
        across += (double)hole->across[axis] * (double)hole->across[axis];
        away += middle * middle;
    }
    return (float)sqrt(across / away / samples);
}

static svo_status fill_params(const svo_light *light, const char *function, const svo_render_options *options,
                              svo_lit_picture_params *params, svo_i_pixel_output *output)
{
    svo_i_pinhole hole;
    SVO_I_TRY(svo_i_pixel_output_of(light->device, function, &options->output, SAMPLES, SVO_I_CURVE_SRGB, output));
    SVO_I_TRY(
        svo_i_pinhole_from_camera(light->device, function, &options->camera, options->width, options->height, &hole));
    *params =
        svo_i_light_shader_params(light, options->view == SVO_VIEW_SHADED ? SVO_LIT_VIEW_FULL : options->view - AHEAD);
    memcpy(params->clip, options->clip, sizeof params->clip);
    params->width = options->width;
    params->height = options->height;
    params->exposure = options->exposure > 0.0F ? options->exposure : 1.0F;
    params->samples = output->samples;
    for (uint32_t rays = output->samples; rays < SOURCE_RAYS; rays *= 2) {
        params->source_rays_log2 += 1;
    }
    params->pixel_flags = output->flags;
    params->sample_width = sample_width(&hole, options, output->samples);
    for (int axis = 0; axis < 3; ++axis) {
        params->eye[axis] = options->camera.eye[axis];
        params->corner[axis] = hole.corner[axis];
        params->across[axis] = hole.across[axis];
        params->down[axis] = hole.down[axis];
        params->background[axis] = output->background[axis];
    }
    return SVO_OK;
}

/* A picture that is about to be drawn. */
typedef struct drawing {
    const svo_light *light;
    svo_render_options asked;
    svo_lit_picture_params params;
    svo_gather_params gather;
    bool by_screen; /* the light of cells of pixels is gathered first, and smoothed */
    svo_i_pixel_output output;
} drawing;

/* Whether a view shows light that is gathered. */
static bool view_gathers(svo_render_view view)
{
    return view != SVO_VIEW_DIRECT;
}

/* The caller's options for what the view shows of them. */
static svo_status fill_gather(const svo_light *light, const char *function, drawing *drawn)
{
    const svo_render_options *options = &drawn->asked;
    svo_gather_params *gather = &drawn->gather;
    SVO_I_TRY(
        svo_i_light_read_gather(light, function, "options.gather", options->gather, SVO_GATHER_RAYS, true, gather));
    drawn->by_screen = view_gathers(options->view) && (options->view == SVO_VIEW_AO || gather->with_light != 0);
    if (!drawn->by_screen) {
        gather->paths = 0;
    }
    if (options->view == SVO_VIEW_AO) {
        gather->with_light = 0;
    }
    return SVO_OK;
}

/* Rows of the picture's band. */
static uint32_t rows_of_band(const svo_render_options *options)
{
    const uint32_t below = options->height - options->first_row;
    return options->row_count == 0 || options->row_count > below ? below : options->row_count;
}

/* Sets the kernel's arguments. screen: zero without one. */
static svo_status set_kernel(const drawing *drawn, const svo_i_light_shader *shader, const svo_i_light_screen *screen,
                             uint32_t first_tile, cl_mem pixels)
{
    const svo_i_argument own[] = {SVO_I_ARGUMENT(screen->cells), SVO_I_ARGUMENT(screen->light),
                                  SVO_I_ARGUMENT(screen->specular), SVO_I_ARGUMENT(screen->params),
                                  SVO_I_ARGUMENT(pixels)};
    svo_lit_picture_params params = drawn->params;
    params.first_tile = first_tile;
    return svo_i_light_shader_set(shader, &drawn->gather, &params, SVO_I_ARGUMENTS(own));
}

/* Tiles across the picture. */
static size_t tiles_across(const svo_render_options *options)
{
    return ((size_t)options->width + TILE_EDGE - 1) / TILE_EDGE;
}

/* Rows of tiles of the picture's band. */
static uint32_t tile_rows(const svo_render_options *options)
{
    return (rows_of_band(options) + TILE_EDGE - 1) / TILE_EDGE;
}

/* Whether the picture shows specular light. */
static bool mirrors(const drawing *drawn)
{
    const svo_i_light_setup *setup = &drawn->light->setup;
    bool any = false;
    for (size_t i = 0; i < setup->finish_count; ++i) {
        const float *specular = setup->finishes[i].specular;
        any = any || specular[0] > 0.0F || specular[1] > 0.0F || specular[2] > 0.0F;
    }
    return any && (drawn->params.view == SVO_LIT_VIEW_FULL || drawn->params.view == SVO_LIT_VIEW_SPECULAR);
}

/* Draws the band by a screen: as many rows of tiles at once as the cells of the screen hold. */
static svo_status draw_by_screen(const drawing *drawn, const svo_i_light_shader *shader, svo_i_light_screen *screen,
                                 cl_mem pixels)
{
    const size_t across = tiles_across(&drawn->asked);
    const uint32_t cells = TILE_EDGE / SVO_I_SCREEN_CELL; /* of a tile's edge */
    const uint32_t most = screen->band_rows / cells > 0 ? screen->band_rows / cells : 1;
    const uint32_t begin = drawn->asked.first_row / TILE_EDGE;
    const uint32_t end = begin + tile_rows(&drawn->asked);
    const size_t tiles = shader->light->device->band_tiles / TILE_COST;
    const size_t in_launch = tiles > 0 ? tiles : 1;
    for (uint32_t row = begin; row < end; row += most) {
        const uint32_t last = end - row < most ? end : row + most;
        const uint32_t end_cell = last * cells < screen->height ? last * cells : screen->height;
        SVO_I_TRY(svo_i_light_screen_band(screen, &drawn->params, row * cells, end_cell));
        SVO_I_TRY(set_kernel(drawn, shader, screen, 0, pixels));
        for (size_t tile = row * across; tile < last * across; tile += in_launch) {
            const size_t left = last * across - tile;
            SVO_I_TRY(svo_i_light_shader_launch(shader, tile, left < in_launch ? left : in_launch));
        }
    }
    return SVO_OK;
}

static svo_status enqueue_screen(const drawing *drawn, cl_mem pixels, svo_i_call *call)
{
    const svo_render_options *options = &drawn->asked;
    svo_i_device_work work;
    svo_i_light_shader shader = {.kernel = NULL};
    svo_i_light_screen screen = {.cells = NULL};
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_i_work_begin_after(call->device, call->function, call->queue, call->num_wait, call->wait, &work));
    SVO_I_TRY_CLEANUP(svo_i_light_shader_begin(&work, drawn->light, &svo_i_program_light_picture, "svo_k_light_picture",
                                               " -DSVO_PICTURE_SCREEN", &shader));
    SVO_I_TRY_CLEANUP(svo_i_light_screen_begin(&shader, &drawn->gather, options->width, options->height,
                                               rows_of_band(options), mirrors(drawn), &screen));
    SVO_I_TRY_CLEANUP(draw_by_screen(drawn, &shader, &screen, pixels));

cleanup:
    svo_i_light_screen_end(&screen);
    svo_i_light_shader_end(&shader);
    svo_i_work_leave(&work, status == SVO_OK ? call->event : NULL);
    return status;
}

/* Of views without gathered light. */
static svo_status enqueue_alone(const drawing *drawn, cl_mem pixels, const svo_i_call *call)
{
    const svo_render_options *options = &drawn->asked;
    const svo_i_light_screen none = {.cells = NULL};
    const size_t across = tiles_across(options);
    svo_i_device_work work;
    svo_i_light_shader shader = {.kernel = NULL};
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_i_work_begin(call->device, call->function, call->queue, &work));
    SVO_I_TRY_CLEANUP(svo_i_light_shader_begin(&work, drawn->light, &svo_i_program_light_picture, "svo_k_light_picture",
                                               "", &shader));
    SVO_I_TRY_CLEANUP(set_kernel(drawn, &shader, &none, (uint32_t)across * (options->first_row / TILE_EDGE), pixels));
    status = svo_i_call_launch(call, &(svo_i_launch){.kernel = shader.kernel,
                                                     .groups = across * tile_rows(options),
                                                     .group_items = SVO_GROUP_ITEMS,
                                                     .band_groups = call->device->band_tiles / TILE_COST});

cleanup:
    svo_i_light_shader_end(&shader);
    svo_i_work_leave(&work, NULL);
    return status;
}

static svo_status enqueue(const drawing *drawn, const svo_array *to, svo_i_call *call)
{
    const svo_render_options *options = &drawn->asked;
    const size_t row_bytes = (size_t)options->width * drawn->output.pixel_bytes;
    cl_mem pixels = NULL;
    SVO_I_TRY(svo_i_call_output(call, "pixels", to, row_bytes * options->height, row_bytes * options->first_row,
                                row_bytes * rows_of_band(options), &pixels));
    return drawn->by_screen ? enqueue_screen(drawn, pixels, call) : enqueue_alone(drawn, pixels, call);
}

static svo_status render(void *of, const svo_render_options *options, const svo_array *pixels, const svo_submit *submit)
{
    static const char function[] = "svo_render";
    static const svo_i_picture_kind kind = {.name = "light",
                                            .views = 1u << SVO_VIEW_SHADED | 1u << SVO_VIEW_AO | 1u << SVO_VIEW_DIRECT |
                                                     1u << SVO_VIEW_INDIRECT | 1u << SVO_VIEW_SPECULAR,
                                            .view_names = "SVO_VIEW_SHADED, AO, DIRECT, INDIRECT and SPECULAR",
                                            .gathers = true};
    svo_light *light = of;
    drawing drawn = {.light = light};
    svo_i_call call;
    SVO_I_TRY(svo_i_picture_options(light->device, function, &kind, options, &drawn.asked));
    SVO_I_TRY(svo_i_tree_check(light->tree, function));
    SVO_I_TRY(check_exposure(light, function, &drawn.asked));
    SVO_I_TRY(check_band(light, function, &drawn.asked));
    SVO_I_TRY(fill_params(light, function, &drawn.asked, &drawn.params, &drawn.output));
    SVO_I_TRY(fill_gather(light, function, &drawn));
    SVO_I_TRY(svo_i_light_list_emitters(light, function, &drawn.gather, submit));
    SVO_I_TRY(svo_i_call_begin(light->device, function, submit, &call));
    return svo_i_call_end(&call, enqueue(&drawn, pixels, &call));
}

/* ---- the class ---- */

static svo_device *device_of(const void *light)
{
    return ((const svo_light *)light)->device;
}

static svo_status fit_camera(const void *light, float aspect, svo_camera *camera)
{
    return svo_i_tree_fit_camera(((const svo_light *)light)->tree, aspect, camera);
}

static const char *kernel_source(void)
{
    return svo_i_source_cones;
}

static const char *kernel_options(const void *light)
{
    return light != NULL ? svo_i_light_options(light) : NULL;
}

static const struct svo_target_class light_class = {.name = "light",
                                                    .device = device_of,
                                                    .render = render,
                                                    .fit_camera = fit_camera,
                                                    .kernel_source = kernel_source,
                                                    .kernel_options = kernel_options,
                                                    .set_kernel_arguments = svo_i_light_set_target};

svo_target svo_light_target(svo_light *light)
{
    return (svo_target){&light_class, light};
}
