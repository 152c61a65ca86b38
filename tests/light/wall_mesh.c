/* SPDX-License-Identifier: MIT */
#include "wall_mesh.h"

svo_mesh wall_mesh(void)
{
    static const float positions[] = {0, 0.5F, 0, 1, 0.5F, 0, 1, 0.5F, 1, 0, 0.5F, 1, 0, 0, 0, 0, 1, 0};
    static const uint32_t indices[] = {0, 1, 2, 0, 2, 3, 4, 4, 4, 5, 5, 5};
    svo_mesh mesh = SVO_MESH_INIT;
    mesh.positions = positions;
    mesh.vertex_count = 6;
    mesh.indices = indices;
    mesh.triangle_count = 4;
    return mesh;
}

svo_plan_options wall_grid(void)
{
    return (svo_plan_options){.struct_size = sizeof(svo_plan_options),
                              .need = SVO_NEED_COLOR | SVO_NEED_RAYS | SVO_NEED_MATERIAL | SVO_NEED_FILL,
                              .edge = 1};
}
