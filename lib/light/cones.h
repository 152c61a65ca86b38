/* SPDX-License-Identifier: MIT */
/*
 * What cones gather from a light: at points, along rays and in pictures.
 *
 * Radiance along rays is for what is made of it. Its kernel takes the arguments that SVO_LIT_PARAMETERS of
 * kernels/light/surface.clh declares, like that of pictures, and then its own.
 */
#ifndef SVO_LIB_LIGHT_CONES_H
#define SVO_LIB_LIGHT_CONES_H

#include "light/handle.h"

/* A kernel, and what lights the tree. */
typedef struct svo_i_light_shader {
    const svo_light *light;
    svo_i_device_work *work;
    cl_kernel kernel; /* owned */
    cl_mem sources, finishes; /* the work's; NULL: none */
} svo_i_light_shader;

typedef struct svo_i_light_shade {
    svo_i_light_shader shader;
    svo_gather_params gather;
} svo_i_light_shade;

/* Checks the number of cones: 1, 5, 6, 16 or 64; 0 for the default. The message names options.cones of the function. */
svo_status svo_i_light_check_cones(const svo_light *light, const char *function, uint32_t cones);

/* What svo_i_light_shade_begin allocates of the work. */
static inline uint64_t svo_i_light_shade_bytes(const svo_light *light)
{
    const svo_i_light_setup *setup = &light->setup;
    return setup->source_count * sizeof *setup->sources + setup->finish_count * sizeof *setup->finishes;
}

/* Begins; cones as checked. The work stays in use until the end. */
svo_status svo_i_light_shade_begin(svo_i_device_work *work, const svo_light *light, uint32_t cones,
                                   svo_i_light_shade *out);
/* Writes three floats to radiance for each of so many svo_ray: what kernels/light/shade.cl finds. */
svo_status svo_i_light_shade_rays(const svo_i_light_shade *shade, cl_mem rays, cl_mem radiance, uint32_t ray_count);
void svo_i_light_shade_end(svo_i_light_shade *shade);

#endif
