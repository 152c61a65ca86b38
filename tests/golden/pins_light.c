/* SPDX-License-Identifier: MIT */
/* Pins of light and probes. */
#include "pins.h"

#include <setjmp.h>
#include <stdarg.h>

#include <cmocka.h>

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "errors/published_probes.h"
#include "svocl/light.h"
#include "svocl/probes.h"

#define DEPTH  4
#define POINTS 64
#define RAYS   400
#define NEEDS                                                                                                       \
    ((uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL | (uint32_t)SVO_NEED_RAYS | (uint32_t)SVO_NEED_MATERIAL | \
     (uint32_t)SVO_NEED_FILL | (uint32_t)SVO_NEED_PROJECTED_AREA)

/* ---- light ---- */

/* A sun, a lamp and a spot; materials of which one reflects green alone, and in the second setup one emits. goes_on:
   that one shoots photons, too, and all of them bounce and honor alpha. */
static void shine_on(pins *all, const svo_tree *tree, svo_light *light, bool emits, bool goes_on)
{
    svo_tree_info info = SVO_TREE_INFO_INIT;
    svo_tree_get_info(tree, &info);
    const float edge = (float)info.edge;
    const float low[3] = {(float)info.origin[0], (float)info.origin[1], (float)info.origin[2]};
    const svo_light_source sources[3] = {
        {.kind = SVO_SOURCE_DIRECTIONAL, .direction = {-0.3F, -1.0F, -0.2F}, .value = {3.0F, 2.5F, 2.0F}},
        {.kind = SVO_SOURCE_POINT,
         .position = {low[0] + 0.5F * edge, low[1] + 0.6F * edge, low[2] + 0.45F * edge},
         .value = {1.0F, 1.5F, 2.0F}},
        {.kind = SVO_SOURCE_SPOT,
         .position = {low[0] + 0.1F * edge, low[1] + 0.9F * edge, low[2] + 1.5F * edge},
         .direction = {0.3F, -0.2F, -1.0F},
         .value = {0.5F, 0.0F, 2.0F},
         .inner_angle = 0.2F,
         .outer_angle = 0.5F},
    };
    const svo_finish finishes[3] = {{.specular = {0, 0.7F, 0}, .exponent = 12},
                                    {.specular = {0, emits ? 0.25F : 0, 0}, .exponent = 3},
                                    {.emission = {emits ? 4.0F : 0, emits ? 1.0F : 0, emits ? 0.25F : 0}}};
    svo_light_setup setup = SVO_LIGHT_SETUP_INIT;
    setup.sources = sources;
    setup.source_count = 3;
    setup.finishes = finishes;
    setup.finish_count = 3;
    setup.sky[2] = 0.125F;
    setup.view_resolution = 48;
    setup.diagnose = emits ? 1 : 0;
    setup.updatable = emits ? 0 : 1;
    setup.emission_photons = goes_on ? 10000 : 0;
    setup.bounces = goes_on ? 4 : 0;
    setup.photon_alpha = goes_on ? 1 : 0;
    pin_succeed(all, svo_light_set_sources(light, &setup, all->opened.queue));
}

static void shine(pins *all, const svo_tree *tree, svo_light *light, bool emits)
{
    shine_on(all, tree, light, emits, false);
}

static void pin_light_hash(pins *all, const char *name, const svo_light *light)
{
    svo_light_info info = SVO_LIGHT_INFO_INIT;
    char hash[SVO_HASH_TEXT_BYTES];
    char counts[64];
    pin_succeed(all, svo_light_hash(light, all->opened.queue, hash));
    svo_light_get_info(light, &info);
    pin_text(all, name, "%s bytes %" PRIu64 " kept %" PRIu64 " lit nodes %" PRIu64, hash, info.total_bytes,
             info.kept_bytes, info.lit_nodes);
    (void)snprintf(counts, sizeof counts, "%s, photons", name);
    pin_text(all, counts,
             "%" PRIu64 " hit %" PRIu64 " traced %" PRIu64 " leaves %" PRIu64 " missed %" PRIu64
             " flux %a %a %a lost %a",
             info.photons, info.photon_hits, info.traced_photons, info.lit_leaves, info.missed_leaves, info.flux[0],
             info.flux[1], info.flux[2], info.lost_flux);
}

static void pin_gathered(pins *all, const svo_tree *tree, svo_light *light)
{
    static const char *const names[] = {"openness", "red", "green", "blue", "specular red", "specular green"};
    svo_gather_point points[POINTS];
    svo_gather_result results[POINTS];
    svo_ray rays[POINTS];
    svo_gather_options options = SVO_GATHER_OPTIONS_INIT;
    options.method = SVO_GATHER_CONES;
    pin_make_rays(tree, 21, rays, POINTS);
    for (size_t i = 0; i < POINTS; ++i) {
        points[i] = (svo_gather_point){.exponent = 20};
        for (int axis = 0; axis < 3; ++axis) {
            points[i].position[axis] = rays[i].origin[axis] + 0.8F * rays[i].direction[axis];
            points[i].normal[axis] = -rays[i].direction[axis];
            points[i].reflected[axis] = axis == 1 ? 1.0F : -rays[i].direction[axis];
        }
    }
    options.falloff = 0.5F;
    pin_succeed(all, svo_gather(light, svo_in_host(points), svo_in_host(results), POINTS, &options,
                                &(svo_submit){.queue = all->opened.queue}));
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        pin_mean(all, names[i], (const float *)&results[0] + i, POINTS, sizeof results[0]);
    }
}

