/* SPDX-License-Identifier: MIT */
/*
 * A plan: what one build of one mesh will do, decided before anything is allocated on the device.
 *
 * Making a plan reads the mesh once: it validates the triangles, sets up the grid, snaps the vertices to integers,
 * sorts triangles into classes by the arithmetic their overlap test needs, and predicts the sizes of all buffers by the
 * fragment estimate (for a triangle with bounding widths w, area A and unit normal n on voxels of edge h, over random
 * offsets, E[voxels] = 1 + (wx + wy + wz) / h + A (|nx| + |ny| + |nz|) / h^2).
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
    SVO_NEED_DEFAULT = 0, /* the colors and normals that the mesh has */
    SVO_NEED_COLOR = 1, /* RGBA8 per node; white if the mesh has neither colors nor materials */
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
       voxel's center on each axis n, after Laine, "A Topological Approach to Voxelization", 2013. Upper levels are the
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
    SVO_WEIGHTS_CENTER = 2
} svo_weights;
SVO_API const char *svo_weights_name(svo_weights weights); /* "area", "uniform", "center"; static string */

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
    /* The first level whose payload is read, 0 .. depth: 0 for all of them, depth for the leaves alone. Nodes above
       have none, and nothing is summed up for them. */
    uint32_t payload_level;
    /* The caller's grid: the cube [origin, origin + edge). edge = 0: fitted to the accepted triangles. Otherwise edge
       is finite and above 0, origin finite. Triangles outside touch nothing; vertices may lie less than 2^29 grid units
       away (512 edges;
       32 at depth 16). */
    double origin[3];
    double edge;
    /* Fragments the list has room for at first, at most 2^32 - 65537; 0: by the fragment estimate. The blocking build
       grows it when it was too small. */
    uint64_t fragment_capacity;
    /* Not 0: room for as many inner nodes as the fragments could possibly make, in place of as many as the fragment
       estimate expects with an eighth to spare. */
    uint32_t worst_case_nodes;
    /* Upper limit in bytes for one chunk of the list, at least 16384; 0: what the device and the front end allow. */
    uint64_t chunk_bytes;
} svo_plan_options;
#define SVO_PLAN_OPTIONS_INIT SVO_STRUCT_INIT(svo_plan_options)

typedef struct svo_plan_info {
    size_t struct_size; /* sizeof(svo_plan_info) */
    uint32_t depth;
    uint32_t snap_bits; /* G: the grid is 2^G units wide; 20 up to depth 12, depth + 8 above */
    uint32_t coverage; /* svo_coverage */
    uint32_t need; /* resolved: never SVO_NEED_DEFAULT; 0 means occupancy alone */
    uint32_t constant; /* of those, the payload that is the same in every node: it is stored once */
    uint64_t triangles; /* given */
    uint64_t refused_triangles; /* of those: an index out of range, not finite, or 2^29 units and more from the grid */
    uint64_t outside_triangles; /* of those: accepted, but their bounds miss the caller's grid */
    double origin[3]; /* world */
    double edge; /* world */
    double scale; /* grid units per world unit */
    double snap_error; /* world: the largest |q / scale + origin - v| over accepted vertices' coordinates */
    double expected_fragments; /* fragment estimate, before any slack */
    uint64_t fragments; /* their number, once svo_plan_count has found it; 0 before */
    double grid_ms; /* wall clock spent in validating, snapping and classifying */
} svo_plan_info;
#define SVO_PLAN_INFO_INIT SVO_STRUCT_INIT(svo_plan_info)

/* How well the bytes of a buffer are known before a build. */
typedef enum svo_certainty {
    SVO_BYTES_EXACT = 0, /* these */
    SVO_BYTES_BOUND = 1, /* these at most */
    SVO_BYTES_ESTIMATE = 2 /* by the fragment estimate, with an eighth and some to spare: rarely more, usually fewer */
} svo_certainty;
SVO_API const char *svo_certainty_name(svo_certainty certainty); /* "exact", "bound", "estimate"; static string */

