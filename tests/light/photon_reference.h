/* SPDX-License-Identifier: MIT */
/*
 * The sums of photons on the host, from traced rays: exact arithmetic with 128 bits, for each photon a search of all
 * leaves for the one that its triangle is in and that holds its point or is nearest, and the leaves that its parts
 * spread to.
 */
#ifndef SVOCL_TESTS_PHOTON_REFERENCE_H
#define SVOCL_TESTS_PHOTON_REFERENCE_H

#include <stdbool.h>

#include "light/source_views.h"
#include "support/fixture.h"

/* Sums as the library has them: units of flux, and of 2^-24 of it for directions. */
typedef struct photon_sums {
    int64_t flux[3], along[3];
    int64_t faces[18]; /* times the cosine, by direction and channel */
    uint64_t photons;
} photon_sums;

/* The ray of a view's photon; shot: whether it has flux. */
svo_ray reference_photon_ray(const svo_light_view_params *view, uint32_t photon, bool shot);

/* Adds the photons of a view to the sums of leaves. value: of the source; unit: of flux. Returns those that hit. */
uint64_t reference_shoot(const fixture *opened, const built *made, const svo_i_light_view *view, const float value[3],
                         double unit, photon_sums *leaves);

#endif
