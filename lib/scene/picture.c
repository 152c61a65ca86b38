/* SPDX-License-Identifier: MIT */
/* Pictures of scenes: the host side of kernels/scene/render.cl. */
#include <math.h>
#include <string.h>

#include "core/struct_size.h"
#include "rays/camera.h"
#include "rays/picture.h"
#include "scene/state.h"

/* Rays of a pixel. */
#define SAMPLES 4u
/* The range of the ambient occlusion, of an instance's mean width. */
#define OCCLUSION_SHARE 0.25

/* ---- checks ---- */

static svo_status check_options(const svo_scene *scene, const char *function, const svo_scene_render_options *options)
{
    SVO_I_TRY(svo_i_camera_check(scene->device, function, &options->camera, options->width, options->height));
    SVO_I_TRY(svo_i_clip_check(scene->device, function, options->clip));
    if (options->light_count > SVO_SCENE_LIGHTS_MAX || (options->light_count > 0 && options->lights == NULL)) {
        return svo_i_device_fail(scene->device, SVO_INVALID_ARGUMENT,
                                 "%s: options.light_count %u is above %u, or options.lights is NULL", function,
                                 options->light_count, SVO_SCENE_LIGHTS_MAX);
    }
    if (!(options->occlusion_range >= 0.0F) || !isfinite(options->occlusion_range)) {
        return svo_i_device_fail(scene->device, SVO_INVALID_ARGUMENT,
                                 "%s: options.occlusion_range %g is not finite, or below 0", function,
                                 (double)options->occlusion_range);
    }
    return SVO_OK;
}

/* ---- parameters ---- */

/* The caller's lights with unit directions. */
static svo_status fill_lights(const svo_scene *scene, const char *function, const svo_scene_render_options *options,
                              svo_scene_light lights[SVO_SCENE_LIGHTS_MAX])
{
    for (uint32_t i = 0; i < options->light_count; ++i) {
        lights[i] = options->lights[i];
        bool valid = lights[i].shadows <= 1;
        const double given[3] = {(double)lights[i].direction[0], (double)lights[i].direction[1],
                                 (double)lights[i].direction[2]};
        double direction[3] = {0, 0, 0};
        valid = svo_i_normalize(given, direction) && valid;
        for (int axis = 0; axis < 3; ++axis) {
            lights[i].direction[axis] = (float)direction[axis];
            valid = valid && lights[i].color[axis] >= 0.0F && isfinite(lights[i].color[axis]);
        }
        if (!valid) {
            return svo_i_device_fail(scene->device, SVO_INVALID_ARGUMENT,
                                     "%s: options.lights[%u] has no direction, a color that is not finite or below 0, "
                                     "or shadows above 1",
                                     function, i);
        }
    }
    return SVO_OK;
}

/* The light of svo_tree_render. */
static svo_scene_light default_light(const svo_i_view *looking, const double up[3])
{
    double sun[3];
    svo_i_place_sun(looking, up, sun);
    return (svo_scene_light){
        .direction = {(float)sun[0], (float)sun[1], (float)sun[2]}, .shadows = 1, .color = {1.05F, 0.98F, 0.86F}};
}

/* A share of the mean width of an instance's box. */
static float default_range(const svo_scene *scene)
{
    double sum = 0;
    for (uint32_t i = 0; i < scene->info.instance_count; ++i) {
        double width = 0;
        for (int axis = 0; axis < 3; ++axis) {
            width = fmax(width, (double)scene->boxes[i].high[axis] - (double)scene->boxes[i].low[axis]);
        }
        sum += width;
    }
    return (float)(OCCLUSION_SHARE * sum / scene->info.instance_count);
}

static svo_status fill_picture(const svo_scene *scene, const char *function, const svo_scene_render_options *options,
                               svo_scene_picture *picture, svo_scene_light lights[SVO_SCENE_LIGHTS_MAX],
                               svo_i_pixel_output *output)
{
    svo_i_pinhole hole;
    SVO_I_TRY(
        svo_i_pixel_output_of(scene->device, function, "options", &options->output, SAMPLES, SVO_I_CURVE_ROOT, output));
    SVO_I_TRY(
        svo_i_pinhole_from_camera(scene->device, function, &options->camera, options->width, options->height, &hole));
    for (int axis = 0; axis < 3; ++axis) {
        picture->eye[axis] = options->camera.eye[axis];
        picture->corner[axis] = hole.corner[axis];
        picture->across[axis] = hole.across[axis];
        picture->down[axis] = hole.down[axis];
        picture->up[axis] = (float)hole.up[axis];
        picture->background[axis] = output->background[axis];
    }
    memcpy(picture->clip, options->clip, sizeof picture->clip);
    picture->footprint = (float)(hole.pixel / sqrt((double)output->samples));
    picture->width = options->width;
    picture->height = options->height;
    picture->samples = output->samples;
    picture->pixel_flags = output->flags;
    picture->occlusion_range = options->occlusion_range > 0.0F ? options->occlusion_range : default_range(scene);
    picture->light_count = options->light_count;
    if (options->light_count == 0) {
        lights[0] = default_light(&hole.view, hole.up);
        picture->light_count = 1;
    }
    return fill_lights(scene, function, options, lights);
}

/* ---- drawing ---- */

