/* SPDX-License-Identifier: MIT */
/* Makes and describes the compact trees that commands hold and write. */
#include "support/tree_form.h"

#include "support/input.h"
#include "support/table.h"

#define DEFAULT_DIRECTORY_STEP_LOG2 5u

svo_compact_options tree_form_options(const options *given)
{
    const svo_form form = (svo_form)(given->tree_form - 1);
    const uint32_t step =
        given->directory_step_log2 != 0 ? (uint32_t)given->directory_step_log2 : DEFAULT_DIRECTORY_STEP_LOG2;
    return (svo_compact_options){.struct_size = sizeof(svo_compact_options),
                                 .form = form,
                                 .directory_step_log2 = form == SVO_FORM_IMPLIED ? step : 0,
                                 .minimize = (uint32_t)given->minimize};
}

bool tree_form_fits(const svo_compact *compact, const svo_compact_options *asked)
{
    svo_compact_info info = SVO_COMPACT_INFO_INIT;
    return svo_compact_get_info(compact, &info) == SVO_OK && info.form == asked->form && asked->minimize == 0 &&
           info.directory_step_log2 == asked->directory_step_log2;
}

bool tree_form_is_plain(const svo_compact *compact)
{
    svo_compact_info info = SVO_COMPACT_INFO_INIT;
    return svo_compact_get_info(compact, &info) == SVO_OK && info.packed == 0;
}

/* ---- packing ---- */

bool tree_form_keeps(const program *state, const svo_compact *compact)
{
    const svo_compact_options asked = tree_form_options(&state->options);
    return tree_form_fits(compact, &asked) && (options_packing(&state->options) == NULL || tree_form_is_plain(compact));
}

int tree_form_pack(program *state, const session *opened, svo_compact **compact)
{
    svo_compact *packed = NULL;
    const svo_pack_options asked = {.struct_size = sizeof asked,
                                    .color_error = (uint32_t)state->options.color_error,
                                    .normal_bits = (uint32_t)state->options.normal_bits};
    if (options_packing(&state->options) == NULL) {
        return PROGRAM_DONE;
    }
    if (svo_compact_pack(*compact, &asked, opened->queue, &packed) != SVO_OK) {
        return program_fail_library(state, svo_device_message(opened->device));
    }
    svo_compact_destroy(compact);
    *compact = packed;
    return PROGRAM_DONE;
}

/* ---- making ---- */

static int make(program *state, const session *opened, const svo_tree *tree, svo_compact **out)
{
    const svo_compact_options asked = tree_form_options(&state->options);
    return svo_compact_create(opened->device, tree, &asked, opened->queue, out) == SVO_OK
               ? tree_form_pack(state, opened, out)
               : program_fail_library(state, svo_device_message(opened->device));
}

int tree_form_make(program *state, const session *opened, const svo_tree *tree, svo_compact **out)
{
    progress_step(state->progress, "making the compact tree");
    return make(state, opened, tree, out);
}

int tree_form_change(program *state, const session *opened, svo_compact **compact)
{
    svo_tree *tree = NULL;
    progress_step(state->progress, "making the compact tree");
    if (tree_form_keeps(state, *compact)) {
        return tree_form_pack(state, opened, compact);
    }
    if (svo_compact_expand(*compact, opened->queue, &tree) != SVO_OK) {
        return program_fail_library(state, svo_device_message(opened->device));
    }
    svo_compact_destroy(compact);
    const int exit_code = make(state, opened, tree, compact);
    svo_tree_destroy(&tree);
    return exit_code;
}

/* ---- in place of the tree ---- */

static int download(program *state, const session *opened, svo_compact *compact)
{
    return svo_compact_download(compact, opened->queue) == SVO_OK
               ? PROGRAM_DONE
               : program_fail_library(state, svo_device_message(opened->device));
}

static int load(program *state, job *done, svo_compact **out)
{
    session *opened = &done->opened;
    progress_step(state->progress, "reading the tree");
    int exit_code = input_load_compact(state, out);
    if (exit_code == PROGRAM_DONE) {
        exit_code = session_open_device(state, opened);
    }
    if (exit_code == PROGRAM_DONE && svo_compact_upload(*out, opened->device, opened->queue) != SVO_OK) {
        exit_code = program_fail_library(state, svo_device_message(opened->device));
    }
    if (exit_code == PROGRAM_DONE && state->options.tree_form != 0) {
        exit_code = tree_form_change(state, opened, out);
    }
    return exit_code == PROGRAM_DONE ? download(state, opened, *out) : exit_code;
}

