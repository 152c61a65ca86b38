/* SPDX-License-Identifier: MIT */
/* What the picture shows: the sections View, Camera, Brush and Settings; and what helps to read it, the axes of the
   world and the legend of a view of numbers. */
#include "view/panels_pages.h"

#include <math.h>
#include <stdio.h>

#include "support/table.h"
#include "support/view_colors.h"
#include "view/camera.h"

#define PI 3.14159265F

/* ---- the picture ---- */

static void choose_picture(ui *toolkit, view_state *state)
{
    const char *names[VIEW_PICTURES];
    int chosen = (int)state->shown.picture;
    for (int i = 0; i < VIEW_PICTURES; ++i) {
        names[i] = view_picture_name((view_picture)i);
    }
    if (ui_tabs(toolkit, names, VIEW_PICTURES, &chosen)) {
        view_choose_picture(state, (view_picture)chosen);
    }
}

static void choose_level(ui *toolkit, view_state *state)
{
    int level = (int)state->shown.level;
    if (ui_slider_count(toolkit, "Level", &level, (int)state->level_min, (int)state->level_max)) {
        view_choose_level(state, level);
    }
    ui_tooltip(toolkit, "Of the leaves that are drawn; lower ones are coarser. Key L.");
}

static void choose_form(ui *toolkit, view_state *state)
{
    const svo_light_form forms[] = {SVO_LIGHT_FACES, SVO_LIGHT_BRICKS, SVO_LIGHT_VOXELS};
    const char *names[3];
    int chosen = 0;
    for (int i = 0; i < 3; ++i) {
        names[i] = svo_name(SVO_NAME_LIGHT_FORM, forms[i]);
        chosen = forms[i] == state->shown.form ? i : chosen;
    }
    if (ui_choice(toolkit, "Light in", names, 3, &chosen)) {
        view_choose_form(state, forms[chosen]);
    }
    ui_tooltip(toolkit,
               "How the tree holds light: on the faces of voxels, in bricks of samples, or once a voxel. Key B.");
}

static void choose_cones(ui *toolkit, view_state *state)
{
    static const char *const names[] = {"no", "1", "5", "6", "16", "64"};
    static const unsigned counts[] = {0, 1, 5, 6, 16, 64};
    int chosen = 0;
    while (chosen < 5 && counts[chosen] < state->shown.cones) {
        ++chosen;
    }
    if (ui_choice(toolkit, "Cones", names, 6, &chosen)) {
        state->shown.cones = counts[chosen];
    }
    ui_tooltip(toolkit, "That each point gathers occlusion and light with, in place of exact rays. More are smoother.");
}

/* The slider moves in powers of two. */
static void choose_exposure(ui *toolkit, view_state *state)
{
    float stops = log2f(state->shown.exposure);
    bool automatic = state->exposure_is_automatic;
    if (ui_slider(toolkit, "Exposure", &stops, -log2f(VIEW_EXPOSURE_MAX), log2f(VIEW_EXPOSURE_MAX), "%+.1f stops")) {
        view_choose_exposure(state, exp2f(stops));
    }
    ui_tooltip(toolkit, "What light is multiplied by before it is shown: two to this power.");
    if (ui_checkbox(toolkit, "Automatic exposure", &automatic)) {
        view_choose_automatic_exposure(state, automatic);
    }
    ui_tooltip(toolkit, "Exposure follows the light in view, once the camera rests. Key E.");
}

static bool shows_cones(view_picture picture)
{
    return picture == VIEW_AO || picture == VIEW_GI || picture == VIEW_FULL;
}

static void choose_occlusion(ui *toolkit, view_state *state)
{
    ui_enable(toolkit, state->shown.picture == VIEW_AO);
    if (ui_numbers(toolkit, "AO range", &state->shown.range, 1, 0.01F, state->shown.range > 0 ? "%.2f" : "no end")) {
        state->shown.range = fmaxf(state->shown.range, 0);
    }
    ui_tooltip(toolkit, "World units within which surfaces darken others; 0: all of the scene.");
    if (ui_numbers(toolkit, "AO falloff", &state->shown.falloff, 1, 0.01F, "%.2f")) {
        state->shown.falloff = fmaxf(state->shown.falloff, 0);
    }
    ui_tooltip(toolkit, "How much less far surfaces darken, a world unit.");
    ui_enable(toolkit, true);
}

