/* SPDX-License-Identifier: MIT */
/* Editing in svocl view: placements of instances and back, scenes to files bit for bit, lights that the mouse moves. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cjson/cJSON.h>
#include <cmocka.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "support/file_register.h"
#include "support/scene_place.h"
#include "support/suite.h"
#include "support/work_folder.h"
#include "view/camera.h"
#include "view/dialogs.h"
#include "view/edit.h"
#include "view/files.h"
#include "view/history.h"
#include "view/input.h"

/* ---- placements ---- */

static uint32_t random_bits(uint32_t *seed)
{
    *seed = *seed * 1664525U + 1013904223U;
    return *seed >> 8;
}

static float random_within(uint32_t *seed, float low, float high)
{
    return low + (high - low) * (float)random_bits(seed) / 16777216.0F;
}

static scene_place random_place(uint32_t *seed)
{
    scene_place place;
    for (int axis = 0; axis < 3; ++axis) {
        place.translate[axis] = random_within(seed, -100, 100);
        place.rotate[axis] = random_within(seed, -180, 180);
        place.scale[axis] = random_within(seed, 0.01F, 10) * (random_bits(seed) % 2 == 0 ? 1.0F : -1.0F);
    }
    return place;
}

static void test_found_placements_give_the_matrix(void **unused)
{
    (void)unused;
    uint32_t seed = 17;
    for (int i = 0; i < 20000; ++i) {
        const scene_place place = random_place(&seed);
        scene_place found;
        float asked[12];
        float composed[12];
        scene_place_compose(&place, asked);
        assert_true(scene_place_find(asked, &found));
        scene_place_compose(&found, composed);
        for (int k = 0; k < 12; ++k) {
            assert_float_equal(composed[k], asked[k], 1e-5F * (k % 4 == 3 ? 100 : 10));
        }
    }
}

/* What people write comes back as they wrote it. */
static void test_plain_placements_are_found(void **unused)
{
    (void)unused;
    for (int x = -175; x <= 180; x += 5) {
        for (int y = -85; y <= 85; y += 5) {
            const scene_place place = {{1.5F, -2, 0.1F}, {(float)x, (float)y, 30}, {1.5F, 0.25F, 2}};
            scene_place found;
            float transform[12];
            scene_place_compose(&place, transform);
            assert_true(scene_place_find(transform, &found));
            assert_memory_equal(&found, &place, sizeof place);
        }
    }
}

static void test_quarter_turns_and_shear(void **unused)
{
    (void)unused;
    const scene_place quarter = {{0, 0, 0}, {20, 90, 50}, {1, 1, 1}};
    const float sheared[12] = {1, 0.3F, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    const float flat[12] = {0};
    scene_place found;
    float asked[12];
    float composed[12];
    scene_place_compose(&quarter, asked);
    assert_true(scene_place_find(asked, &found));
    scene_place_compose(&found, composed);
    for (int k = 0; k < 12; ++k) {
        assert_float_equal(composed[k], asked[k], 1e-6F);
    }
    assert_false(scene_place_find(sheared, &found));
    assert_false(scene_place_find(flat, &found));
}

/* ---- editing ---- */

static void begin_scene(view_state *state)
{
    static const view_tree trees[] = {{.name = "first \"tree\"", .path = "scene:atrium", .depth = 8},
                                      {.name = "second", .path = "models/b.svo"}};
    view_state_begin(state);
    state->width = 640;
    state->height = 400;
    state->trees = trees;
    state->tree_count = 2;
    state->camera.at = (svo_camera){.eye = {1, 2, 10}, .up = {0, 1, 0}, .vertical_fov = 0.6F};
    view_choose_scene(state, true);
    assert_true(state->is_scene);
    assert_int_equal(state->instance_count, 1);
}

static void test_edits(void **unused)
{
    (void)unused;
    view_state *state = malloc(sizeof *state);
    begin_scene(state);
    const unsigned before = state->revisions.instances;
    assert_true(scene_edit_add(state));
    assert_int_equal(state->instance, 1);
    /* An angle beyond a quarter turn stays what the hand made it. */
    const scene_place place = {{1, 2, 3}, {10, 170, 0}, {2, 2, 2}};
    scene_place read;
    assert_true(scene_edit_set(state, 1, &place));
    assert_true(scene_edit_place(state, 1, &read));
    assert_memory_equal(&read, &place, sizeof place);
    assert_true(state->revisions.instances > before);
    /* What a scene would refuse changes nothing. */
    const scene_place flat = {{1, 2, 3}, {0, 0, 0}, {1, 0, 1}};
    const scene_place not_finite = {{NAN, 0, 0}, {0, 0, 0}, {1, 1, 1}};
    assert_false(scene_edit_set(state, 1, &flat));
    assert_false(scene_edit_set(state, 1, &not_finite));
    assert_false(scene_edit_set(state, 9, &place));
    assert_true(scene_edit_place(state, 1, &read));
    assert_memory_equal(&read, &place, sizeof place);
    scene_edit_move(state, 1, (const float[3]){-1, -2, -3});
    assert_true(scene_edit_place(state, 1, &read));
    assert_memory_equal(read.translate, ((const float[3]){-1, -2, -3}), sizeof read.translate);
    scene_edit_remove(state);
    assert_int_equal(state->instance_count, 1);
    scene_edit_remove(state);
    assert_int_equal(state->instance_count, 1);
    view_state_end(state);
    free(state);
}

/* ---- files ---- */

static char *read_whole(const char *path)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    char *text = calloc(1, 1 << 22);
    (void)fread(text, 1, (1 << 22) - 1, file);
    (void)fclose(file);
    return text;
}

