/* SPDX-License-Identifier: MIT */
/* Settings as JSON. Scenes and lights are written as they go, through a small buffer: a scene may have millions of
   instances. */
#include "view/files.h"

#include <cjson/cJSON.h>
#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "output/output.h"
#include "support/scene_place.h"
#include "view/edit.h"

#define PI 3.14159265358979323846

#define SETTINGS_BYTES_MAX 65536

/* ---- what settings have ---- */

typedef enum value_kind { VALUE_COUNT, VALUE_FLOAT, VALUE_FLAG } value_kind;

/* A value of the file, which is a field of view_settings. */
typedef struct setting {
    const char *name;
    value_kind kind;
    size_t offset;
    double low, high;
} setting;

#define COUNT(name, low, high)                                           \
    {                                                                    \
#name, VALUE_COUNT, offsetof(view_settings, name), (low), (high) \
    }
#define FLOAT(name, low, high)                                           \
    {                                                                    \
#name, VALUE_FLOAT, offsetof(view_settings, name), (low), (high) \
    }
#define FLAG(name)                                             \
    {                                                          \
#name, VALUE_FLAG, offsetof(view_settings, name), 0, 1 \
    }

static const setting rules[] = {COUNT(width, VIEW_EDGE_MIN, VIEW_EDGE_MAX),
                                COUNT(height, VIEW_EDGE_MIN, VIEW_EDGE_MAX),
                                COUNT(coarse, 0, VIEW_COARSE_MAX),
                                FLOAT(turn_speed, 0.01, 100),
                                FLOAT(move_speed, 0.0001, 100),
                                FLOAT(goal_ms, 1, 10000),
                                FLOAT(text_scale, 0, 8),
                                FLAG(fullscreen),
                                FLAG(panels),
                                FLAG(axes),
                                FLAG(grid)};

#define RULES (sizeof rules / sizeof rules[0])

/* ---- the place of settings ---- */

void settings_find(settings_file *out)
{
    const char *config = getenv("XDG_CONFIG_HOME");
    const char *home = getenv("HOME");
    int length = 0;
    /* The standard has relative paths ignored. */
    if (config != NULL && config[0] == '/') {
        length = snprintf(out->path, sizeof out->path, "%s/svocl/view.json", config);
    } else if (home != NULL && home[0] == '/') {
        length = snprintf(out->path, sizeof out->path, "%s/.config/svocl/view.json", home);
    }
    if (length <= 0 || (size_t)length >= sizeof out->path) {
        out->path[0] = '\0';
    }
}

/* Makes the folders of a path that are missing. Returns 0 or an errno. */
static int make_folders(const char *path)
{
    char folder[SETTINGS_PATH_BYTES];
    (void)snprintf(folder, sizeof folder, "%s", path);
    for (char *slash = strchr(folder + 1, '/'); slash != NULL; slash = strchr(slash + 1, '/')) {
        *slash = '\0';
        if (mkdir(folder, 0700) != 0 && errno != EEXIST) {
            return errno;
        }
        *slash = '/';
    }
    return 0;
}

/* ---- reading settings ---- */

/* Puts a number into its field; false where it does not belong there. */
static bool take_value(const setting *which, const cJSON *item, view_settings *settings)
{
    void *field = (char *)settings + which->offset;
    if (which->kind == VALUE_FLAG) {
        *(bool *)field = cJSON_IsTrue(item);
        return cJSON_IsBool(item);
    }
    if (!cJSON_IsNumber(item) || !(item->valuedouble >= which->low && item->valuedouble <= which->high)) {
        return false;
    }
    if (which->kind == VALUE_FLOAT) {
        *(float *)field = (float)item->valuedouble;
    } else {
        *(unsigned *)field = (unsigned)item->valuedouble;
    }
    return true;
}

/* Files that were opened. */
static bool take_recent(const cJSON *list, view_settings *settings)
{
    const cJSON *item = NULL;
    size_t count = 0;
    memset(settings->recent, 0, sizeof settings->recent);
    cJSON_ArrayForEach(item, list)
    {
        if (!cJSON_IsString(item) || strlen(item->valuestring) >= sizeof settings->recent[0]) {
            return false;
        }
        if (count < VIEW_RECENT_MAX) {
            (void)snprintf(settings->recent[count++], sizeof settings->recent[0], "%s", item->valuestring);
        }
    }
    return cJSON_IsArray(list);
}

/* The names of the panels that are open. */
static bool take_open(const cJSON *list, view_settings *settings)
{
    const cJSON *item = NULL;
    memset(settings->open, 0, sizeof settings->open);
    cJSON_ArrayForEach(item, list)
    {
        for (int panel = 0; panel < VIEW_PANELS && cJSON_IsString(item); ++panel) {
            if (strcmp(item->valuestring, view_panel_name((view_panel)panel)) == 0) {
                settings->open[panel] = true;
            }
        }
    }
    return cJSON_IsArray(list);
}

