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

#include "svocl/io.h"

/* Of a block at most. */
#define BLOCK_TRIANGLES 16384

typedef struct svo_i_blocks svo_i_blocks;

/* Opens a file. message: kept for all calls. SVO_UNSUPPORTED: a file that is imported whole, and the message says why;
   SVO_FILE_ERROR; SVO_IMPORT_FAILED: counts that the file is too short for. */
svo_status svo_i_blocks_open(const char *path, svo_i_blocks **out, svo_message *message);
/* The next block; triangle_count is 0 at the end. Its arrays are valid until the next call. A corner that does not
   exist is NaN. Returns as above; SVO_UNSUPPORTED comes in the first pass if at all. */
svo_status svo_i_blocks_next(svo_i_blocks *blocks, svo_mesh *block);
/* Begins again. Colors of some STL files are known, and given, from the second pass on. */
void svo_i_blocks_rewind(svo_i_blocks *blocks);
void svo_i_blocks_close(svo_i_blocks **blocks);

#endif
