/* SPDX-License-Identifier: MIT */
/* Folders of parts as INPUT. */
#include "support/parts_input.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#define PATH_BYTES 4096

int parts_fail(program *state, svo_status status, const char *message)
{
    switch (status) {
    case SVO_OUT_OF_DEVICE_MEMORY:
    case SVO_OUT_OF_HOST_MEMORY:
    case SVO_NO_DEVICE:
    case SVO_COMPILE_FAILED:
    case SVO_DEVICE_UNRELIABLE:
    case SVO_CL_ERROR:
    case SVO_GL_ERROR:
    case SVO_UNAVAILABLE:
        return program_fail_status(state, PROGRAM_TRY_AGAIN, message);
    case SVO_CAPACITY_EXCEEDED: /* the limit of --max-memory, or the nodes of a tree */
        return program_fail_status(state, strstr(message, "max_bytes") != NULL ? PROGRAM_WRONG_USAGE : PROGRAM_FAILED,
                                   message);
    default:
        return program_fail_library(state, message);
    }
}

bool parts_lack(const svo_parts *parts)
{
    int is_built = 1;
    for (size_t i = 0; i < svo_parts_count(parts) && is_built != 0; ++i) {
        if (svo_parts_is_built(parts, i, &is_built, NULL) != SVO_OK) {
            return false;
        }
    }
    return is_built == 0;
}

static bool is_file(const char *path)
{
    struct stat found;
    return stat(path, &found) == 0 && S_ISREG(found.st_mode);
}

/* The folder of INPUT, which may be the plan in it. */
static void find_folder(const char *name, char folder[PATH_BYTES])
{
    const char *slash = strrchr(name, '/');
    const char *last = slash != NULL ? slash + 1 : name;
    if (strcmp(last, "plan") != 0 || !is_file(name)) {
        (void)snprintf(folder, PATH_BYTES, "%s", name);
    } else if (slash == NULL) {
        (void)snprintf(folder, PATH_BYTES, ".");
    } else {
        (void)snprintf(folder, PATH_BYTES, "%.*s", (int)(slash - name) + (slash == name), name);
    }
}

bool parts_input_is_name(const char *name)
{
    char plan[PATH_BYTES];
    const int length = snprintf(plan, sizeof plan, "%s/plan", name);
    const char *slash = strrchr(name, '/');
    return (length > 0 && length < PATH_BYTES && is_file(plan)) ||
           (strcmp(slash != NULL ? slash + 1 : name, "plan") == 0 && is_file(name));
}

int parts_input_fail(program *state, svo_status status, const svo_message *message)
{
    char folder[PATH_BYTES];
    svo_parts *parts = NULL;
    bool lack = false;
    find_folder(state->options.input, folder);
    if ((status == SVO_FILE_ERROR || status == SVO_FILE_DAMAGED) && svo_parts_open(folder, &parts, NULL) == SVO_OK) {
        lack = parts_lack(parts);
        svo_parts_close(&parts);
    }
    return lack ? program_fail_status(state, PROGRAM_TRY_AGAIN, message->text)
                : parts_fail(state, status, message->text);
}

int parts_input_open(program *state, svo_parts_tree **out)
{
    svo_message message = {""};
    const svo_status status = svo_parts_tree_open(state->options.input, out, &message);
    return status == SVO_OK ? PROGRAM_DONE : parts_input_fail(state, status, &message);
}

int parts_input_region(program *state, svo_parts_region *region)
{
    const options *given = &state->options;
    const char *text = given->region;
    char *end = NULL;
    *region = (svo_parts_region){
        .struct_size = sizeof *region, .last_level = (uint32_t)given->last_level, .voxels_max = given->max_voxels};
    if (text == NULL) {
        return PROGRAM_DONE;
    }
    errno = 0;
    const unsigned long level = strtoul(text, &end, 10);
    bool valid = text[0] >= '0' && text[0] <= '9' && *end == '-' && level < SVO_PARTS_DEPTH_MAX;
    if (valid) {
        const char *code = end + 1;
        region->level = (uint32_t)level;
        region->code = strtoull(code, &end, 16);
        valid = strspn(code, "0123456789abcdef") == strlen(code) && end != code && errno == 0 &&
                region->code >> 3 * level == 0;
    }
    return valid ? PROGRAM_DONE
                 : program_fail(state, PROGRAM_WRONG_USAGE,
                                "--region '%s' is not LEVEL-CODE, a node as parts are named: its level and its Morton "
                                "code in hexadecimal digits",
                                text);
}

int parts_input_measure(program *state, uint64_t *byte_count)
{
    svo_parts_tree *tree = NULL;
    svo_parts_tree_info info = SVO_PARTS_TREE_INFO_INIT;
    svo_message message = {""};
    const int exit_code = parts_input_open(state, &tree);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    const svo_status status = svo_parts_tree_get_info(tree, &info, &message);
    svo_parts_tree_close(&tree);
    *byte_count = info.file_bytes;
    return status == SVO_OK ? PROGRAM_DONE : program_fail_library(state, message.text);
}

int parts_input_load(program *state, svo_tree **out)
{
    svo_parts_region region;
    svo_parts_tree *tree = NULL;
    svo_message message = {""};
    int exit_code = parts_input_region(state, &region);
    if (exit_code == PROGRAM_DONE) {
        exit_code = parts_input_open(state, &tree);
    }
    if (exit_code == PROGRAM_DONE) {
        const svo_status status = svo_parts_tree_load(tree, &region, out, &message);
        exit_code = status == SVO_OK ? PROGRAM_DONE : parts_input_fail(state, status, &message);
    }
    svo_parts_tree_close(&tree);
    return exit_code;
}
