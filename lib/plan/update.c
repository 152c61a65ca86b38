/* SPDX-License-Identifier: MIT */
/*
 * Updates of plans: new positions of the same topology, by launches alone. Commands that read or write a plan's arrays,
 * updates and builds, form a chain of events, so that any queues will do.
 *
 * A new plan gets buffers with room for every triangle of every class, the arrays that do not move, and then its mesh
 * by the launches of an update, so that a new plan and an updated one are the same.
 */
#include "plan/update.h"

#include <math.h>
#include <string.h>

#include "core/mesh.h"
#include "core/struct_size.h"
#include "core/submit.h"
#include "plan/arrays.h"
#include "plan/attributes.h"
#include "plan/estimate.h"
#include "plan/grid.h"
#include "plan/programs.h"

/* Launches what makes the plan's arrays from update->mesh. Reads nothing back. */
static svo_status run_kernels(svo_plan *plan, svo_i_device_work *work)
{
    svo_i_update *update = plan->update;
    update->grid.work = work;
    return svo_i_device_launch(&update->grid, &update->marks, update->sums_edges ? update->edges : NULL);
}

/* ---- what the host learns ---- */

/* The largest sum of projected areas that the weights have room for, square grid units. */
static double most_area(const svo_plan *plan)
{
    double most = 1.0;
    while (svo_i_plan_choose_weight_log2(plan, INFINITY, most * 0.75) >= plan->weight_log2 && isfinite(most)) {
        most *= 2.0;
    }
    return most * 0.5;
}

svo_status svo_i_update_check_area(const svo_plan *plan, const char *function, double area)
{
    const double unit = 1.0 / (plan->info.scale * plan->info.scale * sqrt(3.0));
    const double total = area / unit;
    if ((plan->info.need & SVO_I_NEED_PAYLOAD) == 0 ||
        svo_i_plan_choose_weight_log2(plan, INFINITY, total) >= plan->weight_log2) {
        return SVO_OK;
    }
    return svo_i_device_fail(plan->device, SVO_CAPACITY_EXCEEDED,
                             "%s: the mesh has an area of at least %g inside the grid, and the plan's unit of weight "
                             "suits %g; see options.max_area",
                             function, area, most_area(plan) * unit);
}

svo_status svo_i_update_take(svo_plan *plan, const char *function, const svo_i_mesh_totals *totals)
{
    svo_plan_info *info = &plan->info;
    const uint64_t *sums = totals->sums;
    const double doubled_areas =
        (double)sums[SVO_PLAN_SUM_AREAS_HIGH] * 4294967296.0 + (double)sums[SVO_PLAN_SUM_AREAS_LOW];
    info->refused_triangles = sums[SVO_FATE_REFUSED] + sums[SVO_FATE_FAR];
    info->outside_triangles = sums[SVO_FATE_OUTSIDE];
    plan->update->kept_triangles = info->triangles - info->refused_triangles - info->outside_triangles;
    plan->update->edge_sums = totals->edges;
    info->area = 0.5 * doubled_areas / (info->scale * info->scale * sqrt(3.0));
    return svo_i_update_check_area(plan, function, info->area);
}

/* Reads what kernels have counted. */
static svo_status read_totals(const svo_plan *plan, svo_i_device_work *work, svo_i_mesh_totals *totals)
{
    const svo_i_update *update = plan->update;
    SVO_I_TRY(svo_i_work_read(work, update->grid.sums, 0, totals->sums, sizeof totals->sums));
    return update->sums_edges ? svo_i_work_read(work, update->edges, 0, &totals->edges, sizeof totals->edges) : SVO_OK;
}

svo_status svo_i_update_settle(svo_plan *plan, const char *function, cl_command_queue queue)
{
    svo_i_mesh_totals totals = {.sums = {0}};
    svo_i_device_work work = {.device = plan->device, .function = function, .queue = queue};
    const cl_event newest = svo_i_in_flight_newest(&plan->update->commands);
    work.wait_count = newest != NULL ? 1 : 0;
    work.wait = newest != NULL ? &newest : NULL;
    const svo_status status = read_totals(plan, &work, &totals);
    svo_i_work_end(&work);
    SVO_I_TRY(status);
    return svo_i_update_take(plan, function, &totals);
}

const char *svo_i_update_wrong(const svo_plan *plan, bool on_device)
{
    if (plan->update == NULL) {
        return NULL;
    }
    if (!on_device) {
        return "plan is updatable, which takes the front end cl";
    }
    return plan->update->has_mesh ? NULL : "the last update of plan failed";
}

void svo_i_update_destroy(svo_i_update *update)
{
    if (update == NULL) {
        return;
    }
    svo_i_in_flight_end(&update->commands);
    svo_i_grid_end(&update->grid);
    svo_i_device_mesh_free(&update->mesh);
    cl_mem *buffers[] = {&update->marks.textured, &update->marks.used, &update->edges};
    for (size_t i = 0; i < sizeof buffers / sizeof buffers[0]; ++i) {
        svo_i_buffer_release(buffers[i]);
    }
    svo_i_free(update);
}

