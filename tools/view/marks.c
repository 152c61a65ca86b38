/* SPDX-License-Identifier: MIT */
/* Lines as thin rectangles, areas as triangles, in pixels. Lines of the ground are cut into pieces of few pixels, and a
   ray to the middle of each tells whether something hides it. */
#include "view/marks.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "view/camera.h"
#include "view/ui.h"

/* Pixels of a piece: at rest, and while something moves. */
#define PIECE_FINE   5.0F
#define PIECE_COARSE 12.0F
/* How often a line is halved. */
#define HALVINGS_MAX 11
/* Lines across the grid, about. */
#define LINES 20.0
/* The grid's radius, in widths of what stands on it. */
#define RADIUS 1.1
/* Rays end before the ground: it touches what stands on it. */
#define NEAR_SHARE 0.998F

/* The plane: two directions on it, a point of it, and the round distance between lines. */
typedef struct plane {
    double along[2][3], up[3];
    double middle[2], height; /* coordinates of the grid's center */
    double radius, spacing;
} plane;

/* ---- the plane ---- */

/* 1, 2 or 5 times a power of ten, not below the number. */
static double round_up(double number)
{
    const double power = pow(10, floor(log10(number)));
    const double share = number / power;
    return power * (share <= 1 ? 1 : share <= 2 ? 2 : share <= 5 ? 5 : 10);
}

/* Where up is an axis, the directions are the others. */
static void find_directions(plane *out)
{
    int first = 0;
    for (int axis = 1; axis < 3; ++axis) {
        first = fabs(out->up[axis]) < fabs(out->up[first]) - 1e-9 ? axis : first;
    }
    const double share = out->up[first];
    double length = 0;
    for (int axis = 0; axis < 3; ++axis) {
        out->along[0][axis] = (axis == first ? 1 : 0) - share * out->up[axis];
        length += out->along[0][axis] * out->along[0][axis];
    }
    for (int axis = 0; axis < 3; ++axis) {
        out->along[0][axis] /= sqrt(length);
    }
    for (int axis = 0; axis < 3; ++axis) {
        const int next = (axis + 1) % 3;
        const int last = (axis + 2) % 3;
        out->along[1][axis] = out->along[0][next] * out->up[last] - out->along[0][last] * out->up[next];
    }
}

static bool find_plane(const view_state *state, plane *out)
{
    double width = 0;
    camera_up(state, out->up);
    find_directions(out);
    out->height = 0;
    out->middle[0] = out->middle[1] = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double low = (double)state->low[axis];
        const double high = (double)state->high[axis];
        out->height += fmin(out->up[axis] * low, out->up[axis] * high);
        out->middle[0] += out->along[0][axis] * 0.5 * (low + high);
        out->middle[1] += out->along[1][axis] * 0.5 * (low + high);
        width = fmax(width, high - low);
    }
    out->radius = RADIUS * width;
    out->spacing = width > 0 ? round_up(2 * out->radius / LINES) : 0;
    return width > 0 && isfinite(width);
}

static void place(const plane *on, double first, double second, float out[3])
{
    for (int axis = 0; axis < 3; ++axis) {
        out[axis] = (float)(first * on->along[0][axis] + second * on->along[1][axis] + on->height * on->up[axis]);
    }
}

/* ---- pieces ---- */

static bool make_room(ground *which)
{
    if (which->count < which->capacity) {
        return true;
    }
    const size_t wanted = which->capacity > 0 ? 2 * which->capacity : 1024;
    which->failed = true;
    view_piece *pieces = realloc(which->pieces, wanted * sizeof *pieces);
    if (pieces == NULL) {
        return false;
    }
    which->pieces = pieces;
    svo_ray *rays = realloc(which->rays, wanted * sizeof *rays);
    if (rays == NULL) {
        return false;
    }
    which->rays = rays;
    which->capacity = wanted;
    which->failed = false;
    return true;
}

