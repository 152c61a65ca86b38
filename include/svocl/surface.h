/* SPDX-License-Identifier: MIT */
/** \file
 * Surfaces: a closed triangle mesh out of a signed distance field, or of any other field of numbers.
 *
 * The mesh lies where the field has a level, 0 unless another is asked for. It follows dual marching cubes (Nielson
 * 2004): the centers of eight voxels make a cube, and a cube that has some below the level and some at or above it gets
 * a vertex for each piece of the surface in it, at the mean of the points where the piece crosses the cube's edges, as
 * surface nets place it (Gibson 1998). Each edge between two centers that the surface crosses gets two triangles, which
 * join the vertices around it. Faces of cubes with two pieces in them are decided as Wenger does (2013, "Isosurfaces",
 * manifold dual marching cubes), so that the mesh is a closed manifold whatever the numbers are: each edge belongs to
 * two triangles, which pass it in opposite directions, and the triangles around a vertex are one ring. Triangles are
 * counterclockwise seen from outside, where the field is at or above the level. They may pass through others where the
 * field is rough.
 *
 * Vertices are less than a voxel's width from the level of the field between centers. Edges and corners of the surface
 * that are sharper than a voxel are cut off.
 *
 * Beyond the field is outside. A surface that reaches its end is closed there, half a voxel beyond the last centers at
 * most.
 *
 * The bytes depend on the numbers alone: a dense field and its narrow band give the same, as does every device.
 *
 * Thread-safety: several threads may call svo_surface_create with one field and one tree, and functions that take a
 * const surface.
 */
#ifndef SVOCL_SURFACE_H
#define SVOCL_SURFACE_H

#include <stddef.h>
#include <stdint.h>

#include "svocl/memory.h"
#include "svocl/mesh.h"
#include "svocl/sdf.h"
#include "svocl/tree.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SVO_SURFACE_SIZE_MAX 65536u /**< most voxels of a field along an axis */

/** A field on the host. svo_surface_field_of makes one of a signed distance field. The arrays are borrowed. */
typedef struct svo_surface_field {
    size_t struct_size; /**< sizeof(svo_surface_field) */
    /** voxel_count, finite. Dense: in rows along x, then y, then z, as SVO_SDF_DISTANCES. At level 0, -0 is inside. */
    const float *distances;
    /** voxel_count: Morton codes of the voxels (svo_cell_to_code), ascending. NULL: dense. */
    const uint64_t *codes;
    uint64_t voxel_count; /**< elements of each array; dense: size[0] size[1] size[2] */
    uint32_t size[3]; /**< voxels along x, y, z: 1 .. SVO_SURFACE_SIZE_MAX each */
    double first[3]; /**< center of voxel 0, 0, 0, world coordinates; finite */
    double spacing; /**< width of a voxel, world units; finite and above 0 */
} svo_surface_field;

/** No field. */
#define SVO_SURFACE_FIELD_INIT SVO_STRUCT_INIT(svo_surface_field)

/** What vertices have besides their position. */
typedef enum svo_surface_parts {
    SVO_SURFACE_NORMALS = 1, /**< unit normals: the field's gradient, of its trilinear interpolation */
    SVO_SURFACE_COLORS = 2, /**< the color of the tree's leaf whose center is nearest */
    SVO_SURFACE_LEAF_NORMALS = 4 /**< in place of the gradient, the normal of that leaf */
} svo_surface_parts;

/** Options of a surface. */
typedef struct svo_surface_options {
    size_t struct_size; /**< sizeof(svo_surface_options) */
    /** Inside is what is below it; at level 0, what has the sign bit. In the field's unit, finite. */
    float level;
    uint32_t parts; /**< svo_surface_parts bits */
    /** For colors and normals of leaves: a tree with host arrays (svo_tree_download), a leaf at least, and that payload
     *  in its leaves, in the world of the field. Else unused; NULL allowed. */
    const svo_tree *tree;
    const svo_memory_callbacks *memory; /**< host memory of the surface; NULL: malloc and free */
} svo_surface_options;

/** All defaults: level 0, positions alone. */
#define SVO_SURFACE_OPTIONS_INIT SVO_STRUCT_INIT(svo_surface_options)

/** What a surface consists of. */
typedef struct svo_surface_info {
    size_t struct_size; /**< sizeof(svo_surface_info) */
    uint64_t vertex_count; /**< vertices; 0 where the field has no inside */
    uint64_t triangle_count; /**< triangles */
    uint64_t end_triangles; /**< of those, around edges that leave the field: what reaches its end is closed there */
    uint64_t bytes; /**< host memory of the mesh */
} svo_surface_info;

/** An empty output. */
#define SVO_SURFACE_INFO_INIT SVO_STRUCT_INIT(svo_surface_info)

/** A surface. It owns its mesh. */
typedef struct svo_surface svo_surface;

/** Describes a signed distance field as a field on the host.
 *
 * \param sdf with host arrays (svo_sdf_download)
 * \param field receives the description, which borrows the arrays
 * \returns SVO_INVALID_ARGUMENT: before svo_sdf_download, or when field is NULL or its struct_size is too small. */
SVO_API svo_status svo_surface_field_of(const svo_sdf *sdf, svo_surface_field *field);

/** Makes the surface of a field, on the calling thread.
 *
 * A narrow band needs all voxels of the cubes that the surface passes. That of a closed mesh, or without signs, has
 * them from |level| / spacing + 2.5 voxels on. Where the mesh has holes, signs change far from it, beyond the band. A
 * field without signs has an inside at levels above 0 alone: what is nearer than that.
 *
 * \param field not NULL
 * \param options NULL means all defaults
 * \param out receives the surface
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_INVALID_ARGUMENT (field or options; a number that is not finite; codes that do not ascend; a surface
 *          that leaves the band; centers that floats cannot tell apart), SVO_UNSUPPORTED (2^32 - 1 vertices or
 *          triangles, or more) or SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_surface_create(const svo_surface_field *field, const svo_surface_options *options,
                                      svo_surface **out, svo_message *message);

/** Frees a surface and its mesh.
 *
 * \param surface set to NULL; NULL and a pointer to NULL are allowed */
SVO_API void svo_surface_destroy(svo_surface **surface);

/** Describes a surface.
 *
 * \param surface not NULL
 * \param info receives the description
 * \returns SVO_INVALID_ARGUMENT when info is NULL or its struct_size is too small. */
SVO_API svo_status svo_surface_get_info(const svo_surface *surface, svo_surface_info *info);

/** The mesh: float positions, indices, and the parts that were asked for. No vertex is without a triangle.
 *
 * \param surface not NULL
 * \returns the mesh; lives as long as the surface. */
SVO_API const svo_mesh *svo_surface_get_mesh(const svo_surface *surface);

#ifdef __cplusplus
}
#endif

#endif
