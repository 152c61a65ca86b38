/* SPDX-License-Identifier: MIT */
/* Looks at the six neighbors of each leaf, first to count the faces, then to write them. */
#include "support/voxel_faces.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "svocl/nodes.h"

typedef struct faces {
    const svo_tree *tree;
    svo_tree_info info;
    svo_grid grid;
    svo_tree_arrays arrays;
    placed_mesh *out; /* NULL: counts alone */
    uint64_t count;
} faces;

/* Whether the cell beside a leaf is outside the grid or empty. step: -1 or 1. */
static bool is_open(const faces *f, const svo_node *leaf, int axis, int step)
{
    uint32_t cell[3] = {leaf->cell[0], leaf->cell[1], leaf->cell[2]};
    svo_node found = {.index = 0};
    cell[axis] += (uint32_t)step; /* below 0: wraps, and is out of range */
    return cell[axis] >> f->info.depth != 0 || svo_tree_find_cell(f->tree, f->info.depth, cell, &found) != SVO_OK ||
           found.level < f->info.depth;
}

/* The four vertices from first on get the leaf's payload. */
static void write_payload(const faces *f, const svo_node *leaf, size_t first)
{
    const size_t place = leaf->index - f->info.level_begin[f->info.payload_level];
    for (size_t vertex = first; vertex < first + 4; ++vertex) {
        if (f->arrays.colors != NULL) {
            memcpy(f->out->colors + 4 * vertex, f->arrays.colors + 4 * place, 4);
        }
        for (size_t axis = 0; axis < 3 && f->arrays.normals != NULL; ++axis) {
            f->out->normals[3 * vertex + axis] = (float)f->arrays.normals[3 * place + axis] / 32767;
        }
    }
}

/* The corners of a face go around it so that it looks outwards. */
static void write_face(const faces *f, const svo_node *leaf, int axis, int step)
{
    static const uint32_t corners[6] = {0, 1, 2, 0, 2, 3};
    const size_t first = (size_t)(4 * f->count);
    const int a = (axis + (step > 0 ? 1 : 2)) % 3;
    const int b = (axis + (step > 0 ? 2 : 1)) % 3;
    double box[2][3];
    svo_grid_cell_box(&f->grid, f->info.depth, leaf->cell, box[0], box[1]);
    for (size_t corner = 0; corner < 4; ++corner) {
        double *at = f->out->positions + 3 * (first + corner);
        at[axis] = box[step > 0 ? 1 : 0][axis];
        at[a] = box[corner == 1 || corner == 2 ? 1 : 0][a];
        at[b] = box[corner >= 2 ? 1 : 0][b];
    }
    write_payload(f, leaf, first);
    for (size_t i = 0; i < 6; ++i) {
        f->out->indices[6 * f->count + i] = (uint32_t)first + corners[i];
    }
}

static void go_through(faces *f)
{
    svo_node leaf = {.index = 0};
    f->count = 0;
    for (uint64_t i = f->info.inner_count; i < f->info.node_count; ++i) {
        (void)svo_tree_find_node(f->tree, (uint32_t)i, &leaf);
        for (int side = 0; side < 6; ++side) {
            const int axis = side / 2;
            const int step = side % 2 == 0 ? -1 : 1;
            if (!is_open(f, &leaf, axis, step)) {
                continue;
            }
            if (f->out != NULL) {
                write_face(f, &leaf, axis, step);
            }
            ++f->count;
        }
    }
}

static bool make_arrays(const faces *f, placed_mesh *out)
{
    const size_t count = (size_t)f->count;
    out->positions = calloc(4 * count, 3 * sizeof *out->positions);
    out->indices = calloc(6 * count, sizeof *out->indices);
    out->colors = f->arrays.colors != NULL ? calloc(4 * count, 4) : NULL;
    out->normals = f->arrays.normals != NULL ? calloc(4 * count, 3 * sizeof *out->normals) : NULL;
    out->mesh = (svo_mesh){.struct_size = sizeof out->mesh,
                           .positions_double = out->positions,
                           .vertex_count = 4 * count,
                           .indices = out->indices,
                           .triangle_count = 2 * count,
                           .normals = out->normals,
                           .colors = out->colors};
    return out->positions != NULL && out->indices != NULL && (out->colors != NULL || f->arrays.colors == NULL) &&
           (out->normals != NULL || f->arrays.normals == NULL);
}

int voxel_faces_make(program *state, const char *name, const svo_tree *tree, placed_mesh *out)
{
    faces f = {.tree = tree, .info = SVO_TREE_INFO_INIT, .arrays = SVO_TREE_ARRAYS_INIT};
    *out = (placed_mesh){.positions = NULL};
    (void)svo_tree_get_info(tree, &f.info);
    (void)svo_tree_get_grid(tree, &f.grid);
    (void)svo_tree_get_arrays(tree, &f.arrays);
    go_through(&f);
    if (f.count == 0) {
        return program_fail(state, PROGRAM_FAILED, "%s: the tree has no voxels", name);
    }
    if (2 * f.count > PLACED_TRIANGLES_MAX) {
        return program_fail(state, PROGRAM_FAILED,
                            "%s: %" PRIu64 " triangles around its voxels are above %" PRIu32
                            ", the most that views by cones take",
                            name, 2 * f.count, PLACED_TRIANGLES_MAX);
    }
    if (!make_arrays(&f, out)) {
        placed_mesh_free(out);
        return program_fail(state, PROGRAM_FAILED, "%s: out of memory for %" PRIu64 " faces of voxels", name, f.count);
    }
    f.out = out;
    go_through(&f);
    return PROGRAM_DONE;
}