/* Lines fade towards the grid's rim. The lines of the world's axes have their colors. */
static void add_piece(ground *which, const view_state *state, const float from[3], const float to[3], int axis,
                      float fade)
{
    static const float colors[4][3] = {
        {0.80F, 0.12F, 0.16F}, {0.12F, 0.56F, 0.16F}, {0.12F, 0.28F, 0.85F}, {0.16F, 0.18F, 0.22F}};
    if (!make_room(which)) {
        return;
    }
    view_piece *piece = &which->pieces[which->count];
    svo_ray *ray = &which->rays[which->count++];
    float length = 0;
    memcpy(piece->from, from, sizeof piece->from);
    memcpy(piece->to, to, sizeof piece->to);
    memcpy(piece->color, colors[axis], sizeof colors[0]);
    piece->color[3] = (axis < 3 ? 0.9F : 0.5F) * fade;
    *ray = (svo_ray){.t_max = INFINITY};
    for (int i = 0; i < 3; ++i) {
        ray->origin[i] = state->camera.at.eye[i];
        ray->direction[i] = 0.5F * (from[i] + to[i]) - ray->origin[i];
        length += ray->direction[i] * ray->direction[i];
    }
    for (int i = 0; i < 3 && length > 0; ++i) {
        ray->direction[i] /= sqrtf(length);
    }
    camera_clip_ray(state, ray);
    ray->t_max = fminf(ray->t_max, NEAR_SHARE * sqrtf(length));
}

static bool is_beside(const view_state *state, const float a[2], const float b[2])
{
    return (a[0] < 0 && b[0] < 0) || (a[1] < 0 && b[1] < 0) ||
           (a[0] > (float)state->width && b[0] > (float)state->width) ||
           (a[1] > (float)state->height && b[1] > (float)state->height);
}

/* A line from begin to end, in the plane's coordinates of one direction; across: that of the other. */
typedef struct line {
    const plane *on;
    int direction;
    int axis; /* of its color */
    double across, begin, end;
    float piece_pixels;
} line;

static void add_grid_line(ground *which, const view_state *state, const line *cut, int halvings)
{
    float from[3] = {0};
    float to[3] = {0};
    float a[2];
    float b[2];
    const double ends[2] = {cut->begin, cut->end};
    for (int i = 0; i < 2; ++i) {
        place(cut->on, cut->direction == 0 ? ends[i] : cut->across, cut->direction == 0 ? cut->across : ends[i],
              i == 0 ? from : to);
    }
    const bool sees_from = camera_project(state, from, a);
    const bool sees_to = camera_project(state, to, b);
    if ((!sees_from && !sees_to) || (sees_from && sees_to && is_beside(state, a, b)) || which->failed) {
        return;
    }
    const double middle = 0.5 * (cut->begin + cut->end);
    if (sees_from && sees_to && hypotf(b[0] - a[0], b[1] - a[1]) <= cut->piece_pixels) {
        const double first = middle - cut->on->middle[cut->direction];
        const double second = cut->across - cut->on->middle[1 - cut->direction];
        const double share = (first * first + second * second) / (cut->on->radius * cut->on->radius);
        add_piece(which, state, from, to, cut->axis, (float)fmax(1 - share, 0));
    } else if (halvings > 0) {
        line half = *cut;
        half.end = middle;
        add_grid_line(which, state, &half, halvings - 1);
        half.begin = middle;
        half.end = cut->end;
        add_grid_line(which, state, &half, halvings - 1);
    }
}

/* The color of the axis that a line is part of; 3: of none. */
static int axis_of(const plane *on, int direction, double across)
{
    for (int axis = 0; axis < 3 && across == 0; ++axis) {
        if (fabs(on->along[direction][axis]) > 1 - 1e-9) {
            return axis;
        }
    }
    return 3;
}

/* Lines of one direction within the grid's disc. */
static void add_lines(ground *which, const view_state *state, const plane *on, int direction)
{
    const double middle = on->middle[1 - direction];
    const double first = ceil((middle - on->radius) / on->spacing);
    for (double k = first; k * on->spacing <= middle + on->radius; ++k) {
        const double away = k * on->spacing - middle;
        const double half = sqrt(fmax(on->radius * on->radius - away * away, 0));
        const line whole = {.on = on,
                            .direction = direction,
                            .axis = axis_of(on, direction, k),
                            .across = k * on->spacing,
                            .begin = on->middle[direction] - half,
                            .end = on->middle[direction] + half,
                            .piece_pixels = state->is_refined ? PIECE_FINE : PIECE_COARSE};
        add_grid_line(which, state, &whole, HALVINGS_MAX);
    }
}

/* ---- what is hidden ---- */

