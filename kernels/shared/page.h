/* SPDX-License-Identifier: MIT */
/* How the nodes of a paged tree name its pages: kernels/rays/read_paged.clh reads it, lib/paged writes it. */
#ifndef SVO_KERNELS_SHARED_PAGE_H
#define SVO_KERNELS_SHARED_PAGE_H

/* In the link of a node whose children are in a page; the rest of the link is the page's number. */
#define SVO_PAGE_ROOT 0x80000000u

/* The words of a page in the table of pages. */
#define SVO_PAGE_BEGIN 0u /* its first node, or SVO_PAGE_ABSENT */
#define SVO_PAGE_MARK  1u /* not 0: rays went into it, or would have, and how often */
#define SVO_PAGE_WORDS 2u

/* Node 0 is the tree's root, which no page has. */
#define SVO_PAGE_ABSENT 0u

#endif
