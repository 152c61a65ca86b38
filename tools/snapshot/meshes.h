/* SPDX-License-Identifier: MIT */
/* The meshes of the cases: scenes, and variants of them. */
#ifndef SVOCL_TOOLS_SNAPSHOT_MESHES_H
#define SVOCL_TOOLS_SNAPSHOT_MESHES_H

#include "cases.h"

#define MESH_TEXTURE_EDGE 16

/* One mesh at a time; all zero at first. */
typedef struct case_mesh {
    const char *scene; /* what it was made of; NULL: nothing yet */
    mesh_variant variant;
    struct scene *made;
    svo_mesh mesh;
    void *arrays[3]; /* a variant's own */
    uint8_t texels[MESH_TEXTURE_EDGE * MESH_TEXTURE_EDGE * 4];
    svo_texture texture;
    svo_material materials[2];
} case_mesh;

/* The mesh of a request, made anew where it is another than the last. NULL: the message says why. */
const svo_mesh *case_mesh_get(case_mesh *kept, const request *asked, svo_message *message);
void case_mesh_release(case_mesh *kept);

#endif
