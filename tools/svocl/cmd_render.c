/* SPDX-License-Identifier: MIT */
/* svocl render: renders a tree or a scene of trees, framed or as a camera sees it. */
#include <stdlib.h>

#include "support/animation.h"
#include "support/job.h"
#include "support/options_parse.h"
#include "support/output.h"
#include "support/picture.h"
#include "support/probe_picture.h"
#include "support/scene_file.h"
#include "support/table.h"
#include "support/tree_form.h"
#include "support/value_scale.h"
#include "support/viewpoint.h"
#include "svocl/commands.h"
#include "svocl/render.h"

static int report_picture(program *state, const session *opened, const svo_camera *camera, const value_scale *scale,
                          double render_ms)
{
    const options *given = &state->options;
    if (given->json) {
        cJSON *document = picture_document(state);
        value_scale_report(document, scale);
        return picture_print_document(state, document, render_ms, opened->device, camera);
    }
    if (given->quiet) {
        return PROGRAM_DONE;
    }
    progress_hide(state->progress);
    table_line("%s of %s in %s", picture_describe(given).text, given->input, figure_ms(render_ms).text);
    return PROGRAM_DONE;
}

/* A tree or a compact tree on the device, with its arrays on the host. */
typedef struct tree_render {
    program *state;
    const session *opened;
    svo_target target;
    float *numbers; /* owned: of a picture that has a scale */
    value_scale scale;
} tree_render;

static int draw_tree(const tree_render *work, const svo_render_options *asked, void *pixels)
{
    return svo_render(work->target, asked, svo_in_host(pixels), &(svo_submit){.queue = work->opened->queue}) == SVO_OK
               ? PROGRAM_DONE
               : program_fail_library(work->state, svo_device_message(work->opened->device));
}

/* A picture of numbers as colors, with their scale. */
static int draw_scaled(tree_render *work, const svo_render_options *asked, uint8_t *pixels)
{
    svo_render_options linear = *asked;
    linear.output = (svo_picture_output){.format = SVO_PIXELS_LINEAR, .samples = asked->output.samples};
    if (work->numbers == NULL) {
        work->numbers = malloc((size_t)asked->width * asked->height * 4 * sizeof *work->numbers);
    }
    if (work->numbers == NULL) {
        return program_fail(work->state, PROGRAM_FAILED, "out of memory for the numbers of %ux%u pixels", asked->width,
                            asked->height);
    }
    const int exit_code = draw_tree(work, &linear, work->numbers);
    if (exit_code == PROGRAM_DONE) {
        value_scale_color(asked, &asked->output, work->numbers, pixels, &work->scale);
    }
    return exit_code;
}

static int draw(void *user, const svo_camera *camera, const svo_picture_output *output, uint8_t *pixels)
{
    tree_render *work = user;
    const options *given = &work->state->options;
    const svo_render_options asked = {.struct_size = sizeof asked,
                                      .width = given->width,
                                      .height = given->height,
                                      .camera = *camera,
                                      .view = (svo_render_view)given->view,
                                      .output = *output};
    const bool has_scale = output->format == SVO_PIXELS_BYTES && value_scale_suits(asked.view);
    return has_scale ? draw_scaled(work, &asked, pixels) : draw_tree(work, &asked, pixels);
}

static int render(program *state, const session *opened, svo_target target)
{
    tree_render work = {.state = state, .opened = opened, .target = target};
    const viewpoint_subject shown = {.target = target, .aspect = viewpoint_aspect(state)};
    svo_camera camera;
    double render_ms = 0;
    int exit_code = viewpoint_place(state, &shown, &camera);
    if (exit_code == PROGRAM_DONE) {
        exit_code = picture_draw(state, "casting rays", &camera, draw, &work, &render_ms);
    }
    free(work.numbers);
    return exit_code == PROGRAM_DONE ? report_picture(state, opened, &camera, &work.scale, render_ms) : exit_code;
}

/* Steps of the progress bar after the tree. */
static unsigned further_steps(const program *state)
{
    return 1 + picture_frames(&state->options) + (state->options.tree_form != 0 ? 1 : 0);
}

static int build_tree(program *state, job *done)
{
    const int exit_code = job_open(state, state->options.need, further_steps(state), done);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    uint32_t need = picture_need(&done->source, state->options.need);
    if (state->options.view == SVO_VIEW_TRIANGLES) {
        need = (need & ~(uint32_t)SVO_NEED_NONE) | (uint32_t)SVO_NEED_RAYS;
    }
    const int built = job_build(state, need, done);
    if (built != PROGRAM_DONE) {
        job_release(done);
    }
    return built;
}