static void read_floats(const cJSON *array, int count, float *out)
{
    assert_int_equal(cJSON_GetArraySize(array), count);
    for (int i = 0; i < count; ++i) {
        out[i] = (float)cJSON_GetArrayItem(array, i)->valuedouble;
    }
}

static scene_place read_place(const cJSON *object)
{
    scene_place place = {.scale = {1, 1, 1}};
    const cJSON *scale = cJSON_GetObjectItem(object, "scale");
    if (cJSON_GetObjectItem(object, "translate") != NULL) {
        read_floats(cJSON_GetObjectItem(object, "translate"), 3, place.translate);
    }
    if (cJSON_GetObjectItem(object, "rotate") != NULL) {
        read_floats(cJSON_GetObjectItem(object, "rotate"), 3, place.rotate);
    }
    if (cJSON_IsNumber(scale)) {
        place.scale[0] = place.scale[1] = place.scale[2] = (float)scale->valuedouble;
    } else if (scale != NULL) {
        read_floats(scale, 3, place.scale);
    }
    return place;
}

/* As the format says: a matrix, or a placement. */
static void read_transform(const cJSON *instance, float transform[12])
{
    const cJSON *matrix = cJSON_GetObjectItem(instance, "matrix");
    if (matrix != NULL) {
        read_floats(matrix, 12, transform);
        return;
    }
    const scene_place place = read_place(instance);
    scene_place_compose(&place, transform);
}

static void test_saved_instances_are_the_same(void **unused)
{
    (void)unused;
    uint32_t seed = 5;
    view_state *state = malloc(sizeof *state);
    begin_scene(state);
    for (int i = 0; i < 3000; ++i) {
        svo_instance added = {.tree = random_bits(&seed) % 2};
        const scene_place place = random_place(&seed);
        scene_place_compose(&place, added.transform);
        added.transform[1] += i % 3 == 0 ? 0.5F : 0; /* sheared */
        assert_true(view_add_instance(state, &added));
    }
    work_folder_remember("scene.json");
    assert_int_equal(scene_save(state, path_of("scene.json")), 0);
    char *text = read_whole(path_of("scene.json"));
    cJSON *document = cJSON_Parse(text);
    assert_non_null(document);
    const cJSON *instance = cJSON_GetObjectItem(document, "instances")->child;
    for (size_t i = 0; i < state->instance_count; ++i, instance = instance->next) {
        float transform[12];
        read_transform(instance, transform);
        for (int k = 0; k < 12; ++k) {
            assert_true(transform[k] == state->instances[i].transform[k]);
        }
        assert_string_equal(cJSON_GetObjectItem(instance, "tree")->valuestring,
                            state->trees[state->instances[i].tree].name);
    }
    assert_null(instance);
    cJSON_Delete(document);
    free(text);
    view_state_end(state);
    free(state);
}

static const char *path_in(const cJSON *document, const char *tree)
{
    const cJSON *trees = cJSON_GetObjectItem(document, "trees");
    return cJSON_GetObjectItem(cJSON_GetObjectItem(trees, tree), "path")->valuestring;
}

/* A scene's paths begin in its folder: the file finds its trees wherever it lies. */
static void test_paths_follow_the_file(void **unused)
{
    (void)unused;
    char folder[4096];
    char wanted[8192];
    view_state *state = malloc(sizeof *state);
    begin_scene(state);
    assert_non_null(getcwd(folder, sizeof folder));
    (void)snprintf(wanted, sizeof wanted, "%s/models/b.svo", folder);
    work_folder_remember("elsewhere.json");
    assert_int_equal(scene_save(state, path_of("elsewhere.json")), 0);
    char *text = read_whole(path_of("elsewhere.json"));
    cJSON *document = cJSON_Parse(text);
    assert_string_equal(path_in(document, "first \"tree\""), "scene:atrium");
    assert_string_equal(path_in(document, "second"), wanted);
    cJSON_Delete(document);
    free(text);
    view_state_end(state);
    free(state);
}

static void test_failed_saves_leave_the_file(void **unused)
{
    (void)unused;
    char path[4096];
    view_state *state = malloc(sizeof *state);
    begin_scene(state);
    (void)snprintf(path, sizeof path, "%s/nowhere/scene.json", work_folder());
    assert_int_equal(scene_save(state, path), ENOENT);
    question_save_as(state, VIEW_SCENE, path);
    assert_non_null(strstr(view_log_line(state, 0), "not saved"));
    assert_int_equal(state->question.asking, VIEW_ASKS_FOR_NAME);
    assert_string_equal(state->question.path, path);
    assert_int_equal(scene_save(state, "/dev/full"), ENOSPC);
    view_state_end(state);
    free(state);
}

