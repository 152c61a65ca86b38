/* SPDX-License-Identifier: MIT */
/* Coarse and refined pictures. */
#include "view/drawing.h"

void drawing_end(drawing *which)
{
    pixel_buffer_drop(&which->pixels);
    *which = (drawing){.width = 0};
}

static bool differs(float a, float b)
{
    return a < b || a > b;
}

static bool camera_differs(const svo_camera *had, const svo_camera *now)
{
    bool is_different = differs(had->vertical_fov, now->vertical_fov);
    for (int axis = 0; axis < 3; ++axis) {
        is_different = is_different || differs(had->eye[axis], now->eye[axis]) ||
                       differs(had->target[axis], now->target[axis]) || differs(had->up[axis], now->up[axis]);
    }
    return is_different;
}

static bool shown_differs(const view_shown *had, const view_shown *now)
{
    return had->picture != now->picture || had->level != now->level || had->gi != now->gi ||
           had->photons != now->photons || had->form != now->form || had->cones != now->cones ||
           differs(had->exposure, now->exposure) || differs(had->range, now->range) ||
           differs(had->falloff, now->falloff) || had->through != now->through ||
           (now->through && (had->choice != now->choice || view_grid_differs(&had->probes, &now->probes)));
}

static bool clip_differs(const view_clip *had, const view_clip *now)
{
    return had->is_on != now->is_on ||
           (now->is_on && (differs(had->offset, now->offset) || differs(had->normal[0], now->normal[0]) ||
                           differs(had->normal[1], now->normal[1]) || differs(had->normal[2], now->normal[2])));
}

/* Whether the last picture shows something else than the state does. */
static bool is_outdated(const drawing *which, const view_state *state)
{
    return which->width == 0 || which->window_width != state->width || which->window_height != state->height ||
           shown_differs(&which->shown, &state->shown) || clip_differs(&which->shown.clip, &state->shown.clip) ||
           which->is_scene != state->is_scene || which->revisions.lights != state->revisions.lights ||
           which->revisions.instances != state->revisions.instances || which->revisions.film != state->revisions.film ||
           camera_differs(&which->camera, &state->camera.at);
}

/* The coarseness whose picture is expected to take no longer than the goal. */
static unsigned coarse_for(const drawing *which, const view_state *state)
{
    if (state->settings.coarse != 0) {
        return state->settings.coarse;
    }
    const double pixel_ms = which->pixel_ms[state->shown.picture][state->shown.through];
    const double pixels = (double)state->width * (double)state->height;
    unsigned coarse = pixel_ms > 0 ? 1 : VIEW_COARSE_MAX;
    while (coarse < VIEW_COARSE_MAX && pixel_ms * pixels / (coarse * coarse) > (double)state->settings.goal_ms) {
        coarse *= 2;
    }
    return coarse;
}

/* Rays from the camera through a pixel: both shaded pictures and those of light have two by two. */
static unsigned rays_of_pixel(const view_shown *shown)
{
    return !shown->through && (shown->picture == VIEW_SHADED || subject_picture_is_lit(shown->picture)) ? 4 : 1;
}

static void remember(drawing *which, const view_state *state)
{
    which->shown = state->shown;
    which->is_scene = state->is_scene;
    which->revisions = state->revisions;
    which->camera = state->camera.at;
    which->window_width = state->width;
    which->window_height = state->height;
}

/* Rows of a band that is expected to take no longer than the goal. */
static unsigned band_rows(const drawing *which, const view_state *state)
{
    const double row_ms = which->pixel_ms[state->shown.picture][state->shown.through] * (double)which->width;
    const double rows = row_ms > 0 ? (double)state->settings.goal_ms / row_ms : SVO_LIGHT_BAND_ROWS;
    const unsigned below = which->height - which->rows_done;
    const unsigned bands =
        rows < (double)below ? (unsigned)rows / SVO_LIGHT_BAND_ROWS : below / SVO_LIGHT_BAND_ROWS + 1;
    const unsigned count = SVO_LIGHT_BAND_ROWS * (bands > 0 ? bands : 1);
    return count < below ? count : below;
}

/* Gives the rows to OpenGL, which reads the buffer up to their end. */
static int enqueue_rows(drawing *which, subject *shown, view_state *state, const picture_part *part)
{
    const size_t row_bytes = (size_t)part->width * 4;
    const size_t window_bytes = (size_t)state->width * state->height * 4;
    cl_event drawn = NULL;
    int exit_code =
        pixel_buffer_begin(&which->pixels, subject_device(shown), subject_queue(shown), window_bytes, state);
    if (exit_code == PROGRAM_DONE) {
        exit_code = subject_draw(shown, state, part, which->pixels.info.memory, &drawn);
    }
    return exit_code == PROGRAM_DONE
               ? pixel_buffer_finish(&which->pixels, row_bytes * (part->first_row + part->row_count), drawn)
               : exit_code;
}

/* Draws rows of the picture and measures them. */
static int draw_rows(drawing *which, subject *shown, view_state *state, const drawing_clock *clock, unsigned row_count)
{
    const picture_part part = {which->width, which->height, which->rows_done, row_count};
    const double begin_ms = clock->now_ms(clock->user);
    const int exit_code = enqueue_rows(which, shown, state, &part);
    const double pixels = (double)which->width * (double)row_count;
    which->pixel_ms[state->shown.picture][state->shown.through] = (clock->now_ms(clock->user) - begin_ms) / pixels;
    which->rays = (uint64_t)pixels * rays_of_pixel(&state->shown);
    which->rows_done += row_count;
    which->row_count = row_count;
    return exit_code;
}

/* Begins a picture. */
static void resize(drawing *which, const view_state *state, unsigned coarse)
{
    which->coarse = coarse;
    which->width = (state->width + coarse - 1) / coarse;
    which->height = (state->height + coarse - 1) / coarse;
    which->rows_done = 0;
}

/* A whole picture. */
static int draw_all(drawing *which, subject *shown, view_state *state, const drawing_clock *clock, unsigned coarse)
{
    resize(which, state, coarse);
    remember(which, state);
    return draw_rows(which, shown, state, clock, which->height);
}

/* The next band of a finer picture. */
static int draw_band(drawing *which, subject *shown, view_state *state, const drawing_clock *clock)
{
    if (which->rows_done == which->height) {
        resize(which, state, which->coarse / 2);
        which->is_enlarged = true;
    }
    return draw_rows(which, shown, state, clock, band_rows(which, state));
}

int drawing_next(drawing *which, subject *shown, view_state *state, const drawing_clock *clock, bool *is_new)
{
    int exit_code = PROGRAM_DONE;
    const bool outdated = is_outdated(which, state);
    which->is_enlarged = false;
    *is_new = outdated || which->coarse > 1 || which->rows_done < which->height;
    if (outdated) {
        exit_code = draw_all(which, shown, state, clock, coarse_for(which, state));
    } else if (*is_new && subject_picture_is_lit(state->shown.picture)) {
        exit_code = draw_band(which, shown, state, clock);
    } else if (*is_new) {
        exit_code = draw_all(which, shown, state, clock, which->coarse / 2);
    }
    state->is_refined = which->coarse == 1 && which->rows_done == which->height;
    return exit_code;
}
