/* SPDX-License-Identifier: MIT */
/* Pins of plans, stages and builds that are enqueued. */
#include "pins.h"
#include "support/info_of.h"

#include <setjmp.h>
#include <stdarg.h>

#include <cmocka.h>

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#define ALL_NEEDS                                                                                                   \
    ((uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL | (uint32_t)SVO_NEED_RAYS | (uint32_t)SVO_NEED_MATERIAL | \
     (uint32_t)SVO_NEED_FILL | (uint32_t)SVO_NEED_PROJECTED_AREA)
#define NO_FILL (ALL_NEEDS & ~(uint32_t)SVO_NEED_FILL)

/* For deep trees: a grid in which the meshes are small. */
#define WIDE_GRID .origin = {-210, -190, -200}, .edge = 400

/* ---- plan ---- */

static void pin_plan_info(pins *all, const svo_plan *plan)
{
    svo_plan_info info = SVO_PLAN_INFO_INIT;
    svo_plan_get_info(plan, &info);
    pin_text(all, "counts",
             "snap_bits %u need %x constant %x triangles %" PRIu64 " refused %" PRIu64 " outside %" PRIu64,
             (unsigned)info.snap_bits, (unsigned)info.need, (unsigned)info.constant, info.triangles,
             info.refused_triangles, info.outside_triangles);
    pin_text(all, "grid", "origin %a %a %a edge %a scale %a", info.origin[0], info.origin[1], info.origin[2], info.edge,
             info.scale);
    pin_text(all, "estimate", "fragments %a area %a weight_log2 %u ray depth %u tree bytes %" PRIu64,
             info.expected_fragments, info.area, (unsigned)info.weight_log2, info.ray_depth, info.tree_bytes);
}

/* What a plan does and leaves out depends on the kernels. */
static void pin_stages_of_plan(pins *all, const char *kernels, const svo_plan *plan)
{
    char text[4096] = "";
    char name[64];
    size_t used = 0;
    for (svo_stage stage = SVO_STAGE_GRID; stage < SVO_STAGE_COUNT; ++stage) {
        if (svo_plan_has_stage(plan, stage)) {
            used += (size_t)snprintf(text + used, sizeof text - used, "%s%s", used > 0 ? ", " : "",
                                     svo_name(SVO_NAME_STAGE, stage));
        }
    }
    (void)snprintf(name, sizeof name, "stages by kernels for %s", kernels);
    pin_text(all, name, "%s", text);
    used = 0;
    for (size_t i = 0; i < info_of_plan(plan).left_out_count; ++i) {
        svo_left_out entry = SVO_LEFT_OUT_INIT;
        svo_plan_get_left_out(plan, i, &entry);
        used += (size_t)snprintf(text + used, sizeof text - used, "%s: %s\n", entry.what, entry.reason);
        assert_true(used < sizeof text);
    }
    (void)snprintf(name, sizeof name, "left out by kernels for %s", kernels);
    pin_digest(all, name, text, used);
}

static const struct {
    const char *name;
    unsigned depth;
    svo_plan_options options;
} plans[] = {
    {"default", 6, {.need = SVO_NEED_DEFAULT}},
    {"all", 5, {.need = ALL_NEEDS}},
    {"across", 11, {.need = ALL_NEEDS, .origin = {0.1, 0.2, -0.5}, .edge = 0.75, .coverage = SVO_COVERAGE_CLOSED}},
    {"deep", 14, {.need = SVO_NEED_RAYS, WIDE_GRID, .coverage = SVO_COVERAGE_THIN}},
    {"in doubt", 7, {.need = SVO_NEED_COLOR, .worst_case_nodes = 1, .fragment_capacity = 123456}},
    {"by kernels", 6, {.need = ALL_NEEDS, .place = SVO_PLACE_DEVICE, .origin = {-4, -4, -4}, .edge = 9}},
};

/* A handle of its own, with the kernels that are asked for. */
static svo_device *open_path(svo_path path)
{
    const svo_device_options options = {.struct_size = sizeof options, .path = path};
    svo_device *device = NULL;
    svo_message message = {""};
    if (svo_device_create_default(&options, &device, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    return device;
}

void pin_plan(pins *all)
{
    svo_device *devices[2] = {open_path(SVO_PATH_CPU), open_path(SVO_PATH_GPU)};
    for (size_t s = 0; s < PIN_SCENES; ++s) {
        for (size_t i = 0; i < sizeof plans / sizeof plans[0]; ++i) {
            svo_plan_options options = plans[i].options;
            svo_plan *plan = NULL;
            options.struct_size = sizeof options;
            pin_begin(all, "%s %s", all->scenes[s].name, plans[i].name);
            pin_succeed(all, svo_plan_create(all->opened.device, all->scenes[s].mesh, plans[i].depth, &options, &plan));
            pin_plan_info(all, plan);
            svo_plan_destroy(&plan);
            for (int path = 0; path < 2 && options.place != SVO_PLACE_DEVICE; ++path) {
                assert_int_equal(svo_plan_create(devices[path], all->scenes[s].mesh, plans[i].depth, &options, &plan),
                                 SVO_OK);
                pin_stages_of_plan(all, svo_name(SVO_NAME_PATH, info_of_device(devices[path]).path), plan);
                svo_plan_destroy(&plan);
            }
        }
    }
    svo_device_destroy(&devices[0]);
    svo_device_destroy(&devices[1]);
}

/* ---- stages ---- */

static const struct {
    const char *name;
    unsigned depth;
    svo_plan_options options;
} builds[] = {
    {"all", 5, {.need = ALL_NEEDS}},
    {"none", 6, {.need = SVO_NEED_NONE}},
    {"closed", 5, {.need = ALL_NEEDS, .coverage = SVO_COVERAGE_CLOSED}},
    {"thin", 5, {.need = SVO_NEED_COLOR | SVO_NEED_RAYS, .coverage = SVO_COVERAGE_THIN}},
    {"uniform", 4, {.need = NO_FILL, .weights = SVO_WEIGHTS_UNIFORM}},
    {"center", 4, {.need = NO_FILL, .weights = SVO_WEIGHTS_CENTER}},
    {"from level 3", 5, {.need = ALL_NEEDS, .payload_level = 3}},
    {"sorted", 5, {.need = ALL_NEEDS, .builder = SVO_BUILDER_SORTED}},
    {"in chunks", 6, {.need = ALL_NEEDS, .chunk_bytes = 16384}},
    {"across", 5, {.need = ALL_NEEDS, .origin = {0, 0.1, -0.5}, .edge = 1}},
    {"deep", 13, {.need = SVO_NEED_DEFAULT, WIDE_GRID}},
};

void pin_stages(pins *all)
{
    for (size_t s = 0; s < PIN_SCENES; ++s) {
        pin_begin(all, "%s", all->scenes[s].name);
        for (size_t i = 0; i < sizeof builds / sizeof builds[0]; ++i) {
            svo_tree *tree = pin_build(all, all->scenes[s].mesh, builds[i].depth, &builds[i].options);
            pin_tree(all, builds[i].name, tree);
            svo_tree_destroy(&tree);
        }
    }
}

/* ---- pipeline ---- */

static void pin_report(pins *all, const char *name, const svo_build_report *report)
{
    pin_text(all, name, "fragments %" PRIu64 " inner nodes %" PRIu64 " chunks %u reruns %u by %s, %s",
             report->fragments, report->inner_nodes, (unsigned)report->list_chunks, (unsigned)report->reruns,
             report->builder, report->frontend);
}

/* Capacities that are too small are grown by a blocking build. */
static void pin_grown(pins *all, const svo_mesh *mesh)
{
    const svo_plan_options options = {.struct_size = sizeof options, .need = ALL_NEEDS, .fragment_capacity = 300};
    svo_build_report report = SVO_BUILD_REPORT_INIT;
    svo_plan *plan = NULL;
    svo_tree *tree = NULL;
    pin_succeed(all, svo_plan_create(all->opened.device, mesh, 5, &options, &plan));
    pin_succeed(all, svo_build(plan, all->opened.frontend, all->opened.queue, &tree, &report));
    pin_tree(all, "grown", tree);
    pin_report(all, "grown, report", &report);
    svo_tree_destroy(&tree);
    svo_plan_destroy(&plan);
}

/* Two builds of one workspace into one tree; the second is trimmed. */
static void pin_enqueued(pins *all, const svo_mesh *mesh)
{
    const svo_plan_options options = {.struct_size = sizeof options, .need = ALL_NEEDS};
    svo_build_report report = SVO_BUILD_REPORT_INIT;
    svo_workspace_info room = SVO_WORKSPACE_INFO_INIT;
    svo_plan *plan = NULL;
    svo_workspace *workspace = NULL;
    svo_tree *tree = NULL;
    const fixture *opened = &all->opened;
    pin_succeed(all, svo_plan_create(opened->device, mesh, 5, &options, &plan));
    pin_succeed(all, svo_plan_count(plan, opened->frontend, opened->queue));
    pin_succeed(all, svo_workspace_create(plan, opened->frontend, opened->queue, NULL, &workspace));
    pin_succeed(all, svo_workspace_get_info(workspace, &room));
    /* Room for fragments is for undecided ones too, and which are depends on the path. */
    pin_text(all, "room", "inner nodes %" PRIu64, room.inner_capacity);
    pin_succeed(all, svo_workspace_make_tree(workspace, &tree));
    for (int i = 0; i < 2; ++i) {
        pin_succeed(all, svo_build_enqueue(workspace, tree, &(svo_submit){.queue = opened->queue}));
        pin_succeed(all, svo_tree_finish(tree, opened->queue, i, &report));
    }
    pin_tree(all, "enqueued", tree);
    pin_report(all, "enqueued, report", &report);
    svo_tree_destroy(&tree);
    svo_workspace_destroy(&workspace);
    svo_plan_destroy(&plan);
}

/* A mesh that moves: the plan is updated, the workspace builds again. */
static void pin_updated(pins *all, const svo_mesh *mesh, const svo_mesh *moved)
{
    const svo_plan_options options = {
        .struct_size = sizeof options, .need = ALL_NEEDS, .origin = {-2, -2, -2}, .edge = 5, .updatable = 1};
    const fixture *opened = &all->opened;
    svo_build_report report = SVO_BUILD_REPORT_INIT;
    svo_plan *plan = NULL;
    svo_workspace *workspace = NULL;
    svo_tree *tree = NULL;
    pin_succeed(all, svo_plan_create(opened->device, mesh, 5, &options, &plan));
    pin_succeed(all, svo_workspace_create(plan, opened->frontend, opened->queue, NULL, &workspace));
    pin_succeed(all, svo_workspace_make_tree(workspace, &tree));
    pin_succeed(all, svo_plan_update(plan, moved, NULL));
    pin_succeed(all, svo_build_enqueue(workspace, tree, &(svo_submit){.queue = opened->queue}));
    pin_succeed(all, svo_tree_finish(tree, opened->queue, 0, &report));
    pin_tree(all, "updated", tree);
    pin_report(all, "updated, report", &report);
    svo_tree_destroy(&tree);
    svo_workspace_destroy(&workspace);
    svo_plan_destroy(&plan);
}

/* The same mesh, smaller and moved. Released by free_moved. */
static svo_mesh move_mesh(const svo_mesh *mesh)
{
    const size_t count = mesh->vertex_count * 3;
    float *floats = mesh->positions != NULL ? malloc(count * sizeof *floats) : NULL;
    double *doubles = mesh->positions == NULL ? malloc(count * sizeof *doubles) : NULL;
    svo_mesh moved = *mesh;
    for (size_t i = 0; i < count && floats != NULL; ++i) {
        floats[i] = mesh->positions[i] * 0.75F + 0.125F;
    }
    for (size_t i = 0; i < count && doubles != NULL; ++i) {
        doubles[i] = mesh->positions_double[i] * 0.75 + 0.125;
    }
    moved.positions = floats;
    moved.positions_double = doubles;
    return moved;
}

static void free_moved(svo_mesh *moved)
{
    free((void *)moved->positions);
    free((void *)moved->positions_double);
}

void pin_pipeline(pins *all)
{
    for (size_t s = 0; s < PIN_SCENES; ++s) {
        const svo_mesh *mesh = all->scenes[s].mesh;
        svo_mesh moved = move_mesh(mesh);
        pin_begin(all, "%s", all->scenes[s].name);
        pin_grown(all, mesh);
        pin_enqueued(all, mesh);
        pin_updated(all, mesh, &moved);
        free_moved(&moved);
    }
}
