/* SPDX-License-Identifier: MIT */
#include "moving_scene.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "support/enqueued.h"
#include "support/memory_ledger.h"

static void use_floats(attributed_mesh *mesh, float **floats)
{
    const size_t count = mesh->mesh.vertex_count * 3;
    *floats = malloc(count * sizeof **floats);
    assert_non_null(*floats);
    for (size_t i = 0; i < count; ++i) {
        (*floats)[i] = (float)mesh->base.positions[i];
    }
    mesh->mesh.positions = *floats;
    mesh->mesh.positions_double = NULL;
}

void actors_create(uint64_t seed, size_t triangles, bool in_floats, actors *out)
{
    *out = (actors){.floats = {NULL}};
    attributed_mesh_create(seed, triangles, 0.1, &out->room);
    for (int i = 0; i < OBJECTS; ++i) {
        attributed_mesh *object = &out->objects[i];
        attributed_mesh_create(seed * 31 + 5 + (uint64_t)i, triangles / 4 + (size_t)i, 0.0, object);
        object->mesh.triangle_materials = i == 2 ? NULL : object->mesh.triangle_materials;
        object->base.positions[3 * i] = i == 3 ? (double)NAN : object->base.positions[3 * i];
    }
    for (int i = 0; in_floats && i <= OBJECTS; ++i) {
        use_floats(i == 0 ? &out->room : &out->objects[i - 1], &out->floats[i]);
    }
}

void actors_destroy(actors *made)
{
    attributed_mesh_destroy(&made->room);
    for (int i = 0; i < OBJECTS; ++i) {
        attributed_mesh_destroy(&made->objects[i]);
    }
    for (int i = 0; i <= OBJECTS; ++i) {
        free(made->floats[i]);
    }
}

void random_transform(uint64_t *seed, double out[12])
{
    const double angle = 6.28 * random_unit(seed);
    const double size = 0.1 + 0.4 * random_unit(seed);
    const double turn[9] = {cos(angle), -sin(angle), 0, sin(angle), cos(angle), 0.3, 0.1, 0, 0.5 + random_unit(seed)};
    for (int row = 0; row < 3; ++row) {
        for (int k = 0; k < 3; ++k) {
            out[4 * row + k] = size * turn[3 * row + k];
        }
        out[4 * row + 3] = 1.2 * random_unit(seed) - 0.2;
    }
}

svo_moving *make_moving(const fixture *opened, const svo_mesh *mesh, unsigned depth, svo_moving_options options)
{
    svo_moving *moving = NULL;
    options.struct_size = sizeof options;
    succeed(opened, svo_moving_create(opened->device, mesh, depth, &options, opened->queue, &moving));
    return moving;
}

svo_moving *make_stage(const fixture *opened, const actors *of, unsigned depth, svo_moving_options options)
{
    uint64_t seed = 99;
    svo_moving *moving = make_moving(opened, &of->room.mesh, depth, options);
    for (uint32_t i = 0; i < OBJECTS; ++i) {
        double transform[12];
        uint32_t object = 77;
        random_transform(&seed, transform);
        succeed(opened, svo_moving_add(moving, &of->objects[i].mesh, transform, &object));
        assert_int_equal(object, i);
    }
    return moving;
}

void update_moving(const fixture *opened, svo_moving *moving)
{
    svo_moving_report report = SVO_MOVING_REPORT_INIT;
    succeed(opened, svo_moving_update(moving, &(svo_submit){.queue = opened->queue}, &report));
}

/* ---- trees ---- */

outcome outcome_of(const fixture *opened, svo_tree *tree)
{
    outcome found = {.info = SVO_TREE_INFO_INIT, .arrays = {.struct_size = sizeof found.arrays}};
    succeed(opened, svo_tree_download(tree, opened->queue));
    succeed(opened, svo_tree_hash(tree, SVO_HASH_ALL, found.hash));
    succeed(opened, svo_tree_get_info(tree, &found.info));
    assert_int_equal(found.info.is_exact, 1);
    succeed(opened, svo_tree_get_arrays(tree, &found.arrays));
    return found;
}

/* What the hash leaves out, of the mesh that rays meet. */
static void assert_same_geometry(const outcome *actual, const outcome *expected)
{
    const svo_tree_arrays *a = &actual->arrays;
    const svo_tree_arrays *b = &expected->arrays;
    const size_t vertices = (size_t)expected->info.vertex_count;
    const size_t triangles = (size_t)expected->info.list_triangle_count;
    if ((expected->info.need & SVO_NEED_RAYS) == 0) {
        return;
    }
    assert_int_equal(actual->info.positions, expected->info.positions);
    assert_memory_equal(a->vertices, b->vertices, vertices * 12);
    assert_memory_equal(a->indices, b->indices, triangles * 12);
    assert_memory_equal(a->triangle_ids, b->triangle_ids, triangles * 4);
    if (b->positions != NULL) {
        assert_memory_equal(a->positions, b->positions, vertices * 12);
    } else if (b->positions_double != NULL) {
        assert_memory_equal(a->positions_double, b->positions_double, vertices * 24);
    }
}

