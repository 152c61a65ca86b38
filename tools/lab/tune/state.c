/* SPDX-License-Identifier: MIT */
/* The state of a sweep as JSON: raw rounds of each setting, raw blocks of errors. */
#include "tune/state.h"

#include <errno.h>
#include <inttypes.h>
#include <string.h>
#include <unistd.h>

#include "support/json.h"
#include "support/json_source.h"

/* ---- writing ---- */

/* With all digits, some of which cJSON leaves out: a run that goes on computes with the same numbers. */
static cJSON *exact_number(double number)
{
    char text[32];
    (void)snprintf(text, sizeof text, "%.17g", number);
    return cJSON_CreateRaw(text);
}

static cJSON *exact_array(const double *numbers, size_t count)
{
    cJSON *list = cJSON_CreateArray();
    for (size_t i = 0; i < count; ++i) {
        cJSON_AddItemToArray(list, exact_number(numbers[i]));
    }
    return list;
}

static cJSON *record_to_json(const tune_errors *errors)
{
    cJSON *object = cJSON_CreateObject();
    cJSON_AddNumberToObject(object, "kind", errors->kind);
    cJSON_AddItemToObject(object, "voxel", exact_number(errors->voxel));
    cJSON_AddItemToObject(object, "faces", exact_number(errors->faces));
    json_add_count(object, "voxels", errors->voxels);
    json_add_count(object, "rungs", errors->rungs);
    cJSON *of = cJSON_AddObjectToObject(object, "of");
    for (tune_quantity i = QUANTITY_VOXEL; i < QUANTITY_COUNT; ++i) {
        const sample_block sum = samples_sum(&errors->of[i]);
        if (sum.count > 0) {
            cJSON *list = cJSON_AddArrayToObject(of, quantity_name(i));
            for (size_t k = 0; k < SAMPLE_BLOCKS; ++k) {
                const sample_block *block = &errors->of[i].blocks[k];
                const double numbers[4] = {block->count, block->sum, block->square_sum, block->most};
                cJSON_AddItemToArray(list, exact_array(numbers, 4));
            }
        }
    }
    return object;
}

static cJSON *setting_to_json(const sweep *all, size_t index)
{
    char value[32];
    text_list text;
    const sweep_setting *own = &all->settings[index];
    const candidate *of = &all->candidates[index];
    cJSON *object = cJSON_CreateObject();
    tune_setting_command(all->state, &own->setting, &text);
    json_add_text(object, "command", text.text);
    for (tune_dimension i = DIMENSION_DEPTH; i < DIMENSION_COUNT; ++i) {
        dimension_value(i, own->setting.values[i], value, sizeof value);
        json_add_text(object, dimension_name(i), value);
    }
    cJSON_AddItemToObject(object, "first_ms", exact_number(own->first_ms));
    cJSON_AddItemToObject(object, "rounds_ms", exact_array(of->rounds, of->round_count));
    cJSON_AddNumberToObject(object, "peak_bytes", of->bytes);
    cJSON_AddNumberToObject(object, "result_bytes", own->result_bytes);
    cJSON_AddItemToObject(object, "query_us", exact_number(own->query_us));
    json_add_text(object, "left", race_left_name(of->left));
    json_add_count(object, "left_after", of->left_after);
    json_add_text(object, "reason", own->reason.text);
    cJSON *records = cJSON_AddArrayToObject(object, "errors");
    for (int kind = 0; kind < KIND_COUNT; ++kind) {
        cJSON_AddItemToArray(records, own->records[kind] == SIZE_MAX ? cJSON_CreateNull()
                                                                     : cJSON_CreateNumber((double)own->records[kind]));
    }
    return object;
}

static void add_text_or_empty(cJSON *object, const char *name, const char *text)
{
    json_add_text(object, name, text != NULL ? text : "");
}

typedef struct lights_mark {
    char text[17];
} lights_mark;

static uint64_t add_bytes(uint64_t hash, const void *bytes, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        hash = (hash ^ ((const uint8_t *)bytes)[i]) * 0x100000001b3u;
    }
    return hash;
}

