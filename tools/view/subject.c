/* SPDX-License-Identifier: MIT */
/* Trees and lights of the viewer, by the functions of svocl render, and what its brush makes of them. */
#include "view/subject.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/info_of.h"
#include "support/output.h"
#include "support/viewpoint.h"
#include "view/edit.h"
#include "view/history.h"

/* ---- opening ---- */

static void begin_camera(view_state *state, double scene_width)
{
    memcpy(state->camera.up, state->camera.at.up, sizeof state->camera.up);
    state->camera.home = state->camera.at;
    state->camera.mode = VIEW_ORBIT;
    state->camera.speed = (float)(scene_width * (double)state->settings.move_speed);
}

static int place_camera(subject *which, view_state *state)
{
    const viewpoint_subject shown = {.camera = which->lit.file.has_camera ? &which->lit.file.camera : NULL,
                                     .target = svo_tree_target(which->done.result.tree),
                                     .aspect = (float)state->width / (float)state->height};
    svo_tree_info info = SVO_TREE_INFO_INIT;
    (void)svo_tree_get_info(which->done.result.tree, &info);
    const int exit_code = viewpoint_place(which->running, &shown, &state->camera.at);
    begin_camera(state, info.edge);
    return exit_code;
}

/* The lights of --lights, or those of svocl render. */
static int take_lights(subject *which, view_state *state)
{
    default_lights *chosen = &which->lit.chosen;
    const lights_file *file = &which->lit.file;
    const bool from_file = which->running->options.lights_path != NULL;
    if (!from_file) {
        const int exit_code =
            default_lights_choose(which->running, &which->done, &state->camera.at, state->width, state->height, chosen);
        if (exit_code != PROGRAM_DONE) {
            return exit_code;
        }
        view_log(state, "%s", default_lights_describe(chosen).text);
    }
    const svo_light_source *sources = from_file ? file->sources : &chosen->source;
    const size_t count = from_file ? file->source_count : chosen->source_count;
    for (size_t i = 0; i < count; ++i) {
        if (!view_add_source(state, &sources[i])) {
            return program_fail(which->running, PROGRAM_FAILED, "out of memory for %zu lights", count);
        }
    }
    state->source = 0;
    (void)snprintf(state->lights_path, sizeof state->lights_path, "%s",
                   from_file ? which->running->options.lights_path : "");
    memcpy(state->own_paths[VIEW_LIGHTS], state->lights_path, sizeof state->lights_path);
    state->sky_map = file->sky.texels != NULL ? &file->sky : NULL;
    memcpy(state->sky, from_file ? file->sky.radiance : default_lights_sky, sizeof state->sky);
    return PROGRAM_DONE;
}

static int describe(subject *which, view_state *state)
{
    svo_tree_info info = SVO_TREE_INFO_INIT;
    if (svo_tree_get_info(which->done.result.tree, &info) != SVO_OK) {
        return program_fail(which->running, PROGRAM_FAILED, "the tree has no content");
    }
    which->level = info.depth;
    state->device = info_of_device(which->done.opened.device).name;
    state->level_min = which->done.source.mesh != NULL ? 1 : info.depth;
    state->level_max = info.depth;
    state->shown.level = info.depth;
    state->shown.range = (float)lighting_occlusion_range(&which->running->options, which->done.result.tree);
    state->has_triangles = (info.need & (uint32_t)SVO_NEED_RAYS) != 0 && info.coverage != (uint32_t)SVO_COVERAGE_THIN;
    return PROGRAM_DONE;
}

/* ---- scenes ---- */

/* The camera of the file, or one that frames all instances. */
static int place_scene_camera(subject *which, view_state *state, const scene_file *file)
{
    svo_scene *all = placed_scene(which->placed);
    const viewpoint_subject shown = {.camera = file->has_camera ? &file->camera : NULL,
                                     .target = svo_scene_target(all),
                                     .aspect = (float)state->width / (float)state->height};
    svo_scene_info info = SVO_SCENE_INFO_INIT;
    (void)svo_scene_get_info(all, &info);
    const int exit_code = viewpoint_place(which->running, &shown, &state->camera.at);
    begin_camera(state, fmax(fmax(info.high[0] - info.low[0], info.high[1] - info.low[1]), info.high[2] - info.low[2]));
    return exit_code;
}