/* What is shown is read from files that a scene must not replace, whatever links lead there. */
static void test_saves_spare_what_is_shown(void **unused)
{
    (void)unused;
    char mesh[4096], link_path[4096];
    struct stat entry;
    file_register files = {0};
    view_state *state = malloc(sizeof *state);
    begin_scene(state);
    state->files = &files;
    (void)snprintf(mesh, sizeof mesh, "%s/mesh.obj", work_folder());
    (void)snprintf(link_path, sizeof link_path, "%s/link.json", work_folder());
    FILE *file = fopen(mesh, "w");
    assert_non_null(file);
    assert_int_equal(fclose(file), 0);
    assert_int_equal(symlink(mesh, link_path), 0);
    assert_int_equal(stat(mesh, &entry), 0);
    assert_null(file_register_read(&files, &entry, mesh));
    question_save_as(state, VIEW_SCENE, link_path);
    assert_non_null(strstr(view_log_line(state, 0), "is what is shown"));
    assert_int_equal(stat(mesh, &entry), 0);
    assert_int_equal(entry.st_size, 0);
    assert_int_equal(unlink(link_path) | unlink(mesh), 0);
    file_register_free(&files);
    view_state_end(state);
    free(state);
}

/* ---- motions ---- */

#define KEYS 5

/* Gives the first instance a motion of random keys. */
static void move_first(view_state *state, scene_key keys[KEYS], scene_motion *motion, uint32_t *seed)
{
    for (int i = 0; i < KEYS; ++i) {
        keys[i] = (scene_key){-1 + 0.7F * (float)i, random_place(seed)};
    }
    *motion = (scene_motion){0, keys, KEYS};
    scene_place_compose(&keys[0].place, state->instances[0].transform);
    assert_true(view_add_mover(state, &(view_mover){0, motion, keys[0].place}));
}

/* The saved keys of an instance, and those that the viewer shows, bit for bit. */
static void expect_saved_motion(view_state *state, size_t index)
{
    const view_mover *mover = view_mover_of(state, index);
    work_folder_remember("moving.json");
    assert_int_equal(scene_save(state, path_of("moving.json")), 0);
    char *text = read_whole(path_of("moving.json"));
    cJSON *document = cJSON_Parse(text);
    const cJSON *instance = cJSON_GetArrayItem(cJSON_GetObjectItem(document, "instances"), (int)index);
    const cJSON *key = cJSON_GetObjectItem(instance, "motion")->child;
    for (size_t i = 0; i < KEYS; ++i, key = key->next) {
        const scene_place saved = read_place(key);
        const scene_place shown = view_mover_key(mover, i);
        assert_memory_equal(&saved, &shown, sizeof shown);
        assert_true((float)cJSON_GetObjectItem(key, "time")->valuedouble == mover->motion->keys[i].time);
    }
    assert_null(key);
    cJSON_Delete(document);
    free(text);
}

static void test_saved_motions_are_the_same(void **unused)
{
    (void)unused;
    uint32_t seed = 11;
    scene_key keys[KEYS];
    scene_motion motion;
    view_state *state = malloc(sizeof *state);
    begin_scene(state);
    move_first(state, keys, &motion, &seed);
    for (size_t i = 0; i < KEYS; ++i) {
        const scene_place shown = view_mover_key(&state->movers[0], i);
        assert_memory_equal(&shown, &keys[i].place, sizeof shown);
    }
    expect_saved_motion(state, 0);
    const scene_place place = random_place(&seed);
    assert_true(scene_edit_set(state, 0, &place));
    expect_saved_motion(state, 0);
    scene_edit_move(state, 0, (const float[3]){0.1F, -7, 3});
    expect_saved_motion(state, 0);
    view_state_end(state);
    free(state);
}

