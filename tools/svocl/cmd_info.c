/* SPDX-License-Identifier: MIT */
/* svocl info: prints what a .svo or .svc file, a folder of parts, or a point cloud, contains. Loading checks every
   length, checksum and index; the hash of a folder every checksum. */
#include <inttypes.h>
#include <string.h>

#include "support/input.h"
#include "support/json.h"
#include "support/parts_input.h"
#include "support/table.h"
#include "support/tree_form.h"
#include "svocl/commands.h"

typedef struct file_facts {
    svo_compact *compact; /* of a .svc file, whose expanded tree the rest describes */
    svo_tree_info info;
    uint64_t node_count, leaf_count, list_count; /* which info has too, unless there are more than it can have */
    uint64_t level_nodes[SVO_PARTS_LEVELS_MAX];
    uint64_t part_count; /* of a folder of parts; 0: another tree */
    uint64_t file_bytes;
    char hash[SVO_HASH_TEXT_BYTES];
    char nodes_hash[SVO_HASH_TEXT_BYTES];
} file_facts;

/* Which mesh rays meet; NULL where they meet no triangles. */
static const char *mesh_of_rays(const svo_tree_info *info)
{
    if ((info->need & SVO_NEED_RAYS) == 0 || info->coverage == SVO_COVERAGE_THIN) {
        return NULL;
    }
    return info->positions == SVO_POSITIONS_ROUNDED ? "the rounded mesh"
           : info->positions == SVO_POSITIONS_FLOAT ? "the input, in floats"
                                                    : "the input, in doubles";
}

/* Which mesh, or list of voxels, the tree's voxels are of. */
static const char *source_of_voxels(const svo_tree_info *info)
{
    return info->is_exact != 0 ? "the input" : "the rounded mesh";
}

static cJSON *to_json(const program *state, const file_facts *facts)
{
    const svo_tree_info *info = &facts->info;
    cJSON *document = json_document();
    json_add_text(document, "file", state->options.input);
    json_add_count(document, "file_bytes", facts->file_bytes);
    cJSON_AddBoolToObject(document, "checksum_ok", 1);
    json_add_count(document, "depth", info->depth);
    json_add_count(document, "snap_bits", info->snap_bits);
    json_add_text(document, "coverage", svo_name(SVO_NAME_COVERAGE, (svo_coverage)info->coverage));
    json_add_needs(document, "need", info->need);
    json_add_needs(document, "constant", info->constant);
    json_add_text(document, "voxels_of", source_of_voxels(info));
    json_add_text(document, "rays_meet", mesh_of_rays(info));
    json_add_text(document, "weights", svo_name(SVO_NAME_WEIGHTS, (svo_weights)info->weights));
    json_add_vector(document, "origin", info->origin);
    cJSON_AddNumberToObject(document, "edge", info->edge);
    cJSON_AddNumberToObject(document, "scale", info->scale);
    json_add_count(document, "triangles", info->triangles);
    json_add_count(document, "refused_triangles", info->refused_triangles);
    json_add_count(document, "fragments", info->fragments);
    json_add_count(document, "nodes", facts->node_count);
    json_add_count(document, "leaves", facts->leaf_count);
    json_add_count(document, "list_entries", facts->list_count);
    if (facts->part_count > 0) {
        json_add_count(document, "parts", facts->part_count);
    }
    cJSON *levels = cJSON_AddArrayToObject(document, "levels");
    for (uint32_t level = 0; level <= info->depth; ++level) {
        cJSON_AddItemToArray(levels, cJSON_CreateNumber((double)facts->level_nodes[level]));
    }
    json_add_text(document, "hash", facts->hash);
    json_add_text(document, "nodes_hash", facts->nodes_hash);
    if (facts->compact != NULL) {
        tree_form_add_json(document, facts->compact);
    }
    return document;
}

static void print_header(const program *state, const file_facts *facts)
{
    const svo_tree_info *info = &facts->info;
    table_heading("%s", state->options.input);
    table *rows = table_create("ll");
    table_cell(rows, "file");
    table_cell(rows, "%s, checksums good", figure_bytes(facts->file_bytes).text);
    if (facts->part_count > 0) {
        table_cell(rows, "parts");
        table_cell(rows, "%s", figure_count(facts->part_count).text);
    }
    if (facts->compact != NULL) {
        tree_form_add_rows(rows, facts->compact);
    }
    table_cell(rows, "grid");
    table_cell(rows, "depth %u, %lu voxels per axis, %s", info->depth, 1UL << info->depth,
               svo_name(SVO_NAME_COVERAGE, (svo_coverage)info->coverage));
    table_cell(rows, "origin");
    table_cell(rows, "%.9g, %.9g, %.9g", info->origin[0], info->origin[1], info->origin[2]);
    table_cell(rows, "edge");
    table_cell(rows, "%.9g, 2^%u grid units", info->edge, info->snap_bits);
    table_cell(rows, "holds");
    table_cell(rows, "nodes%s%s%s%s%s%s", (info->need & SVO_NEED_COLOR) != 0 ? ", colors" : "",
               (info->need & SVO_NEED_NORMAL) != 0 ? ", normals" : "",
               (info->need & SVO_NEED_MATERIAL) != 0 ? ", materials" : "",
               (info->need & SVO_NEED_FILL) != 0 ? ", fills" : "",
               (info->need & SVO_NEED_PROJECTED_AREA) != 0 ? ", projected areas" : "",
               (info->need & SVO_NEED_RAYS) != 0 ? ", leaf lists and triangles" : "");
    table_cell(rows, "voxels of");
    table_cell(rows, "%s", source_of_voxels(info));
    if (mesh_of_rays(info) != NULL) {
        table_cell(rows, "rays meet");
        table_cell(rows, "%s", mesh_of_rays(info));
    }
    if (info->constant != 0) {
        table_cell(rows, "stored once");
        table_cell(rows, "%s: the same in every node", figure_needs(info->constant).text);
    }
    if ((info->need & ~(uint32_t)SVO_NEED_RAYS) != 0) {
        table_cell(rows, "weights");
        table_cell(rows, "%s", svo_name(SVO_NAME_WEIGHTS, (svo_weights)info->weights));
    }
    table_cell(rows, "triangles");
    table_cell(rows, "%s, %s refused", figure_count(info->triangles).text, figure_count(info->refused_triangles).text);
    table_cell(rows, "fragments");
    table_cell(rows, "%s", figure_count(info->fragments).text);
    table_cell(rows, "hash");
    table_cell(rows, "%s", facts->hash);
    table_print(rows);
}

