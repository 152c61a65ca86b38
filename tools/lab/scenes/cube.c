/* SPDX-License-Identifier: MIT */
/* cube: the unit cube, every face n * n squares and a color of its own; the seed turns the colors. */
#include "list.h"
#include "parts.h"

void scene_cube(scene_builder *builder, const scene_request *request)
{
    static const vector3 colors[6] = {{0.85, 0.30, 0.25}, {0.95, 0.75, 0.25}, {0.35, 0.60, 0.85},
                                      {0.45, 0.70, 0.40}, {0.60, 0.45, 0.75}, {0.90, 0.88, 0.84}};
    /* The nearest 12 * n * n. */
    uint32_t cells = 1;
    while (12u * cells * cells + 12u * (cells + 1) * (cells + 1) < 2 * request->triangles) {
        ++cells;
    }
    const vector3 axes[3] = {vector(1, 0, 0), vector(0, 1, 0), vector(0, 0, 1)};
    for (uint32_t face = 0; face < 6; ++face) {
        const uint32_t axis = face % 3;
        const vector3 first = axes[(axis + (face < 3 ? 1 : 2)) % 3];
        const vector3 second = axes[(axis + (face < 3 ? 2 : 1)) % 3];
        panel flat = {.edge_u = first, .edge_v = second, .color = colors[(face + request->seed) % 6]};
        flat.corner = face < 3 ? axes[axis] : vector(0, 0, 0);
        part_panel(builder, &flat, cells, cells);
    }
}