/* What a hand does to the first key it does to all; a copy has a motion of its own. */
static void test_motions_follow_their_first_key(void **unused)
{
    (void)unused;
    uint32_t seed = 3;
    scene_key keys[KEYS];
    scene_motion motion;
    view_state *state = malloc(sizeof *state);
    begin_scene(state);
    move_first(state, keys, &motion, &seed);
    scene_place place = keys[0].place;
    place.translate[1] += 5;
    place.rotate[2] -= 30;
    place.scale[0] *= 2;
    assert_true(scene_edit_set(state, 0, &place));
    const scene_place last = view_mover_key(&state->movers[0], KEYS - 1);
    assert_float_equal(last.translate[1], keys[KEYS - 1].place.translate[1] + 5, 1e-4F);
    assert_float_equal(last.rotate[2], keys[KEYS - 1].place.rotate[2] - 30, 1e-4F);
    assert_float_equal(last.scale[0], keys[KEYS - 1].place.scale[0] * 2, 1e-5F);
    assert_float_equal(last.scale[1], keys[KEYS - 1].place.scale[1], 0);
    state->instance = 0;
    assert_true(scene_edit_add(state));
    assert_int_equal(state->mover_count, 2);
    assert_float_equal(state->movers[1].first.translate[0], state->instances[1].transform[3], 0);
    assert_true(state->movers[1].first.translate[0] > state->movers[0].first.translate[0]);
    expect_saved_motion(state, 1);
    /* Keys that would be no numbers keep the motion as it is. */
    const float far = keys[1].place.translate[0] > keys[0].place.translate[0] ? 1e9F : -1e9F;
    const view_mover before = state->movers[0];
    keys[1].place.translate[0] += far;
    scene_edit_move(state, 0, (const float[3]){far, 0, 0});
    assert_memory_equal(&state->movers[0], &before, sizeof before);
    view_remove_instance(state, 0);
    assert_int_equal(state->mover_count, 1);
    assert_int_equal(state->movers[0].instance, 0);
    view_remove_instance(state, 0);
    assert_int_equal(state->mover_count, 0);
    view_state_end(state);
    free(state);
}

/* ---- lights ---- */

static void test_angles(void **unused)
{
    (void)unused;
    view_state *state = malloc(sizeof *state);
    static const float ups[][3] = {{0, 1, 0}, {0, 0, 1}, {1, 0, 0}, {0, 0.6F, 0.8F}};
    view_state_begin(state);
    for (int up = 0; up < 4; ++up) {
        memcpy(state->camera.up, ups[up], sizeof ups[up]);
        for (int around = -170; around <= 170; around += 10) {
            for (int above = -80; above <= 80; above += 10) {
                float direction[3];
                float angles[2];
                light_edit_direction(state, (const float[2]){(float)around, (float)above}, direction);
                light_edit_angles(state, direction, angles);
                assert_float_equal(angles[0], (float)around, 1e-3F);
                assert_float_equal(angles[1], (float)above, 1e-3F);
                const float falls = -ups[up][0] * direction[0] - ups[up][1] * direction[1] - ups[up][2] * direction[2];
                assert_float_equal(falls, sinf((float)above * 3.14159265F / 180), 1e-5F);
            }
        }
    }
    view_state_end(state);
    free(state);
}

/* The light stays below the mouse. */
static void test_dragged_light_follows_the_mouse(void **unused)
{
    (void)unused;
    view_state *state = malloc(sizeof *state);
    float before[2];
    float after[2];
    view_state_begin(state);
    state->width = 640;
    state->height = 400;
    state->camera.at = (svo_camera){.eye = {1, 2, 10}, .up = {0, 1, 0}, .vertical_fov = 0.6F};
    assert_true(light_edit_add(state, SVO_SOURCE_POINT));
    assert_true(camera_project(state, state->sources[0].position, before));
    light_edit_drag(state, 40, -25);
    assert_true(camera_project(state, state->sources[0].position, after));
    assert_float_equal(after[0] - before[0], 40, 0.05F);
    assert_float_equal(after[1] - before[1], -25, 0.05F);
    light_edit_push(state, 5);
    assert_true(camera_project(state, state->sources[0].position, before));
    assert_float_equal(after[0], before[0], 0.05F);
    assert_float_equal(after[1], before[1], 0.05F);
    view_state_end(state);
    free(state);
}

/* ---- undo ---- */

static scene_key undo_keys[2] = {{.time = 0, .place = {.scale = {1, 1, 1}}},
                                 {.time = 1, .place = {.scale = {1, 1, 1}}}};
static const scene_motion undo_motion = {.keys = undo_keys, .key_count = 2};

static void edit_light(view_state *state, uint32_t *seed)
{
    switch (random_bits(seed) % 5) {
    case 0:
        (void)light_edit_add(state, random_bits(seed) % 3);
        break;
    case 1:
        view_remove_source(state, state->source_count > 0 ? random_bits(seed) % state->source_count : 0);
        break;
    case 2:
        state->sky[random_bits(seed) % 3] = random_within(seed, 0, 2);
        view_lights_changed(state);
        break;
    case 3:
        if (state->scene_light_count < SVO_SCENE_LIGHTS_MAX) {
            view_add_scene_light(state);
        }
        break;
    default:
        view_remove_scene_light(state, random_bits(seed) % 3);
        break;
    }
}

static void edit_at_random(view_state *state, uint32_t *seed)
{
    const scene_place place = random_place(seed);
    state->instance = random_bits(seed) % state->instance_count;
    switch (random_bits(seed) % 6) {
    case 0:
        assert_true(scene_edit_add(state));
        break;
    case 1:
        scene_edit_remove(state);
        break;
    case 2:
        scene_edit_drag(state, random_within(seed, -50, 50), 3);
        break;
    case 3:
        state->instances[state->instance].tree ^= 1;
        view_instances_changed(state);
        break;
    case 4:
        (void)scene_edit_set(state, state->instance, &place);
        break;
    default:
        edit_light(state, seed);
        break;
    }
}

