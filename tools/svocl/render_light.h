/* SPDX-License-Identifier: MIT */
/* Pictures of lit trees. */
#ifndef SVOCL_TOOLS_SVOCL_RENDER_LIGHT_H
#define SVOCL_TOOLS_SVOCL_RENDER_LIGHT_H

#include "support/program.h"

/* Whether --view asks for such a picture. */
bool render_light_is_asked(const options *given);

/* Renders INPUT by --view, --lights and the options of cones. Returns the exit code. */
int render_light(program *state);

#endif
