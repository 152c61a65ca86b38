/* SPDX-License-Identifier: MIT */
/*
 * Panels of svocl view: widgets answer the mouse and keys, the same inputs give the same triangles,
 * the picture's center stays free, and memory that runs out is a failure in words.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "support/suite.h"
#include "view/edit.h"
#include "view/panels.h"

/* ---- memory that runs out ---- */

static size_t calls_until_failure; /* 0: none fails */

static int fails(void)
{
    return calls_until_failure > 0 && --calls_until_failure == 0;
}

/* NOLINTBEGIN(readability-identifier-naming): the linker's names */
void *__real_malloc(size_t bytes);
void *__real_calloc(size_t count, size_t bytes);
void *__real_realloc(void *block, size_t bytes);
void *__wrap_malloc(size_t bytes);
void *__wrap_calloc(size_t count, size_t bytes);
void *__wrap_realloc(void *block, size_t bytes);

void *__wrap_malloc(size_t bytes)
{
    return fails() ? NULL : __real_malloc(bytes);
}

void *__wrap_calloc(size_t count, size_t bytes)
{
    return fails() ? NULL : __real_calloc(count, bytes);
}

void *__wrap_realloc(void *block, size_t bytes)
{
    return fails() ? NULL : __real_realloc(block, bytes);
}
/* NOLINTEND(readability-identifier-naming) */

/* ---- a panel with a widget of each kind ---- */

enum { ROW_CHECKBOX, ROW_SLIDER, ROW_BUTTONS, ROW_FIELD, ROW_SECTION, ROW_NUMBERS, ROW_ITEM, ROW_DISABLED };

#define PANEL_WIDTH 300.0F

/* What the widgets show, and how often they said that they were used. */
typedef struct shown {
    bool checkbox, disabled, section;
    float slider, number;
    char field[32];
    int last_button;
    int buttons, entered, items, sections;
} shown;

static void describe(ui *toolkit, shown *state)
{
    static const char *const names[] = {"one", "two", "three"};
    ui_panel_begin(toolkit, "panel", (ui_place){0, 0, PANEL_WIDTH, 350});
    (void)ui_checkbox(toolkit, "checkbox", &state->checkbox);
    (void)ui_slider(toolkit, "slider", &state->slider, 0, 1, "%.2f");
    const int button = ui_buttons(toolkit, names, 3);
    if (button >= 0) {
        state->last_button = button;
        ++state->buttons;
    }
    state->entered += ui_field(toolkit, "field", state->field, sizeof state->field) ? 1 : 0;
    state->sections += ui_section(toolkit, "section", "F1", &state->section) ? 1 : 0;
    (void)ui_numbers(toolkit, "number", &state->number, 1, 0.5F, "%.1f");
    state->items += ui_item(toolkit, "item", false) ? 1 : 0;
    ui_enable(toolkit, false);
    (void)ui_checkbox(toolkit, "disabled", &state->disabled);
    ui_enable(toolkit, true);
    (void)ui_panel_end(toolkit);
}

typedef struct session {
    ui *toolkit;
    ui_events events;
    shown state;
    const ui_drawing *drawing; /* of the last frame */
} session;

static session begin_session(void)
{
    session made = {.toolkit = ui_create(1)};
    assert_non_null(made.toolkit);
    ui_events_begin(&made.events);
    return made;
}

static void play_frame(session *at)
{
    const ui_input input = ui_events_frame(&at->events, 640, 400, 1.0F / 60);
    ui_begin(at->toolkit, &input);
    describe(at->toolkit, &at->state);
    at->drawing = ui_end(at->toolkit);
    assert_non_null(at->drawing);
}

static int middle_of_row(const session *at, int row)
{
    const float height = ui_row_height(at->toolkit);
    return (int)(UI_PADDING + height * (float)row + (height - UI_GAP) / 2);
}

