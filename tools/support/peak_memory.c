/* SPDX-License-Identifier: MIT */
/* VmHWM of /proc/self/status. */
#include "support/peak_memory.h"

#include <inttypes.h>
#include <stdio.h>

uint64_t peak_memory_bytes(void)
{
    char line[256];
    uint64_t kibibytes = 0;
    FILE *file = fopen("/proc/self/status", "r");
    if (file == NULL) {
        return 0;
    }
    while (fgets(line, sizeof line, file) != NULL && sscanf(line, "VmHWM: %" SCNu64, &kibibytes) != 1) {
    }
    (void)fclose(file);
    return kibibytes * 1024;
}
