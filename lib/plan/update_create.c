/* SPDX-License-Identifier: MIT */
/*
 * Makes updatable plans: buffers with room for every triangle of every class, the arrays that do not move, and then the
 * mesh by the launches of an update, so that a new plan and an updated one are the same.
 */
#include "plan/update_create.h"

#include <math.h>
#include <string.h>

#include "plan/attributes.h"
#include "plan/estimate.h"
#include "plan/grid.h"
#include "plan/host_copy.h"
#include "plan/programs.h"

/* Items of all classes are numbered in 32 bits. */
#define TRIANGLES_MAX (1u << 29)
/* Meshes grow by less than this from the first, if max_area is not given. */
#define AREA_MARGIN 4.0

static svo_status refuse(const svo_plan *plan, const char *reason)
{
    return svo_i_device_fail(plan->device, SVO_INVALID_ARGUMENT, "%s: options.updatable requires %s",
                             plan->progress.function, reason);
}

static svo_status check_request(const svo_plan *plan, const svo_mesh *mesh)
{
    if (!(plan->options.edge > 0.0)) {
        return refuse(plan, "a grid of the caller's, and options.edge is 0");
    }
    if (mesh->vertex_count == 0 || mesh->triangle_count == 0 || mesh->triangle_count > TRIANGLES_MAX) {
        return refuse(plan, "1 .. 2^29 triangles and their vertices");
    }
    if (plan->options.weight_log2 > SVO_I_WEIGHT_LOG2_MAX) {
        return refuse(plan, "options.weight_log2 of at most 30");
    }
    return SVO_OK;
}

/* Whether triangles can be of a class; grid.c explains the classes. */
static bool can_have(const svo_plan *plan, svo_i_class class_id)
{
    switch (class_id) {
    case SVO_I_CLASS_POINT:
        return plan->info.coverage != SVO_COVERAGE_THIN;
    case SVO_I_CLASS_NARROW:
        return plan->voxel_log2 < 14;
    case SVO_I_CLASS_REGULAR:
        return plan->info.snap_bits <= 20;
    default:
        return true;
    }
}

static void place_classes(svo_plan *plan)
{
    for (unsigned c = 0; c < SVO_I_CLASS_COUNT; ++c) {
        const uint32_t room = can_have(plan, (svo_i_class)c) ? plan->triangle_count : 0;
        plan->update->grid.params.class_begin[c] = plan->class_begin[c];
        plan->class_begin[c + 1] = plan->class_begin[c] + room;
    }
}

/* ---- buffers ---- */

/* Replaces an array of the input, NULL allowed, by a copy. */
static svo_status own(svo_i_device_work *work, cl_mem from, uint64_t bytes, cl_mem *to)
{
    if (from == NULL) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_work_result(work, "plan_mesh", bytes, to));
    return svo_i_work_copy(work, from, 0, *to, 0, bytes);
}

static svo_status own_mesh(svo_plan *plan, svo_i_device_work *work, const svo_i_device_mesh *mesh, bool is_double)
{
    svo_i_device_mesh *to = &plan->update->mesh;
    const uint64_t vertices = plan->vertex_count;
    const uint64_t triangles = plan->triangle_count;
    SVO_I_TRY(own(work, mesh->positions, vertices * (is_double ? 24 : 12), &to->positions));
    SVO_I_TRY(own(work, mesh->indices, triangles * 12, &to->indices));
    SVO_I_TRY(own(work, mesh->normals, vertices * 12, &to->normals));
    SVO_I_TRY(own(work, mesh->triangle_materials, triangles * 2, &to->triangle_materials));
    return own(work, mesh->colors, vertices * 4, &plan->memory.colors);
}

/* An array of the plan, at first zero: what keep has not written yet must be in range. */
static svo_status make_zeroed(svo_i_device_work *work, const char *name, uint64_t bytes, cl_mem *out)
{
    SVO_I_TRY(svo_i_work_result(work, name, bytes, out));
    return svo_i_work_fill_zero(work, *out, bytes);
}

