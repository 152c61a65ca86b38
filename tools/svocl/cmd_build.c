/* SPDX-License-Identifier: MIT */
/* svocl build: builds the octree of a mesh, saves it and reports what each stage took. */
#include "support/build_report.h"
#include "support/options_parse.h"
#include "support/output.h"
#include "support/picture.h"
#include "support/table.h"
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

static int report(program *state, const job *done, const char *hash, const solid_result *solid)
{
    cJSON *document = state->options.json ? report_to_json(state, done, hash) : NULL;
    if (state->options.plan) {
        const int planned = show_plan(state, &done->source, done->opened.device, document);
        if (planned != PROGRAM_DONE) {
            cJSON_Delete(document);
            return planned;
        }
    }
    if (state->options.json) {
        solid_add_json(document, state, solid);
        return json_print(state, document);
    }
    if (state->options.plan && !state->options.quiet) {
        table_gap();
    }
    if (!state->options.quiet) {
        report_print(state, done, hash);
        solid_print(state, solid);
    }
    return PROGRAM_DONE;
}

static int finish(program *state, const job *done)
{
    char hash[SVO_HASH_TEXT_BYTES];
    progress_step(state->progress, "hashing");
    if (svo_tree_hash(done->result.tree, SVO_HASH_ALL, hash) != SVO_OK) {
        return program_fail_library(state, svo_device_message(done->opened.device));
    }
    solid_result solid;
    int exit_code = solid_make(state, done->opened.device, done->result.tree, &solid);
    if (exit_code == PROGRAM_DONE && solid.solid != NULL && svo_compact_download(solid.solid, NULL) != SVO_OK) {
        exit_code = program_fail_library(state, svo_device_message(done->opened.device));
    }
    if (exit_code == PROGRAM_DONE && state->options.output_path != NULL) {
        exit_code = tree_output_write(state, done->result.tree, solid.solid, state->options.output_path);
    }
    progress_destroy(&state->progress);
    if (exit_code == PROGRAM_DONE) {
        exit_code = report(state, done, hash, &solid);
    }
    solid_release(&solid);
    return exit_code;
}

static int check_options(program *state)
{
    const options *given = &state->options;
    if (given->plan_only && (given->output_path != NULL || given->repeat > 1)) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "%s does not apply with --plan-only, which builds nothing",
                            given->output_path != NULL ? "-o FILE" : "--repeat");
    }
    if (given->plan_only && (solid_is_wanted(state) || given->count_first)) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--%s does not apply with --plan-only, which builds nothing",
                            given->count_first ? "count-first" : "solid");
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
    if (check_payload_level(state) != PROGRAM_DONE) {
        return PROGRAM_WRONG_USAGE;
    }
    if (state->options.max_memory != 0 || state->options.resume) {
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
    exit_code = job_open(state, need, solid_is_wanted(state) ? 3 : 2, &done);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
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
