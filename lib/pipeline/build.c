/* SPDX-License-Identifier: MIT */
/* svo_build, the blocking build: makes the fragment list, runs the stages and returns the tree. */
#include "core/memory.h"
#include "pipeline/default_frontend.h"
#include "pipeline/list.h"
#include "pipeline/measure.h"
#include "pipeline/order.h"
#include "pipeline/report.h"
#include "plan/accounts.h"
#include "plan/part.h"
#include "plan/update.h"
#include "stages/inputs.h"

/* Refuses a scene that, by the fragment estimate, exceeds the caller's budget. Nothing is compiled yet. A front end
   that makes the tree has all but the tree in memory of its own. */
static svo_status check_budget(const svo_i_build *build)
{
    const svo_plan *plan = build->commands.plan;
    return svo_i_plan_check_budget(
        plan, SVO_I_BUILD, build->frontend->make_tree != NULL ? plan->predicted_tree_bytes : plan->predicted_bytes);
}

/* Refuses a scene that, by the fragment estimate, does not fit the device. Nothing is allocated yet. */
static svo_status check_size(svo_i_build *build)
{
    const svo_plan *plan = build->commands.plan;
    if (plan->info.expected_fragments >= (double)UINT32_MAX) {
        return svo_i_device_fail(build->commands.device, SVO_OUT_OF_DEVICE_MEMORY,
                                 "svo_build: the scene needs about %.0f fragments at depth %u, above 2^32 - 1; "
                                 "svo_parts_create builds it in parts",
                                 plan->info.expected_fragments, plan->info.depth);
    }
    if (plan->predicted_bytes > build->commands.device->global_bytes) {
        return svo_i_device_fail(
            build->commands.device, SVO_OUT_OF_DEVICE_MEMORY,
            "svo_build: the scene needs about %s at depth %u, above the device's %s; svo_parts_create "
            "builds it in parts",
            svo_i_bytes(plan->predicted_bytes).text, plan->info.depth,
            svo_i_bytes(build->commands.device->global_bytes).text);
    }
    return SVO_OK;
}

static svo_status run_stages(svo_i_build *build)
{
    svo_frontend *frontend = build->frontend;
    SVO_I_TRY(check_size(build));
    SVO_I_TRY(svo_i_list_make(build));
    svo_i_build_fill_info(build);
    if (frontend->make_tree == NULL) {
        return svo_i_order_run(build);
    }
    SVO_I_TRY(frontend->make_tree(frontend->self, build));
    return svo_i_constants_store(build);
}

/* Why an argument is wrong, or NULL. */
static const char *wrong_argument(const svo_plan *plan, const svo_frontend *frontend, svo_tree *const *out)
{
    if (frontend->device != plan->device) {
        return "frontend is of another device than plan";
    }
    return out == NULL ? "out is NULL" : svo_i_update_wrong(plan, frontend->on_device);
}

static void begin_report(svo_build_report *report, const svo_plan *plan, const svo_frontend *frontend)
{
    const char *builder = frontend->make_tree != NULL ? frontend->builder : svo_builder_name(plan->options.builder);
    *report = (svo_build_report){.frontend = frontend->name,
                                 .share = frontend->share,
                                 .builder = builder,
                                 .renderer = frontend->renderer != NULL ? frontend->renderer : ""};
    svo_i_report_add(report, SVO_STAGE_GRID, plan->info.grid_ms, "wall");
}

/* Where the mesh moves, the host learns its counts now. */
static svo_status run_updated(svo_i_build *build)
{
    svo_plan *plan = build->commands.plan;
    SVO_I_TRY(svo_i_update_settle(plan, SVO_I_BUILD, build->commands.queue));
    SVO_I_TRY(run_stages(build));
    if (build->tree->info.list_triangle_count > 0) {
        build->tree->info.list_triangle_count = plan->update->kept_triangles;
    }
    return SVO_OK;
}

/* asked: whether the caller wants the report. */
static svo_status run_build(svo_plan *plan, svo_frontend *frontend, cl_command_queue queue, svo_tree **out,
                            svo_build_report *report, bool asked)
{
    svo_status status = SVO_OK;
    svo_i_build build = {.commands = svo_i_commands_begin(plan, queue, report), .frontend = frontend};
    build.commands.untimed = !asked;
    build.commands.blocks = frontend->make_tree != NULL; /* from memory of OpenGL that is mapped for a moment */
    begin_report(report, plan, frontend);
    svo_i_plan_buffers_reset(plan);
    plan->built = true;
    build.tree = svo_i_tree_new(&plan->device->memory);
    if (build.tree == NULL) {
        return svo_i_device_fail(plan->device, SVO_OUT_OF_HOST_MEMORY, "svo_build: no memory for the tree");
    }
    build.tree->device = plan->device;
    SVO_I_TRY_CLEANUP(svo_i_progress_begin(plan, SVO_I_BUILD, SVO_I_STAGES_OF_BUILDS));
    SVO_I_TRY_CLEANUP(check_budget(&build));
    SVO_I_TRY_CLEANUP(svo_i_compile(&build));
    SVO_I_TRY_CLEANUP(plan->update != NULL ? run_updated(&build) : run_stages(&build));
    SVO_I_TRY_CLEANUP(svo_i_commands_wait(&build.commands));
    SVO_I_TRY_CLEANUP(svo_i_progress_end(plan, build.commands.stage));
    *out = build.tree;
    build.tree = NULL;
cleanup:
    report->fragments = build.fragment_count;
    report->list_chunks = build.list.chunk_count;
    svo_i_commands_end(&build.commands);
    svo_i_stage_collect(&build.commands);
    svo_i_order_release_scratch(&build);
    svo_tree_destroy(&build.tree);
    return status;
}

svo_status svo_build(svo_plan *plan, svo_frontend *frontend, cl_command_queue queue, svo_tree **out,
                     svo_build_report *report)
{
    if (plan == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    SVO_I_TRY(svo_i_report_check(plan->device, SVO_I_BUILD, report));
    SVO_I_TRY(svo_i_default_frontend(plan->device, frontend, &frontend));
    SVO_I_TRY(svo_i_device_queue(plan->device, SVO_I_BUILD, queue, &queue));
    const char *wrong = wrong_argument(plan, frontend, out);
    if (wrong != NULL) {
        return svo_i_device_fail(plan->device, SVO_INVALID_ARGUMENT, "svo_build: %s", wrong);
    }
    if (svo_i_plan_is_part(plan) && frontend->make_tree != NULL) {
        return svo_i_device_fail(plan->device, SVO_UNSUPPORTED, "svo_build: the builder %s makes no parts of trees",
                                 frontend->builder);
    }
    svo_build_report made;
    const svo_status status = run_build(plan, frontend, queue, out, &made, report != NULL);
    svo_i_report_write(&made, report);
    return status;
}
