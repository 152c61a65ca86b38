/* SPDX-License-Identifier: MIT */
/* Where the pixels of a picture go: rows of width * 4 bytes, top to bottom, in a buffer of the caller's, or in one that
   lives until they were read. */
#ifndef SVO_LIB_RAYS_PIXELS_H
#define SVO_LIB_RAYS_PIXELS_H

#include "core/device.h"

/* A buffer, and the commands that fill it. */
typedef struct svo_i_pixels {
    cl_mem buffer;
    cl_command_queue queue;
    cl_uint num_wait;
    const cl_event *wait; /* for these the first command waits */
    cl_event *event; /* receives that of the last command; NULL: nobody asks for it */
} svo_i_pixels;

/* Refuses what a caller gave, unless a picture of this size can go there. */
svo_status svo_i_pixels_check(svo_device *device, const char *function, uint32_t width, uint32_t height,
                              const svo_i_pixels *given);

/* Pixels on their way to the host. Not to be moved: to.event points into it. */
typedef struct svo_i_own_pixels {
    svo_device *device;
    const char *function; /* for messages */
    uint32_t width;
    svo_i_pixels to;
    cl_event drawn;
} svo_i_own_pixels;

/* queue: NULL for the device's own. */
svo_status svo_i_own_pixels_begin(svo_device *device, const char *function, uint32_t width, uint32_t height,
                                  cl_command_queue queue, svo_i_own_pixels *out);
/* Waits for the picture and reads rows of it. */
svo_status svo_i_own_pixels_read(const svo_i_own_pixels *own, uint32_t first_row, uint32_t row_count, uint8_t *rgba);
void svo_i_own_pixels_end(svo_i_own_pixels *own);

#endif
