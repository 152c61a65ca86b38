/* SPDX-License-Identifier: MIT */
/*
 * From a source to pixels. Parallel light has a rectangle across its direction; a point source the faces of a cube
 * around it, a spot one face or, if it is wide, several; a disk those of a spot of 90 degrees, from its middle.
 * Rectangles are cut to what they see of the box.
 *
 * The flux of a pixel is its irradiance times its area, or intensity times solid angle: dx dy (1 + x^2 + y^2)^-1.5 at
 * its center. (Differences of arctangents, the exact solid angle, lose all digits of a float.)
 */
#include "light/source_views.h"

#include <math.h>
#include <string.h>

#include "rays/camera.h"

/* Photons of a leaf that faces the light, along each side. */
#define PHOTONS_PER_EDGE 2.0
/* A box that comes nearer to a point source than this part of its far end's depth fills the face. */
#define NEAR 0x1p-20

/* ---- small vectors ---- */

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static void store(const double from[3], float to[3])
{
    for (int axis = 0; axis < 3; ++axis) {
        to[axis] = (float)from[axis];
    }
}

static void load(const float from[3], double to[3])
{
    for (int axis = 0; axis < 3; ++axis) {
        to[axis] = from[axis];
    }
}

double svo_i_plain_cosine(double angle)
{
    /* The series up to x^22 / 22!, from its end. */
    const double square = angle * angle;
    double sum = 1;
    for (int k = 22; k > 0; k -= 2) {
        sum = 1 - square / (k * (k - 1)) * sum;
    }
    return sum;
}

/* Axes across a unit vector: it, times the axis of its smallest component. */
static void make_frame(const double forward[3], double right[3], double up[3])
{
    int least = 0;
    for (int axis = 1; axis < 3; ++axis) {
        least = fabs(forward[axis]) < fabs(forward[least]) ? axis : least;
    }
    const double other[3] = {least == 0, least == 1, least == 2};
    cross(forward, other, right);
    (void)svo_i_normalize(right, right);
    cross(right, forward, up);
}

/* The middle of the box, and the reach from there along a unit vector. */
static void find_middle(const svo_i_lit_box *box, double middle[3])
{
    for (int axis = 0; axis < 3; ++axis) {
        middle[axis] = (box->low[axis] + box->high[axis]) / 2;
    }
}

static double reach_along(const svo_i_lit_box *box, const double direction[3])
{
    double reach = 0;
    for (int axis = 0; axis < 3; ++axis) {
        reach += fabs(direction[axis]) * (box->high[axis] - box->low[axis]) / 2;
    }
    return reach;
}

/* ---- pixels ---- */

/* Divides a rectangle into pixels of at most that edge, or so many along its longer side. */
static void divide(double width, double height, double edge, uint32_t resolution, svo_i_light_view *view)
{
    const double longer = width > height ? width : height;
    const double wanted = resolution > 0 ? resolution : ceil(longer / edge);
    const double most = wanted < 1 ? 1 : wanted > SVO_I_VIEW_PIXELS_MAX ? SVO_I_VIEW_PIXELS_MAX : wanted;
    const double columns = ceil(width / longer * most);
    const double rows = ceil(height / longer * most);
    view->params.columns = columns < 1 ? 1 : (uint32_t)columns;
    view->params.rows = rows < 1 ? 1 : (uint32_t)rows;
    view->half[0] = width / view->params.columns / 2;
    view->half[1] = height / view->params.rows / 2;
    view->pixel = 4 * view->half[0] * view->half[1];
    view->params.half_x = (float)view->half[0];
    view->params.half_y = (float)view->half[1];
    const uint32_t tile = 1u << SVO_TILE_PIXELS_LOG2;
    view->params.tile_columns = (view->params.columns + tile - 1) / tile;
    view->photon_count = view->params.tile_columns * ((view->params.rows + tile - 1) / tile) * tile * tile;
}

static void view_parallel(const svo_light_source *source, const svo_i_lit_box *box, uint32_t resolution,
                          svo_i_light_view *view)
{
    double forward[3];
    double right[3];
    double up[3];
    double base[3];
    load(source->direction, forward);
    (void)svo_i_normalize(forward, forward);
    make_frame(forward, right, up);
    find_middle(box, base);
    const double back = reach_along(box, forward) + box->leaf_edge;
    for (int axis = 0; axis < 3; ++axis) {
        base[axis] -= back * forward[axis];
    }
    *view = (svo_i_light_view){.params.parallel = 1};
    store(base, view->params.base);
    store(right, view->params.right);
    store(up, view->params.up);
    store(forward, view->params.forward);
    divide(2 * reach_along(box, right), 2 * reach_along(box, up), box->leaf_edge / PHOTONS_PER_EDGE, resolution, view);
}

