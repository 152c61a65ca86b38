/* SPDX-License-Identifier: MIT */
/*
 * A mesh that moves: a waving cloth of 20,000 triangles, 60 frames into one tree and one BVH. Each frame is an update
 * of the plan, a build and a refit on one queue; the host waits once. Beside it, some frames are planned anew.
 */
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "svocl/svocl.h"

enum { SIDE = 100, VERTICES = (SIDE + 1) * (SIDE + 1), TRIANGLES = 2 * SIDE * SIDE, DEPTH = 8 };
enum { FRAMES = 60, ANEW_EVERY = 12, PICTURES = 6, WIDTH = 256, HEIGHT = 256, RAYS = 4096 };

static float positions[VERTICES * 3];
static uint8_t colors[VERTICES * 4];
static uint32_t indices[TRIANGLES * 3];
static uint8_t film[HEIGHT][PICTURES][WIDTH * 4];
static svo_ray rays[RAYS];
static svo_hit hits[2][RAYS];

static const svo_mesh mesh = {.struct_size = sizeof mesh,
                              .positions = positions,
                              .vertex_count = VERTICES,
                              .indices = indices,
                              .triangle_count = TRIANGLES,
                              .colors = colors};

/* The grid and all capacities are fixed. */
static const svo_plan_options options = {.struct_size = sizeof options,
                                         .need = SVO_NEED_RAYS | SVO_NEED_COLOR | SVO_NEED_NORMAL,
                                         .edge = 1.0,
                                         .max_area = 4.0,
                                         .fragment_capacity = 300000,
                                         .updatable = 1};

/* What runs once a frame, in order. */
enum { BEGIN, UPDATE, BUILD, REFIT, STAGES };
static const char *const stage_names[STAGES] = {"", "update", "build", "refit"};

typedef struct cloth {
    svo_device *device;
    svo_frontend *frontend;
    cl_command_queue queue;
    svo_plan *plan;
    svo_workspace *workspace;
    svo_tree *tree;
    double stage_ms[STAGES], frames_ms, anew_ms;
} cloth;

static double now_ms(void)
{
    struct timespec t;
    timespec_get(&t, TIME_UTC);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec * 1e-6;
}

/* Squares of two colors, and two triangles for each square of vertices. */
static void weave(void)
{
    for (size_t v = 0; v < VERTICES; ++v) {
        const bool red = (v % (SIDE + 1) / 10 + v / (SIDE + 1) / 10) % 2 == 0;
        const uint8_t rgba[4] = {red ? 190 : 235, red ? 40 : 225, red ? 45 : 205, 255};
        memcpy(colors + v * 4, rgba, sizeof rgba);
    }
    for (size_t t = 0; t < TRIANGLES; ++t) {
        const uint32_t corner = (uint32_t)(t / 2 / SIDE * (SIDE + 1) + t / 2 % SIDE);
        const uint32_t steps[2][3] = {{0, 1, SIDE + 1}, {1, SIDE + 2, SIDE + 1}};
        for (size_t k = 0; k < 3; ++k)
            indices[t * 3 + k] = corner + steps[t % 2][k];
    }
    for (int r = 0; r < RAYS; ++r) {
        const int row = r / 64;
        rays[r] = (svo_ray){.origin = {(float)(r % 64) / 64.0F, (float)row / 64.0F, -1.0F},
                            .direction = {0.05F, 0.02F, 1.0F},
                            .t_max = 10.0F};
    }
}

/* The cloth hangs at its upper edge; waves run down and grow. */
static void move_to(int frame)
{
    const float time = 6.2831853F * (float)frame / FRAMES;
    for (size_t v = 0; v < VERTICES; ++v) {
        const size_t row = v / (SIDE + 1);
        const float x = (float)(v % (SIDE + 1)) / SIDE;
        const float y = (float)row / SIDE;
        positions[v * 3] = 0.12F + 0.76F * x + 0.04F * y * sinf(5.0F * y - time);
        positions[v * 3 + 1] = 0.92F - 0.8F * y + 0.03F * y * cosf(4.0F * x + time);
        positions[v * 3 + 2] = 0.5F + 0.22F * y * sinf(7.0F * x + 3.0F * y - 2.0F * time);
    }
}

