/* SPDX-License-Identifier: MIT */
/*
 * Undo and redo. What is edited, sources of light, sky, instances, their motions, lights of scenes and the position of
 * the brush, is compared with a copy after each frame; a difference is a step. So every edit is one, whatever made it;
 * a drag is one step, and so is a turn of the wheel. A step holds the elements that differ, as they were and as they
 * are.
 */
#ifndef SVOCL_TOOLS_VIEW_HISTORY_H
#define SVOCL_TOOLS_VIEW_HISTORY_H

#include "view/state.h"

/* Steps are forgotten, the oldest first, beyond so many bytes. */
#define HISTORY_BYTES_MAX (64u << 20)

/* Begins without steps: what the state has is saved. For whatever opened another file. */
void history_begin(view_state *state);
void history_end(view_state *state);

/* Makes a step of what changed since the last one, unless a hand is still at it or the wheel still turns, and says in
   state.unsaved what no file has. Without memory it forgets its steps, and the log says so. */
void history_look(view_state *state, bool is_held);
/* The same for a wheel that still turns: before another edit begins. */
void history_settle(view_state *state);

/* One step back, or on again. Shows the tree, the brush or the scene that the step was made in. */
void history_undo(view_state *state);
void history_redo(view_state *state);

/* A file has the document as it is. */
void history_saved(view_state *state, view_document document);

#endif
