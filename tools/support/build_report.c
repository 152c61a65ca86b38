/* SPDX-License-Identifier: MIT */
/* Reports of plans, builds and solids. */
#include "support/build_report.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "support/info_of.h"
#include "support/table.h"
#include "svocl/build.h"

uint64_t peak_memory_bytes(void)
{
    char line[256];
    uint64_t kibibytes = 0;
    FILE *file = fopen("/proc/self/status", "r");
    if (file == NULL) {
        return 0;
    }
    while (fgets(line, sizeof line, file) != NULL && sscanf(line, "VmHWM: %" SCNu64, &kibibytes) != 1) {
    }
    (void)fclose(file);
    return kibibytes * 1024;
}

/* ---- plans ---- */

/* "grid, voxelize, ..." */
static svo_message stages_of(const svo_plan *plan)
{
    svo_message names = {""};
    for (svo_stage stage = SVO_STAGE_GRID; stage < SVO_STAGE_COUNT; ++stage) {
        const size_t used = strlen(names.text);
        if (svo_plan_has_stage(plan, stage)) {
            (void)snprintf(names.text + used, sizeof names.text - used, "%s%s", used > 0 ? ", " : "",
                           svo_name(SVO_NAME_STAGE, stage));
        }
    }
    return names;
}

static void print_request(const svo_plan *plan, const char *name)
{
    const svo_plan_info info = info_of_plan(plan);
    table_heading("plan for %s", name);
    table *rows = table_create("ll");
    table_cell(rows, "grid");
    table_cell(rows, "depth %u, %lu voxels per axis, %s", info.depth, 1UL << info.depth,
               svo_name(SVO_NAME_COVERAGE, (svo_coverage)info.coverage));
    table_cell(rows, "triangles");
    table_cell(rows, "%s, of which %s refused", figure_count(info.triangles).text,
               figure_count(info.refused_triangles).text);
    table_cell(rows, "fragments");
    table_cell(rows, "about %s by the fragment estimate", figure_count((uint64_t)(info.expected_fragments + 0.5)).text);
    table_cell(rows, "read later");
    table_cell(rows, "nodes; %s", figure_needs(info.need).text);
    table_cell(rows, "stages");
    table_cell(rows, "%s", stages_of(plan).text);
    table_print(rows);
}

/* The plan assumes the OpenCL front end. If OpenGL was requested, its lines about the front end do not apply. */
static bool applies(const char *name, bool with_opengl)
{
    return !with_opengl || (strcmp(name, "voxelize") != 0 && strcmp(name, "OpenGL") != 0);
}

static void print_kernels(const svo_plan *plan, bool with_opengl)
{
    const svo_plan_info info = info_of_plan(plan);
    table_gap();
    table_heading("kernels");
    table *rows = table_create("ll");
    for (size_t i = 0; i < info.kernels_count; ++i) {
        svo_kernels_info kernels = SVO_KERNELS_INFO_INIT;
        svo_plan_get_kernels(plan, i, &kernels);
        if (applies(kernels.name, with_opengl)) {
            table_cell(rows, "%s", kernels.name);
            table_cell(rows, "%s", kernels.defines[0] != '\0' ? kernels.defines + 1 : "no defines");
        }
    }
    table_print(rows);
}

static void print_planned_buffers(const svo_plan *plan)
{
    const svo_plan_info info = info_of_plan(plan);
    table_gap();
    table_heading("device memory");
    table *rows = table_create("lrll");
    for (size_t i = 0; i < info.buffer_count; ++i) {
        svo_buffer_info buffer = SVO_BUFFER_INFO_INIT;
        svo_plan_get_buffer(plan, i, &buffer);
        table_cell(rows, "%s", buffer.name);
        table_cell(rows, "%s", figure_bytes(buffer.bytes).text);
        table_cell(rows, "%s", svo_name(SVO_NAME_CERTAINTY, buffer.certainty));
        table_cell(rows, "%s", buffer.persistent != 0 ? "tree" : "scratch");
    }
    table_cell(rows, "peak");
    table_cell(rows, "%s", figure_bytes(info.peak_bytes).text);
    table_cell(rows, "%s", "");
    table_cell(rows, "at any time");
    table_cell(rows, "tree");
    table_cell(rows, "%s", figure_bytes(info.tree_bytes).text);
    table_cell(rows, "%s", "");
    table_cell(rows, "persistent");
    table_print(rows);
}

static void print_left_out(const svo_plan *plan, bool with_opengl)
{
    const svo_plan_info info = info_of_plan(plan);
    table_gap();
    table_heading("left out");
    table *rows = table_create("ll");
    for (size_t i = 0; i < info.left_out_count; ++i) {
        svo_left_out entry = SVO_LEFT_OUT_INIT;
        svo_plan_get_left_out(plan, i, &entry);
        if (applies(entry.what, with_opengl)) {
            table_cell(rows, "%s", entry.what);
            table_cell(rows, "%s", entry.reason);
        }
    }
    table_print(rows);
}

