/* SPDX-License-Identifier: MIT */
/*
 * Pictures of what svo_i_picture_source describes: a built tree, a compact one or a paged one; what pictures share.
 */
#ifndef SVO_LIB_RAYS_PICTURE_H
#define SVO_LIB_RAYS_PICTURE_H

#include "core/device.h"
#include "core/program.h"
#include "core/submit.h"
#include "rays/rays.h"
#include "svocl/nodes.h"
#include "svocl/trace.h"

/* The curve that makes bytes of linear light. */
typedef enum svo_i_curve { SVO_I_CURVE_ROOT, SVO_I_CURVE_SRGB, SVO_I_CURVE_NONE } svo_i_curve;

/* What kernels get of an svo_picture_output. */
typedef struct svo_i_pixel_output {
    uint32_t samples; /* the picture's own, until svo_i_pixel_output says what is asked for */
    uint32_t flags; /* SVO_PIXEL_* */
    float background[3]; /* linear */
    uint32_t pixel_bytes;
} svo_i_pixel_output;

/* Checks what is asked for and describes it. samples: the picture's own number. */
svo_status svo_i_pixel_output_of(svo_device *device, const char *function, const svo_picture_output *asked,
                                 uint32_t samples, svo_i_curve curve, svo_i_pixel_output *out);

/* A kernel that draws tiles of 8 x 8 pixels, a group each. */
typedef struct svo_i_tiles {
    cl_kernel kernel; /* its arguments are set */
    size_t items; /* of a group */
    cl_uint width, height; /* pixels */
} svo_i_tiles;

/* Enqueues all tiles, in bands that begin with svo_device.band_tiles. */
svo_status svo_i_tiles_draw(const svo_i_tiles *tiles, const svo_i_call *call);

typedef struct svo_i_picture_source {
    svo_device *device;
    const char *function; /* for messages */
    svo_grid grid;
    const char *form_defines; /* selects the reader of the nodes; "" for a built tree */
    cl_mem nodes[3]; /* what SVO_NODES_PARAMETERS declares */
    cl_uint node_arguments; /* their number */
    svo_i_ray_target tree; /* the arguments of views */
    cl_mem colors, normals; /* NULL: none */
    bool one_color, one_normal; /* the same in every node */
    uint32_t payload_level;
    bool packed_colors, packed_normals; /* words of packed arrays (kernels/shared/packed.clh) */
} svo_i_picture_source;

/* What of svo_render_options the pictures of a kind of handle have. */
typedef struct svo_i_picture_kind {
    const char *name; /* "tree", for messages */
    uint32_t views; /* a sum of 1 << svo_render_view */
    const char *view_names; /* for messages */
    bool lights; /* light_count, lights, occlusion_range */
    bool gathers; /* gather, exposure, first_row, row_count */
} svo_i_picture_kind;

/* The views of voxels, and their names. */
#define SVO_I_VOXEL_VIEWS \
    (1u << SVO_VIEW_SHADED | 1u << SVO_VIEW_NORMAL | 1u << SVO_VIEW_DEPTH | 1u << SVO_VIEW_STEPS | 1u << SVO_VIEW_LEVEL)
#define SVO_I_VOXEL_VIEW_NAMES "SVO_VIEW_SHADED, NORMAL, DEPTH, STEPS and LEVEL"

SVO_I_SHARED_BEGIN

/* The options of a picture, checked, but for what kinds alone have, and its output. */
svo_status svo_i_picture_options(svo_device *device, const char *function, const svo_i_picture_kind *kind,
                                 const svo_render_options *options, svo_render_options *out);
/* Draws a picture: svo_render. */
svo_status svo_i_picture_draw(const svo_i_picture_source *source, const svo_render_options *options,
                              const svo_array *pixels, const svo_submit *submit);

SVO_I_SHARED_END

/* svo_render of a tree. */
svo_status svo_i_tree_render(void *of, const svo_render_options *options, const svo_array *pixels,
                             const svo_submit *submit);

#endif
