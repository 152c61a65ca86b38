/* SPDX-License-Identifier: MIT */
/*
 * Compiles, measures and runs the stages that a plan needs, in the order of their table; svo_plan_create and its twin
 * for buffers, which predict what a build allocates; build reports.
 */
#include "pipeline/run.h"

#include <string.h>

#include "core/struct_size.h"
#include "plan/accounts.h"
#include "plan/chunking.h"
#include "plan/configuration.h"
#include "plan/estimate.h"
#include "plan/plan.h"
#include "stages/inputs.h"
#include "stages/stage_table.h"
#include "stages/voxelize.h"

/* ---- reports ---- */

_Static_assert(SVO_STAGE_COUNT <= SVO_STAGE_CAPACITY, "a report has room for every stage");

svo_status svo_i_report_check(svo_device *device, const char *function, const svo_build_report *report)
{
    return report == NULL ? SVO_OK
                          : svo_i_struct_check(&device->message, function, "report", report,
                                               SVO_I_STRUCT_SIZES(svo_build_report, renderer));
}

void svo_i_report_write(const svo_build_report *made, svo_build_report *report)
{
    if (report != NULL) {
        (void)svo_i_struct_write(NULL, "", "report", made, report, SVO_I_STRUCT_SIZES(svo_build_report, renderer));
    }
}

size_t svo_build_report_stage(const svo_build_report *report, size_t index, svo_stage_time *time)
{
    const size_t end_bytes = offsetof(svo_build_report, stage_times) + (index + 1) * sizeof report->stage_times[0];
    const bool known = index < SVO_STAGE_COUNT && end_bytes <= report->struct_size;
    if (time != NULL) {
        *time = known ? report->stage_times[index] : (svo_stage_time){.clock = NULL};
    }
    return SVO_STAGE_COUNT;
}

/* ---- the stages ---- */

/* Fills build->programs with those of the plan's stages. Adds newly compiled programs to warm_up. */
static svo_status get_programs(svo_i_build *build, svo_i_warm_up *warm_up)
{
    const svo_plan *plan = build->commands.plan;
    for (size_t i = 0; i < plan->stage_count; ++i) {
        const svo_i_program *program = svo_i_plan_new_program(plan, i);
        bool fresh = false;
        if (program != NULL) {
            SVO_I_TRY(svo_i_build_get_program(build, SVO_I_BUILD, program, &fresh));
        }
        if (fresh) {
            SVO_I_TRY(svo_i_warm_up_add_program(warm_up, svo_i_build_program(build, program)));
        }
    }
    return SVO_OK;
}

svo_status svo_i_order_run(svo_i_build *build)
{
    const svo_plan *plan = build->commands.plan;
    for (size_t i = 0; i < plan->stage_count; ++i) {
        const svo_i_stage *stage = &plan->stages[i];
        if (stage->run != NULL && stage->runs(plan)) {
            svo_i_commands_stage(&build->commands, stage->stage, stage->item_ns);
            SVO_I_TRY(stage->run(build));
        }
    }
    return SVO_OK;
}

void svo_i_order_release_scratch(svo_i_build *build)
{
    for (uint32_t i = 0; build->cursors != NULL && i < build->list.chunk_count; ++i) {
        svo_i_commands_free(&build->commands, &build->cursors[i]);
    }
    svo_i_free(build->cursors);
    svo_i_surface_free(build);
    svo_i_commands_free(&build->commands, &build->order);
    svo_i_commands_free(&build->commands, &build->state);
    svo_i_commands_free(&build->commands, &build->partials);
    svo_i_build_release_list(build);
}

/* ---- measuring builds ---- */

/* Lists of more chunks are measured with this many. */
#define CHUNKS_MAX 32

/* Rough time to make a fragment, for the progress. */
#define FRAGMENT_NS 60.0

/* How much of a build is measured. */
typedef enum build_extent { LIST_ALONE, ALL_STAGES } build_extent;