/* The camera of svocl render --animate. */
static int place_film_camera(subject *which, view_state *state)
{
    svo_tree_info info = SVO_TREE_INFO_INIT;
    (void)svo_tree_get_info(film_tree(&which->film), &info);
    const int exit_code = animation_camera(&which->film.moving, placed_file(which->placed),
                                           (float)state->width / (float)state->height, &state->camera.at);
    begin_camera(state, info.edge);
    return exit_code;
}

/* Where something moves its first frame is shown. */
static int open_scene(program *running, view_state *state, subject *out)
{
    int exit_code = placed_open(running, running->options.input, &out->placed);
    if (exit_code == PROGRAM_DONE && !placed_describe(out->placed, state)) {
        exit_code = program_fail(running, PROGRAM_FAILED, "out of memory for the instances");
    }
    if (exit_code == PROGRAM_DONE && state->mover_count == 0 && running->options.frames != 0) {
        exit_code = program_fail(running, PROGRAM_WRONG_USAGE, "%s: nothing moves, so that --frames does not apply",
                                 running->options.input);
    }
    if (exit_code == PROGRAM_DONE && state->mover_count > 0) {
        view_choose_scene(state, false);
        exit_code = film_update(&out->film, out->placed, state);
    }
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    if (view_shows_film(state)) {
        view_log(state, "%llu frames: Space plays", (unsigned long long)state->film.frame_count);
        return place_film_camera(out, state);
    }
    return place_scene_camera(out, state, placed_file(out->placed));
}

/* ---- both ---- */

/* Nodes of no deeper level are looked at for the box of a tree. */
#define BOX_LEVEL_MAX 6u

/* The occupied part; without host arrays the grid. */
static void box_of_tree(const svo_tree *tree, view_state *state)
{
    svo_tree_info info = SVO_TREE_INFO_INIT;
    double low[3];
    double high[3];
    if (tree == NULL || svo_tree_get_info(tree, &info) != SVO_OK) {
        return;
    }
    for (int axis = 0; axis < 3; ++axis) {
        state->low[axis] = (float)info.origin[axis];
        state->high[axis] = (float)(info.origin[axis] + info.edge);
    }
    const uint32_t level = info.depth < BOX_LEVEL_MAX ? info.depth : BOX_LEVEL_MAX;
    const uint32_t begin = info.level_begin[level];
    for (uint32_t node = begin; node < info.level_begin[level + 1]; ++node) {
        if (svo_tree_node_box(tree, node, low, high) != SVO_OK) {
            return;
        }
        for (int axis = 0; axis < 3; ++axis) {
            const bool is_first = node == begin;
            state->low[axis] = is_first ? (float)low[axis] : fminf(state->low[axis], (float)low[axis]);
            state->high[axis] = is_first ? (float)high[axis] : fmaxf(state->high[axis], (float)high[axis]);
        }
    }
}

/* As kernels/rays/view.cl has it. */
static void tell_depth(const subject *which, view_state *state)
{
    svo_tree_info info = SVO_TREE_INFO_INIT;
    const svo_tree *tree = subject_tree(which, state);
    if (tree == NULL || svo_tree_get_info(tree, &info) != SVO_OK) {
        return;
    }
    double square = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double away = (double)state->camera.at.eye[axis] - (info.origin[axis] + 0.5 * info.edge);
        square += away * away;
    }
    const double reach = 0.87 * info.edge;
    state->depth_range[0] = (float)fmax(sqrt(square) - reach, 0);
    state->depth_range[1] = (float)(sqrt(square) + reach);
}

