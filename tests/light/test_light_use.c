/* SPDX-License-Identifier: MIT */
/*
 * Lights as callers use them: what is allocated and compiled, the same bytes from every builder, queue and number of
 * threads, and what is refused.
 */
#define _POSIX_C_SOURCE 200809L

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "light_fixture.h"
#include "support/attributed_mesh.h"
#include "support/counting.h"
#include "support/info_of.h"
#include "support/suite.h"

#define NEEDS (SVO_NEED_COLOR | (unsigned)SVO_NEED_NORMAL | (unsigned)SVO_NEED_PROJECTED_AREA)

enum { DEPTH = 6 };

static void build(const fixture *opened, uint32_t need, svo_builder builder, uint32_t payload_level, built *out)
{
    const svo_plan_options options = {.need = need, .builder = builder, .payload_level = payload_level};
    attributed_mesh mesh;
    attributed_mesh_create(3, 200, 0, &mesh);
    fixture_build(opened, &mesh.mesh, DEPTH, &options, out);
    attributed_mesh_destroy(&mesh);
}

/* ---- what is allocated and compiled ---- */

static void a_light_allocates_what_is_planned(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    built tree;
    build(&opened, NEEDS, SVO_BUILDER_CL, 0, &tree);
    for (svo_light_form form = SVO_LIGHT_FACES; form < SVO_LIGHT_FORM_COUNT; ++form) {
        svo_light_options options = SVO_LIGHT_OPTIONS_INIT;
        svo_light_info planned = SVO_LIGHT_INFO_INIT;
        svo_light *light = NULL;
        options.form = form;
        light_succeed(&opened, svo_light_plan(tree.tree, &options, &planned));
        counting_begin();
        light_succeed(&opened, svo_light_create(tree.tree, &options, opened.queue, &light));
        const counted taken = counting_read();
        const svo_light_info made = light_info_of(light);
        assert_int_equal(taken.live_bytes, planned.total_bytes);
        assert_int_equal(taken.peak_bytes, planned.total_bytes + planned.scratch_bytes);
        assert_memory_equal(made.bytes, planned.bytes, sizeof made.bytes);
        assert_int_equal(made.total_bytes, planned.total_bytes);
        assert_int_equal(made.scratch_bytes, planned.scratch_bytes);
        svo_light_destroy(&light);
        assert_int_equal(counting_read().live_bytes, 0);
    }
    built_destroy(&tree);
}

/* A build compiles nothing of light, and a light one program, that of its form. */
static void a_light_compiles_its_form_alone(void **state)
{
    const fixture_options none = {.context = 0};
    fixture opened;
    built tree;
    (void)state;
    counting_begin();
    fixture_open_cl(&none, &opened);
    build(&opened, NEEDS, SVO_BUILDER_CL, 0, &tree);
    const size_t of_build = (size_t)counting_read().builds;
    for (size_t i = 0; i < of_build; ++i) {
        assert_null(strstr(counting_options(i), "SVO_LIGHT"));
        assert_null(strstr(counting_kernels(i), "svo_k_light"));
    }
    svo_light *light = light_of(&opened, tree.tree, SVO_LIGHT_FACES);
    assert_int_equal(counting_read().builds, of_build + 1);
    assert_non_null(strstr(counting_options(of_build), "-DSVO_LIGHT_FACES"));
    assert_non_null(strstr(counting_kernels(of_build), "svo_k_light_face_leaves"));
    assert_null(strstr(counting_kernels(of_build), "brick"));
    svo_light_destroy(&light);
    built_destroy(&tree);
    fixture_close(&opened);
}

/* ---- the same bytes ---- */

static void hash_of(const fixture *opened, svo_tree *tree, svo_light_form form, cl_command_queue queue,
                    char text[SVO_HASH_TEXT_BYTES])
{
    svo_light_options options = SVO_LIGHT_OPTIONS_INIT;
    svo_light *light = NULL;
    options.form = form;
    light_succeed(opened, svo_light_create(tree, &options, queue, &light));
    light_succeed(opened, svo_light_hash(light, queue, text));
    svo_light_destroy(&light);
}

static void builders_and_queues_give_the_same_bytes(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    cl_int error = CL_SUCCESS;
    cl_command_queue unordered =
        clCreateCommandQueue(info_of_device(opened.device).context, info_of_device(opened.device).device,
                             CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE, &error);
    built first;
    built second;
    build(&opened, NEEDS, SVO_BUILDER_CL, 0, &first);
    build(&opened, NEEDS, SVO_BUILDER_SORTED, 0, &second);
    for (svo_light_form form = SVO_LIGHT_FACES; form < SVO_LIGHT_FORM_COUNT; ++form) {
        char hashes[3][SVO_HASH_TEXT_BYTES];
        hash_of(&opened, first.tree, form, opened.queue, hashes[0]);
        hash_of(&opened, second.tree, form, NULL, hashes[1]);
        hash_of(&opened, first.tree, form, error == CL_SUCCESS ? unordered : opened.queue, hashes[2]);
        assert_string_equal(hashes[0], hashes[1]);
        assert_string_equal(hashes[0], hashes[2]);
    }
    if (error == CL_SUCCESS) {
        clReleaseCommandQueue(unordered);
    }
    built_destroy(&first);
    built_destroy(&second);
}

