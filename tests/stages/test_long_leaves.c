/* SPDX-License-Identifier: MIT */
/*
 * Two hundred thousand triangles through one voxel. Drivers of GPUs stop launches that take too long, so on their path
 * no work-item may go through a leaf's triangles alone. All launches of a build are noted here. From the launch's size
 * follows how much of the longest list a work-item goes through; a kernel that the table does not know fails the test.
 * The tree is that of the CPU's path. There, launches of small trees are noted too, whose groups keep several threads
 * busy.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "core/device.h"
#include "shared/layout.h"
#include "shared/moving_layout.h"
#include "support/enqueued.h"
#include "support/fixture.h"
#include "support/meshes.h"
#include "support/suite.h"

#define TRIANGLES 200000u
#define MATERIALS 1000u
/* The most entries that a work-item may go through, all passes over them together. */
#define STEPS_MAX 65535u

#define LAUNCHES_MAX 256
#define NAME_BYTES   48

typedef struct noted_launch {
    char kernel[NAME_BYTES];
    size_t items, groups;
} noted_launch;

static struct {
    noted_launch launches[LAUNCHES_MAX];
    size_t count;
} notes;

/* NOLINTBEGIN(readability-identifier-naming) */
cl_int __real_clEnqueueNDRangeKernel(cl_command_queue queue, cl_kernel kernel, cl_uint dimensions, const size_t *offset,
                                     const size_t *global, const size_t *local, cl_uint num_wait, const cl_event *wait,
                                     cl_event *event);
cl_int __wrap_clEnqueueNDRangeKernel(cl_command_queue queue, cl_kernel kernel, cl_uint dimensions, const size_t *offset,
                                     const size_t *global, const size_t *local, cl_uint num_wait, const cl_event *wait,
                                     cl_event *event);

cl_int __wrap_clEnqueueNDRangeKernel(cl_command_queue queue, cl_kernel kernel, cl_uint dimensions, const size_t *offset,
                                     const size_t *global, const size_t *local, cl_uint num_wait, const cl_event *wait,
                                     cl_event *event)
{
    static const char of_plans[] = "svo_k_plan_"; /* before there are leaves */
    noted_launch launch = {.items = global[0], .groups = local != NULL ? global[0] / local[0] : 1};
    clGetKernelInfo(kernel, CL_KERNEL_FUNCTION_NAME, sizeof launch.kernel, launch.kernel, NULL);
    if (notes.count < LAUNCHES_MAX && strncmp(launch.kernel, of_plans, sizeof of_plans - 1) != 0) {
        notes.launches[notes.count++] = launch;
    }
    return __real_clEnqueueNDRangeKernel(queue, kernel, dimensions, offset, global, local, num_wait, wait, event);
}
/* NOLINTEND(readability-identifier-naming) */

/* How a kernel's longest loop depends on a leaf of many triangles. */
typedef enum reach {
    REACH_ONE, /* not at all: a work-item per fragment, block, node or tile of a scan */
    REACH_RUN, /* the part of it that is in one group */
    REACH_SHORT, /* a list of at most SVO_SHORT_LIST_MAX, six gaps */
    REACH_LEAF, /* a leaf of at most SVO_LONG_LEAF, merged by halves */
    REACH_STRIP, /* a part of it for each work-item of a group: two loops for each digit of 32 bits, and four more, or
                    less */
    REACH_MATERIALS, /* its materials, for eight children */
    REACH_KEPT, /* eight leaves of at most SVO_KEPT_LONG pairs, twice */
    REACH_PART, /* a part of the list: strips of two lists that are merged, or that nodes are made from */
    REACH_ALL /* all of it */
} reach;

