/* SPDX-License-Identifier: MIT */
/* Writes as it goes, through a small buffer: a scene may have millions of instances. */
#include "view/scene_save.h"

#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "output/output.h"
#include "support/scene_place.h"
#include "view/edit.h"

#define PI 3.14159265358979323846

#define FLUSH_BYTES 8192

typedef struct writer {
    svo_i_output output;
    int error; /* the first one; nothing is written after it */
    size_t used;
    char buffer[2 * FLUSH_BYTES];
} writer;

/* ---- text ---- */

static void flush(writer *to)
{
    if (to->error == 0 && to->used > 0) {
        to->error = svo_i_output_write(&to->output, to->buffer, to->used);
    }
    to->used = 0;
}

/* Texts of at most FLUSH_BYTES. */
static void put(writer *to, const char *text)
{
    const size_t length = strlen(text);
    memcpy(to->buffer + to->used, text, length);
    to->used += length;
    if (to->used >= FLUSH_BYTES) {
        flush(to);
    }
}

/* A character within quotes. */
static void put_character(writer *to, char character)
{
    char text[8] = {character, '\0'};
    if (character == '"' || character == '\\') {
        (void)snprintf(text, sizeof text, "\\%c", character);
    } else if ((unsigned char)character < ' ') {
        (void)snprintf(text, sizeof text, "\\u%04x", (unsigned)(unsigned char)character);
    }
    put(to, text);
}

static void put_quoted(writer *to, const char *text)
{
    put(to, "\"");
    for (; *text != '\0'; ++text) {
        put_character(to, *text);
    }
    put(to, "\"");
}

/* The shortest decimal that is read as the same float. */
static void put_float(writer *to, float value)
{
    char text[32];
    for (int digits = 6; digits <= 9; ++digits) {
        (void)snprintf(text, sizeof text, "%.*g", digits, (double)value);
        if (strtof(text, NULL) == value) {
            break;
        }
    }
    put(to, text);
}

static void put_floats(writer *to, const char *name, const float *values, int count)
{
    put_quoted(to, name);
    put(to, ": [");
    for (int i = 0; i < count; ++i) {
        put(to, i > 0 ? ", " : "");
        put_float(to, values[i]);
    }
    put(to, "]");
}

/* ---- trees ---- */

/* The bytes of a path's folder, with its slash. */
static size_t folder_bytes(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash != NULL ? (size_t)(slash + 1 - path) : 0;
}

/* A scene's paths begin where its file is; the tree's begins where the program runs. */
static int put_path(writer *to, const char *tree, const char *scene)
{
    char folder[PATH_MAX];
    char absolute[2 * PATH_MAX];
    const size_t shared = folder_bytes(scene);
    if (shared == 0 || tree[0] == '/' || strncmp(tree, "scene:", 6) == 0) {
        put_quoted(to, tree);
    } else if (strncmp(tree, scene, shared) == 0) {
        put_quoted(to, tree + shared);
    } else if (getcwd(folder, sizeof folder) != NULL) {
        (void)snprintf(absolute, sizeof absolute, "%s/%s", folder, tree);
        put_quoted(to, absolute);
    } else {
        return errno;
    }
    return 0;
}

static int put_trees(writer *to, const view_state *state, const char *path)
{
    char depth[32];
    put(to, "  \"trees\": {");
    for (size_t i = 0; i < state->tree_count; ++i) {
        const view_tree *tree = &state->trees[i];
        put(to, i > 0 ? ",\n    " : "\n    ");
        put_quoted(to, tree->name);
        put(to, ": {\"path\": ");
        const int error = put_path(to, tree->path, path);
        if (error != 0) {
            return error;
        }
        if (tree->depth > 0) {
            (void)snprintf(depth, sizeof depth, ", \"depth\": %u", tree->depth);
            put(to, depth);
        }
        put(to, "}");
    }
    put(to, "\n  },\n");
    return 0;
}

/* ---- instances ---- */

static bool is_all(const float values[3], float value)
{
    return values[0] == value && values[1] == value && values[2] == value;
}

static void put_place(writer *to, const scene_place *place)
{
    if (!is_all(place->translate, 0)) {
        put(to, ", ");
        put_floats(to, "translate", place->translate, 3);
    }
    if (!is_all(place->rotate, 0)) {
        put(to, ", ");
        put_floats(to, "rotate", place->rotate, 3);
    }
    if (is_all(place->scale, place->scale[0]) && place->scale[0] != 1) {
        put(to, ", \"scale\": ");
        put_float(to, place->scale[0]);
    } else if (!is_all(place->scale, 1)) {
        put(to, ", ");
        put_floats(to, "scale", place->scale, 3);
    }
}

static void put_motion(writer *to, const view_mover *mover)
{
    put(to, ", \"motion\": [");
    for (size_t i = 0; i < mover->motion->key_count; ++i) {
        const scene_place place = view_mover_key(mover, i);
        put(to, i > 0 ? ",\n      {\"time\": " : "\n      {\"time\": ");
        put_float(to, mover->motion->keys[i].time);
        put_place(to, &place);
        put(to, "}");
    }
    put(to, "]");
}

