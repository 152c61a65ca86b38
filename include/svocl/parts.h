/* SPDX-License-Identifier: MIT */
/** \file
 * Trees in parts, part of svocl::io: a tree that is larger than memory, or that several machines build, is made from
 * parts that lie under nodes of the whole grid, and the parts together are the whole tree, byte for byte.
 *
 *     svo_plan_get_part_header  plan of the whole mesh -> what all parts share      plan.h
 *     svo_plan_create, svo_build  with options.part_header: one part -> its tree    plan.h, build.h
 *     svo_part_save             the part's tree -> a part file
 *     svo_parts_stitch          part files, in any order -> a .svo file
 *
 * svo_parts_create does all of this in a folder, with parts that fit a number of bytes:
 *
 *     svo_parts_create          mesh -> folder: header, triangles by part, list of parts
 *     svo_parts_create_from_file  the same of a file that is read in blocks
 *     svo_parts_planning_...    the same by several processes
 *     svo_parts_open            folder -> svo_parts, in any process on any machine that sees the folder
 *     svo_parts_build           builds one part of the list, unless it is there
 *     svo_parts_finish          all parts are there -> the .svo file
 *     svo_parts_shares_...      the same by several processes
 *     svo_parts_tree_open       all parts are there -> a tree, which nobody stitched      parts_tree.h
 *     svo_parts_remove          removes what is in the folder
 *
 * Every file has the identity of the plan that it is of: a hash of the triangles and materials, the grid, the options
 * of the tree and the version of the library. What is of another plan is refused by name. svo_parts_lease keeps a plan
 * in its place while it is worked by.
 *
 * A part file is a head, a table of segments and the segments: of each level of the part the child masks and the
 * payload, of the leaves also areas and lists, in Morton order. The head has the sums of the part's root, unrounded:
 * the levels above the parts are rounded once, from sums, by the same integer arithmetic as all others. Numbers are
 * little-endian.
 *
 *     0    u8[8] 89 53 56 50 0d 0a 1a 0a
 *     8    u32 version, 4; u32 number of segments
 *     16   u64 length of the file; u64 XXH3 of bytes 32 .. the end of the table
 *     32   u64 identity[2]; u64 code; u32 level; u32 1 for a mesh file, 0 for a part
 *     64   u64 fragments; u64 weight, u64 color[4], i64 normal[3]: the root's sums
 *     136  u32 level_begin[18]: of the part's own levels, as in svo_tree_info
 *     208  segments: u32 kind, u32 level, u64 offset, u64 length, u64 XXH3 of the segment
 *
 * A kind is a svo_tree_buffer; 14 are the root's materials and weights, a u64 each: material << 48 | weight. list_begin
 * has an entry per leaf, and lists have positions among the kept triangles of the whole mesh. Parts of version 1 are of
 * the rounded mesh; they and their folders are refused, so that a stitched tree is exact (svo_tree_info.is_exact).
 *
 * Thread-safety: functions may be called at the same time, also by several processes for one folder: files appear
 * whole or not at all, and two that build the same part write the same bytes. A svo_parts belongs to one thread at a
 * time.
 */
#ifndef SVOCL_PARTS_H
#define SVOCL_PARTS_H

#include "svocl/build.h"
#include "svocl/plan.h"
#include "svocl/tree.h"

