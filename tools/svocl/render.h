/* SPDX-License-Identifier: MIT */
/* What `svocl render` draws, by INPUT and the options; cmd_render.c chooses. Each function returns the exit code. */
#ifndef SVOCL_TOOLS_SVOCL_RENDER_H
#define SVOCL_TOOLS_SVOCL_RENDER_H

#include "support/program.h"

/* Builds or loads the trees of the scene that INPUT describes, places and draws them. */
int render_scene(program *state);

/* Whether --view asks for the picture of a lit tree. */
bool render_light_is_asked(const options *given);
/* Renders INPUT by --view, --lights and the options of cones. */
int render_light(program *state);

/* Renders INPUT by rays through probes, by --view and the options of probes and lights. */
int render_probes(program *state);

/* Draws the .svo file that INPUT names with as many bytes of it on the device as --paged allows. */
int render_paged(program *state);

/* Refuses options of animations where none is asked for. */
int render_animation_check(program *state);
/* Renders the motions of the scene that INPUT names, a picture for each frame. */
int render_animation(program *state);

#endif
