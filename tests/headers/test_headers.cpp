/* SPDX-License-Identifier: MIT */
/*
 * The public headers from C++. Calls one function of each library, which links only if its header declares C linkage,
 * checks that headers and library have the same version, and initializes every struct that has a size, which must not
 * draw a warning.
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

template <typename Struct> static void expect_size(const char *what, const Struct &made)
{
    if (made.struct_size == sizeof made)
        return;
    std::printf("%s: struct_size %zu instead of %zu\n", what, made.struct_size, sizeof made);
    failures++;
}

#define EXPECT_SIZE(type, init)   \
    do {                          \
        const type made = init;   \
        expect_size(#init, made); \
    } while (false)

static void initialize_structs()
{
    EXPECT_SIZE(svo_device_options, SVO_DEVICE_OPTIONS_INIT);
    EXPECT_SIZE(svo_memory_callbacks, SVO_MEMORY_CALLBACKS_INIT);
    EXPECT_SIZE(svo_mesh, SVO_MESH_INIT);
    EXPECT_SIZE(svo_mesh_buffers, SVO_MESH_BUFFERS_INIT);
    EXPECT_SIZE(svo_plan_options, SVO_PLAN_OPTIONS_INIT);
    EXPECT_SIZE(svo_plan_info, SVO_PLAN_INFO_INIT);
    EXPECT_SIZE(svo_buffer_info, SVO_BUFFER_INFO_INIT);
    EXPECT_SIZE(svo_kernels_info, SVO_KERNELS_INFO_INIT);
    EXPECT_SIZE(svo_left_out, SVO_LEFT_OUT_INIT);
    EXPECT_SIZE(svo_build_report, SVO_BUILD_REPORT_INIT);
    EXPECT_SIZE(svo_workspace_options, SVO_WORKSPACE_OPTIONS_INIT);
    EXPECT_SIZE(svo_workspace_info, SVO_WORKSPACE_INFO_INIT);
    EXPECT_SIZE(svo_tree_info, SVO_TREE_INFO_INIT);
    EXPECT_SIZE(svo_tree_arrays, SVO_TREE_ARRAYS_INIT);
    EXPECT_SIZE(svo_render_options, SVO_RENDER_OPTIONS_INIT);
    EXPECT_SIZE(svo_voxels_source, SVO_VOXELS_SOURCE_INIT);
    EXPECT_SIZE(svo_voxels_info, SVO_VOXELS_INFO_INIT);
#ifdef HAVE_GL
    EXPECT_SIZE(svo_gl_context_options, SVO_GL_CONTEXT_OPTIONS_INIT);
    EXPECT_SIZE(svo_gl_context_info, SVO_GL_CONTEXT_INFO_INIT);
    EXPECT_SIZE(svo_gl_options, SVO_GL_OPTIONS_INIT);
#endif
#ifdef HAVE_IO
    EXPECT_SIZE(svo_load_options, SVO_LOAD_OPTIONS_INIT);
    EXPECT_SIZE(svo_save_options, SVO_SAVE_OPTIONS_INIT);
    EXPECT_SIZE(svo_import_options, SVO_IMPORT_OPTIONS_INIT);
    EXPECT_SIZE(svo_paged_options, SVO_PAGED_OPTIONS_INIT);
    EXPECT_SIZE(svo_paged_info, SVO_PAGED_INFO_INIT);
    EXPECT_SIZE(svo_paged_counts, SVO_PAGED_COUNTS_INIT);
    EXPECT_SIZE(svo_voxels_load_options, SVO_VOXELS_LOAD_OPTIONS_INIT);
    EXPECT_SIZE(svo_voxel_file_info, SVO_VOXEL_FILE_INFO_INIT);
    EXPECT_SIZE(svo_voxels_save_info, SVO_VOXELS_SAVE_INFO_INIT);
#endif
}

int main()
{
    initialize_structs();
    expect_text("svo_version_string", svo_version_string(), SVO_VERSION_STRING);
    expect_text("svo_status_name", svo_status_name(SVO_CAPACITY_EXCEEDED), "SVO_CAPACITY_EXCEEDED");
    expect_text("svo_stage_name", svo_stage_name(SVO_STAGE_GRID), "grid");
#ifdef HAVE_GL
    expect_text("svo_gl_context_kind_name", svo_gl_context_kind_name(SVO_GL_OSMESA), "osmesa");
#endif
#ifdef HAVE_IO
    svo_tree *tree = nullptr;
    svo_message message = {};
    const svo_status status = svo_tree_load_memory("", 0, "nothing", &tree, &message);
    expect_text("svo_tree_load_memory of no bytes", svo_status_name(status), "SVO_FILE_DAMAGED");
#endif
    return failures == 0 ? 0 : 1;
}