static void choose_light(ui *toolkit, view_state *state)
{
    bool gi = state->shown.gi;
    bool photons = state->shown.photons;
    const bool is_lit = state->shown.picture >= VIEW_AO;
    ui_enable(toolkit, is_lit);
    if (ui_checkbox(toolkit, "Indirect light", &gi)) {
        view_choose_gi(state, gi);
    }
    ui_tooltip(toolkit, "The full view shows what surfaces reflect to each other. Key G.");
    if (ui_checkbox(toolkit, "Photons", &photons)) {
        view_choose_photons(state, photons);
    }
    ui_tooltip(toolkit, "Surfaces that the lights reach light others; without, only what emits does. Key P.");
    choose_form(toolkit, state);
    ui_enable(toolkit, shows_cones(state->shown.picture));
    choose_cones(toolkit, state);
    ui_enable(toolkit, (is_lit && state->shown.picture != VIEW_AO) ||
                           (state->shown.through && state->shown.picture == VIEW_SHADED));
    choose_exposure(toolkit, state);
    choose_occlusion(toolkit, state);
}

/* ---- what is cut away, and what helps to find one's way ---- */

static void choose_clip_normal(ui *toolkit, view_state *state)
{
    static const char *const names[] = {"below x", "below y", "below z", "above x", "above y", "above z", "as seen"};
    view_clip *clip = &state->shown.clip;
    float range[2];
    int chosen = 6;
    for (int i = 0; i < 6; ++i) {
        chosen = (i < 3 ? clip->normal[i % 3] : -clip->normal[i % 3]) >= 1 ? i : chosen;
    }
    const int before = chosen;
    if (!ui_choice(toolkit, "Cut away", names, 7, &chosen) && chosen == before) {
        return;
    }
    view_clip_range(state, clip->normal, range);
    const float share = range[1] > range[0] ? (clip->offset - range[0]) / (range[1] - range[0]) : 0.5F;
    if (chosen == 6) {
        camera_ray(state, 0.5F * (float)state->width, 0.5F * (float)state->height, clip->normal);
    }
    for (int i = 0; i < 3 && chosen < 6; ++i) {
        clip->normal[i] = i != chosen % 3 ? 0 : chosen < 3 ? 1.0F : -1.0F;
    }
    view_clip_range(state, clip->normal, range);
    clip->offset = range[0] + share * (range[1] - range[0]);
}

/* The slider tells where the plane is along its axis. */
static void choose_clip(ui *toolkit, view_state *state)
{
    view_clip *clip = &state->shown.clip;
    bool is_on = clip->is_on;
    float range[2];
    if (ui_checkbox(toolkit, "Clip", &is_on)) {
        view_choose_clip(state, is_on);
    }
    ui_tooltip(toolkit, "Cuts away what is before a plane, so that the inside shows. Key V.");
    if (!clip->is_on) {
        return;
    }
    choose_clip_normal(toolkit, state);
    ui_tooltip(toolkit, "Across which axis, and which side; as seen: what is nearer, as the camera stands now.");
    const float sign = clip->normal[0] + clip->normal[1] + clip->normal[2] < 0 ? -1.0F : 1.0F;
    view_clip_range(state, clip->normal, range);
    float at = sign * clip->offset;
    const float low = sign > 0 ? range[0] : -range[1];
    const float high = sign > 0 ? range[1] : -range[0];
    if (ui_slider(toolkit, "Plane at", &at, low, high, "%.4g")) {
        clip->offset = sign * at;
    }
    ui_tooltip(toolkit, "World units along the axis, or from the camera.");
}

static void choose_guides(ui *toolkit, view_state *state)
{
    ui_checkbox(toolkit, "Axes", &state->settings.axes);
    ui_tooltip(toolkit, "Where x, y and z are, in the corner of the picture.");
    ui_enable(toolkit, !state->brush.is_on);
    ui_checkbox(toolkit, "Ground grid", &state->settings.grid);
    ui_tooltip(toolkit, "Lines on the ground, hidden by what stands before them. Not while the brush is on. Key X.");
    ui_enable(toolkit, true);
}

/* Scenes are shaded alone, but through probes, and those of a file have no level to choose. */
void panels_picture(ui *toolkit, view_state *state)
{
    if (!state->is_scene || state->shown.through) {
        choose_picture(toolkit, state);
    } else {
        ui_note(toolkit, "Placed trees are shaded, by the lights below.");
    }
    if (state->level_max > state->level_min) {
        choose_level(toolkit, state);
    }
    if (view_shows_film(state)) {
        ui_note(toolkit, "What moves has the light of svocl render, and none that cones gather.");
    } else if (!state->is_scene) {
        choose_light(toolkit, state);
    }
    if (!state->shown.through) {
        choose_clip(toolkit, state);
    }
    choose_guides(toolkit, state);
}