static void move_to(session *at, int x, int y)
{
    const view_event event = {.kind = VIEW_EVENT_MOVE, .x = x, .y = y};
    ui_events_take(&at->events, &event);
    play_frame(at);
}

static void press(session *at, int x, int y, bool is_down)
{
    const view_event event = {.kind = VIEW_EVENT_BUTTON, .is_down = is_down, .x = x, .y = y};
    ui_events_take(&at->events, &event);
    play_frame(at);
}

static void click(session *at, int x, int y)
{
    move_to(at, x, y);
    press(at, x, y, true);
    press(at, x, y, false);
    play_frame(at);
}

static void press_key(session *at, int key)
{
    view_event event = {.kind = VIEW_EVENT_KEY, .key = key, .is_down = true};
    ui_events_take(&at->events, &event);
    play_frame(at);
    event.is_down = false;
    ui_events_take(&at->events, &event);
    play_frame(at);
}

static void type(session *at, const char *text)
{
    view_event event = {.kind = VIEW_EVENT_TEXT};
    (void)snprintf(event.text, sizeof event.text, "%s", text);
    ui_events_take(&at->events, &event);
    play_frame(at);
}

/* ---- widgets ---- */

static void test_clicks(void **unused)
{
    (void)unused;
    session at = begin_session();
    play_frame(&at);
    click(&at, 16, middle_of_row(&at, ROW_CHECKBOX));
    assert_true(at.state.checkbox);
    click(&at, 16, middle_of_row(&at, ROW_DISABLED));
    assert_false(at.state.disabled);
    click(&at, (int)PANEL_WIDTH / 2, middle_of_row(&at, ROW_BUTTONS));
    assert_int_equal(at.state.buttons, 1);
    assert_int_equal(at.state.last_button, 1);
    click(&at, 40, middle_of_row(&at, ROW_ITEM));
    assert_int_equal(at.state.items, 1);
    click(&at, 40, middle_of_row(&at, ROW_SECTION));
    assert_int_equal(at.state.sections, 1);
    assert_true(at.state.section);
    click(&at, 500, middle_of_row(&at, ROW_CHECKBOX));
    assert_true(at.state.checkbox);
    ui_destroy(&at.toolkit);
}

/* Both in one frame, as a slow picture makes them. */
static void test_click_within_a_frame(void **unused)
{
    (void)unused;
    session at = begin_session();
    play_frame(&at);
    const int y = middle_of_row(&at, ROW_CHECKBOX);
    move_to(&at, 16, y);
    view_event event = {.kind = VIEW_EVENT_BUTTON, .is_down = true, .x = 16, .y = y};
    ui_events_take(&at.events, &event);
    event.is_down = false;
    ui_events_take(&at.events, &event);
    play_frame(&at);
    play_frame(&at);
    assert_true(at.state.checkbox);
    ui_destroy(&at.toolkit);
}

static void test_drags(void **unused)
{
    (void)unused;
    session at = begin_session();
    const float left = UI_PADDING + (PANEL_WIDTH - 2 * UI_PADDING) * UI_LABEL_SHARE;
    const int middle = (int)((left + PANEL_WIDTH - UI_PADDING) / 2);
    play_frame(&at);
    int y = middle_of_row(&at, ROW_SLIDER);
    move_to(&at, middle, y);
    press(&at, middle, y, true);
    assert_float_equal(at.state.slider, 0.5F, 0.03F);
    move_to(&at, 600, y);
    assert_float_equal(at.state.slider, 1, 0);
    press(&at, 600, y, false);
    y = middle_of_row(&at, ROW_NUMBERS);
    move_to(&at, middle, y);
    press(&at, middle, y, true);
    move_to(&at, middle + 20, y);
    move_to(&at, middle + 40, y);
    press(&at, middle + 40, y, false);
    assert_in_range((int)at.state.number, 8, 20);
    assert_float_equal(at.state.slider, 1, 0);
    ui_destroy(&at.toolkit);
}

