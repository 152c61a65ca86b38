/* SPDX-License-Identifier: MIT */
/*
 * Projected areas of leaves: against closed forms, and leaf by leaf against tools/lab/reference in double precision.
 * What makes a mesh open. All builders, weights and cuts of the list give the same bytes. (test_payload and
 * test_kernels compare the areas of more meshes with a reference in integers.)
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/device.h"
#include "scenes.h"
#include "support/meshes.h"
#include "support/payload_pair.h"
#include "support/payload_reference.h"
#include "support/solid_meshes.h"
#include "support/suite.h"

#define FACE 4096

/* The coordinates of parts are voxels. */
static svo_plan_options of_voxels(unsigned depth)
{
    return (svo_plan_options){.need = SVO_NEED_PROJECTED_AREA, .edge = (double)(1u << depth)};
}

/* The sums over all leaves, in faces. */
static void sum_leaves(const built *tree, double sums[6])
{
    memset(sums, 0, 6 * sizeof *sums);
    for (size_t i = 0; i < tree->info.leaf_count * 6; ++i) {
        sums[i % 6] += (double)tree->arrays.areas[i] / FACE;
    }
}

/* The most by which rounding changes a sum over all leaves, in faces. */
static double most_rounding(const built *tree)
{
    return 0.51 * (double)tree->info.leaf_count / FACE;
}

static void assert_near(const char *what, double actual, double expected, double tolerance)
{
    if (!(fabs(actual - expected) <= tolerance)) {
        fail_msg("%s: %.6f, not %.6f +- %.6f", what, actual, expected, tolerance);
    }
}

/* ---- closed forms ---- */

/* A face of the cube crosses the voxels of its layer entirely, and rays from outside alone see it. The last layer
   has the far face; its voxels beside the face are only touched. */
static void faces_of_a_cube(void **state)
{
    enum { DEPTH = 4, FIRST = 3, LAST = 11 };
    const fixture opened = fixture_cl_of_group(state);
    const svo_plan_options options = of_voxels(DEPTH);
    parts made = {.vertex_count = 0};
    parts_add_cube(&made, FIRST, LAST, false, -1);
    const svo_mesh mesh = parts_mesh(&made);
    built tree;
    exact expected;
    fixture_build(&opened, &mesh, DEPTH, &options, &tree);
    exact_create(&mesh, DEPTH, &options, &expected);
    assert_true(tree.info.leaf_count > 0);
    size_t leaf = 0;
    for (size_t i = 0; i < expected.pairs.count; ++i) {
        if (i > 0 && expected.pairs.pairs[i].code == expected.pairs.pairs[i - 1].code) {
            continue;
        }
        payload_pair pair;
        payload_pair_open(&expected, &expected.pairs.pairs[i], &pair);
        for (unsigned k = 0; k < 6; ++k) {
            const unsigned axis = k / 2;
            const int64_t layer = pair.box.corner[axis] / pair.box.width;
            const int64_t u = pair.box.corner[(axis + 1) % 3] / pair.box.width;
            const int64_t v = pair.box.corner[(axis + 2) % 3] / pair.box.width;
            const bool in_face = u >= FIRST && u < LAST && v >= FIRST && v < LAST;
            const bool in_layer = layer == (k % 2 == 0 ? FIRST : LAST);
            assert_int_equal(tree.arrays.areas[leaf * 6 + k], in_face && in_layer ? FACE : 0);
        }
        ++leaf;
    }
    assert_int_equal(leaf, tree.info.leaf_count);
    exact_destroy(&expected);
    built_destroy(&tree);
    parts_free(&made);
}

