/* SPDX-License-Identifier: MIT */
/* Saving, and what the window asks about it: a name where there is none, whether a file may be replaced, and what to do
   with unsaved edits before they are lost (view_leave). */
#ifndef SVOCL_TOOLS_VIEW_QUESTION_H
#define SVOCL_TOOLS_VIEW_QUESTION_H

#include "view/events.h"
#include "view/state.h"
#include "view/ui.h"

/* Saves what is edited: the scene, or the lights of a tree alone. Asks for a name where there is none. */
void question_save(view_state *state);

/* Saves in a file. Asks before it replaces one that this session has neither read nor written; never replaces a file
   that a tree of the scene comes from. The log says how it went. */
void question_save_as(view_state *state, view_document document, const char *path);

/* Whether the key is for a question that is asked: Escape cancels, Enter saves. */
bool question_take(view_state *state, const view_event *event);

/* Presses a button of the question, the first one is 0: Save, Discard, Cancel; Save, Cancel; Replace, Other name,
   Cancel. Below 0 it does nothing. */
void question_answer(view_state *state, int button);

/* Draws the question that is asked, in the middle of the window. */
void question_describe(ui *toolkit, view_state *state);

#endif
