/* SPDX-License-Identifier: MIT */
/*
 * Nodes as places (svocl/nodes.h): codes, cells, boxes, the leaf at a point, against a walk over the whole tree and
 * closed forms; and the same functions in a kernel, bit for bit.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "scenes.h"
#include "support/fixture.h"
#include "support/info_of.h"
#include "support/meshes.h"
#include "support/suite.h"

static void succeed(const fixture *opened, svo_status status)
{
    if (status != SVO_OK) {
        fail_msg("%s: %s", svo_name(SVO_NAME_STATUS, status), svo_device_message(opened->device));
    }
}

/* ---- codes ---- */

static void codes_and_cells_round_trip(void **state)
{
    (void)state;
    uint64_t random = 5;
    for (int i = 0; i < 20000; ++i) {
        const unsigned bits = 1 + random_below(&random, 21);
        uint32_t cell[3];
        uint32_t back[3];
        uint64_t code = 0;
        for (unsigned axis = 0; axis < 3; ++axis) {
            cell[axis] = random_word(&random) & ((1u << bits) - 1u);
            for (unsigned bit = 0; bit < bits; ++bit) {
                code |= (uint64_t)(cell[axis] >> bit & 1u) << (3 * bit + axis);
            }
        }
        assert_true(svo_cell_to_code(cell) == code);
        svo_code_to_cell(code, back);
        assert_memory_equal(back, cell, sizeof cell);
    }
}

/* ---- the whole tree ---- */

typedef struct walk {
    const fixture *opened;
    const built *tree;
    svo_grid grid;
    uint64_t visited;
    uint64_t last_code[SVO_LEVELS_MAX]; /* of each level, plus one */
} walk;

static void assert_same_node(const svo_node *actual, const svo_node *expected)
{
    if (memcmp(actual, expected, sizeof *actual) != 0) {
        fail_msg("node %u of level %u at %u, %u, %u instead of node %u of level %u at %u, %u, %u", actual->index,
                 actual->level, actual->cell[0], actual->cell[1], actual->cell[2], expected->index, expected->level,
                 expected->cell[0], expected->cell[1], expected->cell[2]);
    }
}

/* The middle of a cell. */
static void middle_of(const svo_grid *grid, const svo_node *node, double middle[3])
{
    double low[3];
    double high[3];
    svo_grid_cell_box(grid, node->level, node->cell, low, high);
    for (int axis = 0; axis < 3; ++axis) {
        middle[axis] = 0.5 * (low[axis] + high[axis]);
    }
}

static void check_node(walk *w, const svo_node *node)
{
    svo_node found;
    double middle[3];
    double box[2][3];
    double own_box[2][3];
    uint32_t cell[3];
    succeed(w->opened, svo_tree_find_node(w->tree->tree, node->index, &found));
    assert_same_node(&found, node);
    succeed(w->opened, svo_tree_find_cell(w->tree->tree, node->level, node->cell, &found));
    assert_same_node(&found, node);
    svo_grid_cell_box(&w->grid, node->level, node->cell, own_box[0], own_box[1]);
    succeed(w->opened, svo_tree_node_box(w->tree->tree, node->index, box[0], box[1]));
    assert_memory_equal(box, own_box, sizeof box);
    middle_of(&w->grid, node, middle);
    assert_true(svo_grid_cell_of_point(&w->grid, node->level, middle, cell) != 0);
    assert_memory_equal(cell, node->cell, sizeof cell);
    /* Within a level, nodes ascend by code. */
    const uint64_t code = svo_cell_to_code(node->cell);
    assert_true(code >= w->last_code[node->level]);
    w->last_code[node->level] = code + 1;
    ++w->visited;
}

/* An octant without a child: what is found there is the parent. */
static void check_gap(const walk *w, const svo_node *parent, const uint32_t cell[3])
{
    const svo_node empty = {.level = parent->level + 1, .cell = {cell[0], cell[1], cell[2]}};
    svo_node found;
    double middle[3];
    succeed(w->opened, svo_tree_find_cell(w->tree->tree, parent->level + 1, cell, &found));
    assert_same_node(&found, parent);
    middle_of(&w->grid, &empty, middle);
    succeed(w->opened, svo_tree_find_point(w->tree->tree, middle, &found));
    assert_same_node(&found, parent);
}

