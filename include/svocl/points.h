/* SPDX-License-Identifier: MIT */
/** \file
 * Point clouds (svocl::io) as lists of voxels: each voxel with the mean color of its points and their number.
 *
 *     file    form                                          read
 *     .ply    text, binary of either byte order             x, y, z, red, green, blue, intensity of the vertices
 *     .las    versions 1.0 .. 1.4, point formats 0 .. 10    x, y, z, red, green, blue, intensity
 *     .laz    compressed .las                               no: another reader gives its points to svo_points_collect
 *
 * Points are read twice, in blocks: once for their bounds, once for their voxels. Blocks are sorted and merged, so that
 * memory follows the voxels and not the points. All sums are whole numbers: the order of the points changes nothing.
 *
 * Which voxel a point is in is exact to the bit. With each operation rounded to the nearest double, along each axis
 *
 *     voxel = floor((coordinate - origin) / voxel_edge)
 *
 * The grid is one of these:
 *
 * - edge above 0: the cube from origin on with that width, 2^depth voxels along each axis. Points outside are left out.
 * - voxel_edge above 0: planes at whole multiples of voxel_edge; origin is the greatest that, as a double, is at most
 *   the least coordinate.
 * - neither: 2^depth voxels along the longest axis of the bounds. origin is their least corner, and voxel_edge the
 *   least double from width / 2^depth on with which the greatest coordinate is in the last voxel. Where all points are
 *   in one place, voxel_edge is 1.
 */
#ifndef SVOCL_POINTS_H
#define SVOCL_POINTS_H

#include <stddef.h>
#include <stdint.h>

#include "svocl/files.h"
#include "svocl/memory.h"
#include "svocl/status.h"
#include "svocl/voxel_files.h"
#include "svocl/voxels.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SVO_POINTS_MAX           ((uint64_t)1 << 47) /**< most points of a cloud */
#define SVO_POINTS_MEMORY_MIN    ((uint64_t)4 << 20) /**< least svo_points_options.memory_bytes that is not 0 */
#define SVO_POINTS_DEPTH_DEFAULT 8 /**< svo_points_options.depth 0 */

/** A point. 32 bytes; it does not grow. */
typedef struct svo_point {
    double at[3]; /**< a point with a coordinate that is not finite is left out */
    uint16_t rgb[3]; /**< color; 0 without */
    uint16_t intensity; /**< of the returned light, 0 without */
} svo_point;

/** Gives points of a cloud.
 *
 * \param user as given
 * \param first number of the first one: 0 at the beginning of each of two readings, then where the last call ended
 * \param points receives count points, the same in both readings
 * \param count above 0; first + count is at most point_count
 * \returns 0; anything else ends the reading. */
typedef int (*svo_points_callback)(void *user, uint64_t first, svo_point *points, size_t count);

/** Points that a caller has or reads himself. */
typedef struct svo_points_source {
    size_t struct_size; /**< sizeof(svo_points_source) */
    const svo_point *points; /**< point_count; borrowed. NULL: read gives them */
    uint64_t point_count; /**< at most SVO_POINTS_MAX */
    svo_points_callback read; /**< with points, unused */
    void *user; /**< passed to read */
    uint32_t rgb_max; /**< what 255 becomes of: 255 or 65535; 0: judged as that of .las files */
    uint32_t reserved; /**< 0 */
} svo_points_source;

/** No points. */
#define SVO_POINTS_SOURCE_INIT SVO_STRUCT_INIT(svo_points_source)

/** How points become voxels. */
typedef struct svo_points_options {
    size_t struct_size; /**< sizeof(svo_points_options) */
    uint32_t depth; /**< 1 .. 16; 0: SVO_POINTS_DEPTH_DEFAULT. Unused with voxel_edge */
    /** An svo_axes: which axis is up in the file, AUTO: z in .las, y in others. Where it is z, (x, y, z) becomes
     *  (x, z, -y) before all else, and y is up in the list. */
    uint32_t axes;
    double voxel_edge; /**< width of a voxel, world units; 0: by depth. Not with edge */
    double origin[3]; /**< with edge: the least corner of the cube; else 0 */
    double edge; /**< width of the cube, world units; 0: the grid follows from the points */
    /** Most host memory of this call, and then of a build of the list's tree (200 bytes a voxel): 0: what the machine,
     *  the process's limit of address space and its control group allow. Bytes of the source are not counted. */
    uint64_t memory_bytes;
    uint64_t voxels_max; /**< most voxels; 0: by memory_bytes. At most SVO_VOXELS_MAX */
    uint32_t counts; /**< not 0: the material of a voxel is the number of its points, at most 65534; 0: it is 0 */
    uint32_t reserved; /**< 0 */
    svo_log_callback log; /**< receives warnings of what is left out; NULL: nothing is called */
    void *log_user; /**< passed to log */
    const svo_memory_callbacks *memory; /**< host memory of the call and of the list; NULL: malloc and free */
} svo_points_options;