/* A picture that is about to be drawn. */
typedef struct drawing {
    const svo_scene *scene;
    const char *function; /* for messages */
    svo_scene_picture picture;
    svo_scene_light lights[SVO_SCENE_LIGHTS_MAX];
    svo_i_pixel_output output;
    /* Owned, until the picture is enqueued. */
    cl_kernel kernel;
    cl_mem picture_buffer, lights_buffer;
} drawing;

static svo_status prepare(drawing *drawn, cl_mem pixels)
{
    const svo_scene *scene = drawn->scene;
    svo_device *device = scene->device;
    const char *function = drawn->function;
    cl_program program = NULL;
    SVO_I_TRY(svo_i_device_constants(device, function, "camera", &drawn->picture, sizeof drawn->picture,
                                     &drawn->picture_buffer));
    SVO_I_TRY(
        svo_i_device_constants(device, function, "lights", drawn->lights, sizeof drawn->lights, &drawn->lights_buffer));
    SVO_I_TRY(svo_i_program_get(device, function, SVO_I_PROGRAM_SCENE_CAST, scene->form, &program, NULL));
    SVO_I_TRY(svo_i_kernel_create(device, function, program, "svo_k_scene_render", &drawn->kernel));
    const svo_i_argument others[] = {
        SVO_I_ARGUMENT(scene->buffers[SVO_I_SCENE_COLORS]), SVO_I_ARGUMENT(scene->buffers[SVO_I_SCENE_NORMALS]),
        SVO_I_ARGUMENT(drawn->picture_buffer), SVO_I_ARGUMENT(drawn->lights_buffer), SVO_I_ARGUMENT(pixels)};
    SVO_I_TRY(svo_i_scene_set_args(scene, function, drawn->kernel, 0, &scene->params));
    return svo_i_kernel_set_from(device, function, drawn->kernel, svo_i_scene_arguments(scene),
                                 SVO_I_ARGUMENTS(others));
}

static void release(drawing *drawn)
{
    if (drawn->picture_buffer != NULL) {
        clReleaseMemObject(drawn->picture_buffer);
    }
    if (drawn->lights_buffer != NULL) {
        clReleaseMemObject(drawn->lights_buffer);
    }
    if (drawn->kernel != NULL) {
        clReleaseKernel(drawn->kernel);
    }
}

static svo_status enqueue(drawing *drawn, const svo_i_pixels *to)
{
    svo_status status = SVO_OK;
    SVO_I_TRY_CLEANUP(prepare(drawn, to->buffer));
    const svo_i_tiles tiles = {.kernel = drawn->kernel,
                               .first_tile = svo_i_scene_arguments(drawn->scene) + 5,
                               .items = SVO_GROUP_ITEMS,
                               .width = drawn->picture.width,
                               .height = drawn->picture.height};
    SVO_I_TRY_CLEANUP(svo_i_pixels_draw(drawn->scene->device, drawn->function, &tiles, to));

cleanup:
    release(drawn);
    return status;
}

/* Checks what is asked for. */
static svo_status begin(const svo_scene *scene, const char *function, const svo_scene_render_options *options,
                        drawing *out)
{
    svo_scene_render_options asked = {.width = 0};
    *out = (drawing){.scene = scene, .function = function};
    if (options == NULL) {
        return svo_i_device_fail(scene->device, SVO_INVALID_ARGUMENT, "%s: options is NULL", function);
    }
    SVO_I_TRY(svo_i_struct_read(&scene->device->message, function, "options", options, &asked,
                                SVO_I_STRUCT_SIZES(svo_scene_render_options, reserved2)));
    SVO_I_TRY(svo_i_scene_check(scene, function));
    SVO_I_TRY(check_options(scene, function, &asked));
    return fill_picture(scene, function, &asked, &out->picture, out->lights, &out->output);
}

svo_status svo_scene_render_enqueue(svo_scene *scene, const svo_scene_render_options *options, cl_mem pixels,
                                    cl_command_queue queue, cl_uint num_wait, const cl_event *wait, cl_event *event)
{
    svo_i_pixels to = {pixels, queue, num_wait, wait, event};
    drawing drawn;
    if (scene == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    SVO_I_TRY(begin(scene, "svo_scene_render_enqueue", options, &drawn));
    SVO_I_TRY(svo_i_pixels_check(scene->device, drawn.function, drawn.picture.width, drawn.picture.height,
                                 drawn.output.pixel_bytes, &to));
    return enqueue(&drawn, &to);
}

svo_status svo_scene_render(svo_scene *scene, const svo_scene_render_options *options, cl_command_queue queue,
                            uint8_t *rgba)
{
    static const char function[] = "svo_scene_render";
    svo_i_own_pixels own;
    drawing drawn;
    svo_status status = SVO_OK;
    if (scene == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    if (rgba == NULL) {
        return svo_i_device_fail(scene->device, SVO_INVALID_ARGUMENT, "%s: rgba is NULL", function);
    }
    SVO_I_TRY(begin(scene, function, options, &drawn));
    SVO_I_TRY(svo_i_own_pixels_begin(scene->device, function, drawn.picture.width, drawn.picture.height,
                                     drawn.output.pixel_bytes, queue, &own));
    SVO_I_TRY_CLEANUP(enqueue(&drawn, &own.to));
    SVO_I_TRY_CLEANUP(svo_i_own_pixels_read(&own, 0, drawn.picture.height, rgba));

cleanup:
    svo_i_own_pixels_end(&own);
    return status;
}