static void walk_tree(walk *w, const svo_node *node)
{
    check_node(w, node);
    if (node->level == w->grid.depth) {
        return;
    }
    svo_node child = {.index = w->tree->arrays.first_child[node->index], .level = node->level + 1};
    for (uint32_t octant = 0; octant < 8; ++octant) {
        for (uint32_t axis = 0; axis < 3; ++axis) {
            child.cell[axis] = 2 * node->cell[axis] + (octant >> axis & 1u);
        }
        if ((w->tree->arrays.child_mask[node->index] >> octant & 1) == 0) {
            check_gap(w, node, child.cell);
        } else {
            walk_tree(w, &child);
            ++child.index;
        }
    }
}

static void check_tree(const fixture *opened, const svo_mesh *mesh, unsigned depth, const svo_plan_options *options)
{
    built tree;
    fixture_build(opened, mesh, depth, options, &tree);
    walk w = {.opened = opened, .tree = &tree};
    const svo_node root = {.index = 0};
    succeed(opened, svo_tree_get_grid(tree.tree, &w.grid));
    walk_tree(&w, &root);
    assert_int_equal(w.visited, tree.info.node_count);
    svo_node node;
    const uint32_t outside[3] = {0, 1u << depth, 0};
    const uint32_t inside[3] = {0, 0, 0};
    double corner[3];
    assert_int_equal(svo_tree_find_node(tree.tree, (uint32_t)tree.info.node_count, &node), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_tree_find_cell(tree.tree, depth, outside, &node), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_tree_find_cell(tree.tree, depth + 1, inside, &node), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_tree_node_box(tree.tree, 0, corner, NULL), SVO_INVALID_ARGUMENT);
    built_destroy(&tree);
}

static void every_node_is_found_from_its_place_and_back(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_mesh none = {.struct_size = sizeof none};
    scene *knot = fixture_scene("knot:300");
    scene *dust = fixture_scene("dust:20");
    check_tree(&opened, scene_mesh(knot), 6, &(svo_plan_options){.need = SVO_NEED_NONE});
    check_tree(&opened, scene_mesh(knot), 1, &(svo_plan_options){.need = SVO_NEED_NONE});
    check_tree(&opened, scene_mesh(dust), 16, &(svo_plan_options){.need = SVO_NEED_NONE});
    check_tree(&opened, scene_mesh(knot), 5,
               &(svo_plan_options){.coverage = SVO_COVERAGE_CLOSED, .origin = {-1, 0, -0.7}, .edge = 2.3});
    check_tree(&opened, &none, 3, NULL);
    scene_destroy(&dust);
    scene_destroy(&knot);
}

/* Before a build. */
static svo_grid grid_of_plan(const svo_plan *plan)
{
    const svo_plan_info info = info_of_plan(plan);
    return (svo_grid){.depth = info.depth,
                      .snap_bits = info.snap_bits,
                      .origin = {info.origin[0], info.origin[1], info.origin[2]},
                      .scale = info.scale,
                      .edge = info.edge};
}

/* ---- grids ---- */

