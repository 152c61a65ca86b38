/* SPDX-License-Identifier: MIT */
/* The nodes, layers and materials of a .vox file. */
#ifndef SVO_LIB_IO_VOXELS_VOX_NODES_H
#define SVO_LIB_IO_VOXELS_VOX_NODES_H

#include "io/voxels_vox_file.h"

/* Reads one node chunk, or the attributes of a layer, into the file's lists. */
svo_status svo_i_vox_read_transform(vox_file *file, vox_cursor *cursor);
svo_status svo_i_vox_read_group(vox_file *file, vox_cursor *cursor);
svo_status svo_i_vox_read_shape(vox_file *file, vox_cursor *cursor);
svo_status svo_i_vox_read_layer(vox_file *file, vox_cursor *cursor);

/* Reads a material of version 200 or 150 into the reader's properties. */
svo_status svo_i_vox_read_matl(vox_file *file, vox_cursor *cursor);
svo_status svo_i_vox_read_matt(vox_file *file, vox_cursor *cursor);

#endif
