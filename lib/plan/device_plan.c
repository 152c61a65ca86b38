/* SPDX-License-Identifier: MIT */
/*
 * Plans by kernels (kernels/plan): accepts triangles, fits the grid, snaps vertices, makes the draw items and the
 * payload inputs. The host reads rows of totals (bounds, counts and sums), the large triangles, a byte per material,
 * and the first triangle's record and attributes; materials and textures are the host's.
 */
#include "plan/device_plan.h"

#include <stdlib.h>
#include <string.h>

#include "plan/accounts.h"
#include "plan/attributes.h"
#include "plan/estimate.h"
#include "plan/grid.h"
#include "plan/programs.h"

/* ---- the grid ---- */

#define RUN (SVO_SCAN_TILE / SVO_GROUP_ITEMS)

/* Sums of the edges' hashes, and of all. */
#define EDGE_SUMS (sizeof(svo_i_edge_sums) / sizeof(uint64_t))
#define TOTALS    (SVO_PLAN_SUMS + EDGE_SUMS)

/* Local memory of a work-group: one number of 64 bits per work-item. */
#define SCRATCH_BYTES (sizeof(cl_ulong) * SVO_GROUP_ITEMS)

/* Work-groups of a launch with a work-item per SVO_SCAN_TILE / SVO_GROUP_ITEMS elements, and its work-items. */
static uint32_t run_groups(uint64_t elements)
{
    const uint32_t tile = SVO_SCAN_TILE;
    return (uint32_t)((elements + tile - 1) / tile);
}

static uint64_t run_items(uint64_t elements)
{
    return (elements + RUN - 1) / RUN;
}

/* Reduces the columns that a launch over elements has left in its groups' partials, to totals from the first on. */
static svo_status run_reduce(svo_i_device_work *work, cl_mem partials, uint64_t elements, uint32_t columns,
                             bool largest, cl_mem totals, uint32_t first)
{
    const svo_plan_total_params params = {run_groups(elements), columns, largest ? 1u : 0u, first};
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(partials), SVO_I_ARGUMENT(totals), SVO_I_ARGUMENT(params),
                                        SVO_I_LOCAL(SCRATCH_BYTES)};
    return svo_i_work_launch(work, "svo_k_plan_totals", SVO_I_ARGUMENTS(arguments), SVO_GROUP_ITEMS);
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
    const uint32_t groups = run_groups(vertices > triangles ? vertices : triangles);
    const bool sums_edges = (r->plan->options.need & SVO_NEED_PROJECTED_AREA) != 0;
    const svo_i_request scratch[] = {
        {"plan_fragments", triangles * 4, &r->fragments},
        {"plan_fates", triangles * sizeof(cl_ushort), &r->fates},
        {"plan_used", vertices, &r->used},
        {"plan_partials", (uint64_t)groups * SVO_PLAN_SUMS * sizeof(cl_ulong), &r->partials},
        {"plan_sums", TOTALS * sizeof(cl_ulong), &r->sums},
        {"plan_edges", (uint64_t)run_groups(triangles) * sizeof(svo_i_edge_sums), &r->edges}};
    const svo_i_request kept[] = {{"plan_vertices", vertices * 12, &r->plan->memory.vertices},
                                  {"plan_remainders", vertices * 8, &r->plan->memory.remainders}};
    const size_t count = sizeof scratch / sizeof scratch[0] - (sums_edges ? 0 : 1);
    SVO_I_TRY(svo_i_device_buffers(r->work->device, r->work->function, scratch, count));
    return svo_i_device_buffers(r->work->device, r->work->function, kept, svo_i_plan_asks_payload(r->plan) ? 2 : 1);
}

/* Reduces partials to totals and reads those, with what follows them. */
static svo_status read_totals(svo_i_grid_run *r, uint64_t elements, uint32_t columns, bool largest, uint64_t *totals,
                              size_t total_count)
{
    memset(totals, 0, total_count * sizeof *totals);
    if (elements == 0) {
        return SVO_OK;
    }
    SVO_I_TRY(run_reduce(r->work, r->partials, elements, columns, largest, r->sums, 0));
    return svo_i_work_read(r->work, r->sums, 0, totals, total_count * sizeof *totals);
}

