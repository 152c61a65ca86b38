/* SPDX-License-Identifier: MIT */
/*
 * The builder and its kernels without OpenGL. Fragment lists come from the exact references (walk_frontend.h) and from
 * the OpenCL front end; trees and payload are compared with the references. Nothing may depend on the order of the
 * fragments, on the chunking of the list, or on earlier contents of buffers (dirty_buffers.c).
 *
 * In the group small_kernels, inputs are small enough for oclgrind, an OpenCL interpreter that checks every memory
 * access, to finish in seconds. A second argument names the one test to run.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#include "support/compare_tree.h"
#include "support/info_of.h"
#include "support/meshes.h"
#include "support/payload_reference.h"
#include "support/suite.h"
#include "walk_frontend.h"

#define PAYLOAD  (SVO_NEED_ALL & ~(uint32_t)SVO_NEED_RAYS)
#define NEED_ALL (PAYLOAD | (uint32_t)SVO_NEED_RAYS)
/* The smallest allowed: 2048 fragments of short codes per chunk. */
#define SMALL_CHUNK_BYTES 16384

/* Shared by all tests. */
static struct {
    bool small;
    svo_device *device;
    cl_command_queue queue;
} bench;

static int open_bench(void **state)
{
    (void)state;
    svo_message message = {""};
    const svo_status status = svo_device_create_default(NULL, &bench.device, &message);
    if (status != SVO_OK) {
        print_message("%s\n", message.text);
        return status == SVO_NO_DEVICE ? 0 : -1;
    }
    print_message("on %s\n", info_of_device(bench.device).name);
    cl_int error = CL_SUCCESS;
    bench.queue =
        clCreateCommandQueue(info_of_device(bench.device).context, info_of_device(bench.device).device, 0, &error);
    return error == CL_SUCCESS ? 0 : -1;
}

static int close_bench(void **state)
{
    (void)state;
    if (bench.queue != NULL) {
        clReleaseCommandQueue(bench.queue);
    }
    svo_device_destroy(&bench.device);
    return 0;
}

static void skip_without_device(void **state)
{
    (void)state;
    if (bench.device == NULL) {
        print_message("skipped: no OpenCL device\n");
        skip();
    }
}

/* How a tree is built; the tree must not depend on it. */
typedef struct method {
    uint64_t seed; /* of the fragments' order */
    svo_builder builder;
    bool cl; /* with the OpenCL front end, which has its own order */
    uint64_t chunk_bytes; /* 0: one chunk */
    uint64_t fragment_capacity; /* 0: the fragment estimate */
} method;

typedef struct request {
    const svo_mesh *mesh;
    unsigned depth;
    uint32_t need;
    double edge; /* of the grid at the origin; 0: fitted */
    svo_weights weights;
} request;

static svo_plan_options options_of(const request *asked, const method *by)
{
    return (svo_plan_options){.struct_size = sizeof(svo_plan_options),
                              .need = asked->need,
                              .edge = asked->edge,
                              .weights = asked->weights,
                              .builder = by->builder,
                              .fragment_capacity = by->fragment_capacity,
                              .chunk_bytes = by->chunk_bytes};
}

static void build(const request *asked, const method *by, built *out)
{
    const svo_plan_options options = options_of(asked, by);
    *out = (built){.report = {.struct_size = sizeof out->report}};
    walk_frontend walk;
    svo_frontend *cl = NULL;
    walk_frontend_init(bench.device, by->seed, &walk);
    svo_plan *plan = NULL;
    svo_status status = svo_plan_create(bench.device, asked->mesh, asked->depth, &options, &plan);
    if (status == SVO_OK) {
        status = svo_frontend_create_cl(bench.device, &cl);
    }
    if (status == SVO_OK) {
        status = svo_build(plan, by->cl ? cl : &walk.frontend, bench.queue, &out->tree, &out->report);
    }
    if (status == SVO_OK) {
        status = svo_tree_download(out->tree, bench.queue);
    }
    if (status == SVO_OK) {
        status = svo_tree_hash(out->tree, SVO_HASH_ALL, out->hash);
    }
    if (status != SVO_OK) {
        fail_msg("%s: %s", svo_name(SVO_NAME_STATUS, status), svo_device_message(bench.device));
    }
    out->weight_log2 = plan->weight_log2;
    svo_frontend_destroy(&cl);
    svo_plan_destroy(&plan);
    out->info = (svo_tree_info)SVO_TREE_INFO_INIT;
    svo_tree_get_info(out->tree, &out->info);
    out->arrays = (svo_tree_arrays)SVO_TREE_ARRAYS_INIT;
    svo_tree_get_arrays(out->tree, &out->arrays);
}

