/* SPDX-License-Identifier: MIT */
/*
 * Rays against the voxels of compact trees: in kernels of the caller's, in batches and in pictures every form gives
 * what the built tree gives, bit for bit.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "compact_reference.h"
#include "core/compact.h"
#include "core/tree.h"
#include "scenes.h"
#include "support/fixture.h"
#include "support/info_of.h"
#include "support/meshes.h"
#include "support/suite.h"

#define RAY_COUNT 100000u

/* What a ray found, of whatever form. */
typedef struct found {
    uint32_t cell[3];
    svo_voxel_hit hit;
    svo_node node; /* of the point where the ray hit, moved inside; without a hit of its origin */
} found;

static const char own_kernel[] =
    "typedef struct found { uint cell[3]; svo_voxel_hit hit; svo_node node; } found;\n"
    "__kernel void follow(SVO_TREE_PARAMETERS, __global const svo_ray *rays, __global found *out, float footprint)\n"
    "{\n"
    "    SVO_TREE_MAKE(tree);\n"
    "    const svo_ray ray = rays[get_global_id(0)];\n"
    "    found f = {{0, 0, 0}};\n"
    "    const bool met = svo_trace_cell(&tree, &ray, footprint, &f.hit, f.cell);\n"
    "    const float t = met ? f.hit.t + 1e-4f : 0.0f;\n"
    "    svo_find_point(&tree, ray.origin[0] + t * ray.direction[0], ray.origin[1] + t * ray.direction[1],\n"
    "                   ray.origin[2] + t * ray.direction[2], &f.node);\n"
    "    out[get_global_id(0)] = f;\n"
    "}\n";

/* ---- rays and hits ---- */

/* From around and inside a tree's grid: towards points inside it, along axes, and with ends. */
static svo_ray *make_rays(const svo_tree_info *info)
{
    svo_ray *rays = calloc(RAY_COUNT, sizeof *rays);
    uint64_t seed = 41;
    assert_non_null(rays);
    for (size_t i = 0; i < RAY_COUNT; ++i) {
        for (int axis = 0; axis < 3; ++axis) {
            const double start = random_unit(&seed) * (i % 3 == 0 ? 1 : 4) - (i % 3 == 0 ? 0 : 1.5);
            const double from = info->origin[axis] + info->edge * start;
            const double to = info->origin[axis] + info->edge * random_unit(&seed);
            rays[i].origin[axis] = (float)from;
            rays[i].direction[axis] = (float)(to - from) * (i % 7 == 0 ? 100.0F : 1.0F);
        }
        if (i % 5 == 0) {
            rays[i].direction[i / 5 % 3] = 0.0F;
        }
        rays[i].t_max = i % 11 == 0 ? 0.5F : INFINITY;
        rays[i].t_min = i % 13 == 0 ? 0.1F : 0.0F;
    }
    return rays;
}