void subject_box(subject *which, view_state *state)
{
    tell_depth(which, state);
    const svo_scene *placed_now = state->is_scene ? placed_scene(which->placed) : NULL;
    const uint64_t changes =
        1 + 2 * ((uint64_t)which->changes + placed_changes(which->placed)) + (state->is_scene ? 1 : 0);
    if (which->boxed == changes) {
        return;
    }
    which->boxed = changes;
    svo_scene_info info = SVO_SCENE_INFO_INIT;
    if (placed_now == NULL) {
        box_of_tree(subject_tree(which, state), state);
    } else if (svo_scene_get_info(placed_now, &info) == SVO_OK) {
        for (int axis = 0; axis < 3; ++axis) {
            state->low[axis] = (float)info.low[axis];
            state->high[axis] = (float)info.high[axis];
        }
    }
}

/* The tree can be placed too. */
static int prepare_placing(subject *which, view_state *state)
{
    const bool is_mesh = which->done.source.mesh != NULL;
    which->placed = placed_of_input(which->running, is_mesh ? which->level : 0);
    if (which->placed == NULL) {
        return program_fail(which->running, PROGRAM_FAILED, "out of memory");
    }
    placed_use_tree(which->placed, which->done.opened.device, which->done.opened.queue, which->done.result.tree);
    (void)placed_describe(which->placed, state);
    return PROGRAM_DONE;
}

static int open_tree(program *running, view_state *state, subject *out)
{
    running->wants_normal_maps = true;
    int exit_code = lighting_open(running, &out->lit);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    out->lit.for_cones = true; /* a key changes to them */
    exit_code = lighting_tree(running, 1, &out->lit, &out->done);
    if (exit_code != PROGRAM_DONE) {
        lighting_close(&out->lit);
        return exit_code;
    }
    out->has_tree = true;
    out->brush.device = out->done.opened.device;
    out->brush.queue = out->done.opened.queue;
    exit_code = describe(out, state);
    exit_code = exit_code == PROGRAM_DONE ? place_camera(out, state) : exit_code;
    exit_code = exit_code == PROGRAM_DONE ? take_lights(out, state) : exit_code;
    return exit_code == PROGRAM_DONE ? prepare_placing(out, state) : exit_code;
}

int subject_open(program *running, view_state *state, subject *out)
{
    *out = (subject){.running = running,
                     .film = {.running = running},
                     .probes = {.running = running},
                     .brush = {.running = running}};
    const int exit_code =
        scene_file_is_input(running) ? open_scene(running, state, out) : open_tree(running, state, out);
    if (exit_code != PROGRAM_DONE) {
        subject_close(out);
    }
    return exit_code;
}

static void close_tree(subject *which)
{
    if (which->has_tree) {
        brushing_close(&which->brush);
        svo_light_destroy(&which->lit.light);
        job_release(&which->done);
        lighting_close(&which->lit);
        which->has_tree = false;
    }
}

void subject_close(subject *which)
{
    probing_close(&which->probes);
    film_close(&which->film);
    placed_close(&which->placed);
    close_tree(which);
}

/* ---- trees and lights ---- */

bool subject_picture_is_lit(view_picture picture)
{
    return picture >= VIEW_AO && picture <= VIEW_SPECULAR;
}

static void drop_light(subject *which, view_state *state)
{
    probing_drop(&which->probes, state);
    svo_light_destroy(&which->lit.light);
    which->is_lit = false;
}

static int build_level(subject *which)
{
    job *done = &which->done;
    program_begin_progress(which->running, 2);
    const int exit_code =
        job_build(which->running, lighting_need(&which->running->options, &which->lit, &done->source), done);
    progress_destroy(&which->running->progress);
    return exit_code;
}

/* Back to the level that is there. */
static void keep_level(subject *which, view_state *state, const build_result *kept)
{
    which->done.result = *kept;
    which->running->options.depth = which->level;
    state->shown.level = which->level;
    view_log(state, "canceled: level %u stays", which->level);
}

static void release_result(build_result *gone)
{
    svo_tree_destroy(&gone->tree);
    free(gone->buffers);
    *gone = (build_result){.tree = NULL};
}

/* The tree of another level, built anew: levels of a mesh nest, so it is what the deeper tree has there. The one before
   stays until then, for a build that is canceled; where memory does not allow that, it goes first. */
