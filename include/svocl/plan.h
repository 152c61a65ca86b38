/* SPDX-License-Identifier: MIT */
/** \file
 * The plan: what a build of one mesh will do, decided before anything is allocated on the device.
 *
 * svo_plan_create reads the mesh once. It validates the triangles, places the grid, rounds the vertices to integers,
 * classifies the triangles by the arithmetic that their overlap test needs, and predicts the size of every buffer with
 * the fragment estimate: a triangle with bounding widths w, area A and unit normal n touches, on voxels of edge h and
 * averaged over random offsets, E = 1 + (wx + wy + wz) / h + A (|nx| + |ny| + |nz|) / h^2 voxels.
 */
#ifndef SVOCL_PLAN_H
#define SVOCL_PLAN_H

#include <stddef.h>
#include <stdint.h>

#include "svocl/device.h"
#include "svocl/mesh.h"
#include "svocl/part_types.h"
#include "svocl/submit.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SVO_DEPTH_MIN       1 /**< smallest depth */
#define SVO_DEPTH_MAX       16 /**< largest depth */
#define SVO_PARTS_DEPTH_MAX 20 /**< largest depth of a tree in parts, each of which has SVO_DEPTH_MAX levels at most */

/** A plan for one mesh on one device. */
typedef struct svo_plan svo_plan;

/** What a tree holds besides its occupancy. */
typedef enum svo_need {
    SVO_NEED_DEFAULT = 0, /**< normals, and the colors that the mesh has */
    /** RGBA8 per node: the mean of alpha, 255 only where all shows and 0 only where nothing does, and those of red,
     *  green and blue, which alpha weighs; black where nothing shows. White if the mesh has neither colors nor
     *  materials. */
    SVO_NEED_COLOR = 1,
    SVO_NEED_NORMAL = 2, /**< 3 x int16 per node; the triangles' own normals if the mesh has none */
    SVO_NEED_RAYS = 4, /**< leaf lists, vertices as given and rounded, and indices, from which trace.h makes a BVH */
    SVO_NEED_MATERIAL = 8, /**< 16 bits per node: the material with the largest weight; the smaller index on ties */
    SVO_NEED_FILL = 16, /**< 16 bits per node: surface area inside, 4096 = a face of the node, at most 65535 */
    /** 6 x 16 bits per leaf, none for inner nodes: how much surface rays along +x, -x, +y, -y, +z and -z see in the
     *  voxel. For +x it is the sum, over the triangles with n_x < 0, of the area inside times |n_x|; n is the unit
     *  normal by the right-hand rule. 4096 = a face of the voxel, at most 65535. Surfaces that hide each other all
     *  count. With closed voxels, surface in a common face counts in both; with thin ones, surface may lie in no leaf.
     *
     *  Triangles of an open mesh count from both sides. A mesh is closed if each edge is used as often in one direction
     *  as in the other by its accepted triangles, those outside the grid included. Vertices with equal coordinates are
     *  one, so that split vertices do not open a mesh; a crack of an ulp does. */
    SVO_NEED_PROJECTED_AREA = 32,
    SVO_NEED_NONE = 0x40000000 /**< occupancy alone */
} svo_need;

#define SVO_NEED_ALL 0x3f /**< everything */

/** Which voxels a triangle occupies. The triangle is closed; a voxel is w grid units wide. */
typedef enum svo_coverage {
    SVO_COVERAGE_HALF_OPEN = 0, /**< voxels [x, x + 1)^3: each surface point lies in one voxel. 6-separating */
    SVO_COVERAGE_CLOSED = 1, /**< voxels [x, x + 1]^3: a superset. 26-separating */
    /** 6-separating and never more than half-open: the separating axis test with a reach of w / 2 * max |n_i| around
     *  the voxel's center on each axis n. Laine, "A Topological Approach to Voxelization", 2013. Inner nodes are the
     *  ancestors of the leaves. */
    SVO_COVERAGE_THIN = 2
} svo_coverage;

/** The weight of a (voxel, triangle) pair in the means of its voxel and of all nodes above, and the point of the
 *  triangle at which attributes are sampled. Computed in integers, with the same result everywhere. */
