/* SPDX-License-Identifier: MIT */
/* Rays in batches against the voxels or the triangles of a scene (kernels/scene/trace.cl), and its pictures
   (render.cl). */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "core/submit.h"
#include "rays/batch.h"
#include "rays/camera.h"
#include "rays/picture.h"
#include "rays/target.h"
#include "scene/handle.h"
#include "scene/programs.h"
#include "svocl/plan.h"

#define FLAGS_MAX ((uint32_t)SVO_SCENE_ANY | (uint32_t)SVO_SCENE_EVERY_INSTANCE)
_Static_assert((uint32_t)SVO_SCENE_ANY == 1 && (uint32_t)SVO_SCENE_EVERY_INSTANCE == 2,
               "svo_scene_flags and kernels/scene/scene.clh number the flags alike");

/* Rays of a pixel. */
#define SAMPLES 4u
/* The range of the ambient occlusion, of an instance's mean width. */
#define OCCLUSION_SHARE 0.25

/* ---- arguments of kernels ---- */

/* How many arguments SVO_SCENE_PARAMETERS declares for the scene. */
static cl_uint count_arguments(const svo_scene *scene)
{
    return scene->node_buffers + (SVO_I_SCENE_ARGUMENT_BUFFERS - SVO_I_SCENE_NODE_BUFFERS) + 1;
}

/* Lists them. */
static cl_uint list_arguments(const svo_scene *scene, const svo_scene_params *params, svo_i_argument *arguments)
{
    cl_uint count = 0;
    for (cl_uint i = 0; i < SVO_I_SCENE_ARGUMENT_BUFFERS; ++i) {
        if (i < scene->node_buffers || i >= SVO_I_SCENE_NODE_BUFFERS) {
            const bool is_wide = i == SVO_I_SCENE_HIERARCHY && scene->device->cpu_path;
            arguments[count++] = SVO_I_ARGUMENT(scene->buffers[is_wide ? SVO_I_SCENE_WIDE : i]);
        }
    }
    arguments[count++] = (svo_i_argument){sizeof *params, params, false};
    return count;
}

static svo_status set_scene(const svo_scene *scene, const char *function, cl_kernel kernel, cl_uint first_index,
                            const svo_scene_params *params)
{
    svo_i_argument arguments[SVO_I_SCENE_ARGUMENT_BUFFERS + 1];
    const cl_uint count = list_arguments(scene, params, arguments);
    return svo_i_kernel_set_from(scene->device, function, kernel, first_index, arguments, count);
}

/* ---- batches ---- */

/* What a batch is traced against. */
typedef struct scene_target {
    const svo_scene *scene;
    svo_scene_params params;
    bool triangles;
    char defines[SVO_I_PROGRAM_DEFINES_BYTES];
} scene_target;

static svo_status check_target(void *of, const char *function)
{
    const scene_target *target = of;
    svo_device *device = target->scene->device;
    SVO_I_TRY(svo_i_scene_check(target->scene, function));
    if (target->triangles && (target->scene->info.need & SVO_NEED_RAYS) == 0) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                 "%s: the scene holds no triangles; create it with SVO_NEED_RAYS", function);
    }
    if (target->params.flags > FLAGS_MAX) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: flags %u is not in 0 .. %u", function,
                                 target->params.flags, FLAGS_MAX);
    }
    if (!(target->params.footprint >= 0.0F) || !isfinite(target->params.footprint)) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: footprint %g is negative or not finite", function,
                                 (double)target->params.footprint);
    }
    return SVO_OK;
}

static svo_status set_target(void *of, const char *function, cl_kernel kernel, cl_uint first_index)
{
    const scene_target *target = of;
    return set_scene(target->scene, function, kernel, first_index, &target->params);
}

