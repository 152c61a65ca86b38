/* SPDX-License-Identifier: MIT */
/** \file
 * Compact trees: smaller forms of a built tree's nodes, on a device, on the host, or both. A compact tree is
 * independent of the tree that it was made from. Leaf lists and projected areas are not carried; svo_compact_expand
 * gives the rest back.
 *
 * A leaf may lie on any level: it then stands for all voxels inside. The root is always an inner node. In every form a
 * child in octant o = x | y << 1 | z << 2 is named by bit o of its parent's masks.
 *
 * SVO_FORM_DESCRIPTOR (after Laine and Karras, "Efficient Sparse Voxel Octrees", 2010). nodes has a word for each inner
 * node: bits 0-7 valid mask, bits 8-15 leaf mask (the child ends here), bit 16 far, bits 17-31 the distance in words
 * from the node to its first inner child. Inner children lie side by side: that in octant o is at first +
 * popcount(valid & ~leaf & ((1 << o) - 1)). A distance above 32767 sets far; the field then leads to a far word, which
 * holds the distance. Order: a sibling group, its far words, then each member's descendants in turn; the root is the
 * first word. Far flags are the least fixed point: a far word is there only if its group needs it.
 *
 * SVO_FORM_IMPLIED. nodes has a child mask, one byte, for each node above level depth, breadth-first; 0 means a leaf,
 * except in the root. The first child of node i is 1 + the sum of popcount(mask[j]) over j < i; links[k] is that of
 * node k << directory_step_log2. Zeros fill nodes up to a multiple of eight bytes. bases has one element: the first
 * node with payload, which is at place 0.
 *
 * SVO_FORM_SHARED, a directed acyclic graph (after Kampe, Sintorn and Assarsson, "High Resolution Sparse Voxel DAGs",
 * 2013). Nodes of a level with equal subtrees have one record in nodes; only occupancy counts. links has the depth and
 * the number depth - payload_level. The root's record is at word 0. Levels follow each other from the top; the records
 * of a level are in the order of their first nodes. Bits 0-7 of a record's first word are the valid mask, bits 8-15 the
 * leaf mask; inner children are those that do not end here, r = 0, 1, ... by ascending octant. What follows depends on
 * L, the number of levels from the node down to the voxels:
 *
 *     L = 1  all children are voxels. There is no record; the parent has the valid mask. A root has one word
 *     L = 2  byte 2 + r of the record is the valid mask of inner child r; 0 bytes up to a whole word
 *     L > 2  before[r] for r = 1 .. n, then for each r the word at which inner child r's record begins
 *
 * before[r] is the number of payloads in the subtrees of inner children 0 .. r - 1. n is the number of inner children,
 * less one unless a leaf comes after all of them; it is 0 where all payload is constant or not held. For L up to 5
 * before[r] has 16 bits and is half word r of the record; above it has 32 bits and is word r. An odd half word at the
 * end is 0. Payload is in depth-first order: a node's, then those of its first child's subtree, its second child's
 * subtree, and so on. So the place of a child is that of its node, plus 1 if the node has payload, plus the payloads of
 * earlier children's subtrees: before[r], and 1 for each leaf among them that has payload. Added up along a walk this
 * gives every node its own place, whatever it shares. There are no bases.
 *
 * SVO_FORM_MIRRORED (after Villanueva, Marton and Gobbetti, "SSVDAGs: Symmetry-aware Sparse Voxel DAGs", 2016). The
 * same, but nodes of a level share a record if their subtrees are equal up to reflections. A mirror has a bit for each
 * axis; a node with the mirror m has the child of its record's octant s in its own octant s ^ m, reflected by m as
 * well, so mirrors add up by ^ on the way down. The root has none. Records are in half words: half word k is bits 16 (k
 * & 1) and up of nodes[k >> 1], and one may be left over, which is 0. links has the depth, depth - payload_level, and
 * for L = 2 .. depth, at links[L], the half word at which the records with L levels below begin. In a level those that
 * more references lead to are first; of as many, those that are referred to first. A record is
 *
 *     L = 1  as above; a root has one half word
 *     L = 2  byte 0 is the valid mask; a byte for each child follows: its valid mask, 0 if it ends here
 *     L > 2  a half word: bits 0-7 are the inner children, bits 8-15 those of them with a long reference, and the
 *            children that end here; before[r] for r = 1 .. n; then a reference to each inner child's record
 *
 * A reference is a half word: bits 0-12 are the record's place in half words from links[L - 1], bits 13-15 the child's
 * mirror. A long one has a second half word, 16 further bits of the place, and is used where these are not all 0.
 * before[r] and n are as above, a half word for L up to 5, else two, the low one first. Ranks, places and the order of
 * payload are those of the record's octants, not of the node's. The least of a node's eight reflections is its record:
 * by octant 0, 1, ..., nothing before a leaf before inner children, these by masks (L = 2), or by the first of the
 * nodes with their record and by mirror. The least mirror counts where several lead to the same subtree.
 *
 * Payload, as on a built tree, belongs to the nodes from payload_level on. In SVO_FORM_DESCRIPTOR bases[w], beside word
 * w, is the place of the first child's payload in every payload array; the children's payloads lie side by side in
 * ascending octant, groups in the order of their parents' words. Place 0 is the root's if payload_level is 0. bases has
 * SVO_NO_NODE where the children are above payload_level, and 0 beside far words. In every form bases is absent where
 * all payload is constant or not held.
 *
 * Packed payload. svo_compact_pack codes payload arrays in blocks of neighbors; pictures and svo_compact_expand read
 * any element where it is. The elements stay in the form's order. kernels/shared/packed.clh has the layout to the bit,
 * and svo_kernel_source has its functions in programs compiled with -DSVO_PACKED: svo_packed_color(words, place) gives
 * RGBA8 with red in the lowest byte, svo_packed_normal(words, place, uint out[3]) the components in 16 bits each,
 * svo_packed_halves(words, place, 1, out) a material or a fill; words is the array's buffer.
 *
 * Thread-safety: several threads may call functions that take a const svo_compact. All others need exclusive use of it
 * and of its device handle.
 */
