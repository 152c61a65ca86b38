/* SPDX-License-Identifier: MIT */
/* Meshes for the known answers of the plan's kernels, and what the host makes of them. */
#ifndef SVO_LIB_PLAN_PROOF_MESH_H
#define SVO_LIB_PLAN_PROOF_MESH_H

#include "core/proof.h"
#include "plan/attributes.h"

#define SVO_I_PROOF_SOLIDS    271 /* tetrahedra */
#define SVO_I_PROOF_VERTICES  (4 * SVO_I_PROOF_SOLIDS + 3)
#define SVO_I_PROOF_TRIANGLES (4 * SVO_I_PROOF_SOLIDS + 1) /* more than those of a group; an odd number */
#define SVO_I_PROOF_GROUPS    2
#define SVO_I_PROOF_MATERIALS 3

typedef struct svo_i_proof_mesh {
    bool is_open; /* the mesh: of doubles, on a grid that is given */
    float floats[SVO_I_PROOF_VERTICES * 3], normals[SVO_I_PROOF_VERTICES * 3];
    double doubles[SVO_I_PROOF_VERTICES * 3];
    uint32_t indices[SVO_I_PROOF_TRIANGLES * 3], colors[SVO_I_PROOF_VERTICES];
    uint16_t triangle_materials[SVO_I_PROOF_TRIANGLES];
    svo_material materials[SVO_I_PROOF_MATERIALS];
    svo_mesh mesh;

    svo_plan *plan; /* by the host; owned */
    uint8_t used[SVO_I_PROOF_VERTICES], kept[SVO_I_PROOF_VERTICES];
    int32_t vertices[SVO_I_PROOF_VERTICES * 3]; /* snapped, also those that no kept triangle uses */
    uint64_t remainders[SVO_I_PROOF_VERTICES];
    uint64_t bounds[SVO_I_PROOF_GROUPS][6]; /* keys of snap.cl */
    uint16_t fates[SVO_I_PROOF_TRIANGLES];
    float fragments[SVO_I_PROOF_TRIANGLES];
    uint64_t rows[SVO_I_PROOF_GROUPS][SVO_PLAN_SUMS], before[SVO_I_PROOF_GROUPS][SVO_PLAN_SUMS];
    svo_i_findings found;
    uint8_t material_used[SVO_I_PROOF_MATERIALS];
    double positions[SVO_I_PROOF_VERTICES * 3]; /* of the kept triangles' vertices, in the words of the mesh */
} svo_i_proof_mesh;

/*
 * Makes a mesh and its plan. Two meshes: closed, of floats, on a fitted grid; open, of doubles, with triangles outside
 * the grid, beyond all grids or not finite, and vertices a last bit beside units, which products that are fused with
 * sums would put on the other side.
 *
 * out: receives all; its plan is the caller's to destroy, after a failure too.
 */
svo_status svo_i_proof_mesh_make(svo_i_proof *proof, bool is_open, svo_i_proof_mesh *out);

#endif