static svo_status trace(const ground *which, subject *shown, const view_state *state, bool *is_hidden)
{
    const float pixel = 2 * tanf(state->camera.at.vertical_fov / 2) / (float)state->height;
    const size_t bytes = state->is_scene ? sizeof(svo_scene_hit) : sizeof(svo_voxel_hit);
    void *hits = malloc(which->count * bytes);
    svo_scene_hit *scene_hits = hits;
    svo_voxel_hit *tree_hits = hits;
    if (hits == NULL) {
        return SVO_OUT_OF_HOST_MEMORY;
    }
    const svo_status status = state->is_scene
                                  ? svo_trace_voxels(svo_scene_target(placed_scene(shown->placed)),
                                                     svo_in_host(which->rays), svo_in_host(scene_hits), which->count,
                                                     pixel, SVO_SCENE_ANY, &(svo_submit){.queue = subject_queue(shown)})
                                  : svo_trace_voxels(svo_tree_target(subject_tree(shown, state)),
                                                     svo_in_host(which->rays), svo_in_host(tree_hits), which->count,
                                                     pixel, 0, &(svo_submit){.queue = subject_queue(shown)});
    const size_t known = status == SVO_OK ? which->count : 0;
    for (size_t i = 0; i < known; ++i) {
        is_hidden[i] = state->is_scene ? scene_hits[i].node != SVO_NO_NODE : tree_hits[i].node != SVO_NO_NODE;
    }
    free(hits);
    return status;
}

static svo_status hide(ground *which, subject *shown, const view_state *state)
{
    size_t kept = 0;
    bool *is_hidden = malloc(which->count + 1);
    svo_status status = is_hidden != NULL && !which->failed ? SVO_OK : SVO_OUT_OF_HOST_MEMORY;
    if (status == SVO_OK && which->count > 0) {
        status = trace(which, shown, state, is_hidden);
    }
    const size_t known = status == SVO_OK ? which->count : 0;
    for (size_t i = 0; i < known; ++i) {
        if (!is_hidden[i]) {
            which->pieces[kept++] = which->pieces[i];
        }
    }
    which->count = kept;
    free(is_hidden);
    return status;
}

/* ---- all of it ---- */

static ground_key key_of(const view_state *state)
{
    ground_key key;
    memset(&key, 0, sizeof key);
    key.camera = state->camera.at;
    key.clip = state->shown.clip;
    key.revisions = state->revisions;
    memcpy(key.low, state->low, sizeof key.low);
    memcpy(key.high, state->high, sizeof key.high);
    key.width = state->width;
    key.height = state->height;
    key.level = state->shown.level;
    key.is_scene = state->is_scene;
    key.is_refined = state->is_refined;
    return key;
}

int ground_update(ground *which, subject *shown, view_state *state)
{
    plane on;
    const ground_key key = key_of(state);
    const bool is_shown = state->settings.grid && !state->brush.is_on && find_plane(state, &on); /* rays see the tree */
    state->ground_count = is_shown ? which->count : 0;
    state->ground_spacing = is_shown ? (float)on.spacing : 0;
    if (!is_shown || memcmp((const void *)&key, (const void *)&which->made, sizeof key) == 0) {
        return PROGRAM_DONE;
    }
    which->made = key;
    which->count = 0;
    which->failed = false;
    add_lines(which, state, &on, 0);
    add_lines(which, state, &on, 1);
    const svo_status status = hide(which, shown, state);
    state->ground = which->pieces;
    state->ground_count = which->count;
    if (status == SVO_OUT_OF_HOST_MEMORY) {
        return program_fail(shown->running, PROGRAM_FAILED, "out of memory for the ground grid");
    }
    return status == SVO_OK ? PROGRAM_DONE
                            : program_fail_library(shown->running, svo_device_message(subject_device(shown)));
}

void ground_end(ground *which)
{
    free(which->pieces);
    free(which->rays);
    *which = (ground){.count = 0};
}

/* ---- pixels ---- */

/* Half of a line's width, pixels. */
#define THIN  0.75F
#define THICK 1.25F
/* Of a light's mark, pixels. */
#define LIGHT_RADIUS 9.0F
#define LIGHT_SIDES  16
#define BRUSH_SIDES  48

/* Of spheres: sides of a large and a small one, and how far its highlight is from its center, in radii. */
#define SPHERE_SIDES       24
#define SPHERE_SIDES_SMALL 8
#define SPHERE_SMALL       6.0F
#define HIGHLIGHT          0.35F

static const float triangle_color[4] = {1.0F, 0.62F, 0.10F, 1.0F};
static const float triangle_area[4] = {1.0F, 0.62F, 0.10F, 0.35F};
static const float list_color[4] = {1.0F, 0.85F, 0.55F, 0.55F};
static const float node_color[4] = {0.25F, 0.75F, 1.0F, 0.95F};
static const float light_color[4] = {1.0F, 0.95F, 0.55F, 0.95F};
static const float chosen_color[4] = {1.0F, 1.0F, 1.0F, 1.0F};
static const uint32_t probe_colors[] = {UI_COLOR_PROBE_OFF, UI_COLOR_PROBE_IN_PLACE, UI_COLOR_PROBE_MOVED};

