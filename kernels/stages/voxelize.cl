/* SPDX-License-Identifier: MIT */
/*
 * Voxelization: triangles become fragments. Each triangle is projected along the axis of its normal's largest
 * component. For each column of voxels in the projection the plane bounds the candidates, and the test of overlap.clh
 * decides, or leaves them undecided. Does in one pass of OpenCL what the raster front end does with a rasterizer
 * (glinterop/raster).
 *
 *   svo_k_voxelize  one draw of a chunk: each work-item finds its fragments and notes them by columns in local
 *                   memory, the group reserves space for all of them at once, and each work-item writes its own
 *
 * On CPUs (SVO_COLUMN_LANES) the first work-item does the work of its group. It collects fragments in local memory and
 * reserves space when that is full. Columns of the narrow class are tested eight at a time (column_lanes.clh), and of a
 * triangle inside one voxel it reads a single corner. The fragments are the same.
 *
 * Launch: one work-item per triangle, rounded up to whole groups, then one per tile of the triangles with more than
 * SVO_TILE_COLUMNS columns. The first kind skips those triangles, so no work-item handles more than one tile's columns.
 * The plan sorts items and tiles so that neighbors have about as many columns (lib/plan/grid.c).
 * Reads vertices, indices, items, tiles; writes the chunk's fragments from its start, the undecided ones from its end
 * backwards, and its counters; kernels/stages/decide.cl goes on.
 * Atomics: an atomic_add on a counter's low word for each space, an atomic_inc on the high word when that wraps. All
 * fragments are counted, in 64 bits, however few fit; nothing is written beyond the capacity. An atomic_or reads the
 * counter of the other end.
 * Invariant: what touches does not depend on the launch; the order does, and which fragments are undecided.
 *
 * Defines: SVO_NARROW, SVO_WIDE or neither: the class of the triangles (overlap.clh); SVO_NO_TEST: triangles inside one
 * voxel; SVO_THIN; SVO_CODE48; SVO_COLUMN_LANES.
 *
 * A note is the run of voxels of one column: which of the work-item's columns, counted row by row, and the first voxel
 * on t plus SVO_NOTE_BIAS, counted from the first voxel of the first note:
 *
 *   15         14 13                6 5        0
 *   [ length - 1 ] [ first voxel on t ] [ column ]
 *
 * A column of a triangle has at most four voxels, since no component of its normal is larger than the one along t (or,
 * without a normal, no extent is shorter), also with what errors of its corners may add. So the first voxels of two of
 * at most 64 columns are no more than 67 apart. Notes of columns with an undecided voxel lie at the end of the array,
 * the first one last.
 */
#include "shared/fragment.clh"
#include "shared/group.clh"
#include "shared/span.clh"
#include "stages/column_lanes.clh"

typedef ushort svo_note;

#define SVO_NOTE_BIAS 128
/* Words of a work-item's notes; odd, so that those of neighbors lie in different banks of local memory. */
#define SVO_NOTE_WORDS (SVO_TILE_COLUMNS / 2 + 1)
#define SVO_LAST_NOTE  (2 * SVO_NOTE_WORDS - 1)

/* What a work-item has found: notes and fragments, of those the undecided, and the voxel on t that notes count from. */
typedef struct svo_found {
    uint notes, fragments;
    uint undecided_notes, undecided;
    int first;
} svo_found;

/* A triangle, permuted so that t is its axis of projection (overlap.clh). */
typedef struct svo_placed {
    svo_point a, b, c; /* units, from the corner of the first voxel */
    svo_point first; /* its first voxel */
    svo_point last; /* its last voxel, from the first */
    int voxel_log2; /* of the units of a voxel */
    svo_plane normal;
    svo_slope slope; /* by the grid's units */
    uint axis;
    uint triangle;
} svo_placed;

/* A rectangle of voxel columns, the ends exclusive; empty where an end is not above its begin. */
typedef struct svo_window {
    int u, v;
    int end_u, end_v;
} svo_window;