/* A face of a point source: an orthonormal frame, and how far it reaches to each side where the depth is 1. */
typedef struct face {
    double right[3], up[3], forward[3];
    double slope;
} face;

/* The least distance from 0 of a number in a range. */
static double least_size(const double range[2])
{
    return range[0] > 0 ? range[0] : range[1] < 0 ? -range[1] : 0;
}

/* The ratios of numbers of a range to depths of a range, as far as they are on the face. near: above 0. */
static void find_ratios(const double range[2], double near, double far, double slope, double ratios[2])
{
    const double low = range[0] / (range[0] < 0 ? near : far);
    const double high = range[1] / (range[1] < 0 ? far : near);
    ratios[0] = low < -slope ? -slope : low;
    ratios[1] = high > slope ? slope : high;
}

/* What a face sees of the box: ranges of x and y at depth 1. False: nothing. far: the depth of the box's far end. */
static bool find_window(const face *f, const double position[3], const svo_i_lit_box *box, double window[2][2],
                        double *far)
{
    const double *const axes[3] = {f->right, f->up, f->forward};
    double ranges[3][2];
    double middle[3];
    find_middle(box, middle);
    for (int i = 0; i < 3; ++i) {
        const double reach = reach_along(box, axes[i]);
        const double at = dot(middle, axes[i]) - dot(position, axes[i]);
        ranges[i][0] = at - reach;
        ranges[i][1] = at + reach;
    }
    /* What is on the face is no farther aside than slope times its depth. */
    *far = ranges[2][1];
    const double near = fmax(ranges[2][0], fmax(least_size(ranges[0]), least_size(ranges[1])) / f->slope);
    if (!(*far > 0) || near > *far) {
        return false;
    }
    for (int i = 0; i < 2; ++i) {
        window[i][0] = -f->slope;
        window[i][1] = f->slope;
        if (near > NEAR * *far) {
            find_ratios(ranges[i], near, *far, f->slope, window[i]);
        }
    }
    return window[0][0] < window[0][1] && window[1][0] < window[1][1];
}

/* The view of a face; false where it sees nothing of the box. */
static bool view_face(const svo_light_source *source, const face *f, const svo_i_lit_box *box, uint32_t resolution,
                      svo_i_light_view *view)
{
    double position[3];
    double window[2][2];
    double forward[3];
    double depth = 0;
    load(source->position, position);
    if (!find_window(f, position, box, window, &depth)) {
        return false;
    }
    *view = (svo_i_light_view){.middle = {(window[0][0] + window[0][1]) / 2, (window[1][0] + window[1][1]) / 2}};
    for (int axis = 0; axis < 3; ++axis) {
        forward[axis] = f->forward[axis] + view->middle[0] * f->right[axis] + view->middle[1] * f->up[axis];
    }
    store(position, view->params.base);
    store(f->right, view->params.right);
    store(f->up, view->params.up);
    store(forward, view->params.forward);
    divide(window[0][1] - window[0][0], window[1][1] - window[1][0], box->leaf_edge / (PHOTONS_PER_EDGE * depth),
           resolution, view);
    return true;
}

/* A point source's faces look along the world's axes. */
static uint32_t view_point(const svo_light_source *source, const svo_i_lit_box *box, uint32_t resolution,
                           svo_i_light_view views[SVO_I_VIEWS_OF_ONE_MAX])
{
    uint32_t count = 0;
    for (int side = 0; side < 6; ++side) {
        face f = {.slope = 1};
        f.forward[side / 2] = side % 2 == 0 ? 1 : -1;
        f.right[(side / 2 + 1) % 3] = 1;
        f.up[(side / 2 + 2) % 3] = 1;
        count += view_face(source, &f, box, resolution, &views[count]) ? 1 : 0;
    }
    return count;
}

/* The faces of a spot: one forward; and if it is wider than that, those around it. Its cone ends before the one at the
   back. */
static uint32_t list_spot_faces(const double forward[3], double outer_cosine, face faces[5])
{
    const bool wide = outer_cosine < sqrt(0.5);
    memset(faces, 0, 5 * sizeof *faces);
    memcpy(faces[0].forward, forward, sizeof faces[0].forward);
    make_frame(forward, faces[0].right, faces[0].up);
    faces[0].slope = wide ? 1 : sqrt(1 - outer_cosine * outer_cosine) / outer_cosine;
    for (int k = 1; k < 5; ++k) {
        const double sign = k % 2 == 1 ? 1 : -1;
        faces[k].slope = 1;
        for (int axis = 0; axis < 3; ++axis) {
            faces[k].forward[axis] = sign * (k < 3 ? faces[0].right : faces[0].up)[axis];
            faces[k].right[axis] = (k < 3 ? faces[0].up : faces[0].forward)[axis];
            faces[k].up[axis] = (k < 3 ? faces[0].forward : faces[0].right)[axis];
        }
    }
    return wide ? 5 : 1;
}

