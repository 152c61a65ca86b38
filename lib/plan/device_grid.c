/* SPDX-License-Identifier: MIT */
/*
 * The first step of the pipeline by kernels (kernels/plan): accepts triangles, fits the grid, snaps vertices, makes the
 * draw items. The host reads three rows of totals: bounds, the snap error, counts and sums.
 */
#include "plan/device_grid.h"

#include <string.h>

#include "plan/estimate.h"
#include "plan/grid.h"
#include "plan/progress.h"

#define RUN (SVO_SCAN_TILE / SVO_GROUP_ITEMS)

/* Local memory of a work-group: one number of 64 bits per work-item. */
#define SCRATCH_BYTES (sizeof(cl_ulong) * SVO_GROUP_ITEMS)

uint32_t svo_i_run_groups(uint64_t elements)
{
    const uint32_t tile = SVO_SCAN_TILE;
    return (uint32_t)((elements + tile - 1) / tile);
}

uint64_t svo_i_run_items(uint64_t elements)
{
    return (elements + RUN - 1) / RUN;
}

svo_status svo_i_run_reduce(svo_i_device_work *work, cl_mem partials, uint64_t elements, uint32_t columns, bool largest,
                            cl_mem totals)
{
    const svo_plan_total_params params = {svo_i_run_groups(elements), columns, largest ? 1u : 0u, 0};
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(partials), SVO_I_ARGUMENT(totals), SVO_I_ARGUMENT(params),
                                        SVO_I_LOCAL(SCRATCH_BYTES)};
    return svo_i_work_launch(work, "svo_k_plan_totals", SVO_I_ARGUMENTS(arguments), SVO_GROUP_ITEMS);
}

svo_status svo_i_run_totals(svo_i_device_work *work, cl_mem partials, uint64_t elements, uint32_t columns, bool largest,
                            uint64_t *out)
{
    cl_mem totals = NULL;
    memset(out, 0, columns * sizeof *out);
    if (elements == 0) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_work_result(work, "totals", columns * sizeof(cl_ulong), &totals));
    svo_status status = svo_i_run_reduce(work, partials, elements, columns, largest, totals);
    if (status == SVO_OK) {
        status = svo_i_work_read(work, totals, 0, out, columns * sizeof *out);
    }
    svo_i_buffer_release(&totals);
    return status;
}

static void put_double(double x, cl_uint words[2])
{
    uint64_t bits = 0;
    memcpy(&bits, &x, sizeof bits);
    words[0] = (cl_uint)(bits & UINT32_MAX);
    words[1] = (cl_uint)(bits >> 32);
}

static double double_of(uint64_t bits)
{
    double x = 0.0;
    memcpy(&x, &bits, sizeof x);
    return x;
}

/* The double of a key of kernels/plan/snap.cl. */
static double double_of_key(uint64_t key)
{
    const uint64_t sign = UINT64_C(1) << 63;
    return double_of((key & sign) != 0 ? key ^ sign : ~key);
}

svo_status svo_i_grid_alloc(svo_i_grid_run *r)
{
    const uint64_t vertices = r->params.vertex_count;
    const uint64_t triangles = r->params.triangle_count;
    const uint32_t groups = svo_i_run_groups(vertices > triangles ? vertices : triangles);
    SVO_I_TRY(svo_i_work_result(r->work, "plan_used", vertices, &r->used));
    SVO_I_TRY(svo_i_work_result(r->work, "plan_fates", triangles * sizeof(cl_ushort), &r->fates));
    SVO_I_TRY(svo_i_work_result(r->work, "plan_fragments", triangles * 4, &r->fragments));
    SVO_I_TRY(
        svo_i_work_result(r->work, "plan_partials", (uint64_t)groups * SVO_PLAN_SUMS * sizeof(cl_ulong), &r->partials));
    return svo_i_work_result(r->work, "plan_vertices", vertices * 12, &r->plan->memory.vertices);
}

svo_status svo_i_grid_accept(svo_i_grid_run *r)
{
    SVO_I_TRY(svo_i_work_fill_zero(r->work, r->used, r->params.vertex_count));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(r->mesh->positions), SVO_I_ARGUMENT(r->mesh->indices),
                                        SVO_I_ARGUMENT(r->used), SVO_I_ARGUMENT(r->params)};
    return svo_i_work_launch(r->work, "svo_k_plan_accept", SVO_I_ARGUMENTS(arguments),
                             svo_i_run_items(r->params.triangle_count));
}

void svo_i_grid_place(svo_i_grid_run *r)
{
    for (unsigned axis = 0; axis < 3; ++axis) {
        put_double(r->plan->info.origin[axis], r->params.origin + (size_t)axis * 2);
    }
    put_double(r->plan->info.scale, r->params.scale);
}

