/* SPDX-License-Identifier: MIT */
/* Numbers as text, the same in every locale. */
#ifndef SVO_LIB_IO_VOXELS_TEXT_H
#define SVO_LIB_IO_VOXELS_TEXT_H

#include <stddef.h>

#define VOXEL_NUMBER_BYTES 48 /* holds every number, with its terminator */

/* Writes a finite number in decimal, with so many significant digits; 17 give every double back. Returns text. */
const char *svo_i_voxel_number(char text[VOXEL_NUMBER_BYTES], double value, int digits);

#endif
