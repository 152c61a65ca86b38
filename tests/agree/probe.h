/* SPDX-License-Identifier: MIT */
/* probe.clh in C: probe.c is compiled once for each of its variants, which cannot live in one translation unit. */
#ifndef SVO_TESTS_PROBE_H
#define SVO_TESTS_PROBE_H

#include <stddef.h>

#include "probe.clh"

typedef void probe_function(const probe_input *given, probe_output *found, size_t record_count);

probe_function probe_narrow, probe_regular, probe_wide, probe_integers;

/* The same text for OpenCL C and GLSL; the variant is chosen by the keys. */
extern const char probe_source_cl[];
extern const char probe_source_gl[];

/* First and last voxel of the record's column that meet the triangle, by asking for each; first > last: none. */
typedef void probe_column_function(const probe_input *given, SVO_I32 *first, SVO_I32 *last);

probe_column_function probe_column_narrow, probe_column_regular, probe_column_wide;

#endif
