/* SPDX-License-Identifier: MIT */
/*
 * T1 golden: the golden counts through every front end: leaves are voxels, fragments are pairs, half-open and closed, at
 * every depth of the table that can be built.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "fixture.h"
#include "golden.h"

static void check_count(const fixture *opened, const svo_mesh *mesh, const char *name, const golden_count *count)
{
    /* A grid that leaves the table's coordinates as they are. */
    const svo_plan_options options = {.edge = 1u << GOLDEN_SNAP_BITS,
                                      .need = SVO_NEED_NONE,
                                      .coverage = count->is_closed ? SVO_COVERAGE_CLOSED : SVO_COVERAGE_HALF_OPEN};
    built actual;
    fixture_build(opened, mesh, count->depth, &options, &actual);
    if (actual.info.leaf_count != count->voxels || actual.info.fragments != count->pairs) {
        fail_msg("%s, %s at depth %u: %llu voxels and %llu pairs, not %llu and %llu", name,
                 svo_coverage_name(options.coverage), count->depth, (unsigned long long)actual.info.leaf_count,
                 (unsigned long long)actual.info.fragments, (unsigned long long)count->voxels,
                 (unsigned long long)count->pairs);
    }
    built_destroy(&actual);
}

/* Returns how many counts were compared. */
static size_t check_scene(const fixture *opened, const golden_scene *scene)
{
    const size_t vertex_count = scene->triangle_count * 3;
    float *positions = malloc(vertex_count * 3 * sizeof *positions);
    assert_non_null(positions);
    for (size_t i = 0; i < vertex_count * 3; ++i) {
        positions[i] = (float)scene->vertices[i]; /* below 2^24: exact */
    }
    const svo_mesh mesh = {.struct_size = sizeof mesh,
                           .positions = positions,
                           .vertex_count = vertex_count,
                           .triangle_count = scene->triangle_count};
    size_t compared = 0;
    for (size_t i = 0; i < scene->count_count; ++i) {
        const golden_count *count = &scene->counts[i];
        if (count->depth >= SVO_DEPTH_MIN) { /* a tree of depth 0 is not to be built */
            check_count(opened, &mesh, scene->name, count);
            ++compared;
        }
    }
    free(positions);
    return compared;
}

static void check_table(const fixture *opened)
{
    golden_table *table = golden_load(GOLDEN_COUNTS_PATH);
    assert_non_null(table);
    for (size_t i = 0; i < table->scene_count; ++i) {
        const size_t compared = check_scene(opened, &table->scenes[i]);
        print_message("%s: %zu counts\n", table->scenes[i].name, compared);
        assert_in_range(compared, 1, GOLDEN_COUNTS_MAX);
    }
    golden_free(table);
}

static void t1_golden_counts_are_reproduced_by_opencl(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    check_table(&opened);
}

static void t1_golden_counts_are_reproduced_by_opengl(void **state)
{
    check_table(fixture_of_group(state));
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(t1_golden_counts_are_reproduced_by_opencl),
                                       cmocka_unit_test(t1_golden_counts_are_reproduced_by_opengl)};
    return cmocka_run_group_tests(tests, fixture_group_setup, fixture_group_teardown);
}
