/* SPDX-License-Identifier: MIT */
/* Light at points and along rays. */
#ifndef SVO_LIB_LIGHT_GATHER_H
#define SVO_LIB_LIGHT_GATHER_H

#include "light/shader.h"

typedef struct svo_i_light_shade {
    svo_i_light_shader shader;
    svo_gather_params gather;
} svo_i_light_shade;

/* Sets the arguments that SVO_LIGHT_PARAMETERS of kernels/light/light.clh declares. of: a light. */
svo_status svo_i_light_set_target(void *of, const char *function, cl_kernel kernel, cl_uint first_index);

/* kernels/light/gather_rays.cl, a work-item for each point of a buffer: begins it, by the second function with the work
   and the uploads of another kernel, and sets its arguments. */
svo_status svo_i_light_points_begin(svo_i_device_work *work, const svo_light *light, const svo_gather_params *gather,
                                    svo_i_light_shader *out);
svo_status svo_i_light_points_also(const svo_i_light_shader *first, const svo_gather_params *gather,
                                   svo_i_light_shader *out);
svo_status svo_i_light_points_set(const svo_i_light_shader *shader, const svo_gather_params *gather,
                                  uint32_t source_rays_log2, cl_mem points, cl_mem results, uint32_t point_count);

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
