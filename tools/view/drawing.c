/* SPDX-License-Identifier: MIT */
/* Rays of the camera: those of pictures, coarse and refined, by the functions of svocl render; and the ray of a click,
   and what the tree has where it hits. */
#include "view/drawing.h"

#include <math.h>
#include <string.h>

#include "support/exposure.h"
#include "view/camera.h"

/* ---- rows of a picture ---- */

/* Rows of a picture. All but lit pictures are drawn whole. */
typedef struct picture_part {
    unsigned width, height; /* of the picture, pixels */
    unsigned first_row, row_count; /* multiples of SVO_LIGHT_BAND_ROWS, but at the end */
} picture_part;

static svo_render_view light_view(view_picture picture)
{
    static const svo_render_view views[] = {SVO_VIEW_AO, SVO_VIEW_DIRECT, SVO_VIEW_INDIRECT, SVO_VIEW_SHADED,
                                            SVO_VIEW_SPECULAR};
    return views[picture - VIEW_AO];
}

/* The last band ends with the picture; the library cuts it there. */
static unsigned round_rows(unsigned rows)
{
    return (rows + SVO_LIGHT_BAND_ROWS - 1) / SVO_LIGHT_BAND_ROWS * SVO_LIGHT_BAND_ROWS;
}

static svo_gather_options gather_of(const view_shown *shown)
{
    return (svo_gather_options){.struct_size = sizeof(svo_gather_options),
                                .cones = shown->cones,
                                .range = shown->picture == VIEW_AO ? shown->range : 0,
                                .falloff = shown->falloff,
                                .no_light = !shown->gi};
}

static svo_status draw_light(subject *which, const view_state *state, const picture_part *part, cl_mem pixels,
                             cl_event *drawn)
{
    const view_shown *shown = &state->shown;
    const svo_gather_options gather = gather_of(shown);
    svo_render_options asked = {.struct_size = sizeof asked,
                                .width = part->width,
                                .height = part->height,
                                .camera = state->camera.at,
                                .view = light_view(shown->picture),
                                .gather = &gather,
                                .exposure = shown->exposure,
                                .first_row = part->first_row,
                                .row_count = round_rows(part->row_count)};
    view_clip_plane(state, asked.clip);
    return svo_render(svo_light_target(which->lit.light), &asked, svo_in_buffer(pixels),
                      &(svo_submit){.queue = which->done.opened.queue, .event = drawn});
}

static svo_status draw_tree(subject *which, const view_state *state, const picture_part *part, cl_mem pixels,
                            cl_event *drawn)
{
    static const svo_render_view views[] = {SVO_VIEW_SHADED, SVO_VIEW_NORMAL, SVO_VIEW_DEPTH,
                                            SVO_VIEW_STEPS,  SVO_VIEW_LEVEL,  SVO_VIEW_TRIANGLES};
    svo_render_options asked = {.struct_size = sizeof asked,
                                .width = part->width,
                                .height = part->height,
                                .camera = state->camera.at,
                                .view = views[state->shown.picture]};
    view_clip_plane(state, asked.clip);
    return svo_render(subject_target(which, state), &asked, svo_in_buffer(pixels),
                      &(svo_submit){.queue = subject_queue(which), .event = drawn});
}

/* Draws rows of what the state shows, those of what svocl render writes, at their place in pixels, a buffer of the
   whole picture. drawn: receives an event of them. Returns the exit code. */
static int draw_part(subject *which, view_state *state, const picture_part *part, cl_mem pixels, cl_event *drawn)
{
    if (state->shown.through) {
        return probing_draw(&which->probes, state, part->width, part->height, pixels, drawn);
    }
    if (state->is_scene) {
        return placed_draw(which->placed, state, part->width, part->height, pixels, drawn);
    }
    const svo_status status = subject_picture_is_lit(state->shown.picture)
                                  ? draw_light(which, state, part, pixels, drawn)
                                  : draw_tree(which, state, part, pixels, drawn);
    return status == SVO_OK ? PROGRAM_DONE
                            : program_fail_library(which->running, svo_device_message(subject_device(which)));
}

/* ---- when what is drawn ---- */

void drawing_end(drawing *which)
{
    pixel_buffer_drop(&which->pixels);
    *which = (drawing){.width = 0};
}

static bool differs(float a, float b)
{
    return a < b || a > b;
}

static bool camera_differs(const svo_camera *had, const svo_camera *now)
{
    bool is_different = differs(had->vertical_fov, now->vertical_fov);
    for (int axis = 0; axis < 3; ++axis) {
        is_different = is_different || differs(had->eye[axis], now->eye[axis]) ||
                       differs(had->target[axis], now->target[axis]) || differs(had->up[axis], now->up[axis]);
    }
    return is_different;
}