/* Finds the bounds of the used vertices, if the grid depends on them, and makes the grid. */
static svo_status fit(svo_i_grid_run *r)
{
    uint64_t keys[6] = {0};
    svo_i_bounds bounds = {.any = false};
    if (!(r->plan->options.edge > 0.0)) {
        const svo_i_argument arguments[] = {SVO_I_ARGUMENT(r->mesh->positions), SVO_I_ARGUMENT(r->used),
                                            SVO_I_ARGUMENT(r->partials), SVO_I_ARGUMENT(r->params),
                                            SVO_I_LOCAL(SCRATCH_BYTES)};
        SVO_I_TRY(svo_i_work_launch(r->work, "svo_k_plan_bounds", SVO_I_ARGUMENTS(arguments),
                                    svo_i_run_items(r->params.vertex_count)));
        SVO_I_TRY(svo_i_run_totals(r->work, r->partials, r->params.vertex_count, 6, true, keys));
    }
    bounds.any = keys[0] != 0;
    for (unsigned axis = 0; axis < 3 && bounds.any; ++axis) {
        bounds.low[axis] = -double_of_key(keys[axis]);
        bounds.high[axis] = double_of_key(keys[axis + 3]);
    }
    SVO_I_TRY(svo_i_plan_make_grid(r->plan, &bounds));
    svo_i_grid_place(r);
    return SVO_OK;
}

svo_status svo_i_grid_snap(svo_i_grid_run *r)
{
    const svo_i_argument arguments[] = {
        SVO_I_ARGUMENT(r->mesh->positions), SVO_I_ARGUMENT(r->used),   SVO_I_ARGUMENT(r->plan->memory.vertices),
        SVO_I_ARGUMENT(r->partials),        SVO_I_ARGUMENT(r->params), SVO_I_LOCAL(SCRATCH_BYTES)};
    return svo_i_work_launch(r->work, "svo_k_plan_snap", SVO_I_ARGUMENTS(arguments),
                             svo_i_run_items(r->params.vertex_count));
}

static svo_status snap(svo_i_grid_run *r)
{
    uint64_t largest = 0;
    SVO_I_TRY(svo_i_grid_snap(r));
    SVO_I_TRY(svo_i_run_totals(r->work, r->partials, r->params.vertex_count, 1, true, &largest));
    r->plan->info.snap_error = double_of(largest);
    return SVO_OK;
}

/* Takes the counts and sums of all triangles into the plan. */
static void take_totals(svo_i_grid_run *r)
{
    svo_plan *plan = r->plan;
    const uint64_t *totals = r->totals;
    for (unsigned c = 0; c < SVO_I_CLASS_COUNT; ++c) {
        r->params.class_begin[c] = plan->class_begin[c];
        plan->class_begin[c + 1] = plan->class_begin[c] + (uint32_t)totals[c];
    }
    plan->triangle_count = plan->class_begin[SVO_I_CLASS_COUNT];
    plan->info.refused_triangles = totals[SVO_FATE_REFUSED] + totals[SVO_FATE_FAR];
    plan->info.outside_triangles = totals[SVO_FATE_OUTSIDE];
    plan->sums =
        (svo_i_sums){totals[SVO_PLAN_SUM_WIDTHS], totals[SVO_PLAN_SUM_AREAS_LOW], totals[SVO_PLAN_SUM_AREAS_HIGH]};
    plan->large_count = (uint32_t)totals[SVO_PLAN_SUM_LARGE];
    svo_i_estimate_end(plan);
    r->params.flags |= plan->triangle_count < r->params.triangle_count ? SVO_PLAN_SOME : 0u;
}

svo_status svo_i_grid_classify(svo_i_grid_run *r)
{
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(r->plan->memory.vertices),
                                        SVO_I_ARGUMENT(r->mesh->indices),
                                        SVO_I_ARGUMENT(r->used),
                                        SVO_I_ARGUMENT(r->fates),
                                        SVO_I_ARGUMENT(r->fragments),
                                        SVO_I_ARGUMENT(r->partials),
                                        SVO_I_ARGUMENT(r->params),
                                        SVO_I_LOCAL(SCRATCH_BYTES)};
    return svo_i_work_launch(r->work, "svo_k_plan_classify", SVO_I_ARGUMENTS(arguments),
                             svo_i_run_items(r->params.triangle_count));
}

static svo_status classify(svo_i_grid_run *r)
{
    SVO_I_TRY(svo_i_grid_classify(r));
    SVO_I_TRY(svo_i_run_totals(r->work, r->partials, r->params.triangle_count, SVO_PLAN_SUMS, false, r->totals));
    take_totals(r);
    return SVO_OK;
}

svo_status svo_i_grid_alloc_edges(svo_i_grid_run *r)
{
    const uint64_t rows = svo_i_run_groups(r->params.triangle_count);
    return svo_i_work_result(r->work, "plan_edges", rows * sizeof(svo_i_edge_sums), &r->edges);
}

