/* SPDX-License-Identifier: MIT */
/* Writes trees and compact trees as files. */
#include "support/tree_output.h"

#include "support/output.h"
#include "svocl/io.h"

static int write_bytes(void *user, const void *bytes, size_t byte_count)
{
    output_file *file = user;
    output_write(file, bytes, byte_count);
    return file->error;
}

static svo_status write_all(const svo_tree *tree, const svo_compact *compact, output_file *file,
                            const svo_save_options *save_options, svo_message *message)
{
    return compact != NULL ? svo_compact_write(compact, write_bytes, file, save_options, message)
                           : svo_tree_write(tree, write_bytes, file, save_options, message);
}

int tree_output_write(program *state, const svo_tree *tree, const svo_compact *compact, const char *path)
{
    output_file file;
    svo_message message = {""};
    const svo_save_options save_options = {.struct_size = sizeof save_options,
                                           .compress = (uint32_t)state->options.compress};
    progress_step(state->progress, "writing the tree");
    const int exit_code = output_open(state, path, &file);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    /* A write that failed is reported by output_commit. */
    if (write_all(tree, compact, &file, &save_options, &message) != SVO_OK && file.error == 0) {
        output_abandon(&file);
        return program_fail_library(state, message.text);
    }
    return output_commit(state, &file);
}
