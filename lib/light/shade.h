/* SPDX-License-Identifier: MIT */
/* Radiance along rays in a lit tree, for what is made of it. */
#ifndef SVO_LIB_LIGHT_SHADE_H
#define SVO_LIB_LIGHT_SHADE_H

#include "light/shader.h"

typedef struct svo_i_light_shade {
    svo_i_light_shader shader;
    svo_gather_params gather;
} svo_i_light_shade;

/* Checks the number of cones: 1, 5, 6, 16 or 64; 0 for the default. The message names options.cones of the function. */
svo_status svo_i_light_check_cones(const svo_light *light, const char *function, uint32_t cones);

/* Begins; cones as checked. */
svo_status svo_i_light_shade_begin(svo_i_device_work *work, const svo_light *light, uint32_t cones,
                                   svo_i_light_shade *out);
/* Writes three floats to radiance for each of so many svo_ray: what kernels/light/shade.cl finds. */
svo_status svo_i_light_shade_rays(const svo_i_light_shade *shade, cl_mem rays, cl_mem radiance, uint32_t ray_count);
void svo_i_light_shade_end(svo_i_light_shade *shade);

#endif
