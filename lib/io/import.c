/* SPDX-License-Identifier: MIT */
/*
 * Mesh files, in the calling process: checks the arguments and the file, has a child process read it
 * (import_process.c) and parses the child's answer (import_stream.c). import_child.c runs in the child.
 */
#define _POSIX_C_SOURCE 200809L
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/message.h"
#include "core/struct_size.h"
#include "io/import_process.h"
#include "io/import_stream.h"

#define HELPER_PATH_BYTES    4096
#define DEFAULT_MEMORY_BYTES ((uint64_t)8 << 30)
#define DEFAULT_TIME_SECONDS 5
#define BYTES_PER_SECOND     1000000 /* more time for each */

/* Errors for which the system has a better message than a reader: missing, a directory, no permission. */
static svo_status check_file(const char *path, uint64_t *byte_count, svo_message *message)
{
    const int file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (file < 0) {
        return svo_i_fail(message, SVO_FILE_ERROR, "%s: cannot be read: %s", path, strerror(errno));
    }
    struct stat entry;
    svo_status status = SVO_OK;
    if (fstat(file, &entry) != 0) {
        status = svo_i_fail(message, SVO_FILE_ERROR, "%s: cannot be read: %s", path, strerror(errno));
    } else if (!S_ISREG(entry.st_mode)) {
        status = svo_i_fail(message, SVO_FILE_ERROR, "%s: cannot be read: %s", path,
                            S_ISDIR(entry.st_mode) ? strerror(EISDIR) : "not a regular file");
    } else {
        *byte_count = (uint64_t)entry.st_size;
    }
    close(file);
    return status;
}

/* Options without zeros. helper: room for the path of the helper program. */
static svo_status fill_options(svo_import_options *options, uint64_t byte_count, char *helper, size_t helper_bytes,
                               svo_message *message)
{
    if (options->memory_limit_bytes == 0) {
        options->memory_limit_bytes = DEFAULT_MEMORY_BYTES;
    }
    if (options->time_limit_seconds == 0) {
        const uint64_t seconds = DEFAULT_TIME_SECONDS + byte_count / BYTES_PER_SECOND;
        options->time_limit_seconds = seconds < UINT32_MAX ? (uint32_t)seconds : UINT32_MAX;
    }
    if (options->child_program == NULL) {
        const svo_status status = svo_import_helper(helper, helper_bytes, message);
        if (status != SVO_OK) {
            return status == SVO_FILE_ERROR ? SVO_IMPORT_FAILED : status;
        }
        options->child_program = helper;
    }
    return SVO_OK;
}

static svo_status check_arguments(const char *path, svo_import *const *out, svo_message *message)
{
    if (path == NULL || out == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "svo_import_file: %s is NULL", path == NULL ? "path" : "out");
    }
    if (getenv(IMPORT_CHILD_ENVIRONMENT) != NULL) {
        return svo_i_fail(
            message, SVO_IMPORT_FAILED,
            "svo_import_file: called in an import child; svo_import_child_main must come first in main()");
    }
    return SVO_OK;
}

svo_status svo_import_file(const char *path, const svo_import_options *options, svo_log_callback log, void *log_user,
                           svo_import **out, svo_message *message)
{
    svo_status status = SVO_OK;
    svo_import_options filled;
    char helper[HELPER_PATH_BYTES];
    uint64_t byte_count = 0;
    SVO_I_TRY(check_arguments(path, out, message));
    SVO_I_TRY(svo_i_struct_read(message, "svo_import_file", "options", options, &filled,
                                SVO_I_STRUCT_SIZES(svo_import_options, time_limit_seconds)));
    SVO_I_TRY(check_file(path, &byte_count, message));
    SVO_I_TRY(fill_options(&filled, byte_count, helper, sizeof helper, message));
    svo_i_memory memory;
    SVO_I_TRY(svo_i_memory_read(message, "svo_import_file", "options.memory", filled.memory, &memory));
    svo_import *import = svo_i_alloc_zeroed(&memory, 1, sizeof *import);
    if (import == NULL) {
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for the mesh", path);
    }
    import->memory = memory;
    SVO_I_TRY_CLEANUP(svo_i_import_run_child(path, &filled, import, message));
    SVO_I_TRY_CLEANUP(svo_i_stream_parse(import, path, filled.strict != 0, log, log_user, message));
    *out = import;
    import = NULL;
cleanup:
    svo_import_destroy(&import);
    return status;
}

svo_status svo_import_get_info(const svo_import *import, svo_import_info *info)
{
    return svo_i_struct_write(NULL, "svo_import_get_info", "info", &import->info, info,
                              SVO_I_STRUCT_SIZES(svo_import_info, warnings));
}

const svo_mesh *svo_import_mesh(const svo_import *import)
{
    return &import->mesh;
}

const char *svo_import_file_path(const svo_import *import, size_t index)
{
    return index < import->file_count ? import->files[index] : NULL;
}

void svo_import_destroy(svo_import **import)
{
    if (import == NULL || *import == NULL) {
        return;
    }
    svo_i_free((void *)(*import)->files);
    svo_i_free((*import)->textures);
    svo_i_free((*import)->bytes);
    svo_i_free(*import);
    *import = NULL;
}
