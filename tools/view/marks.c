/* SPDX-License-Identifier: MIT */
/* Lines as thin rectangles, areas as triangles, in pixels. */
#include "view/marks.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "view/camera.h"
#include "view/probe_spheres.h"
#include "view/ui.h"

/* Half of a line's width, pixels. */
#define THIN  0.75F
#define THICK 1.25F
/* Of a light's mark, pixels. */
#define LIGHT_RADIUS 9.0F
#define LIGHT_SIDES  16

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
    if (state->probes.has_spheres && state->probes.places != NULL) {
        mark_probes(which, state);
    }
}

void marks_end(marks *which)
{
    free(which->vertices);
    *which = (marks){.vertices = NULL};
}
