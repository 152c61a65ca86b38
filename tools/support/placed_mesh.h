/* SPDX-License-Identifier: MIT */
/* One mesh of many placed ones: the surfaces of a scene in its world. */
#ifndef SVOCL_TOOLS_SUPPORT_PLACED_MESH_H
#define SVOCL_TOOLS_SUPPORT_PLACED_MESH_H

#include "support/program.h"
#include "svocl/mesh.h"
#include "svocl/scene.h"

/* Most triangles of a placed mesh, and a third of its most vertices. */
#define PLACED_TRIANGLES_MAX (UINT32_C(1) << 24)

/* A mesh with arrays of its own, but for texels. */
typedef struct placed_mesh {
    svo_mesh mesh; /* all zero: none */
    double *positions;
    uint32_t *indices;
    float *normals;
    uint8_t *colors;
    float *uvs;
    uint16_t *triangle_materials;
    svo_material *materials;
    svo_texture *textures;
    svo_finish *finishes;
} placed_mesh;

/* Places parts by instances, whose trees number the parts. Normals stay on their side, also under mirrors. Parts
   without colors are clay, unless none has colors. Texels are borrowed from the parts. name: of the scene, for
   messages. Returns the exit code; on failure nothing is left to free. */
int placed_mesh_make(program *state, const char *name, const svo_mesh *const *parts, size_t part_count,
                     const svo_instance *instances, size_t instance_count, placed_mesh *out);
void placed_mesh_free(placed_mesh *placed);

#endif
