/* SPDX-License-Identifier: MIT */
/*
 * Photons from light views into the sums of leaves: kernels/light/light_view.cl and photons.cl. Photons and radiance
 * may be kept on the device, so that few are shot again for a changed tree: kernels/light/kept_photons.cl.
 */
#ifndef SVO_LIB_LIGHT_PHOTONS_H
#define SVO_LIB_LIGHT_PHOTONS_H

#include "core/tree.h"
#include "core/work.h"
#include "light/source_views.h"
#include "svocl/light.h"
#include "svocl/nodes.h"

/* ---- what is kept ---- */

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
/* Selects the program of kept photons. */
svo_status svo_i_kept_use(const svo_i_kept_photons *kept, svo_i_device_work *work);
/* NULL allowed; sets it to NULL. */
void svo_i_kept_destroy(svo_i_kept_photons **kept);

/* ---- photons ---- */

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
    cl_mem weights, rays, met, leaves; /* of a band */
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
/* Shoots all photons of a view. value: red, green, blue of its source. */
svo_status svo_i_photons_shoot(svo_i_photons *photons, const svo_i_light_view *view, const float value[3]);
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
