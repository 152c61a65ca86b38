/* SPDX-License-Identifier: MIT */
/* Cameras: their frames, and the camera that frames a tree. */
#include "rays/camera.h"

#include <math.h>
#include <string.h>

#include "core/device.h"
#include "core/tree.h"

/* The deepest level that is searched for the bounds of the occupied part. */
#define BOUNDS_LEVEL_MAX 6u

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

/* A box of cells on one level. */
typedef struct cell_bounds {
    uint32_t low[3], high[3]; /* high: one past the last cell */
} cell_bounds;

/* The tree's nodes on the host; NULL where the tree has no host arrays. */
typedef struct node_arrays {
    const uint8_t *child_mask;
    const uint32_t *first_child;
} node_arrays;

static void extend_bounds(const node_arrays *arrays, uint32_t node, uint32_t levels_left, const uint32_t cell[3],
                          cell_bounds *bounds)
{
    if (levels_left == 0) {
        for (int axis = 0; axis < 3; ++axis) {
            bounds->low[axis] = cell[axis] < bounds->low[axis] ? cell[axis] : bounds->low[axis];
            bounds->high[axis] = cell[axis] >= bounds->high[axis] ? cell[axis] + 1 : bounds->high[axis];
        }
        return;
    }
    uint32_t child = arrays->first_child[node];
    for (uint32_t octant = 0; octant < 8; ++octant) {
        if ((arrays->child_mask[node] >> octant & 1) != 0) {
            const uint32_t inner[3] = {2 * cell[0] + (octant & 1), 2 * cell[1] + (octant >> 1 & 1),
                                       2 * cell[2] + (octant >> 2)};
            extend_bounds(arrays, child, levels_left - 1, inner, bounds);
            ++child;
        }
    }
}

/* The occupied part in world coordinates; the whole grid without host arrays or leaves. */
static void occupied_bounds(const svo_tree *tree, double low[3], double high[3])
{
    const uint32_t level = tree->info.depth < BOUNDS_LEVEL_MAX ? tree->info.depth : BOUNDS_LEVEL_MAX;
    const uint32_t cells = 1u << level;
    cell_bounds bounds = {{0, 0, 0}, {cells, cells, cells}};
    const node_arrays arrays = {tree->host[SVO_TREE_CHILD_MASK], tree->host[SVO_TREE_FIRST_CHILD]};
    if (arrays.child_mask != NULL && arrays.first_child != NULL && tree->info.leaf_count > 0) {
        bounds = (cell_bounds){{cells, cells, cells}, {0, 0, 0}};
        const uint32_t root[3] = {0, 0, 0};
        extend_bounds(&arrays, 0, level, root, &bounds);
    }
    for (int axis = 0; axis < 3; ++axis) {
        low[axis] = tree->info.origin[axis] + tree->info.edge * bounds.low[axis] / cells;
        high[axis] = tree->info.origin[axis] + tree->info.edge * bounds.high[axis] / cells;
    }
}

/* A corner of a box as a camera at distance sees it: tangents to the right and upwards, and depth past the target. */
typedef struct seen_corner {
    double right, up, beyond;
} seen_corner;

static void see_corners(const svo_i_view *camera_view, const double target[3], const double low[3],
                        const double high[3], seen_corner corners[8])
{
    for (int k = 0; k < 8; ++k) {
        double offset[3];
        for (int axis = 0; axis < 3; ++axis) {
            offset[axis] = ((k >> axis & 1) != 0 ? high[axis] : low[axis]) - target[axis];
        }
        corners[k].right = dot(offset, camera_view->right);
        corners[k].up = dot(offset, camera_view->up);
        corners[k].beyond = dot(offset, camera_view->forward);
    }
}

/* The least distance from which all corners are inside a view of these half tangents. */
static double framing_distance(const seen_corner corners[8], double tangent_right, double tangent_up)
{
    double distance = 0;
    for (int k = 0; k < 8; ++k) {
        distance = fmax(distance, fabs(corners[k].right) / tangent_right - corners[k].beyond);
        distance = fmax(distance, fabs(corners[k].up) / tangent_up - corners[k].beyond);
    }
    return distance;
}

/* Moves the target so that the corners are centered in the picture. */
static void center_target(const svo_i_view *camera_view, const seen_corner corners[8], double distance,
                          double target[3])
{
    double low[2] = {HUGE_VAL, HUGE_VAL};
    double high[2] = {-HUGE_VAL, -HUGE_VAL};
    for (int k = 0; k < 8; ++k) {
        const double depth = distance + corners[k].beyond;
        const double seen[2] = {corners[k].right / depth, corners[k].up / depth};
        for (int side = 0; side < 2; ++side) {
            low[side] = fmin(low[side], seen[side]);
            high[side] = fmax(high[side], seen[side]);
        }
    }
    for (int axis = 0; axis < 3; ++axis) {
        target[axis] += distance * 0.5 *
                        ((low[0] + high[0]) * camera_view->right[axis] + (low[1] + high[1]) * camera_view->up[axis]);
    }
}

void svo_i_camera_frame(const double low[3], const double high[3], float aspect, svo_camera *camera)
{
    const double shape = isfinite(aspect) && aspect > 0.0f ? (double)aspect : 1.0;
    const double half_fov = 0.28;
    const double margin = 1.04;
    /* 26 degrees to the right and 22 above the z axis, which points to the viewer; y is up. */
    const svo_camera direction = {
        .eye = {0.406f, 0.375f, 0.833f}, .up = {0, 1, 0}, .vertical_fov = (float)(2 * half_fov)};
    svo_i_view looking = {{0}, {0}, {0}};
    (void)svo_i_view_from_camera(&direction, &looking);
    double target[3];
    for (int axis = 0; axis < 3; ++axis) {
        target[axis] = 0.5 * (low[axis] + high[axis]);
    }
    const double tangent_up = tan(half_fov) / margin;
    double distance = 0;
    for (int pass = 0; pass < 4; ++pass) {
        seen_corner corners[8];
        see_corners(&looking, target, low, high, corners);
        distance = framing_distance(corners, tangent_up * shape, tangent_up);
        if (pass < 3) {
            center_target(&looking, corners, distance, target);
        }
    }
    *camera = direction;
    for (int axis = 0; axis < 3; ++axis) {
        camera->target[axis] = (float)target[axis];
        camera->eye[axis] = (float)(target[axis] - distance * looking.forward[axis]);
    }
}

void svo_camera_frame(const svo_tree *tree, float aspect, svo_camera *camera)
{
    double low[3];
    double high[3];
    occupied_bounds(tree, low, high);
    svo_i_camera_frame(low, high, aspect, camera);
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
