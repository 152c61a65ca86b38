/* SPDX-License-Identifier: MIT */
/** \file
 * Voxel files (svocl::io): .vox, .svx, .binvox and .nvdb to lists of voxels and back, points as .ply, cubes as .obj.
 *
 *     format    read  write  holds
 *     .vox      yes   yes    MagicaVoxel, versions 150 and 200: models, a scene of them, 255 colors, materials
 *     .svx      yes   yes    Shapeways: slices as PNG images in a zip archive. Needs libzip and expat
 *     .binvox   yes   yes    occupancy, run by run
 *     .nvdb     yes   yes    NanoVDB, version 32: occupancy, RGBA8 colors, materials. Needs NanoVDB's header to build
 *     .ply      no    yes    a point at the center of each voxel, with color and material
 *     .obj      no    yes    the faces between voxels and what is empty, with colors
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
    SVO_VOXEL_FORMAT_NVDB /**< "nvdb" */
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
     *  stb_image, which read .svx files, have their own, by malloc. */
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
    uint32_t version; /**< .vox: 150 or 200; .binvox: 1 or 2; .nvdb: 32; .svx: 0 */
    uint64_t models; /**< .vox: models in the file; else 1 */
    uint64_t instances; /**< models placed */
    uint64_t rotated_instances; /**< of those, with a rotation or a mirror */
    uint64_t hidden_instances; /**< left out since they or their layer are hidden */
    uint64_t instance_voxels; /**< voxels of all instances */
    uint64_t warnings; /**< given to the log callback */
} svo_voxel_file_info;

/** All zero. */
#define SVO_VOXEL_FILE_INFO_INIT SVO_STRUCT_INIT(svo_voxel_file_info)

/** Reads a .vox, .svx, .binvox or .nvdb file; its bytes say which. docs/voxel_files.md says what becomes of each part.
 *
 * \param source the file
 * \param options NULL means all defaults
 * \param out receives the list
 * \param info receives what the file holds; NULL allowed
 * \param message receives what is wrong and where; NULL allowed
 * \returns SVO_FILE_ERROR (cannot be read), SVO_FILE_DAMAGED, SVO_UNSUPPORTED (a .svx file, and the library was built
 *          without libzip or expat; a .nvdb file that is packed or of another version, or the library was built without
 *          NanoVDB's header), SVO_INVALID_ARGUMENT (no such frame, too many voxels, memory is not valid) or
 *          SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_voxels_load(svo_source source, const svo_voxels_load_options *options, svo_voxels **out,
                                   svo_voxel_file_info *info, svo_message *message);

/** What was written. */
typedef struct svo_voxels_save_info {
    size_t struct_size; /**< sizeof(svo_voxels_save_info) */
    uint32_t format; /**< svo_voxel_format */
    /** .vox: the largest difference between a component of a voxel's color and that of its palette entry, 0 .. 255. Not
     *  0 when there are more than 255 colors. */
    uint32_t color_error;
    uint64_t models; /**< .vox: models; else 1 */
    uint64_t colors; /**< .vox: different pairs of a color and a material; else 0 */
    uint64_t faces; /**< .obj: faces; else 0 */
    uint64_t bytes; /**< of the file */
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
 *  voxels. None of these has properties of materials; .vox has neither origin nor voxel_edge. svo_voxels_set_axes says
 *  which axis is up in the file: z in .vox, unless it says otherwise.
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

#ifdef __cplusplus
}
#endif

#endif