typedef enum svo_weights {
    /** The area of the triangle inside the voxel; sampled at that part's centroid. A pair without area (a segment, a
     *  point, a touch) has a weight of one unit: 2^-31 of the heaviest pair, or somewhat more in large scenes. */
    SVO_WEIGHTS_AREA = 0,
    SVO_WEIGHTS_UNIFORM = 1, /**< 1; sampled at the triangle's centroid, whatever the voxel. The fastest */
    /** 1; sampled at the projection of the voxel's center onto the triangle along the triangle's dominant axis, clamped
     *  to the triangle. */
    SVO_WEIGHTS_CENTER = 2
} svo_weights;

/** How nodes are made from the fragment list. The tree is the same, bit for bit. */
typedef enum svo_builder {
    SVO_BUILDER_CL = 0, /**< "cl": top-down, level by level; the list stays in chunks and in any order */
    /** "sorted": bottom-up from the list sorted by Morton code. Needs the list in one buffer, and that much again to
     *  sort it. */
    SVO_BUILDER_SORTED = 1
} svo_builder;

/** Where svo_plan_create works. The plan is the same, bit for bit. */
typedef enum svo_place {
    /** The host for fewer than 4,096 triangles, and on a device handle whose plans had fewer than 524,288 in all;
     *  later the device, so that small meshes do not pay for the kernels. Always the host on handles with a budget
     *  (max_device_bytes) and on devices without doubles or denormals. */
    SVO_PLACE_DEFAULT = 0,
    SVO_PLACE_HOST = 1, /**< "host": one thread; builds upload what they read */
    /** "device": kernels. The mesh and the payload inputs stay on the device, in memory of the plan's own,
     *  28 bytes per triangle and 12 per vertex besides attributes and what rays meet; builds copy what they read. */
    SVO_PLACE_DEVICE = 2
} svo_place;

/** The stages of plans and builds. Later versions may append some. */
typedef enum svo_stage {
    SVO_STAGE_GRID = 0, /**< "grid": validate, round, classify (svo_plan_create) */
    SVO_STAGE_COMPILE, /**< "compile": kernels and shaders, as far as this build compiled any */
    SVO_STAGE_VOXELIZE, /**< "voxelize": triangles -> fragment list */
    SVO_STAGE_TRANSFER, /**< "transfer": list from OpenGL to OpenCL, host data to the device, counts back */
    SVO_STAGE_SUBDIVIDE, /**< "subdivide": nodes of all levels */
    SVO_STAGE_PACK, /**< "pack": sorted leaf lists */
    SVO_STAGE_LINK, /**< "link": linked leaf lists for the filter */
    SVO_STAGE_FILTER, /**< "filter": payload of the leaves, then of each level above */
    SVO_STAGE_DROP, /**< "drop": pairs with too little alpha leave the list (svo_plan_options.drop_alpha) */
    SVO_STAGE_COUNT /**< number of stages that the headers know */
} svo_stage;

/** Receives the progress of a call that may take long, and may stop it.
 *
 * It is called on the thread that called the library, between pieces of work: at the beginning with 0, at the end of a
 * call that succeeds with 1, and in between about as often as a launch or a part of a large one has ended. It must not
 * use the device handle or anything made from it.
 *
 * \param user progress_user of the plan's options
 * \param stage what was being done
 * \param fraction 0 .. 1 of the whole call, by predicted times; never less than in the call before
 * \returns 0 to go on. Else the call that reports ends with SVO_CANCELED as after any failure: it waits for the
 *          commands that it has enqueued, which takes a fraction of a second, and releases everything. */
typedef int (*svo_progress_callback)(void *user, svo_stage stage, double fraction);