/* The area of the triangles that face each of the six rays, or of all for each, in faces of a voxel. */
static void project(const exact *expected, bool both_sides, double seen[6])
{
    memset(seen, 0, 6 * sizeof *seen);
    for (size_t t = 0; t < expected->triangle_count; ++t) {
        double edges[2][3];
        for (unsigned i = 0; i < 6; ++i) {
            const int64_t *from = expected->fine + (size_t)expected->indices[t * 3] * 3;
            const int64_t *to = expected->fine + (size_t)expected->indices[t * 3 + 1 + i / 3] * 3;
            edges[i / 3][i % 3] = (double)(to[i % 3] - from[i % 3]) / (double)PAYLOAD_WIDTH;
        }
        for (unsigned k = 0; k < 6; ++k) {
            const unsigned u = (k / 2 + 1) % 3;
            const unsigned v = (k / 2 + 2) % 3;
            const double n = edges[0][u] * edges[1][v] - edges[0][v] * edges[1][u];
            if (both_sides || (k % 2 == 0 ? n < 0.0 : n > 0.0)) {
                seen[k] += fabs(n) / 2.0;
            }
        }
    }
}

/* Builds a mesh inside the grid and compares the sums over all leaves with the areas of its triangles. */
static void check_sums(const fixture *opened, const svo_mesh *mesh, unsigned depth, const svo_plan_options *options,
                       bool both_sides, double sums[6])
{
    static const char *const names[] = {"+x", "-x", "+y", "-y", "+z", "-z"};
    built tree;
    exact expected;
    double seen[6];
    fixture_build(opened, mesh, depth, options, &tree);
    exact_create(mesh, depth, options, &expected);
    project(&expected, both_sides, seen);
    sum_leaves(&tree, sums);
    for (unsigned k = 0; k < 6; ++k) {
        assert_near(names[k], sums[k], seen[k], most_rounding(&tree));
    }
    exact_destroy(&expected);
    built_destroy(&tree);
}

