/* SPDX-License-Identifier: MIT */
/* kernels/solid/crossing.clh in C, as it is and with planted mistakes: crossing_probe.c. */
#ifndef SVOCL_TESTS_AGREE_CROSSING_CROSSING_PROBE_H
#define SVOCL_TESTS_AGREE_CROSSING_CROSSING_PROBE_H

#include <stdint.h>

/* The sense in which a line along an axis crosses a triangle (x, y, z of its corners) from low to below high; 0: not.
   */
typedef int crossing_function(const int32_t *corners, uint32_t axis, const int32_t point[2], int32_t low, int32_t high);
crossing_function crossing_sound, crossing_tie, crossing_both, crossing_none, crossing_far, crossing_turned;

/* The sign of a dot product whose terms take up to 78 bits. */
int crossing_sign(const int64_t a[3], const int32_t b[3]);

#endif
