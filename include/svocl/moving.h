/* SPDX-License-Identifier: MIT */
/** \file
 * Scenes that move: one tree of a static mesh and of objects that move through it.
 *
 * An update voxelizes the objects that changed, and no others. The (voxel, triangle) pairs of everything else are kept
 * in Morton order with what they contribute to the payload. Those of the changed objects are merged in, and the nodes
 * and the payload follow from the merged list by sums of integers. So the tree is, byte for byte, the one that
 * svo_build makes of the scene's mesh (svo_moving_get_mesh), with the same need, coverage, weights, payload_level,
 * origin and edge, and with the weight_log2 that svo_moving_get_info names.
 *
 * The scene's mesh is the static mesh followed by the visible objects in the order of their numbers. What leaves the
 * grid occupies nothing and is counted.
 *
 * Objects that move rigidly, and need no common tree, are better off as instances of a scene (scene.h): a matrix moves
 * them, nothing is voxelized, and rays meet them where they are.
 *
 * Thread-safety: a handle needs exclusive use, of it and of its device handle.
 */
#ifndef SVOCL_MOVING_H
#define SVOCL_MOVING_H

#include <stddef.h>
#include <stdint.h>

#include "svocl/nodes.h"
#include "svocl/plan.h"
#include "svocl/trace.h"
#include "svocl/tree.h"

