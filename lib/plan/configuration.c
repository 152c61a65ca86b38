/* SPDX-License-Identifier: MIT */
/*
 * Determines what a build of a plan does, from the request and the scene. Everything later follows plan->work: which
 * stages run, which kernels are compiled, which buffers are allocated. Whatever is left out is listed with its reason.
 */
#include "plan/configuration.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "core/struct_size.h"
#include "plan/arrays.h"

/* ---- the choice of a front end ---- */

/*
 * The rules that predict which front end is faster. None of them runs anything.
 *
 * On two cores with PoCL 3.1 and llvmpipe, OpenCL alone makes six times as many fragments per second as the software
 * rasterizer. It makes a million of them in 15 ms; OpenGL takes 30 ms to start. Two rules are assumptions, not
 * measurements: a GPU rasterizes faster than a CPU computes, and copying a GPU's list through the host costs more than
 * rasterization saves.
 */

/* OpenCL makes fewer fragments than this before OpenGL has started. */
#define FEW_FRAGMENTS 1048576.0

int svo_frontend_cl_suffices(const svo_plan *plan, svo_message *reason)
{
    const bool few = plan->info.expected_fragments < FEW_FRAGMENTS;
    svo_i_message_set(reason, "about %.0f fragments are %s to start OpenGL for", plan->info.expected_fragments,
                      few ? "too few" : "enough");
    return few;
}

bool svo_i_frontend_prefers_cl(const svo_device *device, const svo_i_renderer *renderer, svo_message *reason)
{
    if (renderer->is_software) {
        svo_i_message_set(reason, "%s draws in software, OpenCL on %s is faster", renderer->name, device->name);
        return true;
    }
    if (!renderer->in_place && !device->cpu_path) {
        svo_i_message_set(reason, "%s and %s share no memory, and the list would go through the host", renderer->name,
                          device->name);
        return true;
    }
    if (renderer->in_place) {
        svo_i_message_set(reason, "%s draws in hardware, and %s has the list in place", renderer->name, device->name);
    } else {
        svo_i_message_set(reason, "%s draws in hardware, faster than %s computes", renderer->name, device->name);
    }
    return false;
}

/* ---- what a build does ---- */

static void leave_out(svo_i_work *work, const char *what, const char *format, ...) SVO_I_FORMAT(3, 4);

/* Entries beyond SVO_I_LEFT_OUT_MAX are only counted; check_capacities fails then. */
static void leave_out(svo_i_work *work, const char *what, const char *format, ...)
{
    const size_t index = work->left_out_count++;
    if (index >= SVO_I_LEFT_OUT_MAX) {
        return;
    }
    svo_i_left_out *entry = &work->left_out[index];
    entry->what = what;
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(entry->reason.text, sizeof entry->reason.text, format, arguments);
    va_end(arguments);
}

/* The builder, leaf lists, the ranges of the leaves' entries, and the order of leaves. */
static void configure_lists(svo_plan *plan)
{
    svo_i_work *work = &plan->work;
    work->sorted = plan->options.builder == SVO_BUILDER_SORTED;
    work->lists = (plan->info.need & SVO_NEED_RAYS) != 0;
    work->ranges = work->lists || (work->made & SVO_NEED_MATERIAL) != 0;
    work->order = work->filter && !work->pair_lanes && !work->sorted;
}

/* Lists stages that do not run, with the reasons from the table of stages. */
static void leave_out_stages(svo_plan *plan)
{
    for (size_t i = 0; i < plan->stage_count; ++i) {
        const svo_i_stage *stage = &plan->stages[i];
        if (stage->left_out != NULL && !stage->runs(plan)) {
            leave_out(&plan->work, stage->left_out, "%s", stage->reason(plan));
        }
    }
}

static void leave_out_payload(svo_plan *plan, svo_need bit, const char *what)
{
    svo_i_work *work = &plan->work;
    if ((plan->info.need & (uint32_t)bit) == 0) {
        const bool by_default = plan->options.need == SVO_NEED_DEFAULT && bit == SVO_NEED_COLOR;
        leave_out(work, what, "%s", by_default ? "the mesh has none" : "it is not requested");
    }
}

