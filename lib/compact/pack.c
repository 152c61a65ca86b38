/* SPDX-License-Identifier: MIT */
/* svo_compact_pack: payload of a compact tree in blocks that kernels read where they are, and payload on the host. */
#include <string.h>

#include "compact/form.h"
#include "compact/packing.h"
#include "core/device.h"
#include "core/packed.h"
#include "core/staging.h"
#include "core/struct_size.h"
#include "svocl/plan.h"

#define COLOR_ERROR_MAX 255u
#define FILL_ERROR_MAX  65535u
#define NORMAL_BITS_MIN 4u
#define NORMAL_BITS_MAX 8u

static const char function[] = "svo_compact_pack";

/* Arrays in place of those of a compact tree. */
typedef struct packed_arrays {
    const svo_compact *compact;
    svo_pack_options asked;
    cl_command_queue queue; /* NULL without a device */
    uint32_t *words[SVO_I_PAYLOAD_COUNT]; /* owned; NULL: stays as it is */
    cl_mem buffers[SVO_I_PAYLOAD_COUNT]; /* owned */
} packed_arrays;

/* ---- checks ---- */

static svo_status fail_option(const svo_compact *compact, const char *name, uint32_t value, const char *limit)
{
    return svo_i_device_fail(compact->device, SVO_INVALID_ARGUMENT, "%s: options.%s %u is not %s", function, name,
                             value, limit);
}

static svo_status read_options(const svo_compact *compact, const svo_pack_options *options, svo_pack_options *out)
{
    SVO_I_TRY(svo_i_struct_read(svo_i_device_message(compact->device), function, "options", options, out,
                                SVO_I_STRUCT_SIZES(svo_pack_options, fill_error)));
    if ((out->leave_out & ~(uint32_t)SVO_NEED_ALL) != 0) {
        return svo_i_device_fail(compact->device, SVO_INVALID_ARGUMENT,
                                 "%s: options.leave_out 0x%x has bits outside 0x%x", function, out->leave_out,
                                 (unsigned)SVO_NEED_ALL);
    }
    if (out->color_error > COLOR_ERROR_MAX) {
        return fail_option(compact, "color_error", out->color_error, "in 0 .. 255");
    }
    if (out->fill_error > FILL_ERROR_MAX) {
        return fail_option(compact, "fill_error", out->fill_error, "in 0 .. 65535");
    }
    return out->normal_bits == 0 || (out->normal_bits >= NORMAL_BITS_MIN && out->normal_bits <= NORMAL_BITS_MAX)
               ? SVO_OK
               : fail_option(compact, "normal_bits", out->normal_bits, "0 and not in 4 .. 8");
}

/* Whether an array is to be packed. */
static bool is_asked(const packed_arrays *p, svo_compact_buffer buffer)
{
    const svo_compact_info *info = &p->compact->info;
    return info->bytes[buffer] > 0 && (p->asked.leave_out & svo_i_compact_need(buffer)) == 0 &&
           !svo_i_compact_is_constant(info, buffer) && !svo_i_compact_is_packed(info, buffer);
}

/* ---- one array ---- */

/* The elements on the host: the compact tree's own, or *copied, which the caller frees. */
static svo_status fetch(const packed_arrays *p, svo_compact_buffer buffer, void **copied, const void **out)
{
    const svo_compact *compact = p->compact;
    const size_t bytes = (size_t)compact->info.bytes[buffer];
    *out = compact->host[buffer];
    if (*out != NULL) {
        return SVO_OK;
    }
    *copied = svo_i_alloc(&compact->memory, bytes);
    if (*copied == NULL) {
        return svo_i_device_fail(compact->device, SVO_OUT_OF_HOST_MEMORY, "%s: %s needs %zu bytes", function,
                                 svo_name(SVO_NAME_COMPACT_BUFFER, buffer), bytes);
    }
    *out = *copied;
    const cl_int error =
        clEnqueueReadBuffer(p->queue, compact->buffers[buffer], CL_TRUE, 0, bytes, *copied, 0, NULL, NULL);
    return error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(compact->device, function, "clEnqueueReadBuffer", error);
}

