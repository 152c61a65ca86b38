/* SPDX-License-Identifier: MIT */
/* Pins of rays, scenes of instances and paged trees. */
#include "pins.h"

#include <setjmp.h>
#include <stdarg.h>

#include <cmocka.h>

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/info_of.h"
#include "support/work_folder.h"
#include "svocl/io.h"
#include "svocl/paged.h"
#include "svocl/scene.h"

#define RAYS     3000
#define POINTS   300
#define WIDTH    48
#define HEIGHT   40
#define NEEDS    ((uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL | (uint32_t)SVO_NEED_RAYS)
#define PICTURES 12 /* at most, of a paged tree at a stop */

/* ---- rays ---- */

/* Leaves visited depend on how rays are grouped; what is hit does not. */
static void pin_hits(pins *all, const char *name, svo_tree *tree, const svo_ray *rays, uint32_t flags)
{
    svo_hit *hits = calloc(RAYS, sizeof *hits);
    assert_non_null(hits);
    pin_succeed(all, svo_trace_triangles(svo_tree_target(tree), svo_in_host(rays), svo_in_host(hits), RAYS, flags,
                                         &(svo_submit){.queue = all->opened.queue}));
    for (size_t i = 0; i < RAYS; ++i) {
        const bool is_hit = hits[i].triangle != SVO_NO_TRIANGLE;
        const uint32_t count = hits[i].count;
        if (flags == SVO_TRACE_ANY) { /* some hit's record */
            hits[i] = (svo_hit){.triangle = is_hit};
        }
        hits[i].count = flags == SVO_TRACE_COUNT ? count : 0;
    }
    pin_digest(all, name, hits, RAYS * sizeof *hits);
    free(hits);
}

static void pin_nearest(pins *all, svo_tree *tree, const svo_ray *rays)
{
    svo_query_point points[POINTS];
    svo_nearest found[POINTS];
    for (size_t i = 0; i < POINTS; ++i) {
        for (int axis = 0; axis < 3; ++axis) {
            points[i].position[axis] = rays[i].origin[axis] + 0.8F * rays[i].direction[axis];
        }
        points[i].max_distance = i % 4 == 3 ? 0.05F : INFINITY;
    }
    pin_succeed(all, svo_tree_nearest(tree, svo_in_host(points), svo_in_host(found), POINTS,
                                      &(svo_submit){.queue = all->opened.queue}));
    for (size_t i = 0; i < POINTS; ++i) {
        found[i].leaves = 0;
    }
    pin_digest(all, "nearest", found, sizeof found);
}

static void pin_voxel_hits(pins *all, const char *name, svo_tree *tree, const svo_ray *rays, float footprint)
{
    svo_voxel_hit *hits = calloc(RAYS, sizeof *hits);
    assert_non_null(hits);
    pin_succeed(all, svo_trace_voxels(svo_tree_target(tree), svo_in_host(rays), svo_in_host(hits), RAYS, footprint, 0,
                                      &(svo_submit){.queue = all->opened.queue}));
    pin_digest(all, name, hits, RAYS * sizeof *hits);
    free(hits);
}

static void pin_views(pins *all, svo_tree *tree)
{
    static const char *const names[] = {"shaded", "normal", "depth", "steps", "level", "triangles"};
    static uint8_t rgba[WIDTH * HEIGHT * 16];
    svo_render_options options = {.struct_size = sizeof options, .width = WIDTH, .height = HEIGHT};
    (void)svo_camera_fit(svo_tree_target(tree), (float)WIDTH / HEIGHT, &options.camera);
    for (int view = 0; view <= (int)SVO_VIEW_TRIANGLES; ++view) {
        options.view = (svo_render_view)view;
        pin_succeed(all, svo_render(svo_tree_target(tree), &options, svo_in_host(rgba),
                                    &(svo_submit){.queue = all->opened.queue}));
        pin_digest(all, names[view], rgba, (size_t)WIDTH * HEIGHT * 4);
    }
    options.view = SVO_VIEW_SHADED;
    options.output = (svo_picture_output){.format = SVO_PIXELS_LINEAR, .background = SVO_BACKGROUND_TRANSPARENT};
    options.clip[0] = 1;
    options.clip[1] = -0.5F;
    options.clip[3] = 0.1F;
    pin_succeed(
        all, svo_render(svo_tree_target(tree), &options, svo_in_host(rgba), &(svo_submit){.queue = all->opened.queue}));
    pin_digest(all, "linear, cut", rgba, (size_t)WIDTH * HEIGHT * 16);
}

