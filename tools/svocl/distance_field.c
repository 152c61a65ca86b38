/* SPDX-License-Identifier: MIT */
#include "svocl/distance_field.h"

#include <math.h>
#include <stdio.h>

#include "support/options_parse.h"
#include "support/voxel_input.h"

const char *distance_field_sign(const program *state)
{
    return state->options.sign == OPTION_SIGN_NONE ? "none"
                                                   : svo_name(SVO_NAME_SOLID_RULE, (svo_solid_rule)state->options.sign);
}

int distance_field_check(program *state, const char *what)
{
    static const char *const of_payload[] = {"need", "weights", "payload-level", NULL};
    static const char *const of_lists[] = {"drop-alpha", NULL};
    static const char *const of_meshes[] = {"margin", NULL};
    static const char *const of_grids[] = {"edge", "origin", NULL};
    char words[96];
    (void)snprintf(words, sizeof words, "to %s", what);
    if (options_refuse(state, of_payload, words) != PROGRAM_DONE ||
        options_refuse(state, of_lists, "to distances, which are those to the whole surface") != PROGRAM_DONE ||
        (input_is_tree(state) &&
         options_refuse(state, of_meshes, "to a finished tree, whose grid is as it is") != PROGRAM_DONE) ||
        (state->options.margin >= 0 && options_refuse(state, of_grids, "with --margin") != PROGRAM_DONE)) {
        return PROGRAM_WRONG_USAGE;
    }
    if (input_is_compact(state) || voxel_input_is_given(state)) {
        return program_fail(state, PROGRAM_WRONG_USAGE,
                            "%s has no triangles; %s takes a mesh, or a .svo file with rays", state->options.input,
                            state->command);
    }
    return PROGRAM_DONE;
}

/* ---- the grid ---- */

/* The bounds of the corners of triangles that the library takes. Returns false without any. */
static bool find_bounds(const svo_mesh *mesh, double low[3], double high[3])
{
    bool found = false;
    for (size_t i = 0; i < 3 * mesh->triangle_count; ++i) {
        const uint64_t vertex = mesh->indices[i];
        double at[3] = {NAN, NAN, NAN};
        for (size_t axis = 0; axis < 3 && vertex < mesh->vertex_count; ++axis) {
            at[axis] = mesh->positions_double != NULL ? mesh->positions_double[3 * vertex + axis]
                                                      : (double)mesh->positions[3 * vertex + axis];
        }
        if (!isfinite(at[0]) || !isfinite(at[1]) || !isfinite(at[2])) {
            continue;
        }
        for (int axis = 0; axis < 3; ++axis) {
            low[axis] = found ? fmin(low[axis], at[axis]) : at[axis];
            high[axis] = found ? fmax(high[axis], at[axis]) : at[axis];
        }
        found = true;
    }
    return found;
}

/* Rounds up to 24 bits, so that planes between voxels are doubles that neighbors agree on. */
static double round_up(double edge)
{
    int exponent = 0;
    const double share = frexp(edge, &exponent);
    return ldexp(ceil(ldexp(share, 24)), exponent - 24);
}

/* Sets --origin and --edge, unless they are given. */
static int make_room(program *state, const svo_mesh *mesh, double room, double offset)
{
    options *given = &state->options;
    const double voxels = ldexp(1.0, (int)given->depth);
    double low[3];
    double high[3];
    if (given->edge > 0 || mesh == NULL || !find_bounds(mesh, low, high)) {
        return PROGRAM_DONE;
    }
    if (2 * room >= voxels) {
        return program_fail(state, PROGRAM_WRONG_USAGE,
                            "a margin of %g voxels on each side leaves nothing of %g; give a larger --depth or a "
                            "smaller --margin",
                            room, voxels);
    }
    const double widest = fmax(high[0] - low[0], fmax(high[1] - low[1], high[2] - low[2]));
    if (widest > 0) {
        const double edge = round_up((widest + 2 * offset) * (1 + 0x1p-20) * voxels / (voxels - 2 * room));
        for (int axis = 0; axis < 3; ++axis) {
            /* A multiple of a small part of a voxel, so that centers are exact. */
            const double step = edge / voxels * 0x1p-8;
            given->origin[axis] = floor(((low[axis] + high[axis]) / 2 - edge / 2) / step) * step;
        }
        given->edge = edge;
    }
    return PROGRAM_DONE;
}

/* ---- making ---- */

int distance_field_open(program *state, uint32_t need, double room, double offset, unsigned further_steps,
                        distance_field *out)
{
    *out = (distance_field){.sdf = NULL};
    if (input_is_tree(state)) {
        return job_load(state, further_steps, &out->made);
    }
    int exit_code = job_open(state, need, further_steps, &out->made);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = make_room(state, out->made.source.mesh, room, offset);
    if (exit_code == PROGRAM_DONE) {
        exit_code = job_build(state, need, &out->made);
    }
    if (exit_code != PROGRAM_DONE) {
        job_release(&out->made);
    }
    return exit_code;
}

int distance_field_make(program *state, float band, distance_field *field)
{
    const session *opened = &field->made.opened;
    const options *given = &state->options;
    const svo_sdf_options asked = {.struct_size = sizeof asked,
                                   .band = band,
                                   .is_unsigned = given->sign == OPTION_SIGN_NONE,
                                   .rule = given->sign == SVO_SOLID_PARITY ? SVO_SOLID_PARITY : SVO_SOLID_WINDING};
    progress_step(state->progress, "finding distances");
    const double started_ms = input_now_ms();
    if (svo_sdf_create(field->made.result.tree, &asked, opened->queue, &field->sdf) != SVO_OK) {
        return program_fail_library(state, svo_device_message(opened->device));
    }
    field->make_ms = input_now_ms() - started_ms;
    if (svo_sdf_download(field->sdf, opened->queue) != SVO_OK) {
        return program_fail_library(state, svo_device_message(opened->device));
    }
    field->info = (svo_sdf_info)SVO_SDF_INFO_INIT;
    field->arrays = (svo_sdf_arrays)SVO_SDF_ARRAYS_INIT;
    (void)svo_sdf_get_info(field->sdf, &field->info);
    (void)svo_sdf_get_arrays(field->sdf, &field->arrays);
    return PROGRAM_DONE;
}

void distance_field_release(distance_field *field)
{
    svo_sdf_destroy(&field->sdf);
    job_release(&field->made);
}