/* A rectangle turned by any angles is open: rays along both directions see its projection. */
static void tilted_planes(void **state)
{
    enum { DEPTH = 5 };
    static const double angles[][2] = {{0.0, 0.0}, {0.3, 0.0},  {0.785398, 0.0}, {0.785398, 0.615480},
                                       {1.2, 0.9}, {0.01, 2.1}, {1.570796, 0.4}, {2.5, 2.5}};
    const fixture opened = fixture_cl_of_group(state);
    const svo_plan_options options = of_voxels(DEPTH);
    for (size_t i = 0; i < sizeof angles / sizeof angles[0]; ++i) {
        const double u[3] = {cos(angles[i][0]), sin(angles[i][0]), 0.0};
        const double v[3] = {-sin(angles[i][0]) * cos(angles[i][1]), cos(angles[i][0]) * cos(angles[i][1]),
                             sin(angles[i][1])};
        static const double corners[4][2] = {{-10, -9}, {10, -9}, {10, 9}, {-10, 9}};
        static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
        double positions[12];
        for (unsigned k = 0; k < 12; ++k) {
            positions[k] = 16.123 + corners[k / 3][0] * u[k % 3] + corners[k / 3][1] * v[k % 3];
        }
        const svo_mesh mesh = {.struct_size = sizeof mesh,
                               .positions_double = positions,
                               .vertex_count = 4,
                               .indices = indices,
                               .triangle_count = 2};
        const double n[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
        double sums[6];
        check_sums(&opened, &mesh, DEPTH, &options, true, sums);
        for (unsigned k = 0; k < 6; ++k) {
            assert_near("20 x 18 voxels", sums[k], 20.0 * 18.0 * fabs(n[k / 2]), 0.2);
        }
    }
}

/* Every ray sees the disk of a sphere once, since only one side of its surface counts. */
static void spheres(void **state)
{
    enum { DEPTH = 6 };
    const fixture opened = fixture_cl_of_group(state);
    const svo_plan_options options = of_voxels(DEPTH);
    const double center[3] = {31.7, 32.2, 32.4};
    const double radius = 25.0;
    parts made = {.vertex_count = 0};
    parts_add_sphere(&made, center, radius, 60);
    const svo_mesh mesh = parts_mesh(&made);
    const double disk = 3.14159265358979323846 * radius * radius;
    double sums[6];
    check_sums(&opened, &mesh, DEPTH, &options, false, sums);
    for (unsigned k = 0; k < 6; ++k) {
        assert_near("disk", sums[k], disk, 0.002 * disk); /* a polygon of 120 sides has 0.0005 less */
    }
    parts_free(&made);
}

/* Twenty rectangles in one place are more than sixteen faces. */
static void stacks_saturate(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_plan_options options = of_voxels(2);
    static const double corners[12] = {0, 0, 1.5, 4, 0, 1.5, 4, 4, 1.5, 0, 4, 1.5};
    uint32_t indices[20 * 6];
    for (size_t i = 0; i < 20 * 6; ++i) {
        indices[i] = (const uint32_t[]){0, 1, 2, 0, 2, 3}[i % 6];
    }
    for (size_t copies = 15; copies <= 20; ++copies) {
        const svo_mesh mesh = {.struct_size = sizeof mesh,
                               .positions_double = corners,
                               .vertex_count = 4,
                               .indices = indices,
                               .triangle_count = 2 * copies};
        built tree;
        fixture_build(&opened, &mesh, 2, &options, &tree);
        assert_int_equal(tree.info.leaf_count, 16);
        for (size_t i = 0; i < tree.info.leaf_count * 6; ++i) {
            const size_t area = copies * FACE < 65535 ? copies * FACE : 65535;
            assert_int_equal(tree.arrays.areas[i], i % 6 < 4 ? 0 : area);
        }
        built_destroy(&tree);
    }
}

/* ---- leaf by leaf ---- */

/* Compares all leaves with clipping in double precision; areas and their rounding are in 4096ths. */
static void check_leaves(const fixture *opened, const svo_mesh *mesh, unsigned depth, const svo_plan_options *options,
                         bool both_sides)
{
    built tree;
    exact expected;
    fixture_build(opened, mesh, depth, options, &tree);
    exact_create(mesh, depth, options, &expected);
    assert_int_equal(payload_mesh_is_open(&expected), both_sides);
    double *seen = malloc((tree.info.leaf_count * 6 + 1) * sizeof *seen);
    assert_non_null(seen);
    payload_double_projections(&expected, both_sides, seen);
    for (size_t i = 0; i < tree.info.leaf_count * 6; ++i) {
        const double area = fmin(seen[i] * FACE, 65535.0);
        if (!(fabs(area - tree.arrays.areas[i]) <= 0.53)) {
            fail_msg("leaf %zu, direction %zu: %d, not %.4f", i / 6, i % 6, tree.arrays.areas[i], area);
        }
    }
    free(seen);
    exact_destroy(&expected);
    built_destroy(&tree);
}

static void leaves_of_random_triangles(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    for (uint64_t seed = 1; seed <= 16; ++seed) {
        const unsigned depth = 1 + (unsigned)seed % 8;
        owned_mesh made;
        print_message("seed %llu at depth %u\n", (unsigned long long)seed, depth);
        random_mesh(seed, 200, seed % 2 == 0 ? 3.0 : 0.0, &made);
        const svo_plan_options options = {.need = SVO_NEED_PROJECTED_AREA,
                                          .coverage = seed % 3 == 0 ? SVO_COVERAGE_CLOSED : SVO_COVERAGE_HALF_OPEN,
                                          .weights = (svo_weights)(seed % 3),
                                          .edge = 1.0};
        check_leaves(&opened, &made.mesh, depth, &options, true);
        owned_mesh_free(&made);
    }
}

static void leaves_of_closed_scenes(void **state)
{
    static const char *const specs[] = {"knot:2000", "statue:2000", "cube"};
    const fixture opened = fixture_cl_of_group(state);
    const svo_plan_options options = {.need = SVO_NEED_PROJECTED_AREA};
    for (size_t i = 0; i < sizeof specs / sizeof specs[0]; ++i) {
        scene *made = fixture_scene(specs[i]);
        check_leaves(&opened, scene_mesh(made), 6, &options, false);
        scene_destroy(&made);
    }
}

/* ---- open and closed ---- */

/* A tetrahedron with a face whose vertices are its own, and two more vertices. */
static const double corners[][3] = {{1, 1, 1}, {6, 1, 1}, {1, 6, 1}, {1, 1, 6},       {6, 1, 1},
                                    {1, 6, 1}, {1, 1, 6}, {6, 6, 6}, {3.5, 3.5, 1.0}, {NAN, 1, 1}};

typedef struct form {
    const char *name;
    bool is_open;
    size_t triangle_count;
    uint32_t indices[9][3];
} form;

#define LOWER             \
    {0, 2, 1}, {0, 1, 3}, \
    {                     \
        0, 3, 2           \
    } /* the three faces around corner 0 */

static const form forms[] = {
    {"closed", false, 4, {LOWER, {1, 2, 3}}},
    {"split vertices", false, 4, {LOWER, {4, 5, 6}}},
    {"a face missing", true, 3, {LOWER}},
    {"a face turned", true, 4, {LOWER, {1, 3, 2}}},
    {"a face twice", true, 5, {LOWER, {1, 2, 3}, {4, 5, 6}}},
    {"both sides of a face", false, 2, {{1, 2, 3}, {1, 3, 2}}},
    {"all inside out", false, 4, {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}}},
    {"all twice", false, 8, {LOWER, {1, 2, 3}, LOWER, {4, 5, 6}}},
    {"a second one on a face", false, 8, {LOWER, {1, 2, 3}, {7, 2, 1}, {7, 1, 3}, {7, 3, 2}, {4, 5, 6}}},
    {"a segment more", false, 5, {LOWER, {1, 2, 3}, {1, 2, 4}}},
    {"an edge divided on one side", true, 5, {LOWER, {1, 8, 3}, {8, 2, 3}}},
    {"the gap filled by a flat triangle", false, 6, {LOWER, {1, 8, 3}, {8, 2, 3}, {1, 2, 8}}},
    {"a refused face", true, 4, {LOWER, {1, 2, 9}}},
    {"a refused face more", false, 5, {LOWER, {1, 2, 3}, {1, 2, 9}}},
};

