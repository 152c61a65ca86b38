/* SPDX-License-Identifier: MIT */
/*
 * Buffers that wait for their next use, so that work that is done again and again makes none and releases none. New
 * memory costs a page fault for every page, and its release as much again.
 */
#ifndef SVO_LIB_CORE_SPARES_H
#define SVO_LIB_CORE_SPARES_H

#include "core/device.h"

/* Most buffers that wait; of more, the smallest is released. */
#define SVO_I_SPARES_MAX 64

typedef struct svo_i_spare {
    cl_mem buffer;
    uint64_t bytes;
    bool waited; /* for a whole round */
} svo_i_spare;

typedef struct svo_i_spares {
    svo_i_spare entries[SVO_I_SPARES_MAX];
    uint32_t count;
} svo_i_spares;

/* Takes the smallest buffer that is large enough and at most about half too large, or makes one: with an eighth more
   where memory allows, so that what grows a little fits the next time. Its content is undefined. made_bytes: receives
   its size; NULL: not wanted. */
svo_status svo_i_spares_take(svo_i_spares *spares, svo_device *device, const char *function, const char *name,
                             uint64_t bytes, cl_mem *out, uint64_t *made_bytes);
/* Gives a buffer, NULL allowed, which becomes NULL. Commands that use it precede those of the next user. */
void svo_i_spares_give(svo_i_spares *spares, cl_mem *buffer);
/* A round has ended: releases what has waited since the end of the round before it. */
void svo_i_spares_end_round(svo_i_spares *spares);
void svo_i_spares_clear(svo_i_spares *spares);
/* Of all that wait. */
uint64_t svo_i_spares_bytes(const svo_i_spares *spares);

/* The size of a buffer; 0 for NULL. */
uint64_t svo_i_buffer_bytes(cl_mem buffer);

#endif