/* Runs the kernel above on a tree, or on a compact one. */
static found *follow(const fixture *opened, svo_tree *tree, svo_compact *compact, cl_mem rays, float footprint)
{
    const bool built_tree = compact == NULL;
    const char *const sources[] = {built_tree ? svo_kernel_source(svo_tree_target(NULL))
                                              : svo_kernel_source(svo_compact_target(NULL)),
                                   own_kernel};
    const char *options =
        built_tree ? svo_kernel_options(svo_tree_target(NULL)) : svo_kernel_options(svo_compact_target(compact));
    const cl_uint argument_count = built_tree ? SVO_TREE_ARGUMENTS : SVO_COMPACT_ARGUMENTS;
    const cl_context context = info_of_device(opened->device).context;
    const cl_device_id device = info_of_device(opened->device).device;
    const size_t items = RAY_COUNT;
    cl_int error = CL_SUCCESS;
    found *out = calloc(RAY_COUNT, sizeof *out);
    assert_non_null(out);
    cl_program program = clCreateProgramWithSource(context, 2, (const char **)sources, NULL, &error);
    assert_int_equal(error, CL_SUCCESS);
    assert_int_equal(clBuildProgram(program, 1, &device, options, NULL, NULL), CL_SUCCESS);
    cl_kernel kernel = clCreateKernel(program, "follow", &error);
    assert_int_equal(error, CL_SUCCESS);
    cl_mem hits = clCreateBuffer(context, CL_MEM_READ_WRITE, RAY_COUNT * sizeof *out, NULL, &error);
    assert_int_equal(error, CL_SUCCESS);
    const svo_status status = built_tree ? svo_kernel_set_arguments(svo_tree_target(tree), kernel, 0)
                                         : svo_kernel_set_arguments(svo_compact_target(compact), kernel, 0);
    assert_int_equal(status, SVO_OK);
    assert_int_equal(clSetKernelArg(kernel, argument_count, sizeof rays, &rays), CL_SUCCESS);
    assert_int_equal(clSetKernelArg(kernel, argument_count + 1, sizeof hits, &hits), CL_SUCCESS);
    assert_int_equal(clSetKernelArg(kernel, argument_count + 2, sizeof footprint, &footprint), CL_SUCCESS);
    assert_int_equal(clEnqueueNDRangeKernel(opened->queue, kernel, 1, NULL, &items, NULL, 0, NULL, NULL), CL_SUCCESS);
    assert_int_equal(clEnqueueReadBuffer(opened->queue, hits, CL_TRUE, 0, RAY_COUNT * sizeof *out, out, 0, NULL, NULL),
                     CL_SUCCESS);
    clReleaseMemObject(hits);
    clReleaseKernel(kernel);
    clReleaseProgram(program);
    return out;
}

/* Gives the nodes of a subtree that have payload their numbers in depth-first order, the others SVO_NO_NODE. */
static void number_depth_first(const svo_tree *tree, uint32_t node, uint32_t level, uint32_t *next, uint32_t *places)
{
    const uint8_t *masks = tree->host[SVO_TREE_CHILD_MASK];
    const uint32_t *first_child = tree->host[SVO_TREE_FIRST_CHILD];
    const bool has_payload = level >= tree->info.payload_level;
    places[node] = has_payload ? *next : SVO_NO_NODE;
    *next += has_payload ? 1 : 0;
    for (int rank = 0; level < tree->info.depth && rank < __builtin_popcount(masks[node]); ++rank) {
        number_depth_first(tree, first_child[node] + (uint32_t)rank, level + 1, next, places);
    }
}

/* The places of all nodes in SVO_FORM_SHARED and SVO_FORM_MIRRORED. */
static uint32_t *shared_places(const svo_compact *compact, const svo_tree *tree)
{
    uint32_t next = 0;
    uint32_t *places = calloc(tree->info.node_count, sizeof *places);
    assert_non_null(places);
    if (compact->info.form == SVO_FORM_MIRRORED && compact->info.minimized == 0) {
        mirrored_walk walk;
        mirrored_walk_make(compact, tree, &walk);
        assert_int_equal(walk.visited, tree->info.node_count);
        memcpy(places, walk.places, tree->info.node_count * sizeof *places);
        mirrored_walk_free(&walk);
        return places;
    }
    if (svo_i_compact_has_places(&compact->info)) {
        number_depth_first(tree, 0, 0, &next, places);
    }
    return places;
}

/* Where a node's payload is, as the form's documentation says, from the path of its cell. shared: shared_places. */
static uint32_t place_of(const svo_compact *compact, const svo_tree *tree, const uint32_t *shared, const found *f)
{
    svo_node node;
    if (compact->info.form == SVO_FORM_IMPLIED) {
        assert_int_equal(svo_tree_find_cell(tree, f->hit.level, f->cell, &node), SVO_OK);
        const uint32_t begin =
            svo_i_compact_has_places(&compact->info) ? tree->info.level_begin[tree->info.payload_level] : 0;
        return node.index < begin ? SVO_NO_NODE : node.index - begin;
    }
    if (compact->info.form == SVO_FORM_SHARED || compact->info.form == SVO_FORM_MIRRORED) {
        assert_int_equal(svo_tree_find_cell(tree, f->hit.level, f->cell, &node), SVO_OK);
        return shared[node.index];
    }
    const uint32_t *words = compact->host[SVO_COMPACT_NODES];
    const uint32_t *bases = compact->host[SVO_COMPACT_BASES];
    uint32_t at = 0;
    for (uint32_t level = 1;; ++level) {
        const uint32_t shift = f->hit.level - level;
        const uint32_t octant =
            (f->cell[0] >> shift & 1) | (f->cell[1] >> shift & 1) << 1 | (f->cell[2] >> shift & 1) << 2;
        const uint32_t below = (1u << octant) - 1;
        const uint32_t word = words[at];
        assert_true((word >> octant & 1) != 0);
        if (level == f->hit.level) {
            return bases == NULL              ? 0
                   : bases[at] == SVO_NO_NODE ? SVO_NO_NODE
                                              : bases[at] + (uint32_t)__builtin_popcount(word & 255 & below);
        }
        const uint32_t distance = (word & 0x10000) != 0 ? words[at + (word >> 17)] : word >> 17;
        at += distance + (uint32_t)__builtin_popcount(word & ~(word >> 8) & 255 & below);
    }
}

