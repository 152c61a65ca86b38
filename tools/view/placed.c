/* SPDX-License-Identifier: MIT */
/* Scenes on the device, made anew when trees or their number change, else moved; animations of scenes that a hand
   edits. */
#include "view/placed.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/animation.h"
#include "support/info_of.h"
#include "view/edit.h"

struct placed {
    program *running;
    char path[VIEW_PATH_BYTES]; /* of the file; "": none */
    scene_file file;
    scene_trees trees; /* of the file */
    svo_tree *tree; /* without one */
    svo_device *device;
    cl_command_queue queue;
    view_tree *list; /* for the state */
    size_t list_count;
    svo_scene *scene;
    svo_instance *instances; /* as the scene has them, instance_count */
    size_t instance_count;
    view_mover *movers; /* with them */
    size_t mover_count;
    unsigned revision; /* of the state's instances */
    unsigned changes;
};

/* ---- opening ---- */

static bool make_list(placed *which, size_t count)
{
    which->list = calloc(count, sizeof *which->list);
    which->list_count = which->list != NULL ? count : 0;
    return which->list != NULL;
}

/* A copy of a list, into a block that may be there; NULL without memory. */
static void *copy_list(void *block, const void *list, size_t count, size_t element_bytes)
{
    void *copy = realloc(block, (count + 1) * element_bytes);
    if (copy != NULL && count > 0) {
        memcpy(copy, list, count * element_bytes);
    }
    return copy;
}

/* Keeps what the scene now has, to compare with and to return to. */
static bool remember_instances(placed *which, const svo_instance *instances, size_t count)
{
    svo_instance *copy = copy_list(which->instances, instances, count, sizeof *copy);
    which->instances = copy != NULL ? copy : which->instances;
    which->instance_count = copy != NULL ? count : which->instance_count;
    return copy != NULL;
}

static bool remember(placed *which, const view_state *state)
{
    view_mover *movers = copy_list(which->movers, state->movers, state->mover_count, sizeof *movers);
    which->movers = movers != NULL ? movers : which->movers;
    which->mover_count = movers != NULL ? state->mover_count : which->mover_count;
    return movers != NULL && remember_instances(which, state->instances, state->instance_count);
}

/* The motions as the file has them. */
static bool list_movers(placed *which)
{
    const size_t count = which->file.motion_count;
    which->movers = malloc((count + 1) * sizeof *which->movers);
    which->mover_count = which->movers != NULL ? count : 0;
    for (size_t i = 0; i < which->mover_count; ++i) {
        const scene_motion *motion = &which->file.motions[i];
        which->movers[i] = (view_mover){motion->instance, motion, motion->keys[0].place};
    }
    return which->movers != NULL;
}

static int fail_without_memory(const placed *which, size_t count)
{
    return program_fail(which->running, PROGRAM_FAILED, "out of memory for %zu instances", count);
}

/* The first scene is as the file has it, so that a message can name the file's line. */
static int place_file(placed *which)
{
    const scene_file *file = &which->file;
    const svo_scene_options asked = scene_trees_place(&which->trees, file->instances, file->instance_count);
    progress_step(which->running->progress, "placing the trees");
    if (svo_scene_create(which->device, &asked, which->queue, &which->scene) != SVO_OK) {
        return scene_file_fail_library(file, svo_device_message(which->device));
    }
    return list_movers(which) && remember_instances(which, file->instances, file->instance_count)
               ? PROGRAM_DONE
               : fail_without_memory(which, file->instance_count);
}

static int open_file(placed *which)
{
    int exit_code = scene_file_open(which->running, which->path, &which->file);
    if (exit_code == PROGRAM_DONE) {
        program_begin_progress(which->running, SCENE_TREES_STEPS * (unsigned)which->file.tree_count + 1);
        exit_code = scene_trees_open(which->running, &which->file, &which->trees);
    }
    if (exit_code == PROGRAM_DONE && !make_list(which, which->file.tree_count)) {
        exit_code = program_fail(which->running, PROGRAM_FAILED, "out of memory for %zu trees", which->file.tree_count);
    }
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    for (size_t i = 0; i < which->list_count; ++i) {
        const scene_file_tree *from = &which->file.trees[i];
        view_tree *to = &which->list[i];
        (void)snprintf(to->name, sizeof to->name, "%s", from->name);
        (void)snprintf(to->path, sizeof to->path, "%s", from->path);
        to->depth = from->depth;
    }
    which->device = which->trees.opened.device;
    which->queue = which->trees.opened.queue;
    return place_file(which);
}

