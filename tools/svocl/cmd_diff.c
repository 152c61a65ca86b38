/* SPDX-License-Identifier: MIT */
/* svocl diff: where two trees differ, for people, as JSON and as a picture. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/job.h"
#include "support/options_parse.h"
#include "support/output.h"
#include "support/picture.h"
#include "support/table.h"
#include "support/viewpoint.h"
#include "svocl/commands.h"
#include "svocl/tree_diff.h"
#include "svocl/voxels.h"

#define VALUES_SHOWN 8u /* of a list; other fields have fewer */

/* A and B: trees that were read, or built. */
typedef struct comparison {
    const char *names[2];
    svo_tree *read[2]; /* of .svo and .svc files, else NULL */
    job built[2]; /* of the others */
    bool is_built[2];
    diff_side sides[2];
    tree_diff found;
} comparison;

/* ---- the inputs ---- */

static bool is_tree(program *state, const char *name)
{
    state->options.input = name;
    return input_is_tree(state);
}

/* Names both inputs; one of them may come through a pipe. */
static int name_inputs(program *state, comparison *work)
{
    options *given = &state->options;
    work->names[0] = given->input;
    work->names[1] = given->second_input;
    if (work->names[1] == NULL) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "B is missing, see svocl diff --help");
    }
    if (piped_is_stream(work->names[1])) {
        if (state->piped.name != NULL) {
            return program_fail(state, PROGRAM_WRONG_USAGE, "A and B both come through pipes, one must be a file");
        }
        given->input = work->names[1];
        const int exit_code = input_begin(state);
        work->names[1] = given->input;
        return exit_code;
    }
    return PROGRAM_DONE;
}

static int check_options(program *state, const comparison *work)
{
    static const char *const of_pictures[] = {"size", NULL};
    const bool has_picture = state->options.output_path != NULL;
    if (!has_picture && options_refuse(state, of_pictures, "without --picture") != PROGRAM_DONE) {
        return PROGRAM_WRONG_USAGE;
    }
    if (!is_tree(state, work->names[1]) || !is_tree(state, work->names[0])) {
        return has_picture ? output_check(state, state->options.output_path) : PROGRAM_DONE;
    }
    const int exit_code = has_picture ? input_refuse_build_options(state) : input_refuse_device_options(state);
    return exit_code == PROGRAM_DONE && has_picture ? output_check(state, state->options.output_path) : exit_code;
}

static int open_side(program *state, comparison *work, unsigned which)
{
    int exit_code = PROGRAM_DONE;
    diff_side *side = &work->sides[which];
    work->is_built[which] = !is_tree(state, work->names[which]);
    if (work->is_built[which]) {
        const double voxel_size = state->options.voxel_size;
        exit_code = job_run(state, state->options.need, 1, &work->built[which]);
        if (voxel_size > 0.0) { /* of each mesh */
            state->options.voxel_size = voxel_size;
            state->options.edge = 0.0;
        }
        work->is_built[which] = exit_code == PROGRAM_DONE;
    } else {
        program_begin_progress(state, 2);
        exit_code = input_load_tree(state, &work->read[which]);
    }
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    const svo_tree *tree = work->is_built[which] ? work->built[which].result.tree : work->read[which];
    side->info = (svo_tree_info)SVO_TREE_INFO_INIT;
    side->arrays = (svo_tree_arrays)SVO_TREE_ARRAYS_INIT;
    progress_step(state->progress, "hashing");
    return svo_tree_get_info(tree, &side->info) == SVO_OK && svo_tree_get_arrays(tree, &side->arrays) == SVO_OK &&
                   svo_tree_hash(tree, SVO_HASH_ALL, side->hash) == SVO_OK
               ? PROGRAM_DONE
               : program_fail(state, PROGRAM_FAILED, "%s: the tree has no host arrays to hash", work->names[which]);
}

/* ---- the picture ---- */

typedef struct voxel_list {
    svo_voxel *voxels;
    uint64_t count, capacity;
    bool is_short; /* of memory */
} voxel_list;

