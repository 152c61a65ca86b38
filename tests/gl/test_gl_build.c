/* SPDX-License-Identifier: MIT */
/*
 * The builder by compute shaders creates the same tree as svo_build, bit for bit, for every scene, need, kind of
 * weights, coverage, depth and chunking. It reports the context's limits with figures and restores the context's
 * bindings.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "context/context.h"
#include "scenes.h"
#include "support/attributed_mesh.h"
#include "support/fixture.h"
#include "support/info_of.h"
#include "support/suite.h"

#define NEED_PAYLOAD \
    ((uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL | (uint32_t)SVO_NEED_MATERIAL | (uint32_t)SVO_NEED_FILL)
/* All but fill, which requires weights by area. */
#define NEED_UNIFORM \
    ((uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL | (uint32_t)SVO_NEED_MATERIAL | (uint32_t)SVO_NEED_RAYS)

/* Builds one mesh by both builders and compares. report: of the builder in OpenGL; NULL allowed. */
static void assert_same_tree(const fixture *opened, const svo_mesh *mesh, unsigned depth,
                             const svo_plan_options *options, svo_build_report *report)
{
    built by_cl;
    built by_gl;
    fixture_build(opened, mesh, depth, options, &by_cl);
    fixture_build_in_gl(opened, mesh, depth, options, &by_gl);
    assert_string_equal(by_cl.report.builder, "cl");
    assert_string_equal(by_gl.report.builder, "gl-compute");
    assert_int_equal(by_gl.report.fragments, by_cl.report.fragments);
    assert_int_equal(by_gl.info.leaf_count, by_cl.info.leaf_count);
    assert_string_equal(by_gl.nodes_hash, by_cl.nodes_hash);
    assert_string_equal(by_gl.hash, by_cl.hash);
    if (report != NULL) {
        *report = by_gl.report;
    }
    built_destroy(&by_cl);
    built_destroy(&by_gl);
}

static void every_scene_gives_the_same_tree(void **state)
{
    const fixture *opened = fixture_of_group(state);
    const svo_plan_options options = {.need = NEED_UNIFORM, .weights = SVO_WEIGHTS_UNIFORM};
    for (size_t i = 0; scene_describe(i) != NULL; ++i) {
        char spec[64];
        (void)snprintf(spec, sizeof spec, "%s:3000", scene_describe(i)->name);
        scene *made = fixture_scene(spec);
        assert_same_tree(opened, scene_mesh(made), 6, &options, NULL);
        scene_destroy(&made);
    }
}

/* All attributes, unusual values included, with every kind of weights. */
static void every_need_and_weight_gives_the_same_payload(void **state)
{
    const fixture *opened = fixture_of_group(state);
    attributed_mesh made;
    attributed_mesh_create(5, 400, 0.0, &made);
    assert_same_tree(opened, &made.mesh, 6, &(svo_plan_options){.need = SVO_NEED_ALL}, NULL);
    assert_same_tree(opened, &made.mesh, 6, &(svo_plan_options){.need = NEED_UNIFORM, .weights = SVO_WEIGHTS_CENTER},
                     NULL);
    for (uint32_t need = 1; need <= SVO_NEED_ALL; need *= 2) {
        if (need != SVO_NEED_FILL) {
            assert_same_tree(opened, &made.mesh, 5, &(svo_plan_options){.need = need, .weights = SVO_WEIGHTS_UNIFORM},
                             NULL);
        }
    }
    assert_same_tree(opened, &made.mesh, 5, &(svo_plan_options){.need = SVO_NEED_NONE}, NULL);
    /* Materials only, all equal: no shader runs. */
    made.mesh.triangle_materials = NULL;
    assert_same_tree(opened, &made.mesh, 5, &(svo_plan_options){.need = SVO_NEED_MATERIAL}, NULL);
    attributed_mesh_destroy(&made);
}

static void every_coverage_and_depth_gives_the_same_tree(void **state)
{
    const fixture *opened = fixture_of_group(state);
    owned_mesh made;
    random_mesh(3, 60, 0.0, &made);
    for (int coverage = SVO_COVERAGE_HALF_OPEN; coverage <= SVO_COVERAGE_THIN; ++coverage) {
        for (unsigned depth = 1; depth <= 8; ++depth) {
            const svo_plan_options options = {.need = SVO_NEED_RAYS, .coverage = (svo_coverage)coverage};
            assert_same_tree(opened, &made.mesh, depth, &options, NULL);
        }
    }
    owned_mesh_free(&made);
}

/* Codes of both lengths, and triangles that reach outside the grid. Of the mesh a unit has eight voxels at each depth,
   at the grid's upper end, where codes have all their bits. */
static void deep_trees_are_the_same(void **state)
{
    static const double corner[3] = {0.3, 0.4, 0.5};
    const fixture *opened = fixture_of_group(state);
    attributed_mesh made;
    attributed_mesh_create(9, 40, 20.0, &made);
    owned_mesh dust;
    random_dust(2, 300, corner, 0.0005, &dust);
    for (unsigned depth = 9; depth <= SVO_DEPTH_MAX; ++depth) {
        const double edge = ldexp(1.0, (int)depth - 3);
        const svo_plan_options options = {.need = NEED_UNIFORM,
                                          .weights = SVO_WEIGHTS_CENTER,
                                          .origin = {10.0 - edge, 10.0 - edge, 10.0 - edge},
                                          .edge = edge};
        assert_same_tree(opened, &made.mesh, depth, &options, NULL);
        assert_same_tree(opened, &dust.mesh, depth, &(svo_plan_options){.need = SVO_NEED_RAYS, .edge = 1.0}, NULL);
    }
    owned_mesh_free(&dust);
    attributed_mesh_destroy(&made);
}

static unsigned copies;
static PFNGLCOPYBUFFERSUBDATAPROC honest_copy;

static void APIENTRY count_copy(GLenum from, GLenum to, GLintptr read, GLintptr written, GLsizeiptr bytes)
{
    ++copies;
    honest_copy(from, to, read, written, bytes);
}

/* Undecided fragments are decided in OpenGL, and copied there; by the host if the mesh exceeds a storage block. */
static void undecided_fragments_give_the_same_tree(void **state)
{
    static const double corner[3] = {0.3, 0.4, 0.5};
    const fixture *opened = fixture_of_group(state);
    svo_i_gl_functions *functions = &opened->context->functions;
    const svo_i_gl_functions honest = *functions;
    owned_mesh made;
    random_dust(8, 4000, corner, 0.05, &made);
    honest_copy = functions->CopyBufferSubData;
    for (int i = 0; i < 2 * 3; ++i) {
        const unsigned depth = 10 + (unsigned)i % 2; /* codes of both lengths */
        const svo_plan_options options = {
            .need = SVO_NEED_RAYS, .coverage = (svo_coverage)(i % 3), .edge = ldexp(1.0, (int)depth - 5)};
        svo_build_report report;
        copies = 0;
        functions->CopyBufferSubData = count_copy;
        functions->limits.storage_block_bytes = i < 3 ? honest.limits.storage_block_bytes : 4000 * 3 * 24;
        assert_same_tree(opened, &made.mesh, depth, &options, &report);
        *functions = honest;
        assert_true(report.undecided > 50);
        assert_int_equal(copies, i < 3 ? 1 : 0);
    }
    owned_mesh_free(&made);
}

static void cut_lists_give_the_same_tree(void **state)
{
    const fixture *opened = fixture_of_group(state);
    attributed_mesh made;
    attributed_mesh_create(7, 150, 0.0, &made);
    svo_build_report report;
    const svo_plan_options uniform = {.need = NEED_UNIFORM, .weights = SVO_WEIGHTS_UNIFORM, .chunk_bytes = 16384};
    assert_same_tree(opened, &made.mesh, 6, &uniform, &report);
    assert_in_range(report.list_chunks, 2, UINT32_MAX);
    const svo_plan_options too_small = {.need = SVO_NEED_RAYS, .fragment_capacity = 1};
    assert_same_tree(opened, &made.mesh, 6, &too_small, &report);
    assert_int_equal(report.reruns, 1);
    const svo_plan_options by_area = {.need = NEED_PAYLOAD, .chunk_bytes = 100000};
    assert_same_tree(opened, &made.mesh, 6, &by_area, &report);
    assert_in_range(report.list_chunks, 2, UINT32_MAX);
    attributed_mesh_destroy(&made);
}

/* Triangles that touch far more voxels than the fragment estimate: list and nodes need a second attempt. */
static void nodes_that_do_not_fit_are_made_again(void **state)
{
    owned_mesh made;
    corner_mesh(16, &made);
    svo_build_report report;
    assert_same_tree(fixture_of_group(state), &made.mesh, 8, &(svo_plan_options){.need = SVO_NEED_RAYS, .edge = 1.0},
                     &report);
    assert_int_equal(report.reruns, 2);
    owned_mesh_free(&made);
}

/* Lists from one triangle to a hundred thousand in a voxel, with ties between materials. */
static void crowds_in_a_voxel_give_the_same_lists(void **state)
{
    static const double corner[3] = {0.51, 0.51, 0.51};
    static const size_t counts[] = {1, 31, 32, 33, 34, 1000, 100000};
    const fixture *opened = fixture_of_group(state);
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; ++i) {
        owned_mesh dust;
        random_dust(i + 1, counts[i], corner, 0.4, &dust);
        assert_same_tree(
            opened, &dust.mesh, 1 + (unsigned)i % 2,
            &(svo_plan_options){.need = SVO_NEED_RAYS | SVO_NEED_NORMAL, .weights = SVO_WEIGHTS_UNIFORM, .edge = 1.0},
            NULL);
        owned_mesh_free(&dust);
    }
}

