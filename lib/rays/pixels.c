/* SPDX-License-Identifier: MIT */
/* Buffers that pictures are drawn to. */
#include "rays/pixels.h"

svo_status svo_i_pixels_check(svo_device *device, const char *function, uint32_t width, uint32_t height,
                              const svo_i_pixels *given)
{
    if (given->buffer == NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: pixels is NULL", function);
    }
    SVO_I_TRY(svo_i_device_check_queue(device, function, given->queue));
    SVO_I_TRY(svo_i_device_check_wait(device, function, given->num_wait, given->wait));
    return svo_i_device_check_output(device, function, "pixels", given->buffer, (size_t)width * height * 4);
}

svo_status svo_i_own_pixels_begin(svo_device *device, const char *function, uint32_t width, uint32_t height,
                                  cl_command_queue queue, svo_i_own_pixels *out)
{
    *out = (svo_i_own_pixels){.device = device, .function = function, .width = width};
    out->to.event = &out->drawn;
    SVO_I_TRY(svo_i_device_queue(device, function, queue, &out->to.queue));
    return svo_i_device_buffer(device, function, "picture", CL_MEM_WRITE_ONLY, (size_t)width * height * 4,
                               &out->to.buffer);
}

svo_status svo_i_own_pixels_read(const svo_i_own_pixels *own, uint32_t first_row, uint32_t row_count, uint8_t *rgba)
{
    const size_t row_bytes = (size_t)own->width * 4;
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
