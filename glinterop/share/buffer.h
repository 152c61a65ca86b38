/* SPDX-License-Identifier: MIT */
/* The insides of svo_gl_buffer. */
#ifndef SVO_GLINTEROP_SHARE_BUFFER_H
#define SVO_GLINTEROP_SHARE_BUFFER_H

#include "core/work.h"
#include "share/probe.h"
#include "share/share.h"

struct svo_gl_buffer {
    svo_i_share_buffer shared;
    svo_i_share_reasons reasons;
    bool is_in_cl; /* between svo_gl_buffer_to_cl and svo_gl_buffer_to_gl */
    svo_i_in_flight released; /* by interop: the ends of updates from it */
};

/* Names the public function in the message of a failure inside. */
svo_status svo_i_gl_buffer_named(svo_device *device, const char *function, svo_status status);

/* Waits until no update from the buffer is in flight. */
void svo_i_gl_buffer_settle(svo_gl_buffer *buffer);

#endif
