/* SPDX-License-Identifier: MIT */
/* The reader of STL files in the import child. */
#ifndef SVO_LIB_IO_IMPORT_STL_H
#define SVO_LIB_IO_IMPORT_STL_H

#include "io/import_reader.h"

/* Gathers the mesh of a file, which may be without triangles. Returns SVO_IMPORT_FAILED or SVO_OUT_OF_HOST_MEMORY. */
svo_status svo_i_read_stl(mesh_reader *reader);

#endif
