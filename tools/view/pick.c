/* SPDX-License-Identifier: MIT */
/* Picking: rays, and what the tree has where they hit. */
#include "view/pick.h"

#include <math.h>
#include <string.h>

#include "view/camera.h"
#include "view/probe_spheres.h"

/* What rays found, and where to look it up. */
typedef struct find {
    const svo_tree *tree; /* NULL: held in a compact form */
    const float *transform; /* 3 x 4, from the tree's world to the scene's; NULL: the same */
    svo_tree_info info;
    svo_tree_arrays arrays;
    svo_ray ray;
    svo_hit hit;
    svo_voxel_hit voxel;
} find;

/* ---- places ---- */

static void place(const find *found, const double from[3], float out[3])
{
    for (int axis = 0; axis < 3; ++axis) {
        const float *row = found->transform != NULL ? found->transform + (ptrdiff_t)4 * axis : NULL;
        out[axis] = row == NULL ? (float)from[axis]
                                : (float)((double)row[0] * from[0] + (double)row[1] * from[1] +
                                          (double)row[2] * from[2] + (double)row[3]);
    }
}

static void vertex_of(const find *found, uint32_t vertex, float out[3])
{
    double point[3];
    for (int axis = 0; axis < 3; ++axis) {
        const double units = (double)found->arrays.vertices[(size_t)vertex * 3 + (size_t)axis];
        point[axis] = found->info.origin[axis] + units / found->info.scale;
    }
    place(found, point, out);
}

static void box_of(const find *found, const double low[3], const double high[3], float corners[8][3])
{
    for (unsigned corner = 0; corner < 8; ++corner) {
        double point[3];
        for (unsigned axis = 0; axis < 3; ++axis) {
            point[axis] = (corner >> axis & 1u) != 0 ? high[axis] : low[axis];
        }
        place(found, point, corners[corner]);
    }
}

/* The corners of an accepted triangle. */
static void corners_of(const find *found, uint32_t accepted, float corners[3][3])
{
    for (size_t corner = 0; corner < 3; ++corner) {
        vertex_of(found, found->arrays.indices[(size_t)accepted * 3 + corner], corners[corner]);
    }
}

/* The node at the hit of the triangle, if a leaf is there: rounding may put the hit a bit beside it. */
static uint32_t node_of_hit(const find *found)
{
    svo_node node = {.index = SVO_NO_NODE};
    double point[3];
    for (int axis = 0; axis < 3; ++axis) {
        point[axis] = (double)found->ray.origin[axis] + (double)found->hit.t * (double)found->ray.direction[axis];
    }
    if (found->hit.triangle == SVO_NO_TRIANGLE || svo_tree_find_point(found->tree, point, &node) != SVO_OK) {
        return found->voxel.node;
    }
    return node.index != SVO_NO_NODE && node.level == found->info.depth ? node.index : found->voxel.node;
}

/* ---- what a node holds ---- */

static void fill_payload(const find *found, view_selection *out)
{
    const svo_tree_arrays *arrays = &found->arrays;
    const uint32_t first = found->info.level_begin[found->info.payload_level];
    if (out->node < first) {
        return;
    }
    const size_t index = out->node - first;
    out->has_color = arrays->colors != NULL;
    out->has_normal = arrays->normals != NULL;
    out->has_material = arrays->materials != NULL;
    out->has_fill = arrays->fills != NULL;
    if (out->has_color) {
        memcpy(out->color, arrays->colors + 4 * index, sizeof out->color);
    }
    for (size_t axis = 0; axis < 3 && out->has_normal; ++axis) {
        out->normal[axis] = (float)arrays->normals[3 * index + axis] / 32767.0F;
    }
    out->material = out->has_material ? arrays->materials[index] : 0;
    out->fill = out->has_fill ? arrays->fills[index] : 0;
}

static void fill_list(const find *found, view_selection *out)
{
    const svo_tree_arrays *arrays = &found->arrays;
    const uint64_t leaf = out->node - found->info.inner_count;
    if (arrays->list_begin == NULL || out->node < found->info.inner_count) {
        return;
    }
    const uint32_t *list = arrays->list + arrays->list_begin[leaf];
    out->list_count = arrays->list_begin[leaf + 1] - arrays->list_begin[leaf];
    out->list_kept = out->list_count < VIEW_LIST_KEPT ? out->list_count : VIEW_LIST_KEPT;
    for (size_t i = 0; i < out->list_kept; ++i) {
        out->list[i] = arrays->triangle_ids[list[i]];
        corners_of(found, list[i], out->list_corners[i]);
    }
}

static void fill_node(const find *found, view_selection *out)
{
    double low[3];
    double high[3];
    svo_node node;
    if (svo_tree_find_node(found->tree, out->node, &node) != SVO_OK ||
        svo_tree_node_box(found->tree, out->node, low, high) != SVO_OK) {
        return;
    }
    out->level = node.level;
    out->has_box = true;
    box_of(found, low, high, out->box);
    fill_payload(found, out);
    fill_list(found, out);
}

