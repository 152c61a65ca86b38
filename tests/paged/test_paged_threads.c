/* SPDX-License-Identifier: MIT */
/*
 * Paged trees of different threads are independent: two threads fly through one file at the same time, each with a
 * device handle of its own, and page in and out all the while. Pictures and counts are those of a single thread.
 * `tools/dev tsan` runs this.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <pthread.h>

#include "paged_walk.h"
#include "support/fixture_folder.h"
#include "support/info_of.h"
#include "support/suite.h"

enum { THREADS = 2, VIEWS = 8, DEPTH = 7, PAGE_LEVELS = 2 };

/* A thread's flight. cmocka's asserts work in the main thread only, so the outcome is counted. */
typedef struct flight {
    const paged_scene *of;
    const char *path;
    uint64_t budget;
    uint8_t *pictures; /* VIEWS of them */
    svo_paged_counts counts; /* at the end */
    unsigned done; /* views drawn and updated */
} flight;

static bool fly(flight *self, svo_paged *paged)
{
    for (unsigned view = 0; view < VIEWS; ++view) {
        const svo_render_options options = paged_view(self->of, SVO_VIEW_NORMAL, view * 3 % VIEWS, VIEWS);
        if (svo_paged_render(paged, &options, self->pictures + view * PAGED_BYTES) != SVO_OK ||
            svo_paged_update(paged) != SVO_OK) {
            return false;
        }
        ++self->done;
    }
    return svo_paged_get_counts(paged, &self->counts) == SVO_OK;
}

static void *run(void *pointer)
{
    flight *self = pointer;
    const svo_paged_options options = {.struct_size = sizeof options, .page_levels = PAGE_LEVELS};
    svo_device *device = NULL;
    svo_paged *paged = NULL;
    self->counts = (svo_paged_counts)SVO_PAGED_COUNTS_INIT;
    if (svo_device_create(info_of_device(self->of->opened.device).context,
                          info_of_device(self->of->opened.device).device, NULL, &device, NULL) == SVO_OK &&
        svo_paged_open(device, self->path, self->budget, &options, &paged) == SVO_OK && !fly(self, paged)) {
        self->done = 0;
    }
    svo_paged_close(&paged);
    svo_device_destroy(&device);
    return NULL;
}

static void check_equal(const flight *actual, const flight *expected)
{
    assert_int_equal(actual->done, VIEWS);
    assert_memory_equal(actual->pictures, expected->pictures, VIEWS * PAGED_BYTES);
    assert_memory_equal(&actual->counts, &expected->counts, sizeof actual->counts);
}

static void two_threads_page_one_file_at_once(void **state)
{
    paged_scene scene;
    flight flights[THREADS + 1];
    pthread_t threads[THREADS];
    char path[256];
    paged_scene_make(state, "statue:2000", DEPTH, 0, &scene);
    assert_true(strlen(path_of(scene.name)) < sizeof path);
    memcpy(path, path_of(scene.name), strlen(path_of(scene.name)) + 1);
    for (unsigned i = 0; i <= THREADS; ++i) {
        flights[i] = (flight){.of = &scene,
                              .path = path,
                              .budget = paged_scene_whole_bytes(&scene, PAGE_LEVELS) / 6,
                              .pictures = calloc(VIEWS, PAGED_BYTES)};
        assert_non_null(flights[i].pictures);
    }
    (void)run(&flights[THREADS]);
    assert_true(flights[THREADS].counts.all_evicted_pages > 0);
    for (unsigned i = 0; i < THREADS; ++i) {
        assert_int_equal(pthread_create(&threads[i], NULL, run, &flights[i]), 0);
    }
    for (unsigned i = 0; i < THREADS; ++i) {
        assert_int_equal(pthread_join(threads[i], NULL), 0);
    }
    for (unsigned i = 0; i < THREADS; ++i) {
        check_equal(&flights[i], &flights[THREADS]);
    }
    for (unsigned i = 0; i <= THREADS; ++i) {
        free(flights[i].pictures);
    }
    paged_scene_destroy(&scene);
}

TEST_GROUP(paged_threads)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(two_threads_page_one_file_at_once),
    };
    return cmocka_run_group_tests_name("paged_threads", tests, fixture_folder_setup, fixture_folder_teardown);
}
