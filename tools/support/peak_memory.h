/* SPDX-License-Identifier: MIT */
/* The memory of this process. */
#ifndef SVOCL_TOOLS_SUPPORT_PEAK_MEMORY_H
#define SVOCL_TOOLS_SUPPORT_PEAK_MEMORY_H

#include <stdint.h>

/* The most bytes that this process ever had resident, from /proc; 0: not known. */
uint64_t peak_memory_bytes(void);

#endif