/* Whether the build of a form counts both sides, by what rays along +x and -x see in all leaves. */
static bool counts_both_sides(const fixture *opened, const form *wanted, const svo_plan_options *options)
{
    const svo_mesh mesh = {.struct_size = sizeof mesh,
                           .positions_double = corners[0],
                           .vertex_count = sizeof corners / sizeof corners[0],
                           .indices = wanted->indices[0],
                           .triangle_count = wanted->triangle_count};
    built tree;
    exact expected;
    bool same[2] = {true, true};
    fixture_build(opened, &mesh, 3, options, &tree);
    exact_create(&mesh, 3, options, &expected);
    double *seen = malloc((tree.info.leaf_count * 6 + 1) * sizeof *seen);
    assert_non_null(seen);
    for (unsigned both = 0; both < 2; ++both) {
        payload_double_projections(&expected, both != 0, seen);
        for (size_t i = 0; i < tree.info.leaf_count * 6; ++i) {
            same[both] = same[both] && fabs(seen[i] * FACE - tree.arrays.areas[i]) <= 0.53;
        }
    }
    free(seen);
    exact_destroy(&expected);
    built_destroy(&tree);
    if (same[0] == same[1]) {
        fail_msg("%s: the areas are those of %s", wanted->name, same[0] ? "one side and of both" : "neither");
    }
    return same[1];
}

static void open_meshes_count_from_both_sides(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_plan_options options = of_voxels(3);
    for (size_t i = 0; i < sizeof forms / sizeof forms[0]; ++i) {
        const bool both = counts_both_sides(&opened, &forms[i], &options);
        if (both != forms[i].is_open) {
            fail_msg("%s: counts from %s", forms[i].name, both ? "both sides" : "one side");
        }
    }
}

/* Triangles outside the caller's grid belong to the mesh; without them it is open. */
static void a_grid_that_cuts_a_mesh(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_plan_options options = {.need = SVO_NEED_PROJECTED_AREA, .origin = {2, 0, 0}, .edge = 8};
    static const form whole = {"whole", false, 4, {LOWER, {1, 2, 3}}};
    static const form cut = {"cut", true, 3, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}}}; /* without x = 1 */
    assert_false(counts_both_sides(&opened, &whole, &options));
    assert_true(counts_both_sides(&opened, &cut, &options));
}