/* A mesh, voxels, or a finished tree, of whatever form; drawn in the form of --tree-form. */
static int render_tree(program *state)
{
    job done;
    svo_compact *compact = NULL;
    int exit_code = input_is_compact(state) ? tree_form_load(state, further_steps(state), &done, &compact)
                    : input_is_tree(state)  ? job_load(state, further_steps(state), &done)
                                            : build_tree(state, &done);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    if (compact == NULL) {
        exit_code = tree_form_take(state, &done, &compact);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = render(state, &done.opened,
                           compact != NULL ? svo_compact_target(compact) : svo_tree_target(done.result.tree));
    }
    svo_compact_destroy(&compact);
    job_release(&done);
    return exit_code;
}

static int check_probes(program *state)
{
    const options *given = &state->options;
    if (given->through == 0) {
        return (given->given_groups & (unsigned)OPTION_PROBES) == 0
                   ? PROGRAM_DONE
                   : program_fail(state, PROGRAM_WRONG_USAGE, "options of probes require --through probes");
    }
    return probe_picture_has_view(given->view)
               ? PROGRAM_DONE
               : program_fail(state, PROGRAM_WRONG_USAGE,
                              "--through probes has the views shaded, normal, depth and steps alone");
}

/* Options that the view does not take. */
static int check_view(program *state)
{
    const options *given = &state->options;
    const bool by_cones = render_light_is_asked(given);
    const bool lit_probes = given->through != 0 && given->view == SVO_VIEW_SHADED;
    static const char *const of_cones[] = {"gi", NULL};
    static const char *const of_light[] = {"gi", "exposure", NULL};
    if (!by_cones &&
        options_refuse(state, lit_probes ? of_cones : of_light, "to a view without cones") != PROGRAM_DONE) {
        return PROGRAM_WRONG_USAGE;
    }
    return by_cones || lit_probes || (given->given_groups & (unsigned)OPTION_LIGHT) == 0
               ? PROGRAM_DONE
               : program_fail(state, PROGRAM_WRONG_USAGE,
                              "options of lights and cones require --view ao, direct, gi, specular or full");
}

/* What is made of built trees alone. */
static int check_form(program *state)
{
    const options *given = &state->options;
    const char *where = given->animate != 0                 ? "with --animate, which moves a built tree"
                        : given->paged > 0                  ? "with --paged, which reads a .svo file"
                        : given->through != 0               ? "with --through probes, which are made of a built tree"
                        : render_light_is_asked(given)      ? "to views of light, which is stored in a built tree"
                        : given->view == SVO_VIEW_TRIANGLES ? "to --view triangles, which no compact tree has"
                                                            : NULL;
    if (where != NULL && options_refuse_groups(state, OPTION_TREE_FORM, where) != PROGRAM_DONE) {
        return PROGRAM_WRONG_USAGE;
    }
    return given->view != SVO_VIEW_TRIANGLES || !input_is_compact(state)
               ? PROGRAM_DONE
               : program_fail(state, PROGRAM_WRONG_USAGE, "%s is a compact tree, which has no triangles to view",
                              given->input);
}

int command_render(program *state)
{
    if (state->options.output_path == NULL) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "-o FILE is missing");
    }
    if (check_probes(state) != PROGRAM_DONE || check_view(state) != PROGRAM_DONE || check_form(state) != PROGRAM_DONE) {
        return PROGRAM_WRONG_USAGE;
    }
    int exit_code = render_animation_check(state);
    if (exit_code == PROGRAM_DONE) {
        exit_code = picture_check(state);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = picture_check_files(state, state->options.animate != 0 ? animation_frame_count(state)
                                                                           : picture_frames(&state->options));
    }
    if (exit_code == PROGRAM_DONE && state->options.animate != 0) {
        return render_animation(state);
    }
    if (exit_code == PROGRAM_DONE && state->options.paged > 0) {
        return render_paged(state);
    }
    if (exit_code == PROGRAM_DONE && state->options.through != 0) {
        return render_probes(state);
    }
    if (exit_code == PROGRAM_DONE && render_light_is_asked(&state->options)) {
        return render_light(state);
    }
    if (exit_code == PROGRAM_DONE && scene_file_is_input(state)) {
        return render_scene(state);
    }
    return exit_code == PROGRAM_DONE ? render_tree(state) : exit_code;
}