static bool prepare(cloth *c, svo_message *message)
{
    svo_device_info on = SVO_DEVICE_INFO_INIT;
    if (svo_device_create_default(NULL, &c->device, message) != SVO_OK || svo_device_get_info(c->device, &on) != SVO_OK)
        return false;
    c->queue = clCreateCommandQueue(on.context, on.device, CL_QUEUE_PROFILING_ENABLE, NULL);
    move_to(0);
    return c->queue != NULL && svo_frontend_create_cl(c->device, &c->frontend) == SVO_OK &&
           svo_plan_create(c->device, &mesh, DEPTH, &options, &c->plan) == SVO_OK &&
           svo_workspace_create(c->plan, c->frontend, c->queue, NULL, &c->workspace) == SVO_OK &&
           svo_workspace_make_tree(c->workspace, &c->tree) == SVO_OK &&
           svo_build_enqueue(c->workspace, c->tree, &(svo_submit){.queue = c->queue}) == SVO_OK &&
           svo_tree_finish(c->tree, c->queue, 0, NULL) == SVO_OK &&
           svo_tree_make_bvh(c->tree, SVO_BVH_BEST, c->queue) == SVO_OK;
}

/* The time between the ends of consecutive stages. */
static void add_times(cloth *c, cl_event ends[STAGES])
{
    cl_ulong before = 0;
    for (int i = 0; i < STAGES; ++i) {
        cl_ulong end = 0;
        clGetEventProfilingInfo(ends[i], CL_PROFILING_COMMAND_END, sizeof end, &end, NULL);
        c->stage_ms[i] += i > BEGIN ? (double)(end - before) * 1e-6 : 0.0;
        before = end;
        clReleaseEvent(ends[i]);
    }
}

/* One frame: nothing waits before the last line. */
static bool show_frame(cloth *c, int frame)
{
    cl_event ends[STAGES] = {NULL};
    move_to(frame);
    const double start = now_ms();
    const bool done =
        clEnqueueMarkerWithWaitList(c->queue, 0, NULL, &ends[BEGIN]) == CL_SUCCESS &&
        svo_plan_update(c->plan, &mesh, &(svo_submit){.queue = c->queue, .event = &ends[UPDATE]}) == SVO_OK &&
        svo_build_enqueue(c->workspace, c->tree, &(svo_submit){.queue = c->queue, .event = &ends[BUILD]}) == SVO_OK &&
        svo_tree_refit_bvh(c->tree, &(svo_submit){.queue = c->queue, .event = &ends[REFIT]}) == SVO_OK &&
        svo_tree_finish(c->tree, c->queue, 0, NULL) == SVO_OK && clFinish(c->queue) == CL_SUCCESS;
    c->frames_ms += now_ms() - start;
    if (done)
        add_times(c, ends);
    return done;
}

static bool take_picture(cloth *c, int picture)
{
    static uint8_t rgba[HEIGHT * WIDTH * 4];
    svo_render_options view = {.struct_size = sizeof view, .width = WIDTH, .height = HEIGHT};
    if (svo_camera_fit(svo_tree_target(c->tree), 1.0F, &view.camera) != SVO_OK ||
        svo_render(svo_tree_target(c->tree), &view, svo_in_host(rgba), &(svo_submit){.queue = c->queue}) != SVO_OK)
        return false;
    for (size_t y = 0; y < HEIGHT; ++y)
        memcpy(film[y][picture], rgba + y * sizeof film[y][picture], sizeof film[y][picture]);
    return true;
}