static svo_status trace(const svo_scene *scene, const char *function, scene_target *of, const svo_array *rays,
                        const svo_array *hits, size_t ray_count, const svo_submit *submit)
{
    const char *lanes = scene->device->cpu_path ? " -DSVO_LANES_APART" : "";
    (void)snprintf(of->defines, sizeof of->defines, "%s%s", scene->form,
                   of->triangles ? " -DSVO_SCENE_TRIANGLES" : lanes);
    const svo_i_batch asked = {.device = scene->device,
                               .function = function,
                               .target = {of, count_arguments(scene), check_target, set_target},
                               .program = &svo_i_program_scene_trace,
                               .kernel_name = "svo_k_scene_trace",
                               .defines = of->defines,
                               .input_name = "rays",
                               .output_name = "hits",
                               .input_bytes = sizeof(svo_ray),
                               .output_bytes = of->triangles ? sizeof(svo_scene_triangle_hit) : sizeof(svo_scene_hit),
                               .count = ray_count,
                               .streams = scene->device->cpu_path};
    return svo_i_batch_run(&asked, rays, hits, submit);
}

static svo_status trace_voxels(void *scene, const svo_array *rays, const svo_array *hits, size_t ray_count,
                               float footprint, uint32_t flags, const svo_submit *submit)
{
    scene_target of = {.scene = scene, .params = ((const svo_scene *)scene)->params, .triangles = false};
    of.params.footprint = footprint;
    of.params.flags = flags;
    return trace(scene, "svo_trace_voxels", &of, rays, hits, ray_count, submit);
}

static svo_status trace_triangles(void *scene, const svo_array *rays, const svo_array *hits, size_t ray_count,
                                  uint32_t flags, const svo_submit *submit)
{
    scene_target of = {.scene = scene, .params = ((const svo_scene *)scene)->params, .triangles = true};
    of.params.footprint = 0.0F;
    of.params.flags = flags;
    return trace(scene, "svo_trace_triangles", &of, rays, hits, ray_count, submit);
}

/* ---- rays by alpha ---- */

/* Options of kernels that see what shows in part, and read payload. */
static void write_seeing_options(const svo_scene *scene, char defines[SVO_I_PROGRAM_DEFINES_BYTES])
{
    (void)snprintf(defines, SVO_I_PROGRAM_DEFINES_BYTES, "%s%s%s%s", scene->form,
                   scene->is_clear ? " -DSVO_CLEAR_NODES" : "", scene->is_packed ? " -DSVO_PACKED" : "",
                   scene->device->cpu_path ? " -DSVO_RAY_STREAMS" : "");
}

svo_status svo_i_scene_see(const svo_scene *scene, svo_i_device_work *work, cl_mem rays, cl_mem hits,
                           uint32_t ray_count)
{
    svo_i_argument arguments[SVO_I_SCENE_ARGUMENT_BUFFERS + 5];
    char defines[SVO_I_PROGRAM_DEFINES_BYTES];
    svo_scene_params params = scene->params;
    params.footprint = 0.0F;
    params.flags = SVO_SCENE_CLOSEST;
    cl_uint count = list_arguments(scene, &params, arguments);
    arguments[count++] = SVO_I_ARGUMENT(scene->buffers[SVO_I_SCENE_COLORS]);
    arguments[count++] = SVO_I_ARGUMENT(rays);
    arguments[count++] = SVO_I_ARGUMENT(hits);
    arguments[count++] = SVO_I_ARGUMENT(ray_count);
    write_seeing_options(scene, defines);
    SVO_I_TRY(svo_i_work_use(work, &svo_i_program_scene_see, defines));
    return svo_i_work_launch(work, "svo_k_scene_see", arguments, count, ray_count);
}

/* ---- pictures ---- */