void assert_same(const outcome *actual, const outcome *expected)
{
    assert_string_equal(actual->hash, expected->hash);
    assert_int_equal(actual->info.triangles, expected->info.triangles);
    assert_int_equal(actual->info.refused_triangles, expected->info.refused_triangles);
    assert_int_equal(actual->info.vertex_count, expected->info.vertex_count);
    assert_int_equal(actual->info.list_triangle_count, expected->info.list_triangle_count);
    assert_int_equal(actual->info.fragments, expected->info.fragments);
    assert_same_geometry(actual, expected);
}

svo_tree *build_whole(const fixture *opened, svo_moving *moving, unsigned depth, const svo_moving_options *of)
{
    svo_mesh mesh;
    svo_tree *tree = NULL;
    svo_moving_info info = SVO_MOVING_INFO_INIT;
    succeed(opened, svo_moving_get_mesh(moving, &mesh));
    succeed(opened, svo_moving_get_info(moving, &info));
    svo_plan_options options = {.need = info.need != 0 ? info.need : (uint32_t)SVO_NEED_NONE,
                                .coverage = of->coverage,
                                .weights = of->weights,
                                .payload_level = of->payload_level,
                                .edge = of->edge,
                                .weight_log2 = info.weight_log2,
                                .drop_alpha = of->drop_alpha};
    memcpy(options.origin, of->origin, sizeof options.origin);
    svo_plan *plan = make_plan(opened, &mesh, depth, options);
    succeed(opened, svo_build(plan, opened->frontend, opened->queue, &tree, NULL));
    svo_plan_destroy(&plan);
    return tree;
}

void compare_moving(const fixture *opened, svo_moving *moving, unsigned depth, const svo_moving_options *of)
{
    svo_moving_info info = SVO_MOVING_INFO_INIT;
    svo_tree *tree = build_whole(opened, moving, depth, of);
    const outcome expected = outcome_of(opened, tree);
    const outcome actual = outcome_of(opened, svo_moving_tree(moving));
    assert_same(&actual, &expected);
    succeed(opened, svo_moving_get_info(moving, &info));
    assert_int_equal(info.fragments, expected.info.fragments);
    svo_tree_destroy(&tree);
}

/* ---- memory ---- */

static void change(const fixture *opened, svo_moving *moving, const svo_mesh *mesh, int step, uint32_t *object)
{
    const double transform[12] = {1, 0, 0, (double)(step % 64) / 64.0, 0, 1, 0, 0, 0, 0, 1, 0};
    if (step % 10 == 3) {
        succeed(opened, svo_moving_remove(moving, *object));
        succeed(opened, svo_moving_add(moving, mesh, NULL, object));
    }
    succeed(opened, svo_moving_set_transform(moving, *object, transform));
    succeed(opened, svo_moving_show(moving, *object, step % 7 != 0));
}

void check_memory_is_flat(int updates, void (*update)(const fixture *opened, svo_moving *moving),
                          uint64_t (*held)(const svo_moving *moving))
{
    enum { WARM = 100 };
    if (getenv("SVOCL_TEST_PATH") != NULL) {
        print_message("skipped: memory does not depend on the kernels\n");
        skip();
    }
    const svo_device_options device_options = {.struct_size = sizeof device_options, .memory = &ledger_callbacks};
    const float positions[9] = {0.1F, 0.1F, 0.1F, 0.3F, 0.1F, 0.1F, 0.1F, 0.4F, 0.1F};
    const svo_mesh mesh = {.struct_size = sizeof mesh, .positions = positions, .vertex_count = 3, .triangle_count = 1};
    const svo_moving_options options = {.need = SVO_NEED_RAYS | SVO_NEED_NORMAL, .edge = 1.0};
    svo_moving_info info[2] = {SVO_MOVING_INFO_INIT, SVO_MOVING_INFO_INIT};
    fixture opened = {.device = NULL};
    uint64_t blocks = 0;
    uint64_t early = 0;
    uint32_t object = 0;
    assert_int_equal(svo_device_create_default(&device_options, &opened.device, NULL), SVO_OK);
    svo_moving *moving = make_moving(&opened, &mesh, 3, options);
    succeed(&opened, svo_moving_add(moving, &mesh, NULL, &object));
    for (int i = 0; i < updates; ++i) {
        change(&opened, moving, &mesh, i, &object);
        update(&opened, moving);
        if (i == WARM) {
            blocks = ledger_end().live_blocks;
            early = held(moving);
            succeed(&opened, svo_moving_get_info(moving, &info[0]));
        }
    }
    succeed(&opened, svo_moving_get_info(moving, &info[1]));
    assert_int_equal(info[1].list_bytes, info[0].list_bytes);
    assert_int_equal(held(moving), early);
    assert_int_equal(ledger_end().live_blocks, blocks);
    assert_null(ledger_end().wrong);
    svo_moving_destroy(&moving);
    fixture_close(&opened);
}