/* What fragments are made from, besides the notes. */
typedef struct svo_source {
    svo_point corner; /* the voxel the notes count from; on t the triangle's first */
    uint width; /* columns of a row */
    uint axis;
    uint triangle;
} svo_source;

SVO_FUNCTION svo_point svo_turn(int3 p, uint axis)
{
    return axis == 0u   ? svo_make_point(p.y, p.z, p.x)
           : axis == 1u ? svo_make_point(p.z, p.x, p.y)
                        : svo_make_point(p.x, p.y, p.z);
}

SVO_FUNCTION svo_placed svo_place(__global const int *vertices, __global const uint *indices, svo_draw_item item,
                                  svo_voxelize_params params)
{
    svo_placed r;
    const uint3 corners = vload3(item.triangle, indices);
    const int3 a = vload3(corners.x, vertices);
    const int3 b = vload3(corners.y, vertices);
    const int3 c = vload3(corners.z, vertices);
    const int3 limit = (int3)((1 << params.depth) - 1);
    const int voxel_log2 = (int)params.voxel_log2;
    const int3 low = min(a, min(b, c)) - (int)(1u - params.open);
    const int3 first = clamp(low >> voxel_log2, (int3)(0), limit);
    const int3 last = clamp(max(a, max(b, c)) >> voxel_log2, (int3)(0), limit) - first;
    const int3 corner = first << voxel_log2;
    const int dropped = svo_dropped_bits(max(last.x, max(last.y, last.z)), voxel_log2);
    r.voxel_log2 = voxel_log2 - dropped;
    r.axis = item.flags & SVO_DRAW_AXIS_MASK;
    r.triangle = item.triangle;
    r.a = svo_turn(a - corner, r.axis);
    r.b = svo_turn(b - corner, r.axis);
    r.c = svo_turn(c - corner, r.axis);
    r.normal = svo_normal(r.a, r.b, r.c);
    r.slope = svo_slope_of(r.normal.nu, r.normal.nv, r.normal.nt);
    if (dropped != 0) {
        r.a = svo_coarse_point(r.a, dropped);
        r.b = svo_coarse_point(r.b, dropped);
        r.c = svo_coarse_point(r.c, dropped);
        r.normal = svo_normal(r.a, r.b, r.c);
    }
    r.first = svo_turn(first, r.axis);
    r.last = svo_turn(last, r.axis);
    return r;
}

/* The triangle's columns inside the draw. */
SVO_FUNCTION svo_window svo_draw_window(svo_placed placed, svo_voxelize_params params)
{
    svo_window r;
    r.u = max(placed.first.u, (int)params.left);
    r.v = max(placed.first.v, (int)params.bottom);
    r.end_u = min(placed.first.u + placed.last.u + 1, (int)(params.left + params.width));
    r.end_v = min(placed.first.v + placed.last.v + 1, (int)(params.bottom + params.height));
    return r;
}

SVO_FUNCTION svo_window svo_tile_window(svo_window draw, svo_tile_item tile)
{
    svo_window r;
    r.u = (int)(tile.corner & 0xffffu);
    r.v = (int)(tile.corner >> 16);
    r.end_u = min(draw.end_u, r.u + SVO_TILE_EDGE);
    r.end_v = min(draw.end_v, r.v + SVO_TILE_EDGE);
    return r;
}

SVO_FUNCTION svo_source svo_source_of(svo_placed placed, svo_window window)
{
    svo_source r;
    r.corner = svo_make_point(window.u, window.v, placed.first.t);
    r.width = (uint)(window.end_u - window.u);
    r.axis = placed.axis;
    r.triangle = placed.triangle;
    return r;
}

#ifndef SVO_NO_TEST

/* The voxels of the column at (u, v), from the triangle's first voxel, that may touch the triangle: consecutive, since
   it is convex. x: the first of them, y: how many, z: whether they do: SVO_TOUCHES, or column if that is weaker. */