static bool shown_differs(const view_shown *had, const view_shown *now)
{
    return had->picture != now->picture || had->level != now->level || had->gi != now->gi ||
           had->photons != now->photons || had->form != now->form || had->cones != now->cones ||
           differs(had->range, now->range) || differs(had->falloff, now->falloff) || had->through != now->through ||
           (now->through && view_grid_differs(&had->probes, &now->probes));
}

static bool clip_differs(const view_clip *had, const view_clip *now)
{
    return had->is_on != now->is_on ||
           (now->is_on && (differs(had->offset, now->offset) || differs(had->normal[0], now->normal[0]) ||
                           differs(had->normal[1], now->normal[1]) || differs(had->normal[2], now->normal[2])));
}

/* Whether the last picture shows something else than the state does, wherever the camera is. */
static bool content_differs(const drawing *which, const view_state *state)
{
    return which->width == 0 || which->window_width != state->width || which->window_height != state->height ||
           shown_differs(&which->shown, &state->shown) || which->is_scene != state->is_scene ||
           which->revisions.lights != state->revisions.lights ||
           which->revisions.instances != state->revisions.instances || which->revisions.film != state->revisions.film ||
           which->revisions.strokes != state->revisions.strokes || which->shows_brush != state->brush.is_on;
}

/* Whether the camera or the clip plane has moved since. */
static bool sight_differs(const drawing *which, const view_state *state)
{
    return clip_differs(&which->shown.clip, &state->shown.clip) || camera_differs(&which->camera, &state->camera.at);
}

/* ---- automatic exposure ---- */

/* Whether the picture shows light of the tree that has to be measured. */
static bool awaits_exposure(const drawing *which, const view_state *state)
{
    const view_picture picture = state->shown.picture;
    const bool is_lit =
        state->shown.through ? picture == VIEW_SHADED : subject_picture_is_lit(picture) && picture != VIEW_AO;
    return state->exposure_is_automatic && is_lit && !state->is_scene && !which->is_exposed;
}

/* Exposes as svocl render does the same picture; those through probes by what rays and cones show. */
static int expose(drawing *which, subject *shown, view_state *state)
{
    const svo_gather_options gather = gather_of(&state->shown);
    const bool through = state->shown.through;
    svo_render_options asked = {.struct_size = sizeof asked,
                                .width = state->width,
                                .height = state->height,
                                .camera = state->camera.at,
                                .view = through ? SVO_VIEW_SHADED : light_view(state->shown.picture),
                                .gather = &gather};
    exposure chosen;
    if (!through) {
        view_clip_plane(state, asked.clip);
    }
    const int exit_code =
        exposure_measure(shown->running, svo_light_target(shown->lit.light), &asked, &shown->done.opened, &chosen);
    if (exit_code == PROGRAM_DONE) {
        state->shown.exposure = chosen.value;
        which->is_exposed = true;
    }
    return exit_code;
}

/* ---- pictures ---- */

/* The coarseness whose picture is expected to take no longer than the goal. */
static unsigned coarse_for(const drawing *which, const view_state *state)
{
    if (state->settings.coarse != 0) {
        return state->settings.coarse;
    }
    const double pixel_ms = which->pixel_ms[state->shown.picture][state->shown.through];
    const double pixels = (double)state->width * (double)state->height;
    unsigned coarse = pixel_ms > 0 ? 1 : VIEW_COARSE_MAX;
    while (coarse < VIEW_COARSE_MAX && pixel_ms * pixels / (coarse * coarse) > (double)state->settings.goal_ms) {
        coarse *= 2;
    }
    return coarse;
}

/* Rays from the camera through a pixel: both shaded pictures and those of light have two by two. */
static unsigned rays_of_pixel(const view_shown *shown)
{
    return !shown->through && (shown->picture == VIEW_SHADED || subject_picture_is_lit(shown->picture)) ? 4 : 1;
}

static void remember(drawing *which, const view_state *state)
{
    which->shown = state->shown;
    which->is_scene = state->is_scene;
    which->shows_brush = state->brush.is_on;
    which->revisions = state->revisions;
    which->camera = state->camera.at;
    which->window_width = state->width;
    which->window_height = state->height;
}

/* Rows of a band that is expected to take no longer than the goal. */
static unsigned band_rows(const drawing *which, const view_state *state)
{
    const double row_ms = which->pixel_ms[state->shown.picture][state->shown.through] * (double)which->width;
    const double rows = row_ms > 0 ? (double)state->settings.goal_ms / row_ms : SVO_LIGHT_BAND_ROWS;
    const unsigned below = which->height - which->rows_done;
    const unsigned bands =
        rows < (double)below ? (unsigned)rows / SVO_LIGHT_BAND_ROWS : below / SVO_LIGHT_BAND_ROWS + 1;
    const unsigned count = SVO_LIGHT_BAND_ROWS * (bands > 0 ? bands : 1);
    return count < below ? count : below;
}

