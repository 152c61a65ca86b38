/* SPDX-License-Identifier: MIT */
/* Pictures of lit trees: the host side of kernels/light/picture.cl. */
#include <math.h>
#include <string.h>

#include "core/struct_size.h"
#include "light/gather.h"
#include "light/shader.h"
#include "rays/camera.h"
#include "rays/picture.h"

_Static_assert((uint32_t)SVO_LIGHT_VIEW_FULL == SVO_LIT_VIEW_FULL && (uint32_t)SVO_LIGHT_VIEW_AO == SVO_LIT_VIEW_AO &&
                   (uint32_t)SVO_LIGHT_VIEW_DIRECT == SVO_LIT_VIEW_DIRECT &&
                   (uint32_t)SVO_LIGHT_VIEW_INDIRECT == SVO_LIT_VIEW_INDIRECT &&
                   (uint32_t)SVO_LIGHT_VIEW_SPECULAR == SVO_LIT_VIEW_SPECULAR,
               "svo_light_view and kernels/light/picture.cl number the views alike");

#define TILE_EDGE SVO_LIGHT_BAND_ROWS
/* Camera rays of a pixel. */
#define SAMPLES 4u
/* Tiles of a launch, so that none takes long enough for a driver to end it. */
#define BAND_TILES 256u

/* ---- parameters ---- */

static svo_status check_band(const svo_light *light, const char *function, const svo_light_picture *picture)
{
    if (picture->first_row >= picture->height || picture->first_row % TILE_EDGE != 0) {
        return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT,
                                 "%s: picture.first_row %u is not a multiple of %u below height %u", function,
                                 picture->first_row, TILE_EDGE, picture->height);
    }
    return picture->row_count % TILE_EDGE == 0 ? SVO_OK
                                               : svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT,
                                                                   "%s: picture.row_count %u is not a multiple of %u",
                                                                   function, picture->row_count, TILE_EDGE);
}

static svo_status check_picture(const svo_light *light, const char *function, const svo_light_picture *picture)
{
    SVO_I_TRY(svo_i_camera_check(light->device, function, &picture->camera, picture->width, picture->height));
    SVO_I_TRY(svo_i_clip_check(light->device, function, picture->clip));
    if ((unsigned)picture->view > SVO_LIGHT_VIEW_SPECULAR) {
        return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT, "%s: picture.view %d is not in 0 .. %d", function,
                                 (int)picture->view, (int)SVO_LIGHT_VIEW_SPECULAR);
    }
    return picture->exposure >= 0.0F && isfinite(picture->exposure)
               ? check_band(light, function, picture)
               : svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT,
                                   "%s: picture.exposure %g is negative or not finite", function,
                                   (double)picture->exposure);
}

static svo_status fill_params(const svo_light *light, const char *function, const svo_light_picture *picture,
                              svo_lit_picture_params *params, svo_i_pixel_output *output)
{
    svo_i_pinhole hole;
    SVO_I_TRY(
        svo_i_pixel_output_of(light->device, function, "picture", &picture->output, SAMPLES, SVO_I_CURVE_SRGB, output));
    SVO_I_TRY(
        svo_i_pinhole_from_camera(light->device, function, &picture->camera, picture->width, picture->height, &hole));
    *params = svo_i_light_shader_params(light, picture->view);
    memcpy(params->clip, picture->clip, sizeof params->clip);
    params->width = picture->width;
    params->height = picture->height;
    params->exposure = picture->exposure > 0.0F ? picture->exposure : 1.0F;
    params->samples = output->samples;
    params->pixel_flags = output->flags;
    for (int axis = 0; axis < 3; ++axis) {
        params->eye[axis] = picture->camera.eye[axis];
        params->corner[axis] = hole.corner[axis];
        params->across[axis] = hole.across[axis];
        params->down[axis] = hole.down[axis];
        params->background[axis] = output->background[axis];
    }
    return SVO_OK;
}

/* The caller's options for what the view shows of them. */
static svo_status fill_gather(const svo_light *light, const char *function, const svo_light_picture *picture,
                              svo_gather_params *gather)
{
    SVO_I_TRY(svo_i_gather_params(light, function, &picture->gather, gather));
    if (picture->view == SVO_LIGHT_VIEW_AO) {
        gather->with_light = 0;
    }
    return SVO_OK;
}

/* ---- drawing ---- */

/* Rows of the picture's band. */
static uint32_t rows_of_band(const svo_light_picture *picture)
{
    const uint32_t below = picture->height - picture->first_row;
    return picture->row_count == 0 || picture->row_count > below ? below : picture->row_count;
}

