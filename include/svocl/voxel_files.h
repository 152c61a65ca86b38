/* SPDX-License-Identifier: MIT */
/** \file
 * Voxel files (svocl::io): .vox, .svx, .binvox, .nvdb, .vdb and .bt to lists of voxels and back, points as .ply, cubes
 * as .obj.
 *
 *     format    read  write  holds
 *     .vox      yes   yes    MagicaVoxel, versions 150 and 200: models, a scene of them, 255 colors, materials
 *     .vox      yes   no     SLAB6: a grid of indices into 255 colors. Has no mark: judged by its length
 *     .svx      yes   yes    Shapeways: slices as PNG images in a zip archive. Needs libzip and expat
 *     .binvox   yes   yes    occupancy, run by run
 *     .nvdb     yes   yes    NanoVDB, version 32: occupancy, RGBA8 colors, materials. Needs NanoVDB's header to build
 *     .vdb      yes   yes    OpenVDB, version 224: the same, colors in linear light. Needs zlib; of others BLOSC
 *     .bt       yes   yes    OctoMap: occupancy, with the width of voxels
 *     .ply      no    yes    a point at the center of each voxel, with color and material; or rectangles
 *     .obj      no    yes    the faces between voxels and what is empty, with colors; or rectangles
 *
 * Files are not trusted. Every length is checked against the file, and every count against its limit, before memory is
 * allocated for it. What is damaged is refused with SVO_FILE_DAMAGED and a message that names the file, the part of it
 * and the byte.
 */
#ifndef SVOCL_VOXEL_FILES_H
#define SVOCL_VOXEL_FILES_H

#include <stddef.h>
#include <stdint.h>

#include "svocl/files.h"
#include "svocl/memory.h"
#include "svocl/sdf.h"
#include "svocl/status.h"
#include "svocl/voxels.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SVO_VOXEL_INSTANCES_MAX 0x100000 /**< most models that a scene places */

/** The formats of voxel files. */
typedef enum svo_voxel_format {
    SVO_VOXEL_FORMAT_AUTO = 0, /**< by the bytes of a file to read; by the suffix of one to write */
    SVO_VOXEL_FORMAT_VOX, /**< "vox" */
    SVO_VOXEL_FORMAT_SVX, /**< "svx" */
    SVO_VOXEL_FORMAT_BINVOX, /**< "binvox" */
    SVO_VOXEL_FORMAT_PLY, /**< "ply": is only written */
    SVO_VOXEL_FORMAT_OBJ, /**< "obj": is only written */
    SVO_VOXEL_FORMAT_NVDB, /**< "nvdb" */
    SVO_VOXEL_FORMAT_SLAB6, /**< "slab6": is only read; its files end in .vox too */
    SVO_VOXEL_FORMAT_BT, /**< "bt" */
    SVO_VOXEL_FORMAT_LAS, /**< "las": points, which svo_points_load reads (points.h) */
    SVO_VOXEL_FORMAT_LAZ, /**< "laz": compressed points, which are not read */
    SVO_VOXEL_FORMAT_VDB /**< "vdb" */
} svo_voxel_format;

/** The format that a file is written in by its suffix, in upper or lower case.
 *
 * \param path of the file
 * \returns the format; SVO_VOXEL_FORMAT_AUTO for other suffixes and for NULL. */
SVO_API svo_voxel_format svo_voxel_format_of_path(const char *path);

/** What to read. */
typedef struct svo_voxels_load_options {
    size_t struct_size; /**< sizeof(svo_voxels_load_options) */
    uint32_t hidden; /**< .vox: not 0: what hidden layers and nodes hold is read too */
    /** .vox: the frame. Of nodes with frames, the last one that begins at this frame or earlier is taken. In a file
     *  without a scene it is the number of the model, from 0 on. */
    uint32_t frame;
    /** More voxels, before those in one place become one, are refused before there is memory for them; 0: one for each
     *  200 bytes of memory that the machine, the process's limit of address space and its control group allow, which a
     *  build of them needs. At most SVO_VOXELS_MAX. */
    uint64_t voxels_max;
    svo_log_callback log; /**< receives warnings of what is not read; NULL: nothing is called */
    void *log_user; /**< passed to log */
    /** Host memory of the reading and of the list, for its whole life; NULL: malloc and free. libzip, expat and
     *  stb_image, which read .svx files, and libblosc have their own, by malloc. */
    const svo_memory_callbacks *memory;
    uint32_t axes; /**< an svo_axes: which axis is up in the file. In the list it is y, but for SVO_AXES_KEEP */
    uint32_t reserved; /**< 0 */
} svo_voxels_load_options;

