/* SPDX-License-Identifier: MIT */
/*
 * The public headers from C++. Calls one function of each library, which links only if its header declares C linkage,
 * and checks that headers and library have the same version.
 */
#include <cstdio>
#include <cstring>

#ifdef HAVE_GL
#include "svocl/gl.h"
#endif
#ifdef HAVE_IO
#include "svocl/io.h"
#include "svocl/paged.h"
#endif
#include "svocl/svocl.h"

static int failures;

static void expect_text(const char *what, const char *actual, const char *expected)
{
    if (std::strcmp(actual, expected) == 0)
        return;
    std::printf("%s: \"%s\" instead of \"%s\"\n", what, actual, expected);
    failures++;
}

int main()
{
    expect_text("svo_version_string", svo_version_string(), SVO_VERSION_STRING);
    expect_text("svo_name", svo_name(SVO_NAME_STATUS, SVO_CAPACITY_EXCEEDED), "SVO_CAPACITY_EXCEEDED");
    expect_text("svo_name", svo_name(SVO_NAME_STAGE, SVO_STAGE_GRID), "grid");
#ifdef HAVE_GL
    expect_text("svo_name", svo_name(SVO_NAME_GL_CONTEXT_KIND, SVO_GL_OSMESA), "osmesa");
#endif
#ifdef HAVE_IO
    svo_tree *tree = nullptr;
    svo_message message = {};
    const svo_status status = svo_tree_load(svo_from_memory("", 0, "nothing"), nullptr, &tree, &message);
    expect_text("svo_tree_load of no bytes", svo_name(SVO_NAME_STATUS, status), "SVO_FILE_DAMAGED");
#endif
    return failures == 0 ? 0 : 1;
}
