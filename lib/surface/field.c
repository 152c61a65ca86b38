/* SPDX-License-Identifier: MIT */
/* The first step to a surface: the field's numbers, in bricks. Dense fields and bands give the same bricks. */
#include "surface/field.h"

#include <float.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "shared/nodes.clh"

#define BRICK_LOG2 3
#define CODE_SHIFT (3 * BRICK_LOG2)

/* Floats between two centers, at least, so that vertices keep apart. */
#define STEPS_MIN 64.0

static const char function[] = "svo_surface_create";

/* ---- checks ---- */

/* Fails where floats cannot tell the centers apart. */
static svo_status check_places(const svo_surface_field *field, svo_message *message)
{
    double farthest = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
        if (!isfinite(field->first[axis])) {
            return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: field.first[%d] %g is not finite", function, axis,
                              field->first[axis]);
        }
        farthest = fmax(farthest, fabs(field->first[axis]) + field->spacing * ((double)field->size[axis] + 1.0));
    }
    const float at = (float)farthest;
    const double step = (double)nextafterf(at, INFINITY) - (double)at;
    return isfinite(step) && step * STEPS_MIN <= field->spacing
               ? SVO_OK
               : svo_i_fail(message, SVO_INVALID_ARGUMENT,
                            "%s: voxels %g wide lie at up to %g, where floats are %g apart", function, field->spacing,
                            farthest, step);
}

static svo_status check_field(const svo_surface_field *field, svo_message *message)
{
    if (!(field->spacing > 0.0 && isfinite(field->spacing))) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: field.spacing %g is not finite and above 0", function,
                          field->spacing);
    }
    uint64_t all = 1;
    for (int axis = 0; axis < 3; ++axis) {
        if (field->size[axis] < 1 || field->size[axis] > SVO_SURFACE_SIZE_MAX) {
            return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: field.size[%d] %u is not in 1 .. %u", function, axis,
                              field->size[axis], SVO_SURFACE_SIZE_MAX);
        }
        all *= field->size[axis];
    }
    if (field->distances == NULL && field->voxel_count > 0) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: field.distances is NULL", function);
    }
    if (field->codes == NULL ? field->voxel_count != all && field->voxel_count != 0 : field->voxel_count > all) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT,
                          "%s: field.voxel_count %" PRIu64 " is not that of %u x %u x %u voxels", function,
                          field->voxel_count, field->size[0], field->size[1], field->size[2]);
    }
    return check_places(field, message);
}

/* ---- bricks ---- */

static int compare_codes(const void *a, const void *b)
{
    const uint64_t left = *(const uint64_t *)a;
    const uint64_t right = *(const uint64_t *)b;
    return (left > right) - (left < right);
}

static svo_status make_bricks(svo_i_surface_reader *reader, uint64_t count, const svo_i_memory *memory,
                              svo_message *message)
{
    const uint64_t bytes = count * sizeof *reader->bricks;
    reader->bricks = bytes < SIZE_MAX ? svo_i_alloc(memory, (size_t)bytes + 1) : NULL;
    return reader->bricks != NULL
               ? SVO_OK
               : svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %" PRIu64 " bricks", function, count);
}

static svo_status list_dense(svo_i_surface_reader *reader, const svo_i_memory *memory, svo_message *message)
{
    uint64_t counts[3];
    for (int axis = 0; axis < 3; ++axis) {
        counts[axis] = (reader->field.size[axis] + SVO_I_SURFACE_BRICK - 1) / SVO_I_SURFACE_BRICK + 1;
    }
    SVO_I_TRY(make_bricks(reader, counts[0] * counts[1] * counts[2], memory, message));
    uint32_t at[3];
    for (at[2] = 0; at[2] < counts[2]; ++at[2]) {
        for (at[1] = 0; at[1] < counts[1]; ++at[1]) {
            for (at[0] = 0; at[0] < counts[0]; ++at[0]) {
                reader->bricks[reader->brick_count++] = svo_interleave(at);
            }
        }
    }
    return SVO_OK;
}