/* Builds, compares nodes, and lists if they are requested, with the references, and releases the tree. */
static void check_exact(const request *asked, const method *by, svo_build_report *report)
{
    built actual;
    build(asked, by, &actual);
    const svo_plan_options options = options_of(asked, by);
    assert_build_is_exact(asked->mesh, &options, &actual);
    *report = actual.report;
    svo_tree_destroy(&actual.tree);
}

static void assert_same_tree(const built *actual, const built *expected)
{
    const uint64_t nodes = expected->info.node_count;
    assert_int_equal(actual->info.node_count, nodes);
    if (expected->arrays.colors != NULL) {
        assert_memory_equal(actual->arrays.colors, expected->arrays.colors, nodes * 4);
    }
    if (expected->arrays.normals != NULL) {
        assert_memory_equal(actual->arrays.normals, expected->arrays.normals, nodes * 6);
    }
    if (expected->arrays.materials != NULL) {
        assert_memory_equal(actual->arrays.materials, expected->arrays.materials, nodes * 2);
    }
    if (expected->arrays.fills != NULL) {
        assert_memory_equal(actual->arrays.fills, expected->arrays.fills, nodes * 2);
    }
    if (expected->arrays.areas != NULL) {
        assert_memory_equal(actual->arrays.areas, expected->arrays.areas, expected->info.leaf_count * 12);
    }
    assert_string_equal(actual->hash, expected->hash);
}

/* Compares nodes and the requested lists and payload with the references. */
static void assert_true_tree(const request *asked, const svo_plan_options *options, const built *actual)
{
    exact reference;
    exact_create(asked->mesh, asked->depth, options, &reference);
    assert_tree_is_exact(actual, &reference);
    if ((asked->need & PAYLOAD) != 0) {
        assert_payload_is_exact(asked->mesh, &reference, actual);
    }
    exact_destroy(&reference);
}

/* Builds in one chunk, in another order, in many chunks, and with a list that is too small at first, each with the
   references' walk and with the OpenCL front end. Returns the walk's reports for many chunks and the growing list. */
static void check_all_methods(const request *asked, svo_build_report *cut, svo_build_report *grown)
{
    const method plain = {.seed = 1};
    const svo_plan_options options = options_of(asked, &plain);
    built expected;
    build(asked, &plain, &expected);
    assert_true_tree(asked, &options, &expected);
    assert_in_range(expected.report.list_chunks, 0, 1);
    const method others[] = {{.seed = 5, .builder = SVO_BUILDER_SORTED, .chunk_bytes = SMALL_CHUNK_BYTES},
                             {.seed = 2, .chunk_bytes = SMALL_CHUNK_BYTES},
                             {.seed = 3, .fragment_capacity = expected.info.fragments / 3 + 1},
                             {.cl = true, .chunk_bytes = SMALL_CHUNK_BYTES},
                             {.cl = true, .fragment_capacity = expected.info.fragments / 3 + 1},
                             {.cl = true},
                             {.seed = 6, .builder = SVO_BUILDER_SORTED},
                             {.seed = 4}};
    svo_build_report reports[8] = {{0}};
    for (size_t i = 0; i < (bench.small ? 5 : 8); ++i) {
        built actual;
        build(asked, &others[i], &actual);
        assert_same_tree(&actual, &expected);
        reports[i] = actual.report;
        svo_tree_destroy(&actual.tree);
    }
    *cut = reports[1];
    *grown = reports[2];
    svo_tree_destroy(&expected.tree);
}

