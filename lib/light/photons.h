/* SPDX-License-Identifier: MIT */
/* Photons from light views into the sums of leaves: kernels/light/light_view.cl and photons.cl. */
#ifndef SVO_LIB_LIGHT_PHOTONS_H
#define SVO_LIB_LIGHT_PHOTONS_H

#include "light/kept_photons.h"

/* What casts photons in place of the tree's rays: svocl::gl, by rasterization. */
typedef struct svo_i_photon_caster {
    void *self;
    /* Makes the hits of view->count photons from view->first on, svo_hit each, in world units. weights: of these
       photons; those without flux meet nothing. The queue is idle, and must be on return. */
    svo_status (*cast)(void *self, const svo_light_view_params *view, const svo_photon_weight *weights,
                       cl_command_queue queue, cl_mem hits);
} svo_i_photon_caster;

/* Photons of a band: many enough for a GPU, few enough for the caches of a CPU. Whole tiles. */
#define SVO_I_BAND_PHOTONS (UINT32_C(1) << 18)

/* What photons leave behind. Buffers belong to the work; svo_i_photons_release_bands must follow. */
typedef struct svo_i_photons {
    svo_i_device_work *work;
    svo_tree *tree;
    bool has_directions; /* of radiance */
    bool has_lobes; /* a material shines, and the tree has what lobes follow from */
    bool of_triangles; /* that photons meet; else voxels */
    bool is_clear; /* triangles in some leaves show in part, and let photons through */
    bool has_clear_voxels; /* some of the voxels do */
    uint32_t bounces; /* times that a photon lights a leaf, at most; at least 1 */
    double unit; /* world flux of one */
    cl_mem slots; /* u32 a leaf: its slot, SVO_SLOT_NONE, ... */
    cl_mem sums; /* of the slots */
    cl_mem counters; /* SVO_PHOTON_COUNTERS */
    uint64_t slot_room, slot_count;
    uint64_t slot_base, slot_free; /* of kept photons: slots that there were, and those of them that were free */
    uint64_t lit_count; /* leaves with slots */
    uint64_t shot; /* photons with flux */
    uint64_t traced; /* of them, by rays of this call */
    uint64_t hits; /* of rays of this call: 64 bits of what the counter has 32 of */
    uint64_t hits_before; /* of photons that are not shot again */
    svo_i_kept_photons *kept; /* owns the sums, and receives what is shot; NULL: nothing is kept */
    uint64_t sent; /* photons that surfaces sent on, each time */
    uint32_t through; /* photons that went through what they met, modulo 2^32 */
    uint32_t views; /* that were shot, and emission */
    cl_mem weights, rays, met, leaves; /* of a band */
    cl_mem carried; /* svo_carried_photon, of photons that are sent on; NULL: none are */
    cl_mem behind, found, lists[2]; /* of those that go through what they meet: rays, hits, numbers; NULL: none do */
    cl_mem groups; /* of the photons that are shot; NULL: all of a view */
    svo_photon_weight *host_weights; /* of a band, owned */
    cl_mem spreads; /* svo_photon_spread each SVO_ITEM_PHOTONS of them */
    const svo_i_photon_caster *caster; /* NULL: rays of the tree */
    double view_ms, sum_ms; /* rays; leaves and sums */
} svo_i_photons;

/* Begins: no leaf has a slot. unit: a power of two; all photons together have less flux than
   2^SVO_FLUX_TOTAL_LOG2 of it. kept: NULL: nothing is kept. */
svo_status svo_i_photons_begin(svo_i_device_work *work, svo_tree *tree, bool has_directions, double unit,
                               svo_i_kept_photons *kept, svo_i_photons *out);
/* Photons go through what shows in part, if some of the tree does: its root then has an alpha below 1. */
svo_status svo_i_photons_see_alpha(svo_i_photons *photons);
/* Shoots all photons of a view. value: red, green, blue of its source. */
svo_status svo_i_photons_shoot(svo_i_photons *photons, const svo_i_light_view *view, const float value[3]);
/* Shoots so many photons from pieces of triangles that emit: svo_emitter_piece each, whose ends and flux say how many
   and what. brightest: the most flux that one has in a channel. */
svo_status svo_i_photons_emit(svo_i_photons *photons, cl_mem pieces, uint32_t piece_count, uint32_t photon_count,
                              uint64_t brightest);
/* Shoots those of a launch whose weights are there. */
svo_status svo_i_photons_shoot_weighed(svo_i_photons *photons, const svo_light_view_params *params);
/* Buffers for a band, kept from view to view. */
svo_status svo_i_photons_make_bands(svo_i_photons *photons);
/* Releases the buffers of bands, which only shooting needs; and the rest. The work does so otherwise. */
void svo_i_photons_release_bands(svo_i_photons *photons);
void svo_i_photons_release(svo_i_photons *photons);

/* Selects the program of photons and of their exchange. */
svo_status svo_i_photons_use(const svo_i_photons *photons);
/* Makes room for the slots that have been claimed, and reads how many there are. */
svo_status svo_i_photons_make_room(svo_i_photons *photons);
/* 32-bit numbers of the radiance of a lit leaf. */
static inline uint64_t svo_i_photons_values_of_leaf(const svo_i_photons *photons)
{
    return photons->has_directions ? SVO_FACE_SUMS : 3;
}

/* The flux of all lit leaves, and the flux that hit the tree without a leaf: red, green, blue in units. */
typedef struct svo_i_flux_totals {
    uint64_t in_leaves[3], lost[3];
} svo_i_flux_totals;
svo_status svo_i_photons_total(svo_i_photons *photons, svo_i_flux_totals *totals);

/* Counts the leaves without a slot that a ray from one of the sources to their center meets first. */
svo_status svo_i_photons_count_unmet(svo_i_photons *photons, const svo_light_setup *setup, uint64_t *count);

#endif
