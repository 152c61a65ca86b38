/* SPDX-License-Identifier: MIT */
/* Motions in time: played by the viewer's clock, which in a script counts frames, or stepped through. */
#ifndef SVOCL_TOOLS_VIEW_PLAY_H
#define SVOCL_TOOLS_VIEW_PLAY_H

#include "view/state.h"

/* Plays or pauses; after the last frame from the first. Instances that are edited give way to what moves. */
void play_toggle(view_state *state);

/* Shows a frame, and pauses. */
void play_seek(view_state *state, uint64_t frame);
/* The frame after (1) or before (-1) the one that is shown. */
void play_step(view_state *state, int direction);

/* Clamped. */
void play_choose_speed(view_state *state, int speed_log2);

/* Lets so many seconds pass. */
void play_advance(view_state *state, double seconds);

#endif