int tree_form_load(program *state, unsigned further_steps, job *done, svo_compact **out)
{
    *done = (job){0};
    *out = NULL;
    int exit_code = input_refuse_build_options(state);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    program_begin_progress(state, 1 + further_steps);
    exit_code = load(state, done, out);
    if (exit_code != PROGRAM_DONE) {
        svo_compact_destroy(out);
        job_release(done);
    }
    return exit_code;
}

int tree_form_take(program *state, job *done, svo_compact **out)
{
    *out = NULL;
    if (state->options.tree_form == 0) {
        return PROGRAM_DONE;
    }
    int exit_code = tree_form_make(state, &done->opened, done->result.tree, out);
    svo_tree_destroy(&done->result.tree);
    return exit_code == PROGRAM_DONE ? download(state, &done->opened, *out) : exit_code;
}

/* ---- what it is ---- */

/* A kind of payload: its array's name, and its bit. */
typedef struct payload_kind {
    const char *name;
    uint32_t need;
} payload_kind;

static const payload_kind *payload_of(int k)
{
    static const payload_kind kinds[SVO_PAYLOAD_COUNT] = {{"colors", SVO_NEED_COLOR},
                                                          {"normals", SVO_NEED_NORMAL},
                                                          {"materials", SVO_NEED_MATERIAL},
                                                          {"fills", SVO_NEED_FILL}};
    return &kinds[k];
}

static bool is_packed(const svo_compact_info *info, int k)
{
    return (info->packed & payload_of(k)->need) != 0;
}

static double bits_per_leaf(const svo_compact_info *info, uint64_t bytes)
{
    return info->leaf_count > 0 ? 8.0 * (double)bytes / (double)info->leaf_count : 0.0;
}

void tree_form_add_rows(struct table *rows, const svo_compact *compact)
{
    svo_compact_info info = SVO_COMPACT_INFO_INIT;
    (void)svo_compact_get_info(compact, &info);
    table_cell(rows, "form");
    table_cell(rows, "%s%s", svo_name(SVO_NAME_FORM, info.form), info.minimized != 0 ? ", leaves on any level" : "");
    table_cell(rows, "compact");
    table_cell(rows, "%s leaves, %s inner nodes, %s", figure_count(info.leaf_count).text,
               figure_count(info.inner_count).text, figure_bytes(info.total_bytes).text);
    for (int k = 0; k < SVO_PAYLOAD_COUNT; ++k) {
        const uint64_t bytes = info.bytes[SVO_COMPACT_COLORS + k];
        if (is_packed(&info, k)) {
            table_cell(rows, "packed %s", payload_of(k)->name);
            table_cell(rows, "%s, %.3g bit per leaf, error at most %u, %.3g in the mean", figure_bytes(bytes).text,
                       bits_per_leaf(&info, bytes), info.largest_error[k], info.mean_error[k]);
        }
    }
}

static void add_packed_json(cJSON *compact, const svo_compact_info *info, int k)
{
    const uint64_t bytes = info->bytes[SVO_COMPACT_COLORS + k];
    cJSON *object = cJSON_AddObjectToObject(compact, payload_of(k)->name);
    json_add_count(object, "bytes", bytes);
    cJSON_AddNumberToObject(object, "bits_per_leaf", bits_per_leaf(info, bytes));
    json_add_count(object, "largest_error", info->largest_error[k]);
    cJSON_AddNumberToObject(object, "mean_error", info->mean_error[k]);
}

void tree_form_add_json(cJSON *document, const svo_compact *compact)
{
    char hash[SVO_HASH_TEXT_BYTES];
    svo_compact_info info = SVO_COMPACT_INFO_INIT;
    cJSON *object = cJSON_AddObjectToObject(document, "compact");
    (void)svo_compact_get_info(compact, &info);
    json_add_text(object, "form", svo_name(SVO_NAME_FORM, info.form));
    cJSON_AddBoolToObject(object, "minimized", info.minimized != 0);
    json_add_count(object, "directory_step", info.form == SVO_FORM_IMPLIED ? 1u << info.directory_step_log2 : 0);
    json_add_count(object, "voxels", info.voxel_count);
    json_add_count(object, "leaves", info.leaf_count);
    json_add_count(object, "inner_nodes", info.inner_count);
    json_add_count(object, "stored", info.stored_count);
    json_add_count(object, "payload", info.payload_count);
    json_add_count(object, "bytes", info.total_bytes);
    for (int k = 0; k < SVO_PAYLOAD_COUNT; ++k) {
        if (is_packed(&info, k)) {
            add_packed_json(object, &info, k);
        }
    }
    if (svo_compact_hash(compact, hash) == SVO_OK) {
        json_add_text(object, "hash", hash);
    }
}