static int make_tree(subject *which, view_state *state)
{
    job *done = &which->done;
    build_result kept = done->result;
    done->result = (build_result){.tree = NULL};
    which->running->options.depth = state->shown.level;
    int exit_code = build_level(which);
    if (exit_code != PROGRAM_DONE && program_is_canceled(which->running)) {
        release_result(&done->result);
        keep_level(which, state, &kept);
        return PROGRAM_DONE;
    }
    brushing_close(&which->brush); /* it has drawn nothing */
    drop_light(which, state);
    state->selection.is_hit = false;
    release_result(&kept);
    exit_code = exit_code == PROGRAM_DONE ? exit_code : build_level(which);
    which->level = state->shown.level;
    ++which->changes;
    if (exit_code == PROGRAM_DONE) {
        placed_use_tree(which->placed, done->opened.device, done->opened.queue, done->result.tree);
    }
    return exit_code;
}

static bool light_is_current(const subject *which, const view_state *state)
{
    return which->is_lit && which->form == state->shown.form && which->photons == state->shown.photons &&
           which->lights_revision == state->revisions.lights;
}

/* A light of another form is a new one; other sources go into the one that is there. */
static int make_light(subject *which, view_state *state)
{
    const job *done = &which->done;
    const svo_light_options light_options = {.struct_size = sizeof light_options,
                                             .form = state->shown.form,
                                             .opacity = (svo_opacity)which->running->options.opacity,
                                             .one_side = (uint32_t)which->running->options.one_side};
    svo_light_setup setup = lighting_setup(&which->lit, done);
    setup.sources = state->sources;
    setup.source_count = state->source_count;
    lighting_set_photons(&which->running->options, &setup);
    setup.no_photons = !state->shown.photons;
    memcpy(setup.sky, state->sky, sizeof setup.sky);
    if (which->lit.light != NULL && which->form != state->shown.form) {
        probing_drop(&which->probes, state);
        svo_light_destroy(&which->lit.light);
    }
    program_begin_step(which->running, "lighting the tree");
    if ((which->lit.light == NULL &&
         svo_light_create(done->result.tree, &light_options, done->opened.queue, &which->lit.light) != SVO_OK) ||
        svo_light_set_sources(which->lit.light, &setup, done->opened.queue) != SVO_OK ||
        lighting_give_mesh(done, &which->lit) != SVO_OK) {
        return program_fail_library(which->running, svo_device_message(done->opened.device));
    }
    progress_destroy(&which->running->progress);
    which->is_lit = true;
    ++which->lightings;
    ++which->changes;
    which->form = state->shown.form;
    which->photons = state->shown.photons;
    which->lights_revision = state->revisions.lights;
    return PROGRAM_DONE;
}

/* ---- the brush ---- */

/* The tree with all strokes, in place of the one before. It is one of voxels: without mesh, normals and levels. */
static int take_strokes(subject *which, view_state *state)
{
    job *done = &which->done;
    svo_tree *tree = NULL;
    const int exit_code = brushing_commit(&which->brush, state, &tree);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    drop_light(which, state);
    release_result(&done->result);
    input_close(&done->source);
    input_close(&which->lit.mesh);
    done->source.name = which->running->options.input;
    done->result.tree = tree;
    state->selection.is_hit = false;
    state->has_triangles = false;
    state->level_min = state->level_max = state->shown.level = which->level = info_of_tree(tree).depth;
    ++which->changes;
    placed_use_tree(which->placed, done->opened.device, done->opened.queue, tree);
    return PROGRAM_DONE;
}

/* Views that need the tree get it anew. Where it cannot be made, the strokes stay, and are shown. */
static void leave_brush(subject *which, view_state *state)
{
    if (take_strokes(which, state) == PROGRAM_DONE) {
        return;
    }
    if (state->is_scene) {
        view_choose_scene(state, false);
    }
    view_choose_brush(state, true);
    view_notice(state, which->running->failure != NULL ? which->running->failure->text : "the tree was not written");
    if (which->running->failure != NULL) {
        which->running->failure->text[0] = '\0';
    }
}

