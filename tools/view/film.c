/* SPDX-License-Identifier: MIT */
/* Animations of scenes that a hand edits. */
#include "view/film.h"

#include <stdlib.h>

#include "view/edit.h"

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