static svo_status check_options(const svo_scene *scene, const char *function, const svo_render_options *options)
{
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

/* The caller's lights with unit directions. */
static svo_status fill_lights(const svo_scene *scene, const char *function, const svo_render_options *options,
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

/* The light of a tree's picture. */
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

static svo_status fill_picture(const svo_scene *scene, const char *function, const svo_render_options *options,
                               svo_scene_picture *picture, svo_scene_light lights[SVO_SCENE_LIGHTS_MAX],
                               svo_i_pixel_output *output)
{
    svo_i_pinhole hole;
    SVO_I_TRY(svo_i_pixel_output_of(scene->device, function, &options->output, SAMPLES, SVO_I_CURVE_ROOT, output));
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
    char defines[SVO_I_PROGRAM_DEFINES_BYTES];
    cl_program program = NULL;
    write_seeing_options(scene, defines);
    SVO_I_TRY(svo_i_device_constants(device, function, "camera", &drawn->picture, sizeof drawn->picture,
                                     &drawn->picture_buffer));
    SVO_I_TRY(
        svo_i_device_constants(device, function, "lights", drawn->lights, sizeof drawn->lights, &drawn->lights_buffer));
    SVO_I_TRY(svo_i_program_get(device, function, &svo_i_program_scene_cast, defines, &program, NULL));
    SVO_I_TRY(svo_i_kernel_create(device, function, program, "svo_k_scene_render", &drawn->kernel));
    const svo_i_argument others[] = {
        SVO_I_ARGUMENT(scene->buffers[SVO_I_SCENE_COLORS]), SVO_I_ARGUMENT(scene->buffers[SVO_I_SCENE_NORMALS]),
        SVO_I_ARGUMENT(drawn->picture_buffer), SVO_I_ARGUMENT(drawn->lights_buffer), SVO_I_ARGUMENT(pixels)};
    SVO_I_TRY(set_scene(scene, function, drawn->kernel, 0, &scene->params));
    return svo_i_kernel_set_from(device, function, drawn->kernel, count_arguments(scene), SVO_I_ARGUMENTS(others));
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

static svo_status enqueue(drawing *drawn, const svo_array *to, svo_i_call *call)
{
    const size_t bytes = (size_t)drawn->picture.width * drawn->picture.height * drawn->output.pixel_bytes;
    cl_mem pixels = NULL;
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_i_call_output(call, "pixels", to, bytes, 0, bytes, &pixels));
    SVO_I_TRY_CLEANUP(prepare(drawn, pixels));
    const svo_i_tiles tiles = {.kernel = drawn->kernel,
                               .items = SVO_GROUP_ITEMS,
                               .width = drawn->picture.width,
                               .height = drawn->picture.height};
    SVO_I_TRY_CLEANUP(svo_i_tiles_draw(&tiles, call));

cleanup:
    release(drawn);
    return status;
}

static svo_status render(void *of, const svo_render_options *options, const svo_array *pixels, const svo_submit *submit)
{
    static const svo_i_picture_kind kind = {
        .name = "scene", .views = 1u << SVO_VIEW_SHADED, .view_names = "SVO_VIEW_SHADED", .lights = true};
    const svo_scene *scene = of;
    drawing drawn = {.scene = scene, .function = "svo_render"};
    svo_render_options asked;
    svo_i_call call;
    SVO_I_TRY(svo_i_picture_options(scene->device, drawn.function, &kind, options, &asked));
    SVO_I_TRY(svo_i_scene_check(scene, drawn.function));
    SVO_I_TRY(check_options(scene, drawn.function, &asked));
    SVO_I_TRY(fill_picture(scene, drawn.function, &asked, &drawn.picture, drawn.lights, &drawn.output));
    SVO_I_TRY(svo_i_call_begin(scene->device, drawn.function, submit, &call));
    return svo_i_call_end(&call, enqueue(&drawn, pixels, &call));
}

/* ---- cameras ---- */

/* Of the instances' boxes. */
static double scene_reach(const void *subject, const double along[3])
{
    const svo_scene *scene = subject;
    double farthest = -HUGE_VAL;
    for (uint32_t i = 0; i < scene->info.instance_count; ++i) {
        const svo_i_instance_box *box = &scene->boxes[i];
        double reach = 0;
        for (int axis = 0; axis < 3; ++axis) {
            reach += along[axis] * (double)(along[axis] > 0 ? box->high[axis] : box->low[axis]);
        }
        farthest = fmax(farthest, reach);
    }
    return farthest;
}

static svo_status fit_camera(const void *scene, float aspect, svo_camera *camera)
{
    const svo_i_fitted fitted = {scene, scene_reach};
    return svo_i_camera_fit(&fitted, aspect, camera) ? SVO_OK : SVO_INVALID_ARGUMENT;
}

/* ---- the class ---- */

static svo_device *device_of(const void *scene)
{
    return ((const svo_scene *)scene)->device;
}

static const struct svo_target_class scene_class = {.name = "scene",
                                                    .device = device_of,
                                                    .trace_triangles = trace_triangles,
                                                    .trace_voxels = trace_voxels,
                                                    .render = render,
                                                    .fit_camera = fit_camera};

svo_target svo_scene_target(svo_scene *scene)
{
    return (svo_target){&scene_class, scene};
}