/* For the test below: prints the hashes of all forms. */
static void print_hashes(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    built tree;
    build(&opened, NEEDS, SVO_BUILDER_CL, 0, &tree);
    for (svo_light_form form = SVO_LIGHT_FACES; form < SVO_LIGHT_FORM_COUNT; ++form) {
        char text[SVO_HASH_TEXT_BYTES];
        hash_of(&opened, tree.tree, form, NULL, text);
        printf("hash %s\n", text);
    }
    built_destroy(&tree);
}

/* The lines that this program prints with so many threads of PoCL. */
static size_t hashes_by_threads(unsigned threads, char lines[4][64])
{
    char path[512] = "";
    char command[640];
    char line[256];
    size_t count = 0;
    assert_true(readlink("/proc/self/exe", path, sizeof path - 1) > 0);
    (void)snprintf(command, sizeof command, "POCL_MAX_PTHREAD_COUNT=%u '%s' light_use_hashes 2>/dev/null", threads,
                   path);
    FILE *output = popen(command, "r");
    assert_non_null(output);
    while (fgets(line, sizeof line, output) != NULL) {
        if (strncmp(line, "hash ", 5) == 0 && count < 4) {
            (void)snprintf(lines[count++], 64, "%.63s", line);
        }
    }
    (void)pclose(output);
    return count;
}

static void threads_give_the_same_bytes(void **state)
{
    (void)fixture_cl_of_group(state); /* skips without a device */
    char one[4][64];
    char three[4][64];
    assert_int_equal(hashes_by_threads(1, one), SVO_LIGHT_FORM_COUNT);
    assert_int_equal(hashes_by_threads(3, three), SVO_LIGHT_FORM_COUNT);
    for (int form = 0; form < SVO_LIGHT_FORM_COUNT; ++form) {
        assert_string_equal(one[form], three[form]);
        assert_true(form == 0 || strcmp(one[form], one[form - 1]) != 0);
    }
}

/* ---- options ---- */

/* Opacity by area needs areas; full opacity does not look at them. */
static void opacity_is_full_without_areas(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    built with;
    built without;
    char hashes[2][SVO_HASH_TEXT_BYTES];
    svo_light_options options = SVO_LIGHT_OPTIONS_INIT;
    svo_light *light = NULL;
    build(&opened, NEEDS, SVO_BUILDER_CL, 0, &with);
    build(&opened, NEEDS & ~(unsigned)SVO_NEED_PROJECTED_AREA, SVO_BUILDER_CL, 0, &without);
    options.opacity = SVO_OPACITY_FULL;
    light_succeed(&opened, svo_light_create(with.tree, &options, opened.queue, &light));
    assert_int_equal(light_info_of(light).opacity, SVO_OPACITY_FULL);
    light_succeed(&opened, svo_light_hash(light, opened.queue, hashes[0]));
    svo_light_destroy(&light);
    light_succeed(&opened, svo_light_create(without.tree, NULL, opened.queue, &light));
    assert_int_equal(light_info_of(light).opacity, SVO_OPACITY_FULL);
    light_succeed(&opened, svo_light_hash(light, opened.queue, hashes[1]));
    svo_light_destroy(&light);
    assert_string_equal(hashes[0], hashes[1]);
    built_destroy(&with);
    built_destroy(&without);
}

/* A color that all nodes have is stored once. */
static void one_alpha_is_that_of_all_leaves(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_material glass = {{10, 20, 30, 100}, SVO_NO_TEXTURE};
    const svo_plan_options options = {.need = SVO_NEED_COLOR | (unsigned)SVO_NEED_NORMAL};
    uint16_t materials[200] = {0};
    attributed_mesh mesh;
    built tree;
    attributed_mesh_create(3, 200, 0, &mesh);
    svo_mesh painted = mesh.base.mesh;
    painted.materials = &glass;
    painted.material_count = 1;
    painted.triangle_materials = materials;
    fixture_build(&opened, &painted, DEPTH, &options, &tree);
    assert_true((tree.info.constant & SVO_NEED_COLOR) != 0);
    svo_light *light = light_of(&opened, tree.tree, SVO_LIGHT_VOXELS);
    uint16_t *opacity = light_read(&opened, light, SVO_LIGHT_OPACITY);
    for (uint64_t leaf = tree.info.inner_count; leaf < tree.info.node_count; ++leaf) {
        assert_int_equal(opacity[leaf], 257 * 100);
    }
    free(opacity);
    svo_light_destroy(&light);
    built_destroy(&tree);
    attributed_mesh_destroy(&mesh);
}

