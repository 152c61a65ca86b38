/* SPDX-License-Identifier: MIT */
/* How much memory this process may have, so that a small file that unfolds to more is refused before it does. */
#ifndef SVO_LIB_CORE_HOST_MEMORY_H
#define SVO_LIB_CORE_HOST_MEMORY_H

#include "core/message.h"

/* A number of bytes for a message. */
typedef struct svo_i_bytes_text {
    char text[32];
} svo_i_bytes_text;

SVO_I_SHARED_BEGIN

/* The least of the machine's memory, the process's limit of address space and the limit of its control group, bytes. */
uint64_t svo_i_host_memory_bytes(void);

/* "144.0 GiB", or "512 bytes" below a KiB. */
svo_i_bytes_text svo_i_bytes(uint64_t bytes);

SVO_I_SHARED_END

#endif
