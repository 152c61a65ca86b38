/* SPDX-License-Identifier: MIT */
/* Lists of voxels and their files, in the memory of the ledger, for test_memory. */
#ifndef SVOCL_TESTS_MEMORY_VOXELS_H
#define SVOCL_TESTS_MEMORY_VOXELS_H

#include <stdbool.h>

#include "svocl/voxel_files.h"

/* What a scenario makes. */
typedef struct memory_voxels {
    svo_voxels *list, *again;
} memory_voxels;

/* Makes a list, with properties, of more colors than a palette has. doubled: each voxel is given twice. */
svo_status memory_voxels_make(memory_voxels *of, bool doubled, svo_message *message);
void memory_voxels_destroy(memory_voxels *of);

/* Writes the list in each format: into memory, which the functions below read, and as .vox to a path. */
svo_status memory_voxels_write(const memory_voxels *of, const char *path, svo_message *message);

/* Whether the library writes and reads files of a format. */
bool memory_voxels_have(svo_voxel_format format);

/* Read a file that was written before, and check that the list fills the same box. */
svo_status memory_voxels_load_path(memory_voxels *of, const char *path, svo_message *message);
svo_status memory_voxels_load(memory_voxels *of, svo_voxel_format format, svo_message *message);

#endif
