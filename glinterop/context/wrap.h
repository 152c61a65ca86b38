/* SPDX-License-Identifier: MIT */
/* Contexts that the caller created and keeps current. */
#ifndef SVO_GLINTEROP_CONTEXT_WRAP_H
#define SVO_GLINTEROP_CONTEXT_WRAP_H

#include "context/platform.h"

/* is_current compares with the context that was current when create was called; make_current always fails. */
extern const svo_i_gl_platform svo_i_wrap_platform;

#endif
