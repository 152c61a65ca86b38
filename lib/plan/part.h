/* SPDX-License-Identifier: MIT */
/* The header of all parts of a tree, from a plan of the whole or by a survey of a mesh that is not in memory. */
#ifndef SVO_LIB_PLAN_PART_H
#define SVO_LIB_PLAN_PART_H

#include "plan/attributes.h"
#include "plan/grid.h"

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

SVO_I_SHARED_BEGIN

/* empty: a plan of a mesh without triangles, for the same request; it becomes the whole. SVO_UNSUPPORTED: of a need for
   which the mesh must be there. */
svo_status svo_i_survey_begin(svo_plan *empty, svo_i_survey *survey);
/* Blocks have positions in floats, no indices and no materials. A triangle that is not finite is refused. */
void svo_i_survey_bounds(svo_i_survey *survey, const svo_mesh *block);
/* After the last block's bounds. */
svo_status svo_i_survey_fit(svo_i_survey *survey);
/* kept: room for the block's triangles; receives which of them the tree keeps. */
svo_status svo_i_survey_add(svo_i_survey *survey, const svo_mesh *block, uint32_t *kept, uint32_t *kept_count);
/* After the last block. */
svo_status svo_i_survey_header(svo_i_survey *survey, svo_part_header *header);

SVO_I_SHARED_END

#endif