/* Returns the name of the value that is wrong, or NULL. What the file does not have stays. */
static const char *take_document(const cJSON *document, view_settings *settings)
{
    if (!cJSON_IsObject(document)) {
        return "its content";
    }
    for (size_t i = 0; i < RULES; ++i) {
        const cJSON *item = cJSON_GetObjectItemCaseSensitive(document, rules[i].name);
        if (item != NULL && !take_value(&rules[i], item, settings)) {
            return rules[i].name;
        }
    }
    const cJSON *recent = cJSON_GetObjectItemCaseSensitive(document, "recent");
    const cJSON *open = cJSON_GetObjectItemCaseSensitive(document, "open");
    return recent != NULL && !take_recent(recent, settings) ? "recent"
           : open != NULL && !take_open(open, settings)     ? "open"
                                                            : NULL;
}

/* The file as text; false with errno 0 where it is too long. */
static bool read_text(const char *path, char *text, size_t text_bytes)
{
    FILE *file = fopen(path, "rb");
    if (file == NULL) {
        return false;
    }
    const size_t length = fread(text, 1, text_bytes, file);
    const int error = ferror(file) != 0 ? EIO : 0;
    (void)fclose(file);
    errno = error;
    if (error != 0 || length == text_bytes) {
        return false;
    }
    text[length] = '\0';
    return true;
}

/* Reads the text into settings. Returns what is wrong with it, or NULL. */
static const char *take_text(const char *text, view_settings *settings)
{
    cJSON *document = cJSON_Parse(text);
    const char *wrong = document != NULL ? take_document(document, settings) : "its JSON";
    cJSON_Delete(document);
    return wrong;
}

bool settings_load(const settings_file *file, view_state *state)
{
    view_settings read = state->settings;
    char *text = file->path[0] != '\0' ? malloc(SETTINGS_BYTES_MAX) : NULL;
    if (text == NULL) {
        return true;
    }
    bool is_whole = true;
    if (read_text(file->path, text, SETTINGS_BYTES_MAX)) {
        const char *wrong = take_text(text, &read);
        is_whole = wrong == NULL;
        state->settings = is_whole ? read : state->settings;
        if (!is_whole) {
            view_log(state, "%s: %s is damaged; defaults are taken", file->path, wrong);
        }
    } else if (errno != ENOENT && errno != ENOTDIR) {
        is_whole = false;
        view_log(state, "%s: %s; defaults are taken", file->path, errno != 0 ? strerror(errno) : "it is too long");
    }
    free(text);
    return is_whole;
}

/* ---- writing settings ---- */

static bool add_value(cJSON *document, const setting *which, const view_settings *settings)
{
    const void *field = (const char *)settings + which->offset;
    if (which->kind == VALUE_FLAG) {
        return cJSON_AddBoolToObject(document, which->name, *(const bool *)field) != NULL;
    }
    return cJSON_AddNumberToObject(document, which->name,
                                   which->kind == VALUE_FLOAT ? (double)*(const float *)field
                                                              : (double)*(const unsigned *)field) != NULL;
}

static bool add_open(cJSON *document, const view_settings *settings)
{
    cJSON *list = cJSON_AddArrayToObject(document, "open");
    bool is_added = list != NULL;
    for (int panel = 0; panel < VIEW_PANELS && is_added; ++panel) {
        if (settings->open[panel]) {
            cJSON *name = cJSON_CreateString(view_panel_name((view_panel)panel));
            is_added = name != NULL && cJSON_AddItemToArray(list, name);
        }
    }
    return is_added;
}

static bool add_recent(cJSON *document, const view_settings *settings)
{
    cJSON *list = cJSON_AddArrayToObject(document, "recent");
    bool is_added = list != NULL;
    for (int i = 0; i < VIEW_RECENT_MAX && settings->recent[i][0] != '\0' && is_added; ++i) {
        cJSON *path = cJSON_CreateString(settings->recent[i]);
        is_added = path != NULL && cJSON_AddItemToArray(list, path);
    }
    return is_added;
}

/* The text of the file, by malloc; NULL without memory. */
static char *print(const view_settings *settings)
{
    cJSON *document = cJSON_CreateObject();
    bool is_added = document != NULL;
    for (size_t i = 0; i < RULES && is_added; ++i) {
        is_added = add_value(document, &rules[i], settings);
    }
    is_added = is_added && add_recent(document, settings) && add_open(document, settings);
    char *text = is_added ? cJSON_Print(document) : NULL;
    cJSON_Delete(document);
    return text;
}

