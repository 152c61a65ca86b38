/* SPDX-License-Identifier: MIT */
/*
 * What stages get from the plan: parameters, the snapped mesh, under a name that says which stages it is for, the
 * attributes for material.c and filter.c, and constant payload, as one element per buffer.
 */
#include "stages/inputs.h"

#include <string.h>

#include "plan/arrays.h"

/* ---- parameters ---- */

svo_decide_params svo_i_decide_params(const svo_plan *plan)
{
    const svo_i_plan_part *part = &plan->part;
    svo_decide_params params =
        svo_i_grid_params(&part->header, part->level, part->code, plan->info.depth, plan->info.origin, plan->info.edge);
    params.coverage = (cl_uint)plan->info.coverage;
    params.is_double = svo_i_plan_has(plan->positions_double, plan->memory.positions_double) ? 1 : 0;
    return params;
}

svo_filter_params svo_i_payload_params(const svo_i_build *build)
{
    const svo_tree_info *info = &build->tree->info;
    return (svo_filter_params){.depth = info->depth,
                               .leaf_begin = (cl_uint)info->inner_count,
                               .leaf_count = (cl_uint)info->leaf_count,
                               .voxel_log2 = build->commands.plan->voxel_log2,
                               .weight_log2 = build->commands.plan->weight_log2,
                               .both_sides = build->commands.plan->work.both_sides,
                               .payload_level = info->payload_level};
}

void svo_i_params_of_level(svo_filter_params *params, const svo_tree_info *info, uint32_t level)
{
    params->level = level;
    params->level_begin = info->level_begin[level];
    params->level_count = info->level_begin[level + 1] - info->level_begin[level];
    params->child_begin = info->level_begin[level + 1];
    params->fill_shift = params->weight_log2 + 2 * (info->depth - level - 1) - SVO_I_FILL_LOG2;
}

uint32_t svo_i_digit_passes(uint32_t triangle_count)
{
    uint32_t passes = 0;
    while (passes < 32 / SVO_DIGIT_BITS && triangle_count > 1u &&
           ((triangle_count - 1u) >> (SVO_DIGIT_BITS * passes)) != 0) {
        passes += 2;
    }
    return passes;
}

/* ---- the mesh ---- */

/* Whether a stage after the voxelizer reads the array. */
static bool keeps_vertices(const svo_plan *plan)
{
    return plan->work.lists || (plan->work.surface && plan->work.positions);
}

static bool keeps_indices(const svo_plan *plan)
{
    return plan->work.lists || plan->work.surface;
}

/* How an array of the plan is got: for the tree, or for the build alone. */
typedef svo_status getter(svo_i_commands *commands, const char *name, const void *host, cl_mem memory, uint64_t bytes,
                          cl_mem *out);

static getter *getter_for(bool stays)
{
    return stays ? svo_i_commands_take : svo_i_commands_borrow;
}

static svo_status get_vertices(svo_i_commands *commands, cl_mem *out)
{
    const svo_plan *plan = commands->plan;
    if (commands->mesh.vertices == NULL) {
        SVO_I_TRY(getter_for(plan->work.lists)(commands, keeps_vertices(plan) ? "vertices" : "mesh_vertices",
                                               plan->vertices, plan->memory.vertices, (uint64_t)plan->vertex_count * 12,
                                               &commands->mesh.vertices));
    }
    *out = commands->mesh.vertices;
    return SVO_OK;
}

static svo_status get_indices(svo_i_commands *commands, cl_mem *out)
{
    const svo_plan *plan = commands->plan;
    if (commands->mesh.indices == NULL) {
        SVO_I_TRY(getter_for(plan->work.lists)(commands, keeps_indices(plan) ? "indices" : "mesh_indices",
                                               plan->indices, plan->memory.indices, (uint64_t)plan->triangle_count * 12,
                                               &commands->mesh.indices));
    }
    *out = commands->mesh.indices;
    return SVO_OK;
}

static svo_status get_positions(svo_i_commands *commands, cl_mem *out)
{
    const svo_plan *plan = commands->plan;
    const bool is_stored = plan->work.lists && svo_i_plan_stores_positions(plan);
    getter *get = getter_for(is_stored);
    if (commands->mesh.positions != NULL) {
        *out = commands->mesh.positions;
        return SVO_OK;
    }
    if (svo_i_plan_has(plan->positions_double, plan->memory.positions_double)) {
        SVO_I_TRY(get(commands, is_stored ? "positions_double" : "mesh_positions", plan->positions_double,
                      plan->memory.positions_double, (uint64_t)plan->vertex_count * 24, &commands->mesh.positions));
    } else {
        SVO_I_TRY(get(commands, is_stored ? "positions" : "mesh_positions", plan->positions, plan->memory.positions,
                      (uint64_t)plan->vertex_count * 12, &commands->mesh.positions));
    }
    *out = commands->mesh.positions;
    return SVO_OK;
}