static svo_status make_arrays(svo_plan *plan, svo_i_device_work *work)
{
    svo_i_update *update = plan->update;
    svo_i_plan_memory *memory = &plan->memory;
    const uint64_t triangles = plan->triangle_count;
    const uint64_t items = plan->class_begin[SVO_I_CLASS_COUNT];
    update->grid.work = work;
    SVO_I_TRY(svo_i_grid_alloc(&update->grid));
    SVO_I_TRY(svo_i_work_result(work, "plan_kept", plan->vertex_count, &update->grid.kept));
    SVO_I_TRY(svo_i_work_result(work, "plan_sums", SVO_PLAN_SUMS * sizeof(cl_ulong), &update->sums));
    SVO_I_TRY(svo_i_work_result(work, "plan_error", sizeof(cl_ulong), &update->error));
    if ((plan->options.need & SVO_NEED_PROJECTED_AREA) != 0) {
        update->sums_edges = true;
        SVO_I_TRY(svo_i_grid_alloc_edges(&update->grid));
        SVO_I_TRY(svo_i_work_result(work, "plan_edges", sizeof(svo_i_edge_sums), &update->edges));
    }
    SVO_I_TRY(make_zeroed(work, "plan_indices", triangles * 12, &memory->indices));
    SVO_I_TRY(make_zeroed(work, "plan_triangle_ids", triangles * 4, &memory->triangle_ids));
    SVO_I_TRY(svo_i_work_result(work, "plan_items", (items + 1) * sizeof(svo_draw_item), &memory->items));
    return svo_i_work_result(work, "plan_item_fragments", items * 4, &memory->item_fragments);
}

/* ---- attributes ---- */

/* Which materials have a texture, and room for the kernel's marks. */
static svo_status mark_materials(svo_plan *plan, svo_i_device_work *work, const svo_mesh *mesh, bool has_uvs)
{
    svo_i_material_marks *marks = &plan->update->marks;
    const uint32_t count = plan->material_count;
    uint8_t *textured = svo_i_alloc_zeroed(&plan->device->memory, count, 1);
    if (textured == NULL) {
        return svo_i_device_fail(plan->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %u materials", work->function,
                                 count);
    }
    svo_status status = SVO_OK;
    for (uint32_t i = 0; i < count; ++i) {
        textured[i] = (plan->info.need & SVO_NEED_COLOR) != 0 && svo_i_material_is_textured(mesh, has_uvs, i) ? 1 : 0;
    }
    SVO_I_TRY_CLEANUP(svo_i_work_result(work, "plan_materials", count, &marks->used));
    SVO_I_TRY_CLEANUP(svo_i_work_result(work, "plan_textured", count, &marks->textured));
    SVO_I_TRY_CLEANUP(svo_i_work_write(work, marks->textured, textured, count));
cleanup:
    svo_i_free(textured);
    return status;
}

/* The materials and textures, as if triangles had them all: nothing is left out. */
static svo_status copy_materials(svo_plan *plan, const svo_mesh *mesh, bool has_uvs)
{
    uint8_t *used = svo_i_alloc(&plan->device->memory, plan->material_count);
    if (used == NULL) {
        return svo_i_device_fail(plan->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %u materials",
                                 plan->progress.function, plan->material_count);
    }
    memset(used, 1, plan->material_count);
    const svo_status status = svo_i_plan_copy_materials(plan, mesh, has_uvs, used);
    svo_i_free(used);
    return status;
}

static svo_status make_attributes(svo_plan *plan, svo_i_device_work *work, const svo_i_plan_input *input, cl_mem uvs)
{
    svo_i_plan_memory *memory = &plan->memory;
    const uint64_t vertices = plan->vertex_count;
    if ((plan->info.need & SVO_I_NEED_PAYLOAD) == 0) {
        return SVO_OK;
    }
    if ((plan->info.need & SVO_NEED_COLOR) != 0) {
        SVO_I_TRY(copy_materials(plan, &input->mesh, uvs != NULL));
    }
    if (plan->textures_used > 0) {
        SVO_I_TRY(svo_i_work_result(work, "plan_uvs", vertices * 8, &memory->uvs));
        SVO_I_TRY(svo_i_launch_uvs(work, uvs, memory->uvs, vertices * 2));
    }
    if (plan->update->mesh.normals != NULL) {
        SVO_I_TRY(svo_i_work_result(work, "plan_normals", vertices * 8, &memory->normals));
    }
    SVO_I_TRY(svo_i_work_result(work, "plan_records", (uint64_t)plan->triangle_count * sizeof(svo_triangle_record),
                                &memory->records));
    return mark_materials(plan, work, &input->mesh, uvs != NULL);
}

/* ---- what the host keeps of the first mesh ---- */

/* The fragment estimate, from which capacities follow. */
static void take_estimate(svo_plan *plan, const uint64_t *totals)
{
    const uint32_t triangles = plan->triangle_count;
    plan->sums =
        (svo_i_sums){totals[SVO_PLAN_SUM_WIDTHS], totals[SVO_PLAN_SUM_AREAS_LOW], totals[SVO_PLAN_SUM_AREAS_HIGH]};
    plan->triangle_count = (uint32_t)plan->update->kept_triangles;
    svo_i_estimate_end(plan);
    plan->triangle_count = triangles;
}

