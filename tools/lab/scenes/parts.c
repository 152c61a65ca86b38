/* SPDX-License-Identifier: MIT */
/* Patches, panels, boxes, turned bodies and spheres, tessellated into a builder. */
#include "parts.h"

static uint32_t patch_index(patch_grid grid, uint32_t base, uint32_t column, uint32_t row)
{
    const uint32_t vertex_columns = grid.wrap_u ? grid.columns : grid.columns + 1;
    const uint32_t vertex_column = grid.wrap_u && column == grid.columns ? 0 : column;
    const uint32_t vertex_row = grid.wrap_v && row == grid.rows ? 0 : row;
    return base + vertex_row * vertex_columns + vertex_column;
}

static void patch_vertices(scene_builder *builder, patch_grid grid, surface_function surface, const void *context)
{
    const uint32_t vertex_columns = grid.wrap_u ? grid.columns : grid.columns + 1;
    const uint32_t vertex_rows = grid.wrap_v ? grid.rows : grid.rows + 1;
    for (uint32_t row = 0; row < vertex_rows; ++row) {
        for (uint32_t column = 0; column < vertex_columns; ++column) {
            const surface_point point =
                surface(context, (double)column / (double)grid.columns, (double)row / (double)grid.rows);
            builder_vertex(builder, &point);
        }
    }
}

void part_patch(scene_builder *builder, patch_grid grid, surface_function surface, const void *context)
{
    if (builder->counting) {
        builder->triangle_count += (size_t)2 * grid.columns * grid.rows;
        return;
    }
    const uint32_t base = (uint32_t)builder->vertex_count;
    patch_vertices(builder, grid, surface, context);
    for (uint32_t row = 0; row < grid.rows; ++row) {
        for (uint32_t column = 0; column < grid.columns; ++column) {
            builder_quad(builder, patch_index(grid, base, column, row), patch_index(grid, base, column + 1, row),
                         patch_index(grid, base, column + 1, row + 1), patch_index(grid, base, column, row + 1));
        }
    }
}

static surface_point panel_point(const void *context, double u, double v)
{
    const panel *flat = context;
    surface_point point;
    point.position = vector_add(flat->corner, vector_add(vector_scale(flat->edge_u, u), vector_scale(flat->edge_v, v)));
    point.normal = vector_normalize(vector_cross(flat->edge_u, flat->edge_v));
    point.color = flat->color;
    return point;
}

void part_panel(scene_builder *builder, const panel *flat, uint32_t columns, uint32_t rows)
{
    const patch_grid grid = {.columns = columns, .rows = rows};
    part_patch(builder, grid, panel_point, flat);
}

void part_tiles(scene_builder *builder, const panel *flat, const tiling *tiles)
{
    panel tile = *flat;
    tile.edge_u = vector_scale(flat->edge_u, 1.0 / tiles->columns);
    tile.edge_v = vector_scale(flat->edge_v, 1.0 / tiles->rows);
    for (uint32_t row = 0; row < tiles->rows; ++row) {
        for (uint32_t column = 0; column < tiles->columns; ++column) {
            tile.corner =
                vector_add(flat->corner, vector_add(vector_scale(tile.edge_u, column), vector_scale(tile.edge_v, row)));
            tile.color = tiles->color(tiles->seed, column, row);
            const double dither = 0.618033988749895 * (row * tiles->columns + column);
            const uint32_t cells = (uint32_t)floor(tiles->mean_cells + dither - floor(dither));
            part_panel(builder, &tile, cells == 0 ? 1 : cells, cells == 0 ? 1 : cells);
        }
    }
}

/* Six faces of a box given by its center and three half axes that form a right-handed frame. */
static void box_faces(scene_builder *builder, vector3 center, const vector3 axes[3], uint32_t cells, vector3 color)
{
    for (int face = 0; face < 6; ++face) {
        const vector3 out = face < 3 ? axes[face] : vector_scale(axes[face - 3], -1);
        const vector3 first = axes[(face + 1) % 3];
        const vector3 second = axes[(face + 2) % 3];
        panel flat = {.color = color};
        flat.edge_u = vector_scale(face < 3 ? first : second, 2);
        flat.edge_v = vector_scale(face < 3 ? second : first, 2);
        flat.corner = vector_subtract(vector_add(center, out), vector_add(first, second));
        part_panel(builder, &flat, cells, cells);
    }
}