svo_status svo_i_build_mesh_get(svo_i_commands *commands, svo_i_build_mesh *out)
{
    SVO_I_TRY(get_vertices(commands, &out->vertices));
    SVO_I_TRY(get_positions(commands, &out->positions));
    return get_indices(commands, &out->indices);
}

void svo_i_build_mesh_listed(svo_i_commands *commands)
{
    if (!commands->plan->work.lists || !svo_i_plan_stores_positions(commands->plan)) {
        svo_i_commands_free(commands, &commands->mesh.positions);
    }
    if (!keeps_vertices(commands->plan)) {
        svo_i_commands_free(commands, &commands->mesh.vertices);
    }
    if (!keeps_indices(commands->plan)) {
        svo_i_commands_free(commands, &commands->mesh.indices);
    }
}

void svo_i_build_mesh_free(svo_i_commands *commands)
{
    svo_i_commands_free(commands, &commands->mesh.positions);
    svo_i_commands_free(commands, &commands->mesh.vertices);
    svo_i_commands_free(commands, &commands->mesh.indices);
}

/* ---- geometry for rays ---- */

/* Moves the positions to the tree. */
static svo_status take_positions(svo_i_build *build)
{
    const svo_plan *plan = build->commands.plan;
    svo_tree *tree = build->tree;
    cl_mem positions = NULL;
    tree->info.positions = SVO_POSITIONS_ROUNDED;
    if (!svo_i_plan_stores_positions(plan)) {
        return SVO_OK;
    }
    SVO_I_TRY(get_positions(&build->commands, &positions));
    build->commands.mesh.positions = NULL;
    const bool is_double = svo_i_plan_has(plan->positions_double, plan->memory.positions_double);
    tree->info.positions = is_double ? SVO_POSITIONS_DOUBLE : SVO_POSITIONS_FLOAT;
    tree->buffers[is_double ? SVO_TREE_POSITIONS_DOUBLE : SVO_TREE_POSITIONS] = positions;
    return SVO_OK;
}

/* Moves the snapped mesh to the tree. */
static svo_status take_mesh(svo_i_build *build)
{
    svo_i_build_mesh *mesh = &build->commands.mesh;
    if (build->tree->buffers[SVO_TREE_VERTICES] == NULL) { /* else a front end has them there */
        SVO_I_TRY(get_vertices(&build->commands, &build->tree->buffers[SVO_TREE_VERTICES]));
        mesh->vertices = NULL;
    }
    SVO_I_TRY(get_indices(&build->commands, &build->tree->buffers[SVO_TREE_INDICES]));
    mesh->indices = NULL;
    return SVO_OK;
}

svo_status svo_i_geometry_upload(svo_i_build *build)
{
    const svo_plan *plan = build->commands.plan;
    svo_i_stage_begin(&build->commands);
    SVO_I_TRY(take_mesh(build));
    SVO_I_TRY(svo_i_commands_take(&build->commands, "triangle_ids", plan->triangle_ids, plan->memory.triangle_ids,
                                  (uint64_t)plan->triangle_count * 4, &build->tree->buffers[SVO_TREE_TRIANGLE_IDS]));
    SVO_I_TRY(take_positions(build));
    build->tree->info.vertex_count = plan->vertex_count;
    build->tree->info.list_triangle_count = plan->triangle_count;
    return svo_i_stage_end(&build->commands, SVO_STAGE_TRANSFER);
}

/* ---- the surface ---- */

/* Uniform weights alone need no vertices: they do not depend on where in its voxel a triangle is. */
static svo_status get_geometry(svo_i_build *build, svo_i_surface *out)
{
    if (build->tree->buffers[SVO_TREE_VERTICES] != NULL) {
        out->vertices = build->tree->buffers[SVO_TREE_VERTICES];
        out->indices = build->tree->buffers[SVO_TREE_INDICES];
        return SVO_OK;
    }
    SVO_I_TRY(build->commands.plan->work.positions ? get_vertices(&build->commands, &out->vertices) : SVO_OK);
    return get_indices(&build->commands, &out->indices);
}

/* An array of the surface; no bytes: the plan has none, or nothing reads it. */
typedef struct surface_array {
    svo_i_request request;
    const void *host;
    cl_mem memory; /* NULL: host */
} surface_array;