/* The bytes of both files of a state. */
static char *bytes_of(const view_state *state)
{
    enum { BYTES_MAX = 1 << 20 };
    char *text = calloc(2, BYTES_MAX);
    static const char *const names[2] = {"undo-scene.json", "undo-lights.json"};
    work_folder_remember(names[0]);
    work_folder_remember(names[1]);
    assert_int_equal(scene_save(state, path_of(names[0])), 0);
    assert_int_equal(lights_save(state, path_of(names[1])), 0);
    for (size_t i = 0, used = 0; i < 2; ++i) {
        FILE *file = fopen(path_of(names[i]), "rb");
        assert_non_null(file);
        used += fread(text + used, 1, BYTES_MAX - 1, file);
        (void)fclose(file);
    }
    return text;
}

static void test_undo_of_all_edits_gives_the_first_bytes(void **unused)
{
    (void)unused;
    enum { EDITS = 400 };
    uint32_t seed = 29;
    char *texts[EDITS + 1];
    view_state *state = malloc(sizeof *state);
    begin_scene(state);
    assert_true(scene_edit_add(state));
    assert_true(view_add_mover(state, &(view_mover){1, &undo_motion, undo_keys[0].place}));
    assert_true(light_edit_add(state, SVO_SOURCE_DIRECTIONAL));
    history_begin(state);
    assert_false(view_is_unsaved(state));
    texts[0] = bytes_of(state);
    size_t step_count = 0;
    for (int i = 0; i < EDITS; ++i) {
        edit_at_random(state, &seed);
        history_look(state, false);
        char *now = bytes_of(state);
        if (strcmp(now, texts[step_count]) == 0) {
            free(now);
        } else {
            texts[++step_count] = now;
        }
    }
    assert_true(step_count > EDITS / 2);
    assert_true(view_is_unsaved(state));
    for (size_t pass = 0; pass < 2; ++pass) {
        for (size_t i = step_count; i-- > 0;) {
            history_undo(state);
            char *now = bytes_of(state);
            assert_string_equal(now, texts[i]);
            free(now);
        }
        assert_false(view_is_unsaved(state));
        history_undo(state); /* there is nothing left */
        for (size_t i = 1; i <= step_count; ++i) {
            history_redo(state);
            char *now = bytes_of(state);
            assert_string_equal(now, texts[i]);
            free(now);
        }
        history_redo(state);
        assert_true(view_is_unsaved(state));
    }
    for (size_t i = 0; i <= step_count; ++i) {
        free(texts[i]);
    }
    history_end(state);
    view_state_end(state);
    free(state);
}

static void test_a_drag_is_one_step(void **unused)
{
    (void)unused;
    view_state *state = malloc(sizeof *state);
    begin_scene(state);
    history_begin(state);
    char *before = bytes_of(state);
    for (int i = 0; i < 20; ++i) {
        scene_edit_drag(state, 4, 2);
        history_look(state, i < 19);
    }
    history_undo(state);
    char *after = bytes_of(state);
    assert_string_equal(before, after);
    /* An edit instead of a redo forgets what was undone. */
    scene_edit_drag(state, -4, 2);
    history_redo(state);
    assert_non_null(strstr(view_log_line(state, 0), "nothing to redo"));
    free(before);
    free(after);
    history_end(state);
    view_state_end(state);
    free(state);
}

/* Strokes as the brush makes them: so many shapes each, in one drag. */
static void draw(view_state *state, unsigned shapes)
{
    for (unsigned i = 0; i < shapes; ++i) {
        ++state->brush.position;
        ++state->revisions.strokes;
        history_look(state, true);
    }
    history_look(state, false);
}

/* Strokes and lights are undone in the order that they were made in; what the brush has forgotten is not. */
static void test_strokes_share_the_history(void **unused)
{
    (void)unused;
    view_state *state = malloc(sizeof *state);
    begin_scene(state);
    state->is_scene = false;
    history_begin(state);
    view_choose_brush(state, true);
    draw(state, 5);
    assert_true(light_edit_add(state, SVO_SOURCE_POINT));
    history_look(state, false);
    draw(state, 3);
    assert_true(state->unsaved[VIEW_VOXELS] && state->unsaved[VIEW_LIGHTS] && !state->unsaved[VIEW_SCENE]);
    history_saved(state, VIEW_LIGHTS);
    assert_true(view_is_unsaved(state));
    view_choose_scene(state, true);
    state->brush.is_on = false;
    history_undo(state);
    assert_int_equal(state->brush.position, 5);
    assert_true(state->brush.is_on && !state->is_scene);
    history_undo(state);
    assert_int_equal(state->source_count, 0);
    assert_int_equal(state->brush.position, 5);
    history_redo(state);
    history_redo(state);
    assert_int_equal(state->source_count, 1);
    assert_int_equal(state->brush.position, 8);
    history_undo(state);
    draw(state, 1);
    history_redo(state);
    assert_int_equal(state->brush.position, 6);
    state->brush.oldest = 1;
    history_undo(state);
    history_undo(state);
    history_undo(state);
    assert_int_equal(state->brush.position, 5);
    assert_int_equal(state->source_count, 0);
    assert_non_null(strstr(view_log_line(state, 0), "older strokes were forgotten"));
    state->brush.oldest = 0;
    history_undo(state);
    assert_int_equal(state->brush.position, 0);
    assert_false(state->unsaved[VIEW_VOXELS]);
    history_end(state);
    view_state_end(state);
    free(state);
}

