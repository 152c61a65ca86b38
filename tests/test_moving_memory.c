/* SPDX-License-Identifier: MIT */
/*
 * Memory of scenes that move: updates reuse the buffers of earlier ones, what is kept does not grow, and it goes where
 * memory is short.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "attributed_mesh.h"
#include "counting.h"
#include "enqueued.h"
#include "fixture.h"
#include "memory_ledger.h"

static svo_moving *make_moving(const fixture *opened, const svo_mesh *mesh, unsigned depth, svo_moving_options options)
{
    svo_moving *moving = NULL;
    options.struct_size = sizeof options;
    succeed(opened, svo_moving_create(opened->device, mesh, depth, &options, opened->queue, &moving));
    return moving;
}

static uint64_t kept_bytes(const fixture *opened, const svo_moving *moving)
{
    svo_moving_info info = SVO_MOVING_INFO_INIT;
    succeed(opened, svo_moving_get_info(moving, &info));
    return info.list_bytes;
}

/* ---- flat ---- */

/* An update of a triangle that moves to and fro, and hides now and then. What it does repeats every PERIOD times. */
enum { PERIOD = 7 * 64 };

static void flutter(const fixture *opened, svo_moving *moving, uint32_t object, int i)
{
    const double transform[12] = {1, 0, 0, (double)(i % 64) / 128.0, 0, 1, 0, 0, 0, 0, 1, 0};
    succeed(opened, svo_moving_set_transform(moving, object, transform));
    succeed(opened, svo_moving_show(moving, object, i % 7 != 0));
    succeed(opened, svo_moving_update(moving, opened->queue, NULL));
}

/* The most bytes that are kept after an update of a period. */
static uint64_t most_of_period(const fixture *opened, svo_moving *moving, uint32_t object)
{
    uint64_t most = 0;
    for (int i = 0; i < PERIOD; ++i) {
        flutter(opened, moving, object, i);
        const uint64_t bytes = kept_bytes(opened, moving);
        most = bytes > most ? bytes : most;
    }
    return most;
}

static void memory_is_flat(void **state)
{
    enum { PERIODS = 22 };
    (void)state;
    const svo_device_options device_options = {.struct_size = sizeof device_options, .memory = &ledger_callbacks};
    const float positions[9] = {0.1F, 0.1F, 0.1F, 0.3F, 0.1F, 0.1F, 0.1F, 0.4F, 0.1F};
    const svo_mesh mesh = {.struct_size = sizeof mesh, .positions = positions, .vertex_count = 3, .triangle_count = 1};
    const svo_moving_options options = {.need = SVO_NEED_RAYS | SVO_NEED_NORMAL, .edge = 1.0};
    fixture opened = {.device = NULL};
    uint32_t object = 0;
    assert_int_equal(svo_device_create_default(&device_options, &opened.device, NULL), SVO_OK);
    svo_moving *moving = make_moving(&opened, &mesh, 3, options);
    succeed(&opened, svo_moving_add(moving, &mesh, NULL, &object));
    uint64_t most = most_of_period(&opened, moving, object);
    ledger_begin(LEDGER_NEVER);
    const uint64_t blocks = ledger_end().live_blocks;
    for (int i = 1; i < PERIODS; ++i) {
        assert_true(most_of_period(&opened, moving, object) <= most);
    }
    assert_int_equal(ledger_end().live_blocks, blocks);
    assert_null(ledger_end().wrong);
    svo_moving_destroy(&moving);
    fixture_close(&opened);
}

/* ---- reused ---- */

/* Scales an object around a point of the unit cube. */
static void scale(const fixture *opened, svo_moving *moving, uint32_t object, double size, double at)
{
    const double transform[12] = {size, 0, 0, at, 0, size, 0, at, 0, 0, size, at};
    succeed(opened, svo_moving_set_transform(moving, object, transform));
}

