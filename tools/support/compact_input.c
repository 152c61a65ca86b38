/* SPDX-License-Identifier: MIT */
/*
 * Compact trees as INPUT. They are expanded on a device that is open meanwhile, and leave it as the bytes of a .svo
 * file: the command may open another device, or none.
 */
#include "support/compact_input.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "support/session.h"
#include "svocl/io.h"

typedef struct byte_list {
    unsigned char *bytes;
    size_t count, capacity;
} byte_list;

static int append(void *user, const void *bytes, size_t byte_count)
{
    byte_list *list = user;
    if (byte_count > list->capacity - list->count) {
        const size_t capacity = 2 * list->capacity + byte_count;
        unsigned char *larger = realloc(list->bytes, capacity);
        if (larger == NULL) {
            return 1;
        }
        list->bytes = larger;
        list->capacity = capacity;
    }
    memcpy(list->bytes + list->count, bytes, byte_count);
    list->count += byte_count;
    return 0;
}

bool compact_input_is_name(const char *name)
{
    const size_t length = strlen(name);
    return strncmp(name, "scene:", 6) != 0 && length >= 4 && strcasecmp(name + length - 4, ".svc") == 0;
}

/* Writes the expanded tree to a list. */
static int expand(program *state, const session *opened, svo_compact *compact, byte_list *list)
{
    svo_tree *tree = NULL;
    svo_message message = {""};
    int exit_code = PROGRAM_DONE;
    if (svo_compact_upload(compact, opened->device, opened->queue) != SVO_OK ||
        svo_compact_expand(compact, opened->queue, &tree) != SVO_OK ||
        svo_tree_download(tree, opened->queue) != SVO_OK) {
        exit_code = program_fail_library(state, svo_device_message(opened->device));
    } else if (svo_tree_write(tree, append, list, NULL, &message) != SVO_OK) {
        exit_code = program_fail_library(state, message.text);
    }
    svo_tree_destroy(&tree);
    return exit_code;
}

int compact_input_load(program *state, const char *name, const void *bytes, size_t byte_count, svo_compact **out)
{
    svo_message message = {""};
    const svo_load_options load_options = {.struct_size = sizeof load_options,
                                           .voxels_max = state->options.max_voxels};
    const svo_status loaded = bytes != NULL
                                  ? svo_compact_load_memory(bytes, byte_count, name, &load_options, out, &message)
                                  : svo_compact_load(name, &load_options, out, &message);
    return loaded == SVO_OK ? PROGRAM_DONE : program_fail_library(state, message.text);
}

/* The nodes of the expanded tree: those of a level, and those inside the leaves above it. */
static double count_nodes(const svo_compact *compact)
{
    svo_compact_info info = SVO_COMPACT_INFO_INIT;
    double nodes = 0.0, inside = 0.0;
    (void)svo_compact_get_info(compact, &info);
    for (uint32_t level = 0; level <= info.depth; ++level) {
        nodes += (double)info.level_inner[level] + (double)info.level_leaf[level] + inside;
        inside = 8.0 * (inside + (double)info.level_leaf[level]);
    }
    return nodes;
}

int compact_input_expand(program *state, const char *name, svo_compact **compact, svo_tree **out)
{
    session opened = {0};
    byte_list list = {NULL, 0, 0};
    svo_message message = {""};
    const double limit = (double)state->options.max_voxels;
    int exit_code = limit > 0.0 && count_nodes(*compact) > limit
                        ? program_fail(state, PROGRAM_FAILED, "%s: %.0f voxels are above the limit of %.0f (--max-voxels)",
                                       name, count_nodes(*compact), limit)
                        : session_open_device(state, &opened);
    if (exit_code == PROGRAM_DONE) {
        exit_code = expand(state, &opened, *compact, &list);
    }
    svo_compact_destroy(compact);
    session_close(&opened);
    if (exit_code == PROGRAM_DONE && svo_tree_load_memory(list.bytes, list.count, name, out, &message) != SVO_OK) {
        exit_code = program_fail_library(state, message.text);
    }
    free(list.bytes);
    return exit_code;
}
