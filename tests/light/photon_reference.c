/* SPDX-License-Identifier: MIT */
#include "photon_reference.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdlib.h>

#include <cmocka.h>

__extension__ typedef __int128 wide;

#define POINT_BITS    24
#define DISTANCE_BITS 16

/* floor(a / 2^shift) */
static wide shift_down(wide a, int shift)
{
    const wide one = (wide)1 << shift;
    const wide quotient = a / one;
    return quotient - (a % one < 0 ? 1 : 0);
}

/* ---- rays ---- */

static void compact_bits(uint32_t bits, uint32_t *even, uint32_t *odd)
{
    *even = *odd = 0;
    for (uint32_t k = 0; k < SVO_TILE_PIXELS_LOG2; ++k) {
        *even |= (bits >> 2 * k & 1) << k;
        *odd |= (bits >> (2 * k + 1) & 1) << k;
    }
}

/* The pixel's x and y, as the kernel computes them. */
static void photon_place(const svo_light_view_params *view, uint32_t photon, float *x, float *y)
{
    const uint32_t tile_photons = 1u << 2 * SVO_TILE_PIXELS_LOG2;
    const uint32_t tile = photon / tile_photons;
    uint32_t column = 0;
    uint32_t row = 0;
    compact_bits(photon % tile_photons, &column, &row);
    column += tile % view->tile_columns << SVO_TILE_PIXELS_LOG2;
    row += tile / view->tile_columns << SVO_TILE_PIXELS_LOG2;
    *x = (float)((int)(2 * column + 1) - (int)view->columns) * view->half_x;
    *y = (float)((int)(2 * row + 1) - (int)view->rows) * view->half_y;
}

svo_ray reference_photon_ray(const svo_light_view_params *view, uint32_t photon, bool shot)
{
    svo_ray ray = {.t_min = shot ? 0.0F : 1.0F, .t_max = shot ? INFINITY : 0.0F};
    float x = 0;
    float y = 0;
    photon_place(view, photon, &x, &y);
    for (int axis = 0; axis < 3; ++axis) {
        const float along_x = x * view->right[axis];
        const float along_y = y * view->up[axis];
        const float aside = along_x + along_y;
        const float first = view->forward[axis] + along_x;
        ray.origin[axis] = view->parallel != 0 ? view->base[axis] + aside : view->base[axis];
        ray.direction[axis] = view->parallel != 0 ? view->forward[axis] : first + along_y;
    }
    return ray;
}

/* ---- leaves ---- */

static uint32_t list_index(const built *made, uint32_t id)
{
    uint32_t k = 0;
    while (k < made->info.list_triangle_count && made->arrays.triangle_ids[k] != id) {
        ++k;
    }
    assert_true(k < made->info.list_triangle_count);
    return k;
}

static bool leaf_has(const built *made, uint32_t leaf, uint32_t triangle)
{
    for (uint32_t k = made->arrays.list_begin[leaf]; k < made->arrays.list_begin[leaf + 1]; ++k) {
        if (made->arrays.list[k] == triangle) {
            return true;
        }
    }
    return false;
}

/* The hit's point, grid units with POINT_BITS fractional bits. */
static void hit_point(const built *made, uint32_t triangle, const svo_hit *hit, wide point[3])
{
    const uint32_t *corner = made->arrays.indices + (size_t)triangle * 3;
    const wide one = (wide)1 << POINT_BITS;
    const wide b = llrint((double)hit->u * (double)one);
    const wide c = llrint((double)hit->v * (double)one);
    for (int axis = 0; axis < 3; ++axis) {
        const wide last = ((wide)1 << (made->info.snap_bits + POINT_BITS)) - 1;
        point[axis] = (one - b - c) * made->arrays.vertices[corner[0] * 3 + (uint32_t)axis] +
                      b * made->arrays.vertices[corner[1] * 3 + (uint32_t)axis] +
                      c * made->arrays.vertices[corner[2] * 3 + (uint32_t)axis];
        point[axis] = point[axis] < 0 ? 0 : point[axis] > last ? last : point[axis];
    }
}

/* The squared distance of a point from a cell, in 2^-DISTANCE_BITS of its width; along an axis from a neighbor to the
   point in steps, rounded down from the low face of the point's own cell. */