void pin_rays(pins *all)
{
    static svo_ray rays[RAYS];
    const char *const qualities[] = {"best", "fast"};
    for (size_t s = 0; s < PIN_SCENES; ++s) {
        const svo_plan_options options = {.need = NEEDS};
        svo_tree *tree = pin_build(all, all->scenes[s].mesh, 5, &options);
        pin_make_rays(tree, s + 1, rays, RAYS);
        for (int quality = 0; quality < 2; ++quality) {
            pin_begin(all, "%s %s", all->scenes[s].name, qualities[quality]);
            pin_succeed(all, svo_tree_make_bvh(tree, (svo_bvh_quality)quality, all->opened.queue));
            pin_text(all, "BVH", "%" PRIu64 " bytes", info_of_tree(tree).ray_bytes);
            pin_hits(all, "closest", tree, rays, SVO_TRACE_CLOSEST);
            pin_hits(all, "any", tree, rays, SVO_TRACE_ANY);
            pin_hits(all, "count", tree, rays, SVO_TRACE_COUNT);
        }
        pin_nearest(all, tree, rays);
        pin_begin(all, "PoCL %s", all->scenes[s].name);
        pin_voxel_hits(all, "voxels", tree, rays, 0);
        pin_voxel_hits(all, "nodes of a footprint", tree, rays, 0.05F);
        pin_views(all, tree);
        svo_tree_destroy(&tree);
    }
}

/* ---- scenes of instances ---- */

enum { INSTANCES = 60, MOVED = 20, MOVED_FIRST = 7 };

/* Turned, sheared and scaled; never flat, as the diagonal is greater than the rest of a row. */
static void place(uint64_t *state, float transform[12])
{
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) {
            const float other = 0.6F * (pin_random(state) - 0.5F);
            transform[4 * row + column] = row == column ? 0.7F + other : other;
        }
        transform[4 * row + 3] = 8.0F * (pin_random(state) - 0.5F);
    }
}

static void make_scene_rays(svo_ray *rays)
{
    uint64_t state = 4;
    for (size_t i = 0; i < RAYS; ++i) {
        for (int axis = 0; axis < 3; ++axis) {
            rays[i].origin[axis] = 16.0F * (pin_random(&state) - 0.5F);
            rays[i].direction[axis] = 8.0F * (pin_random(&state) - 0.5F) - rays[i].origin[axis];
        }
        rays[i].t_min = 0;
        rays[i].t_max = i % 16 == 0 ? 0.5F : INFINITY;
    }
}

static void pin_placed(pins *all, const char *when, svo_scene *scene, const svo_ray *rays)
{
    static uint8_t rgba[WIDTH * HEIGHT * 4];
    const svo_scene_light lights[] = {{.direction = {1, 2, 0.5F}, .shadows = 1, .color = {0.9F, 0.8F, 0.7F}},
                                      {.direction = {-1, 0.5F, 2}, .color = {0.1F, 0.2F, 0.3F}}};
    svo_render_options options = {.struct_size = sizeof options, .width = WIDTH, .height = HEIGHT};
    svo_scene_hit *hits = calloc(RAYS, sizeof *hits);
    svo_scene_triangle_hit *triangles = calloc(RAYS, sizeof *triangles);
    assert_true(hits != NULL && triangles != NULL);
    pin_begin(all, "PoCL %s", when);
    pin_succeed(all, svo_trace_voxels(svo_scene_target(scene), svo_in_host(rays), svo_in_host(hits), RAYS, 0.01F,
                                      SVO_SCENE_CLOSEST, &(svo_submit){.queue = all->opened.queue}));
    pin_digest(all, "voxels", hits, RAYS * sizeof *hits);
    pin_succeed(all, svo_trace_triangles(svo_scene_target(scene), svo_in_host(rays), svo_in_host(triangles), RAYS,
                                         SVO_SCENE_CLOSEST, &(svo_submit){.queue = all->opened.queue}));
    pin_digest(all, "triangles", triangles, RAYS * sizeof *triangles);
    pin_succeed(all, svo_trace_triangles(svo_scene_target(scene), svo_in_host(rays), svo_in_host(triangles), RAYS,
                                         SVO_SCENE_ANY, &(svo_submit){.queue = all->opened.queue}));
    size_t met = 0;
    for (size_t i = 0; i < RAYS; ++i) {
        met += triangles[i].instance != SVO_NO_INSTANCE ? 1 : 0;
    }
    pin_text(all, "any triangle", "%zu of %d rays", met, RAYS);
    (void)svo_camera_fit(svo_scene_target(scene), (float)WIDTH / HEIGHT, &options.camera);
    pin_succeed(all, svo_render(svo_scene_target(scene), &options, svo_in_host(rgba),
                                &(svo_submit){.queue = all->opened.queue}));
    pin_digest(all, "picture", rgba, sizeof rgba);
    options.lights = lights;
    options.light_count = 2;
    options.occlusion_range = 0.3F;
    pin_succeed(all, svo_render(svo_scene_target(scene), &options, svo_in_host(rgba),
                                &(svo_submit){.queue = all->opened.queue}));
    pin_digest(all, "picture by lights", rgba, sizeof rgba);
    free(triangles);
    free(hits);
}

