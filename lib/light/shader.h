/* SPDX-License-Identifier: MIT */
/*
 * Options of gathering, and kernels that shade surfaces of a lit tree. These take the arguments that SVO_LIT_PARAMETERS
 * of kernels/light/surface.clh declares, and then their own.
 */
#ifndef SVO_LIB_LIGHT_SHADER_H
#define SVO_LIB_LIGHT_SHADER_H

#include "light/handle.h"

/* The options, checked, with the defaults for 0. by_default: the method where the options name none and no cones;
   for_picture: the defaults are those of pictures. */
svo_status svo_i_light_read_gather(const svo_light *light, const char *function, const char *argument,
                                   const svo_gather_options *options, svo_gather_method by_default, bool for_picture,
                                   svo_gather_params *params);

/* svo_kernel_options of a light. Static string. */
const char *svo_i_light_options(const svo_light *light);
/* The defines among them: of the light's form, and of the map of its sky. */
const char *svo_i_light_form_defines(const svo_light *light);

/* A kernel, and what lights the tree. */
typedef struct svo_i_light_shader {
    const svo_light *light;
    svo_i_device_work *work;
    cl_kernel kernel; /* owned */
    cl_mem sources, finishes; /* the work's; NULL: none */
} svo_i_light_shader;

/* Makes the kernel, with more defines, and uploads what lights the tree. The work stays in use until the end. */
svo_status svo_i_light_shader_begin(svo_i_device_work *work, const svo_light *light, const svo_i_program *program,
                                    const char *kernel_name, const char *defines, svo_i_light_shader *out);
/* Another kernel of the same program, work and uploads. Ended before the first one. */
svo_status svo_i_light_shader_also(const svo_i_light_shader *first, const svo_i_program *program,
                                   const char *kernel_name, const char *defines, svo_i_light_shader *out);
/* What params have of a light: numbers of sources, finishes and emitters. */
svo_lit_picture_params svo_i_light_shader_params(const svo_light *light, uint32_t view);
/* Sets the kernel's arguments. own: its own ones, own_count. */
svo_status svo_i_light_shader_set(const svo_i_light_shader *shader, const svo_gather_params *gather,
                                  const svo_lit_picture_params *params, const svo_i_argument *own, cl_uint own_count);
/* Launches so many whole groups from one on, as the work's next command. */
svo_status svo_i_light_shader_launch(const svo_i_light_shader *shader, size_t first_group, size_t groups);
/* Releases the kernel, but not what the work owns. */
void svo_i_light_shader_end(svo_i_light_shader *shader);

#endif