svo_status svo_i_grid_sum_edges(svo_i_grid_run *r)
{
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(r->plan->memory.vertices),
                                        SVO_I_ARGUMENT(r->mesh->indices),
                                        SVO_I_ARGUMENT(r->fates),
                                        SVO_I_ARGUMENT(r->edges),
                                        SVO_I_ARGUMENT(r->params),
                                        SVO_I_LOCAL(SCRATCH_BYTES)};
    return svo_i_work_launch(r->work, "svo_k_plan_closed", SVO_I_ARGUMENTS(arguments),
                             svo_i_run_items(r->params.triangle_count));
}

/* For projected areas: whether the edges cancel. */
static svo_status find_closed(svo_i_grid_run *r)
{
    svo_i_edge_sums sums = {{0}};
    SVO_I_TRY(svo_i_grid_alloc_edges(r));
    SVO_I_TRY(svo_i_grid_sum_edges(r));
    SVO_I_TRY(svo_i_run_totals(r->work, r->edges, r->params.triangle_count, 2, false, sums.words));
    r->plan->work.both_sides = svo_i_edges_are_open(&sums);
    return SVO_OK;
}

static svo_status alloc_kept(svo_i_grid_run *r)
{
    svo_i_plan_memory *memory = &r->plan->memory;
    const uint64_t count = r->plan->triangle_count;
    const cl_uint kept_bytes = (r->params.flags & SVO_PLAN_SOME) != 0 ? r->params.vertex_count : 0;
    SVO_I_TRY(svo_i_work_result(r->work, "plan_indices", count * 12, &memory->indices));
    SVO_I_TRY(svo_i_work_result(r->work, "plan_triangle_ids", count * 4, &memory->triangle_ids));
    SVO_I_TRY(svo_i_work_result(r->work, "plan_items", count * sizeof(svo_draw_item), &memory->items));
    SVO_I_TRY(svo_i_work_result(r->work, "plan_item_fragments", count * 4, &memory->item_fragments));
    SVO_I_TRY(svo_i_work_result(r->work, "plan_large", r->plan->large_count * sizeof(svo_large_item), &r->large));
    SVO_I_TRY(svo_i_work_result(r->work, "plan_large_count", sizeof(cl_uint), &r->large_count));
    SVO_I_TRY(svo_i_work_fill_zero(r->work, r->large_count, sizeof(cl_uint)));
    SVO_I_TRY(svo_i_work_result(r->work, "plan_kept", kept_bytes, &r->kept));
    return svo_i_work_fill_zero(r->work, r->kept, kept_bytes);
}

svo_status svo_i_grid_keep(svo_i_grid_run *r)
{
    const svo_i_plan_memory *memory = &r->plan->memory;
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(memory->vertices),
                                        SVO_I_ARGUMENT(r->mesh->indices),
                                        SVO_I_ARGUMENT(r->fates),
                                        SVO_I_ARGUMENT(r->fragments),
                                        SVO_I_ARGUMENT(r->partials),
                                        SVO_I_ARGUMENT(memory->indices),
                                        SVO_I_ARGUMENT(memory->triangle_ids),
                                        SVO_I_ARGUMENT(memory->items),
                                        SVO_I_ARGUMENT(memory->item_fragments),
                                        SVO_I_ARGUMENT(r->large),
                                        SVO_I_ARGUMENT(r->large_count),
                                        SVO_I_ARGUMENT(r->kept),
                                        SVO_I_ARGUMENT(r->params),
                                        SVO_I_LOCAL(SCRATCH_BYTES),
                                        SVO_I_LOCAL(sizeof(cl_ushort) * SVO_SIZE_COUNT * SVO_SIZE_PITCH)};
    SVO_I_TRY(svo_i_work_launch(r->work, "svo_k_plan_keep", SVO_I_ARGUMENTS(arguments),
                                svo_i_run_items(r->params.triangle_count)));
    if ((r->params.flags & SVO_PLAN_SOME) == 0) {
        return SVO_OK;
    }
    const svo_i_argument clear[] = {SVO_I_ARGUMENT(r->kept), SVO_I_ARGUMENT(memory->vertices),
                                    SVO_I_ARGUMENT(r->params)};
    return svo_i_work_launch(r->work, "svo_k_plan_clear", SVO_I_ARGUMENTS(clear), r->params.vertex_count);
}