/* The frame without updates: a plan, a build, a BVH. Leaves what it finds in hash and hits[1]. */
static bool plan_anew(cloth *c, char hash[SVO_HASH_TEXT_BYTES])
{
    svo_plan *plan = NULL;
    svo_tree *tree = NULL;
    svo_plan_options fixed = {.struct_size = sizeof fixed, .need = options.need, .edge = options.edge};
    svo_plan_info info = SVO_PLAN_INFO_INIT;
    svo_plan_get_info(c->plan, &info);
    fixed.weight_log2 = info.weight_log2; /* the same unit of weight, so that payload is equal */
    const double start = now_ms();
    bool done = svo_plan_create(c->device, &mesh, DEPTH, &fixed, &plan) == SVO_OK &&
                svo_build(plan, c->frontend, c->queue, &tree, NULL) == SVO_OK &&
                svo_tree_make_bvh(tree, SVO_BVH_BEST, c->queue) == SVO_OK;
    c->anew_ms += now_ms() - start;
    done = done &&
           svo_trace_triangles(svo_tree_target(tree), svo_in_host(rays), svo_in_host(hits[1]), RAYS, SVO_TRACE_CLOSEST,
                               &(svo_submit){.queue = c->queue}) == SVO_OK &&
           svo_tree_download(tree, c->queue) == SVO_OK && svo_tree_hash(tree, SVO_HASH_ALL, hash) == SVO_OK;
    svo_tree_destroy(&tree);
    svo_plan_destroy(&plan);
    return done;
}

static void write_film(void)
{
    FILE *file = fopen("cloth.ppm", "wb");
    if (file == NULL)
        return;
    fprintf(file, "P6 %d %d 255\n", PICTURES * WIDTH, HEIGHT);
    for (int i = 0; i < HEIGHT * PICTURES * WIDTH; ++i)
        fwrite(&film[0][0][0] + (size_t)i * 4, 1, 3, file);
    fclose(file);
}

static bool run(cloth *c)
{
    char hash[2][SVO_HASH_TEXT_BYTES];
    svo_tree_info info = SVO_TREE_INFO_INIT;
    int found = 0;
    for (int frame = 0; frame < FRAMES; ++frame) {
        if (!show_frame(c, frame) ||
            (frame % (FRAMES / PICTURES) == 0 && !take_picture(c, frame / (FRAMES / PICTURES))) ||
            ((frame + 1) % ANEW_EVERY == 0 && !plan_anew(c, hash[1])))
            return false;
    }
    if (svo_trace_triangles(svo_tree_target(c->tree), svo_in_host(rays), svo_in_host(hits[0]), RAYS, SVO_TRACE_CLOSEST,
                            &(svo_submit){.queue = c->queue}) != SVO_OK ||
        svo_tree_download(c->tree, c->queue) != SVO_OK || svo_tree_hash(c->tree, SVO_HASH_ALL, hash[0]) != SVO_OK ||
        svo_tree_get_info(c->tree, &info) != SVO_OK)
        return false;
    bool same = strcmp(hash[0], hash[1]) == 0;
    for (int r = 0; r < RAYS; ++r) {
        found += hits[0][r].triangle != SVO_NO_TRIANGLE ? 1 : 0;
        same = same && hits[0][r].t == hits[1][r].t && hits[0][r].triangle == hits[1][r].triangle;
    }
    for (int i = UPDATE; i < STAGES; ++i)
        printf("%-7s %6.2f ms\n", stage_names[i], c->stage_ms[i] / FRAMES);
    printf("frame   %6.2f ms; planned anew %.2f ms\n", c->frames_ms / FRAMES, c->anew_ms * ANEW_EVERY / FRAMES);
    printf("%d frames of %d triangles, %u voxels in the last, %d of %d rays hit\n", FRAMES, TRIANGLES,
           (unsigned)info.leaf_count, found, RAYS);
    printf("the last tree and its hits: %s\n", same ? "the same as planned anew" : "not those of a new plan");
    write_film();
    return same;
}

int main(void)
{
    svo_message message = {""};
    cloth c = {.device = NULL};
    weave();
    const bool done = prepare(&c, &message) && run(&c);
    if (!done)
        fprintf(stderr, "%s\n", c.device != NULL ? svo_device_message(c.device) : message.text);
    svo_tree_destroy(&c.tree);
    svo_workspace_destroy(&c.workspace);
    svo_plan_destroy(&c.plan);
    svo_frontend_destroy(&c.frontend);
    if (c.queue != NULL)
        clReleaseCommandQueue(c.queue);
    svo_device_destroy(&c.device);
    return done ? 0 : 1;
}
