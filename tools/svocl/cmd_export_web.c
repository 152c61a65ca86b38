/* SPDX-License-Identifier: MIT */
/* svocl export-web: a page of one file that shows a tree in a browser. */
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "support/exposure.h"
#include "support/lighting.h"
#include "support/options_parse.h"
#include "support/output.h"
#include "support/table.h"
#include "support/tree_form.h"
#include "support/viewpoint.h"
#include "svocl/commands.h"
#include "svocl/compact.h"
#include "web/bake.h"
#include "web/page.h"

/* Texels of the sky take at most so small a share of --max-bytes. */
#define SKY_SHARE 8u

/* What is made on the way from INPUT to the page. */
typedef struct web_export {
    job done; /* empty for a compact tree that is taken as it is */
    svo_compact *compact;
    lighting lit; /* of pages with light */
    web_light light;
    web_tree tree;
    web_page page;
    size_t page_bytes;
} web_export;

/* ---- the compact tree ---- */

static int make_compact(program *state, uint32_t minimize, web_export *made)
{
    const session *opened = &made->done.opened;
    const svo_compact_options wanted = {.struct_size = sizeof wanted,
                                        .form = SVO_FORM_IMPLIED,
                                        .leave_out = SVO_NEED_ALL & ~(SVO_NEED_COLOR | SVO_NEED_NORMAL),
                                        .directory_step_log2 = WEB_DIRECTORY_STEP_LOG2,
                                        .minimize = minimize | (uint32_t)state->options.minimize};
    const svo_tree *tree = made->done.result.tree;
    progress_step(state->progress, "making the compact tree");
    if (svo_compact_create(opened->device, tree, &wanted, opened->queue, &made->compact) != SVO_OK ||
        svo_compact_download(made->compact, opened->queue) != SVO_OK) {
        return program_fail_library(state, svo_device_message(opened->device));
    }
    return PROGRAM_DONE;
}

/* A file of a compact tree in the form that pages have is taken as it is; others are expanded. */
static int load_compact(program *state, web_export *made, bool lights)
{
    svo_compact_info info = SVO_COMPACT_INFO_INIT;
    int exit_code = input_refuse_build_options(state);
    if (exit_code == PROGRAM_DONE) {
        exit_code = input_load_compact(state, &made->compact);
    }
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    (void)svo_compact_get_info(made->compact, &info);
    const svo_compact_options wanted = {.form = SVO_FORM_IMPLIED,
                                        .directory_step_log2 = WEB_DIRECTORY_STEP_LOG2,
                                        .minimize = (uint32_t)state->options.minimize};
    if (!lights && tree_form_fits(made->compact, &wanted) && tree_form_is_plain(made->compact)) {
        program_begin_progress(state, 2);
        return PROGRAM_DONE;
    }
    svo_compact_destroy(&made->compact);
    exit_code = job_load(state, lights ? 5 : 3, &made->done);
    return exit_code == PROGRAM_DONE ? make_compact(state, info.minimized, made) : exit_code;
}

static int open_lit(program *state, web_export *made)
{
    const int exit_code = lighting_open(state, &made->lit);
    made->lit.for_cones = true; /* which bake the page */
    if (exit_code != PROGRAM_DONE || input_is_compact(state)) {
        return exit_code == PROGRAM_DONE ? load_compact(state, made, true) : exit_code;
    }
    const int loaded = lighting_tree(state, 5, &made->lit, &made->done);
    return loaded == PROGRAM_DONE ? make_compact(state, 0, made) : loaded;
}

static int open_unlit(program *state, web_export *made)
{
    if (input_is_compact(state)) {
        return load_compact(state, made, false);
    }
    const int exit_code =
        input_is_tree(state) ? job_load(state, 3, &made->done) : job_run(state, state->options.need, 3, &made->done);
    return exit_code == PROGRAM_DONE ? make_compact(state, 0, made) : exit_code;
}

