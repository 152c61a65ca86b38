/* SPDX-License-Identifier: MIT */
/*
 * The first step of the pipeline: accepts triangles, fits the grid, snaps vertices to integers, makes the draw items.
 *
 * Vertices are rounded to odd (kernels/shared/snap.clh), so that they keep their sides of all planes between voxels:
 * what follows from the voxels of a triangle's corners is exact. The overlap test knows by how much they may be off.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "plan/accounts.h"
#include "plan/closed.h"
#include "plan/estimate.h"
#include "plan/grid.h"
#include "shared/fine.clh"
#include "shared/snap.clh"

#define VERTEX_FINITE 1u
#define VERTEX_USED   2u
/* Significant bits of a fitted grid's edge. */
#define EDGE_BITS 24
/* Triangles with this ratio of length to height are drawn by their bounds, because the corners of the expanded triangle
   are too far away for float arithmetic. */
#define NEEDLE_RATIO 4096.0

/* Triangles between two looks at the progress. */
#define TRIANGLES_TOLD 4096

/* What the items are sorted by. */
typedef struct order_key {
    uint8_t class_id;
    uint8_t size; /* size_of */
} order_key;

static uint32_t corner_index(const svo_mesh *mesh, size_t triangle, unsigned corner)
{
    const size_t index = triangle * 3 + corner;
    return mesh->indices != NULL ? mesh->indices[index] : (uint32_t)index;
}

/* Whether all indices are in range and all three vertices finite. */
static bool acceptable(const svo_mesh *mesh, const uint8_t *flags, size_t triangle)
{
    for (unsigned corner = 0; corner < 3; ++corner) {
        /* Without indices a triangle count beyond the vertices is out of range too. */
        const size_t index = mesh->indices != NULL ? mesh->indices[triangle * 3 + corner] : triangle * 3 + corner;
        if (index >= mesh->vertex_count || (flags[index] & VERTEX_FINITE) == 0) {
            return false;
        }
    }
    return true;
}

/* Marks finite vertices and those that accepted triangles use. Returns the number of refused triangles. */
static uint64_t mark_vertices(const svo_mesh *mesh, uint8_t *flags)
{
    for (size_t v = 0; v < mesh->vertex_count; ++v) {
        const bool finite = isfinite(svo_i_mesh_coordinate(mesh, v, 0)) &&
                            isfinite(svo_i_mesh_coordinate(mesh, v, 1)) && isfinite(svo_i_mesh_coordinate(mesh, v, 2));
        flags[v] = finite ? VERTEX_FINITE : 0;
    }
    uint64_t refused = 0;
    for (size_t t = 0; t < mesh->triangle_count; ++t) {
        if (!acceptable(mesh, flags, t)) {
            ++refused;
            continue;
        }
        for (unsigned corner = 0; corner < 3; ++corner) {
            flags[corner_index(mesh, t, corner)] |= VERTEX_USED;
        }
    }
    return refused;
}

/* The edge of the grid around an extent: a little above, so that the vertex at the far end lies inside and not on the
   grid's far face, in few bits, so that the planes' distances from the origin are exact doubles. */
static double fit_edge(double extent)
{
    int exponent = 0;
    const double edge = frexp(extent * (1.0 + 0x1p-20), &exponent);
    return ldexp(ceil(ldexp(edge, EDGE_BITS)), exponent - EDGE_BITS);
}

