/* SPDX-License-Identifier: MIT */
/*
 * Strokes of the mouse to steps of an edit. Rays of the mouse go through the voxels of the edit on the host, one by one
 * (Amanatides and Woo, "A Fast Voxel Traversal Algorithm for Ray Tracing", 1987). Those of a stroke go through the
 * voxels as they were when it began: else it would climb what it sets, and dig into what it clears.
 */
#include "view/brushing.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "support/job.h"
#include "view/camera.h"

/* Shapes that can be undone. */
#define UNDO_COUNT 65536u
/* Between two places of a stroke that are farther apart than so many times what the mouse has moved lies an edge of
   what is seen. */
#define GAP_SHARE 4.0
/* Boxes between two places of a stroke. */
#define BOXES_MAX 64

/* ---- the edit ---- */

void brushing_close(brushing *which)
{
    svo_edit_mirror_destroy(&which->mirror);
    svo_edit_destroy(&which->edit);
    *which = (brushing){.running = which->running, .device = which->device, .queue = which->queue};
}

static void describe(brushing *which, view_state *state)
{
    which->info = (svo_edit_info)SVO_EDIT_INFO_INIT;
    which->mirrored = (svo_edit_mirror_info)SVO_EDIT_MIRROR_INFO_INIT;
    (void)svo_edit_get_info(which->edit, &which->info);
    (void)svo_edit_mirror_get_info(which->mirror, &which->mirrored);
    state->brush.voxel_count = which->info.voxel_count;
    state->brush.oldest = which->position - which->info.undo_count;
}

static void find_bounds(brushing *which, const svo_voxels *voxels)
{
    svo_voxels_info list = SVO_VOXELS_INFO_INIT;
    (void)svo_voxels_get_info(voxels, &list);
    for (int axis = 0; axis < 3; ++axis) {
        which->low[axis] = list.low[axis] - 1;
        which->high[axis] = list.high[axis] + 1;
    }
}

static svo_status begin(brushing *which, const svo_tree *tree, svo_message *message)
{
    const svo_edit_options asked = {.struct_size = sizeof asked, .undo_count = UNDO_COUNT};
    svo_voxels *voxels = NULL;
    svo_status status = svo_tree_get_voxels(tree, &voxels, message);
    if (status != SVO_OK) {
        return status;
    }
    status = svo_edit_create(voxels, &asked, &which->edit, message);
    if (status == SVO_OK) {
        find_bounds(which, voxels);
        status = svo_edit_mirror_create(which->device, which->edit, which->queue, &which->mirror);
        if (status != SVO_OK) {
            (void)snprintf(message->text, sizeof message->text, "%s", svo_device_message(which->device));
        }
    }
    svo_voxels_destroy(&voxels);
    return status;
}

/* Without memory for the voxels there is no brush, and all else goes on. */
static void open_edit(brushing *which, const svo_tree *tree, view_state *state)
{
    svo_message message = {""};
    program_begin_step(which->running, "reading the voxels of the tree");
    if (begin(which, tree, &message) == SVO_OK) {
        describe(which, state);
    } else {
        brushing_close(which);
        view_choose_brush(state, false);
        view_notice(state, message.text);
    }
    progress_destroy(&which->running->progress);
}

/* ---- the voxel under a place of the window ---- */

typedef struct place_hit {
    int32_t voxel[3];
    int32_t before[3]; /* the empty one that the ray came from; where it began within, the same */
    double along; /* t */
} place_hit;

/* A ray in units of voxels; t as in the world. */
typedef struct voxel_ray {
    double origin[3], direction[3];
    double begin, end;
} voxel_ray;

/* Cuts the ray to the bounds; false where it is outside. */
static bool enter(const brushing *which, voxel_ray *ray)
{
    for (int axis = 0; axis < 3; ++axis) {
        const double low = (double)which->low[axis] - ray->origin[axis];
        const double high = (double)which->high[axis] - ray->origin[axis];
        const double step = ray->direction[axis];
        if (step == 0.0 && (low > 0.0 || high < 0.0)) {
            return false;
        }
        if (step != 0.0) {
            ray->begin = fmax(ray->begin, (step > 0.0 ? low : high) / step);
            ray->end = fmin(ray->end, (step > 0.0 ? high : low) / step);
        }
    }
    return ray->begin <= ray->end;
}