#ifdef __cplusplus
extern "C" {
#endif

/** What a part file holds. */
typedef struct svo_part_info {
    size_t struct_size; /**< sizeof(svo_part_info) */
    uint32_t level; /**< of the node that the part lies under */
    uint64_t code; /**< its Morton code */
    uint64_t node_count; /**< 0: no triangle touches the part */
    uint64_t leaf_count; /**< of those, on the deepest level */
    uint64_t fragments; /**< (voxel, triangle) pairs */
    uint64_t file_bytes; /**< length of the file */
} svo_part_info;

/** An empty output. */
#define SVO_PART_INFO_INIT SVO_STRUCT_INIT(svo_part_info)

/** Saves the tree of a part. The file appears whole or not at all.
 *
 * \param tree built from a plan with part_header, with host arrays (svo_tree_download)
 * \param path the file
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_INVALID_ARGUMENT (not a part, no host arrays), SVO_FILE_ERROR or SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_part_save(const svo_tree *tree, const char *path, svo_message *message);

/** Saves what rays meet of the whole mesh: rounded vertices, indices, names of triangles and the mesh's own positions.
 *  svo_parts_stitch needs it for trees with SVO_NEED_RAYS.
 *
 * \param plan of the whole mesh, with SVO_NEED_RAYS; arrays that a device has are copied to the host
 * \param path the file, which appears whole or not at all
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_INVALID_ARGUMENT, SVO_FILE_ERROR, SVO_CL_ERROR or SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_part_save_mesh(svo_plan *plan, const char *path, svo_message *message);

/** Reads a part file whole and checks every byte.
 *
 * \param header of the tree that the part must belong to
 * \param path the file
 * \param info receives what it holds; NULL allowed
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_FILE_ERROR (cannot be read), SVO_FILE_DAMAGED (truncated, changed, of another tree),
 *          SVO_INVALID_ARGUMENT or SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_part_check(const svo_part_header *header, const char *path, svo_part_info *info,
                                  svo_message *message);

/** Puts parts together: writes the .svo file that svo_tree_save writes of the tree in one piece, byte for byte.
 *
 * Parts are read once, in blocks of 64 KiB. Memory holds about 200 bytes per part and per node above the parts.
 *
 * \param header of the tree
 * \param paths part_count part files, in any order; parts may have different levels but not overlap. Where no part is,
 *        the tree is empty: parts that no triangle touches need no file
 * \param part_count 0 is allowed
 * \param mesh_path file of svo_part_save_mesh; NULL without SVO_NEED_RAYS
 * \param path the .svo file, which appears whole or not at all; no pipe or terminal, since its head is written last
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_FILE_DAMAGED (a part is damaged, of another tree, or overlaps another), SVO_CAPACITY_EXCEEDED (more than
 *          2^32 - 2 nodes or list entries; the message has the number), SVO_UNAVAILABLE (a failure of files that may
 *          pass, such as that of a full disk), SVO_FILE_ERROR, SVO_INVALID_ARGUMENT or SVO_OUT_OF_HOST_MEMORY on
 *          failure. */
SVO_API svo_status svo_parts_stitch(const svo_part_header *header, const char *const *paths, size_t part_count,
                                    const char *mesh_path, const char *path, svo_message *message);

/** A folder with the parts of one tree. */
typedef struct svo_parts svo_parts;

#define SVO_PARTS_IDENTITY_BYTES 33 /**< of an identity as text: 32 hexadecimal digits, and the terminator */
#define SVO_PARTS_LEASE_SECONDS  60 /**< a lease that was not renewed for so long is stale */

/** That a run builds or stitches the parts of a folder. While there is one, other processes do not plan or remove it.
 *  Any number of runs may have one of a folder. */
typedef struct svo_parts_lease svo_parts_lease;

/** Takes a lease. It is a file of the folder with its owner in it. A process that takes one before it plans has no gap
 *  between its plan and its parts.
 *
 * \param folder is made where it is not there
 * \param out receives the lease; release it by svo_parts_lease_release
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_UNAVAILABLE (another process plans the folder, which the message names, or there is no space),
 *          SVO_FILE_ERROR, SVO_INVALID_ARGUMENT or SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_parts_lease_take(const char *folder, svo_parts_lease **out, svo_message *message);

/** Renews a lease: to be called three times in SVO_PARTS_LEASE_SECONDS or more often, by any thread, but not while
 *  another uses the lease. A lease that is not renewed counts for nothing, and whoever plans next breaks it: what is
 *  built by the plan before is then refused.
 *
 * \param lease not NULL
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_UNAVAILABLE (it was broken), SVO_FILE_ERROR or SVO_INVALID_ARGUMENT on failure. */
SVO_API svo_status svo_parts_lease_renew(svo_parts_lease *lease, svo_message *message);

/** Releases a lease, and removes the folder if the lease made it and it is empty.
 *
 * \param lease set to NULL; NULL and a pointer to NULL are allowed */
SVO_API void svo_parts_lease_release(svo_parts_lease **lease);

/** A part of the list of a folder. */
typedef struct svo_parts_entry {
    size_t struct_size; /**< sizeof(svo_parts_entry) */
    uint32_t level; /**< of the node that the part lies under */
    uint32_t reserved; /**< 0 */
    uint64_t code; /**< the node's Morton code */
    uint64_t triangles; /**< that may meet the part */
    uint64_t expected_bytes; /**< memory that its build is expected to take at most, buffers and host together */
} svo_parts_entry;

/** An empty output. */
#define SVO_PARTS_ENTRY_INIT SVO_STRUCT_INIT(svo_parts_entry)

/** Plans the parts of a mesh: makes one plan of the whole mesh for the header, counts its triangles in coarse cells of
 *  the grid, cuts the grid into parts that are each expected to fit max_bytes, and writes the triangles of each part to
 *  the folder. Parts that no triangle meets do not exist. Part files that are there already stay; svo_parts_build
 *  checks whether they are of this tree. The plan is made beside the one that is there and replaces it at once, in the
 *  end. Leases of other processes that are stale are broken, which the device's log is told.
 *
 * \param device whose memory the parts are planned for
 * \param mesh the whole mesh
 * \param depth of the whole tree, SVO_DEPTH_MIN .. SVO_PARTS_DEPTH_MAX
 * \param options of the whole tree; NULL means all defaults. part_header must be NULL; builder has no effect, parts
 *        are built by SVO_BUILDER_CL
 * \param max_bytes for the buffers and the host's memory of one part's build; 0: a sixteenth of the whole's, and
 *        at least 16 MiB
 * \param folder is made where it is not there
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_CAPACITY_EXCEEDED (max_bytes is too small for any part), SVO_UNAVAILABLE (another process plans, builds
 *          or stitches the parts, or broke this one's lease, or there is no space), SVO_UNSUPPORTED (SVO_NEED_RAYS
 *          above SVO_DEPTH_MAX, where the tree is never loaded as a whole), SVO_FILE_ERROR, and what svo_plan_create
 *          returns. */
SVO_API svo_status svo_parts_create(svo_device *device, const svo_mesh *mesh, unsigned depth,
                                    const svo_plan_options *options, uint64_t max_bytes, const char *folder,
                                    svo_message *message);

/** The same for a mesh file that is read in blocks, twice after its vertices, so that the mesh is never in memory as a
 *  whole: binary STL, and binary PLY with vertices and faces alone. The tree is the one that the file's import gives,
 *  byte for byte. What an import leaves out with a warning is left out without one.
 *
 * Memory holds about 40 MB beside what the limit counts, however large the file is.
 *
 * \param device whose memory the parts are planned for
 * \param path the file
 * \param depth of the whole tree, SVO_DEPTH_MIN .. SVO_PARTS_DEPTH_MAX
 * \param options of the whole tree, see svo_parts_create
 * \param max_bytes for the buffers and the host's memory of one part's build; 0: see svo_parts_create
 * \param folder is made where it is not there
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_UNSUPPORTED (another format, a file with textures, materials or strips, SVO_NEED_RAYS or
 *          SVO_NEED_PROJECTED_AREA: the message has the reason, and svo_import_file with svo_parts_create does it),
 *          SVO_IMPORT_FAILED (truncated, counts that the file is too short for, no triangles) and what
 *          svo_parts_create returns. */
SVO_API svo_status svo_parts_create_from_file(svo_device *device, const char *path, unsigned depth,
                                              const svo_plan_options *options, uint64_t max_bytes, const char *folder,
                                              svo_message *message);

/** Planning from a mesh file by any number of processes: what svo_parts_create_from_file does, divided into tasks that
 *  may be done anywhere at once. The folder gets the same bytes however many there are. Binary STL is divided into
 *  ranges of facets, binary PLY into ranges of faces where all have one number of corners; else there is one range.
 *
 *      svo_parts_planning_begin    file -> the tasks of the first step
 *      svo_parts_planning_tasks    how many tasks the step has; 0: all is done
 *      svo_parts_planning_task     a task, as bytes
 *      svo_parts_planning_work     a task -> its result, as bytes; in any process that sees the file and the folder
 *      svo_parts_planning_take     a result; after the last of a step, the next step begins
 *      svo_parts_planning_finish   all is done -> the plan takes its place in the folder
 *      svo_parts_planning_end      releases the handle
 *
 *  There are three steps or four: bounds, a count of triangles in coarse cells of the grid, from which the parts
 *  follow, and the triangles themselves, each written once to the parts that it may meet. A task may be done again, and
 *  twice at once: it writes the same bytes to the same places. Bytes of tasks and results are for machines of one kind.
 */
typedef struct svo_parts_planning svo_parts_planning;

/** Begins to plan.
 *
 * \param device,path,depth,options,max_bytes,folder see svo_parts_create_from_file. Others see path and folder under
 *        these names; the device must outlive the planning
 * \param ranges of the file that may be read side by side, 1 .. 65536
 * \param out receives the planning; release it by svo_parts_planning_end
 * \param message receives the reason for a failure; NULL allowed
 * \returns what svo_parts_create_from_file returns. */
SVO_API svo_status svo_parts_planning_begin(svo_device *device, const char *path, unsigned depth,
                                            const svo_plan_options *options, uint64_t max_bytes, const char *folder,
                                            unsigned ranges, svo_parts_planning **out, svo_message *message);

/** The number of tasks of this step. It renews the planner's lease, so it is to be called three times in
 *  SVO_PARTS_LEASE_SECONDS or more often.
 *
 * \param planning not NULL
 * \param count receives the number; 0: svo_parts_planning_finish is next
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_UNAVAILABLE (the lease was broken), SVO_FILE_ERROR or SVO_INVALID_ARGUMENT on failure. */
SVO_API svo_status svo_parts_planning_tasks(svo_parts_planning *planning, size_t *count, svo_message *message);

/** A task of this step.
 *
 * \param planning not NULL
 * \param index below the number of tasks
 * \param task receives its bytes, valid until the last result of the step is taken
 * \param byte_count receives their number
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_INVALID_ARGUMENT on failure. */
SVO_API svo_status svo_parts_planning_task(const svo_parts_planning *planning, size_t index, const void **task,
                                           size_t *byte_count, svo_message *message);

/** Does a task. Memory holds about 40 MB beside the task and its result.
 *
 * \param device any
 * \param task its bytes
 * \param byte_count their number
 * \param result receives bytes; release them by svo_parts_planning_free
 * \param result_bytes receives their number
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_FILE_ERROR (the mesh cannot be read or has changed, or the folder is not there), SVO_UNAVAILABLE (no
 *          space), SVO_INVALID_ARGUMENT (no task of this version of the library) and what svo_parts_create_from_file
 *          returns for the mesh. */
SVO_API svo_status svo_parts_planning_work(svo_device *device, const void *task, size_t byte_count, void **result,
                                           size_t *result_bytes, svo_message *message);

/** Releases a result.
 *
 * \param result of svo_parts_planning_work; NULL allowed */
SVO_API void svo_parts_planning_free(void *result);

/** Takes a result. With the last one of a step, its results are put together and the next step's tasks are made.
 *
 * \param planning not NULL
 * \param index of the task
 * \param result its bytes, which are copied
 * \param byte_count their number
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_INVALID_ARGUMENT (no result of this task) and what svo_parts_create_from_file returns; after a failure
 *          of another kind the planning can only be released. */
SVO_API svo_status svo_parts_planning_take(svo_parts_planning *planning, size_t index, const void *result,
                                           size_t byte_count, svo_message *message);

/** Divides parts that do not fit, and puts the plan in the place of the one that is there.
 *
 * \param planning all of its tasks are done
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_INVALID_ARGUMENT (tasks are left) and what svo_parts_create returns. */
SVO_API svo_status svo_parts_planning_finish(svo_parts_planning *planning, svo_message *message);

/** Releases a planning. What it wrote is removed, unless it was finished.
 *
 * \param planning set to NULL; NULL and a pointer to NULL are allowed */
SVO_API void svo_parts_planning_end(svo_parts_planning **planning);

/** Opens a folder of svo_parts_create.
 *
 * \param folder its path
 * \param out receives the parts
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_FILE_ERROR, SVO_FILE_DAMAGED, SVO_INVALID_ARGUMENT or SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_parts_open(const char *folder, svo_parts **out, svo_message *message);

/** Closes a folder; its files stay.
 *
 * \param parts set to NULL; NULL and a pointer to NULL are allowed */
SVO_API void svo_parts_close(svo_parts **parts);

/** Number of parts in the list.
 *
 * \param parts not NULL
 * \returns the number. */
SVO_API size_t svo_parts_count(const svo_parts *parts);

/** What all parts share.
 *
 * \param parts not NULL
 * \param header receives it
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_INVALID_ARGUMENT when header is NULL or its struct_size is too small. */
SVO_API svo_status svo_parts_get_header(const svo_parts *parts, svo_part_header *header, svo_message *message);

/** The identity of the plan. It is in each of its files, and names the folder of those that are not parts.
 *
 * \param parts not NULL
 * \param text receives it
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_INVALID_ARGUMENT on failure. */
SVO_API svo_status svo_parts_get_identity(const svo_parts *parts, char text[SVO_PARTS_IDENTITY_BYTES],
                                          svo_message *message);

/** Describes a part as it was planned.
 *
 * \param parts not NULL
 * \param index below svo_parts_count
 * \param entry receives the description
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_INVALID_ARGUMENT on failure. */
SVO_API svo_status svo_parts_get(const svo_parts *parts, size_t index, svo_parts_entry *entry, svo_message *message);

/** Whether a part is built: its file is there, or those of the parts that it was split into, and every byte is right.
 *
 * \param parts not NULL
 * \param index below svo_parts_count
 * \param is_built receives 1 or 0
 * \param message receives the reason for a failure, or why a file that is there does not count; else it is empty. NULL
 *        allowed
 * \returns SVO_INVALID_ARGUMENT or SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_parts_is_built(const svo_parts *parts, size_t index, int *is_built, svo_message *message);

/** Builds a part, unless its file is there and whole. A part that takes more memory than expected is split, and its
 *  children are built instead. A damaged file is replaced. Triangles of such children that are missing or damaged are
 *  made again from those of the part.
 *
 * \param parts not NULL
 * \param index below svo_parts_count
 * \param device any; with a budget (max_device_bytes), parts that exceed it are split
 * \param frontend of the device; NULL: OpenCL's. Builders of OpenGL make no parts
 * \param queue of the device; NULL: the device's own
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_FILE_ERROR (such as triangles that are missing), SVO_FILE_DAMAGED (triangles that are not those that
 *          were written; creating the parts again writes them, and keeps what is built), SVO_UNAVAILABLE (the folder
 *          was planned anew since it was opened, or there is no space), SVO_CAPACITY_EXCEEDED (a part that cannot be
 *          split does not fit), SVO_INVALID_ARGUMENT and what svo_build returns. */
SVO_API svo_status svo_parts_build(const svo_parts *parts, size_t index, svo_device *device, svo_frontend *frontend,
                                   cl_command_queue queue, svo_message *message);

/** Stitches all parts of a folder.
 *
 * \param parts not NULL
 * \param path the .svo file, see svo_parts_stitch
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_FILE_ERROR (a part is missing; the message names it), SVO_UNAVAILABLE (the folder was planned anew, and
 *          parts of the plan that was opened are missing) and what svo_parts_stitch returns. */
SVO_API svo_status svo_parts_finish(const svo_parts *parts, const char *path, svo_message *message);

/** Stitching by any number of processes: what svo_parts_finish does, divided into shares of about one cost that may be
 *  written anywhere at once, into one file. The .svo file is the same, byte for byte, whatever their number.
 *
 *      svo_parts_shares_begin    all parts are there -> who writes what, and a file in the folder
 *      svo_parts_shares_write    one share; in any process that sees the folder
 *      svo_parts_shares_finish   all shares are written -> the file gets its name
 *
 *  Each may be called again, and twice at once: what is written is the same bytes at the same places, and what is there
 *  stays. Until the end the file has no head, so that nobody can take it for one that is whole. A share that is written
 *  is flushed to the disk before it counts. Shares of different numbers do not meet.
 *
 * \param parts not NULL, all of them built
 * \param count of shares, 1 .. 65536
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_FILE_ERROR (a part is missing; the message names it, or a file cannot be written), SVO_FILE_DAMAGED (a
 *          part is damaged), SVO_CAPACITY_EXCEEDED (see svo_parts_stitch), SVO_UNAVAILABLE (the folder was planned
 *          anew, or there is no space), SVO_INVALID_ARGUMENT or SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_parts_shares_begin(const svo_parts *parts, unsigned count, svo_message *message);

/** Writes a share, unless it is written. Memory holds about 200 bytes per part and per node above the parts.
 *
 * \param parts not NULL
 * \param index below count
 * \param count as svo_parts_shares_begin was told
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_UNAVAILABLE (the shares have not been begun, or are finished, or a part is another file than it was),
 *          and what svo_parts_shares_begin returns. */
SVO_API svo_status svo_parts_shares_write(const svo_parts *parts, unsigned index, unsigned count, svo_message *message);

/** Completes the file and gives it its name, which must be on the file system of the folder.
 *
 * \param parts not NULL
 * \param count as svo_parts_shares_begin was told
 * \param path the .svo file, which appears whole or not at all
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_UNAVAILABLE (a share is not written, and the message names it, or they have not been begun, or are
 *          finished), SVO_FILE_ERROR (the file cannot get the name), and what svo_parts_shares_begin returns. */
SVO_API svo_status svo_parts_shares_finish(const svo_parts *parts, unsigned count, const char *path,
                                           svo_message *message);

/** Removes the files of a folder, and the folder if nothing else is in it.
 *
 * \param folder of svo_parts_create
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_UNAVAILABLE (another process has a lease), SVO_FILE_ERROR or SVO_INVALID_ARGUMENT on failure. */
SVO_API svo_status svo_parts_remove(const char *folder, svo_message *message);

#ifdef __cplusplus
}
#endif

#endif
