/* SPDX-License-Identifier: MIT */
/* The payload of a tree by compute shaders: materials, projected areas, colors, normals and fills of nodes. */
#ifndef SVO_GLINTEROP_COMPUTE_PAYLOAD_H
#define SVO_GLINTEROP_COMPUTE_PAYLOAD_H

#include "compute/compute.h"

/* Creates what the plan makes of it, for all levels, from the mesh's attributes. Needs the cursors; the masks and first
   children; for materials the ranges of entries, which it frees where the tree has no leaf lists. */
svo_status svo_i_gl_payload(svo_i_gl_build *gl_build);

#endif
