/* SPDX-License-Identifier: MIT */
/* Settings as JSON. */
#include "view/settings.h"

#include <cjson/cJSON.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "output/output.h"

#define SETTINGS_BYTES_MAX 65536

/* ---- what is in the file ---- */

typedef enum value_kind { VALUE_COUNT, VALUE_FLOAT, VALUE_FLAG } value_kind;

/* A value of the file, which is a field of view_settings. */
typedef struct value {
    const char *name;
    value_kind kind;
    size_t offset;
    double low, high;
} value;

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

static const value values[] = {COUNT(width, VIEW_EDGE_MIN, VIEW_EDGE_MAX),
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

#define VALUES (sizeof values / sizeof values[0])

/* ---- paths ---- */

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

/* ---- reading ---- */

/* Puts a number into its field; false where it does not belong there. */
static bool take_value(const value *which, const cJSON *item, view_settings *settings)
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
    for (size_t i = 0; i < VALUES; ++i) {
        const cJSON *item = cJSON_GetObjectItemCaseSensitive(document, values[i].name);
        if (item != NULL && !take_value(&values[i], item, settings)) {
            return values[i].name;
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

/* ---- writing ---- */

static bool add_value(cJSON *document, const value *which, const view_settings *settings)
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
    for (size_t i = 0; i < VALUES && is_added; ++i) {
        is_added = add_value(document, &values[i], settings);
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
