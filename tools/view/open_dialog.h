/* SPDX-License-Identifier: MIT */
/* The box that asks for a file: its path, and what the folder has that the path may go on with. */
#ifndef SVOCL_TOOLS_VIEW_OPEN_DIALOG_H
#define SVOCL_TOOLS_VIEW_OPEN_DIALOG_H

#include "view/state.h"
#include "view/ui.h"

/* Shows the box, at the folder of what is looked at. */
void open_dialog_show(view_state *state);
void open_dialog_hide(view_state *state);

/* Lists the names again where the path has changed. */
void open_dialog_list(view_state *state);
/* Goes on with what all names have in common. */
void open_dialog_complete(view_state *state);
/* Chooses the next name, or the one before. */
void open_dialog_choose(view_state *state, int step);
/* Opens the chosen name, else the path; a folder is listed. */
void open_dialog_accept(view_state *state);

/* Describes the box, where it is shown, in a window of this size. */
void panels_open(ui *toolkit, view_state *state, float width, float height);

#endif
