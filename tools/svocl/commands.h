/* SPDX-License-Identifier: MIT */
/* The commands, one file each. Each returns the exit code; if it is not 0, the command has printed one line. */
#ifndef SVOCL_TOOLS_SVOCL_COMMANDS_H
#define SVOCL_TOOLS_SVOCL_COMMANDS_H

#include "support/program.h"

int command_devices(program *state);
int command_scene(program *state);
int command_build(program *state);
int command_info(program *state);
int command_kernels(program *state);
int command_hash(program *state);
int command_diff(program *state);
int command_convert(program *state);
int command_edit(program *state);
int command_render(program *state);
int command_export_web(program *state);
int command_view(program *state);
int command_trace(program *state);
int command_gather(program *state);
int command_sdf(program *state);
int command_mesh(program *state);
int command_parts(program *state);
int command_completion(program *state);
int command_man(program *state);

#endif