/* Packs an array into p->words, unless that takes no fewer bytes. */
static svo_status pack_array(packed_arrays *p, svo_compact_buffer buffer)
{
    const svo_compact *compact = p->compact;
    const int k = (int)buffer - (int)SVO_I_PAYLOAD_FIRST;
    svo_i_packing what = {.buffer = buffer,
                          .count = compact->info.payload_count,
                          .error = buffer == SVO_COMPACT_COLORS  ? p->asked.color_error
                                   : buffer == SVO_COMPACT_FILLS ? p->asked.fill_error
                                                                 : 0,
                          .normal_bits = buffer == SVO_COMPACT_NORMALS ? p->asked.normal_bits : 0};
    void *copied = NULL;
    svo_status status = SVO_OK;
    SVO_I_TRY_CLEANUP(fetch(p, buffer, &copied, &what.elements));
    SVO_I_TRY_CLEANUP(
        svo_i_pack_payload(function, &what, &compact->memory, &p->words[k], svo_i_device_message(compact->device)));
    if (svo_i_packed_bytes(p->words[k]) >= compact->info.bytes[buffer]) {
        svo_i_free(p->words[k]);
        p->words[k] = NULL;
    }

cleanup:
    svo_i_free(copied);
    return status;
}

static svo_status put_on_device(packed_arrays *p, int k)
{
    svo_device *device = p->compact->device;
    const size_t bytes = (size_t)svo_i_packed_bytes(p->words[k]);
    SVO_I_TRY(svo_i_device_buffer(device, function, "packed payload", CL_MEM_READ_ONLY, bytes, &p->buffers[k]));
    return svo_i_device_write(device, function, p->queue, p->buffers[k], 0, p->words[k], bytes);
}

static svo_status pack_arrays(packed_arrays *p)
{
    for (int k = 0; k < SVO_I_PAYLOAD_COUNT; ++k) {
        const svo_compact_buffer buffer = (svo_compact_buffer)(SVO_I_PAYLOAD_FIRST + k);
        if (is_asked(p, buffer)) {
            SVO_I_TRY(pack_array(p, buffer));
        }
        if (p->words[k] != NULL && p->compact->device != NULL) {
            SVO_I_TRY(put_on_device(p, k));
        }
    }
    return SVO_OK;
}

/* ---- the new compact tree ---- */

/* The array as it is: the same buffer, or a copy of what is on the host alone. */
static svo_status share_array(const svo_compact *compact, svo_compact_buffer buffer, svo_compact *out)
{
    const size_t bytes = (size_t)compact->info.bytes[buffer];
    if (compact->device != NULL && bytes > 0) {
        const cl_int error = clRetainMemObject(compact->buffers[buffer]);
        if (error != CL_SUCCESS) {
            return svo_i_device_fail_cl(compact->device, function, "clRetainMemObject", error);
        }
        out->buffers[buffer] = compact->buffers[buffer];
    }
    if (compact->device != NULL || bytes == 0) {
        return SVO_OK;
    }
    out->host[buffer] = svo_i_alloc(&compact->memory, bytes);
    if (out->host[buffer] == NULL) {
        return SVO_OUT_OF_HOST_MEMORY;
    }
    memcpy(out->host[buffer], compact->host[buffer], bytes);
    return SVO_OK;
}

static void take_array(packed_arrays *p, svo_compact_buffer buffer, svo_compact *out)
{
    const int k = (int)buffer - (int)SVO_I_PAYLOAD_FIRST;
    out->info.packed |= svo_i_compact_need(buffer);
    out->info.bytes[buffer] = svo_i_packed_bytes(p->words[k]);
    svo_i_packed_errors(p->words[k], buffer, &out->info);
    out->buffers[buffer] = p->buffers[k];
    p->buffers[k] = NULL;
    if (p->compact->device == NULL) {
        out->host[buffer] = p->words[k];
        p->words[k] = NULL;
    }
}