#define SURFACE_ARRAYS 7

static void list_arrays(svo_i_build *build, surface_array arrays[SURFACE_ARRAYS])
{
    const svo_plan *plan = build->commands.plan;
    const svo_i_plan_memory *memory = &plan->memory;
    svo_i_surface *out = &build->surface;
    const uint64_t vertices = plan->vertex_count;
    const surface_array all[SURFACE_ARRAYS] = {
        {{"vertex_remainders", vertices * 8, &out->remainders},
         plan->work.positions ? plan->remainders : NULL,
         plan->work.positions ? memory->remainders : NULL},
        {{"records", (uint64_t)plan->triangle_count * sizeof(svo_triangle_record), &out->records},
         plan->records,
         memory->records},
        {{"vertex_colors", vertices * 4, &out->colors}, plan->colors, memory->colors},
        {{"vertex_normals", vertices * 8, &out->normals}, plan->normals, memory->normals},
        {{"uvs", vertices * 8, &out->uvs}, plan->uvs, memory->uvs},
        {{"material_records", plan->material_count * sizeof(svo_material_record), &out->materials},
         plan->materials,
         NULL},
        {{"texels", plan->texel_count * 4, &out->texels}, plan->texels, NULL}};
    memcpy(arrays, all, sizeof all);
}

/* Arrays that the plan has on the device are read there; the others are uploaded. */
svo_status svo_i_surface_upload(svo_i_build *build)
{
    svo_i_commands *commands = &build->commands;
    surface_array arrays[SURFACE_ARRAYS];
    svo_i_request requests[SURFACE_ARRAYS];
    const surface_array *uploaded[SURFACE_ARRAYS];
    size_t count = 0;
    if (build->surface.records != NULL) { /* a stage before has uploaded it */
        return SVO_OK;
    }
    svo_i_stage_begin(commands);
    SVO_I_TRY(get_geometry(build, &build->surface));
    list_arrays(build, arrays);
    for (size_t i = 0; i < SURFACE_ARRAYS; ++i) {
        *arrays[i].request.out = arrays[i].memory;
        if (arrays[i].memory == NULL && arrays[i].host != NULL) {
            uploaded[count] = &arrays[i];
            requests[count++] = arrays[i].request;
        }
    }
    SVO_I_TRY(svo_i_commands_alloc_all(commands, requests, count));
    for (size_t i = 0; i < count; ++i) {
        SVO_I_TRY(svo_i_commands_write(commands, *requests[i].out, uploaded[i]->host, requests[i].bytes));
    }
    return svo_i_stage_end(commands, SVO_STAGE_TRANSFER);
}

void svo_i_surface_free(svo_i_build *build)
{
    svo_i_surface *surface = &build->surface;
    cl_mem *buffers[] = {&surface->remainders, &surface->records,   &surface->colors, &surface->normals,
                         &surface->uvs,        &surface->materials, &surface->texels};
    for (unsigned i = 0; i < sizeof buffers / sizeof buffers[0]; ++i) {
        svo_i_commands_free(&build->commands, buffers[i]);
    }
    svo_i_build_mesh_free(&build->commands);
    *surface = (svo_i_surface){0};
}

/* ---- constant payload ---- */

/* The payload of a tree without leaves is zero. */
svo_status svo_i_constants_store(svo_i_build *build)
{
    static const unsigned char none[8] = {0};
    const svo_i_work *work = &build->commands.plan->work;
    const struct {
        svo_need bit;
        svo_tree_buffer array;
        const void *value;
    } constants[] = {{SVO_NEED_COLOR, SVO_TREE_COLORS, &work->constant_color},
                     {SVO_NEED_NORMAL, SVO_TREE_NORMALS, work->constant_normal},
                     {SVO_NEED_MATERIAL, SVO_TREE_MATERIALS, &work->constant_material}};
    svo_i_surface_free(build);
    svo_i_stage_begin(&build->commands);
    for (unsigned i = 0; i < sizeof constants / sizeof constants[0]; ++i) {
        const svo_tree_buffer array = constants[i].array;
        if ((work->constant & (uint32_t)constants[i].bit) != 0) {
            SVO_I_TRY(svo_i_commands_upload(&build->commands, svo_name(SVO_NAME_TREE_BUFFER, array),
                                            build->tree->info.leaf_count > 0 ? constants[i].value : none,
                                            svo_i_tree_element_bytes(array), &build->tree->buffers[array]));
        }
    }
    return svo_i_stage_end(&build->commands, SVO_STAGE_TRANSFER);
}