/* More loop iterations than llvmpipe allows an invocation: over clipped pairs and over long lists. */
static void crowds_beyond_the_limit_of_loops_give_the_same_tree(void **state)
{
    static const double corner[3] = {0.51, 0.51, 0.51};
    const fixture *opened = fixture_of_group(state);
    owned_mesh dust;
    random_dust(3, 5000, corner, 0.4, &dust);
    assert_same_tree(opened, &dust.mesh, 1, &(svo_plan_options){.need = SVO_NEED_NORMAL | SVO_NEED_FILL, .edge = 1.0},
                     NULL);
    owned_mesh_free(&dust);
    random_dust(4, 1000000, corner, 0.4, &dust);
    assert_same_tree(opened, &dust.mesh, 1, &(svo_plan_options){.need = SVO_NEED_RAYS, .edge = 1.0}, NULL);
    owned_mesh_free(&dust);
}

/* One invocation sorts the materials of a voxel; several do where that takes too many iterations. */
static void materials_of_a_crowd_are_the_same(void **state)
{
    static const size_t counts[] = {500, 5000, 50000, 200000};
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; ++i) {
        const svo_plan_options options = {.need = SVO_NEED_MATERIAL, .weights = SVO_WEIGHTS_UNIFORM, .edge = 3.0};
        attributed_mesh made;
        attributed_mesh_create(i, counts[i], 0.0, &made);
        assert_same_tree(fixture_of_group(state), &made.mesh, 1, &options, NULL);
        attributed_mesh_destroy(&made);
    }
}

