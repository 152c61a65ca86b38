/* SPDX-License-Identifier: MIT */
/*
 * Rays against the triangles of a tree's leaf lists, which lie in a grid of two levels in place of the tree: a dense
 * array of bricks, and in each brick that has leaves a dense array of cells, one per voxel. Both levels are walked by
 * 3-D DDA (Amanatides and Woo, "A Fast Voxel Traversal Algorithm for Ray Tracing", 1987); triangles are tested in
 * float (Moeller and Trumbore, "Fast, Minimum Storage Ray-Triangle Intersection", 1997). For comparison with svocl.
 *
 * Lengths are in units of the snapped grid, t is that of the ray. Every step leaves a cell in the ray's direction, so
 * all walks end.
 */

#define NO_BRICK    0xffffffffu
#define NO_TRIANGLE 0xffffffffu

typedef struct two_levels {
    __global const uint *bricks; /* by x, then y, then z; NO_BRICK where there are no leaves */
    __global const uint *cells; /* by brick, then Morton code: the cell's first entry of the list; the next ends it */
    __global const uint *list;
    __global const int *vertices;
    __global const uint *indices;
    uint grid_log2; /* bricks per axis */
    uint brick_log2; /* cells per axis of a brick */
    float width; /* of a cell */
} two_levels;

typedef struct grid_ray {
    float3 origin, direction, inverse;
    float t_min, t_max;
} grid_ray;

typedef struct nearest_hit {
    float t, u, v;
    uint triangle;
    uint cell_count; /* cells with triangles that were visited */
} nearest_hit;

/* A place on one level. */
typedef struct walk {
    int3 cell, low, high; /* the first and the last cell of this level's box */
    float3 leave; /* t where the ray leaves the cell along each axis */
    float width;
} walk;

static float leave_axis(float origin, float direction, float inverse, int cell, float width)
{
    const int plane = direction > 0.0f ? cell + 1 : cell;
    return direction != 0.0f ? ((float)plane * width - origin) * inverse : INFINITY;
}

static void walk_begin(const grid_ray *ray, float t, int3 low, int3 high, float width, walk *at)
{
    at->low = low;
    at->high = high;
    at->width = width;
    at->cell = clamp(convert_int3_rtn((ray->origin + t * ray->direction) / width), low, high);
    at->leave.x = leave_axis(ray->origin.x, ray->direction.x, ray->inverse.x, at->cell.x, width);
    at->leave.y = leave_axis(ray->origin.y, ray->direction.y, ray->inverse.y, at->cell.y, width);
    at->leave.z = leave_axis(ray->origin.z, ray->direction.z, ray->inverse.z, at->cell.z, width);
}

static float walk_leave(const walk *at)
{
    return min(at->leave.x, min(at->leave.y, at->leave.z));
}

/* To the next cell. Returns false outside the box. */
static bool walk_step(const grid_ray *ray, walk *at)
{
    if (at->leave.x <= at->leave.y && at->leave.x <= at->leave.z) {
        at->cell.x += ray->direction.x > 0.0f ? 1 : -1;
        at->leave.x = leave_axis(ray->origin.x, ray->direction.x, ray->inverse.x, at->cell.x, at->width);
        return at->cell.x >= at->low.x && at->cell.x <= at->high.x;
    }
    if (at->leave.y <= at->leave.z) {
        at->cell.y += ray->direction.y > 0.0f ? 1 : -1;
        at->leave.y = leave_axis(ray->origin.y, ray->direction.y, ray->inverse.y, at->cell.y, at->width);
        return at->cell.y >= at->low.y && at->cell.y <= at->high.y;
    }
    at->cell.z += ray->direction.z > 0.0f ? 1 : -1;
    at->leave.z = leave_axis(ray->origin.z, ray->direction.z, ray->inverse.z, at->cell.z, at->width);
    return at->cell.z >= at->low.z && at->cell.z <= at->high.z;
}

static void test_triangle(const two_levels *grid, const grid_ray *ray, uint triangle, nearest_hit *best)
{
    const uint3 corners = vload3(triangle, grid->indices);
    const float3 a = convert_float3(vload3(corners.x, grid->vertices));
    const float3 to_b = convert_float3(vload3(corners.y, grid->vertices)) - a;
    const float3 to_c = convert_float3(vload3(corners.z, grid->vertices)) - a;
    const float3 across = cross(ray->direction, to_c);
    const float determinant = dot(to_b, across);
    const float inverse = 1.0f / determinant;
    const float3 from_a = ray->origin - a;
    const float3 turned = cross(from_a, to_b);
    const float u = dot(from_a, across) * inverse;
    const float v = dot(ray->direction, turned) * inverse;
    const float t = dot(to_c, turned) * inverse;
    if (determinant == 0.0f || !(u >= 0.0f && v >= 0.0f && u + v <= 1.0f && t >= ray->t_min && t <= ray->t_max)) {
        return;
    }
    if (t < best->t || (t == best->t && triangle < best->triangle)) {
        best->t = t;
        best->u = u;
        best->v = v;
        best->triangle = triangle;
    }
}