/* A grid of the caller's with powers of two: every figure is exact. */
static void boxes_of_a_callers_grid_have_closed_forms(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    scene *cube = fixture_scene("cube");
    const svo_plan_options options = {.struct_size = sizeof options, .origin = {-4, -4, -4}, .edge = 8};
    svo_plan *plan = NULL;
    double low[3];
    double high[3];
    uint32_t cell[3] = {7, 7, 7};
    succeed(&opened, svo_plan_create(opened.device, scene_mesh(cube), 5, &options, &plan));
    const svo_grid grid = grid_of_plan(plan);
    assert_true(svo_grid_cell_edge(&grid, 0) == 8 && svo_grid_cell_edge(&grid, 5) == 0.25);
    svo_grid_cell_box(&grid, 5, (const uint32_t[3]){0, 16, 31}, low, high);
    assert_true(low[0] == -4 && low[1] == 0 && low[2] == 3.75 && high[0] == -3.75 && high[1] == 0.25 && high[2] == 4);
    svo_grid_cell_box(&grid, 0, (const uint32_t[3]){0, 0, 0}, low, NULL);
    assert_true(low[0] == -4 && low[1] == -4 && low[2] == -4);
    /* A voxel holds its near faces alone, and what is between two units. */
    const double unit = 8.0 / 1048576;
    assert_true(svo_grid_cell_of_point(&grid, 5, (const double[3]){0, 0.25, 0.25 - unit}, cell) != 0);
    assert_true(cell[0] == 16 && cell[1] == 17 && cell[2] == 16);
    assert_true(svo_grid_cell_of_point(&grid, 5, (const double[3]){-4 + 0.4 * unit, 0.25 - 1e-9 * unit, 0}, cell) != 0);
    assert_true(cell[0] == 0 && cell[1] == 16 && cell[2] == 16);
    cell[0] = cell[1] = cell[2] = 99;
    assert_true(svo_grid_cell_of_point(&grid, 5, (const double[3]){-4 - 1e-9 * unit, 0, 0}, cell) == 0);
    assert_true(svo_grid_cell_of_point(&grid, 5, (const double[3]){0, 4, 0}, cell) == 0);
    assert_true(svo_grid_cell_of_point(&grid, 5, (const double[3]){0, 0, NAN}, cell) == 0);
    assert_true(svo_grid_cell_of_point(&grid, 5, (const double[3]){INFINITY, 0, 0}, cell) == 0);
    assert_true(cell[0] == 99 && cell[1] == 99 && cell[2] == 99);
    svo_plan_destroy(&plan);
    scene_destroy(&cube);
}

/* The mesh spans 2^20 - 1 of a fitted grid's 2^20 units, so its far end is in the last voxel. */
static void the_far_end_of_a_fitted_grid_is_in_the_last_voxel(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static const float corners[9] = {10.0F, 20.0F, 30.0F, 13.7F, 20.0F, 30.0F, 10.0F, 23.7F, 33.7F};
    const svo_mesh mesh = {.struct_size = sizeof mesh, .positions = corners, .vertex_count = 3, .triangle_count = 1};
    for (unsigned depth = 1; depth <= 16; ++depth) {
        svo_plan *plan = NULL;
        svo_plan_info info = SVO_PLAN_INFO_INIT;
        uint32_t cell[3];
        succeed(&opened, svo_plan_create(opened.device, &mesh, depth, NULL, &plan));
        succeed(&opened, svo_plan_get_info(plan, &info));
        const svo_grid grid = grid_of_plan(plan);
        assert_true(fabs(svo_grid_cell_edge(&grid, 0) / info.edge - 1.0) < 1e-15);
        for (int corner = 0; corner < 3; ++corner) {
            const double point[3] = {(double)corners[3 * corner], (double)corners[3 * corner + 1],
                                     (double)corners[3 * corner + 2]};
            assert_true(svo_grid_cell_of_point(&grid, depth, point, cell) != 0);
            assert_int_equal(cell[0], corner == 1 ? (1u << depth) - 1 : 0);
            assert_int_equal(cell[2], corner == 2 ? (1u << depth) - 1 : 0);
        }
        svo_plan_destroy(&plan);
    }
}

