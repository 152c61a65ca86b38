/* SPDX-License-Identifier: MIT */
/* Kernels that shade surfaces of a lit tree: pictures, and radiance along rays. Their arguments are those that
   SVO_LIT_PARAMETERS of kernels/light/surface.clh declares, and then their own. */
#ifndef SVO_LIB_LIGHT_SHADER_H
#define SVO_LIB_LIGHT_SHADER_H

#include "light/state.h"

/* A kernel, and what lights the tree. */
typedef struct svo_i_light_shader {
    const svo_light *light;
    svo_i_device_work *work;
    cl_kernel kernel; /* owned */
    cl_mem sources, finishes; /* the work's; NULL: none */
} svo_i_light_shader;

/* What svo_i_light_shader_begin allocates of the work. */
uint64_t svo_i_light_shader_bytes(const svo_light *light);

/* Makes the kernel and uploads what lights the tree. The work stays in use until svo_i_light_shader_end. */
svo_status svo_i_light_shader_begin(svo_i_device_work *work, const svo_light *light, const svo_i_program *program,
                                    const char *kernel_name, svo_i_light_shader *out);
/* Launches so many whole groups. own: the kernel's own arguments, own_count. */
svo_status svo_i_light_shader_launch(const svo_i_light_shader *shader, const svo_gather_params *gather,
                                     const svo_lit_picture_params *params, const svo_i_argument *own, cl_uint own_count,
                                     uint64_t groups);
/* Releases the kernel, but not what the work owns. */
void svo_i_light_shader_end(svo_i_light_shader *shader);

/* What params have of a light: sky, numbers of sources and finishes. */
svo_lit_picture_params svo_i_light_shader_params(const svo_light *light, uint32_t view);

#endif
