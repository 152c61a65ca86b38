/* SPDX-License-Identifier: MIT */
/*
 * The fields of a paged tree. A band is a number of levels whose nodes are in pages: its root level has the roots, and
 * the page of a root has the nodes below it down to the root level of the next band, or to the leaves.
 *
 * Nodes on the device have one numbering. First come inner nodes: those of the top levels, then room for those of
 * pages; then leaves. Child masks and links are there for inner nodes alone.
 */
#ifndef SVO_LIB_PAGED_PAGED_H
#define SVO_LIB_PAGED_PAGED_H

#include <stdbool.h>
#include <stdint.h>

#include "core/device.h"
#include "core/memory.h"
#include "io/file_format.h"
#include "parts/view.h"
#include "shared/layout.h"
#include "svocl/paged.h"

/*
 * ---- runs of free elements (pool.c) ----
 *
 * The first one that is long enough is taken, so the same calls give the same places.
 */

typedef struct svo_i_run {
    uint32_t begin, count;
} svo_i_run;

typedef struct svo_i_runs {
    svo_i_run *spans; /* ascending, none beside another; owned */
    uint32_t free_count, free_capacity;
    uint32_t taken_count;
} svo_i_runs;

/* All of count elements from begin on are free. Returns false when out of memory. */
bool svo_i_runs_begin(svo_i_runs *runs, const svo_i_memory *memory, uint32_t begin, uint32_t count);
void svo_i_runs_end(svo_i_runs *runs);

/* Makes sure that one more run can be taken and given back. Returns false when out of memory. */
bool svo_i_runs_reserve(svo_i_runs *runs);
/* Takes count elements, above 0, after svo_i_runs_reserve. Returns false where no run is long enough. */
bool svo_i_runs_take(svo_i_runs *runs, uint32_t count, uint32_t *begin);
void svo_i_runs_give_back(svo_i_runs *runs, uint32_t begin, uint32_t count);

/* ---- a paged tree ---- */

#define PAGED_LEVELS_MIN     2 /* so that the children of a root are inner nodes */
#define PAGED_LEVELS_MAX     5
#define PAGED_LEVELS_DEFAULT 3
#define PAGED_BANDS_MAX      (SVO_LEVELS_MAX / PAGED_LEVELS_MIN)

/* The arrays of the file that are paged, in the order of its chunks. */
typedef enum paged_array { PAGED_MASKS, PAGED_COLORS, PAGED_NORMALS, PAGED_ARRAYS } paged_array;

/* What is where, by counts alone. */
typedef struct paged_layout {
    uint32_t top_level, page_levels, band_count;
    uint32_t page_count;
    bool by_node[PAGED_ARRAYS]; /* whether nodes have an element of their own */
    uint32_t payload_bytes; /* of a node: of those arrays but the masks */
    uint32_t top_inner_count; /* inner nodes of the top levels */
    uint64_t inner_count, leaf_count; /* of all pages */
    uint32_t inner_capacity; /* elements on the device for inner nodes, those of the top levels too */
    uint32_t leaf_capacity; /* and after them for leaves */
    uint64_t least_bytes, whole_bytes, device_bytes; /* of svo_paged_info */
} paged_layout;

typedef struct paged_band {
    uint32_t root_level;
    uint32_t first_page; /* the number of its first root's page */
    uint32_t page_count;
    /* first[k][j]: the first node of level root_level + k in page first_page + j, counted from the begin of the level;
       page_count + 1 of them. first[0] is NULL. */
    uint32_t *first[PAGED_LEVELS_MAX + 1];
} paged_band;

typedef struct paged_page {
    uint64_t hash; /* of its bytes in the file, see scan.c */
    uint32_t inner_at, leaf_at; /* its first nodes on the device; inner_at SVO_PAGE_ABSENT: not there */
    uint32_t used; /* the number of the last picture that used it */
} paged_page;

/* Nodes on their way to the device: pages whose nodes are adjacent there. */
typedef struct paged_stage {
    uint32_t inner_capacity, leaf_capacity;
    uint32_t inner_at, inner_count;
    uint32_t leaf_at, leaf_count;
    uint32_t *links;
    uint8_t *inner[PAGED_ARRAYS], *leaves[PAGED_ARRAYS];
} paged_stage;

struct svo_paged {
    svo_device *device;
    svo_i_memory memory;
    char *path; /* owned */
    svo_i_file_load load; /* open */
    svo_parts_tree *parts; /* of a folder, owned; NULL: a file */
    svo_i_parts_view *view; /* of it, which load reads; owned */
    svo_i_tree_file file;
    svo_ray_params params;
    paged_layout layout;
    paged_band bands[PAGED_BANDS_MAX];
    paged_page *pages; /* layout.page_count, by level and Morton code */
    uint32_t largest_inner, largest_leaves; /* nodes of a page */
    uint32_t *table; /* SVO_PAGE_WORDS for each page: what the device has before a picture, and the marks after it */
    cl_mem device_table, links, arrays[PAGED_ARRAYS]; /* owned; colors and normals NULL: none */
    svo_i_runs inner_runs, leaf_runs; /* of what is free */
    paged_stage stage;
    uint64_t update_bytes; /* of svo_paged_options */
    uint64_t open_read_bytes;
    svo_paged_counts counts;
};

/* ---- pages in the file (scan.c) ---- */

/* The array's name among those of trees, and the bytes of an element. */
svo_tree_buffer svo_i_paged_buffer(paged_array array);
size_t svo_i_paged_element_bytes(paged_array array);

/* The last level of a band's pages, and how many nodes a page has of a level. */
uint32_t svo_i_paged_last_level(const svo_paged *paged, const paged_band *band);
uint32_t svo_i_paged_count(const paged_band *band, uint32_t index, uint32_t level);
/* The band of a page, and its index there. */
const paged_band *svo_i_paged_band(const svo_paged *paged, uint32_t page, uint32_t *index);
/* The inner nodes and the leaves of a page. */
void svo_i_paged_size(const svo_paged *paged, uint32_t page, uint32_t *inner_count, uint32_t *leaf_count);

/* The chunk of an array's level; NULL where the file has none. index: receives its number. */
const file_chunk *svo_i_paged_chunk(const svo_paged *paged, paged_array array, uint32_t level, uint32_t *index);

/* The arrays of the top levels; NULL where there is none. */
typedef struct paged_top {
    uint8_t *arrays[PAGED_ARRAYS]; /* owned. An element for every node, or one for all */
} paged_top;

/* Reads the top levels into top, and of all pages which nodes they have and a checksum. Checks nodes and checksums. */
svo_status svo_i_paged_scan(svo_paged *paged, paged_top *top);

/* The checksum of a page after further bytes of it, which begins with 0. */
uint64_t svo_i_paged_hash(uint64_t hash, const void *bytes, size_t byte_count);

/* ---- nodes on the device (pool.c) ---- */

/* Makes the buffers with the top levels, and everything else whose size the layout says. */
svo_status svo_i_paged_make_pool(svo_paged *paged, const paged_top *top);
void svo_i_paged_release_pool(svo_paged *paged);

/* The table of pages to the device and, with marks, back. */
svo_status svo_i_paged_write_table(svo_paged *paged);
svo_status svo_i_paged_read_table(svo_paged *paged);

#endif
