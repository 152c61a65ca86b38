/* SPDX-License-Identifier: MIT */
/* The meshes of the cases: scenes, and variants of them. */
#ifndef SVOCL_TOOLS_SNAPSHOT_MESHES_H
#define SVOCL_TOOLS_SNAPSHOT_MESHES_H

#include "cases.h"

#define MESH_TEXTURE_EDGE 16

/* One mesh at a time; all zero at first. */
typedef struct case_mesh {
    const char *scene; /* the scene it was made from; NULL: none yet */
    mesh_variant variant;
    struct scene *made;
    svo_mesh mesh;
    void *arrays[3]; /* a variant's own */
    uint8_t texels[MESH_TEXTURE_EDGE * MESH_TEXTURE_EDGE * 4];
    svo_texture texture;
    svo_material materials[2];
} case_mesh;

/* The mesh of a request, generated again if it differs from the last one. NULL: the message says why. */
const svo_mesh *case_mesh_get(case_mesh *kept, const request *wanted, svo_message *message);
void case_mesh_release(case_mesh *kept);

#endif