/* Lists payload that is the same in every node. */
static void leave_out_constants(svo_i_work *work)
{
    if ((work->constant & SVO_NEED_COLOR) != 0) {
        const uint32_t color = work->constant_color;
        leave_out(work, "color per node", "every node has the color #%02x%02x%02x%02x, stored once", color & 255u,
                  color >> 8 & 255u, color >> 16 & 255u, color >> 24);
    }
    if ((work->constant & SVO_NEED_NORMAL) != 0) {
        leave_out(work, "normal per node", "every node has the normal (%.3f, %.3f, %.3f), stored once",
                  work->constant_normal[0] / 32767.0, work->constant_normal[1] / 32767.0,
                  work->constant_normal[2] / 32767.0);
    }
    if ((work->constant & SVO_NEED_MATERIAL) != 0) {
        leave_out(work, "material per node", "every node has material %u, stored once", work->constant_material);
    }
}

static void leave_out_clipping(svo_plan *plan)
{
    svo_i_work *work = &plan->work;
    if ((work->made & SVO_NEED_PROJECTED_AREA) != 0) {
        return; /* clipping is for the areas, whatever the weights */
    }
    if (!work->positions) {
        leave_out(work, "clipping", "uniform weights do not depend on where in its voxel a triangle is");
    } else if (plan->options.weights == SVO_WEIGHTS_CENTER) {
        leave_out(work, "clipping", "with center weights every pair weighs 1");
    }
}

static void leave_out_textures(svo_plan *plan)
{
    svo_i_work *work = &plan->work;
    const bool color = (work->made & SVO_NEED_COLOR) != 0;
    const char *reason = color ? "no accepted triangle is textured" : "no color is computed per node";
    if (work->drop && plan->texel_count > 0 && !work->textures) {
        return; /* their alpha is read */
    }
    if (!work->textures) {
        leave_out(work, "textures", "%s", reason);
        leave_out(work, "texture coordinates", "%s", color ? "no texture is sampled" : reason);
    } else if (plan->textures_used < plan->textures_given) {
        leave_out(work, "unused textures", "no accepted triangle uses %zu of the %zu",
                  plan->textures_given - plan->textures_used, plan->textures_given);
    }
}

/* Lists payload inputs that no stage reads. */
static void leave_out_inputs(svo_plan *plan)
{
    svo_i_work *work = &plan->work;
    if (!work->surface) {
        leave_out(work, "mesh attributes", "no payload is computed from them");
        return;
    }
    leave_out_clipping(plan);
    const bool alpha_of_vertices = work->drop && svo_i_plan_has(plan->colors, plan->memory.colors);
    if (!work->vertex_colors && !alpha_of_vertices) {
        leave_out(work, "vertex colors", "%s",
                  (work->made & SVO_NEED_COLOR) != 0 ? "the mesh has none, or a single one, which the materials include"
                                                     : "no color is computed per node");
    }
    leave_out_textures(plan);
    if (!work->vertex_normals) {
        leave_out(work, "vertex normals", "%s",
                  (work->made & SVO_NEED_NORMAL) != 0 ? "the mesh has none; triangles use their own"
                                                      : "no normal is computed per node");
    }
}

/* Whether lanes of pairs get the sums of single pairs: kernels/shared/clip_lanes.clh undoes roundings by fma, and needs
   doubles without any other error. rusticl on llvmpipe (Mesa 25.0) claims them and gives other sums. */
static bool has_exact_doubles(const svo_device *device)
{
    static const char *const drivers[] = {"Portable Computing Language", "Oclgrind"};
    bool is_known = false;
    for (size_t i = 0; i < sizeof drivers / sizeof drivers[0]; ++i) {
        is_known = is_known || strncmp(device->name, drivers[i], strlen(drivers[i])) == 0;
    }
    return device->has_fp64 && is_known;
}