/* The brush, or the tree that has what it drew. */
static int update_brush(subject *which, view_state *state)
{
    const bool shows_more = state->is_scene || state->shown.picture != VIEW_SHADED || view_shows_probes(state);
    if (state->brush.is_on && shows_more) {
        view_log(state, "brush: off; %s",
                 state->is_scene            ? "instances show the tree as it was drawn"
                 : view_shows_probes(state) ? "probes see the tree as it was drawn"
                                            : "this view shows the tree as it was drawn");
        state->brush.is_on = state->brush.is_down = false;
    }
    if (!state->brush.is_on && brushing_is_newer(&which->brush, state)) {
        leave_brush(which, state);
    }
    if (!state->brush.is_on) {
        return PROGRAM_DONE;
    }
    const int exit_code = brushing_update(&which->brush, which->done.result.tree, state);
    if (state->brush.position > 0) { /* other levels have no strokes */
        state->level_min = state->level_max = which->level;
    }
    return exit_code;
}

svo_target subject_target(const subject *which, const view_state *state)
{
    return state->brush.is_on && which->brush.mirror != NULL ? svo_edit_mirror_target(which->brush.mirror)
                                                             : svo_tree_target(subject_tree(which, state));
}

int subject_save_voxels(subject *which, view_state *state, const char *path)
{
    const int exit_code = brushing_is_newer(&which->brush, state) ? take_strokes(which, state) : PROGRAM_DONE;
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    const int written = tree_output_write(which->running, which->done.result.tree, NULL, path);
    if (written == PROGRAM_DONE) {
        placed_name_tree(which->placed, path);
    }
    return written;
}

/* ---- both ---- */

/* The tree and the light that are shown. */
static int update_tree(subject *which, view_state *state)
{
    const bool is_lit = subject_picture_is_lit(state->shown.picture) || (view_shows_probes(state) && !state->is_scene);
    int exit_code = which->level != state->shown.level ? make_tree(which, state) : PROGRAM_DONE;
    exit_code = exit_code == PROGRAM_DONE ? update_brush(which, state) : exit_code;
    return exit_code == PROGRAM_DONE && is_lit && !light_is_current(which, state) ? make_light(which, state)
                                                                                  : exit_code;
}

/* Probes refer to the scene, so they go before it changes. */
static int update_scene(subject *which, view_state *state)
{
    if (!placed_is_current(which->placed, state)) {
        probing_drop(&which->probes, state);
    }
    return placed_update(which->placed, state);
}

static int update_probes(subject *which, view_state *state)
{
    const probing_source source = {.tree = state->is_scene ? NULL : which->done.result.tree,
                                   .scene = state->is_scene ? placed_scene(which->placed) : NULL,
                                   .light = state->is_scene ? NULL : which->lit.light,
                                   .lightings = which->lightings,
                                   .device = placed_device(which->placed),
                                   .queue = placed_queue(which->placed)};
    return probing_update(&which->probes, &source, state);
}

/* Trees that move are gone with the next frame, so they have no probes. */
static int update_film(subject *which, view_state *state)
{
    if (view_shows_probes(state)) {
        view_refuse_probes(state);
    }
    if (which->probes.probes != NULL) {
        probing_drop(&which->probes, state);
    }
    which->probes.map.is_new = false;
    return film_update(&which->film, which->placed, state);
}

int subject_update(subject *which, view_state *state)
{
    int exit_code = view_shows_film(state) ? update_film(which, state) : PROGRAM_DONE;
    if (exit_code == PROGRAM_DONE && which->has_tree) {
        exit_code = update_tree(which, state);
    }
    if (exit_code == PROGRAM_DONE && state->is_scene) {
        exit_code = update_scene(which, state);
    }
    return exit_code == PROGRAM_DONE && !view_shows_film(state) ? update_probes(which, state) : exit_code;
}

/* ---- what it is made of ---- */

svo_tree *subject_tree(const subject *which, const view_state *state)
{
    return view_shows_film(state) ? film_tree(&which->film) : which->done.result.tree;
}

svo_device *subject_device(const subject *which)
{
    return placed_device(which->placed);
}

cl_command_queue subject_queue(const subject *which)
{
    return placed_queue(which->placed);
}
