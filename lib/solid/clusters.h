/* SPDX-License-Identifier: MIT */
/* Clusters of edges of a boundary, for winding.c. */
#ifndef SVO_LIB_SOLID_CLUSTERS_H
#define SVO_LIB_SOLID_CLUSTERS_H

#include "solid/winding.h"

/* An edge from a cluster's center to a point. */
typedef struct svo_i_winding_star {
    uint32_t point;
    int32_t times; /* -1 : from the point to the center */
} svo_i_winding_star;

/* A cluster of pieces that follow each other. */
typedef struct svo_i_winding_node {
    double center[3], radius; /* in voxels, of a ball that holds it */
    double dipole[3], area; /* of the cone: the sum of its triangles, and of their sizes */
    size_t end; /* the node behind it and all below it */
    uint32_t first, count; /* pieces */
    size_t star_first, star_count;
    bool is_leaf;
    bool is_far; /* may be taken for far away */
    bool is_path; /* with two ends: an edge from one to the other stands for the star */
} svo_i_winding_node;

static inline size_t svo_i_winding_first_edge(const svo_i_winding *w, const svo_i_winding_node *node)
{
    return w->boundary.pieces[node->first].first;
}

static inline size_t svo_i_winding_edges_end(const svo_i_winding *w, const svo_i_winding_node *node)
{
    const svo_i_boundary_piece *last = &w->boundary.pieces[node->first + node->count - 1];
    return last->first + last->count;
}

static inline double svo_i_winding_dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

SVO_I_SHARED_BEGIN

/* Makes the clusters of w->boundary, whose pieces it sorts. Returns false when out of memory. */
bool svo_i_winding_make_clusters(const svo_i_memory *memory, svo_i_winding *w);

SVO_I_SHARED_END

#endif