static void configure_payload(svo_plan *plan)
{
    svo_i_work *work = &plan->work;
    work->made = plan->info.need & SVO_I_NEED_PAYLOAD & ~work->constant;
    const bool areas = (work->made & SVO_NEED_PROJECTED_AREA) != 0;
    work->filter = areas || (work->made & SVO_I_NEED_FILTER) != 0;
    work->pair_lanes = work->filter && plan->device->cpu_path && has_exact_doubles(plan->device);
    work->surface = work->made != 0 || work->drop;
    work->positions = areas || (work->surface && plan->options.weights != SVO_WEIGHTS_UNIFORM);
    work->vertex_colors = (work->made & SVO_NEED_COLOR) != 0 && svo_i_plan_has(plan->colors, plan->memory.colors);
    work->vertex_normals = (work->made & SVO_NEED_NORMAL) != 0 && svo_i_plan_has(plan->normals, plan->memory.normals);
    work->textures = (work->made & SVO_NEED_COLOR) != 0 && plan->texels != NULL;
    leave_out_payload(plan, SVO_NEED_COLOR, "color");
    leave_out_payload(plan, SVO_NEED_NORMAL, "normal");
    leave_out_payload(plan, SVO_NEED_MATERIAL, "material");
    leave_out_payload(plan, SVO_NEED_FILL, "fill");
    leave_out_payload(plan, SVO_NEED_PROJECTED_AREA, "projected area");
    leave_out_constants(work);
    if (plan->least_alpha != 0 && !work->drop) {
        leave_out(work, "pairs to drop", "no color, material or texel of the triangles has an alpha below %g",
                  plan->options.drop_alpha);
    }
    if (work->made == SVO_NEED_PROJECTED_AREA) {
        leave_out(work, "filtered levels", "only leaves have projected areas");
    } else if (work->made != 0 && plan->options.payload_level > 0) {
        leave_out(work, "filtered levels", "payload begins at level %u", plan->options.payload_level);
    }
    leave_out_inputs(plan);
}

static uint32_t class_count(const svo_plan *plan, svo_i_class class_id)
{
    return plan->class_begin[class_id + 1] - plan->class_begin[class_id];
}

/* Selects the overlap tests. Triangles inside one voxel need none; any variant works for them. */
static void configure_tests(svo_plan *plan)
{
    svo_i_work *work = &plan->work;
    const uint32_t points = class_count(plan, SVO_I_CLASS_POINT);
    work->tests[SVO_I_TEST_NARROW] = class_count(plan, SVO_I_CLASS_NARROW) > 0;
    work->tests[SVO_I_TEST_REGULAR] = class_count(plan, SVO_I_CLASS_REGULAR) > 0;
    work->tests[SVO_I_TEST_WIDE] = class_count(plan, SVO_I_CLASS_WIDE) > 0;
    const bool any = work->tests[SVO_I_TEST_NARROW] || work->tests[SVO_I_TEST_REGULAR] || work->tests[SVO_I_TEST_WIDE];
    work->tests[SVO_I_TEST_NONE] = points > 0 && !any;
    if (plan->triangle_count == 0 || plan->update != NULL) {
        return; /* no triangles, or nothing is known of them */
    }
    if (points > 0) {
        leave_out(work, "overlap test", "%u of %u triangles lie inside one voxel each", points, plan->triangle_count);
    }
    if (!work->tests[SVO_I_TEST_REGULAR] && !work->tests[SVO_I_TEST_WIDE]) {
        leave_out(work, "64-bit overlap test", "no triangle's bounding box is wider than 128 voxels");
    }
    if (!work->tests[SVO_I_TEST_WIDE]) {
        leave_out(work, "128-bit products", "no triangle reaches outside the grid%s",
                  plan->info.snap_bits > 20 ? ", or is wider than 128 voxels" : "");
    }
}

