/* SPDX-License-Identifier: MIT */
/* Keeps buffers between uses: best fit by size (Knuth, "The Art of Computer Programming", volume 1, section 2.5). */
#include "core/spares.h"

/* Small buffers fit one another. */
#define SLACK_BYTES 4096u

uint64_t svo_i_buffer_bytes(cl_mem buffer)
{
    size_t bytes = 0;
    if (buffer != NULL) {
        clGetMemObjectInfo(buffer, CL_MEM_SIZE, sizeof bytes, &bytes, NULL);
    }
    return bytes;
}

/* Removes an entry, whose buffer is the caller's. */
static cl_mem remove_at(svo_i_spares *spares, uint32_t index)
{
    const cl_mem buffer = spares->entries[index].buffer;
    spares->entries[index] = spares->entries[--spares->count];
    return buffer;
}

/* The index of the buffer that fits best; count where none does. */
static uint32_t find_fit(const svo_i_spares *spares, uint64_t bytes)
{
    uint32_t best = spares->count;
    uint64_t most = bytes + bytes / 2 + SLACK_BYTES;
    for (uint32_t i = 0; i < spares->count; ++i) {
        const uint64_t held = spares->entries[i].bytes;
        if (held >= bytes && held <= most) {
            best = i;
            most = held;
        }
    }
    return best;
}

/* With an eighth more; where that does not fit, exactly, after releasing all that waits. */
static svo_status make(svo_i_spares *spares, svo_device *device, const char *function, const char *name, uint64_t bytes,
                       cl_mem *out)
{
    const uint64_t room = bytes + bytes / 8;
    if (room <= device->max_allocation_bytes &&
        svo_i_device_buffer(device, function, name, CL_MEM_READ_WRITE, (size_t)room, out) == SVO_OK) {
        return SVO_OK;
    }
    svo_i_spares_clear(spares);
    return svo_i_device_buffer(device, function, name, CL_MEM_READ_WRITE, (size_t)bytes, out);
}

svo_status svo_i_spares_take(svo_i_spares *spares, svo_device *device, const char *function, const char *name,
                             uint64_t bytes, cl_mem *out, uint64_t *made_bytes)
{
    const uint32_t index = find_fit(spares, bytes);
    if (index < spares->count) {
        *out = remove_at(spares, index);
    } else {
        SVO_I_TRY(make(spares, device, function, name, bytes, out));
    }
    if (made_bytes != NULL) {
        *made_bytes = svo_i_buffer_bytes(*out);
    }
    return SVO_OK;
}

static uint32_t find_smallest(const svo_i_spares *spares)
{
    uint32_t smallest = 0;
    for (uint32_t i = 1; i < spares->count; ++i) {
        smallest = spares->entries[i].bytes < spares->entries[smallest].bytes ? i : smallest;
    }
    return smallest;
}

void svo_i_spares_give(svo_i_spares *spares, cl_mem *buffer)
{
    if (*buffer == NULL) {
        return;
    }
    if (spares->count == SVO_I_SPARES_MAX) {
        clReleaseMemObject(remove_at(spares, find_smallest(spares)));
    }
    spares->entries[spares->count++] = (svo_i_spare){.buffer = *buffer, .bytes = svo_i_buffer_bytes(*buffer)};
    *buffer = NULL;
}

void svo_i_spares_end_round(svo_i_spares *spares)
{
    for (uint32_t i = spares->count; i-- > 0;) {
        if (spares->entries[i].waited) {
            clReleaseMemObject(remove_at(spares, i));
        } else {
            spares->entries[i].waited = true;
        }
    }
}

void svo_i_spares_clear(svo_i_spares *spares)
{
    while (spares->count > 0) {
        clReleaseMemObject(remove_at(spares, 0));
    }
}

uint64_t svo_i_spares_bytes(const svo_i_spares *spares)
{
    uint64_t bytes = 0;
    for (uint32_t i = 0; i < spares->count; ++i) {
        bytes += spares->entries[i].bytes;
    }
    return bytes;
}
