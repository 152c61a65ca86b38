/* SPDX-License-Identifier: MIT */
/*
 * svo_light_set_sources as a whole: the same bytes on every run and with any number of threads; new sources rerun the
 * stages of sources alone; what is refused, and that a refusal leaves the light dark.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <sys/wait.h>
#include <unistd.h>

#include "light_fixture.h"
#include "support/counting.h"
#include "support/meshes.h"
#include "support/suite.h"

#define DEPTH 6
/* The descriptor that a child writes hashes to; cmocka has the standard output. */
#define HASHES 9

static const svo_plan_options everything = {.need = SVO_NEED_COLOR | SVO_NEED_NORMAL | SVO_NEED_RAYS |
                                                    SVO_NEED_MATERIAL | SVO_NEED_FILL};

static const svo_light_source sources[] = {
    {.kind = SVO_SOURCE_DIRECTIONAL, .direction = {-0.3F, -1.0F, -0.2F}, .value = {3.0F, 2.0F, 1.0F}},
    {.kind = SVO_SOURCE_POINT, .position = {0.6F, 0.7F, 0.5F}, .value = {0.1F, 0.0F, 0.5F}},
    {.kind = SVO_SOURCE_SPOT,
     .position = {2.0F, 0.5F, 0.4F},
     .direction = {-1.0F, 0.0F, 0.1F},
     .value = {2.0F, 2.0F, 5.0F},
     .inner_angle = 0.2F,
     .outer_angle = 0.5F},
};

/* Random triangles, and their light. */
typedef struct lit_scene {
    owned_mesh random;
    built made;
    svo_light *light;
} lit_scene;

static void open_scene(const fixture *opened, svo_light_form form, lit_scene *out)
{
    random_mesh(7, 400, 0, &out->random);
    fixture_build(opened, &out->random.mesh, DEPTH, &everything, &out->made);
    out->light = light_of(opened, out->made.tree, form);
}

static void close_scene(lit_scene *scene)
{
    svo_light_destroy(&scene->light);
    built_destroy(&scene->made);
    owned_mesh_free(&scene->random);
}

static svo_light_setup setup_of(const svo_light_source *list, size_t count)
{
    svo_light_setup setup = SVO_LIGHT_SETUP_INIT;
    setup.sources = list;
    setup.source_count = count;
    return setup;
}

/* The hashes of all forms with all sources, one after the other. */
static void hash_forms(const fixture *opened, char text[SVO_LIGHT_FORM_COUNT * SVO_HASH_TEXT_BYTES])
{
    const svo_light_setup setup = setup_of(sources, 3);
    for (int form = 0; form < SVO_LIGHT_FORM_COUNT; ++form) {
        lit_scene scene;
        char *hash = text + form * (SVO_HASH_TEXT_BYTES - 1);
        open_scene(opened, (svo_light_form)form, &scene);
        light_succeed(opened, svo_light_set_sources(scene.light, &setup, opened->queue));
        light_succeed(opened, svo_light_hash(scene.light, opened->queue, hash));
        close_scene(&scene);
    }
}

/* ---- the same bytes ---- */

static void test_repeated_runs_have_the_same_hash(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_light_setup all = setup_of(sources, 3);
    const svo_light_setup one = setup_of(sources, 1);
    for (int form = 0; form < SVO_LIGHT_FORM_COUNT; ++form) {
        lit_scene scene;
        char first[SVO_HASH_TEXT_BYTES];
        char other[SVO_HASH_TEXT_BYTES];
        char again[SVO_HASH_TEXT_BYTES];
        char none[SVO_HASH_TEXT_BYTES];
        char dark[SVO_HASH_TEXT_BYTES];
        open_scene(&opened, (svo_light_form)form, &scene);
        light_succeed(&opened, svo_light_hash(scene.light, opened.queue, none));
        light_succeed(&opened, svo_light_set_sources(scene.light, &all, opened.queue));
        light_succeed(&opened, svo_light_hash(scene.light, opened.queue, first));
        light_succeed(&opened, svo_light_set_sources(scene.light, &one, opened.queue));
        light_succeed(&opened, svo_light_hash(scene.light, opened.queue, other));
        light_succeed(&opened, svo_light_set_sources(scene.light, &all, NULL));
        light_succeed(&opened, svo_light_hash(scene.light, opened.queue, again));
        light_succeed(&opened, svo_light_set_sources(scene.light, NULL, opened.queue));
        light_succeed(&opened, svo_light_hash(scene.light, opened.queue, dark));
        assert_string_equal(first, again);
        assert_string_not_equal(first, other);
        assert_string_equal(none, dark);
        close_scene(&scene);
    }
}