/* A picture that is about to be drawn. */
typedef struct drawing {
    const svo_light *light;
    const char *function; /* for messages */
    svo_light_picture asked;
    svo_lit_picture_params params;
    svo_gather_params gather;
    svo_i_pixel_output output;
} drawing;

static svo_status launch(const drawing *drawn, const svo_i_light_shader *shader, cl_mem pixels)
{
    const svo_light_picture *picture = &drawn->asked;
    const svo_i_argument own[] = {SVO_I_ARGUMENT(pixels)};
    const uint64_t across = (picture->width + TILE_EDGE - 1) / TILE_EDGE;
    const uint64_t begin = across * (picture->first_row / TILE_EDGE);
    const uint64_t end = begin + across * ((rows_of_band(picture) + TILE_EDGE - 1) / TILE_EDGE);
    svo_lit_picture_params params = drawn->params;
    for (uint64_t first = begin; first < end; first += BAND_TILES) {
        params.first_tile = (uint32_t)first;
        SVO_I_TRY(svo_i_light_shader_launch(shader, &drawn->gather, &params, SVO_I_ARGUMENTS(own),
                                            end - first < BAND_TILES ? end - first : BAND_TILES));
    }
    return SVO_OK;
}

static svo_status enqueue(const drawing *drawn, const svo_i_pixels *to)
{
    svo_i_device_work work;
    svo_i_light_shader shader = {.kernel = NULL};
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_i_work_begin_after(drawn->light->device, drawn->function, to->queue, to->num_wait, to->wait, &work));
    SVO_I_TRY_CLEANUP(
        svo_i_light_shader_begin(&work, drawn->light, SVO_I_PROGRAM_LIGHT_PICTURE, "svo_k_light_picture", &shader));
    SVO_I_TRY_CLEANUP(launch(drawn, &shader, to->buffer));

cleanup:
    svo_i_light_shader_end(&shader);
    svo_i_work_leave(&work, status == SVO_OK ? to->event : NULL);
    return status;
}

/* Checks what is asked for. */
static svo_status begin(const svo_light *light, const char *function, const svo_light_picture *picture, drawing *out)
{
    *out = (drawing){.light = light, .function = function};
    if (picture == NULL) {
        return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT, "%s: picture is NULL", function);
    }
    SVO_I_TRY(svo_i_struct_read(svo_i_device_message(light->device), function, "picture", picture, &out->asked,
                                SVO_I_STRUCT_SIZES(svo_light_picture, exposure)));
    SVO_I_TRY(svo_i_tree_check(light->tree, function));
    SVO_I_TRY(check_picture(light, function, &out->asked));
    SVO_I_TRY(fill_params(light, function, &out->asked, &out->params, &out->output));
    return fill_gather(light, function, &out->asked, &out->gather);
}

svo_status svo_light_render_enqueue(svo_light *light, const svo_light_picture *picture, cl_mem pixels,
                                    cl_command_queue queue, cl_uint num_wait, const cl_event *wait, cl_event *event)
{
    svo_i_pixels to = {pixels, queue, num_wait, wait, event};
    drawing drawn;
    if (light == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    SVO_I_TRY(begin(light, "svo_light_render_enqueue", picture, &drawn));
    SVO_I_TRY(svo_i_pixels_check(light->device, drawn.function, drawn.asked.width, drawn.asked.height,
                                 drawn.output.pixel_bytes, &to));
    return enqueue(&drawn, &to);
}

svo_status svo_light_render(svo_light *light, const svo_light_picture *picture, cl_command_queue queue, uint8_t *rgba)
{
    static const char function[] = "svo_light_render";
    svo_i_own_pixels own;
    drawing drawn;
    svo_status status = SVO_OK;
    if (light == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    if (rgba == NULL) {
        return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT, "%s: rgba is NULL", function);
    }
    SVO_I_TRY(begin(light, function, picture, &drawn));
    SVO_I_TRY(svo_i_own_pixels_begin(light->device, function, drawn.asked.width, drawn.asked.height,
                                     drawn.output.pixel_bytes, queue, &own));
    SVO_I_TRY_CLEANUP(enqueue(&drawn, &own.to));
    SVO_I_TRY_CLEANUP(svo_i_own_pixels_read(&own, drawn.asked.first_row, rows_of_band(&drawn.asked), rgba));

cleanup:
    svo_i_own_pixels_end(&own);
    return status;
}
