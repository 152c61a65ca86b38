/* SPDX-License-Identifier: MIT */
/** \file
 * What the parts of a tree have in common: plan.h builds a part from it, parts.h saves parts and puts them together.
 */
#ifndef SVOCL_PART_TYPES_H
#define SVOCL_PART_TYPES_H

#include <stddef.h>
#include <stdint.h>

#include "svocl/status.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SVO_PARTS_LEVELS_MAX 22 /**< SVO_LEVELS_MAX of a tree in parts: SVO_PARTS_DEPTH_MAX + 2 */

/** Bits of svo_part_header.flags. */
typedef enum svo_part_flags {
    SVO_PART_BOTH_SIDES = 1 /**< the mesh is open: its triangles count from both sides in projected areas */
} svo_part_flags;

/** What the whole mesh decides for every part: the grid, the unit of weights, what is constant.
 *  svo_plan_get_part_header reads it from a plan of the whole. Plain values, the same on every device; a part is a
 *  function of it, of the part's place and of the triangles that meet the place. */
typedef struct svo_part_header {
    size_t struct_size; /**< sizeof(svo_part_header) */
    uint32_t depth; /**< of the whole tree */
    uint32_t snap_bits; /**< the whole grid is 2^snap_bits units wide */
    uint32_t coverage; /**< svo_coverage */
    uint32_t need; /**< svo_need bits, resolved: 0 means occupancy alone */
    uint32_t constant; /**< of those, payload that is the same in every node */
    uint32_t weights; /**< svo_weights */
    uint32_t payload_level; /**< of the whole tree */
    uint32_t weight_log2; /**< weight of a voxel's face, as a power of two */
    uint32_t flags; /**< svo_part_flags */
    uint32_t positions; /**< svo_positions of the whole tree */
    uint8_t constant_color[4]; /**< RGBA8 */
    int16_t constant_normal[3]; /**< 32767 = 1 */
    uint16_t constant_material; /**< into the mesh's materials */
    uint32_t least_alpha; /**< 255ths: pairs of less alpha are left out (svo_plan_options.drop_alpha); 0: none are */
    double origin[3]; /**< minimum corner of the whole grid, world */
    double edge; /**< of the whole grid, as svo_plan_info has it */
    double scale; /**< grid units per world unit */
    uint64_t also_reserved; /**< 0 */
    uint64_t triangles; /**< of the mesh */
    uint64_t refused_triangles; /**< of the mesh */
    uint64_t kept_triangles; /**< those accepted whose bounds meet the grid; leaf lists have positions among these */
    uint64_t vertex_count; /**< of the mesh */
    uint64_t input_hash; /**< of the triangles and materials that svo_parts_create wrote; 0 without it */
    double expected_fragments; /**< the fragment estimate of the whole */
    /** Nodes of all levels that the mesh's area alone accounts for: by the fragment estimate without its terms for the
     *  edges of triangles. */
    double expected_nodes;
} svo_part_header;

/** An empty output. */
#define SVO_PART_HEADER_INIT SVO_STRUCT_INIT(svo_part_header)

#ifdef __cplusplus
}
#endif

#endif
