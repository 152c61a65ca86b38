/* SPDX-License-Identifier: MIT */
/* The header of all parts of a tree, from a plan of the whole or by a survey of a mesh that is not in memory. */
#ifndef SVO_LIB_PLAN_PART_H
#define SVO_LIB_PLAN_PART_H

#include <math.h>

#include "plan/attributes.h"
#include "plan/grid.h"
#include "shared/snap.clh"

/*
 * What all parts of a mesh share, found from triangles that come in blocks: so the mesh need not be in memory. All
 * blocks are shown twice, first for their bounds, then for the rest. The header is that of the mesh in one piece.
 */

typedef struct svo_i_survey {
    svo_plan *whole; /* without arrays; the caller's */
    svo_i_bounds bounds;
    svo_i_findings found;
    uint64_t kept; /* triangles that the tree keeps */
    bool has_colors, has_normals; /* whether blocks have them */
    uint8_t material_used[1];
} svo_i_survey;

/* What a survey has found; plain values. */
typedef struct svo_i_survey_sums {
    svo_i_bounds bounds;
    svo_i_findings found; /* its material_used is NULL */
    svo_i_sums sums;
    uint64_t triangles, refused_triangles, outside_triangles, kept;
    uint32_t need; /* resolved; 0 without blocks */
    bool has_colors, has_normals, has_material;
} svo_i_survey_sums;

SVO_I_SHARED_BEGIN

/* empty: a plan of a mesh without triangles, for the same request; it becomes the whole. SVO_UNSUPPORTED: of a need for
   which the mesh must be there. */
svo_status svo_i_survey_begin(svo_plan *empty, svo_i_survey *survey);
/* Bounds of nothing. */
static inline svo_i_bounds svo_i_survey_no_bounds(void)
{
    return (svo_i_bounds){false, {INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
}
/* Blocks have positions in floats, no indices and no materials. A triangle that is not finite is refused. */
void svo_i_survey_bounds(svo_i_survey *survey, const svo_mesh *block);
/* After the last block's bounds. */
svo_status svo_i_survey_fit(svo_i_survey *survey);
/* kept, corners: room for the block's triangles; receives which of them the tree keeps, and where these are, in grid
   units. */
svo_status svo_i_survey_add(svo_i_survey *survey, const svo_mesh *block, uint32_t *kept, int32_t (*corners)[3][3],
                            uint32_t *kept_count);
/* Adds what another survey has found in the triangles that follow, on the same grid. */
void svo_i_survey_get(const svo_i_survey *survey, svo_i_survey_sums *sums);
void svo_i_survey_append(svo_i_survey *survey, const svo_i_survey_sums *next);
/* After the last block. */
svo_status svo_i_survey_header(svo_i_survey *survey, svo_part_header *header);
/* Whether the tree of a header keeps a triangle of such a block, and where it is, in grid units. snap: the header's. */
bool svo_i_survey_places(const svo_part_header *header, const svo_snap *snap, const svo_mesh *block, size_t triangle,
                         int32_t corners[3][3]);

SVO_I_SHARED_END

#endif
