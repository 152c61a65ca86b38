/* SPDX-License-Identifier: MIT */
/* The triangles of a tree that emit, for rays that aim at them: kernels/light/emitters.clh. */
#ifndef SVO_LIB_LIGHT_EMITTERS_H
#define SVO_LIB_LIGHT_EMITTERS_H

#include "light/handle.h"

/* Lists the triangles in leaves whose finish emits, as the light's emitters, if paths are to aim at them and they are
   not listed; waits. There are none without triangles or materials, and where so much of the surface emits that any ray
   finds some. submit: whose queue is used; NULL: the device's own. */
svo_status svo_i_light_list_emitters(svo_light *light, const char *function, const svo_gather_params *gather,
                                     const svo_submit *submit);

/* Pieces of triangles for photons: what of them lies in each leaf whose finish emits. */
typedef struct svo_i_emission {
    svo_emitter_piece *pieces; /* without ends and flux; owned */
    double *powers; /* of each: area, both sides, times the flux by area of its brightest channel; owned */
    uint32_t *finishes; /* owned */
    uint32_t count, room;
    double power; /* of all */
} svo_i_emission;

/* Lists them, in the order of leaves. codes: of the leaves. out: all zero; svo_i_emission_free must follow, also after
   a failure. */
svo_status svo_i_emission_list(svo_i_device_work *work, const svo_light *light, const svo_light_setup *setup,
                               const uint64_t *codes, svo_i_emission *out);
/* Shares so many photons out, of a flux in that unit. brightest: receives the most of one in a channel. */
void svo_i_emission_share(svo_i_emission *emission, const svo_light_setup *setup, uint32_t photon_count, double unit,
                          uint64_t *brightest);
void svo_i_emission_free(svo_i_emission *emission);
/* Whether a setup's finishes emit, and the tree has triangles and materials. */
bool svo_i_emission_may_be(const svo_tree *tree, const svo_finish *finishes, size_t finish_count);
/* Forgets the light's emitters: the light has other finishes, or is of another tree. */
void svo_i_light_drop_emitters(svo_light *light);

#endif