/* As a placement where that gives the matrix exactly. */
static void put_instance(writer *to, const view_state *state, size_t index)
{
    const svo_instance *instance = &state->instances[index];
    const view_mover *mover = view_mover_of(state, index);
    scene_place place;
    put(to, "    {\"tree\": ");
    put_quoted(to, state->trees[instance->tree].name);
    if (mover != NULL) {
        put_motion(to, mover);
    } else if (scene_place_find(instance->transform, &place) && scene_place_is_exact(&place, instance->transform)) {
        put_place(to, &place);
    } else {
        put(to, ", ");
        put_floats(to, "matrix", instance->transform, 12);
    }
    put(to, "}");
}

/* ---- the rest ---- */

static void put_camera(writer *to, const svo_camera *camera)
{
    put(to, "  \"camera\": {");
    put_floats(to, "eye", camera->eye, 3);
    put(to, ", ");
    put_floats(to, "target", camera->target, 3);
    put(to, ", ");
    put_floats(to, "up", camera->up, 3);
    put(to, ", \"fov\": ");
    put_float(to, (float)((double)camera->vertical_fov * 180 / PI));
    put(to, "}");
}

static void put_lights(writer *to, const view_state *state)
{
    put(to, ",\n  \"lights\": [");
    for (size_t i = 0; i < state->scene_light_count; ++i) {
        const svo_scene_light *light = &state->scene_lights[i];
        put(to, i > 0 ? ",\n    {" : "\n    {");
        put_floats(to, "direction", light->direction, 3);
        put(to, ", ");
        put_floats(to, "color", light->color, 3);
        put(to, light->shadows != 0 ? ", \"shadows\": true}" : ", \"shadows\": false}");
    }
    put(to, "\n  ]");
}

static int put_scene(writer *to, const view_state *state, const char *path)
{
    put(to, "{\n  \"form\": ");
    put_quoted(to, state->scene_form != NULL ? state->scene_form : "built");
    put(to, ",\n");
    const int error = put_trees(to, state, path);
    if (error != 0) {
        return error;
    }
    put(to, "  \"instances\": [");
    for (size_t i = 0; i < state->instance_count; ++i) {
        put(to, i > 0 ? ",\n" : "\n");
        put_instance(to, state, i);
    }
    put(to, "\n  ],\n");
    put_camera(to, &state->camera.at);
    if (state->scene_light_count > 0) {
        put_lights(to, state);
    }
    if (state->occlusion_range > 0) {
        put(to, ",\n  \"occlusion_range\": ");
        put_float(to, state->occlusion_range);
    }
    put(to, "\n}\n");
    flush(to);
    return to->error;
}

/* ---- lights of a tree ---- */

/* Radians as degrees that give the same float again. */
static void put_angle(writer *to, const char *name, float radians)
{
    char text[64];
    (void)snprintf(text, sizeof text, ", \"%s\": %.17g", name, (double)radians * 180 / PI);
    put(to, text);
}

static void put_source(writer *to, const svo_light_source *source)
{
    static const char *const kinds[] = {"directional", "point", "spot"};
    put(to, "    {\"kind\": ");
    put_quoted(to, kinds[source->kind <= SVO_SOURCE_SPOT ? source->kind : SVO_SOURCE_DIRECTIONAL]);
    if (source->kind != SVO_SOURCE_DIRECTIONAL) {
        put(to, ", ");
        put_floats(to, "position", source->position, 3);
    }
    if (source->kind != SVO_SOURCE_POINT) {
        put(to, ", ");
        put_floats(to, "direction", source->direction, 3);
    }
    put(to, ", ");
    put_floats(to, "value", source->value, 3);
    if (source->kind == SVO_SOURCE_SPOT) {
        put_angle(to, "inner_angle", source->inner_angle);
        put_angle(to, "outer_angle", source->outer_angle);
    }
    put(to, "}");
}

static int put_sources(writer *to, const view_state *state, const char *path)
{
    const svo_camera *camera = &state->camera.at;
    (void)path;
    put(to, "{\n  \"lights\": [");
    for (size_t i = 0; i < state->source_count; ++i) {
        put(to, i > 0 ? ",\n" : "\n");
        put_source(to, &state->sources[i]);
    }
    put(to, "\n  ],\n  ");
    put_floats(to, "sky", state->sky, 3);
    put(to, ",\n  \"camera\": {");
    put_floats(to, "eye", camera->eye, 3);
    put(to, ", ");
    put_floats(to, "at", camera->target, 3);
    put(to, ", ");
    put_floats(to, "up", camera->up, 3);
    put_angle(to, "fov", camera->vertical_fov);
    put(to, "}\n}\n");
    flush(to);
    return to->error;
}

/* ---- files ---- */

static int save(const view_state *state, const char *path,
                int (*put_all)(writer *to, const view_state *state, const char *path))
{
    writer to = {.error = 0};
    to.error = svo_i_output_open(path, NULL, &to.output);
    if (to.error != 0) {
        return to.error;
    }
    const int error = put_all(&to, state, path);
    if (error != 0) {
        svo_i_output_abandon(&to.output);
        return error;
    }
    return svo_i_output_commit(&to.output);
}

int scene_save(const view_state *state, const char *path)
{
    return save(state, path, put_scene);
}

int lights_save(const view_state *state, const char *path)
{
    return save(state, path, put_sources);
}
