/* SPDX-License-Identifier: MIT */
/*
 * Reads the limits of this process's memory: setrlimit's of address space, and those of control groups, version 2 or 1
 * (https://docs.kernel.org/admin-guide/cgroup-v2.html and cgroup-v1/memory.html). A limit that cannot be read is none.
 */
#define _POSIX_C_SOURCE 200809L
#include "core/limits.h"

#include <fcntl.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#define SPACE_NAME "RLIMIT_AS (ulimit -v)"
/* Above it stands no limit: version 1 has no word for that, but a number near 2^63. */
#define GROUP_BYTES_MAX (UINT64_C(1) << 62)
#define PATH_BYTES      512
#define TEXT_BYTES      8192

static uint64_t smaller(uint64_t a, uint64_t b)
{
    return a < b ? a : b;
}

/* The beginning of a file as a text; "" where it cannot be read. */
static void read_text(const char *path, char text[TEXT_BYTES])
{
    size_t length = 0;
    ssize_t got = 1;
    const int file = open(path, O_RDONLY | O_CLOEXEC);
    while (file >= 0 && got > 0 && length + 1 < TEXT_BYTES) {
        got = read(file, text + length, TEXT_BYTES - 1 - length);
        length += got > 0 ? (size_t)got : 0;
    }
    if (file >= 0) {
        (void)close(file);
    }
    text[length] = '\0';
}

/* ---- address space ---- */

static svo_i_limit read_space(void)
{
    struct rlimit space;
    char text[TEXT_BYTES];
    svo_i_limit limit = {SPACE_NAME, UINT64_MAX, 0};
    if (getrlimit(RLIMIT_AS, &space) == 0 && space.rlim_cur != RLIM_INFINITY) {
        const long page_bytes = sysconf(_SC_PAGESIZE);
        limit.bytes = space.rlim_cur;
        read_text("/proc/self/statm", text);
        limit.used_bytes = page_bytes > 0 ? strtoull(text, NULL, 10) * (uint64_t)page_bytes : 0;
    }
    return limit;
}

/* ---- control groups ---- */

/* The two versions: where groups are, and what their files are called. */
typedef struct group_version {
    const char *root, *limit_file, *used_file;
    const char *limit_name;
    const char *cache_words[2]; /* of memory.stat, before the bytes of files, which are given up when memory is short */
} group_version;

static const group_version versions[] = {
    {"/sys/fs/cgroup",
     "memory.max",
     "memory.current",
     "the control group's memory.max",
     {"\ninactive_file ", "\nactive_file "}},
    {"/sys/fs/cgroup/memory",
     "memory.limit_in_bytes",
     "memory.usage_in_bytes",
     "the control group's memory.limit_in_bytes",
     {"\ntotal_inactive_file ", "\ntotal_active_file "}},
};

static void read_group_text(const group_version *version, const char *group, const char *name, char text[TEXT_BYTES])
{
    char path[PATH_BYTES + 128];
    (void)snprintf(path, sizeof path, "%s%s/%s", version->root, group, name);
    read_text(path, text);
}

/* The number that a group's file holds; otherwise: no file, or "max". */
static uint64_t read_group_bytes(const group_version *version, const char *group, const char *name, uint64_t otherwise)
{
    char text[TEXT_BYTES];
    read_group_text(version, group, name, text);
    return text[0] >= '0' && text[0] <= '9' ? strtoull(text, NULL, 10) : otherwise;
}

static svo_i_limit read_group(const group_version *version, const char *group)
{
    char text[TEXT_BYTES];
    svo_i_limit limit = {version->limit_name, read_group_bytes(version, group, version->limit_file, UINT64_MAX), 0};
    if (limit.bytes >= GROUP_BYTES_MAX) {
        return (svo_i_limit){version->limit_name, UINT64_MAX, 0};
    }
    limit.used_bytes = read_group_bytes(version, group, version->used_file, 0);
    read_group_text(version, group, "memory.stat", text);
    for (size_t i = 0; i < sizeof version->cache_words / sizeof version->cache_words[0]; ++i) {
        const char *at = strstr(text, version->cache_words[i]);
        const uint64_t bytes = at != NULL ? strtoull(at + strlen(version->cache_words[i]), NULL, 10) : 0;
        limit.used_bytes -= smaller(bytes, limit.used_bytes);
    }
    return limit;
}

/* The process's group by its line in /proc/self/cgroup, "number:controllers:group": of version 2 without controllers,
   of version 1 with "memory" among them. False without one. */
static bool find_group(const char *lines, bool is_first_version, char group[PATH_BYTES])
{
    for (const char *line = lines; line != NULL && *line != '\0'; line = strchr(line, '\n')) {
        line += *line == '\n' ? 1 : 0;
        const char *controllers = strchr(line, ':');
        const char *path = controllers != NULL ? strchr(controllers + 1, ':') : NULL;
        const size_t length = path != NULL ? strcspn(path + 1, "\n") : 0;
        if (path == NULL || length >= PATH_BYTES) {
            continue;
        }
        const char *word = strstr(controllers, "memory");
        const bool has_memory =
            word != NULL && word < path && (word[-1] == ':' || word[-1] == ',') && (word[6] == ':' || word[6] == ',');
        if (is_first_version ? has_memory : path == controllers + 1) {
            memcpy(group, path + 1, length);
            group[length] = '\0';
            return true;
        }
    }
    return false;
}

/* The group and those above it, up to the root that this process sees: the one that leaves the least. */
static svo_i_limit read_groups(void)
{
    char lines[TEXT_BYTES];
    svo_i_limit least = {versions[0].limit_name, UINT64_MAX, 0};
    read_text("/proc/self/cgroup", lines);
    for (size_t i = 0; i < sizeof versions / sizeof versions[0]; ++i) {
        char group[PATH_BYTES];
        char *end = find_group(lines, i == 1, group) ? group + strlen(group) : NULL;
        while (end != NULL) {
            while (end > group && end[-1] == '/') {
                --end;
            }
            *end = '\0';
            const svo_i_limit limit = read_group(&versions[i], group);
            least = svo_i_limit_left(&limit) < svo_i_limit_left(&least) ? limit : least;
            end = strrchr(group, '/');
        }
    }
    return least;
}

/* ---- both ---- */

svo_i_limit svo_i_limit_read(svo_i_limit_kind kind)
{
    return kind == SVO_I_LIMIT_SPACE ? read_space() : read_groups();
}
