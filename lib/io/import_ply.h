/* SPDX-License-Identifier: MIT */
/* The reader of PLY files in the import child. */
#ifndef SVO_LIB_IO_IMPORT_PLY_H
#define SVO_LIB_IO_IMPORT_PLY_H

#include "io/import_reader.h"

/* Gathers the mesh of a file, which may be without triangles. Returns SVO_IMPORT_FAILED or SVO_OUT_OF_HOST_MEMORY. */
svo_status svo_i_read_ply(mesh_reader *reader);

#endif