void plan_print(const svo_plan *plan, const char *name, bool with_opengl)
{
    print_request(plan, name);
    print_kernels(plan, with_opengl);
    print_planned_buffers(plan);
    print_left_out(plan, with_opengl);
}

/* Adds {name: text, other_name: other_text} to an array. */
static void add_pair(cJSON *array, const char *name, const char *text, const char *other_name, const char *other_text)
{
    cJSON *entry = cJSON_CreateObject();
    json_add_text(entry, name, text);
    json_add_text(entry, other_name, other_text);
    cJSON_AddItemToArray(array, entry);
}

static void add_kernels(cJSON *document, const svo_plan *plan, bool with_opengl)
{
    const svo_plan_info info = info_of_plan(plan);
    cJSON *array = cJSON_AddArrayToObject(document, "kernels");
    for (size_t i = 0; i < info.kernels_count; ++i) {
        svo_kernels_info kernels = SVO_KERNELS_INFO_INIT;
        svo_plan_get_kernels(plan, i, &kernels);
        if (applies(kernels.name, with_opengl)) {
            add_pair(array, "name", kernels.name, "defines", kernels.defines[0] != '\0' ? kernels.defines + 1 : "");
        }
    }
}

static void add_planned_buffers(cJSON *document, const svo_plan *plan)
{
    const svo_plan_info info = info_of_plan(plan);
    cJSON *array = cJSON_AddArrayToObject(document, "buffers");
    for (size_t i = 0; i < info.buffer_count; ++i) {
        svo_buffer_info buffer = SVO_BUFFER_INFO_INIT;
        cJSON *entry = cJSON_CreateObject();
        svo_plan_get_buffer(plan, i, &buffer);
        json_add_text(entry, "name", buffer.name);
        json_add_count(entry, "bytes", buffer.bytes);
        json_add_text(entry, "certainty", svo_name(SVO_NAME_CERTAINTY, buffer.certainty));
        cJSON_AddBoolToObject(entry, "persistent", buffer.persistent != 0);
        cJSON_AddItemToArray(array, entry);
    }
}

static void add_left_out(cJSON *document, const svo_plan *plan, bool with_opengl)
{
    const svo_plan_info info = info_of_plan(plan);
    cJSON *array = cJSON_AddArrayToObject(document, "left_out");
    for (size_t i = 0; i < info.left_out_count; ++i) {
        svo_left_out left_out = SVO_LEFT_OUT_INIT;
        svo_plan_get_left_out(plan, i, &left_out);
        if (applies(left_out.what, with_opengl)) {
            add_pair(array, "what", left_out.what, "reason", left_out.reason);
        }
    }
}

static void add_planned_stages(cJSON *document, const svo_plan *plan)
{
    cJSON *array = cJSON_AddArrayToObject(document, "stages");
    for (svo_stage stage = SVO_STAGE_GRID; stage < SVO_STAGE_COUNT; ++stage) {
        if (svo_plan_has_stage(plan, stage)) {
            cJSON_AddItemToArray(array, cJSON_CreateString(svo_name(SVO_NAME_STAGE, stage)));
        }
    }
}

void plan_add_json(cJSON *document, const svo_plan *plan, bool with_opengl)
{
    const svo_plan_info info = info_of_plan(plan);
    json_add_count(document, "depth", info.depth);
    json_add_text(document, "coverage", svo_name(SVO_NAME_COVERAGE, (svo_coverage)info.coverage));
    json_add_count(document, "triangles", info.triangles);
    json_add_count(document, "refused_triangles", info.refused_triangles);
    cJSON_AddNumberToObject(document, "expected_fragments", info.expected_fragments);
    json_add_needs(document, "need", info.need);
    json_add_needs(document, "constant", info.constant);
    add_planned_stages(document, plan);
    add_kernels(document, plan, with_opengl);
    add_planned_buffers(document, plan);
    json_add_count(document, "peak_bytes", info.peak_bytes);
    json_add_count(document, "tree_bytes", info.tree_bytes);
    add_left_out(document, plan, with_opengl);
}

/* ---- solids ---- */

bool solid_is_wanted(const program *state)
{
    return state->options.solid != 0;
}

svo_solid_rule solid_rule(const program *state)
{
    return (svo_solid_rule)(state->options.solid - 1);
}

uint32_t solid_need(const program *state, uint32_t need)
{
    return solid_is_wanted(state) ? (need & ~(uint32_t)SVO_NEED_NONE) | (uint32_t)SVO_NEED_RAYS : need;
}