static const struct {
    const char *kernel;
    reach reach;
} kernels[] = {
    {"svo_k_voxelize", REACH_ONE},
    {"svo_k_decide", REACH_ONE},
    {"svo_k_keep_decided", REACH_ONE},
    {"svo_k_mark", REACH_ONE},
    {"svo_k_mark_above", REACH_ONE},
    {"svo_k_count_blocks", REACH_ONE},
    {"svo_k_scan_blocks", REACH_ONE},
    {"svo_k_make_nodes", REACH_ONE},
    {"svo_k_make_top", REACH_ONE},
    {"svo_k_find_leaves", REACH_ONE},
    {"svo_k_count", REACH_ONE},
    {"svo_k_scan_lists_reduce", REACH_ONE},
    {"svo_k_scan_lists_add", REACH_ONE},
    {"svo_k_scatter", REACH_ONE},
    {"svo_k_sort_short", REACH_SHORT},
    {"svo_k_sort_long", REACH_STRIP},
    {"svo_k_material_scatter", REACH_ONE},
    {"svo_k_material_leaves", REACH_LEAF},
    {"svo_k_material_long", REACH_STRIP},
    {"svo_k_material_merge", REACH_MATERIALS},
    {"svo_k_material_top", REACH_MATERIALS},
    {"svo_k_clear_shared", REACH_ONE},
    {"svo_k_gather_pairs", REACH_RUN},
    {"svo_k_filter", REACH_ONE},
    {"svo_k_filter_top", REACH_ONE},
    {"svo_k_round_areas", REACH_ONE},
    {"svo_k_link", REACH_ONE},
    {"svo_k_gather_level", REACH_ALL},
    {"svo_k_sort_count", REACH_STRIP},
    {"svo_k_sort_scatter", REACH_STRIP},
    {"svo_k_merge_count", REACH_PART},
    {"svo_k_merge_write", REACH_PART},
    {"svo_k_moving_shift", REACH_ONE},
    {"svo_k_moving_number", REACH_ONE},
    {"svo_k_moving_weigh", REACH_ONE},
    {"svo_k_moving_begins", REACH_PART},
    {"svo_k_moving_levels", REACH_ONE},
    {"svo_k_moving_nodes", REACH_PART},
    {"svo_k_moving_long", REACH_STRIP},
    {"svo_k_moving_gather", REACH_KEPT},
    {"svo_k_moving_entries", REACH_ONE},
};

static uint64_t steps_of(const char *kernel, uint64_t triangles)
{
    static const uint64_t sums = 14, gaps = 6, halvings = 12, children = 8;
    const uint64_t strip = (triangles + SVO_GROUP_ITEMS - 1) / SVO_GROUP_ITEMS;
    const uint64_t passes = 2 * (32 / SVO_DIGIT_BITS) + 4;
    for (size_t i = 0; i < sizeof kernels / sizeof kernels[0]; ++i) {
        if (strcmp(kernels[i].kernel, kernel) == 0) {
            switch (kernels[i].reach) {
            case REACH_ONE:
                return 1;
            case REACH_RUN:
                return SVO_GROUP_ITEMS * sums;
            case REACH_SHORT:
                return SVO_SHORT_LIST_MAX * gaps;
            case REACH_LEAF:
                return SVO_LONG_LEAF * halvings;
            case REACH_STRIP:
                return strip * passes;
            case REACH_MATERIALS:
                return MATERIALS * children;
            case REACH_KEPT:
                return children * SVO_KEPT_LONG * 3;
            case REACH_PART:
                return SVO_MERGE_STRIP + SVO_NODE_STRIP * SVO_NODE_LEVELS;
            case REACH_ALL:
                return triangles;
            }
        }
    }
    fail_msg("%s: how much of a leaf its work-items go through is not known", kernel);
    return UINT64_MAX;
}

/* The most steps of a work-item, and the kernel that takes them. */
static uint64_t longest_item(const char **kernel)
{
    uint64_t most = 0;
    assert_in_range(notes.count, 1, LAUNCHES_MAX - 1);
    for (size_t i = 0; i < notes.count; ++i) {
        const uint64_t steps = steps_of(notes.launches[i].kernel, TRIANGLES);
        *kernel = steps > most ? notes.launches[i].kernel : *kernel;
        most = steps > most ? steps : most;
    }
    return most;
}

