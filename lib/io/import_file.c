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

const char *svo_i_file_open_beside(const char *path, const char *name, file_bytes *file)
{
    char *joined = svo_i_file_beside(path, name);
    if (joined == NULL) {
        return "out of memory";
    }
    const char *trouble = svo_i_file_open(joined, file);
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