/* ---- updates ---- */

/* New vertices, in one of the two forms. */
typedef struct new_vertices {
    svo_mesh mesh;
    const svo_mesh_buffers *buffers; /* NULL: the arrays are the mesh's */
} new_vertices;

static svo_status check_vertices(svo_plan *plan, const char *function, const new_vertices *from)
{
    const svo_mesh *mesh = &from->mesh;
    const bool wants_doubles = (plan->update->grid.params.flags & SVO_PLAN_DOUBLES) != 0;
    const bool has_positions = from->buffers != NULL ? !wants_doubles
                               : wants_doubles       ? mesh->positions_double != NULL && mesh->positions == NULL
                                                     : mesh->positions != NULL && mesh->positions_double == NULL;
    const bool has_normals = from->buffers != NULL ? from->buffers->normals.memory != NULL : mesh->normals != NULL;
    if (mesh->vertex_count != plan->vertex_count || mesh->triangle_count != plan->triangle_count) {
        return svo_i_device_fail(plan->device, SVO_INVALID_ARGUMENT,
                                 "%s: mesh has %zu vertices and %zu triangles, the plan has %u and %u", function,
                                 mesh->vertex_count, mesh->triangle_count, plan->vertex_count, plan->triangle_count);
    }
    if (!has_positions) {
        return svo_i_device_fail(plan->device, SVO_INVALID_ARGUMENT, "%s: the plan is of positions in %s, mesh is not",
                                 function, wants_doubles ? "doubles" : "floats");
    }
    if (plan->memory.normals != NULL && !has_normals) {
        return svo_i_device_fail(plan->device, SVO_INVALID_ARGUMENT, "%s: the plan reads normals, mesh has none",
                                 function);
    }
    return SVO_OK;
}

/* Enqueues a wait for the caller's events, then for the chain. */
static svo_status wait_first(const svo_plan *plan, svo_i_device_work *work)
{
    SVO_I_TRY(svo_i_in_flight_reserve(&plan->update->commands, plan->device, work->function));
    cl_event newest = svo_i_in_flight_newest(&plan->update->commands);
    cl_event given = NULL;
    cl_int error = work->wait_count > 0 ? clEnqueueMarkerWithWaitList(work->queue, work->wait_count, work->wait, &given)
                                        : CL_SUCCESS;
    if (error == CL_SUCCESS) {
        cl_event both[2];
        cl_uint count = 0;
        if (given != NULL) {
            both[count++] = given;
        }
        if (newest != NULL) {
            both[count++] = newest;
        }
        error = clEnqueueMarkerWithWaitList(work->queue, count, count > 0 ? both : NULL, &work->last);
    }
    if (given != NULL) {
        clReleaseEvent(given);
    }
    return error == CL_SUCCESS
               ? SVO_OK
               : svo_i_device_fail_cl(plan->device, work->function, "clEnqueueMarkerWithWaitList", error);
}

/* Copies the new vertices to the plan's own. */
static svo_status copy_vertices(const svo_plan *plan, svo_i_device_work *work, const new_vertices *from)
{
    const svo_i_device_mesh *to = &plan->update->mesh;
    const uint64_t count = plan->vertex_count;
    const svo_mesh *mesh = &from->mesh;
    if (from->buffers != NULL) {
        SVO_I_TRY(svo_i_plan_copy_view(work, &from->buffers->positions, count, 12, to->positions));
        return to->normals != NULL ? svo_i_plan_copy_view(work, &from->buffers->normals, count, 12, to->normals)
                                   : SVO_OK;
    }
    SVO_I_TRY(mesh->positions != NULL
                  ? svo_i_work_write_later(work, to->positions, mesh->positions, count * 12)
                  : svo_i_work_write_later(work, to->positions, mesh->positions_double, count * 24));
    return to->normals != NULL ? svo_i_work_write_later(work, to->normals, mesh->normals, count * 12) : SVO_OK;
}

static svo_status enqueue(svo_plan *plan, svo_i_device_work *work, const new_vertices *from)
{
    SVO_I_TRY(svo_i_work_use(work, &svo_i_program_plan, ""));
    SVO_I_TRY(wait_first(plan, work));
    SVO_I_TRY(copy_vertices(plan, work, from));
    SVO_I_TRY(run_kernels(plan, work));
    SVO_I_TRY(svo_i_in_flight_add(&plan->update->commands, plan->device, work->function, work->last));
    const cl_int error = clFlush(work->queue);
    return error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(plan->device, work->function, "clFlush", error);
}

static svo_status update_plan(svo_plan *plan, const char *function, const new_vertices *from, const svo_submit *submit)
{
    svo_i_call call;
    SVO_I_TRY(check_vertices(plan, function, from));
    SVO_I_TRY(svo_i_call_begin(plan->device, function, submit, &call));
    svo_i_device_work work = {.device = plan->device,
                              .function = function,
                              .queue = call.queue,
                              .wait_count = call.num_wait,
                              .wait = call.wait};
    plan->update->has_mesh = false; /* until all commands are enqueued */
    const svo_status status = enqueue(plan, &work, from);
    if (status != SVO_OK) {
        svo_i_work_end(&work); /* commands that were enqueued may read the caller's arrays */
        return status;
    }
    svo_i_work_leave(&work, call.event);
    SVO_I_TRY(svo_i_call_end(&call, SVO_OK));
    plan->update->has_mesh = true;
    return SVO_OK;
}

