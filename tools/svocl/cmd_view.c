/* SPDX-License-Identifier: MIT */
/* svocl view: shows a tree in a window. */
#include "svocl/commands.h"
#include "view/view.h"

int command_view(program *state)
{
    return view_run(state);
}