static uint32_t view_spot(const svo_light_source *source, const svo_i_lit_box *box, uint32_t resolution,
                          svo_i_light_view views[SVO_I_VIEWS_OF_ONE_MAX])
{
    face faces[5];
    double forward[3];
    const bool is_disk = source->kind == SVO_SOURCE_DISK;
    const double outer_cosine = is_disk ? 0 : svo_i_plain_cosine(source->outer_angle);
    load(source->direction, forward);
    (void)svo_i_normalize(forward, forward);
    const uint32_t face_count = list_spot_faces(forward, outer_cosine, faces);
    uint32_t count = 0;
    for (uint32_t i = 0; i < face_count; ++i) {
        svo_i_light_view *view = &views[count];
        if (view_face(source, &faces[i], box, resolution, view)) {
            view->has_axis = true;
            view->is_disk = is_disk;
            view->axis[0] = dot(forward, faces[i].right);
            view->axis[1] = dot(forward, faces[i].up);
            view->axis[2] = dot(forward, faces[i].forward);
            view->inner_cosine = svo_i_plain_cosine(source->inner_angle);
            view->outer_cosine = outer_cosine;
            ++count;
        }
    }
    return count;
}

bool svo_i_source_is_dark(const svo_light_source *source)
{
    return !(source->value[0] > 0.0F || source->value[1] > 0.0F || source->value[2] > 0.0F);
}

uint32_t svo_i_light_views(const svo_light_source *source, const svo_i_lit_box *box, uint32_t resolution,
                           svo_i_light_view views[SVO_I_VIEWS_OF_ONE_MAX])
{
    if (source->kind == SVO_SOURCE_DIRECTIONAL) {
        view_parallel(source, box, resolution, &views[0]);
        return 1;
    }
    return source->kind == SVO_SOURCE_POINT ? view_point(source, box, resolution, views)
                                            : view_spot(source, box, resolution, views);
}

/* ---- weights ---- */

/* The share of a spot by the cosine from its axis: 1 inside, 0 outside, smooth between; of a disk. */
static double share_of(const svo_i_light_view *view, double cosine)
{
    if (view->is_disk) {
        return cosine < 0 ? 0 : cosine;
    }
    const double at = (cosine - view->outer_cosine) / (view->inner_cosine - view->outer_cosine);
    const double share = at < 0 ? 0 : at > 1 ? 1 : at;
    return share * share * (3 - 2 * share);
}

/* The flux of a pixel relative to that of one in the face's middle, and 1 / length of its direction. */
static double weigh(const svo_i_light_view *view, uint32_t column, uint32_t row, double *inverse_length)
{
    *inverse_length = 1;
    if (view->params.parallel != 0) {
        return 1;
    }
    const double x = view->middle[0] + (2.0 * column + 1 - view->params.columns) * view->half[0];
    const double y = view->middle[1] + (2.0 * row + 1 - view->params.rows) * view->half[1];
    const double squared = 1 + x * x + y * y;
    *inverse_length = 1 / sqrt(squared);
    const double share =
        view->has_axis ? share_of(view, (view->axis[0] * x + view->axis[1] * y + view->axis[2]) * *inverse_length) : 1;
    return share * *inverse_length / squared;
}

/* Bits 0, 2, 4. */
static uint32_t even_bits(uint32_t bits)
{
    return (bits & 1) | (bits >> 1 & 2) | (bits >> 2 & 4);
}

/* The pixel of a photon; false beyond the view's edge. As kernels/light/light_view.clh has it. */
static bool find_pixel(const svo_light_view_params *view, uint32_t photon, uint32_t *column, uint32_t *row)
{
    const uint32_t tile = photon >> 2 * SVO_TILE_PIXELS_LOG2;
    *column = (tile % view->tile_columns << SVO_TILE_PIXELS_LOG2) + even_bits(photon);
    *row = (tile / view->tile_columns << SVO_TILE_PIXELS_LOG2) + even_bits(photon >> 1);
    return *column < view->columns && *row < view->rows;
}

uint32_t svo_i_view_weights(const svo_i_light_view *view, uint32_t first, uint32_t count, svo_photon_weight *weights)
{
    const double one = (double)(UINT32_C(1) << SVO_WEIGHT_UNIT_LOG2);
    uint32_t shot = 0;
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t column = 0;
        uint32_t row = 0;
        weights[i] = (svo_photon_weight){.flux = 0};
        if (find_pixel(&view->params, first + i, &column, &row)) {
            double inverse_length = 1;
            const double weight = weigh(view, column, row, &inverse_length);
            weights[i].flux = (uint32_t)(weight * one + 0.5);
            weights[i].inverse_length = (uint32_t)(inverse_length * one + 0.5);
        }
        shot += weights[i].flux > 0 ? 1 : 0;
    }
    return shot;
}
