/* SPDX-License-Identifier: MIT */
/*
 * A triangle mesh as the caller hands it over: borrowed arrays, read during svo_plan_create and not touched later.
 * Arrays that lie in a device's buffers are read back first, since vertices are snapped on the host.
 *
 * Any values are allowed in the arrays: triangles with an index out of range or a vertex that is not finite are refused
 * and counted, never undefined. Degenerate triangles (segments, points) are geometry and touch what they touch.
 */
#ifndef SVOCL_MESH_H
#define SVOCL_MESH_H

#include <stddef.h>
#include <stdint.h>

#include "svocl/device.h"

#ifdef __cplusplus
extern "C" {
#endif

/* How texture coordinates outside [0, 1) are read. */
typedef enum svo_wrap { SVO_WRAP_REPEAT = 0, SVO_WRAP_CLAMP = 1, SVO_WRAP_MIRROR = 2 } svo_wrap;

/* RGBA8 texels, 4 bytes each, rows top to bottom without padding; v = 0 is the first row. Sampled bilinearly in fixed
   point, the same on every device. width and height: 1 .. 16384. */
typedef struct svo_texture {
    const uint8_t *rgba;
    uint32_t width, height;
    svo_wrap wrap_u, wrap_v;
} svo_texture;

#define SVO_NO_TEXTURE UINT32_MAX

/* A triangle's color is vertex color * base color * texel, each in [0, 255] / 255, rounded half up. */
typedef struct svo_material {
    uint8_t rgba[4]; /* base color */
    uint32_t texture_index; /* into svo_mesh.textures; SVO_NO_TEXTURE, or any other value out of range: none */
} svo_material;

typedef struct svo_mesh {
    size_t struct_size; /* sizeof(svo_mesh) */

    /* Exactly one of the two, unless vertex_count is 0: x, y, z per vertex, any unit. */
    const float *positions;
    const double *positions_double;
    size_t vertex_count; /* below 2^32 - 1 */

    const uint32_t *indices; /* three per triangle; NULL: vertices 3t, 3t + 1, 3t + 2 */
    size_t triangle_count; /* below 2^32 - 1; the triangle ids of fragments and lists are positions in this array */

    /* Optional attributes, NULL where absent. */
    const float *normals; /* three per vertex, any length; not finite or zero: the triangle's own normal */
    const uint8_t *colors; /* RGBA8 per vertex */
    const float *uvs; /* two per vertex; not finite: 0; limited to -32767 .. 32767 */
    const uint16_t *triangle_materials; /* per triangle, below material_count; NULL: material 0 */
    const svo_material *materials;
    size_t material_count; /* 0: white, no texture; at most 65535 */
    const svo_texture *textures;
    size_t texture_count;
} svo_mesh;
#define SVO_MESH_INIT SVO_STRUCT_INIT(svo_mesh)

/* Where one array of a mesh lies: in an OpenCL buffer for svo_mesh_read, in an OpenGL buffer for svo_gl_mesh_read. The
   other of the two is not looked at. All zero: the mesh has no such array. */
typedef struct svo_mesh_view {
    cl_mem memory;
    uint32_t gl_buffer; /* OpenGL's name */
    size_t offset_bytes; /* of the first element */
    size_t stride_bytes; /* from one element to the next; 0: they follow each other */
} svo_mesh_view;

/* A mesh in buffers; elements as in svo_mesh. */
typedef struct svo_mesh_buffers {
    size_t struct_size; /* sizeof(svo_mesh_buffers) */
    size_t vertex_count, triangle_count; /* below 2^32 - 1 */
    svo_mesh_view positions; /* 3 floats per vertex */
    svo_mesh_view indices; /* 3 per triangle */
    uint32_t index_bytes; /* 0 or 4: indices are uint32_t; 2: uint16_t */
    svo_mesh_view normals, colors, uvs; /* per vertex: 3 floats, RGBA8, 2 floats */
    svo_mesh_view triangle_materials; /* per triangle: uint16_t */
} svo_mesh_buffers;
#define SVO_MESH_BUFFERS_INIT SVO_STRUCT_INIT(svo_mesh_buffers)

/* Arrays on the host, owned. Thread-safety: reading is safe from several threads. */
typedef struct svo_mesh_copy svo_mesh_copy;

/*
 * Reads a mesh out of OpenCL buffers and waits for it. The buffers are not needed afterwards.
 *
 * buffers, out: not NULL. queue: on the buffers' context, in-order or out-of-order.
 * num_wait, wait: events to be complete before anything is read; 0 and NULL: none.
 * message: receives the reason on failure; NULL allowed.
 * Returns SVO_INVALID_ARGUMENT (no positions, a stride below an element, an array that ends behind its buffer),
 * SVO_CL_ERROR (one of the events failed, for example) or SVO_OUT_OF_HOST_MEMORY.
 */
SVO_API svo_status svo_mesh_read(const svo_mesh_buffers *buffers, cl_command_queue queue, cl_uint num_wait,
                                 const cl_event *wait, svo_mesh_copy **out, svo_message *message);
/* The mesh, for svo_plan_create; it lives as long as the copy. Materials and textures are added to a copy of the
   struct. */
SVO_API const svo_mesh *svo_mesh_copy_get(const svo_mesh_copy *copy);
SVO_API void
svo_mesh_copy_destroy(svo_mesh_copy **copy); /* sets *copy to NULL; NULL and a pointer to NULL are allowed */

#ifdef __cplusplus
}
#endif

#endif