static svo_status check_plan(svo_plan *plan, const char *function, const char *name, const void *mesh)
{
    if (plan == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    if (mesh == NULL) {
        return svo_i_device_fail(plan->device, SVO_INVALID_ARGUMENT, "%s: %s is NULL", function, name);
    }
    return plan->update != NULL ? SVO_OK
                                : svo_i_device_fail(plan->device, SVO_INVALID_ARGUMENT,
                                                    "%s: plan is not updatable; see svo_plan_options", function);
}

svo_status svo_plan_update(svo_plan *plan, const svo_mesh *mesh, const svo_submit *submit)
{
    static const char function[] = "svo_plan_update";
    new_vertices from = {.buffers = NULL};
    SVO_I_TRY(check_plan(plan, function, "mesh", mesh));
    SVO_I_TRY(svo_i_struct_read(&plan->device->message, function, "mesh", mesh, &from.mesh,
                                SVO_I_STRUCT_SIZES(svo_mesh, triangle_count)));
    return update_plan(plan, function, &from, submit);
}

svo_status svo_plan_update_from_buffers(svo_plan *plan, const svo_mesh_buffers *buffers, const svo_submit *submit)
{
    static const char function[] = "svo_plan_update_from_buffers";
    svo_mesh_buffers given;
    new_vertices from = {.buffers = &given};
    SVO_I_TRY(check_plan(plan, function, "buffers", buffers));
    SVO_I_TRY(svo_i_struct_read(&plan->device->message, function, "buffers", buffers, &given,
                                SVO_I_STRUCT_SIZES(svo_mesh_buffers, indices)));
    SVO_I_TRY(svo_i_mesh_check(function, plan->device->context, &given, &plan->device->message));
    from.mesh.vertex_count = given.vertex_count;
    from.mesh.triangle_count = given.triangle_count;
    return update_plan(plan, function, &from, submit);
}

/* ---- a new plan: checks and classes ---- */

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
    case SVO_I_CLASS_REGULAR:
        return plan->info.snap_bits <= SVO_REGULAR_BITS;
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

/* ---- a new plan: buffers ---- */

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
    if ((plan->options.need & SVO_NEED_PROJECTED_AREA) != 0) {
        update->sums_edges = true;
        SVO_I_TRY(svo_i_work_result(work, "plan_edges", sizeof(svo_i_edge_sums), &update->edges));
    }
    SVO_I_TRY(make_zeroed(work, "plan_indices", triangles * 12, &memory->indices));
    SVO_I_TRY(make_zeroed(work, "plan_triangle_ids", triangles * 4, &memory->triangle_ids));
    SVO_I_TRY(svo_i_work_result(work, "plan_items", (items + 1) * sizeof(svo_draw_item), &memory->items));
    return svo_i_work_result(work, "plan_item_fragments", items * 4, &memory->item_fragments);
}

/* ---- a new plan: attributes ---- */

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
        textured[i] =
            (svo_i_plan_reads(plan) & SVO_NEED_COLOR) != 0 && svo_i_material_is_textured(mesh, has_uvs, i) ? 1 : 0;
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
    if (svo_i_plan_reads(plan) == 0) {
        return SVO_OK;
    }
    if ((svo_i_plan_reads(plan) & SVO_NEED_COLOR) != 0) {
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
    SVO_I_TRY(mark_materials(plan, work, &input->mesh, uvs != NULL));
    svo_i_plan_find_dropped(plan, NULL);
    return SVO_OK;
}

/* ---- a new plan: what the host keeps of its mesh ---- */

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
    svo_i_mesh_totals totals = {.sums = {0}};
    SVO_I_TRY(read_totals(plan, work, &totals));
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
                                        SVO_I_ARGUMENT(plan->update->grid.sums),
                                        SVO_I_ARGUMENT(plan->update->grid.sums),
                                        SVO_I_ARGUMENT(plan->update->grid.sums),
                                        SVO_I_ARGUMENT(nothing)};
    return svo_i_work_launch(work, "svo_k_plan_tiles", SVO_I_ARGUMENTS(arguments), plan->triangle_count);
}

/* ---- a new plan: all of it ---- */

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
    if (svo_i_plan_reads(plan) != 0) {
        SVO_I_TRY(svo_i_device_mesh_attributes(work, input, svo_i_plan_reads(plan), mesh));
    }
    SVO_I_TRY(own_mesh(plan, work, mesh, is_double));
    describe(plan, is_double);
    SVO_I_TRY(make_arrays(plan, work));
    SVO_I_TRY(make_attributes(plan, work, input, mesh->uvs));
    SVO_I_TRY(run_kernels(plan, work));
    SVO_I_TRY(warm_tiles(plan, work));
    return take_first(plan, work);
}