int placed_open(program *running, const char *path, placed **out)
{
    *out = NULL;
    if (strlen(path) >= VIEW_PATH_BYTES) {
        return program_fail(running, PROGRAM_FAILED, "the path of the scene is longer than %u bytes",
                            VIEW_PATH_BYTES - 1);
    }
    placed *made = calloc(1, sizeof *made);
    if (made == NULL) {
        return program_fail(running, PROGRAM_FAILED, "out of memory for a scene");
    }
    made->running = running;
    (void)snprintf(made->path, sizeof made->path, "%s", path);
    const int exit_code = open_file(made);
    if (exit_code != PROGRAM_DONE) {
        placed_close(&made);
    }
    *out = made;
    return exit_code;
}

/* What a path or scene:NAME calls the tree: "a/statue.svo" gives "statue", "scene:knot:2000" gives "knot". */
static void name_tree(const char *path, char name[VIEW_NAME_BYTES])
{
    const char *slash = strrchr(path, '/');
    const char *begin = strncmp(path, "scene:", 6) == 0 ? path + 6 : slash != NULL ? slash + 1 : path;
    (void)snprintf(name, VIEW_NAME_BYTES, "%.*s", (int)strcspn(begin, ".:"), begin);
    if (name[0] == '\0') {
        (void)snprintf(name, VIEW_NAME_BYTES, "tree");
    }
}

placed *placed_of_input(program *running, unsigned depth)
{
    const char *path = running->options.input;
    placed *made = calloc(1, sizeof *made);
    if (made == NULL || !make_list(made, 1)) {
        free(made);
        return NULL;
    }
    made->running = running;
    name_tree(path, made->list[0].name);
    (void)snprintf(made->list[0].path, sizeof made->list[0].path, "%s", path);
    made->list[0].depth = depth;
    /* What came through a pipe cannot be read again. */
    made->list_count = running->piped.name != NULL ? 0 : 1;
    return made;
}

void placed_name_tree(placed *which, const char *path)
{
    (void)snprintf(which->list[0].path, sizeof which->list[0].path, "%s", path);
    which->list[0].depth = 0;
}

void placed_close(placed **which)
{
    placed *gone = *which;
    if (gone == NULL) {
        return;
    }
    svo_scene_destroy(&gone->scene);
    scene_trees_close(&gone->trees);
    scene_file_close(&gone->file);
    free(gone->instances);
    free(gone->movers);
    free(gone->list);
    free(gone);
    *which = NULL;
}

/* ---- the state ---- */

static bool take_instances(const placed *which, view_state *state)
{
    svo_instance *instances = copy_list(NULL, which->instances, which->instance_count, sizeof *instances);
    view_mover *movers = copy_list(NULL, which->movers, which->mover_count, sizeof *movers);
    if (instances == NULL || movers == NULL) {
        free(instances);
        free(movers);
        return false;
    }
    free(state->instances);
    free(state->movers);
    state->instances = instances;
    state->instance_count = state->instance_capacity = which->instance_count;
    state->instance = 0;
    state->movers = movers;
    state->mover_count = state->mover_capacity = which->mover_count;
    return true;
}

bool placed_describe(placed *which, view_state *state)
{
    const scene_file *file = &which->file;
    if (which->path[0] != '\0' && !take_instances(which, state)) {
        return false;
    }
    state->trees = which->list;
    state->tree_count = which->list_count;
    (void)snprintf(state->scene_path, sizeof state->scene_path, "%s", which->path);
    (void)snprintf(state->own_paths[VIEW_SCENE], sizeof state->own_paths[0], "%s", which->path);
    if (which->path[0] == '\0') {
        return true;
    }
    memcpy(state->scene_lights, file->lights, sizeof file->lights);
    state->scene_light_count = file->light_count;
    state->scene_light = 0;
    state->occlusion_range = file->occlusion_range;
    state->scene_form = scene_file_form_name(file);
    state->device = info_of_device(which->device).name;
    state->film.frame_count = animation_frame_count(which->running);
    state->film.frame = 0;
    state->film.position = 0;
    state->film.is_playing = false;
    state->is_scene = true;
    state->shown.picture = VIEW_SHADED;
    state->shown.through = false;
    state->probes.map = VIEW_MAP_NORMAL;
    view_lights_changed(state);
    view_instances_changed(state);
    return true;
}

/* ---- scenes ---- */

void placed_use_tree(placed *which, svo_device *device, cl_command_queue queue, svo_tree *tree)
{
    svo_scene_destroy(&which->scene);
    which->device = device;
    which->queue = queue;
    which->tree = tree;
}