/* ---- the camera ---- */

static float distance(const float a[3], const float b[3])
{
    return hypotf(hypotf(a[0] - b[0], a[1] - b[1]), a[2] - b[2]);
}

/* Numbers that leave the eye apart from its target are taken. */
static void place_camera(ui *toolkit, view_state *state)
{
    svo_camera moved = state->camera.at;
    const float step = 0.002F * distance(moved.eye, moved.target);
    ui_numbers(toolkit, "Eye", moved.eye, 3, step, "%.2f");
    ui_tooltip(toolkit, "Where the camera is, in the world. Drag to change.");
    ui_numbers(toolkit, "Target", moved.target, 3, step, "%.2f");
    ui_tooltip(toolkit, "What it looks at, and what it turns around in orbit.");
    float degrees = moved.vertical_fov * 180 / PI;
    if (ui_slider(toolkit, "Angle", &degrees, 5, 120, "%.0f \xC2\xB0")) {
        moved.vertical_fov = degrees * PI / 180;
    }
    ui_tooltip(toolkit, "Of view, from top to bottom.");
    if (distance(moved.eye, moved.target) > 0 && view_is_moderate(moved.eye, 3) && view_is_moderate(moved.target, 3)) {
        state->camera.at = moved;
    }
}

static void choose_up(ui *toolkit, view_state *state)
{
    static const char *const names[] = {"x", "y", "z", "-x", "-y", "-z", "other"};
    double up[3];
    int chosen = 6;
    camera_up(state, up);
    for (int i = 0; i < 6; ++i) {
        chosen = (i < 3 ? up[i % 3] : -up[i % 3]) > 1 - 1e-9 ? i : chosen;
    }
    if (ui_choice(toolkit, "Up", names, 6, &chosen) && chosen < 6) {
        float wanted[3] = {0};
        wanted[chosen % 3] = chosen < 3 ? 1.0F : -1.0F;
        camera_choose_up(state, wanted);
    }
    ui_tooltip(toolkit, "What is up in the world; the camera turns around it. Key Z: y or z.");
}

void panels_camera(ui *toolkit, view_state *state)
{
    static const char *const modes[] = {"orbit", "fly"};
    static const char *const along[] = {"X", "Y", "Z", "Home"};
    int mode = (int)state->camera.mode;
    if (ui_choice(toolkit, "Mode", modes, 2, &mode)) {
        state->camera.mode = (view_camera_mode)mode;
    }
    ui_tooltip(toolkit, "Dragging turns around the target, or turns the view where the camera is. Key C.");
    choose_up(toolkit, state);
    place_camera(toolkit, state);
    if (ui_numbers(toolkit, "Speed", &state->camera.speed, 1, 0.01F * fmaxf(state->camera.speed, 0.01F), "%.2f")) {
        state->camera.speed = fmaxf(state->camera.speed, 0);
    }
    ui_tooltip(toolkit, "World units a second while W S A D R F are held.");
    const int pressed = ui_buttons(toolkit, along, 4);
    if (pressed == 3) {
        state->camera.at = state->camera.home;
    } else if (pressed >= 0) {
        camera_look_along(state, pressed);
    }
    ui_tooltip(toolkit, "Looks along an axis, or from where the camera began.");
}

/* ---- the brush ---- */

static void choose_tool(ui *toolkit, view_brush *brush)
{
    const char *tools[VIEW_BRUSH_TOOLS];
    const char *shapes[VIEW_BRUSH_SHAPES];
    int tool = (int)brush->tool;
    int shape = (int)brush->shape;
    for (int i = 0; i < VIEW_BRUSH_TOOLS; ++i) {
        tools[i] = view_brush_tool_name((view_brush_tool)i);
    }
    for (int i = 0; i < VIEW_BRUSH_SHAPES; ++i) {
        shapes[i] = view_brush_shape_name((view_brush_shape)i);
    }
    if (ui_choice(toolkit, "Tool", tools, VIEW_BRUSH_TOOLS, &tool)) {
        brush->tool = (view_brush_tool)tool;
    }
    ui_tooltip(toolkit, "Adds voxels on what is there, removes them, or gives them another color. Key Q.");
    if (ui_choice(toolkit, "Shape", shapes, VIEW_BRUSH_SHAPES, &shape)) {
        brush->shape = (view_brush_shape)shape;
    }
    ui_tooltip(toolkit, "Spheres become a capsule along a drag. Shift and Q.");
}

