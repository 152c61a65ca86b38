/* SPDX-License-Identifier: MIT */
/** \file
 * Files (svocl::io): trees as .svo; meshes from OBJ, PLY, STL, OFF, glTF, and from what assimp knows. It includes
 * files.h, which says where files are, and voxel_files.h, whose subject is voxels.
 *
 * The .svo format, version 4. All numbers are little-endian; offsets are bytes from the start of the file.
 *
 *     offset bytes
 *     0      8     magic: 89 53 56 4F 0D 0A 1A 0A  ("\x89SVO\r\n\x1a\n")
 *     8      4     u32 version: 4; files of versions 1 to 3 are still read
 *     12     4     u32 header_bytes: offset of the first byte after the chunk table
 *     16     8     u64 file_bytes: length of the whole file
 *     24     8     u64 XXH3-64 over bytes 32 .. header_bytes
 *     32     4     u32 chunk_count
 *     36     4     u32 depth
 *     40     4     u32 snap_bits: 20 .. 24
 *     44     4     u32 coverage: 0 half-open, 1 closed, 2 thin
 *     48     2     u16 need: bit 0 color, bit 1 normal, bit 2 lists and geometry, bit 3 material, bit 4 fill, bit 5
 *                  areas
 *     50     2     u16 constant: of those bits, color, normal and material that are the same in all nodes: one element
 *     52     2     u16 weights: 0 area, 1 uniform, 2 center
 *     54     2     u16 payload_level: 0 .. depth
 *     56     24    f64 origin[3]
 *     80     8     f64 edge
 *     88     8     f64 scale
 *     96     8     u64 reserved: 0; files that svocl wrote before have any value
 *     104    8     u64 triangles
 *     112    8     u64 refused_triangles
 *     120    8     u64 fragments
 *     128    72    u32 level_begin[18], entries after depth + 1 are 0
 *     200    40 *  chunk table: one entry per chunk
 *
 *     chunk entry
 *     0      2     u16 kind: svo_tree_buffer's value
 *     2      2     u16 level: whose nodes the elements belong to
 *     4      4     u32 codec: 0 stored, 1 zstd frame
 *     8      8     u64 offset
 *     16     8     u64 stored_bytes
 *     24     8     u64 plain_bytes
 *     32     8     u64 XXH3-64 over the uncompressed bytes
 *
 * Chunks lie back to back, the first at header_bytes, in ascending level, and within a level in ascending kind. So the
 * levels above any level are one piece at the beginning of the file. A chunk holds the elements of svo_tree_arrays that
 * belong to the nodes of its level:
 *
 *     array                               levels
 *     child_mask                          0 .. depth - 1
 *     colors, normals, materials, fills   payload_level .. depth; if constant, one element at payload_level
 *     all others                          depth
 *
 * first_child is not in the file: a node's children begin where those of the node before it end, from node 1 on.
 * plain_bytes follows from the header's counts and the array's element size; that of list, vertices and indices gives
 * their count. child_mask is always present. positions or positions_double is there with need's bit 2, unless coverage
 * is thin; its used vertices round to those of vertices. A zstd chunk has at least 4 bytes per 128 KiB of plain_bytes,
 * as zstd itself ensures.
 *
 * Version 3 has the same layout. Its voxels and lists are not those of the mesh as it was given, but of vertices, to
 * which it was rounded: to the nearest unit, where version 4 rounds to odd (svo_tree_info.is_exact). Trees of such
 * files, and of older ones, are saved in version 3 again.
 *
 * In version 2 a chunk is a whole array, its level is 0, and first_child is there as well, of every node, also of the
 * empty tree's root (1). Version 1 has, besides, no positions. Trees of such files, and files that are made of those,
 * are without them: rays meet the rounded mesh (svo_tree_info.positions).
 *
 * Files of compact trees (compact.h) differ in this: the magic is 89 53 56 43 0D 0A 1A 0A ("\x89SVC\r\n\x1a\n"). The
 * version is 3 with packed payload, else 2, or 1 where svo_compact_info.is_exact is 0, as it is for all files that
 * svocl wrote before; the layout is the same. A packed array has the length that its head says (compact.h).
 * need has payload alone. level_begin counts inner nodes: level l has level_begin[l + 1] - level_begin[l] of them,
 * level depth none. The kind of a chunk is a svo_compact_buffer, in ascending order, where the array is held,
 * and its level is 0. Before them there is one chunk of kind 64:
 *
 *     offset bytes
 *     0      4     u32 form: svo_form
 *     4      4     u32 minimized: 0 or 1
 *     8      4     u32 directory_step_log2: 4 .. 6 with SVO_FORM_IMPLIED, else 0
 *     12     4     u32 packed: svo_need bits; bit 31 where is_exact is 0; 0 before version 3
 *     16     8     u64 stored_count
 *     24     8     u64 far_count
 *     32     8     u64 shared_count
 *     40     72    u32 level_leaf[18], entries after depth are 0
 *
 * Files of lights (light.h) have the magic 89 53 56 4C 0D 0A 1A 0A ("\x89SVL\r\n\x1a\n"), version 1, or 2 with a map of
 * the sky, 3 with chunk 68, and the header of their tree. The first chunk, of kind 64, says what the light is:
 *
 *     offset bytes
 *     0      32    hash of the tree, svo_tree_hash with SVO_HASH_ALL: hexadecimal digits
 *     32     4     u32 form: svo_light_form
 *     36     4     u32 opacity: svo_opacity
 *     40     8     u32 one_side, has_setup: 0 or 1; without a setup all that follows is 0
 *     48     4     f32 radiance of a unit
 *     52     12    f32 sky[3]
 *     64     16    u32 view_resolution, diagnose, no_photons, updatable: of svo_light_setup
 *     80     16    u64 source_count, finish_count
 *     96     40    u64 photons, photon_hits, lit_leaves, lit_nodes, missed_leaves: of svo_light_info
 *     136    32    f64 flux[3], lost_flux
 *
 * Then come chunks of kind 65, the svo_light_source as given, 66, the svo_finish, and of each svo_light_buffer, in
 * ascending order; those of no bytes are left out. From version 2 on a chunk of kind 67 may follow the finishes:
 * u32 sky_width, u32 sky_height, and the texels of the map of the sky, three f32 each. In files of version 3 one of
 * kind 68 follows these: u32 emission_photons, bounces, photon_alpha (0 or 1) of svo_light_setup, u32 0. All levels in
 * the table of chunks are 0.
 */