/* ---- where the page begins ---- */

/* Light is baked where lights are given, or the view shows it. */
static bool is_lit(const options *given)
{
    return given->lights_path != NULL || given->view == OPTION_VIEW_FULL;
}

/* The page's view; false: it has no such view. */
static bool find_view(const options *given, int *view)
{
    static const struct {
        int option, view;
    } views[] = {{SVO_VIEW_SHADED, WEB_VIEW_SHADED}, {SVO_VIEW_NORMAL, WEB_VIEW_NORMAL},
                 {SVO_VIEW_DEPTH, WEB_VIEW_DEPTH},   {SVO_VIEW_STEPS, WEB_VIEW_STEPS},
                 {SVO_VIEW_LEVEL, WEB_VIEW_LEVEL},   {SVO_VIEW_AO, WEB_VIEW_OCCLUSION},
                 {OPTION_VIEW_FULL, WEB_VIEW_FULL}};
    for (size_t i = 0; i < sizeof views / sizeof views[0]; ++i) {
        if (views[i].option == given->view) {
            *view = views[i].view;
            return true;
        }
    }
    return false;
}

/* Without --view, a page with light begins with it. */
static int check_view(program *state, web_start *start)
{
    const options *given = &state->options;
    if (!find_view(given, &start->view)) {
        return program_fail(state, PROGRAM_WRONG_USAGE,
                            "a page has the views shaded, normal, depth, steps, level, ao and full alone");
    }
    if (!is_lit(given)) {
        static const char *const of_light[] = {"exposure", NULL};
        const int exit_code = options_refuse_groups(state, OPTION_LIGHT, "to a page without --lights or --view full");
        return exit_code == PROGRAM_DONE ? options_refuse(state, of_light, "to a page without --lights or --view full")
                                         : exit_code;
    }
    start->view = options_is_given(given, "view") ? start->view : (int)WEB_VIEW_FULL;
    return PROGRAM_DONE;
}

/* Pages hold one form. */
static int check_form(program *state)
{
    const options *given = &state->options;
    if (given->tree_form != 0 && given->tree_form != 1 + SVO_FORM_IMPLIED) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--tree-form %s: pages hold trees in form implied alone",
                            svo_name(SVO_NAME_FORM, (svo_form)(given->tree_form - 1)));
    }
    if (options_packing(given) != NULL) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--%s: pages hold payload unpacked", options_packing(given));
    }
    return given->directory_step_log2 == 0 || given->directory_step_log2 == (int)WEB_DIRECTORY_STEP_LOG2
               ? PROGRAM_DONE
               : program_fail(state, PROGRAM_WRONG_USAGE, "--directory-step %u: that of pages is %u",
                              1u << given->directory_step_log2, 1u << WEB_DIRECTORY_STEP_LOG2);
}

/* Where a camera stands that sees all of a tree, roughly: of those that are not on a device. */
static void frame_bounds(const web_export *made, svo_camera *camera)
{
    static const float direction[3] = {0.406F, 0.375F, 0.833F};
    const svo_compact_info *info = &made->tree.info;
    const double edge = web_tree_edge(&made->tree, info->depth);
    const web_page *page = &made->page;
    const double reach = 3.0 * edge * (double)(1u << info->depth);
    *camera = (svo_camera){.up = {0, 1, 0}, .vertical_fov = 0.56F};
    for (int axis = 0; axis < 3; ++axis) {
        const double middle = info->origin[axis] + 0.5 * edge * ((double)page->low[axis] + (double)page->high[axis]);
        camera->target[axis] = (float)middle;
        camera->eye[axis] = (float)(middle + reach * (double)direction[axis]);
    }
}

