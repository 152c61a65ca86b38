/* SPDX-License-Identifier: MIT */
/* Cameras: their frames, and the camera that frames a tree. */
#include "rays/camera.h"

#include <math.h>
#include <string.h>

#include "core/device.h"
#include "core/tree.h"

#define PICTURE_EDGE_MAX 16384u

/* ---- vectors ---- */

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

bool svo_i_normalize(const double a[3], double out[3])
{
    const double length = sqrt(dot(a, a));
    if (!(length > 0) || !isfinite(length)) {
        return false;
    }
    for (int axis = 0; axis < 3; ++axis) {
        out[axis] = a[axis] / length;
    }
    return true;
}

bool svo_i_view_from_camera(const svo_camera *camera, svo_i_view *out)
{
    double towards[3];
    double up[3];
    for (int axis = 0; axis < 3; ++axis) {
        towards[axis] = (double)camera->target[axis] - (double)camera->eye[axis];
        up[axis] = camera->up[axis];
    }
    double right[3];
    if (!svo_i_normalize(towards, out->forward) || !svo_i_normalize(up, up)) {
        return false;
    }
    cross(out->forward, up, right);
    /* A millionth of a radian off parallel is enough for floats. */
    if (dot(right, right) < 1e-12 || !svo_i_normalize(right, out->right)) {
        return false;
    }
    cross(out->right, out->forward, out->up);
    return true;
}

/* ---- pictures ---- */

svo_status svo_i_camera_check(svo_device *device, const char *function, const svo_camera *camera, uint32_t width,
                              uint32_t height)
{
    const double fov = (double)camera->vertical_fov;
    if (width < 1 || width > PICTURE_EDGE_MAX || height < 1 || height > PICTURE_EDGE_MAX) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: %u x %u pixels are not within 1 .. %u", function,
                                 width, height, PICTURE_EDGE_MAX);
    }
    return fov > 0 && fov < 3.14159265358979
               ? SVO_OK
               : svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: camera.vertical_fov %g is not between 0 and pi",
                                   function, fov);
}

svo_status svo_i_clip_check(svo_device *device, const char *function, const float clip[4])
{
    const bool is_finite = isfinite(clip[0]) && isfinite(clip[1]) && isfinite(clip[2]) && isfinite(clip[3]);
    return is_finite ? SVO_OK
                     : svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: clip %g, %g, %g, %g is not finite",
                                         function, (double)clip[0], (double)clip[1], (double)clip[2], (double)clip[3]);
}

svo_status svo_i_pinhole_from_camera(svo_device *device, const char *function, const svo_camera *camera, uint32_t width,
                                     uint32_t height, svo_i_pinhole *out)
{
    const double up[3] = {(double)camera->up[0], (double)camera->up[1], (double)camera->up[2]};
    const double tangent = tan(0.5 * (double)camera->vertical_fov);
    *out = (svo_i_pinhole){.pixel = 2 * tangent / height};
    if (!svo_i_view_from_camera(camera, &out->view) || !svo_i_normalize(up, out->up)) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                 "%s: camera.eye, target and up are not finite, or up is along the line of sight",
                                 function);
    }
    for (int axis = 0; axis < 3; ++axis) {
        out->corner[axis] = (float)(out->view.forward[axis] + tangent * out->view.up[axis] -
                                    0.5 * out->pixel * width * out->view.right[axis]);
        out->across[axis] = (float)(out->pixel * out->view.right[axis]);
        out->down[axis] = (float)(-out->pixel * out->view.up[axis]);
    }
    return SVO_OK;
}

/* ---- framing ---- */

/* Of a camera that names no direction: 26 degrees to the right and 22 above the horizon, of a viewer in front. */
static const double front_side[3] = {0.406, 0.375, 0.833};
#define FRONT_FOV 0.56
/* Of the picture's half, around what is framed. */
#define FRAME_MARGIN 1.04