/* The first launch of a kernel, or nothing. */
static noted_launch launch_of(const char *kernel)
{
    for (size_t i = 0; i < notes.count; ++i) {
        if (strcmp(notes.launches[i].kernel, kernel) == 0) {
            return notes.launches[i];
        }
    }
    return (noted_launch){.items = 0};
}

static size_t items_of(const char *kernel)
{
    return launch_of(kernel).items;
}

/* Triangles in one voxel with a few of other materials beside them. */
typedef struct crowd {
    owned_mesh base;
    uint8_t *colors;
    uint16_t *triangle_materials;
    svo_material *materials;
} crowd;

static void crowd_create(crowd *out)
{
    static const double corner[3] = {0.3, 0.6, 0.9};
    uint64_t random = 19;
    random_dust(random, TRIANGLES, corner, 0.001, &out->base);
    out->colors = malloc((size_t)TRIANGLES * 12);
    out->triangle_materials = malloc(TRIANGLES * sizeof *out->triangle_materials);
    out->materials = calloc(MATERIALS, sizeof *out->materials);
    assert_non_null(out->colors);
    assert_non_null(out->triangle_materials);
    assert_non_null(out->materials);
    for (size_t i = 0; i < (size_t)TRIANGLES * 12; ++i) {
        out->colors[i] = (uint8_t)random_below(&random, 256);
    }
    for (size_t i = 0; i < TRIANGLES; ++i) {
        out->triangle_materials[i] = (uint16_t)random_below(&random, MATERIALS);
    }
    for (size_t i = 0; i < MATERIALS; ++i) {
        out->materials[i] = (svo_material){{255, 255, (uint8_t)i, 255}, SVO_NO_TEXTURE};
    }
    out->base.mesh.colors = out->colors;
    out->base.mesh.triangle_materials = out->triangle_materials;
    out->base.mesh.materials = out->materials;
    out->base.mesh.material_count = MATERIALS;
}

static void crowd_destroy(crowd *made)
{
    free(made->materials);
    free(made->triangle_materials);
    free(made->colors);
    owned_mesh_free(&made->base);
}

/* Builds on a path. The kernels are warm, so that what is noted is the build's own. */
static void build_on(const fixture *opened, bool cpu_path, const svo_mesh *mesh, const svo_plan_options *options,
                     built *out)
{
    opened->device->cpu_path = cpu_path;
    fixture_build(opened, mesh, 5, options, out);
    built_destroy(out);
    notes.count = 0;
    fixture_build(opened, mesh, 5, options, out);
}

static void no_work_item_goes_through_a_long_leaf(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_plan_options options = {.need = SVO_NEED_ALL, .edge = 1.0};
    const char *kernel = "";
    crowd made;
    built by_cpu, by_gpu;
    crowd_create(&made);
    build_on(&opened, true, &made.base.mesh, &options, &by_cpu);
    assert_in_range(by_cpu.info.leaf_count, 1, 8);
    if (items_of("svo_k_gather_level") > 0) { /* not on CPUs without exact doubles */
        assert_in_range(longest_item(&kernel), TRIANGLES, UINT64_MAX);
        assert_string_equal(kernel, "svo_k_gather_level");
    }
    build_on(&opened, false, &made.base.mesh, &options, &by_gpu);
    const uint64_t steps = longest_item(&kernel);
    print_message("%u triangles: at most %llu steps of a work-item, in %s\n", TRIANGLES, (unsigned long long)steps,
                  kernel);
    assert_in_range(steps, 1, STEPS_MAX);
    assert_in_range(items_of("svo_k_gather_pairs"), TRIANGLES, TRIANGLES * 8);
    assert_in_range(items_of("svo_k_material_long"), SVO_GROUP_ITEMS, TRIANGLES);
    assert_string_equal(by_gpu.hash, by_cpu.hash);
    built_destroy(&by_gpu);
    built_destroy(&by_cpu);
    crowd_destroy(&made);
}