static void turn_wheel(view_state *state, int notches)
{
    input_mouse mouse = {.x = 0};
    const view_event notch = {.kind = VIEW_EVENT_WHEEL, .control = true, .steps = 1};
    for (int i = 0; i < notches; ++i) {
        (void)input_take(&mouse, &notch, state);
        state->seconds += 0.1;
        history_look(state, false);
    }
}

/* Notches of the wheel that move a light are one step, until it rests or another edit begins. */
static void test_a_turn_of_the_wheel_is_one_step(void **unused)
{
    (void)unused;
    view_state *state = malloc(sizeof *state);
    view_state_begin(state);
    state->width = 640;
    state->height = 400;
    state->camera.at = (svo_camera){.eye = {1, 2, 10}, .up = {0, 1, 0}, .vertical_fov = 0.6F};
    assert_true(light_edit_add(state, SVO_SOURCE_POINT));
    history_begin(state);
    const float first = state->sources[0].position[2];
    turn_wheel(state, 7);
    const float second = state->sources[0].position[2];
    assert_true(view_is_unsaved(state));
    state->seconds += 1;
    history_look(state, false);
    turn_wheel(state, 5);
    const float third = state->sources[0].position[2];
    history_settle(state);
    assert_true(light_edit_add(state, SVO_SOURCE_SPOT));
    history_look(state, false);
    history_undo(state);
    assert_int_equal(state->source_count, 1);
    assert_float_equal(state->sources[0].position[2], third, 0);
    history_undo(state);
    assert_float_equal(state->sources[0].position[2], second, 0);
    history_undo(state);
    assert_float_equal(state->sources[0].position[2], first, 0);
    assert_false(view_is_unsaved(state));
    /* What is undone while the wheel turns is all of its turn. */
    turn_wheel(state, 3);
    history_undo(state);
    assert_float_equal(state->sources[0].position[2], first, 0);
    history_end(state);
    view_state_end(state);
    free(state);
}

/* Lists of many instances: old steps go, and what is left still leads back to where the first of them began. */
static void test_steps_are_bounded(void **unused)
{
    (void)unused;
    enum { INSTANCES = 200000, EDITS = 20 };
    view_state *state = malloc(sizeof *state);
    begin_scene(state);
    const svo_instance first = state->instances[0];
    while (state->instance_count < INSTANCES) {
        assert_true(view_add_instance(state, &first));
    }
    history_begin(state);
    for (int edit = 0; edit < EDITS; ++edit) { /* 20 MB a step */
        for (size_t i = 0; i < state->instance_count; ++i) {
            state->instances[i].transform[3] += 1;
        }
        view_instances_changed(state);
        history_look(state, false);
    }
    int undone = 0;
    for (float x = EDITS + 1; state->instances[0].transform[3] < x; ++undone) {
        x = state->instances[0].transform[3];
        history_undo(state);
    }
    assert_in_range(undone - 1, 1, 2 * (HISTORY_BYTES_MAX / (INSTANCES * 2 * sizeof(svo_instance))));
    assert_true(view_is_unsaved(state));
    history_end(state);
    view_state_end(state);
    free(state);
}

/* ---- questions ---- */

static void press(view_state *state, int key, bool control)
{
    input_mouse mouse = {.x = 0};
    const view_event event = {.kind = VIEW_EVENT_KEY, .key = key, .is_down = true, .control = control};
    if (!question_take(state, &event)) {
        (void)input_take(&mouse, &event, state);
    }
}

static void test_closing_asks_about_unsaved_edits(void **unused)
{
    (void)unused;
    input_mouse mouse = {.x = 0};
    const view_event close = {.kind = VIEW_EVENT_QUIT};
    view_state *state = malloc(sizeof *state);
    begin_scene(state);
    state->input = path_of("model.obj");
    char input[4096];
    (void)snprintf(input, sizeof input, "%s", state->input);
    state->input = input;
    history_begin(state);
    scene_edit_drag(state, 4, 2); /* in the same frame */
    (void)input_take(&mouse, &close, state);
    assert_false(state->is_done);
    assert_int_equal(state->question.asking, VIEW_ASKS_TO_SAVE);
    press(state, VIEW_KEY_ESCAPE, false);
    assert_int_equal(state->question.asking, VIEW_ASKS_NOTHING);
    assert_false(state->is_done);
    /* Another scene. */
    press(state, 'r', true);
    assert_false(state->wants_load);
    question_answer(state, 1);
    assert_true(state->wants_load);
    state->wants_load = false;
    /* Save asks for a name, and then closes. */
    work_folder_remember("model-scene.json");
    press(state, 'q', true);
    press(state, VIEW_KEY_ENTER, false);
    assert_int_equal(state->question.asking, VIEW_ASKS_FOR_NAME);
    assert_string_equal(state->question.path, path_of("model-scene.json"));
    question_answer(state, 0);
    assert_true(state->is_done);
    assert_false(view_is_unsaved(state));
    assert_int_equal(access(path_of("model-scene.json"), F_OK), 0);
    history_end(state);
    view_state_end(state);
    free(state);
}

