/* SPDX-License-Identifier: MIT */
/*
 * Surfaces of trees' distance fields: closed, near the mesh, the same of a dense field and of its band; colors and
 * normals of the nearest leaves, by all leaves; and what is refused.
 */
#include "svocl/surface.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "scenes.h"
#include "support/fixture.h"
#include "support/solid_meshes.h"
#include "support/suite.h"
#include "surface_check.h"

static void succeed(const fixture *opened, svo_status status)
{
    if (status != SVO_OK) {
        fail_msg("%s: %s", svo_name(SVO_NAME_STATUS, status), svo_device_message(opened->device));
    }
}

/* The field of a tree, on the host. */
static svo_surface_field make_field(const fixture *opened, const svo_tree *tree, float band, svo_sdf **sdf)
{
    const svo_sdf_options options = {.struct_size = sizeof options, .band = band};
    svo_surface_field field = SVO_SURFACE_FIELD_INIT;
    *sdf = NULL;
    succeed(opened, svo_sdf_create(tree, &options, opened->queue, sdf));
    assert_int_equal(svo_surface_field_of(*sdf, &field), SVO_INVALID_ARGUMENT);
    assert_non_null(strstr(svo_device_message(opened->device), "call svo_sdf_download first"));
    succeed(opened, svo_sdf_download(*sdf, opened->queue));
    succeed(opened, svo_surface_field_of(*sdf, &field));
    return field;
}

/* A hollow box and a ball that overlaps another. */
static void surfaces_of_solids(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static const double centers[2][3] = {{22.1, 22.7, 8.9}, {24.6, 20.2, 13.3}};
    const svo_plan_options plan = {.edge = 32.0, .need = SVO_NEED_RAYS};
    parts made = {.vertex_count = 0};
    svo_sdf *dense = NULL, *band = NULL;
    built tree;
    parts_add_cube(&made, 2.3, 15.6, false, -1);
    parts_add_cube(&made, 6.1, 11.2, true, -1);
    parts_add_sphere(&made, centers[0], 6.2, 8);
    parts_add_sphere(&made, centers[1], 5.7, 8);
    const svo_mesh mesh = parts_mesh(&made);
    fixture_build(&opened, &mesh, 5, &plan, &tree);
    const svo_surface_field of_all = make_field(&opened, tree.tree, 0.0F, &dense);
    const svo_surface_field of_band = make_field(&opened, tree.tree, 2.5F, &band);
    const svo_surface_options options = {.struct_size = sizeof options, .parts = SVO_SURFACE_NORMALS};
    svo_surface *first = surface_make(&of_all, &options);
    svo_surface *second = surface_make(&of_band, &options);
    const surface_measures measures = surface_check(first);
    /* The box has an inner and an outer surface, the two balls one. */
    assert_int_equal(measures.euler, 6);
    print_message("volume %g\n", measures.volume);
    assert_true(measures.volume > 3300 && measures.volume < 3700);
    surface_compare(first, second);
    svo_surface_destroy(&first);
    svo_surface_destroy(&second);
    svo_sdf_destroy(&dense);
    svo_sdf_destroy(&band);
    built_destroy(&tree);
    parts_free(&made);
}

/* The leaf whose center is nearest, of all. */
static size_t nearest_leaf(const built *tree, const double (*centers)[3], const float at[3])
{
    size_t best = 0;
    double least = INFINITY;
    for (size_t leaf = 0; leaf < tree->info.leaf_count; ++leaf) {
        double squared = 0;
        for (int axis = 0; axis < 3; ++axis) {
            const double away = ((double)at[axis] - centers[leaf][axis]) / tree->info.edge;
            squared += away * away;
        }
        if (squared < least * (1 - 1e-12)) {
            least = squared;
            best = leaf;
        }
    }
    return best;
}

