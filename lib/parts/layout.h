/* SPDX-License-Identifier: MIT */
/*
 * How a .svo file is divided into shares that processes write side by side (shares.c). A share has a run of parts,
 * which it copies to their places in the file, and chunks, whose checksums it finds from all parts.
 *
 * The file "stitch-COUNT" in the place of a plan has all that a share needs but the parts themselves: their counts, the
 * nodes above them, who does what, and the token of the file that is written.
 */
#ifndef SVO_LIB_PARTS_LAYOUT_H
#define SVO_LIB_PARTS_LAYOUT_H

#include "parts/chunks.h"
#include "parts/folder.h"

typedef struct svo_i_layout {
    char token[OWNER_BYTES]; /* a name that no other file has; "": none yet */
    uint32_t share_count;
    uint32_t owners[FILE_CHUNKS_MAX]; /* the share that finds the checksum of each chunk */
    uint32_t *shares; /* the share of each part, ascending */
    char **paths; /* of the parts */
    size_t path_count;
} svo_i_layout;

/* Divides the work of a stitcher, whose chunks are placed, among share_count shares. */
svo_status svo_i_layout_make(const svo_i_stitcher *s, svo_i_layout *layout);
/* Whether the folder has the same layout; its token is taken. What cannot be read is another. */
bool svo_i_layout_is_there(const svo_parts *parts, const svo_i_stitcher *s, svo_i_layout *layout);
svo_status svo_i_layout_save(const svo_parts *parts, const svo_i_stitcher *s, const svo_i_layout *layout);
/* Reads the layout of share_count shares, and sets the parts of a stitcher by it. SVO_UNAVAILABLE: there is none. */
svo_status svo_i_layout_load(const svo_parts *parts, svo_i_stitcher *s, svo_i_layout *layout);
void svo_i_layout_free(svo_i_layout *layout);

/* The file of a layout; released by svo_i_free. NULL when out of memory. */
char *svo_i_layout_path(const svo_parts *parts, uint32_t share_count);

#endif
