/* SPDX-License-Identifier: MIT */
/* The readers and writers of voxel files, one of each for a format. */
#ifndef SVO_LIB_IO_VOXELS_FORMATS_H
#define SVO_LIB_IO_VOXELS_FORMATS_H

#include <stdbool.h>

#include "io/voxels_reader.h"
#include "io/voxels_writer.h"

/* Whether z is up in a file of that format. */
bool svo_i_voxels_are_turned(svo_axes axes, svo_voxel_format format);

/* Reads a file of one format into the reader's voxels and properties. */
svo_status svo_i_voxels_read_vox(voxel_reader *reader);
svo_status svo_i_voxels_read_binvox(voxel_reader *reader);
svo_status svo_i_voxels_read_svx(voxel_reader *reader);

/* Write a file of one format. */
svo_status svo_i_voxels_write_vox(voxel_writer *writer);
svo_status svo_i_voxels_write_svx(voxel_writer *writer);
svo_status svo_i_voxels_write_binvox(voxel_writer *writer);
svo_status svo_i_voxels_write_ply(voxel_writer *writer);
svo_status svo_i_voxels_write_obj(voxel_writer *writer);

#endif
