/* SPDX-License-Identifier: MIT */
/* The .binvox writer: the occupancy of the smallest cube whose edge is a power of two, as most readers want it. */

#include "io/voxels_formats.h"
#include "io/voxels_text.h"

#define BITS_MAX 12u /* longer edges would make gigabytes of empty runs */
#define RUN_MAX  255u

static svo_status put_header(voxel_writer *writer, uint32_t side)
{
    char text[4][VOXEL_NUMBER_BYTES];
    for (int axis = 0; axis < 3; ++axis) {
        (void)svo_i_voxel_number(text[axis], svo_i_voxels_world(writer, axis, (double)writer->list.low[axis]), 17);
    }
    (void)svo_i_voxel_number(text[3], writer->list.voxel_edge * (double)side, 17);
    return svo_i_voxels_print(writer, "#binvox 1\ndim %u %u %u\ntranslate %s %s %s\nscale %s\ndata\n", side, side, side,
                              text[0], text[1], text[2], text[3]);
}

static svo_status put_run(voxel_writer *writer, uint8_t value, uint64_t count)
{
    while (count > 0) {
        const uint8_t run[2] = {value, (uint8_t)(count < RUN_MAX ? count : RUN_MAX)};
        SVO_I_TRY(svo_i_voxels_put(writer, run, sizeof run));
        count -= run[1];
    }
    return SVO_OK;
}

/* Writes the runs of voxels that are sorted by row. */
static svo_status put_runs(voxel_writer *writer, const svo_voxel *sorted, uint32_t bits)
{
    uint64_t cell = 0; /* the first that is not written */
    uint64_t filled = 0; /* voxels before it that are not written */
    for (uint64_t i = 0; i < writer->list.voxel_count; ++i) {
        const uint64_t x = (uint64_t)(sorted[i].x - writer->list.low[0]);
        const uint64_t y = (uint64_t)(sorted[i].y - writer->list.low[1]);
        const uint64_t z = (uint64_t)(sorted[i].z - writer->list.low[2]);
        const uint64_t at = (x << bits | z) << bits | y;
        if (at != cell + filled) {
            SVO_I_TRY(put_run(writer, 1, filled));
            SVO_I_TRY(put_run(writer, 0, at - cell - filled));
            cell = at;
            filled = 0;
        }
        ++filled;
    }
    SVO_I_TRY(put_run(writer, 1, filled));
    return put_run(writer, 0, (UINT64_C(1) << 3 * bits) - cell - filled);
}

svo_status svo_i_voxels_write_binvox(voxel_writer *writer)
{
    const uint32_t bits = svo_i_voxel_bits(writer->list.low, writer->list.high);
    svo_voxel *sorted = NULL;
    if (bits > BITS_MAX) {
        return svo_i_voxels_write_fail(writer, SVO_INVALID_ARGUMENT,
                                       "a .binvox grid of %u^3 voxels is above the limit of %u^3", 1u << bits,
                                       1u << BITS_MAX);
    }
    SVO_I_TRY(svo_i_voxels_sorted(writer, SVO_I_VOXEL_ROWS, &sorted));
    svo_status status = put_header(writer, 1u << bits);
    if (status == SVO_OK) {
        status = put_runs(writer, sorted, bits);
    }
    svo_i_free(sorted);
    return status;
}