static void meshes_of_nothing_give_a_root(void **state)
{
    static const double corners[] = {0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.3, 0.9, 0.4};
    const fixture *opened = fixture_of_group(state);
    const svo_plan_options everything = {.need = SVO_NEED_ALL};
    svo_mesh mesh = {.struct_size = sizeof mesh, .positions_double = corners, .vertex_count = 3};
    assert_same_tree(opened, &mesh, 4, &everything, NULL);
    mesh.triangle_count = 1;
    assert_same_tree(opened, &mesh, 4, &everything, NULL);
    assert_same_tree(opened, &mesh, 1, &everything, NULL);
    mesh.positions_double = (const double[]){0.2, 0.2, 0.2, 0.2, 0.2, 0.2, 0.2, 0.2, 0.2};
    assert_same_tree(opened, &mesh, 6, &everything, NULL);
}

/* An out-of-order queue without profiling, and the device's own queue. Stages name their clock. */
static void any_queue_will_do(void **state)
{
    (void)state;
    fixture opened;
    fixture_open(&(fixture_options){.queue_properties = CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE}, &opened);
    scene *made = fixture_scene("knot:2000");
    svo_build_report report;
    assert_same_tree(&opened, scene_mesh(made), 6, &(svo_plan_options){.need = SVO_NEED_RAYS}, &report);
    assert_string_equal(report.share, "none");
    svo_gl_context_info info = SVO_GL_CONTEXT_INFO_INIT;
    svo_gl_context_get_info(opened.context, &info);
    const char *clock = strstr(info.renderer, "llvmpipe") != NULL ? "wall" : "gl-timer";
    assert_string_equal(report.stage_times[SVO_STAGE_SUBDIVIDE].clock, clock);
    assert_string_equal(report.stage_times[SVO_STAGE_PACK].clock, clock);
    assert_null(report.stage_times[SVO_STAGE_FILTER].clock);
    fixture without_queue = opened;
    without_queue.queue = NULL;
    assert_same_tree(&without_queue, scene_mesh(made), 6, &(svo_plan_options){.need = SVO_NEED_RAYS}, NULL);
    scene_destroy(&made);
    fixture_close(&opened);
}