/** All defaults. */
#define SVO_VOXELS_LOAD_OPTIONS_INIT SVO_STRUCT_INIT(svo_voxels_load_options)

/** What a file holds. */
typedef struct svo_voxel_file_info {
    size_t struct_size; /**< sizeof(svo_voxel_file_info) */
    uint32_t format; /**< svo_voxel_format */
    uint32_t version; /**< .vox: 150 or 200; .binvox: 1 or 2; .nvdb: 32; .vdb: 222 to 225; .svx: 0 */
    uint64_t models; /**< .vox: models in the file; else 1 */
    uint64_t instances; /**< models placed */
    uint64_t rotated_instances; /**< of those, with a rotation or a mirror */
    uint64_t hidden_instances; /**< left out since they or their layer are hidden */
    uint64_t instance_voxels; /**< voxels of all instances */
    uint64_t warnings; /**< given to the log callback */
    uint64_t left_out_models; /**< .vox: models that no instance places: of other frames, hidden, or unused */
    uint64_t left_out_frames; /**< .vox: frames of nodes besides the one taken of each */
    uint64_t names; /**< .vox: of nodes and layers */
    uint64_t layers; /**< .vox: chunks LAYR */
    uint64_t groups; /**< .vox: chunks nGRP */
    uint64_t cameras; /**< .vox: chunks rCAM */
    uint64_t render_settings; /**< .vox: chunks rOBJ */
    uint64_t notes; /**< .vox: chunks NOTE */
    uint64_t palette_orders; /**< .vox: chunks IMAP */
    uint64_t unused_colors; /**< .vox with a palette: entries that no voxel of any model has */
    uint64_t other_chunks; /**< .vox: chunks of other kinds, which are not read */
} svo_voxel_file_info;

/** All zero. */
#define SVO_VOXEL_FILE_INFO_INIT SVO_STRUCT_INIT(svo_voxel_file_info)

/** Reads a .vox, .svx, .binvox, .nvdb, .vdb or .bt file; its bytes say which. docs/voxel_files.md says what becomes of
 *  each part. svo_voxels_left_out says what the list lacks.
 *
 * \param source the file
 * \param options NULL means all defaults
 * \param out receives the list
 * \param info receives what the file holds; NULL allowed
 * \param message receives what is wrong and where; NULL allowed
 * \returns SVO_FILE_ERROR (cannot be read), SVO_FILE_DAMAGED, SVO_UNSUPPORTED (a file that Teardown compressed; a
 *          .svx file, and the library was built without libzip or expat; a .nvdb file that is packed or of another
 *          version, or the library was built without NanoVDB's header; a .vdb file of another version or compression,
 *          whose map turns voxels, with no grid that is read, or the library was built without zlib),
 *          SVO_INVALID_ARGUMENT (no such frame, too many voxels, memory is not valid) or SVO_OUT_OF_HOST_MEMORY on
 *          failure. */
SVO_API svo_status svo_voxels_load(svo_source source, const svo_voxels_load_options *options, svo_voxels **out,
                                   svo_voxel_file_info *info, svo_message *message);

/** Says what a file holds and a list of its voxels does not: which instance a voxel is of, other models and frames,
 *  hidden ones, names, layers, groups, cameras, settings, notes, the palette's order and unused colors, other chunks.
 *
 * \param info that svo_voxels_load filled; not NULL
 * \param text receives it in one line without the file's name, such as "the division into 3 instances, 8 layers, 1
 *        group"; empty where nothing is left out
 * \returns SVO_INVALID_ARGUMENT when info or text is NULL or the struct_size is too small. */
SVO_API svo_status svo_voxels_left_out(const svo_voxel_file_info *info, svo_message *text);

