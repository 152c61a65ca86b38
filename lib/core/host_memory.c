/* SPDX-License-Identifier: MIT */
/* Limits of memory. One that cannot be read is none. */
#define _POSIX_C_SOURCE 200809L
#include "core/host_memory.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <unistd.h>

/* The number that a file of a control group holds; UINT64_MAX: no file, or "max". */
static uint64_t read_limit(const char *path)
{
    char text[32] = "";
    const int file = open(path, O_RDONLY | O_CLOEXEC);
    if (file < 0) {
        return UINT64_MAX;
    }
    const ssize_t got = read(file, text, sizeof text - 1);
    (void)close(file);
    return got > 0 && text[0] >= '0' && text[0] <= '9' ? strtoull(text, NULL, 10) : UINT64_MAX;
}

static uint64_t smaller(uint64_t a, uint64_t b)
{
    return a < b ? a : b;
}

uint64_t svo_i_host_memory_bytes(void)
{
    struct rlimit space;
    const long pages = sysconf(_SC_PHYS_PAGES);
    const long page_bytes = sysconf(_SC_PAGESIZE);
    uint64_t bytes = pages > 0 && page_bytes > 0 ? (uint64_t)pages * (uint64_t)page_bytes : UINT64_MAX;
    if (getrlimit(RLIMIT_AS, &space) == 0 && space.rlim_cur != RLIM_INFINITY) {
        bytes = smaller(bytes, space.rlim_cur);
    }
    bytes = smaller(bytes, read_limit("/sys/fs/cgroup/memory.max"));
    return smaller(bytes, read_limit("/sys/fs/cgroup/memory/memory.limit_in_bytes"));
}

svo_i_bytes_text svo_i_bytes(uint64_t bytes)
{
    static const char *const units[] = {"KiB", "MiB", "GiB", "TiB", "PiB", "EiB"};
    svo_i_bytes_text made;
    double value = (double)bytes / 1024.0;
    size_t unit = 0;
    while (value >= 1024.0 && unit + 1 < sizeof units / sizeof units[0]) {
        value /= 1024.0;
        ++unit;
    }
    if (bytes < 1024) {
        (void)snprintf(made.text, sizeof made.text, "%u bytes", (unsigned)bytes);
    } else {
        (void)snprintf(made.text, sizeof made.text, "%.1f %s", value, units[unit]);
    }
    return made;
}