static svo_status make_packed(packed_arrays *p, svo_compact *out)
{
    out->info = p->compact->info;
    SVO_I_TRY(pack_arrays(p));
    for (int i = 0; i < SVO_COMPACT_BUFFER_COUNT; ++i) {
        const svo_compact_buffer buffer = (svo_compact_buffer)i;
        if (i >= (int)SVO_I_PAYLOAD_FIRST && p->words[i - (int)SVO_I_PAYLOAD_FIRST] != NULL) {
            take_array(p, buffer, out);
        } else {
            SVO_I_TRY(share_array(p->compact, buffer, out));
        }
    }
    svo_i_compact_count(&out->info);
    out->device = p->compact->device;
    out->downloaded = out->device == NULL;
    return SVO_OK;
}

svo_status svo_compact_pack(const svo_compact *compact, const svo_pack_options *options, cl_command_queue queue,
                            svo_compact **out)
{
    packed_arrays p = {.compact = compact};
    svo_compact *made = NULL;
    svo_status status = SVO_OK;
    if (compact == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    if (out == NULL) {
        return svo_i_device_fail(compact->device, SVO_INVALID_ARGUMENT, "%s: out is NULL", function);
    }
    SVO_I_TRY(read_options(compact, options, &p.asked));
    if (compact->device != NULL) {
        SVO_I_TRY(svo_i_device_queue(compact->device, function, queue, &p.queue));
    }
    made = svo_i_compact_new(&compact->memory);
    if (made == NULL) {
        return svo_i_device_fail(compact->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for a compact tree", function);
    }
    SVO_I_TRY_CLEANUP(make_packed(&p, made));
    *out = made;
    made = NULL;

cleanup:
    svo_compact_destroy(&made);
    for (int k = 0; k < SVO_I_PAYLOAD_COUNT; ++k) {
        svo_i_free(p.words[k]);
        svo_i_buffer_release(&p.buffers[k]);
    }
    return status;
}

/* ---- payload on the host ---- */

svo_status svo_compact_read_payload(const svo_compact *compact, svo_compact_buffer buffer, uint64_t first,
                                    uint64_t count, void *elements)
{
    static const char reader[] = "svo_compact_read_payload";
    if (compact == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    const svo_compact_info *info = &compact->info;
    if (svo_i_compact_need(buffer) == 0 || compact->host[buffer] == NULL) {
        return svo_i_device_fail(compact->device, SVO_INVALID_ARGUMENT, "%s: buffer %d is no payload on the host",
                                 reader, (int)buffer);
    }
    if (first > info->payload_count || count > info->payload_count - first) {
        return svo_i_device_fail(compact->device, SVO_INVALID_ARGUMENT,
                                 "%s: %llu elements from %llu on are not in %llu", reader, (unsigned long long)count,
                                 (unsigned long long)first, (unsigned long long)info->payload_count);
    }
    if (count > 0 && elements == NULL) {
        return svo_i_device_fail(compact->device, SVO_INVALID_ARGUMENT, "%s: elements is NULL", reader);
    }
    if (svo_i_compact_is_packed(info, buffer)) {
        svo_i_packed_read(compact->host[buffer], buffer, first, count, elements);
        return SVO_OK;
    }
    const size_t bytes = svo_i_compact_element_bytes(info, buffer);
    const bool one = svo_i_compact_is_constant(info, buffer);
    for (uint64_t i = 0; i < count; ++i) {
        memcpy((uint8_t *)elements + i * bytes, (const uint8_t *)compact->host[buffer] + (one ? 0 : first + i) * bytes,
               bytes);
    }
    return SVO_OK;
}