static svo_status accept(svo_i_grid_run *r)
{
    SVO_I_TRY(svo_i_work_fill_zero(r->work, r->used, r->params.vertex_count));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(r->mesh->positions), SVO_I_ARGUMENT(r->mesh->indices),
                                        SVO_I_ARGUMENT(r->used), SVO_I_ARGUMENT(r->params)};
    return svo_i_work_launch(r->work, "svo_k_plan_accept", SVO_I_ARGUMENTS(arguments),
                             run_items(r->params.triangle_count));
}

/* Copies the grid that the plan has to params. */
static void copy_place(svo_i_grid_run *r)
{
    for (unsigned axis = 0; axis < 3; ++axis) {
        put_double(r->plan->info.origin[axis], r->params.origin + (size_t)axis * 2);
    }
    put_double(r->plan->info.scale, r->params.scale);
    put_double(r->plan->info.edge, r->params.edge);
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
                                    run_items(r->params.vertex_count)));
        SVO_I_TRY(read_totals(r, r->params.vertex_count, 6, true, keys, 6));
    }
    bounds.any = keys[0] != 0;
    for (unsigned axis = 0; axis < 3 && bounds.any; ++axis) {
        bounds.low[axis] = -double_of_key(keys[axis]);
        bounds.high[axis] = double_of_key(keys[axis + 3]);
    }
    SVO_I_TRY(svo_i_plan_make_grid(r->plan, &bounds));
    copy_place(r);
    return SVO_OK;
}

static svo_status snap(svo_i_grid_run *r)
{
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(r->mesh->positions), SVO_I_ARGUMENT(r->used),
                                        SVO_I_ARGUMENT(r->plan->memory.vertices),
                                        SVO_I_ARGUMENT(r->plan->memory.remainders), SVO_I_ARGUMENT(r->params)};
    return svo_i_work_launch(r->work, "svo_k_plan_snap", SVO_I_ARGUMENTS(arguments), run_items(r->params.vertex_count));
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

static svo_status launch_classify(svo_i_grid_run *r)
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
                             run_items(r->params.triangle_count));
}

static svo_status sum_edges(svo_i_grid_run *r)
{
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(r->mesh->positions), SVO_I_ARGUMENT(r->mesh->indices),
                                        SVO_I_ARGUMENT(r->fates),           SVO_I_ARGUMENT(r->edges),
                                        SVO_I_ARGUMENT(r->params),          SVO_I_LOCAL(SCRATCH_BYTES)};
    return svo_i_work_launch(r->work, "svo_k_plan_closed", SVO_I_ARGUMENTS(arguments),
                             run_items(r->params.triangle_count));
}

/* Launches the sums of the edges' hashes, to totals from the first on. */
static svo_status launch_edges(svo_i_grid_run *r, cl_mem totals, uint32_t first)
{
    SVO_I_TRY(sum_edges(r));
    return run_reduce(r->work, r->edges, r->params.triangle_count, EDGE_SUMS, false, totals, first);
}

/* Classifies all triangles, and reads their counts and whether the edges cancel. */
static svo_status classify(svo_i_grid_run *r)
{
    svo_i_edge_sums edges;
    const uint32_t triangles = r->params.triangle_count;
    SVO_I_TRY(launch_classify(r));
    if (r->edges != NULL && triangles > 0) {
        SVO_I_TRY(launch_edges(r, r->sums, SVO_PLAN_SUMS));
    }
    SVO_I_TRY(read_totals(r, triangles, SVO_PLAN_SUMS, false, r->totals, TOTALS));
    memcpy(&edges, r->totals + SVO_PLAN_SUMS, sizeof edges);
    r->plan->work.both_sides = r->edges != NULL && svo_i_edges_are_open(&edges);
    take_totals(r);
    return SVO_OK;
}