#ifndef SVOCL_COMPACT_H
#define SVOCL_COMPACT_H

#include <stddef.h>
#include <stdint.h>

#include "svocl/device.h"
#include "svocl/trace.h"
#include "svocl/tree.h"

#ifdef __cplusplus
extern "C" {
#endif

/** A compact tree. */
typedef struct svo_compact svo_compact;

/** How a compact tree stores its nodes. */
typedef enum svo_form {
    SVO_FORM_DESCRIPTOR = 0, /**< a word per inner node, in an order of short distances */
    SVO_FORM_IMPLIED = 1, /**< child masks alone, and a directory */
    SVO_FORM_SHARED = 2, /**< equal subtrees are stored once */
    SVO_FORM_MIRRORED = 3, /**< subtrees that are equal up to reflections are stored once */
    SVO_FORM_COUNT /**< number of forms */
} svo_form;

/** The arrays of a compact tree. */
typedef enum svo_compact_buffer {
    SVO_COMPACT_NODES = 0, /**< "nodes": as the form has them */
    SVO_COMPACT_LINKS, /**< "links": u32; the directory of SVO_FORM_IMPLIED, numbers of the forms with records */
    SVO_COMPACT_BASES, /**< "bases": u32; places of payload */
    SVO_COMPACT_COLORS, /**< "colors": 4 u8 each */
    SVO_COMPACT_NORMALS, /**< "normals": 3 i16 each */
    SVO_COMPACT_MATERIALS, /**< "materials": u16 each */
    SVO_COMPACT_FILLS, /**< "fills": u16 each */
    SVO_COMPACT_BUFFER_COUNT /**< number of arrays */
} svo_compact_buffer;

/** The payload arrays among them, which begin with SVO_COMPACT_COLORS. */
#define SVO_PAYLOAD_COUNT 4

/** Options of a compact tree. */
typedef struct svo_compact_options {
    size_t struct_size; /**< sizeof(svo_compact_options) */
    svo_form form; /**< how to store the nodes */
    uint32_t leave_out; /**< svo_need bits: payload of the tree that is not carried */
    uint32_t directory_step_log2; /**< SVO_FORM_IMPLIED: 4, 5 or 6, an entry for 16, 32 or 64 nodes; 0 means 5 */
    /** Not 0: a node whose eight children are leaves becomes a leaf if all payload below is equal, or within the
     *  tolerances of what the node stores. It stores the color, normal and material that it has as an inner node, and
     *  the middle of the fills below: a fill of each voxel in it, not of the node. Materials must be equal. The root
     *  and, where some payload is not constant, nodes above payload_level stay inner nodes. */
    uint32_t minimize;
    uint32_t color_tolerance[4]; /**< minimize: most that red, green, blue, alpha of a voxel may change; 0 .. 255 */
    uint32_t normal_tolerance; /**< minimize: most that a component of a voxel's normal may change; 0 .. 65534 */
    uint32_t fill_tolerance; /**< minimize: most that a voxel's fill may change; 0 .. 65535 */
} svo_compact_options;

/** All defaults. */
#define SVO_COMPACT_OPTIONS_INIT SVO_STRUCT_INIT(svo_compact_options)

/** What describes a compact tree besides its arrays. */
typedef struct svo_compact_info {
    size_t struct_size; /**< sizeof(svo_compact_info) */
    svo_form form; /**< how the nodes are stored */
    uint32_t minimized; /**< not 0: leaves may lie above level depth */
    uint32_t directory_step_log2; /**< SVO_FORM_IMPLIED; else 0 */
    uint32_t depth; /**< the grid has 2^depth voxels per axis */
    uint32_t snap_bits; /**< as all down to scale: those of the tree */
    uint32_t coverage; /**< svo_coverage */
    uint32_t need; /**< svo_need bits: the payload that is held */
    uint32_t constant; /**< of those, payload that is the same in every node: one element */
    uint32_t weights; /**< svo_weights */
    uint32_t payload_level; /**< first level with payload */
    double origin[3]; /**< minimum corner of the grid, world coordinates */
    double edge; /**< world units: as in svo_tree_info */
    double scale; /**< grid units per world unit */
    uint64_t triangles; /**< of the mesh */
    uint64_t refused_triangles; /**< of those, not usable */
    uint64_t fragments; /**< (voxel, triangle) pairs */
    uint64_t inner_count; /**< inner nodes of the tree that the form describes */
    uint64_t leaf_count; /**< its leaves, on whatever level */
    uint64_t voxel_count; /**< voxels that these leaves stand for */
    uint64_t stored_count; /**< elements of nodes: words, or masks in SVO_FORM_IMPLIED */
    uint64_t far_count; /**< SVO_FORM_DESCRIPTOR: far words among them; else 0 */
    uint64_t shared_count; /**< SVO_FORM_SHARED, SVO_FORM_MIRRORED: records in these words; else 0 */
    uint64_t payload_count; /**< elements of each payload array that is not constant */
    uint32_t level_inner[SVO_LEVELS_MAX]; /**< inner nodes on each level */
    uint32_t level_leaf[SVO_LEVELS_MAX]; /**< leaves on each level */
    uint64_t bytes[SVO_COMPACT_BUFFER_COUNT]; /**< of each array; 0: not held */
    uint64_t total_bytes; /**< of all arrays */
    uint32_t bounds; /**< svo_compact_plan: bit b is set where bytes[b] is an upper bound; else 0 */
    /** Not 0: voxels are those of the mesh, or the voxels, as given. 0: the tree or the compact tree is from a file of
     *  an older version, and they are those of the mesh as it was rounded; as in svo_tree_info. */
    uint32_t is_exact;
    uint32_t packed; /**< svo_need bits: payload that is packed; bytes has its packed length */
    uint32_t normal_bits; /**< of packed normals: as in svo_pack_options */
    /** Of packed payload, colors, normals, materials and fills in turn: the largest difference of a component from what
     *  was packed, and below it the mean one over all components but alpha and all elements. 0: nothing changed. */
    uint32_t largest_error[SVO_PAYLOAD_COUNT];
    double mean_error[SVO_PAYLOAD_COUNT]; /**< see largest_error */
} svo_compact_info;

/** An empty output. */
#define SVO_COMPACT_INFO_INIT SVO_STRUCT_INIT(svo_compact_info)

/** Host arrays, owned by the compact tree; NULL where it does not hold them. Constant payload has one element. */
typedef struct svo_compact_arrays {
    size_t struct_size; /**< sizeof(svo_compact_arrays) */
    const void *nodes; /**< stored_count: u32 words; u8 masks in SVO_FORM_IMPLIED */
    const uint32_t *links; /**< see the head of this file */
    const uint32_t *bases; /**< places of payload: see the head of this file */
    const uint8_t *colors; /**< payload_count * 4: RGBA8 */
    const int16_t *normals; /**< payload_count * 3 */
    const uint16_t *materials; /**< payload_count */
    const uint16_t *fills; /**< payload_count */
    /** Packed colors, normals, materials and fills in turn, where those above are NULL; svo_compact_info.bytes each. */
    const uint32_t *packed[SVO_PAYLOAD_COUNT];
} svo_compact_arrays;

/** An empty output. */
#define SVO_COMPACT_ARRAYS_INIT SVO_STRUCT_INIT(svo_compact_arrays)

/** Says what svo_compact_create would make, before anything is allocated on the device. What follows from the tree's
 *  counts is exact; the rest is an upper bound, which svo_compact_info.bounds marks: the far words of
 *  SVO_FORM_DESCRIPTOR, at most 0.33 % of the words; the records of the other forms, as if no two subtrees were equal;
 *  and with minimize all that is not constant.
 *
 * \param tree complete
 * \param options NULL means all defaults
 * \param info receives the description; its counts are those before minimizing
 * \returns SVO_INVALID_ARGUMENT when an option is out of its range. */
SVO_API svo_status svo_compact_plan(const svo_tree *tree, const svo_compact_options *options, svo_compact_info *info);

/** Makes a compact tree on a device and waits for it. Its arrays are the same bytes on every device.
 *
 * \param device the tree's, or, for a tree that is on the host alone, any; must outlive the compact tree
 * \param tree complete, on the device or with host arrays, with at most 2^31 - 1 inner nodes; it stays as it is
 * \param options NULL means all defaults
 * \param queue on the device's context; NULL: the device's own
 * \param out receives the compact tree
 * \returns SVO_INVALID_ARGUMENT, SVO_UNSUPPORTED (more inner nodes, 2^32 words of records, or in SVO_FORM_MIRRORED 2^29
 *          half words of them), SVO_OUT_OF_HOST_MEMORY, SVO_OUT_OF_DEVICE_MEMORY, SVO_COMPILE_FAILED or SVO_CL_ERROR
 *          on failure. */
SVO_API svo_status svo_compact_create(svo_device *device, const svo_tree *tree, const svo_compact_options *options,
                                      cl_command_queue queue, svo_compact **out);

/** Makes a tree without leaf lists from a compact tree and waits for it. It has the voxels of the tree that the compact
 *  tree was made from, and its payload as far as that is carried and unless tolerances changed it: the same
 *  SVO_HASH_NODES, and without leaf lists the same SVO_HASH_ALL. A leaf above level depth becomes all of its voxels and
 *  the nodes above them, each with the leaf's payload; after minimizing, fills of these nodes alone may differ.
 *
 * \param compact on a device
 * \param queue on the device's context; NULL: the device's own
 * \param out receives the tree, which is on that device
 * \returns SVO_INVALID_ARGUMENT, SVO_UNSUPPORTED (the tree would have more than 2^32 - 2 nodes),
 *          SVO_OUT_OF_HOST_MEMORY, SVO_OUT_OF_DEVICE_MEMORY, SVO_COMPILE_FAILED or SVO_CL_ERROR on failure. */
SVO_API svo_status svo_compact_expand(svo_compact *compact, cl_command_queue queue, svo_tree **out);

/** What is packed, and how much may change. All zero: all payload, exactly. */
typedef struct svo_pack_options {
    size_t struct_size; /**< sizeof(svo_pack_options) */
    uint32_t leave_out; /**< svo_need bits: payload that stays as it is */
    uint32_t color_error; /**< most that red, green and blue may change, 0 .. 255; alpha never changes */
    /** 0: normals are exact. 4 .. 8: they become octahedral, with so many bits for each of two numbers, and eight for
     *  the length; svo_compact_info.largest_error tells what that changed. */
    uint32_t normal_bits;
    uint32_t fill_error; /**< most that fills may change, 0 .. 65535 */
} svo_pack_options;

/** All defaults. */
#define SVO_PACK_OPTIONS_INIT SVO_STRUCT_INIT(svo_pack_options)

/** Makes a compact tree with packed payload of another one, on the host, and waits. Arrays that are constant, packed
 *  already, or would not get smaller are those of the other; on a device the two then have one buffer. Packed arrays
 *  are the same bytes on every machine. Pictures have the bytes that the expanded tree's have, and so have those of
 *  scenes.
 *
 * \param compact on a device, or else with host arrays; it stays as it is
 * \param options NULL means all defaults
 * \param queue on the device's context; NULL: the device's own; of no meaning without a device
 * \param out receives the compact tree, on the device alone, or else with host arrays alone
 * \returns SVO_INVALID_ARGUMENT, SVO_UNSUPPORTED (an array would take 2^32 words), SVO_OUT_OF_HOST_MEMORY,
 *          SVO_OUT_OF_DEVICE_MEMORY or SVO_CL_ERROR on failure. */
SVO_API svo_status svo_compact_pack(const svo_compact *compact, const svo_pack_options *options, cl_command_queue queue,
                                    svo_compact **out);

/** Reads payload of a compact tree on the host, packed or not. Constant payload is given for each element.
 *
 * \param compact with host arrays
 * \param buffer a payload array that is held
 * \param first the place of the first element
 * \param count how many; first + count is at most svo_compact_info.payload_count
 * \param elements receives them: 4 u8 of colors, 3 i16 of normals, u16 of materials or fills each; NULL if count is 0
 * \returns SVO_INVALID_ARGUMENT on failure. */
SVO_API svo_status svo_compact_read_payload(const svo_compact *compact, svo_compact_buffer buffer, uint64_t first,
                                            uint64_t count, void *elements);

/** Destroys a compact tree.
 *
 * \param compact set to NULL; NULL and a pointer to NULL are allowed */
SVO_API void svo_compact_destroy(svo_compact **compact);

/** Describes a compact tree.
 *
 * \param compact not NULL
 * \param info receives the description
 * \returns SVO_INVALID_ARGUMENT when info is NULL or its struct_size is too small. */
SVO_API svo_status svo_compact_get_info(const svo_compact *compact, svo_compact_info *info);

/** A device buffer of the compact tree.
 *
 * \param compact not NULL
 * \param buffer which one
 * \returns the buffer, which belongs to the compact tree; NULL where it does not hold it or is not on a device. Retain
 *          it (clRetainMemObject) to keep it longer. */
SVO_API cl_mem svo_compact_get_buffer(const svo_compact *compact, svo_compact_buffer buffer);

/** Copies the arrays to the host. The first call copies; later calls do nothing.
 *
 * \param compact not NULL
 * \param queue on the context of its device; NULL: the device's own
 * \returns SVO_INVALID_ARGUMENT, SVO_CL_ERROR or SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_compact_download(svo_compact *compact, cl_command_queue queue);

/** Copies the arrays of a compact tree from a file to a device and waits. The first call copies; later calls do
 *  nothing.
 *
 * \param compact with host arrays, not on another device
 * \param device must outlive the compact tree
 * \param queue on the device's context; NULL: the device's own
 * \returns SVO_INVALID_ARGUMENT, SVO_CL_ERROR or SVO_OUT_OF_DEVICE_MEMORY on failure. */
SVO_API svo_status svo_compact_upload(svo_compact *compact, svo_device *device, cl_command_queue queue);

/** The host arrays.
 *
 * \param compact not NULL
 * \param arrays receives the pointers; all NULL before svo_compact_download, unless the compact tree is from a file
 * \returns SVO_INVALID_ARGUMENT when arrays is NULL or its struct_size is too small. */
SVO_API svo_status svo_compact_get_arrays(const svo_compact *compact, svo_compact_arrays *arrays);

/** Hashes a compact tree with XXH3-128: u32 form, directory_step_log2, depth, coverage, and 0, or snap_bits where
 *  is_exact is 0; f64 origin[3], edge; u32 payload_level; then each array in the order of svo_compact_buffer, its
 *  length in bytes as u64 before its elements; length 0 where it is not held. Little-endian, seed 0. The hash does not
 *  depend on device or time.
 *
 * \param compact with host arrays
 * \param text receives 32 lowercase hexadecimal digits, the high half first
 * \returns SVO_INVALID_ARGUMENT (no host arrays) on failure. */
SVO_API svo_status svo_compact_hash(const svo_compact *compact, char text[SVO_HASH_TEXT_BYTES]);

/** Number of kernel arguments that SVO_TREE_PARAMETERS declares with the options of a compact tree. */
#define SVO_COMPACT_ARGUMENTS 4u

/** A compact tree as a target: svo_render, svo_trace_voxels, svo_camera_fit and kernels of the caller's.
 *
 * Hits have the level, face, normal, t and cell of those against the built tree. svo_voxel_hit.node is the place of the
 * node's payload. It is SVO_NO_NODE for a node above payload_level; t tells whether there is a hit. Where all payload
 * is constant or not held it is the node's breadth-first index in SVO_FORM_IMPLIED, and 0 in other forms. Rays through
 * a minimized tree may stop at a leaf above level depth.
 *
 * Its pictures are the same bytes as those of the tree that it was made from. svo_kernel_source is that of trees, which
 * declares the same for a compact tree when it is compiled with its svo_kernel_options, but for triangles and
 * svo_find_node. These differ by form, directory step and whether there are places. svo_node.index is a place, as
 * svo_voxel_hit.node is in hits; svo_find_cell and svo_find_point stop at leaves above the level and return true there.
 *
 * \param compact NULL: calls are refused, but svo_kernel_source answers
 * \returns the target. */
SVO_API svo_target svo_compact_target(svo_compact *compact);

#ifdef __cplusplus
}
#endif

#endif
