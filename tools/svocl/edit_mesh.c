/* SPDX-License-Identifier: MIT */
/* From the file of a mesh to the voxels inside it. */
#include "svocl/edit_mesh.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/input.h"

/* ---- its place ---- */

/* Positions and normals of a mesh that is placed; both are freed. */
typedef struct placed_arrays {
    double *positions;
    float *normals; /* NULL where the mesh has none */
} placed_arrays;

static double turned(const double row[3], const double from[3])
{
    return row[0] * from[0] + row[1] * from[1] + row[2] * from[2];
}

/* The mesh with arrays of its own: scaled, turned, moved. */
static int place(program *state, const svo_mesh *mesh, const script_mesh *at, svo_mesh *out, placed_arrays *own)
{
    *out = *mesh;
    own->positions = malloc((mesh->vertex_count + 1) * 3 * sizeof *own->positions);
    own->normals = mesh->normals != NULL ? malloc((mesh->vertex_count + 1) * 3 * sizeof *own->normals) : NULL;
    if (own->positions == NULL || (own->normals == NULL && mesh->normals != NULL)) {
        return program_fail(state, PROGRAM_FAILED, "no memory for the vertices of %s", state->options.input);
    }
    for (size_t i = 0; i < mesh->vertex_count; ++i) {
        double from[3];
        double normal[3] = {0.0, 0.0, 0.0};
        for (size_t axis = 0; axis < 3; ++axis) {
            normal[axis] = mesh->normals != NULL ? (double)mesh->normals[3 * i + axis] : 0.0;
            from[axis] = mesh->positions_double != NULL ? mesh->positions_double[3 * i + axis]
                                                        : (double)mesh->positions[3 * i + axis];
        }
        for (size_t axis = 0; axis < 3; ++axis) {
            const double *row = at->turn[axis];
            own->positions[3 * i + axis] = at->at[axis] + at->scale * turned(row, from);
            if (own->normals != NULL) {
                own->normals[3 * i + axis] = (float)turned(row, normal);
            }
        }
    }
    out->positions = NULL;
    out->positions_double = own->positions;
    out->normals = own->normals;
    return PROGRAM_DONE;
}

/* ---- its voxels ---- */

/* Adds what is inside to the tree of the surface, which it replaces. */
static svo_status fill(const session *opened, const script_step *step, svo_tree **tree, svo_solid_info *info)
{
    const svo_solid_options filling = {.struct_size = sizeof filling, .rule = step->mesh.rule};
    svo_compact *solid = NULL;
    svo_status status = svo_solid_create(*tree, &filling, opened->queue, &solid, info);
    svo_tree_destroy(tree);
    if (status == SVO_OK) {
        status = svo_compact_expand(solid, opened->queue, tree);
    }
    if (status == SVO_OK) {
        status = svo_tree_download(*tree, opened->queue);
    }
    svo_compact_destroy(&solid);
    return status;
}

/* Builds on a grid whose planes are those of the edit's voxels, so that coordinates are the edit's. */
static int build(program *state, const session *opened, const svo_mesh *mesh, const script_step *step, svo_tree **tree,
                 svo_solid_info *info)
{
    svo_plan_options planned = SVO_PLAN_OPTIONS_INIT;
    svo_plan *plan = NULL;
    svo_message message = {""};
    unsigned depth = 0;
    planned.need =
        (uint32_t)SVO_NEED_RAYS | (uint32_t)SVO_NEED_NORMAL | (step->has_color ? 0u : (uint32_t)SVO_NEED_COLOR);
    if (svo_mesh_voxel_grid(mesh, 1.0, planned.origin, &planned.edge, &depth, &message) != SVO_OK) {
        return program_fail_library(state, message.text);
    }
    svo_status status = svo_plan_create(opened->device, mesh, depth, &planned, &plan);
    if (status == SVO_OK) {
        status = svo_build(plan, NULL, opened->queue, tree, NULL);
    }
    svo_plan_destroy(&plan);
    if (status == SVO_OK) {
        status = fill(opened, step, tree, info);
    }
    return status == SVO_OK ? PROGRAM_DONE : program_fail_library(state, svo_device_message(opened->device));
}