/* Of what the lights and the sky are, whatever their file is called: FNV-1a. */
static lights_mark mark_of_lights(const svo_light_setup *setup)
{
    lights_mark mark;
    uint64_t hash = 0xcbf29ce484222325u;
    hash = add_bytes(hash, setup->sources, setup->source_count * sizeof *setup->sources);
    hash = add_bytes(hash, setup->sky, sizeof setup->sky);
    hash = add_bytes(hash, setup->sky_map, 3 * (size_t)setup->sky_width * setup->sky_height * sizeof *setup->sky_map);
    (void)snprintf(mark.text, sizeof mark.text, "%016" PRIx64, hash);
    return mark;
}

cJSON *state_to_json(const sweep *all)
{
    const options *given = &all->state->options;
    cJSON *document = json_document();
    json_add_text(document, "input", given->input);
    json_add_count(document, "triangles", all->made->source->mesh->triangle_count);
    cJSON_AddItemToObject(document, "area", exact_number(all->made->area));
    add_text_or_empty(document, "error", given->error_list);
    add_text_or_empty(document, "free", given->free_list);
    cJSON_AddItemToObject(document, "time_s", exact_number(given->time_bound));
    json_add_count(document, "memory", given->memory_bound);
    add_text_or_empty(document, "lights", given->lights_path);
    json_add_text(document, "light", mark_of_lights(&all->made->setup).text);
    cJSON_AddBoolToObject(document, "exhaustive", all->exhaustive);
    json_add_count(document, "seed", all->seed);
    json_add_count(document, "queries", all->runs->queries);
    cJSON *settings = cJSON_AddArrayToObject(document, "settings");
    for (size_t i = 0; i < all->count; ++i) {
        cJSON_AddItemToArray(settings, setting_to_json(all, i));
    }
    cJSON *records = cJSON_AddArrayToObject(document, "errors");
    for (size_t i = 0; i < all->record_count; ++i) {
        cJSON_AddItemToArray(records, record_to_json(&all->records[i]));
    }
    return document;
}

int state_save(const sweep *all)
{
    if (all->state->options.resume_path == NULL) {
        return PROGRAM_DONE;
    }
    cJSON *document = state_to_json(all);
    const int exit_code = json_save(all->state, all->state->options.resume_path, document);
    cJSON_Delete(document);
    return exit_code;
}

/* ---- reading ---- */

static double number_of(const cJSON *object, const char *name)
{
    const cJSON *number = cJSON_GetObjectItemCaseSensitive(object, name);
    return cJSON_IsNumber(number) ? number->valuedouble : 0;
}

/* 0 also for what is no count. */
static uint64_t count_of(const cJSON *object, const char *name)
{
    const double number = number_of(object, name);
    return number > 0 && number < 0x1p53 ? (uint64_t)number : 0;
}

static bool has_text(const cJSON *object, const char *name, const char *text)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(object, name);
    return cJSON_IsString(item) && strcmp(item->valuestring, text != NULL ? text : "") == 0;
}

/* Whether the state is of the same mesh, the same settings, which commands tell with all else that is given, and the
   same wishes. */
static bool is_same_sweep(const sweep *all, const cJSON *root, const cJSON *settings)
{
    char value[32];
    text_list line;
    const options *given = &all->state->options;
    bool same = has_text(root, "input", given->input) &&
                number_of(root, "triangles") == (double)all->made->source->mesh->triangle_count &&
                number_of(root, "area") == all->made->area && number_of(root, "seed") == all->seed &&
                number_of(root, "queries") == (double)all->runs->queries &&
                has_text(root, "light", mark_of_lights(&all->made->setup).text) &&
                has_text(root, "error", given->error_list) && number_of(root, "time_s") == given->time_bound &&
                number_of(root, "memory") == (double)given->memory_bound &&
                cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(root, "exhaustive")) == all->exhaustive &&
                (size_t)cJSON_GetArraySize(settings) == all->count;
    const cJSON *one = settings != NULL ? settings->child : NULL;
    for (size_t i = 0; i < all->count && same && one != NULL; ++i, one = one->next) {
        tune_setting_command(all->state, &all->settings[i].setting, &line);
        same = has_text(one, "command", line.text);
        for (tune_dimension k = DIMENSION_DEPTH; k < DIMENSION_COUNT && same; ++k) {
            dimension_value(k, all->settings[i].setting.values[k], value, sizeof value);
            same = has_text(one, dimension_name(k), value);
        }
    }
    return same;
}

