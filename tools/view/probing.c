/* SPDX-License-Identifier: MIT */
/* Probes on the device, by the functions of svocl render --through probes, and the map of one as a picture. */
#include "view/probing.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/probe_picture.h"

/* ---- the map of a probe ---- */

static void free_map(probe_map *map)
{
    free(map->texels);
    free(map->rgba);
    *map = (probe_map){.texels = NULL};
}

static bool make_room(probe_map *map, unsigned edge)
{
    const size_t count = (size_t)edge * edge;
    if (map->edge == edge) {
        return true;
    }
    free_map(map);
    map->texels = malloc(count * 2 * sizeof *map->texels);
    map->rgba = malloc(count * 4);
    map->edge = map->texels != NULL && map->rgba != NULL ? edge : 0;
    return map->edge != 0;
}

static cl_int read_texels(const probe_map *map, const svo_probes *probes, cl_command_queue queue, uint32_t probe)
{
    const size_t bytes = (size_t)map->edge * map->edge * 2 * sizeof *map->texels;
    return clEnqueueReadBuffer(queue, svo_probes_get_buffer(probes, SVO_PROBES_TEXELS), CL_TRUE, probe * bytes, bytes,
                               map->texels, 0, NULL, NULL);
}

/* What a ray along the texel would find. */
static svo_probe_hit hit_of(const svo_probe_info *info, const uint32_t texel[2])
{
    const uint32_t code = texel[0] & SVO_PROBE_NOTHING;
    svo_probe_hit hit = {.t = (float)svo_probe_distance(info, code),
                         .state = code == SVO_PROBE_NOTHING ? SVO_PROBE_MISS : SVO_PROBE_HIT,
                         .normal = texel[0] & ~SVO_PROBE_NOTHING};
    svo_probe_radiance(texel[1], hit.radiance);
    return hit;
}

/* Distances are white at the probe, and nearly black where the farthest surface is that it sees. */
static double farthest_of(const svo_probe_info *info, const probe_map *map)
{
    uint32_t code = 0;
    for (size_t i = 0; i < (size_t)map->edge * map->edge; ++i) {
        const uint32_t other = map->texels[2 * i] & SVO_PROBE_NOTHING;
        code = other != SVO_PROBE_NOTHING && other > code ? other : code;
    }
    return fmax(svo_probe_distance(info, code), (double)info->leaf_edge);
}

static void color_map(const svo_probe_info *info, probe_map *map)
{
    static const svo_render_view views[VIEW_MAPS] = {SVO_VIEW_SHADED, SVO_VIEW_NORMAL, SVO_VIEW_DEPTH};
    const probe_colors colors = {
        .view = views[map->kind], .farthest = farthest_of(info, map), .exposure = (double)map->exposure};
    for (size_t i = 0; i < (size_t)map->edge * map->edge; ++i) {
        const svo_probe_hit hit = hit_of(info, map->texels + 2 * i);
        probe_colors_pixel(&colors, &hit, map->rgba + 4 * i);
    }
}

/* Reads and colors the map of the chosen probe, where the state shows one and it is another than before. version:
   counts up when the probes change. Returns the exit code. */
static int update_map(probe_map *map, program *running, const svo_probes *probes, cl_command_queue queue,
                      unsigned version, view_state *state)
{
    view_probes *shown = &state->probes;
    const svo_probe_info *info = &shown->made;
    const float exposure = state->shown.exposure;
    const bool is_other = map->edge != info->resolution || map->version != version || map->probe != shown->chosen;
    const bool is_recolored = map->kind != shown->map || map->exposure < exposure || map->exposure > exposure;
    map->is_new = false;
    shown->texels = NULL;
    if (!shown->has_map || info->probe_count == 0) {
        return PROGRAM_DONE;
    }
    if (!make_room(map, info->resolution)) {
        return program_fail(running, PROGRAM_FAILED, "out of memory for a map of %u x %u texels", info->resolution,
                            info->resolution);
    }
    if (is_other && read_texels(map, probes, queue, shown->chosen) != CL_SUCCESS) {
        return program_fail(running, PROGRAM_FAILED, "the device does not give the map of a probe");
    }
    shown->texels = map->texels;
    map->probe = shown->chosen;
    map->version = version;
    map->kind = shown->map;
    map->exposure = exposure;
    map->is_new = is_other || is_recolored;
    if (map->is_new) {
        color_map(info, map);
    }
    return PROGRAM_DONE;
}