static int place_camera(program *state, web_export *made)
{
    const options *given = &state->options;
    web_start *start = &made->page.start;
    svo_tree *tree = made->done.result.tree;
    start->has_place = made->lit.file.has_camera || given->eye.is_given || given->look_at.is_given;
    start->has_fov = start->has_place || given->fov > 0;
    if (tree != NULL) {
        return lighting_place_camera(state, &made->lit, tree, &start->camera);
    }
    svo_camera framed;
    frame_bounds(made, &framed);
    return viewpoint_place(state, &(viewpoint_subject){.camera = &framed, .aspect = 1}, &start->camera);
}

/* ---- light ---- */

/* That of a picture by the camera that the page begins with. */
static int expose(program *state, web_export *made)
{
    const svo_gather_options gather = lighting_gather(&state->options);
    const svo_render_options asked = {.struct_size = sizeof asked,
                                      .width = state->options.width,
                                      .height = state->options.height,
                                      .camera = made->page.start.camera,
                                      .gather = &gather};
    exposure chosen;
    const int exit_code =
        exposure_choose(state, svo_light_target(made->lit.light), &asked, &made->done.opened, &chosen);
    made->page.shine.exposure = (double)chosen.value;
    return exit_code;
}

static int bake(program *state, web_export *made)
{
    web_shine *shine = &made->page.shine;
    svo_light_setup setup;
    int exit_code = lighting_setup_for_picture(state, &made->done, &made->page.start.camera, &made->lit, &setup);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    if (setup.source_count > WEB_SOURCES_MAX) {
        return program_fail(state, PROGRAM_FAILED, "%s: %zu lights, above the %u of a page", state->options.lights_path,
                            setup.source_count, WEB_SOURCES_MAX);
    }
    *shine = (web_shine){.sources = setup.sources,
                         .source_count = setup.source_count,
                         .sky = {setup.sky[0], setup.sky[1], setup.sky[2]}};
    if (!web_sky_make(&setup, (size_t)(state->options.max_bytes / SKY_SHARE), &shine->sky_map)) {
        return program_fail(state, PROGRAM_FAILED, "out of memory for the sky");
    }
    exit_code = lighting_make(state, &made->done, &setup, &made->lit);
    if (exit_code == PROGRAM_DONE) {
        exit_code = expose(state, made);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = web_bake(state, &made->tree, &made->lit, &made->done.opened, &made->light);
    }
    made->tree.light = &made->light;
    return exit_code;
}

/* ---- the page ---- */

/* What the page calls the tree: a page that is handed around does not say where its file was. */
static const char *name_of_input(const options *given)
{
    const char *slash = strrchr(given->input, '/');
    return slash != NULL && slash[1] != '\0' ? slash + 1 : given->input;
}

/* Packs the tree down to a level; *fits tells whether the page is within --max-bytes then. */
static int pack_level(program *state, uint32_t level, web_export *made, bool *fits)
{
    web_page *page = &made->page;
    const uint64_t most = state->options.max_bytes;
    page->cut = web_cut_at(&made->tree, level);
    free(page->packed.bytes);
    const web_pack_status status = web_pack(&made->tree, &page->cut, (size_t)most / 4 * 3, &page->packed);
    if (status == WEB_PACK_NO_MEMORY) {
        return program_fail(state, PROGRAM_FAILED, "out of memory for the compressed nodes");
    }
    if (status == WEB_PACK_TOO_LARGE) {
        return PROGRAM_DONE;
    }
    const int exit_code = web_page_measure(state, page, &made->page_bytes);
    *fits = made->page_bytes <= most;
    return exit_code;
}

/* The deepest level that fits. */
static int pack(program *state, web_export *made)
{
    bool fits = false;
    progress_step(state->progress, "compressing the nodes");
    for (uint32_t level = made->tree.info.depth; level > 0 && !fits; --level) {
        const int exit_code = pack_level(state, level, made, &fits);
        if (exit_code != PROGRAM_DONE) {
            return exit_code;
        }
    }
    return fits ? PROGRAM_DONE
                : program_fail(state, PROGRAM_FAILED,
                               "--max-bytes %" PRIu64 " is too small for a page of the first level alone",
                               state->options.max_bytes);
}

