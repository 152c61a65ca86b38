/* SPDX-License-Identifier: MIT */
/* Divides parts. A .split file has the numbers of triangles of the eight children, what the part is of, and the
   checksum of both. */
#define _POSIX_C_SOURCE 200809L
#include "parts/split.h"

#include <errno.h>
#include <fcntl.h>
#include <stddef.h>
#include <string.h>
#include <unistd.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "io/file_format.h"
#include "output/output.h"
#include "parts/triangles.h"

typedef struct split_file {
    uint64_t counts[8];
    svo_i_triangles_of of;
    uint64_t hash;
} split_file;

svo_status svo_i_part_divide(const svo_parts *parts, uint32_t level, uint64_t code, uint64_t counts[8],
                             svo_message *message)
{
    char *paths[8] = {NULL};
    char *path = svo_i_part_path(parts, level, code, "tri");
    const svo_i_triangles_of of = svo_i_folder_triangles(parts, level, code);
    bool whole = path != NULL;
    svo_status status = SVO_OK;
    for (unsigned octant = 0; octant < 8; ++octant) {
        paths[octant] = svo_i_part_path(parts, level + 1, code << 3 | octant, "tri");
        whole = whole && paths[octant] != NULL;
    }
    status = whole ? svo_i_triangles_split(&parts->header, &of, path, paths, counts, message)
                   : svo_i_folder_no_memory(parts, message);
    for (unsigned octant = 0; octant < 8; ++octant) {
        svo_i_free(paths[octant]);
    }
    svo_i_free(path);
    return status;
}

static uint64_t hash_of(const split_file *content)
{
    return XXH3_64bits(content, offsetof(split_file, hash));
}

svo_status svo_i_split_save(const svo_parts *parts, uint32_t level, uint64_t code, const uint64_t counts[8],
                            svo_message *message)
{
    split_file content = {.of = svo_i_folder_triangles(parts, level, code)};
    memcpy(content.counts, counts, sizeof content.counts);
    content.hash = hash_of(&content);
    char *path = svo_i_part_path(parts, level, code, "split");
    if (path == NULL) {
        return svo_i_folder_no_memory(parts, message);
    }
    svo_i_output output = {.descriptor = -1};
    int error = svo_i_output_open(path, NULL, &output);
    if (error == 0) {
        error = svo_i_output_write(&output, &content, sizeof content);
    }
    if (error == 0) {
        error = svo_i_output_commit_unflushed(&output);
    }
    svo_i_output_abandon(&output);
    const svo_status status =
        error == 0 ? SVO_OK : svo_i_fail(message, SVO_FILE_ERROR, "%s: cannot be written: %s", path, strerror(error));
    svo_i_free(path);
    return status;
}

/* Reads the file; its bytes may be fewer. Returns an errno. */
static int read_split(const char *path, split_file *content, size_t *byte_count)
{
    const int file = open(path, O_RDONLY | O_CLOEXEC);
    if (file < 0) {
        return errno;
    }
    const int error = svo_i_read_at(file, 0, content, sizeof *content, byte_count);
    (void)close(file);
    return error;
}

svo_status svo_i_split_find(const svo_parts *parts, uint32_t level, uint64_t code, bool *is_split, uint64_t counts[8],
                            svo_message *message)
{
    const svo_i_triangles_of of = svo_i_folder_triangles(parts, level, code);
    split_file content;
    size_t byte_count = 0;
    char *path = svo_i_part_path(parts, level, code, "split");
    if (path == NULL) {
        return svo_i_folder_no_memory(parts, message);
    }
    const int error = read_split(path, &content, &byte_count);
    *is_split = error == 0 && byte_count == sizeof content && content.hash == hash_of(&content) &&
                memcmp(&content.of, &of, sizeof of) == 0;
    if (*is_split) {
        memcpy(counts, content.counts, sizeof content.counts);
    }
    const svo_status status =
        error == 0 || error == ENOENT
            ? SVO_OK
            : svo_i_fail(message, SVO_FILE_ERROR, "%s: cannot be read: %s", path, strerror(error));
    svo_i_free(path);
    return status;
}