#ifndef SVOCL_IO_H
#define SVOCL_IO_H

#include <stddef.h>
#include <stdint.h>

#include "svocl/compact.h"
#include "svocl/files.h"
#include "svocl/light.h"
#include "svocl/mesh.h"
#include "svocl/status.h"
#include "svocl/tree.h"
#include "svocl/voxel_files.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Options of a saved tree. */
typedef struct svo_save_options {
    size_t struct_size; /**< sizeof(svo_save_options) */
    uint32_t compress; /**< not 0: zstd for each chunk that becomes smaller */
} svo_save_options;

/** All defaults. */
#define SVO_SAVE_OPTIONS_INIT SVO_STRUCT_INIT(svo_save_options)

/** Writes a .svo file (see files.h). With compression, the compressed chunks are in memory until they are written.
 *
 * \param tree with host arrays (svo_tree_download)
 * \param sink receives the file
 * \param options NULL means all defaults: not compressed
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_FILE_ERROR, SVO_INVALID_ARGUMENT or SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_tree_save(const svo_tree *tree, svo_sink sink, const svo_save_options *options,
                                 svo_message *message);

/** Options of a tree that is loaded. */
typedef struct svo_load_options {
    size_t struct_size; /**< sizeof(svo_load_options) */
    const svo_memory_callbacks *memory; /**< host memory of the tree, for its whole life; NULL: malloc and free */
    /** A tree of more voxels, its nodes on all levels, is refused before there is memory for it: a small file may
     *  unfold to any size. 0: as many as take half the memory that the machine, the process's limit of address space
     *  and its control group allow. Of a compact tree its stored nodes count. */
    uint64_t voxels_max;
    /** 1 .. the depth of the file: the upper levels alone, a tree of that depth; 0: all. Of files since version 3 the
     *  levels below are not read; older ones are read whole and shortened. Compact trees are read whole.
     *
     *  The nodes of last_level are the tree's leaves. It has the file's colors, normals, materials and fills, unless
     *  their payload_level is below last_level, and neither lists nor geometry nor areas, so rays meet its voxels
     *  (svo_trace_voxel). Counts of triangles and fragments are the whole tree's. With the depth of the file it is the
     *  whole tree, with all that it has. */
    uint32_t last_level;
    uint32_t reserved; /**< 0 */
} svo_load_options;

/** All defaults. */
#define SVO_LOAD_OPTIONS_INIT SVO_STRUCT_INIT(svo_load_options)

