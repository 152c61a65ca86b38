/* SPDX-License-Identifier: MIT */
/*
 * A folder of parts. "plan" has the header, the list of parts and the materials; a part's files are LEVEL-CODE with a
 * suffix: .tri its triangles, .part its tree, .split in place of that where its children are built instead. "mesh" is
 * what rays meet.
 */
#ifndef SVO_LIB_PARTS_FOLDER_H
#define SVO_LIB_PARTS_FOLDER_H

#include <stdbool.h>

#include "core/memory.h"
#include "parts/triangles.h"
#include "svocl/parts.h"

/* A part of the list. */
typedef struct svo_i_part_entry {
    uint32_t level;
    uint32_t reserved; /* 0 */
    uint64_t code;
    uint64_t triangles;
    uint64_t expected_bytes;
} svo_i_part_entry;

struct svo_parts {
    char *folder;
    svo_part_header header;
    uint64_t max_bytes;
    uint32_t fields; /* of records of triangles */
    uint32_t reserved; /* 0 */
    svo_i_part_entry *entries;
    size_t entry_count, entry_capacity;
    svo_material *materials;
    size_t material_count;
    svo_texture *textures; /* rgba is owned */
    size_t texture_count;
};

/* The path of a file in the folder; released by svo_i_free. NULL when out of memory. */
char *svo_i_folder_path(const svo_parts *parts, const char *name);
char *svo_i_part_path(const svo_parts *parts, uint32_t level, uint64_t code, const char *suffix);

/* Which plan a folder is of, for the files that could be another's: an XXH3-128 of the header, whose input_hash is of
   the mesh, and of what decides how it is divided. */
void svo_i_folder_identity(const svo_parts *parts, uint64_t identity[2]);
/* What a part's file of triangles must be of. */
svo_i_triangles_of svo_i_folder_triangles(const svo_parts *parts, uint32_t level, uint64_t code);

/* A handle without parts; NULL when out of memory. */
svo_parts *svo_i_folder_new(const char *folder, uint64_t max_bytes);
/* Makes the folder, or empties it of all but part files. */
svo_status svo_i_folder_make(const char *folder, svo_message *message);
svo_status svo_i_folder_add(svo_parts *parts, const svo_i_part_entry *entry, svo_message *message);
/* Writes "plan". */
svo_status svo_i_folder_save(const svo_parts *parts, svo_message *message);

/* Whether there is a file; what cannot be told is a failure, since a part would be left out. */
svo_status svo_i_file_find(const char *path, bool *is_there, svo_message *message);
svo_status svo_i_folder_no_memory(const svo_parts *parts, svo_message *message);

#endif