static int follow_fill(void *user, double fraction)
{
    progress_part(user, "cells", fraction);
    return progress_stops(user) ? 1 : 0;
}

int solid_make(program *state, const svo_device *device, const svo_tree *tree, solid_result *out)
{
    *out = (solid_result){.info = SVO_SOLID_INFO_INIT, .form = SVO_COMPACT_INFO_INIT};
    if (!solid_is_wanted(state)) {
        return PROGRAM_DONE;
    }
    const svo_solid_options asked = {.struct_size = sizeof asked,
                                     .rule = solid_rule(state),
                                     .progress = follow_fill,
                                     .progress_user = state->progress};
    const double compiled_ms = info_of_device(device).compile_ms;
    progress_step(state->progress, "finding the inside");
    const double start_ms = input_now_ms();
    if (svo_solid_create(tree, &asked, NULL, &out->solid, &out->info) != SVO_OK) {
        return program_fail_library(state, svo_device_message(device));
    }
    out->compile_ms = info_of_device(device).compile_ms - compiled_ms;
    out->ms = input_now_ms() - start_ms - out->compile_ms;
    (void)svo_compact_get_info(out->solid, &out->form);
    return PROGRAM_DONE;
}

void solid_release(solid_result *made)
{
    svo_compact_destroy(&made->solid);
}

static bool is_closed(const svo_solid_info *info)
{
    return info->open_columns[0] == 0 && info->open_columns[1] == 0 && info->open_columns[2] == 0;
}

static void add_row(table *rows, const char *name, uint64_t voxels, uint64_t leaves)
{
    table_cell(rows, "%s", name);
    table_cell(rows, "%s", figure_count(voxels).text);
    table_cell(rows, "%s", figure_count(leaves).text);
}

void solid_print(const program *state, const solid_result *made)
{
    const svo_solid_info *info = &made->info;
    if (made->solid == NULL) {
        return;
    }
    table_gap();
    table_heading("solid by %s, %s, and %s of compiling", svo_name(SVO_NAME_SOLID_RULE, solid_rule(state)),
                  figure_ms(made->ms).text, figure_ms(made->compile_ms).text);
    table *rows = table_create("lrr");
    table_cell(rows, "%s", "");
    table_cell(rows, "voxels");
    table_cell(rows, "leaves");
    add_row(rows, "surface", info->surface_voxels, info->surface_voxels);
    add_row(rows, "inside", info->inside_voxels, info->inside_leaves);
    add_row(rows, "ambiguous", info->ambiguous_voxels, info->ambiguous_cells);
    table_print(rows);
    if (info->regions > 0) {
        table_line("%s empty cells in %s regions, %s of words and payload", figure_count(info->tests).text,
                   figure_count(info->regions).text, figure_bytes(made->form.total_bytes).text);
    } else {
        table_line("%s empty cells tested, %s of words and payload", figure_count(info->tests).text,
                   figure_bytes(made->form.total_bytes).text);
    }
    if (info->boundary_edges > 0) {
        table_line("generalized winding numbers beside %s edges that do not cancel",
                   figure_count(info->boundary_edges).text);
    }
    if (!is_closed(info)) {
        table_line("the surface is not closed: crossings do not cancel in %s columns along x, %s along y, %s along z",
                   figure_count(info->open_columns[0]).text, figure_count(info->open_columns[1]).text,
                   figure_count(info->open_columns[2]).text);
    }
}

cJSON *solid_add_json(cJSON *document, const program *state, const solid_result *made)
{
    const svo_solid_info *info = &made->info;
    static const char *const axes[3] = {"x", "y", "z"};
    if (made->solid == NULL) {
        return NULL;
    }
    cJSON *object = cJSON_AddObjectToObject(document, "solid");
    json_add_text(object, "rule", svo_name(SVO_NAME_SOLID_RULE, solid_rule(state)));
    json_add_count(object, "surface_voxels", info->surface_voxels);
    json_add_count(object, "inside_voxels", info->inside_voxels);
    json_add_count(object, "inside_leaves", info->inside_leaves);
    json_add_count(object, "tests", info->tests);
    json_add_count(object, "regions", info->regions);
    json_add_count(object, "boundary_edges", info->boundary_edges);
    json_add_count(object, "ambiguous_cells", info->ambiguous_cells);
    json_add_count(object, "ambiguous_voxels", info->ambiguous_voxels);
    cJSON *columns = cJSON_AddObjectToObject(object, "open_columns");
    for (int axis = 0; axis < 3; ++axis) {
        json_add_count(columns, axes[axis], info->open_columns[axis]);
    }
    json_add_count(object, "bytes", made->form.total_bytes);
    json_add_count(object, "scratch_bytes", info->scratch_bytes);
    cJSON_AddNumberToObject(object, "ms", made->ms);
    cJSON_AddNumberToObject(object, "compile_ms", made->compile_ms);
    return object;
}

