/* SPDX-License-Identifier: MIT */
/* Makes compact forms of a tree, expands them, and compares. */
#include "support/form_check.h"

#include <string.h>

#include "support/table.h"

/* Whether two arrays are equal; both are NULL where the trees hold none. */
static bool same(const void *a, const void *b, uint64_t bytes)
{
    return a == NULL || b == NULL ? a == b : memcmp(a, b, (size_t)bytes) == 0;
}

static bool same_payload(const svo_tree *a, const svo_tree *b)
{
    svo_tree_info info = SVO_TREE_INFO_INIT;
    svo_tree_arrays of_a = SVO_TREE_ARRAYS_INIT;
    svo_tree_arrays of_b = SVO_TREE_ARRAYS_INIT;
    svo_tree_get_info(a, &info);
    svo_tree_get_arrays(a, &of_a);
    svo_tree_get_arrays(b, &of_b);
    const uint64_t count = info.node_count - info.level_begin[info.payload_level];
    return same(of_a.colors, of_b.colors, count * 4) && same(of_a.normals, of_b.normals, count * 6) &&
           same(of_a.materials, of_b.materials, count * 2) && same(of_a.fills, of_b.fills, count * 2);
}

/* Compares what the compact tree expands to. */
static svo_status expand(const session *opened, svo_compact *compact, const svo_tree *tree, form_check *check)
{
    char expected[SVO_HASH_TEXT_BYTES];
    svo_tree *expanded = NULL;
    svo_status status = svo_compact_expand(compact, opened->queue, &expanded);
    if (status != SVO_OK) {
        return status;
    }
    status = svo_tree_download(expanded, opened->queue);
    if (status != SVO_OK) {
        goto cleanup;
    }
    status = svo_tree_hash(expanded, SVO_HASH_NODES, check->hash);
    if (status != SVO_OK) {
        goto cleanup;
    }
    status = svo_tree_hash(tree, SVO_HASH_NODES, expected);
    if (status == SVO_OK) {
        check->same_nodes = strcmp(expected, check->hash) == 0;
        check->same_payload = check->same_nodes && same_payload(tree, expanded);
    }

cleanup:
    svo_tree_destroy(&expanded);
    return status;
}

static svo_status check_form(const session *opened, const svo_tree *tree, svo_form form, form_check *check)
{
    svo_compact_options asked = SVO_COMPACT_OPTIONS_INIT;
    svo_compact *compact = NULL;
    asked.form = form;
    check->info = (svo_compact_info)SVO_COMPACT_INFO_INIT;
    svo_status status = svo_compact_create(opened->device, tree, &asked, opened->queue, &compact);
    if (status != SVO_OK) {
        return status;
    }
    status = svo_compact_get_info(compact, &check->info);
    if (status == SVO_OK) {
        status = expand(opened, compact, tree, check);
    }
    svo_compact_destroy(&compact);
    return status;
}

int form_check_run(program *state, const session *opened, const svo_tree *tree, form_checks *out)
{
    const int wanted = state->options.form;
    *out = (form_checks){.count = 0};
    for (int form = 0; form < SVO_FORM_COUNT; ++form) {
        if (wanted == OPTION_FORM_ALL || wanted == 1 + form) {
            if (check_form(opened, tree, (svo_form)form, &out->forms[out->count]) != SVO_OK) {
                return program_fail_library(state, svo_device_message(opened->device));
            }
            ++out->count;
        }
    }
    return PROGRAM_DONE;
}

bool form_check_is_exact(const form_checks *checks)
{
    bool exact = true;
    for (size_t i = 0; i < checks->count; ++i) {
        exact = exact && checks->forms[i].same_nodes && checks->forms[i].same_payload;
    }
    return exact;
}

void form_check_print(const form_checks *checks)
{
    if (checks->count == 0) {
        return;
    }
    table *rows = table_create("lrll");
    table_cell(rows, "form");
    table_cell(rows, "bytes");
    table_cell(rows, "expands to");
    table_cell(rows, "%s", "");
    for (size_t i = 0; i < checks->count; ++i) {
        const form_check *check = &checks->forms[i];
        table_cell(rows, "%s", svo_form_name(check->info.form));
        table_cell(rows, "%s", figure_count(check->info.total_bytes).text);
        table_cell(rows, "%s", check->hash);
        table_cell(rows, "%s",
                   !check->same_nodes     ? "other nodes"
                   : !check->same_payload ? "other payload"
                                          : "the same tree");
    }
    table_print(rows);
}

void form_check_add_json(cJSON *document, const form_checks *checks)
{
    cJSON *forms = checks->count > 0 ? cJSON_AddArrayToObject(document, "forms") : NULL;
    for (size_t i = 0; i < checks->count; ++i) {
        const form_check *check = &checks->forms[i];
        cJSON *one = cJSON_CreateObject();
        json_add_text(one, "form", svo_form_name(check->info.form));
        json_add_count(one, "bytes", check->info.total_bytes);
        json_add_text(one, "hash", check->hash);
        cJSON_AddBoolToObject(one, "same_nodes", check->same_nodes);
        cJSON_AddBoolToObject(one, "same_payload", check->same_payload);
        cJSON_AddItemToArray(forms, one);
    }
}
