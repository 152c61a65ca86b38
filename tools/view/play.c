/* SPDX-License-Identifier: MIT */
/* Frames by seconds. */
#include "view/play.h"

#include <math.h>

/* Frames in a second; 0: there is one frame alone, or all have one time. */
static double rate(const view_film *film)
{
    const double span = (double)film->last_time - (double)film->first_time;
    return span > 0 ? ldexp((double)(film->frame_count - 1) / span, film->speed_log2) : 0;
}

/* Whether there is something to play, which is shown then. */
static bool show_film(view_state *state)
{
    if (state->mover_count == 0) {
        view_log(state, "nothing moves: no instance has a 'motion'");
        return false;
    }
    if (!view_shows_film(state)) {
        view_choose_scene(state, false);
    }
    return true;
}

static void show_frame(view_film *film, double position)
{
    film->position = position;
    film->frame = (uint64_t)position;
}

void play_toggle(view_state *state)
{
    view_film *film = &state->film;
    if (show_film(state)) {
        film->is_playing = !film->is_playing;
        if (film->is_playing && !film->loops && film->frame + 1 >= film->frame_count) {
            show_frame(film, 0);
        }
    }
}

void play_seek(view_state *state, uint64_t frame)
{
    if (show_film(state)) {
        const uint64_t last = state->film.frame_count - 1;
        state->film.is_playing = false;
        show_frame(&state->film, (double)(frame < last ? frame : last));
    }
}

void play_step(view_state *state, int direction)
{
    const view_film *film = &state->film;
    const uint64_t end = direction > 0 ? film->frame_count - 1 : 0;
    const uint64_t beyond = film->loops ? film->frame_count - 1 - end : end;
    play_seek(state, film->frame == end ? beyond : direction > 0 ? film->frame + 1 : film->frame - 1);
}

void play_choose_speed(view_state *state, int speed_log2)
{
    const int most = speed_log2 < VIEW_SPEED_MAX ? speed_log2 : VIEW_SPEED_MAX;
    state->film.speed_log2 = most > -VIEW_SPEED_MAX ? most : -VIEW_SPEED_MAX;
}

void play_advance(view_state *state, double seconds)
{
    view_film *film = &state->film;
    if (!film->is_playing) {
        return;
    }
    const double count = (double)film->frame_count;
    const double position = film->position + seconds * rate(film);
    if (position < count) {
        show_frame(film, position);
    } else if (film->loops) {
        show_frame(film, fmod(position, count));
    } else {
        play_seek(state, film->frame_count - 1);
    }
}