/* After the first updates, a small change makes no buffer that is as large as the scene. */
static void updates_reuse_buffers(void **state)
{
    enum { WARM = 4, UPDATES = 4 };
    const fixture opened = fixture_cl_of_group(state);
    const svo_moving_options options = {.need = SVO_NEED_COLOR | SVO_NEED_NORMAL | SVO_NEED_RAYS, .edge = 1.0};
    uint32_t object = 0;
    attributed_mesh room;
    attributed_mesh thing;
    attributed_mesh_create(3, 150, 0.0, &room);
    attributed_mesh_create(4, 20, 0.0, &thing);
    svo_moving *moving = make_moving(&opened, &room.mesh, 7, options);
    succeed(&opened, svo_moving_add(moving, &thing.mesh, NULL, &object));
    for (int i = 0; i < WARM + UPDATES; ++i) {
        if (i == WARM) {
            counting_begin();
        }
        scale(&opened, moving, object, 0.05, i % 2 != 0 ? 0.2 : 0.7);
        succeed(&opened, svo_moving_update(moving, opened.queue, NULL));
    }
    const counted figures = counting_read();
    const uint64_t kept = kept_bytes(&opened, moving);
    if (figures.total_bytes > kept / 10) {
        print_error("%d updates made buffers of %llu bytes, beside %llu that are kept\n", UPDATES,
                    (unsigned long long)figures.total_bytes, (unsigned long long)kept);
    }
    assert_true(figures.total_bytes <= kept / 10);
    svo_moving_destroy(&moving);
    attributed_mesh_destroy(&thing);
    attributed_mesh_destroy(&room);
}

/* ---- short ---- */

typedef struct stage {
    attributed_mesh room, thing;
} stage;

static const double small = 0.03;
static const double large = 0.9;

static svo_status play(const fixture *opened, const stage *of, const double *sizes, size_t count, svo_moving **moving)
{
    const svo_moving_options options = {
        .struct_size = sizeof options, .need = SVO_NEED_NORMAL, .edge = 1.0, .max_area = 1000.0};
    const svo_status made = svo_moving_create(opened->device, &of->room.mesh, 6, &options, NULL, moving);
    uint32_t object = 0;
    if (made != SVO_OK) {
        return made;
    }
    succeed(opened, svo_moving_add(*moving, &of->thing.mesh, NULL, &object));
    for (size_t i = 0; i < count; ++i) {
        scale(opened, *moving, object, sizes[i], 0.05);
        const svo_status updated = svo_moving_update(*moving, NULL, NULL);
        if (updated != SVO_OK) {
            return updated;
        }
    }
    return SVO_OK;
}

/* Plays sizes of an object on a device of so many bytes. Returns whether all fit. */
static bool plays(const stage *of, uint64_t bytes, const double *sizes, size_t count)
{
    const svo_device_options device_options = {.struct_size = sizeof device_options, .max_device_bytes = bytes};
    fixture opened = {.device = NULL};
    svo_moving *moving = NULL;
    counting_begin(); /* of the programs of one device */
    assert_int_equal(svo_device_create_default(&device_options, &opened.device, NULL), SVO_OK);
    const svo_status status = play(&opened, of, sizes, count, &moving);
    if (status != SVO_OK) {
        assert_int_equal(status, SVO_OUT_OF_DEVICE_MEMORY);
    }
    svo_moving_destroy(&moving);
    fixture_close(&opened);
    return status == SVO_OK;
}

/* What an update from small to large needs is enough for it when larger buffers wait that do not fit. */
static void kept_buffers_go_when_memory_is_short(void **state)
{
    enum { STEPS = 12 };
    (void)state;
    const double grows[] = {small, large};
    const double waits[] = {small, large, 0.4, small, large};
    uint64_t fits = 64u << 20;
    uint64_t fails = 0;
    stage made;
    attributed_mesh_create(5, 10, 0.0, &made.room);
    attributed_mesh_create(6, 60, 0.0, &made.thing);
    assert_true(plays(&made, fits, grows, 2));
    for (int i = 0; i < STEPS; ++i) {
        const uint64_t bytes = (fits + fails) / 2;
        if (plays(&made, bytes, grows, 2)) {
            fits = bytes;
        } else {
            fails = bytes;
        }
    }
    assert_true(plays(&made, fits, waits, sizeof waits / sizeof waits[0]));
    attributed_mesh_destroy(&made.thing);
    attributed_mesh_destroy(&made.room);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(memory_is_flat),
        cmocka_unit_test(updates_reuse_buffers),
        cmocka_unit_test(kept_buffers_go_when_memory_is_short),
    };
    return cmocka_run_group_tests(tests, fixture_group_setup, fixture_group_teardown);
}
