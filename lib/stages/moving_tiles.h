/* SPDX-License-Identifier: MIT */
/* Tiles of large triangles by a kernel, for plans whose mesh the host does not see. plan/tiles.h is for others. */
#ifndef SVO_LIB_STAGES_MOVING_TILES_H
#define SVO_LIB_STAGES_MOVING_TILES_H

#include "commands/commands.h"

/* Buffers of the voxelizer. */
typedef struct svo_i_moving_tiles {
    cl_mem vertices, indices, items, counters;
    cl_mem tiles; /* has room for svo_i_update_tiles_max */
    cl_mem count;
} svo_i_moving_tiles;

/* Lists the tiles of a draw in place of those before. params: of the draw; tile_count is the room. */
svo_status svo_i_moving_tiles_make(svo_i_commands *commands, const svo_i_moving_tiles *buffers,
                                   const svo_voxelize_params *params);

#endif
