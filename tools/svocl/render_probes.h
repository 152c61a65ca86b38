/* SPDX-License-Identifier: MIT */
/* Pictures of what light field probes know. */
#ifndef SVOCL_TOOLS_SVOCL_RENDER_PROBES_H
#define SVOCL_TOOLS_SVOCL_RENDER_PROBES_H

#include "support/program.h"

/* Renders INPUT by rays through probes, by --view and the options of probes and lights. Returns the exit code. */
int render_probes(program *state);

#endif
