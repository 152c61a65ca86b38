/* SPDX-License-Identifier: MIT */
/*
 * Arrays between the host and the device: those of the mesh that a plan is made from, and those of a plan that kernels
 * made.
 */
#ifndef SVO_LIB_PLAN_ARRAYS_H
#define SVO_LIB_PLAN_ARRAYS_H

#include "core/work.h"
#include "plan/plan_data.h"

/* The mesh that a plan is made from, as buffers of the device. */

/* Packed arrays; NULL where the mesh has none. */
typedef struct svo_i_device_mesh {
    cl_mem positions; /* 3 floats or doubles per vertex */
    cl_mem indices; /* 3 per triangle, 32 bits */
    cl_mem normals, colors, uvs; /* per vertex: 3 floats, RGBA8, 2 floats */
    cl_mem triangle_materials; /* 16 bits per triangle */
} svo_i_device_mesh;

/* What the mesh is given as: host arrays, or views of buffers with the counts, materials and textures in mesh. */
typedef struct svo_i_plan_input {
    svo_mesh mesh;
    const svo_mesh_buffers *buffers; /* NULL: the arrays are the mesh's */
    /* In place of the mesh's normals: x, y, z, 0 per vertex, as nodes have them, of any length. NULL: the mesh's.
       Plans that are updated have none. */
    const int16_t *exact_normals;
    cl_command_queue queue; /* NULL: the device's own */
    cl_uint wait_count;
    const cl_event *wait;
    bool is_of_parts; /* the plan is for the header of parts: the tree may be as deep as theirs, and is not built */
} svo_i_plan_input;

/* Gets the arrays that the request reads. Positions and indices: always. need: resolved svo_need bits. */
svo_status svo_i_device_mesh_geometry(svo_i_device_work *work, const svo_i_plan_input *input, svo_i_device_mesh *out);
svo_status svo_i_device_mesh_attributes(svo_i_device_work *work, const svo_i_plan_input *input, uint32_t need,
                                        svo_i_device_mesh *out);
/* Copies the elements of a view to a buffer, packed. */
svo_status svo_i_plan_copy_view(svo_i_device_work *work, const svo_mesh_view *view, uint64_t count,
                                uint32_t element_bytes, cl_mem to);
void svo_i_device_mesh_free(svo_i_device_mesh *mesh);

/* The arrays of plans that kernels made, for those who need them on the host. */

/* Whether a plan has an array, on the host or on the device. */
bool svo_i_plan_has(const void *host, cl_mem memory);
/* Reads an array of the plan's memory; the caller frees *out. */
svo_status svo_i_plan_read(const svo_plan *plan, cl_mem memory, uint64_t bytes, void **out);
/* Whether a buffer is one of the plan's arrays. */
bool svo_i_plan_owns(const svo_plan *plan, cl_mem buffer);
void svo_i_plan_memory_free(svo_i_plan_memory *memory);

SVO_I_SHARED_BEGIN

/* Brings all arrays to the host, for front ends and builders of OpenGL and for files. Does nothing where they are. */
svo_status svo_i_plan_copy_to_host(svo_plan *plan);

SVO_I_SHARED_END

#endif
