/* SPDX-License-Identifier: MIT */
/*
 * A scene that moves: its objects, the list of their pairs, and the BVHs of the objects.
 *
 * The room, each file after those that it uses:
 *   handle        this: the fields
 *   objects       objects: their meshes, transforms and bounds
 *   pairs         pairs of an object, and lists of pairs merged; the chain of an update's commands
 *   tree          the tree of a list of pairs
 *   update        updates, which wait or do not
 *   bvh_buffers   the common buffers of the objects' BVHs
 *   bvh           the BVH of the scene from those of its objects
 *   moving        creation, destruction, and what is known of the scene
 */
#ifndef SVO_LIB_MOVING_HANDLE_H
#define SVO_LIB_MOVING_HANDLE_H

#include "plan/plan_data.h"
#include "rays/bvh_fit.h"
#include "shared/moving_layout.h"
#include "svocl/moving.h"

/* Kept pairs in the order of (code, object, triangle), as kernels/moving has them. */
typedef struct svo_i_kept_list {
    cl_mem fragments, values;
    cl_mem materials, areas; /* NULL where none are needed */
    cl_mem marks; /* of merged lists: whose pairs are where, see merge.cl; else NULL */
    cl_mem counted; /* where the device alone knows the count, which is at most this one; else NULL */
    uint64_t count;
    uint64_t capacity; /* that the buffers have room for; 0: there are none */
} svo_i_kept_list;

/* The arrays of a mesh, all owned. One of floats and doubles is there. */
typedef struct svo_i_vertices {
    float *floats;
    double *doubles;
    float *normals; /* NULL where the mesh has none */
} svo_i_vertices;

/* The triangles of an object in the newest tree, and which they are. */
typedef struct svo_i_moving_part {
    uint64_t first_vertex, vertex_count;
    uint32_t first_triangle, triangle_count; /* among those that the tree lists */
    uint32_t first_id; /* the position of the object's first triangle in the scene's mesh */
    bool is_there;
    uint64_t identity, version; /* as of the object when the tree was made */
} svo_i_moving_part;

typedef struct svo_i_moving_object {
    svo_plan *plan; /* of the object alone; NULL: the number is free */
    double transform[12];
    svo_i_vertices given, world; /* as the caller gave them, and where they are */
    svo_mesh mesh; /* with the vertices of world; its other arrays are owned too, but for materials and textures */
    bool visible;
    bool moved; /* the plan does not have the vertices of world yet */
    bool stale; /* pairs in the scene's list are not those of the plan, or there are none */
    bool listed; /* the scene's list has pairs of the object, or of the one before it with this number */
    uint64_t fragments; /* in the scene's list */
    uint64_t identity, version; /* serial numbers: of the object, and of its vertices in the newest tree */
    svo_i_moving_part part; /* of the object in the newest tree, or of the one before it with this number */
    svo_box box; /* of the vertices that the scene's list is of; low above high: there are none */
    svo_box changes[2]; /* of the newest update */
    uint32_t change_count;
} svo_i_moving_object;

/*
 * The BVH of a scene that moves: one for each object, in common buffers, below common nodes. So kernels traverse it as
 * that of any tree.
 */

/* Most levels of the common nodes: the root, and five below it, since 7 * 8^5 is above SVO_I_MOVING_OBJECTS. */
#define SVO_I_MOVING_TOP_LEVELS 6

/* The BVH of an object. */
typedef struct svo_i_object_bvh {
    svo_i_device_bvh bvh;
    uint64_t identity; /* of the object; 0: there is no BVH */
    uint64_t version; /* of its vertices, in the records */
    uint32_t first_id; /* of its triangles, in the records */
    bool is_placed; /* it has a place in the buffers */
    bool is_written; /* its records are there */
    uint32_t node_room, leaf_room, item_room; /* of its place: nodes, units of 16 bytes, and items of the shape */
    uint32_t item_begin; /* of its place */
    float made_cost; /* what rays cost when it was made, see cost_of in bvh.c */
    svo_bvh_extent extent; /* as it was written last */
} svo_i_object_bvh;

typedef struct svo_i_moving_bvhs {
    svo_i_object_bvh *objects; /* by their indices in the scene */
    uint32_t object_count;
    cl_mem nodes, leaves; /* node 0 is the root */
    cl_mem shape[SVO_I_BVH_SHAPE_BUFFERS]; /* of all but the static mesh, which is not refit */
    uint64_t node_capacity, node_end; /* room, and where places can begin */
    uint64_t leaf_capacity, leaf_end; /* the same of the leaves, in units */
    uint64_t item_capacity, item_end; /* the same of the items of shapes */
    uint64_t still_end; /* where the static mesh's nodes end; the nodes of shapes are those from there on */
    uint64_t top_begin, top_room; /* the common nodes below the root */
} svo_i_moving_bvhs;

struct svo_i_flight; /* an enqueued update, of update.c alone */

/* Object k of the caller is objects[k + 1]; the static mesh is objects[0]. */
struct svo_moving {
    svo_device *device;
    svo_frontend *frontend; /* owned */
    svo_plan_options options; /* of the objects' plans */
    uint64_t fragment_limit;
    uint32_t depth;
    svo_i_moving_object *objects;
    uint32_t object_count, object_capacity; /* numbers in use or once used, and room for them */
    /* For stages that work on the whole scene: a copy of the static mesh's plan, whose arrays it borrows. That plan
       lives as long as the scene and is never updated. */
    svo_plan whole;
    cl_mem materials, texels; /* of all objects; NULL where none are needed */
    svo_i_kept_list list, spare; /* of the newest tree; and the buffers that were its list before */
    svo_tree *tree;
    struct svo_i_flight *flight; /* an update that is enqueued and not finished; else NULL */
    double area; /* of the newest tree */
    bool is_open; /* the mesh of the newest tree is open; false where that is not known, without projected areas */
    uint64_t serial; /* the newest serial number */
    svo_i_moving_bvhs *bvhs; /* NULL before svo_moving_make_bvh */
    svo_mesh mesh; /* svo_moving_get_mesh: arrays owned; vertex_count 0: not made */
};

#define SVO_I_MOVING_OBJECTS (SVO_MOVING_OBJECTS_MAX + 1u)

/* Refuses to touch the scene while an update is in flight. */
static inline svo_status svo_i_moving_check_still(const svo_moving *moving, const char *function)
{
    return moving->flight == NULL
               ? SVO_OK
               : svo_i_device_fail(moving->device, SVO_INVALID_ARGUMENT,
                                   "%s: an update is in flight; call svo_moving_finish first", function);
}

/* Whether the scene's pairs are kept with what they show, for projected areas. */
static inline bool svo_i_moving_has_areas(const svo_moving *moving)
{
    return (moving->whole.work.made & (uint32_t)SVO_NEED_PROJECTED_AREA) != 0;
}

/* Whether pairs of the object stay in the list. */
static inline bool svo_i_moving_stays(const svo_i_moving_object *object)
{
    return object->listed && object->plan != NULL && object->visible && !object->stale;
}

/* Whether the object is in the scene. */
static inline bool svo_i_moving_shows(const svo_i_moving_object *object)
{
    return object->plan != NULL && object->visible;
}

/* The objects of the newest tree, with the static mesh. */
static inline uint32_t svo_i_moving_count_parts(const svo_moving *moving)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < moving->object_count; ++i) {
        count += moving->objects[i].part.is_there ? 1 : 0;
    }
    return count;
}

#endif