SVO_FUNCTION int3 svo_column_run(svo_overlap overlap, svo_placed placed, int u, int v, int voxel_log2, float reach,
                                 int column)
{
    int3 run = (int3)(0, 0, column);
    const svo_span span = svo_column_span(placed.slope, placed.a, u, v, 1 << voxel_log2, placed.last.t, reach);
    for (int k = span.first; k <= span.last; ++k) {
        const int touches = svo_overlap_voxel(overlap, u, v, k << voxel_log2);
        if (touches != SVO_TOUCHES_NOT) {
            run.x = run.y == 0 ? k : run.x;
            ++run.y;
            run.z = svo_weaker(run.z, touches);
        } else if (run.y > 0) {
            break;
        }
    }
    return run;
}

/* The largest coordinate, for svo_column_span. */
SVO_FUNCTION float svo_reach_of(svo_placed placed)
{
    const uint u = max(abs(placed.a.u), max(abs(placed.b.u), abs(placed.c.u)));
    const uint v = max(abs(placed.a.v), max(abs(placed.b.v), abs(placed.c.v)));
    const uint t = max(abs(placed.a.t), max(abs(placed.b.t), abs(placed.c.t)));
    return (float)max(u, max(v, t));
}

/* Notes the runs of all columns of the window, which is not empty: in one loop, since in a loop over rows and one over
   their columns neighbors would wait for each other's longest row. */
SVO_FUNCTION svo_found svo_scan_columns(svo_placed placed, svo_window window, svo_voxelize_params params,
                                        __local svo_note *notes)
{
    const int voxel_log2 = placed.voxel_log2;
    const svo_overlap overlap =
        svo_make_overlap(placed.a, placed.b, placed.c, 1 << voxel_log2, (int)params.open, (int)placed.axis);
    const float reach = svo_reach_of(placed);
    const uint columns = (uint)((window.end_u - window.u) * (window.end_v - window.v));
    svo_found found = {0u, 0u, 0u, 0u, 0};
    int u = window.u;
    int v = window.v;
    for (uint column = 0; column < columns; ++column) {
        const int local_u = (u - placed.first.u) << voxel_log2;
        const int local_v = (v - placed.first.v) << voxel_log2;
        ++u;
        if (u == window.end_u) {
            u = window.u;
            ++v;
        }
        const int touches = svo_overlap_column(overlap, local_u, local_v);
        if (touches == SVO_TOUCHES_NOT) {
            continue;
        }
        const int3 run = svo_column_run(overlap, placed, local_u, local_v, voxel_log2, reach, touches);
        if (run.y > 0) {
            found.first = found.notes + found.undecided_notes == 0u ? run.x : found.first;
            const uint first = (uint)(run.x - found.first + SVO_NOTE_BIAS);
            const bool is_sure = run.z == SVO_TOUCHES;
            const uint place = is_sure ? found.notes : SVO_LAST_NOTE - found.undecided_notes;
            notes[place] = (svo_note)(column | first << 6 | (uint)(run.y - 1) << 14);
            found.notes += is_sure ? 1u : 0u;
            found.fragments += is_sure ? (uint)run.y : 0u;
            found.undecided_notes += is_sure ? 0u : 1u;
            found.undecided += is_sure ? 0u : (uint)run.y;
        }
    }
    return found;
}

#endif

/* Whether there are columns, and no more than a work-item takes. Tiles cover larger windows, or the rasterizer does. */
SVO_FUNCTION bool svo_fits(svo_window window, svo_voxelize_params params)
{
    const int width = clamp(window.end_u - window.u, 0, SVO_TILE_COLUMNS + 1);
    const int height = clamp(window.end_v - window.v, 0, SVO_TILE_COLUMNS + 1);
    return width * height > 0 && width * height <= (int)params.most_columns;
}

/* The same for any window: finds nothing in one that does not fit. */
SVO_FUNCTION svo_found svo_find(svo_placed placed, svo_window window, svo_voxelize_params params,
                                __local svo_note *notes)
{
    const svo_found nothing = {0u, 0u, 0u, 0u, 0};
    if (!svo_fits(window, params)) {
        return nothing;
    }
    if (params.one_voxel != 0u) {
        const svo_found one = {1u, 1u, 0u, 0u, 0};
        notes[0] = SVO_NOTE_BIAS << 6;
        return one;
    }
#ifdef SVO_NO_TEST
    (void)placed;
    return nothing; /* only triangles inside one voxel come here */
#else
    return svo_scan_columns(placed, window, params, notes);
#endif
}