static void pin_pictures(pins *all, svo_light *light)
{
    static const struct {
        svo_render_view view;
        const char *name;
    } views[] = {{SVO_VIEW_SHADED, "full"},
                 {SVO_VIEW_AO, "ao"},
                 {SVO_VIEW_DIRECT, "direct"},
                 {SVO_VIEW_INDIRECT, "indirect"},
                 {SVO_VIEW_SPECULAR, "specular"}};
    enum { WIDTH = 24, HEIGHT = 16 };
    static float pixels[WIDTH * HEIGHT * 4];
    const svo_gather_options gather = {.struct_size = sizeof gather, .cones = 5};
    svo_render_options picture = SVO_RENDER_OPTIONS_INIT;
    picture.width = WIDTH;
    picture.height = HEIGHT;
    picture.output.format = SVO_PIXELS_LINEAR;
    picture.gather = &gather;
    (void)svo_camera_fit(svo_light_target(light), (float)WIDTH / HEIGHT, &picture.camera);
    for (size_t i = 0; i < sizeof views / sizeof views[0]; ++i) {
        char name[32];
        picture.view = views[i].view;
        pin_succeed(all, svo_render(svo_light_target(light), &picture, svo_in_host(pixels),
                                    &(svo_submit){.queue = all->opened.queue}));
        for (size_t channel = 0; channel < 3; channel += 2) {
            (void)snprintf(name, sizeof name, "picture %s, %s", views[i].name, channel == 0 ? "red" : "blue");
            pin_mean(all, name, pixels + channel, (size_t)WIDTH * HEIGHT, 4 * sizeof *pixels);
        }
    }
}

/* Where a vertex is. */
static double coordinate(const svo_mesh *mesh, size_t corner, int axis)
{
    const size_t at = 3 * (size_t)(mesh->indices != NULL ? mesh->indices[corner] : corner) + (size_t)axis;
    return mesh->positions != NULL ? (double)mesh->positions[at] : mesh->positions_double[at];
}

/* The bounds of the triangles from one on. */
static svo_box bound_from(const svo_mesh *mesh, size_t first)
{
    svo_box box = {{0, 0, 0}, {0, 0, 0}};
    for (int axis = 0; axis < 3; ++axis) {
        box.low[axis] = box.high[axis] = coordinate(mesh, 3 * first, axis);
        for (size_t corner = 3 * first; corner < 3 * mesh->triangle_count; ++corner) {
            box.low[axis] = fmin(box.low[axis], coordinate(mesh, corner, axis));
            box.high[axis] = fmax(box.high[axis], coordinate(mesh, corner, axis));
        }
    }
    return box;
}

/* A grid around the mesh, which stays when triangles go. */
static svo_plan_options grid_around(const svo_mesh *mesh)
{
    const svo_box box = bound_from(mesh, 0);
    svo_plan_options options = {.need = NEEDS};
    for (int axis = 0; axis < 3; ++axis) {
        options.edge = fmax(options.edge, 1.0625 * (box.high[axis] - box.low[axis]));
        options.origin[axis] = box.low[axis] - 0.03125 * (box.high[axis] - box.low[axis]);
    }
    return options;
}

/* The light of the tree without the last triangles, which destroys it. */
static void pin_updated(pins *all, const svo_mesh *mesh, svo_light *light)
{
    const svo_plan_options options = grid_around(mesh);
    svo_mesh fewer = *mesh;
    fewer.triangle_count -= mesh->triangle_count / 12;
    const svo_box gone = bound_from(mesh, fewer.triangle_count);
    svo_tree *after = pin_build(all, &fewer, DEPTH, &options);
    pin_succeed(all, svo_light_update(light, after, &gone, 1, all->opened.queue));
    pin_light_hash(all, "updated", light);
    svo_light_destroy(&light);
    svo_tree_destroy(&after);
}