static svo_status measure_stages(svo_i_build *build, const svo_i_chunking *chunking, build_extent extent)
{
    svo_i_commands *commands = &build->commands;
    build->list.chunk_count = chunking->chunk_count;
    build->list.chunks =
        svo_i_alloc_zeroed(&commands->device->memory, chunking->chunk_count + 1u, sizeof *build->list.chunks);
    if (build->list.chunks == NULL) {
        return svo_i_device_fail(commands->device, SVO_OUT_OF_HOST_MEMORY, "svo_plan_create: no memory for %u chunks",
                                 chunking->chunk_count);
    }
    build->owns_list = true;
    if (build->in_place) {
        SVO_I_TRY(svo_i_build_alloc_published(build));
    }
    if (build->frontend == NULL || build->frontend->on_device) { /* other front ends allocate their lists themselves */
        SVO_I_TRY(svo_i_voxelize(NULL, commands, chunking, &build->list));
    }
    if (!build->in_place) { /* a blocking build has read them by now */
        svo_i_commands_free(commands, &build->list.counters);
    }
    for (uint32_t i = 0; i < chunking->chunk_count; ++i) {
        build->list.chunks[i].needed = chunking->chunks[i].capacity;
        build->fragment_count += chunking->chunks[i].capacity;
    }
    svo_i_build_fill_info(build);
    svo_i_build_assume_counts(build);
    return extent == ALL_STAGES ? svo_i_order_run(build) : SVO_OK;
}

/* Marks an allocation of the tree. The handles in a measured tree are no buffers, but indices of allocations. */
static void mark_persistent(const svo_i_allocations *allocations, cl_mem *handle)
{
    if (*handle != NULL) {
        allocations->entries[(size_t)(uintptr_t)*handle - 1].persistent = true;
        *handle = NULL;
    }
}

static void mark_tree(svo_i_build *build)
{
    for (int i = 0; i < SVO_TREE_BUFFER_COUNT; ++i) {
        mark_persistent(build->commands.allocations, &build->tree->buffers[i]);
    }
    mark_persistent(build->commands.allocations, &build->tree->build_state);
}

/* Runs a measuring build. build: its frontend, in_place, and the allocations and warm_up of its commands are set. */
static svo_status run(svo_i_build *build, svo_plan *plan, const svo_i_chunking *chunking, build_extent extent)
{
    svo_i_allocations discarded = {0};
    svo_build_report report = {0};
    svo_i_commands *commands = &build->commands;
    build->tree = svo_i_tree_new(&plan->device->memory);
    if (build->tree == NULL) {
        return svo_i_device_fail(plan->device, SVO_OUT_OF_HOST_MEMORY, "svo_plan_create: no memory to predict sizes");
    }
    commands->mode = SVO_I_MODE_MEASURE;
    commands->device = plan->device;
    commands->plan = plan;
    commands->report = &report;
    if (commands->allocations == NULL) {
        commands->allocations = &discarded;
    }
    svo_i_plan_buffers_reset(plan);
    const svo_status status = measure_stages(build, chunking, extent);
    svo_i_order_release_scratch(build);
    mark_tree(build);
    svo_i_allocations_free(&discarded);
    svo_tree_destroy(&build->tree);
    commands->report = NULL;
    commands->allocations = NULL;
    return status;
}

svo_status svo_i_measure(svo_plan *plan, svo_frontend *frontend, const svo_i_chunking *chunking,
                         svo_i_allocations *allocations)
{
    double expected_ns[SVO_STAGE_COUNT] = {0};
    svo_i_build build = {.commands = {.allocations = allocations, .expected_ns = expected_ns},
                         .frontend = frontend,
                         .in_place = allocations != NULL};
    SVO_I_TRY(run(&build, plan, chunking, ALL_STAGES));
    expected_ns[SVO_STAGE_VOXELIZE] = FRAGMENT_NS * plan->info.expected_fragments;
    expected_ns[SVO_STAGE_GRID] = plan->progress.expected_ns[SVO_STAGE_GRID];
    memcpy(plan->progress.expected_ns, expected_ns, sizeof expected_ns);
    return SVO_OK;
}