static wide distance_to(const built *made, const wide point[3], const uint32_t cell[3])
{
    const int shift = (int)(made->info.snap_bits - made->info.depth) + POINT_BITS - DISTANCE_BITS;
    wide sum = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const wide at = shift_down(point[axis], shift);
        const wide low = (wide)cell[axis] << DISTANCE_BITS;
        const wide high = low + ((wide)1 << DISTANCE_BITS);
        const wide along = at < low ? low - at : at >= high ? at - high : 0;
        sum += along * along;
    }
    return sum;
}

/* The leaf that holds a hit, or the nearest with its triangle. */
static uint32_t find_leaf(const built *made, const svo_hit *hit)
{
    const uint32_t triangle = list_index(made, hit->triangle);
    uint32_t best = UINT32_MAX;
    wide nearest = -1;
    wide point[3];
    hit_point(made, triangle, hit, point);
    for (uint32_t leaf = 0; leaf < made->info.leaf_count; ++leaf) {
        if (!leaf_has(made, leaf, triangle)) {
            continue;
        }
        svo_node node;
        assert_int_equal(svo_tree_find_node(made->tree, (uint32_t)made->info.inner_count + leaf, &node), SVO_OK);
        bool inside = true;
        for (int axis = 0; axis < 3; ++axis) {
            const int shift = (int)(made->info.snap_bits - made->info.depth) + POINT_BITS;
            inside = inside && shift_down(point[axis], shift) == node.cell[axis];
        }
        const wide distance = inside ? -1 : distance_to(made, point, node.cell);
        if (best == UINT32_MAX || distance < nearest) {
            best = leaf;
            nearest = distance;
        }
    }
    assert_true(best != UINT32_MAX);
    return best;
}

/* ---- spreading ---- */

/* The leaf of each cell of the grid, or SVO_PHOTON_LOST. */
static uint32_t *map_cells(const built *made)
{
    const size_t cells = (size_t)1 << 3 * made->info.depth;
    uint32_t *map = malloc(cells * sizeof *map);
    assert_non_null(map);
    for (size_t i = 0; i < cells; ++i) {
        map[i] = SVO_PHOTON_LOST;
    }
    for (uint32_t leaf = 0; leaf < made->info.leaf_count; ++leaf) {
        svo_node node;
        assert_int_equal(svo_tree_find_node(made->tree, (uint32_t)made->info.inner_count + leaf, &node), SVO_OK);
        map[((size_t)node.cell[2] << made->info.depth | node.cell[1]) << made->info.depth | node.cell[0]] = leaf;
    }
    return map;
}

/* A photon: its ray, hit and leaf, and how far its parts are apart on the surface, in 2^-16 of a cell. */
typedef struct photon {
    const svo_ray *ray;
    const svo_hit *hit;
    uint32_t leaf;
    int own; /* its leaf's place among those that are reached */
    int32_t cell[3];
    int64_t inside[3], right[3], up[3];
} photon;

static float product(const float a[3], const float b[3])
{
    const float x = a[0] * b[0];
    const float y = a[1] * b[1];
    const float z = a[2] * b[2];
    const float xy = x + y;
    return xy + z;
}

/* A vector across the ray, along which it is moved onto the surface, as the kernel computes it. */
static void lay_down(const float across[3], const photon *p, int64_t side[3])
{
    const int64_t divisor = llrintf(product(p->ray->direction, p->hit->normal) * 0x1p24F);
    const int64_t whole = divisor == 0 ? 0 : ((int64_t)1 << 46) / divisor;
    const float inverse = (float)whole * 0x1p-22F;
    const float distance = product(across, p->hit->normal) * inverse;
    for (int axis = 0; axis < 3; ++axis) {
        const float along = p->ray->direction[axis] * distance;
        const float laid = across[axis] - along;
        side[axis] = llrintf(fminf(fmaxf(laid, -0x1p19F), 0x1p19F));
    }
}