void part_box(scene_builder *builder, vector3 low, vector3 high, uint32_t cells, vector3 color)
{
    const vector3 half = vector_scale(vector_subtract(high, low), 0.5);
    part_turned_box(builder, vector_mix(low, high, 0.5), half, 0, cells, color);
}

void part_turned_box(scene_builder *builder, vector3 center, vector3 half, double turns, uint32_t cells, vector3 color)
{
    const double cosine = cosine_of_turns(turns);
    const double sine = sine_of_turns(turns);
    const vector3 axes[3] = {vector(half.x * cosine, 0, -half.x * sine), vector(0, half.y, 0),
                             vector(half.z * sine, 0, half.z * cosine)};
    box_faces(builder, center, axes, cells, color);
}

static const profile_point *clamped_point(const turned_body *body, int64_t index)
{
    const int64_t last = (int64_t)body->profile_count - 1;
    return &body->profile[index < 0 ? 0 : index > last ? last : index];
}

/* Catmull-Rom value and derivative of four neighboring values. */
static double spline(const double p[4], double t, double *slope)
{
    const double a = -p[0] + 3 * p[1] - 3 * p[2] + p[3];
    const double b = 2 * p[0] - 5 * p[1] + 4 * p[2] - p[3];
    const double c = p[2] - p[0];
    *slope = 0.5 * ((3 * a * t + 2 * b) * t + c);
    return 0.5 * (((a * t + b) * t + c) * t + 2 * p[1]);
}

static surface_point turned_point(const void *context, double u, double v)
{
    const turned_body *body = context;
    const double along = v * (double)(body->profile_count - 1);
    int64_t segment = (int64_t)floor(along);
    if (segment > (int64_t)body->profile_count - 2) {
        segment = (int64_t)body->profile_count - 2;
    }
    double radii[4];
    double heights[4];
    for (int64_t k = 0; k < 4; ++k) {
        const profile_point *point = clamped_point(body, segment + k - 1);
        radii[k] = point->radius;
        heights[k] = point->height;
    }
    double radius_slope;
    double height_slope;
    const double radius = spline(radii, along - (double)segment, &radius_slope) * body->scale;
    const double height = spline(heights, along - (double)segment, &height_slope) * body->scale;
    /* u runs clockwise seen from above, so that u x v points outwards. */
    const double cosine = cosine_of_turns(-u);
    const double sine = sine_of_turns(-u);
    surface_point point;
    point.position = vector_add(body->base, vector(radius * cosine, height, radius * sine));
    point.normal = vector_normalize(vector(height_slope * cosine, -radius_slope, height_slope * sine));
    point.color = vector_mix(body->color_low, body->color_high, v);
    return point;
}

void part_turned_body(scene_builder *builder, const turned_body *body, uint32_t sides, uint32_t rows)
{
    const patch_grid grid = {.columns = sides, .rows = rows, .wrap_u = true};
    part_patch(builder, grid, turned_point, body);
}

typedef struct ball_face {
    const ball *sphere;
    vector3 out, across, up;
} ball_face;

static surface_point ball_point(const void *context, double u, double v)
{
    const ball_face *face = context;
    const vector3 on_cube =
        vector_add(face->out, vector_add(vector_scale(face->across, 2 * u - 1), vector_scale(face->up, 2 * v - 1)));
    surface_point point;
    point.normal = vector_normalize(on_cube);
    point.position = vector_add(face->sphere->center, vector_scale(point.normal, face->sphere->radius));
    point.color = face->sphere->color;
    return point;
}

void part_ball(scene_builder *builder, const ball *sphere, uint32_t cells)
{
    const vector3 axes[3] = {vector(1, 0, 0), vector(0, 1, 0), vector(0, 0, 1)};
    for (int side = 0; side < 6; ++side) {
        const bool positive = side < 3;
        ball_face face = {.sphere = sphere};
        face.out = vector_scale(axes[side % 3], positive ? 1 : -1);
        face.across = axes[(side + (positive ? 1 : 2)) % 3];
        face.up = axes[(side + (positive ? 2 : 1)) % 3];
        const patch_grid grid = {.columns = cells, .rows = cells};
        part_patch(builder, grid, ball_point, &face);
    }
}