/* A mesh with every attribute: colors, normals (some not usable), two textures and a material without texture. */
typedef struct painted {
    owned_mesh owned;
    svo_mesh mesh;
    uint8_t *colors;
    float *normals, *uvs;
    uint16_t *triangle_materials;
    uint8_t texels[2][5 * 3 * 4];
    svo_texture textures[2];
    svo_material materials[3];
} painted;

static void paint_textures(painted *out, uint64_t *state)
{
    static const svo_wrap wraps[2][2] = {{SVO_WRAP_REPEAT, SVO_WRAP_MIRROR}, {SVO_WRAP_CLAMP, SVO_WRAP_REPEAT}};
    for (unsigned i = 0; i < 2; ++i) {
        for (size_t k = 0; k < sizeof out->texels[i]; ++k) {
            out->texels[i][k] = (uint8_t)random_word(state);
        }
        out->textures[i] = (svo_texture){out->texels[i], i == 0 ? 5 : 3, i == 0 ? 3 : 5, wraps[i][0], wraps[i][1]};
        out->materials[i] = (svo_material){{255, 200, (uint8_t)(100 * i), 255}, i};
    }
    out->materials[2] = (svo_material){{10, 250, 130, 200}, SVO_NO_TEXTURE};
}

/* Takes ownership of the triangles. */
static void paint(uint64_t seed, const owned_mesh *owned, painted *out)
{
    uint64_t state = seed;
    const size_t vertices = owned->mesh.vertex_count;
    const size_t triangles = owned->mesh.triangle_count;
    *out = (painted){.owned = *owned,
                     .mesh = owned->mesh,
                     .colors = malloc(vertices * 4),
                     .normals = malloc(vertices * 3 * sizeof(float)),
                     .uvs = malloc(vertices * 2 * sizeof(float)),
                     .triangle_materials = malloc(triangles * sizeof(uint16_t))};
    if (out->colors == NULL || out->normals == NULL || out->uvs == NULL || out->triangle_materials == NULL) {
        fail_msg("no memory for %zu vertices", vertices);
        return;
    }
    for (size_t i = 0; i < vertices * 4; ++i) {
        out->colors[i] = (uint8_t)random_word(&state);
    }
    for (size_t i = 0; i < vertices * 3; ++i) {
        out->normals[i] = random_below(&state, 8) == 0 ? 0.0f : (float)(random_unit(&state) * 2.0 - 1.0);
    }
    for (size_t i = 0; i < vertices * 2; ++i) {
        out->uvs[i] = (float)(random_unit(&state) * 6.0 - 3.0);
    }
    for (size_t i = 0; i < triangles; ++i) {
        out->triangle_materials[i] = (uint16_t)random_below(&state, 3);
    }
    paint_textures(out, &state);
    out->mesh.colors = out->colors;
    out->mesh.normals = out->normals;
    out->mesh.uvs = out->uvs;
    out->mesh.triangle_materials = out->triangle_materials;
    out->mesh.materials = out->materials;
    out->mesh.material_count = 3;
    out->mesh.textures = out->textures;
    out->mesh.texture_count = 2;
}

static void painted_free(painted *made)
{
    owned_mesh_free(&made->owned);
    free(made->colors);
    free(made->normals);
    free(made->uvs);
    free(made->triangle_materials);
}

/* Some triangles about `voxels` voxels wide at that depth of the unit grid. */
static void mesh_for_depth(uint64_t seed, size_t triangle_count, unsigned depth, double voxels, owned_mesh *out)
{
    static const double corner[3] = {0.493, 0.249, 0.121};
    const double width = voxels / (double)(1u << depth);
    random_dust(seed, triangle_count, corner, width < 0.5 ? width : 0.5, out);
}