/* Expects that a build is rejected with this message. */
static void assert_refused(const fixture *opened, const svo_mesh *mesh, unsigned depth, uint32_t need,
                           const char *words)
{
    const svo_plan_options options = {.struct_size = sizeof options, .need = need, .chunk_bytes = 16384};
    svo_plan *plan = NULL;
    svo_tree *tree = NULL;
    assert_int_equal(svo_plan_create(opened->device, mesh, depth, &options, &plan), SVO_OK);
    assert_int_equal(svo_gl_build(opened->gl, plan, opened->queue, &tree, NULL), SVO_UNSUPPORTED);
    assert_null(tree);
    if (strstr(svo_device_message(opened->device), words) == NULL) {
        fail_msg("'%s' does not contain '%s'", svo_device_message(opened->device), words);
    }
    svo_plan_destroy(&plan);
}

static void without_64_bit_integers_payload_is_refused(void **state)
{
    (void)state;
    fixture opened;
    fixture_open(&(fixture_options){.no_int64 = 1}, &opened);
    scene *made = fixture_scene("cornell:500");
    assert_string_equal(svo_gl_build_reason(opened.gl, SVO_NEED_RAYS), "");
    assert_non_null(strstr(svo_gl_build_reason(opened.gl, SVO_NEED_COLOR), "GL_ARB_gpu_shader_int64"));
    assert_same_tree(&opened, scene_mesh(made), 6, &(svo_plan_options){.need = SVO_NEED_RAYS}, NULL);
    assert_same_tree(&opened, scene_mesh(made), 9, &(svo_plan_options){.need = SVO_NEED_NONE}, NULL);
    assert_refused(&opened, scene_mesh(made), 6, SVO_NEED_COLOR, "payload needs GL_ARB_gpu_shader_int64");
    scene_destroy(&made);
    fixture_close(&opened);
}

/* All shaders use binding 15, those for nodes alone too. */
static void too_few_bindings_are_refused(void **state)
{
    const fixture *opened = fixture_of_group(state);
    svo_i_gl_limits *limits = &opened->context->functions.limits;
    const svo_i_gl_limits honest = *limits;
    scene *made = fixture_scene("cube");
    assert_string_equal(svo_gl_build_reason(opened->gl, 0), "");
    limits->storage_bindings = 8; /* the minimum of OpenGL 4.3 */
    assert_non_null(strstr(svo_gl_build_reason(opened->gl, 0), "has 8 bindings of storage blocks, below 16"));
    assert_refused(opened, scene_mesh(made), 4, SVO_NEED_NONE, "has 8 bindings of storage blocks");
    *limits = honest;
    limits->compute_storage_blocks = 8;
    assert_string_equal(svo_gl_build_reason(opened->gl, SVO_NEED_RAYS), "");
    assert_non_null(strstr(svo_gl_build_reason(opened->gl, SVO_NEED_FILL), "below the 16 of payload"));
    *limits = honest;
    scene_destroy(&made);
}

/* ---- arrays that exceed a storage block ---- */

/* What is bound must fit a storage block. */
static struct {
    svo_i_gl_functions honest;
    GLint64 block_bytes;
    unsigned ranges; /* that begin inside their array */
} bound;