/* On any grid, the snapped vertices decide: each vertex is in a leaf. */
static void every_vertex_is_in_a_leaf(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static const struct {
        const char *scene;
        unsigned depth;
        double origin[3], edge;
    } cases[] = {{"knot:3000", 4, {0, 0, 0}, 0},
                 {"knot:3000", 8, {0, 0, 0}, 0},
                 {"knot:3000", 7, {-7, -9, -8}, 17},
                 {"dust:300", 12, {0, 0, 0}, 0},
                 {"dust:300", 16, {0, 0, 0}, 0}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        svo_plan_options options = {.need = SVO_NEED_NONE, .edge = cases[i].edge};
        scene *made = fixture_scene(cases[i].scene);
        const svo_mesh *mesh = scene_mesh(made);
        svo_node node;
        built tree;
        memcpy(options.origin, cases[i].origin, sizeof options.origin);
        fixture_build(&opened, mesh, cases[i].depth, &options, &tree);
        for (size_t v = 0; v < mesh->vertex_count; ++v) {
            const float *position = mesh->positions + 3 * v;
            const double point[3] = {(double)position[0], (double)position[1], (double)position[2]};
            succeed(&opened, svo_tree_find_point(tree.tree, point, &node));
            if (node.level != cases[i].depth || node.index < tree.info.inner_count) {
                fail_msg("case %zu: vertex %zu is in node %u of level %u", i, v, node.index, node.level);
            }
        }
        const double far_away[3] = {1e9, 0, 0};
        succeed(&opened, svo_tree_find_point(tree.tree, far_away, &node));
        assert_int_equal(node.index, SVO_NO_NODE);
        built_destroy(&tree);
        scene_destroy(&made);
    }
}

static void trees_without_host_arrays_are_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    scene *cube = fixture_scene("cube");
    svo_plan *plan = NULL;
    svo_tree *tree = NULL;
    svo_node node;
    svo_grid grid;
    double box[2][3];
    const double point[3] = {0, 0, 0};
    succeed(&opened, svo_plan_create(opened.device, scene_mesh(cube), 3, NULL, &plan));
    succeed(&opened, svo_build(plan, opened.frontend, opened.queue, &tree, NULL));
    succeed(&opened, svo_tree_get_grid(tree, &grid)); /* needs no arrays */
    assert_int_equal(svo_tree_find_point(tree, point, &node), SVO_INVALID_ARGUMENT);
    assert_non_null(strstr(svo_device_message(opened.device), "svo_tree_download"));
    assert_int_equal(svo_tree_find_node(tree, 0, &node), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_tree_node_box(tree, 0, box[0], box[1]), SVO_INVALID_ARGUMENT);
    succeed(&opened, svo_tree_download(tree, opened.queue));
    succeed(&opened, svo_tree_find_node(tree, 0, &node));
    assert_int_equal(svo_tree_find_node(tree, 0, NULL), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_tree_find_point(NULL, point, &node), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_tree_get_grid(tree, NULL), SVO_INVALID_ARGUMENT);
    svo_tree_destroy(&tree);
    svo_plan_destroy(&plan);
    scene_destroy(&cube);
}

/* ---- kernels ---- */

/* What a kernel finds for one node and one point. */
typedef struct found_places {
    svo_node by_index, by_cell, by_point;
    cl_uint leaf; /* whether the point is in one */
    float low[3], high[3], edge;
    cl_uint code_low, code_high;
    cl_uint cell[3]; /* of the code */
} found_places;

static const char places_kernel[] =
    "typedef struct found_places {\n"
    "    svo_node by_index, by_cell, by_point;\n"
    "    uint leaf;\n"
    "    float low[3], high[3], edge;\n"
    "    uint code_low, code_high;\n"
    "    uint cell[3];\n"
    "} found_places;\n"
    "__kernel void find_places(SVO_TREE_PARAMETERS, __global const float *points, __global found_places *found,\n"
    "                          uint node_count)\n"
    "{\n"
    "    SVO_TREE_MAKE(tree);\n"
    "    const uint i = (uint)get_global_id(0);\n"
    "    found_places made;\n"
    "    const bool known = svo_find_node(&tree, i, &made.by_index);\n"
    "    if (known != (i < node_count)) {\n"
    "        made.by_index.level = 99u;\n"
    "    }\n"
    "    made.leaf = svo_find_point(&tree, points[3 * i], points[3 * i + 1], points[3 * i + 2], &made.by_point);\n"
    "    if (known) {\n"
    "        svo_find_cell(&tree, made.by_index.level, made.by_index.cell, &made.by_cell);\n"
    "        svo_node_box(&tree, &made.by_index, made.low, made.high);\n"
    "        made.edge = svo_node_edge(&tree, made.by_index.level);\n"
    "        const ulong code = svo_cell_to_code(made.by_index.cell);\n"
    "        made.code_low = (uint)code;\n"
    "        made.code_high = (uint)(code >> 32);\n"
    "        svo_code_to_cell(code, made.cell);\n"
    "    }\n"
    "    found[i] = made;\n"
    "}\n";