/* ---- builds ---- */

/* One row of the stage table. The program measures the import itself; the library measures the others. */
typedef struct stage_row {
    const char *name;
    svo_stage_time time;
} stage_row;

#define STAGE_ROWS (SVO_STAGE_COUNT + 1)

/* In pipeline order; compilation comes last because it is no stage of the pipeline. */
static void list_stages(const job *done, stage_row rows[STAGE_ROWS])
{
    static const svo_stage order[SVO_STAGE_COUNT] = {SVO_STAGE_GRID,      SVO_STAGE_VOXELIZE, SVO_STAGE_DROP,
                                                     SVO_STAGE_SUBDIVIDE, SVO_STAGE_LINK,     SVO_STAGE_PACK,
                                                     SVO_STAGE_FILTER,    SVO_STAGE_TRANSFER, SVO_STAGE_COMPILE};
    rows[0] = (stage_row){"import", {done->source.import_ms, "wall"}};
    for (size_t i = 0; i < SVO_STAGE_COUNT; ++i) {
        rows[i + 1] = (stage_row){svo_name(SVO_NAME_STAGE, order[i]), done->result.report.stage_times[order[i]]};
    }
}

static double stage_ms(const job *done, svo_stage stage)
{
    return done->result.report.stage_times[stage].ms;
}

/* From the fragment list to the finished tree. */
static double tree_ms(const job *done)
{
    return stage_ms(done, SVO_STAGE_DROP) + stage_ms(done, SVO_STAGE_SUBDIVIDE) + stage_ms(done, SVO_STAGE_LINK) +
           stage_ms(done, SVO_STAGE_PACK) + stage_ms(done, SVO_STAGE_FILTER);
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
    table_cell(rows, "depth %u, %lu voxels per axis, %s", result->info.depth, width,
               svo_name(SVO_NAME_COVERAGE, (svo_coverage)result->info.coverage));
    table_cell(rows, "opencl");
    table_cell(rows, "%s", info_of_device(done->opened.device).name);
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

static void print_counts(const program *state, const job *done, const char *hash)
{
    const bool drops = state->options.drop_alpha > 0.0;
    table_gap();
    table_heading("tree");
    table *rows = table_create("lr");
    table_cell(rows, "fragments");
    table_cell(rows, "%s", figure_count(done->result.report.fragments).text);
    table_cell(rows, "undecided");
    table_cell(rows, "%s", figure_count(done->result.report.undecided).text);
    if (drops) {
        table_cell(rows, "dropped");
        table_cell(rows, "%s", figure_count(done->result.report.dropped).text);
    }
    table_cell(rows, "leaves");
    table_cell(rows, "%s", figure_count(done->result.info.leaf_count).text);
    table_cell(rows, "nodes");
    table_cell(rows, "%s", figure_count(done->result.info.node_count).text);
    table_print(rows);
    table_line("hash       %s", hash);
    if (drops && done->result.plan.drops_pairs == 0) {
        table_line("--drop-alpha leaves nothing out: no color, material or texel has an alpha below %g",
                   state->options.drop_alpha);
    }
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
    print_counts(state, done, hash);
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
    json_add_count(object, "welded_vertices", info->welded_vertices);
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
    if (state->options.drop_alpha > 0.0) {
        json_add_count(document, "dropped", result->report.dropped);
    }
    json_add_count(document, "leaves", result->info.leaf_count);
    json_add_count(document, "nodes", result->info.node_count);
    json_add_text(document, "hash", hash);
    job_add_what_ran(document, done);
    json_add_vector(document, "origin", result->info.origin);
    cJSON_AddNumberToObject(document, "edge", result->info.edge);
    json_add_count(document, "undecided", result->report.undecided);
    json_add_count(document, "list_chunks", result->report.list_chunks);
    json_add_count(document, "reruns", result->report.reruns);
    if (result->calls_are_counted) {
        json_add_count(document, "launches", result->calls.launches);
        json_add_count(document, "uploads", result->calls.uploads);
        json_add_count(document, "waits", result->calls.waits);
        json_add_count(document, "allocations", result->calls.buffers);
        json_add_count(document, "reads", result->calls.reads);
        cJSON_AddNumberToObject(document, "allocations_ms", result->calls.buffers_ms);
        cJSON_AddNumberToObject(document, "reads_ms", result->calls.reads_ms);
    }
    cJSON_AddNumberToObject(document, "wall_ms", result->wall_ms);
    cl_calls_add_kernels(document);
    add_stages(document, state, done);
    add_buffers(document, done);
    return document;
}