/* Reserves slots for fragments; returns the first. */
SVO_FUNCTION uint svo_reserve(uint count, __global uint *counter)
{
    const uint base = atomic_add(counter, count);
    if (base + count < base) {
        atomic_inc(counter + 1);
    }
    return base;
}

/* How many slots those of the other counter leave, so far: beyond, fragments from both ends would meet, and the chunk
   is too small. */
SVO_FUNCTION uint svo_slots_left(uint capacity, __global uint *other)
{
    return capacity - min(atomic_or(other, 0u), capacity);
}

/* The work-item's triangle or tile; false if it has none. */
SVO_FUNCTION bool svo_get_part(uint id, __global const svo_draw_item *items, __global const svo_tile_item *tiles,
                               svo_voxelize_params params, svo_tile_item *part)
{
    const uint tile = id - params.first_tile_id;
    bool has_part = tile < params.tile_count;
    if (id < params.first_tile_id) {
        part->item = params.first_item + id;
        part->corner = 0u;
        has_part = id < params.item_count;
    } else if (has_part) {
        *part = tiles[params.first_tile + tile];
    }
    return has_part && items[part->item].flags != SVO_DRAW_NOTHING;
}

/* The columns of a part. */
SVO_FUNCTION svo_window svo_part_window(uint id, svo_placed placed, svo_tile_item part, svo_voxelize_params params)
{
    const svo_window draw = svo_draw_window(placed, params);
    return id < params.first_tile_id ? draw : svo_tile_window(draw, part);
}

/* The code of a note's column: of its voxel that is 0 on the axis of projection. */
SVO_FUNCTION svo_code svo_column_code(uint note, svo_source source)
{
    const uint column = note & 63u;
    const uint v = column / source.width;
    const uint u = column - v * source.width;
    const uint at_u = source.axis == 2u ? 0u : source.axis + 1u;
    const uint at_v = source.axis == 0u ? 2u : source.axis - 1u;
    return svo_axis_code((uint)source.corner.u + u) << at_u | svo_axis_code((uint)source.corner.v + v) << at_v;
}

/* The first voxel of a note's run, on the axis of projection. */
SVO_FUNCTION uint svo_run_begin(uint note, svo_source source, svo_found found)
{
    return (uint)(source.corner.t + found.first + (int)(note >> 6 & 255u) - SVO_NOTE_BIAS);
}

SVO_FUNCTION uint svo_run_length(uint note)
{
    return (note >> 14) + 1u;
}

#ifdef SVO_COLUMN_LANES

/* Fragments that are not written yet, the undecided ones at the end, the first one last. */
typedef struct svo_stage {
    __local uint *fragments;
    uint count, undecided;
} svo_stage;

/* Local memory: the notes of one part, then the stage. A part has at most SVO_PART_FRAGMENTS. */
#define SVO_STAGE_ROOM     ((SVO_VOXELIZE_STAGE_WORDS - SVO_NOTE_WORDS) / SVO_FRAGMENT_WORDS)
#define SVO_PART_FRAGMENTS (4 * SVO_TILE_COLUMNS)

SVO_FUNCTION void svo_push(svo_stage *stage, svo_code code, uint triangle, bool is_sure)
{
    const uint place = is_sure ? stage->count : SVO_STAGE_ROOM - 1u - stage->undecided;
    __local uint *words = stage->fragments + place * SVO_FRAGMENT_WORDS;
    words[0] = (uint)code;
#ifdef SVO_CODE48
    words[1] = (uint)(code >> 32);
#endif
    words[SVO_FRAGMENT_WORDS - 1] = triangle;
    stage->count += is_sure ? 1u : 0u;
    stage->undecided += is_sure ? 0u : 1u;
}

