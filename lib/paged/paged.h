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

#include "core/device.h"
#include "io/file_format.h"
#include "paged/runs.h"
#include "shared/layout.h"
#include "svocl/paged.h"

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

#endif