static void test_field(void **unused)
{
    (void)unused;
    session at = begin_session();
    play_frame(&at);
    click(&at, 200, middle_of_row(&at, ROW_FIELD));
    assert_true(ui_wants_keys(at.toolkit));
    type(&at, "ab\xC3\xBC");
    assert_string_equal(at.state.field, "ab\xC3\xBC");
    press_key(&at, VIEW_KEY_BACKSPACE);
    assert_string_equal(at.state.field, "ab");
    press_key(&at, VIEW_KEY_ENTER);
    assert_int_equal(at.state.entered, 1);
    assert_false(ui_wants_keys(at.toolkit));
    type(&at, "c");
    assert_string_equal(at.state.field, "ab");
    ui_destroy(&at.toolkit);
}

static void test_whose_mouse(void **unused)
{
    (void)unused;
    session at = begin_session();
    play_frame(&at);
    move_to(&at, 100, 30);
    assert_true(ui_wants_mouse(at.toolkit));
    move_to(&at, 100, 330); /* below what the panel holds */
    assert_false(ui_wants_mouse(at.toolkit));
    move_to(&at, 500, 30);
    assert_false(ui_wants_mouse(at.toolkit));
    ui_destroy(&at.toolkit);
}

/* ---- drawings ---- */

static void assert_same_drawing(const ui_drawing *a, const ui_drawing *b)
{
    assert_int_equal(a->vertex_count, b->vertex_count);
    assert_int_equal(a->index_count, b->index_count);
    assert_int_equal(a->batch_count, b->batch_count);
    assert_true(a->vertex_count > 100 && a->batch_count > 0);
    assert_memory_equal(a->vertices, b->vertices, a->vertex_count * sizeof *a->vertices);
    assert_memory_equal(a->indices, b->indices, a->index_count * sizeof *a->indices);
    assert_memory_equal(a->batches, b->batches, a->batch_count * sizeof *a->batches);
}

/* A copy whose arrays are its own. */
static ui_drawing copy_drawing(const ui_drawing *from)
{
    ui_drawing copy = *from;
    copy.vertices = malloc(from->vertex_count * sizeof *from->vertices);
    copy.indices = malloc(from->index_count * sizeof *from->indices);
    copy.batches = malloc(from->batch_count * sizeof *from->batches);
    memcpy(copy.vertices, from->vertices, from->vertex_count * sizeof *from->vertices);
    memcpy(copy.indices, from->indices, from->index_count * sizeof *from->indices);
    memcpy(copy.batches, from->batches, from->batch_count * sizeof *from->batches);
    return copy;
}

static ui_drawing play_session(void)
{
    session at = begin_session();
    play_frame(&at);
    click(&at, 16, middle_of_row(&at, ROW_CHECKBOX));
    click(&at, 200, middle_of_row(&at, ROW_FIELD));
    type(&at, "out.json");
    click(&at, 200, middle_of_row(&at, ROW_SLIDER));
    const ui_drawing copy = copy_drawing(at.drawing);
    ui_destroy(&at.toolkit);
    return copy;
}

static void test_same_inputs_same_triangles(void **unused)
{
    (void)unused;
    ui_drawing first = play_session();
    ui_drawing second = play_session();
    assert_same_drawing(&first, &second);
    ui_drawing_free(&first);
    ui_drawing_free(&second);
}

/* ---- the viewer's panels ---- */

#define MAP_TEXTURE 7u

/* Two probes, of which one is off, and the map of the first. */
static void fill_probes(view_probes *probes)
{
    static const svo_probe places[2] = {{.state = SVO_PROBE_IN_PLACE}, {.state = SVO_PROBE_OFF}};
    static const uint32_t texels[2 * 64 * 64];
    probes->made = (svo_probe_info){.resolution = 64, .probe_count = 2, .off = 1, .leaf_edge = 1, .farthest = 10};
    probes->planned = probes->made;
    probes->places = places;
    probes->texels = texels;
    probes->has_map = true;
    probes->texture = MAP_TEXTURE;
}

