/* SPDX-License-Identifier: MIT */
/* What stands in each section of the panels; the files panels_*.c have them. */
#ifndef SVOCL_TOOLS_VIEW_PANELS_PAGES_H
#define SVOCL_TOOLS_VIEW_PANELS_PAGES_H

#include "view/state.h"
#include "view/ui.h"

typedef void panels_page(ui *toolkit, view_state *state);

panels_page panels_frames; /* times as a graph, rays a second */
panels_page panels_memory; /* by buffer, beside the plan */
panels_page panels_picture; /* what is shown */
panels_page panels_camera;
panels_page panels_lights;
panels_page panels_selection; /* what a click found */
panels_page panels_instances;
panels_page panels_motion; /* playing what moves */
panels_page panels_probes;
panels_page panels_settings;

/* The axes in the corner of the picture, and what the colors of a view of numbers mean, above the line at the bottom.
   free: the picture between the columns, as far as that line. */
void panels_guides(ui *toolkit, view_state *state, ui_place free);

#endif
