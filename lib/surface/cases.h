/* SPDX-License-Identifier: MIT */
/*
 * How a surface may pass a cube, by which of its corners are inside. Corner c is at (c & 1, c >> 1 & 1, c >> 2). Edge
 * 4 a + k is along axis a; of the axes a + 1 and a + 2, modulo 3, bits 0 and 1 of k say on which side it is. Face
 * 2 a + s is that of axis a on its low (0) or high (1) side.
 */
#ifndef SVO_LIB_SURFACE_CASES_H
#define SVO_LIB_SURFACE_CASES_H

#include <stdint.h>

#define SVO_I_SURFACE_PIECES_MAX 4
#define SVO_I_SURFACE_NO_FACE    6

/* The pieces of the surface in a cube. */
typedef struct svo_i_surface_case {
    uint16_t pieces[SVO_I_SURFACE_PIECES_MAX]; /* the edges that each crosses: bits */
    uint8_t piece_count;
} svo_i_surface_case;

/* All cases. A face with two inside corners, diagonally opposite, has two pieces of the surface in it, and there are
   two ways to join its edges: around each inside corner, or around each outside corner. */
typedef struct svo_i_surface_cases {
    svo_i_surface_case apart[256]; /* by corners inside: each such face around its inside corners */
    svo_i_surface_case joined[256]; /* the same but for the case's shared face, around its outside corners */
    /* The face whose two pieces belong to one piece of apart; SVO_I_SURFACE_NO_FACE: none. At most one face does, and
       then the case has no other face with two. */
    uint8_t shared_face[256];
} svo_i_surface_cases;

void svo_i_surface_make_cases(svo_i_surface_cases *cases);

/* The corners of an edge: the lower one, and the other. */
static inline unsigned svo_i_surface_edge_low(unsigned edge)
{
    const unsigned axis = edge / 4;
    return (edge & 1u) << (axis + 1) % 3 | (edge >> 1 & 1u) << (axis + 2) % 3;
}

static inline unsigned svo_i_surface_edge_high(unsigned edge)
{
    return svo_i_surface_edge_low(edge) | 1u << edge / 4;
}

#endif