/* ---- equal vertices ---- */

typedef enum seam { SEAM_NONE, SEAM_SIGNED_ZEROS, SEAM_AN_ULP, SEAM_COUNT } seam;

/* A tetrahedron with vertices of its own for each face, three of whose corners lie between grid units. */
static void split_vertices(seam kind, bool in_floats, double vertices[12][3])
{
    static const uint32_t faces[4][3] = {LOWER, {1, 2, 3}};
    for (unsigned i = 0; i < 12; ++i) {
        for (unsigned axis = 0; axis < 3; ++axis) {
            const double x = (corners[faces[i / 3][i % 3]][axis] - 1) / 3;
            vertices[i][axis] = in_floats ? (double)(float)x : x;
            if (kind == SEAM_SIGNED_ZEROS && x == 0.0 && i % 2 == 1) {
                vertices[i][axis] = -0.0;
            }
        }
    }
    if (kind == SEAM_AN_ULP) {
        const double x = vertices[9][0];
        vertices[9][0] = in_floats ? (double)nextafterf((float)x, 8.0F) : nextafter(x, 8.0);
    }
}

/* Builds from a plan of the host or of the device. */
static void check_seam(const fixture *opened, seam kind, bool in_floats, svo_place place)
{
    double vertices[12][3];
    float floats[36];
    svo_plan_options options = of_voxels(3);
    svo_mesh mesh = {.struct_size = sizeof mesh, .vertex_count = 12, .triangle_count = 4};
    split_vertices(kind, in_floats, vertices);
    for (size_t i = 0; i < 36; ++i) {
        floats[i] = (float)vertices[i / 3][i % 3];
    }
    if (in_floats) {
        mesh.positions = floats;
    } else {
        mesh.positions_double = vertices[0];
    }
    options.place = place;
    check_leaves(opened, &mesh, 3, &options, kind == SEAM_AN_ULP);
}

/* Vertices are one where their coordinates are equal, whatever the signs of zeros. A crack of one ulp, which lies
   between two grid units, opens a mesh. */
static void cracks_open_a_mesh(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    for (unsigned i = 0; i < 4 * SEAM_COUNT; ++i) {
        check_seam(&opened, (seam)(i / 4), i % 2 != 0, i / 2 % 2 != 0 ? SVO_PLACE_DEVICE : SVO_PLACE_HOST);
    }
}

/* ---- all builds ---- */

static svo_status enqueue(const fixture *opened, svo_plan *plan, svo_tree **out, svo_build_report *report)
{
    svo_workspace *workspace = NULL;
    svo_status status = svo_workspace_create(plan, opened->frontend, opened->queue, NULL, &workspace);
    if (status == SVO_OK) {
        status = svo_workspace_make_tree(workspace, out);
    }
    if (status == SVO_OK) {
        status = svo_build_enqueue(workspace, *out, &(svo_submit){.queue = opened->queue});
    }
    if (status == SVO_OK) {
        status = svo_tree_finish(*out, opened->queue, 0, report);
    }
    svo_workspace_destroy(&workspace);
    return status;
}

/* Builds by all methods and compares the areas with those of the first tree. */
static void check_methods(const fixture *opened, const svo_mesh *mesh, uint32_t need, svo_weights weights,
                          const built *first)
{
    static const struct {
        bool sorted, in_gl, enqueued;
        uint64_t chunk_bytes;
    } methods[] = {{false, false, false, 0}, {false, false, false, 16384}, {true, false, false, 0},
                   {false, true, false, 0},  {false, true, false, 16384},  {false, false, true, 0}};
    for (size_t i = 0; i < sizeof methods / sizeof methods[0]; ++i) {
        const svo_plan_options options = {.need = need | (uint32_t)SVO_NEED_PROJECTED_AREA,
                                          .weights = weights,
                                          .builder = methods[i].sorted ? SVO_BUILDER_SORTED : SVO_BUILDER_CL,
                                          .chunk_bytes = methods[i].chunk_bytes};
        built tree;
        if (methods[i].enqueued) {
            fixture_build_by(opened, mesh, 5, &options, enqueue, &tree);
        } else if (methods[i].in_gl) {
            fixture_build_in_gl(opened, mesh, 5, &options, &tree);
        } else {
            fixture_build(opened, mesh, 5, &options, &tree);
        }
        assert_true(methods[i].chunk_bytes == 0 || tree.report.list_chunks > 1);
        assert_int_equal(tree.info.leaf_count, first->info.leaf_count);
        if (memcmp(tree.arrays.areas, first->arrays.areas, tree.info.leaf_count * 12) != 0) {
            fail_msg("need %u, weights %s, method %zu: other areas", need, svo_name(SVO_NAME_WEIGHTS, weights), i);
        }
        built_destroy(&tree);
    }
}