static void trees_are_exact(void **state)
{
    static const unsigned depths[] = {1, 10, 11, 4, 2, 7, 12};
    skip_without_device(state);
    for (size_t i = 0; i < (bench.small ? 3 : 7); ++i) {
        print_message("depth %u\n", depths[i]);
        owned_mesh made;
        mesh_for_depth(i, bench.small ? 12 : 150, depths[i], 24.0, &made);
        const request asked = {&made.mesh, depths[i], SVO_NEED_RAYS, 1.0, SVO_WEIGHTS_AREA};
        const request nodes_alone = {&made.mesh, depths[i], SVO_NEED_NONE, 1.0, SVO_WEIGHTS_AREA};
        svo_build_report reports[2];
        if (bench.small) {
            check_exact(&asked, &(method){.seed = i, .chunk_bytes = SMALL_CHUNK_BYTES}, reports);
        } else {
            check_all_methods(&asked, &reports[0], &reports[1]);
            check_exact(&nodes_alone, &(method){.seed = i}, reports);
        }
        owned_mesh_free(&made);
    }
}

/* All kinds of triangles at once, on the fitted grid and on one that they reach out of. */
static void random_meshes_are_exact(void **state)
{
    skip_without_device(state);
    for (uint64_t seed = 1; seed <= (bench.small ? 1 : 8); ++seed) {
        print_message("seed %llu\n", (unsigned long long)seed);
        const unsigned depth = bench.small ? 3 : 2 + (unsigned)seed % 6;
        owned_mesh made;
        random_mesh(seed, bench.small ? 30 : 300, seed % 2 == 0 ? 0.0 : 0.5, &made);
        svo_build_report reports[2];
        if (!bench.small) {
            check_all_methods(&(request){&made.mesh, depth, SVO_NEED_RAYS, 0.0, SVO_WEIGHTS_AREA}, &reports[0],
                              &reports[1]);
        }
        check_all_methods(&(request){&made.mesh, depth, NEED_ALL, 1.0, SVO_WEIGHTS_AREA}, &reports[0], &reports[1]);
        owned_mesh_free(&made);
    }
}

/* Every variant of the payload kernels: the attributes of the mesh are removed one by one. */
static void payload_does_not_depend_on_order_and_chunking(void **state)
{
    static const struct {
        uint32_t need;
        bool colors, normals, textures;
        svo_weights weights;
    } cases[] = {
        {PAYLOAD, true, true, true, SVO_WEIGHTS_AREA},
        {NEED_ALL, true, true, true, SVO_WEIGHTS_AREA},
        {SVO_NEED_COLOR, false, false, false, SVO_WEIGHTS_CENTER},
        {SVO_NEED_COLOR, true, false, false, SVO_WEIGHTS_UNIFORM},
        {SVO_NEED_COLOR, false, true, true, SVO_WEIGHTS_AREA},
        {SVO_NEED_NORMAL, true, false, false, SVO_WEIGHTS_AREA},
        {SVO_NEED_NORMAL, false, true, false, SVO_WEIGHTS_CENTER},
        {SVO_NEED_MATERIAL, false, false, false, SVO_WEIGHTS_AREA},
        {SVO_NEED_MATERIAL | SVO_NEED_NORMAL, true, true, false, SVO_WEIGHTS_UNIFORM},
        {SVO_NEED_FILL, true, true, false, SVO_WEIGHTS_AREA},
        {SVO_NEED_PROJECTED_AREA, false, false, false, SVO_WEIGHTS_UNIFORM},
        {SVO_NEED_PROJECTED_AREA | SVO_NEED_NORMAL, false, true, false, SVO_WEIGHTS_CENTER},
    };
    static const unsigned depths[] = {5, 1, 4, 10, 11};
    skip_without_device(state);
    for (size_t i = 0; i < (bench.small ? 1 : sizeof cases / sizeof cases[0]); ++i) {
        for (size_t k = 0; k < (bench.small ? 1 : 5); ++k) {
            print_message("case %zu at depth %u\n", i, depths[k]);
            owned_mesh bare;
            painted made;
            mesh_for_depth(i * 10 + k, bench.small ? 30 : 100, depths[k], bench.small ? 16.0 : 24.0, &bare);
            paint(i + k, &bare, &made);
            made.mesh.colors = cases[i].colors ? made.mesh.colors : NULL;
            made.mesh.normals = cases[i].normals ? made.mesh.normals : NULL;
            made.mesh.texture_count = cases[i].textures ? 2 : 0;
            svo_build_report cut;
            svo_build_report grown;
            check_all_methods(&(request){&made.mesh, depths[k], cases[i].need, 1.0, cases[i].weights}, &cut, &grown);
            assert_true(depths[k] < 4 || cut.list_chunks > 1);
            assert_true(depths[k] < 4 || grown.reruns > 0);
            painted_free(&made);
        }
    }
}

