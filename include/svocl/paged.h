/* SPDX-License-Identifier: MIT */
/** \file
 * Paged trees, part of svocl::io: pictures of a .svo file that is larger than the memory it may take (after Crassin,
 * "GigaVoxels", 2011).
 *
 *     svo_paged_open      file, bytes -> svo_paged: its upper levels, and room for pages
 *     svo_paged_render    a picture of what is there; rays mark the pages that they use and those that they miss
 *     svo_paged_update    reads the pages that were missed
 *     svo_paged_get_counts    whether the picture was complete, and what was read
 *
 * A page is what lies under one node, its root, for a number of levels; below the last of them are the roots of further
 * pages. The levels down to the roots of the first pages are always there. Where a page is absent its root stands in:
 * it is drawn as a voxel, with its own color and normal. So a picture has no holes, and the first one is there at
 * once, coarse; as pages arrive it becomes finer. A ray that stops at a node since that is smaller than a pixel misses
 * nothing.
 *
 * When room is short, pages that no ray used for longest go: by the number of the last picture that used them, and of
 * the same picture deeper ones first, on a level those with the greater Morton code. Pages that the last picture used
 * stay. Nothing depends on time or on the number of threads: the same calls give the same pictures, misses and reads.
 *
 * A picture that misses nothing is, byte for byte, that of the whole tree by svo_render with the same options.
 *
 * The file is read once from end to end when it is opened, apart from lists and geometry, and its checksums are
 * compared. Each page has a checksum of its own, which is compared whenever it is read: a file whose bytes change
 * meanwhile is noticed. A file that is replaced by another of its name stays the one that was opened.
 *
 * Thread-safety: one thread at a time may use a svo_paged and its device handle.
 */
#ifndef SVOCL_PAGED_H
#define SVOCL_PAGED_H

#include <stddef.h>
#include <stdint.h>

#include "svocl/device.h"
#include "svocl/export.h"
#include "svocl/memory.h"
#include "svocl/parts_tree.h"
#include "svocl/status.h"
#include "svocl/trace.h"