static void add_voxel(void *user, const uint32_t cell[3], diff_kind kind)
{
    static const uint8_t colors[][4] = {[DIFF_SAME] = {150, 150, 150, 255},
                                        [DIFF_ONLY_A] = {230, 90, 0, 255},
                                        [DIFF_ONLY_B] = {20, 110, 230, 255},
                                        [DIFF_CHANGED] = {240, 210, 30, 255}};
    voxel_list *list = user;
    if (list->count == list->capacity && !list->is_short) {
        const uint64_t capacity = 2 * list->capacity + 1024;
        svo_voxel *larger =
            capacity <= SIZE_MAX / sizeof *larger ? realloc(list->voxels, (size_t)capacity * sizeof *larger) : NULL;
        list->is_short = larger == NULL;
        list->voxels = larger != NULL ? larger : list->voxels;
        list->capacity = larger != NULL ? capacity : list->capacity;
    }
    if (!list->is_short) {
        svo_voxel *voxel = &list->voxels[list->count++];
        *voxel = (svo_voxel){.x = (int32_t)cell[0], .y = (int32_t)cell[1], .z = (int32_t)cell[2]};
        for (unsigned channel = 0; channel < 4; ++channel) {
            voxel->rgba[channel] = colors[kind][channel];
        }
    }
}

static int draw_tree(program *state, const session *opened, svo_tree *tree)
{
    const options *given = &state->options;
    const viewpoint_subject shown = {.target = svo_tree_target(tree), .aspect = viewpoint_aspect(state)};
    svo_render_options asked = {.struct_size = sizeof asked, .width = given->width, .height = given->height};
    int exit_code = viewpoint_place(state, &shown, &asked.camera);
    uint8_t *pixels = malloc((size_t)given->width * given->height * 4);
    if (exit_code == PROGRAM_DONE && pixels == NULL) {
        exit_code = program_fail(state, PROGRAM_FAILED, "out of memory for the picture");
    }
    if (exit_code == PROGRAM_DONE &&
        svo_render(shown.target, &asked, svo_in_host(pixels), &(svo_submit){.queue = opened->queue}) != SVO_OK) {
        exit_code = program_fail_library(state, svo_device_message(opened->device));
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = picture_write_as(state, given->output_path, given->width, given->height, pixels);
    }
    free(pixels);
    return exit_code;
}

/* Builds the tree of the list, whose colors say what differs. */
static int build_and_draw(program *state, const svo_voxels *voxels)
{
    session opened;
    svo_tree *tree = NULL;
    int exit_code = session_open_device(state, &opened);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    const svo_plan_options plan_options = {
        .struct_size = sizeof plan_options, .need = SVO_NEED_COLOR, .builder = SVO_BUILDER_SORTED};
    if (svo_voxels_build(opened.device, voxels, 0, &plan_options, opened.queue, &tree, NULL) != SVO_OK ||
        svo_tree_download(tree, opened.queue) != SVO_OK) {
        exit_code = program_fail_library(state, svo_device_message(opened.device));
    } else {
        exit_code = draw_tree(state, &opened, tree);
    }
    svo_tree_destroy(&tree);
    session_close(&opened);
    return exit_code;
}

static int draw_list(program *state, const comparison *work, const voxel_list *list)
{
    const svo_tree_info *info = &work->sides[0].info;
    svo_voxels_source source = {.struct_size = sizeof source, .voxels = list->voxels, .voxel_count = list->count};
    svo_voxels *voxels = NULL;
    svo_message message = {""};
    if (list->is_short) {
        return program_fail(state, PROGRAM_FAILED, "out of memory for the voxels of --picture");
    }
    if (list->count == 0) {
        return program_fail(state, PROGRAM_FAILED, "--picture: neither tree has voxels");
    }
    source.voxel_edge = info->edge / (double)(1u << work->found.level);
    for (unsigned axis = 0; axis < 3; ++axis) {
        source.origin[axis] = info->origin[axis];
    }
    program_begin_step(state, "drawing the difference");
    if (svo_voxels_create(&source, &voxels, &message) != SVO_OK) {
        return program_fail_library(state, message.text);
    }
    const int exit_code = build_and_draw(state, voxels);
    svo_voxels_destroy(&voxels);
    return exit_code;
}

/* ---- the report ---- */

static bool is_other(const comparison *work, diff_option option)
{
    return (work->found.options >> option & 1u) != 0;
}

static bool holds_differ(const comparison *work)
{
    bool differ = false;
    for (diff_field field = 0; field < DIFF_FIELD_COUNT; ++field) {
        const diff_counts *counts = &work->found.fields[field];
        differ = differ || counts->is_held[0] != counts->is_held[1];
    }
    return differ;
}

static void write_holds(const comparison *work, unsigned which, char *text, size_t text_bytes)
{
    size_t used = (size_t)snprintf(text, text_bytes, "nodes");
    for (diff_field field = 0; field < DIFF_FIELD_COUNT; ++field) {
        if (work->found.fields[field].is_held[which] && used < text_bytes) {
            used += (size_t)snprintf(text + used, text_bytes - used, ", %s", diff_field_name(field));
        }
    }
}