/* Writes the stage's fragments, up to the capacity, and empties it. */
SVO_FUNCTION void svo_flush(svo_stage *stage, __global uint *counters, __global uint *fragments, uint capacity)
{
    if (stage->count > 0u) {
        const uint slot = svo_reserve(stage->count, counters);
        const uint left = svo_slots_left(capacity, counters + 2);
        const uint taken = min(stage->count, left - min(slot, left));
        __global uint *words = fragments + (size_t)slot * SVO_FRAGMENT_WORDS;
        for (uint i = 0; i < taken * SVO_FRAGMENT_WORDS; ++i) {
            words[i] = stage->fragments[i];
        }
    }
    if (stage->undecided > 0u) {
        const uint slot = svo_reserve(stage->undecided, counters + 2);
        const uint left = svo_slots_left(capacity, counters);
        const uint taken = min(stage->undecided, left - min(slot, left));
        __global uint *words = fragments + ((size_t)capacity - slot - taken) * SVO_FRAGMENT_WORDS;
        for (uint i = 0; i < taken * SVO_FRAGMENT_WORDS; ++i) {
            words[i] = stage->fragments[(SVO_STAGE_ROOM - taken) * SVO_FRAGMENT_WORDS + i];
        }
    }
    stage->count = 0u;
    stage->undecided = 0u;
}

SVO_FUNCTION void svo_push_run(uint note, svo_found found, svo_source source, svo_stage *stage, bool is_sure)
{
    const svo_code column = svo_column_code(note, source);
    const uint first = svo_run_begin(note, source, found);
    for (uint k = 0; k < svo_run_length(note); ++k) {
        svo_push(stage, column | svo_axis_code(first + k) << source.axis, source.triangle, is_sure);
    }
}

SVO_FUNCTION void svo_push_notes(__local const svo_note *notes, svo_found found, svo_source source, svo_stage *stage)
{
    for (uint i = 0; i < found.notes; ++i) {
        svo_push_run(notes[i], found, source, stage, true);
    }
    for (uint i = 0; i < found.undecided_notes; ++i) {
        svo_push_run(notes[SVO_LAST_NOTE - i], found, source, stage, false);
    }
}

#ifdef SVO_SCANS_LANES

/* Pushes the fragments of eight columns at (u, v), in voxels from the triangle's first; inside: those that count. */
SVO_FUNCTION void svo_push_columns(const svo_column_test *test, const svo_placed *placed, uint8 u, uint8 v, int8 inside,
                                   svo_stage *stage)
{
    const uint8 local_u = u << test->voxel_log2;
    const uint8 local_v = v << test->voxel_log2;
    int8 sure;
    inside &= svo_meets_columns(test, local_u, local_v, &sure);
    if (svo_lanes(inside) == 0u) {
        return;
    }
    const uint at_u = placed->axis == 2u ? 0u : placed->axis + 1u;
    const uint at_v = placed->axis == 0u ? 2u : placed->axis - 1u;
    const svo_code8 columns =
        svo_axis_codes((uint)placed->first.u + u) << at_u | svo_axis_codes((uint)placed->first.v + v) << at_v;
    svo_column_lanes at = svo_begin_columns(test, local_u, local_v, sure);
    svo_code8 heights = svo_axis_codes((uint)placed->first.t + as_uint8(at.first));
    for (inside &= at.first <= at.last; svo_lanes(inside) != 0u; inside &= at.first <= at.last) {
        const int8 found = inside & svo_meets_voxels(test, &at, &sure);
        uint decided = svo_lanes(found & sure);
        uint undecided = svo_lanes(found & ~sure);
        svo_code codes[8];
        vstore8(columns | heights << placed->axis, 0, codes);
        for (; decided != 0u; decided &= decided - 1u) {
            svo_push(stage, codes[svo_lowest_lane(decided)], placed->triangle, true);
        }
        for (; undecided != 0u; undecided &= undecided - 1u) {
            svo_push(stage, codes[svo_lowest_lane(undecided)], placed->triangle, false);
        }
        svo_next_voxels(test, &at);
        heights = svo_next_axis_codes(heights);
    }
}

