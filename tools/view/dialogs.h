/* SPDX-License-Identifier: MIT */
/* Boxes over the panels that ask for an answer: for a file to open; for a name to save under, whether a file may be
   replaced, and what to do with unsaved edits before they are lost (view_leave). */
#ifndef SVOCL_TOOLS_VIEW_DIALOGS_H
#define SVOCL_TOOLS_VIEW_DIALOGS_H

#include "view/state.h"
#include "view/ui.h"

/* ---- questions ---- */

/* Saves what is edited: the scene, or the voxels or the lights of a tree alone. Asks for a name where there is none. */
void question_save(view_state *state);

/* Saves in a file. Asks before it replaces one that this session has neither read nor written; never replaces a file
   that a tree of the scene comes from. The log says how it went. Voxels come first: a scene names their file. */
void question_save_as(view_state *state, view_document document, const char *path);

/* For whatever wrote the voxels that the state wants: how it went, in words where it failed, else NULL. */
void question_wrote_voxels(view_state *state, const char *failure);

/* Whether the key is for a question that is asked: Escape cancels, Enter and S save, D discards. */
bool question_take(view_state *state, const view_event *event);

/* Presses a button of the question, the first one is 0: Save, Discard, Cancel; Save, Cancel; Replace, Other name,
   Cancel. Below 0 it does nothing. */
void question_answer(view_state *state, int button);

/* ---- a file to open ---- */

/* Shows the box, at the folder of what is looked at. */
void open_dialog_show(view_state *state);
void open_dialog_hide(view_state *state);

/* Goes on with what all names have in common. */
void open_dialog_complete(view_state *state);
/* Chooses the next name, or the one before. */
void open_dialog_choose(view_state *state, int step);
/* Opens the chosen name, else the path; a folder is listed. */
void open_dialog_accept(view_state *state);

/* ---- drawing ---- */

/* Describes what is shown of them, and the notice, above the panels. */
void dialogs_describe(ui *toolkit, view_state *state);

#endif
