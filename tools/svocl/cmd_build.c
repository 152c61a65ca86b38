/* SPDX-License-Identifier: MIT */
/* svocl build: builds the octree of a mesh, saves it and reports what each stage took. */
#include "support/build_report.h"
#include "support/options_parse.h"
#include "support/output.h"
#include "support/picture.h"
#include "support/table.h"
#include "support/tree_form.h"
#include "svocl/build_parts.h"
#include "svocl/commands.h"

/* Prints, or adds to *document, the plan of a source on a device. */
static int show_plan(program *state, const input *source, svo_device *device, cJSON *document)
{
    const bool with_opengl = options_ask_for_gl(&state->options);
    svo_plan *plan = NULL;
    const int exit_code = job_plan(state, device, source, state->options.need, &plan);
    if (exit_code == PROGRAM_DONE && document != NULL) {
        plan_add_json(cJSON_AddObjectToObject(document, "plan"), plan, with_opengl);
    } else if (exit_code == PROGRAM_DONE) {
        plan_print(plan, source->name, with_opengl);
    }
    svo_plan_destroy(&plan);
    return exit_code;
}

/* --plan-only: reads the input and plans. */
static int plan_alone(program *state)
{
    const bool with_opengl = options_ask_for_gl(&state->options);
    input source = {0};
    session opened = {0};
    program_begin_progress(state, 2);
    int exit_code = input_open_any(state, state->options.need, &source);
    if (exit_code == PROGRAM_DONE) {
        exit_code = session_open_device(state, &opened);
    }
    if (exit_code == PROGRAM_DONE) {
        svo_plan *plan = NULL;
        progress_step(state->progress, "planning");
        exit_code = job_plan(state, opened.device, &source, state->options.need, &plan);
        progress_destroy(&state->progress);
        if (exit_code == PROGRAM_DONE && state->options.json) {
            cJSON *document = json_document();
            plan_add_json(document, plan, with_opengl);
            json_add_text(document, "input", source.name);
            exit_code = json_print(state, document);
        } else if (exit_code == PROGRAM_DONE) {
            plan_print(plan, source.name, with_opengl);
        }
        svo_plan_destroy(&plan);
    }
    session_close(&opened);
    input_close(&source);
    return exit_code;
}

/* What a build gives beside the tree. */
typedef struct build_extras {
    solid_result solid;
    svo_compact *form; /* by --tree-form; NULL: none, or it is the solid's */
    char hash[SVO_HASH_TEXT_BYTES];
} build_extras;

/* What -o writes in place of the tree; NULL: the tree. */
static svo_compact *compact_of(const build_extras *extras)
{
    return extras->form != NULL ? extras->form : extras->solid.solid;
}

static int report_json(program *state, const build_extras *extras, cJSON *document)
{
    solid_add_json(document, state, &extras->solid);
    if (state->options.tree_form != 0) {
        tree_form_add_json(document, compact_of(extras));
    }
    return json_print(state, document);
}

static void report_text(const program *state, const job *done, const build_extras *extras)
{
    report_print(state, done, extras->hash);
    solid_print(state, &extras->solid);
    if (state->options.tree_form != 0) {
        table_gap();
        table *rows = table_create("ll");
        tree_form_add_rows(rows, compact_of(extras));
        table_print(rows);
    }
}

static int report(program *state, const job *done, const build_extras *extras)
{
    cJSON *document = state->options.json ? report_to_json(state, done, extras->hash) : NULL;
    if (state->options.plan) {
        const int planned = show_plan(state, &done->source, done->opened.device, document);
        if (planned != PROGRAM_DONE) {
            cJSON_Delete(document);
            return planned;
        }
    }
    if (state->options.json) {
        return report_json(state, extras, document);
    }
    if (state->options.plan && !state->options.quiet) {
        table_gap();
    }
    if (!state->options.quiet) {
        report_text(state, done, extras);
    }
    return PROGRAM_DONE;
}

