/* SPDX-License-Identifier: MIT */
/*
 * Writes triangles to the files of the parts that they meet, each once, in one pass over a run of the mesh. A run has a
 * section of each part's file, from the counts of the runs before it, so that several processes write one file.
 */
#ifndef SVO_LIB_PARTS_SECTIONS_H
#define SVO_LIB_PARTS_SECTIONS_H

#include "parts/cells.h"
#include "parts/triangles.h"

/* What a run writes of a part. */
typedef struct svo_i_section {
    uint64_t code;
    uint32_t level;
    uint32_t reserved; /* 0 */
    uint64_t first; /* record of the part's file */
    uint64_t count; /* of records to be written */
} svo_i_section;

typedef struct svo_i_sections svo_i_sections;

/* place: the folder of the parts' files. list: in the order of svo_i_cut; parts do not overlap. cells_level: of the
   histogram. header, place, list and message must outlive it. */
svo_status svo_i_sections_begin(const svo_part_header *header, uint32_t cells_level, uint32_t fields, const char *place,
                                const svo_i_section *list, size_t count, svo_message *message, svo_i_sections **out);
/* Appends a triangle's record to the sections of all parts that it meets. record: with its name. */
svo_status svo_i_sections_add(svo_i_sections *sections, const int32_t corners[3][3], const unsigned char *record,
                              uint64_t hash_of_record, uint32_t name);
/* Writes what is left, and compares the counts. hashes: count; receives those of the sections. */
svo_status svo_i_sections_finish(svo_i_sections *sections, svo_i_triangle_hash *hashes);
void svo_i_sections_free(svo_i_sections **sections);

#endif
