/* SPDX-License-Identifier: MIT */
/* Photons from light views into the sums of leaves: kernels/light/light_view.cl and photons.cl. */
#ifndef SVO_LIB_LIGHT_PHOTONS_H
#define SVO_LIB_LIGHT_PHOTONS_H

#include "compact/work.h"
#include "core/tree.h"
#include "light/light_view.h"

/* What photons leave behind. Buffers belong to the work. */
typedef struct svo_i_photons {
    svo_i_compact_work *work;
    svo_tree *tree;
    bool has_directions; /* of radiance */
    bool of_triangles; /* that photons meet; else voxels */
    double unit; /* world flux of one */
    cl_mem slots; /* u32 a leaf: its slot, SVO_SLOT_NONE, ... */
    cl_mem sums; /* of the slots */
    cl_mem counters; /* SVO_PHOTON_COUNTERS */
    uint64_t slot_room, slot_count;
    uint64_t shot; /* photons with flux */
    uint64_t hits; /* 64 bits of what the counter has 32 of */
    cl_mem weights, rays, met, leaves; /* of a band */
    double view_ms, sum_ms; /* rays; leaves and sums */
} svo_i_photons;

/* Bounds of a tree's leaves, from the masks of its upper levels. There is a leaf. */
svo_status svo_i_lit_box_of_tree(svo_i_compact_work *work, const svo_tree *tree, svo_i_lit_box *box);

/* Begins: no leaf has a slot. unit: a power of two; all photons together have less flux than
   2^SVO_FLUX_TOTAL_LOG2 of it. */
svo_status svo_i_photons_begin(svo_i_compact_work *work, svo_tree *tree, bool has_directions, double unit,
                               svo_i_photons *out);
/* Shoots all photons of a view. value: red, green, blue of its source. */
svo_status svo_i_photons_shoot(svo_i_photons *photons, const svo_i_light_view *view, const float value[3]);
/* Releases the buffers of bands, which only shooting needs; and the rest. The work does so otherwise. */
void svo_i_photons_release_bands(svo_i_photons *photons);
void svo_i_photons_release(svo_i_photons *photons);

/* Selects the program of photons and of their exchange. */
svo_status svo_i_photons_use(const svo_i_photons *photons);
/* Makes room for the slots that have been claimed, and reads how many there are. */
svo_status svo_i_photons_make_room(svo_i_photons *photons);
/* 64-bit numbers of one slot. */
uint64_t svo_i_photons_sums_of_slot(const svo_i_photons *photons);

/* The flux of all lit leaves, and the flux that hit the tree without a leaf: red, green, blue in units. */
typedef struct svo_i_flux_totals {
    uint64_t in_leaves[3], lost[3];
} svo_i_flux_totals;
svo_status svo_i_photons_total(svo_i_photons *photons, svo_i_flux_totals *totals);

#endif