void panels_brush(ui *toolkit, view_state *state)
{
    view_brush *brush = &state->brush;
    bool is_on = brush->is_on;
    float radius = brush->radius;
    if (ui_checkbox(toolkit, "Draw", &is_on)) {
        view_choose_brush(state, is_on);
    }
    ui_tooltip(toolkit, "Dragging draws; with Shift, or from beside the tree, it turns the camera. Key U.");
    choose_tool(toolkit, brush);
    if (ui_slider(toolkit, "Radius", &radius, 0, VIEW_BRUSH_MAX, "%.1f")) {
        view_choose_brush_radius(state, roundf(2 * radius) / 2);
    }
    ui_tooltip(toolkit, "Voxels around the middle one. Keys [ and ].");
    ui_enable(toolkit, brush->tool != VIEW_BRUSH_CLEAR);
    if (ui_color(toolkit, "Color", brush->color)) {
        for (int channel = 0; channel < 3; ++channel) {
            brush->color[channel] = fminf(brush->color[channel], 1);
        }
    }
    ui_tooltip(toolkit, "Of what is set or painted. Shift and a click take those of a voxel.");
    ui_slider_count(toolkit, "Material", &brush->material, 0, VIEW_BRUSH_MATERIAL_MAX);
    ui_tooltip(toolkit, "Its number. Control and a click to type it.");
    ui_enable(toolkit, true);
    if (brush->is_on) {
        ui_value(toolkit, "Voxels", "%s", figure_count(brush->voxel_count).text);
        ui_note(toolkit, "Shaded alone: another view, probes and instances first write the tree.");
    }
    if (brush->position > 0) {
        ui_note(toolkit, "Drawn on: a tree of voxels, without normals, triangles and levels.");
    }
}

/* ---- settings ---- */

static void choose_coarse(ui *toolkit, view_settings *settings)
{
    static const char *const names[] = {"by goal", "all pixels", "2 x 2", "4 x 4", "8 x 8"};
    static const unsigned sides[] = {0, 1, 2, 4, 8};
    int chosen = 0;
    while (chosen < 4 && sides[chosen] != settings->coarse) {
        ++chosen;
    }
    if (ui_choice(toolkit, "Moving", names, 5, &chosen)) {
        settings->coarse = sides[chosen];
    }
    ui_tooltip(toolkit, "Blocks of pixels that get one ray while something moves; at rest every pixel gets its own.");
}

static void choose_text(ui *toolkit, view_settings *settings)
{
    static const char *const names[] = {"by window", "small", "large"};
    int chosen = settings->text_scale <= 0 ? 0 : settings->text_scale > 1 ? 2 : 1;
    if (ui_choice(toolkit, "Text", names, 3, &chosen)) {
        settings->text_scale = chosen == 0 ? 0 : chosen == 1 ? 1 : 1.25F;
    }
    ui_tooltip(toolkit, "Size of the text in panels; by window: large from 720 pixels of height on.");
}

void panels_settings(ui *toolkit, view_state *state)
{
    view_settings *settings = &state->settings;
    ui_slider(toolkit, "Goal", &settings->goal_ms, 8, 200, "%.0f ms");
    ui_tooltip(toolkit, "Time of a frame while something moves; pictures get coarser to keep it.");
    choose_coarse(toolkit, settings);
    ui_slider(toolkit, "Turning", &settings->turn_speed, 0.5F, 12, "%.1f rad");
    ui_tooltip(toolkit, "How far a drag over the width of the window turns.");
    ui_slider(toolkit, "Flight", &settings->move_speed, 0.01F, 2, "%.2f");
    ui_tooltip(toolkit, "Widths of the scene a second; takes effect at the next start.");
    choose_text(toolkit, settings);
    ui_checkbox(toolkit, "Full screen", &settings->fullscreen);
    ui_tooltip(toolkit, "Key F11.");
    ui_note(toolkit, "Kept in view.json of $XDG_CONFIG_HOME/svocl.");
    ui_note(toolkit, "%s; %s; %s", ui_toolkit(), state->renderer != NULL ? state->renderer : "",
            state->device != NULL ? state->device : "");
}

/* ---- axes ---- */

#define AXES_EDGE    76.0F
#define LEGEND_WIDTH 300.0F
#define LEGEND_LEAST 110.0F
#define BAR_HEIGHT   12.0F
#define BAR_STRIPS   96
#define GAP          6.0F