/* The index of the deepest node that holds the point. expected: of the built tree. */
static void check_node(const svo_compact *compact, const svo_tree *tree, const uint32_t *shared, const found *expected,
                       const found *got)
{
    const bool root_has_none = svo_i_compact_has_places(&compact->info) && tree->info.payload_level > 0;
    found at = {.hit = {.level = got->node.level}};
    memcpy(at.cell, got->node.cell, sizeof at.cell);
    if (expected->node.index == SVO_NO_NODE) {
        assert_int_equal(got->node.index, SVO_NO_NODE); /* outside the grid */
    } else if (got->node.level == 0) {
        assert_int_equal(got->node.index, root_has_none ? SVO_NO_NODE : 0);
    } else {
        assert_int_equal(got->node.index, place_of(compact, tree, shared, &at));
    }
}

static void assert_same_hit(size_t ray, const found *expected, const found *got)
{
    svo_voxel_hit a = expected->hit;
    svo_voxel_hit b = got->hit;
    a.node = b.node = 0;
    if (memcmp((const unsigned char *)&a, (const unsigned char *)&b, sizeof a) != 0 ||
        memcmp(expected->cell, got->cell, sizeof got->cell) != 0 || expected->node.level != got->node.level ||
        memcmp(expected->node.cell, got->node.cell, sizeof got->node.cell) != 0) {
        fail_msg("ray %zu: level %u cell %u %u %u t %a steps %u, built tree: level %u cell %u %u %u t %a steps %u", ray,
                 got->hit.level, got->cell[0], got->cell[1], got->cell[2], (double)got->hit.t, got->hit.steps,
                 expected->hit.level, expected->cell[0], expected->cell[1], expected->cell[2], (double)expected->hit.t,
                 expected->hit.steps);
    }
}

static svo_compact *compact_of(const fixture *opened, const svo_tree *tree, svo_form form, uint32_t step_log2)
{
    svo_compact_options options = SVO_COMPACT_OPTIONS_INIT;
    svo_compact *made = NULL;
    options.form = form;
    options.directory_step_log2 = step_log2;
    if (svo_compact_create(opened->device, tree, &options, opened->queue, &made) != SVO_OK ||
        svo_compact_download(made, opened->queue) != SVO_OK) {
        fail_msg("%s", svo_device_message(opened->device));
    }
    return made;
}

/* Compares one form with the built tree. expected: its hits. */
static void check_form(const fixture *opened, svo_tree *tree, svo_compact *compact, cl_mem buffer, const svo_ray *rays,
                       float footprint, const found *expected)
{
    found *got = follow(opened, tree, compact, buffer, footprint);
    svo_voxel_hit *batch = calloc(RAY_COUNT, sizeof *batch);
    uint32_t *shared = shared_places(compact, tree);
    assert_non_null(batch);
    assert_int_equal(svo_trace_voxels(svo_compact_target(compact), svo_in_host(rays), svo_in_host(batch), RAY_COUNT,
                                      footprint, 0, &(svo_submit){.queue = opened->queue}),
                     SVO_OK);
    for (size_t i = 0; i < RAY_COUNT; ++i) {
        assert_same_hit(i, &expected[i], &got[i]);
        assert_memory_equal(&batch[i], &got[i].hit, sizeof batch[i]);
        if (isfinite(got[i].hit.t)) {
            assert_int_equal(got[i].hit.node, place_of(compact, tree, shared, &got[i]));
        } else {
            assert_int_equal(got[i].hit.node, SVO_NO_NODE);
        }
        check_node(compact, tree, shared, &expected[i], &got[i]);
    }
    free(shared);
    free(batch);
    free(got);
}

