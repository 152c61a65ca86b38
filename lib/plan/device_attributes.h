/* SPDX-License-Identifier: MIT */
/* The payload inputs by kernels: the same steps and the same bytes as attributes.c on the host. */
#ifndef SVO_LIB_PLAN_DEVICE_ATTRIBUTES_H
#define SVO_LIB_PLAN_DEVICE_ATTRIBUTES_H

#include "plan/device_mesh.h"

/* Columns of svo_k_plan_records. */
#define SVO_I_RECORD_COLUMNS 5

/* A byte per material: whether it has a texture; whether a kept triangle has it, which the kernel sets. */
typedef struct svo_i_material_marks {
    cl_mem textured, used;
} svo_i_material_marks;

/* Launches that read nothing back. partials: receives SVO_I_RECORD_COLUMNS columns. */
svo_status svo_i_launch_normals(svo_i_device_work *work, cl_mem from, cl_mem to, cl_uint vertices);
svo_status svo_i_launch_uvs(svo_i_device_work *work, cl_mem from, cl_mem to, cl_ulong numbers);
svo_status svo_i_launch_records(svo_i_device_work *work, const svo_plan *plan, const svo_i_device_mesh *mesh,
                                const svo_i_material_marks *marks, cl_mem partials);

/* Resolves SVO_NEED_DEFAULT, fills the payload inputs and finds constant payload. mesh receives the arrays that are
   read; the caller frees it. */
svo_status svo_i_device_attributes(svo_plan *plan, svo_i_device_work *work, const svo_i_plan_input *input,
                                   svo_i_device_mesh *mesh);

#endif