/* Pushes the fragments of a window of at most SVO_TILE_COLUMNS columns, row after row, eight columns at a time. */
SVO_FUNCTION void svo_push_window(svo_placed placed, svo_window window, svo_voxelize_params params, svo_stage *stage)
{
    const svo_column_test test = svo_make_column_test(placed.a, placed.b, placed.c, placed.normal, placed.slope,
                                                      placed.voxel_log2, (uint)placed.last.t, (int)params.open);
    const uint width = (uint)(window.end_u - window.u);
    const uint count = width * (uint)(window.end_v - window.v);
    const uint rows = 65536u / width + 1u; /* i * rows >> 16 is i / width for i below SVO_TILE_COLUMNS */
    for (uint first = 0; first < count; first += 8u) {
        const uint8 column = min(first + (uint8)(0u, 1u, 2u, 3u, 4u, 5u, 6u, 7u), (uint8)(count - 1u));
        const uint8 v = column * rows >> 16;
        const uint8 u = column - v * width;
        const int8 inside = first + (uint8)(0u, 1u, 2u, 3u, 4u, 5u, 6u, 7u) < count;
        svo_push_columns(&test, &placed, u + (uint)(window.u - placed.first.u), v + (uint)(window.v - placed.first.v),
                         inside, stage);
    }
}

#endif

/* Pushes the fragment of a triangle inside one voxel, which any of its corners names. */
SVO_FUNCTION void svo_push_one(__global const int *vertices, __global const uint *indices, svo_draw_item item,
                               svo_voxelize_params params, svo_stage *stage)
{
    const int3 corner = vload3(indices[3 * (size_t)item.triangle], vertices);
    const int3 voxel = clamp(corner >> (int)params.voxel_log2, (int3)(0), (int3)((1 << params.depth) - 1));
    const svo_point at = svo_turn(voxel, item.flags & SVO_DRAW_AXIS_MASK);
    if ((uint)at.u - params.left < params.width && (uint)at.v - params.bottom < params.height) {
        svo_push(stage,
                 svo_axis_code((uint)voxel.x) | svo_axis_code((uint)voxel.y) << 1 | svo_axis_code((uint)voxel.z) << 2,
                 item.triangle, true);
    }
}

/* The same of a triangle in several voxels, for any window. */
SVO_FUNCTION void svo_push_part(svo_placed placed, svo_window window, svo_voxelize_params params,
                                __local svo_note *notes, svo_stage *stage)
{
#ifdef SVO_SCANS_LANES
    (void)notes;
    if (svo_fits(window, params)) {
        svo_push_window(placed, window, params, stage);
    }
#else
    const svo_found found = svo_find(placed, window, params, notes);
    svo_push_notes(notes, found, svo_source_of(placed, window), stage);
#endif
}

/* The kernel's buffers. */
typedef struct svo_draw {
    __global const int *vertices;
    __global const uint *indices;
    __global const svo_draw_item *items;
    __global const svo_tile_item *tiles;
    __global uint *counters, *fragments;
} svo_draw;