static void check_scene(const fixture *opened, const char *spec, uint32_t depth, const svo_plan_options *options,
                        float footprint)
{
    scene *made = fixture_scene(spec);
    cl_int error = CL_SUCCESS;
    size_t hit_count = 0;
    built tree;
    fixture_build(opened, scene_mesh(made), depth, options, &tree);
    svo_ray *rays = make_rays(&tree.info);
    cl_mem buffer = clCreateBuffer(info_of_device(opened->device).context, CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR,
                                   RAY_COUNT * sizeof *rays, rays, &error);
    assert_int_equal(error, CL_SUCCESS);
    found *expected = follow(opened, tree.tree, NULL, buffer, footprint);
    svo_voxel_hit *batch = calloc(RAY_COUNT, sizeof *batch);
    assert_non_null(batch);
    assert_int_equal(svo_trace_voxels(svo_tree_target(tree.tree), svo_in_host(rays), svo_in_host(batch), RAY_COUNT,
                                      footprint, 0, &(svo_submit){.queue = opened->queue}),
                     SVO_OK);
    for (size_t i = 0; i < RAY_COUNT; ++i) {
        svo_node node;
        assert_memory_equal(&batch[i], &expected[i].hit, sizeof batch[i]);
        if (isfinite(batch[i].t)) {
            ++hit_count;
            assert_int_equal(svo_tree_find_cell(tree.tree, batch[i].level, expected[i].cell, &node), SVO_OK);
            assert_int_equal(node.index, batch[i].node);
        }
    }
    assert_in_range(hit_count, RAY_COUNT / 20, RAY_COUNT);
    svo_compact *forms[] = {
        compact_of(opened, tree.tree, SVO_FORM_DESCRIPTOR, 0), compact_of(opened, tree.tree, SVO_FORM_IMPLIED, 4),
        compact_of(opened, tree.tree, SVO_FORM_IMPLIED, 5),    compact_of(opened, tree.tree, SVO_FORM_IMPLIED, 6),
        compact_of(opened, tree.tree, SVO_FORM_SHARED, 0),     compact_of(opened, tree.tree, SVO_FORM_MIRRORED, 0)};
    for (size_t i = 0; i < sizeof forms / sizeof forms[0]; ++i) {
        check_form(opened, tree.tree, forms[i], buffer, rays, footprint, expected);
        svo_compact_destroy(&forms[i]);
    }
    free(batch);
    free(expected);
    clReleaseMemObject(buffer);
    free(rays);
    built_destroy(&tree);
    scene_destroy(&made);
}

static void every_form_gives_the_hits_of_the_built_tree(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    check_scene(&opened, "knot:3000", 7, &(svo_plan_options){.need = SVO_NEED_COLOR}, 0.0F);
    check_scene(&opened, "atrium", 6, &(svo_plan_options){.need = SVO_NEED_NONE}, 0.02F);
    check_scene(&opened, "statue:3000", 5, &(svo_plan_options){.need = SVO_NEED_NORMAL, .payload_level = 3}, 0.05F);
}

