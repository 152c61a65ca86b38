/* SPDX-License-Identifier: MIT */
/** \file
 * Triangle meshes. svo_plan_create reads the caller's arrays and does not need them afterwards. Arrays in OpenCL
 * buffers stay there: svo_plan_create_from_buffers makes the plan on the device. On devices without doubles or
 * denormals, they are read back first (svo_mesh_read).
 *
 * The arrays may hold any values. A triangle with an index out of range or a vertex that is not finite is refused and
 * counted. Degenerate triangles (segments, points) are geometry and occupy the voxels that they touch.
 */
#ifndef SVOCL_MESH_H
#define SVOCL_MESH_H

#include <stddef.h>
#include <stdint.h>

#include "svocl/device.h"
#include "svocl/light_types.h"

#ifdef __cplusplus
extern "C" {
#endif

/** How texture coordinates outside [0, 1) are mapped into it. */
typedef enum svo_wrap {
    SVO_WRAP_REPEAT = 0, /**< the fractional part */
    SVO_WRAP_CLAMP = 1, /**< the nearest texel */
    SVO_WRAP_MIRROR = 2 /**< every second repetition is mirrored */
} svo_wrap;

/** An RGBA8 image, sampled bilinearly in fixed point with the same result on every device. */
typedef struct svo_texture {
    /** height rows of width texels of 4 bytes, top to bottom, without padding; v = 0 is the first row. */
    const uint8_t *rgba;
    uint32_t width; /**< texels, 1 .. 16384 */
    uint32_t height; /**< texels, 1 .. 16384 */
    svo_wrap wrap_u; /**< along a row */
    svo_wrap wrap_v; /**< along a column */
} svo_texture;

#define SVO_NO_TEXTURE UINT32_MAX /**< svo_material.texture_index without a texture */

/** A material. A triangle's color is vertex color * base color * texel, each in [0, 255] / 255, rounded half up. */
typedef struct svo_material {
    uint8_t rgba[4]; /**< base color */
    uint32_t texture_index; /**< into svo_mesh.textures; SVO_NO_TEXTURE or any other value out of range: no texture */
} svo_material;

/** How a material bends normals, for pictures of light. The texture's red, green and blue are x, y and z of a unit
 *  vector, 2 c / 255 - 1 each: x goes along u, y against v, which is up in the image, z out of the surface, as normal
 *  textures of glTF 2.0 have them (OpenGL's convention). Alpha is not read. */
typedef struct svo_normal_map {
    uint32_t texture_index; /**< into svo_mesh.textures; SVO_NO_TEXTURE or any other value out of range: no map */
    float scale; /**< what x and y are multiplied by, finite */
} svo_normal_map;

/** A mesh in host memory. The arrays are borrowed. */
typedef struct svo_mesh {
    size_t struct_size; /**< sizeof(svo_mesh) */
    const float *positions; /**< vertex_count * 3: x, y, z in any unit. Either this or positions_double is NULL */
    const double *positions_double; /**< vertex_count * 3: the same in double precision */
    size_t vertex_count; /**< below 2^32 - 1 */
    const uint32_t *indices; /**< triangle_count * 3; NULL: triangle t has the vertices 3t, 3t + 1, 3t + 2 */
    size_t triangle_count; /**< below 2^32 - 1. Results name triangles by their position in indices */
    const float *normals; /**< vertex_count * 3, any length; zero or not finite: the triangle's own. NULL: none */
    const uint8_t *colors; /**< vertex_count * 4: RGBA8. NULL: none */
    const float *uvs; /**< vertex_count * 2, clamped to -32767 .. 32767; not finite: 0. NULL: none */
    const uint16_t *triangle_materials; /**< triangle_count: into materials; out of range: 0. NULL: all 0 */
    const svo_material *materials; /**< material_count; NULL when that is 0 */
    size_t material_count; /**< at most 65535; 0: white without a texture */
    const svo_texture *textures; /**< texture_count; NULL when that is 0 */
    size_t texture_count; /**< any */
    /** material_count: what materials do besides their color, for svo_light_setup; builds do not read it. NULL: all are
     *  diffuse and none emits. */
    const svo_finish *finishes;
    /** material_count: how materials bend normals, for svo_light_set_mesh; builds do not read them. NULL: none do. */
    const svo_normal_map *normal_maps;
} svo_mesh;

/** No vertices, no triangles. */
#define SVO_MESH_INIT SVO_STRUCT_INIT(svo_mesh)

/** One array of a mesh in a buffer. All zero: the mesh has no such array. */
typedef struct svo_mesh_view {
    cl_mem memory; /**< OpenCL buffer, for svo_mesh_read */
    uint32_t gl_buffer; /**< name of an OpenGL buffer, for svo_gl_mesh_read */
    size_t offset_bytes; /**< of the first element */
    size_t stride_bytes; /**< between the starts of elements; 0: they are packed */
} svo_mesh_view;

/** A mesh in buffers. Elements are those of svo_mesh. */
typedef struct svo_mesh_buffers {
    size_t struct_size; /**< sizeof(svo_mesh_buffers) */
    size_t vertex_count; /**< below 2^32 - 1 */
    size_t triangle_count; /**< below 2^32 - 1 */
    svo_mesh_view positions; /**< 3 floats per vertex */
    svo_mesh_view indices; /**< 3 per triangle */
    uint32_t index_bytes; /**< 0 or 4: indices are uint32_t; 2: uint16_t */
    svo_mesh_view normals; /**< 3 floats per vertex */
    svo_mesh_view colors; /**< RGBA8 per vertex */
    svo_mesh_view uvs; /**< 2 floats per vertex */
    svo_mesh_view triangle_materials; /**< uint16_t per triangle */
    const svo_memory_callbacks *memory; /**< host memory of the mesh that is read; NULL: malloc and free */
    const svo_material *materials; /**< as in svo_mesh, on the host; svo_mesh_read refers to them */
    size_t material_count; /**< of materials */
    const svo_texture *textures; /**< as in svo_mesh, on the host; svo_mesh_read refers to them */
    size_t texture_count; /**< of textures */
} svo_mesh_buffers;

/** No arrays. */
#define SVO_MESH_BUFFERS_INIT SVO_STRUCT_INIT(svo_mesh_buffers)

/** A mesh that owns its host arrays. Thread-safety: several threads may read it. */
typedef struct svo_mesh_copy svo_mesh_copy;

/** Reads a mesh from OpenCL buffers to the host and waits for it. The buffers are not needed afterwards.
 * svo_plan_create_from_buffers (plan.h) makes a plan without it: the mesh stays where it is.
 *
 * \param buffers where the arrays are
 * \param queue not NULL, on the buffers' context, in-order or out-of-order
 * \param num_wait number of events in wait
 * \param wait events to wait for first; NULL when num_wait is 0
 * \param out receives the mesh
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_INVALID_ARGUMENT (no positions, a stride below an element, an array beyond the end of its buffer, a
 *          buffer or an event of another context than the queue's),
 *          SVO_CL_ERROR (a failed event, for example) or SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_mesh_read(const svo_mesh_buffers *buffers, cl_command_queue queue, cl_uint num_wait,
                                 const cl_event *wait, svo_mesh_copy **out, svo_message *message);

/** The mesh that was read, for svo_plan_create. To add materials and textures, copy the struct.
 *
 * \param copy not NULL
 * \returns the mesh; lives as long as copy. */
SVO_API const svo_mesh *svo_mesh_copy_get(const svo_mesh_copy *copy);

/** Frees a mesh that was read.
 *
 * \param copy set to NULL; NULL and a pointer to NULL are allowed */
SVO_API void svo_mesh_copy_destroy(svo_mesh_copy **copy);

#ifdef __cplusplus
}
#endif

#endif