static void APIENTRY check_range(GLenum target, GLuint index, GLuint buffer, GLintptr offset, GLsizeiptr bytes)
{
    assert_true(bytes <= bound.block_bytes);
    assert_int_equal(offset % 256, 0);
    bound.ranges += offset > 0;
    bound.honest.BindBufferRange(target, index, buffer, offset, bytes);
}

static void APIENTRY check_buffer(GLenum target, GLuint index, GLuint buffer)
{
    GLint64 bytes = 0;
    bound.honest.BindBufferBase(target, index, buffer);
    bound.honest.GetBufferParameteri64v(target, GL_BUFFER_SIZE, &bytes);
    assert_true(buffer == 0 || bytes <= bound.block_bytes);
    bound.honest.BindBufferBase(target, index, buffer);
}

/* As if the context's storage blocks were so small. */
static void assert_same_in_blocks(const fixture *opened, const svo_mesh *mesh, unsigned depth,
                                  const svo_plan_options *options, GLint64 block_bytes, svo_build_report *report)
{
    svo_i_gl_functions *functions = &opened->context->functions;
    svo_plan_options small = *options;
    small.chunk_bytes = (size_t)block_bytes; /* front ends keep the limit that they found */
    bound.honest = *functions;
    bound.block_bytes = functions->limits.storage_block_bytes = block_bytes;
    bound.ranges = 0;
    functions->BindBufferRange = check_range;
    functions->BindBufferBase = check_buffer;
    assert_same_tree(opened, mesh, depth, &small, report);
    *functions = bound.honest;
    assert_in_range(bound.ranges, 1, UINT32_MAX);
}

/* Parts of the mesh, two blocks of texels, windows of leaves and of nodes, with every need and weight. */
static void arrays_may_exceed_a_storage_block(void **state)
{
    static const uint32_t needs[] = {SVO_NEED_COLOR, SVO_NEED_NORMAL,         SVO_NEED_RAYS, SVO_NEED_MATERIAL,
                                     SVO_NEED_FILL,  SVO_NEED_PROJECTED_AREA, SVO_NEED_ALL};
    const fixture *opened = fixture_of_group(state);
    attributed_mesh made;
    attributed_mesh_create(5, 400, 0.0, &made);
    for (size_t i = 0; i < sizeof needs / sizeof needs[0]; ++i) {
        assert_same_in_blocks(opened, &made.mesh, 4, &(svo_plan_options){.need = needs[i]}, 16384, NULL);
    }
    for (int weights = SVO_WEIGHTS_UNIFORM; weights <= SVO_WEIGHTS_CENTER; ++weights) {
        svo_plan_options options = {.need = NEED_UNIFORM, .weights = (svo_weights)weights};
        assert_same_in_blocks(opened, &made.mesh, 5, &options, 16384, NULL);
        options.edge = 200.0; /* codes of 48 bits */
        assert_same_in_blocks(opened, &made.mesh, 11, &options, 16384, NULL);
    }
    attributed_mesh_destroy(&made);
}

/* One triangle, of many voxels. */
static const double wall_corners[] = {0.0, 0.0, 0.0, 1.0, 0.0, 0.01, 0.0, 1.0, 0.02};
static const svo_mesh wall = {
    .struct_size = sizeof wall, .positions_double = wall_corners, .vertex_count = 3, .triangle_count = 1};

/* One chunk, but more nodes than a block has sums, payload or first children of. */
static void nodes_may_exceed_a_storage_block(void **state)
{
    static const double corner[3] = {0.3, 0.4, 0.5};
    svo_build_report report;
    owned_mesh dust;
    random_dust(4, 25, corner, 0.06, &dust);
    for (unsigned depth = 9; depth <= 10; ++depth) {
        const svo_plan_options options = {.need = SVO_NEED_NORMAL | SVO_NEED_FILL, .edge = ldexp(1.0, (int)depth - 7)};
        assert_same_in_blocks(fixture_of_group(state), &dust.mesh, depth, &options, 16384, &report);
        assert_int_equal(report.list_chunks, 1);
    }
    owned_mesh_free(&dust);
    assert_same_in_blocks(fixture_of_group(state), &wall, 7, &(svo_plan_options){.need = SVO_NEED_RAYS}, 16384, NULL);
}