/* Makes the fragments of the group whose first work-item is given. */
SVO_CALLED void svo_draw_group(uint first, const svo_draw *draw, svo_voxelize_params params, __local uint *words)
{
    __local svo_note *notes = (__local svo_note *)words;
    svo_stage stage = {words + SVO_NOTE_WORDS, 0u, 0u};
    for (uint id = first; id < first + SVO_GROUP_ITEMS; ++id) {
        svo_tile_item part;
        if (svo_get_part(id, draw->items, draw->tiles, params, &part)) {
            const svo_draw_item item = draw->items[part.item];
            if (params.one_voxel != 0u) {
                svo_push_one(draw->vertices, draw->indices, item, params, &stage);
            } else {
                const svo_placed placed = svo_place(draw->vertices, draw->indices, item, params);
                svo_push_part(placed, svo_part_window(id, placed, part, params), params, notes, &stage);
            }
        }
        if (stage.count + stage.undecided + SVO_PART_FRAGMENTS > SVO_STAGE_ROOM) {
            svo_flush(&stage, draw->counters, draw->fragments, params.capacity);
        }
    }
    svo_flush(&stage, draw->counters, draw->fragments, params.capacity);
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_voxelize(__global const int *vertices, __global const uint *indices, __global const svo_draw_item *items,
               __global const svo_tile_item *tiles, __global uint *counters, __global uint *fragments,
               svo_voxelize_params params, __local uint *words, __local uint *scratch)
{
    (void)scratch;
    if (get_local_id(0) == 0u) {
        const svo_draw draw = {vertices, indices, items, tiles, counters + SVO_COUNTER_WORDS * params.counter,
                               fragments};
        svo_draw_group((uint)get_global_id(0), &draw, params, words);
    }
}

#else

/* Where a work-item's fragments go: to the slots from next on, or, if they are undecided, as far from the end. */
typedef struct svo_slots {
    uint next, left; /* left: svo_slots_left */
    uint capacity;
    bool is_sure;
} svo_slots;

/* Reserves slots for the group's fragments. counters: the chunk's. */
SVO_FUNCTION svo_slots svo_reserve_group(uint count, __global uint *counters, uint capacity, bool is_sure,
                                         __local uint *scratch)
{
    svo_slots r = {0u, 0u, capacity, is_sure};
    uint total;
    const uint before = svo_group_exclusive(count, scratch, &total);
    if (get_local_id(0) == 0u && total > 0u) {
        scratch[0] = svo_reserve(total, counters + (is_sure ? 0u : 2u));
        scratch[1] = svo_slots_left(capacity, counters + (is_sure ? 2u : 0u));
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    r.next = scratch[0] + before;
    r.left = scratch[1];
    barrier(CLK_LOCAL_MEM_FENCE);
    return r;
}

/* Writes the fragments of a note, those that there are slots for. */
SVO_FUNCTION void svo_write_run(uint note, svo_found found, svo_source source, __global uint *fragments,
                                svo_slots *slots)
{
    const svo_code column = svo_column_code(note, source);
    const uint first = svo_run_begin(note, source, found);
    for (uint k = 0; k < svo_run_length(note); ++k) {
        if (slots->next < slots->left) {
            const svo_code code = column | svo_axis_code(first + k) << source.axis;
            const uint place = slots->is_sure ? slots->next : slots->capacity - 1u - slots->next;
            svo_fragment_store(fragments, place, code, source.triangle);
        }
        ++slots->next;
    }
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_voxelize(__global const int *vertices, __global const uint *indices, __global const svo_draw_item *items,
               __global const svo_tile_item *tiles, __global uint *counters, __global uint *fragments,
               svo_voxelize_params params, __local uint *words, __local uint *scratch)
{
    const uint id = (uint)get_global_id(0);
    __local svo_note *notes = (__local svo_note *)(words + (uint)get_local_id(0) * SVO_NOTE_WORDS);
    svo_found found = {0u, 0u, 0u, 0u, 0};
    svo_source source = {{0, 0, 0}, 1u, 0u, 0u};
    svo_tile_item part;
    if (svo_get_part(id, items, tiles, params, &part)) {
        const svo_placed placed = svo_place(vertices, indices, items[part.item], params);
        const svo_window window = svo_part_window(id, placed, part, params);
        source = svo_source_of(placed, window);
        found = svo_find(placed, window, params, notes);
    }
    __global uint *own = counters + SVO_COUNTER_WORDS * params.counter;
    svo_slots slots = svo_reserve_group(found.fragments, own, params.capacity, true, scratch);
    for (uint i = 0; i < found.notes; ++i) {
        svo_write_run(notes[i], found, source, fragments, &slots);
    }
    slots = svo_reserve_group(found.undecided, own, params.capacity, false, scratch);
    for (uint i = 0; i < found.undecided_notes; ++i) {
        svo_write_run(notes[SVO_LAST_NOTE - i], found, source, fragments, &slots);
    }
}

#endif