#define MIB_LOG2 20u

static int fail_device(const probing *which)
{
    return program_fail_library(which->running, svo_device_message(which->source.device));
}

static svo_probe_options options_of(const view_probe_grid *grid, const probing_source *source, unsigned cones)
{
    svo_probe_options asked = {.struct_size = sizeof asked,
                               .resolution = grid->resolution,
                               .field_size = grid->field_size,
                               .max_bytes = (uint64_t)grid->max_mib << MIB_LOG2,
                               .cones = cones,
                               .light = source->light,
                               .tree = source->tree,
                               .scene = source->tree == NULL ? source->scene : NULL};
    memcpy(asked.counts, grid->counts, sizeof asked.counts);
    return asked;
}

/* ---- plans ---- */

static svo_status plan(const probing_source *source, const view_probe_grid *grid, svo_probe_info *info)
{
    probing_source dark = *source;
    dark.light = NULL;
    const svo_probe_options asked = options_of(grid, &dark, 0);
    *info = (svo_probe_info)SVO_PROBE_INFO_INIT;
    return svo_probes_plan(&asked, info);
}

/* What the grid that is asked for would take. */
static void plan_asked(probing *which, view_state *state)
{
    view_probes *shown = &state->probes;
    which->planned = shown->asked;
    shown->refusal[0] = '\0';
    if (plan(&which->source, &shown->asked, &shown->planned) != SVO_OK) {
        shown->planned = (svo_probe_info)SVO_PROBE_INFO_INIT;
        (void)snprintf(shown->refusal, sizeof shown->refusal, "%s",
                       program_words(svo_device_message(which->source.device)));
    }
}

/* ---- probes ---- */

void probing_drop(probing *which, view_state *state)
{
    svo_probes_destroy(&which->probes);
    which->planned = (view_probe_grid){.max_mib = 0};
    state->probes.made = (svo_probe_info)SVO_PROBE_INFO_INIT;
    state->probes.places = NULL;
    state->probes.texels = NULL;
}

void probing_close(probing *which)
{
    svo_probes_destroy(&which->probes);
    free_map(&which->map);
    free(which->places);
    which->places = NULL;
}

/* Reads where the probes are. */
static int take_places(probing *which, view_state *state)
{
    svo_probe_info *made = &state->probes.made;
    *made = (svo_probe_info)SVO_PROBE_INFO_INIT;
    if (svo_probes_get_info(which->probes, made) != SVO_OK) {
        return fail_device(which);
    }
    svo_probe *places = realloc(which->places, made->probe_count * sizeof *places);
    if (places == NULL) {
        return program_fail(which->running, PROGRAM_FAILED, "out of memory for %u probes", made->probe_count);
    }
    which->places = places;
    if (clEnqueueReadBuffer(which->source.queue, svo_probes_get_buffer(which->probes, SVO_PROBES_PLACES), CL_TRUE, 0,
                            made->probe_count * sizeof *places, places, 0, NULL, NULL) != CL_SUCCESS) {
        return program_fail(which->running, PROGRAM_FAILED, "the device does not give the places of its probes");
    }
    state->probes.places = places;
    view_choose_probe(state, (int64_t)state->probes.chosen);
    view_log(state, "%u probes of %u x %u texels: %u moved, %u off", made->probe_count, made->resolution,
             made->resolution, made->moved, made->off);
    return PROGRAM_DONE;
}

/* Back to the probes that are there, or to none. */
static void refuse(probing *which, view_state *state)
{
    view_log(state, "probes: %s", program_words(svo_device_message(which->source.device)));
    if (which->probes != NULL) {
        state->shown.probes = which->grid;
    } else {
        view_hide_probes(state);
    }
}