/* The leaves with their normals, the step's color, where it has one, and its material. */
static svo_status list_leaves(const svo_tree *tree, const script_step *step, svo_voxels **out, svo_message *message)
{
    svo_voxels *leaves = NULL;
    svo_voxels_info info = SVO_VOXELS_INFO_INIT;
    svo_status status = svo_tree_get_voxels(tree, &leaves, message);
    if (status != SVO_OK) {
        return status;
    }
    (void)svo_voxels_get_info(leaves, &info);
    svo_voxel *voxels = malloc((size_t)(info.voxel_count + 1) * sizeof *voxels);
    if (voxels == NULL) {
        status = SVO_OUT_OF_HOST_MEMORY;
        (void)snprintf(message->text, sizeof message->text, "no memory for %" PRIu64 " voxels", info.voxel_count);
        goto cleanup;
    }
    memcpy(voxels, svo_voxels_get(leaves), (size_t)info.voxel_count * sizeof *voxels);
    for (uint64_t i = 0; i < info.voxel_count; ++i) {
        voxels[i].material = (uint16_t)step->step.material;
        if (step->has_color) {
            memcpy(voxels[i].rgba, step->step.rgba, sizeof voxels[i].rgba);
        }
    }
    const svo_voxels_source source = {.struct_size = sizeof source,
                                      .voxels = voxels,
                                      .voxel_count = info.voxel_count,
                                      .normals = svo_voxels_get_normals(leaves)};
    status = svo_voxels_create(&source, out, message);
cleanup:
    free(voxels);
    svo_voxels_destroy(&leaves);
    return status;
}

/* An open mesh has no inside that all lines agree on. */
static void warn_open(program *state, const edit_script *script, const script_step *step, const svo_solid_info *info)
{
    char text[4500];
    const uint64_t open = info->open_columns[0] + info->open_columns[1] + info->open_columns[2];
    if (open > 0) {
        (void)snprintf(text, sizeof text,
                       "%s:%u: %s is not closed: %" PRIu64 " columns of voxels, and %" PRIu64 " voxels are ambiguous",
                       script->path, script->line, step->file, open, info->ambiguous_voxels);
        program_log(state, SVO_LOG_WARNING, text);
    }
}

static int make(program *state, const edit_script *script, const script_step *step, session *opened, svo_voxels **out)
{
    input source;
    svo_mesh placed;
    placed_arrays own = {NULL, NULL};
    svo_tree *tree = NULL;
    svo_message message = {""};
    svo_solid_info info = SVO_SOLID_INFO_INIT;
    int exit_code = input_open(state, &source);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = opened->device != NULL ? PROGRAM_DONE : session_open(state, opened);
    if (exit_code == PROGRAM_DONE) {
        exit_code = place(state, source.mesh, &step->mesh, &placed, &own);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = build(state, opened, &placed, step, &tree, &info);
    }
    if (exit_code == PROGRAM_DONE && list_leaves(tree, step, out, &message) != SVO_OK) {
        exit_code = program_fail_library(state, message.text);
    }
    if (exit_code == PROGRAM_DONE) {
        warn_open(state, script, step, &info);
    }
    svo_tree_destroy(&tree);
    free(own.positions);
    free(own.normals);
    input_close(&source);
    return exit_code;
}

int edit_mesh_make(program *state, const edit_script *script, const script_step *step, session *opened,
                   svo_voxels **out)
{
    const char *before = state->options.input;
    state->options.input = step->file;
    int exit_code = PROGRAM_DONE;
    if (input_is_tree(state) || voxel_input_is_given(state)) {
        svo_message text;
        (void)snprintf(text.text, sizeof text.text, "%s is no file of a mesh", step->file);
        exit_code = edit_script_fail(state, script, PROGRAM_FAILED, text.text);
    } else {
        exit_code = make(state, script, step, opened, out);
    }
    state->options.input = before;
    return exit_code;
}
