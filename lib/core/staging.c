/* SPDX-License-Identifier: MIT */
#include "core/staging.h"

#include <string.h>

/* ---- staging memory ---- */

/* Attached to its device. */
typedef struct staging {
    svo_i_attachment attachment;
    cl_command_queue queue; /* that mapped it; owned */
    cl_mem memory; /* owned */
    unsigned char *mapped; /* two halves */
    size_t half_bytes;
    cl_event busy[2]; /* of the command that uses a half; owned; NULL: none */
    unsigned next; /* half */
} staging;

/* Waits until a half is free. */
static void clear_half(cl_event *busy)
{
    if (*busy != NULL) {
        (void)svo_i_event_settle(*busy);
        clReleaseEvent(*busy);
        *busy = NULL;
    }
}

static void release_staging(svo_i_attachment *attachment)
{
    staging *held = (staging *)attachment;
    cl_event unmapped = NULL;
    clear_half(&held->busy[0]);
    clear_half(&held->busy[1]);
    if (clEnqueueUnmapMemObject(held->queue, held->memory, held->mapped, 0, NULL, &unmapped) == CL_SUCCESS) {
        (void)svo_i_event_settle(unmapped);
        clReleaseEvent(unmapped);
    }
    clReleaseMemObject(held->memory);
    clReleaseCommandQueue(held->queue);
    svo_i_free(held);
}

/* Memory that the driver allocates for the host is where its DMA can read it. */
static cl_int fill_staging(const svo_device *device, staging *out)
{
    cl_int error = CL_SUCCESS;
    out->half_bytes = device->staging_bytes;
    out->queue = clCreateCommandQueue(device->context, device->device, 0, &error);
    if (error != CL_SUCCESS) {
        out->queue = NULL;
        return error;
    }
    out->memory =
        clCreateBuffer(device->context, CL_MEM_READ_WRITE | CL_MEM_ALLOC_HOST_PTR, 2 * out->half_bytes, NULL, &error);
    if (error != CL_SUCCESS) {
        out->memory = NULL;
        return error;
    }
    out->mapped = clEnqueueMapBuffer(out->queue, out->memory, CL_TRUE, CL_MAP_READ | CL_MAP_WRITE, 0,
                                     2 * out->half_bytes, 0, NULL, NULL, &error);
    return error;
}

/* The device's staging memory for so many bytes, made on first use; NULL: its driver copies. */
static staging *get_staging(svo_device *device, size_t bytes)
{
    if (device->staging_bytes == 0 || bytes < device->staged_bytes_min) {
        return NULL;
    }
    svo_i_attachment *known = svo_i_attachment_find(device->attachments, release_staging);
    if (known != NULL) {
        return (staging *)known;
    }
    staging *made = svo_i_alloc_zeroed(&device->memory, 1, sizeof *made);
    if (made != NULL && fill_staging(device, made) == CL_SUCCESS) {
        made->attachment.destroy = release_staging;
        svo_i_attachment_add(&device->attachments, &made->attachment);
        return made;
    }
    device->staging_bytes = 0; /* it works without */
    if (made != NULL && made->memory != NULL) {
        clReleaseMemObject(made->memory);
    }
    if (made != NULL && made->queue != NULL) {
        clReleaseCommandQueue(made->queue);
    }
    svo_i_free(made);
    return NULL;
}

/* ---- uploads ---- */

/* Copies a part to a half, and writes it from there after what previous stands for. */
static cl_int write_part(staging *held, const svo_i_upload *upload, size_t done, size_t bytes)
{
    const unsigned half = held->next;
    const cl_event *previous = done > 0 ? &held->busy[1 - half] : NULL;
    unsigned char *pinned = held->mapped + half * held->half_bytes;
    clear_half(&held->busy[half]);
    memcpy(pinned, (const unsigned char *)upload->from + done, bytes);
    const cl_int error = clEnqueueWriteBuffer(upload->queue, upload->buffer, CL_FALSE, upload->offset + done, bytes,
                                              pinned, previous != NULL ? 1 : upload->num_wait,
                                              previous != NULL ? previous : upload->wait, &held->busy[half]);
    if (error != CL_SUCCESS) {
        held->busy[half] = NULL;
        return error;
    }
    held->next = 1 - half;
    return clFlush(upload->queue); /* so that it begins while the next half is filled */
}

