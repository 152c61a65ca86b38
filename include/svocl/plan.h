/* SPDX-License-Identifier: MIT */
/*
 * A plan: what one build of one mesh will do, decided before anything is allocated on the device.
 *
 * Making a plan reads the mesh once: it validates the triangles, sets up the grid, snaps the vertices to integers,
 * sorts triangles into classes by the arithmetic their overlap test needs, and predicts the sizes of all buffers by the
 * count law (for a triangle with bounding widths w, area A and unit normal n on voxels of edge h, over random offsets,
 * E[voxels] = 1 + (wx + wy + wz) / h + A (|nx| + |ny| + |nz|) / h^2).
 */
#ifndef SVOCL_PLAN_H
#define SVOCL_PLAN_H

#include <stddef.h>
#include <stdint.h>

#include "svocl/device.h"
#include "svocl/mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SVO_DEPTH_MIN 1
#define SVO_DEPTH_MAX 16

typedef struct svo_plan svo_plan;

/* What will be read from the tree besides its occupancy. */
typedef enum svo_need {
    SVO_NEED_DEFAULT = 0, /* the colours and normals that the mesh has */
    SVO_NEED_COLOR = 1, /* RGBA8 per node; white if the mesh has neither colours nor materials */
    SVO_NEED_NORMAL = 2, /* 3 x int16 per node; the triangles' own normals if the mesh has none */
    SVO_NEED_RAYS = 4, /* leaf lists, snapped vertices and indices; trace.h makes the rest when it is asked for */
    SVO_NEED_MATERIAL = 8, /* 16 bits per node: the material that weighs most in it; of equals the smaller */
    SVO_NEED_FILL = 16, /* 16 bits per node: area of the surface in it, 4096 = one of its faces, 65535 at most */
    SVO_NEED_NONE = 0x40000000 /* occupancy alone */
} svo_need;
#define SVO_NEED_ALL 0x1f /* every bit of the above */
/* Of one bit: "color", "normal", "rays", "material", "fill"; else "none". Static string. */
SVO_API const char *svo_need_name(svo_need bit);

/* Which voxels a triangle touches; the triangle is closed, and a voxel covers w grid units. */
typedef enum svo_coverage {
    /* [x, x + 1)^3: every surface point lies in exactly one voxel. 6-separating. */
    SVO_COVERAGE_HALF_OPEN = 0,
    /* [x, x + 1]^3: a superset, 26-separating. */
    SVO_COVERAGE_CLOSED = 1,
    /* 6-separating and never more than half-open: the separating axis test with a reach of w / 2 * max |n_i| around the
       voxel's centre on each axis n, after Laine, "A Topological Approach to Voxelization", 2013. Upper levels are the
       ancestors of the leaves. */
    SVO_COVERAGE_THIN = 2
} svo_coverage;
SVO_API const char *svo_coverage_name(svo_coverage coverage); /* "half-open", "closed", "thin"; static string */

/* What a (voxel, triangle) pair weighs in the means of its voxel and of all nodes above, and where on the triangle its
   attributes are taken. All in integers: the same bytes everywhere. */
typedef enum svo_weights {
    /* The area of the part of the triangle inside the voxel, at its centroid. What has no area there, such as segments,
       points, and triangles that only touch, weighs one unit, 2^-31 of the heaviest pair or (in large scenes) somewhat
       more. */
    SVO_WEIGHTS_AREA = 0,
    SVO_WEIGHTS_UNIFORM = 1, /* 1; at the triangle's own centroid, whatever the voxel. The cheapest */
    /* 1; at the point of the triangle that the voxel's middle has in front of it along the triangle's dominant axis, or
       at the triangle's rim if that misses it. */
    SVO_WEIGHTS_CENTRE = 2
} svo_weights;
SVO_API const char *svo_weights_name(svo_weights weights); /* "area", "uniform", "centre"; static string */

/* How the tree is made of the fragment list; the tree is the same, bit for bit. */
typedef enum svo_builder {
    SVO_BUILDER_CL = 0, /* "cl": from the root down, level by level; the list stays as it is, in chunks */
    /* "sorted": the list is sorted by Morton code, and the levels follow from the leaves up. Asks for the list in one
       buffer, and for as much again to sort it. */
    SVO_BUILDER_SORTED = 1
} svo_builder;
SVO_API const char *svo_builder_name(svo_builder builder); /* "cl", "sorted"; static string */

