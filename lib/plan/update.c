/* SPDX-License-Identifier: MIT */
/*
 * Updates of plans: new positions of the same topology, by launches alone. Commands that read or write a plan's arrays,
 * updates and builds, form a chain of events, so that any queues will do.
 */
#include "plan/update.h"

#include <math.h>
#include <string.h>

#include "core/mesh.h"
#include "core/struct_size.h"
#include "plan/attributes.h"

/* ---- launches ---- */

/* Empties what keep does not write. */
static svo_status clear(svo_plan *plan, svo_i_device_work *work)
{
    static const svo_draw_item nothing = {0, SVO_DRAW_NOTHING};
    const svo_i_plan_memory *memory = &plan->memory;
    const uint64_t items = plan->class_begin[SVO_I_CLASS_COUNT];
    SVO_I_TRY(svo_i_work_fill_pattern(work, memory->items, &nothing, sizeof nothing, (items + 1) * sizeof nothing));
    SVO_I_TRY(svo_i_work_fill_zero(work, memory->item_fragments, items * sizeof(cl_float)));
    return svo_i_work_fill_zero(work, plan->update->grid.kept, plan->vertex_count);
}

static svo_status sum_edges(svo_plan *plan, svo_i_device_work *work)
{
    svo_i_update *update = plan->update;
    SVO_I_TRY(svo_i_grid_sum_edges(&update->grid));
    return svo_i_run_reduce(work, update->grid.edges, plan->triangle_count, 2, false, update->edges);
}

svo_status svo_i_update_run(svo_plan *plan, svo_i_device_work *work)
{
    svo_i_update *update = plan->update;
    svo_i_grid_run *grid = &update->grid;
    grid->work = work;
    SVO_I_TRY(svo_i_grid_accept(grid));
    SVO_I_TRY(svo_i_grid_snap(grid));
    SVO_I_TRY(svo_i_run_reduce(work, grid->partials, plan->vertex_count, 1, true, update->error));
    SVO_I_TRY(svo_i_grid_classify(grid));
    SVO_I_TRY(svo_i_run_reduce(work, grid->partials, plan->triangle_count, SVO_PLAN_SUMS, false, update->sums));
    SVO_I_TRY(update->sums_edges ? sum_edges(plan, work) : SVO_OK);
    SVO_I_TRY(clear(plan, work));
    SVO_I_TRY(svo_i_grid_keep(grid));
    SVO_I_TRY(svo_i_grid_keep_positions(grid));
    if (plan->memory.normals != NULL) {
        SVO_I_TRY(svo_i_launch_normals(work, update->mesh.normals, plan->memory.normals, plan->vertex_count));
    }
    return plan->memory.records != NULL
               ? svo_i_launch_records(work, plan, &update->mesh, &update->marks, grid->partials)
               : SVO_OK;
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
    memcpy(&info->snap_error, &totals->error, sizeof info->snap_error);
    info->area = 0.5 * doubled_areas / (info->scale * info->scale * sqrt(3.0));
    return svo_i_update_check_area(plan, function, info->area);
}

svo_status svo_i_update_read(const svo_plan *plan, svo_i_device_work *work, svo_i_mesh_totals *totals)
{
    const svo_i_update *update = plan->update;
    SVO_I_TRY(svo_i_work_read(work, update->sums, 0, totals->sums, sizeof totals->sums));
    SVO_I_TRY(svo_i_work_read(work, update->error, 0, &totals->error, sizeof totals->error));
    return update->sums_edges ? svo_i_work_read(work, update->edges, 0, &totals->edges, sizeof totals->edges) : SVO_OK;
}

