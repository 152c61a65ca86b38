/* SPDX-License-Identifier: MIT */
/*
 * The cases of a cube. On each face, the edges that the surface crosses are joined in pairs; edges that hang together
 * are a piece. Neighbors decide a face alike, so pieces go on from cube to cube.
 *
 * A face with two pairs gives two of the mesh's edges. Where both cubes have both pairs in one piece, these join the
 * same two vertices, and four triangles would meet there. So such a face, and no other, is decided the other way, by
 * which either piece falls into two (Wenger 2013, "Isosurfaces: Geometry, Topology, and Algorithms").
 */
#include "surface/cases.h"

#include <stdbool.h>

#define EDGES     12
#define FACES     6
#define PAIRS_MAX (2 * FACES)

/* The pairs of a case: bits of their edges. */
typedef struct pair_list {
    unsigned pairs[PAIRS_MAX];
    unsigned count;
} pair_list;

static bool is_inside(unsigned inside, unsigned corner)
{
    return (inside >> corner & 1u) != 0;
}

/* The corners of a face, around it, and the edges from each to the next: bits. */
static void go_around(unsigned face, unsigned corners[4], unsigned edges[4])
{
    const unsigned axis = face / 2;
    const unsigned u = (axis + 1) % 3;
    const unsigned v = (axis + 2) % 3;
    const unsigned side = face % 2;
    for (unsigned i = 0; i < 4; ++i) {
        const unsigned on_u = i == 1 || i == 2;
        const unsigned on_v = i / 2;
        corners[i] = side << axis | on_u << u | on_v << v;
    }
    edges[0] = 1u << (4 * u + (0 | side << 1));
    edges[1] = 1u << (4 * v + (side | 2));
    edges[2] = 1u << (4 * u + (1 | side << 1));
    edges[3] = 1u << (4 * v + side);
}

/* Adds the pairs of a face. joined: two pairs are around its outside corners. Returns the crossed edges: bits. */
static unsigned add_pairs(unsigned inside, unsigned face, bool joined, pair_list *list)
{
    unsigned corners[4];
    unsigned edges[4];
    unsigned crossed = 0;
    unsigned count = 0;
    go_around(face, corners, edges);
    for (unsigned i = 0; i < 4; ++i) {
        if (is_inside(inside, corners[i]) != is_inside(inside, corners[(i + 1) % 4])) {
            crossed |= edges[i];
            ++count;
        }
    }
    for (unsigned i = 0; i < 4 && count == 4; ++i) {
        if (is_inside(inside, corners[i]) != joined) {
            list->pairs[list->count++] = edges[(i + 3) % 4] | edges[i];
        }
    }
    if (count == 2) {
        list->pairs[list->count++] = crossed;
    }
    return crossed;
}

/* The edges that hang together with one. */
static unsigned find_piece(const pair_list *list, unsigned edge)
{
    unsigned piece = edge;
    for (unsigned before = 0; before != piece;) {
        before = piece;
        for (unsigned i = 0; i < list->count; ++i) {
            piece |= (list->pairs[i] & piece) != 0 ? list->pairs[i] : 0u;
        }
    }
    return piece;
}

/* The pieces by the lowest of their edges. joined_face: the face whose two pairs are around its outside corners. */
static svo_i_surface_case make_case(unsigned inside, unsigned joined_face)
{
    svo_i_surface_case made = {.piece_count = 0};
    pair_list list = {.count = 0};
    unsigned left = 0;
    for (unsigned face = 0; face < FACES; ++face) {
        left |= add_pairs(inside, face, face == joined_face, &list);
    }
    for (unsigned edge = 0; edge < EDGES; ++edge) {
        if ((left >> edge & 1u) != 0) {
            const unsigned piece = find_piece(&list, 1u << edge);
            left &= ~piece;
            made.pieces[made.piece_count++] = (uint16_t)piece;
        }
    }
    return made;
}

/* The face whose four edges one piece has, or SVO_I_SURFACE_NO_FACE. */
static uint8_t find_shared(const svo_i_surface_case *made)
{
    for (uint8_t face = 0; face < FACES; ++face) {
        unsigned corners[4];
        unsigned edges[4];
        go_around(face, corners, edges);
        const unsigned all = edges[0] | edges[1] | edges[2] | edges[3];
        for (unsigned i = 0; i < made->piece_count; ++i) {
            if ((made->pieces[i] & all) == all) {
                return face;
            }
        }
    }
    return SVO_I_SURFACE_NO_FACE;
}

void svo_i_surface_make_cases(svo_i_surface_cases *cases)
{
    for (unsigned inside = 0; inside < 256; ++inside) {
        cases->apart[inside] = make_case(inside, SVO_I_SURFACE_NO_FACE);
        cases->shared_face[inside] = find_shared(&cases->apart[inside]);
        cases->joined[inside] = make_case(inside, cases->shared_face[inside]);
    }
}
