/* SPDX-License-Identifier: MIT */
/* Pictures of what svo_i_picture_source describes: a built tree (render.c), a compact one or a paged one. */
#ifndef SVO_LIB_RAYS_PICTURE_H
#define SVO_LIB_RAYS_PICTURE_H

#include "rays/pixels.h"
#include "rays/target.h"
#include "svocl/nodes.h"
#include "svocl/trace.h"

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