static void all_builds_have_the_same_areas(void **state)
{
    static const char *const specs[] = {"knot:600", "dust:4000"}; /* closed, open */
    static const uint32_t needs[] = {0, SVO_NEED_COLOR | SVO_NEED_NORMAL, SVO_NEED_RAYS | SVO_NEED_MATERIAL};
    const fixture *opened = fixture_of_group(state);
    for (size_t i = 0; i < sizeof specs / sizeof specs[0]; ++i) {
        scene *made = fixture_scene(specs[i]);
        built first;
        fixture_build(opened, scene_mesh(made), 5, &(svo_plan_options){.need = SVO_NEED_PROJECTED_AREA}, &first);
        for (int weights = SVO_WEIGHTS_AREA; weights <= SVO_WEIGHTS_CENTER; ++weights) {
            check_methods(opened, scene_mesh(made), needs[((size_t)weights + i) % 3], (svo_weights)weights, &first);
        }
        built_destroy(&first);
        scene_destroy(&made);
    }
}

/* A compact tree has the payload of nodes alone, and so has the tree that it expands to. */
static void compact_trees_have_none(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_plan_options options = {.need = SVO_NEED_PROJECTED_AREA | SVO_NEED_COLOR};
    scene *made = fixture_scene("knot:600");
    svo_compact *compact = NULL;
    svo_tree *expanded = NULL;
    svo_tree_info info = SVO_TREE_INFO_INIT;
    built tree;
    fixture_build(&opened, scene_mesh(made), 4, &options, &tree);
    assert_int_equal(svo_compact_create(opened.device, tree.tree, NULL, opened.queue, &compact), SVO_OK);
    assert_int_equal(svo_compact_expand(compact, opened.queue, &expanded), SVO_OK);
    assert_int_equal(svo_tree_get_info(expanded, &info), SVO_OK);
    assert_int_equal(info.need, SVO_NEED_COLOR);
    assert_null(svo_tree_get_buffer(expanded, SVO_TREE_AREAS));
    svo_tree_destroy(&expanded);
    svo_compact_destroy(&compact);
    built_destroy(&tree);
    scene_destroy(&made);
}

/* As on GPUs: the areas of pairs are added one by one. */
static int setup_for_single_pairs(void **state)
{
    const int failed = fixture_group_setup_unoptimized(state);
    if (failed == 0 && *state != NULL) {
        fixture_of_group(state)->device->cpu_path = false;
    }
    return failed;
}

TEST_GROUP(area)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(faces_of_a_cube),
        cmocka_unit_test(tilted_planes),
        cmocka_unit_test(spheres),
        cmocka_unit_test(stacks_saturate),
        cmocka_unit_test(leaves_of_random_triangles),
        cmocka_unit_test(leaves_of_closed_scenes),
        cmocka_unit_test(open_meshes_count_from_both_sides),
        cmocka_unit_test(a_grid_that_cuts_a_mesh),
        cmocka_unit_test(cracks_open_a_mesh),
        cmocka_unit_test(all_builds_have_the_same_areas),
        cmocka_unit_test(compact_trees_have_none),
    };
    return cmocka_run_group_tests_name("eight pairs", tests, fixture_group_setup, fixture_group_teardown) +
           cmocka_run_group_tests_name("single pairs", tests, setup_for_single_pairs,
                                       fixture_group_teardown_unoptimized);
}