/** Reads a .svo file into host arrays. Lengths, checksums and every index are checked: a tree that loads is well
 *  formed. Nothing larger than the file is allocated before the header is checked.
 *
 * \param source the file
 * \param options NULL means all defaults
 * \param out receives the tree
 * \param message receives what is wrong and where; NULL allowed
 * \returns SVO_FILE_ERROR (cannot be read), SVO_FILE_DAMAGED, SVO_INVALID_ARGUMENT (also more voxels than voxels_max,
 *          or a last_level that the file does not have) or SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_tree_load(svo_source source, const svo_load_options *options, svo_tree **out,
                                 svo_message *message);

/** Writes a file of a compact tree, as svo_tree_save writes one of a tree.
 *
 * \param compact with host arrays (svo_compact_download)
 * \param sink receives the file
 * \param options NULL means all defaults: not compressed
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_FILE_ERROR, SVO_INVALID_ARGUMENT or SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_compact_save(const svo_compact *compact, svo_sink sink, const svo_save_options *options,
                                    svo_message *message);

/** Reads such a file into host arrays. Lengths, checksums and every node are checked. Nothing larger than the file is
 *  allocated before the header is checked.
 *
 * \param source the file
 * \param options NULL means all defaults; last_level is 0
 * \param out receives the compact tree
 * \param message receives what is wrong and where; NULL allowed
 * \returns SVO_FILE_ERROR (cannot be read), SVO_FILE_DAMAGED, SVO_INVALID_ARGUMENT (also more voxels than voxels_max)
 *          or SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_compact_load(svo_source source, const svo_load_options *options, svo_compact **out,
                                    svo_message *message);

/** Writes a file of a light, as svo_tree_save writes one of a tree: opacity, radiance and what lights the tree, but not
 *  the photons that svo_light_setup.updatable keeps.
 *
 * \param light of a tree with host arrays, whose hash the file has; not one of svo_light_options.no_cones
 * \param sink receives the file
 * \param options NULL means all defaults: not compressed
 * \param queue on the context of the light's device; NULL: the device's own
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_FILE_ERROR, SVO_INVALID_ARGUMENT, SVO_OUT_OF_HOST_MEMORY or SVO_CL_ERROR on failure. */
SVO_API svo_status svo_light_save(const svo_light *light, svo_sink sink, const svo_save_options *options,
                                  cl_command_queue queue, svo_message *message);

/** Reads such a file. The light has the hash of the one that was saved, and gives the same pictures. Its first
 *  svo_light_update shoots all photons. Lengths, checksums and places are checked.
 *
 * \param tree on a device, with host arrays; must outlive the light
 * \param source the file
 * \param options NULL means all defaults; last_level is 0
 * \param queue on the context of the tree's device; NULL: the device's own
 * \param out receives the light
 * \param message receives what is wrong and where; NULL allowed
 * \returns SVO_FILE_ERROR (cannot be read), SVO_FILE_DAMAGED, SVO_INVALID_ARGUMENT (the light of another tree),
 *          SVO_NOT_ON_DEVICE, SVO_OUT_OF_HOST_MEMORY, SVO_OUT_OF_DEVICE_MEMORY or SVO_CL_ERROR on failure. */
SVO_API svo_status svo_light_load(svo_tree *tree, svo_source source, const svo_load_options *options,
                                  cl_command_queue queue, svo_light **out, svo_message *message);

/** Is asked while a mesh file is read, ten times a second or more often, on the thread that called the library.
 *
 * \param user progress_user of the import's options
 * \param byte_count of the mesh so far that the child has sent: 0 until it has read the file
 * \returns 0 to go on. Else the child is killed, and the import ends with SVO_CANCELED. */
typedef int (*svo_import_progress_callback)(void *user, uint64_t byte_count);