static void pin_light_of(pins *all, const pinned_scene *scene, svo_tree *tree, svo_light_form form, svo_opacity opacity)
{
    svo_light_options options = SVO_LIGHT_OPTIONS_INIT;
    svo_light *light = NULL;
    const char *how = opacity == SVO_OPACITY_AREA ? "by areas" : "full";
    options.form = form;
    options.opacity = opacity;
    pin_begin(all, "%s %s %s", scene->name, svo_name(SVO_NAME_LIGHT_FORM, form), how);
    pin_succeed(all, svo_light_create(tree, &options, all->opened.queue, &light));
    pin_light_hash(all, "dark", light);
    shine(all, tree, light, true);
    pin_light_hash(all, "emitting", light);
    if (opacity == SVO_OPACITY_AREA) {
        pin_begin(all, "PoCL %s %s %s", scene->name, svo_name(SVO_NAME_LIGHT_FORM, form), how);
        pin_gathered(all, tree, light);
        pin_pictures(all, light);
        pin_begin(all, "%s %s %s", scene->name, svo_name(SVO_NAME_LIGHT_FORM, form), how);
    }
    shine_on(all, tree, light, true, true);
    pin_light_hash(all, "going on", light);
    shine(all, tree, light, false);
    pin_light_hash(all, "lit", light);
    pin_updated(all, scene->mesh, light);
}

/* Of closed meshes the front alone is opaque. */
static void pin_one_side(pins *all, const pinned_scene *scene, svo_tree *tree)
{
    const svo_light_options options = {.struct_size = sizeof options, .one_side = 1};
    svo_light *light = NULL;
    pin_begin(all, "%s faces, one side", scene->name);
    pin_succeed(all, svo_light_create(tree, &options, all->opened.queue, &light));
    shine(all, tree, light, true);
    pin_light_hash(all, "emitting", light);
    svo_light_destroy(&light);
}

void pin_light(pins *all)
{
    for (size_t s = 0; s < PIN_SCENES; ++s) {
        const svo_plan_options options = grid_around(all->scenes[s].mesh);
        svo_tree *tree = pin_build(all, all->scenes[s].mesh, DEPTH, &options);
        for (int form = 0; form < SVO_LIGHT_FORM_COUNT; ++form) {
            pin_light_of(all, &all->scenes[s], tree, (svo_light_form)form, SVO_OPACITY_AREA);
        }
        pin_light_of(all, &all->scenes[s], tree, SVO_LIGHT_FACES, SVO_OPACITY_FULL);
        pin_one_side(all, &all->scenes[s], tree);
        svo_tree_destroy(&tree);
    }
}

/* ---- probes ---- */

static void pin_probe_info(pins *all, const svo_probes *probes)
{
    svo_probe_info info = SVO_PROBE_INFO_INIT;
    svo_probes_get_info(probes, &info);
    pin_text(all, "counts", "moved %u off %u rays %" PRIu64 " for places %" PRIu64 " bytes %" PRIu64,
             (unsigned)info.moved, (unsigned)info.off, info.rays, info.place_rays, info.total_bytes);
    pin_text(all, "grid", "start %a %a %a step %a %a %a leaf %a farthest %a", (double)info.start[0],
             (double)info.start[1], (double)info.start[2], (double)info.step[0], (double)info.step[1],
             (double)info.step[2], (double)info.leaf_edge, (double)info.farthest);
}

/* As svo_probes_trace chooses probes, or by the eight of the laboratory. */
static void pin_probe_rays(pins *all, const svo_tree *tree, svo_probes *probes, bool by_eight)
{
    static svo_ray rays[RAYS];
    static svo_probe_hit hits[RAYS];
    size_t states[3] = {0};
    pin_make_rays(tree, 33, rays, RAYS);
    for (size_t i = 0; i < RAYS; ++i) { /* from inside */
        for (int axis = 0; axis < 3; ++axis) {
            rays[i].origin[axis] += 0.6F * rays[i].direction[axis];
        }
    }
    if (by_eight) {
        published_probes made;
        assert_true(published_probes_make(all->opened.device, probes, all->opened.queue, &made));
        assert_true(published_probes_trace(&made, rays, hits, RAYS));
        published_probes_free(&made);
    } else {
        pin_succeed(all, svo_probes_trace(probes, svo_in_host(rays), svo_in_host(hits), RAYS, NULL,
                                          &(svo_submit){.queue = all->opened.queue}));
    }
    for (size_t i = 0; i < RAYS; ++i) {
        states[hits[i].state < 3 ? hits[i].state : 2] += 1;
        hits[i].radiance[0] = hits[i].radiance[1] = hits[i].radiance[2] = 0;
    }
    pin_text(all, by_eight ? "rays by eight" : "rays by field", "%zu miss, %zu hit, %zu unknown", states[0], states[1],
             states[2]);
    pin_digest(all, by_eight ? "hits by eight" : "hits by field", hits, sizeof hits);
}