static cl_kernel make_places_kernel(const fixture *opened)
{
    const char *sources[2] = {svo_kernel_source(svo_tree_target(NULL)), places_kernel};
    const cl_device_id device = info_of_device(opened->device).device;
    cl_program program = clCreateProgramWithSource(info_of_device(opened->device).context, 2, sources, NULL, NULL);
    if (clBuildProgram(program, 1, &device, svo_kernel_options(svo_tree_target(NULL)), NULL, NULL) != CL_SUCCESS) {
        static char log[4096];
        clGetProgramBuildInfo(program, device, CL_PROGRAM_BUILD_LOG, sizeof log, log, NULL);
        fail_msg("%s", log);
    }
    cl_kernel kernel = clCreateKernel(program, "find_places", NULL);
    clReleaseProgram(program);
    assert_non_null(kernel);
    return kernel;
}

static void run_places_kernel(const fixture *opened, cl_kernel kernel, const built *tree, const float *points,
                              found_places *found, size_t count)
{
    const cl_context context = info_of_device(opened->device).context;
    const cl_uint node_count = (cl_uint)tree->info.node_count;
    cl_mem input = clCreateBuffer(context, CL_MEM_READ_WRITE, count * 3 * sizeof *points, NULL, NULL);
    cl_mem output = clCreateBuffer(context, CL_MEM_READ_WRITE, count * sizeof *found, NULL, NULL);
    assert_non_null(input);
    assert_non_null(output);
    assert_int_equal(
        clEnqueueWriteBuffer(opened->queue, input, CL_TRUE, 0, count * 3 * sizeof *points, points, 0, NULL, NULL),
        CL_SUCCESS);
    succeed(opened, svo_kernel_set_arguments(svo_tree_target(tree->tree), kernel, 0));
    assert_int_equal(clSetKernelArg(kernel, SVO_TREE_ARGUMENTS, sizeof(cl_mem), &input), CL_SUCCESS);
    assert_int_equal(clSetKernelArg(kernel, SVO_TREE_ARGUMENTS + 1, sizeof(cl_mem), &output), CL_SUCCESS);
    assert_int_equal(clSetKernelArg(kernel, SVO_TREE_ARGUMENTS + 2, sizeof node_count, &node_count), CL_SUCCESS);
    assert_int_equal(clEnqueueNDRangeKernel(opened->queue, kernel, 1, NULL, &count, NULL, 0, NULL, NULL), CL_SUCCESS);
    assert_int_equal(
        clEnqueueReadBuffer(opened->queue, output, CL_TRUE, 0, count * sizeof *found, found, 0, NULL, NULL),
        CL_SUCCESS);
    clReleaseMemObject(input);
    clReleaseMemObject(output);
}

