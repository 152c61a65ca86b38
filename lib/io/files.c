/* SPDX-License-Identifier: MIT */
/* Sources and sinks of a caller's, opened, read or written, and closed. output/output.c makes the file at a path. */
#define _POSIX_C_SOURCE 200809L
#include "io/files.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* ---- reading ---- */

/* The one loop around pread of trees, parts, voxels and meshes in blocks, which may be interrupted or give less. */
int svo_i_read_at(int file, uint64_t offset, void *out, size_t byte_count, size_t *got)
{
    char *to = out;
    ssize_t count = 1;
    *got = 0;
    while (*got < byte_count && count != 0) {
        count = pread(file, to + *got, byte_count - *got, (off_t)(offset + *got));
        if (count < 0 && errno != EINTR) {
            return errno;
        }
        *got += count > 0 ? (size_t)count : 0;
    }
    return 0;
}

static svo_status fail_to_read(const svo_i_source *source, const char *why)
{
    return svo_i_fail(source->message, SVO_FILE_ERROR, "%s: cannot be read: %s", source->name, why);
}

static svo_status open_path(svo_i_source *source)
{
    struct stat entry;
    /* Non-blocking: opening a named pipe must fail below, not wait for a writer. */
    source->file = open(source->name, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (source->file < 0) {
        return fail_to_read(source, strerror(errno));
    }
    svo_status status = SVO_OK;
    if (fstat(source->file, &entry) != 0) {
        status = fail_to_read(source, strerror(errno));
    } else if (!S_ISREG(entry.st_mode)) {
        status = fail_to_read(source, S_ISDIR(entry.st_mode) ? strerror(EISDIR) : "not a regular file");
    } else {
        source->byte_count = (uint64_t)entry.st_size;
        return SVO_OK;
    }
    svo_i_source_close(source);
    return status;
}

svo_status svo_i_source_open(const char *function, svo_source given, svo_message *message, svo_i_source *source)
{
    *source = (svo_i_source){.message = message, .file = -1};
    if (given.path != NULL) {
        source->name = given.path;
        return open_path(source);
    }
    if (given.bytes == NULL || given.name == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: %s NULL", function,
                          given.bytes == NULL ? "source.path and source.bytes are" : "source.name is");
    }
    source->name = given.name;
    source->bytes = given.bytes;
    source->byte_count = given.byte_count;
    return SVO_OK;
}

void svo_i_source_close(svo_i_source *source)
{
    if (source->file >= 0) {
        close(source->file);
        source->file = -1;
    }
}

svo_status svo_i_source_read(const svo_i_source *source, uint64_t offset, void *out, size_t byte_count)
{
    if (source->read != NULL) {
        return source->read(source->of, offset, out, byte_count);
    }
    if (source->bytes != NULL) {
        memcpy(out, source->bytes + offset, byte_count);
        return SVO_OK;
    }
    size_t got = 0;
    const int error = svo_i_read_at(source->file, offset, out, byte_count, &got);
    if (error != 0) {
        return fail_to_read(source, strerror(error));
    }
    return got == byte_count ? SVO_OK
                             : svo_i_fail(source->message, SVO_FILE_DAMAGED,
                                          "%s: became shorter while it was read: byte %" PRIu64 " is gone",
                                          source->name, offset + got);
}

/* ---- writing ---- */

static svo_status fail_to_write(const svo_i_sink *sink)
{
    return svo_i_fail(sink->message, SVO_FILE_ERROR, "%s: cannot be written: %s", sink->name, strerror(sink->error));
}

svo_status svo_i_sink_open(const char *function, svo_sink given, svo_message *message, svo_i_sink *sink)
{
    *sink = (svo_i_sink){.name = function, .message = message, .given = given, .output = {.descriptor = -1}};
    if (given.path == NULL) {
        return given.write != NULL
                   ? SVO_OK
                   : svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: sink.path and sink.write are NULL", function);
    }
    sink->name = given.path;
    sink->error = svo_i_output_open(given.path, NULL, &sink->output);
    return sink->error == 0 ? SVO_OK : fail_to_write(sink);
}

bool svo_i_sink_write(svo_i_sink *sink, const void *bytes, size_t byte_count)
{
    if (sink->given.path == NULL) {
        return sink->given.write(sink->given.user, bytes, byte_count) == 0;
    }
    sink->error = svo_i_output_write(&sink->output, bytes, byte_count);
    return sink->error == 0;
}

svo_status svo_i_sink_close(svo_i_sink *sink, svo_status status)
{
    if (status == SVO_OK && sink->given.path != NULL) {
        sink->error = svo_i_output_commit(&sink->output);
    }
    svo_i_output_abandon(&sink->output);
    return sink->error != 0 ? fail_to_write(sink) : status;
}
