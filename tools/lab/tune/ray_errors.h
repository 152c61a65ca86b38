/* SPDX-License-Identifier: MIT */
/* Errors of rays: where they meet the voxels of a setting's tree or compact form, and which triangle they hit where. */
#ifndef SVOCL_TOOLS_TUNE_RAY_ERRORS_H
#define SVOCL_TOOLS_TUNE_RAY_ERRORS_H

#include "reference/oracle_rays.h"
#include "support/session.h"
#include "tune/dimensions.h"
#include "tune/measures.h"

/* Rays of a seed and what they truly meet. */
typedef struct ray_truth {
    session *opened; /* borrowed, and the tree */
    svo_tree *tree; /* of the mesh, with lists, downloaded */
    unsigned threads;
    size_t count, exact_count; /* 0: not made yet; the first ones, which have an exact hit */
    uint32_t seed;
    svo_ray *rays;
    svo_hit *hits; /* by the tree's rays */
    oracle_ray_hit *exact; /* by every triangle in long double */
} ray_truth;

/* Releases the rays. */
void ray_truth_clear(ray_truth *truth);

/* Adds count rays of a seed, which all settings share. tree: of the setting, with SVO_NEED_RAYS, on the device. need:
   the svo_need bits of what is measured. Returns false on failure, with the device's message or where memory runs
   out. */
bool ray_errors_add(ray_truth *truth, const tune_setting *setting, svo_tree *tree, uint32_t need, size_t count,
                    uint32_t seed, tune_errors *errors);

#endif