#ifdef __cplusplus
extern "C" {
#endif

/** The most objects of a scene, numbered from 0. */
#define SVO_MOVING_OBJECTS_MAX 65535

/** A transform is flat when the absolute value of its determinant is at most this times the product of the lengths of
 *  its columns. */
#define SVO_MOVING_DETERMINANT_MIN 1e-12

/** A scene that moves. */
typedef struct svo_moving svo_moving;

/** What a scene is, for good. */
typedef struct svo_moving_options {
    size_t struct_size; /**< sizeof(svo_moving_options) */
    /** svo_need bits; SVO_NEED_DEFAULT goes by the static mesh. With SVO_NEED_PROJECTED_AREA each update finds whether
     *  the scene's mesh is closed, which may take several objects; that can change the areas of all leaves. */
    uint32_t need;
    svo_coverage coverage; /**< which voxels are occupied */
    svo_weights weights; /**< of the payload */
    uint32_t payload_level; /**< the first level with payload, 0 .. depth */
    double origin[3]; /**< minimum corner of the grid; finite */
    double edge; /**< width of the grid; finite and above 0 */
    /** The largest area that the scene will have inside the grid, square world units. It decides the unit of weight,
     *  which stays. 0: four times the area of the static mesh. */
    double max_area;
    /** Most (voxel, triangle) pairs of the scene; 0: as many as memory holds, at most 2^32 - 65537. */
    uint64_t fragment_capacity;
    uint32_t weight_log2; /**< see svo_plan_options; takes the place of max_area */
    double drop_alpha; /**< see svo_plan_options: pairs with an alpha below it are left out; 0: none are */
} svo_moving_options;

/** All defaults; edge is missing. */
#define SVO_MOVING_OPTIONS_INIT SVO_STRUCT_INIT(svo_moving_options)

/** What an update did. */
typedef struct svo_moving_report {
    size_t struct_size; /**< sizeof(svo_moving_report) */
    uint64_t changed_objects; /**< voxelized, hidden or removed */
    uint64_t changed_fragments; /**< pairs that went and pairs that came */
    uint64_t fragments; /**< pairs of the scene */
    double move_ms; /**< the objects' vertices: to the device, rounded, classified */
    double voxelize_ms; /**< their pairs, in Morton order */
    double weigh_ms; /**< what their pairs contribute: clipping, colors, normals */
    double merge_ms; /**< the lists merged */
    double nodes_ms; /**< nodes, leaf lists and their triangles */
    double payload_ms; /**< the payload */
    double total_ms; /**< all of it. Milliseconds, wall clock; stages are told apart by waiting after each */
} svo_moving_report;

/** An empty output. */
#define SVO_MOVING_REPORT_INIT SVO_STRUCT_INIT(svo_moving_report)

/** A scene after its newest update. */
typedef struct svo_moving_info {
    size_t struct_size; /**< sizeof(svo_moving_info) */
    uint32_t need; /**< svo_need bits, resolved */
    uint32_t weight_log2; /**< see svo_plan_options */
    uint32_t object_count; /**< objects that exist, now */
    uint32_t reserved; /**< zero */
    uint64_t fragments; /**< (voxel, triangle) pairs */
    uint64_t list_bytes; /**< device memory of the lists, what merging needs included */
    double area; /**< inside the grid, as svo_plan_info.area */
} svo_moving_info;

/** An empty output. */
#define SVO_MOVING_INFO_INIT SVO_STRUCT_INIT(svo_moving_info)

/** An object after the newest update. */
typedef struct svo_moving_object {
    size_t struct_size; /**< sizeof(svo_moving_object) */
    uint64_t triangles; /**< of its mesh */
    uint64_t refused_triangles; /**< as in svo_plan_info */
    uint64_t outside_triangles; /**< whose bounds miss the grid */
    uint64_t fragments; /**< (voxel, triangle) pairs; 0 while it is hidden */
    uint32_t first_triangle; /**< where its triangles begin in the scene's mesh; unused while it is hidden */
    uint32_t visible; /**< not 0: it is part of the scene */
} svo_moving_object;

/** An empty output. */
#define SVO_MOVING_OBJECT_INIT SVO_STRUCT_INIT(svo_moving_object)

/** Makes a scene of a static mesh alone, and its tree.
 *
 * \param device with doubles and denormals; must outlive the scene
 * \param mesh the static mesh, with vertices and triangles; it may lie outside the grid. Objects have the arrays of
 *        vertices that it has: normals, colors and texture coordinates, or none. Its materials and textures are those
 *        of all objects and must stay as long as the scene; the other arrays are copied
 * \param depth SVO_DEPTH_MIN .. SVO_DEPTH_MAX
 * \param options not NULL, since edge is required
 * \param queue of the device, in-order or out-of-order; NULL: the device's own
 * \param out receives the scene
 * \returns SVO_INVALID_ARGUMENT, SVO_UNSUPPORTED (no doubles), SVO_CAPACITY_EXCEEDED or what svo_build returns. */
SVO_API svo_status svo_moving_create(svo_device *device, const svo_mesh *mesh, unsigned depth,
                                     const svo_moving_options *options, cl_command_queue queue, svo_moving **out);

/** Destroys a scene and its tree.
 *
 * \param moving set to NULL; NULL and a pointer to NULL are allowed */
SVO_API void svo_moving_destroy(svo_moving **moving);

/** Adds an object, which is visible. The tree changes with the next update.
 *
 * \param moving not NULL
 * \param mesh with vertices and triangles and the vertices' arrays of the static mesh; all are copied but materials and
 *        textures, which are not read
 * \param transform rows of a 3 x 4 matrix from the mesh to the world, 12 numbers; NULL: none, the mesh is in the world
 * \param object receives the object's number: the least that is free
 * \returns SVO_INVALID_ARGUMENT (also for a transform that is not finite or flat, or a mesh with other arrays) or what
 *          svo_plan_create returns. The scene is unchanged then. */
SVO_API svo_status svo_moving_add(svo_moving *moving, const svo_mesh *mesh, const double transform[12],
                                  uint32_t *object);

/** Moves an object. Its vertices in the world are ((m0 x + m1 y) + m2 z) + m3 in double, for each row, then rounded to
 *  floats if the mesh has floats. Normals are turned by the matrix of cofactors and keep any length.
 *
 * \param moving not NULL
 * \param object its number
 * \param transform see svo_moving_add
 * \returns SVO_INVALID_ARGUMENT, naming the object, for a transform that is not finite or flat; nothing moves then. */
SVO_API svo_status svo_moving_set_transform(svo_moving *moving, uint32_t object, const double transform[12]);

/** Replaces an object's vertices, to which its transform applies.
 *
 * \param moving not NULL
 * \param object its number
 * \param mesh positions and normals as in the object's mesh, and its counts; other arrays are not read
 * \returns SVO_INVALID_ARGUMENT (other counts, a missing array). */
SVO_API svo_status svo_moving_set_vertices(svo_moving *moving, uint32_t object, const svo_mesh *mesh);

/** Shows or hides an object.
 *
 * \param moving not NULL
 * \param object its number
 * \param visible not 0: it is part of the scene
 * \returns SVO_INVALID_ARGUMENT. */
SVO_API svo_status svo_moving_show(svo_moving *moving, uint32_t object, int visible);

/** Removes an object and releases its memory; an object that is added later may get its number.
 *
 * \param moving not NULL
 * \param object its number
 * \returns SVO_INVALID_ARGUMENT. */
SVO_API svo_status svo_moving_remove(svo_moving *moving, uint32_t object);

/** Makes the tree of the scene as it is now. After a failure the tree before stays what it was, and another update may
 *  succeed, for example after objects have moved back.
 *
 * With submit and without report it does not wait for the device:
 *
 *     svo_moving_set_transform   what moves, each frame
 *     svo_moving_update          waits for nothing; the tree stays the one before
 *     svo_moving_finish          waits for the update; now the tree is that of a full build, byte for byte
 *
 * Until svo_moving_finish, calls that change the scene are refused, and those that read it tell of the tree before,
 * which may be used meanwhile. An object that is made anew has room for an eighth more pairs than it ever had, before
 * its first update for those that the fragment estimate expects. Where that is too little, svo_moving_finish says so.
 * Device memory is allocated for all of the room at once; OpenCL releases what is scratch when its commands are done.
 *
 * \param moving not NULL, without an update in flight
 * \param submit NULL: the device's own queue, and the call waits
 * \param report not NULL: the call waits, for the events of submit too, and receives what was done; it waits between
 *        the stages, to take their times
 * \returns SVO_CAPACITY_EXCEEDED (more pairs than fragment_capacity, more area than max_area; the message has the
 *          figures; with submit: room for more than 2^32 - 65537 pairs), SVO_INVALID_ARGUMENT, SVO_UNSUPPORTED (with
 *          submit: the pairs of an object do not fit one buffer of the device), SVO_OUT_OF_DEVICE_MEMORY,
 *          SVO_OUT_OF_HOST_MEMORY, SVO_COMPILE_FAILED or SVO_CL_ERROR. After a failure, which waits for what was
 *          enqueued until then, no update is in flight. */
SVO_API svo_status svo_moving_update(svo_moving *moving, const svo_submit *submit, svo_moving_report *report);

/** Waits for the update in flight and takes its tree.
 *
 * \param moving not NULL, with an update in flight
 * \param report receives what was done, without the times of stages; total_ms is the time since the update was
 *        enqueued. NULL: not wanted
 * \returns SVO_CAPACITY_EXCEEDED (an object has more pairs than the update had room for: the message has the figures,
 *          and the next update has room; or as svo_moving_update), SVO_INVALID_ARGUMENT (no update is in flight),
 *          SVO_OUT_OF_DEVICE_MEMORY or SVO_CL_ERROR. After a failure the tree before stays what it was, and no update
 *          is in flight. */
SVO_API svo_status svo_moving_finish(svo_moving *moving, svo_moving_report *report);

/** What became of the objects' BVHs. The static mesh counts as an object. */
typedef struct svo_moving_bvh_report {
    size_t struct_size; /**< sizeof(svo_moving_bvh_report) */
    uint32_t kept; /**< objects that had not changed */
    uint32_t refit; /**< objects that moved or got new vertices */
    uint32_t made; /**< objects that had no BVH, or whose BVH was made anew */
    uint32_t reserved; /**< zero */
    double total_ms; /**< all of it. Milliseconds, wall clock */
} svo_moving_bvh_report;

/** An empty output. */
#define SVO_MOVING_BVH_REPORT_INIT SVO_STRUCT_INIT(svo_moving_bvh_report)

/** Makes the BVH of the newest tree from those of its objects, and waits for it. Call it after an update; then all that
 *  trace.h offers works on svo_moving_tree, with the hits of a BVH of the whole mesh, bit for bit, but for the counts
 *  of leaves visited and the record of SVO_TRACE_ANY. Without this call the first rays make a BVH of the whole mesh.
 *
 *  Each object has a BVH of its own below common nodes. The static mesh's is made once, with SVO_BVH_BEST. An object's
 *  is kept while the object stays, refit when it moves or gets new vertices, and made anew when rays through it have
 *  become too costly, when it reaches or reached outside the grid, and when its triangles inside the grid are others.
 *  A transform is followed by a refit too: rays meet vertices as they are in the scene's mesh, rounded to its floats,
 *  where a ray that is transformed into the object would be rounded itself and meet others.
 *
 *  Objects' BVHs lie in common buffers, and those that are refit are refit in one set of launches. A BVH that can be
 *  refit takes about 50 bytes per triangle, beside the 51 to 55 of its nodes and leaves; there is room for two thirds
 *  more of both. Objects' BVHs stay while they are hidden.
 *
 * \param moving with SVO_NEED_RAYS, coverage half-open or closed. No batch of rays of its trees may be in progress
 * \param quality of objects' BVHs that are made, a svo_bvh_quality
 * \param cost_ratio a refit BVH is made anew when a random ray through the object visits so many times the nodes and
 *        leaves that it visited when the BVH was made; not negative. 0: 1.5. Below 1: every object that has changed is
 *        made anew
 * \param queue of the device, in-order or out-of-order; NULL: the device's own
 * \param report receives what was done; NULL: not wanted
 * \returns SVO_INVALID_ARGUMENT or what svo_tree_make_bvh returns. After a failure rays make a BVH of the whole
 *          mesh, and another call makes all objects' anew. */
SVO_API svo_status svo_moving_make_bvh(svo_moving *moving, svo_bvh_quality quality, float cost_ratio,
                                       cl_command_queue queue, svo_moving_bvh_report *report);

/** The tree of the newest update that succeeded.
 *
 * \param moving not NULL
 * \returns the tree, owned by the scene; the next update that succeeds destroys it. */
SVO_API svo_tree *svo_moving_tree(const svo_moving *moving);

/** Where the newest update that succeeded changed the tree: the bounds of each object that changed, before it and after
 *  it, where it was and is in the scene. An update that found nothing to do has none. svo_light_update takes them.
 *  Where the scene's mesh opens or closes, the projected areas of all leaves change: a box is the grid then.
 *
 * \param moving not NULL
 * \param boxes receives the first boxes, at most capacity; NULL allowed when that is 0
 * \param capacity boxes that there is room for; two for each object and one more suffice
 * \param count receives how many there are
 * \returns SVO_INVALID_ARGUMENT when count is NULL, or boxes where capacity is not 0. */
SVO_API svo_status svo_moving_get_changes(const svo_moving *moving, svo_box *boxes, size_t capacity, size_t *count);

/** The scene's mesh, as it will be after the next update: the static mesh, then the visible objects, in the world.
 *
 * \param moving not NULL
 * \param mesh receives the mesh; its arrays live until the scene is changed or destroyed
 * \returns SVO_INVALID_ARGUMENT or SVO_OUT_OF_HOST_MEMORY. */
SVO_API svo_status svo_moving_get_mesh(svo_moving *moving, svo_mesh *mesh);

/** Describes a scene.
 *
 * \param moving not NULL
 * \param info receives the description
 * \returns SVO_INVALID_ARGUMENT when info is NULL or its struct_size is too small. */
SVO_API svo_status svo_moving_get_info(const svo_moving *moving, svo_moving_info *info);

/** Describes an object.
 *
 * \param moving not NULL
 * \param object its number
 * \param info receives the description
 * \returns SVO_INVALID_ARGUMENT when there is no such object, info is NULL or its struct_size is too small. */
SVO_API svo_status svo_moving_get_object(const svo_moving *moving, uint32_t object, svo_moving_object *info);

#ifdef __cplusplus
}
#endif

#endif