static svo_i_bounds find_bounds(const svo_mesh *mesh, const uint8_t *flags)
{
    svo_i_bounds bounds = {false, {INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    for (size_t v = 0; v < mesh->vertex_count; ++v) {
        if ((flags[v] & VERTEX_USED) == 0) {
            continue;
        }
        bounds.any = true;
        for (unsigned axis = 0; axis < 3; ++axis) {
            const double x = svo_i_mesh_coordinate(mesh, v, axis);
            bounds.low[axis] = x < bounds.low[axis] ? x : bounds.low[axis];
            bounds.high[axis] = x > bounds.high[axis] ? x : bounds.high[axis];
        }
    }
    return bounds;
}

static void fit_grid(svo_plan *plan, const svo_i_bounds *bounds)
{
    double edge = 0.0;
    for (unsigned axis = 0; axis < 3; ++axis) {
        const double width = bounds->any ? bounds->high[axis] - bounds->low[axis] : 0.0;
        /* + 0.0 turns -0 into 0; their hashes differ */
        plan->info.origin[axis] = bounds->any ? bounds->low[axis] + 0.0 : 0.0;
        edge = width > edge ? width : edge;
    }
    plan->info.edge = edge > 0.0 ? fit_edge(edge) : 1.0;
}

/* Sets the grid of a part. */
static void place_part(svo_plan *plan)
{
    const svo_part_header *header = &plan->part.header;
    plan->info.scale = header->scale;
    plan->info.edge = ldexp(header->edge, -(int)plan->part.level);
    for (unsigned axis = 0; axis < 3; ++axis) {
        plan->info.origin[axis] = header->origin[axis] + (double)plan->part.corner[axis] / header->scale;
    }
}

svo_status svo_i_plan_make_grid(svo_plan *plan, const svo_i_bounds *bounds)
{
    if (plan->has_grid) {
        return SVO_OK;
    }
    if (svo_i_plan_is_part(plan)) {
        place_part(plan);
    } else if (plan->options.edge > 0.0) {
        for (unsigned axis = 0; axis < 3; ++axis) {
            plan->info.origin[axis] = plan->options.origin[axis] + 0.0;
        }
        plan->info.edge = plan->options.edge;
    } else {
        fit_grid(plan, bounds);
    }
    if (!svo_i_plan_is_part(plan)) {
        plan->info.scale = (double)(1u << plan->info.snap_bits) / plan->info.edge;
    }
    if (!isfinite(plan->info.edge) || !isfinite(plan->info.scale) || plan->info.scale <= 0.0) {
        return svo_i_device_fail(plan->device, SVO_INVALID_ARGUMENT,
                                 "%s: a grid of edge %g cannot be scaled to 2^%u units", plan->progress.function,
                                 plan->info.edge, plan->info.snap_bits);
    }
    return SVO_OK;
}

/* What a vertex lacks that was snapped to units, an odd one of which differs from it; 2^bits parts to a unit. */
static uint64_t remainders_of(const svo_snap *snap, const svo_mesh *mesh, size_t vertex, const double origin[3],
                              const int32_t units[3], int32_t bits)
{
    int32_t parts[3];
    for (unsigned axis = 0; axis < 3; ++axis) {
        parts[axis] =
            svo_snap_remainder(snap, svo_i_mesh_coordinate(mesh, vertex, axis), origin[axis], units[axis], bits);
    }
    return svo_pack_remainders(parts[0], parts[1], parts[2]);
}

/* Snaps the used vertices. Those of a part are snapped to the whole grid, and then count from the part's corner. */
static void snap_vertices(svo_plan *plan, const svo_mesh *mesh, const uint8_t *flags)
{
    const bool is_part = svo_i_plan_is_part(plan);
    const svo_part_header *header = &plan->part.header;
    const double *origin = is_part ? header->origin : plan->info.origin;
    const svo_snap snap = is_part ? svo_make_snap(header->scale, header->edge, (int32_t)header->snap_bits)
                                  : svo_make_snap(plan->info.scale, plan->info.edge, (int32_t)plan->info.snap_bits);
    for (size_t v = 0; v < mesh->vertex_count; ++v) {
        int32_t units[3] = {0};
        for (unsigned axis = 0; axis < 3 && (flags[v] & VERTEX_USED) != 0; ++axis) {
            const double x = svo_i_mesh_coordinate(mesh, v, axis);
            const int32_t q = units[axis] = svo_snap_coordinate(&snap, x, origin[axis]);
            plan->vertices[v * 3 + axis] = abs(q) < SVO_UNITS_FAR ? q - plan->part.corner[axis] : q;
        }
        if (plan->remainders != NULL) {
            plan->remainders[v] =
                remainders_of(&snap, mesh, v, origin, units, (int32_t)(SVO_SUB_LOG2 - plan->voxel_log2));
        }
    }
}

/* The position of a snapped triangle in the grid. */
typedef struct placed {
    int32_t low[3], high[3]; /* grid units */
    int32_t first[3], last[3]; /* voxels, clamped to the grid */
    bool far; /* a vertex is beyond SVO_UNITS_MAX */
    bool outside; /* does not meet the grid */
} placed;

static placed place(const svo_plan *plan, const uint32_t corners[3])
{
    const int32_t units = (int32_t)(1u << plan->info.snap_bits);
    /* Closed voxels contain their far faces: what lies on a common face touches both voxels. */
    const int32_t closed = plan->info.coverage == SVO_COVERAGE_CLOSED ? 1 : 0;
    placed p = {.far = false, .outside = false};
    for (unsigned axis = 0; axis < 3; ++axis) {
        int32_t low = INT32_MAX;
        int32_t high = INT32_MIN;
        for (unsigned corner = 0; corner < 3; ++corner) {
            const int32_t q = plan->vertices[(size_t)corners[corner] * 3 + axis];
            low = q < low ? q : low;
            high = q > high ? q : high;
        }
        p.far = p.far || low <= -SVO_UNITS_FAR || high >= SVO_UNITS_FAR;
        p.outside = p.outside || high < 0 || low >= units + closed;
        p.low[axis] = low;
        p.high[axis] = high;
        p.first[axis] = (low < closed ? 0 : low - closed) >> plan->voxel_log2;
        p.last[axis] = (high >= units ? units - 1 : high) >> plan->voxel_log2;
    }
    return p;
}

static bool inside_grid(const svo_plan *plan, const placed *p)
{
    bool inside = true;
    for (unsigned axis = 0; axis < 3; ++axis) {
        inside = inside && p->low[axis] >= 0 && p->high[axis] < (int32_t)(1u << plan->info.snap_bits);
    }
    return inside;
}

static svo_i_class classify(const svo_plan *plan, const placed *p)
{
    int32_t widest = 0;
    for (unsigned axis = 0; axis < 3; ++axis) {
        const int32_t width = p->last[axis] - p->first[axis] + 1;
        widest = width > widest ? width : widest;
    }
    if (!inside_grid(plan, p)) {
        return SVO_I_CLASS_WIDE;
    }
    if (widest == 1 && plan->info.coverage != SVO_COVERAGE_THIN) {
        return SVO_I_CLASS_POINT;
    }
    if (widest <= SVO_NARROW_VOXELS) {
        return SVO_I_CLASS_NARROW;
    }
    return plan->info.snap_bits <= SVO_REGULAR_BITS ? SVO_I_CLASS_REGULAR : SVO_I_CLASS_WIDE;
}

void svo_i_plan_normal(const svo_plan *plan, const uint32_t corners[3], int64_t normal[3])
{
    const int32_t *a = plan->vertices + (size_t)corners[0] * 3;
    const int32_t *b = plan->vertices + (size_t)corners[1] * 3;
    const int32_t *c = plan->vertices + (size_t)corners[2] * 3;
    for (unsigned axis = 0; axis < 3; ++axis) {
        const unsigned p = (axis + 1) % 3;
        const unsigned q = (axis + 2) % 3;
        normal[axis] =
            ((int64_t)b[p] - a[p]) * ((int64_t)c[q] - a[q]) - ((int64_t)b[q] - a[q]) * ((int64_t)c[p] - a[p]);
    }
}

/* The square of the longest edge of the projection along axis; exact inside the grid. */
static double longest_squared(const svo_plan *plan, const uint32_t corners[3], unsigned axis)
{
    int64_t longest = 0;
    for (unsigned corner = 0; corner < 3; ++corner) {
        const int32_t *a = plan->vertices + (size_t)corners[corner] * 3;
        const int32_t *b = plan->vertices + (size_t)corners[(corner + 1) % 3] * 3;
        const int64_t p = (int64_t)b[(axis + 1) % 3] - a[(axis + 1) % 3];
        const int64_t q = (int64_t)b[(axis + 2) % 3] - a[(axis + 2) % 3];
        longest = p * p + q * q > longest ? p * p + q * q : longest;
    }
    return (double)longest;
}

/* The axis of projection is that of the normal's largest component, ties to the first. Degenerate triangles are
   projected along their shortest extent. So a column has at most four voxels. Needles (less than a pixel high) and
   triangles that reach outside the grid are drawn by their bounds. */
static uint32_t draw_flags(const svo_plan *plan, const uint32_t corners[3], const placed *p, const int64_t normal[3])
{
    unsigned axis = 0;
    unsigned shortest = 0;
    for (unsigned k = 1; k < 3; ++k) {
        axis = llabs(normal[k]) > llabs(normal[axis]) ? k : axis;
        shortest = p->high[k] - p->low[k] < p->high[shortest] - p->low[shortest] ? k : shortest;
    }
    if (normal[axis] == 0) {
        return shortest | SVO_DRAW_BOUNDS;
    }
    if (!inside_grid(plan, p)) {
        return axis | SVO_DRAW_BOUNDS;
    }
    const double voxel = (double)(1u << plan->voxel_log2);
    const double area = (double)llabs(normal[axis]);
    const double squared = longest_squared(plan, corners, axis);
    const bool needle = area * area < voxel * voxel * squared || area * NEEDLE_RATIO < squared;
    return axis | (needle ? SVO_DRAW_BOUNDS : 0u);
}

/* Puts a triangle outside the grid at the end of the indices, behind those of all kept ones; plan/closed.c reads it. */
static void put_outside(svo_plan *plan, const uint32_t corners[3])
{
    const uint64_t place = plan->info.triangles - plan->info.outside_triangles;
    memcpy(plan->indices + (size_t)place * 3, corners, 3 * sizeof *corners);
}

/* Whether the whole tree, of which the plan makes a part, keeps the triangle. */
static bool whole_keeps(const svo_plan *plan, const placed *p)
{
    const int32_t units = (int32_t)(1u << plan->part.header.snap_bits);
    const int32_t closed = plan->info.coverage == SVO_COVERAGE_CLOSED ? 1 : 0;
    bool meets = !p->far;
    for (unsigned axis = 0; axis < 3; ++axis) {
        meets = meets && p->high[axis] >= -plan->part.corner[axis] &&
                p->low[axis] < units + closed - plan->part.corner[axis];
    }
    return meets;
}

/* Notes the position of a part's triangle among those that the whole keeps. *whole_kept: how many of those came before.
   */
static void note_position(svo_plan *plan, size_t t, const placed *p, uint32_t *whole_kept)
{
    const uint32_t *given = plan->options.part_triangles;
    plan->part.positions[plan->triangle_count] = given != NULL ? given[t] : *whole_kept;
    *whole_kept += whole_keeps(plan, p) ? 1u : 0u;
}

/* The voxel columns that the front end "cl" visits for a triangle. */
static int64_t count_columns(const placed *p, unsigned axis)
{
    const unsigned u = (axis + 1) % 3;
    const unsigned v = (axis + 2) % 3;
    const int64_t width = p->last[u] - p->first[u] + 1;
    const int64_t height = p->last[v] - p->first[v] + 1;
    return width * height;
}

/* Whether a triangle of so many columns is cut into tiles. */
static bool is_large(int64_t columns)
{
    const int32_t most = SVO_TILE_COLUMNS;
    return columns > most;
}

/* The rank of a triangle among those of its class and block; kernels/plan/classify.cl has the same. */
static uint32_t size_of(int64_t columns)
{
    return is_large(columns) ? SVO_SIZE_LARGE : columns < SVO_SIZE_COUNT ? (uint32_t)columns : SVO_SIZE_COUNT - 1;
}

/* Keeps an accepted triangle that meets the grid, or counts it. */
static void keep_triangle(svo_plan *plan, const svo_mesh *mesh, size_t t, order_key *keys, uint32_t *whole_kept)
{
    const uint32_t corners[3] = {corner_index(mesh, t, 0), corner_index(mesh, t, 1), corner_index(mesh, t, 2)};
    const placed p = place(plan, corners);
    if (plan->part.positions != NULL) {
        note_position(plan, t, &p, whole_kept);
    }
    if (p.outside) {
        ++plan->info.outside_triangles;
        put_outside(plan, corners);
        return;
    }
    if (p.far) {
        ++plan->info.refused_triangles;
        return;
    }
    int64_t normal[3];
    svo_i_plan_normal(plan, corners, normal);
    const uint32_t kept = plan->triangle_count++;
    memcpy(plan->indices + (size_t)kept * 3, corners, sizeof corners);
    plan->triangle_ids[kept] = (uint32_t)t;
    plan->items[kept] = (svo_draw_item){kept, draw_flags(plan, corners, &p, normal)};
    keys[kept] = (order_key){(uint8_t)classify(plan, &p),
                             (uint8_t)size_of(count_columns(&p, plan->items[kept].flags & SVO_DRAW_AXIS_MASK))};
    plan->item_fragments[kept] = svo_i_estimate_add(plan, corners);
}

/* Keeps the accepted triangles. Items are in the order of the mesh; keys[] receives what they are sorted by. */
static svo_status keep_triangles(svo_plan *plan, const svo_mesh *mesh, const uint8_t *flags, order_key *keys)
{
    uint32_t whole_kept = 0;
    for (size_t t = 0; t < mesh->triangle_count; ++t) {
        if (t % TRIANGLES_TOLD == 0 &&
            svo_i_progress_add(plan, SVO_STAGE_GRID, SVO_I_KEEP_NS * (double)TRIANGLES_TOLD)) {
            SVO_I_TRY(svo_i_progress_tell(plan, SVO_STAGE_GRID));
        }
        if (acceptable(mesh, flags, t)) {
            keep_triangle(plan, mesh, t, keys, &whole_kept);
        }
    }
    return SVO_OK;
}

/* Sets vertices that no kept triangle uses to 0, since they may be out of range. */
static void clear_unused_vertices(svo_plan *plan, uint8_t *flags)
{
    memset(flags, 0, plan->vertex_count);
    for (size_t i = 0; i < (size_t)plan->triangle_count * 3; ++i) {
        flags[plan->indices[i]] = VERTEX_USED;
    }
    for (size_t v = 0; v < plan->vertex_count; ++v) {
        if (flags[v] == 0) {
            memset(plan->vertices + v * 3, 0, 3 * sizeof *plan->vertices);
        }
    }
}

/* Sorts the items begin .. end by class and size. next: the slot of each class. */
static void sort_block(const svo_plan *plan, const order_key *keys, size_t begin, size_t end, uint32_t *next,
                       svo_draw_item *items, float *fragments)
{
    uint32_t slots[SVO_I_CLASS_COUNT][SVO_SIZE_COUNT] = {{0}};
    for (size_t i = begin; i < end; ++i) {
        ++slots[keys[i].class_id][keys[i].size];
    }
    for (unsigned c = 0; c < SVO_I_CLASS_COUNT; ++c) {
        for (unsigned size = 0; size < SVO_SIZE_COUNT; ++size) {
            const uint32_t count = slots[c][size];
            slots[c][size] = next[c];
            next[c] += count;
        }
    }
    for (size_t i = begin; i < end; ++i) {
        const uint32_t slot = slots[keys[i].class_id][keys[i].size]++;
        items[slot] = plan->items[i];
        fragments[slot] = plan->item_fragments[i];
    }
}

/* Sorts the items by class, and those of a class by size within blocks of the mesh's triangles, with stable counting
   sorts. So work-items of a GPU that run together visit about as many columns, and neighbors in the mesh stay close. */
static svo_status sort_items(svo_plan *plan, const order_key *keys)
{
    const size_t count = plan->triangle_count;
    svo_draw_item *items = svo_i_alloc(&plan->device->memory, (count + 1) * sizeof *items);
    float *fragments = svo_i_alloc(&plan->device->memory, (count + 1) * sizeof *fragments);
    if (items == NULL || fragments == NULL) {
        svo_i_free(items);
        svo_i_free(fragments);
        return svo_i_device_fail(plan->device, SVO_OUT_OF_HOST_MEMORY, "svo_plan_create: no memory for %zu triangles",
                                 count);
    }
    for (size_t i = 0; i < count; ++i) {
        ++plan->class_begin[keys[i].class_id + 1];
    }
    uint32_t next[SVO_I_CLASS_COUNT];
    for (unsigned c = 0; c < SVO_I_CLASS_COUNT; ++c) {
        plan->class_begin[c + 1] += plan->class_begin[c];
        next[c] = plan->class_begin[c];
    }
    for (size_t begin = 0, end = 0; begin < count; begin = end) {
        const uint32_t block = plan->triangle_ids[begin] / SVO_SCAN_TILE;
        while (end < count && plan->triangle_ids[end] / SVO_SCAN_TILE == block) {
            ++end;
        }
        sort_block(plan, keys, begin, end, next, items, fragments);
    }
    svo_i_free(plan->items);
    svo_i_free(plan->item_fragments);
    plan->items = items;
    plan->item_fragments = fragments;
    return SVO_OK;
}

static bool item_is_large(const svo_plan *plan, uint32_t item)
{
    const placed p = place(plan, plan->indices + (size_t)plan->items[item].triangle * 3);
    return is_large(count_columns(&p, plan->items[item].flags & SVO_DRAW_AXIS_MASK));
}

static svo_large_item large_item(const svo_plan *plan, uint32_t item)
{
    const uint32_t *corners = plan->indices + (size_t)plan->items[item].triangle * 3;
    svo_large_item large = {item, plan->items[item].flags & SVO_DRAW_AXIS_MASK, plan->item_fragments[item], {0}};
    for (unsigned corner = 0; corner < 3; ++corner) {
        memcpy(large.corners + (size_t)corner * 3, plan->vertices + (size_t)corners[corner] * 3, 3 * sizeof(int32_t));
    }
    return large;
}

/* Lists the large triangles; item_fragments and class_begin are final. */
static svo_status list_large(svo_plan *plan)
{
    for (uint32_t i = 0; i < plan->triangle_count; ++i) {
        plan->large_count += item_is_large(plan, i) ? 1u : 0u;
    }
    plan->large = svo_i_alloc(&plan->device->memory, (plan->large_count + (size_t)1) * sizeof *plan->large);
    if (plan->large == NULL) {
        return svo_i_device_fail(plan->device, SVO_OUT_OF_HOST_MEMORY, "svo_plan_create: no memory for %u triangles",
                                 plan->large_count);
    }
    uint32_t count = 0;
    for (uint32_t i = 0; count < plan->large_count; ++i) {
        if (item_is_large(plan, i)) {
            plan->large[count++] = large_item(plan, i);
        }
    }
    return SVO_OK;
}

/* Allocates part.positions, in plans of parts. */
static svo_status alloc_positions(svo_plan *plan, size_t triangles)
{
    if (!svo_i_plan_is_part(plan)) {
        return SVO_OK;
    }
    plan->part.positions = svo_i_alloc(&plan->device->memory, (triangles + 1) * sizeof(uint32_t));
    return plan->part.positions != NULL
               ? SVO_OK
               : svo_i_device_fail(plan->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %zu triangles",
                                   plan->progress.function, triangles);
}

/* Replaces what was counted over the triangles of a part by the counts of the whole. */
static void take_counts(svo_plan *plan)
{
    const svo_part_header *header = &plan->part.header;
    if (svo_i_plan_is_part(plan)) {
        plan->info.triangles = header->triangles;
        plan->info.refused_triangles = header->refused_triangles;
        plan->info.outside_triangles = header->triangles - header->refused_triangles - header->kept_triangles;
        plan->work.both_sides = (header->flags & SVO_PART_BOTH_SIDES) != 0;
    }
}

svo_status svo_i_plan_grid(svo_plan *plan, const svo_mesh *mesh)
{
    const size_t vertices = mesh->vertex_count;
    const size_t triangles = mesh->triangle_count;
    svo_status status = SVO_OK;
    uint8_t *flags = svo_i_alloc_zeroed(&plan->device->memory, vertices + 1, 1);
    order_key *keys = svo_i_alloc_zeroed(&plan->device->memory, triangles + 1, sizeof *keys);
    plan->vertices = svo_i_alloc_zeroed(&plan->device->memory, vertices * 3 + 1, sizeof(int32_t));
    const bool is_fine = svo_i_plan_asks_payload(plan);
    plan->remainders = is_fine ? svo_i_alloc(&plan->device->memory, (vertices + 1) * sizeof(uint64_t)) : NULL;
    plan->indices = svo_i_alloc_zeroed(&plan->device->memory, triangles * 3 + 1, sizeof(uint32_t));
    plan->triangle_ids = svo_i_alloc(&plan->device->memory, (triangles + 1) * sizeof(uint32_t));
    plan->items = svo_i_alloc(&plan->device->memory, (triangles + 1) * sizeof(svo_draw_item));
    plan->item_fragments = svo_i_alloc(&plan->device->memory, (triangles + 1) * sizeof(float));
    if (flags == NULL || keys == NULL || plan->vertices == NULL || plan->indices == NULL ||
        plan->triangle_ids == NULL || plan->items == NULL || plan->item_fragments == NULL ||
        (is_fine && plan->remainders == NULL)) {
        status =
            svo_i_device_fail(plan->device, SVO_OUT_OF_HOST_MEMORY,
                              "svo_plan_create: no memory for %zu vertices and %zu triangles", vertices, triangles);
        goto cleanup;
    }
    SVO_I_TRY_CLEANUP(alloc_positions(plan, triangles));
    plan->vertex_count = (uint32_t)vertices;
    plan->info.triangles = triangles;
    plan->info.refused_triangles = mark_vertices(mesh, flags);
    plan->info.outside_triangles = 0;
    const svo_i_bounds bounds = find_bounds(mesh, flags);
    SVO_I_TRY_CLEANUP(svo_i_plan_make_grid(plan, &bounds));
    snap_vertices(plan, mesh, flags);
    (void)svo_i_progress_add(plan, SVO_STAGE_GRID, SVO_I_SNAP_NS * (double)vertices);
    SVO_I_TRY_CLEANUP(svo_i_progress_tell(plan, SVO_STAGE_GRID));
    SVO_I_TRY_CLEANUP(keep_triangles(plan, mesh, flags, keys));
    if ((plan->options.need & SVO_NEED_PROJECTED_AREA) != 0 && !svo_i_plan_is_part(plan)) {
        bool closed = false;
        SVO_I_TRY_CLEANUP(svo_i_plan_is_closed(plan, mesh, &closed));
        plan->work.both_sides = !closed;
    }
    clear_unused_vertices(plan, flags);
    SVO_I_TRY_CLEANUP(sort_items(plan, keys));
    svo_i_estimate_end(plan);
    take_counts(plan);
    status = list_large(plan);
cleanup:
    svo_i_free(flags);
    svo_i_free(keys);
    return status;
}