/** Options of a plan. */
typedef struct svo_plan_options {
    size_t struct_size; /**< sizeof(svo_plan_options) */
    uint32_t need; /**< svo_need bits */
    svo_coverage coverage; /**< which voxels are occupied */
    svo_weights weights; /**< of the payload; SVO_NEED_FILL requires SVO_WEIGHTS_AREA */
    svo_builder builder; /**< how nodes are made */
    /** The first level with payload, 0 .. depth: 0 for all levels, depth for the leaves alone. */
    uint32_t payload_level;
    /** Minimum corner of the caller's grid [origin, origin + edge)^3; finite. Unused when edge is 0. */
    double origin[3];
    /** Width of the caller's grid, finite and above 0; or 0 for a grid fitted to the accepted triangles, see nodes.h.
     *  Triangles outside occupy nothing. Vertices must lie less than 2^29 grid units away: 512 edges, 32 at depth
     *  16, 2 at depth 20. */
    double edge;
    /** Fragments the list has room for at first, at most 2^32 - 65537; 0: by the fragment estimate. svo_build grows it
     *  when it is too small. */
    uint64_t fragment_capacity;
    /** Not 0: room for as many inner nodes as the fragments could require, instead of the fragment estimate plus an
     *  eighth. */
    uint32_t worst_case_nodes;
    /** Upper limit in bytes for a chunk of the list, at least 16384; 0: the limit of device and front end. */
    uint64_t chunk_bytes;
    /** Called by svo_plan_create and, for this plan, by svo_plan_count, svo_build, svo_gl_build, svo_workspace_create
     *  and svo_device_warm; NULL: nothing is called. Builds that report wait for their launches as they go, and divide
     *  large ones. Enqueued builds wait for nothing and report nothing. */
    svo_progress_callback progress;
    void *progress_user; /**< passed to progress */
    /** Where the plan is made. SVO_PLACE_DEVICE fails with SVO_UNSUPPORTED on devices without doubles or denormals. */
    svo_place place;
    /** Not NULL: builds a part of a larger tree (parts.h): what lies under the node of level part_level and Morton code
     *  part_code. The result is a tree of depth - part_level levels below that node, for svo_part_save. need, coverage,
     *  weights, payload_level, origin and edge are the header's. The plan is made on the host. */
    const svo_part_header *part_header;
    /** triangle_count: each triangle's position among the kept triangles of the whole mesh, ascending, for leaf lists;
     *  then the mesh needs only the triangles that meet the part. NULL: the mesh is the whole mesh. */
    const uint32_t *part_triangles;
    uint64_t part_code; /**< below 8^part_level; unused without part_header */
    uint32_t part_level; /**< 0 .. depth - 1; 0 is the whole tree. Unused without part_header */
    /** Of an updatable plan: the largest area that the mesh will have inside the grid, square world units; finite. It
     *  decides the unit of weight, which stays, so that payload does not depend on how the mesh lies at first. 0: four
     *  times the area of the mesh that is given. */
    double max_area;
    /** Not 0: the mesh may move, see svo_plan_update. Requires edge, a mesh with vertices and triangles, and a
     *  device with doubles and denormals, since kernels make the plan: SVO_PLACE_DEVICE. All kernels that some motion
     *  may need are compiled, all payload is made per node, and the list has the room of this mesh, a margin included,
     *  unless fragment_capacity says otherwise. Takes 55 bytes per triangle and up to 38 per vertex besides what
     *  SVO_PLACE_DEVICE names. */
    uint32_t updatable;
    /** The weight of a voxel's face, as a power of two from 13 on (svo_plan_info.weight_log2); 0: the largest without
     *  overflow. So that trees of different plans can be equal. At most what the mesh's area allows, and 30 in
     *  updatable plans, where it takes the place of max_area. */
    uint32_t weight_log2;
    /** Above 0, at most 1: pairs of a voxel and a triangle with an alpha below it are left out, so that a voxel of no
     *  other pairs is empty. A pair's alpha is that of its color, be colors needed or not: of material, vertex colors
     *  and texture, multiplied, where weights says that the triangle is sampled, in 255ths. Payload and leaf lists are
     *  of the pairs that remain. Without any the tree is a root without leaves. Rays that meet triangles meet them
     *  whole. 0: no pair is left out. */
    double drop_alpha;
} svo_plan_options;

/** All defaults. */
#define SVO_PLAN_OPTIONS_INIT SVO_STRUCT_INIT(svo_plan_options)

