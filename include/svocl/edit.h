/* SPDX-License-Identifier: MIT */
/** \file
 * Edits of voxels: shapes, and the voxels of other trees, are set, cleared, kept or painted, and each step can be
 * undone. The result is a list of voxels or a tree.
 *
 * An edit is an octree of its own in host memory, made from a list of voxels: of a file, or of a tree
 * (svo_tree_get_voxels; of a compact tree after svo_compact_expand). A step writes new nodes along the surface of what
 * it changes and shares all others with the version before. So it costs what it changes, and the versions that can be
 * undone to cost what they differ in. Full cubes of one color and material, without normals, are one node each.
 *
 * An edit has normals if its first list has them. Then voxels keep theirs, wherever they go, and SVO_EDIT_PAINT changes
 * none. Of a box, a sphere or a capsule that is set or added, a voxel with a face to the outside of the shape gets the
 * shape's normal, rounded to 1/32767: of a sphere or a capsule the direction from its center, or from the nearest point
 * of its line in 1/256 of a voxel, to the voxel's center; of a box the sum of the normals of the faces that it is at.
 * The other voxels of shapes have none, 0, 0, 0, nor do voxels that come from an edit without normals. What the edit
 * uncovers keeps what it has.
 *
 * Coordinates are those of the list. A voxel (x, y, z) is inside a shape if its center (x + 1/2, y + 1/2, z + 1/2) is.
 * Positions and radii are rounded to 1/256 of a voxel, halves up, and decisions are exact from there on.
 *
 * Nodes that no version has any more are collected by a step that begins with more than svo_edit_info.collect_bytes in
 * use, twice what the last collection kept and eight segments of 1.02 MiB, and by a step that else would exceed
 * max_bytes. A collection moves nodes in place and needs no memory. svo_edit_collect does it when the caller wants.
 *
 * Thread-safety: several threads may call functions that take a const edit. All others need exclusive use of the edit.
 */
#ifndef SVOCL_EDIT_H
#define SVOCL_EDIT_H

#include <stddef.h>
#include <stdint.h>

#include "svocl/build.h"
#include "svocl/compact.h"
#include "svocl/device.h"
#include "svocl/memory.h"
#include "svocl/plan.h"
#include "svocl/trace.h"
#include "svocl/tree.h"
#include "svocl/voxels.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SVO_EDIT_EXTENT    0x200000 /**< voxels along each axis of the cube that an edit can fill */
#define SVO_EDIT_UNDO_MAX  0x100000 /**< most steps that can be kept */
#define SVO_EDIT_BYTES_MIN 0x200000 /**< least max_bytes */

/** An octree that can be edited, with its versions. */
typedef struct svo_edit svo_edit;

/** What a step does with the voxels inside a shape. */
typedef enum svo_edit_verb {
    /** "set": all of it gets the step's color and material, and the shape's normals. A union where the shape wins */
    SVO_EDIT_SET = 0,
    SVO_EDIT_ADD = 1, /**< "add": what is empty is filled; voxels stay as they are. A union where they win */
    SVO_EDIT_CLEAR = 2, /**< "clear": all of it becomes empty. A difference */
    SVO_EDIT_KEEP = 3, /**< "keep": all outside of it becomes empty. An intersection */
    SVO_EDIT_PAINT = 4 /**< "paint": voxels get the step's color and material; what is empty stays so */
} svo_edit_verb;

/** Shapes. */
typedef enum svo_edit_shape {
    SVO_EDIT_BOX = 0, /**< "box": from begin, inclusive, to end, exclusive; empty where end is not above begin */
    SVO_EDIT_SPHERE = 1, /**< "sphere": at most radius from begin */
    SVO_EDIT_CAPSULE = 2, /**< "capsule": at most radius from the line between begin and end */
    /** "voxels": those of another edit, moved by offset; each has its own color, material and normal. A closed mesh is
     *  one: its solid (svo_solid_create), expanded, as voxels */
    SVO_EDIT_VOXELS = 3
} svo_edit_shape;

