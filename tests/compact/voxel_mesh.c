/* SPDX-License-Identifier: MIT */
/* A triangle inside each voxel. */
#include "voxel_mesh.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include <cmocka.h>

static const svo_material white[VOXEL_MATERIALS] = {
    {{255, 255, 255, 255}, SVO_NO_TEXTURE}, {{255, 255, 255, 255}, SVO_NO_TEXTURE},
    {{255, 255, 255, 255}, SVO_NO_TEXTURE}, {{255, 255, 255, 255}, SVO_NO_TEXTURE},
    {{255, 255, 255, 255}, SVO_NO_TEXTURE}, {{255, 255, 255, 255}, SVO_NO_TEXTURE},
    {{255, 255, 255, 255}, SVO_NO_TEXTURE}, {{255, 255, 255, 255}, SVO_NO_TEXTURE},
    {{255, 255, 255, 255}, SVO_NO_TEXTURE}, {{255, 255, 255, 255}, SVO_NO_TEXTURE},
    {{255, 255, 255, 255}, SVO_NO_TEXTURE}, {{255, 255, 255, 255}, SVO_NO_TEXTURE},
    {{255, 255, 255, 255}, SVO_NO_TEXTURE}, {{255, 255, 255, 255}, SVO_NO_TEXTURE},
    {{255, 255, 255, 255}, SVO_NO_TEXTURE}, {{255, 255, 255, 255}, SVO_NO_TEXTURE},
};

static void put_corner(const voxel *from, size_t vertex, voxel_mesh *out)
{
    const size_t corner = vertex % 3;
    for (size_t axis = 0; axis < 3; ++axis) {
        const double along = axis < 2 && axis + 1 == corner ? from->width : 0;
        out->positions[3 * vertex + axis] = from->cell[axis] + 0.0625 + along;
        out->normals[3 * vertex + axis] = from->normal[axis];
    }
    for (size_t channel = 0; channel < 4; ++channel) {
        out->colors[4 * vertex + channel] = from->rgba[channel];
    }
}

void voxel_mesh_make(const voxel *voxels, size_t voxel_count, unsigned depth, voxel_mesh *out)
{
    *out = (voxel_mesh){.mesh = SVO_MESH_INIT, .options = SVO_PLAN_OPTIONS_INIT};
    out->positions = calloc(9 * voxel_count + 1, sizeof *out->positions);
    out->normals = calloc(9 * voxel_count + 1, sizeof *out->normals);
    out->colors = calloc(12 * voxel_count + 1, 1);
    out->materials = calloc(voxel_count + 1, sizeof *out->materials);
    if (out->positions == NULL || out->normals == NULL || out->colors == NULL || out->materials == NULL) {
        fail_msg("no memory for %zu voxels", voxel_count);
        return;
    }
    for (size_t i = 0; i < voxel_count; ++i) {
        for (size_t corner = 0; corner < 3; ++corner) {
            put_corner(&voxels[i], 3 * i + corner, out);
        }
        out->materials[i] = voxels[i].material;
    }
    out->mesh.positions_double = out->positions;
    out->mesh.vertex_count = 3 * voxel_count;
    out->mesh.triangle_count = voxel_count;
    out->mesh.normals = out->normals;
    out->mesh.colors = out->colors;
    out->mesh.triangle_materials = out->materials;
    out->mesh.materials = white;
    out->mesh.material_count = VOXEL_MATERIALS;
    out->options.edge = (double)(UINT64_C(1) << depth);
}

void voxel_mesh_free(voxel_mesh *made)
{
    free(made->positions);
    free(made->normals);
    free(made->colors);
    free(made->materials);
    *made = (voxel_mesh){.positions = NULL};
}
