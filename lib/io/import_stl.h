/* SPDX-License-Identifier: MIT */
/* The reader of STL files in the import child, and what it shares with the one that reads blocks. */
#ifndef SVO_LIB_IO_IMPORT_STL_H
#define SVO_LIB_IO_IMPORT_STL_H

#include "io/import_reader.h"

/* Gathers the mesh of a file, which may be without triangles. Returns SVO_IMPORT_FAILED or SVO_OUT_OF_HOST_MEMORY. */
svo_status svo_i_read_stl(mesh_reader *reader);

#define STL_BEGIN_BYTES 84 /* of a binary file: the header and the number of facets */
#define STL_FACET_BYTES 50

/* Whether a file is text, by its first bytes. The length tells binary files from text, since headers of binary files
   may begin with "solid" as well. */
bool svo_i_stl_is_text(const char *bytes, size_t byte_count, uint64_t file_bytes);
/* bytes: the first STL_BEGIN_BYTES. */
uint32_t svo_i_stl_facet_count(const char *bytes);
/* The header's color, or white; whether the file follows Magics. */
bool svo_i_stl_header_color(const char *bytes, uint8_t rgba[4]);
/* A facet's normal and corners, and its color, none if it has no color of its own. Returns whether it has. */
bool svo_i_stl_read_facet(const char *facet, bool is_magics, const uint8_t none[4], float values[12], uint8_t rgba[4]);

#endif
