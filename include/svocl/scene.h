/* SPDX-License-Identifier: MIT */
/** \file
 * Scenes: many placed trees that rays traverse together.
 *
 * A scene copies its trees into one set of buffers and keeps instances of them, each a tree and a 3 x 4 matrix. Over
 * the instances' world boxes it holds a hierarchy, built on the device: Morton codes of the boxes' centers, ties broken
 * by index, a radix tree (Karras, "Maximizing Parallelism in the Construction of BVHs, Octrees, and k-d Trees", 2012).
 * svo_scene_set_transforms moves instances and refits the boxes; svo_scene_rebuild makes the hierarchy anew, which pays
 * after instances moved far. Hits do not depend on the hierarchy: they are those of all instances in turn, bit for bit.
 *
 * A ray enters a tree as M^-1 origin and M^-1 direction, which is not normalized, so t is the same in the world and in
 * every tree. Where two instances are hit at the same t, the one with the smaller index counts.
 *
 * Thread-safety: every function needs exclusive use of the scene and of its device handle.
 */
#ifndef SVOCL_SCENE_H
#define SVOCL_SCENE_H

#include <stddef.h>
#include <stdint.h>

#include "svocl/compact.h"
#include "svocl/scene_types.h"
#include "svocl/trace.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SVO_SCENE_INSTANCES_MAX 0x1000000u /**< most instances */
#define SVO_SCENE_TREES_MAX     0x10000u /**< most trees */
#define SVO_SCENE_LIGHTS_MAX    8u /**< most lights of a picture */
/** A matrix is refused unless |determinant| is above this times the product of the lengths of its columns. */
#define SVO_SCENE_DETERMINANT_MIN 1e-12

/** Trees and their instances on a device. */
typedef struct svo_scene svo_scene;

/** What a scene is made of. */
typedef struct svo_scene_options {
    size_t struct_size; /**< sizeof(svo_scene_options) */
    svo_tree *const *trees; /**< tree_count trees on the scene's device; the scene copies what it needs of them */
    /** In place of trees, which is then NULL: compact trees, all of one form, made with the same directory_step_log2,
     *  and either all or none with payload that differs between nodes, packed or not. */
    svo_compact *const *compacts;
    const svo_instance *instances; /**< instance_count */
    uint32_t tree_count; /**< 1 .. SVO_SCENE_TREES_MAX */
    uint32_t instance_count; /**< 1 .. SVO_SCENE_INSTANCES_MAX */
    /** What of the trees to copy besides their nodes, bits of svo_need: SVO_NEED_COLOR and SVO_NEED_NORMAL for
     *  pictures, of those trees that hold them on all levels; SVO_NEED_RAYS for triangles, which every tree must then
     *  hold. SVO_NEED_DEFAULT: colors and normals. SVO_NEED_NONE: nothing. */
    uint32_t need;
    uint32_t reserved; /**< zero */
} svo_scene_options;

/** Everything zero; trees and instances have to be set. */
#define SVO_SCENE_OPTIONS_INIT SVO_STRUCT_INIT(svo_scene_options)

/** A scene in numbers. */
typedef struct svo_scene_info {
    size_t struct_size; /**< sizeof(svo_scene_info) */
    uint32_t tree_count; /**< trees */
    uint32_t instance_count; /**< instances */
    uint32_t need; /**< what is copied of the trees */
    uint32_t reserved; /**< zero */
    uint64_t tree_bytes; /**< of device memory: the trees */
    uint64_t instance_bytes; /**< the instances' matrices, normals and boxes */
    uint64_t hierarchy_bytes; /**< the hierarchy */
    uint64_t sort_bytes; /**< Morton codes and what sorts them, kept for svo_scene_rebuild */
    uint64_t total_bytes; /**< all of these */
    double low[3]; /**< least corner of the box around all instances, world coordinates; zero in a plan */
    double high[3]; /**< its greatest corner */
} svo_scene_info;

/** An empty output. */
#define SVO_SCENE_INFO_INIT SVO_STRUCT_INIT(svo_scene_info)