/* A grid that does not fit is refused while the old one is still there. */
static int make(probing *which, view_state *state)
{
    const view_probe_grid *grid = &state->shown.probes;
    if (plan(&which->source, grid, &which->plan) != SVO_OK) {
        refuse(which, state);
        return PROGRAM_DONE;
    }
    const svo_probe_options asked = options_of(grid, &which->source, state->shown.cones);
    probing_drop(which, state);
    program_begin_step(which->running, "making probes");
    const svo_status status = svo_probes_create(&asked, which->source.queue, &which->probes);
    progress_destroy(&which->running->progress);
    if (status == SVO_CL_ERROR) {
        return fail_device(which);
    }
    if (status != SVO_OK) {
        refuse(which, state);
        return PROGRAM_DONE;
    }
    which->grid = *grid;
    which->cones = state->shown.cones;
    which->lightings = which->source.lightings;
    ++which->version;
    return take_places(which, state);
}

static int light(probing *which)
{
    which->lightings = which->source.lightings;
    ++which->version;
    program_begin_step(which->running, "lighting the probes");
    const svo_status status = svo_probes_relight(which->probes, which->source.queue);
    progress_destroy(&which->running->progress);
    return status == SVO_OK ? PROGRAM_DONE : fail_device(which);
}

int probing_update(probing *which, const probing_source *source, view_state *state)
{
    if (which->source.tree != source->tree || which->source.scene != source->scene ||
        which->source.light != source->light) {
        probing_drop(which, state);
    }
    which->source = *source;
    if (view_grid_differs(&which->planned, &state->probes.asked)) {
        plan_asked(which, state);
    }
    which->map.is_new = false;
    if (!view_shows_probes(state)) {
        return PROGRAM_DONE;
    }
    int exit_code = PROGRAM_DONE;
    if (which->probes == NULL || view_grid_differs(&which->grid, &state->shown.probes) ||
        which->cones != state->shown.cones) {
        exit_code = make(which, state);
    } else if (source->light != NULL && which->lightings != source->lightings) {
        exit_code = light(which);
    }
    return exit_code == PROGRAM_DONE
               ? update_map(&which->map, which->running, which->probes, which->source.queue, which->version, state)
               : exit_code;
}

/* ---- pictures ---- */

/* Colors the rays on the host, and takes from there what they found. */
static int color(const probing *which, view_state *state, unsigned width, unsigned height, uint8_t *rgba)
{
    static const svo_render_view views[] = {SVO_VIEW_SHADED, SVO_VIEW_NORMAL, SVO_VIEW_DEPTH, SVO_VIEW_STEPS};
    const probe_picture asked = {.camera = state->camera.at,
                                 .width = width,
                                 .height = height,
                                 .view = views[state->shown.picture],
                                 .exposure = (double)state->shown.exposure};
    probe_found found;
    const int exit_code = probe_picture_draw(which->running, &asked, which->probes, which->source.device,
                                             which->source.queue, rgba, &found);
    for (unsigned i = 0; i <= SVO_PROBE_UNKNOWN; ++i) {
        state->probes.found[i] = (float)probe_found_percent(&found, i);
    }
    return exit_code;
}

int probing_draw(probing *which, view_state *state, unsigned width, unsigned height, cl_mem pixels, cl_event *drawn)
{
    const size_t bytes = (size_t)width * height * 4;
    uint8_t *rgba = malloc(bytes);
    if (rgba == NULL) {
        return program_fail(which->running, PROGRAM_FAILED, "out of memory for %ux%u pixels", width, height);
    }
    int exit_code = color(which, state, width, height, rgba);
    if (exit_code == PROGRAM_DONE &&
        clEnqueueWriteBuffer(which->source.queue, pixels, CL_TRUE, 0, bytes, rgba, 0, NULL, drawn) != CL_SUCCESS) {
        exit_code = program_fail(which->running, PROGRAM_FAILED, "the device does not take the picture of its probes");
    }
    free(rgba);
    return exit_code;
}
