/* SPDX-License-Identifier: MIT */
/* sRGB's curve (IEC 61966-2-1), the same on every platform: of square roots and of Newton's steps. */
#ifndef SVO_LIB_IO_SRGB_H
#define SVO_LIB_IO_SRGB_H

#include <stdint.h>

/* Linear [0, 1] to sRGB, 0 .. 255, rounded. What is outside is taken as the nearest end, NaN as 0. */
uint8_t svo_i_srgb_byte(double linear);

/* sRGB, 0 .. 255, to linear [0, 1]. As a float it gives the byte back. */
double svo_i_srgb_linear(uint8_t byte);

#endif