static void fill_state(view_state *state, unsigned width, unsigned height)
{
    static const view_tree trees[] = {{.name = "atrium", .path = "scene:atrium", .depth = 8}};
    view_state_begin(state);
    state->width = width;
    state->height = height;
    state->level_min = 1;
    state->level_max = 9;
    state->shown.level = 8;
    state->trees = trees;
    state->tree_count = 1;
    state->camera.at = (svo_camera){.eye = {1, 2, 10}, .up = {0, 1, 0}, .vertical_fov = 0.6F};
    assert_true(light_edit_add(state, SVO_SOURCE_DIRECTIONAL));
    assert_true(light_edit_add(state, SVO_SOURCE_SPOT));
    for (int i = 0; i < 2 * VIEW_FRAMES_KEPT; ++i) {
        state->frames[state->frame_count++ % VIEW_FRAMES_KEPT] =
            (view_frame){.ms = 20, .stage_ms = {[VIEW_STAGE_PICTURE] = 15}, .rays = 1000, .coarse = 2};
    }
    for (int i = 0; i < VIEW_MEMORY_MAX; ++i) {
        state->memory[state->memory_count++] = (view_memory){.name = "a buffer", .bytes = 1U << (i % 30)};
    }
    for (int i = 0; i < 2 * VIEW_LOG_LINES; ++i) {
        view_log(state, "line %d of the log, which is longer than a column is wide", i);
    }
    state->selection.is_hit = true;
    state->selection.list_count = state->selection.list_kept = VIEW_LIST_KEPT;
    memset(state->settings.open, true, sizeof state->settings.open);
    fill_probes(&state->probes);
}

/* The viewer's panels in a window, and a hand over them. */
typedef struct panels_session {
    ui *toolkit;
    ui_events events;
    view_state *state;
} panels_session;

static panels_session begin_panels(unsigned width, unsigned height)
{
    panels_session made = {.toolkit = ui_create(1), .state = malloc(sizeof *made.state)};
    assert_true(made.toolkit != NULL && made.state != NULL);
    fill_state(made.state, width, height);
    ui_events_begin(&made.events);
    return made;
}

static void end_panels(panels_session *at)
{
    view_state_end(at->state);
    free(at->state);
    ui_destroy(&at->toolkit);
}

static const ui_drawing *describe_panels(panels_session *at)
{
    const view_state *state = at->state;
    ui_input input = ui_events_frame(&at->events, state->width, state->height, 1.0F / 60);
    input.large = panels_text_is_large(state);
    ui_begin(at->toolkit, &input);
    panels_describe(at->toolkit, at->state);
    return ui_end(at->toolkit);
}

static void click_panels(panels_session *at, int x, int y)
{
    const view_event events[] = {{.kind = VIEW_EVENT_MOVE, .x = x, .y = y},
                                 {.kind = VIEW_EVENT_BUTTON, .is_down = true, .x = x, .y = y},
                                 {.kind = VIEW_EVENT_BUTTON, .x = x, .y = y}};
    for (size_t i = 0; i < sizeof events / sizeof events[0]; ++i) {
        ui_events_take(&at->events, &events[i]);
        assert_non_null(describe_panels(at));
    }
}

/* How far a batch reaches into a rectangle: pixels of what its clip leaves there. */
static bool reaches(const ui_drawing *drawing, const ui_batch *batch, const float place[4])
{
    for (uint32_t i = batch->index_begin; i < batch->index_begin + batch->index_count; ++i) {
        const ui_vertex *corner = &drawing->vertices[drawing->indices[i]];
        if (corner->x > place[0] && corner->x < place[2] && corner->y > place[1] && corner->y < place[3] &&
            corner->y < (float)batch->clip[3]) {
            return true;
        }
    }
    return false;
}