static bool walk(const brushing *which, const voxel_ray *ray, place_hit *out)
{
    double next[3];
    int32_t cell[3];
    for (int axis = 0; axis < 3; ++axis) {
        const double at = ray->origin[axis] + ray->begin * ray->direction[axis];
        const double least = fmax(floor(at), (double)which->low[axis]);
        cell[axis] = (int32_t)fmin(least, (double)(which->high[axis] - 1));
        const double face = (double)cell[axis] + (ray->direction[axis] > 0.0 ? 1.0 : 0.0);
        next[axis] = ray->direction[axis] != 0.0 ? (face - ray->origin[axis]) / ray->direction[axis] : INFINITY;
    }
    memcpy(out->before, cell, sizeof cell);
    out->along = ray->begin;
    while (svo_edit_find(which->edit, cell, NULL) == 0) {
        const int axis = next[0] <= next[1] && next[0] <= next[2] ? 0 : next[1] <= next[2] ? 1 : 2;
        memcpy(out->before, cell, sizeof cell);
        out->along = next[axis];
        cell[axis] += ray->direction[axis] > 0.0 ? 1 : -1;
        if (!(out->along <= ray->end) || cell[axis] < which->low[axis] || cell[axis] >= which->high[axis]) {
            return false;
        }
        next[axis] += 1.0 / fabs(ray->direction[axis]);
    }
    memcpy(out->voxel, cell, sizeof cell);
    return true;
}

static bool find_voxel(const brushing *which, const view_state *state, const float pixel[2], place_hit *out)
{
    svo_ray seen;
    camera_pick_ray(state, pixel[0], pixel[1], &seen);
    voxel_ray ray = {.begin = (double)seen.t_min, .end = (double)seen.t_max};
    for (int axis = 0; axis < 3; ++axis) {
        ray.origin[axis] = ((double)seen.origin[axis] - which->info.origin[axis]) / which->info.voxel_edge;
        ray.direction[axis] = (double)seen.direction[axis] / which->info.voxel_edge;
    }
    return enter(which, &ray) && walk(which, &ray, out);
}

/* What is set stands on the voxel; what is cleared and painted is the voxel. */
static void find_center(const view_brush *asked, const place_hit *hit, double out[3])
{
    const int32_t *from = asked->tool == VIEW_BRUSH_SET ? hit->before : hit->voxel;
    for (int axis = 0; axis < 3; ++axis) {
        out[axis] = (double)from[axis] + 0.5;
    }
}

/* ---- steps ---- */

static void grow_bounds(brushing *which, view_state *state, const svo_edit_step *step)
{
    for (int axis = 0; axis < 3; ++axis) {
        const double low = floor(fmin(step->begin[axis], step->end[axis]) - step->radius);
        const double high = ceil(fmax(step->begin[axis], step->end[axis]) + step->radius);
        which->low[axis] = low <= (double)which->low[axis] ? (int32_t)low - 1 : which->low[axis];
        which->high[axis] = high >= (double)which->high[axis] ? (int32_t)high + 1 : which->high[axis];
        const double edge = which->info.voxel_edge;
        const double origin = which->info.origin[axis];
        state->low[axis] = fminf(state->low[axis], (float)(origin + low * edge));
        state->high[axis] = fmaxf(state->high[axis], (float)(origin + high * edge));
    }
}

/* Changes the edit by a shape. Where its memory ends, what could be undone makes room. False where it stays. */
static bool apply(brushing *which, view_state *state, const svo_edit_step *step)
{
    svo_message message = {""};
    svo_status status = svo_edit_apply(which->edit, step, &message);
    if (status == SVO_CAPACITY_EXCEEDED) {
        svo_edit_forget(which->edit);
        status = svo_edit_apply(which->edit, step, &message);
        view_log(state, "the memory of the brush is full: what was drawn so far cannot be undone");
    }
    if (status == SVO_OK) {
        status = svo_edit_mirror_update(which->mirror, which->queue);
        if (status != SVO_OK) {
            (void)snprintf(message.text, sizeof message.text, "%s", svo_device_message(which->device));
            (void)svo_edit_undo(which->edit);
            (void)svo_edit_mirror_update(which->mirror, which->queue); /* else the picture fails, in words */
        }
    }
    if (status != SVO_OK) {
        view_log(state, "brush: %s", program_words(message.text));
        describe(which, state);
        return false;
    }
    state->brush.position = ++which->position;
    ++state->revisions.strokes;
    state->selection.is_hit = false;
    if (step->verb == SVO_EDIT_SET) {
        grow_bounds(which, state, step);
    }
    describe(which, state);
    return true;
}

