/* SPDX-License-Identifier: MIT */
/* Prints plans and builds. Numbers are exact; lists of buffers after a build are digests to save space. */
#include "describe.h"

#include <inttypes.h>
#include <stdio.h>

#include "digest.h"
#include "support/info_of.h"
#include "svocl/io.h"

#define PATH_BYTES 512

static void print_plan_info(const char *name, const svo_plan *plan)
{
    const svo_plan_info info = info_of_plan(plan);
    line_text line = {.used = 0};
    line_text_add(&line, "snap_bits %u need %x constant %x triangles %" PRIu64 " refused %" PRIu64 " outside %" PRIu64,
                  (unsigned)info.snap_bits, (unsigned)info.need, (unsigned)info.constant, info.triangles,
                  info.refused_triangles, info.outside_triangles);
    line_text_add(&line, " origin %a %a %a edge %a scale %a snap_error %a", info.origin[0], info.origin[1],
                  info.origin[2], info.edge, info.scale, info.snap_error);
    line_text_add(&line, " expected %a fragments %" PRIu64 " ray depth %u", info.expected_fragments, info.fragments,
                  info.ray_depth);
    line_print(name, "plan", line.text);
}

static void list_buffers(const svo_plan *plan, line_text *line)
{
    static const char *const certainties[] = {"exact", "bound", "estimate"};
    const svo_plan_info info = info_of_plan(plan);
    for (size_t i = 0; i < info.buffer_count; ++i) {
        svo_buffer_info buffer = SVO_BUFFER_INFO_INIT;
        svo_plan_get_buffer(plan, i, &buffer);
        line_text_add(line, "%s %" PRIu64 " in %" PRIu64 " %s%s, ", buffer.name, buffer.bytes, buffer.count,
                      certainties[buffer.certainty], buffer.persistent != 0 ? " persistent" : "");
    }
    line_text_add(line, "peak %" PRIu64 ", tree %" PRIu64, info.peak_bytes, info.tree_bytes);
}

static void print_programs(const char *name, const svo_plan *plan)
{
    const svo_plan_info info = info_of_plan(plan);
    line_text line = {.used = 0};
    for (size_t i = 0; i < info.kernels_count; ++i) {
        svo_kernels_info kernels = SVO_KERNELS_INFO_INIT;
        svo_plan_get_kernels(plan, i, &kernels);
        line_text_add(&line, "%s%s%s", i > 0 ? ", " : "", kernels.name, kernels.defines);
    }
    line_print(name, "plan kernels", line.text);
}

static void print_left_out(const char *name, const svo_plan *plan)
{
    const svo_plan_info info = info_of_plan(plan);
    line_text what = {.used = 0};
    line_text reasons = {.used = 0};
    for (size_t i = 0; i < info.left_out_count; ++i) {
        svo_left_out entry = SVO_LEFT_OUT_INIT;
        svo_plan_get_left_out(plan, i, &entry);
        line_text_add(&what, "%s%s", i > 0 ? ", " : "", entry.what);
        line_text_add(&reasons, "%s%s", i > 0 ? "; " : "", entry.reason);
    }
    line_print(name, "plan left out", what.text);
    line_print(name, "plan left out because", reasons.text);
}

void describe_plan(const char *name, const svo_plan *plan)
{
    line_text buffers = {.used = 0};
    line_text stages = {.used = 0};
    for (svo_stage stage = SVO_STAGE_GRID; stage < SVO_STAGE_COUNT; ++stage) {
        line_text_add(&stages, "%s", svo_plan_has_stage(plan, stage) ? svo_name(SVO_NAME_STAGE, stage) : "");
        line_text_add(&stages, " ");
    }
    list_buffers(plan, &buffers);
    print_plan_info(name, plan);
    line_print(name, "plan stages", stages.text);
    line_print(name, "plan buffers", buffers.text);
    print_programs(name, plan);
    print_left_out(name, plan);
}

void describe_room(const char *name, svo_plan *plan, svo_frontend *frontend)
{
    svo_workspace_info info = SVO_WORKSPACE_INFO_INIT;
    line_text line = {.used = 0};
    const svo_status status = svo_workspace_measure(plan, frontend, &info);
    if (status != SVO_OK) {
        line_print_status(name, "workspace", status);
        return;
    }
    line_text_add(&line, "scratch %" PRIu64 " by %" PRIu64 " tree %" PRIu64 " fragments %" PRIu64 " inner %" PRIu64,
                  info.scratch_bytes, info.scratch_alignment, info.tree_bytes, info.fragment_capacity,
                  info.inner_capacity);
    line_print(name, "workspace", line.text);
}

