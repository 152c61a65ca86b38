/* SPDX-License-Identifier: MIT */
/*
 * Handles of different threads are independent: two threads build at the same time and repeatedly, in one OpenCL
 * context with one queue each. Every tree equals the one that a single thread builds.
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

#include "support/fixture.h"
#include "support/gl_contexts.h"
#include "support/info_of.h"
#include "support/meshes.h"
#include "support/suite.h"

enum { THREADS = 2, ROUNDS = 6, MESHES = 3, TRIANGLES = 80, DEPTH = 6 };

static const svo_plan_options everything = {.struct_size = sizeof everything,
                                            .need = SVO_NEED_COLOR | SVO_NEED_NORMAL | SVO_NEED_RAYS};

/* One thread's work. cmocka's asserts work in the main thread only, so the outcome is counted. */
typedef struct worker {
    const fixture *shared; /* all threads use its device's OpenCL context */
    svo_gl_context_kind kind;
    svo_gl_share share;
    const owned_mesh *meshes;
    char (*hashes)[SVO_HASH_TEXT_BYTES];
    unsigned equal_count;
    svo_message message;
} worker;

static bool build_equals(const worker *self, svo_device *device, svo_gl *gl, cl_command_queue queue, unsigned which)
{
    svo_plan *plan = NULL;
    svo_tree *tree = NULL;
    char hash[SVO_HASH_TEXT_BYTES] = "";
    const bool done = svo_plan_create(device, &self->meshes[which].mesh, DEPTH + which, &everything, &plan) == SVO_OK &&
                      svo_build(plan, svo_gl_frontend(gl), queue, &tree, NULL) == SVO_OK &&
                      svo_tree_download(tree, queue) == SVO_OK && svo_tree_hash(tree, SVO_HASH_ALL, hash) == SVO_OK;
    svo_tree_destroy(&tree);
    svo_plan_destroy(&plan);
    return done && strcmp(hash, self->hashes[which]) == 0;
}

static void *work(void *pointer)
{
    worker *self = pointer;
    const svo_gl_options options = {.struct_size = sizeof options, .share = self->share};
    const cl_context context = info_of_device(self->shared->device).context;
    const cl_device_id id = info_of_device(self->shared->device).device;
    for (unsigned round = 0; round < ROUNDS; ++round) {
        svo_device *device = NULL;
        svo_gl_context *gl_context = NULL;
        svo_gl *gl = NULL;
        cl_command_queue queue = clCreateCommandQueue(context, id, 0, NULL);
        if (svo_device_create(context, id, NULL, &device, &self->message) == SVO_OK &&
            context_of_kind(self->kind, 0, &gl_context, &self->message) == SVO_OK &&
            svo_gl_create(device, gl_context, &options, &gl) == SVO_OK) {
            self->equal_count += build_equals(self, device, gl, queue, round % MESHES);
            self->equal_count += build_equals(self, device, gl, queue, (round + 1) % MESHES);
        }
        if (device != NULL && svo_device_message(device)[0] != '\0') {
            memcpy(self->message.text, svo_device_message(device), sizeof self->message.text);
        }
        svo_gl_destroy(&gl);
        svo_gl_context_destroy(&gl_context);
        svo_device_destroy(&device);
        clReleaseCommandQueue(queue);
    }
    return NULL;
}

static void check_threads(void **state, svo_gl_share share)
{
    const fixture *opened = fixture_of_group(state);
    svo_gl_context_info info = SVO_GL_CONTEXT_INFO_INIT;
    owned_mesh meshes[MESHES];
    char hashes[MESHES][SVO_HASH_TEXT_BYTES];
    worker workers[THREADS];
    pthread_t threads[THREADS];
    svo_gl_context_get_info(opened->context, &info);
    for (unsigned i = 0; i < MESHES; ++i) {
        built finished;
        random_mesh(40 + i, TRIANGLES, 0.0, &meshes[i]);
        fixture_build(opened, &meshes[i].mesh, DEPTH + i, &everything, &finished);
        memcpy(hashes[i], finished.hash, sizeof hashes[i]);
        built_destroy(&finished);
    }
    for (unsigned i = 0; i < THREADS; ++i) {
        workers[i] = (worker){.shared = opened, .kind = info.kind, .share = share, .meshes = meshes, .hashes = hashes};
        assert_int_equal(pthread_create(&threads[i], NULL, work, &workers[i]), 0);
    }
    for (unsigned i = 0; i < THREADS; ++i) {
        assert_int_equal(pthread_join(threads[i], NULL), 0);
    }
    for (unsigned i = 0; i < THREADS; ++i) {
        if (workers[i].equal_count != 2 * ROUNDS) {
            fail_msg("thread %u: %u of %d trees are equal; %s", i, workers[i].equal_count, 2 * ROUNDS,
                     workers[i].message.text);
        }
    }
    for (unsigned i = 0; i < MESHES; ++i) {
        owned_mesh_free(&meshes[i]);
    }
}

static void two_threads_build_at_once(void **state)
{
    check_threads(state, SVO_GL_SHARE_AUTO);
}

static void two_threads_build_at_once_through_copies(void **state)
{
    check_threads(state, SVO_GL_SHARE_COPY);
}

TEST_GROUP(threads)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(two_threads_build_at_once),
        cmocka_unit_test(two_threads_build_at_once_through_copies),
    };
    return cmocka_run_group_tests_name("threads", tests, fixture_group_setup, fixture_group_teardown);
}