/* Returns 0 or an errno. */
static int write_text(const char *path, const char *text)
{
    svo_i_output output = {.descriptor = -1};
    int error = make_folders(path);
    error = error == 0 ? svo_i_output_open(path, NULL, &output) : error;
    if (error != 0) {
        return error;
    }
    error = svo_i_output_write(&output, text, strlen(text));
    if (error == 0) {
        return svo_i_output_commit(&output);
    }
    svo_i_output_abandon(&output);
    return error;
}

bool settings_save(const settings_file *file, view_state *state)
{
    if (file->path[0] == '\0') {
        return true;
    }
    char *text = print(&state->settings);
    const int error = text != NULL ? write_text(file->path, text) : ENOMEM;
    if (error != 0) {
        view_log(state, "%s: %s; the settings are not kept", file->path, strerror(error));
    }
    cJSON_free(text);
    return error == 0;
}

/* ---- text of scenes ---- */

#define FLUSH_BYTES 8192

typedef struct writer {
    svo_i_output output;
    int error; /* the first one; nothing is written after it */
    size_t used;
    char buffer[2 * FLUSH_BYTES];
} writer;

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

/* ---- trees of scenes ---- */

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

/* ---- cameras, lights, whole scenes ---- */

/* A camera up to its angle. target: what the file calls that. */
static void put_camera(writer *to, const svo_camera *camera, const char *target)
{
    put(to, "  \"camera\": {");
    put_floats(to, "eye", camera->eye, 3);
    put(to, ", ");
    put_floats(to, target, camera->target, 3);
    put(to, ", ");
    put_floats(to, "up", camera->up, 3);
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
    put_camera(to, &state->camera.at, "target");
    put(to, ", \"fov\": ");
    put_float(to, (float)((double)state->camera.at.vertical_fov * 180 / PI));
    put(to, "}");
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

static void put_number(writer *to, const char *name, double number)
{
    char text[64];
    (void)snprintf(text, sizeof text, ", \"%s\": %.17g", name, number);
    put(to, text);
}

/* Radians as degrees that give the same float again. */
static void put_angle(writer *to, const char *name, float radians)
{
    put_number(to, name, (double)radians * 180 / PI);
}

static void put_source(writer *to, const svo_light_source *source)
{
    static const char *const kinds[] = {"directional", "point", "spot", "disk"};
    put(to, "    {\"kind\": ");
    put_quoted(to, kinds[source->kind <= SVO_SOURCE_DISK ? source->kind : SVO_SOURCE_DIRECTIONAL]);
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
    if (source->radius > 0.0F && source->kind == SVO_SOURCE_DIRECTIONAL) {
        put_angle(to, "angular_radius", source->radius);
    } else if (source->radius > 0.0F) {
        put(to, ", \"radius\": ");
        put_float(to, source->radius);
    }
    if (source->kind == SVO_SOURCE_SPOT) {
        put_angle(to, "inner_angle", source->inner_angle);
        put_angle(to, "outer_angle", source->outer_angle);
    }
    put(to, "}");
}

/* One radiance, or what the map was made of. */
static int put_sky(writer *to, const view_state *state, const char *path)
{
    static const char *const names[] = {"zenith", "horizon", "ground"};
    const sky_file *map = state->sky_map;
    int error = 0;
    if (map == NULL) {
        put_floats(to, "sky", state->sky, 3);
        return 0;
    }
    put(to, "\"sky\": {");
    if (map->path != NULL) {
        put(to, "\"file\": ");
        error = put_path(to, map->path, path);
        put_number(to, "scale", map->scale);
        put_number(to, "turn", map->turn);
    }
    for (int i = 0; i < 3 && map->path == NULL; ++i) {
        put(to, i > 0 ? ", " : "");
        put_floats(to, names[i], map->gradient[i], 3);
    }
    put(to, "}");
    return error;
}

static int put_sources(writer *to, const view_state *state, const char *path)
{
    put(to, "{\n  \"lights\": [");
    for (size_t i = 0; i < state->source_count; ++i) {
        put(to, i > 0 ? ",\n" : "\n");
        put_source(to, &state->sources[i]);
    }
    put(to, "\n  ],\n  ");
    const int error = put_sky(to, state, path);
    if (error != 0) {
        return error;
    }
    put(to, ",\n");
    put_camera(to, &state->camera.at, "at");
    put_angle(to, "fov", state->camera.at.vertical_fov);
    put(to, "}\n}\n");
    flush(to);
    return to->error;
}

/* ---- scenes and lights to files ---- */

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