static svo_status alloc_kept(svo_i_grid_run *r)
{
    svo_i_plan_memory *memory = &r->plan->memory;
    const uint64_t count = r->plan->triangle_count;
    const cl_uint kept_bytes = (r->params.flags & SVO_PLAN_SOME) != 0 ? r->params.vertex_count : 0;
    const svo_i_request kept[] = {{"plan_indices", count * 12, &memory->indices},
                                  {"plan_triangle_ids", count * 4, &memory->triangle_ids},
                                  {"plan_items", count * sizeof(svo_draw_item), &memory->items},
                                  {"plan_item_fragments", count * 4, &memory->item_fragments}};
    const svo_i_request scratch[] = {{"plan_large", r->plan->large_count * sizeof(svo_large_item), &r->large},
                                     {"plan_kept", kept_bytes, &r->kept},
                                     {"plan_large_count", sizeof(cl_uint), &r->large_count}};
    SVO_I_TRY(svo_i_device_buffers(r->work->device, r->work->function, SVO_I_REQUESTS(kept)));
    SVO_I_TRY(svo_i_device_buffers(r->work->device, r->work->function, SVO_I_REQUESTS(scratch)));
    SVO_I_TRY(svo_i_work_fill_zero(r->work, r->large_count, sizeof(cl_uint)));
    return svo_i_work_fill_zero(r->work, r->kept, kept_bytes);
}

static svo_status keep(svo_i_grid_run *r)
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
    SVO_I_TRY(
        svo_i_work_launch(r->work, "svo_k_plan_keep", SVO_I_ARGUMENTS(arguments), run_items(r->params.triangle_count)));
    if ((r->params.flags & SVO_PLAN_SOME) == 0) {
        return SVO_OK;
    }
    const svo_i_argument clear[] = {SVO_I_ARGUMENT(r->kept), SVO_I_ARGUMENT(memory->vertices),
                                    SVO_I_ARGUMENT(r->params)};
    return svo_i_work_launch(r->work, "svo_k_plan_clear", SVO_I_ARGUMENTS(clear), r->params.vertex_count);
}

/* The mesh's own positions of the vertices that kept triangles use; plan.c has it for the host. */
static svo_status keep_positions(svo_i_grid_run *r)
{
    const bool is_double = (r->params.flags & SVO_PLAN_DOUBLES) != 0;
    svo_i_plan_memory *memory = &r->plan->memory;
    cl_mem *positions = is_double ? &memory->positions_double : &memory->positions;
    const cl_mem marks = (r->params.flags & SVO_PLAN_SOME) != 0 ? r->kept : r->used;
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

/* Reads the large triangles, without waiting. Their order differs from run to run. */
static svo_status read_large(svo_i_grid_run *r)
{
    svo_plan *plan = r->plan;
    const size_t bytes = plan->large_count * sizeof *plan->large;
    plan->large = svo_i_alloc(&plan->device->memory, bytes + sizeof *plan->large);
    if (plan->large == NULL) {
        return svo_i_device_fail(plan->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %u triangles",
                                 r->work->function, plan->large_count);
    }
    return svo_i_work_read_later(r->work, r->large, 0, plan->large, bytes);
}

static svo_status run_grid(svo_i_grid_run *r)
{
    svo_plan *plan = r->plan;
    SVO_I_TRY(svo_i_grid_alloc(r));
    SVO_I_TRY(accept(r));
    SVO_I_TRY(fit(r));
    SVO_I_TRY(snap(r));
    (void)svo_i_progress_add(plan, SVO_STAGE_GRID, SVO_I_SNAP_NS * (double)r->params.vertex_count);
    SVO_I_TRY(svo_i_progress_tell(plan, SVO_STAGE_GRID));
    SVO_I_TRY(classify(r));
    SVO_I_TRY(alloc_kept(r));
    SVO_I_TRY(keep(r));
    SVO_I_TRY(keep_positions(r));
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
    copy_place(r);
}

void svo_i_grid_end(svo_i_grid_run *r)
{
    cl_mem *buffers[] = {&r->used,  &r->kept,        &r->fates, &r->fragments, &r->partials,
                         &r->large, &r->large_count, &r->edges, &r->sums};
    for (unsigned i = 0; i < sizeof buffers / sizeof buffers[0]; ++i) {
        svo_i_buffer_release(buffers[i]);
    }
}

static svo_status make_grid(svo_plan *plan, svo_i_device_work *work, const svo_i_plan_input *input,
                            const svo_i_device_mesh *mesh)
{
    const svo_mesh *given = &input->mesh;
    svo_i_grid_run r = {.plan = plan, .work = work, .mesh = mesh};
    plan->vertex_count = (uint32_t)given->vertex_count;
    plan->info.triangles = given->triangle_count;
    svo_i_grid_begin(&r, given->triangle_count, given->positions_double != NULL);
    const svo_status status = run_grid(&r);
    svo_i_grid_end(&r);
    return status;
}

/* ---- the payload inputs ---- */

typedef struct attributes_run {
    svo_plan *plan;
    svo_i_device_work *work;
    const svo_i_plan_input *input;
    const svo_i_device_mesh *mesh;
    bool has_colors, has_normals, has_uvs; /* in the mesh */
    svo_i_findings found;
    uint8_t *is_textured; /* one byte per material */
    svo_i_material_marks marks;
    cl_mem partials, totals;
} attributes_run;

static svo_status launch_normals(svo_i_device_work *work, cl_mem from, cl_mem to, cl_uint vertices)
{
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(from), SVO_I_ARGUMENT(to), SVO_I_ARGUMENT(vertices)};
    return svo_i_work_launch(work, "svo_k_plan_normals", SVO_I_ARGUMENTS(arguments), vertices);
}