static void test_saving_replaces_no_other_file_unasked(void **unused)
{
    (void)unused;
    char model[4096];
    char there[4096];
    char text[64] = "";
    view_state *state = malloc(sizeof *state);
    begin_scene(state);
    (void)snprintf(model, sizeof model, "%s", path_of("mesh.obj"));
    (void)snprintf(there, sizeof there, "%s", path_of("mesh-scene.json"));
    write_text("mesh.obj", "v 0 0 0\n");
    write_text("mesh-scene.json", "mine\n");
    state->input = model;
    history_begin(state);
    press(state, 's', true);
    assert_int_equal(state->question.asking, VIEW_ASKS_FOR_NAME);
    question_answer(state, 0);
    assert_int_equal(state->question.asking, VIEW_ASKS_TO_REPLACE);
    press(state, VIEW_KEY_ENTER, false); /* does not replace */
    assert_int_equal(state->question.asking, VIEW_ASKS_TO_REPLACE);
    FILE *file = fopen(there, "rb");
    assert_string_equal(fgets(text, sizeof text, file), "mine\n");
    (void)fclose(file);
    question_answer(state, 0);
    assert_int_equal(state->question.asking, VIEW_ASKS_NOTHING);
    assert_string_equal(state->scene_path, there);
    press(state, 's', true); /* its own file now */
    assert_int_equal(state->question.asking, VIEW_ASKS_NOTHING);
    /* Never what is looked at. */
    question_save_as(state, VIEW_SCENE, model);
    assert_int_equal(state->question.asking, VIEW_ASKS_FOR_NAME);
    assert_true(state->question.has_failed);
    file = fopen(model, "rb");
    assert_string_equal(fgets(text, sizeof text, file), "v 0 0 0\n");
    (void)fclose(file);
    history_end(state);
    view_state_end(state);
    free(state);
}

static void check_floats(const cJSON *object, const char *name, const float *wanted)
{
    const cJSON *values = cJSON_GetObjectItem(object, name);
    assert_int_equal(values != NULL, wanted != NULL);
    for (int i = 0; i < 3 && wanted != NULL; ++i) {
        assert_true((float)cJSON_GetArrayItem(values, i)->valuedouble == wanted[i]);
    }
}

/* Lights of a tree alone go where --lights reads them, bit for bit. */
static void test_saved_lights_are_read_again(void **unused)
{
    (void)unused;
    uint32_t seed = 5;
    view_state *state = malloc(sizeof *state);
    begin_scene(state);
    state->is_scene = false;
    history_begin(state);
    for (uint32_t i = 0; i < 60; ++i) {
        assert_true(light_edit_add(state, i % 4));
        svo_light_source *source = &state->sources[i];
        source->value[0] = random_within(&seed, 0, 9);
        source->radius = i < 30 ? 0 : random_within(&seed, 0.01F, 1.5F);
        if (source->kind == SVO_SOURCE_SPOT) {
            source->outer_angle = random_within(&seed, 0.4F, 1.5F);
            source->inner_angle = random_within(&seed, 0, 0.39F);
        }
    }
    state->sky[1] = 0.1F;
    press(state, 's', true);
    assert_int_equal(state->question.asking, VIEW_ASKS_FOR_NAME);
    assert_int_equal(state->question.document, VIEW_LIGHTS);
    work_folder_remember("lights.json");
    question_save_as(state, VIEW_LIGHTS, path_of("lights.json"));
    assert_false(view_is_unsaved(state));
    char *text = bytes_of(state);
    cJSON *root = cJSON_Parse(strstr(text, "{\n  \"lights\": [\n    {\"kind\""));
    assert_non_null(root);
    const cJSON *lights = cJSON_GetObjectItem(root, "lights");
    assert_int_equal(cJSON_GetArraySize(lights), 60);
    for (int i = 0; i < 60; ++i) {
        const svo_light_source *had = &state->sources[i];
        const cJSON *got = cJSON_GetArrayItem(lights, i);
        check_floats(got, "value", had->value);
        check_floats(got, "direction", had->kind != SVO_SOURCE_POINT ? had->direction : NULL);
        check_floats(got, "position", had->kind != SVO_SOURCE_DIRECTIONAL ? had->position : NULL);
        const double degree = 0.017453292519943295; /* as lights_file.c has it */
        const bool is_sun = had->kind == SVO_SOURCE_DIRECTIONAL;
        const cJSON *radius = cJSON_GetObjectItem(got, is_sun ? "angular_radius" : "radius");
        assert_int_equal(radius != NULL, had->radius > 0);
        assert_true(radius == NULL || (float)(radius->valuedouble * (is_sun ? degree : 1)) == had->radius);
        if (had->kind == SVO_SOURCE_SPOT) {
            assert_true((float)(cJSON_GetObjectItem(got, "inner_angle")->valuedouble * degree) == had->inner_angle);
            assert_true((float)(cJSON_GetObjectItem(got, "outer_angle")->valuedouble * degree) == had->outer_angle);
        }
    }
    check_floats(root, "sky", state->sky);
    check_floats(cJSON_GetObjectItem(root, "camera"), "eye", state->camera.at.eye);
    cJSON_Delete(root);
    free(text);
    history_end(state);
    view_state_end(state);
    free(state);
}

