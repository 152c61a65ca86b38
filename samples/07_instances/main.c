/* SPDX-License-Identifier: MIT */
/*
 * Many instances of five models, all moving: a swarm on a wave. Each frame sets all transforms, traces a ray to the
 * middle, and writes a picture.
 */
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "svocl/svocl.h"

#define MODELS 5
#define AROUND 48u /* quads around a model, and along it */
#define ALONG  48u
#define DEPTH  6
#define TURN   6.283185307179586

/* ---- models ---- */

/* A point of a model's surface; u and v go once around, in turns. */
typedef void surface(double u, double v, double point[3]);

static void ball(double u, double v, double point[3])
{
    point[0] = sin(0.5 * TURN * v) * cos(TURN * u);
    point[1] = cos(0.5 * TURN * v);
    point[2] = sin(0.5 * TURN * v) * sin(TURN * u);
}

static void ring(double u, double v, double point[3])
{
    const double radius = 0.7 + 0.28 * cos(TURN * v);
    point[0] = radius * cos(TURN * u);
    point[1] = -0.28 * sin(TURN * v);
    point[2] = radius * sin(TURN * u);
}

static void top(double u, double v, double point[3])
{
    const double radius = v < 0.5 ? 2 * v : 2 - 2 * v;
    point[0] = radius * cos(TURN * u);
    point[1] = 1 - 2 * v;
    point[2] = radius * sin(TURN * u);
}

static void flower(double u, double v, double point[3])
{
    const double radius = 0.55 + 0.45 * cos(5 * TURN * u);
    ball(u, v, point);
    point[0] *= radius;
    point[1] *= 0.35;
    point[2] *= radius;
}

static void twist(double u, double v, double point[3])
{
    const double angle = 1.5 * TURN * u;
    const double wide = 0.3 * cos(TURN * v);
    const double thick = -0.12 * sin(TURN * v);
    const double radius = 0.7 + wide * cos(angle) - thick * sin(angle);
    point[0] = radius * cos(TURN * u);
    point[1] = wide * sin(angle) + thick * cos(angle);
    point[2] = radius * sin(TURN * u);
}

static surface *const surfaces[MODELS] = {ball, ring, top, flower, twist};
static const uint8_t tints[MODELS][2][3] = {{{244, 180, 60}, {225, 85, 45}},
                                            {{70, 170, 215}, {35, 75, 160}},
                                            {{245, 240, 225}, {190, 60, 90}},
                                            {{235, 120, 165}, {130, 55, 150}},
                                            {{120, 205, 110}, {25, 120, 95}}};

/* The vertices and triangles of a model, which does not close its seams. */
typedef struct model {
    float positions[(AROUND + 1) * (ALONG + 1) * 3];
    uint8_t colors[(AROUND + 1) * (ALONG + 1) * 4];
    uint32_t indices[AROUND * ALONG * 6];
} model;

static void make_model(int which, model *out)
{
    for (uint32_t k = 0; k < (AROUND + 1) * (ALONG + 1); ++k) {
        const uint32_t column = k % (AROUND + 1);
        const uint32_t row = k / (AROUND + 1);
        double point[3];
        surfaces[which]((double)column / AROUND, (double)row / ALONG, point);
        for (int axis = 0; axis < 3; ++axis) {
            out->positions[3 * k + (uint32_t)axis] = (float)point[axis];
            out->colors[4 * k + (uint32_t)axis] = tints[which][(column / 4 + row / 6) % 2][axis];
        }
        out->colors[4 * k + 3] = 255;
    }
    for (uint32_t k = 0; k < AROUND * ALONG; ++k) {
        const uint32_t corner = k / AROUND * (AROUND + 1) + k % AROUND;
        const uint32_t quad[6] = {corner,     corner + 1,          corner + AROUND + 1,
                                  corner + 1, corner + AROUND + 2, corner + AROUND + 1};
        memcpy(out->indices + (size_t)6 * k, quad, sizeof quad);
    }
}

