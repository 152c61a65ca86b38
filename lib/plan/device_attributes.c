/* SPDX-License-Identifier: MIT */
/*
 * The payload inputs by kernels. The host reads a row of totals, a byte per material, and the first triangle's record
 * and attributes; materials and textures are the host's.
 */
#include "plan/device_attributes.h"

#include <string.h>

#include "plan/attributes.h"
#include "plan/device_grid.h"

#define COLUMNS       SVO_I_RECORD_COLUMNS
#define SCRATCH_BYTES (sizeof(cl_ulong) * SVO_GROUP_ITEMS)

typedef struct attributes_run {
    svo_plan *plan;
    svo_i_device_work *work;
    const svo_i_plan_input *input;
    const svo_i_device_mesh *mesh;
    bool has_colors, has_normals, has_uvs; /* in the mesh */
    svo_i_findings found;
    uint8_t *is_textured; /* one byte per material */
    svo_i_material_marks marks;
    cl_mem partials;
} attributes_run;

svo_status svo_i_launch_normals(svo_i_device_work *work, cl_mem from, cl_mem to, cl_uint vertices)
{
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(from), SVO_I_ARGUMENT(to), SVO_I_ARGUMENT(vertices)};
    return svo_i_work_launch(work, "svo_k_plan_normals", SVO_I_ARGUMENTS(arguments), vertices);
}

svo_status svo_i_launch_uvs(svo_i_device_work *work, cl_mem from, cl_mem to, cl_ulong numbers)
{
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(from), SVO_I_ARGUMENT(to), SVO_I_ARGUMENT(numbers)};
    return svo_i_work_launch(work, "svo_k_plan_uvs", SVO_I_ARGUMENTS(arguments), numbers);
}

svo_status svo_i_launch_records(svo_i_device_work *work, const svo_plan *plan, const svo_i_device_mesh *mesh,
                                const svo_i_material_marks *marks, cl_mem partials)
{
    const svo_i_plan_memory *memory = &plan->memory;
    const svo_plan_params params = {.vertex_count = plan->vertex_count,
                                    .triangle_count = plan->triangle_count,
                                    .flags = SVO_PLAN_TEXTURED,
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
                                        SVO_I_LOCAL(SCRATCH_BYTES)};
    return svo_i_work_launch(work, "svo_k_plan_records", SVO_I_ARGUMENTS(arguments),
                             svo_i_run_items(plan->triangle_count));
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
    if (r->mesh->normals == NULL) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_work_result(r->work, "plan_normals", (uint64_t)vertices * 8, &memory->normals));
    return svo_i_launch_normals(r->work, r->mesh->normals, memory->normals, vertices);
}

/* Which materials have a texture, for the kernel. */
static svo_status mark_textured(attributes_run *r)
{
    const bool wanted = (r->plan->info.need & SVO_NEED_COLOR) != 0;
    for (uint32_t i = 0; i < r->plan->material_count; ++i) {
        r->is_textured[i] = wanted && svo_i_material_is_textured(&r->input->mesh, r->has_uvs, i) ? 1 : 0;
    }
    SVO_I_TRY(svo_i_work_result(r->work, "plan_materials", r->plan->material_count, &r->marks.used));
    SVO_I_TRY(svo_i_work_fill_zero(r->work, r->marks.used, r->plan->material_count));
    SVO_I_TRY(svo_i_work_result(r->work, "plan_textured", r->plan->material_count, &r->marks.textured));
    return svo_i_work_write(r->work, r->marks.textured, r->is_textured, r->plan->material_count);
}

static void take_totals(svo_i_findings *found, const uint64_t totals[COLUMNS])
{
    memcpy(&found->largest_area, &totals[0], sizeof found->largest_area);
    found->colors_vary = totals[1] != 0;
    found->normals_vary = totals[2] != 0;
    found->own_normals_vary = totals[3] != ~totals[4]; /* the largest and the smallest */
}

static svo_status make_records(attributes_run *r)
{
    svo_plan *plan = r->plan;
    svo_i_plan_memory *memory = &plan->memory;
    uint64_t totals[COLUMNS] = {0};
    SVO_I_TRY(mark_textured(r));
    SVO_I_TRY(svo_i_work_result(r->work, "plan_records", plan->triangle_count * sizeof(svo_triangle_record),
                                &memory->records));
    SVO_I_TRY(svo_i_work_result(r->work, "plan_partials",
                                (uint64_t)svo_i_run_groups(plan->triangle_count) * COLUMNS * sizeof(cl_ulong),
                                &r->partials));
    SVO_I_TRY(svo_i_launch_records(r->work, plan, r->mesh, &r->marks, r->partials));
    SVO_I_TRY(svo_i_run_totals(r->work, r->partials, plan->triangle_count, COLUMNS, true, totals));
    if (plan->triangle_count > 0) {
        take_totals(&r->found, totals);
    }
    return svo_i_work_read(r->work, r->marks.used, 0, r->found.material_used, plan->material_count);
}

/* The first triangle's record, and the attributes of its first corner. */
static svo_status read_first(attributes_run *r)
{
    const svo_i_plan_memory *memory = &r->plan->memory;
    uint32_t vertex = 0;
    if (r->plan->triangle_count == 0) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_work_read(r->work, memory->records, 0, &r->found.first_record, sizeof r->found.first_record));
    SVO_I_TRY(svo_i_work_read(r->work, memory->indices, 0, &vertex, sizeof vertex));
    if (memory->colors != NULL) {
        SVO_I_TRY(svo_i_work_read(r->work, memory->colors, (uint64_t)vertex * 4, &r->found.first_color, 4));
    }
    if (memory->normals != NULL) {
        SVO_I_TRY(svo_i_work_read(r->work, memory->normals, (uint64_t)vertex * 8, r->found.first_normal, 8));
    }
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

static svo_status run_steps(attributes_run *r, svo_i_device_mesh *mesh)
{
    svo_plan *plan = r->plan;
    if (r->found.material_used == NULL || r->is_textured == NULL) {
        return svo_i_device_fail(plan->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %u materials",
                                 r->work->function, plan->material_count);
    }
    SVO_I_TRY(svo_i_device_mesh_attributes(r->work, r->input, plan->info.need, mesh));
    SVO_I_TRY(fill_vertices(r));
    SVO_I_TRY(make_records(r));
    SVO_I_TRY(read_first(r));
    if ((plan->info.need & SVO_NEED_COLOR) != 0) {
        SVO_I_TRY(fill_colors(r));
    }
    return svo_i_plan_conclude(plan, &r->found);
}

svo_status svo_i_device_attributes(svo_plan *plan, svo_i_device_work *work, const svo_i_plan_input *input,
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
    if ((plan->info.need & SVO_I_NEED_PAYLOAD) == 0) {
        return SVO_OK;
    }
    r.found.material_used = svo_i_alloc_zeroed(&plan->device->memory, plan->material_count, 1);
    r.is_textured = svo_i_alloc_zeroed(&plan->device->memory, plan->material_count, 1);
    const svo_status status = run_steps(&r, mesh);
    svo_i_buffer_release(&r.marks.textured);
    svo_i_buffer_release(&r.marks.used);
    svo_i_buffer_release(&r.partials);
    svo_i_free(r.found.material_used);
    svo_i_free(r.is_textured);
    return status;
}
