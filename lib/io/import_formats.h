/* SPDX-License-Identifier: MIT */
/* The mesh formats that have readers of the library's own, in the import child. */
#ifndef SVO_LIB_IO_IMPORT_FORMATS_H
#define SVO_LIB_IO_IMPORT_FORMATS_H

#include "io/import_reader.h"

typedef enum mesh_format {
    MESH_FORMAT_OTHER = 0, /* none of these: for assimp */
    MESH_FORMAT_OBJ,
    MESH_FORMAT_PLY,
    MESH_FORMAT_STL,
    MESH_FORMAT_OFF,
    MESH_FORMAT_GLTF
} mesh_format;

/* Judged by the suffix of the path, else by the first bytes. */
mesh_format svo_i_mesh_format(const char *path, const char *bytes, size_t byte_count);

/*
 * Reads a mesh of one of the formats above.
 * Returns SVO_IMPORT_FAILED or SVO_OUT_OF_HOST_MEMORY, with words without the path. A mesh without a triangle fails. So
 * does glTF 1.0, and the counts name assimp as its reader.
 */
svo_status svo_i_read_mesh(mesh_reader *reader, mesh_format format);

#endif