static bool build_model(svo_device *device, int which, svo_tree **out)
{
    static model made;
    make_model(which, &made);
    const svo_mesh mesh = {.struct_size = sizeof mesh,
                           .positions = made.positions,
                           .colors = made.colors,
                           .vertex_count = (size_t)(AROUND + 1) * (ALONG + 1),
                           .indices = made.indices,
                           .triangle_count = (size_t)AROUND * ALONG * 2};
    const svo_plan_options options = {.struct_size = sizeof options,
                                      .need = (uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL};
    svo_plan *plan = NULL;
    const bool done = svo_plan_create(device, &mesh, DEPTH, &options, &plan) == SVO_OK &&
                      svo_build(plan, NULL, NULL, out, NULL) == SVO_OK;
    svo_plan_destroy(&plan);
    return done;
}

/* ---- motion ---- */

/* The instance's place at a time: a spiral of golden angles around the middle, on a wave, spinning. */
static void place(uint32_t index, double time, float transform[12])
{
    const double radius = 1.25 * sqrt(index + 0.5);
    const double angle = index * 2.399963229728653 + 0.05 * time;
    const double spin = time * (0.5 + index % 7 * 0.2) + index;
    const double tilt = 0.6 * sin(0.7 * time + index);
    const double size = 0.75 + 0.35 * sin(index * 0.37);
    const double c = cos(spin) * size;
    const double s = sin(spin) * size;
    const double height = 1.8 * sin(0.22 * radius - 1.3 * time);
    const double matrix[12] = {c,  -s * sin(tilt),   s * cos(tilt),    radius * cos(angle),
                               0,  size * cos(tilt), size * sin(tilt), height,
                               -s, -c * sin(tilt),   c * cos(tilt),    radius * sin(angle)};
    for (int i = 0; i < 12; ++i) {
        transform[i] = (float)matrix[i];
    }
}

static bool make_scene(svo_device *device, svo_tree *const *trees, uint32_t count, svo_scene **out)
{
    svo_instance *instances = calloc(count, sizeof *instances);
    if (instances == NULL) {
        return false;
    }
    for (uint32_t i = 0; i < count; ++i) {
        instances[i].tree = i % MODELS;
        place(i, 0, instances[i].transform);
    }
    const svo_scene_options options = {.struct_size = sizeof options,
                                       .trees = trees,
                                       .instances = instances,
                                       .tree_count = MODELS,
                                       .instance_count = count};
    const bool done = svo_scene_create(device, &options, NULL, out) == SVO_OK;
    free(instances);
    return done;
}

/* ---- frames ---- */

static bool write_picture(uint32_t frame, const uint8_t *rgba, uint32_t width, uint32_t height)
{
    char name[32];
    snprintf(name, sizeof name, "frame_%02u.ppm", frame);
    FILE *file = fopen(name, "wb");
    if (file == NULL) {
        return false;
    }
    bool done = fprintf(file, "P6\n%u %u\n255\n", width, height) > 0;
    for (size_t i = 0; i < (size_t)width * height; ++i) {
        done = fwrite(rgba + 4 * i, 1, 3, file) == 3 && done;
    }
    return fclose(file) == 0 && done;
}

/* Moves everything, asks what the middle of the picture shows, and draws. */
static bool draw_frame(svo_scene *scene, uint32_t frame, uint32_t count, uint32_t width, float *transforms,
                       uint8_t *rgba)
{
    const svo_camera camera = {.eye = {0, 14, 46}, .target = {0, 0, 16}, .up = {0, 1, 0}, .vertical_fov = 0.6F};
    const svo_render_options options = {
        .struct_size = sizeof options, .width = width, .height = width * 9 / 16, .camera = camera};
    const svo_ray ray = {.origin = {0, 14, 46}, .direction = {0, -14, -30}, .t_min = 0, .t_max = INFINITY};
    svo_scene_hit hit;
    for (uint32_t i = 0; i < count; ++i) {
        place(i, 0.25 * frame, transforms + (size_t)12 * i);
    }
    if (svo_scene_set_transforms(scene, 0, count, transforms, NULL) != SVO_OK ||
        svo_scene_rebuild(scene, NULL) != SVO_OK || /* pays when instances move far; not needed for the result */
        svo_trace_voxels(svo_scene_target(scene), svo_in_host(&ray), svo_in_host(&hit), 1, 0, SVO_SCENE_CLOSEST,
                         NULL) != SVO_OK ||
        svo_render(svo_scene_target(scene), &options, svo_in_host(rgba), NULL) != SVO_OK) {
        return false;
    }
    if (hit.instance == SVO_NO_INSTANCE) {
        printf("frame %u: nothing in the middle\n", frame);
    } else {
        printf("frame %u: instance %u in the middle\n", frame, hit.instance);
    }
    return write_picture(frame, rgba, width, options.height);
}

static bool draw_frames(svo_scene *scene, uint32_t count, uint32_t frames, uint32_t width)
{
    float *transforms = calloc(count, 12 * sizeof *transforms);
    uint8_t *rgba = calloc((size_t)width * width, 4);
    bool done = transforms != NULL && rgba != NULL;
    for (uint32_t frame = 0; frame < frames && done; ++frame) {
        done = draw_frame(scene, frame, count, width, transforms, rgba);
    }
    free(transforms);
    free(rgba);
    return done;
}

static uint32_t number(int argument_count, char **arguments, int index, uint32_t otherwise)
{
    return argument_count > index ? (uint32_t)strtoul(arguments[index], NULL, 10) : otherwise;
}

int main(int argument_count, char **arguments)
{
    const uint32_t count = number(argument_count, arguments, 1, 10000);
    const uint32_t frames = number(argument_count, arguments, 2, 4);
    const uint32_t width = number(argument_count, arguments, 3, 640);
    if (argument_count > 4 || count < 1 || count > 1000000 || width < 16 || width > 4096) {
        fprintf(stderr, "usage: %s [INSTANCES [FRAMES [WIDTH]]]\n", arguments[0]);
        return 2;
    }
    svo_message message = {""};
    svo_device *device = NULL;
    svo_tree *trees[MODELS] = {NULL};
    svo_scene *scene = NULL;
    bool done = svo_device_create_default(NULL, &device, &message) == SVO_OK;
    for (int i = 0; i < MODELS && done; ++i) {
        done = build_model(device, i, &trees[i]);
    }
    done = done && make_scene(device, trees, count, &scene);
    for (int i = 0; i < MODELS; ++i) {
        svo_tree_destroy(&trees[i]); /* the scene has copies */
    }
    done = done && draw_frames(scene, count, frames, width);
    if (!done) {
        fprintf(stderr, "%s\n", device == NULL ? message.text : svo_device_message(device));
    }
    svo_scene_destroy(&scene);
    svo_device_destroy(&device);
    return done ? 0 : 1;
}
