/* SPDX-License-Identifier: MIT */
/* Pictures of scenes: the host side of kernels/scene/render.cl. */
#include <math.h>

#include "core/struct_size.h"
#include "rays/camera.h"
#include "rays/picture.h"
#include "scene/state.h"

/* Rays along each side of a pixel. */
#define SAMPLES 2u
/* The range of the ambient occlusion, of an instance's mean width. */
#define OCCLUSION_SHARE 0.25

static const char function_name[] = "svo_scene_render";

/* ---- checks ---- */

static svo_status check_options(const svo_scene *scene, const svo_scene_render_options *options)
{
    SVO_I_TRY(svo_i_camera_check(scene->device, function_name, &options->camera, options->width, options->height));
    if (options->light_count > SVO_SCENE_LIGHTS_MAX || (options->light_count > 0 && options->lights == NULL)) {
        return svo_i_device_fail(scene->device, SVO_INVALID_ARGUMENT,
                                 "%s: options.light_count %u is above %u, or options.lights is NULL", function_name,
                                 options->light_count, SVO_SCENE_LIGHTS_MAX);
    }
    if (!(options->occlusion_range >= 0.0F) || !isfinite(options->occlusion_range)) {
        return svo_i_device_fail(scene->device, SVO_INVALID_ARGUMENT,
                                 "%s: options.occlusion_range %g is not finite, or below 0", function_name,
                                 (double)options->occlusion_range);
    }
    return SVO_OK;
}

/* ---- parameters ---- */

/* The caller's lights with unit directions. */
static svo_status fill_lights(const svo_scene *scene, const svo_scene_render_options *options,
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
                                     function_name, i);
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

static svo_status fill_picture(const svo_scene *scene, const svo_scene_render_options *options,
                               svo_scene_picture *picture, svo_scene_light lights[SVO_SCENE_LIGHTS_MAX])
{
    svo_i_pinhole hole;
    SVO_I_TRY(svo_i_pinhole_from_camera(scene->device, function_name, &options->camera, options->width, options->height,
                                        &hole));
    for (int axis = 0; axis < 3; ++axis) {
        picture->eye[axis] = options->camera.eye[axis];
        picture->corner[axis] = hole.corner[axis];
        picture->across[axis] = hole.across[axis];
        picture->down[axis] = hole.down[axis];
        picture->up[axis] = (float)hole.up[axis];
    }
    picture->footprint = (float)hole.pixel;
    picture->width = options->width;
    picture->height = options->height;
    picture->samples = SAMPLES;
    picture->occlusion_range = options->occlusion_range > 0.0F ? options->occlusion_range : default_range(scene);
    picture->light_count = options->light_count;
    if (options->light_count == 0) {
        lights[0] = default_light(&hole.view, hole.up);
        picture->light_count = 1;
    }
    return fill_lights(scene, options, lights);
}

/* ---- drawing ---- */

typedef struct drawing {
    svo_i_tiles tiles;
    cl_mem picture, lights;
} drawing;

static svo_status write(const svo_scene *scene, cl_command_queue queue, cl_mem to, size_t bytes, const void *data)
{
    const cl_int error = clEnqueueWriteBuffer(queue, to, CL_TRUE, 0, bytes, data, 0, NULL, NULL);
    return error == CL_SUCCESS ? SVO_OK
                               : svo_i_device_fail_cl(scene->device, function_name, "clEnqueueWriteBuffer", error);
}

static svo_status prepare(const svo_scene *scene, const svo_scene_picture *picture, drawing *out)
{
    svo_device *device = scene->device;
    const size_t pixel_bytes = (size_t)picture->width * picture->height * 4;
    cl_program program = NULL;
    out->tiles.items = SVO_GROUP_ITEMS;
    out->tiles.width = picture->width;
    out->tiles.height = picture->height;
    SVO_I_TRY(svo_i_device_buffer(device, function_name, "camera", CL_MEM_READ_ONLY, sizeof *picture, &out->picture));
    SVO_I_TRY(svo_i_device_buffer(device, function_name, "lights", CL_MEM_READ_ONLY,
                                  SVO_SCENE_LIGHTS_MAX * sizeof(svo_scene_light), &out->lights));
    SVO_I_TRY(
        svo_i_device_buffer(device, function_name, "picture", CL_MEM_WRITE_ONLY, pixel_bytes, &out->tiles.pixels));
    SVO_I_TRY(svo_i_program_get(device, function_name, SVO_I_PROGRAM_SCENE_CAST, scene->form, &program, NULL));
    SVO_I_TRY(svo_i_kernel_create(device, function_name, program, "svo_k_scene_render", &out->tiles.kernel));
    const svo_i_argument others[] = {SVO_I_ARGUMENT(scene->buffers[SVO_I_SCENE_COLORS]),
                                     SVO_I_ARGUMENT(scene->buffers[SVO_I_SCENE_NORMALS]), SVO_I_ARGUMENT(out->picture),
                                     SVO_I_ARGUMENT(out->lights), SVO_I_ARGUMENT(out->tiles.pixels)};
    out->tiles.first_tile = svo_i_scene_arguments(scene) + 5;
    SVO_I_TRY(svo_i_scene_set_args(scene, function_name, out->tiles.kernel, 0, &scene->params));
    return svo_i_kernel_set_from(device, function_name, out->tiles.kernel, svo_i_scene_arguments(scene),
                                 SVO_I_ARGUMENTS(others));
}

static void release(drawing *drawn)
{
    const cl_mem buffers[] = {drawn->picture, drawn->lights, drawn->tiles.pixels};
    for (size_t i = 0; i < sizeof buffers / sizeof buffers[0]; ++i) {
        if (buffers[i] != NULL) {
            clReleaseMemObject(buffers[i]);
        }
    }
    if (drawn->tiles.kernel != NULL) {
        clReleaseKernel(drawn->tiles.kernel);
    }
}

svo_status svo_scene_render(svo_scene *scene, const svo_scene_render_options *options, cl_command_queue queue,
                            uint8_t *rgba)
{
    svo_scene_render_options asked = {.width = 0};
    svo_scene_picture picture = {.samples = 0};
    svo_scene_light lights[SVO_SCENE_LIGHTS_MAX] = {{.shadows = 0}};
    drawing drawn = {.picture = NULL};
    svo_status status = SVO_OK;
    if (scene == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    if (options == NULL || rgba == NULL) {
        return svo_i_device_fail(scene->device, SVO_INVALID_ARGUMENT, "%s: %s is NULL", function_name,
                                 options == NULL ? "options" : "rgba");
    }
    SVO_I_TRY(svo_i_struct_read(&scene->device->message, function_name, "options", options, &asked,
                                SVO_I_STRUCT_SIZES(svo_scene_render_options, reserved2)));
    SVO_I_TRY(svo_i_scene_check(scene, function_name));
    SVO_I_TRY(check_options(scene, &asked));
    SVO_I_TRY(fill_picture(scene, &asked, &picture, lights));
    SVO_I_TRY(svo_i_device_queue(scene->device, function_name, queue, &queue));
    SVO_I_TRY_CLEANUP(prepare(scene, &picture, &drawn));
    SVO_I_TRY_CLEANUP(write(scene, queue, drawn.picture, sizeof picture, &picture));
    SVO_I_TRY_CLEANUP(write(scene, queue, drawn.lights, sizeof lights, lights));
    SVO_I_TRY_CLEANUP(svo_i_picture_draw_tiles(scene->device, function_name, queue, &drawn.tiles, rgba));

cleanup:
    release(&drawn);
    return status;
}
