/* SPDX-License-Identifier: MIT */
/*
 * .svx files (https://abfab3d.com/svx-format/): a zip archive with a manifest and, for each channel, a PNG image for
 * each slice of the grid.
 */
#ifndef SVO_LIB_IO_VOXELS_SVX_H
#define SVO_LIB_IO_VOXELS_SVX_H

#include <stdint.h>

#define SVX_MANIFEST       "manifest.xml"
#define SVX_MANIFEST_BYTES ((uint64_t)1 << 20) /* most bytes of a manifest */
#define SVX_CELLS_MAX      ((uint64_t)1 << 31) /* most cells of a grid */
#define SVX_SIDE_MAX       16384 /* most pixels along a side of a slice */
#define SVX_PIXELS_MAX     ((uint64_t)1 << 27) /* most pixels of a slice */
#define SVX_NAME_BYTES     256 /* of a type or of the names of slices, with the terminator */
#define SVX_CHANNELS_MAX   16

/* What is read of channels. */
typedef enum svx_kind { SVX_DENSITY, SVX_COLOR, SVX_MATERIAL, SVX_KINDS } svx_kind;

typedef struct svx_channel {
    char type[SVX_NAME_BYTES];
    char slices[SVX_NAME_BYTES]; /* "density/slice%04d.png" */
    uint32_t bits; /* 1 .. 16, or 24 for colors */
} svx_channel;

typedef struct svx_manifest {
    uint32_t size[3]; /* of the grid: x, y, z */
    double voxel_size; /* 0: not said */
    double origin[3];
    int slice_axis; /* that the slices follow: 0 x, 1 y, 2 z */
    int column_axis, row_axis;
    svx_channel channels[SVX_CHANNELS_MAX];
    uint32_t channel_count;
} svx_manifest;

#endif
