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

static svo_ray photon_ray(const svo_light_view_params *view, uint32_t photon, bool shot)
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

/* ---- sums ---- */

static void add_photon(const svo_ray *ray, svo_photon_weight weight, const svo_hit *hit, const wide of_one[3],
                       photon_sums *leaf)
{
    wide flux[3];
    wide all = 0;
    float toward = 0;
    for (int channel = 0; channel < 3; ++channel) {
        flux[channel] = shift_down(of_one[channel] * weight.flux, SVO_WEIGHT_UNIT_LOG2);
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
    wide of_one[3];
    uint64_t hit_count = 0;
    for (int channel = 0; channel < 3; ++channel) {
        of_one[channel] = (wide)((double)value[channel] * view->pixel / unit + 0.5);
    }
    (void)svo_i_view_weights(view, 0, count, weights);
    for (uint32_t i = 0; i < count; ++i) {
        rays[i] = photon_ray(&view->params, i, weights[i].flux > 0);
    }
    assert_int_equal(svo_tree_trace(made->tree, rays, hits, count, SVO_TRACE_CLOSEST, opened->queue), SVO_OK);
    for (uint32_t i = 0; i < count; ++i) {
        if (hits[i].triangle != SVO_NO_TRIANGLE) {
            ++hit_count;
            add_photon(&rays[i], weights[i], &hits[i], of_one, &leaves[find_leaf(made, &hits[i])]);
        }
    }
    free(weights);
    free(rays);
    free(hits);
    return hit_count;
}