/** What a plan found out. */
typedef struct svo_plan_info {
    size_t struct_size; /**< sizeof(svo_plan_info) */
    uint32_t depth; /**< the grid has 2^depth voxels per axis */
    uint32_t snap_bits; /**< the grid is 2^snap_bits units wide: 20 up to depth 12, depth + 8 above */
    uint32_t coverage; /**< svo_coverage */
    uint32_t need; /**< svo_need bits, resolved: 0 means occupancy alone */
    uint32_t constant; /**< of those, payload that is the same in every node and stored once */
    uint64_t triangles; /**< of the mesh */
    uint64_t refused_triangles; /**< index out of range, not finite, or 2^29 units and more from the grid */
    uint64_t outside_triangles; /**< accepted, but with bounds that miss the caller's grid */
    double origin[3]; /**< minimum corner of the grid, world */
    double edge; /**< width of the grid, the caller's or fitted, world; see nodes.h */
    double scale; /**< grid units per world unit */
    double expected_fragments; /**< the fragment estimate, without slack */
    uint64_t fragments; /**< after svo_plan_count the capacity that suffices; 0 before */
    double grid_ms; /**< wall clock of validating, rounding and classifying, milliseconds; without compiling */
    uint32_t place; /**< svo_place: SVO_PLACE_HOST or SVO_PLACE_DEVICE */
    /** The areas of the three projections of the kept triangles, as far as inside the grid, divided by the square root
     *  of 3; square world units. At most their area. */
    double area;
    uint32_t weight_log2; /**< the weight of a voxel's face, as a power of two; 0 without payload */
    uint32_t updatable; /**< not 0: see svo_plan_update */
    /** The depth that suits rays against the mesh's triangles, whatever the plan's own depth, 1 .. 12: the largest at
     *  which the fragment estimate expects a triangle in at most 6 leaves, so that voxels are about as large as
     *  triangles and lists stay short. Neither the hits nor the speed of rays depend on the depth. */
    uint32_t ray_depth;
    uint32_t buffer_count; /**< the entries of svo_plan_get_buffer */
    uint64_t peak_bytes; /**< the most device memory that a build allocates at one time */
    uint64_t tree_bytes; /**< the device memory of the finished tree */
    uint32_t kernels_count; /**< the entries of svo_plan_get_kernels */
    uint32_t left_out_count; /**< the entries of svo_plan_get_left_out */
    /** Not 0: builds look for pairs with an alpha below options.drop_alpha. 0: there are none, or it is 0. */
    uint32_t drops_pairs;
} svo_plan_info;

/** An empty output. */
#define SVO_PLAN_INFO_INIT SVO_STRUCT_INIT(svo_plan_info)

/** How certain the bytes of a buffer are before a build. */
typedef enum svo_certainty {
    SVO_BYTES_EXACT = 0, /**< exactly these */
    SVO_BYTES_BOUND = 1, /**< at most these */
    SVO_BYTES_ESTIMATE = 2 /**< the fragment estimate plus an eighth: rarely more, usually less */
} svo_certainty;

/** A buffer that a build allocates. */
typedef struct svo_buffer_info {
    size_t struct_size; /**< sizeof(svo_buffer_info) */
    const char *name; /**< static string */
    uint64_t bytes; /**< of all its cl_mems */
    uint64_t count; /**< cl_mems it is split into */
    svo_certainty certainty; /**< SVO_BYTES_EXACT after a build */
    int persistent; /**< not 0: part of the tree; 0: scratch that is released before the build ends */
} svo_buffer_info;

/** An empty output. */
#define SVO_BUFFER_INFO_INIT SVO_STRUCT_INIT(svo_buffer_info)

/** A program of kernels that a build compiles, unless the device handle has it already. */
typedef struct svo_kernels_info {
    size_t struct_size; /**< sizeof(svo_kernels_info) */
    const char *name; /**< "subdivide", "sort", "pack", "filter", "voxelize", "drop"; static string */
    const char *defines; /**< " -DSVO_COLOR -DSVO_WEIGHTS_AREA", ...; lives as long as the plan */
} svo_kernels_info;

/** An empty output. */
#define SVO_KERNELS_INFO_INIT SVO_STRUCT_INIT(svo_kernels_info)

/** Something that a build does without. */
typedef struct svo_left_out {
    size_t struct_size; /**< sizeof(svo_left_out) */
    const char *what; /**< "leaf lists", "color per node", ...; static string */
    const char *reason; /**< one line; lives as long as the plan */
} svo_left_out;

/** An empty output. */
#define SVO_LEFT_OUT_INIT SVO_STRUCT_INIT(svo_left_out)

/** The grid whose voxels have a given width, for svo_plan_options: its planes are at whole multiples of the width, it
 *  begins at or below the mesh's least corner, and it has the least depth that holds the mesh. A vertex on a plane lies
 *  in the voxel above it, so that a cube of 4 voxels whose corners are on planes takes 5 of them.
 *
 * \param mesh its valid triangles are looked at, on the host
 * \param voxel_edge width of a voxel, world units, finite and above 0
 * \param origin receives svo_plan_options.origin; all 0 without triangles
 * \param edge receives svo_plan_options.edge: voxel_edge times 2^depth, exactly
 * \param depth receives the depth, SVO_DEPTH_MIN .. SVO_DEPTH_MAX
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_INVALID_ARGUMENT (NULL, no positions, a width that is none; more than 2^SVO_DEPTH_MAX voxels along an
 *          axis, which the message counts). */