/** Writes a .vox file again with everything that it holds, after the checks of svo_voxels_load: models, instances,
 *  rotations, names, layers, groups, all frames, the palette with its order, materials, cameras, settings, notes. The
 *  contents of chunks, those of other kinds too, are the same bytes in the same order.
 *
 * \param source a .vox file of MagicaVoxel
 * \param sink receives the file; nothing is written of one that is refused
 * \param options as for svo_voxels_load. voxels_max limits the voxels of all instances; 0: they may be any number, for
 *        no list is made. hidden and frame select what info counts, nothing else. NULL means all defaults
 * \param info receives what the file holds; NULL allowed
 * \param message receives what is wrong and where; NULL allowed
 * \returns what svo_voxels_load returns. SVO_UNSUPPORTED also for a voxel file of another format. */
SVO_API svo_status svo_voxels_copy_vox(svo_source source, svo_sink sink, const svo_voxels_load_options *options,
                                       svo_voxel_file_info *info, svo_message *message);

/** A model of a .vox file, and where its scene places it. */
typedef struct svo_voxel_part {
    size_t struct_size; /**< sizeof(svo_voxel_part) */
    uint64_t model; /**< its number in the file, from 0 on */
    const svo_voxels *voxels; /**< around the origin, as turned as the list of the file; at least one voxel */
    /** 3 x 4 matrices, row by row: where (x, y, z) of the list is in the list of the file. Rows have one 1 or -1 and a
     *  whole number, so that voxels come to lie on voxels. */
    const double *transforms;
    uint64_t transform_count; /**< at least 1 */
} svo_voxel_part;

/** Receives parts. user: as given. part: borrowed for the call, with all that it has. Returns SVO_OK; another status
 *  ends the reading and is what it returns. */
typedef svo_status (*svo_voxel_part_callback)(void *user, const svo_voxel_part *part);

/** Reads a .vox file by its models, not as one list: each that has voxels and that the scene places, once, with where
 *  it is placed. Put together by the matrices, the parts are the list that svo_voxels_load makes; where instances
 *  overlap, that has the later one.
 *
 * \param source the file (see files.h)
 * \param options NULL means all defaults; hidden and frame choose instances; voxels_max is for each model
 * \param callback receives the parts by ascending number, on the calling thread; not NULL
 * \param user passed to it
 * \param info receives what the file holds; NULL allowed
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_UNSUPPORTED: no .vox file of MagicaVoxel. Else what svo_voxels_load or the callback returns. */
SVO_API svo_status svo_voxels_load_parts(svo_source source, const svo_voxels_load_options *options,
                                         svo_voxel_part_callback callback, void *user, svo_voxel_file_info *info,
                                         svo_message *message);

/** What was written. */
typedef struct svo_voxels_save_info {
    size_t struct_size; /**< sizeof(svo_voxels_save_info) */
    uint32_t format; /**< svo_voxel_format */
    /** .vox: the largest difference between a component of a voxel's color and that of its palette entry, 0 .. 255. Not
     *  0 when there are more than 255 colors. */
    uint32_t color_error;
    uint64_t models; /**< .vox: models; else 1 */
    uint64_t colors; /**< .vox: different pairs of a color and a material; else 0 */
    uint64_t faces; /**< .obj: faces; of svo_voxels_save_faces: rectangles; else 0 */
    uint64_t bytes; /**< of the file */
    uint64_t voxel_faces; /**< svo_voxels_save_faces: faces of voxels that the rectangles are of; else 0 */
} svo_voxels_save_info;

/** All zero. */
#define SVO_VOXELS_SAVE_INFO_INIT SVO_STRUCT_INIT(svo_voxels_save_info)

