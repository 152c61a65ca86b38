/* SPDX-License-Identifier: MIT */
/*
 * The memory of edits: many steps stay within the plan, what is collected is what no version needs, and steps that run
 * out of memory or are canceled leave everything as it was.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#include "support/fixture.h"
#include "support/meshes.h"
#include "support/suite.h"

#define SEGMENT_BYTES 0x106000u /* of 2^17 units of 8 bytes, with the bits and numbers of a collection */

static svo_edit_info info_of(const svo_edit *edit)
{
    svo_edit_info info = SVO_EDIT_INFO_INIT;
    assert_int_equal(svo_edit_get_info(edit, &info), SVO_OK);
    return info;
}

static svo_edit *make_edit(const svo_voxels *voxels, const svo_edit_options *options)
{
    svo_edit *made = NULL;
    svo_message message = {""};
    if (svo_edit_create(voxels, options, &made, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    return made;
}

static svo_voxels *list_of(const svo_edit *edit)
{
    svo_voxels *made = NULL;
    assert_int_equal(svo_edit_get_voxels(edit, &made, NULL), SVO_OK);
    return made;
}

/* Colors of their own, so that no block is uniform. */
static svo_edit_step random_brush(uint64_t *seed, int edge)
{
    svo_edit_step step = SVO_EDIT_STEP_INIT;
    const uint32_t color = random_word(seed);
    step.verb = random_below(seed, 5);
    step.verb = step.verb == SVO_EDIT_KEEP ? SVO_EDIT_CLEAR : step.verb;
    step.shape = random_below(seed, 3);
    step.radius = step.shape == SVO_EDIT_BOX ? 0.0 : 1.0 + random_unit(seed) * 5.0;
    for (int axis = 0; axis < 3; ++axis) {
        step.begin[axis] = random_unit(seed) * edge;
        step.end[axis] = step.begin[axis] + random_unit(seed) * 8.0;
    }
    memcpy(step.rgba, &color, 4);
    return step;
}

static bool are_same(const svo_edit *left, const svo_edit *right)
{
    svo_voxels *lists[2] = {list_of(left), list_of(right)};
    svo_voxels_info infos[2] = {SVO_VOXELS_INFO_INIT, SVO_VOXELS_INFO_INIT};
    for (int i = 0; i < 2; ++i) {
        assert_int_equal(svo_voxels_get_info(lists[i], &infos[i]), SVO_OK);
    }
    const bool same =
        infos[0].voxel_count == infos[1].voxel_count &&
        memcmp(svo_voxels_get(lists[0]), svo_voxels_get(lists[1]), infos[0].voxel_count * sizeof(svo_voxel)) == 0;
    svo_voxels_destroy(&lists[0]);
    svo_voxels_destroy(&lists[1]);
    return same;
}

/* A million steps where SVOCL_LONG_TESTS is set (tools/dev long). */
static void many_steps_stay_within_the_plan(void **state)
{
    (void)state;
    const int count = suite_is_long() ? 1000000 : 100000;
    const svo_edit_options options = {.struct_size = sizeof options, .undo_count = 8};
    svo_edit *edit = make_edit(NULL, &options);
    uint64_t seed = 3;
    uint64_t bound = 0;
    for (int i = 0; i < count; ++i) {
        const svo_edit_step step = random_brush(&seed, 100);
        bound = info_of(edit).collect_bytes > bound ? info_of(edit).collect_bytes : bound;
        assert_int_equal(svo_edit_apply(edit, &step, NULL), SVO_OK);
        const svo_edit_info info = info_of(edit);
        assert_in_range(info.held_bytes, 1, info.collect_bytes + info.step_bytes + SEGMENT_BYTES);
    }
    const svo_edit_info info = info_of(edit);
    assert_in_range(info.collections, 10, (uint64_t)count / 10);
    assert_in_range(info.peak_bytes, 1, bound + 2u * SEGMENT_BYTES);
    /* What is kept is one tree and a few steps. */
    svo_voxels *list = list_of(edit);
    svo_edit *fresh = make_edit(list, NULL);
    svo_edit_collect(edit);
    assert_in_range(info_of(edit).kept_bytes, info_of(fresh).kept_bytes, info_of(fresh).kept_bytes + SEGMENT_BYTES);
    assert_true(are_same(edit, fresh));
    print_message("%d steps: %llu voxels, %llu KiB kept, at most %llu KiB held, %llu collections\n", count,
                  (unsigned long long)info.voxel_count, (unsigned long long)info_of(edit).kept_bytes / 1024,
                  (unsigned long long)info.peak_bytes / 1024, (unsigned long long)info.collections);
    svo_voxels_destroy(&list);
    svo_edit_destroy(&edit);
    svo_edit_destroy(&fresh);
}

/* In a single segment, until not even a collection makes room. */
static void a_budget_that_is_too_small_leaves_the_old(void **state)
{
    (void)state;
    const svo_edit_options options = {.struct_size = sizeof options, .max_bytes = SVO_EDIT_BYTES_MIN, .undo_count = 2};
    svo_edit *edit = make_edit(NULL, &options);
    svo_edit *twin = make_edit(NULL, NULL);
    svo_message message = {""};
    uint64_t seed = 8;
    int failed = 0;
    for (int i = 0; i < 4000; ++i) {
        svo_edit_step step = random_brush(&seed, 80);
        step.verb = i % 2 == 0 ? SVO_EDIT_SET : SVO_EDIT_ADD;
        const svo_edit_info before = info_of(edit);
        const svo_status status = svo_edit_apply(edit, &step, &message);
        const svo_edit_info after = info_of(edit);
        assert_in_range(after.peak_bytes, 0, SVO_EDIT_BYTES_MIN);
        if (status == SVO_OK) {
            assert_int_equal(svo_edit_apply(twin, &step, NULL), SVO_OK);
            continue;
        }
        assert_int_equal(status, SVO_CAPACITY_EXCEEDED);
        assert_string_equal(message.text, "svo_edit_apply: the nodes need more than max_bytes, 2.0 MiB");
        assert_int_equal(after.voxel_count, before.voxel_count);
        assert_int_equal(after.undo_count, before.undo_count);
        assert_int_equal(after.redo_count, before.redo_count);
        if (failed++ % 5 == 0) {
            assert_true(are_same(edit, twin));
        }
        if (failed > 10) {
            break;
        }
    }
    assert_in_range(failed, 1, 4000);
    assert_true(info_of(edit).collections > 0);
    /* Without the versions before there is room again. */
    svo_edit_forget(edit);
    svo_edit_step step = SVO_EDIT_STEP_INIT;
    step.verb = SVO_EDIT_CLEAR;
    for (int axis = 0; axis < 3; ++axis) {
        step.begin[axis] = -10.0;
        step.end[axis] = axis < 2 ? 100.0 : 48.0;
    }
    assert_int_equal(info_of(edit).undo_count, 0);
    assert_int_equal(svo_edit_apply(edit, &step, &message), SVO_OK);
    assert_int_equal(svo_edit_apply(twin, &step, &message), SVO_OK);
    assert_true(are_same(edit, twin));
    assert_int_equal(info_of(edit).undo_count, 1);
    svo_edit_destroy(&edit);
    svo_edit_destroy(&twin);
}

/* Voxels with colors of their own, 4 bytes each and 16 for a block. */
static void a_list_above_the_budget_is_refused(void **state)
{
    (void)state;
    enum { EDGE = 80 };
    const svo_edit_options options = {.struct_size = sizeof options, .max_bytes = SVO_EDIT_BYTES_MIN};
    svo_voxels_source source = SVO_VOXELS_SOURCE_INIT;
    svo_voxel *voxels = calloc((size_t)EDGE * EDGE * EDGE, sizeof *voxels);
    svo_voxels *list = NULL;
    svo_edit *edit = NULL;
    svo_message message = {""};
    assert_non_null(voxels);
    for (int i = 0; i < EDGE * EDGE * EDGE; ++i) {
        voxels[i] = (svo_voxel){.x = i % EDGE, .y = i / EDGE % EDGE, .z = i / EDGE / EDGE, .rgba = {(uint8_t)i}};
    }
    source.voxels = voxels;
    source.voxel_count = (uint64_t)EDGE * EDGE * EDGE;
    assert_int_equal(svo_voxels_create(&source, &list, &message), SVO_OK);
    assert_int_equal(svo_edit_create(list, &options, &edit, &message), SVO_CAPACITY_EXCEEDED);
    assert_string_equal(message.text, "svo_edit_create: 512000 voxels need more than max_bytes, 2.0 MiB");
    assert_null(edit);
    svo_voxels_destroy(&list);
    free(voxels);
}

/* Counts calls, and stops the one whose number is stop_at. */
typedef struct counter {
    int calls;
    int stop_at;
    double last;
} counter;

static int count_call(void *user, double fraction)
{
    counter *c = user;
    assert_true(fraction >= 0.0 && fraction <= 1.0);
    assert_true(c->calls == 0 || fraction > c->last);
    c->last = fraction;
    return ++c->calls == c->stop_at;
}

static void progress_tells_and_stops(void **state)
{
    (void)state;
    counter c = {.stop_at = 0};
    const svo_edit_options options = {.struct_size = sizeof options, .progress = count_call, .progress_user = &c};
    svo_edit *edit = make_edit(NULL, &options);
    svo_edit_step step = SVO_EDIT_STEP_INIT;
    step.shape = SVO_EDIT_SPHERE;
    step.radius = 150.0;
    assert_int_equal(svo_edit_apply(edit, &step, NULL), SVO_OK);
    assert_true(c.last == 1.0);
    const int calls = c.calls;
    assert_in_range(calls, 10, 10000);
    const uint64_t voxel_count = info_of(edit).voxel_count;
    const int32_t offset[3] = {13, 1, -5};
    for (int copies = 0; copies < 2; ++copies) {
        for (int stop_at = 1; stop_at < calls; stop_at += calls / 9) {
            svo_message message = {""};
            c = (counter){.stop_at = stop_at};
            const svo_status status =
                copies != 0 ? svo_edit_copy(edit, &step, offset, &message) : svo_edit_apply(edit, &step, &message);
            assert_int_equal(status, c.calls < stop_at ? SVO_OK : SVO_CANCELED);
            if (c.calls == stop_at) {
                assert_non_null(strstr(message.text, ": the progress callback stopped the call at "));
                assert_int_equal(info_of(edit).undo_count, 1);
                assert_int_equal(info_of(edit).voxel_count, voxel_count);
            } else {
                assert_int_equal(svo_edit_undo(edit), SVO_OK);
            }
        }
        step.verb = SVO_EDIT_PAINT; /* walks through all that is there */
        step.material = 1;
    }
    svo_edit_destroy(&edit);
}

/* Blocks that the caller's functions gave and have not got back. */
static void *count_block(void *user, size_t bytes, size_t alignment)
{
    (void)alignment;
    ++*(int *)user;
    return malloc(bytes);
}

static void release_block(void *user, void *block, size_t bytes, size_t alignment)
{
    (void)bytes;
    (void)alignment;
    --*(int *)user;
    free(block);
}

static void all_memory_is_the_callers(void **state)
{
    (void)state;
    int blocks = 0;
    const svo_memory_callbacks memory = {
        .struct_size = sizeof memory, .allocate = count_block, .release = release_block, .user = &blocks};
    const svo_edit_options options = {.struct_size = sizeof options, .memory = &memory};
    svo_edit *edit = make_edit(NULL, &options);
    uint64_t seed = 1;
    for (int i = 0; i < 200; ++i) {
        const svo_edit_step step = random_brush(&seed, 60);
        assert_int_equal(svo_edit_apply(edit, &step, NULL), SVO_OK);
    }
    svo_edit_collect(edit);
    assert_in_range(blocks, 5, 100);
    svo_voxels *list = list_of(edit);
    svo_edit_destroy(&edit);
    svo_voxels_destroy(&list);
    assert_int_equal(blocks, 0);
}

TEST_GROUP(edit_memory)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(many_steps_stay_within_the_plan),
        cmocka_unit_test(a_budget_that_is_too_small_leaves_the_old),
        cmocka_unit_test(a_list_above_the_budget_is_refused),
        cmocka_unit_test(progress_tells_and_stops),
        cmocka_unit_test(all_memory_is_the_callers),
    };
    return cmocka_run_group_tests_name("edit_memory", tests, NULL, NULL);
}