SVO_API svo_status svo_mesh_voxel_grid(const svo_mesh *mesh, double voxel_edge, double origin[3], double *edge,
                                       unsigned *depth, svo_message *message);

/** Makes a plan. The mesh's arrays are not needed afterwards.
 *
 * \param device must outlive the plan
 * \param mesh what to voxelize
 * \param depth SVO_DEPTH_MIN .. SVO_DEPTH_MAX; of a part: that of the whole tree, SVO_PARTS_DEPTH_MAX at most
 * \param options NULL means all defaults
 * \param out receives the plan
 * \returns SVO_INVALID_ARGUMENT (depth, options, missing arrays, a grid that cannot be scaled),
 *          SVO_OUT_OF_DEVICE_MEMORY (2^32 texels or more), SVO_CANCELED or SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_plan_create(svo_device *device, const svo_mesh *mesh, unsigned depth,
                                   const svo_plan_options *options, svo_plan **out);

/** What parts of the plan's tree need to know of the whole; see svo_plan_options.part_header.
 *
 * \param plan of the whole mesh, not of a part
 * \param header receives the values
 * \returns SVO_INVALID_ARGUMENT (a plan of a part, a struct_size that is too small), SVO_CAPACITY_EXCEEDED (payload of
 *          a surface of 2^34 faces of voxels or more, whose sums exceed 64 bits). */
SVO_API svo_status svo_plan_get_part_header(const svo_plan *plan, svo_part_header *header);

/** Makes a plan from a mesh in OpenCL buffers, by kernels: SVO_PLACE_DEVICE.
 *
 * The mesh does not cross to the host. Of the whole plan the host reads totals (some hundred bytes, and a byte per
 * material), the triangles of more than 64 columns of voxels, 48 bytes each, for the front end "cl", and, where the
 * fragment list takes several chunks, 4 bytes per triangle. A front end or a builder of OpenGL reads the rounded mesh,
 * since it draws from OpenGL's memory. The buffers are not needed afterwards. OpenGL buffers can be given as the
 * cl_mems that clCreateFromGLBuffer makes of them, acquired; svo_gl_mesh_read reads those of other drivers to the host.
 *
 * \param device must outlive the plan
 * \param buffers where the arrays are; gl_buffer and memory of it are unused
 * \param depth SVO_DEPTH_MIN .. SVO_DEPTH_MAX
 * \param options NULL means all defaults; place: SVO_PLACE_DEFAULT or SVO_PLACE_DEVICE
 * \param queue of the device, in-order or out-of-order; NULL: the device's own
 * \param num_wait number of events in wait
 * \param wait events to wait for first; NULL when num_wait is 0
 * \param out receives the plan; the call waits for it
 * \returns SVO_UNSUPPORTED (the device has no doubles or denormals; read the mesh with svo_mesh_read), and as
 *          svo_mesh_read and svo_plan_create: SVO_INVALID_ARGUMENT, SVO_CL_ERROR, SVO_COMPILE_FAILED, SVO_CANCELED,
 *          SVO_OUT_OF_DEVICE_MEMORY, SVO_OUT_OF_HOST_MEMORY. */
SVO_API svo_status svo_plan_create_from_buffers(svo_device *device, const svo_mesh_buffers *buffers, unsigned depth,
                                                const svo_plan_options *options, cl_command_queue queue,
                                                cl_uint num_wait, const cl_event *wait, svo_plan **out);

/** Replaces the vertices of an updatable plan by others, without allocating device memory or compiling. Builds that
 * are enqueued later (svo_build_enqueue) wait for the update, and the update for those enqueued before, whatever the
 * queues.
 *
 * The topology stays: indices, materials, vertex colors and texture coordinates are those that the plan was made from.
 * A triangle may become degenerate, leave the grid and come back. The tree equals, byte for byte, that of a new
 * updatable plan for this mesh with the same weight_log2. With SVO_NEED_PROJECTED_AREA, whether the mesh is closed is
 * found once, when the plan is made.
 *
 * Capacities stay too. What does not fit shows in svo_tree_finish or svo_build: SVO_CAPACITY_EXCEEDED. After a failure
 * of this call the plan has no mesh until another update succeeds.
 *
 * \param plan with options.updatable
 * \param mesh positions, in floats or doubles as at first, and normals where the plan reads them; vertex_count and
 *        triangle_count are the plan's. Other arrays are not read. The arrays must stay as they are until the update
 *        is done, and with submit the call does not wait for that
 * \param submit NULL: the device's own queue, and the call waits
 * \returns SVO_INVALID_ARGUMENT (not updatable, other counts, a missing array), SVO_CL_ERROR or SVO_OUT_OF_HOST_MEMORY
 *          on failure. */
