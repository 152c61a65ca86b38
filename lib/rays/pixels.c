/* SPDX-License-Identifier: MIT */
/* Buffers that pictures are drawn to. */
#include "rays/pixels.h"

#include <math.h>

#include "shared/layout.h"

#define TILE_EDGE 8u

_Static_assert(SVO_PICTURE_SAMPLES_MAX == SVO_PIXEL_SAMPLES_MAX, "kernels sample as often as trace.h says");

/* The linear light of a coded color. */
static float decode(svo_i_curve curve, float coded)
{
    switch (curve) {
    case SVO_I_CURVE_ROOT:
        return coded * coded;
    case SVO_I_CURVE_SRGB: /* IEC 61966-2-1 */
        return coded <= 0.04045F ? coded / 12.92F : (float)pow(((double)coded + 0.055) / 1.055, 2.4);
    default:
        return coded;
    }
}

static svo_status check_output(svo_device *device, const char *function, const char *argument,
                               const svo_picture_output *asked)
{
    if ((unsigned)asked->format > SVO_PIXELS_LINEAR || (unsigned)asked->background > SVO_BACKGROUND_TRANSPARENT) {
        const bool format = (unsigned)asked->format > SVO_PIXELS_LINEAR;
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: %s.output.%s %d is not in 0 .. %d", function,
                                 argument, format ? "format" : "background",
                                 format ? (int)asked->format : (int)asked->background,
                                 format ? (int)SVO_PIXELS_LINEAR : (int)SVO_BACKGROUND_TRANSPARENT);
    }
    for (int channel = 0; channel < 3; ++channel) {
        if (!(asked->background_color[channel] >= 0.0F && asked->background_color[channel] <= 1.0F)) {
            return svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                     "%s: %s.output.background_color[%d] %g is not in 0 .. 1", function, argument,
                                     channel, (double)asked->background_color[channel]);
        }
    }
    return asked->samples <= SVO_PICTURE_SAMPLES_MAX
               ? SVO_OK
               : svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: %s.output.samples %u is above %u", function,
                                   argument, asked->samples, SVO_PICTURE_SAMPLES_MAX);
}

svo_status svo_i_pixel_output_of(svo_device *device, const char *function, const char *argument,
                                 const svo_picture_output *asked, uint32_t samples, svo_i_curve curve,
                                 svo_i_pixel_output *out)
{
    SVO_I_TRY(check_output(device, function, argument, asked));
    const bool linear = asked->format == SVO_PIXELS_LINEAR;
    *out = (svo_i_pixel_output){.samples = asked->samples > 0 ? asked->samples : samples,
                                .flags = (linear ? SVO_PIXEL_LINEAR : 0u) |
                                         (asked->background == SVO_BACKGROUND_COLOR         ? SVO_PIXEL_COLOR
                                          : asked->background == SVO_BACKGROUND_TRANSPARENT ? SVO_PIXEL_TRANSPARENT
                                                                                            : 0u),
                                .pixel_bytes = linear ? 16u : 4u};
    for (int channel = 0; channel < 3; ++channel) {
        out->background[channel] = decode(curve, asked->background_color[channel]);
    }
    return SVO_OK;
}

svo_status svo_i_pixels_check(svo_device *device, const char *function, uint32_t width, uint32_t height,
                              uint32_t pixel_bytes, svo_i_pixels *given)
{
    if (given->buffer == NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: pixels is NULL", function);
    }
    SVO_I_TRY(svo_i_device_queue(device, function, given->queue, &given->queue));
    SVO_I_TRY(svo_i_device_check_wait(device, function, given->num_wait, given->wait));
    return svo_i_device_check_output(device, function, "pixels", given->buffer, (size_t)width * height * pixel_bytes);
}

static cl_uint count_tiles(const svo_i_tiles *tiles)
{
    return ((tiles->width + TILE_EDGE - 1) / TILE_EDGE) * ((tiles->height + TILE_EDGE - 1) / TILE_EDGE);
}

/* Launches the band that begins with a tile. */
static svo_status draw_band(svo_device *device, const char *function, const svo_i_tiles *tiles, cl_uint first,
                            const svo_i_pixels *to)
{
    const cl_uint count = count_tiles(tiles);
    const cl_uint band = count - first < device->band_tiles ? count - first : device->band_tiles;
    const size_t global = band * tiles->items;
    SVO_I_TRY(svo_i_kernel_set_from(device, function, tiles->kernel, tiles->first_tile, &SVO_I_ARGUMENT(first), 1));
    const cl_int error = clEnqueueNDRangeKernel(to->queue, tiles->kernel, 1, NULL, &global, &tiles->items, to->num_wait,
                                                to->wait, to->event);
    return error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(device, function, "clEnqueueNDRangeKernel", error);
}

svo_status svo_i_pixels_draw(svo_device *device, const char *function, const svo_i_tiles *tiles, const svo_i_pixels *to)
{
    const cl_uint count = count_tiles(tiles);
    cl_event previous = NULL;
    svo_status status = SVO_OK;
    for (cl_uint first = 0; first < count; first += device->band_tiles) {
        const bool is_last = count - first <= device->band_tiles;
        cl_event drawn = NULL;
        svo_i_pixels band = *to;
        band.event = is_last ? to->event : &drawn;
        /* Each band waits for the previous one, since the queue may be out-of-order. */
        if (previous != NULL) {
            band.num_wait = 1;
            band.wait = &previous;
        }
        SVO_I_TRY_CLEANUP(draw_band(device, function, tiles, first, &band));
        if (previous != NULL) {
            clReleaseEvent(previous);
        }
        previous = drawn;
    }

cleanup:
    if (previous != NULL) {
        (void)svo_i_event_settle(previous); /* nothing is in progress after a failure */
        clReleaseEvent(previous);
    }
    return status;
}

svo_status svo_i_own_pixels_begin(svo_device *device, const char *function, uint32_t width, uint32_t height,
                                  uint32_t pixel_bytes, cl_command_queue queue, svo_i_own_pixels *out)
{
    *out = (svo_i_own_pixels){.device = device, .function = function, .row_bytes = width * pixel_bytes};
    out->to.event = &out->drawn;
    SVO_I_TRY(svo_i_device_queue(device, function, queue, &out->to.queue));
    return svo_i_device_buffer(device, function, "picture", CL_MEM_WRITE_ONLY, (size_t)width * height * pixel_bytes,
                               &out->to.buffer);
}

svo_status svo_i_own_pixels_read(const svo_i_own_pixels *own, uint32_t first_row, uint32_t row_count, uint8_t *rgba)
{
    const size_t row_bytes = own->row_bytes;
    const cl_int error = clEnqueueReadBuffer(own->to.queue, own->to.buffer, CL_TRUE, row_bytes * first_row,
                                             row_bytes * row_count, rgba, 1, &own->drawn, NULL);
    return error == CL_SUCCESS ? SVO_OK
                               : svo_i_device_fail_cl(own->device, own->function, "clEnqueueReadBuffer", error);
}

void svo_i_own_pixels_end(svo_i_own_pixels *own)
{
    if (own->drawn != NULL) {
        (void)svo_i_event_settle(own->drawn);
        clReleaseEvent(own->drawn);
    }
    if (own->to.buffer != NULL) {
        clReleaseMemObject(own->to.buffer);
    }
    *own = (svo_i_own_pixels){.device = NULL};
}
