/* SPDX-License-Identifier: MIT */
/*
 * Pictures of what svo_i_picture_source describes: a built tree, a compact one or a paged one; where their pixels go.
 */
#ifndef SVO_LIB_RAYS_PICTURE_H
#define SVO_LIB_RAYS_PICTURE_H

#include "core/device.h"
#include "core/program.h"
#include "rays/rays.h"
#include "svocl/nodes.h"
#include "svocl/trace.h"

/* Where the pixels of a picture go, and what of them: rows, top to bottom, in a buffer of the caller's, or in one that
   lives until they were read. */

/* The curve that makes bytes of linear light. */
typedef enum svo_i_curve { SVO_I_CURVE_ROOT, SVO_I_CURVE_SRGB, SVO_I_CURVE_NONE } svo_i_curve;

/* What kernels get of an svo_picture_output. */
typedef struct svo_i_pixel_output {
    uint32_t samples; /* the picture's own, until svo_i_pixel_output says what is asked for */
    uint32_t flags; /* SVO_PIXEL_* */
    float background[3]; /* linear */
    uint32_t pixel_bytes;
} svo_i_pixel_output;

/* Checks what is asked for and describes it. argument: its name in messages. samples: the picture's own number. */
svo_status svo_i_pixel_output_of(svo_device *device, const char *function, const char *argument,
                                 const svo_picture_output *asked, uint32_t samples, svo_i_curve curve,
                                 svo_i_pixel_output *out);

/* A buffer, and the commands that fill it. */
typedef struct svo_i_pixels {
    cl_mem buffer;
    cl_command_queue queue;
    cl_uint num_wait;
    const cl_event *wait; /* for these the first command waits */
    cl_event *event; /* receives that of the last command; NULL: nobody asks for it */
} svo_i_pixels;

/* Refuses what a caller gave, unless a picture of this size can go there. A queue of NULL becomes the device's own. */
svo_status svo_i_pixels_check(svo_device *device, const char *function, uint32_t width, uint32_t height,
                              uint32_t pixel_bytes, svo_i_pixels *given);

/* A kernel that draws tiles of 8 x 8 pixels, a group each. */
typedef struct svo_i_tiles {
    cl_kernel kernel;
    cl_uint first_tile; /* the index of its last argument; all others are set */
    size_t items; /* of a group */
    cl_uint width, height; /* pixels */
} svo_i_tiles;

/* Enqueues all tiles, in launches of at most svo_device.band_tiles. */
svo_status svo_i_pixels_draw(svo_device *device, const char *function, const svo_i_tiles *tiles,
                             const svo_i_pixels *to);

/* Pixels on their way to the host. Not to be moved: to.event points into it. */
typedef struct svo_i_own_pixels {
    svo_device *device;
    const char *function; /* for messages */
    uint32_t row_bytes;
    svo_i_pixels to;
    cl_event drawn;
} svo_i_own_pixels;

/* queue: NULL for the device's own. */
svo_status svo_i_own_pixels_begin(svo_device *device, const char *function, uint32_t width, uint32_t height,
                                  uint32_t pixel_bytes, cl_command_queue queue, svo_i_own_pixels *out);
/* Waits for the picture and reads rows of it. */
svo_status svo_i_own_pixels_read(const svo_i_own_pixels *own, uint32_t first_row, uint32_t row_count, uint8_t *rgba);
void svo_i_own_pixels_end(svo_i_own_pixels *own);

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
} svo_i_picture_source;

SVO_I_SHARED_BEGIN

/* The options of a picture, checked, but for its output. */
svo_status svo_i_picture_options(svo_device *device, const char *function, const svo_render_options *options,
                                 svo_render_options *out);
/* Draws a picture and waits for it. */
svo_status svo_i_picture_draw(const svo_i_picture_source *source, const svo_render_options *options,
                              cl_command_queue queue, uint8_t *rgba);

SVO_I_SHARED_END

/* Enqueues what draws a picture. to: a queue of NULL becomes the device's own. */
svo_status svo_i_picture_enqueue(const svo_i_picture_source *source, const svo_render_options *options,
                                 svo_i_pixels *to);

#endif
