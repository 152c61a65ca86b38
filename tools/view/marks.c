/* SPDX-License-Identifier: MIT */
/* Lines as thin rectangles, areas as triangles, in pixels. */
#include "view/marks.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "view/camera.h"

/* Half of a line's width, pixels. */
#define THIN  0.75F
#define THICK 1.25F
/* Of a light's mark, pixels. */
#define LIGHT_RADIUS 9.0F
#define LIGHT_SIDES  16

static const float triangle_color[4] = {1.0F, 0.62F, 0.10F, 1.0F};
static const float triangle_area[4] = {1.0F, 0.62F, 0.10F, 0.35F};
static const float list_color[4] = {1.0F, 0.85F, 0.55F, 0.55F};
static const float node_color[4] = {0.25F, 0.75F, 1.0F, 0.95F};
static const float light_color[4] = {1.0F, 0.95F, 0.55F, 0.95F};

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

/* A circle where a lamp is. Parallel light has no place. */
static void mark_light(marks *which, const view_state *state)
{
    const svo_light_source *source = state->source < state->source_count ? &state->sources[state->source] : NULL;
    float middle[2];
    if (source == NULL || source->kind == SVO_SOURCE_DIRECTIONAL || !camera_project(state, source->position, middle)) {
        return;
    }
    for (int i = 0; i < LIGHT_SIDES; ++i) {
        const float step = 2 * acosf(-1.0F) / LIGHT_SIDES;
        const float a[2] = {middle[0] + LIGHT_RADIUS * cosf(step * (float)i),
                            middle[1] + LIGHT_RADIUS * sinf(step * (float)i)};
        const float b[2] = {middle[0] + LIGHT_RADIUS * cosf(step * (float)(i + 1)),
                            middle[1] + LIGHT_RADIUS * sinf(step * (float)(i + 1))};
        add_line(which, a, b, THICK, light_color);
    }
}

void marks_make(marks *which, const view_state *state)
{
    which->count = 0;
    which->failed = false;
    if (state->selection.is_hit) {
        mark_selection(which, state);
    }
    if (state->settings.panels && state->settings.open[VIEW_PANEL_LIGHTS] && !state->is_scene) {
        mark_light(which, state);
    }
}

void marks_end(marks *which)
{
    free(which->vertices);
    *which = (marks){.vertices = NULL};
}