static svo_edit_step step_of(const view_brush *asked)
{
    static const svo_edit_verb verbs[VIEW_BRUSH_TOOLS] = {SVO_EDIT_SET, SVO_EDIT_CLEAR, SVO_EDIT_PAINT};
    svo_edit_step step = {
        .struct_size = sizeof step, .verb = (uint32_t)verbs[asked->tool], .material = (uint32_t)asked->material};
    for (int channel = 0; channel < 3; ++channel) {
        step.rgba[channel] = (uint8_t)lrintf(255 * fminf(fmaxf(asked->color[channel], 0), 1));
    }
    step.rgba[3] = 255;
    return step;
}

static bool apply_box(brushing *which, view_state *state, const double center[3])
{
    svo_edit_step step = step_of(&state->brush);
    step.shape = SVO_EDIT_BOX;
    for (int axis = 0; axis < 3; ++axis) { /* half a voxel more: a radius of 0 is a voxel, as that of a sphere */
        step.begin[axis] = center[axis] - (double)state->brush.radius - 0.5;
        step.end[axis] = center[axis] + (double)state->brush.radius + 0.5;
    }
    return apply(which, state, &step);
}

/* Boxes that touch, from behind the first place to the second. */
static bool apply_boxes(brushing *which, view_state *state, const double from[3], const double to[3])
{
    const double farthest =
        fmax(fmax(fabs(to[0] - from[0]), fabs(to[1] - from[1])), fabs(to[2] - from[2])) / fmax(state->brush.radius, 1);
    const int count = farthest < BOXES_MAX ? (int)ceil(farthest) : BOXES_MAX;
    bool is_done = true;
    for (int i = 1; i <= count && is_done; ++i) {
        double center[3];
        for (int axis = 0; axis < 3; ++axis) {
            center[axis] = floor(from[axis] + (to[axis] - from[axis]) * i / count) + 0.5;
        }
        is_done = apply_box(which, state, center);
    }
    return is_done;
}

static bool apply_capsule(brushing *which, view_state *state, const double from[3], const double to[3])
{
    svo_edit_step step = step_of(&state->brush);
    step.shape = SVO_EDIT_CAPSULE;
    step.radius = (double)state->brush.radius;
    memcpy(step.begin, from, sizeof step.begin);
    memcpy(step.end, to, sizeof step.end);
    return apply(which, state, &step);
}

/* ---- strokes ---- */

/* Back to where the stroke began, and on again: versions are roots. */
static bool find_in_stroke(brushing *which, const view_state *state, const float pixel[2], place_hit *out)
{
    uint64_t back = 0;
    while (back < which->position - which->begun && svo_edit_undo(which->edit) == SVO_OK) {
        ++back;
    }
    const bool is_hit = find_voxel(which, state, pixel, out);
    for (; back > 0; --back) {
        (void)svo_edit_redo(which->edit);
    }
    return is_hit;
}

/* Whether a place is as near to the last one as the mouse's way between them lets expect of one surface. */
static bool is_near(const brushing *which, const view_state *state, const float pixel[2], const double center[3],
                    double along)
{
    double square = 0;
    for (int axis = 0; axis < 3; ++axis) {
        square += (center[axis] - which->last[axis]) * (center[axis] - which->last[axis]);
    }
    const double pixels = hypot((double)(pixel[0] - which->last_pixel[0]), (double)(pixel[1] - which->last_pixel[1]));
    const double pixel_width =
        2 * tan((double)state->camera.at.vertical_fov / 2) / (double)state->height * along / which->info.voxel_edge;
    return sqrt(square) <= GAP_SHARE * pixels * pixel_width + 2 * (double)state->brush.radius + 2;
}

/* A place of the stroke: alone, or with what lies between it and the last one. */
static void draw_place(brushing *which, view_state *state, const float pixel[2])
{
    place_hit hit;
    double center[3];
    const bool is_box = state->brush.shape == VIEW_BRUSH_BOX;
    if (!find_in_stroke(which, state, pixel, &hit)) {
        state->brush.is_beside = state->brush.is_beside || state->brush.begins;
        state->brush.begins = which->is_along = false;
        return;
    }
    find_center(&state->brush, &hit, center);
    const bool is_first = state->brush.begins || !which->is_along || !is_near(which, state, pixel, center, hit.along);
    const double *last = which->last;
    const bool has_moved = is_first || center[0] != last[0] || center[1] != last[1] || center[2] != last[2];
    state->brush.begins = false;
    if (has_moved && !(!is_box    ? apply_capsule(which, state, is_first ? center : last, center)
                       : is_first ? apply_box(which, state, center)
                                  : apply_boxes(which, state, last, center))) {
        state->brush.is_down = false; /* the log says why */
        return;
    }
    which->is_along = true;
    memcpy(which->last, center, sizeof center);
    memcpy(which->last_pixel, pixel, sizeof which->last_pixel);
}