/** Writes a list as a file (see files.h).
 *
 *  .vox: models of up to 256^3 voxels in a scene that places them. Where materials are 1 .. 255 and each has one color,
 *  they become the indices of the palette; else colors do, and beyond 255 of them a voxel has the nearest of 255 that
 *  k-means finds. Properties are written to the materials' chunks. .binvox: the occupancy, in the smallest cube whose
 *  edge is a power of two. .svx: occupancy, colors without alpha, and materials unless one is above 255. .nvdb: a grid
 *  "density", a fog volume that is 1 in voxels, and where there are any, grids "color" and "material" of the same
 *  voxels. .vdb: the same grids in OpenVDB's types, without alpha. .bt: the occupancy, at planes that are whole
 *  multiples of voxel_edge: places are moved to the nearest. Voxels may be 32768 from the origin, at most. None of
 *  these has properties of materials; .vox has neither origin nor voxel_edge. svo_voxels_set_axes says which axis is up
 *  in the file: z in .vox and .bt, unless it says otherwise.
 *
 * \param voxels not NULL
 * \param sink receives the file
 * \param format AUTO: by the suffix of the sink's path; of a sink without one not AUTO
 * \param info receives what was written; NULL allowed
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_FILE_ERROR, SVO_UNSUPPORTED, SVO_INVALID_ARGUMENT (no known suffix; more models, slices or bytes than
 *          the format can hold) or SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_voxels_save(const svo_voxels *voxels, svo_sink sink, svo_voxel_format format,
                                   svo_voxels_save_info *info, svo_message *message);

/** Writes the surface of a list as a mesh of rectangles (see files.h): the faces behind which there is no voxel, merged
 *  as far as they have one plane and one color. Each rectangle has four corners of its own, with that color.
 *
 *  The surface is closed, and its front is outside. Sides of rectangles may end in the middle of other ones
 *  (T-junctions): a program that needs edges to meet at corners alone must split them. The mesh can be read in again
 *  (svo_import_file). A half-open build of it, on a grid of the same planes, has voxels of the list alone: all with an
 *  outer face, in their colors, and some that touch the surface at an edge. A solid of it has them all.
 *
 *  For that, faces on the far sides of voxels lie 2^-20 of a voxel, or a float's step, below the plane between the
 *  voxels. Where voxel_edge is no power of two, so that planes are no doubles, faces on near sides lie as far above it.
 *  Where outlines or colors turn, strips of that width are left between rectangles. Materials are left out, and in .obj
 *  files alpha.
 *
 * \param voxels not NULL. Planes between voxels must lie four floats apart, at least
 * \param sink receives the file
 * \param format SVO_VOXEL_FORMAT_PLY, SVO_VOXEL_FORMAT_OBJ, or AUTO: by the suffix of the sink's path
 * \param info receives what was written; NULL allowed
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_FILE_ERROR, SVO_INVALID_ARGUMENT (another format; voxels too far out for floats; more than 2^29
 *          rectangles in a .ply file) or SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_voxels_save_faces(const svo_voxels *voxels, svo_sink sink, svo_voxel_format format,
                                         svo_voxels_save_info *info, svo_message *message);

/** Writes a signed distance field as a .nvdb file (see files.h): a level set "surface" of floats, NanoVDB's form of
 *  what programs of volumes take. The field's voxels are active, at the field's places in the world. What is not in a
 *  band has its width as the distance, negative inside; in a dense field all voxels are active. -0 becomes -FLT_MIN.
 *
 * \param sdf with host arrays (svo_sdf_download), at most 4096^3 voxels
 * \param sink receives the file
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_FILE_ERROR, SVO_UNSUPPORTED (more voxels along an axis; svocl was built without NanoVDB's header),
 *          SVO_INVALID_ARGUMENT or SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_sdf_save(const svo_sdf *sdf, svo_sink sink, svo_message *message);

/** The same in a format that is chosen: .nvdb, or .vdb for OpenVDB.
 *
 * \param sdf as above
 * \param sink receives the file
 * \param format SVO_VOXEL_FORMAT_NVDB, SVO_VOXEL_FORMAT_VDB, or AUTO: by the suffix of the sink's path
 * \param message receives the reason for a failure; NULL allowed
 * \returns what svo_sdf_save returns; SVO_INVALID_ARGUMENT also for another format, SVO_UNSUPPORTED for .vdb where
 *           svocl was built without zlib. */
SVO_API svo_status svo_sdf_save_as(const svo_sdf *sdf, svo_sink sink, svo_voxel_format format, svo_message *message);

#ifdef __cplusplus
}
#endif

#endif