static void test_center_is_free(void **unused)
{
    (void)unused;
    static const unsigned sizes[][2] = {{160, 160}, {640, 400}, {1280, 800}, {3840, 2160}};
    static scene_key key;
    static const scene_motion motion = {0, &key, 1};
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; ++i) {
        const float width = (float)sizes[i][0];
        const float height = (float)sizes[i][1];
        const float center[4] = {0.36F * width, 0, 0.64F * width, height - 40 - 100};
        panels_session at = begin_panels(sizes[i][0], sizes[i][1]);
        for (int scene = 0; scene < 3; ++scene) {
            assert_true(scene < 2 || view_add_mover(at.state, &(view_mover){.motion = &motion}));
            view_choose_scene(at.state, scene == 1);
            (void)describe_panels(&at);
            const ui_drawing *drawing = describe_panels(&at);
            assert_non_null(drawing);
            assert_true(drawing->vertex_count > 200);
            for (size_t k = 0; k < drawing->batch_count; ++k) {
                assert_false(reaches(drawing, &drawing->batches[k], center));
            }
        }
        end_panels(&at);
    }
}

/* The first row of the left column is a heading. */
static void test_heading_opens(void **unused)
{
    (void)unused;
    panels_session at = begin_panels(640, 400);
    memset(at.state->settings.open, false, sizeof at.state->settings.open);
    (void)describe_panels(&at);
    click_panels(&at, 60, 22);
    assert_true(at.state->settings.open[VIEW_PANEL_HELP]);
    at.state->settings.panels = false;
    assert_int_equal(describe_panels(&at)->index_count, 0);
    end_panels(&at);
}

/* Clicks a row of the right column, of which the first ones are headings. */
static void click_right(panels_session *at, int row)
{
    click_panels(at, 445, (int)(6 + UI_PADDING + ui_row_height(at->toolkit) * ((float)row + 0.5F)));
}

static bool draws_map(const ui_drawing *drawing)
{
    bool is_drawn = false;
    for (size_t i = 0; i < drawing->batch_count; ++i) {
        const ui_batch *batch = &drawing->batches[i];
        is_drawn = is_drawn || (batch->texture == MAP_TEXTURE && batch->index_count == 6);
    }
    return is_drawn;
}

/* The panel of probes looks through them, and shows spheres and the map. */
static void test_probes_are_shown(void **unused)
{
    (void)unused;
    panels_session at = begin_panels(640, 400);
    memset(at.state->settings.open, false, sizeof at.state->settings.open);
    at.state->settings.open[VIEW_PANEL_PROBES] = true;
    (void)describe_panels(&at);
    click_right(&at, 4);
    assert_true(at.state->shown.through);
    click_right(&at, 7);
    assert_true(at.state->probes.has_spheres);
    assert_true(draws_map(describe_panels(&at)));
    click_right(&at, 10);
    assert_false(at.state->probes.has_map);
    at.state->probes.texels = NULL; /* as the drawing does then */
    assert_false(draws_map(describe_panels(&at)));
    end_panels(&at);
}

/* ---- texts and boxes ---- */

static void test_texts_end_at_words(void **unused)
{
    (void)unused;
    static const char text[] = "Portable Computing Language, a device";
    char fitted[sizeof text + 8];
    panels_session at = begin_panels(640, 400);
    (void)describe_panels(&at);
    const float whole = ui_text_width(at.toolkit, text);
    assert_true(ui_fit(at.toolkit, text, whole, fitted, sizeof fitted));
    assert_string_equal(fitted, text);
    assert_false(ui_fit(at.toolkit, text, whole - 1, fitted, sizeof fitted));
    assert_string_equal(fitted, "Portable Computing Language, a...");
    assert_false(ui_fit(at.toolkit, text, ui_text_width(at.toolkit, "Portable Comp..."), fitted, sizeof fitted));
    assert_string_equal(fitted, "Portable...");
    assert_false(ui_fit(at.toolkit, text, ui_text_width(at.toolkit, "Porta..."), fitted, sizeof fitted));
    assert_string_equal(fitted, "Porta...");
    assert_false(ui_fit(at.toolkit, "\xC3\xA9\xC3\xA9\xC3\xA9", ui_text_width(at.toolkit, "\xC3\xA9..."), fitted,
                        sizeof fitted));
    assert_string_equal(fitted, "\xC3\xA9...");
    end_panels(&at);
}