static race_left left_of(const cJSON *setting)
{
    race_left left = LEFT_NOT;
    while (left < LEFT_COUNT && !has_text(setting, "left", race_left_name(left))) {
        ++left;
    }
    return left < LEFT_COUNT ? left : LEFT_NOT;
}

static void read_setting(const cJSON *object, sweep_setting *own, candidate *of)
{
    const cJSON *rounds = cJSON_GetObjectItemCaseSensitive(object, "rounds_ms");
    const cJSON *reason = cJSON_GetObjectItemCaseSensitive(object, "reason");
    const cJSON *round = cJSON_IsArray(rounds) ? rounds->child : NULL;
    for (; round != NULL && of->round_count < BOOTSTRAP_ROUNDS_MAX; round = round->next) {
        of->rounds[of->round_count] = round->valuedouble;
        of->round_count += cJSON_IsNumber(round) && round->valuedouble > 0;
    }
    own->first_ms = number_of(object, "first_ms");
    own->result_bytes = number_of(object, "result_bytes");
    own->query_us = number_of(object, "query_us");
    of->bytes = number_of(object, "peak_bytes");
    of->left = left_of(object);
    of->left_after = (unsigned)count_of(object, "left_after");
    (void)snprintf(own->reason.text, sizeof own->reason.text, "%s", cJSON_IsString(reason) ? reason->valuestring : "");
}

static void read_block(const cJSON *numbers, sample_block *out)
{
    out->count = cJSON_GetArraySize(numbers) == 4 ? cJSON_GetArrayItem(numbers, 0)->valuedouble : 0;
    out->sum = out->count > 0 ? cJSON_GetArrayItem(numbers, 1)->valuedouble : 0;
    out->square_sum = out->count > 0 ? cJSON_GetArrayItem(numbers, 2)->valuedouble : 0;
    out->most = out->count > 0 ? cJSON_GetArrayItem(numbers, 3)->valuedouble : 0;
}

static void read_record(const cJSON *object, tune_errors *out)
{
    const cJSON *of = cJSON_GetObjectItemCaseSensitive(object, "of");
    out->voxel = number_of(object, "voxel");
    out->faces = number_of(object, "faces");
    out->voxels = count_of(object, "voxels");
    out->rungs = (size_t)count_of(object, "rungs");
    for (tune_quantity i = QUANTITY_VOXEL; i < QUANTITY_COUNT; ++i) {
        const cJSON *list = cJSON_GetObjectItemCaseSensitive(of, quantity_name(i));
        const cJSON *block = cJSON_IsArray(list) ? list->child : NULL;
        for (size_t k = 0; k < SAMPLE_BLOCKS && block != NULL; ++k, block = block->next) {
            read_block(block, &out->of[i].blocks[k]);
        }
    }
}

static int read_state(sweep *all, const cJSON *root)
{
    const cJSON *settings = cJSON_GetObjectItemCaseSensitive(root, "settings");
    const cJSON *records = cJSON_GetObjectItemCaseSensitive(root, "errors");
    if (!cJSON_IsArray(settings) || !cJSON_IsArray(records) || !is_same_sweep(all, root, settings) ||
        (size_t)cJSON_GetArraySize(records) != all->record_count) {
        return program_fail(all->state, PROGRAM_FAILED,
                            "--resume %s: it is of another mesh, other settings or other bounds",
                            all->state->options.resume_path);
    }
    size_t index = 0;
    for (const cJSON *one = settings->child; one != NULL; one = one->next, ++index) {
        read_setting(one, &all->settings[index], &all->candidates[index]);
    }
    index = 0;
    for (const cJSON *one = records->child; one != NULL; one = one->next) {
        read_record(one, &all->records[index++]);
    }
    return PROGRAM_DONE;
}

/* The file is read and written, which no other command does; so it is not among the inputs that outputs spare. */
int state_resume(sweep *all)
{
    const char *path = all->state->options.resume_path;
    json_source source;
    if (path == NULL || (access(path, F_OK) != 0 && errno == ENOENT)) {
        return PROGRAM_DONE;
    }
    int exit_code = json_source_open(all->state, path, &source);
    if (exit_code == PROGRAM_DONE) {
        exit_code = read_state(all, source.root);
        json_source_close(&source);
    }
    return exit_code;
}