SVO_API svo_status svo_plan_update(svo_plan *plan, const svo_mesh *mesh, const svo_submit *submit);

/** svo_plan_update for vertices in OpenCL buffers. gl.h has svo_gl_plan_update for those of OpenGL.
 *
 * \param plan with options.updatable, of floats
 * \param buffers views of positions, and of normals where the plan reads them, with the plan's vertex_count and
 *        triangle_count. Other views are not read. The buffers must stay as they are until the update is done
 * \param submit NULL: the device's own queue, and the call waits
 * \returns what svo_plan_update returns. */
SVO_API svo_status svo_plan_update_from_buffers(svo_plan *plan, const svo_mesh_buffers *buffers,
                                                const svo_submit *submit);

/** Destroys a plan. Updates in flight are waited for.
 *
 * \param plan set to NULL; NULL and a pointer to NULL are allowed */
SVO_API void svo_plan_destroy(svo_plan **plan);

/** Replaces the callback that was given in the plan's options.
 *
 * \param plan not NULL
 * \param progress NULL: nothing is called
 * \param user passed to progress */
SVO_API void svo_plan_set_progress(svo_plan *plan, svo_progress_callback progress, void *user);

/** Describes a plan. Figures of the mesh that an updatable plan's updates change are those of the newest that
 *  svo_tree_finish or svo_build has waited for.
 *
 * \param plan not NULL
 * \param info receives the description
 * \returns SVO_INVALID_ARGUMENT when info is NULL or its struct_size is too small. */
SVO_API svo_status svo_plan_get_info(const svo_plan *plan, svo_plan_info *info);

/** An OpenCL buffer that a build allocates, in order of allocation.
 *
 * Before a build the list is predicted, with the front end of OpenCL alone. After a build it is exact, attempts that
 * were too small included. svo_workspace_create makes it the list of a workspace and a tree. The rounded mesh is
 * there once: vertices and indices, or mesh_vertices and mesh_indices where the voxelizer alone reads them. Arrays
 * that a plan with SVO_PLACE_DEVICE has already are read there, and are not listed unless the tree keeps them. With a
 * front end of OpenGL, mesh_vertices, mesh_indices, mesh_items, mesh_tiles and counters are missing, since they are
 * in OpenGL's memory, as is OpenGL's side of the list with share "copy". Small buffers that kernels are tried on when
 * they are compiled, before the build allocates, are not listed. Buffers that are released together may be parts of
 * one allocation, and have their bytes rounded up for that.
 *
 * \param plan not NULL
 * \param index below svo_plan_info.buffer_count
 * \param info receives the entry
 * \returns SVO_INVALID_ARGUMENT when index is too large, info is NULL or its struct_size is too small. */
SVO_API svo_status svo_plan_get_buffer(const svo_plan *plan, size_t index, svo_buffer_info *info);

/** A program that a build with the front end of OpenCL alone compiles.
 *
 * \param plan not NULL
 * \param index below svo_plan_info.kernels_count
 * \param info receives the entry
 * \returns SVO_INVALID_ARGUMENT when index is too large, info is NULL or its struct_size is too small. */
SVO_API svo_status svo_plan_get_kernels(const svo_plan *plan, size_t index, svo_kernels_info *info);

/** A stage, buffer or kernel variant that this mesh and this request do not use. The result is the same, bit for bit,
 *  as if nothing were left out.
 *
 * \param plan not NULL
 * \param index below svo_plan_info.left_out_count
 * \param entry receives the entry
 * \returns SVO_INVALID_ARGUMENT when index is too large, entry is NULL or its struct_size is too small. */
SVO_API svo_status svo_plan_get_left_out(const svo_plan *plan, size_t index, svo_left_out *entry);

#ifdef __cplusplus
}
#endif

#endif
