/* SPDX-License-Identifier: MIT */
/* The map of the sky: kernels/light/sky.clh. */
#ifndef SVO_LIB_LIGHT_SKY_H
#define SVO_LIB_LIGHT_SKY_H

#include "light/handle.h"

/* Checks the map of a setup, if there is one: its size, and each value. */
svo_status svo_i_light_check_sky(const svo_light *light, const char *function, const svo_light_setup *setup);
/* Puts the map of a setup that has been checked, and its means, on the device. The light has none yet. */
svo_status svo_i_light_make_sky(svo_i_device_work *work, svo_light *light, const svo_light_setup *setup);
/* Gives a light that has none the map of another one, which keeps it. */
svo_status svo_i_light_share_sky(const svo_light *from, const char *function, svo_light *to);
void svo_i_light_drop_sky(svo_light *light);

/* Bytes of a map of so many texels, without its means. */
static inline uint64_t svo_i_sky_map_bytes(uint32_t width, uint32_t height)
{
    return (uint64_t)width * height * 3 * sizeof(cl_float);
}

#endif