static void an_empty_tree_has_a_light(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_mesh none = SVO_MESH_INIT;
    built tree;
    fixture_build(&opened, &none, DEPTH, NULL, &tree);
    for (svo_light_form form = SVO_LIGHT_FACES; form < SVO_LIGHT_FORM_COUNT; ++form) {
        svo_light *light = light_of(&opened, tree.tree, form);
        const light_probe probe = {.position = {9, 9, 9}, .level = 3, .direction = {1, 0, 0}, .with_light = 1};
        light_sample sample;
        light_probe_field(&opened, light, &probe, &sample, 1);
        assert_true(sample.opacity == 0 && sample.extinction == 0);
        svo_light_destroy(&light);
    }
    built_destroy(&tree);
}

/* ---- without cones ---- */

/* Gathers at some points and draws a picture, by rays. */
static void use_rays(const fixture *opened, svo_light *light, svo_gather_result results[9], uint8_t rgba[32 * 32 * 4])
{
    const svo_light_source sun = {.kind = SVO_SOURCE_DIRECTIONAL, .direction = {0.3F, -1, 0.1F}, .value = {1, 1, 1}};
    const svo_light_setup setup = {
        .struct_size = sizeof setup, .sources = &sun, .source_count = 1, .sky = {0.2F, 0.3F, 0.4F}};
    svo_render_options picture = SVO_RENDER_OPTIONS_INIT;
    svo_gather_point points[9] = {{.normal = {0, 1, 0}}};
    light_succeed(opened, svo_light_set_sources(light, &setup, opened->queue));
    for (int i = 0; i < 9; ++i) {
        points[i] = (svo_gather_point){.position = {0.1F * (float)i, 0.5F, 0.4F}, .normal = {0, 1, 0}};
    }
    light_succeed(opened, svo_gather(light, svo_in_host(points), svo_in_host(results), 9, NULL,
                                     &(svo_submit){.queue = opened->queue}));
    picture.width = picture.height = 32;
    picture.view = SVO_VIEW_SHADED;
    light_succeed(opened, svo_camera_fit(svo_light_target(light), 1, &picture.camera));
    light_succeed(opened, svo_render(svo_light_target(light), &picture, svo_in_host(rgba),
                                     &(svo_submit){.queue = opened->queue}));
}

/* What rays gather is the same, and nothing is stored for them. */
static void rays_do_without_stored_light(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_light_options no_cones = {.struct_size = sizeof no_cones, .no_cones = 1};
    const svo_gather_options cones = {.struct_size = sizeof cones, .cones = 5};
    static uint8_t rgba[2][32 * 32 * 4];
    svo_gather_result results[2][9];
    svo_light *light = NULL;
    built tree;
    build(&opened, NEEDS | SVO_NEED_RAYS, SVO_BUILDER_CL, 0, &tree);
    light = light_of(&opened, tree.tree, SVO_LIGHT_FACES);
    use_rays(&opened, light, results[0], rgba[0]);
    svo_light_destroy(&light);
    light_succeed(&opened, svo_light_create(tree.tree, &no_cones, opened.queue, &light));
    use_rays(&opened, light, results[1], rgba[1]);
    assert_memory_equal(results[1], results[0], sizeof results[0]);
    assert_memory_equal(rgba[1], rgba[0], sizeof rgba[0]);
    const svo_light_info info = light_info_of(light);
    assert_int_equal(info.total_bytes + info.scratch_bytes + info.photons, 0);
    light_succeed(&opened, svo_light_update(light, tree.tree, NULL, 0, opened.queue));
    assert_int_equal(light_info_of(light).total_bytes, 0);
    assert_int_equal(svo_gather(light, svo_in_host(NULL), svo_in_host(NULL), 0, &cones, NULL), SVO_INVALID_ARGUMENT);
    assert_string_equal(svo_device_message(opened.device),
                        "svo_gather: options.method is cones; the light was made with no_cones");
    svo_light_destroy(&light);
    built_destroy(&tree);
}

/* ---- what is refused ---- */

static void refuse(const fixture *opened, svo_status status, const char *message)
{
    assert_int_equal(status, SVO_INVALID_ARGUMENT);
    assert_string_equal(svo_device_message(opened->device), message);
}