/* A value of each side, in the words of `svocl info`. */
static void write_option(const diff_side *side, diff_option option, char *text, size_t text_bytes)
{
    const svo_tree_info *info = &side->info;
    switch (option) {
    case DIFF_DEPTH:
        (void)snprintf(text, text_bytes, "%u", info->depth);
        break;
    case DIFF_COVERAGE:
        (void)snprintf(text, text_bytes, "%s", svo_name(SVO_NAME_COVERAGE, (svo_coverage)info->coverage));
        break;
    case DIFF_VOXELS_OF:
        (void)snprintf(text, text_bytes, "%s", info->is_exact != 0 ? "the input" : "the rounded mesh");
        break;
    case DIFF_ORIGIN:
        (void)snprintf(text, text_bytes, "%.17g, %.17g, %.17g", info->origin[0], info->origin[1], info->origin[2]);
        break;
    case DIFF_EDGE:
        (void)snprintf(text, text_bytes, "%.17g", info->edge);
        break;
    default:
        (void)snprintf(text, text_bytes, "%u", info->payload_level);
        break;
    }
}

static void print_options(const comparison *work)
{
    table *rows = table_create("lll");
    table_cell(rows, "%s", "");
    table_cell(rows, "A");
    table_cell(rows, "B");
    table_cell(rows, "hash");
    table_cell(rows, "%s", work->sides[0].hash);
    table_cell(rows, "%s", work->sides[1].hash);
    char text[128];
    for (diff_option option = 0; option < DIFF_OPTION_COUNT; ++option) {
        if (is_other(work, option)) {
            table_cell(rows, "%s", diff_option_name(option));
            for (unsigned which = 0; which < 2; ++which) {
                write_option(&work->sides[which], option, text, sizeof text);
                table_cell(rows, "%s", text);
            }
        }
    }
    if (holds_differ(work)) {
        table_cell(rows, "holds");
        for (unsigned which = 0; which < 2; ++which) {
            write_holds(work, which, text, sizeof text);
            table_cell(rows, "%s", text);
        }
    }
    table_print(rows);
}

/* Nodes of a level; those of the last one are the leaves. */
static uint64_t nodes_at(const svo_tree_info *info, uint32_t level)
{
    return level <= info->depth ? info->level_begin[level + 1] - info->level_begin[level] : 0;
}

static void print_levels(const comparison *work)
{
    const svo_tree_info *a = &work->sides[0].info, *b = &work->sides[1].info;
    table_gap();
    table_heading("nodes");
    table *rows = table_create("rrr");
    table_cell(rows, "level");
    table_cell(rows, "A");
    table_cell(rows, "B");
    for (uint32_t level = 0; level <= a->depth || level <= b->depth; ++level) {
        table_cell(rows, "%u", level);
        table_cell(rows, "%s", figure_count(nodes_at(a, level)).text);
        table_cell(rows, "%s", figure_count(nodes_at(b, level)).text);
    }
    table_cell(rows, "leaves");
    table_cell(rows, "%s", figure_count(a->leaf_count).text);
    table_cell(rows, "%s", figure_count(b->leaf_count).text);
    table_print(rows);
}

static void print_voxels(const comparison *work)
{
    const tree_diff *found = &work->found;
    table_gap();
    table_heading("voxels of level %u", found->level);
    table *rows = table_create("ll");
    table_cell(rows, "only in A");
    table_cell(rows, "%s", figure_count(found->only[0]).text);
    table_cell(rows, "only in B");
    table_cell(rows, "%s", figure_count(found->only[1]).text);
    table_cell(rows, "in both");
    table_cell(rows, "%s, %s of them with other payload", figure_count(found->both).text,
               figure_count(found->changed).text);
    for (diff_field field = 0; field < DIFF_FIELD_COUNT; ++field) {
        const diff_counts *counts = &found->fields[field];
        if (counts->voxels + counts->nodes > 0) {
            char by[64];
            (void)snprintf(by, sizeof by, ", %s at most %u", field == DIFF_LIST ? "in length by" : "by",
                           counts->largest);
            table_cell(rows, "%s", diff_field_name(field));
            table_cell(rows, "%s voxels and %s nodes above differ%s", figure_count(counts->voxels).text,
                       figure_count(counts->nodes).text, diff_field_is_label(field) ? "" : by);
        }
    }
    table_print(rows);
}

static void find_center(const comparison *work, const diff_place *at, double center[3])
{
    const svo_tree_info *info = &work->sides[at->node[0] == SVO_NO_NODE ? 1 : 0].info;
    for (unsigned axis = 0; axis < 3; ++axis) {
        center[axis] = info->origin[axis] + (at->cell[axis] + 0.5) * (info->edge / (double)(1u << at->level));
    }
}

