/* SPDX-License-Identifier: MIT */
/*
 * Welding: vertices of an imported mesh that lie close together get one position, that of the first. So cracks that a
 * program left by rounding are closed. It runs in the calling process, on the parsed answer of the child.
 *
 * Vertices that stay where they are form a hash table by cells of a grid, three tolerances wide. What lies near a
 * vertex is in one or two cells along each axis: subtracting, dividing and rounding down keep the order of numbers, so
 * no rounding error hides a neighbor. Those that stay lie farther apart than the tolerance, so cells hold few of them.
 */
#include "io/import_weld.h"

#include <math.h>
#include <string.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "core/memory.h"
#include "core/message.h"
#include "io/import_stream.h"

/* Width of a cell: more than the two tolerances around a position, so that these span two cells at most, also where the
   quotients are rounded. Beyond 2^51 cells all would be, but floats that far out are equal or farther apart. */
#define CELL_TOLERANCES 3.0
/* Floats that are not equal differ by this at least. */
#define LEAST_DIFFERENCE 0x1p-149

typedef struct slot {
    uint32_t hash; /* of the vertex's cell */
    uint32_t vertex; /* plus one; 0: free */
} slot;

typedef struct welder {
    float *positions; /* three per vertex */
    double tolerance;
    slot *slots; /* open addressing; at most half full */
    size_t slot_mask;
} welder;

static uint32_t hash_cell(const double cell[3])
{
    return (uint32_t)XXH3_64bits(cell, 3 * sizeof *cell);
}

/* The cell of a position whose coordinates are raised by shift; + 0.0 turns -0 into 0. */
static void find_cell(const welder *w, const float *position, double shift, double cell[3])
{
    for (unsigned axis = 0; axis < 3; ++axis) {
        cell[axis] = floor(((double)position[axis] + shift) / (CELL_TOLERANCES * w->tolerance)) + 0.0;
    }
}

static double squared_distance(const float *a, const float *b)
{
    const double x = (double)a[0] - (double)b[0];
    const double y = (double)a[1] - (double)b[1];
    const double z = (double)a[2] - (double)b[2];
    return x * x + y * y + z * z;
}

/* Lowers *first to the first vertex of a cell that is near. */
static void look_in_cell(const welder *w, const double cell[3], const float *position, uint32_t *first)
{
    const uint32_t hash = hash_cell(cell);
    for (size_t i = hash & w->slot_mask; w->slots[i].vertex != 0; i = (i + 1) & w->slot_mask) {
        const uint32_t vertex = w->slots[i].vertex - 1;
        if (w->slots[i].hash == hash && vertex < *first &&
            squared_distance(position, w->positions + (size_t)vertex * 3) <= w->tolerance * w->tolerance) {
            *first = vertex;
        }
    }
}

/* The first vertex that is near; UINT32_MAX: none. */
static uint32_t find_first(const welder *w, const float *position)
{
    double ends[2][3];
    uint32_t first = UINT32_MAX;
    find_cell(w, position, -w->tolerance, ends[0]);
    find_cell(w, position, w->tolerance, ends[1]);
    for (unsigned corner = 0; corner < 8; ++corner) {
        double cell[3];
        bool is_new = true;
        for (unsigned axis = 0; axis < 3; ++axis) {
            const unsigned end = corner >> axis & 1u;
            cell[axis] = ends[end][axis];
            is_new = is_new && (end == 0 || ends[0][axis] != ends[1][axis]);
        }
        if (is_new) {
            look_in_cell(w, cell, position, &first);
        }
    }
    return first;
}

static void insert(welder *w, uint32_t vertex)
{
    double cell[3];
    find_cell(w, w->positions + (size_t)vertex * 3, 0.0, cell);
    const uint32_t hash = hash_cell(cell);
    size_t i = hash & w->slot_mask;
    while (w->slots[i].vertex != 0) {
        i = (i + 1) & w->slot_mask;
    }
    w->slots[i] = (slot){hash, vertex + 1};
}

/* Moves each vertex to the first one that is near, or lets it stay. Returns how many got other coordinates. */
static uint64_t move_vertices(welder *w, size_t vertex_count)
{
    uint64_t moved = 0;
    for (size_t v = 0; v < vertex_count; ++v) {
        float *position = w->positions + v * 3;
        if (!isfinite(position[0]) || !isfinite(position[1]) || !isfinite(position[2])) {
            continue;
        }
        const uint32_t first = find_first(w, position);
        if (first == UINT32_MAX) {
            insert(w, (uint32_t)v);
            continue;
        }
        const float *to = w->positions + (size_t)first * 3;
        moved += squared_distance(position, to) > 0.0 ? 1 : 0;
        memcpy(position, to, 3 * sizeof *to);
    }
    return moved;
}

svo_status svo_i_import_weld(svo_import *import, double tolerance, const char *path, svo_message *message)
{
    const size_t vertices = import->mesh.vertex_count;
    size_t slot_count = 2;
    if (tolerance < LEAST_DIFFERENCE) {
        return SVO_OK;
    }
    while (slot_count / 2 < vertices) {
        slot_count *= 2;
    }
    welder w = {.positions = (float *)import->mesh.positions, /* in import->bytes */
                .tolerance = tolerance,
                .slots = svo_i_alloc_zeroed(&import->memory, slot_count, sizeof(slot)),
                .slot_mask = slot_count - 1};
    if (w.slots == NULL) {
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory to weld %zu vertices", path, vertices);
    }
    import->info.welded_vertices = move_vertices(&w, vertices);
    svo_i_free(w.slots);
    return SVO_OK;
}
