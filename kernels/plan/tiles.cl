/* SPDX-License-Identifier: MIT */
/*
 * The tiles of large triangles of an updatable plan, whose mesh the host does not see. lib/plan/chunking.c has the same
 * steps for the host. Each tile that the projection of a triangle can meet is listed once; the order differs from run
 * to run. Tiles beyond the room are counted as a full list of fragments and the most that they can hold, so that the
 * build reports a list that is too short.
 *
 * Launch: svo_k_plan_tiles one work-item per item of a draw, in whole groups. Atomics: tile_count, which places the
 * tiles of a row, and the draw's counter of fragments.
 */
#include "plan/plan.clh"

/* Fragments of a column of one triangle, at most. */
#define SVO_COLUMN_FRAGMENTS 4u

/* A triangle's projection along its axis: its corners in voxels, and its columns inside the draw. */
typedef struct svo_projection {
    double2 corners[3];
    int2 first, end;
} svo_projection;

/* The components u and v of a point. */
static int2 svo_project_point(int3 p, uint axis)
{
    return axis == 0u ? p.yz : axis == 1u ? p.zx : p.xy;
}

static svo_projection svo_project(__global const int *vertices, __global const uint *indices, svo_draw_item item,
                                  const svo_voxelize_params *params)
{
    const uint axis = item.flags & SVO_DRAW_AXIS_MASK;
    const uint3 at = vload3(item.triangle, indices);
    const int2 a = svo_project_point(vload3(at.x, vertices), axis);
    const int2 b = svo_project_point(vload3(at.y, vertices), axis);
    const int2 c = svo_project_point(vload3(at.z, vertices), axis);
    const int2 limit = (int2)((1 << params->depth) - 1);
    const int2 low = min(a, min(b, c)) - (int)(1u - params->open);
    const int2 high = max(a, max(b, c));
    const int2 corner = (int2)((int)params->left, (int)params->bottom);
    const double voxel = (double)(1u << params->voxel_log2);
    svo_projection p;
    p.corners[0] = convert_double2(a) / voxel;
    p.corners[1] = convert_double2(b) / voxel;
    p.corners[2] = convert_double2(c) / voxel;
    p.first = max(clamp(low >> (int2)(params->voxel_log2), (int2)(0), limit), corner);
    p.end = min(clamp(high >> (int2)(params->voxel_log2), (int2)(0), limit) + 1,
                corner + (int2)((int)params->width, (int)params->height));
    return p;
}

/* Whether svo_k_voxelize leaves the triangle to tiles. */
static bool svo_needs_tiles(const svo_projection *p)
{
    const int2 size = p->end - p->first;
    return size.x > 0 && size.y > 0 && (long)size.x * size.y > SVO_TILE_COLUMNS;
}

/* The range of u of the projection between two values of v; x is above y if the projection is not there. */
static double2 svo_band_reach(const svo_projection *p, double from, double to)
{
    double2 reach = (double2)(INFINITY, -INFINITY);
    for (uint corner = 0; corner < 3u; ++corner) {
        const double2 a = p->corners[corner];
        const double2 b = p->corners[corner < 2u ? corner + 1u : 0u];
        const double rise = b.y - a.y;
        if (rise == 0.0 && (a.y < from || a.y > to)) {
            continue;
        }
        /* Where the edge enters and leaves the band, as fractions of its length. */
        const double at_from = rise != 0.0 ? (from - a.y) / rise : 0.0;
        const double at_to = rise != 0.0 ? (to - a.y) / rise : 1.0;
        const double enter = fmax(fmin(at_from, at_to), 0.0);
        const double leave = fmin(fmax(at_from, at_to), 1.0);
        if (enter <= leave) {
            const double at_enter = a.x + enter * (b.x - a.x);
            const double at_leave = a.x + leave * (b.x - a.x);
            reach.x = fmin(reach.x, fmin(at_enter, at_leave));
            reach.y = fmax(reach.y, fmax(at_enter, at_leave));
        }
    }
    return reach;
}

/* The first and one past the last tile of the row at v, with a margin of one voxel on every side for the rounding of
   doubles and closed voxels' far faces. */
static int2 svo_tiles_of_row(const svo_projection *p, int v)
{
    const double2 reach = svo_band_reach(p, v - 1.0, v + SVO_TILE_EDGE + 1.0);
    const double end = (double)((p->end.x - 1 - p->first.x) / SVO_TILE_EDGE + 1);
    if (reach.x > reach.y) {
        return (int2)(0, 0);
    }
    const double first = floor((reach.x - 1.0 - p->first.x) / SVO_TILE_EDGE);
    const double last = floor((reach.y + 1.0 - p->first.x) / SVO_TILE_EDGE);
    const int2 tiles = convert_int2(clamp((double2)(first, last + 1.0), (double2)(0.0), (double2)(end)));
    return tiles;
}

static void svo_add_to_counter(__global uint *counter, ulong count)
{
    const uint low = (uint)count;
    const uint old = atomic_add((volatile __global uint *)counter, low);
    const uint high = (uint)(count >> 32) + (old + low < old ? 1u : 0u);
    if (high > 0u) {
        atomic_add((volatile __global uint *)counter + 1, high);
    }
}

/* Counts tiles first .. first + count - 1, of which the room holds those before tile_count, as fragments. */
static void svo_count_missing(uint first, uint count, __global uint *counter, const svo_voxelize_params *params)
{
    const uint room = params->tile_count;
    const uint missing = first + count - max(first, room);
    if (first + count > room) {
        const ulong list = first <= room ? params->capacity : 0u;
        svo_add_to_counter(counter, list + (ulong)missing * (SVO_TILE_COLUMNS * SVO_COLUMN_FRAGMENTS));
    }
}

/* params.tile_count: the room for tiles. Unused tiles hold an item that is SVO_DRAW_NOTHING. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_plan_tiles(__global const int *vertices, __global const uint *indices, __global const svo_draw_item *items,
                 __global svo_tile_item *tiles, volatile __global uint *tile_count, __global uint *counters,
                 svo_voxelize_params params)
{
    const uint id = (uint)get_global_id(0);
    if (id >= params.item_count || items[params.first_item + id].flags == SVO_DRAW_NOTHING) {
        return;
    }
    const svo_projection p = svo_project(vertices, indices, items[params.first_item + id], &params);
    for (int v = p.first.y; v < (svo_needs_tiles(&p) ? p.end.y : p.first.y); v += SVO_TILE_EDGE) {
        const int2 row = svo_tiles_of_row(&p, v);
        const uint count = (uint)(row.y - row.x);
        const uint first = count > 0u ? atomic_add(tile_count, count) : 0u;
        for (uint k = 0; k < count && first + k < params.tile_count; ++k) {
            tiles[first + k].item = params.first_item + id;
            tiles[first + k].corner = (uint)(p.first.x + (row.x + (int)k) * SVO_TILE_EDGE) | (uint)v << 16;
        }
        svo_count_missing(first, count, counters + SVO_COUNTER_WORDS * params.counter, &params);
    }
}