/* An axis as the camera sees it: on the picture, and away from the eye. */
typedef struct seen_axis {
    float end[2];
    float away;
    int axis; /* -1: drawn */
} seen_axis;

static void see_axes(const view_state *state, seen_axis axes[3])
{
    float right[3];
    float above[3];
    float sight[3];
    camera_axes(state, right, above, sight);
    for (int axis = 0; axis < 3; ++axis) {
        axes[axis] = (seen_axis){{right[axis], -above[axis]}, sight[axis], axis};
    }
}

static void describe_axes(ui *toolkit, view_state *state, ui_place place)
{
    static const uint32_t colors[3] = {UI_COLOR_AXIS_X, UI_COLOR_AXIS_Y, UI_COLOR_AXIS_Z};
    static const char *const names[3] = {"x", "y", "z"};
    seen_axis axes[3];
    ui_place canvas;
    see_axes(state, axes);
    ui_panel_begin(toolkit, "#axes", place);
    (void)ui_canvas(toolkit, "#axes", AXES_EDGE - 2 * UI_PADDING, &canvas, NULL);
    const float middle[2] = {canvas.x + 0.5F * canvas.width, canvas.y + 0.5F * canvas.height};
    const float reach = 0.36F * fminf(canvas.width, canvas.height);
    for (int drawn = 0; drawn < 3; ++drawn) { /* far ones first */
        int next = -1;
        for (int i = 0; i < 3; ++i) {
            next = axes[i].axis >= 0 && (next < 0 || axes[i].away > axes[next].away) ? i : next;
        }
        const seen_axis *axis = &axes[next];
        const float end[2] = {middle[0] + reach * axis->end[0], middle[1] + reach * axis->end[1]};
        for (int thick = 0; thick < 2; ++thick) {
            const float shift = 0.6F * (float)thick;
            ui_line(toolkit, (const float[2]){middle[0] + shift, middle[1] + shift},
                    (const float[2]){end[0] + shift, end[1] + shift}, colors[next]);
        }
        const float beside[2] = {middle[0] + 1.28F * reach * axis->end[0], middle[1] + 1.28F * reach * axis->end[1]};
        ui_fill_text(toolkit, beside[0] - 0.5F * ui_text_width(toolkit, names[next]),
                     beside[1] - 0.35F * ui_row_height(toolkit), colors[next], names[next]);
        axes[next].axis = -1;
    }
    if (state->ground_spacing > 0) {
        ui_note(toolkit, "grid %g", (double)state->ground_spacing);
    }
    (void)ui_panel_end(toolkit);
}

/* ---- legends ---- */

static float clamped(float value)
{
    return value < 0 ? 0 : value > 1 ? 1 : value;
}

static uint32_t pack(const float rgb[3])
{
    return UI_RGBA((uint32_t)(clamped(rgb[0]) * 255 + 0.5F), (uint32_t)(clamped(rgb[1]) * 255 + 0.5F),
                   (uint32_t)(clamped(rgb[2]) * 255 + 0.5F), 255);
}

/* The colors of kernels/rays/view.cl and kernels/light/picture.cl at a share of the bar. */
static uint32_t color_at(view_picture picture, float share)
{
    const float coded = share <= 0.0031308F ? 12.92F * share : 1.055F * powf(share, 1 / 2.4F) - 0.055F;
    const float gray = picture == VIEW_DEPTH ? 1 - 0.9F * share : coded;
    float rgb[3] = {gray, gray, gray};
    if (picture == VIEW_STEPS) {
        view_colors_steps(share, rgb);
    }
    return pack(rgb);
}

/* The color of a level, on the faces that have it in full. */
static uint32_t color_of_level(unsigned level)
{
    uint32_t mixed = (level * 7 + 1) * 2654435769u;
    mixed = (mixed ^ mixed >> 15) * 2246822519u;
    mixed ^= mixed >> 13;
    float rgb[3];
    for (unsigned i = 0; i < 3; ++i) {
        rgb[i] = 0.25F + (float)(mixed >> 8 * i & 255u) * (0.75F / 255);
    }
    return pack(rgb);
}

/* A number at a share of a row of text, inside of it. */
static void write_at(ui *toolkit, ui_place row, float share, const char *text)
{
    const float width = ui_text_width(toolkit, text);
    const float x = fminf(fmaxf(row.x + share * row.width - 0.5F * width, row.x), row.x + row.width - width);
    ui_fill_text(toolkit, x, row.y, UI_COLOR_TEXT, text);
}

