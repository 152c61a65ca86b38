/* SPDX-License-Identifier: MIT */
/* Which share paths work on a pair of device and context. */
#ifndef SVO_GLINTEROP_SHARE_PROBE_H
#define SVO_GLINTEROP_SHARE_PROBE_H

#include "context/context.h"
#include "core/device.h"

/*
 * Writes to reason why a share path does not work on this pair, in one line, or "" if it works. `interop` and `host`
 * are tested by a round trip. The device's message stays unchanged.
 *
 * share: not AUTO. reason: not NULL, at least one byte; longer reasons are cut.
 */
void svo_i_share_probe(svo_device *device, svo_gl_context *context, svo_gl_share share, char *reason,
                       size_t reason_bytes);

#endif