/** A step. */
typedef struct svo_edit_step {
    size_t struct_size; /**< sizeof(svo_edit_step) */
    uint32_t verb; /**< svo_edit_verb */
    uint32_t shape; /**< svo_edit_shape */
    uint8_t rgba[4]; /**< color of what is set, added or painted; not of SVO_EDIT_VOXELS */
    uint32_t material; /**< the same: below 65535 */
    double begin[3]; /**< voxels; not of SVO_EDIT_VOXELS */
    double end[3]; /**< voxels; of boxes and capsules */
    double radius; /**< voxels, at least 0; of spheres and capsules */
    const svo_edit *other; /**< of SVO_EDIT_VOXELS: its voxels as they are now; may be the same edit */
    int32_t offset[3]; /**< of SVO_EDIT_VOXELS: is added to their coordinates */
    uint32_t reserved; /**< 0 */
} svo_edit_step;

/** A step that sets nothing: an empty box. */
#define SVO_EDIT_STEP_INIT SVO_STRUCT_INIT(svo_edit_step)

/** Receives the progress of a step, and may stop it: at the beginning 0, at the end 1, and in between often. It must
 *  not use the edit.
 *
 * \param user progress_user of the options
 * \param fraction 0 .. 1, never less than in the call before
 * \returns 0 to go on. Else the step ends with SVO_CANCELED, and the edit is as it was before. */
typedef int (*svo_edit_progress_callback)(void *user, double fraction);

/** Options of an edit. */
typedef struct svo_edit_options {
    size_t struct_size; /**< sizeof(svo_edit_options) */
    /** Most memory of all nodes, in bytes, at least SVO_EDIT_BYTES_MIN; 0: half of what the machine and the process's
     *  limits allow. */
    uint64_t max_bytes;
    uint32_t undo_count; /**< steps that can be undone, at most SVO_EDIT_UNDO_MAX; the oldest is forgotten. 0: 64 */
    uint32_t reserved; /**< 0 */
    svo_edit_progress_callback progress; /**< of steps; NULL: nothing is called */
    void *progress_user; /**< passed to progress */
    /** Host memory of the edit and its lists, for its whole life; NULL: malloc and free. */
    const svo_memory_callbacks *memory;
} svo_edit_options;

/** All defaults. */
#define SVO_EDIT_OPTIONS_INIT SVO_STRUCT_INIT(svo_edit_options)

/** What an edit holds. */
typedef struct svo_edit_info {
    size_t struct_size; /**< sizeof(svo_edit_info) */
    int32_t low[3]; /**< least coordinates that voxels can have: the list's least ones less 2^20 */
    int32_t high[3]; /**< greatest ones plus 1 */
    uint64_t voxel_count; /**< now */
    uint32_t undo_count; /**< steps that can be undone */
    uint32_t redo_count; /**< steps that can be done again */
    uint64_t max_bytes; /**< of the options, or what 0 means */
    uint64_t held_bytes; /**< of all nodes, in whole segments; never above max_bytes */
    uint64_t peak_bytes; /**< the most so far */
    uint64_t kept_bytes; /**< what the last collection kept; before the first, what the list took */
    uint64_t collect_bytes; /**< a step that begins with more collects first */
    uint64_t collections; /**< so far */
    uint64_t step_nodes; /**< places on all levels that the last step decided about */
    uint64_t step_bytes; /**< of the nodes that it wrote */
    double origin[3]; /**< of the list */
    double voxel_edge; /**< of the list */
} svo_edit_info;

/** An empty output. */
#define SVO_EDIT_INFO_INIT SVO_STRUCT_INIT(svo_edit_info)

/** Begins an edit of a list of voxels. The edit takes over its place, the width of its voxels, and the properties of
 *  its materials.
 *
 * \param voxels not needed afterwards; NULL: no voxels, with origin 0 and voxels one unit wide
 * \param options NULL means all defaults
 * \param out receives the edit
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_INVALID_ARGUMENT, SVO_CAPACITY_EXCEEDED (max_bytes) or SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_edit_create(const svo_voxels *voxels, const svo_edit_options *options, svo_edit **out,
                                   svo_message *message);

/** Destroys an edit.
 *
 * \param edit set to NULL; NULL and a pointer to NULL are allowed */
SVO_API void svo_edit_destroy(svo_edit **edit);

/** Describes an edit.
 *
 * \param edit not NULL
 * \param info receives the description
 * \returns SVO_INVALID_ARGUMENT when info is NULL or its struct_size is too small. */