/* A CPU runs a group on one thread, so the nodes of a small tree are gathered by several. */
static void small_trees_are_gathered_by_groups(void **state)
{
    static const double corner[3] = {0.1, 0.1, 0.1};
    const fixture opened = fixture_cl_of_group(state);
    const svo_plan_options options = {.need = SVO_NEED_NORMAL};
    owned_mesh dust;
    built small;
    random_dust(7, 20, corner, 0.8, &dust);
    build_on(&opened, true, &dust.mesh, &options, &small);
    const uint64_t parents = small.info.inner_count - small.info.level_begin[4];
    const size_t groups = launch_of("svo_k_gather_level").groups;
    if (items_of("svo_k_gather_pairs") == 0) { /* which is for CPUs without exact doubles */
        assert_in_range(parents, 2 * SVO_GATHER_NODES, SVO_GROUP_ITEMS * SVO_GATHER_NODES - 1);
        assert_int_equal(groups, (parents + SVO_GATHER_NODES - 1) / SVO_GATHER_NODES);
    }
    built_destroy(&small);
    owned_mesh_free(&dust);
}

/* Updates a scene that moves, and leaves the launches of the update. */
static void update_on(const fixture *opened, bool cpu_path, const crowd *made, char hash[SVO_HASH_TEXT_BYTES])
{
    static const double aside[12] = {1, 0, 0, 0.4, 0, 1, 0, 0.1, 0, 0, 1, -0.5};
    const svo_moving_options options = {.struct_size = sizeof options, .need = SVO_NEED_ALL, .edge = 1.0};
    svo_moving *moving = NULL;
    uint32_t object = 0;
    opened->device->cpu_path = cpu_path;
    succeed(opened, svo_moving_create(opened->device, &made->base.mesh, 5, &options, opened->queue, &moving));
    succeed(opened, svo_moving_add(moving, &made->base.mesh, NULL, &object));
    succeed(opened, svo_moving_update(moving, NULL, NULL));
    succeed(opened, svo_moving_set_transform(moving, object, aside));
    notes.count = 0;
    succeed(opened, svo_moving_update(moving, NULL, NULL));
    succeed(opened, svo_tree_download(svo_moving_tree(moving), opened->queue));
    succeed(opened, svo_tree_hash(svo_moving_tree(moving), SVO_HASH_ALL, hash));
    svo_moving_destroy(&moving);
}

static void nor_does_one_of_a_scene_that_moves(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    char by_cpu[SVO_HASH_TEXT_BYTES], by_gpu[SVO_HASH_TEXT_BYTES];
    const char *kernel = "";
    crowd made;
    crowd_create(&made);
    update_on(&opened, true, &made, by_cpu);
    assert_int_equal(items_of("svo_k_moving_long"), 0);
    update_on(&opened, false, &made, by_gpu);
    assert_in_range(longest_item(&kernel), 1, STEPS_MAX);
    assert_in_range(items_of("svo_k_moving_long"), 2 * TRIANGLES / SVO_KEPT_LONG * SVO_GROUP_ITEMS, TRIANGLES);
    assert_string_equal(by_gpu, by_cpu);
    crowd_destroy(&made);
}

TEST_GROUP(long_leaves)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(no_work_item_goes_through_a_long_leaf),
                                       cmocka_unit_test(small_trees_are_gathered_by_groups),
                                       cmocka_unit_test(nor_does_one_of_a_scene_that_moves)};
    return cmocka_run_group_tests_name("long_leaves", tests, fixture_group_setup_unoptimized,
                                       fixture_group_teardown_unoptimized);
}
