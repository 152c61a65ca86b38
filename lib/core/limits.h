/* SPDX-License-Identifier: MIT */
/* How much memory this process may have: what is sure to exceed it is refused before it begins. */
#ifndef SVO_LIB_CORE_LIMITS_H
#define SVO_LIB_CORE_LIMITS_H

#include <stddef.h>
#include <stdint.h>

#include "core/visibility.h"
#include "svocl/status.h"

/* A number of bytes for a message. */
typedef struct svo_i_bytes_text {
    char text[32];
} svo_i_bytes_text;

/* What limits a process beside the machine's memory. */
typedef enum svo_i_limit_kind {
    SVO_I_LIMIT_SPACE, /* of address space: a larger request fails */
    SVO_I_LIMIT_GROUP, /* of the control group and those above it: the system kills a process that needs more */
    SVO_I_LIMIT_KINDS
} svo_i_limit_kind;

typedef struct svo_i_limit {
    const char *name; /* for messages */
    uint64_t bytes; /* UINT64_MAX: none, or it cannot be read */
    uint64_t used_bytes; /* of these; 0 where there is no limit */
} svo_i_limit;

SVO_I_SHARED_BEGIN

/* "144.0 GiB", or "512 bytes" below a KiB. */
svo_i_bytes_text svo_i_bytes(uint64_t bytes);

/* A limit as it is now. */
svo_i_limit svo_i_limit_read(svo_i_limit_kind kind);

/* The least of the machine's memory and the limits, bytes. */
uint64_t svo_i_host_memory_bytes(void);

SVO_I_SHARED_END

/* What it leaves; UINT64_MAX without a limit. */
uint64_t svo_i_limit_left(const svo_i_limit *limit);

/* Adds to the text of a failed allocation that memory is limited, where address space is: "; out of memory: RLIMIT_AS
   (ulimit -v) is 400.0 MiB, of which 12.0 MiB are left". Control groups let no allocation fail. message: NULL
   allowed. */
void svo_i_limit_explain(svo_message *message);

#endif
