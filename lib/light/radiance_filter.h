/* SPDX-License-Identifier: MIT */
/* From the radiance of the lit leaves to that of all nodes that see them. */
#ifndef SVO_LIB_LIGHT_RADIANCE_FILTER_H
#define SVO_LIB_LIGHT_RADIANCE_FILTER_H

#include "light/handle.h"

/* The leaves with light, and how much leaves them. */
typedef struct svo_i_lit_leaves {
    cl_mem leaves; /* lit_count, u32: 0 is the first leaf; ascending */
    /* u32, of 3 channels. SVO_LIGHT_FACES: lit_count * 6, for rays along +x, -x, ..., premultiplied by how much of its
       face the leaf's surface covers, so that it is radiance over the whole face. Else lit_count: of the surface. */
    cl_mem radiance;
    cl_mem slots; /* u32 a leaf: the place of its radiance; NULL: radiance is in the order of leaves */
    uint64_t lit_count;
    float unit; /* radiance of a 1, a power of two */
} svo_i_lit_leaves;

/* u32 of the radiance of a node or brick; how many of these may have any. */
uint64_t svo_i_light_words(svo_light_form form);
uint64_t svo_i_light_bearers(const svo_tree *tree, svo_light_form form);

/* Replaces the light's radiance (SVO_LIGHT_LIT, SVO_LIGHT_RADIANCE) and sets lit_nodes, the unit and the time of the
   stage. The light is dark after a failure. */
svo_status svo_i_light_filter(svo_i_device_work *work, svo_light *light, const svo_i_lit_leaves *lit);

#endif