SVO_API svo_status svo_edit_get_info(const svo_edit *edit, svo_edit_info *info);

/** Does a step. Those that were undone can no longer be done again. After a failure the edit is as it was before.
 *
 * \param edit not NULL
 * \param step not NULL. The shape must lie within svo_edit_info.low .. high, with its radius; of SVO_EDIT_VOXELS what
 *        is set or added must
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_INVALID_ARGUMENT, SVO_CAPACITY_EXCEEDED (max_bytes), SVO_OUT_OF_HOST_MEMORY or SVO_CANCELED (the
 *          progress callback) on failure. */
SVO_API svo_status svo_edit_apply(svo_edit *edit, const svo_edit_step *step, svo_message *message);

/** Copies the voxels inside a shape to another place, as one step. Where the copy meets others, the copy wins with
 *  SVO_EDIT_SET, and they win with SVO_EDIT_ADD; other verbs take the copy as svo_edit_apply takes other voxels.
 *
 * \param edit not NULL
 * \param region not NULL; a box, sphere or capsule, and the verb. rgba and material have no meaning
 * \param offset x, y, z, which is added to coordinates, each in -2^21 .. 2^21
 * \param message receives the reason for a failure; NULL allowed
 * \returns what svo_edit_apply returns. */
SVO_API svo_status svo_edit_copy(svo_edit *edit, const svo_edit_step *region, const int32_t offset[3],
                                 svo_message *message);

/** Goes back by one step.
 *
 * \param edit not NULL
 * \returns SVO_INVALID_ARGUMENT when svo_edit_info.undo_count is 0. */
SVO_API svo_status svo_edit_undo(svo_edit *edit);

/** Does the step again that was undone last.
 *
 * \param edit not NULL
 * \returns SVO_INVALID_ARGUMENT when svo_edit_info.redo_count is 0. */
SVO_API svo_status svo_edit_redo(svo_edit *edit);

/** Forgets all versions but the current one: nothing can be undone or done again. What they alone need is garbage.
 *
 * \param edit not NULL */
SVO_API void svo_edit_forget(svo_edit *edit);

/** Releases the memory of nodes that no version has any more. The time is in proportion to what the edit holds.
 *
 * \param edit not NULL */
SVO_API void svo_edit_collect(svo_edit *edit);

/** The voxel at a place.
 *
 * \param edit not NULL
 * \param place x, y, z
 * \param voxel receives it; untouched where there is none; NULL allowed
 * \returns not 0 when there is a voxel. */
SVO_API int svo_edit_find(const svo_edit *edit, const int32_t place[3], svo_voxel *voxel);

/** The voxels of an edit as a list, which equals one that svo_voxels_create makes of the same voxels. While it runs it
 *  needs 20 bytes for each voxel, and 20 more where the voxels do not begin where those of the first list began; with
 *  normals, 6 and 10 more.
 *
 * \param edit with at most SVO_VOXELS_MAX voxels
 * \param out receives the list
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_INVALID_ARGUMENT or SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_edit_get_voxels(const svo_edit *edit, svo_voxels **out, svo_message *message);

/** Makes the tree of an edit. It has the bytes of every tree that is built of these voxels, however they came to be.
 *  The edit goes on and does not change.
 *
 *  The host writes the tree from the edit's nodes, in time in proportion to the tree, and without kernels; then
 *  svo_build_report.builder is "edit". An empty edit, a tree of depth 1, and options other than need, payload_level,
 *  builder, weights and progress take the way of svo_edit_get_voxels and svo_voxels_build. Host memory for the arrays
 *  is released again; where the voxels do not begin where those of the first list began, also for a copy of the nodes.
 *
 * \param edit as for svo_edit_get_voxels
 * \param device not NULL; must outlive the tree. It has the message of a failure
 * \param depth as for svo_voxels_plan
 * \param options as for svo_voxels_plan
 * \param queue on the device's context; NULL: the device's own
 * \param out receives the tree
 * \param report receives times and counts, as from svo_build; NULL allowed
 * \returns what svo_edit_get_voxels, svo_voxels_build and svo_tree_upload return. */
SVO_API svo_status svo_edit_commit(const svo_edit *edit, svo_device *device, unsigned depth,
                                   const svo_plan_options *options, cl_command_queue queue, svo_tree **out,
                                   svo_build_report *report);