static void choose_weights(svo_plan *plan, const uint64_t *totals)
{
    const svo_plan_options *options = &plan->options;
    const double face = ldexp(1.0, 2 * (int)plan->voxel_log2);
    const double doubled_areas =
        (double)totals[SVO_PLAN_SUM_AREAS_HIGH] * 4294967296.0 + (double)totals[SVO_PLAN_SUM_AREAS_LOW];
    const double total = options->max_area > 0.0 ? options->max_area * sqrt(3.0) * plan->info.scale * plan->info.scale
                                                 : AREA_MARGIN * fmax(0.5 * doubled_areas, face);
    plan->weight_log2 =
        options->weight_log2 != 0 ? options->weight_log2 : svo_i_plan_choose_weight_log2(plan, INFINITY, total);
    plan->info.weight_log2 = (plan->info.need & SVO_I_NEED_PAYLOAD) != 0 ? plan->weight_log2 : 0;
}

static svo_status take_first(svo_plan *plan, svo_i_device_work *work)
{
    svo_i_mesh_totals totals = {.error = 0};
    SVO_I_TRY(svo_i_update_read(plan, work, &totals));
    plan->work.both_sides = svo_i_edges_are_open(&totals.edges);
    plan->update->sums_edges = false;
    choose_weights(plan, totals.sums);
    SVO_I_TRY(svo_i_update_take(plan, work->function, &totals));
    take_estimate(plan, totals.sums);
    plan->update->has_mesh = true;
    return SVO_OK;
}

/* Launches the kernel of builds that is in this program on nothing, since some drivers compile at the first launch. */
static svo_status warm_tiles(svo_plan *plan, svo_i_device_work *work)
{
    const svo_i_plan_memory *memory = &plan->memory;
    const svo_voxelize_params nothing = {.item_count = 0};
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(memory->vertices),
                                        SVO_I_ARGUMENT(memory->indices),
                                        SVO_I_ARGUMENT(memory->items),
                                        SVO_I_ARGUMENT(plan->update->sums),
                                        SVO_I_ARGUMENT(plan->update->error),
                                        SVO_I_ARGUMENT(plan->update->error),
                                        SVO_I_ARGUMENT(nothing)};
    return svo_i_work_launch(work, "svo_k_plan_tiles", SVO_I_ARGUMENTS(arguments), plan->triangle_count);
}

/* ---- all of it ---- */

static svo_status begin(svo_plan *plan, const svo_mesh *mesh)
{
    const svo_i_bounds none = {.any = false};
    SVO_I_TRY(check_request(plan, mesh));
    plan->update = svo_i_alloc_zeroed(&plan->device->memory, 1, sizeof *plan->update);
    if (plan->update == NULL) {
        return svo_i_device_fail(plan->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for updates",
                                 plan->progress.function);
    }
    plan->vertex_count = (uint32_t)mesh->vertex_count;
    plan->triangle_count = (uint32_t)mesh->triangle_count;
    plan->info.triangles = mesh->triangle_count;
    plan->info.updatable = 1;
    plan->materials_vary = true;
    return svo_i_plan_make_grid(plan, &none);
}

/* Fills params of the launches; mesh: has its arrays. */
static void describe(svo_plan *plan, bool is_double)
{
    svo_i_grid_run *grid = &plan->update->grid;
    grid->plan = plan;
    grid->mesh = &plan->update->mesh;
    svo_i_grid_begin(grid, plan->triangle_count, is_double);
    svo_i_grid_place(grid);
    grid->params.flags |= SVO_PLAN_SOME;
    place_classes(plan);
}

svo_status svo_i_update_create(svo_plan *plan, svo_i_device_work *work, const svo_i_plan_input *input,
                               svo_i_device_mesh *mesh)
{
    const bool is_double = input->mesh.positions_double != NULL;
    SVO_I_TRY(begin(plan, &input->mesh));
    SVO_I_TRY(svo_i_work_use(work, &svo_i_program_plan, ""));
    const svo_mesh_buffers *b = input->buffers;
    svo_i_plan_resolve_need(plan, &input->mesh, b != NULL ? b->colors.memory != NULL : input->mesh.colors != NULL);
    SVO_I_TRY(svo_i_device_mesh_geometry(work, input, mesh));
    if ((plan->info.need & SVO_I_NEED_PAYLOAD) != 0) {
        SVO_I_TRY(svo_i_device_mesh_attributes(work, input, plan->info.need, mesh));
    }
    SVO_I_TRY(own_mesh(plan, work, mesh, is_double));
    describe(plan, is_double);
    SVO_I_TRY(make_arrays(plan, work));
    SVO_I_TRY(make_attributes(plan, work, input, mesh->uvs));
    SVO_I_TRY(svo_i_update_run(plan, work));
    SVO_I_TRY(warm_tiles(plan, work));
    return take_first(plan, work);
}