/* A merged leaf is met where its first voxel would be. */
static void merged_leaves_are_met_at_the_same_distance(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    scene *made = fixture_scene("atrium");
    size_t merged_count = 0;
    cl_int error = CL_SUCCESS;
    built tree;
    fixture_build(&opened, scene_mesh(made), 7, &(svo_plan_options){.need = SVO_NEED_NONE}, &tree);
    svo_ray *rays = make_rays(&tree.info);
    cl_mem buffer = clCreateBuffer(info_of_device(opened.device).context, CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR,
                                   RAY_COUNT * sizeof *rays, rays, &error);
    assert_int_equal(error, CL_SUCCESS);
    found *expected = follow(&opened, tree.tree, NULL, buffer, 0.0F);
    for (int form = 0; form < SVO_FORM_COUNT; ++form) {
        svo_compact_options options = SVO_COMPACT_OPTIONS_INIT;
        svo_compact *compact = NULL;
        options.form = (svo_form)form;
        options.minimize = 1;
        assert_int_equal(svo_compact_create(opened.device, tree.tree, &options, opened.queue, &compact), SVO_OK);
        found *got = follow(&opened, tree.tree, compact, buffer, 0.0F);
        for (size_t i = 0; i < RAY_COUNT; ++i) {
            found ancestor = expected[i];
            const uint32_t shift = isfinite(ancestor.hit.t) ? ancestor.hit.level - got[i].hit.level : 0;
            merged_count += shift > 0 ? 1 : 0;
            for (int axis = 0; axis < 3; ++axis) {
                ancestor.cell[axis] >>= shift;
            }
            ancestor.hit.level -= shift;
            ancestor.node = got[i].node;
            assert_same_hit(i, &ancestor, &got[i]);
        }
        free(got);
        svo_compact_destroy(&compact);
    }
    assert_in_range(merged_count, SVO_FORM_COUNT, SVO_FORM_COUNT * RAY_COUNT);
    free(expected);
    clReleaseMemObject(buffer);
    free(rays);
    built_destroy(&tree);
    scene_destroy(&made);
}

/* ---- pictures ---- */