/* The solid by --solid, then the form by --tree-form, of the solid if there is one. */
static int make_extras(program *state, const job *done, build_extras *extras)
{
    const session *opened = &done->opened;
    int exit_code = solid_make(state, opened->device, done->result.tree, &extras->solid);
    if (exit_code == PROGRAM_DONE && state->options.tree_form != 0) {
        exit_code = extras->solid.solid != NULL ? tree_form_change(state, opened, &extras->solid.solid)
                                                : tree_form_make(state, opened, done->result.tree, &extras->form);
    }
    svo_compact *compact = compact_of(extras);
    return exit_code != PROGRAM_DONE || compact == NULL || svo_compact_download(compact, opened->queue) == SVO_OK
               ? exit_code
               : program_fail_library(state, svo_device_message(opened->device));
}

static int finish(program *state, const job *done)
{
    build_extras extras = {.form = NULL};
    progress_step(state->progress, "hashing");
    if (svo_tree_hash(done->result.tree, SVO_HASH_ALL, extras.hash) != SVO_OK) {
        return program_fail_library(state, svo_device_message(done->opened.device));
    }
    int exit_code = make_extras(state, done, &extras);
    if (exit_code == PROGRAM_DONE && state->options.output_path != NULL) {
        exit_code = tree_output_write(state, done->result.tree, compact_of(&extras), state->options.output_path);
    }
    progress_destroy(&state->progress);
    if (exit_code == PROGRAM_DONE) {
        exit_code = report(state, done, &extras);
    }
    svo_compact_destroy(&extras.form);
    solid_release(&extras.solid);
    return exit_code;
}

static int check_options(program *state)
{
    const options *given = &state->options;
    if (given->plan_only && (given->output_path != NULL || given->repeat > 1)) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "%s does not apply with --plan-only, which builds nothing",
                            given->output_path != NULL ? "-o FILE" : "--repeat");
    }
    if (given->plan_only && (solid_is_wanted(state) || given->count_first || given->tree_form != 0)) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--%s does not apply with --plan-only, which builds nothing",
                            given->count_first       ? "count-first"
                            : solid_is_wanted(state) ? "solid"
                                                     : "tree-form");
    }
    if (solid_is_wanted(state) && given->drop_alpha > 0.0) {
        return program_fail(state, PROGRAM_WRONG_USAGE,
                            "--drop-alpha does not apply with --solid, which counts crossings of the whole surface");
    }
    if (given->compress && given->output_path == NULL) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--compress needs -o FILE");
    }
    return given->output_path != NULL ? output_check(state, given->output_path) : PROGRAM_DONE;
}

/* Of a voxel file the depth is known when it is read. */
static int check_payload_level(program *state)
{
    const options *given = &state->options;
    const bool is_known = given->has_depth || !voxel_input_is_given(state);
    return !is_known || given->payload_level <= given->depth
               ? PROGRAM_DONE
               : program_fail(state, PROGRAM_WRONG_USAGE, "--payload-level %u is above the depth, %u",
                              (unsigned)given->payload_level, (unsigned)given->depth);
}

int command_build(program *state)
{
    if (input_is_tree(state)) {
        return program_fail(state, PROGRAM_WRONG_USAGE,
                            "%s is a finished tree, a mesh or voxels are needed here; svocl convert changes its form",
                            state->options.input);
    }
    if (check_payload_level(state) != PROGRAM_DONE) {
        return PROGRAM_WRONG_USAGE;
    }
    const bool is_cloud = points_input_is_given(state); /* whose memory is limited otherwise */
    if ((state->options.max_memory != 0 && !is_cloud) || state->options.resume) {
        return build_parts(state);
    }
    int exit_code = check_options(state);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    if (state->options.plan_only) {
        return plan_alone(state);
    }
    job done;
    uint32_t need = solid_need(state, state->options.need);
    const unsigned further_steps = solid_is_wanted(state) ? 3 : 2;
    exit_code = job_open(state, need, further_steps + (state->options.tree_form != 0 ? 1 : 0), &done);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    if (done.source.voxels.voxels != NULL) {
        voxel_input_warn(state, &done.source.voxels, NULL);
    }
    if (need != state->options.need && state->options.need == (uint32_t)SVO_NEED_DEFAULT) {
        need |= picture_need(&done.source, SVO_NEED_DEFAULT); /* what the default means beside the bits of the solid */
    }
    exit_code = job_build(state, need, &done);
    if (exit_code == PROGRAM_DONE) {
        exit_code = finish(state, &done);
    }
    job_release(&done);
    return exit_code;
}