svo_status svo_i_update_settle(svo_plan *plan, const char *function, cl_command_queue queue)
{
    svo_i_mesh_totals totals = {.error = 0};
    svo_i_device_work work = {.device = plan->device, .function = function, .queue = queue};
    const cl_event newest = svo_i_in_flight_newest(&plan->update->commands);
    work.wait_count = newest != NULL ? 1 : 0;
    work.wait = newest != NULL ? &newest : NULL;
    const svo_status status = svo_i_update_read(plan, &work, &totals);
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

uint64_t svo_i_update_tiles_max(uint64_t fragment_capacity)
{
    return fragment_capacity / 4 + 256;
}

void svo_i_update_destroy(svo_i_update *update)
{
    if (update == NULL) {
        return;
    }
    svo_i_in_flight_end(&update->commands);
    svo_i_grid_end(&update->grid);
    svo_i_device_mesh_free(&update->mesh);
    cl_mem *buffers[] = {&update->marks.textured, &update->marks.used, &update->sums, &update->error, &update->edges};
    for (size_t i = 0; i < sizeof buffers / sizeof buffers[0]; ++i) {
        svo_i_buffer_release(buffers[i]);
    }
    svo_i_free(update);
}

/* ---- updates ---- */

/* New vertices, in one of the two forms. */
typedef struct vertices {
    svo_mesh mesh;
    const svo_mesh_buffers *buffers; /* NULL: the arrays are the mesh's */
} vertices;

static svo_status check_vertices(svo_plan *plan, const char *function, const vertices *from)
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
static svo_status copy_vertices(const svo_plan *plan, svo_i_device_work *work, const vertices *from)
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

static svo_status enqueue(svo_plan *plan, svo_i_device_work *work, const vertices *from)
{
    SVO_I_TRY(svo_i_work_use(work, SVO_I_PROGRAM_PLAN, ""));
    SVO_I_TRY(wait_first(plan, work));
    SVO_I_TRY(copy_vertices(plan, work, from));
    SVO_I_TRY(svo_i_update_run(plan, work));
    SVO_I_TRY(svo_i_in_flight_add(&plan->update->commands, plan->device, work->function, work->last));
    const cl_int error = clFlush(work->queue);
    return error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(plan->device, work->function, "clFlush", error);
}

static svo_status update_plan(svo_plan *plan, svo_i_device_work *work, const vertices *from, cl_event *event)
{
    work->device = plan->device;
    SVO_I_TRY(check_vertices(plan, work->function, from));
    SVO_I_TRY(svo_i_device_check_wait(plan->device, work->function, work->wait_count, work->wait));
    plan->update->has_mesh = false; /* until all commands are enqueued */
    const svo_status status = enqueue(plan, work, from);
    if (status != SVO_OK) {
        svo_i_work_end(work); /* commands that were enqueued may read the caller's arrays */
        return status;
    }
    plan->update->has_mesh = true;
    svo_i_work_leave(work, event);
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

svo_status svo_plan_update_enqueue(svo_plan *plan, const svo_mesh *mesh, cl_command_queue queue, cl_uint num_wait,
                                   const cl_event *wait, cl_event *event)
{
    static const char function[] = "svo_plan_update_enqueue";
    vertices from = {.buffers = NULL};
    svo_i_device_work work = {.function = function, .wait_count = num_wait, .wait = wait};
    SVO_I_TRY(check_plan(plan, function, "mesh", mesh));
    SVO_I_TRY(svo_i_struct_read(&plan->device->message, function, "mesh", mesh, &from.mesh,
                                SVO_I_STRUCT_SIZES(svo_mesh, triangle_count)));
    SVO_I_TRY(svo_i_device_queue(plan->device, function, queue, &work.queue));
    return update_plan(plan, &work, &from, event);
}

svo_status svo_plan_update_from_buffers_enqueue(svo_plan *plan, const svo_mesh_buffers *buffers, cl_command_queue queue,
                                                cl_uint num_wait, const cl_event *wait, cl_event *event)
{
    static const char function[] = "svo_plan_update_from_buffers_enqueue";
    svo_mesh_buffers given;
    vertices from = {.buffers = &given};
    svo_i_device_work work = {.function = function, .wait_count = num_wait, .wait = wait};
    SVO_I_TRY(check_plan(plan, function, "buffers", buffers));
    SVO_I_TRY(svo_i_struct_read(&plan->device->message, function, "buffers", buffers, &given,
                                SVO_I_STRUCT_SIZES(svo_mesh_buffers, indices)));
    SVO_I_TRY(svo_i_device_queue(plan->device, function, queue, &work.queue));
    SVO_I_TRY(svo_i_mesh_check(function, plan->device->context, &given, &plan->device->message));
    from.mesh.vertex_count = given.vertex_count;
    from.mesh.triangle_count = given.triangle_count;
    return update_plan(plan, &work, &from, event);
}

svo_status svo_plan_update(svo_plan *plan, const svo_mesh *mesh)
{
    static const char function[] = "svo_plan_update";
    vertices from = {.buffers = NULL};
    svo_i_device_work work = {.function = function};
    cl_event done = NULL;
    SVO_I_TRY(check_plan(plan, function, "mesh", mesh));
    SVO_I_TRY(svo_i_struct_read(&plan->device->message, function, "mesh", mesh, &from.mesh,
                                SVO_I_STRUCT_SIZES(svo_mesh, triangle_count)));
    SVO_I_TRY(svo_i_device_queue(plan->device, function, NULL, &work.queue));
    SVO_I_TRY(update_plan(plan, &work, &from, &done));
    const cl_int error = clWaitForEvents(1, &done);
    if (error != CL_SUCCESS) {
        (void)svo_i_event_settle(done);
        plan->update->has_mesh = false;
    }
    clReleaseEvent(done);
    return error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(plan->device, function, "clWaitForEvents", error);
}