/* Gives the rows to OpenGL, which reads the buffer up to their end. */
static int enqueue_rows(drawing *which, subject *shown, view_state *state, const picture_part *part)
{
    const size_t row_bytes = (size_t)part->width * 4;
    const size_t window_bytes = (size_t)state->width * state->height * 4;
    cl_event drawn = NULL;
    int exit_code =
        pixel_buffer_begin(&which->pixels, subject_device(shown), subject_queue(shown), window_bytes, state);
    if (exit_code == PROGRAM_DONE) {
        exit_code = draw_part(shown, state, part, which->pixels.info.memory, &drawn);
    }
    return exit_code == PROGRAM_DONE
               ? pixel_buffer_finish(&which->pixels, row_bytes * (part->first_row + part->row_count), drawn)
               : exit_code;
}

/* Draws rows of the picture and measures them. */
static int draw_rows(drawing *which, subject *shown, view_state *state, const drawing_clock *clock, unsigned row_count)
{
    const picture_part part = {which->width, which->height, which->rows_done, row_count};
    const double begin_ms = clock->now_ms(clock->user);
    const int exit_code = enqueue_rows(which, shown, state, &part);
    const double pixels = (double)which->width * (double)row_count;
    which->pixel_ms[state->shown.picture][state->shown.through] = (clock->now_ms(clock->user) - begin_ms) / pixels;
    which->rays = (uint64_t)pixels * rays_of_pixel(&state->shown);
    which->rows_done += row_count;
    which->row_count = row_count;
    return exit_code;
}

/* Begins a picture. */
static void resize(drawing *which, const view_state *state, unsigned coarse)
{
    which->coarse = coarse;
    which->width = (state->width + coarse - 1) / coarse;
    which->height = (state->height + coarse - 1) / coarse;
    which->rows_done = 0;
}

/* A whole picture. */
static int draw_all(drawing *which, subject *shown, view_state *state, const drawing_clock *clock, unsigned coarse)
{
    resize(which, state, coarse);
    remember(which, state);
    return draw_rows(which, shown, state, clock, which->height);
}

/* The next band of a finer picture. */
static int draw_band(drawing *which, subject *shown, view_state *state, const drawing_clock *clock)
{
    if (which->rows_done == which->height) {
        resize(which, state, which->coarse / 2);
        which->is_enlarged = true;
    }
    return draw_rows(which, shown, state, clock, band_rows(which, state));
}

int drawing_next(drawing *which, subject *shown, view_state *state, const drawing_clock *clock, bool *is_new)
{
    const bool is_other = content_differs(which, state);
    const bool has_moved = sight_differs(which, state);
    which->is_exposed = which->is_exposed && !is_other && !has_moved && state->exposure_is_automatic;
    const bool exposes = awaits_exposure(which, state) && (is_other || !has_moved);
    int exit_code = exposes ? expose(which, shown, state) : PROGRAM_DONE;
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    const bool outdated = is_other || has_moved || differs(which->shown.exposure, state->shown.exposure);
    which->is_enlarged = false;
    *is_new = outdated || which->coarse > 1 || which->rows_done < which->height;
    if (outdated) {
        exit_code = draw_all(which, shown, state, clock, coarse_for(which, state));
    } else if (*is_new && subject_picture_is_lit(state->shown.picture)) {
        exit_code = draw_band(which, shown, state, clock);
    } else if (*is_new) {
        exit_code = draw_all(which, shown, state, clock, which->coarse / 2);
    }
    state->is_refined = which->coarse == 1 && which->rows_done == which->height && !awaits_exposure(which, state);
    return exit_code;
}

/* ---- what a click found ---- */

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

/* ---- places of what a ray found ---- */

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

/* ---- rays of a click ---- */

static svo_status trace(subject *which, const view_state *state, find *found)
{
    svo_tree *tree = subject_tree(which, state);
    cl_command_queue queue = subject_queue(which);
    if (state->has_triangles) {
        const svo_status status =
            svo_trace_triangles(svo_tree_target(tree), svo_in_host(&found->ray), svo_in_host(&found->hit), 1,
                                SVO_TRACE_CLOSEST, &(svo_submit){.queue = queue});
        if (status != SVO_OK) {
            return status;
        }
    }
    return svo_trace_voxels(svo_tree_target(tree), svo_in_host(&found->ray), svo_in_host(&found->voxel), 1, 0, 0,
                            &(svo_submit){.queue = queue});
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
    if (svo_trace_voxels(svo_scene_target(traced), svo_in_host(&found->ray), svo_in_host(&hit), 1, 0, SVO_SCENE_CLOSEST,
                         &(svo_submit){.queue = placed_queue(which->placed)}) != SVO_OK) {
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
