/* SPDX-License-Identifier: MIT */
/* Prints the stages, counts and buffers of a build. */
#include "support/build_report.h"

#include <inttypes.h>
#include <stdio.h>

#include "support/peak_memory.h"
#include "support/table.h"

/* One row of the stage table. The program measures the import itself; the library measures the others. */
typedef struct stage_row {
    const char *name;
    svo_stage_time time;
} stage_row;

#define STAGE_ROWS (SVO_STAGE_COUNT + 1)

/* In pipeline order; compilation comes last because it is no stage of the pipeline. */
static void list_stages(const job *done, stage_row rows[STAGE_ROWS])
{
    static const svo_stage order[SVO_STAGE_COUNT] = {SVO_STAGE_GRID,     SVO_STAGE_VOXELIZE, SVO_STAGE_SUBDIVIDE,
                                                     SVO_STAGE_LINK,     SVO_STAGE_PACK,     SVO_STAGE_FILTER,
                                                     SVO_STAGE_TRANSFER, SVO_STAGE_COMPILE};
    rows[0] = (stage_row){"import", {done->source.import_ms, "wall"}};
    for (size_t i = 0; i < SVO_STAGE_COUNT; ++i) {
        rows[i + 1] = (stage_row){svo_stage_name(order[i]), done->result.report.stage_times[order[i]]};
    }
}

static double stage_ms(const job *done, svo_stage stage)
{
    return done->result.report.stage_times[stage].ms;
}

/* From the fragment list to the finished tree. */
static double tree_ms(const job *done)
{
    return stage_ms(done, SVO_STAGE_SUBDIVIDE) + stage_ms(done, SVO_STAGE_LINK) + stage_ms(done, SVO_STAGE_PACK) +
           stage_ms(done, SVO_STAGE_FILTER);
}

static double per_second(uint64_t count, double ms)
{
    return ms > 0.0 ? (double)count / ms * 1000.0 : 0.0;
}

static void print_what_ran(const job *done)
{
    const build_result *result = &done->result;
    const unsigned long width = 1UL << result->info.depth;
    table *rows = table_create("ll");
    table_heading("%s", done->source.name);
    if (done->source.mesh != NULL) {
        table_cell(rows, "mesh");
        table_cell(rows, "%s triangles, %s vertices", figure_count(result->info.triangles).text,
                   figure_count(done->source.mesh->vertex_count).text);
    } else {
        voxel_input_add_rows(rows, &done->source.voxels);
    }
    table_cell(rows, "grid");
    table_cell(rows, "depth %u, %lu voxels per axis, %s, snap error %.3g", result->info.depth, width,
               svo_coverage_name((svo_coverage)result->info.coverage), result->info.snap_error);
    table_cell(rows, "opencl");
    table_cell(rows, "%s", svo_device_name(done->opened.device));
    table_cell(rows, "opengl");
    if (done->opened.frontend == done->opened.cl) {
        table_cell(rows, "%s", "not used");
    } else {
        table_cell(rows, "%s, %s", session_renderer(&done->opened), session_context(&done->opened));
    }
    table_cell(rows, "methods");
    table_cell(rows, "frontend %s, share %s, builder %s", result->report.frontend, result->report.share,
               result->report.builder);
    table_cell(rows, "%s", "");
    table_cell(rows, "%s: %s", result->report.frontend, done->opened.reason.text);
    table_print(rows);
}

static void print_stages(const program *state, const job *done)
{
    stage_row stages[STAGE_ROWS];
    list_stages(done, stages);
    const uint64_t repeats = state->options.repeat;
    table_gap();
    if (repeats > 1) {
        table_heading("stages, medians of %" PRIu64 " builds after the first", repeats - 1);
    } else {
        table_heading("stages");
    }
    table *rows = table_create("lrl");
    for (size_t i = 0; i < STAGE_ROWS; ++i) {
        table_cell(rows, "%s", stages[i].name);
        table_cell(rows, "%s", stages[i].time.clock != NULL ? figure_ms(stages[i].time.ms).text : "-");
        table_cell(rows, "%s", stages[i].time.clock != NULL ? stages[i].time.clock : "not needed");
    }
    if (repeats > 1) {
        table_cell(rows, "first compile");
        table_cell(rows, "%s", figure_ms(done->result.first_compile_ms).text);
        table_cell(rows, "in the first build");
    }
    table_print(rows);
    const uint64_t fragments = done->result.report.fragments;
    table_line("%s fragments voxelized, %s list to tree",
               figure_rate(per_second(fragments, stage_ms(done, SVO_STAGE_VOXELIZE))).text,
               figure_rate(per_second(fragments, tree_ms(done))).text);
}

static void print_counts(const job *done, const char *hash)
{
    table_gap();
    table_heading("tree");
    table *rows = table_create("lr");
    table_cell(rows, "fragments");
    table_cell(rows, "%s", figure_count(done->result.report.fragments).text);
    table_cell(rows, "leaves");
    table_cell(rows, "%s", figure_count(done->result.info.leaf_count).text);
    table_cell(rows, "nodes");
    table_cell(rows, "%s", figure_count(done->result.info.node_count).text);
    table_print(rows);
    table_line("hash       %s", hash);
}

static void print_buffers(const job *done)
{
    table_gap();
    table_heading("device memory");
    table *rows = table_create("lr");
    for (size_t i = 0; i < done->result.buffer_count; ++i) {
        table_cell(rows, "%s", done->result.buffers[i].name);
        table_cell(rows, "%s", figure_bytes(done->result.buffers[i].bytes).text);
    }
    table_cell(rows, "peak");
    table_cell(rows, "%s", figure_bytes(done->result.peak_bytes).text);
    table_print(rows);
}