/* The hierarchy of CPUs over the instances: with at most 34 nodes. */
#define WIDE_BYTES (34 * 224)

static void pin_scene_info(pins *all, const char *when, const svo_scene *scene)
{
    svo_scene_info info = SVO_SCENE_INFO_INIT;
    svo_device_info device = SVO_DEVICE_INFO_INIT;
    pin_begin(all, "%s", when);
    pin_succeed(all, svo_device_get_info(all->opened.device, &device));
    pin_succeed(all, svo_scene_get_info(scene, &info));
    pin_text(all, "bytes", "trees %" PRIu64 " instances %" PRIu64 " hierarchy %" PRIu64, info.tree_bytes,
             info.instance_bytes, info.hierarchy_bytes - (device.path == SVO_PATH_CPU ? WIDE_BYTES : 0));
    pin_text(all, "box", "%a %a %a to %a %a %a", info.low[0], info.low[1], info.low[2], info.high[0], info.high[1],
             info.high[2]);
}

void pin_scene(pins *all)
{
    static svo_ray rays[RAYS];
    static float transforms[MOVED * 12];
    svo_tree *trees[PIN_SCENES];
    svo_instance instances[INSTANCES];
    svo_scene *scene = NULL;
    uint64_t state = 3;
    for (size_t s = 0; s < PIN_SCENES; ++s) {
        trees[s] = pin_build(all, all->scenes[s].mesh, 4, &(svo_plan_options){.need = NEEDS});
    }
    for (uint32_t i = 0; i < INSTANCES; ++i) {
        instances[i].tree = i % PIN_SCENES;
        place(&state, instances[i].transform);
    }
    const svo_scene_options options = {.struct_size = sizeof options,
                                       .trees = trees,
                                       .instances = instances,
                                       .tree_count = PIN_SCENES,
                                       .instance_count = INSTANCES,
                                       .need = NEEDS};
    pin_succeed(all, svo_scene_create(all->opened.device, &options, all->opened.queue, &scene));
    make_scene_rays(rays);
    pin_scene_info(all, "as made", scene);
    pin_placed(all, "as made", scene, rays);
    for (int i = 0; i < MOVED; ++i) {
        place(&state, transforms + (ptrdiff_t)12 * i);
    }
    pin_succeed(all, svo_scene_set_transforms(scene, MOVED_FIRST, MOVED, transforms, all->opened.queue));
    pin_scene_info(all, "moved", scene);
    pin_placed(all, "moved", scene, rays);
    pin_succeed(all, svo_scene_rebuild(scene, all->opened.queue));
    pin_placed(all, "made anew", scene, rays);
    svo_scene_destroy(&scene);
    for (size_t s = 0; s < PIN_SCENES; ++s) {
        svo_tree_destroy(&trees[s]);
    }
}

/* ---- paged trees ---- */