/* Runs this program with a number of PoCL's threads and reads the hashes that it prints. */
static void hash_with_threads(const char *threads, char *text, size_t bytes)
{
    int ends[2];
    size_t length = 0;
    assert_int_equal(pipe(ends), 0);
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        dup2(ends[1], HASHES);
        setenv("POCL_MAX_PTHREAD_COUNT", threads, 1);
        execl("/proc/self/exe", "test_light", "light_source_hashes", (char *)NULL);
        _exit(127);
    }
    close(ends[1]);
    for (ssize_t got = 1; got > 0; length += (size_t)got) {
        got = read(ends[0], text + length, bytes - 1 - length);
        got = got > 0 ? got : 0;
    }
    text[length] = '\0';
    close(ends[0]);
    int status = 0;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), 0);
}

static void test_threads_do_not_matter(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    char own[SVO_LIGHT_FORM_COUNT * SVO_HASH_TEXT_BYTES];
    char other[SVO_LIGHT_FORM_COUNT * SVO_HASH_TEXT_BYTES];
    hash_forms(&opened, own);
    assert_int_equal(strlen(own), SVO_LIGHT_FORM_COUNT * (SVO_HASH_TEXT_BYTES - 1));
    hash_with_threads("1", other, sizeof other);
    assert_string_equal(own, other);
    hash_with_threads("5", other, sizeof other);
    assert_string_equal(own, other);
}

/* ---- what runs ---- */

/* New sources compile nothing, make no opacity, and leave no buffers of the old ones behind. */
static void test_new_sources_rerun_their_own_stages(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_light_setup all = setup_of(sources, 3);
    for (int form = 0; form < SVO_LIGHT_FORM_COUNT; ++form) {
        lit_scene scene;
        open_scene(&opened, (svo_light_form)form, &scene);
        uint32_t *before = light_read(&opened, scene.light, SVO_LIGHT_OPACITY);
        const cl_mem opacity = svo_light_get_buffer(scene.light, SVO_LIGHT_OPACITY);
        light_succeed(&opened, svo_light_set_sources(scene.light, &all, opened.queue));
        counting_begin();
        light_succeed(&opened, svo_light_set_sources(scene.light, &all, opened.queue));
        const counted first = counting_read();
        const svo_light_info info = light_info_of(scene.light);
        counting_begin();
        light_succeed(&opened, svo_light_set_sources(scene.light, &all, opened.queue));
        const counted second = counting_read();
        assert_int_equal(first.programs, 0);
        assert_int_equal(first.launched_items, second.launched_items);
        assert_int_equal(first.buffers, second.buffers);
        assert_int_equal(second.live_buffers, 3);
        assert_int_equal(second.live_bytes,
                         info.bytes[SVO_LIGHT_LIT] + info.bytes[SVO_LIGHT_RADIANCE] + info.bytes[SVO_LIGHT_FLUX]);
        assert_in_range(second.peak_bytes, info.scratch_bytes, info.scratch_bytes + second.live_bytes);
        assert_true(opacity == svo_light_get_buffer(scene.light, SVO_LIGHT_OPACITY));
        uint32_t *after = light_read(&opened, scene.light, SVO_LIGHT_OPACITY);
        assert_memory_equal(before, after, info.bytes[SVO_LIGHT_OPACITY]);
        free(before);
        free(after);
        close_scene(&scene);
    }
}