static void configure_codes(svo_plan *plan)
{
    plan->work.long_codes = plan->info.depth > SVO_CODE30_DEPTH_MAX;
    if (!plan->work.long_codes) {
        leave_out(&plan->work, "64-bit Morton codes", "depth %u is not above %d", plan->info.depth,
                  SVO_CODE30_DEPTH_MAX);
    }
}

static void configure_opengl(svo_plan *plan)
{
    svo_message reason;
    if (svo_frontend_cl_suffices(plan, &reason)) {
        leave_out(&plan->work, "OpenGL", "%s", reason.text);
    }
}

/* Whether a stage among the first rows of the table runs and has kernels in the program. */
static bool needs_program(const svo_plan *plan, size_t rows, const svo_i_program *program)
{
    for (size_t i = 0; i < rows; ++i) {
        if (plan->stages[i].program == program && plan->stages[i].runs(plan)) {
            return true;
        }
    }
    return false;
}

bool svo_i_plan_needs_program(const svo_plan *plan, const svo_i_program *program)
{
    return needs_program(plan, plan->stage_count, program);
}

/* Programs that the front end compiles: the voxelizer, which is one for each test, and what decides. */
static bool is_of_frontend(const svo_i_stage *stage)
{
    return stage->stage == SVO_STAGE_VOXELIZE;
}

const svo_i_program *svo_i_plan_new_program(const svo_plan *plan, size_t row)
{
    const svo_i_stage *stage = &plan->stages[row];
    return stage->runs(plan) && !is_of_frontend(stage) && !needs_program(plan, row, stage->program) ? stage->program
                                                                                                    : NULL;
}

/* Adds a program; returns the array for its defines. Those beyond SVO_I_KERNELS_MAX are only counted;
   check_capacities fails then. */
static char *add_kernels(svo_i_work *work, const char *name)
{
    const size_t index = work->kernels_count++;
    const size_t place = index < SVO_I_KERNELS_MAX ? index : SVO_I_KERNELS_MAX - 1;
    work->kernels[place].name = name;
    return work->kernels[place].defines;
}

/* Lists the voxelizer of a front end, once per test. */
static void list_voxelizers(svo_plan *plan, const char *name)
{
    for (svo_i_test test = 0; test < SVO_I_TEST_COUNT; ++test) {
        if (plan->work.tests[test]) {
            svo_i_plan_test_defines(plan, test, add_kernels(&plan->work, name), SVO_I_DEFINES_BYTES);
        }
    }
}

static void list_kernels(svo_plan *plan)
{
    for (size_t i = 0; i < plan->stage_count; ++i) {
        const svo_i_program *program = svo_i_plan_new_program(plan, i);
        if (program != NULL) {
            svo_i_plan_defines(plan, program, add_kernels(&plan->work, program->name), SVO_I_DEFINES_BYTES);
        }
    }
    for (size_t i = 0; i < plan->stage_count; ++i) {
        const svo_i_stage *stage = &plan->stages[i];
        if (is_of_frontend(stage) && stage->defines == NULL) {
            list_voxelizers(plan, stage->program->name);
        } else if (is_of_frontend(stage) && stage->runs(plan)) {
            svo_i_plan_defines(plan, stage->program, add_kernels(&plan->work, stage->program->name),
                               SVO_I_DEFINES_BYTES);
        }
    }
}

/* Whether the configuration fits its arrays: a mistake in the library if it does not. */
static svo_status check_capacities(const svo_plan *plan)
{
    const svo_i_work *work = &plan->work;
    if (work->left_out_count > SVO_I_LEFT_OUT_MAX) {
        return svo_i_device_fail(plan->device, SVO_INTERNAL, "svo_plan_create: %zu things are left out, above %d",
                                 work->left_out_count, SVO_I_LEFT_OUT_MAX);
    }
    if (work->kernels_count > SVO_I_KERNELS_MAX) {
        return svo_i_device_fail(plan->device, SVO_INTERNAL, "svo_plan_create: %zu programs, above %d",
                                 work->kernels_count, SVO_I_KERNELS_MAX);
    }
    for (size_t i = 0; i < work->kernels_count; ++i) {
        if (strlen(work->kernels[i].defines) + 1 == SVO_I_DEFINES_BYTES) { /* full, so they may have been cut */
            return svo_i_device_fail(plan->device, SVO_INTERNAL,
                                     "svo_plan_create: the defines of program %s take %d bytes or more",
                                     work->kernels[i].name, SVO_I_DEFINES_BYTES);
        }
    }
    return SVO_OK;
}

