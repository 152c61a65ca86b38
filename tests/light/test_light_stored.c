/* SPDX-License-Identifier: MIT */
/*
 * Files of lights: what is loaded is what was saved, in hash and pictures, and goes on as it would have; the light of
 * another tree is refused, and whatever is wrong with a file is told in one line.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "io/file_format.h"
#include "light/record.h"
#include "light_fixture.h"
#include "support/attributed_mesh.h"
#include "support/suite.h"
#include "svocl/io.h"

enum { DEPTH = 4, SIDE = 32, PIXELS = SIDE * SIDE };

#define NEEDS                                                                                                       \
    ((uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL | (uint32_t)SVO_NEED_MATERIAL | (uint32_t)SVO_NEED_RAYS | \
     (uint32_t)SVO_NEED_PROJECTED_AREA)

/* A file in memory. */
typedef struct bytes {
    uint8_t *data;
    size_t count;
} bytes;

static int append(void *user, const void *data, size_t byte_count)
{
    bytes *to = user;
    to->data = realloc(to->data, to->count + byte_count);
    assert_non_null(to->data);
    memcpy(to->data + to->count, data, byte_count);
    to->count += byte_count;
    return 0;
}

static svo_tree *make_tree(const fixture *opened, uint64_t seed, uint32_t need)
{
    const svo_plan_options options = {.struct_size = sizeof options, .need = need};
    attributed_mesh mesh;
    built made;
    attributed_mesh_create(seed, 60, 0, &mesh);
    fixture_build(opened, &mesh.mesh, DEPTH, &options, &made);
    attributed_mesh_destroy(&mesh);
    svo_tree *tree = made.tree;
    made.tree = NULL;
    built_destroy(&made);
    light_succeed(opened, svo_tree_download(tree, opened->queue));
    return tree;
}

/* A sun, a lamp and a sky over materials that shine and emit. sky_map: of 3 x 2 texels; NULL: none. goes_on: photons of
   emission, too, bounces and alpha. */
static void shine_under(const fixture *opened, svo_light *light, const float *sky_map, bool goes_on)
{
    static const svo_light_source sources[] = {
        {.kind = SVO_SOURCE_DIRECTIONAL, .direction = {-3, -10, -2}, .value = {3, 2, 1}},
        {.kind = SVO_SOURCE_POINT, .position = {0.5F, 0.9F, 0.5F}, .value = {0.1F, 0.2F, 0.3F}}};
    static const svo_finish finishes[] = {{.emission = {0.1F, 0, 0}}, {.specular = {0.5F, 0.5F, 0.5F}, .exponent = 8}};
    const svo_light_setup setup = {.struct_size = sizeof setup,
                                   .sources = sources,
                                   .source_count = 2,
                                   .finishes = finishes,
                                   .finish_count = 2,
                                   .sky = {0.2F, 0.3F, 0.4F},
                                   .view_resolution = 24,
                                   .updatable = 1,
                                   .sky_map = sky_map,
                                   .sky_width = sky_map != NULL ? 3 : 0,
                                   .sky_height = sky_map != NULL ? 2 : 0,
                                   .emission_photons = goes_on ? 3000 : 0,
                                   .bounces = goes_on ? 3 : 0,
                                   .photon_alpha = goes_on};
    light_succeed(opened, svo_light_set_sources(light, &setup, opened->queue));
}

static void shine(const fixture *opened, svo_light *light)
{
    shine_under(opened, light, NULL, false);
}

static const float sky_texels[18] = {0.1F, 0.2F, 0.9F, 0, 0, 2, 1, 1, 1, 0.3F, 0, 0, 0.25F, 0.5F, 0, 0, 0, 0};