/** Makes the compact tree of an edit: svo_edit_commit, and svo_compact_create of its tree, with the same bytes.
 *
 *  In SVO_FORM_SHARED without minimize, where svo_edit_commit writes the tree from the edit's nodes, payload is written
 *  in the form's order at once and no tree goes to the device: this takes about half the time.
 *
 * \param edit as for svo_edit_get_voxels
 * \param device not NULL; must outlive the compact tree. It has the message of a failure
 * \param depth as for svo_voxels_plan
 * \param options as for svo_voxels_plan
 * \param compact as for svo_compact_create; NULL means all defaults
 * \param queue on the device's context; NULL: the device's own
 * \param out receives the compact tree
 * \returns what svo_edit_commit and svo_compact_create return. */
SVO_API svo_status svo_edit_commit_compact(const svo_edit *edit, svo_device *device, unsigned depth,
                                           const svo_plan_options *options, const svo_compact_options *compact,
                                           cl_command_queue queue, svo_compact **out);

/** The nodes of an edit on a device, for pictures without a tree: svo_render(svo_edit_mirror_target(mirror), ...). */
typedef struct svo_edit_mirror svo_edit_mirror;

/** What a mirror holds. */
typedef struct svo_edit_mirror_info {
    size_t struct_size; /**< sizeof(svo_edit_mirror_info) */
    uint64_t device_bytes; /**< of all nodes, and room for a quarter and a MiB more */
    uint64_t written_bytes; /**< that the last update copied */
    uint32_t depth; /**< of the grid of pictures */
} svo_edit_mirror_info;

/** An empty output. */
#define SVO_EDIT_MIRROR_INFO_INIT SVO_STRUCT_INIT(svo_edit_mirror_info)

/** Copies the nodes of an edit to a device.
 *
 * \param device must outlive the mirror
 * \param edit must outlive the mirror. Its nodes may get a few more above those of its voxels
 * \param queue on the device's context; NULL: the device's own
 * \param out receives the mirror
 * \returns what svo_edit_mirror_update returns. */
SVO_API svo_status svo_edit_mirror_create(svo_device *device, svo_edit *edit, cl_command_queue queue,
                                          svo_edit_mirror **out);

/** Makes pictures show the edit as it is now, after steps, undo, redo or a collection. What the device lacks is copied:
 *  the nodes that steps wrote since the last update, or all after a collection and where the buffer was too small.
 *
 * \param mirror not NULL; no picture of it may be in flight
 * \param queue on the device's context; NULL: the device's own
 * \returns SVO_INVALID_ARGUMENT, SVO_UNSUPPORTED (voxels that span more than about 2^16 along an axis, or 16 GiB of
 *          nodes), SVO_CAPACITY_EXCEEDED (the edit's max_bytes), SVO_OUT_OF_HOST_MEMORY, SVO_OUT_OF_DEVICE_MEMORY or
 *          SVO_CL_ERROR on failure. Call it again before the next picture then. */
SVO_API svo_status svo_edit_mirror_update(svo_edit_mirror *mirror, cl_command_queue queue);

/** Describes a mirror.
 *
 * \param mirror not NULL
 * \param info receives the description
 * \returns SVO_INVALID_ARGUMENT when info is NULL or its struct_size is too small. */
SVO_API svo_status svo_edit_mirror_get_info(const svo_edit_mirror *mirror, svo_edit_mirror_info *info);

/** A mirror as a target: of svo_render with SVO_VIEW_SHADED, and of svo_camera_fit, which frames its cubes of
 *  four voxels; the whole grid between a collection and the update. Where
 *  rays meet voxels, pictures are those of the tree of svo_edit_commit if both grids begin in one place; where a pixel
 *  covers more, nodes have means of means of the colors below. Other grids round elsewhere.
 *
 * \param mirror NULL: calls are refused
 * \returns the target. */
SVO_API svo_target svo_edit_mirror_target(svo_edit_mirror *mirror);

/** Destroys a mirror. Pictures in flight keep what they read.
 *
 * \param mirror set to NULL; NULL and a pointer to NULL are allowed */
SVO_API void svo_edit_mirror_destroy(svo_edit_mirror **mirror);

#ifdef __cplusplus
}
#endif

#endif