#ifdef __cplusplus
extern "C" {
#endif

/** An open file with some of its pages. */
typedef struct svo_paged svo_paged;

/** Options of a paged tree. */
typedef struct svo_paged_options {
    size_t struct_size; /**< sizeof(svo_paged_options) */
    uint32_t page_levels; /**< of a page, 2 .. 5; 0: 3. Fewer follow the view more closely, and take more pages */
    uint32_t reserved; /**< 0 */
    /** An update that has read as many bytes reads no further page; 0: no limit. */
    uint64_t update_bytes;
    const svo_memory_callbacks *memory; /**< host memory, for the whole life of the tree; NULL: malloc and free */
    /** Of a folder of parts, what is drawn. NULL, or last_level 0 for the root: down to svo_parts_tree_info.last_level.
     *  Must be NULL for a .svo file. */
    const svo_parts_region *region;
} svo_paged_options;

/** All defaults. */
#define SVO_PAGED_OPTIONS_INIT SVO_STRUCT_INIT(svo_paged_options)

/** What was opened. */
typedef struct svo_paged_info {
    size_t struct_size; /**< sizeof(svo_paged_info) */
    uint32_t depth; /**< of the tree */
    uint32_t top_level; /**< levels 0 .. top_level are always there: the more, the greater budget_bytes is */
    uint32_t page_levels; /**< of a page */
    uint32_t need; /**< of the file's svo_need bits those that are there: color and normal */
    uint64_t page_count; /**< of all levels below top_level */
    uint64_t file_bytes; /**< length of the file */
    uint64_t device_bytes; /**< of the buffers on the device, all of them: at most what was given */
    /** Of the buffers with these upper levels and room for the largest page alone. A smaller budget may do: it holds
     *  fewer upper levels. One with which svo_paged_open fails names the least of all. */
    uint64_t least_bytes;
    uint64_t whole_bytes; /**< of the buffers with these upper levels and room for all pages */
    uint64_t open_read_bytes; /**< that were read by svo_paged_open */
} svo_paged_info;

/** An empty output. */
#define SVO_PAGED_INFO_INIT SVO_STRUCT_INIT(svo_paged_info)

/** What the last picture and the last update did, and all of them. */
typedef struct svo_paged_counts {
    size_t struct_size; /**< sizeof(svo_paged_counts) */
    uint64_t pictures; /**< that were drawn */
    uint64_t used_pages; /**< by the last picture */
    uint64_t missed_pages; /**< absent ones that the last picture asked for; 0: it was complete */
    uint64_t read_pages; /**< by the last update */
    uint64_t read_bytes; /**< by the last update */
    uint64_t evicted_pages; /**< by the last update */
    uint64_t waiting_pages; /**< missed, and not read by the last update: no room, or update_bytes were read */
    uint64_t held_pages; /**< now */
    uint64_t all_missed_pages; /**< sum over all pictures */
    uint64_t all_read_pages; /**< by all updates */
    uint64_t all_read_bytes; /**< by all updates */
    uint64_t all_evicted_pages; /**< by all updates */
} svo_paged_counts;

/** An empty output. */
#define SVO_PAGED_COUNTS_INIT SVO_STRUCT_INIT(svo_paged_counts)

/** Opens a .svo file of version 3 whose chunks are not compressed, checks it and reads its upper levels. Or a region of
 *  a tree of parts, which is read from the part files, as if the region's .svo file were there (parts_tree.h).
 *
 * Beside the buffers, the host holds 32 bytes for each page of the tree, 4 bytes for each page and level, and at
 * most a few MB of pages on their way.
 *
 * \param device that draws; must outlive the paged tree
 * \param path of the file, which stays open; or of a folder of parts, or of the file "plan" in it
 * \param budget_bytes for buffers on the device: svo_paged_info.device_bytes is at most that. Pictures come on top
 * \param options NULL means all defaults
 * \param out receives the paged tree
 * \returns SVO_FILE_ERROR (cannot be read), SVO_FILE_DAMAGED, SVO_UNSUPPORTED (an older version, compressed, payload
 *          not on all levels, or the grid is beyond the range of floats), what svo_parts_tree_load
 *          returns of a region, SVO_CAPACITY_EXCEEDED (budget_bytes is too small; the message has the least number),
 *          SVO_INVALID_ARGUMENT, SVO_OUT_OF_HOST_MEMORY,
 *          SVO_OUT_OF_DEVICE_MEMORY or SVO_CL_ERROR on failure. */
SVO_API svo_status svo_paged_open(svo_device *device, const char *path, uint64_t budget_bytes,
                                  const svo_paged_options *options, svo_paged **out);

/** What was opened.
 *
 * \param paged not NULL
 * \param info filled in; its struct_size is set by the caller
 * \returns SVO_INVALID_ARGUMENT on failure. */
SVO_API svo_status svo_paged_get_info(const svo_paged *paged, svo_paged_info *info);

/** Draws a picture of what is there, on the device's own queue, and waits for it.
 *
 * \param paged not NULL
 * \param options as for svo_render of a tree; every view of it but SVO_VIEW_TRIANGLES
 * \param rgba receives height rows of width * 4 bytes, top to bottom
 * \returns what svo_render returns. */
SVO_API svo_status svo_paged_render(svo_paged *paged, const svo_render_options *options, uint8_t *rgba);

/** Reads the pages that the last picture missed: those nearer to the root first, of equal levels those that rays missed
 *  most often, then by Morton code. Drops others as far as room is short. After a failure none of them is there,
 *  pictures are as they would be without the call, or coarser where pages were dropped, and the call may be repeated.
 *
 * \param paged not NULL
 * \returns SVO_FILE_ERROR (cannot be read), SVO_FILE_DAMAGED (the file has changed since it was opened), SVO_CL_ERROR,
 *          SVO_INVALID_ARGUMENT or SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_paged_update(svo_paged *paged);

/** What the last picture and the last update did, and all of them.
 *
 * \param paged not NULL
 * \param counts filled in; its struct_size is set by the caller
 * \returns SVO_INVALID_ARGUMENT on failure. */
SVO_API svo_status svo_paged_get_counts(const svo_paged *paged, svo_paged_counts *counts);

/** Closes the file and releases everything.
 *
 * \param paged set to NULL; NULL and a pointer to NULL are allowed */
SVO_API void svo_paged_close(svo_paged **paged);

#ifdef __cplusplus
}
#endif

#endif