/* Checks the codes and finds the runs. */
static svo_status find_runs(svo_i_surface_reader *reader, const svo_i_memory *memory, svo_message *message)
{
    const svo_surface_field *field = &reader->field;
    uint64_t count = 0;
    for (uint64_t i = 0; i < field->voxel_count; ++i) {
        const uint64_t code = field->codes[i];
        uint32_t cell[3];
        svo_deinterleave(code, cell);
        if (code >> 48 != 0 || cell[0] >= field->size[0] || cell[1] >= field->size[1] || cell[2] >= field->size[2]) {
            return svo_i_fail(message, SVO_INVALID_ARGUMENT,
                              "%s: field.codes[%" PRIu64 "] is voxel %u, %u, %u, not in %u x %u x %u", function, i,
                              cell[0], cell[1], cell[2], field->size[0], field->size[1], field->size[2]);
        }
        if (i > 0 && code <= field->codes[i - 1]) {
            return svo_i_fail(message, SVO_INVALID_ARGUMENT,
                              "%s: field.codes[%" PRIu64 "] is not above the code before it", function, i);
        }
        count += i == 0 || code >> CODE_SHIFT != field->codes[i - 1] >> CODE_SHIFT;
    }
    reader->runs = svo_i_alloc_zeroed(memory, (size_t)count + 1, sizeof *reader->runs);
    if (reader->runs == NULL) {
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %" PRIu64 " bricks", function, count);
    }
    for (uint64_t i = 0; i < field->voxel_count; ++i) {
        if (i == 0 || field->codes[i] >> CODE_SHIFT != field->codes[i - 1] >> CODE_SHIFT) {
            reader->runs[reader->run_count++] = (svo_i_surface_run){field->codes[i] >> CODE_SHIFT, i};
        }
    }
    reader->runs[count] = (svo_i_surface_run){UINT64_MAX, field->voxel_count};
    return SVO_OK;
}

/* The bricks of a run: that of its voxels, and at the field's low ends those beyond. Returns how many. */
static uint64_t bricks_of(const svo_i_surface_run *run, uint64_t bricks[8])
{
    uint32_t at[3];
    uint64_t count = 0;
    svo_deinterleave(run->code, at);
    for (unsigned beyond = 0; beyond < 8; ++beyond) {
        uint32_t brick[3];
        bool is_there = true;
        for (unsigned axis = 0; axis < 3; ++axis) {
            const bool is_beyond = (beyond >> axis & 1u) != 0;
            is_there = is_there && (!is_beyond || at[axis] == 0);
            brick[axis] = is_beyond ? 0 : at[axis] + 1;
        }
        if (is_there) {
            bricks[count++] = svo_interleave(brick);
        }
    }
    return count;
}

static svo_status list_band(svo_i_surface_reader *reader, const svo_i_memory *memory, svo_message *message)
{
    uint64_t found[8];
    uint64_t count = 0;
    SVO_I_TRY(find_runs(reader, memory, message));
    for (uint64_t i = 0; i < reader->run_count; ++i) {
        count += bricks_of(&reader->runs[i], found);
    }
    SVO_I_TRY(make_bricks(reader, count, memory, message));
    for (uint64_t i = 0; i < reader->run_count; ++i) {
        const uint64_t more = bricks_of(&reader->runs[i], found);
        memcpy(reader->bricks + reader->brick_count, found, (size_t)more * sizeof *found);
        reader->brick_count += more;
    }
    return SVO_OK;
}