/* ---- pixels ---- */

static void add(marks *which, const float places[][2], size_t count, const float color[4])
{
    if (which->count + count > which->capacity) {
        const size_t wanted = 2 * (which->capacity + count);
        canvas_vertex *larger = realloc(which->vertices, wanted * sizeof *larger);
        if (larger == NULL) {
            which->failed = true;
            return;
        }
        which->vertices = larger;
        which->capacity = wanted;
    }
    for (size_t i = 0; i < count; ++i) {
        canvas_vertex *made = &which->vertices[which->count++];
        made->x = places[i][0];
        made->y = places[i][1];
        memcpy(made->color, color, sizeof made->color);
    }
}

static void add_line(marks *which, const float from[2], const float to[2], float half_width, const float color[4])
{
    const float along[2] = {to[0] - from[0], to[1] - from[1]};
    const float length = hypotf(along[0], along[1]);
    if (!(length > 0)) {
        return;
    }
    const float x = -along[1] / length * half_width;
    const float y = along[0] / length * half_width;
    const float a[2] = {from[0] + x, from[1] + y};
    const float b[2] = {from[0] - x, from[1] - y};
    const float c[2] = {to[0] + x, to[1] + y};
    const float d[2] = {to[0] - x, to[1] - y};
    const float places[6][2] = {{a[0], a[1]}, {b[0], b[1]}, {c[0], c[1]}, {c[0], c[1]}, {b[0], b[1]}, {d[0], d[1]}};
    add(which, places, 6, color);
}

/* ---- the world ---- */

/* A line of which an end is behind the eye is left out. */
static void add_edge(marks *which, const view_state *state, const float from[3], const float to[3], float half_width,
                     const float color[4])
{
    float a[2];
    float b[2];
    if (camera_project(state, from, a) && camera_project(state, to, b)) {
        add_line(which, a, b, half_width, color);
    }
}

static void add_outline(marks *which, const view_state *state, const float corners[3][3], float half_width,
                        const float color[4])
{
    for (int i = 0; i < 3; ++i) {
        add_edge(which, state, corners[i], corners[(i + 1) % 3], half_width, color);
    }
}

static void add_area(marks *which, const view_state *state, const float corners[3][3], const float color[4])
{
    float places[3][2];
    if (camera_project(state, corners[0], places[0]) && camera_project(state, corners[1], places[1]) &&
        camera_project(state, corners[2], places[2])) {
        add(which, places, 3, color);
    }
}

static void add_box(marks *which, const view_state *state, const float corners[8][3], const float color[4])
{
    for (unsigned from = 0; from < 8; ++from) {
        for (unsigned axis = 0; axis < 3; ++axis) {
            if ((from >> axis & 1u) == 0) {
                add_edge(which, state, corners[from], corners[from | 1u << axis], THICK, color);
            }
        }
    }
}

/* ---- what is marked ---- */

static void mark_selection(marks *which, const view_state *state)
{
    const view_selection *picked = &state->selection;
    for (size_t i = 0; i < picked->list_kept; ++i) {
        add_outline(which, state, picked->list_corners[i], THIN, list_color);
    }
    if (picked->triangle != SVO_NO_TRIANGLE) {
        add_area(which, state, picked->corners, triangle_area);
        add_outline(which, state, picked->corners, THICK, triangle_color);
    }
    if (picked->has_box) {
        add_box(which, state, picked->box, node_color);
    }
}

static void on_circle(const float middle[2], float radius, int index, int sides, float out[2])
{
    const float angle = 2 * acosf(-1.0F) / (float)sides * (float)index;
    out[0] = middle[0] + radius * cosf(angle);
    out[1] = middle[1] + radius * sinf(angle);
}

static void add_circle(marks *which, const float middle[2], float radius, int sides, const float color[4])
{
    for (int i = 0; i < sides; ++i) {
        float a[2];
        float b[2];
        on_circle(middle, radius, i, sides, a);
        on_circle(middle, radius, i + 1, sides, b);
        add_line(which, a, b, THICK, color);
    }
}

/* A circle where a lamp is. Parallel light has no place. */
static void mark_light(marks *which, const view_state *state)
{
    const svo_light_source *source = state->source < state->source_count ? &state->sources[state->source] : NULL;
    float middle[2];
    if (source == NULL || source->kind == SVO_SOURCE_DIRECTIONAL || !camera_project(state, source->position, middle)) {
        return;
    }
    add_circle(which, middle, LIGHT_RADIUS, LIGHT_SIDES, light_color);
}

