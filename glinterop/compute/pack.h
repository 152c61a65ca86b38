/* SPDX-License-Identifier: MIT */
/* Ranges and lists of the leaves' triangles. */
#ifndef SVO_GLINTEROP_COMPUTE_PACK_H
#define SVO_GLINTEROP_COMPUTE_PACK_H

#include "compute/stage.h"

/* list_begin; and list, if asked for. */
svo_status svo_i_gl_pack(svo_i_gl_build *gl_build, bool with_lists);

#endif