svo_status svo_i_launch_uvs(svo_i_device_work *work, cl_mem from, cl_mem to, cl_ulong numbers)
{
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(from), SVO_I_ARGUMENT(to), SVO_I_ARGUMENT(numbers)};
    return svo_i_work_launch(work, "svo_k_plan_uvs", SVO_I_ARGUMENTS(arguments), numbers);
}

/* partials: receives SVO_PLAN_FINDINGS columns. */
static svo_status launch_records(svo_i_device_work *work, const svo_plan *plan, const svo_i_device_mesh *mesh,
                                 const svo_i_material_marks *marks, cl_mem partials)
{
    const svo_i_plan_memory *memory = &plan->memory;
    const svo_plan_params params = {.vertex_count = plan->vertex_count,
                                    .triangle_count = plan->triangle_count,
                                    .flags = SVO_PLAN_TEXTURED,
                                    .voxel_log2 = plan->voxel_log2,
                                    .material_count = plan->material_count};
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(memory->vertices),
                                        SVO_I_ARGUMENT(memory->indices),
                                        SVO_I_ARGUMENT(memory->triangle_ids),
                                        SVO_I_ARGUMENT(mesh->triangle_materials),
                                        SVO_I_ARGUMENT(memory->colors),
                                        SVO_I_ARGUMENT(memory->normals),
                                        SVO_I_ARGUMENT(marks->textured),
                                        SVO_I_ARGUMENT(marks->used),
                                        SVO_I_ARGUMENT(memory->records),
                                        SVO_I_ARGUMENT(partials),
                                        SVO_I_ARGUMENT(params),
                                        SVO_I_LOCAL(SCRATCH_BYTES),
                                        SVO_I_ARGUMENT(memory->remainders)};
    return svo_i_work_launch(work, "svo_k_plan_records", SVO_I_ARGUMENTS(arguments), run_items(plan->triangle_count));
}

/* Vertex colors and normals, in buffers of the plan's own. */
static svo_status fill_vertices(attributes_run *r)
{
    const cl_uint vertices = r->plan->vertex_count;
    svo_i_plan_memory *memory = &r->plan->memory;
    if (r->mesh->colors != NULL) {
        SVO_I_TRY(svo_i_work_result(r->work, "plan_colors", (uint64_t)vertices * 4, &memory->colors));
        SVO_I_TRY(svo_i_work_copy(r->work, r->mesh->colors, 0, memory->colors, 0, (uint64_t)vertices * 4));
    }
    const int16_t *exact =
        vertices > 0 && (svo_i_plan_reads(r->plan) & SVO_NEED_NORMAL) != 0 ? r->plan->exact_normals : NULL;
    if (r->mesh->normals == NULL && exact == NULL) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_work_result(r->work, "plan_normals", (uint64_t)vertices * 8, &memory->normals));
    return exact != NULL ? svo_i_work_write_later(r->work, memory->normals, exact, (uint64_t)vertices * 8)
                         : launch_normals(r->work, r->mesh->normals, memory->normals, vertices);
}