svo_status svo_i_surface_open(const svo_surface_field *field, float level, const svo_i_memory *memory,
                              svo_message *message, svo_i_surface_reader *reader)
{
    *reader = (svo_i_surface_reader){
        .field = *field, .level = level, .beyond = (float)fmin((double)level + 0.5 * field->spacing, (double)FLT_MAX)};
    SVO_I_TRY(check_field(field, message));
    if (field->voxel_count == 0) {
        return SVO_OK;
    }
    SVO_I_TRY(field->codes == NULL ? list_dense(reader, memory, message) : list_band(reader, memory, message));
    qsort(reader->bricks, (size_t)reader->brick_count, sizeof *reader->bricks, compare_codes);
    uint64_t kept = 1;
    for (uint64_t i = 1; i < reader->brick_count; ++i) {
        if (reader->bricks[i] != reader->bricks[kept - 1]) {
            reader->bricks[kept++] = reader->bricks[i];
        }
    }
    reader->brick_count = kept;
    return SVO_OK;
}

void svo_i_surface_close(svo_i_surface_reader *reader)
{
    svo_i_free(reader->runs);
    svo_i_free(reader->bricks);
    reader->runs = NULL;
    reader->bricks = NULL;
}

/* ---- numbers ---- */

/* At level 0 the sign decides, which tells -0 from 0. */
static svo_i_surface_state state_of(const svo_i_surface_reader *reader, float value)
{
    const bool is_inside = reader->level == 0.0F ? signbit(value) != 0 : value < reader->level;
    return is_inside ? SVO_I_SURFACE_INSIDE : SVO_I_SURFACE_OUTSIDE;
}