svo_status svo_i_plan_configure(svo_plan *plan)
{
    configure_payload(plan);
    configure_lists(plan);
    leave_out_stages(plan);
    configure_tests(plan);
    configure_codes(plan);
    configure_opengl(plan);
    list_kernels(plan);
    return check_capacities(plan);
}

void svo_i_plan_test_defines(const svo_plan *plan, svo_i_test test, char *defines, size_t bytes)
{
    static const char *const names[SVO_I_TEST_COUNT] = {" -DSVO_NO_TEST", " -DSVO_NARROW", "", " -DSVO_WIDE"};
    (void)snprintf(defines, bytes, "%s%s%s%s", names[test], plan->work.long_codes ? " -DSVO_CODE48" : "",
                   plan->info.coverage == SVO_COVERAGE_THIN ? " -DSVO_THIN" : "",
                   plan->device->cpu_path ? " -DSVO_COLUMN_LANES" : "");
}

/* Every option begins with a space, because some compilers fail on options that end in one. */
void svo_i_plan_defines(const svo_plan *plan, const svo_i_program *program, char *defines, size_t bytes)
{
    (void)snprintf(defines, bytes, "%s", plan->work.long_codes ? " -DSVO_CODE48" : "");
    for (size_t i = 0; i < plan->stage_count; ++i) {
        const svo_i_stage *stage = &plan->stages[i];
        if (stage->program == program && stage->defines != NULL && stage->runs(plan)) {
            const size_t used = strlen(defines);
            stage->defines(plan, defines + used, bytes - used);
        }
    }
}

int svo_plan_has_stage(const svo_plan *plan, svo_stage stage)
{
    if (stage == SVO_STAGE_GRID || stage == SVO_STAGE_COMPILE || stage == SVO_STAGE_TRANSFER) {
        return 1; /* part of every build */
    }
    for (size_t i = 0; i < plan->stage_count; ++i) {
        if (plan->stages[i].stage == stage && plan->stages[i].runs(plan)) {
            return 1;
        }
    }
    return 0;
}

svo_status svo_plan_get_kernels(const svo_plan *plan, size_t index, svo_kernels_info *info)
{
    static const char function[] = "svo_plan_get_kernels";
    if (index >= plan->work.kernels_count) {
        return svo_i_device_fail(plan->device, SVO_INVALID_ARGUMENT, "%s: index %zu is not below %zu", function, index,
                                 (size_t)plan->work.kernels_count);
    }
    const svo_kernels_info found = {.name = plan->work.kernels[index].name,
                                    .defines = plan->work.kernels[index].defines};
    return svo_i_struct_write(&plan->device->message, function, "info", &found, info,
                              SVO_I_STRUCT_SIZES(svo_kernels_info, name));
}

svo_status svo_plan_get_left_out(const svo_plan *plan, size_t index, svo_left_out *entry)
{
    static const char function[] = "svo_plan_get_left_out";
    if (index >= plan->work.left_out_count) {
        return svo_i_device_fail(plan->device, SVO_INVALID_ARGUMENT, "%s: index %zu is not below %zu", function, index,
                                 (size_t)plan->work.left_out_count);
    }
    const svo_left_out found = {.what = plan->work.left_out[index].what,
                                .reason = plan->work.left_out[index].reason.text};
    return svo_i_struct_write(&plan->device->message, function, "entry", &found, entry,
                              SVO_I_STRUCT_SIZES(svo_left_out, what));
}
