/* SPDX-License-Identifier: MIT */
/* Windows: consecutive nodes or leaves, such that a launch can bind all their elements. Exclusive sums over arrays. */
#ifndef SVO_GLINTEROP_COMPUTE_WINDOWS_H
#define SVO_GLINTEROP_COMPUTE_WINDOWS_H

#include "compute/compute.h"

/* Where the elements of each of count items begin, as an array in OpenGL. */
typedef struct svo_i_offsets {
    GLuint buffer;
    uint64_t first; /* the word of the first item */
    uint32_t subtracted; /* from each word */
    GLuint through; /* not 0: what is read is an index into this array, which has the offset */
    uint32_t count;
    uint32_t end; /* where the elements of the last item end */
} svo_i_offsets;

/* The entries of leaves. Needs the tree's list_begin. */
svo_i_offsets svo_i_gl_list_offsets(const svo_i_gl_build *gl_build);
/* The children of a level's nodes, counted from the first of them. Needs the tree's first children. */
svo_i_offsets svo_i_gl_child_offsets(const svo_i_gl_build *gl_build, uint32_t level);
/* Where the elements of an item begin; those of item `count` are the end. */
svo_status svo_i_gl_offset(svo_i_gl_build *gl_build, const svo_i_offsets *offsets, uint32_t item, uint32_t *out);
/* Items from begin on, at most most_items, with at most most_elements elements. SVO_UNSUPPORTED when a single one has
   more: what they are, for the message. */
typedef struct svo_i_window {
    uint32_t begin, end; /* items */
    uint32_t first, last; /* elements: the first, and one past the last */
} svo_i_window;
svo_status svo_i_gl_window(svo_i_gl_build *gl_build, const svo_i_offsets *offsets, uint32_t begin, uint64_t most_items,
                           uint64_t most_elements, const char *what, svo_i_window *out);

/* Sums up counts, one word for each of count items, exclusively. begins: count + 1 words. */
svo_status svo_i_gl_scan(svo_i_gl_build *gl_build, GLuint counts, GLuint begins, uint32_t count);

#endif