/* The run with that code, or NULL. */
static const svo_i_surface_run *find_run(const svo_i_surface_reader *reader, uint64_t code)
{
    uint64_t low = 0;
    uint64_t high = reader->run_count;
    while (low < high) {
        const uint64_t middle = low + (high - low) / 2;
        if (reader->runs[middle].code < code) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low < reader->run_count && reader->runs[low].code == code ? &reader->runs[low] : NULL;
}

static bool is_in_field(const svo_surface_field *field, const int32_t place[3])
{
    return place[0] >= 0 && place[1] >= 0 && place[2] >= 0 && (uint32_t)place[0] < field->size[0] &&
           (uint32_t)place[1] < field->size[1] && (uint32_t)place[2] < field->size[2];
}

static uint64_t dense_index(const svo_surface_field *field, const int32_t place[3])
{
    return (uint64_t)place[0] + field->size[0] * ((uint64_t)place[1] + field->size[1] * (uint64_t)place[2]);
}

svo_i_surface_state svo_i_surface_look(const svo_i_surface_reader *reader, const int32_t place[3])
{
    const svo_surface_field *field = &reader->field;
    if (!is_in_field(field, place)) {
        return SVO_I_SURFACE_OUTSIDE;
    }
    if (field->codes == NULL) {
        return state_of(reader, field->distances[dense_index(field, place)]);
    }
    const uint32_t cell[3] = {(uint32_t)place[0], (uint32_t)place[1], (uint32_t)place[2]};
    const uint64_t code = svo_interleave(cell);
    const svo_i_surface_run *run = find_run(reader, code >> CODE_SHIFT);
    for (uint64_t i = run != NULL ? run->begin : 0; run != NULL && i < run[1].begin && field->codes[i] <= code; ++i) {
        if (field->codes[i] == code) {
            return state_of(reader, field->distances[i]);
        }
    }
    return SVO_I_SURFACE_ABSENT;
}

/* Sets the centers beyond the field to outside, and the others to absent or, if they can be read at once, to what they
   are. */
static void read_rows(const svo_i_surface_reader *reader, svo_i_surface_window *window)
{
    const svo_surface_field *field = &reader->field;
    size_t site = 0;
    int32_t at[3];
    for (at[2] = window->low[2]; at[2] < window->low[2] + SVO_I_SURFACE_SIDE; ++at[2]) {
        for (at[1] = window->low[1]; at[1] < window->low[1] + SVO_I_SURFACE_SIDE; ++at[1]) {
            for (at[0] = window->low[0]; at[0] < window->low[0] + SVO_I_SURFACE_SIDE; ++at[0], ++site) {
                const bool is_there = is_in_field(field, at);
                window->states[site] = is_there ? SVO_I_SURFACE_ABSENT : SVO_I_SURFACE_OUTSIDE;
                window->values[site] = reader->beyond;
                if (is_there && field->codes == NULL) {
                    window->values[site] = field->distances[dense_index(field, at)];
                    window->states[site] = (uint8_t)state_of(reader, window->values[site]);
                }
            }
        }
    }
}

/* Puts the voxels of a run in their places, as far as the window has them. */
static void read_run(const svo_i_surface_reader *reader, const svo_i_surface_run *run, svo_i_surface_window *window)
{
    for (uint64_t i = run->begin; i < run[1].begin; ++i) {
        uint32_t cell[3];
        uint32_t from_low[3];
        svo_deinterleave(reader->field.codes[i], cell);
        for (int axis = 0; axis < 3; ++axis) {
            from_low[axis] = cell[axis] - (uint32_t)window->low[axis];
        }
        if (from_low[0] < SVO_I_SURFACE_SIDE && from_low[1] < SVO_I_SURFACE_SIDE && from_low[2] < SVO_I_SURFACE_SIDE) {
            const size_t site = from_low[0] + SVO_I_SURFACE_SIDE * (from_low[1] + SVO_I_SURFACE_SIDE * from_low[2]);
            window->values[site] = reader->field.distances[i];
            window->states[site] = (uint8_t)state_of(reader, window->values[site]);
        }
    }
}

/* The runs that have centers of the window: its own eight along each axis, and those behind. */
static void read_runs(const svo_i_surface_reader *reader, svo_i_surface_window *window)
{
    for (unsigned behind = 0; behind < 8; ++behind) {
        uint32_t at[3];
        bool is_there = true;
        for (unsigned axis = 0; axis < 3; ++axis) {
            const int32_t place = window->low[axis] / SVO_I_SURFACE_BRICK + (int32_t)(behind >> axis & 1u);
            is_there = is_there && (window->low[axis] >= 0 || (behind >> axis & 1u) != 0);
            at[axis] = (uint32_t)(window->low[axis] < 0 ? 0 : place);
        }
        const svo_i_surface_run *run = is_there ? find_run(reader, svo_interleave(at)) : NULL;
        if (run != NULL) {
            read_run(reader, run, window);
        }
    }
}

svo_status svo_i_surface_read(const svo_i_surface_reader *reader, uint64_t brick, svo_message *message,
                              svo_i_surface_window *window)
{
    uint32_t at[3];
    bool has_inside = false;
    bool has_others = false;
    svo_deinterleave(brick, at);
    for (int axis = 0; axis < 3; ++axis) {
        window->low[axis] = ((int32_t)at[axis] - 1) * SVO_I_SURFACE_BRICK;
    }
    read_rows(reader, window);
    if (reader->field.codes != NULL) {
        read_runs(reader, window);
    }
    for (size_t site = 0; site < SVO_I_SURFACE_SITES; ++site) {
        if (!isfinite(window->values[site])) {
            return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: the field's number at voxel %d, %d, %d is %g",
                              function, window->low[0] + (int)(site % SVO_I_SURFACE_SIDE),
                              window->low[1] + (int)(site / SVO_I_SURFACE_SIDE % SVO_I_SURFACE_SIDE),
                              window->low[2] + (int)(site / SVO_I_SURFACE_SIDE / SVO_I_SURFACE_SIDE),
                              (double)window->values[site]);
        }
        has_inside = has_inside || window->states[site] == SVO_I_SURFACE_INSIDE;
        has_others = has_others || window->states[site] != SVO_I_SURFACE_INSIDE;
    }
    window->is_mixed = has_inside && has_others;
    return SVO_OK;
}