/* The values of a field at the first place: "255, 0, 0, 255", a long list cut; "-": that side has none. */
static void write_values(const comparison *work, diff_field field, unsigned which, char *text, size_t text_bytes)
{
    const diff_place *at = &work->found.first;
    int64_t values[VALUES_SHOWN];
    const uint32_t count = diff_values(&work->sides[which], field, at->level, at->node[which], VALUES_SHOWN, values);
    size_t used = (size_t)snprintf(text, text_bytes, "%s", count == 0 ? "-" : "");
    for (uint32_t i = 0; i < count && i < VALUES_SHOWN && used < text_bytes; ++i) {
        used += (size_t)snprintf(text + used, text_bytes - used, "%s%" PRId64, i == 0 ? "" : ", ", values[i]);
    }
    if (count > VALUES_SHOWN && used < text_bytes) {
        (void)snprintf(text + used, text_bytes - used, ", ... (%u)", count);
    }
}

static void print_first(const comparison *work)
{
    const diff_place *at = &work->found.first;
    double center[3];
    find_center(work, at, center);
    table_gap();
    table_heading("first difference: %s %u, %u, %u of level %u",
                  at->level == work->found.level ? "voxel" : "node above the voxels", at->cell[0], at->cell[1],
                  at->cell[2], at->level);
    table *rows = table_create("lll");
    table_cell(rows, "center");
    table_cell(rows, "%.9g, %.9g, %.9g", center[0], center[1], center[2]);
    table_cell(rows, "%s", "");
    table_cell(rows, "%s", "");
    table_cell(rows, at->node[0] != SVO_NO_NODE ? "A" : "not in A");
    table_cell(rows, at->node[1] != SVO_NO_NODE ? "B" : "not in B");
    for (diff_field field = 0; field < DIFF_FIELD_COUNT; ++field) {
        char texts[2][128];
        for (unsigned which = 0; which < 2; ++which) {
            write_values(work, field, which, texts[which], sizeof texts[which]);
        }
        if (strcmp(texts[0], "-") != 0 || strcmp(texts[1], "-") != 0) {
            table_cell(rows, "%s", diff_field_name(field));
            table_cell(rows, "%s", texts[0]);
            table_cell(rows, "%s", texts[1]);
        }
    }
    table_print(rows);
}

static void print_report(const comparison *work)
{
    if (work->found.is_equal) {
        table_heading("A %s and B %s are equal: %s", work->names[0], work->names[1], work->sides[0].hash);
        return;
    }
    table_heading("A %s and B %s differ", work->names[0], work->names[1]);
    print_options(work);
    print_levels(work);
    print_voxels(work);
    if (work->found.has_first) {
        print_first(work);
    }
}

/* ---- the same as JSON ---- */

static void add_side(cJSON *document, const comparison *work, unsigned which)
{
    const diff_side *side = &work->sides[which];
    const svo_tree_info *info = &side->info;
    cJSON *object = cJSON_AddObjectToObject(document, which == 0 ? "a" : "b");
    json_add_text(object, "input", work->names[which]);
    json_add_text(object, "hash", side->hash);
    json_add_count(object, "depth", info->depth);
    json_add_text(object, "coverage", svo_name(SVO_NAME_COVERAGE, (svo_coverage)info->coverage));
    json_add_text(object, "voxels_of", info->is_exact != 0 ? "the input" : "the rounded mesh");
    json_add_vector(object, "origin", info->origin);
    cJSON_AddNumberToObject(object, "edge", info->edge);
    json_add_count(object, "payload_level", info->payload_level);
    json_add_count(object, "nodes", info->node_count);
    json_add_count(object, "leaves", info->leaf_count);
    cJSON *levels = cJSON_AddArrayToObject(object, "levels");
    for (uint32_t level = 0; level <= info->depth; ++level) {
        cJSON_AddItemToArray(levels, cJSON_CreateNumber((double)nodes_at(info, level)));
    }
}

static void add_fields(cJSON *document, const comparison *work)
{
    cJSON *payload = cJSON_AddArrayToObject(document, "payload");
    for (diff_field field = 0; field < DIFF_FIELD_COUNT; ++field) {
        const diff_counts *counts = &work->found.fields[field];
        if (counts->is_held[0] || counts->is_held[1]) {
            cJSON *entry = cJSON_CreateObject();
            json_add_text(entry, "field", diff_field_name(field));
            cJSON_AddBoolToObject(entry, "in_a", counts->is_held[0]);
            cJSON_AddBoolToObject(entry, "in_b", counts->is_held[1]);
            json_add_count(entry, "voxels", counts->voxels);
            json_add_count(entry, "nodes", counts->nodes);
            if (!diff_field_is_label(field)) {
                json_add_count(entry, "largest", counts->largest);
            }
            cJSON_AddItemToArray(payload, entry);
        }
    }
}