/* Positions in the mesh's index array ascend. */
static void fill_triangle(const find *found, view_selection *out)
{
    const uint32_t *ids = found->arrays.triangle_ids;
    uint64_t low = 0;
    uint64_t high = found->info.list_triangle_count;
    while (low < high) {
        const uint64_t middle = (low + high) / 2;
        if (ids[middle] < out->triangle) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    if (low < found->info.list_triangle_count && ids[low] == out->triangle) {
        corners_of(found, (uint32_t)low, out->corners);
    }
}

/* ---- rays ---- */

static svo_status trace(subject *which, const view_state *state, find *found)
{
    svo_tree *tree = subject_tree(which, state);
    cl_command_queue queue = subject_queue(which);
    if (state->has_triangles) {
        const svo_status status = svo_tree_trace(tree, &found->ray, &found->hit, 1, SVO_TRACE_CLOSEST, queue);
        if (status != SVO_OK) {
            return status;
        }
    }
    return svo_tree_trace_voxels(tree, &found->ray, &found->voxel, 1, 0, queue);
}

static void fill(const find *found, view_selection *out)
{
    const bool has_triangle = found->hit.triangle != SVO_NO_TRIANGLE;
    out->is_hit = has_triangle || found->voxel.node != SVO_NO_NODE;
    if (!out->is_hit) {
        return;
    }
    out->t = has_triangle ? found->hit.t : found->voxel.t;
    for (int axis = 0; axis < 3; ++axis) {
        out->point[axis] = found->ray.origin[axis] + out->t * found->ray.direction[axis];
    }
    out->triangle = found->hit.triangle;
    out->node = node_of_hit(found);
    if (has_triangle) {
        fill_triangle(found, out);
    }
    if (out->node != SVO_NO_NODE && found->tree != NULL) {
        fill_node(found, out);
    }
}

static bool look_up(const svo_tree *tree, find *found)
{
    found->tree = tree;
    found->info = (svo_tree_info)SVO_TREE_INFO_INIT;
    found->arrays = (svo_tree_arrays)SVO_TREE_ARRAYS_INIT;
    return svo_tree_get_info(tree, &found->info) == SVO_OK && svo_tree_get_arrays(tree, &found->arrays) == SVO_OK;
}

static int pick_in_tree(subject *which, view_state *state, find *found)
{
    svo_tree *tree = subject_tree(which, state);
    if ((view_shows_film(state) && svo_tree_download(tree, subject_queue(which)) != SVO_OK) || !look_up(tree, found) ||
        trace(which, state, found) != SVO_OK) {
        return program_fail_library(which->running, svo_device_message(subject_device(which)));
    }
    fill(found, &state->selection);
    return PROGRAM_DONE;
}

/* Instances are picked by their voxels. */
static int pick_in_scene(subject *which, view_state *state, find *found)
{
    svo_scene_hit hit = {.node = SVO_NO_NODE};
    svo_scene *traced = placed_scene(which->placed);
    if (svo_scene_trace(traced, &found->ray, &hit, 1, 0, SVO_SCENE_CLOSEST, placed_queue(which->placed)) != SVO_OK) {
        return program_fail_library(which->running, svo_device_message(placed_device(which->placed)));
    }
    if (hit.node == SVO_NO_NODE || hit.instance >= state->instance_count) {
        return PROGRAM_DONE;
    }
    const svo_instance *instance = &state->instances[hit.instance];
    const svo_tree *tree = placed_tree(which->placed, instance->tree);
    found->voxel.node = hit.node;
    found->voxel.t = hit.t;
    found->transform = instance->transform;
    state->selection.level = hit.level;
    if (tree == NULL || !look_up(tree, found)) {
        found->tree = NULL;
    }
    fill(found, &state->selection);
    state->selection.instance = hit.instance;
    state->instance = hit.instance;
    return PROGRAM_DONE;
}

static void log_selection(view_state *state)
{
    const view_selection *picked = &state->selection;
    if (!picked->is_hit) {
        view_log(state, "nothing is there");
    } else if (picked->triangle != SVO_NO_TRIANGLE) {
        view_log(state, "triangle %u at t %g, node %u on level %u", picked->triangle, (double)picked->t, picked->node,
                 picked->level);
    } else {
        view_log(state, "node %u on level %u at t %g", picked->node, picked->level, (double)picked->t);
    }
}

int pick_at(subject *which, view_state *state, int x, int y)
{
    uint32_t probe = 0;
    if (probe_sphere_at(state, (float)x + 0.5F, (float)y + 0.5F, &probe)) {
        static const char *const states[] = {"off", "in place", "moved"};
        view_choose_probe(state, (int64_t)probe);
        view_log(state, "probe %u: %s", probe, states[state->probes.places[probe].state]);
        return PROGRAM_DONE;
    }
    find found = {.hit.triangle = SVO_NO_TRIANGLE, .voxel.node = SVO_NO_NODE};
    camera_pick_ray(state, (float)x + 0.5F, (float)y + 0.5F, &found.ray);
    state->selection =
        (view_selection){.instance = SVO_NO_INSTANCE, .triangle = SVO_NO_TRIANGLE, .node = SVO_NO_NODE, .t = INFINITY};
    const int exit_code = state->is_scene ? pick_in_scene(which, state, &found) : pick_in_tree(which, state, &found);
    log_selection(state);
    return exit_code;
}