static svo_scene_options place(placed *which, const view_state *state)
{
    svo_scene_options asked = SVO_SCENE_OPTIONS_INIT;
    if (which->path[0] != '\0') {
        return scene_trees_place(&which->trees, state->instances, state->instance_count);
    }
    asked.trees = &which->tree;
    asked.tree_count = 1;
    asked.instances = state->instances;
    asked.instance_count = (uint32_t)state->instance_count;
    return asked;
}

/* Whether the instances differ by their matrices alone. */
static bool are_of_same_trees(const placed *which, const view_state *state)
{
    if (which->scene == NULL || which->instance_count != state->instance_count) {
        return false;
    }
    for (size_t i = 0; i < which->instance_count; ++i) {
        if (which->instances[i].tree != state->instances[i].tree) {
            return false;
        }
    }
    return true;
}

svo_status placed_plan(placed *which, const view_state *state, svo_scene_info *info)
{
    const svo_scene_options asked = place(which, state);
    return svo_scene_plan(which->device, &asked, info);
}

static svo_status make_scene(placed *which, const view_state *state)
{
    svo_scene *made = NULL;
    const svo_scene_options asked = place(which, state);
    const svo_status status = svo_scene_create(which->device, &asked, which->queue, &made);
    if (status == SVO_OK) {
        svo_scene_destroy(&which->scene);
        which->scene = made;
    }
    return status;
}

/* The hierarchy is made anew as well: that takes milliseconds, and instances may have moved far. */
static svo_status move_scene(placed *which, const view_state *state)
{
    const size_t count = state->instance_count;
    float *transforms = malloc(count * sizeof state->instances->transform);
    if (transforms == NULL) {
        return SVO_OUT_OF_HOST_MEMORY;
    }
    for (size_t i = 0; i < count; ++i) {
        memcpy(transforms + 12 * i, state->instances[i].transform, sizeof state->instances[i].transform);
    }
    const svo_status status = svo_scene_set_transforms(which->scene, 0, (uint32_t)count, transforms, which->queue);
    free(transforms);
    if (status != SVO_OK) {
        return status;
    }
    return svo_scene_rebuild(which->scene, which->queue);
}

/* Back to the instances that the scene has; they fit, since the state had them. */
static void undo(placed *which, view_state *state, svo_status status)
{
    const char *message = status == SVO_OUT_OF_HOST_MEMORY ? "out of memory" : svo_device_message(which->device);
    view_log(state, "not placed: %s", program_words(message));
    if (which->instance_count <= state->instance_capacity) {
        memcpy(state->instances, which->instances, which->instance_count * sizeof *state->instances);
        state->instance_count = which->instance_count;
        state->instance = state->instance < state->instance_count ? state->instance : state->instance_count - 1;
    }
    if (which->mover_count > 0 && which->mover_count <= state->mover_capacity) {
        memcpy(state->movers, which->movers, which->mover_count * sizeof *state->movers);
        state->mover_count = which->mover_count;
    }
    view_instances_changed(state);
    which->revision = state->revisions.instances;
}

bool placed_is_current(const placed *which, const view_state *state)
{
    return which->scene != NULL && which->revision == state->revisions.instances;
}

int placed_update(placed *which, view_state *state)
{
    if (placed_is_current(which, state)) {
        return PROGRAM_DONE;
    }
    const svo_status status = are_of_same_trees(which, state) ? move_scene(which, state) : make_scene(which, state);
    if (status == SVO_OK) {
        ++which->changes;
        which->revision = state->revisions.instances;
        return remember(which, state) ? PROGRAM_DONE : fail_without_memory(which, state->instance_count);
    }
    if (which->scene == NULL || status == SVO_CL_ERROR) {
        return program_fail_library(which->running, svo_device_message(which->device));
    }
    undo(which, state, status);
    return PROGRAM_DONE;
}

int placed_draw(placed *which, const view_state *state, unsigned width, unsigned height, cl_mem pixels, cl_event *drawn)
{
    svo_render_options asked = {.struct_size = sizeof asked,
                                .width = width,
                                .height = height,
                                .camera = state->camera.at,
                                .lights = state->scene_light_count > 0 ? state->scene_lights : NULL,
                                .light_count = (uint32_t)state->scene_light_count,
                                .occlusion_range = state->occlusion_range};
    view_clip_plane(state, asked.clip);
    return svo_render(svo_scene_target(which->scene), &asked, svo_in_buffer(pixels),
                      &(svo_submit){.queue = which->queue, .event = drawn}) == SVO_OK
               ? PROGRAM_DONE
               : program_fail_library(which->running, svo_device_message(which->device));
}

unsigned placed_changes(const placed *which)
{
    return which->changes;
}

svo_scene *placed_scene(const placed *which)
{
    return which->scene;
}