static double (*find_centers(const built *tree))[3]
{
    double(*centers)[3] = malloc((size_t)tree->info.leaf_count * sizeof *centers);
    assert_non_null(centers);
    for (uint32_t leaf = 0; leaf < tree->info.leaf_count; ++leaf) {
        svo_node node;
        assert_int_equal(svo_tree_find_node(tree->tree, (uint32_t)tree->info.inner_count + leaf, &node), SVO_OK);
        for (int axis = 0; axis < 3; ++axis) {
            centers[leaf][axis] =
                tree->info.origin[axis] + (node.cell[axis] + 0.5) * ldexp(tree->info.edge, -(int)tree->info.depth);
        }
    }
    return centers;
}

static void vertices_have_what_the_nearest_leaves_have(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_plan_options plan = {
        .origin = {-2.0, -2.0, -2.0}, .edge = 4.0, .need = SVO_NEED_RAYS | SVO_NEED_COLOR | SVO_NEED_NORMAL};
    scene *knot = fixture_scene("knot:2000");
    built tree;
    svo_sdf *sdf = NULL;
    fixture_build(&opened, scene_mesh(knot), 5, &plan, &tree);
    const svo_surface_field field = make_field(&opened, tree.tree, 4.0F, &sdf);
    /* An offset, so that leaves are not all around. */
    const svo_surface_options options = {.struct_size = sizeof options,
                                         .level = (float)(field.spacing * 1.3),
                                         .parts = SVO_SURFACE_COLORS | SVO_SURFACE_LEAF_NORMALS,
                                         .tree = tree.tree};
    svo_surface *made = surface_make(&field, &options);
    const svo_mesh *mesh = svo_surface_get_mesh(made);
    double(*centers)[3] = find_centers(&tree);
    (void)surface_check(made);
    assert_true(mesh->vertex_count > 500);
    for (size_t i = 0; i < mesh->vertex_count; i += 7) {
        const size_t node =
            tree.info.inner_count + nearest_leaf(&tree, (const double(*)[3])centers, mesh->positions + 3 * i);
        assert_memory_equal(mesh->colors + 4 * i, tree.arrays.colors + 4 * node, 4);
        for (size_t axis = 0; axis < 3; ++axis) {
            assert_true(mesh->normals[3 * i + axis] == (float)(tree.arrays.normals[3 * node + axis] / 32767.0));
        }
    }
    free(centers);
    svo_surface_destroy(&made);
    svo_sdf_destroy(&sdf);
    built_destroy(&tree);
    scene_destroy(&knot);
}

static void expect_refusal(const svo_surface_field *field, const svo_surface_options *options, const char *words)
{
    svo_surface *made = NULL;
    svo_message message = {""};
    assert_int_equal(svo_surface_create(field, options, &made, &message), SVO_INVALID_ARGUMENT);
    assert_null(made);
    if (strstr(message.text, words) == NULL) {
        fail_msg("'%s' does not say '%s'", message.text, words);
    }
}

/* Trees without the payload; a mesh with a hole, whose signs change beyond the band. */
static void trees_that_do_not_suffice_are_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_plan_options plan = {.edge = 32.0, .need = SVO_NEED_RAYS};
    parts made = {.vertex_count = 0};
    svo_sdf *sdf = NULL;
    built tree;
    parts_add_cube(&made, 4.2, 27.9, false, 3);
    const svo_mesh mesh = parts_mesh(&made);
    fixture_build(&opened, &mesh, 5, &plan, &tree);
    const svo_surface_field field = make_field(&opened, tree.tree, 3.0F, &sdf);
    svo_surface_options options = {.struct_size = sizeof options, .parts = SVO_SURFACE_COLORS, .tree = tree.tree};
    expect_refusal(&field, &options, "the tree's leaves have no colors");
    options.parts = SVO_SURFACE_LEAF_NORMALS;
    expect_refusal(&field, &options, "the tree's leaves have no normals");
    expect_refusal(&field, NULL, "whose neighbors the band does not hold");
    svo_sdf_destroy(&sdf);
    built_destroy(&tree);
    parts_free(&made);
}

TEST_GROUP(surface_tree)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(surfaces_of_solids),
        cmocka_unit_test(vertices_have_what_the_nearest_leaves_have),
        cmocka_unit_test(trees_that_do_not_suffice_are_refused),
    };
    return cmocka_run_group_tests_name("surface_tree", tests, fixture_group_setup, fixture_group_teardown);
}
