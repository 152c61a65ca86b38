/* SPDX-License-Identifier: MIT */
/* Files of the import child. A file that shrinks while it is mapped ends the child with a signal, as a crash does. */
#define _POSIX_C_SOURCE 200809L
#include "io/import_file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "io/import_stream.h"

const char *svo_i_file_open(const char *path, file_bytes *file)
{
    *file = (file_bytes){.bytes = "", .byte_count = 0};
    const int descriptor = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (descriptor < 0) {
        return strerror(errno);
    }
    struct stat entry;
    const char *trouble = NULL;
    if (fstat(descriptor, &entry) != 0) {
        trouble = strerror(errno);
    } else if (!S_ISREG(entry.st_mode)) {
        trouble = "not a regular file";
    } else if (entry.st_size > 0) {
        void *bytes = mmap(NULL, (size_t)entry.st_size, PROT_READ, MAP_PRIVATE, descriptor, 0);
        if (bytes == MAP_FAILED) {
            trouble = errno == ENOMEM ? "out of memory" : strerror(errno);
        } else {
            *file = (file_bytes){.bytes = bytes, .byte_count = (size_t)entry.st_size};
        }
    }
    close(descriptor);
    return trouble;
}

char *svo_i_file_beside(const char *path, const char *name)
{
    const char *slash = strrchr(path, '/');
    const int is_absolute = name[0] == '/' || name[0] == '\\';
    const size_t folder_bytes = slash == NULL || is_absolute ? 0 : (size_t)(slash - path) + 1;
    const size_t name_bytes = strlen(name) + 1;
    char *joined = malloc(folder_bytes + name_bytes);
    if (joined == NULL) {
        return NULL;
    }
    memcpy(joined, path, folder_bytes);
    memcpy(joined + folder_bytes, name, name_bytes);
    for (char *c = joined + folder_bytes; *c != '\0'; ++c) {
        if (*c == '\\') {
            *c = '/';
        }
    }
    return joined;
}

const char *svo_i_file_open_beside(int stream, const char *path, const char *name, file_bytes *file)
{
    char *joined = svo_i_file_beside(path, name);
    if (joined == NULL) {
        return "out of memory";
    }
    const char *trouble = svo_i_file_open(joined, file);
    if (trouble == NULL) {
        (void)svo_i_stream_file(stream, joined); /* without a parent the next frame fails too */
    }
    free(joined);
    return trouble;
}

void svo_i_file_close(file_bytes *file)
{
    if (file->byte_count > 0) {
        munmap((void *)(uintptr_t)file->bytes, file->byte_count);
    }
    *file = (file_bytes){.bytes = "", .byte_count = 0};
}

/* ---- files of assimp ---- */

typedef struct scene_file {
    struct aiFile file; /* its UserData is this */
    file_bytes content;
    size_t at;
} scene_file;

static scene_file *scene_file_of(struct aiFile *file)
{
    return (scene_file *)(void *)file->UserData;
}

static size_t read_items(struct aiFile *file, char *out, size_t item_bytes, size_t item_count)
{
    scene_file *one = scene_file_of(file);
    const size_t left = item_bytes > 0 ? (one->content.byte_count - one->at) / item_bytes : 0;
    const size_t count = item_count < left ? item_count : left;
    memcpy(out, one->content.bytes + one->at, count * item_bytes);
    one->at += count * item_bytes;
    return count;
}

static size_t write_nothing(struct aiFile *file, const char *bytes, size_t item_bytes, size_t item_count)
{
    (void)file;
    (void)bytes;
    (void)item_bytes;
    (void)item_count;
    return 0;
}

static size_t tell(struct aiFile *file)
{
    return scene_file_of(file)->at;
}

static size_t measure(struct aiFile *file)
{
    return scene_file_of(file)->content.byte_count;
}

static enum aiReturn seek(struct aiFile *file, size_t offset, enum aiOrigin origin)
{
    scene_file *one = scene_file_of(file);
    const size_t from = origin == aiOrigin_SET ? 0 : origin == aiOrigin_CUR ? one->at : one->content.byte_count;
    const size_t at = from + offset; /* which may stand for a step back */
    if (at > one->content.byte_count) {
        return aiReturn_FAILURE;
    }
    one->at = at;
    return aiReturn_SUCCESS;
}

static void flush_nothing(struct aiFile *file)
{
    (void)file;
}

static struct aiFile *open_scene_file(struct aiFileIO *io, const char *path, const char *mode)
{
    const scene_files *files = (const scene_files *)(const void *)io->UserData;
    scene_file *one = mode[0] == 'r' ? malloc(sizeof *one) : NULL;
    if (one == NULL || svo_i_file_open(path, &one->content) != NULL) {
        free(one);
        return NULL;
    }
    if (strcmp(path, files->path) != 0) {
        (void)svo_i_stream_file(files->stream, path); /* without a parent the next frame fails too */
    }
    one->at = 0;
    one->file = (struct aiFile){.ReadProc = read_items,
                                .WriteProc = write_nothing,
                                .TellProc = tell,
                                .FileSizeProc = measure,
                                .SeekProc = seek,
                                .FlushProc = flush_nothing,
                                .UserData = (aiUserData)(void *)one};
    return &one->file;
}

static void close_scene_file(struct aiFileIO *io, struct aiFile *file)
{
    (void)io;
    scene_file *one = scene_file_of(file);
    svo_i_file_close(&one->content);
    free(one);
}

void svo_i_scene_files(int stream, const char *path, scene_files *files)
{
    *files = (scene_files){
        .io = {.OpenProc = open_scene_file, .CloseProc = close_scene_file, .UserData = (aiUserData)(void *)files},
        .stream = stream,
        .path = path};
}
