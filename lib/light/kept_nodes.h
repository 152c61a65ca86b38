/* SPDX-License-Identifier: MIT */
/*
 * What is kept of the nodes of a tree, so that the light of a changed one copies what stays: kernels/light/origins.cl.
 * The light before has the rest.
 */
#ifndef SVO_LIB_LIGHT_KEPT_NODES_H
#define SVO_LIB_LIGHT_KEPT_NODES_H

#include "light/kept_tree.h"
#include "light/state.h"

typedef struct svo_i_kept_nodes {
    svo_i_kept_tree tree;
    cl_mem masks, children; /* of inner nodes: the tree's */
    cl_mem opacities; /* of inner nodes of SVO_LIGHT_FACES, whose extinctions say too little: six u16 each; else NULL */
} svo_i_kept_nodes;

/* Begins to keep the nodes of a light's tree, in light->nodes. */
svo_status svo_i_kept_nodes_begin(svo_i_device_work *work, svo_light *light);
uint64_t svo_i_kept_nodes_bytes(const svo_i_kept_nodes *nodes);
/* NULL allowed; sets it to NULL. */
void svo_i_kept_nodes_destroy(svo_i_kept_nodes **nodes);

/* Finds where the nodes of a light's tree were in the tree before: light->before->origins, NULL where nothing is kept
   that fits. Needs light->nodes. */
svo_status svo_i_find_origins(svo_i_device_work *work, svo_light *light);
/* Those; NULL: all is made anew. */
cl_mem svo_i_light_origins(const svo_light *light);
/* Copies what stays of the inner nodes' opacity, so many u16 each, where there are origins; from one buffer to another,
   or from that of the light before to this one's. */
svo_status svo_i_keep_nodes(svo_i_device_work *work, const svo_light *light, cl_mem from, cl_mem to, cl_uint elements);
svo_status svo_i_keep_opacity(svo_i_device_work *work, const svo_light *light, cl_uint elements);

#endif