/* How far the rightmost corner of a color is. */
static float reach_of(const ui_drawing *drawing, uint32_t color)
{
    float reach = 0;
    for (size_t i = 0; i < drawing->vertex_count; ++i) {
        const ui_vertex *corner = &drawing->vertices[i];
        reach = corner->color == color && corner->x > reach ? corner->x : reach;
    }
    return reach;
}

/* The box of work has a bar that grows with the steps, and stays within the window. */
static void test_work_has_a_bar(void **unused)
{
    (void)unused;
    panels_session at = begin_panels(640, 400);
    panels_work work = {.name = "folder/a.obj",
                        .progress = {.what = "building the tree", .stage = "pack", .step = 2, .step_count = 2},
                        .seconds = 12};
    float before = 0;
    for (int quarter = 1; quarter <= 4; ++quarter) {
        work.progress.part = 0.25 * quarter;
        const ui_input input = ui_events_frame(&at.events, 640, 400, 1.0F / 60);
        ui_begin(at.toolkit, &input);
        panels_describe_work(at.toolkit, &work, 640, 400);
        const ui_drawing *drawing = ui_end(at.toolkit);
        assert_non_null(drawing);
        const float reach = reach_of(drawing, UI_COLOR_ACCENT);
        assert_true(reach > before && reach < 540);
        before = reach;
    }
    end_panels(&at);
}

/* ---- memory ---- */

/* Opens the panels and shows three frames; false when memory ran out. */
static bool show_panels(view_state *state)
{
    const view_event event = {.kind = VIEW_EVENT_MOVE, .x = 60, .y = 60};
    panels_session at = {.toolkit = ui_create(1), .state = state};
    bool is_shown = at.toolkit != NULL;
    ui_events_begin(&at.events);
    for (int i = 0; i < 3 && is_shown; ++i) {
        ui_events_take(&at.events, &event);
        is_shown = describe_panels(&at) != NULL;
    }
    if (at.toolkit != NULL) {
        /* What comes after a failure does nothing. */
        is_shown = describe_panels(&at) != NULL && is_shown;
        (void)ui_wants_mouse(at.toolkit);
        (void)ui_wants_keys(at.toolkit);
        ui_destroy(&at.toolkit);
    }
    return is_shown;
}

static void test_each_allocation_fails(void **unused)
{
    (void)unused;
    view_state *state = malloc(sizeof *state);
    fill_state(state, 640, 400);
    size_t failed = 0;
    for (size_t call = 1;; ++call) {
        calls_until_failure = call;
        const bool is_shown = show_panels(state);
        const bool all_succeeded = calls_until_failure > 0;
        calls_until_failure = 0;
        if (all_succeeded) {
            assert_true(is_shown);
            break;
        }
        failed += is_shown ? 0 : 1;
    }
    assert_true(failed > 5);
    view_state_end(state);
    free(state);
}

TEST_GROUP(view_panels)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_clicks),
        cmocka_unit_test(test_click_within_a_frame),
        cmocka_unit_test(test_drags),
        cmocka_unit_test(test_field),
        cmocka_unit_test(test_whose_mouse),
        cmocka_unit_test(test_same_inputs_same_triangles),
        cmocka_unit_test(test_center_is_free),
        cmocka_unit_test(test_heading_opens),
        cmocka_unit_test(test_probes_are_shown),
        cmocka_unit_test(test_texts_end_at_words),
        cmocka_unit_test(test_work_has_a_bar),
        cmocka_unit_test(test_each_allocation_fails),
    };
    return cmocka_run_group_tests_name("view_panels", tests, NULL, NULL);
}
