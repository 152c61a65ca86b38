/* SPDX-License-Identifier: MIT */
/* Prints a plan. */
#include "support/plan_report.h"

#include <stdio.h>
#include <string.h>

#include "support/table.h"
#include "svocl/build.h"

/* "grid, voxelize, ..." */
static svo_message stages_of(const svo_plan *plan)
{
    svo_message names = {""};
    for (svo_stage stage = SVO_STAGE_GRID; stage < SVO_STAGE_COUNT; ++stage) {
        const size_t used = strlen(names.text);
        if (svo_plan_has_stage(plan, stage)) {
            (void)snprintf(names.text + used, sizeof names.text - used, "%s%s", used > 0 ? ", " : "",
                           svo_stage_name(stage));
        }
    }
    return names;
}

static void print_request(const svo_plan *plan, const char *input)
{
    svo_plan_info info = SVO_PLAN_INFO_INIT;
    svo_plan_get_info(plan, &info);
    table_heading("plan for %s", input);
    table *rows = table_create("ll");
    table_cell(rows, "grid");
    table_cell(rows, "depth %u, %lu voxels per axis, %s", info.depth, 1UL << info.depth,
               svo_coverage_name((svo_coverage)info.coverage));
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
    table_gap();
    table_heading("kernels");
    table *rows = table_create("ll");
    for (size_t i = 0; i < svo_plan_kernels_count(plan); ++i) {
        svo_kernels_info kernels = SVO_KERNELS_INFO_INIT;
        svo_plan_get_kernels(plan, i, &kernels);
        if (applies(kernels.name, with_opengl)) {
            table_cell(rows, "%s", kernels.name);
            table_cell(rows, "%s", kernels.defines[0] != '\0' ? kernels.defines + 1 : "no defines");
        }
    }
    table_print(rows);
}

static void print_buffers(const svo_plan *plan)
{
    table_gap();
    table_heading("device memory");
    table *rows = table_create("lrll");
    for (size_t i = 0; i < svo_plan_buffer_count(plan); ++i) {
        svo_buffer_info buffer = SVO_BUFFER_INFO_INIT;
        svo_plan_get_buffer(plan, i, &buffer);
        table_cell(rows, "%s", buffer.name);
        table_cell(rows, "%s", figure_bytes(buffer.bytes).text);
        table_cell(rows, "%s", svo_certainty_name(buffer.certainty));
        table_cell(rows, "%s", buffer.persistent != 0 ? "tree" : "scratch");
    }
    table_cell(rows, "peak");
    table_cell(rows, "%s", figure_bytes(svo_plan_peak_bytes(plan)).text);
    table_cell(rows, "%s", "");
    table_cell(rows, "at any time");
    table_cell(rows, "tree");
    table_cell(rows, "%s", figure_bytes(svo_plan_tree_bytes(plan)).text);
    table_cell(rows, "%s", "");
    table_cell(rows, "persistent");
    table_print(rows);
}

static void print_left_out(const svo_plan *plan, bool with_opengl)
{
    table_gap();
    table_heading("left out");
    table *rows = table_create("ll");
    for (size_t i = 0; i < svo_plan_left_out_count(plan); ++i) {
        svo_left_out entry = SVO_LEFT_OUT_INIT;
        svo_plan_get_left_out(plan, i, &entry);
        if (applies(entry.what, with_opengl)) {
            table_cell(rows, "%s", entry.what);
            table_cell(rows, "%s", entry.reason);
        }
    }
    table_print(rows);
}

void plan_print(const svo_plan *plan, const char *input, bool with_opengl)
{
    print_request(plan, input);
    print_kernels(plan, with_opengl);
    print_buffers(plan);
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
    cJSON *array = cJSON_AddArrayToObject(document, "kernels");
    for (size_t i = 0; i < svo_plan_kernels_count(plan); ++i) {
        svo_kernels_info kernels = SVO_KERNELS_INFO_INIT;
        svo_plan_get_kernels(plan, i, &kernels);
        if (applies(kernels.name, with_opengl)) {
            add_pair(array, "name", kernels.name, "defines", kernels.defines[0] != '\0' ? kernels.defines + 1 : "");
        }
    }
}

static void add_buffers(cJSON *document, const svo_plan *plan)
{
    cJSON *array = cJSON_AddArrayToObject(document, "buffers");
    for (size_t i = 0; i < svo_plan_buffer_count(plan); ++i) {
        svo_buffer_info buffer = SVO_BUFFER_INFO_INIT;
        cJSON *entry = cJSON_CreateObject();
        svo_plan_get_buffer(plan, i, &buffer);
        json_add_text(entry, "name", buffer.name);
        json_add_count(entry, "bytes", buffer.bytes);
        json_add_text(entry, "certainty", svo_certainty_name(buffer.certainty));
        cJSON_AddBoolToObject(entry, "persistent", buffer.persistent != 0);
        cJSON_AddItemToArray(array, entry);
    }
}

static void add_left_out(cJSON *document, const svo_plan *plan, bool with_opengl)
{
    cJSON *array = cJSON_AddArrayToObject(document, "left_out");
    for (size_t i = 0; i < svo_plan_left_out_count(plan); ++i) {
        svo_left_out left_out = SVO_LEFT_OUT_INIT;
        svo_plan_get_left_out(plan, i, &left_out);
        if (applies(left_out.what, with_opengl)) {
            add_pair(array, "what", left_out.what, "reason", left_out.reason);
        }
    }
}

static void add_stages(cJSON *document, const svo_plan *plan)
{
    cJSON *array = cJSON_AddArrayToObject(document, "stages");
    for (svo_stage stage = SVO_STAGE_GRID; stage < SVO_STAGE_COUNT; ++stage) {
        if (svo_plan_has_stage(plan, stage)) {
            cJSON_AddItemToArray(array, cJSON_CreateString(svo_stage_name(stage)));
        }
    }
}

void plan_add_json(cJSON *document, const svo_plan *plan, bool with_opengl)
{
    svo_plan_info info = SVO_PLAN_INFO_INIT;
    svo_plan_get_info(plan, &info);
    json_add_count(document, "depth", info.depth);
    json_add_text(document, "coverage", svo_coverage_name((svo_coverage)info.coverage));
    json_add_count(document, "triangles", info.triangles);
    json_add_count(document, "refused_triangles", info.refused_triangles);
    cJSON_AddNumberToObject(document, "expected_fragments", info.expected_fragments);
    json_add_needs(document, "need", info.need);
    json_add_needs(document, "constant", info.constant);
    add_stages(document, plan);
    add_kernels(document, plan, with_opengl);
    add_buffers(document, plan);
    json_add_count(document, "peak_bytes", svo_plan_peak_bytes(plan));
    json_add_count(document, "tree_bytes", svo_plan_tree_bytes(plan));
    add_left_out(document, plan, with_opengl);
}
