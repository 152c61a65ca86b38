/* SPDX-License-Identifier: MIT */
/* Scans and sorts divide their work among as many groups as the device is wide. Trees do not depend on how many. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "core/device.h"
#include "core/work.h"
#include "scenes.h"
#include "shared/layout.h"
#include "support/fixture.h"
#include "support/suite.h"

/* Of groups, and of the sort's digits, which are wider on CPUs. */
static void trees_do_not_depend_on_the_widths(void **state)
{
    static const struct {
        uint32_t scan_groups, sort_groups;
    } widths[] = {{1, 1}, {3, 2}, {65, 16}, {2048, 512}};
    static const svo_builder builders[] = {SVO_BUILDER_CL, SVO_BUILDER_SORTED};
    const fixture opened = fixture_cl_of_group(state);
    scene *knot = fixture_scene("knot:3000");
    for (size_t b = 0; b < sizeof builders / sizeof builders[0]; ++b) {
        const svo_plan_options options = {.need = SVO_NEED_ALL, .builder = builders[b]};
        built usual;
        fixture_build(&opened, scene_mesh(knot), 8, &options, &usual);
        assert_in_range(usual.info.fragments, SVO_SORT_LONG_LIST, UINT64_MAX);
        for (size_t i = 0; i < sizeof widths / sizeof widths[0]; ++i) {
            const svo_device before = *opened.device;
            built forced;
            opened.device->cpu_path = false;
            opened.device->scan_groups = widths[i].scan_groups;
            opened.device->sort_groups = widths[i].sort_groups;
            fixture_build(&opened, scene_mesh(knot), 8, &options, &forced);
            assert_string_equal(forced.hash, usual.hash);
            built_destroy(&forced);
            opened.device->cpu_path = before.cpu_path;
            opened.device->scan_groups = before.scan_groups;
            opened.device->sort_groups = before.sort_groups;
        }
        built_destroy(&usual);
    }
    scene_destroy(&knot);
}

/* Buffers that would be parts of an allocation larger than the device allows are made one by one. */
static void trees_do_not_depend_on_the_largest_allocation(void **state)
{
    static const svo_path paths[] = {SVO_PATH_CPU, SVO_PATH_GPU};
    scene *knot = fixture_scene("knot:3000");
    (void)state;
    for (size_t i = 0; i < sizeof paths / sizeof paths[0]; ++i) {
        fixture opened;
        built usual;
        built forced;
        enum { LEAF_BYTES = 48 }; /* of the largest sums of leaves, which a list of several chunks has on CPUs too */
        const svo_plan_options options = {.need = SVO_NEED_ALL, .place = SVO_PLACE_DEVICE};
        fixture_open_cl(&(fixture_options){.path = paths[i]}, &opened);
        fixture_build(&opened, scene_mesh(knot), 7, &options, &usual);
        uint64_t largest = (usual.info.leaf_count + 16) * LEAF_BYTES;
        for (size_t k = 0; k < usual.buffer_count; ++k) {
            largest = usual.buffers[k].bytes > largest ? usual.buffers[k].bytes : largest;
        }
        opened.device->max_allocation_bytes = largest; /* below the bytes of a stage's buffers together */
        fixture_build(&opened, scene_mesh(knot), 7, &options, &forced);
        assert_string_equal(forced.hash, usual.hash);
        assert_true(forced.plan.peak_bytes > largest);
        built_destroy(&forced);
        built_destroy(&usual);
        fixture_close(&opened);
    }
    scene_destroy(&knot);
}

/* At least one, one for each tile, and no more than have a place for their sums. */
static void scans_have_at_most_the_devices_groups(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const uint32_t most = opened.device->scan_groups;
    assert_int_equal(svo_i_scan_groups(opened.device, 0), 1);
    assert_int_equal(svo_i_scan_groups(opened.device, SVO_SCAN_TILE), 1);
    assert_int_equal(svo_i_scan_groups(opened.device, (uint64_t)most * SVO_SCAN_TILE), most);
    assert_int_equal(svo_i_scan_groups(opened.device, (uint64_t)most * SVO_SCAN_TILE + 1), most);
    assert_int_equal(svo_i_scan_groups(opened.device, UINT32_MAX), most);
}

TEST_GROUP(widths)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(trees_do_not_depend_on_the_widths),
                                       cmocka_unit_test(trees_do_not_depend_on_the_largest_allocation),
                                       cmocka_unit_test(scans_have_at_most_the_devices_groups)};
    return cmocka_run_group_tests_name("widths", tests, fixture_group_setup_unoptimized,
                                       fixture_group_teardown_unoptimized);
}
