/* SPDX-License-Identifier: MIT */
/* svocl kernels: compiles what builds of INPUT need and saves it, for later runs. */
#include <errno.h>
#include <string.h>

#include "support/info_of.h"
#include "support/job.h"
#include "support/json.h"
#include "support/kernel_folder.h"
#include "support/options_parse.h"
#include "support/session.h"
#include "support/table.h"
#include "svocl/commands.h"

static int print(program *state, const input *source, const session *opened, const svo_plan *plan, const char *folder,
                 size_t saved)
{
    const svo_plan_info info = info_of_plan(plan);
    progress_destroy(&state->progress);
    cJSON *document = state->options.json ? json_document() : NULL;
    cJSON *array = document != NULL ? cJSON_AddArrayToObject(document, "kernels") : NULL;
    table *rows = document == NULL && !state->options.quiet ? table_create("ll") : NULL;
    for (size_t i = 0; i < info.kernels_count; ++i) {
        svo_kernels_info kernels = SVO_KERNELS_INFO_INIT;
        svo_plan_get_kernels(plan, i, &kernels);
        const char *defines = kernels.defines[0] == ' ' ? kernels.defines + 1 : kernels.defines;
        table_cell(rows, "%s", kernels.name);
        table_cell(rows, "%s", defines);
        if (array != NULL) {
            cJSON *entry = cJSON_CreateObject();
            json_add_text(entry, "name", kernels.name);
            json_add_text(entry, "defines", defines);
            cJSON_AddItemToArray(array, entry);
        }
    }
    if (document != NULL) {
        json_add_text(document, "input", source->name);
        json_add_text(document, "device", info_of_device(opened->device).name);
        json_add_text(document, "folder", folder);
        json_add_count(document, "saved", saved);
        return json_print(state, document);
    }
    if (rows == NULL) {
        return PROGRAM_DONE;
    }
    table_heading("kernels for builds of %s in %s: %zu programs saved", source->name, folder, saved);
    table_print(rows);
    return PROGRAM_DONE;
}

/* Compiles and saves. The session has loaded what the folder had. */
static int make_kernels(program *state, const input *source, const session *opened, const char *folder)
{
    svo_plan *plan = NULL;
    size_t saved = 0;
    progress_step(state->progress, "planning");
    int exit_code = job_plan(state, opened->device, source, state->options.need, &plan);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    progress_step(state->progress, "compiling");
    svo_status status = svo_device_warm(opened->device, plan);
    progress_step(state->progress, "saving");
    if (status == SVO_OK) {
        status = svo_device_save_kernels(opened->device, folder, &saved);
    }
    exit_code = status == SVO_OK ? print(state, source, opened, plan, folder, saved)
                                 : program_fail_library(state, svo_device_message(opened->device));
    svo_plan_destroy(&plan);
    return exit_code;
}

/* --kernels, or else the user's folder, which is made. */
static int choose_folder(program *state, char own[KERNEL_FOLDER_BYTES], const char **folder)
{
    *folder = state->options.kernels_path;
    if (*folder != NULL) {
        return PROGRAM_DONE;
    }
    if (!kernel_folder_name(own)) {
        return program_fail(state, PROGRAM_WRONG_USAGE,
                            "--kernels DIR is missing, and neither XDG_CACHE_HOME nor HOME names a folder");
    }
    if (!kernel_folder_make(own)) {
        return program_fail(state, PROGRAM_FAILED, "%s cannot be made: %s", own, strerror(errno));
    }
    if (!kernel_folder_is_own(own)) {
        return program_fail(state, PROGRAM_FAILED, "%s is no folder that you alone may write to", own);
    }
    *folder = own;
    return PROGRAM_DONE;
}

int command_kernels(program *state)
{
    input source = {0};
    session opened = {0};
    char own[KERNEL_FOLDER_BYTES];
    const char *folder = NULL;
    if (options_ask_for_gl(&state->options)) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "kernels are OpenCL's: what asks for OpenGL does not apply");
    }
    int exit_code = choose_folder(state, own, &folder);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    program_begin_progress(state, 4);
    exit_code = input_open_any(state, state->options.need, &source);
    if (exit_code == PROGRAM_DONE) {
        exit_code = session_open_device(state, &opened);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = make_kernels(state, &source, &opened, folder);
    }
    session_close(&opened);
    input_close(&source);
    return exit_code;
}