/* null where the node is not in that tree; else the values of each field, of a long list the first. */
static void add_values(cJSON *object, const comparison *work, unsigned which)
{
    const diff_place *at = &work->found.first;
    if (at->node[which] == SVO_NO_NODE) {
        cJSON_AddNullToObject(object, which == 0 ? "a" : "b");
        return;
    }
    cJSON *node = cJSON_AddObjectToObject(object, which == 0 ? "a" : "b");
    for (diff_field field = 0; field < DIFF_FIELD_COUNT; ++field) {
        int64_t values[VALUES_SHOWN];
        const uint32_t count =
            diff_values(&work->sides[which], field, at->level, at->node[which], VALUES_SHOWN, values);
        cJSON *array = count > 0 ? cJSON_AddArrayToObject(node, diff_field_name(field)) : NULL;
        for (uint32_t i = 0; i < count && i < VALUES_SHOWN; ++i) {
            cJSON_AddItemToArray(array, cJSON_CreateNumber((double)values[i]));
        }
    }
}

static void add_first(cJSON *document, const comparison *work)
{
    const diff_place *at = &work->found.first;
    if (!work->found.has_first) {
        cJSON_AddNullToObject(document, "first");
        return;
    }
    double center[3];
    find_center(work, at, center);
    cJSON *first = cJSON_AddObjectToObject(document, "first");
    json_add_count(first, "level", at->level);
    cJSON *cell = cJSON_AddArrayToObject(first, "cell");
    for (unsigned axis = 0; axis < 3; ++axis) {
        cJSON_AddItemToArray(cell, cJSON_CreateNumber(at->cell[axis]));
    }
    json_add_vector(first, "center", center);
    add_values(first, work, 0);
    add_values(first, work, 1);
}

static int print_json(program *state, const comparison *work)
{
    const tree_diff *found = &work->found;
    cJSON *document = json_document();
    cJSON_AddBoolToObject(document, "equal", found->is_equal);
    add_side(document, work, 0);
    add_side(document, work, 1);
    cJSON *others = cJSON_AddArrayToObject(document, "options");
    for (diff_option option = 0; option < DIFF_OPTION_COUNT; ++option) {
        if (is_other(work, option)) {
            cJSON_AddItemToArray(others, json_text(diff_option_name(option)));
        }
    }
    json_add_count(document, "level", found->level);
    cJSON *voxels = cJSON_AddObjectToObject(document, "voxels");
    json_add_count(voxels, "only_a", found->only[0]);
    json_add_count(voxels, "only_b", found->only[1]);
    json_add_count(voxels, "both", found->both);
    json_add_count(voxels, "changed", found->changed);
    add_fields(document, work);
    add_first(document, work);
    if (state->options.output_path != NULL) {
        json_add_text(document, "picture", state->options.output_path);
    }
    return json_print(state, document);
}

/* ---- the command ---- */

static int compare(program *state, comparison *work)
{
    voxel_list list = {NULL, 0, 0, false};
    const bool has_picture = state->options.output_path != NULL;
    work->found = tree_diff_find(work->sides, has_picture ? add_voxel : NULL, &list);
    int exit_code = has_picture ? draw_list(state, work, &list) : PROGRAM_DONE;
    free(list.voxels);
    progress_destroy(&state->progress);
    if (exit_code == PROGRAM_DONE && state->options.json) {
        exit_code = print_json(state, work);
    } else if (exit_code == PROGRAM_DONE && !state->options.quiet) {
        print_report(work);
    }
    return exit_code == PROGRAM_DONE && !work->found.is_equal ? PROGRAM_DIFFERENT : exit_code;
}

int command_diff(program *state)
{
    comparison work = {.names = {NULL, NULL}};
    int exit_code = name_inputs(state, &work);
    if (exit_code == PROGRAM_DONE) {
        exit_code = check_options(state, &work);
    }
    for (unsigned which = 0; which < 2 && exit_code == PROGRAM_DONE; ++which) {
        exit_code = open_side(state, &work, which);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = compare(state, &work);
    }
    for (unsigned which = 0; which < 2; ++which) {
        svo_tree_destroy(&work.read[which]);
        if (work.is_built[which]) {
            job_release(&work.built[which]);
        }
    }
    return exit_code;
}