static bytes save(const svo_light *light, uint32_t compress)
{
    const svo_save_options options = {.struct_size = sizeof options, .compress = compress};
    bytes made = {NULL, 0};
    svo_message message = {""};
    if (svo_light_save(light, svo_to_callback(append, &made), &options, NULL, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    return made;
}

static svo_light *load(svo_tree *tree, const bytes *file)
{
    svo_light *light = NULL;
    svo_message message = {""};
    if (svo_light_load(tree, svo_from_memory(file->data, file->count, "light"), NULL, NULL, &light, &message) !=
        SVO_OK) {
        fail_msg("%s", message.text);
    }
    return light;
}

static void draw(const fixture *opened, svo_light *light, uint32_t cones, uint32_t pixels[PIXELS])
{
    const svo_gather_options gather = {.struct_size = sizeof gather, .cones = cones};
    svo_render_options options = {
        .struct_size = sizeof options, .width = SIDE, .height = SIDE, .view = SVO_VIEW_SHADED, .gather = &gather};
    light_succeed(opened, svo_camera_fit(svo_light_target(light), 1, &options.camera));
    light_succeed(opened, svo_render(svo_light_target(light), &options, svo_in_host(pixels),
                                     &(svo_submit){.queue = opened->queue}));
}

static void assert_same(const fixture *opened, svo_light *a, svo_light *b)
{
    static uint32_t pictures[2][PIXELS];
    char hashes[2][SVO_HASH_TEXT_BYTES];
    const svo_light_info infos[2] = {light_info_of(a), light_info_of(b)};
    light_succeed(opened, svo_light_hash(a, opened->queue, hashes[0]));
    light_succeed(opened, svo_light_hash(b, opened->queue, hashes[1]));
    assert_string_equal(hashes[0], hashes[1]);
    assert_int_equal(infos[0].photons, infos[1].photons);
    assert_int_equal(infos[0].lit_nodes, infos[1].lit_nodes);
    assert_int_equal(infos[0].total_bytes, infos[1].total_bytes);
    assert_int_equal(infos[0].sky_bytes, infos[1].sky_bytes);
    assert_memory_equal(infos[0].bytes, infos[1].bytes, sizeof infos[0].bytes);
    assert_memory_equal(infos[0].flux, infos[1].flux, sizeof infos[0].flux);
    for (uint32_t cones = 0; cones <= 5; cones += 5) { /* by rays, and by cones */
        draw(opened, a, cones, pictures[0]);
        draw(opened, b, cones, pictures[1]);
        assert_memory_equal(pictures[0], pictures[1], sizeof pictures[0]);
    }
}

/* What is loaded follows changes as what was saved does. */
static void assert_same_after_an_update(const fixture *opened, svo_tree *tree, svo_light *a, svo_light *b)
{
    const svo_box changed = {.low = {0, 0, 0}, .high = {0.3, 0.3, 0.3}};
    light_succeed(opened, svo_light_update(a, tree, &changed, 1, opened->queue));
    light_succeed(opened, svo_light_update(b, tree, &changed, 1, opened->queue));
    assert_same(opened, a, b);
}

static void loaded_lights_are_those_that_were_saved(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    svo_tree *tree = make_tree(&opened, 3, NEEDS);
    for (int form = 0; form < SVO_LIGHT_FORM_COUNT; ++form) {
        for (uint32_t kind = 0; kind < 10;
             ++kind) { /* lit, dark, or under a map of the sky, photons that go on; packed or not */
            const svo_light_options options = {
                .struct_size = sizeof options, .form = (svo_light_form)form, .one_side = kind & 1};
            svo_light *light = NULL;
            light_succeed(&opened, svo_light_create(tree, &options, opened.queue, &light));
            if (kind < 2) {
                shine(&opened, light);
            } else if (kind >= 4) {
                shine_under(&opened, light, kind < 8 ? sky_texels : NULL, kind >= 6);
            }
            bytes file = save(light, kind & 1);
            svo_light *loaded = load(tree, &file);
            assert_same(&opened, light, loaded);
            bytes again = save(loaded, kind & 1);
            assert_int_equal(again.count, file.count);
            assert_memory_equal(again.data, file.data, file.count);
            assert_same_after_an_update(&opened, tree, light, loaded);
            free(again.data);
            free(file.data);
            svo_light_destroy(&loaded);
            svo_light_destroy(&light);
        }
    }
    svo_tree_destroy(&tree);
}

/* ---- refusals ---- */

static void assert_refused(svo_tree *tree, const bytes *file, svo_status expected, const char *text)
{
    svo_light *loaded = NULL;
    svo_message message = {""};
    const svo_status status =
        svo_light_load(tree, svo_from_memory(file->data, file->count, "cut"), NULL, NULL, &loaded, &message);
    if (status != expected || strstr(message.text, text) == NULL || strchr(message.text, '\n') != NULL ||
        loaded != NULL) {
        fail_msg("%s, \"%s\", expected \"%s\"", svo_name(SVO_NAME_STATUS, status), message.text, text);
    }
}

static bytes lit_file(const fixture *opened, svo_tree *tree)
{
    svo_light *light = light_of(opened, tree, SVO_LIGHT_FACES);
    shine(opened, light);
    const bytes file = save(light, 0);
    svo_light_destroy(&light);
    return file;
}

static void lights_of_other_trees_are_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    svo_tree *tree = make_tree(&opened, 3, NEEDS);
    svo_tree *other = make_tree(&opened, 4, NEEDS);
    svo_tree *less = make_tree(&opened, 3, NEEDS & ~(uint32_t)SVO_NEED_PROJECTED_AREA);
    bytes file = lit_file(&opened, tree);
    char hash[SVO_HASH_TEXT_BYTES];
    light_succeed(&opened, svo_tree_hash(other, SVO_HASH_ALL, hash));
    assert_refused(other, &file, SVO_INVALID_ARGUMENT, "cut: the light is of a tree of hash ");
    assert_refused(other, &file, SVO_INVALID_ARGUMENT, hash);
    assert_refused(less, &file, SVO_INVALID_ARGUMENT, "cut: the light is of a tree of hash ");
    free(file.data);
    svo_tree_destroy(&less);
    svo_tree_destroy(&other);
    svo_tree_destroy(&tree);
}

/* The head of a file, and a sum that fits it again. */
static file_head *head_of(const bytes *file)
{
    return (file_head *)(void *)file->data;
}

static void sign(const bytes *file)
{
    file_head *head = head_of(file);
    for (uint32_t i = 0; i < head->header.chunk_count; ++i) {
        head->chunks[i].hash = XXH3_64bits(file->data + head->chunks[i].offset, (size_t)head->chunks[i].plain_bytes);
    }
    head->header.header_hash =
        XXH3_64bits(file->data + FILE_HASH_BEGIN, head->header.header_bytes - (size_t)FILE_HASH_BEGIN);
}

static void damage_is_noticed(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    svo_tree *tree = make_tree(&opened, 3, NEEDS);
    bytes file = lit_file(&opened, tree);
    const file_head *head = head_of(&file);
    assert_int_equal(head->header.chunk_count, 3 + SVO_LIGHT_BUFFER_COUNT);
    for (size_t i = 0; i < head->header.header_bytes; ++i) {
        if (i >= offsetof(file_header, header_hash) || i < FILE_MAGIC_BYTES) {
            file.data[i] ^= 1;
            assert_refused(tree, &file, SVO_FILE_DAMAGED, "cut: ");
            file.data[i] ^= 1;
        }
    }
    for (uint32_t chunk = 0; chunk < head->header.chunk_count; ++chunk) {
        const size_t at = (size_t)(head->chunks[chunk].offset + head->chunks[chunk].stored_bytes / 2);
        file.data[at] ^= 16;
        assert_refused(tree, &file, SVO_FILE_DAMAGED, "checksum");
        file.data[at] ^= 16;
    }
    for (size_t count = 0; count < file.count; count += count < 1000 ? 7 : 997) {
        assert_refused(tree, &(bytes){file.data, count}, SVO_FILE_DAMAGED, "cut: ");
    }
    free(file.data);
    svo_tree_destroy(&tree);
}

/* Values that agree with all sums, and yet make no light. */
static void wrong_values_are_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    svo_tree *tree = make_tree(&opened, 3, NEEDS);
    bytes file = lit_file(&opened, tree);
    const file_head *head = head_of(&file);
    svo_i_light_record *record = (void *)(file.data + head->chunks[0].offset);
    const svo_i_light_record good = *record;
    svo_light_source *sources = (void *)(file.data + head->chunks[1].offset);
    uint32_t *lit = (void *)(file.data + head->chunks[3 + SVO_LIGHT_LIT].offset);
    record->form = SVO_LIGHT_FORM_COUNT;
    sign(&file);
    assert_refused(tree, &file, SVO_FILE_DAMAGED, "chunk light: its values do not fit the tree");
    *record = good;
    record->lit_nodes += 1;
    sign(&file);
    assert_refused(tree, &file, SVO_FILE_DAMAGED, "chunk radiance: ");
    *record = good;
    record->has_setup = 0;
    sign(&file);
    assert_refused(tree, &file, SVO_FILE_DAMAGED, "chunk light: its values do not fit the tree");
    *record = good;
    const uint32_t place = lit[0];
    lit[0] = (uint32_t)good.lit_nodes;
    sign(&file);
    assert_refused(tree, &file, SVO_FILE_DAMAGED, "lit: a place is not below ");
    lit[0] = place;
    sources[1].kind = 4;
    sign(&file);
    assert_refused(tree, &file, SVO_FILE_DAMAGED, "sources[1].kind 4 is not in 0 .. 3");
    free(file.data);
    svo_tree_destroy(&tree);
}

