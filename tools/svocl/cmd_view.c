/* SPDX-License-Identifier: MIT */
/* svocl view: shows a tree in a window. A build that lacks what the viewer needs says what that is. */
#include "svocl/commands.h"

#ifdef SVOCL_VIEW_MISSING

int command_view(program *state)
{
    return program_fail(state, PROGRAM_FAILED, "this svocl has no viewer: it was built without %s", SVOCL_VIEW_MISSING);
}

#else

#include "view/view.h"

int command_view(program *state)
{
    return view_run(state);
}

#endif