static void describe_bar(ui *toolkit, const view_state *state, float low, float high, const char *format)
{
    ui_place bar;
    ui_place row;
    char text[32];
    (void)ui_canvas(toolkit, "#bar", BAR_HEIGHT, &bar, NULL);
    for (int i = 0; i < BAR_STRIPS; ++i) {
        const float begin = floorf(bar.x + bar.width * (float)i / BAR_STRIPS);
        const float end = floorf(bar.x + bar.width * (float)(i + 1) / BAR_STRIPS);
        ui_fill(toolkit, (ui_place){begin, bar.y, end - begin, bar.height},
                color_at(state->shown.picture, ((float)i + 0.5F) / BAR_STRIPS));
    }
    (void)ui_canvas(toolkit, "#numbers", ui_row_height(toolkit) - UI_GAP - 2 * UI_INSET_Y, &row, NULL);
    for (int i = 0; i <= 2; ++i) {
        (void)snprintf(text, sizeof text, format, (double)(low + 0.5F * (float)i * (high - low)));
        write_at(toolkit, row, 0.5F * (float)i, text);
    }
}

/* The levels that leaves and larger nodes may have, one patch each. */
static void describe_levels(ui *toolkit, const view_state *state)
{
    enum { SHOWN = 8 };
    ui_place bar;
    ui_place row;
    char text[16];
    const unsigned last = state->shown.level;
    const unsigned first = last > SHOWN ? last - SHOWN + 1 : 1;
    const unsigned count = last >= first ? last - first + 1 : 1;
    (void)ui_canvas(toolkit, "#bar", BAR_HEIGHT, &bar, NULL);
    (void)ui_canvas(toolkit, "#numbers", ui_row_height(toolkit) - UI_GAP - 2 * UI_INSET_Y, &row, NULL);
    for (unsigned i = 0; i < count; ++i) {
        const float width = bar.width / (float)count;
        ui_fill(toolkit, (ui_place){bar.x + width * (float)i, bar.y, width - 2, bar.height}, color_of_level(first + i));
        (void)snprintf(text, sizeof text, "%u", first + i);
        write_at(toolkit, row, ((float)i + 0.5F) / (float)count, text);
    }
}

/* Only views of numbers have one. */
static void describe_legend(ui *toolkit, const view_state *state, ui_place place)
{
    ui_panel_begin(toolkit, "#legend", place);
    switch (state->shown.picture) {
    case VIEW_DEPTH:
        ui_note(toolkit, "Distance from the eye, world units");
        describe_bar(toolkit, state, state->depth_range[0], state->depth_range[1], "%.4g");
        break;
    case VIEW_STEPS:
        ui_note(toolkit, "Cells that the ray visited");
        describe_bar(toolkit, state, 0, VIEW_COLORS_STEPS_HOT, "%.0f");
        break;
    case VIEW_AO:
        ui_note(toolkit, "Openness: share of the hemisphere");
        describe_bar(toolkit, state, 0, 1, "%.1f");
        break;
    default:
        ui_note(toolkit, "Level of the node");
        describe_levels(toolkit, state);
        break;
    }
    (void)ui_panel_end(toolkit);
}

static bool has_legend(const view_state *state)
{
    const view_picture picture = state->shown.picture;
    const bool is_of_tree = !state->is_scene && !state->shown.through;
    return is_of_tree &&
           (picture == VIEW_DEPTH || picture == VIEW_STEPS || picture == VIEW_LEVEL || picture == VIEW_AO);
}

void panels_guides(ui *toolkit, view_state *state, ui_place free)
{
    const float text = ui_row_height(toolkit);
    const float axes_height = AXES_EDGE + (state->ground_spacing > 0 ? text : 0);
    const float legend_height = 2 * text + BAR_HEIGHT + 2 * UI_PADDING;
    const float bottom = free.y + free.height;
    if (state->settings.axes && free.width >= AXES_EDGE && free.height > 3 * axes_height) {
        describe_axes(toolkit, state, (ui_place){free.x, bottom - axes_height, AXES_EDGE, axes_height});
        free.x += AXES_EDGE + GAP;
        free.width -= AXES_EDGE + GAP;
    }
    if (has_legend(state) && free.width >= LEGEND_LEAST && free.height > 3 * legend_height) {
        const float width = fminf(LEGEND_WIDTH, free.width);
        describe_legend(toolkit, state,
                        (ui_place){free.x + free.width - width, bottom - legend_height, width, legend_height});
    }
}