/* Files with a map are of version 2; others stay of version 1. */
static void wrong_maps_are_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    svo_tree *tree = make_tree(&opened, 3, NEEDS);
    svo_light *light = light_of(&opened, tree, SVO_LIGHT_FACES);
    shine(&opened, light);
    bytes file = save(light, 0);
    assert_int_equal(head_of(&file)->header.version, 1);
    free(file.data);
    shine_under(&opened, light, sky_texels, false);
    file = save(light, 0);
    file_head *head = head_of(&file);
    assert_int_equal(head->header.version, 2);
    assert_int_equal(head->chunks[3].plain_bytes, 8 + sizeof sky_texels);
    uint32_t *size = (void *)(file.data + head->chunks[3].offset);
    float *texels = (float *)(void *)(size + 2);
    assert_memory_equal(texels, sky_texels, sizeof sky_texels);
    size[0] = 2;
    sign(&file);
    assert_refused(tree, &file, SVO_FILE_DAMAGED, "chunk sky_map: 80 bytes are no map of 2 x 2");
    size[0] = 0;
    sign(&file);
    assert_refused(tree, &file, SVO_FILE_DAMAGED, "chunk sky_map: 80 bytes are no map of 0 x 2");
    size[0] = UINT32_MAX;
    size[1] = UINT32_MAX;
    sign(&file);
    assert_refused(tree, &file, SVO_FILE_DAMAGED, "chunk sky_map: 80 bytes are no map");
    size[0] = 3;
    size[1] = 2;
    texels[4] = -1;
    sign(&file);
    assert_refused(tree, &file, SVO_FILE_DAMAGED, "sky_map[4] -1, of column 1 and row 0, is negative or not finite");
    texels[4] = sky_texels[4];
    head->chunks[3].kind = 69;
    sign(&file);
    assert_refused(tree, &file, SVO_FILE_DAMAGED, "chunk opacity is missing");
    free(file.data);
    svo_light_destroy(&light);
    svo_tree_destroy(&tree);
}

