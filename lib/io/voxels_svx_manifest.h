/* SPDX-License-Identifier: MIT */
/* The manifest of a .svx file. */
#ifndef SVO_LIB_IO_VOXELS_SVX_MANIFEST_H
#define SVO_LIB_IO_VOXELS_SVX_MANIFEST_H

#include "io/voxels_reader.h"
#include "io/voxels_svx.h"

/* Reads the text of a manifest and checks its numbers. */
svo_status svo_i_svx_read_manifest(const voxel_reader *reader, const char *text, size_t byte_count,
                                   svx_manifest *manifest);

#endif