/* Which materials have a texture, for the kernel. */
static svo_status mark_textured(attributes_run *r)
{
    const bool wanted = (svo_i_plan_reads(r->plan) & SVO_NEED_COLOR) != 0;
    for (uint32_t i = 0; i < r->plan->material_count; ++i) {
        r->is_textured[i] = wanted && svo_i_material_is_textured(&r->input->mesh, r->has_uvs, i) ? 1 : 0;
    }
    SVO_I_TRY(svo_i_work_fill_zero(r->work, r->marks.used, r->plan->material_count));
    return svo_i_work_write_later(r->work, r->marks.textured, r->is_textured, r->plan->material_count);
}

/* The columns of svo_k_plan_records. */
static void take_findings(svo_i_findings *found, const uint64_t totals[SVO_PLAN_FINDINGS])
{
    memcpy(&found->largest_area, &totals[0], sizeof found->largest_area);
    found->colors_vary = totals[1] != 0;
    found->normals_vary = totals[2] != 0;
    found->own_normals_vary = totals[3] != ~totals[4]; /* the largest and the smallest */
    found->first_color = (uint32_t)totals[5];
    memcpy(found->first_normal, &totals[6], sizeof found->first_normal);
    memcpy(&found->first_record, &totals[7], sizeof found->first_record);
}

static svo_status alloc_records(attributes_run *r)
{
    const svo_plan *plan = r->plan;
    const uint64_t rows = run_groups(plan->triangle_count);
    const svo_i_request scratch[] = {{"plan_partials", rows * SVO_PLAN_FINDINGS * sizeof(cl_ulong), &r->partials},
                                     {"plan_totals", SVO_PLAN_FINDINGS * sizeof(cl_ulong), &r->totals},
                                     {"plan_materials", plan->material_count, &r->marks.used},
                                     {"plan_textured", plan->material_count, &r->marks.textured}};
    SVO_I_TRY(svo_i_device_buffers(r->work->device, r->work->function, SVO_I_REQUESTS(scratch)));
    return svo_i_work_result(r->work, "plan_records", plan->triangle_count * sizeof(svo_triangle_record),
                             &r->plan->memory.records);
}

/* Makes the records. The host waits for what they tell. */
static svo_status make_records(attributes_run *r)
{
    svo_plan *plan = r->plan;
    const uint32_t triangles = plan->triangle_count;
    uint64_t totals[SVO_PLAN_FINDINGS] = {0};
    SVO_I_TRY(alloc_records(r));
    SVO_I_TRY(mark_textured(r));
    SVO_I_TRY(launch_records(r->work, plan, r->mesh, &r->marks, r->partials));
    SVO_I_TRY(svo_i_work_read_later(r->work, r->marks.used, 0, r->found.material_used, plan->material_count));
    if (triangles == 0) {
        return svo_i_work_wait(r->work);
    }
    SVO_I_TRY(run_reduce(r->work, r->partials, triangles, SVO_PLAN_FINDINGS, true, r->totals, 0));
    SVO_I_TRY(svo_i_work_read(r->work, r->totals, 0, totals, sizeof totals));
    take_findings(&r->found, totals);
    return SVO_OK;
}

static svo_status fill_colors(attributes_run *r)
{
    svo_plan *plan = r->plan;
    const cl_ulong numbers = (cl_ulong)plan->vertex_count * 2;
    SVO_I_TRY(svo_i_plan_copy_materials(plan, &r->input->mesh, r->has_uvs, r->found.material_used));
    if (plan->textures_used == 0) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_work_result(r->work, "plan_uvs", numbers * 4, &plan->memory.uvs));
    return svo_i_launch_uvs(r->work, r->mesh->uvs, plan->memory.uvs, numbers);
}

static svo_status run_attributes(attributes_run *r, svo_i_device_mesh *mesh)
{
    svo_plan *plan = r->plan;
    if (r->found.material_used == NULL || r->is_textured == NULL) {
        return svo_i_device_fail(plan->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %u materials",
                                 r->work->function, plan->material_count);
    }
    SVO_I_TRY(svo_i_device_mesh_attributes(r->work, r->input, svo_i_plan_reads(plan), mesh));
    SVO_I_TRY(fill_vertices(r));
    SVO_I_TRY(make_records(r));
    if ((svo_i_plan_reads(plan) & SVO_NEED_COLOR) != 0) {
        SVO_I_TRY(fill_colors(r));
    }
    return svo_i_plan_conclude(plan, &r->found);
}