static void print_tree_info(const char *name, const svo_tree *tree)
{
    svo_tree_info info = SVO_TREE_INFO_INIT;
    line_text line = {.used = 0};
    svo_tree_get_info(tree, &info);
    line_text_add(&line, "need %x constant %x weights %u payload_level %u nodes %" PRIu64 " inner %" PRIu64,
                  (unsigned)info.need, (unsigned)info.constant, (unsigned)info.weights, (unsigned)info.payload_level,
                  info.node_count, info.inner_count);
    line_text_add(&line, " list %" PRIu64 " vertices %" PRIu64 " triangles %" PRIu64 " of %" PRIu64 " refused %" PRIu64,
                  info.list_count, info.vertex_count, info.list_triangle_count, info.triangles, info.refused_triangles);
    line_text_add(&line, " fragments %" PRIu64 " edge %a scale %a error %a", info.fragments, info.edge, info.scale,
                  info.snap_error);
    line_print(name, "info", line.text);
}

/* Geometry kept for rays is not part of the tree's hash; it is part of the file. */
static void print_file(const char *name, const char *part, const svo_tree *tree, const char *path, uint32_t compress)
{
    const svo_save_options options = {.struct_size = sizeof options, .compress = compress};
    const svo_status status = svo_tree_save(tree, svo_to_path(path), &options, NULL);
    if (status != SVO_OK) {
        line_print_status(name, part, status);
        return;
    }
    line_print_file(name, part, path);
}

static void print_hash(const char *name, const char *part, const svo_tree *tree)
{
    char hash[SVO_HASH_TEXT_BYTES];
    const svo_status status = svo_tree_hash(tree, SVO_HASH_ALL, hash);
    if (status != SVO_OK) {
        line_print_status(name, part, status);
        return;
    }
    line_print(name, part, hash);
}

void describe_files(const char *name, svo_tree *tree, const char *folder)
{
    char path[PATH_BYTES];
    svo_tree *loaded = NULL;
    (void)snprintf(path, sizeof path, "%s/tree.svo", folder);
    print_file(name, "file compressed", tree, path, 1);
    const svo_status status = svo_tree_load(svo_from_path(path), NULL, &loaded, NULL);
    if (status == SVO_OK) {
        print_hash(name, "tree loaded", loaded);
        print_file(name, "file saved again", loaded, path, 0);
    } else {
        line_print_status(name, "tree loaded", status);
    }
    svo_tree_destroy(&loaded);
    (void)remove(path);
}

/* The clock of a stage tells whether it ran; milliseconds are left out. */
static void print_report(const char *name, const svo_build_report *report)
{
    line_text line = {.used = 0};
    line_text_add(&line, "fragments %" PRIu64 " inner %" PRIu64 " chunks %u reruns %u %s %s %s", report->fragments,
                  report->inner_nodes, (unsigned)report->list_chunks, (unsigned)report->reruns,
                  report->frontend != NULL ? report->frontend : "-", report->builder != NULL ? report->builder : "-",
                  report->share != NULL ? report->share : "-");
    for (size_t stage = 0; stage < SVO_STAGE_COUNT; ++stage) {
        svo_stage_time time;
        (void)svo_build_report_stage(report, stage, &time);
        const char *clock = time.clock;
        line_text_add(&line, " %s", clock != NULL ? clock : "-");
    }
    line_print(name, "report", line.text);
}

void describe_build(const char *name, const opened *session, build *finished, const char *folder)
{
    char path[PATH_BYTES];
    line_text buffers = {.used = 0};
    print_report(name, &finished->report);
    const svo_status status = svo_tree_download(finished->tree, session->queue);
    if (status != SVO_OK) {
        line_print_status(name, "tree", status);
        return;
    }
    (void)snprintf(path, sizeof path, "%s/tree.svo", folder);
    list_buffers(finished->plan, &buffers);
    print_hash(name, "tree", finished->tree);
    print_tree_info(name, finished->tree);
    print_file(name, "file", finished->tree, path, 0);
    (void)remove(path);
    line_print_digest(name, "buffers", buffers.text, buffers.used);
}

static void print_calls(const char *name, const char *part, const call_counts *counts)
{
    char title[LINE_NAME_BYTES];
    line_text line = {.used = 0};
    for (int call = 0; call < COUNTED_CALL_COUNT; ++call) {
        line_text_add(&line, "%s %" PRIu64 " ", counted_call_name((counted_call)call), counts->calls[call]);
    }
    line_text_add(&line, "bytes %" PRIu64, counts->created_bytes);
    (void)snprintf(title, sizeof title, "calls of %s", part);
    line_print(name, title, line.text);
    (void)snprintf(title, sizeof title, "order of calls of %s", part);
    line = (line_text){.used = 0};
    line_text_add(&line, "buffers %016" PRIx64 " programs %016" PRIx64 " arguments %016" PRIx64, counts->buffers,
                  counts->programs, counts->arguments);
    line_text_add(&line, " launches %016" PRIx64 " transfers %016" PRIx64, counts->launches, counts->transfers);
    line_print(name, title, line.text);
}

void describe_calls(const char *name, const build *finished)
{
    static const char *const parts[PART_COUNT] = {"plan", "workspace", "enqueue", "build"};
    for (int part = 0; part < PART_COUNT; ++part) {
        print_calls(name, parts[part], &finished->counts[part]);
    }
}