static void pin_irradiance(pins *all, const svo_tree *tree, svo_probes *probes)
{
    svo_ray rays[POINTS];
    svo_gather_point points[POINTS];
    svo_probe_irradiance results[POINTS];
    pin_make_rays(tree, 34, rays, POINTS);
    for (size_t i = 0; i < POINTS; ++i) {
        points[i] = (svo_gather_point){.exponent = 0};
        for (int axis = 0; axis < 3; ++axis) {
            points[i].position[axis] = rays[i].origin[axis] + 0.7F * rays[i].direction[axis];
            points[i].normal[axis] = -rays[i].direction[axis];
        }
    }
    pin_succeed(all, svo_probes_irradiance(probes, svo_in_host(points), svo_in_host(results), POINTS,
                                           &(svo_submit){.queue = all->opened.queue}));
    pin_mean(all, "irradiance, red", &results[0].irradiance[0], POINTS, sizeof results[0]);
    pin_mean(all, "irradiance, blue", &results[0].irradiance[2], POINTS, sizeof results[0]);
    pin_mean(all, "weight", &results[0].weight, POINTS, sizeof results[0]);
}

/* The mean radiance of the texels. */
static void pin_radiance(pins *all, const char *name, const svo_probes *probes, svo_probes_buffer buffer)
{
    cl_mem texels = svo_probes_get_buffer(probes, buffer);
    size_t byte_count = 0;
    assert_int_equal(clGetMemObjectInfo(texels, CL_MEM_SIZE, sizeof byte_count, &byte_count, NULL), CL_SUCCESS);
    const size_t step = buffer == SVO_PROBES_TEXELS ? 2 : 1;
    const size_t count = byte_count / sizeof(uint32_t) / step;
    uint32_t *words = malloc(byte_count);
    float *radiance = malloc(count * 3 * sizeof *radiance);
    assert_true(words != NULL && radiance != NULL);
    assert_int_equal(clEnqueueReadBuffer(all->opened.queue, texels, CL_TRUE, 0, byte_count, words, 0, NULL, NULL),
                     CL_SUCCESS);
    for (size_t i = 0; i < count; ++i) {
        svo_probe_radiance(words[i * step + step - 1], radiance + 3 * i);
    }
    pin_mean(all, name, radiance, 3 * count, sizeof *radiance);
    free(radiance);
    free(words);
}

void pin_probes(pins *all)
{
    for (size_t s = 0; s < PIN_SCENES; ++s) {
        const svo_light_options lit = {.struct_size = sizeof lit, .form = SVO_LIGHT_VOXELS};
        svo_probe_options options = {.struct_size = sizeof options, .counts = {3, 2, 2}, .resolution = 64};
        svo_tree *tree = pin_build(all, all->scenes[s].mesh, DEPTH, &(svo_plan_options){.need = NEEDS});
        svo_light *light = NULL;
        svo_probes *probes = NULL;
        char hash[SVO_HASH_TEXT_BYTES];
        options.field_size = 16;
        options.tree = tree;
        pin_begin(all, "%s", all->scenes[s].name);
        pin_succeed(all, svo_probes_create(&options, all->opened.queue, &probes));
        pin_succeed(all, svo_probes_hash(probes, all->opened.queue, hash));
        pin_text(all, "hash", "%s", hash);
        pin_probe_info(all, probes);
        for (int i = 0; i <= (int)SVO_PROBES_FIELD; ++i) {
            pin_buffer(all, svo_name(SVO_NAME_PROBES_BUFFER, (svo_probes_buffer)i),
                       svo_probes_get_buffer(probes, (svo_probes_buffer)i));
        }
        pin_begin(all, "PoCL %s", all->scenes[s].name);
        pin_probe_rays(all, tree, probes, false);
        pin_probe_rays(all, tree, probes, true);
        svo_probes_destroy(&probes);
        pin_succeed(all, svo_light_create(tree, &lit, all->opened.queue, &light));
        shine(all, tree, light, true);
        options.light = light;
        options.diffuse = 1;
        options.cones = 5;
        options.keep_places = 1;
        pin_succeed(all, svo_probes_create(&options, all->opened.queue, &probes));
        pin_radiance(all, "radiance", probes, SVO_PROBES_TEXELS);
        pin_radiance(all, "irradiance", probes, SVO_PROBES_IRRADIANCE);
        pin_irradiance(all, tree, probes);
        svo_probes_destroy(&probes);
        svo_light_destroy(&light);
        svo_tree_destroy(&tree);
    }
}