static void every_form_draws_the_picture_of_the_built_tree(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    scene *knot = fixture_scene("knot:3000");
    const svo_plan_options needs = {.need = (uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL};
    svo_render_options options = SVO_RENDER_OPTIONS_INIT;
    built tree;
    fixture_build(&opened, scene_mesh(knot), 6, &needs, &tree);
    options.width = 64;
    options.height = 48;
    (void)svo_camera_fit(svo_tree_target(tree.tree), 64.0F / 48.0F, &options.camera);
    uint8_t *expected = malloc((size_t)64 * 48 * 4);
    uint8_t *got = malloc((size_t)64 * 48 * 4);
    assert_non_null(expected);
    assert_non_null(got);
    for (int form = 0; form < SVO_FORM_COUNT; ++form) {
        svo_compact *compact = compact_of(&opened, tree.tree, (svo_form)form, 0);
        for (int view = SVO_VIEW_SHADED; view <= SVO_VIEW_LEVEL; ++view) {
            options.view = (svo_render_view)view;
            assert_int_equal(svo_render(svo_tree_target(tree.tree), &options, svo_in_host(expected),
                                        &(svo_submit){.queue = opened.queue}),
                             SVO_OK);
            assert_int_equal(svo_render(svo_compact_target(compact), &options, svo_in_host(got),
                                        &(svo_submit){.queue = opened.queue}),
                             SVO_OK);
            assert_memory_equal(expected, got, (size_t)64 * 48 * 4);
        }
        svo_compact_destroy(&compact);
    }
    free(expected);
    free(got);
    built_destroy(&tree);
    scene_destroy(&knot);
}

/* On the device alone. */
static svo_compact *make_form(const fixture *opened, const svo_tree *tree, svo_form form, bool minimize)
{
    const svo_compact_options options = {
        .struct_size = sizeof options, .form = form, .leave_out = minimize ? SVO_NEED_ALL : 0, .minimize = minimize};
    svo_compact *made = NULL;
    if (svo_compact_create(opened->device, tree, &options, opened->queue, &made) != SVO_OK) {
        fail_msg("%s", svo_device_message(opened->device));
    }
    return made;
}

/* A camera is fitted to each form as to the built tree, merged or not, above and below the last level that counts. */
static void every_form_is_framed_as_the_built_tree(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_plan_options needs = {.need = (uint32_t)SVO_NEED_NORMAL};
    static const struct {
        const char *scene;
        unsigned depth;
    } trees[] = {{"knot:3000", 6}, {"cube", 1}, {"cube", 2}, {"terrain:500", 4}, {"knot:3000", 8}};
    for (size_t i = 0; i < 2 * sizeof trees / sizeof trees[0]; ++i) {
        scene *made = fixture_scene(trees[i / 2].scene);
        built tree;
        fixture_build(&opened, scene_mesh(made), trees[i / 2].depth, &needs, &tree);
        assert_int_equal(svo_tree_download(tree.tree, opened.queue), SVO_OK);
        for (int form = 0; form < SVO_FORM_COUNT; ++form) {
            const svo_camera from = {.eye = {1, 2, -3}, .up = {0, 0, 1}, .vertical_fov = 1.0F};
            svo_camera expected[2] = {{.vertical_fov = 0}, from};
            svo_camera got[2] = {{.vertical_fov = 0}, from};
            svo_compact *compact = make_form(&opened, tree.tree, (svo_form)form, i % 2 == 1);
            assert_int_equal(svo_compact_download(compact, opened.queue), SVO_OK);
            for (size_t k = 0; k < 2; ++k) {
                assert_int_equal(svo_camera_fit(svo_tree_target(tree.tree), 1.5F, &expected[k]), SVO_OK);
                assert_int_equal(svo_camera_fit(svo_compact_target(compact), 1.5F, &got[k]), SVO_OK);
            }
            assert_memory_equal(expected, got, sizeof got);
            svo_compact_destroy(&compact);
        }
        built_destroy(&tree);
        scene_destroy(&made);
    }
}

/* Without host arrays the whole grid is framed. */
static void a_form_on_the_device_alone_is_framed_by_its_grid(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    scene *knot = fixture_scene("knot:500");
    svo_camera whole = {.vertical_fov = 0};
    svo_camera occupied = {.vertical_fov = 0};
    built tree;
    fixture_build(&opened, scene_mesh(knot), 4, NULL, &tree);
    svo_compact *compact = make_form(&opened, tree.tree, SVO_FORM_SHARED, false);
    assert_int_equal(svo_camera_fit(svo_compact_target(compact), 1, &whole), SVO_OK);
    assert_int_equal(svo_compact_download(compact, opened.queue), SVO_OK);
    assert_int_equal(svo_camera_fit(svo_compact_target(compact), 1, &occupied), SVO_OK);
    assert_true(whole.eye[2] > occupied.eye[2]);
    svo_compact_destroy(&compact);
    built_destroy(&tree);
    scene_destroy(&knot);
}

/* ---- wrong calls ---- */

static void assert_refused(const fixture *opened, svo_status status, const char *words)
{
    assert_int_equal(status, SVO_INVALID_ARGUMENT);
    if (strstr(svo_device_message(opened->device), words) == NULL) {
        fail_msg("\"%s\" does not say \"%s\"", svo_device_message(opened->device), words);
    }
}

static void wrong_arguments_are_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    scene *cube = fixture_scene("cube");
    const svo_ray ray = {.direction = {0, 0, 1}, .t_max = 1};
    svo_voxel_hit hit;
    uint8_t rgba[4];
    svo_render_options options = {.struct_size = sizeof options, .width = 1, .height = 1};
    svo_compact *nowhere = svo_i_compact_new(NULL);
    svo_tree *host_tree = svo_i_tree_new(NULL);
    built tree;
    fixture_build(&opened, scene_mesh(cube), 3, &(svo_plan_options){.need = SVO_NEED_NORMAL, .payload_level = 3},
                  &tree);
    svo_compact *compact = compact_of(&opened, tree.tree, SVO_FORM_DESCRIPTOR, 0);
    const cl_command_queue queue = opened.queue;
    assert_int_equal(svo_trace_voxels(svo_compact_target(NULL), svo_in_host(&ray), svo_in_host(&hit), 1, 0, 0,
                                      &(svo_submit){.queue = queue}),
                     SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_trace_voxels(svo_compact_target(nowhere), svo_in_host(&ray), svo_in_host(&hit), 1, 0, 0,
                                      &(svo_submit){.queue = queue}),
                     SVO_NOT_ON_DEVICE);
    assert_int_equal(svo_trace_voxels(svo_tree_target(NULL), svo_in_host(&ray), svo_in_host(&hit), 1, 0, 0,
                                      &(svo_submit){.queue = queue}),
                     SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_trace_voxels(svo_tree_target(host_tree), svo_in_host(&ray), svo_in_host(&hit), 1, 0, 0,
                                      &(svo_submit){.queue = queue}),
                     SVO_NOT_ON_DEVICE);
    assert_refused(&opened,
                   svo_trace_voxels(svo_compact_target(compact), svo_in_host(NULL), svo_in_host(&hit), 1, 0, 0,
                                    &(svo_submit){.queue = queue}),
                   "svo_trace_voxels: rays is NULL");
    assert_refused(&opened,
                   svo_trace_voxels(svo_compact_target(compact), svo_in_host(&ray), svo_in_host(NULL), 1, 0, 0,
                                    &(svo_submit){.queue = queue}),
                   "hits is NULL");
    assert_refused(&opened,
                   svo_trace_voxels(svo_compact_target(compact), svo_in_host(&ray), svo_in_host(&hit),
                                    (size_t)SVO_TRACE_RAYS_MAX + 1, 0, 0, &(svo_submit){.queue = queue}),
                   "2147483648 rays are above 2147483647");
    assert_refused(&opened,
                   svo_trace_voxels(svo_compact_target(compact), svo_in_host(&ray), svo_in_host(&hit), 1, -1.0F, 0,
                                    &(svo_submit){.queue = queue}),
                   "footprint -1 is negative");
    assert_refused(&opened,
                   svo_trace_voxels(svo_tree_target(tree.tree), svo_in_host(&ray), svo_in_host(&hit), 1, NAN, 0,
                                    &(svo_submit){.queue = queue}),
                   "is negative or not finite");
    assert_refused(&opened,
                   svo_trace_voxels(svo_tree_target(tree.tree), svo_in_buffer(NULL), svo_in_buffer(NULL), 1, 0, 0,
                                    &(svo_submit){.queue = queue}),
                   "svo_trace_voxels: rays is NULL");
    assert_int_equal(svo_trace_voxels(svo_compact_target(compact), svo_in_host(NULL), svo_in_host(NULL), 0, 0, 0,
                                      &(svo_submit){.queue = queue}),
                     SVO_OK);
    assert_int_equal(svo_render(svo_compact_target(NULL), &options, svo_in_host(rgba), &(svo_submit){.queue = queue}),
                     SVO_INVALID_ARGUMENT);
    assert_refused(&opened,
                   svo_render(svo_compact_target(compact), NULL, svo_in_host(rgba), &(svo_submit){.queue = queue}),
                   "options is NULL");
    assert_refused(&opened,
                   svo_render(svo_compact_target(compact), &options, svo_in_host(rgba), &(svo_submit){.queue = queue}),
                   "svo_render: camera.vertical");
    (void)svo_camera_fit(svo_tree_target(tree.tree), 1, &options.camera);
    assert_refused(&opened,
                   svo_render(svo_compact_target(compact), &options, svo_in_host(rgba), &(svo_submit){.queue = queue}),
                   "payload from level 3 on only");
    options.view = SVO_VIEW_TRIANGLES;
    assert_refused(&opened,
                   svo_render(svo_compact_target(compact), &options, svo_in_host(rgba), &(svo_submit){.queue = queue}),
                   "options.view 5 is none of a compact tree, which has SVO_VIEW_SHADED, NORMAL,");
    assert_refused(&opened, svo_kernel_set_arguments(svo_compact_target(compact), NULL, 0), "kernel is NULL");
    assert_int_equal(svo_kernel_set_arguments(svo_compact_target(NULL), NULL, 0), SVO_INVALID_ARGUMENT);
    svo_compact_destroy(&compact);
    svo_compact_destroy(&nowhere);
    svo_tree_destroy(&host_tree);
    built_destroy(&tree);
    scene_destroy(&cube);
}

TEST_GROUP(compact_rays)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(every_form_gives_the_hits_of_the_built_tree),
                                       cmocka_unit_test(merged_leaves_are_met_at_the_same_distance),
                                       cmocka_unit_test(every_form_draws_the_picture_of_the_built_tree),
                                       cmocka_unit_test(every_form_is_framed_as_the_built_tree),
                                       cmocka_unit_test(a_form_on_the_device_alone_is_framed_by_its_grid),
                                       cmocka_unit_test(wrong_arguments_are_refused)};
    return cmocka_run_group_tests_name("compact_rays", tests, fixture_group_setup, fixture_group_teardown);
}
