/* SPDX-License-Identifier: MIT */
/*
 * A folder of parts. "plan" has the header, the list of parts and the materials; a part's files are LEVEL-CODE with a
 * suffix: .part its tree, and in the folder that has the plan's identity for a name, .tri its triangles, and .split in
 * place of a .part where its children are built instead. There is "mesh" too, what rays meet.
 *
 * A plan's identity is that of its tree (svo_i_part_identity), and each file has it. So two plans that differ in the
 * limit of a part alone have one: they cut the same tree, and a part of a place is the same in both.
 */
#ifndef SVO_LIB_PARTS_FOLDER_H
#define SVO_LIB_PARTS_FOLDER_H

#include <stdbool.h>

#include "core/memory.h"
#include "parts/lease.h"
#include "parts/part_file.h"
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
    char *place; /* of the files of the plan but parts: while it is made, below the planner's lease */
    uint64_t identity[2];
    svo_i_planner planner; /* while the plan is made */
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

/* The path of a part's file, or of another file of the plan; released by svo_i_free. NULL when out of memory. */
char *svo_i_part_path(const svo_parts *parts, uint32_t level, uint64_t code, const char *suffix);
char *svo_i_folder_path(const svo_parts *parts, const char *name);

/* What a part's file of triangles must be of. */
svo_i_triangles_of svo_i_folder_triangles(const svo_parts *parts, uint32_t level, uint64_t code);
/* Whether the folder's plan is still the one that was opened. SVO_UNAVAILABLE: the message names both. */
svo_status svo_i_folder_is_current(const svo_parts *parts, svo_message *message);
/* Whether an entry of a folder is a file or the place of a plan other than the one whose place is kept. */
bool svo_i_folder_is_of_other_plans(const char *name, const char *kept);

/* A handle without parts; NULL when out of memory. */
svo_parts *svo_i_folder_new(const char *folder, uint64_t max_bytes);
svo_status svo_i_folder_add(svo_parts *parts, const svo_i_part_entry *entry, svo_message *message);
/* Writes the file "plan" to a path. */
svo_status svo_i_folder_save(const svo_parts *parts, const char *path, svo_message *message);

/* Whether there is a file; what cannot be told is a failure, since a part would be left out. */
svo_status svo_i_file_find(const char *path, bool *is_there, svo_message *message);
/* Reads a whole file. bytes: released by svo_i_free, also after a failure. */
svo_status svo_i_file_read_all(const char *path, unsigned char **bytes, size_t *byte_count, svo_message *message);
/* The same of a file that may not be there: then *bytes stays NULL. */
svo_status svo_i_file_read_found(const char *path, unsigned char **bytes, size_t *byte_count, svo_message *message);
svo_status svo_i_folder_no_memory(const svo_parts *parts, svo_message *message);

#endif