/** The bytes that svo_scene_create will allocate, checked as it does, without the matrices.
 *
 * \param device the trees'
 * \param options see svo_scene_options; instances may be NULL
 * \param info receives the numbers
 * \returns SVO_INVALID_ARGUMENT or SVO_UNSUPPORTED on failure, or what svo_tree_make_bvh returns: with SVO_NEED_RAYS
 *          the trees' BVHs are made, whose sizes are not known before. */
SVO_API svo_status svo_scene_plan(svo_device *device, const svo_scene_options *options, svo_scene_info *info);

/** Makes a scene and waits for it. The trees may be destroyed afterwards.
 *
 * \param device the trees'; must outlive the scene
 * \param options see svo_scene_options
 * \param queue on the device's context; NULL: the device's own
 * \param scene receives the scene, which the caller destroys
 * \returns SVO_INVALID_ARGUMENT (also for a matrix that is not finite, flat, or puts its instance beyond 2^100 in
 *          absolute value; the message names the instance), SVO_UNSUPPORTED, SVO_COMPILE_FAILED, SVO_CL_ERROR or
 *          SVO_OUT_OF_DEVICE_MEMORY on failure. */
SVO_API svo_status svo_scene_create(svo_device *device, const svo_scene_options *options, cl_command_queue queue,
                                    svo_scene **scene);

/** Destroys a scene.
 *
 * \param scene set to NULL; NULL and a pointer to NULL are allowed */
SVO_API void svo_scene_destroy(svo_scene **scene);

/** Describes a scene.
 *
 * \param scene not NULL
 * \param info receives the description
 * \returns SVO_INVALID_ARGUMENT when an argument is NULL or info's struct_size is too small. */
SVO_API svo_status svo_scene_get_info(const svo_scene *scene, svo_scene_info *info);

/** Moves consecutive instances, refits the hierarchy's boxes, and waits. If a matrix is refused, nothing moves.
 *
 * \param scene not used by commands in flight
 * \param first the first instance
 * \param count instances, first + count at most svo_scene_info.instance_count; 0 does nothing
 * \param transforms count * 12 floats, as svo_instance.transform; NULL allowed when count is 0
 * \param queue on the context of the scene's device; NULL: the device's own
 * \returns SVO_INVALID_ARGUMENT, SVO_OUT_OF_HOST_MEMORY or SVO_CL_ERROR on failure. After SVO_CL_ERROR the scene can
 *          only be destroyed. */
SVO_API svo_status svo_scene_set_transforms(svo_scene *scene, uint32_t first, uint32_t count, const float *transforms,
                                            cl_command_queue queue);

/** Builds the hierarchy anew from where the instances are now, and waits. The result is that of a new scene, bit for
 *  bit.
 *
 * \param scene not used by commands in flight
 * \param queue on the context of the scene's device; NULL: the device's own
 * \returns what svo_scene_set_transforms returns. */
SVO_API svo_status svo_scene_rebuild(svo_scene *scene, cl_command_queue queue);

/** What a batch of rays asks a scene for: a sum of these. */
typedef enum svo_scene_flags {
    SVO_SCENE_CLOSEST = 0, /**< the first hit along each ray: least t as reported, then least instance */
    SVO_SCENE_ANY = 1, /**< whether there is a hit; the record is that of some instance */
    SVO_SCENE_EVERY_INSTANCE =
        2 /**< asks every instance in turn, without the hierarchy: the same hits, to check them */
} svo_scene_flags;

/** A scene as a target: svo_render, svo_trace_voxels, svo_trace_triangles and svo_camera_fit.
 *
 * Each instance's hit is that of svo_trace_voxels or svo_trace_triangles for the ray in the tree. A footprint divides
 * by the length of the matrix's longest column: nodes are drawn as leaves when the instance shows them smaller than a
 * pixel. Triangles need SVO_NEED_RAYS.
 *
 * Its pictures show voxels by normal and color as far as the scene holds them (SVO_NEED_NORMAL, SVO_NEED_COLOR), with
 * Lambert shading by the lights, shadows, and the light of the sky. With colors, what shows in part takes its alpha's
 * share of a pixel's rays, and from an alpha of a half on it has a shadow; traced rays meet whatever is there.
 *
 * \param scene NULL: calls are refused
 * \returns the target. */
SVO_API svo_target svo_scene_target(svo_scene *scene);

#ifdef __cplusplus
}
#endif

#endif
