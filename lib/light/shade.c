/* SPDX-License-Identifier: MIT */
/* The host side of kernels/light/shade.cl. */
#include "light/shade.h"

#include "light/gather.h"
#include "light/programs.h"

/* Rays of a work-item: SVO_SHADE_RAYS of the kernel. */
#define ITEM_RAYS 64u

static svo_status gather_params(const svo_light *light, const char *function, uint32_t cones, svo_gather_params *out)
{
    const svo_gather_options options = {.struct_size = sizeof options, .cones = cones};
    return svo_i_gather_params(light, function, &options, out);
}

svo_status svo_i_light_check_cones(const svo_light *light, const char *function, uint32_t cones)
{
    svo_gather_params unused;
    return gather_params(light, function, cones, &unused);
}

svo_status svo_i_light_shade_begin(svo_i_device_work *work, const svo_light *light, uint32_t cones,
                                   svo_i_light_shade *out)
{
    *out = (svo_i_light_shade){.shader = {.light = light}};
    SVO_I_TRY(gather_params(light, work->function, cones, &out->gather));
    return svo_i_light_shader_begin(work, light, &svo_i_program_light_shade, "svo_k_light_shade", &out->shader);
}

svo_status svo_i_light_shade_rays(const svo_i_light_shade *shade, cl_mem rays, cl_mem radiance, uint32_t ray_count)
{
    svo_lit_picture_params params = svo_i_light_shader_params(shade->shader.light, SVO_LIT_VIEW_MATTE);
    const svo_i_argument own[] = {SVO_I_ARGUMENT(rays), SVO_I_ARGUMENT(radiance)};
    const uint32_t group_rays = ITEM_RAYS * SVO_GROUP_ITEMS;
    params.width = ray_count;
    return svo_i_light_shader_launch(&shade->shader, &shade->gather, &params, SVO_I_ARGUMENTS(own),
                                     ((uint64_t)ray_count + group_rays - 1) / group_rays);
}

void svo_i_light_shade_end(svo_i_light_shade *shade)
{
    svo_i_light_shader_end(&shade->shader);
}
