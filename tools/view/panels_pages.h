/* SPDX-License-Identifier: MIT */
/* The sections of the panels that panels_look.c and panels_scene.c have. */
#ifndef SVOCL_TOOLS_VIEW_PANELS_PAGES_H
#define SVOCL_TOOLS_VIEW_PANELS_PAGES_H

#include "view/state.h"
#include "view/ui.h"

typedef void panels_page(ui *toolkit, view_state *state);

panels_page panels_picture; /* what is shown */
panels_page panels_camera;
panels_page panels_brush;
panels_page panels_lights;
panels_page panels_instances;
panels_page panels_motion; /* playing what moves */
panels_page panels_probes;
panels_page panels_settings;

/* The axes in the corner of the picture, and what the colors of a view of numbers mean, above the line at the bottom.
   free: the picture between the columns, as far as that line. */
void panels_guides(ui *toolkit, view_state *state, ui_place free);

#endif
