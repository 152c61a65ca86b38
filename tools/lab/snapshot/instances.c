/* SPDX-License-Identifier: MIT */
/* Places instances, traces rays through them, draws and moves them. */
#include "instances.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "digest.h"
#include "random.h"

#define INSTANCES      200
#define MOVED          70 /* of those, from the 30th on */
#define MOVED_FIRST    30
#define SCENE_RAYS     8000
#define PICTURE_WIDTH  160
#define PICTURE_HEIGHT 120
#define SPREAD         12.0f /* of the instances, world units; each is about one wide */

static const struct {
    const char *name;
    uint32_t flags;
} asked[] = {{"closest", SVO_SCENE_CLOSEST}, {"any", SVO_SCENE_ANY}, {"of every instance", SVO_SCENE_EVERY_INSTANCE}};

/* Turned, sheared and scaled; never flat, as the diagonal is greater than the rest of a row. */
static void place(uint64_t *state, float transform[12])
{
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) {
            const float other = 0.6f * (next_random(state) - 0.5f);
            transform[4 * row + column] = row == column ? 0.7f + other : other;
        }
        transform[4 * row + 3] = SPREAD * (next_random(state) - 0.5f);
    }
}

static svo_status make_scene(const opened *session, svo_tree *const *trees, uint32_t tree_count, svo_scene **out)
{
    svo_instance *instances = calloc(INSTANCES, sizeof *instances);
    uint64_t state = 3;
    if (instances == NULL) {
        return SVO_OUT_OF_HOST_MEMORY;
    }
    for (uint32_t i = 0; i < INSTANCES; ++i) {
        instances[i].tree = i % tree_count;
        place(&state, instances[i].transform);
    }
    const svo_scene_options options = {.struct_size = sizeof options,
                                       .trees = trees,
                                       .instances = instances,
                                       .tree_count = tree_count,
                                       .instance_count = INSTANCES,
                                       .need = (uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL |
                                               (uint32_t)SVO_NEED_RAYS};
    const svo_status status = svo_scene_create(session->device, &options, session->queue, out);
    free(instances);
    return status;
}

/* From around the instances to points among them. */
static void fill_rays(svo_ray *rays)
{
    uint64_t state = 4;
    for (size_t i = 0; i < SCENE_RAYS; ++i) {
        for (int axis = 0; axis < 3; ++axis) {
            rays[i].origin[axis] = 2 * SPREAD * (next_random(&state) - 0.5f);
            rays[i].direction[axis] = SPREAD * (next_random(&state) - 0.5f) - rays[i].origin[axis];
        }
        rays[i].t_max = i % 16 == 0 ? 0.5f : INFINITY;
    }
}

static void print_hits(const char *name, const char *part, svo_status status, const void *hits, size_t bytes)
{
    if (status == SVO_OK) {
        line_print_digest(name, part, hits, bytes);
    } else {
        line_print_status(name, part, status);
    }
}

static void trace(const char *name, const char *when, const opened *session, svo_scene *scene, const svo_ray *rays)
{
    char part[LINE_NAME_BYTES];
    svo_scene_hit *hits = calloc(SCENE_RAYS, sizeof *hits);
    svo_scene_triangle_hit *triangles = calloc(SCENE_RAYS, sizeof *triangles);
    for (size_t i = 0; i < sizeof asked / sizeof asked[0] && hits != NULL && triangles != NULL; ++i) {
        const uint32_t flags = asked[i].flags;
        svo_status status = svo_trace_voxels(svo_scene_target(scene), svo_in_host(rays), svo_in_host(hits), SCENE_RAYS,
                                             0.01f, flags, &(svo_submit){.queue = session->queue});
        (void)snprintf(part, sizeof part, "voxels %s, %s", asked[i].name, when);
        print_hits(name, part, status, hits, SCENE_RAYS * sizeof *hits);
        status = svo_trace_triangles(svo_scene_target(scene), svo_in_host(rays), svo_in_host(triangles), SCENE_RAYS,
                                     flags, &(svo_submit){.queue = session->queue});
        (void)snprintf(part, sizeof part, "triangles %s, %s", asked[i].name, when);
        print_hits(name, part, status, triangles, SCENE_RAYS * sizeof *triangles);
    }
    free(triangles);
    free(hits);
}

static void draw(const char *name, const char *when, const opened *session, svo_scene *scene)
{
    char part[LINE_NAME_BYTES];
    const size_t bytes = (size_t)PICTURE_WIDTH * PICTURE_HEIGHT * 4;
    svo_render_options options = {.struct_size = sizeof options, .width = PICTURE_WIDTH, .height = PICTURE_HEIGHT};
    uint8_t *rgba = malloc(bytes);
    (void)svo_camera_fit(svo_scene_target(scene), (float)PICTURE_WIDTH / PICTURE_HEIGHT, &options.camera);
    const svo_status status = rgba != NULL ? svo_render(svo_scene_target(scene), &options, svo_in_host(rgba),
                                                        &(svo_submit){.queue = session->queue})
                                           : SVO_OUT_OF_HOST_MEMORY;
    (void)snprintf(part, sizeof part, "picture, %s", when);
    print_hits(name, part, status, rgba, bytes);
    free(rgba);
}

static svo_status move(const opened *session, svo_scene *scene)
{
    float transforms[MOVED * 12];
    uint64_t state = 5;
    for (int i = 0; i < MOVED; ++i) {
        place(&state, transforms + (ptrdiff_t)12 * i);
    }
    return svo_scene_set_transforms(scene, MOVED_FIRST, MOVED, transforms, session->queue);
}

static void print_info(const char *name, const svo_scene *scene)
{
    svo_scene_info info = SVO_SCENE_INFO_INIT;
    line_text line = {.used = 0};
    (void)svo_scene_get_info(scene, &info);
    line_text_add(&line, "trees %" PRIu64 " instances %" PRIu64 " hierarchy %" PRIu64 " sort %" PRIu64, info.tree_bytes,
                  info.instance_bytes, info.hierarchy_bytes, info.sort_bytes);
    line_text_add(&line, " low %a %a %a high %a %a %a", info.low[0], info.low[1], info.low[2], info.high[0],
                  info.high[1], info.high[2]);
    line_print(name, "scene", line.text);
}

static void describe_scene(const char *name, const opened *session, svo_scene *scene, const svo_ray *rays)
{
    print_info(name, scene);
    trace(name, "as made", session, scene, rays);
    draw(name, "as made", session, scene);
    line_print_status(name, "moving", move(session, scene));
    trace(name, "moved", session, scene, rays);
    draw(name, "moved", session, scene);
    line_print_status(name, "hierarchy made anew", svo_scene_rebuild(scene, session->queue));
    trace(name, "made anew", session, scene, rays);
    draw(name, "made anew", session, scene);
}

void describe_instances(const char *name, const opened *session, svo_tree *const *trees, uint32_t tree_count)
{
    svo_scene *scene = NULL;
    svo_ray *rays = calloc(SCENE_RAYS, sizeof *rays);
    const svo_status status = rays != NULL ? make_scene(session, trees, tree_count, &scene) : SVO_OUT_OF_HOST_MEMORY;
    if (status == SVO_OK) {
        fill_rays(rays);
        describe_scene(name, session, scene, rays);
    } else {
        line_print_status(name, "scene", status);
    }
    svo_scene_destroy(&scene);
    free(rays);
}
