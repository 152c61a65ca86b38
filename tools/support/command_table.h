/* SPDX-License-Identifier: MIT */
/* The table of commands. A new command is added here; help, manual pages and completion follow. */
#ifndef SVOCL_TOOLS_SUPPORT_COMMAND_TABLE_H
#define SVOCL_TOOLS_SUPPORT_COMMAND_TABLE_H

#include <stddef.h>

#include "support/options.h"

/* All commands, in the order of the help. */
const command *command_table(size_t *count);

#endif
