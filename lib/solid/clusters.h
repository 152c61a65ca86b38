/* SPDX-License-Identifier: MIT */
/* Clusters of edges of a boundary, for winding.c. */
#ifndef SVO_LIB_SOLID_CLUSTERS_H
#define SVO_LIB_SOLID_CLUSTERS_H

#include <stdbool.h>

#include "solid/boundary.h"

/* An edge from a cluster's center to a point. */
typedef struct svo_i_cluster_star {
    uint32_t point;
    int32_t times; /* -1 : from the point to the center */
} svo_i_cluster_star;

/* A cluster of pieces that follow each other. */
typedef struct svo_i_cluster {
    double center[3], radius; /* in voxels, of a ball that holds it */
    double dipole[3], area; /* of the cone: the sum of its triangles, and of their sizes */
    size_t end; /* the node behind it and all below it */
    uint32_t first, count; /* pieces */
    size_t star_first, star_count;
    bool is_leaf;
    bool is_far; /* may be taken for far away */
    bool is_path; /* with two ends: an edge from one to the other stands for the star */
} svo_i_cluster;

/* A boundary, and clusters of its pieces. All owned. */
typedef struct svo_i_clusters {
    svo_i_boundary boundary;
    svo_i_cluster *nodes; /* each before its children */
    svo_i_cluster_star *stars;
    size_t node_count, star_count;
} svo_i_clusters;

static inline size_t svo_i_cluster_first_edge(const svo_i_clusters *of, const svo_i_cluster *node)
{
    return of->boundary.pieces[node->first].first;
}

static inline size_t svo_i_cluster_edges_end(const svo_i_clusters *of, const svo_i_cluster *node)
{
    const svo_i_boundary_piece *last = &of->boundary.pieces[node->first + node->count - 1];
    return last->first + last->count;
}

static inline double svo_i_cluster_dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

SVO_I_SHARED_BEGIN

/* Makes those of a boundary, whose pieces it sorts. Returns false when out of memory. */
bool svo_i_clusters_make(const svo_i_memory *memory, svo_i_clusters *clusters);
/* Releases them, as far as they are made, and the boundary. */
void svo_i_clusters_release(svo_i_clusters *clusters);

SVO_I_SHARED_END

#endif