/** Options of an import. */
typedef struct svo_import_options {
    size_t struct_size; /**< sizeof(svo_import_options) */
    /** Address space of the child process. 0: 1 GiB, 64 bytes for each of the file and of the files that it names, and
     *  16 for each of the texels of its textures and of the corners of meshes that it draws many times, for these 8 GiB
     *  at most. A limit of the calling process (RLIMIT_AS) that is lower holds too, and what exceeds it is
     *  SVO_OUT_OF_HOST_MEMORY; what exceeds this one is SVO_IMPORT_FAILED. */
    uint64_t memory_limit_bytes;
    uint32_t time_limit_seconds; /**< wall clock, of all; 0: 5 s, and 1 s for each 10^6 bytes of the file, of the
                                      files that it names, and of the texels of its textures */
    const char *child_program; /**< a program that calls svo_import_child_main first; "/proc/self/exe" is the caller.
                                    NULL: the installed helper (svo_import_helper) */
    uint32_t strict; /**< not 0: what would be a warning is an error */
    /** Host memory of the import in this process; NULL: malloc and free. The child process has its own, by malloc, up
     *  to memory_limit_bytes. */
    const svo_memory_callbacks *memory;
    svo_import_progress_callback progress; /**< NULL allowed */
    void *progress_user; /**< passed to progress */
    /** An svo_axes: which axis is up in the file. SVO_AXES_Z_UP turns (x, y, z) to (x, z, -y), normals too; else
     *  nothing is turned but what the file itself asks for, as COLLADA does. */
    uint32_t axes;
    uint32_t normal_maps; /**< not 0: the mesh has the normal maps of its materials, and their textures; see
                               svo_import_file */
    /** 0 or more, in the mesh's units; 0: positions stay as they are. Vertices are taken in their order: one that lies
     *  no farther than this from an earlier one that stayed gets the position of the first of these, else it stays. So
     *  cracks close, and with them a mesh for projected areas. Attributes, indices and triangles stay, also triangles
     *  that become a segment or a point. */
    double weld;
} svo_import_options;

/** All defaults. */
#define SVO_IMPORT_OPTIONS_INIT SVO_STRUCT_INIT(svo_import_options)

/** What a file declares and what was read. */
typedef struct svo_import_info {
    size_t struct_size; /**< sizeof(svo_import_info) */
    const char *reader; /**< "obj", "ply", "stl", "off" or "gltf": the library's own; "assimp". A static string */
    uint64_t declared_vertices; /**< vertices in the file, or by its header; 0 for glTF and with assimp, as the next
                                     three */
    uint64_t used_vertices; /**< of those, the ones that a triangle has */
    uint64_t declared_faces; /**< faces in the file, or by its header; each triangle of a strip counts */
    uint64_t read_faces; /**< of those, the ones that became triangles */
    uint64_t triangles; /**< in the mesh */
    uint64_t warnings; /**< given to the log callback */
    uint64_t welded_vertices; /**< of the mesh, that svo_import_options.weld moved */
} svo_import_info;

/** All zero. */
#define SVO_IMPORT_INFO_INIT SVO_STRUCT_INIT(svo_import_info)

/** A mesh from a file, with its arrays. */
typedef struct svo_import svo_import;

/** Reads a mesh file in a child process with limits on memory and time, so that a reader that crashes or hangs ends in
 *  an error. OBJ with MTL, PLY, STL and OFF have readers of the library's own: every number of a text becomes the
 *  nearest float, whatever the locale, and a damaged file is an error that names the line or byte, the value and the
 *  limit. So has glTF 2.0, with KHR_mesh_quantization, EXT_mesh_gpu_instancing and KHR_texture_transform; a file that
 *  requires another extension is refused. What else assimp knows is read by assimp. Transforms of nodes are applied.
 *  Polygons are triangulated. Linear colors, as glTF has them, become sRGB.
 *
 *  With svo_import_options.normal_maps, materials have what glTF names normalTexture, MTL norm, bump or map_bump with
 *  -bm, and what assimp calls normals or height. An image of bump is a normal map where nine tenths of its texels are
 *  unit vectors out of the surface; else it is a height, of which white is two texels above black. A map that lies
 *  otherwise on the surface than the color's texture is left out, with a warning.
 *
 *  What a file declares and is not in the mesh is a warning: vertices of no face, points, lines, elements and
 *  statements that are not read, textures that cannot be read (white is used), indices of vertices that do not exist
 *  (PLY, glTF; a build refuses such triangles and counts them), extensions of glTF that change what is seen.
 *  svo_import_options.strict makes them errors.
 *
 * \param path of the file
 * \param options NULL means all defaults
 * \param log receives warnings; NULL allowed
 * \param log_user passed to log
 * \param out receives the mesh
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_FILE_ERROR (missing, unreadable), SVO_IMPORT_FAILED (not understood, no triangle, a crash, a limit, a
 *          warning of a strict import, no helper), SVO_INVALID_ARGUMENT (an option out of range), SVO_CANCELED (the
 *          progress callback) or SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_import_file(const char *path, const svo_import_options *options, svo_log_callback log,
                                   void *log_user, svo_import **out, svo_message *message);

/** Finds the helper program that imports run by default: svocl-import, in libexec/svocl of the installation that the
 *  library's file belongs to (the program's file, where the library is static), else where the library was built to be
 *  installed. Without one, a program may import through itself: svo_import_child_main.
 *
 * \param path receives the program's path
 * \param path_bytes its size
 * \param message receives where it was looked for; NULL allowed
 * \returns SVO_FILE_ERROR (there is no such program, or path is too small) or SVO_INVALID_ARGUMENT on failure. */