static svo_status make_attributes(svo_plan *plan, svo_i_device_work *work, const svo_i_plan_input *input,
                                  svo_i_device_mesh *mesh)
{
    const svo_mesh *given = &input->mesh;
    const svo_mesh_buffers *b = input->buffers;
    attributes_run r = {.plan = plan,
                        .work = work,
                        .input = input,
                        .mesh = mesh,
                        .has_colors = b != NULL ? b->colors.memory != NULL : given->colors != NULL,
                        .has_normals = b != NULL ? b->normals.memory != NULL : given->normals != NULL,
                        .has_uvs = b != NULL ? b->uvs.memory != NULL : given->uvs != NULL};
    svo_i_plan_resolve_need(plan, given, r.has_colors);
    if (svo_i_plan_reads(plan) == 0) {
        return SVO_OK;
    }
    r.found.material_used = svo_i_alloc_zeroed(&plan->device->memory, plan->material_count, 1);
    r.is_textured = svo_i_alloc_zeroed(&plan->device->memory, plan->material_count, 1);
    const svo_status status = run_attributes(&r, mesh);
    if (status != SVO_OK && work->last != NULL) {
        (void)svo_i_event_settle(work->last); /* it may use the arrays below */
    }
    svo_i_buffer_release(&r.marks.textured);
    svo_i_buffer_release(&r.marks.used);
    svo_i_buffer_release(&r.partials);
    svo_i_buffer_release(&r.totals);
    svo_i_free(r.found.material_used);
    svo_i_free(r.is_textured);
    return status;
}

svo_status svo_i_device_take_mesh(svo_plan *plan, svo_i_device_work *work, const svo_i_plan_input *input,
                                  svo_i_device_mesh *mesh)
{
    SVO_I_TRY(svo_i_work_use(work, &svo_i_program_plan, ""));
    SVO_I_TRY(svo_i_device_mesh_geometry(work, input, mesh));
    SVO_I_TRY(make_grid(plan, work, input, mesh));
    SVO_I_TRY(make_attributes(plan, work, input, mesh));
    SVO_I_TRY(svo_i_work_wait(work));
    qsort(plan->large, plan->large_count, sizeof *plan->large, compare_items);
    return SVO_OK;
}

/* ---- plans that are updated ---- */

/* Empties what keep does not write. */
static svo_status clear(svo_i_grid_run *r)
{
    static const svo_draw_item nothing = {0, SVO_DRAW_NOTHING};
    const svo_i_plan_memory *memory = &r->plan->memory;
    const uint64_t items = r->plan->class_begin[SVO_I_CLASS_COUNT];
    SVO_I_TRY(svo_i_work_fill_pattern(r->work, memory->items, &nothing, sizeof nothing, (items + 1) * sizeof nothing));
    SVO_I_TRY(svo_i_work_fill_zero(r->work, memory->item_fragments, items * sizeof(cl_float)));
    return svo_i_work_fill_zero(r->work, r->kept, r->params.vertex_count);
}

svo_status svo_i_device_launch(svo_i_grid_run *r, const svo_i_material_marks *marks, cl_mem edges)
{
    const svo_i_plan_memory *memory = &r->plan->memory;
    const uint32_t vertices = r->params.vertex_count;
    const uint32_t triangles = r->params.triangle_count;
    SVO_I_TRY(accept(r));
    SVO_I_TRY(snap(r));
    SVO_I_TRY(launch_classify(r));
    SVO_I_TRY(run_reduce(r->work, r->partials, triangles, SVO_PLAN_SUMS, false, r->sums, 0));
    SVO_I_TRY(edges != NULL ? launch_edges(r, edges, 0) : SVO_OK);
    SVO_I_TRY(clear(r));
    SVO_I_TRY(keep(r));
    SVO_I_TRY(keep_positions(r));
    if (memory->normals != NULL) {
        SVO_I_TRY(launch_normals(r->work, r->mesh->normals, memory->normals, vertices));
    }
    return memory->records != NULL ? launch_records(r->work, r->plan, r->mesh, marks, r->partials) : SVO_OK;
}