static void find_footprint(const built *made, const svo_light_view_params *view, photon *p)
{
    const double leaf_edge = ldexp(1 / made->info.scale, (int)(made->info.snap_bits - made->info.depth));
    const int shift = (int)(made->info.snap_bits - made->info.depth) + POINT_BITS;
    const float cells = (float)(1 / leaf_edge);
    const float distance = (view->parallel != 0 ? 1.0F : p->hit->t) * cells;
    const float scale = distance * (2.0F * 65536 / SVO_SPREAD_PARTS);
    float right[3];
    float up[3];
    wide point[3];
    hit_point(made, list_index(made, p->hit->triangle), p->hit, point);
    for (int axis = 0; axis < 3; ++axis) {
        right[axis] = view->right[axis] * (view->half_x * scale);
        up[axis] = view->up[axis] * (view->half_y * scale);
        p->cell[axis] = (int32_t)shift_down(point[axis], shift);
        p->inside[axis] = (int64_t)(shift_down(point[axis], shift - 16) - ((wide)p->cell[axis] << 16));
    }
    lay_down(right, p, p->right);
    lay_down(up, p, p->up);
}

/* The cells that the photons of a work-item reach. */
typedef struct reach {
    int count;
    int32_t cells[SVO_SPREAD_CELLS][3];
    uint32_t leaves[SVO_SPREAD_CELLS];
} reach;

static void add_cell(reach *r, const int32_t cell[3], uint32_t leaf)
{
    for (int axis = 0; axis < 3; ++axis) {
        r->cells[r->count][axis] = cell[axis];
    }
    r->leaves[r->count++] = leaf;
}

/* The place of a photon's own leaf. */
static int own_place(const photon *p, reach *r)
{
    for (int k = 0; k < r->count; ++k) {
        if (r->leaves[k] == p->leaf) {
            return k;
        }
    }
    add_cell(r, p->cell, p->leaf);
    return r->count - 1;
}

/* The place that a part of a photon goes to. */
static int place_of_part(const built *made, const uint32_t *map, const photon *p, int part, reach *r)
{
    const int up = (SVO_SPREAD_PARTS / 2 + 4 * part) % SVO_SPREAD_PARTS - SVO_SPREAD_PARTS / 2;
    const int right = part <= SVO_SPREAD_PARTS / 2 ? part : part - SVO_SPREAD_PARTS;
    int32_t cell[3];
    size_t place = 0;
    bool in_grid = true;
    for (int axis = 2; axis >= 0; --axis) {
        cell[axis] =
            p->cell[axis] + (int32_t)shift_down(p->inside[axis] + right * p->right[axis] + up * p->up[axis], 16);
        in_grid = in_grid && cell[axis] >= 0 && cell[axis] < 1 << made->info.depth;
        place = place << made->info.depth | (size_t)cell[axis];
    }
    if (cell[0] == p->cell[0] && cell[1] == p->cell[1] && cell[2] == p->cell[2]) {
        return p->own;
    }
    int k = 0;
    while (k < r->count && !(r->cells[k][0] == cell[0] && r->cells[k][1] == cell[1] && r->cells[k][2] == cell[2])) {
        ++k;
    }
    if (k == r->count) {
        if (k == SVO_SPREAD_CELLS) {
            return p->own;
        }
        add_cell(r, cell, in_grid ? map[place] : SVO_PHOTON_LOST);
    }
    return r->leaves[k] == SVO_PHOTON_LOST ? p->own : k;
}

/* ---- sums ---- */

/* Adds the parts of a photon from range[0] up to range[1]. */
static void add_parts(const svo_ray *ray, svo_photon_weight weight, const svo_hit *hit, const wide of_one[3],
                      const int range[2], photon_sums *leaf)
{
    wide flux[3];
    wide all = 0;
    float toward = 0;
    for (int channel = 0; channel < 3; ++channel) {
        const wide whole = shift_down(of_one[channel] * weight.flux, SVO_WEIGHT_UNIT_LOG2);
        flux[channel] = whole * range[1] / SVO_SPREAD_PARTS - whole * range[0] / SVO_SPREAD_PARTS;
        leaf->flux[channel] += (int64_t)flux[channel];
        all += flux[channel];
    }
    for (int axis = 0; axis < 3; ++axis) {
        const float scale = (float)weight.inverse_length * (0x1p-31F * (float)(1 << SVO_FLUX_UNIT_LOG2));
        const wide unit = llrintf(ray->direction[axis] * scale);
        leaf->along[axis] += (int64_t)shift_down(all * unit, SVO_FLUX_UNIT_LOG2);
        toward += ray->direction[axis] * hit->normal[axis];
    }
    for (int axis = 0; axis < 3; ++axis) {
        const float normal = toward > 0 ? -hit->normal[axis] : hit->normal[axis];
        const wide cosine = llrintf(normal * (float)(1 << SVO_COSINE_UNIT_LOG2));
        const int direction = 2 * axis + (cosine > 0 ? 1 : 0);
        for (int channel = 0; channel < 3; ++channel) {
            leaf->faces[3 * direction + channel] +=
                (int64_t)shift_down(flux[channel] * (cosine < 0 ? -cosine : cosine), SVO_COSINE_UNIT_LOG2);
        }
    }
    ++leaf->photons;
}

