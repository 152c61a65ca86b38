/* SPDX-License-Identifier: MIT */
/* What is kept of photons for svo_light_update. */
#ifndef SVO_LIB_LIGHT_KEPT_PHOTONS_H
#define SVO_LIB_LIGHT_KEPT_PHOTONS_H

#include "core/tree.h"
#include "core/work.h"
#include "light/source_views.h"
#include "svocl/light.h"
#include "svocl/nodes.h"

/* What two trees have in common where one has what is kept of the other. */
typedef struct svo_i_kept_tree {
    svo_grid grid;
    uint32_t need, constant, weights; /* of svo_tree_info */
    uint64_t constants[3]; /* of colors, normals and materials, where all nodes have the same; else 0 */
} svo_i_kept_tree;

svo_status svo_i_kept_tree_read(svo_i_device_work *work, const svo_tree *tree, svo_i_kept_tree *out);
bool svo_i_kept_tree_is_same(const svo_i_kept_tree *a, const svo_i_kept_tree *b);

/* A view whose photons are kept. */
typedef struct svo_i_kept_view {
    svo_light_view_params params; /* but for first and count */
    uint32_t photon_count;
    uint32_t first; /* its first photon among all */
} svo_i_kept_view;

/* The views, and with them their photons, follow from a setup, the grid and the bounds of the leaves. */
typedef struct svo_i_kept_photons {
    svo_device *device;
    bool whole; /* what follows is that of the light's tree */
    bool has_directions; /* of radiance */
    bool is_clear; /* some of the tree shows in part, and lets photons through */
    svo_i_kept_tree tree;
    svo_i_lit_box box;
    svo_i_kept_view *views; /* owned */
    size_t view_count, shot_views;
    uint32_t photon_count;
    cl_mem weights, ends, spreads; /* of photons; of groups: slots, not leaves */
    cl_mem sums, users, codes; /* of slots */
    cl_mem radiance, bits; /* of slots: values in the unit, and the bits of the largest or SVO_SLOT_STALE */
    float unit; /* of that radiance; 0: there is none yet */
    uint64_t slot_room, slot_count;
    uint64_t shot, hits;
    cl_uint lost[6]; /* flux: red, green, blue, 64 bits each */
} svo_i_kept_photons;

/* Whether what is kept is that of the same views and of leaves with the same kind of payload. */
svo_status svo_i_kept_fits(const svo_i_kept_photons *kept, svo_i_device_work *work, const svo_tree *tree,
                           const svo_i_lit_box *box, bool *fits);
/* Begins anew, for the views of a setup. */
svo_status svo_i_kept_begin(svo_i_kept_photons *kept, svo_i_device_work *work, const svo_tree *tree,
                            const svo_light_setup *setup, const svo_i_lit_box *box, bool has_directions);
/* Gives slots more room. slot_bytes, radiance_bytes: of one. */
svo_status svo_i_kept_grow(svo_i_kept_photons *kept, svo_i_device_work *work, uint64_t room, uint64_t slot_bytes,
                           uint64_t radiance_bytes);
/* The photons that are shot next are those of the next view, whose params are known now but for kept_first. */
void svo_i_kept_next_view(svo_i_kept_photons *kept, svo_light_view_params *params);
/* Selects the program of kept photons. */
svo_status svo_i_kept_use(const svo_i_kept_photons *kept, svo_i_device_work *work);
/* NULL allowed; sets it to NULL. */
void svo_i_kept_destroy(svo_i_kept_photons **kept);

#endif