SVO_API svo_status svo_import_helper(char *path, size_t path_bytes, svo_message *message);

/** Counts of an import.
 *
 * \param import not NULL
 * \param info filled in; its struct_size is set by the caller
 * \returns SVO_INVALID_ARGUMENT on failure. */
SVO_API svo_status svo_import_get_info(const svo_import *import, svo_import_info *info);

/** The mesh of an import.
 *
 * \param import not NULL
 * \returns the mesh; lives as long as import. */
SVO_API const svo_mesh *svo_import_mesh(const svo_import *import);

#define SVO_NO_VERTEX UINT32_MAX /**< a vertex of a file that no face has */

/** Which vertex of the mesh each vertex of the file is. The mesh has corners that are equal in all attributes once, and
 *  leaves out vertices that no face has; so what is computed at its vertices comes back to the file by this map.
 *
 * \param import not NULL
 * \param vertex_count receives how many vertices the file has; 0 where the result is NULL
 * \returns for each vertex of a PLY or OFF file, and for each "v" of an OBJ file, in their order, the index of one of
 *          the mesh's vertices that lie there (several differ in normal or texture coordinates), or SVO_NO_VERTEX. NULL
 *          for other formats. Positions of svo_import_options.weld and axes are those of the mesh. Lives as long as
 *          import. */
SVO_API const uint32_t *svo_import_file_vertices(const svo_import *import, size_t *vertex_count);

/** The files besides the mesh file that an import opened: material libraries, textures, buffers. So a program that
 *  writes files can spare those that its mesh is made of.
 *
 * \param import not NULL
 * \param index from 0 on
 * \returns the path, from where the program runs or absolute, each once; NULL past the last. Lives as long as
 *          import. */
SVO_API const char *svo_import_file_path(const svo_import *import, size_t index);

/** Frees a mesh.
 *
 * \param import set to NULL; NULL and a pointer to NULL are allowed */
SVO_API void svo_import_destroy(svo_import **import);

/** Formats of mesh files that are written. */
typedef enum svo_mesh_format {
    SVO_MESH_FORMAT_AUTO = 0, /**< by the suffix of the path, in any case */
    SVO_MESH_FORMAT_PLY = 1, /**< binary, little-endian: normals, RGBA8 colors */
    SVO_MESH_FORMAT_OBJ = 2, /**< normals; colors after positions, without alpha */
    SVO_MESH_FORMAT_GLB = 3 /**< glTF 2.0, binary: unit normals; colors as linear light, 16 bits */
} svo_mesh_format;

/** The format of a mesh file by the suffix of its name.
 *
 * \param path may be NULL
 * \returns the format; SVO_MESH_FORMAT_AUTO for another suffix, and for NULL. */
SVO_API svo_mesh_format svo_mesh_format_of_path(const char *path);

/** Writes a mesh as a file: positions, triangles and, where it has them, normals and colors, taken as sRGB. In .glb a
 *  normal of length 0 becomes 0, 0, 1, and alpha below 255 makes the material blend. svo_import_file gives the same
 *  positions, triangles and colors back.
 *
 * \param mesh not NULL: float positions, finite; at least a triangle, whose vertices are there; no materials and no
 *        textures. Texture coordinates are not written
 * \param sink where it is written to
 * \param format AUTO: by the suffix of the path
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_INVALID_ARGUMENT (mesh, format), SVO_UNSUPPORTED (a mesh with materials, textures or double positions; a
 *          .glb file of 4 GiB or more) or SVO_FILE_ERROR on failure. */
SVO_API svo_status svo_mesh_save(const svo_mesh *mesh, svo_sink sink, svo_mesh_format format, svo_message *message);

/** Does the work of an import's child process. A program that imports through itself calls this first in main().
 *
 * \param argc of main
 * \param argv of main
 * \param exit_code receives the code to exit with
 * \returns 1 when the process is such a child, whose work is done now; 0 when it is not, and nothing happened. */
SVO_API int svo_import_child_main(int argc, char **argv, int *exit_code);

#ifdef __cplusplus
}
#endif

#endif