#define SHEETS_MAX 5000

/* The same large triangle many times, of two materials. */
typedef struct sheets {
    svo_mesh mesh;
    svo_material materials[2];
    uint16_t of_triangle[SHEETS_MAX];
    uint32_t indices[3 * SHEETS_MAX];
} sheets;

static void make_sheets(size_t count, sheets *out)
{
    static const double slope[] = {0.0, 0.0, 1.5, 0.0, 1.5, 0.0, 1.5, 0.0, 0.0};
    for (size_t i = 0; i < 3 * count; ++i) {
        out->indices[i] = (uint32_t)(i % 3);
        out->of_triangle[i / 3] = (uint16_t)(i / 3 % 5 == 0);
    }
    out->materials[0] = out->materials[1] = (svo_material){.texture_index = SVO_NO_TEXTURE};
    out->mesh = (svo_mesh){.struct_size = sizeof out->mesh,
                           .positions_double = slope,
                           .vertex_count = 3,
                           .triangle_count = count,
                           .indices = out->indices,
                           .triangle_materials = out->of_triangle,
                           .materials = out->materials,
                           .material_count = 2};
}

/* Long lists in each window, and voxels whose materials many invocations sort. */
static void crowds_may_fill_windows(void **state)
{
    static sheets made;
    const fixture *opened = fixture_of_group(state);
    make_sheets(1200, &made);
    assert_same_in_blocks(opened, &made.mesh, 2, &(svo_plan_options){.need = SVO_NEED_RAYS}, 16384, NULL);
    make_sheets(SHEETS_MAX, &made);
    assert_same_in_blocks(opened, &made.mesh, 2, &(svo_plan_options){.need = SVO_NEED_MATERIAL | SVO_NEED_NORMAL},
                          300000, NULL);
}

/* What no window can hold: the triangles of a node's children, the masks of all nodes, texels beyond seven blocks. */
static void what_no_window_holds_is_refused(void **state)
{
    static sheets made;
    const fixture *opened = fixture_of_group(state);
    GLint64 *block_bytes = &opened->context->functions.limits.storage_block_bytes;
    const GLint64 honest = *block_bytes;
    attributed_mesh textured;
    attributed_mesh_create(5, 20, 0.0, &textured);
    make_sheets(1200, &made);
    *block_bytes = 16384;
    assert_refused(opened, &wall, 9, SVO_NEED_NONE, "the tree has more inner nodes than the 15872 of a storage block");
    assert_refused(opened, &made.mesh, 1, SVO_NEED_MATERIAL, "a node has more than 1984 triangles");
    *block_bytes = 1200;
    assert_refused(opened, &textured.mesh, 4, SVO_NEED_COLOR, "texels are above the 896 of 7 storage blocks");
    *block_bytes = honest;
    attributed_mesh_destroy(&textured);
}

static void wrong_arguments_are_refused(void **state)
{
    const fixture *opened = fixture_of_group(state);
    scene *made = fixture_scene("cube");
    svo_plan *plan = NULL;
    svo_tree *tree = NULL;
    svo_build_report report = {.struct_size = 1};
    assert_int_equal(svo_plan_create(opened->device, scene_mesh(made), 4, NULL, &plan), SVO_OK);
    assert_int_equal(svo_gl_build(NULL, plan, opened->queue, &tree, NULL), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_gl_build(opened->gl, NULL, opened->queue, &tree, NULL), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_gl_build(opened->gl, plan, opened->queue, NULL, NULL), SVO_INVALID_ARGUMENT);
    assert_string_equal(svo_device_message(opened->device), "svo_gl_build: out is NULL");
    assert_int_equal(svo_gl_build(opened->gl, plan, opened->queue, &tree, &report), SVO_INVALID_ARGUMENT);
    const cl_device_id device = info_of_device(opened->device).device;
    cl_context other = clCreateContext(NULL, 1, &device, NULL, NULL, NULL);
    cl_command_queue foreign = clCreateCommandQueue(other, device, 0, NULL);
    assert_int_equal(svo_gl_build(opened->gl, plan, foreign, &tree, NULL), SVO_INVALID_ARGUMENT);
    assert_string_equal(svo_device_message(opened->device),
                        "svo_gl_build: queue is of another context than the device");
    clReleaseCommandQueue(foreign);
    clReleaseContext(other);
    assert_null(tree);
    svo_plan_destroy(&plan);
    scene_destroy(&made);
}

