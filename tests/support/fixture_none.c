/* SPDX-License-Identifier: MIT */
/* Replaces fixture_gl.c where svocl is built without svocl::gl. */
#include "fixture.h"

void fixture_open(const fixture_options *options, fixture *out)
{
    fixture_open_cl(options, out);
    fixture_skip(out, "svocl was built without OpenGL");
}

void fixture_close_gl(fixture *opened)
{
    (void)opened;
}
