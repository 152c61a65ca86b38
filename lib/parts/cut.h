/* SPDX-License-Identifier: MIT */
/* The cut of the grid into parts, from a histogram of its triangles: the same whoever counted. */
#ifndef SVO_LIB_PARTS_CUT_H
#define SVO_LIB_PARTS_CUT_H

#include "parts/cells.h"
#include "parts/folder.h"

/* A part of the cut. */
typedef struct svo_i_cut_part {
    svo_i_part_entry entry;
    bool fits; /* false: it is to be planned, and divided where it does not fit */
} svo_i_cut_part;

typedef struct svo_i_cut {
    svo_i_cut_part *parts; /* in the order of Morton codes */
    size_t count, capacity;
} svo_i_cut;

/* The first level with parts: a part has SVO_DEPTH_MAX levels at most. */
uint32_t svo_i_cut_first_level(const svo_part_header *header);
/* Sets the limit of a part where none is given, from the buffers of the whole: a sixteenth of them, or what the least
   part needs. list: with totals. */
svo_status svo_i_cut_choose_limit(svo_parts *parts, svo_device *device, const svo_i_cell_list *list,
                                  svo_message *message);
/* How deep a histogram is worth it: parts of triangles, or of one surface that fills its cell. triangles: of the mesh,
   or more. */
uint32_t svo_i_cut_level(const svo_parts *parts, unsigned depth, uint64_t triangles);
/* What is said of a limit that no part fits. */
svo_status svo_i_cut_refuse_limit(const svo_parts *parts, svo_message *message);
/* parts: header, limit and fields are set. list: with totals. cut: all zero; to be freed also after a failure. */
svo_status svo_i_cut_make(const svo_parts *parts, svo_device *device, const svo_i_cell_list *list, svo_i_cut *cut,
                          svo_message *message);
/* Host memory of the build of a part of so many triangles, and the least that host and buffers take. */
uint64_t svo_i_parts_host_bytes(const svo_parts *parts, uint64_t triangles);
uint64_t svo_i_parts_least_bytes(const svo_parts *parts, uint64_t triangles);

/* Completes the files of triangles of a cut, whose records are there. hashes: of each part. */
svo_status svo_i_cut_write_tails(const svo_parts *parts, const svo_i_cut *cut, const svo_i_triangle_hash *hashes,
                                 svo_message *message);
void svo_i_cut_free(svo_i_cut *cut);

#endif