/* Puts zeros between the three lowest bits. */
static uint spread_bits(int x)
{
    return (uint)((x & 1) | (x & 2) << 2 | (x & 4) << 4);
}

/* Walks through the cells of a brick whose first is low, from t to last. */
static void walk_cells(const two_levels *grid, const grid_ray *ray, uint brick, int3 low, float t, float last,
                       nearest_hit *best)
{
    __global const uint *cells = grid->cells + (brick << 3u * grid->brick_log2);
    walk at;
    walk_begin(ray, t, low, low + ((1 << grid->brick_log2) - 1), grid->width, &at);
    for (;;) {
        const int3 cell = at.cell - low;
        const uint code = spread_bits(cell.x) | spread_bits(cell.y) << 1 | spread_bits(cell.z) << 2;
        const uint end = cells[code + 1u];
        uint entry = cells[code];
        best->cell_count += entry < end ? 1u : 0u;
        for (; entry < end; ++entry) {
            test_triangle(grid, ray, grid->list[entry], best);
        }
        const float leave = walk_leave(&at);
        if (best->t <= leave || leave > last || !walk_step(ray, &at)) {
            return;
        }
    }
}

/* Walks through the bricks from t to last. */
static void walk_bricks(const two_levels *grid, const grid_ray *ray, float t, float last, nearest_hit *best)
{
    const int side = 1 << grid->grid_log2;
    walk at;
    walk_begin(ray, t, (int3)(0), (int3)(side - 1), grid->width * (float)(1 << grid->brick_log2), &at);
    for (;;) {
        const uint brick = grid->bricks[(at.cell.z << grid->grid_log2 | at.cell.y) << grid->grid_log2 | at.cell.x];
        const float leave = walk_leave(&at);
        if (brick != NO_BRICK) {
            walk_cells(grid, ray, brick, at.cell << (int3)((int)grid->brick_log2), t, min(leave, last), best);
        }
        if (best->t <= leave || leave > last || !walk_step(ray, &at)) {
            return;
        }
        t = leave;
    }
}

/* Clips the ray to the grid, size wide. Returns false if it passes by. */
static bool clip(const grid_ray *ray, float size, float *first, float *last)
{
    const float3 at_low = -ray->origin * ray->inverse;
    const float3 at_high = (size - ray->origin) * ray->inverse;
    const float3 zero = (float3)(0.0f);
    const int3 along = ray->direction != zero;
    const int3 inside = ray->origin >= zero && ray->origin <= size;
    const float3 enter = select((float3)(-INFINITY), fmin(at_low, at_high), along);
    const float3 leave = select((float3)(INFINITY), fmax(at_low, at_high), along);
    *first = max(ray->t_min, max(enter.x, max(enter.y, enter.z)));
    *last = min(ray->t_max, min(leave.x, min(leave.y, leave.z)));
    return all(along || inside) && any(along) && *first <= *last;
}

/* rays, hits: of svo_ray and svo_hit, with triangles counted without refused ones. world: the grid's origin, and grid
   units per world unit. logs: bricks per axis, cells per axis of a brick, grid units per cell. */
__kernel void trace_grid(__global const uint *bricks, __global const uint *cells, __global const uint *list,
                         __global const int *vertices, __global const uint *indices, __global const float *rays,
                         __global uint *hits, float4 world, uint4 logs, uint ray_count)
{
    const uint i = get_global_id(0);
    if (i >= ray_count) {
        return;
    }
    const float8 given = vload8(i, rays);
    two_levels grid = {bricks, cells, list, vertices, indices, logs.x, logs.y, (float)(1u << logs.z)};
    grid_ray ray;
    nearest_hit best = {INFINITY, 0.0f, 0.0f, NO_TRIANGLE, 0u};
    float first;
    float last;
    ray.origin = (given.s012 - world.xyz) * world.w;
    ray.direction = given.s345 * world.w;
    ray.inverse = 1.0f / ray.direction;
    ray.t_min = given.s6;
    ray.t_max = given.s7;
    if (clip(&ray, grid.width * (float)(1u << (logs.x + logs.y)), &first, &last)) {
        walk_bricks(&grid, &ray, first, last, &best);
    }
    vstore8((uint8)(as_uint(best.t), best.triangle, as_uint(best.u), as_uint(best.v), 0u, 0u, 0u, best.cell_count), i,
            hits);
}
