/* SPDX-License-Identifier: MIT */
/* Normal maps from images of bump. */
#ifndef SVO_LIB_IO_IMPORT_BUMP_H
#define SVO_LIB_IO_IMPORT_BUMP_H

#include <stddef.h>
#include <stdint.h>

#include "svocl/mesh.h"

/* The normal map of an image of bump, from malloc; NULL when memory runs out. */
uint8_t *svo_i_import_normals_of_bump(const uint8_t *pixels, size_t width, size_t height, svo_wrap wrap_u,
                                      svo_wrap wrap_v);

#endif