/* ---- what is refused ---- */

typedef struct refusal {
    svo_light_setup setup;
    const char *message;
} refusal;

#define ONE_SOURCE(...)                                                                                 \
    {                                                                                                   \
        .struct_size = sizeof(svo_light_setup), .source_count = 1, .sources = &(const svo_light_source) \
        {                                                                                               \
            __VA_ARGS__                                                                                 \
        }                                                                                               \
    }
#define ONE_FINISH(...)                                                                            \
    {                                                                                              \
        .struct_size = sizeof(svo_light_setup), .finish_count = 1, .finishes = &(const svo_finish) \
        {                                                                                          \
            __VA_ARGS__                                                                            \
        }                                                                                          \
    }

static void test_bad_setups_are_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const refusal refusals[] = {
        {ONE_SOURCE(.kind = 4), "setup.sources[0].kind 4 is not in 0 .. 3"},
        {ONE_SOURCE(.kind = 3), "setup.sources[0].direction is zero"},
        {ONE_SOURCE(.kind = 1, .value = {0, -2, 0}), "setup.sources[0].value -2 is negative"},
        {ONE_SOURCE(.kind = 1, .value = {NAN, 0, 0}), "setup.sources[0].value nan is not finite"},
        {ONE_SOURCE(.kind = 1, .position = {0, 0, INFINITY}), "setup.sources[0].position inf is not finite"},
        {ONE_SOURCE(.kind = 0, .value = {1, 1, 1}), "setup.sources[0].direction is zero"},
        {ONE_SOURCE(.kind = 0, .direction = {0, -INFINITY, 0}), "setup.sources[0].direction -inf is not finite"},
        {ONE_SOURCE(.kind = 2, .inner_angle = 0.5F, .outer_angle = 1), "setup.sources[0].direction is zero"},
        {ONE_SOURCE(.kind = 2, .direction = {0, 1, 0}, .inner_angle = 0.5F, .outer_angle = 0.5F),
         "setup.sources[0].outer_angle 0.5 is not above inner_angle 0.5"},
        {ONE_SOURCE(.kind = 2, .direction = {0, 1, 0}, .inner_angle = -0.5F, .outer_angle = 0.5F),
         "setup.sources[0].inner_angle -0.5 is negative"},
        {ONE_SOURCE(.kind = 2, .direction = {0, 1, 0}, .inner_angle = 0.5F, .outer_angle = 1.75F),
         "setup.sources[0].outer_angle 1.75 is not below pi / 2"},
        {ONE_SOURCE(.kind = 1, .radius = -0.5F), "setup.sources[0].radius -0.5 is negative"},
        {ONE_SOURCE(.kind = 0, .direction = {0, 1, 0}, .radius = 1.75F),
         "setup.sources[0].radius 1.75 is not below pi / 2"},
        {ONE_FINISH(.emission = {1, 1, -1}), "setup.finishes[0].emission -1 is negative"},
        {ONE_FINISH(.specular = {0, 1.5F, 0}), "setup.finishes[0].specular 1.5 is above 1"},
        {ONE_FINISH(.exponent = INFINITY), "setup.finishes[0].exponent inf is not finite"},
        {{.struct_size = sizeof(svo_light_setup), .sky = {0, 0, -1}}, "setup.sky[2] -1 is negative or not finite"},
        {{.struct_size = sizeof(svo_light_setup), .view_resolution = 16385},
         "setup.view_resolution 16385 is above 16384"},
        {{.struct_size = sizeof(svo_light_setup), .source_count = 1}, "setup.sources is NULL"},
        {{.struct_size = sizeof(svo_light_setup), .finish_count = 2}, "setup.finishes is NULL"},
        {{.struct_size = sizeof(svo_light_setup), .source_count = 1025}, "1025 sources are above 1024"},
        {{.struct_size = sizeof(svo_light_setup), .finish_count = 65536}, "65536 finishes are above 65535"},
    };
    svo_light_setup good = setup_of(sources, 1);
    lit_scene scene;
    good.view_resolution = 32;
    open_scene(&opened, SVO_LIGHT_FACES, &scene);
    for (size_t i = 0; i < sizeof refusals / sizeof refusals[0]; ++i) {
        char expected[256];
        light_succeed(&opened, svo_light_set_sources(scene.light, &good, opened.queue));
        assert_true(light_info_of(scene.light).lit_leaves > 0);
        assert_int_equal(svo_light_set_sources(scene.light, &refusals[i].setup, opened.queue), SVO_INVALID_ARGUMENT);
        (void)snprintf(expected, sizeof expected, "svo_light_set_sources: %s", refusals[i].message);
        assert_string_equal(svo_device_message(opened.device), expected);
        assert_null(svo_light_get_buffer(scene.light, SVO_LIGHT_RADIANCE));
        assert_null(svo_light_get_buffer(scene.light, SVO_LIGHT_FLUX));
        assert_int_equal(light_info_of(scene.light).lit_leaves, 0);
    }
    assert_int_equal(svo_light_set_sources(NULL, &good, opened.queue), SVO_INVALID_ARGUMENT);
    close_scene(&scene);
}