/* With one color and one normal in the mesh, every node has exactly these. */
static void every_node_of_a_one_color_mesh_has_that_color(void **state)
{
    static const uint8_t rgba[4] = {1, 254, 128, 77};
    static const float upwards[3] = {0.0f, 0.0f, 7.5f};
    skip_without_device(state);
    owned_mesh bare;
    painted made;
    mesh_for_depth(5, 40, 4, 16.0, &bare);
    paint(5, &bare, &made);
    made.mesh.material_count = 0;
    for (size_t v = 0; v < made.mesh.vertex_count; ++v) {
        memcpy(made.colors + v * 4, rgba, sizeof rgba);
        memcpy(made.normals + v * 3, upwards, sizeof upwards);
    }
    built actual;
    build(&(request){&made.mesh, 4, PAYLOAD, 1.0, SVO_WEIGHTS_AREA}, &(method){.seed = 1}, &actual);
    assert_in_range(actual.info.node_count, 100, UINT32_MAX);
    for (uint64_t node = 0; node < actual.info.node_count; ++node) {
        assert_memory_equal(actual.arrays.colors + node * 4, rgba, sizeof rgba);
        assert_int_equal(actual.arrays.normals[node * 3], 0);
        assert_int_equal(actual.arrays.normals[node * 3 + 1], 0);
        assert_int_equal(actual.arrays.normals[node * 3 + 2], 32767);
    }
    svo_tree_destroy(&actual.tree);
    painted_free(&made);
}

static void a_mesh_without_triangles_gives_a_root(void **state)
{
    static const uint32_t needs[] = {SVO_NEED_NONE, SVO_NEED_RAYS, NEED_ALL};
    skip_without_device(state);
    for (size_t i = 0; i < 3; ++i) {
        const svo_mesh mesh = {.struct_size = sizeof mesh};
        const request asked = {&mesh, 1 + (bench.small ? 1 : 5) * (unsigned)i, needs[i], 0.0, SVO_WEIGHTS_AREA};
        built actual;
        build(&asked, &(method){.seed = 1}, &actual);
        assert_int_equal(actual.info.node_count, 1);
        assert_int_equal(actual.info.leaf_count, 0);
        assert_int_equal(actual.arrays.child_mask[0], 0);
        assert_build_is_exact(&mesh, NULL, &actual);
        svo_tree_destroy(&actual.tree);
    }
}