/* The mesh's own positions of the vertices that kept triangles use, for rays; positions.c has it for the host. */
svo_status svo_i_grid_keep_positions(svo_i_grid_run *r)
{
    const bool is_double = (r->params.flags & SVO_PLAN_DOUBLES) != 0;
    svo_i_plan_memory *memory = &r->plan->memory;
    cl_mem *positions = is_double ? &memory->positions_double : &memory->positions;
    const cl_mem marks = (r->params.flags & SVO_PLAN_SOME) != 0 ? r->kept : r->used;
    if ((r->plan->options.need & SVO_NEED_RAYS) == 0 || r->plan->info.coverage == SVO_COVERAGE_THIN) {
        return SVO_OK;
    }
    if (*positions == NULL) {
        SVO_I_TRY(svo_i_work_result(r->work, "plan_positions", (uint64_t)r->params.vertex_count * (is_double ? 24 : 12),
                                    positions));
    }
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(r->mesh->positions), SVO_I_ARGUMENT(marks),
                                        SVO_I_ARGUMENT(*positions), SVO_I_ARGUMENT(r->params)};
    return svo_i_work_launch(r->work, "svo_k_plan_positions", SVO_I_ARGUMENTS(arguments), r->params.vertex_count);
}

static int compare_items(const void *a, const void *b)
{
    const uint32_t x = ((const svo_large_item *)a)->item;
    const uint32_t y = ((const svo_large_item *)b)->item;
    return x < y ? -1 : x > y ? 1 : 0;
}

/* Reads the large triangles, whose order differs from run to run. */
static svo_status read_large(svo_i_grid_run *r)
{
    svo_plan *plan = r->plan;
    const size_t bytes = plan->large_count * sizeof *plan->large;
    plan->large = svo_i_alloc(&plan->device->memory, bytes + sizeof *plan->large);
    if (plan->large == NULL) {
        return svo_i_device_fail(plan->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %u triangles",
                                 r->work->function, plan->large_count);
    }
    SVO_I_TRY(svo_i_work_read(r->work, r->large, 0, plan->large, bytes));
    qsort(plan->large, plan->large_count, sizeof *plan->large, compare_items);
    return SVO_OK;
}

static svo_status run_steps(svo_i_grid_run *r)
{
    svo_plan *plan = r->plan;
    SVO_I_TRY(svo_i_grid_alloc(r));
    SVO_I_TRY(svo_i_grid_accept(r));
    SVO_I_TRY(fit(r));
    SVO_I_TRY(snap(r));
    (void)svo_i_progress_add(plan, SVO_STAGE_GRID, SVO_I_SNAP_NS * (double)r->params.vertex_count);
    SVO_I_TRY(svo_i_progress_tell(plan, SVO_STAGE_GRID));
    SVO_I_TRY(classify(r));
    if ((plan->options.need & SVO_NEED_PROJECTED_AREA) != 0) {
        SVO_I_TRY(find_closed(r));
    }
    SVO_I_TRY(alloc_kept(r));
    SVO_I_TRY(svo_i_grid_keep(r));
    SVO_I_TRY(svo_i_grid_keep_positions(r));
    SVO_I_TRY(read_large(r));
    (void)svo_i_progress_add(plan, SVO_STAGE_GRID, SVO_I_KEEP_NS * (double)r->params.triangle_count);
    return svo_i_progress_tell(plan, SVO_STAGE_GRID);
}

void svo_i_grid_begin(svo_i_grid_run *r, uint64_t triangles, bool is_double)
{
    const svo_plan *plan = r->plan;
    r->params = (svo_plan_params){.vertex_count = plan->vertex_count,
                                  .triangle_count = (cl_uint)triangles,
                                  .snap_bits = plan->info.snap_bits,
                                  .voxel_log2 = plan->voxel_log2};
    r->params.flags = (r->mesh->indices != NULL ? SVO_PLAN_INDEXED : 0u) | (is_double ? SVO_PLAN_DOUBLES : 0u) |
                      (plan->info.coverage == SVO_COVERAGE_CLOSED ? SVO_PLAN_CLOSED : 0u) |
                      (plan->info.coverage == SVO_COVERAGE_THIN ? SVO_PLAN_THIN : 0u);
}

void svo_i_grid_end(svo_i_grid_run *r)
{
    cl_mem *buffers[] = {&r->used,     &r->kept,  &r->fates,       &r->fragments,
                         &r->partials, &r->large, &r->large_count, &r->edges};
    for (unsigned i = 0; i < sizeof buffers / sizeof buffers[0]; ++i) {
        svo_i_buffer_release(buffers[i]);
    }
}

svo_status svo_i_device_grid(svo_plan *plan, svo_i_device_work *work, const svo_i_plan_input *input,
                             const svo_i_device_mesh *mesh)
{
    const svo_mesh *given = &input->mesh;
    svo_i_grid_run r = {.plan = plan, .work = work, .mesh = mesh};
    plan->vertex_count = (uint32_t)given->vertex_count;
    plan->info.triangles = given->triangle_count;
    svo_i_grid_begin(&r, given->triangle_count, given->positions_double != NULL);
    const svo_status status = run_steps(&r);
    svo_i_grid_end(&r);
    return status;
}
