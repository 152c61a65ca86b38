/* SPDX-License-Identifier: MIT */
/* A scene that moves: its objects, and the list of their pairs. */
#ifndef SVO_LIB_MOVING_STATE_H
#define SVO_LIB_MOVING_STATE_H

#include "plan/plan_data.h"
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

struct svo_i_flight; /* enqueue.c */

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
    bool is_open; /* the newest tree's mesh, where it has projected areas */
    bool areas_changed; /* of all leaves by the newest update, since the mesh opened or closed */
    uint64_t serial; /* the newest serial number */
    struct svo_i_moving_bvhs *bvhs; /* NULL before svo_moving_make_bvh */
    svo_mesh mesh; /* svo_moving_get_mesh: arrays owned; vertex_count 0: not made */
};

#define SVO_I_MOVING_OBJECTS (SVO_MOVING_OBJECTS_MAX + 1u)

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

#endif