/* Long lists are sorted by another method than short ones; these need two and four passes of the sort. */
static void one_leaf_holds_thousands_of_triangles(void **state)
{
    static const size_t counts[] = {200, 3000, 33, 32, 70000};
    skip_without_device(state);
    for (size_t i = 0; i < (bench.small ? 2 : 5); ++i) {
        print_message("%zu triangles\n", counts[i]);
        static const double corner[3] = {0.51, 0.51, 0.51};
        owned_mesh made;
        random_dust(i, counts[i], corner, 0.01, &made);
        svo_build_report cut;
        svo_build_report grown;
        if (bench.small) {
            check_exact(&(request){&made.mesh, 3, SVO_NEED_RAYS, 1.0, SVO_WEIGHTS_AREA},
                        &(method){.seed = i, .chunk_bytes = SMALL_CHUNK_BYTES}, &cut);
        } else {
            check_all_methods(&(request){&made.mesh, 5, NEED_ALL, 1.0, SVO_WEIGHTS_AREA}, &cut, &grown);
            assert_in_range(cut.list_chunks, (counts[i] + 2047) / 2048, counts[i] / 256 + 1);
        }
        owned_mesh_free(&made);
    }
}

/* Short and long lists in one tree. */
static void lists_of_all_lengths_are_sorted(void **state)
{
    static const double corner[3] = {0.0, 0.0, 0.0};
    skip_without_device(state);
    owned_mesh made;
    random_dust(9, bench.small ? 60 : 4000, corner, 1.0, &made);
    for (size_t t = 0; t < made.mesh.triangle_count; ++t) {
        for (unsigned k = 3; k < 9; ++k) { /* small ones, denser and denser towards the corner */
            const double first = made.positions[t * 9 + k % 3];
            made.positions[t * 9 + k] = first * first + (made.positions[t * 9 + k] - 0.5) * 0.01;
        }
        for (unsigned k = 0; k < 3; ++k) {
            made.positions[t * 9 + k] *= made.positions[t * 9 + k];
        }
    }
    svo_build_report reports[2];
    for (unsigned depth = 2; depth <= (bench.small ? 2 : 6); ++depth) {
        check_all_methods(&(request){&made.mesh, depth, SVO_NEED_RAYS, 1.0, SVO_WEIGHTS_AREA}, &reports[0],
                          &reports[1]);
    }
    owned_mesh_free(&made);
}

/* Triangles around voxel corners touch seven voxels each where the fragment estimate expects one: nodes and chunks need
   far more memory than planned, and chunks are halved until they fit. */
static void a_scene_that_defies_the_estimate_is_built_again(void **state)
{
    skip_without_device(state);
    owned_mesh made;
    corner_mesh(bench.small ? 8 : 24, &made);
    svo_build_report cut;
    if (bench.small) {
        check_exact(&(request){&made.mesh, 4, SVO_NEED_NONE, 1.0, SVO_WEIGHTS_AREA},
                    &(method){.seed = 1, .chunk_bytes = SMALL_CHUNK_BYTES}, &cut);
    } else {
        svo_build_report grown;
        check_all_methods(&(request){&made.mesh, 10, NEED_ALL, 1.0, SVO_WEIGHTS_AREA}, &cut, &grown);
        assert_in_range(grown.reruns, 2, 32); /* the list, and the nodes */
    }
    assert_in_range(cut.reruns, 1, 32);
    owned_mesh_free(&made);
}

static int run_group(const char *name, bool small)
{
    bench.small = small;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(trees_are_exact),
        cmocka_unit_test(random_meshes_are_exact),
        cmocka_unit_test(payload_does_not_depend_on_order_and_chunking),
        cmocka_unit_test(every_node_of_a_one_color_mesh_has_that_color),
        cmocka_unit_test(a_mesh_without_triangles_gives_a_root),
        cmocka_unit_test(one_leaf_holds_thousands_of_triangles),
        cmocka_unit_test(lists_of_all_lengths_are_sorted),
        cmocka_unit_test(a_scene_that_defies_the_estimate_is_built_again),
    };
    return _cmocka_run_group_tests(name, tests, sizeof tests / sizeof tests[0], open_bench, close_bench);
}

TEST_GROUP(kernels)
{
    return run_group("kernels", false);
}

TEST_GROUP(small_kernels)
{
    return run_group("small_kernels", true);
}
