/* SPDX-License-Identifier: MIT */
/* svocl build: a mesh becomes a tree, a file and a table of what it took. */
#include "commands.h"
#include "output.h"
#include "report.h"

static int save(program *state, const svo_tree *tree)
{
    if (state->options.output_path == NULL) {
        return PROGRAM_DONE;
    }
    svo_message message = {""};
    const svo_save_options save_options = {.struct_size = sizeof save_options,
                                           .compress = (uint32_t)state->options.compress};
    progress_step(state->progress, "writing the tree");
    if (svo_tree_save(tree, state->options.output_path, &save_options, &message) != SVO_OK) {
        return program_fail_library(state, message.text);
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
    const int exit_code = save(state, done->result.tree);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    progress_destroy(&state->progress);
    if (state->options.json) {
        return json_print(state, report_to_json(state, done, hash));
    }
    report_print(state, done, hash);
    return PROGRAM_DONE;
}

int command_build(program *state)
{
    int exit_code = PROGRAM_DONE;
    if (state->options.output_path != NULL) {
        exit_code = output_check(state, state->options.output_path);
    }
    if (state->options.compress && state->options.output_path == NULL) {
        exit_code = program_fail(state, PROGRAM_WRONG_USAGE, "--compress needs -o FILE");
    }
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    job done;
    exit_code = job_run(state, state->options.need, 2, &done);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = finish(state, &done);
    job_release(&done);
    return exit_code;
}
