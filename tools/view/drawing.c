/* SPDX-License-Identifier: MIT */
/* Coarse and refined pictures. */
#include "view/drawing.h"

#include <stdlib.h>
#include <string.h>

void drawing_end(drawing *which)
{
    free(which->rgba);
    *which = (drawing){.rgba = NULL};
}

/* Whether the last picture shows something else than the state does. Fields are compared one by one: structs have
   padding. */
static bool is_outdated(const drawing *which, const view_state *state)
{
    const view_shown *had = &which->shown;
    const view_shown *now = &state->shown;
    return which->width == 0 || which->window_width != state->width || which->window_height != state->height ||
           had->picture != now->picture || had->level != now->level || had->gi != now->gi ||
           had->photons != now->photons || had->form != now->form || had->cones != now->cones ||
           memcmp(&had->exposure, &now->exposure, sizeof had->exposure) != 0 ||
           memcmp(&had->range, &now->range, sizeof had->range) != 0 ||
           memcmp(&had->falloff, &now->falloff, sizeof had->falloff) != 0 ||
           which->revisions.lights != state->revisions.lights ||
           which->revisions.instances != state->revisions.instances ||
           memcmp(&which->camera, &state->camera.at, sizeof which->camera) != 0;
}

/* The coarseness whose picture is expected to take no longer than the goal. */
static unsigned coarse_for(const drawing *which, const view_state *state)
{
    if (state->settings.coarse != 0) {
        return state->settings.coarse;
    }
    const double pixel_ms = which->pixel_ms[state->shown.picture];
    const double pixels = (double)state->width * (double)state->height;
    unsigned coarse = pixel_ms > 0 ? 1 : VIEW_COARSE_MAX;
    while (coarse < VIEW_COARSE_MAX && pixel_ms * pixels / (coarse * coarse) > (double)state->settings.goal_ms) {
        coarse *= 2;
    }
    return coarse;
}

static bool make_room(drawing *which, unsigned width, unsigned height)
{
    const size_t bytes = (size_t)width * height * 4;
    if (bytes <= which->capacity) {
        return true;
    }
    uint8_t *larger = realloc(which->rgba, bytes);
    if (larger == NULL) {
        return false;
    }
    which->rgba = larger;
    which->capacity = bytes;
    return true;
}

/* Rays from the camera through a pixel: both shaded pictures and those of light have two by two. */
static unsigned rays_of_pixel(view_picture picture)
{
    return picture == VIEW_SHADED || subject_picture_is_lit(picture) ? 4 : 1;
}

static void remember(drawing *which, const view_state *state, unsigned coarse)
{
    which->shown = state->shown;
    which->revisions = state->revisions;
    which->camera = state->camera.at;
    which->window_width = state->width;
    which->window_height = state->height;
    which->coarse = coarse;
    which->rays = (uint64_t)which->width * which->height * rays_of_pixel(state->shown.picture);
}

int drawing_next(drawing *which, subject *shown, view_state *state, double (*now_ms)(void *clock), void *clock,
                 bool *is_new)
{
    const bool outdated = is_outdated(which, state);
    *is_new = outdated || which->coarse > 1;
    state->is_refined = !*is_new;
    if (!*is_new) {
        return PROGRAM_DONE;
    }
    const unsigned coarse = outdated ? coarse_for(which, state) : which->coarse / 2;
    const unsigned width = (state->width + coarse - 1) / coarse;
    const unsigned height = (state->height + coarse - 1) / coarse;
    if (!make_room(which, width, height)) {
        return program_fail(shown->running, PROGRAM_FAILED, "out of memory for %ux%u pixels", width, height);
    }
    const double begin_ms = now_ms(clock);
    which->width = 0;
    const int exit_code = subject_draw(shown, state, width, height, which->rgba);
    if (exit_code == PROGRAM_DONE) {
        which->pixel_ms[state->shown.picture] = (now_ms(clock) - begin_ms) / ((double)width * (double)height);
        which->width = width;
        which->height = height;
        remember(which, state, coarse);
    }
    state->is_refined = coarse == 1;
    return exit_code;
}
