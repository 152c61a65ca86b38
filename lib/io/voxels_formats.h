/* SPDX-License-Identifier: MIT */
/* The readers and writers of voxel files, one of each for a format. */
#ifndef SVO_LIB_IO_VOXELS_FORMATS_H
#define SVO_LIB_IO_VOXELS_FORMATS_H

#include "io/voxels_files.h"

/* Reads a file of one format into the reader's voxels and properties. */
svo_status svo_i_voxels_read_vox(voxel_reader *reader);
svo_status svo_i_voxels_read_svx(voxel_reader *reader);
svo_status svo_i_voxels_read_nvdb(voxel_reader *reader);
svo_status svo_i_voxels_read_vdb(voxel_reader *reader);
svo_status svo_i_voxels_read_bt(voxel_reader *reader);

/* Checks a .vox file and fills the reader's info, as reading does, without a list. Where the reader has a take_part,
   the models go there. */
svo_status svo_i_voxels_check_vox(voxel_reader *reader);

/* Write a file of one format. */
svo_status svo_i_voxels_write_vox(voxel_writer *writer);
svo_status svo_i_voxels_write_svx(voxel_writer *writer);
svo_status svo_i_voxels_write_nvdb(voxel_writer *writer);
svo_status svo_i_voxels_write_vdb(voxel_writer *writer);
svo_status svo_i_voxels_write_bt(voxel_writer *writer);
/* Writes a list to a sink, for the functions that save lists. writer: what is to be written, and how. info: NULL
   allowed. */
svo_status svo_i_voxels_save_by(const char *function, const svo_voxels *voxels, svo_sink sink, svo_voxel_format format,
                                voxel_writer *writer, svo_voxels_save_info *info, svo_message *message);
/* Writes the merged faces as .ply or .obj. */
svo_status svo_i_voxels_write_faces(voxel_writer *writer, svo_voxel_format format);

/* The first line of a .bt file. */
#define VOXELS_BT_MAGIC "# Octomap OcTree binary file"

/* ---- .svx, as its reader and its writer share it ---- */

#define SVX_MANIFEST   "manifest.xml"
#define SVX_CELLS_MAX  ((uint64_t)1 << 31) /* most cells of a grid */
#define SVX_SIDE_MAX   16384 /* most pixels along a side of a slice */
#define SVX_PIXELS_MAX ((uint64_t)1 << 27) /* most pixels of a slice */

/* What channels are for. */
typedef enum svx_kind { SVX_DENSITY, SVX_COLOR, SVX_MATERIAL, SVX_KINDS } svx_kind;

/* Why there is neither where the library is built without what they need. */
#define VOXELS_NO_SVX  ".svx needs libzip and expat, which svocl was built without"
#define VOXELS_NO_NVDB ".nvdb needs NanoVDB's header, which svocl was built without"
#define VOXELS_NO_VDB  ".vdb needs zlib, which svocl was built without"

#endif