/* The voxel under the mouse, and what a click would change. */
static void mark_brush(marks *which, const view_state *state)
{
    const view_brush *brush = &state->brush;
    float corners[8][3];
    float middle[2];
    float rim[2];
    float right[3];
    float above[3];
    float sight[3];
    float beside[3];
    add_box(which, state, brush->box, node_color);
    for (unsigned corner = 0; corner < 8; ++corner) {
        for (unsigned axis = 0; axis < 3; ++axis) {
            corners[corner][axis] = brush->center[axis] + ((corner >> axis & 1u) != 0 ? brush->reach : -brush->reach);
        }
    }
    if (brush->shape == VIEW_BRUSH_BOX) {
        add_box(which, state, (const float(*)[3])corners, chosen_color);
        return;
    }
    camera_axes(state, right, above, sight);
    for (int axis = 0; axis < 3; ++axis) {
        beside[axis] = brush->center[axis] + brush->reach * right[axis];
    }
    if (camera_project(state, brush->center, middle) && camera_project(state, beside, rim)) {
        add_circle(which, middle, hypotf(rim[0] - middle[0], rim[1] - middle[1]), BRUSH_SIDES, chosen_color);
    }
}

/* ---- probes ---- */

/* Between black, a color and white. */
static void shade(uint32_t rgba, float light, float out[4])
{
    for (unsigned channel = 0; channel < 3; ++channel) {
        const float value = (float)(rgba >> 8 * channel & 255u) / 255;
        out[channel] = light < 1 ? light * value : value + (light - 1) * (1 - value);
    }
    out[3] = 1;
}

/* A fan from its highlight to its rim. */
static void add_sphere(marks *which, const probe_sphere *sphere, uint32_t rgba)
{
    const int sides = sphere->radius < SPHERE_SMALL ? SPHERE_SIDES_SMALL : SPHERE_SIDES;
    float bright[4];
    float dark[4];
    shade(rgba, 1.55F, bright);
    shade(rgba, 0.5F, dark);
    for (int i = 0; i < sides; ++i) {
        float places[3][2] = {{sphere->pixel[0] - HIGHLIGHT * sphere->radius, //
                               sphere->pixel[1] - HIGHLIGHT * sphere->radius}};
        on_circle(sphere->pixel, sphere->radius, i, sides, places[1]);
        on_circle(sphere->pixel, sphere->radius, i + 1, sides, places[2]);
        add(which, (const float(*)[2])places, 1, bright);
        add(which, (const float(*)[2])places + 1, 2, dark);
    }
}

static int compare_away(const void *a, const void *b)
{
    const probe_sphere *first = a;
    const probe_sphere *second = b;
    return first->away < second->away   ? 1
           : first->away > second->away ? -1
                                        : (first->index > second->index) - (first->index < second->index);
}

/* Far ones first: what is nearer covers them. */
static void mark_probes(marks *which, const view_state *state)
{
    const view_probes *shown = &state->probes;
    probe_sphere *spheres = malloc(shown->made.probe_count * sizeof *spheres);
    size_t count = 0;
    if (spheres == NULL) {
        which->failed = true;
        return;
    }
    for (uint32_t i = 0; i < shown->made.probe_count; ++i) {
        count += probe_sphere_project(state, i, &spheres[count]) ? 1 : 0;
    }
    qsort(spheres, count, sizeof *spheres, compare_away);
    for (size_t i = 0; i < count; ++i) {
        const probe_sphere *sphere = &spheres[i];
        add_sphere(which, sphere, probe_colors[shown->places[sphere->index].state]);
        if (shown->has_map && sphere->index == shown->chosen) {
            add_circle(which, sphere->pixel, sphere->radius + 2 * THICK, SPHERE_SIDES, chosen_color);
        }
    }
    free(spheres);
}

void marks_make(marks *which, const view_state *state)
{
    which->count = 0;
    which->failed = false;
    for (size_t i = 0; i < state->ground_count; ++i) {
        const view_piece *piece = &state->ground[i];
        add_edge(which, state, piece->from, piece->to, THIN, piece->color);
    }
    if (state->selection.is_hit) {
        mark_selection(which, state);
    }
    if (state->settings.panels && state->settings.open[VIEW_PANEL_LIGHTS] && !state->is_scene) {
        mark_light(which, state);
    }
    if (state->brush.is_on && state->brush.is_over) {
        mark_brush(which, state);
    }
    if (state->probes.has_spheres && state->probes.places != NULL) {
        mark_probes(which, state);
    }
}

void marks_end(marks *which)
{
    free(which->vertices);
    *which = (marks){.vertices = NULL};
}