/* A source that shines past the tree, and a tree without leaves: dark, and no error. */
static void test_no_light_is_no_error(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_light_source away[] = {{.kind = SVO_SOURCE_SPOT,
                                      .position = {2.0F, 0.5F, 0.4F},
                                      .direction = {1.0F, 0.0F, 0.1F},
                                      .value = {2.0F, 2.0F, 5.0F},
                                      .inner_angle = 0.2F,
                                      .outer_angle = 0.5F},
                                     {.kind = SVO_SOURCE_POINT}};
    const svo_mesh nothing = SVO_MESH_INIT;
    const svo_light_setup past = setup_of(away, 2);
    const svo_light_setup all = setup_of(sources, 3);
    lit_scene scene;
    built empty;
    open_scene(&opened, SVO_LIGHT_FACES, &scene);
    light_succeed(&opened, svo_light_set_sources(scene.light, &past, opened.queue));
    assert_int_equal(light_info_of(scene.light).photons, 0);
    assert_int_equal(light_info_of(scene.light).lit_leaves, 0);
    close_scene(&scene);
    fixture_build(&opened, &nothing, 3, &everything, &empty);
    svo_light *light = light_of(&opened, empty.tree, SVO_LIGHT_FACES);
    light_succeed(&opened, svo_light_set_sources(light, &all, opened.queue));
    assert_int_equal(light_info_of(light).lit_leaves, 0);
    svo_light_destroy(&light);
    built_destroy(&empty);
}

/* For test_threads_do_not_matter: prints the hashes. */
static void print_hashes(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    char text[SVO_LIGHT_FORM_COUNT * SVO_HASH_TEXT_BYTES];
    hash_forms(&opened, text);
    assert_int_equal(write(HASHES, text, strlen(text)), strlen(text));
}

/* For the same program with another number of threads. */
TEST_GROUP(light_source_hashes)
{
    const struct CMUnitTest hashes[] = {cmocka_unit_test(print_hashes)};
    return cmocka_run_group_tests_name("light_source_hashes", hashes, fixture_group_setup, fixture_group_teardown);
}

TEST_GROUP(light_sources)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_repeated_runs_have_the_same_hash),
        cmocka_unit_test(test_threads_do_not_matter),
        cmocka_unit_test(test_new_sources_rerun_their_own_stages),
        cmocka_unit_test(test_bad_setups_are_refused),
        cmocka_unit_test(test_no_light_is_no_error),
    };
    return cmocka_run_group_tests_name("light_sources", tests, fixture_group_setup, fixture_group_teardown);
}