/* A driver whose timer queries work, by its own account: each query is a microsecond after the one before. */
static struct {
    GLuint64 now_ns;
    GLuint ids[2];
    GLuint64 times[2];
} invented;

static void APIENTRY count_query(GLuint id, GLenum target)
{
    assert_int_equal(target, GL_TIMESTAMP);
    invented.now_ns += 1000;
    invented.ids[1] = invented.ids[0];
    invented.times[1] = invented.times[0];
    invented.ids[0] = id;
    invented.times[0] = invented.now_ns;
}

static void APIENTRY tell_query(GLuint id, GLenum name, GLuint64 *out)
{
    assert_int_equal(name, GL_QUERY_RESULT);
    assert_true(id == invented.ids[0] || id == invented.ids[1]);
    *out = id == invented.ids[0] ? invented.times[0] : invented.times[1];
}

/* GPUs have timers, llvmpipe has the wall clock. */
static void stages_are_timed_where_timers_work(void **state)
{
    (void)state;
    static const char *const clocks[] = {"wall", "gl-timer"};
    for (unsigned timers = 0; timers < 2; ++timers) {
        fixture opened;
        built made;
        fixture_open(&(fixture_options){0}, &opened);
        if (timers == 1) {
            opened.context->functions.renderer = "Invented GPU";
            opened.context->functions.QueryCounter = count_query;
            opened.context->functions.GetQueryObjectui64v = tell_query;
        } else if (strstr(opened.context->functions.renderer, "llvmpipe") == NULL) {
            fixture_close(&opened);
            continue;
        }
        scene *knot = fixture_scene("knot:300");
        fixture_build_in_gl(&opened, scene_mesh(knot), 4, &(svo_plan_options){.weights = SVO_WEIGHTS_UNIFORM}, &made);
        svo_stage_time time;
        (void)svo_build_report_stage(&made.report, SVO_STAGE_SUBDIVIDE, &time);
        assert_string_equal(time.clock, clocks[timers]);
        /* The stage is timed once or more, a microsecond each time. */
        assert_true(timers == 0 || (time.ms > 0.0009 && fabs(time.ms * 1000 - rint(time.ms * 1000)) < 1e-6));
        built_destroy(&made);
        scene_destroy(&knot);
        fixture_close(&opened);
    }
}

TEST_GROUP(gl_build)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_scene_gives_the_same_tree),
        cmocka_unit_test(every_need_and_weight_gives_the_same_payload),
        cmocka_unit_test(every_coverage_and_depth_gives_the_same_tree),
        cmocka_unit_test(deep_trees_are_the_same),
        cmocka_unit_test(undecided_fragments_give_the_same_tree),
        cmocka_unit_test(cut_lists_give_the_same_tree),
        cmocka_unit_test(nodes_that_do_not_fit_are_made_again),
        cmocka_unit_test(crowds_in_a_voxel_give_the_same_lists),
        cmocka_unit_test(crowds_beyond_the_limit_of_loops_give_the_same_tree),
        cmocka_unit_test(materials_of_a_crowd_are_the_same),
        cmocka_unit_test(stages_are_timed_where_timers_work),
        cmocka_unit_test(meshes_of_nothing_give_a_root),
        cmocka_unit_test(any_queue_will_do),
        cmocka_unit_test(without_64_bit_integers_payload_is_refused),
        cmocka_unit_test(too_few_bindings_are_refused),
        cmocka_unit_test(arrays_may_exceed_a_storage_block),
        cmocka_unit_test(nodes_may_exceed_a_storage_block),
        cmocka_unit_test(crowds_may_fill_windows),
        cmocka_unit_test(what_no_window_holds_is_refused),
        cmocka_unit_test(wrong_arguments_are_refused),
    };
    return cmocka_run_group_tests_name("gl_build", tests, fixture_group_setup, fixture_group_teardown);
}