/* Makes CHUNKS_MAX equal chunks for a list of more. An exact cut would take a plan too much time and memory. */
static svo_status cut_roughly(const svo_plan *plan, svo_i_chunking *chunking)
{
    const uint64_t fragments = svo_i_with_slack(svo_i_plan_expected(plan, plan->info.depth));
    *chunking =
        (svo_i_chunking){.chunks = svo_i_alloc_zeroed(&plan->device->memory, CHUNKS_MAX, sizeof *chunking->chunks),
                         .chunk_count = CHUNKS_MAX};
    for (uint32_t i = 0; chunking->chunks != NULL && i < CHUNKS_MAX; ++i) {
        chunking->chunks[i].capacity = fragments / CHUNKS_MAX + 1;
    }
    return chunking->chunks != NULL
               ? SVO_OK
               : svo_i_device_fail(plan->device, SVO_OUT_OF_HOST_MEMORY, "svo_plan_create: no memory to predict sizes");
}

static svo_status cut(const svo_plan *plan, svo_i_chunking *chunking)
{
    const uint64_t chunk_bytes = svo_i_chunk_bytes_max(plan, UINT64_MAX);
    const double chunks =
        svo_i_plan_expected(plan, plan->info.depth) * svo_i_plan_fragment_bytes(plan) / (double)chunk_bytes;
    return chunks < CHUNKS_MAX ? svo_i_chunking_create(plan, chunk_bytes, chunking) : cut_roughly(plan, chunking);
}

svo_status svo_i_predict(svo_plan *plan)
{
    svo_i_chunking chunking = {0};
    SVO_I_TRY(cut(plan, &chunking));
    const svo_status status = svo_i_measure(plan, NULL, &chunking, NULL);
    svo_i_chunking_destroy(&chunking);
    plan->predicted_bytes = plan->peak_bytes;
    plan->predicted_tree_bytes = svo_i_plan_tree_bytes(plan);
    return status;
}

/* Warms up the kernels of newly compiled programs, by a measuring build. */
static svo_status warm_up_stages(const svo_i_build *build, svo_i_warm_up *warm_up, build_extent extent)
{
    svo_plan *plan = build->commands.plan;
    const svo_plan before = *plan;
    svo_i_chunking chunking = {0};
    svo_i_build measuring = {.commands = {.plan = plan, .warm_up = warm_up}, .frontend = build->frontend};
    memcpy(measuring.programs, build->programs, sizeof measuring.programs);
    SVO_I_TRY(cut(plan, &chunking));
    const svo_status status = run(&measuring, plan, &chunking, extent);
    svo_i_chunking_destroy(&chunking);
    const svo_i_progress progress = plan->progress;
    *plan = before; /* restores its list of buffers */
    plan->progress = progress;
    return status;
}

static svo_status compile(svo_i_build *build, build_extent extent)
{
    svo_status status = SVO_OK;
    svo_i_commands *commands = &build->commands;
    svo_frontend *frontend = build->frontend;
    const double start_ms = svo_i_now_ms();
    commands->plan->progress.expected_ns[SVO_STAGE_COMPILE] = 0.0;
    svo_i_warm_up warm_up = svo_i_warm_up_begin(commands->plan, commands->queue);
    if (extent == ALL_STAGES && frontend->make_tree == NULL) {
        SVO_I_TRY_CLEANUP(get_programs(build, &warm_up));
    }
    SVO_I_TRY_CLEANUP(frontend->prepare(frontend->self, commands->plan, &warm_up));
    if (warm_up.program_count > 0) {
        const double warm_ms = svo_i_now_ms();
        SVO_I_TRY_CLEANUP(warm_up_stages(build, &warm_up, extent));
        commands->device->compile_ms += svo_i_now_ms() - warm_ms;
    }
cleanup:
    svo_i_warm_up_end(&warm_up);
    svo_i_report_add(commands->report, SVO_STAGE_COMPILE, svo_i_now_ms() - start_ms, "wall");
    return status;
}

