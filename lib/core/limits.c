/* SPDX-License-Identifier: MIT */
/* What follows from the limits of this process's memory, which limits_posix.c or limits_windows.c reads. */
#include "core/limits.h"

#include <stdio.h>
#include <string.h>

#include "core/system.h"

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

uint64_t svo_i_limit_left(const svo_i_limit *limit)
{
    return limit->bytes == UINT64_MAX         ? UINT64_MAX
           : limit->used_bytes < limit->bytes ? limit->bytes - limit->used_bytes
                                              : 0;
}

uint64_t svo_i_host_memory_bytes(void)
{
    uint64_t bytes = svo_i_system_memory_bytes();
    for (unsigned kind = 0; kind < SVO_I_LIMIT_KINDS; ++kind) {
        const svo_i_limit limit = svo_i_limit_read((svo_i_limit_kind)kind);
        bytes = limit.bytes < bytes ? limit.bytes : bytes;
    }
    return bytes;
}

void svo_i_limit_explain(svo_message *message)
{
    const svo_i_limit limit = svo_i_limit_read(SVO_I_LIMIT_SPACE);
    const size_t length = message != NULL ? strlen(message->text) : 0;
    if (length > 0 && limit.bytes != UINT64_MAX && strstr(message->text, limit.name) == NULL) {
        (void)snprintf(message->text + length, sizeof message->text - length, "%s%s is %s, of which %s are left",
                       strstr(message->text, "out of memory") != NULL ? "; " : "; out of memory: ", limit.name,
                       svo_i_bytes(limit.bytes).text, svo_i_bytes(svo_i_limit_left(&limit)).text);
    }
}
