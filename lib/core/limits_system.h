/* SPDX-License-Identifier: MIT */
/* What limits.c asks of the operating system; limits_posix.c or limits_windows.c answers. */
#ifndef SVO_LIB_CORE_LIMITS_SYSTEM_H
#define SVO_LIB_CORE_LIMITS_SYSTEM_H

#include <stdint.h>

typedef struct svo_i_system_limit {
    const char *name; /* for messages */
    uint64_t bytes; /* UINT64_MAX: none, or it cannot be read */
    uint64_t used_bytes; /* of these; 0 where there is no limit */
} svo_i_system_limit;

/* The limit of address space, and that of the process's control groups which leaves the least. */
svo_i_system_limit svo_i_limits_space(void);
svo_i_system_limit svo_i_limits_group(void);

#endif