void report_print_refused(const job *done)
{
    const refused_triangles *refused = &done->source.refused;
    const build_result *result = &done->result;
    const uint64_t all = result->plan.refused_triangles;
    if (all == 0) {
        return;
    }
    table_line("%s of %s triangles refused:", figure_count(all).text, figure_count(result->plan.triangles).text);
    if (refused->bad_index_count > 0) {
        table_line("  %s with an index out of range, the first is triangle %" PRIu64,
                   figure_count(refused->bad_index_count).text, refused->first_bad_index);
    }
    if (refused->not_finite_count > 0) {
        table_line("  %s with a coordinate that is not finite, the first is triangle %" PRIu64,
                   figure_count(refused->not_finite_count).text, refused->first_not_finite);
    }
    const uint64_t named = refused->bad_index_count + refused->not_finite_count;
    if (all > named) {
        table_line("  %s too far from the grid", figure_count(all - named).text);
    }
}

void report_print(const program *state, const job *done, const char *hash)
{
    print_what_ran(done);
    report_print_refused(done);
    print_stages(state, done);
    print_counts(done, hash);
    print_buffers(done);
}

void report_add_refused(cJSON *document, const job *done)
{
    const refused_triangles *refused = &done->source.refused;
    const uint64_t named = refused->bad_index_count + refused->not_finite_count;
    const uint64_t all = done->result.plan.refused_triangles;
    json_add_count(document, "triangles", done->result.plan.triangles);
    json_add_count(document, "refused_triangles", all);
    cJSON *reasons = cJSON_AddObjectToObject(document, "refused_reasons");
    json_add_count(reasons, "index_out_of_range", refused->bad_index_count);
    json_add_count(reasons, "not_finite", refused->not_finite_count);
    json_add_count(reasons, "too_far", all > named ? all - named : 0);
}

static void add_stages(cJSON *document, const program *state, const job *done)
{
    stage_row stages[STAGE_ROWS];
    list_stages(done, stages);
    cJSON *array = cJSON_AddArrayToObject(document, "stages");
    for (size_t i = 0; i < STAGE_ROWS; ++i) {
        cJSON *stage = cJSON_CreateObject();
        json_add_text(stage, "name", stages[i].name);
        cJSON_AddNumberToObject(stage, "ms", stages[i].time.clock != NULL ? stages[i].time.ms : 0.0);
        json_add_text(stage, "clock", stages[i].time.clock != NULL ? stages[i].time.clock : "none");
        cJSON_AddItemToArray(array, stage);
    }
    cJSON_AddNumberToObject(document, "first_compile_ms", done->result.first_compile_ms);
    json_add_count(document, "repeat", state->options.repeat);
    const uint64_t fragments = done->result.report.fragments;
    cJSON_AddNumberToObject(document, "voxelize_fragments_per_s",
                            per_second(fragments, stage_ms(done, SVO_STAGE_VOXELIZE)));
    cJSON_AddNumberToObject(document, "tree_fragments_per_s", per_second(fragments, tree_ms(done)));
}

/* What a mesh file declares and what was read, or what a voxel file holds; generated scenes have neither. */
static void add_import(cJSON *document, const job *done)
{
    const svo_import_info *info = &done->source.import_info;
    if (done->source.mesh == NULL) {
        voxel_input_add_json(document, &done->source.voxels);
    }
    if (done->source.import == NULL) {
        return;
    }
    cJSON *object = cJSON_AddObjectToObject(document, "import");
    json_add_text(object, "reader", info->reader);
    json_add_count(object, "declared_vertices", info->declared_vertices);
    json_add_count(object, "used_vertices", info->used_vertices);
    json_add_count(object, "declared_faces", info->declared_faces);
    json_add_count(object, "read_faces", info->read_faces);
    json_add_count(object, "triangles", info->triangles);
}

static void add_buffers(cJSON *document, const job *done)
{
    cJSON *array = cJSON_AddArrayToObject(document, "buffers");
    for (size_t i = 0; i < done->result.buffer_count; ++i) {
        cJSON *buffer = cJSON_CreateObject();
        json_add_text(buffer, "name", done->result.buffers[i].name);
        json_add_count(buffer, "bytes", done->result.buffers[i].bytes);
        cJSON_AddItemToArray(array, buffer);
    }
    json_add_count(document, "peak_bytes", done->result.peak_bytes);
    json_add_count(document, "peak_resident_bytes", peak_memory_bytes());
}

cJSON *report_to_json(const program *state, const job *done, const char *hash)
{
    const build_result *result = &done->result;
    cJSON *document = json_document();
    json_add_text(document, "input", done->source.name);
    add_import(document, done);
    report_add_refused(document, done);
    json_add_count(document, "fragments", result->report.fragments);
    json_add_count(document, "leaves", result->info.leaf_count);
    json_add_count(document, "nodes", result->info.node_count);
    json_add_text(document, "hash", hash);
    job_add_what_ran(document, done);
    cJSON_AddNumberToObject(document, "snap_error", result->info.snap_error);
    json_add_vector(document, "origin", result->info.origin);
    cJSON_AddNumberToObject(document, "edge", result->info.edge);
    json_add_count(document, "list_chunks", result->report.list_chunks);
    json_add_count(document, "reruns", result->report.reruns);
    if (result->calls_are_counted) {
        json_add_count(document, "launches", result->calls.launches);
        json_add_count(document, "uploads", result->calls.uploads);
        json_add_count(document, "waits", result->calls.waits);
    }
    add_stages(document, state, done);
    add_buffers(document, done);
    return document;
}
