/* SPDX-License-Identifier: MIT */
/* What a changed tree needs of photons, where photons->kept has those of the tree before. */
#ifndef SVO_LIB_LIGHT_AGAIN_H
#define SVO_LIB_LIGHT_AGAIN_H

#include "light/photons.h"
#include "light/state.h"

/* Shoots again what the boxes concern, and finds places in the new tree for the rest. */
svo_status svo_i_photons_shoot_again(svo_i_photons *photons, svo_i_light_before *before);
/* All photons have been shot, or shot again, and leaves that emit have slots: what is kept is whole. totals: of
   photons. renewed: of svo_i_light_before; NULL: not wanted. */
svo_status svo_i_photons_finish_kept(svo_i_photons *photons, const svo_i_flux_totals *totals, cl_mem renewed);

#endif