typedef struct svo_plan_options {
    size_t struct_size; /* sizeof(svo_plan_options) */
    uint32_t need; /* svo_need bits */
    svo_coverage coverage;
    svo_weights weights; /* of the payload; SVO_NEED_FILL asks for SVO_WEIGHTS_AREA */
    svo_builder builder;
    /* The caller's grid: the cube [origin, origin + edge). edge = 0: fitted to the accepted triangles. Otherwise edge is
       finite and above 0, origin finite. Triangles outside touch nothing; vertices may lie less than 2^29 grid units away (512 edges;
       32 at depth 16). */
    double origin[3];
    double edge;
    /* Fragments the list has room for at first, at most 2^32 - 65537; 0: by the count law. The blocking build grows it
       when it was too small. */
    uint64_t fragment_capacity;
    /* Upper limit in bytes for one chunk of the list, at least 16384; 0: what the device and the front end allow. */
    uint64_t chunk_bytes;
} svo_plan_options;

typedef struct svo_plan_info {
    uint32_t depth;
    uint32_t snap_bits; /* G: the grid is 2^G units wide; 20 up to depth 12, depth + 8 above */
    uint32_t coverage; /* svo_coverage */
    uint32_t need; /* resolved: never SVO_NEED_DEFAULT; 0 means occupancy alone */
    uint64_t triangles; /* given */
    uint64_t refused_triangles; /* of those: an index out of range, not finite, or 2^29 units and more from the grid */
    uint64_t outside_triangles; /* of those: accepted, but their bounds miss the caller's grid */
    double origin[3]; /* world */
    double edge; /* world */
    double scale; /* grid units per world unit */
    double snap_error; /* world: the largest |q / scale + origin - v| over accepted vertices' coordinates */
    double expected_fragments; /* count law, before any slack */
    double grid_ms; /* wall clock spent in validating, snapping and classifying */
} svo_plan_info;

typedef struct svo_buffer_info {
    const char *name; /* static string */
    uint64_t bytes;
    uint64_t count; /* cl_mems it is split into */
} svo_buffer_info;

/*
 * Makes a plan. The mesh's arrays are not needed afterwards.
 *
 * depth: SVO_DEPTH_MIN .. SVO_DEPTH_MAX; the grid has 2^depth voxels per axis.
 * options: NULL means all defaults.
 * Returns SVO_INVALID_ARGUMENT (depth, options, arrays missing, a grid that cannot be scaled),
 * SVO_OUT_OF_DEVICE_MEMORY (2^32 texels and more), SVO_OUT_OF_HOST_MEMORY.
 */
SVO_API svo_status svo_plan_create(svo_device *device, const svo_mesh *mesh, unsigned depth,
                                   const svo_plan_options *options, svo_plan **out);
SVO_API void svo_plan_destroy(svo_plan **plan);

SVO_API void svo_plan_get_info(const svo_plan *plan, svo_plan_info *info);

/* The depth that suits a tree whose triangles are asked for, 1 .. 12, whatever the plan's own depth: the deepest where the
   count law expects a triangle in at most 6 leaves, so that voxels are about as large as triangles and lists stay short.
   Neither which triangle a ray meets nor how quickly depends on the depth. */
SVO_API unsigned svo_plan_ray_depth(const svo_plan *plan);

/* The OpenCL buffers a build of this plan allocates, in order of allocation: predicted before a build, exact after one,
   attempts that were too small included. A plan does not know its front end: what that of OpenCL alone allocates for
   itself (mesh_vertices, mesh_indices, mesh_items, mesh_tiles, counters) is listed after a build only. Memory of OpenGL
   (the mesh; with share "copy" its side of the list) is apart.
   Returns their number; *info receives entry index, which must be below it; info may be NULL. */
SVO_API size_t svo_plan_get_buffer(const svo_plan *plan, size_t index, svo_buffer_info *info);
/* The largest sum of bytes that is allocated at one time. */
SVO_API uint64_t svo_plan_peak_bytes(const svo_plan *plan);

#ifdef __cplusplus
}
#endif

#endif