/* What the page shows, from where, and in which light. */
static int make_page(program *state, web_export *made)
{
    made->tree = web_tree_of(made->compact);
    made->page.name = name_of_input(&state->options);
    made->page.tree = &made->tree;
    if (!web_tree_bounds(&made->tree, made->page.low, made->page.high)) {
        return program_fail(state, PROGRAM_FAILED, "out of memory for the bounds");
    }
    int exit_code = place_camera(state, made);
    if (exit_code == PROGRAM_DONE && is_lit(&state->options)) {
        exit_code = bake(state, made);
    }
    return exit_code == PROGRAM_DONE ? pack(state, made) : exit_code;
}

static int write_page(program *state, web_export *made)
{
    output_file file;
    progress_step(state->progress, "writing the page");
    int exit_code = output_open(state, state->options.output_path, &file);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = web_page_write(state, &made->page, file.stream);
    if (exit_code != PROGRAM_DONE) {
        output_abandon(&file);
        return exit_code;
    }
    return output_commit(state, &file);
}

/* ---- the command ---- */

static int report_json(program *state, const web_export *made)
{
    const web_cut *cut = &made->page.cut;
    cJSON *document = json_document();
    json_add_text(document, "input", state->options.input);
    json_add_text(document, "file", state->options.output_path);
    json_add_count(document, "bytes", made->page_bytes);
    json_add_count(document, "max_bytes", state->options.max_bytes);
    json_add_count(document, "packed_bytes", made->page.packed.count);
    json_add_count(document, "unpacked_bytes", cut->byte_count);
    json_add_count(document, "depth", made->tree.info.depth);
    json_add_count(document, "level", cut->level);
    json_add_count(document, "nodes", cut->node_count);
    json_add_count(document, "leaves", cut->leaf_count);
    cJSON_AddBoolToObject(document, "colors", cut->colors.count > 0);
    cJSON_AddBoolToObject(document, "normals", cut->normals.count > 0);
    cJSON_AddBoolToObject(document, "light", cut->light.count > 0);
    return json_print(state, document);
}

static int report(program *state, const web_export *made)
{
    const options *given = &state->options;
    const web_cut *cut = &made->page.cut;
    const uint32_t depth = made->tree.info.depth;
    if (given->json) {
        return report_json(state, made);
    }
    if (given->quiet) {
        return PROGRAM_DONE;
    }
    progress_hide(state->progress);
    table_line("%s: %s, %s leaves at depth %u of %s%s%s%s", output_name(given->output_path),
               figure_bytes(made->page_bytes).text, figure_count(cut->leaf_count).text, cut->level, given->input,
               cut->colors.count > 0 ? ", colors" : "", cut->normals.count > 0 ? ", normals" : "",
               cut->light.count > 0 ? ", light" : "");
    lighting_report_chosen(&made->lit);
    if (cut->level < depth) {
        table_line("Levels %u to %u are left out: with them the page would exceed %s (--max-bytes).", cut->level + 1,
                   depth, figure_bytes(given->max_bytes).text);
    }
    return PROGRAM_DONE;
}

int command_export_web(program *state)
{
    web_export made = {0};
    if (state->options.output_path == NULL) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "-o FILE is missing");
    }
    int exit_code = check_view(state, &made.page.start);
    if (exit_code == PROGRAM_DONE) {
        exit_code = check_form(state);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = output_check(state, state->options.output_path);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = is_lit(&state->options) ? open_lit(state, &made) : open_unlit(state, &made);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = make_page(state, &made);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = write_page(state, &made);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = report(state, &made);
    }
    free(made.page.packed.bytes);
    free(made.light.texels);
    free(made.page.shine.sky_map.texels);
    svo_compact_destroy(&made.compact);
    svo_light_destroy(&made.lit.light);
    job_release(&made.done);
    lighting_close(&made.lit);
    return exit_code;
}