typedef struct svo_buffer_info {
    size_t struct_size; /* sizeof(svo_buffer_info) */
    const char *name; /* static string */
    uint64_t bytes;
    uint64_t count; /* cl_mems it is split into */
    svo_certainty certainty; /* SVO_BYTES_EXACT after a build */
    int persistent; /* not 0: part of the tree; 0: scratch, released before the build ends */
} svo_buffer_info;
#define SVO_BUFFER_INFO_INIT SVO_STRUCT_INIT(svo_buffer_info)

/* A program of kernels that a build of the plan compiles, unless the device has it already. */
typedef struct svo_kernels_info {
    size_t struct_size; /* sizeof(svo_kernels_info) */
    const char *name; /* "build", "voxelize", "sort"; static string */
    const char
        *defines; /* " -DSVO_COLOR -DSVO_WEIGHTS_AREA": which parts and variants of them; lives as long as the plan */
} svo_kernels_info;
#define SVO_KERNELS_INFO_INIT SVO_STRUCT_INIT(svo_kernels_info)

/* Something that a build of the plan does without. */
typedef struct svo_left_out {
    size_t struct_size; /* sizeof(svo_left_out) */
    const char *what; /* "leaf lists", "color per node"; static string */
    const char *reason; /* one line; lives as long as the plan */
} svo_left_out;
#define SVO_LEFT_OUT_INIT SVO_STRUCT_INIT(svo_left_out)

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

SVO_API svo_status svo_plan_get_info(const svo_plan *plan, svo_plan_info *info);

/* The depth that suits a tree whose triangles are asked for, 1 .. 12, whatever the plan's own depth: the deepest where
   the fragment estimate expects a triangle in at most 6 leaves, so that voxels are about as large as triangles and
   lists stay short. Neither which triangle a ray meets nor how quickly depends on the depth. */
SVO_API unsigned svo_plan_ray_depth(const svo_plan *plan);

/* The OpenCL buffers a build of this plan allocates, in order of allocation: predicted before a build, with the front
   end of OpenCL alone; exact after one, attempts that were too small included. With a front end of OpenGL,
   mesh_vertices, mesh_indices, mesh_items, mesh_tiles and counters are not among them: OpenGL's memory (the mesh; with
   share "copy" its side of the list) is apart, and so are the buffers that kernels are tried on when they are compiled,
   which are released before the build allocates. svo_workspace_create makes it what a workspace and a tree hold.
   Returns their number; *info receives entry index, which must be below it; info may be NULL. */
SVO_API size_t svo_plan_buffer_count(const svo_plan *plan);
SVO_API svo_status svo_plan_get_buffer(const svo_plan *plan, size_t index, svo_buffer_info *info);
/* The largest sum of bytes that is allocated at one time, and what of it stays in the tree. */
SVO_API uint64_t svo_plan_peak_bytes(const svo_plan *plan);
SVO_API uint64_t svo_plan_tree_bytes(const svo_plan *plan);

/* The programs of kernels, with the front end of OpenCL alone. Returns their number; *info receives entry index, which
   must be below it; info may be NULL. */
SVO_API size_t svo_plan_kernels_count(const svo_plan *plan);
SVO_API svo_status svo_plan_get_kernels(const svo_plan *plan, size_t index, svo_kernels_info *info);

/* What this mesh and this request have no use for: stages that do not run, buffers that do not exist, kernels and
   variants of them that are not compiled. Returns their number; *entry receives entry index, which must be below it;
   entry may be NULL. What was asked for is the same, bit for bit, as if all of it were done. */
SVO_API size_t svo_plan_left_out_count(const svo_plan *plan);
SVO_API svo_status svo_plan_get_left_out(const svo_plan *plan, size_t index, svo_left_out *entry);

#ifdef __cplusplus
}
#endif

#endif
