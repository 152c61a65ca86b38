/* SPDX-License-Identifier: MIT */
#include "support/tree_mesh.h"

#include "support/info_of.h"

/* A vertex in double, which holds floats exactly. */
static void place_of(const float *positions, const double *positions_double, size_t vertex, double out[3])
{
    for (size_t axis = 0; axis < 3; ++axis) {
        const size_t at = 3 * vertex + axis;
        out[axis] = positions_double != NULL ? positions_double[at] : (double)positions[at];
    }
}

/* The corner of a mesh's triangle; false past its end. */
static bool corner_of(const svo_mesh *mesh, uint32_t triangle, size_t corner, double out[3])
{
    const size_t at = 3 * (size_t)triangle + corner;
    const size_t vertex = triangle >= mesh->triangle_count ? SIZE_MAX : mesh->indices != NULL ? mesh->indices[at] : at;
    if (vertex >= mesh->vertex_count) {
        return false;
    }
    place_of(mesh->positions, mesh->positions_double, vertex, out);
    return true;
}

/* The first triangle of the tree that the mesh has elsewhere; the count without one. */
static uint64_t first_other(const svo_tree_arrays *of, uint64_t count, const svo_mesh *mesh)
{
    for (uint64_t i = 0; i < count; ++i) {
        for (size_t corner = 0; corner < 3; ++corner) {
            double own[3], given[3];
            place_of(of->positions, of->positions_double, of->indices[3 * i + corner], own);
            if (!corner_of(mesh, of->triangle_ids[i], corner, given) || own[0] != given[0] || own[1] != given[1] ||
                own[2] != given[2]) {
                return i;
            }
        }
    }
    return count;
}

static int check(program *state, const svo_tree *tree, const svo_mesh *mesh)
{
    const options *given = &state->options;
    const svo_tree_info info = info_of_tree(tree);
    svo_tree_arrays of = SVO_TREE_ARRAYS_INIT;
    if (svo_tree_get_arrays(tree, &of) != SVO_OK || of.triangle_ids == NULL) {
        return program_fail(state, PROGRAM_FAILED, "--mesh %s: the tree of %s has no triangles; it needs --need rays",
                            given->mesh_path, given->input);
    }
    const uint64_t other = first_other(&of, info.list_triangle_count, mesh);
    return other == info.list_triangle_count
               ? PROGRAM_DONE
               : program_fail(state, PROGRAM_FAILED, "--mesh %s: triangle %u is not where the tree of %s has it",
                              given->mesh_path, of.triangle_ids[other], given->input);
}

int tree_mesh_open(program *state, const svo_tree *tree, input *opened)
{
    const char *tree_path = state->options.input;
    state->options.input = state->options.mesh_path;
    int exit_code = input_open(state, opened);
    state->options.input = tree_path;
    if (exit_code == PROGRAM_DONE) {
        exit_code = check(state, tree, opened->mesh);
        if (exit_code != PROGRAM_DONE) {
            input_close(opened);
        }
    }
    return exit_code;
}