/* The sky of a saved file of lights. */
static cJSON *saved_sky(view_state *state, const sky_file *map, const char *path)
{
    state->sky_map = map;
    assert_int_equal(lights_save(state, path), 0);
    char *text = read_whole(path);
    cJSON *root = cJSON_Parse(text);
    assert_non_null(root);
    cJSON *sky = cJSON_DetachItemFromObject(root, "sky");
    assert_non_null(sky);
    cJSON_Delete(root);
    free(text);
    return sky;
}

/* Skies by direction are written as what they were made of; pictures are found from the file's folder. */
static void test_saved_skies_are_what_they_were_made_of(void **unused)
{
    (void)unused;
    static const char *const names[] = {"zenith", "horizon", "ground"};
    const sky_file gradient = {.gradient = {{0.1F, 0.2F, 1}, {3, 0.3F, 0.7F}, {0, 0.6F, 0.9F}}};
    char folder[4096], path[4096], wanted[8192];
    sky_file picture = {.path = "skies/sky.hdr", .scale = 0.1, .turn = -200.7};
    view_state *state = malloc(sizeof *state);
    begin_scene(state);
    state->is_scene = false;
    work_folder_remember("sky.json");
    (void)snprintf(path, sizeof path, "%s", path_of("sky.json"));
    cJSON *sky = saved_sky(state, &gradient, path);
    assert_int_equal(cJSON_GetArraySize(sky), 3);
    for (int i = 0; i < 3; ++i) {
        check_floats(sky, names[i], gradient.gradient[i]);
    }
    cJSON_Delete(sky);
    assert_non_null(getcwd(folder, sizeof folder));
    (void)snprintf(wanted, sizeof wanted, "%s/skies/sky.hdr", folder);
    sky = saved_sky(state, &picture, path);
    assert_int_equal(cJSON_GetArraySize(sky), 3);
    assert_string_equal(cJSON_GetObjectItem(sky, "file")->valuestring, wanted);
    assert_true(cJSON_GetObjectItem(sky, "scale")->valuedouble == 0.1);
    assert_true(cJSON_GetObjectItem(sky, "turn")->valuedouble == -200.7);
    cJSON_Delete(sky);
    (void)snprintf(wanted, sizeof wanted, "%s/sky.hdr", work_folder());
    picture.path = wanted;
    sky = saved_sky(state, &picture, path);
    assert_string_equal(cJSON_GetObjectItem(sky, "file")->valuestring, wanted);
    cJSON_Delete(sky);
    view_state_end(state);
    free(state);
}

TEST_GROUP(view_edit)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_found_placements_give_the_matrix),
        cmocka_unit_test(test_plain_placements_are_found),
        cmocka_unit_test(test_quarter_turns_and_shear),
        cmocka_unit_test(test_edits),
        cmocka_unit_test(test_saved_instances_are_the_same),
        cmocka_unit_test(test_paths_follow_the_file),
        cmocka_unit_test(test_failed_saves_leave_the_file),
        cmocka_unit_test(test_saves_spare_what_is_shown),
        cmocka_unit_test(test_saved_motions_are_the_same),
        cmocka_unit_test(test_motions_follow_their_first_key),
        cmocka_unit_test(test_angles),
        cmocka_unit_test(test_dragged_light_follows_the_mouse),
        cmocka_unit_test(test_undo_of_all_edits_gives_the_first_bytes),
        cmocka_unit_test(test_a_drag_is_one_step),
        cmocka_unit_test(test_strokes_share_the_history),
        cmocka_unit_test(test_a_turn_of_the_wheel_is_one_step),
        cmocka_unit_test(test_steps_are_bounded),
        cmocka_unit_test(test_closing_asks_about_unsaved_edits),
        cmocka_unit_test(test_saving_replaces_no_other_file_unasked),
        cmocka_unit_test(test_saved_lights_are_read_again),
        cmocka_unit_test(test_saved_skies_are_what_they_were_made_of),
    };
    return cmocka_run_group_tests_name("view_edit", tests, work_folder_make, work_folder_remove);
}
