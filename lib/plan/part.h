/* SPDX-License-Identifier: MIT */
/* Parts of a tree: their plans, what they take from the header of the whole, and surveys, which make that header. */
#ifndef SVO_LIB_PLAN_PART_H
#define SVO_LIB_PLAN_PART_H

#include "plan/attributes.h"
#include "plan/grid.h"
#include "plan/plan_data.h"

/* Grid units per axis of a tree of that depth, as a power of two: the same for all depths up to 12, so that their trees
   nest. Above, a voxel has 2^8 units. */
static inline uint32_t svo_i_snap_bits(uint32_t depth)
{
    return depth <= 12 ? 20 : depth + 8;
}

/* Checks the options of a part and replaces those that the header decides. Leaves *part as it is where there is no
   header. */
svo_status svo_i_part_read(svo_device *device, const char *function, uint32_t depth, svo_plan_options *options,
                           svo_i_plan_part *part);

/* Whether a level above the part sums up its root's payload. */
bool svo_i_part_sums_root(const svo_plan *plan);

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