static void draw_strokes(brushing *which, view_state *state)
{
    view_brush *asked = &state->brush;
    const size_t count = asked->place_count;
    if (asked->begins) {
        which->begun = which->position;
        which->is_along = false;
    }
    asked->place_count = 0;
    for (size_t i = 0; i < count && !asked->is_beside; ++i) {
        draw_place(which, state, asked->places[i]);
    }
}

/* ---- undo ---- */

static int follow(brushing *which, view_state *state)
{
    if (which->position == state->brush.position) {
        return PROGRAM_DONE;
    }
    while (which->position > state->brush.position && svo_edit_undo(which->edit) == SVO_OK) {
        --which->position;
    }
    while (which->position < state->brush.position && svo_edit_redo(which->edit) == SVO_OK) {
        ++which->position;
    }
    state->brush.position = which->position;
    if (svo_edit_mirror_update(which->mirror, which->queue) != SVO_OK) {
        return program_fail_library(which->running, svo_device_message(which->device));
    }
    describe(which, state);
    return PROGRAM_DONE;
}

/* ---- what is under the mouse ---- */

static void place_in_world(const brushing *which, const double voxels[3], float out[3])
{
    for (int axis = 0; axis < 3; ++axis) {
        out[axis] = (float)(which->info.origin[axis] + voxels[axis] * which->info.voxel_edge);
    }
}

static void mark(const brushing *which, view_state *state)
{
    view_brush *asked = &state->brush;
    place_hit hit;
    double at[3];
    asked->is_over = asked->mouse[0] >= 0 && find_voxel(which, state, asked->mouse, &hit);
    if (!asked->is_over) {
        return;
    }
    memcpy(asked->voxel, hit.voxel, sizeof hit.voxel);
    find_center(asked, &hit, at);
    place_in_world(which, at, asked->center);
    asked->reach = (float)(((double)asked->radius + 0.5) * which->info.voxel_edge);
    for (unsigned corner = 0; corner < 8; ++corner) {
        for (unsigned axis = 0; axis < 3; ++axis) {
            at[axis] = (double)hit.voxel[axis] + (double)(corner >> axis & 1u);
        }
        place_in_world(which, at, asked->box[corner]);
    }
}

static void take_color(const brushing *which, view_state *state)
{
    svo_voxel voxel;
    if (!state->brush.is_over || svo_edit_find(which->edit, state->brush.voxel, &voxel) == 0) {
        view_log(state, "nothing is there");
        return;
    }
    for (int channel = 0; channel < 3; ++channel) {
        state->brush.color[channel] = (float)voxel.rgba[channel] / 255;
    }
    state->brush.material = voxel.material;
    view_log(state, "brush: color %u %u %u, material %u", voxel.rgba[0], voxel.rgba[1], voxel.rgba[2], voxel.material);
}

/* ---- all of it ---- */

int brushing_update(brushing *which, const svo_tree *tree, view_state *state)
{
    if (which->edit == NULL) {
        open_edit(which, tree, state);
    }
    if (which->edit == NULL) {
        return PROGRAM_DONE;
    }
    const int exit_code = follow(which, state);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    draw_strokes(which, state);
    mark(which, state);
    if (state->brush.takes) {
        state->brush.takes = false;
        take_color(which, state);
    }
    return PROGRAM_DONE;
}

bool brushing_is_newer(const brushing *which, const view_state *state)
{
    return which->edit != NULL && which->written != state->brush.position;
}

int brushing_commit(brushing *which, view_state *state, svo_tree **out)
{
    program *running = which->running;
    const int exit_code = follow(which, state);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    program_begin_step(running, "writing the tree");
    const svo_plan_options asked = {.struct_size = sizeof asked,
                                    .need = running->options.need,
                                    .progress = running->progress != NULL ? job_show_progress : NULL,
                                    .progress_user = running->progress};
    svo_tree *made = NULL;
    const svo_status status = svo_edit_commit(which->edit, which->device, 0, &asked, which->queue, &made, NULL);
    progress_destroy(&running->progress);
    if (status != SVO_OK || svo_tree_download(made, which->queue) != SVO_OK) {
        svo_tree_destroy(&made);
        return program_fail_library(running, svo_device_message(which->device));
    }
    which->written = which->position;
    *out = made;
    return PROGRAM_DONE;
}
