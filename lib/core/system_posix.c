/* SPDX-License-Identifier: MIT */
/* The operating system as POSIX.1-2008 describes it (https://pubs.opengroup.org/onlinepubs/9699919799/). */
#define _POSIX_C_SOURCE 200809L
#include "core/system.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

double svo_i_now_ms(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec * 1e3 + (double)now.tv_nsec * 1e-6;
}

void svo_i_system_sleep_ms(unsigned milliseconds)
{
    const struct timespec moment = {.tv_sec = (time_t)(milliseconds / 1000),
                                    .tv_nsec = (long)(milliseconds % 1000) * 1000000};
    nanosleep(&moment, NULL);
}

uint32_t svo_i_system_processors(void)
{
    const long online = sysconf(_SC_NPROCESSORS_ONLN);
    return online > 0 ? (uint32_t)online : 1;
}

uint64_t svo_i_system_memory_bytes(void)
{
    const long pages = sysconf(_SC_PHYS_PAGES);
    const long page_bytes = sysconf(_SC_PAGESIZE);
    return pages > 0 && page_bytes > 0 ? (uint64_t)pages * (uint64_t)page_bytes : UINT64_MAX;
}

int svo_i_system_open(const char *path)
{
    return open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
}

int svo_i_system_make(const char *path)
{
    return open(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
}

bool svo_i_system_read(int descriptor, void *bytes, size_t size)
{
    size_t done = 0;
    while (done < size) {
        const ssize_t got = read(descriptor, (char *)bytes + done, size - done);
        if (got <= 0 && !(got < 0 && errno == EINTR)) {
            return false;
        }
        done += got > 0 ? (size_t)got : 0;
    }
    return true;
}

bool svo_i_system_write(int descriptor, const void *bytes, size_t size)
{
    size_t done = 0;
    while (done < size) {
        const ssize_t put = write(descriptor, (const char *)bytes + done, size - done);
        if (put < 0 && errno != EINTR) {
            return false;
        }
        done += put > 0 ? (size_t)put : 0;
    }
    return true;
}

bool svo_i_system_replace(const char *from, const char *to)
{
    return rename(from, to) == 0;
}

bool svo_i_system_make_folder(const char *path)
{
    return mkdir(path, 0755) == 0 || errno == EEXIST;
}