static void print_levels(const file_facts *facts)
{
    table_gap();
    table_heading("levels");
    table *rows = table_create("rr");
    for (uint32_t level = 0; level <= facts->info.depth; ++level) {
        table_cell(rows, "%u", level);
        table_cell(rows, "%s", figure_count(facts->level_nodes[level]).text);
    }
    table_cell(rows, "all");
    table_cell(rows, "%s", figure_count(facts->node_count).text);
    table_print(rows);
}

/* Counts and hashes of a whole folder of parts, which no tree in memory may hold. */
static int read_parts(program *state, file_facts *facts)
{
    svo_parts_tree *tree = NULL;
    svo_parts_tree_info info = SVO_PARTS_TREE_INFO_INIT;
    svo_message message = {""};
    progress_step(state->progress, "reading the parts");
    const int exit_code = parts_input_open(state, &tree);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    svo_status status = svo_parts_tree_get_info(tree, &info, &message);
    if (status == SVO_OK) {
        status = svo_parts_tree_hash(tree, SVO_HASH_ALL, facts->hash, &message);
    }
    if (status == SVO_OK) {
        status = svo_parts_tree_hash(tree, SVO_HASH_NODES, facts->nodes_hash, &message);
    }
    svo_parts_tree_close(&tree);
    facts->info = info.tree;
    facts->node_count = info.node_count;
    facts->leaf_count = info.leaf_count;
    facts->list_count = info.list_count;
    facts->part_count = info.part_count;
    facts->file_bytes = info.file_bytes;
    memcpy(facts->level_nodes, info.level_nodes, sizeof facts->level_nodes);
    return status == SVO_OK ? PROGRAM_DONE : parts_input_fail(state, status, &message);
}

static void count_nodes(file_facts *facts)
{
    const svo_tree_info *info = &facts->info;
    facts->node_count = info->node_count;
    facts->leaf_count = info->leaf_count;
    facts->list_count = info->list_count;
    for (uint32_t level = 0; level <= info->depth; ++level) {
        facts->level_nodes[level] = info->level_begin[level + 1] - info->level_begin[level];
    }
}

/* Reads what INPUT is, and the tree that a compact one expands to. */
static int read_facts(program *state, file_facts *facts)
{
    svo_tree *tree = NULL;
    if (input_is_parts(state) && state->options.region == NULL && state->options.last_level == 0) {
        return read_parts(state, facts);
    }
    int exit_code = input_load_tree(state, &tree);
    if (exit_code == PROGRAM_DONE && input_is_compact(state)) {
        exit_code = input_load_compact(state, &facts->compact);
    }
    if (exit_code == PROGRAM_DONE) {
        facts->info = (svo_tree_info)SVO_TREE_INFO_INIT;
        svo_tree_get_info(tree, &facts->info);
        count_nodes(facts);
        exit_code = input_measure(state, &facts->file_bytes);
    }
    if (exit_code == PROGRAM_DONE && (svo_tree_hash(tree, SVO_HASH_ALL, facts->hash) != SVO_OK ||
                                      svo_tree_hash(tree, SVO_HASH_NODES, facts->nodes_hash) != SVO_OK)) {
        exit_code = program_fail(state, PROGRAM_FAILED, "%s: the tree cannot be hashed", state->options.input);
    }
    svo_tree_destroy(&tree);
    return exit_code;
}

/* All points are read, for their bounds. */
static int show_points(program *state)
{
    svo_points_info info;
    program_begin_step(state, "reading the points");
    const int exit_code = points_input_read(state, NULL, &info);
    progress_destroy(&state->progress);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    if (state->options.json) {
        cJSON *document = json_document();
        json_add_text(document, "file", state->options.input);
        points_input_add_json(document, &info);
        return json_print(state, document);
    }
    table_heading("%s", state->options.input);
    table *rows = table_create("ll");
    points_input_add_rows(rows, &info);
    table_print(rows);
    return PROGRAM_DONE;
}

int command_info(program *state)
{
    file_facts facts = {.compact = NULL};
    if (points_input_is_given(state)) {
        return show_points(state);
    }
    program_begin_progress(state, 1);
    int exit_code = read_facts(state, &facts);
    progress_destroy(&state->progress);
    if (exit_code == PROGRAM_DONE && state->options.json) {
        exit_code = json_print(state, to_json(state, &facts));
    } else if (exit_code == PROGRAM_DONE) {
        print_header(state, &facts);
        print_levels(&facts);
    }
    svo_compact_destroy(&facts.compact);
    return exit_code;
}