/* A direction along which the farthest occupied cell is sought. */
typedef struct reach_search {
    const svo_i_framed *of;
    double along[3];
    uint32_t ahead; /* the octant that lies farthest along it */
    uint32_t level; /* cells of this one are not opened */
    double reach;
} reach_search;

/* How far the corner of a cell reaches. */
static double cell_reach(const reach_search *of, uint32_t level, const uint32_t cell[3])
{
    const double width = of->of->edge / (double)(1u << level);
    double reach = 0;
    for (int axis = 0; axis < 3; ++axis) {
        reach += of->along[axis] * (of->of->origin[axis] + width * (cell[axis] + (of->ahead >> axis & 1)));
    }
    return reach;
}

/* Opens nodes that may reach farther than what was found, the one ahead first. */
static void search_reach(reach_search *of, uint32_t node, uint32_t level, const uint32_t cell[3])
{
    const double reach = cell_reach(of, level, cell);
    if (reach <= of->reach) {
        return;
    }
    uint32_t child[8];
    const uint32_t mask = level < of->level ? of->of->open(of->of->subject, node, level, child) : 0;
    if (mask == 0) {
        of->reach = reach;
        return;
    }
    for (uint32_t k = 0; k < 8; ++k) {
        const uint32_t octant = of->ahead ^ k;
        if ((mask >> octant & 1) != 0) {
            const uint32_t inner[3] = {2 * cell[0] + (octant & 1), 2 * cell[1] + (octant >> 1 & 1),
                                       2 * cell[2] + (octant >> 2)};
            search_reach(of, child[octant], level + 1, inner);
        }
    }
}

double svo_i_framed_reach(const void *framed, const double along[3])
{
    const svo_i_framed *of = framed;
    const uint32_t deepest = of->depth < SVO_FRAME_LEVEL_MAX ? of->depth : SVO_FRAME_LEVEL_MAX;
    reach_search search = {.of = of, .level = of->open != NULL ? deepest : 0, .reach = -HUGE_VAL};
    for (int axis = 0; axis < 3; ++axis) {
        search.along[axis] = along[axis];
        search.ahead |= along[axis] > 0 ? 1u << axis : 0;
    }
    const uint32_t root[3] = {0, 0, 0};
    search_reach(&search, 0, 0, root);
    return search.reach;
}

/* An svo_i_framed.open. */
static uint32_t open_node(const void *subject, uint32_t node, uint32_t level, uint32_t child[8])
{
    const svo_tree *tree = subject;
    const uint32_t mask = ((const uint8_t *)tree->host[SVO_TREE_CHILD_MASK])[node];
    uint32_t next = ((const uint32_t *)tree->host[SVO_TREE_FIRST_CHILD])[node];
    (void)level;
    for (uint32_t octant = 0; octant < 8; ++octant) {
        child[octant] = next;
        next += mask >> octant & 1;
    }
    return mask;
}

/* The direction from which a camera without one looks: in front of whoever has this up, unit, turned there from y by
   the least rotation (Rodrigues' formula). */
static void turn_front_side(const double up[3], double side[3])
{
    const double axis[3] = {up[2], 0, -up[0]}; /* y x up */
    double once[3];
    double twice[3];
    cross(axis, front_side, once);
    cross(axis, once, twice);
    for (int i = 0; i < 3; ++i) {
        side[i] = up[1] > -1 + 1e-12 ? front_side[i] + once[i] + twice[i] / (1 + up[1])
                                     : (i < 2 ? -front_side[i] : front_side[i]);
    }
}

