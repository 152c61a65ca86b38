/* SPDX-License-Identifier: MIT */
/* Which share paths work on a pair of device and context. */
#ifndef SVO_GLINTEROP_SHARE_PROBE_H
#define SVO_GLINTEROP_SHARE_PROBE_H

#include "context/context.h"
#include "core/device.h"

/*
 * Why a share path works or not on this pair: "" in reason if it does, else one line. `sharing` and `host` are put to a
 * round trip.
 *
 * share: not AUTO. reason: not NULL, at least one byte; longer reasons are cut. Leaves the device's message as it was.
 */
void svo_i_share_probe(svo_device *device, svo_gl_context *context, svo_gl_share share, char *reason,
                       size_t reason_bytes);

#endif