const svo_tree *placed_tree(const placed *which, uint32_t index)
{
    return which->trees.trees == NULL ? which->tree : index < which->list_count ? which->trees.trees[index] : NULL;
}

const scene_file *placed_file(const placed *which)
{
    return &which->file;
}

svo_device *placed_device(const placed *which)
{
    return which->device;
}

cl_command_queue placed_queue(const placed *which)
{
    return which->queue;
}

/* ---- motions ---- */

static void free_motions(film *which)
{
    for (size_t i = 0; i < which->motion_count; ++i) {
        free(which->motions[i].keys);
    }
    free(which->motions);
    which->motions = NULL;
    which->motion_count = 0;
}

/* The motion of an instance as it was edited. */
static bool copy_motion(const view_mover *mover, scene_motion *out)
{
    const size_t count = mover->motion->key_count;
    *out = (scene_motion){mover->instance, malloc(count * sizeof *out->keys), count};
    for (size_t i = 0; i < count && out->keys != NULL; ++i) {
        out->keys[i] = (scene_key){mover->motion->keys[i].time, view_mover_key(mover, i)};
    }
    return out->keys != NULL;
}

static bool copy_motions(film *which, const view_state *state)
{
    which->motions = calloc(state->mover_count, sizeof *which->motions);
    bool fits = which->motions != NULL;
    for (size_t i = 0; i < state->mover_count && fits; ++i) {
        fits = copy_motion(&state->movers[i], &which->motions[i]);
        ++which->motion_count;
    }
    return fits;
}

/* ---- opening ---- */

static void describe(const film *which, view_state *state)
{
    svo_tree_info info = SVO_TREE_INFO_INIT;
    (void)svo_tree_get_info(film_tree(which), &info);
    state->film.first_time = which->moving.first_time;
    state->film.last_time = which->moving.last_time;
    state->level_min = state->level_max = state->shown.level = info.depth;
    state->has_triangles = (info.need & (uint32_t)SVO_NEED_RAYS) != 0 && info.coverage != (uint32_t)SVO_COVERAGE_THIN;
}

static int open_film(film *which, const placed *from, const view_state *state)
{
    scene_file edited = *placed_file(from);
    if (!copy_motions(which, state)) {
        return program_fail(which->running, PROGRAM_FAILED, "out of memory for %zu motions", state->mover_count);
    }
    edited.instances = state->instances;
    edited.instance_count = state->instance_count;
    edited.motions = which->motions;
    edited.motion_count = which->motion_count;
    program_begin_progress(which->running, (unsigned)edited.tree_count);
    const int exit_code =
        animation_open(which->running, &edited, placed_device(from), placed_queue(from), &which->moving);
    progress_destroy(&which->running->progress);
    which->is_open = exit_code == PROGRAM_DONE;
    return exit_code;
}

void film_close(film *which)
{
    if (which->is_open) {
        animation_close(&which->moving);
    }
    free_motions(which);
    which->is_open = false;
}

/* ---- frames ---- */

/* is_first: the tree has no frame yet. */
static int move_to_frame(film *which, view_state *state, bool is_first)
{
    const svo_status status = animation_update(&which->moving, state->film.frame, NULL);
    if (status == SVO_CL_ERROR) {
        return program_fail_library(which->running, svo_device_message(which->moving.device));
    }
    if (status == SVO_OK) {
        which->frame = state->film.frame;
        state->film.time = animation_time(&which->moving, which->frame);
        state->selection.is_hit = false; /* what was picked may be elsewhere */
        ++state->revisions.film;
        return PROGRAM_DONE;
    }
    view_log(state, "frame %llu: %s", (unsigned long long)state->film.frame,
             program_words(svo_device_message(which->moving.device)));
    if (is_first) {
        film_close(which);
        view_choose_scene(state, true);
    } else {
        play_seek(state, which->frame);
    }
    return PROGRAM_DONE;
}

int film_update(film *which, const placed *from, view_state *state)
{
    const bool is_current = which->is_open && which->revision == state->revisions.instances;
    if (!is_current) {
        film_close(which);
        if (open_film(which, from, state) != PROGRAM_DONE) {
            film_close(which);
            view_log(state, "the motions are not shown");
            view_choose_scene(state, true);
            return PROGRAM_DONE;
        }
        which->revision = state->revisions.instances;
        describe(which, state);
    }
    return !is_current || which->frame != state->film.frame ? move_to_frame(which, state, !is_current) : PROGRAM_DONE;
}

svo_tree *film_tree(const film *which)
{
    return which->is_open ? animation_tree(&which->moving) : NULL;
}