/* What a camera leaves open takes its default. False without a frame. */
static bool complete_camera(svo_camera *camera, svo_i_view *out)
{
    double up[3] = {(double)camera->up[0], (double)camera->up[1], (double)camera->up[2]};
    if (!(camera->vertical_fov > 0)) {
        camera->vertical_fov = (float)FRONT_FOV;
    }
    if (dot(up, up) == 0) {
        camera->up[1] = 1;
        up[1] = 1;
    }
    if (camera->eye[0] == camera->target[0] && camera->eye[1] == camera->target[1] &&
        camera->eye[2] == camera->target[2]) {
        double side[3];
        if (!svo_i_normalize(up, up)) {
            return false;
        }
        turn_front_side(up, side);
        for (int axis = 0; axis < 3; ++axis) {
            camera->eye[axis] = (float)side[axis];
            camera->target[axis] = 0;
        }
    }
    return (double)camera->vertical_fov < 3.14159265358979 && svo_i_view_from_camera(camera, out);
}

/*
 * A point is inside a side of the picture if side . point - tangent * forward . point is at most that of the eye. So
 * the farthest points along four directions place the eye: two opposite ones give its place between them, and how far
 * back it has to be for both.
 */
static double fit_sides(const svo_i_fitted *of, const svo_i_view *looking, const double side[3], double tangent,
                        double *between)
{
    double along[2][3];
    for (int axis = 0; axis < 3; ++axis) {
        along[0][axis] = side[axis] - tangent * looking->forward[axis];
        along[1][axis] = -side[axis] - tangent * looking->forward[axis];
    }
    const double first = of->reach(of->subject, along[0]);
    const double second = of->reach(of->subject, along[1]);
    *between = 0.5 * (first - second);
    return -0.5 * (first + second) / tangent;
}

bool svo_i_camera_fit(const svo_i_fitted *of, float aspect, svo_camera *camera)
{
    const double shape = isfinite(aspect) && aspect > 0.0f ? (double)aspect : 1.0;
    svo_camera fitted = *camera;
    svo_i_view looking = {{0}, {0}, {0}};
    if (!complete_camera(&fitted, &looking)) {
        return false;
    }
    const double tangent = tan(0.5 * (double)fitted.vertical_fov) / FRAME_MARGIN;
    double right;
    double up;
    const double far_enough = fmin(fit_sides(of, &looking, looking.right, tangent * shape, &right),
                                   fit_sides(of, &looking, looking.up, tangent, &up));
    const double back[3] = {-looking.forward[0], -looking.forward[1], -looking.forward[2]};
    const double middle = 0.5 * (of->reach(of->subject, looking.forward) - of->reach(of->subject, back));
    for (int axis = 0; axis < 3; ++axis) {
        const double across = right * looking.right[axis] + up * looking.up[axis];
        fitted.eye[axis] = (float)(across + far_enough * looking.forward[axis]);
        fitted.target[axis] = (float)(across + middle * looking.forward[axis]);
    }
    *camera = fitted;
    return true;
}

svo_status svo_i_tree_fit_camera(const void *subject, float aspect, svo_camera *camera)
{
    const svo_tree *tree = subject;
    const bool is_known = tree->host[SVO_TREE_CHILD_MASK] != NULL && tree->host[SVO_TREE_FIRST_CHILD] != NULL &&
                          tree->info.leaf_count > 0;
    const svo_i_framed framed = {.subject = tree,
                                 .open = is_known ? open_node : NULL,
                                 .depth = tree->info.depth,
                                 .origin = {tree->info.origin[0], tree->info.origin[1], tree->info.origin[2]},
                                 .edge = tree->info.edge};
    const svo_i_fitted fitted = {&framed, svo_i_framed_reach};
    return svo_i_camera_fit(&fitted, aspect, camera) ? SVO_OK : SVO_INVALID_ARGUMENT;
}

/* ---- light ---- */

void svo_i_place_sun(const svo_i_view *looking, const double up[3], double sun[3])
{
    double raw[3];
    for (int axis = 0; axis < 3; ++axis) {
        raw[axis] = 0.85 * up[axis] + 0.50 * looking->right[axis] - 0.38 * looking->forward[axis];
    }
    if (!svo_i_normalize(raw, sun)) {
        memcpy(sun, up, 3 * sizeof *sun);
    }
}
