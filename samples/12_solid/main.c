/* SPDX-License-Identifier: MIT */
/* The volume of two bodies that overlap: all voxels of the solid, and by parity without what they have in common. */
#include <inttypes.h>
#include <stdbool.h>
#include <stdio.h>

#include "svocl/svocl.h"

#define DEPTH 7

/* Two octahedra with corners one unit from their centers, which are half a unit apart. */
static const float positions[] = {1, 0, 0,    -1, 0, 0,    0, 1, 0,    0, -1, 0,    0, 0, 1,    0, 0, -1,
                                  1, 0, 0.5F, -1, 0, 0.5F, 0, 1, 0.5F, 0, -1, 0.5F, 0, 0, 1.5F, 0, 0, -0.5F};
static const uint32_t octahedron[24] = {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5};

static bool measure(const svo_tree *tree, svo_solid_rule rule)
{
    const svo_solid_options options = {.struct_size = sizeof options, .rule = rule, .color = {200, 160, 90, 255}};
    svo_solid_info info = SVO_SOLID_INFO_INIT;
    svo_compact *solid = NULL;
    svo_grid grid;
    if (svo_tree_get_grid(tree, &grid) != SVO_OK || svo_solid_create(tree, &options, NULL, &solid, &info) != SVO_OK)
        return false;
    const double edge = svo_grid_cell_edge(&grid, DEPTH);
    const double voxel = edge * edge * edge;
    printf("%s: %" PRIu64 " voxels inside in %" PRIu64 " leaves, %" PRIu64
           " on the surface: a volume of %.2f to %.2f\n",
           svo_name(SVO_NAME_SOLID_RULE, rule), info.inside_voxels, info.inside_leaves, info.surface_voxels,
           (double)info.inside_voxels * voxel, (double)(info.inside_voxels + info.surface_voxels) * voxel);
    if (info.open_columns[0] + info.open_columns[1] + info.open_columns[2] > 0)
        printf("the surface is not closed\n");
    svo_compact_destroy(&solid);
    return true;
}

int main(void)
{
    uint32_t indices[2 * 24];
    for (uint32_t i = 0; i < 2 * 24; ++i) {
        indices[i] = octahedron[i % 24] + i / 24 * 6;
    }
    const svo_mesh mesh = {.struct_size = sizeof(svo_mesh),
                           .positions = positions,
                           .vertex_count = 12,
                           .indices = indices,
                           .triangle_count = 16};
    const svo_plan_options options = {.struct_size = sizeof options, .need = SVO_NEED_RAYS | SVO_NEED_COLOR};
    svo_message message = {""};
    svo_device *device = NULL;
    svo_plan *plan = NULL;
    svo_tree *tree = NULL;

    bool done = svo_device_create_default(NULL, &device, &message) == SVO_OK;
    done = done && svo_plan_create(device, &mesh, DEPTH, &options, &plan) == SVO_OK &&
           svo_build(plan, NULL, NULL, &tree, NULL) == SVO_OK && measure(tree, SVO_SOLID_WINDING) &&
           measure(tree, SVO_SOLID_PARITY);
    if (!done)
        fprintf(stderr, "%s\n", device == NULL || message.text[0] != '\0' ? message.text : svo_device_message(device));

    svo_tree_destroy(&tree);
    svo_plan_destroy(&plan);
    svo_device_destroy(&device);
    return done ? 0 : 1;
}