/* Files that say how photons go on are of version 3. */
static void wrong_photons_are_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    svo_tree *tree = make_tree(&opened, 3, NEEDS);
    svo_light *light = light_of(&opened, tree, SVO_LIGHT_FACES);
    shine_under(&opened, light, NULL, true);
    bytes file = save(light, 0);
    file_head *head = head_of(&file);
    assert_int_equal(head->header.version, 3);
    assert_int_equal(head->chunks[3].kind, 68);
    assert_int_equal(head->chunks[3].plain_bytes, 16);
    uint32_t *numbers = (void *)(file.data + head->chunks[3].offset);
    assert_int_equal(numbers[0], 3000);
    assert_int_equal(numbers[1], 3);
    assert_int_equal(numbers[2], 1);
    numbers[2] = 2;
    sign(&file);
    assert_refused(tree, &file, SVO_FILE_DAMAGED, "chunk photons: 2, 0 are not 0 or 1, 0");
    numbers[2] = 1;
    numbers[3] = 1;
    sign(&file);
    assert_refused(tree, &file, SVO_FILE_DAMAGED, "chunk photons: 1, 1 are not 0 or 1, 0");
    numbers[3] = 0;
    numbers[1] = 65;
    sign(&file);
    assert_refused(tree, &file, SVO_FILE_DAMAGED, "setup.bounces 65 is above 64");
    free(file.data);
    svo_light_destroy(&light);
    svo_tree_destroy(&tree);
}

static void wrong_calls_are_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_load_options upper = {.struct_size = sizeof upper, .last_level = 2};
    svo_tree *tree = make_tree(&opened, 3, NEEDS);
    svo_light *loaded = NULL;
    svo_message message = {""};
    bytes file = lit_file(&opened, tree);
    const svo_source source = svo_from_memory(file.data, file.count, "light");
    assert_int_equal(svo_light_save(NULL, svo_to_path("a"), NULL, NULL, &message), SVO_INVALID_ARGUMENT);
    assert_string_equal(message.text, "svo_light_save: light is NULL");
    assert_int_equal(svo_light_load(NULL, source, NULL, NULL, &loaded, &message), SVO_INVALID_ARGUMENT);
    assert_string_equal(message.text, "svo_light_load: tree is NULL");
    assert_int_equal(svo_light_load(tree, source, NULL, NULL, NULL, &message), SVO_INVALID_ARGUMENT);
    assert_string_equal(message.text, "svo_light_load: out is NULL");
    assert_int_equal(svo_light_load(tree, source, &upper, NULL, &loaded, &message), SVO_INVALID_ARGUMENT);
    assert_string_equal(message.text, "svo_light_load: options.last_level is 2; lights are read whole");
    assert_refused(tree, &(bytes){(uint8_t *)"PNG", 3}, SVO_FILE_DAMAGED, "not a light's file");
    free(file.data);
    svo_tree_destroy(&tree);
}

TEST_GROUP(light_stored)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(loaded_lights_are_those_that_were_saved),
        cmocka_unit_test(lights_of_other_trees_are_refused),
        cmocka_unit_test(damage_is_noticed),
        cmocka_unit_test(wrong_values_are_refused),
        cmocka_unit_test(wrong_maps_are_refused),
        cmocka_unit_test(wrong_photons_are_refused),
        cmocka_unit_test(wrong_calls_are_refused),
    };
    return cmocka_run_group_tests_name("light_stored", tests, fixture_group_setup, fixture_group_teardown);
}