/* What the photons of a view share. */
typedef struct shot {
    const built *made;
    const svo_light_view_params *view;
    const svo_photon_weight *weights;
    const svo_ray *rays;
    const svo_hit *hits;
    const uint32_t *map;
    wide of_one[3];
} shot;

/* Adds a photon whose work-item has reached the leaves. */
static void add_photon(const shot *s, uint32_t number, const photon *p, reach *r, photon_sums *leaves)
{
    int parts[SVO_SPREAD_CELLS] = {0};
    int range[2] = {0, 0};
    for (int part = 0; part < SVO_SPREAD_PARTS; ++part) {
        ++parts[place_of_part(s->made, s->map, p, part, r)];
    }
    for (int k = 0; k < r->count; ++k) {
        range[0] = range[1];
        range[1] += parts[k];
        if (parts[k] > 0) {
            add_parts(p->ray, s->weights[number], p->hit, s->of_one, range, &leaves[r->leaves[k]]);
        }
    }
}

/* Adds the photons of a work-item. Returns those that hit. */
static uint64_t add_item(const shot *s, uint32_t first, photon_sums *leaves)
{
    photon photons[SVO_ITEM_PHOTONS];
    reach r = {.count = 0};
    uint64_t hit_count = 0;
    for (uint32_t k = 0; k < SVO_ITEM_PHOTONS; ++k) {
        photons[k] = (photon){.ray = &s->rays[first + k], .hit = &s->hits[first + k]};
        if (photons[k].hit->triangle != SVO_NO_TRIANGLE) {
            photons[k].leaf = find_leaf(s->made, photons[k].hit);
            find_footprint(s->made, s->view, &photons[k]);
            photons[k].own = own_place(&photons[k], &r);
            ++hit_count;
        }
    }
    for (uint32_t k = 0; k < SVO_ITEM_PHOTONS; ++k) {
        if (photons[k].hit->triangle != SVO_NO_TRIANGLE) {
            add_photon(s, first + k, &photons[k], &r, leaves);
        }
    }
    return hit_count;
}

uint64_t reference_shoot(const fixture *opened, const built *made, const svo_i_light_view *view, const float value[3],
                         double unit, photon_sums *leaves)
{
    const uint32_t count = view->photon_count;
    svo_photon_weight *weights = calloc(count, sizeof *weights);
    svo_ray *rays = calloc(count, sizeof *rays);
    svo_hit *hits = calloc(count, sizeof *hits);
    assert_non_null(weights);
    assert_non_null(rays);
    assert_non_null(hits);
    uint32_t *map = map_cells(made);
    shot s = {.made = made, .view = &view->params, .weights = weights, .rays = rays, .hits = hits, .map = map};
    uint64_t hit_count = 0;
    for (int channel = 0; channel < 3; ++channel) {
        s.of_one[channel] = (wide)((double)value[channel] * view->pixel / unit + 0.5);
    }
    (void)svo_i_view_weights(view, 0, count, weights);
    for (uint32_t i = 0; i < count; ++i) {
        rays[i] = reference_photon_ray(&view->params, i, weights[i].flux > 0);
    }
    assert_int_equal(svo_trace_triangles(svo_tree_target(made->tree), svo_in_host(rays), svo_in_host(hits), count,
                                         SVO_TRACE_CLOSEST, &(svo_submit){.queue = opened->queue}),
                     SVO_OK);
    for (uint32_t first = 0; first < count; first += SVO_ITEM_PHOTONS) { /* whole tiles */
        hit_count += add_item(&s, first, leaves);
    }
    free(map);
    free(weights);
    free(rays);
    free(hits);
    return hit_count;
}
