/* SPDX-License-Identifier: MIT */
/* Which share paths work on a pair of device and context. */
#ifndef SVO_GLINTEROP_SHARE_PROBE_H
#define SVO_GLINTEROP_SHARE_PROBE_H

#include "context/context.h"
#include "core/device.h"

#define SVO_I_SHARES             4
#define SVO_I_SHARE_REASON_BYTES SVO_MESSAGE_BYTES /* reasons are messages, with names of drivers in them */

/* Why each path does not work; "" for one that does. */
typedef struct svo_i_share_reasons {
    char text[SVO_I_SHARES][SVO_I_SHARE_REASON_BYTES];
} svo_i_share_reasons;

/*
 * Finds what works on this pair and chooses. asked: AUTO takes the first path that works; another one that does not is
 * SVO_UNSUPPORTED, with the reason in the device's message. function: for that message.
 */
svo_status svo_i_share_choose(svo_device *device, svo_gl_context *context, const char *function, svo_gl_share asked,
                              svo_i_share_reasons *reasons, svo_gl_share *choice);

/*
 * Writes to reason why a share path does not work on this pair, in one line, or "" if it works. `interop` and `host`
 * are tested by a round trip. The device's message stays unchanged.
 *
 * share: not AUTO. reason: not NULL, at least one byte; longer reasons are cut.
 */
void svo_i_share_probe(svo_device *device, svo_gl_context *context, svo_gl_share share, char *reason,
                       size_t reason_bytes);

#endif
