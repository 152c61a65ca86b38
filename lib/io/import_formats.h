/* SPDX-License-Identifier: MIT */
/*
 * The readers of mesh formats, in the import child: the library's own, and what becomes of assimp's scenes. The formats
 * that the library reads itself are read faster, in full, and with messages that name a line or a byte.
 *
 * assimp 5.2.5 has the same numbers of text STL and OFF within an ulp, but names no line. It drops triangles of facets
 * with five corners, takes faces that name no vertex, and ends with an assertion where an OFF file is cut off.
 */
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

/* ---- the readers ---- */

/* Gather the mesh of a file, which may be without triangles. Return SVO_IMPORT_FAILED or SVO_OUT_OF_HOST_MEMORY. */
svo_status svo_i_read_obj(mesh_reader *reader);
svo_status svo_i_read_ply(mesh_reader *reader);
svo_status svo_i_read_off(mesh_reader *reader);
svo_status svo_i_read_stl(mesh_reader *reader);
/* Of glTF 2.0, text or binary. A file of glTF 1.0 fails and names assimp as its reader in the counts. */
svo_status svo_i_read_gltf(const mesh_reader *reader);

/* ---- binary STL, as its reader and the one that reads blocks share it ---- */

#define STL_BEGIN_BYTES 84 /* of a binary file: the header and the number of facets */
#define STL_FACET_BYTES 50

/* The begin of a binary file. */
typedef struct stl_begin {
    uint32_t facet_count;
    bool is_magics; /* the header has a color, and facets follow Magics */
    uint8_t color[4]; /* that, or white */
} stl_begin;

/* Whether a file is text, by its first bytes. The length tells binary files from text, since headers of binary files
   may begin with "solid" as well. */
bool svo_i_stl_is_text(const char *bytes, size_t byte_count, uint64_t whole_bytes);
/* bytes: the first STL_BEGIN_BYTES. */
stl_begin svo_i_stl_read_begin(const char *bytes);
/* A facet's normal and corners, and its color, that of begin if it has none of its own. Returns whether it has. */
bool svo_i_stl_read_facet(const char *facet, const stl_begin *begin, float values[12], uint8_t rgba[4]);

/* ---- assimp ---- */

/*
 * Reads a file of any other format. reader: its path, stream, mesh and message alone.
 * Returns SVO_IMPORT_FAILED with words, or SVO_FILE_ERROR without any when the parent is gone.
 */
svo_status svo_i_read_scene(const mesh_reader *reader);

#endif
