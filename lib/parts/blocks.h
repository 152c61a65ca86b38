/* SPDX-License-Identifier: MIT */
/*
 * Mesh files read in blocks of triangles, so that the mesh is never in memory as a whole: binary STL, and binary PLY of
 * vertices and faces alone. Triangles come in the order and with the values that svo_import_file gives, each with
 * corners of its own. What is left out there with a warning is left out here without one.
 *
 * Files are not trusted: every count is compared with the file's length before it is used.
 */
#ifndef SVO_LIB_PARTS_BLOCKS_H
#define SVO_LIB_PARTS_BLOCKS_H

#include "plan/grid.h"
#include "svocl/io.h"

/* Of a block at most. */
#define BLOCK_TRIANGLES 16384

typedef struct svo_i_blocks svo_i_blocks;

/* Opens a file. message: kept for all calls. SVO_UNSUPPORTED: a file that is imported whole, and the message says why;
   SVO_FILE_ERROR; SVO_IMPORT_FAILED: counts that the file is too short for. All items are selected. */
svo_status svo_i_blocks_open(const char *path, svo_i_blocks **out, svo_message *message);
/* The next block; triangle_count is 0 at the end. Its arrays are valid until the next call. A corner that does not
   exist is NaN. Returns as above; SVO_UNSUPPORTED comes in the first pass over an item if at all. */
svo_status svo_i_blocks_next(svo_i_blocks *blocks, svo_mesh *block);
/* What a file has. */
typedef struct svo_i_blocks_extent {
    uint64_t file_bytes;
    uint64_t items; /* faces or facets */
    uint64_t vertices; /* that bounds are found from: of a PLY file, or a facet's three as one */
    bool is_even; /* all items seem to have one length, so that reading may begin at any */
    bool has_normals, has_colors; /* of blocks; colors as svo_i_blocks_select was told */
} svo_i_blocks_extent;

svo_i_blocks_extent svo_i_blocks_get_extent(const svo_i_blocks *blocks);
/* The next blocks are of the items begin .. end; all of them, where the file is not even. any_color: of the facets of
   an STL file, as svo_i_blocks_bounds found it. */
void svo_i_blocks_select(svo_i_blocks *blocks, uint64_t begin, uint64_t end, bool any_color);
/* Whether reading some of the items failed because they have not one length. */
bool svo_i_blocks_is_uneven(const svo_i_blocks *blocks);
/* Widens bounds by vertices begin .. end of the extent, also those that no triangle uses, and sets *any_color where a
   facet has a color of its own. Vertices and facets that are not finite have no bounds. */
svo_status svo_i_blocks_bounds(svo_i_blocks *blocks, uint64_t begin, uint64_t end, svo_i_bounds *bounds,
                               bool *any_color);
void svo_i_blocks_close(svo_i_blocks **blocks);

#endif