static void wrong_arguments_are_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    svo_light_options options = SVO_LIGHT_OPTIONS_INIT;
    svo_light_info info = SVO_LIGHT_INFO_INIT;
    char text[SVO_HASH_TEXT_BYTES];
    svo_light *light = NULL;
    built tree;
    built partial;
    build(&opened, NEEDS, SVO_BUILDER_CL, 0, &tree);
    build(&opened, SVO_NEED_COLOR, SVO_BUILDER_CL, 2, &partial);
    assert_int_equal(svo_light_create(NULL, NULL, NULL, &light), SVO_INVALID_ARGUMENT);
    refuse(&opened, svo_light_create(tree.tree, NULL, NULL, NULL), "svo_light_create: out is NULL");
    options.form = (svo_light_form)3;
    refuse(&opened, svo_light_create(tree.tree, &options, NULL, &light),
           "svo_light_create: options.form 3 is not in 0 .. 2");
    refuse(&opened, svo_light_plan(tree.tree, &options, &info), "svo_light_plan: options.form 3 is not in 0 .. 2");
    options.form = SVO_LIGHT_FACES;
    options.opacity = (svo_opacity)2;
    refuse(&opened, svo_light_create(tree.tree, &options, NULL, &light),
           "svo_light_create: options.opacity 2 is not in 0 .. 1");
    options.struct_size = 4;
    assert_int_equal(svo_light_create(tree.tree, &options, NULL, &light), SVO_INVALID_ARGUMENT);
    refuse(&opened, svo_light_create(partial.tree, NULL, NULL, &light),
           "svo_light_create: the tree's payload begins at level 2; light needs it from level 0 on");
    assert_null(light);
    light = light_of(&opened, tree.tree, SVO_LIGHT_VOXELS);
    assert_int_equal(svo_light_get_info(NULL, &info), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_light_get_info(light, NULL), SVO_INVALID_ARGUMENT);
    refuse(&opened, svo_light_hash(light, NULL, NULL), "svo_light_hash: text is NULL");
    assert_int_equal(svo_light_hash(NULL, NULL, text), SVO_INVALID_ARGUMENT);
    refuse(&opened, svo_kernel_set_arguments(svo_light_target(light), NULL, 0),
           "svo_kernel_set_arguments: kernel is NULL");
    assert_int_equal(svo_kernel_set_arguments(svo_light_target(NULL), NULL, 0), SVO_INVALID_ARGUMENT);
    assert_null(svo_light_get_buffer(NULL, SVO_LIGHT_OPACITY));
    assert_null(svo_light_get_buffer(light, SVO_LIGHT_BUFFER_COUNT));
    assert_null(svo_light_get_buffer(light, SVO_LIGHT_COVER));
    assert_null(svo_kernel_options(svo_light_target(NULL)));
    svo_light_destroy(&light);
    svo_light_destroy(&light);
    svo_light_destroy(NULL);
    built_destroy(&tree);
    built_destroy(&partial);
}

static void names_are_those_of_the_header(void **state)
{
    (void)state;
    assert_string_equal(svo_name(SVO_NAME_LIGHT_FORM, SVO_LIGHT_FACES), "faces");
    assert_string_equal(svo_name(SVO_NAME_LIGHT_FORM, SVO_LIGHT_FORM_COUNT), "unknown form");
    assert_string_equal(svo_name(SVO_NAME_LIGHT_BUFFER, SVO_LIGHT_RADIANCE), "radiance");
    assert_string_equal(svo_name(SVO_NAME_LIGHT_BUFFER, SVO_LIGHT_BUFFER_COUNT), "unknown buffer");
    assert_string_equal(svo_name(SVO_NAME_LIGHT_STAGE, SVO_LIGHT_STAGE_FILTER), "radiance filter");
    assert_string_equal(svo_name(SVO_NAME_LIGHT_STAGE, SVO_LIGHT_STAGE_COUNT), "unknown stage");
}

/* For the same program with another number of threads. */
TEST_GROUP(light_use_hashes)
{
    const struct CMUnitTest printing[] = {cmocka_unit_test(print_hashes)};
    return cmocka_run_group_tests_name("light_use_hashes", printing, fixture_group_setup, fixture_group_teardown);
}

TEST_GROUP(light_use)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_light_allocates_what_is_planned),
        cmocka_unit_test(a_light_compiles_its_form_alone),
        cmocka_unit_test(builders_and_queues_give_the_same_bytes),
        cmocka_unit_test(threads_give_the_same_bytes),
        cmocka_unit_test(opacity_is_full_without_areas),
        cmocka_unit_test(one_alpha_is_that_of_all_leaves),
        cmocka_unit_test(an_empty_tree_has_a_light),
        cmocka_unit_test(rays_do_without_stored_light),
        cmocka_unit_test(wrong_arguments_are_refused),
        cmocka_unit_test(names_are_those_of_the_header),
    };
    return cmocka_run_group_tests_name("light_use", tests, fixture_group_setup, fixture_group_teardown);
}