/** All defaults. */
#define SVO_POINTS_OPTIONS_INIT SVO_STRUCT_INIT(svo_points_options)

/** What gives voxels their colors. */
typedef enum svo_points_color {
    SVO_POINTS_WHITE = 0, /**< neither colors nor intensities, or all of them are 0: voxels are white */
    SVO_POINTS_RGB = 1, /**< the mean of the points' colors */
    SVO_POINTS_INTENSITY = 2 /**< gray: the mean intensity, of which the greatest becomes 255 */
} svo_points_color;

/** What a cloud holds. */
typedef struct svo_points_info {
    size_t struct_size; /**< sizeof(svo_points_info) */
    uint32_t format; /**< svo_voxel_format: PLY, LAS, or AUTO for a caller's points */
    uint32_t version; /**< .las: 10 .. 14; else 0 */
    uint32_t point_format; /**< .las: 0 .. 10; else 0 */
    uint32_t color; /**< svo_points_color */
    uint32_t rgb_max; /**< 255 or 65535: what 255 becomes of; 0 without SVO_POINTS_RGB */
    uint32_t intensity_max; /**< the greatest */
    uint64_t point_count; /**< points of the file */
    uint64_t taken_count; /**< of these, in voxels */
    uint64_t outside_count; /**< left out: outside of the cube */
    uint64_t not_finite_count; /**< left out: with a coordinate that is infinite or not a number */
    uint64_t withheld_count; /**< .las: left out, since they are marked as withheld */
    double low[3]; /**< least coordinates of those taken, turned by axes; 0 without points */
    double high[3]; /**< greatest coordinates */
    double origin[3]; /**< of the grid */
    double voxel_edge; /**< of the grid */
    uint64_t voxel_count; /**< voxels of the list; 0 without one */
    uint64_t count_max; /**< most points of a voxel; 0 without a list */
} svo_points_info;

/** All zero. */
#define SVO_POINTS_INFO_INIT SVO_STRUCT_INIT(svo_points_info)

/** Whether a file holds points, by its first bytes.
 *
 * \param source the file
 * \returns SVO_VOXEL_FORMAT_LAS or SVO_VOXEL_FORMAT_LAZ; SVO_VOXEL_FORMAT_PLY for a .ply file that declares vertices
 *          and no faces or strips, or none of them; SVO_VOXEL_FORMAT_AUTO for all else, also what cannot be read. */
SVO_API svo_voxel_format svo_points_format(svo_source source);

/** Reads a .ply or .las file; its bytes say which. The voxels of the list have the mean color of their points: the sum
 *  of each channel as a fraction of what 255 becomes of, times 255, rounded half up, once. Alpha is 255.
 *
 *  Of .las files, colors whose greatest channel is at most 255 are bytes; the format has 16 bits, but not all writers
 *  use them. Points that are marked as withheld are left out: they are deleted by the format's words. Of .ply files,
 *  faces and elements but for the vertices are left out; intensity is read where it is a whole number.
 *
 * \param source the file
 * \param options NULL means all defaults
 * \param out receives the list, with svo_voxels_get_counts; NULL: points are read once, for info alone
 * \param info receives what the file holds; NULL allowed
 * \param message receives what is wrong and where; NULL allowed
 * \returns SVO_FILE_ERROR, SVO_FILE_DAMAGED, SVO_UNSUPPORTED (a .laz file; a .ply file with lists before the end of its
 *          vertices), SVO_INVALID_ARGUMENT (options; coordinates too far out for the grid) or SVO_OUT_OF_HOST_MEMORY
 *          (also: more voxels than memory_bytes holds) on failure. */
SVO_API svo_status svo_points_load(svo_source source, const svo_points_options *options, svo_voxels **out,
                                   svo_points_info *info, svo_message *message);

/** The same of a caller's points: arrays, or what another reader gives, such as one of .laz files.
 *
 * \param source not NULL
 * \param options NULL means all defaults
 * \param out as for svo_points_load
 * \param info as for svo_points_load
 * \param message receives the reason for a failure; NULL allowed
 * \returns what svo_points_load returns; SVO_FILE_ERROR when source.read does not return 0. */
SVO_API svo_status svo_points_collect(const svo_points_source *source, const svo_points_options *options,
                                      svo_voxels **out, svo_points_info *info, svo_message *message);

#ifdef __cplusplus
}
#endif

#endif