static void check_places(const fixture *opened, const built *tree, const svo_grid *grid, const float *point,
                         uint32_t index, const found_places *found)
{
    svo_node expected;
    double low[3];
    double high[3];
    const double wide[3] = {(double)point[0], (double)point[1], (double)point[2]};
    succeed(opened, svo_tree_find_point(tree->tree, wide, &expected));
    assert_same_node(&found->by_point, &expected);
    assert_int_equal(found->leaf, expected.index != SVO_NO_NODE && expected.level == grid->depth);
    if (index >= tree->info.node_count) {
        assert_int_equal(found->by_index.index, SVO_NO_NODE);
        return;
    }
    succeed(opened, svo_tree_find_node(tree->tree, index, &expected));
    assert_same_node(&found->by_index, &expected);
    assert_same_node(&found->by_cell, &expected);
    assert_true(((uint64_t)found->code_high << 32 | found->code_low) == svo_cell_to_code(expected.cell));
    assert_memory_equal(found->cell, expected.cell, sizeof expected.cell);
    svo_grid_cell_box(grid, expected.level, expected.cell, low, high);
    for (int axis = 0; axis < 3; ++axis) {
        assert_true(found->low[axis] == (float)low[axis] && found->high[axis] == (float)high[axis]);
    }
    assert_true(found->edge == (float)svo_grid_cell_edge(grid, expected.level));
}

/* Random points in and around the grid, and vertices of the mesh. */
static void make_points(const svo_mesh *mesh, const svo_tree_info *info, float *points, size_t count)
{
    uint64_t random = 11;
    for (size_t i = 0; i < count; ++i) {
        const size_t vertex = random_below(&random, (uint32_t)mesh->vertex_count);
        for (size_t axis = 0; axis < 3; ++axis) {
            points[3 * i + axis] = i % 2 == 0
                                       ? mesh->positions[3 * vertex + axis]
                                       : (float)(info->origin[axis] + (1.2 * random_unit(&random) - 0.1) * info->edge);
        }
    }
}

static void kernels_agree_with_the_host(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    cl_device_fp_config doubles = 0;
    clGetDeviceInfo(info_of_device(opened.device).device, CL_DEVICE_DOUBLE_FP_CONFIG, sizeof doubles, &doubles, NULL);
    if (doubles == 0) {
        print_message("skipped: the device has no double precision\n");
        skip();
    }
    const struct {
        unsigned depth;
        svo_plan_options options;
    } requests[] = {{5, {.need = SVO_NEED_NONE}},
                    {13, {.need = SVO_NEED_NONE}},
                    {7, {.need = SVO_NEED_RAYS, .origin = {-7, -9, -8}, .edge = 17}}};
    scene *knot = fixture_scene("knot:300");
    scene *dust = fixture_scene("dust:300");
    cl_kernel kernel = make_places_kernel(&opened);
    for (size_t r = 0; r < sizeof requests / sizeof requests[0]; ++r) {
        built tree;
        svo_grid grid;
        fixture_build(&opened, scene_mesh(r == 1 ? dust : knot), requests[r].depth, &requests[r].options, &tree);
        succeed(&opened, svo_tree_get_grid(tree.tree, &grid));
        const size_t count = (size_t)(tree.info.node_count + 8) / 8 * 8 + 8; /* some beyond the last node */
        float *points = calloc(count * 3, sizeof *points);
        found_places *found = calloc(count, sizeof *found);
        assert_true(points != NULL && found != NULL);
        make_points(scene_mesh(r == 1 ? dust : knot), &tree.info, points, count);
        run_places_kernel(&opened, kernel, &tree, points, found, count);
        for (size_t i = 0; i < count; ++i) {
            check_places(&opened, &tree, &grid, points + 3 * i, (uint32_t)i, &found[i]);
        }
        free(found);
        free(points);
        built_destroy(&tree);
    }
    clReleaseKernel(kernel);
    scene_destroy(&dust);
    scene_destroy(&knot);
}

TEST_GROUP(nodes)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(codes_and_cells_round_trip),
        cmocka_unit_test(every_node_is_found_from_its_place_and_back),
        cmocka_unit_test(boxes_of_a_callers_grid_have_closed_forms),
        cmocka_unit_test(the_far_end_of_a_fitted_grid_is_in_the_last_voxel),
        cmocka_unit_test(every_vertex_is_in_a_leaf),
        cmocka_unit_test(trees_without_host_arrays_are_refused),
        cmocka_unit_test(kernels_agree_with_the_host),
    };
    return cmocka_run_group_tests_name("nodes", tests, fixture_group_setup, fixture_group_teardown);
}