/* Pictures until one misses nothing, or nothing more finds room. */
static void refine(pins *all, svo_paged *paged, const svo_render_options *view, uint8_t *rgba)
{
    svo_paged_counts counts = SVO_PAGED_COUNTS_INIT;
    for (int i = 0; i < PICTURES; ++i) {
        pin_succeed(all, svo_paged_render(paged, view, rgba));
        pin_succeed(all, svo_paged_get_counts(paged, &counts));
        if (counts.missed_pages == 0) {
            return;
        }
        pin_succeed(all, svo_paged_update(paged));
        pin_succeed(all, svo_paged_get_counts(paged, &counts));
        if (counts.read_pages == 0) {
            return;
        }
    }
}

/* Flies in from where the camera frames the tree. share: of the file's bytes that there is room for. */
static void pin_flight(pins *all, const char *scene, const char *path, const svo_camera *camera, double share,
                       uint32_t page_levels)
{
    static uint8_t rgba[WIDTH * HEIGHT * 4];
    svo_paged_options options = SVO_PAGED_OPTIONS_INIT;
    svo_paged_info info = SVO_PAGED_INFO_INIT;
    svo_paged *paged = NULL;
    options.page_levels = page_levels;
    pin_succeed(all, svo_paged_open(all->opened.device, path, UINT64_MAX, &options, &paged));
    pin_succeed(all, svo_paged_get_info(paged, &info));
    svo_paged_close(&paged);
    pin_begin(all, "PoCL %s, room for %g, pages of %u levels", scene, share, (unsigned)page_levels);
    const uint64_t budget_bytes = (uint64_t)(share * (double)info.file_bytes);
    pin_succeed(all, svo_paged_open(all->opened.device, path, budget_bytes, &options, &paged));
    pin_succeed(all, svo_paged_get_info(paged, &info));
    pin_text(all, "opened",
             "top level %u pages %" PRIu64 " bytes %" PRIu64 " least %" PRIu64 " whole %" PRIu64 " read %" PRIu64,
             (unsigned)info.top_level, info.page_count, info.device_bytes, info.least_bytes, info.whole_bytes,
             info.open_read_bytes);
    for (int stop = 0; stop < 3; ++stop) {
        static const float stops[] = {1.0F, 0.6F, 0.3F};
        static const char *const names[] = {"far", "nearer", "near"};
        svo_render_options view = {
            .struct_size = sizeof view, .width = WIDTH, .height = HEIGHT, .camera = *camera, .view = SVO_VIEW_NORMAL};
        svo_paged_counts counts = SVO_PAGED_COUNTS_INIT;
        char name[32];
        for (int axis = 0; axis < 3; ++axis) {
            view.camera.eye[axis] = camera->target[axis] + stops[stop] * (camera->eye[axis] - camera->target[axis]);
        }
        refine(all, paged, &view, rgba);
        pin_digest(all, names[stop], rgba, sizeof rgba);
        pin_succeed(all, svo_paged_get_counts(paged, &counts));
        (void)snprintf(name, sizeof name, "%s, counts", names[stop]);
        pin_text(all, name,
                 "pictures %" PRIu64 " missed %" PRIu64 " held %" PRIu64 " read %" PRIu64 " bytes %" PRIu64
                 " evicted %" PRIu64,
                 counts.pictures, counts.missed_pages, counts.held_pages, counts.all_read_pages, counts.all_read_bytes,
                 counts.all_evicted_pages);
    }
    svo_paged_close(&paged);
}

void pin_paged(pins *all)
{
    for (size_t s = 0; s < PIN_SCENES; ++s) {
        const svo_plan_options options = {.need = (uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL};
        svo_tree *tree = pin_build(all, all->scenes[s].mesh, 7, &options);
        svo_message message = {""};
        svo_camera camera = {.vertical_fov = 0};
        char path[512];
        work_folder_remember("paged.svo");
        (void)snprintf(path, sizeof path, "%s", path_of("paged.svo"));
        if (svo_tree_save(tree, svo_to_path(path), NULL, &message) != SVO_OK) {
            fail_msg("%s", message.text);
        }
        (void)svo_camera_fit(svo_tree_target(tree), (float)WIDTH / HEIGHT, &camera);
        pin_flight(all, all->scenes[s].name, path, &camera, 1.2, 3);
        pin_flight(all, all->scenes[s].name, path, &camera, 0.4, 3);
        pin_flight(all, all->scenes[s].name, path, &camera, 0.25, 2);
        svo_tree_destroy(&tree);
    }
}
