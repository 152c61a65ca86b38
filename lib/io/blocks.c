/* SPDX-License-Identifier: MIT */
/* Opens mesh files for reading in blocks; the window over the file, and the block. */
#define _POSIX_C_SOURCE 200809L
#include "io/blocks.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/memory.h"
#include "core/message.h"
#include "io/blocks_file.h"
#include "io/import_formats.h"
#include "io/import_stl.h"
#include "io/read_at.h"

svo_status svo_i_blocks_no_memory(const svo_i_blocks *blocks)
{
    return svo_i_blocks_fail(blocks, SVO_OUT_OF_HOST_MEMORY, "no memory for a block of triangles");
}

svo_status svo_i_blocks_fail(const svo_i_blocks *blocks, svo_status status, const char *words)
{
    return svo_i_fail(blocks->message, status, "%s: %s", blocks->path, words);
}

/* ---- the window ---- */

svo_status svo_i_blocks_read_at(const svo_i_blocks *blocks, uint64_t offset, void *out, size_t byte_count)
{
    size_t got = 0;
    const int error = svo_i_read_at(blocks->file, offset, out, byte_count, &got);
    return got == byte_count ? SVO_OK
                             : svo_i_fail(blocks->message, SVO_FILE_ERROR, "%s: cannot be read: %s", blocks->path,
                                          error != 0 ? strerror(error) : "it has become shorter");
}

svo_status svo_i_blocks_need(svo_i_blocks *blocks, size_t byte_count)
{
    const size_t ahead = blocks->window_count - blocks->window_at;
    const uint64_t behind = blocks->file_bytes - blocks->window_begin - blocks->window_count;
    if (ahead >= byte_count || behind == 0) {
        return SVO_OK;
    }
    memmove(blocks->window, blocks->window + blocks->window_at, ahead);
    const size_t room = WINDOW_BYTES - ahead;
    const size_t more = behind < room ? (size_t)behind : room;
    blocks->window_begin += blocks->window_at;
    blocks->window_at = 0;
    blocks->window_count = ahead;
    SVO_I_TRY(svo_i_blocks_read_at(blocks, blocks->window_begin + ahead, blocks->window + ahead, more));
    blocks->window_count = ahead + more;
    return SVO_OK;
}

void svo_i_blocks_seek(svo_i_blocks *blocks, uint64_t offset)
{
    blocks->window_begin = offset;
    blocks->window_count = 0;
    blocks->window_at = 0;
}

/* ---- the block ---- */

void svo_i_blocks_put(svo_i_blocks *blocks, unsigned corner, const gather_vertex *vertex)
{
    const size_t at = blocks->filled * 3 + corner;
    memcpy(blocks->positions + at * 3, vertex->position, sizeof vertex->position);
    memcpy(blocks->normals + at * 3, vertex->normal, sizeof vertex->normal);
    memcpy(blocks->colors + at * 4, vertex->color, sizeof vertex->color);
}

svo_status svo_i_blocks_next(svo_i_blocks *blocks, svo_mesh *block)
{
    blocks->filled = 0;
    SVO_I_TRY(blocks->ply != NULL ? svo_i_blocks_fill_ply(blocks) : svo_i_blocks_fill_stl(blocks));
    *block = (svo_mesh){.struct_size = sizeof *block,
                        .positions = blocks->positions,
                        .normals = blocks->has_normals ? blocks->normals : NULL,
                        .colors = blocks->has_colors ? blocks->colors : NULL,
                        .vertex_count = 3 * blocks->filled,
                        .triangle_count = blocks->filled};
    return SVO_OK;
}

void svo_i_blocks_rewind(svo_i_blocks *blocks)
{
    if (blocks->ply != NULL) {
        svo_i_blocks_rewind_ply(blocks);
        return;
    }
    blocks->has_colors = blocks->is_magics || blocks->any_color;
    blocks->facets_read = 0;
    svo_i_blocks_seek(blocks, STL_BEGIN_BYTES);
}

/* ---- opening ---- */

static svo_status open_file(svo_i_blocks *blocks)
{
    struct stat found;
    blocks->file = open(blocks->path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (blocks->file < 0 || fstat(blocks->file, &found) != 0) {
        return svo_i_fail(blocks->message, SVO_FILE_ERROR, "%s: cannot be read: %s", blocks->path, strerror(errno));
    }
    if (!S_ISREG(found.st_mode)) {
        return svo_i_blocks_fail(blocks, SVO_FILE_ERROR, "cannot be read: not a regular file");
    }
    blocks->file_bytes = (uint64_t)found.st_size;
    return SVO_OK;
}

static bool alloc_block(svo_i_blocks *blocks)
{
    const size_t corners = (size_t)BLOCK_TRIANGLES * 3;
    blocks->window = svo_i_alloc(NULL, WINDOW_BYTES);
    blocks->positions = svo_i_alloc(NULL, corners * 3 * sizeof *blocks->positions);
    blocks->normals = svo_i_alloc(NULL, corners * 3 * sizeof *blocks->normals);
    blocks->colors = svo_i_alloc(NULL, corners * 4);
    return blocks->window != NULL && blocks->positions != NULL && blocks->normals != NULL && blocks->colors != NULL;
}

static svo_status open_format(svo_i_blocks *blocks)
{
    SVO_I_TRY(open_file(blocks));
    if (!alloc_block(blocks)) {
        return svo_i_blocks_no_memory(blocks);
    }
    SVO_I_TRY(svo_i_blocks_need(blocks, WINDOW_BYTES));
    switch (svo_i_mesh_format(blocks->path, blocks->window, blocks->window_count)) {
    case MESH_FORMAT_PLY:
        return svo_i_blocks_open_ply(blocks);
    case MESH_FORMAT_STL:
        return svo_i_blocks_open_stl(blocks);
    default:
        return svo_i_blocks_fail(blocks, SVO_UNSUPPORTED, "neither binary PLY nor binary STL");
    }
}

svo_status svo_i_blocks_open(const char *path, svo_i_blocks **out, svo_message *message)
{
    svo_i_blocks *blocks = svo_i_alloc_zeroed(NULL, 1, sizeof *blocks);
    char *copy = svo_i_copy_text(NULL, path);
    if (blocks == NULL || copy == NULL) {
        svo_i_free(blocks);
        svo_i_free(copy);
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory to read it", path);
    }
    blocks->path = copy;
    blocks->message = message;
    blocks->file = -1;
    const svo_status status = open_format(blocks);
    if (status != SVO_OK) {
        svo_i_blocks_close(&blocks);
        return status;
    }
    svo_i_blocks_rewind(blocks);
    *out = blocks;
    return SVO_OK;
}

void svo_i_blocks_close(svo_i_blocks **blocks)
{
    svo_i_blocks *b = *blocks;
    if (b == NULL) {
        return;
    }
    if (b->file >= 0) {
        (void)close(b->file);
    }
    svo_i_blocks_close_ply(b);
    svo_i_free(b->window);
    svo_i_free(b->positions);
    svo_i_free(b->normals);
    svo_i_free(b->colors);
    svo_i_free((void *)b->path);
    svo_i_free(b);
    *blocks = NULL;
}