svo_status svo_i_compile(svo_i_build *build)
{
    return compile(build, ALL_STAGES);
}

svo_status svo_i_compile_frontend(svo_i_build *build)
{
    return compile(build, LIST_ALONE);
}

/* ---- plans ---- */

static svo_status check_arguments(svo_device *device, const char *function, const char *mesh_name, const void *mesh,
                                  svo_plan *const *out)
{
    return device != NULL && mesh != NULL && out != NULL
               ? SVO_OK
               : svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: %s is NULL", function,
                                   device == NULL ? "device"
                                   : mesh == NULL ? mesh_name
                                                  : "out");
}

svo_status svo_i_plan_create(svo_device *device, const char *function, const svo_i_plan_input *input, unsigned depth,
                             const svo_plan_options *options, svo_plan **out)
{
    svo_i_stage_list stages = {0};
    svo_plan *plan = NULL;
    svo_status status = SVO_OK;
    stages.rows = svo_i_stage_table(&stages.count);
    SVO_I_TRY(svo_i_plan_new(device, function, input, depth, options, &stages, &plan));
    SVO_I_TRY_CLEANUP(svo_i_progress_reach(plan, SVO_STAGE_GRID, 1.0));
    SVO_I_TRY_CLEANUP(input->is_of_parts ? SVO_OK : svo_i_predict(plan));
    SVO_I_TRY_CLEANUP(svo_i_progress_end(plan, SVO_STAGE_GRID));
    *out = plan;
    return SVO_OK;
cleanup:
    svo_plan_destroy(&plan);
    return status;
}

static svo_status create_from_mesh(svo_device *device, const char *function, const svo_mesh *mesh, bool is_of_parts,
                                   unsigned depth, const svo_plan_options *options, svo_plan **out)
{
    svo_i_plan_input input = {.is_of_parts = is_of_parts};
    SVO_I_TRY(check_arguments(device, function, "mesh", mesh, out));
    SVO_I_TRY(svo_i_struct_read(&device->message, function, "mesh", mesh, &input.mesh,
                                SVO_I_STRUCT_SIZES(svo_mesh, triangle_count)));
    return svo_i_plan_create(device, function, &input, depth, options, out);
}

svo_status svo_plan_create(svo_device *device, const svo_mesh *mesh, unsigned depth, const svo_plan_options *options,
                           svo_plan **out)
{
    return create_from_mesh(device, "svo_plan_create", mesh, false, depth, options, out);
}

svo_status svo_i_plan_of_parts(svo_device *device, const char *function, const svo_mesh *mesh, unsigned depth,
                               const svo_plan_options *options, svo_plan **out)
{
    return create_from_mesh(device, function, mesh, true, depth, options, out);
}

svo_status svo_plan_create_from_buffers(svo_device *device, const svo_mesh_buffers *buffers, unsigned depth,
                                        const svo_plan_options *options, cl_command_queue queue, cl_uint num_wait,
                                        const cl_event *wait, svo_plan **out)
{
    static const char function[] = "svo_plan_create_from_buffers";
    svo_mesh_buffers given;
    SVO_I_TRY(check_arguments(device, function, "buffers", buffers, out));
    SVO_I_TRY(svo_i_struct_read(&device->message, function, "buffers", buffers, &given,
                                SVO_I_STRUCT_SIZES(svo_mesh_buffers, indices)));
    const svo_i_plan_input input = {.mesh = {.vertex_count = given.vertex_count,
                                             .triangle_count = given.triangle_count,
                                             .materials = given.materials,
                                             .material_count = given.material_count,
                                             .textures = given.textures,
                                             .texture_count = given.texture_count},
                                    .buffers = &given,
                                    .queue = queue,
                                    .wait_count = num_wait,
                                    .wait = wait};
    return svo_i_plan_create(device, function, &input, depth, options, out);
}