static cl_int enqueue_parts(staging *held, const svo_i_upload *upload, cl_event *event)
{
    cl_int error = CL_SUCCESS;
    for (size_t done = 0; done < upload->bytes && error == CL_SUCCESS; done += held->half_bytes) {
        const size_t left = upload->bytes - done;
        error = write_part(held, upload, done, left < held->half_bytes ? left : held->half_bytes);
    }
    cl_event last = held->busy[1 - held->next];
    error = error == CL_SUCCESS ? clRetainEvent(last) : error;
    if (error == CL_SUCCESS) {
        *event = last;
    }
    return error;
}

cl_int svo_i_upload_enqueue(svo_device *device, const svo_i_upload *upload, cl_event *event)
{
    staging *held = get_staging(device, upload->bytes);
    if (held == NULL) {
        return clEnqueueWriteBuffer(upload->queue, upload->buffer, upload->blocks, upload->offset, upload->bytes,
                                    upload->from, upload->num_wait, upload->wait, event);
    }
    const cl_int error = enqueue_parts(held, upload, event);
    if (error != CL_SUCCESS || upload->blocks == CL_FALSE) {
        return error;
    }
    const cl_int waited = clWaitForEvents(1, event);
    if (waited != CL_SUCCESS) {
        clReleaseEvent(*event);
        *event = NULL;
    }
    return waited;
}

svo_status svo_i_device_write(svo_device *device, const char *function, cl_command_queue queue, cl_mem buffer,
                              size_t offset, const void *from, size_t bytes)
{
    const svo_i_upload upload = {
        .queue = queue, .buffer = buffer, .offset = offset, .bytes = bytes, .from = from, .blocks = CL_TRUE};
    cl_event written = NULL;
    if (bytes == 0) {
        return SVO_OK;
    }
    cl_int error = svo_i_upload_enqueue(device, &upload, &written);
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(device, function, "clEnqueueWriteBuffer", error);
    }
    error = clWaitForEvents(1, &written);
    if (error != CL_SUCCESS) {
        (void)svo_i_event_settle(written);
    }
    clReleaseEvent(written);
    return error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(device, function, "clWaitForEvents", error);
}

/* ---- downloads ---- */

/* Begins to read the part at an offset of the bytes to the next half. */
static cl_int read_part(staging *held, const svo_i_download_from *from, size_t at)
{
    const unsigned half = held->next;
    const size_t left = from->bytes - at;
    clear_half(&held->busy[half]);
    const cl_int error = clEnqueueReadBuffer(from->queue, from->buffer, CL_FALSE, from->offset + at,
                                             left < held->half_bytes ? left : held->half_bytes,
                                             held->mapped + half * held->half_bytes, 1, from->wait, &held->busy[half]);
    if (error != CL_SUCCESS) {
        held->busy[half] = NULL;
        return error;
    }
    held->next = 1 - half;
    return clFlush(from->queue);
}

/* Waits for the older of two parts, and copies it. */
static cl_int take_part(staging *held, unsigned half, unsigned char *to, size_t bytes)
{
    const cl_int error = clWaitForEvents(1, &held->busy[half]);
    if (error != CL_SUCCESS) {
        return error;
    }
    clReleaseEvent(held->busy[half]);
    held->busy[half] = NULL;
    memcpy(to, held->mapped + half * held->half_bytes, bytes);
    return CL_SUCCESS;
}

static cl_int read_parts(staging *held, const svo_i_download_from *from, unsigned char *to)
{
    unsigned half = held->next;
    cl_int error = read_part(held, from, 0);
    for (size_t at = 0; at < from->bytes && error == CL_SUCCESS; at += held->half_bytes, half = 1 - half) {
        const size_t left = from->bytes - at;
        if (left > held->half_bytes) {
            error = read_part(held, from, at + held->half_bytes);
        }
        if (error == CL_SUCCESS) {
            error = take_part(held, half, to + at, left < held->half_bytes ? left : held->half_bytes);
        }
    }
    return error;
}

cl_int svo_i_download(svo_device *device, const svo_i_download_from *from, void *to)
{
    staging *held = get_staging(device, from->bytes);
    return held != NULL ? read_parts(held, from, to)
                        : clEnqueueReadBuffer(from->queue, from->buffer, CL_TRUE, from->offset, from->bytes, to, 1,
                                              from->wait, NULL);
}
