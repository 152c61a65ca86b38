/* SPDX-License-Identifier: MIT */
/* Creates the leaves' ranges and lists of triangles. */
#ifndef SVO_GLINTEROP_COMPUTE_PACK_H
#define SVO_GLINTEROP_COMPUTE_PACK_H

#include "compute/stage.h"

/* Creates list_begin, and list if with_lists. */
svo_status svo_i_gl_pack(svo_i_gl_build *gl_build, bool with_lists);

#endif
