/* SPDX-License-Identifier: MIT */
/* Photons and radiance that are kept on the device, so that few are shot again for a changed tree:
   kernels/light/kept_photons.cl. */
#ifndef SVO_LIB_LIGHT_KEPT_PHOTONS_H
#define SVO_LIB_LIGHT_KEPT_PHOTONS_H

#include "light/kept_tree.h"
#include "light/light_view.h"
#include "light/state.h"

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

/* Photons of a launch that have been shot, as photons.h has them. */
typedef struct svo_i_shot_photons {
    cl_mem weights, met, spreads, slots, groups;
    cl_uint first; /* their view's first photon among the kept ones */
} svo_i_shot_photons;

/* Whether photons of a tree can be kept: they meet triangles by rays. */
bool svo_i_kept_is_possible(const svo_light *light, const svo_light_setup *setup);
/* Whether what is kept is that of the same views and of leaves with the same kind of payload. */
svo_status svo_i_kept_fits(const svo_i_kept_photons *kept, svo_i_device_work *work, const svo_tree *tree,
                           const svo_i_lit_box *box, bool *fits);
/* Begins anew, for the views of a setup. */
svo_status svo_i_kept_begin(svo_i_kept_photons *kept, svo_i_device_work *work, const svo_tree *tree,
                            const svo_light_setup *setup, const svo_i_lit_box *box, bool has_directions);
/* Gives slots more room. sum_bytes, radiance_bytes: of one. */
svo_status svo_i_kept_grow(svo_i_kept_photons *kept, svo_i_device_work *work, uint64_t room, uint64_t sum_bytes,
                           uint64_t radiance_bytes);
/* The photons that are shot next are those of the next view, whose params are known now. Returns its first photon. */
uint32_t svo_i_kept_next_view(svo_i_kept_photons *kept, const svo_light_view_params *params);
/* Keeps the photons of a launch. */
svo_status svo_i_kept_take(const svo_i_kept_photons *kept, svo_i_device_work *work, const svo_i_shot_photons *shot,
                           const svo_light_view_params *params);
/* Selects the program of kept photons. */
svo_status svo_i_kept_use(const svo_i_kept_photons *kept, svo_i_device_work *work);
uint64_t svo_i_kept_bytes(const svo_i_kept_photons *kept);
/* NULL allowed; sets it to NULL. */
void svo_i_kept_destroy(svo_i_kept_photons **kept);

#endif
