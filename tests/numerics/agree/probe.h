/* SPDX-License-Identifier: MIT */
/* probe.clh in C: probe.c is compiled once per variant, since a translation unit can hold only one. */
#ifndef SVOCL_TESTS_AGREE_PROBE_H
#define SVOCL_TESTS_AGREE_PROBE_H

#include <stddef.h>

#include "probe.clh"

typedef void probe_function(const probe_input *given, probe_output *found, size_t record_count);

probe_function probe_narrow, probe_regular, probe_wide, probe_integers, probe_exact;
probe_function probe_thin_narrow, probe_thin_regular, probe_thin_wide;

/* The source for OpenCL C and for GLSL; the defines select the variant. */
extern const char probe_source_cl[];
extern const char probe_source_gl[];

/* First and last voxel of the record's column that meet the triangle, by testing each; first > last: none. */
typedef void probe_column_function(const probe_input *given, SVO_I32 *first, SVO_I32 *last, SVO_I32 *decided);

probe_column_function probe_column_narrow, probe_column_regular, probe_column_wide;
probe_column_function probe_column_thin_narrow, probe_column_thin_regular, probe_column_thin_wide;

/* Variants with a planted mistake: a strict comparison (regular and narrow), a missing line test, a missing plane test,
   voxels closed at their far faces, closed thin intervals. */
probe_function probe_mutant_sign, probe_mutant_narrow_sign, probe_mutant_line, probe_mutant_plane, probe_mutant_open,
    probe_mutant_thin;
probe_column_function probe_column_mutant_sign, probe_column_mutant_narrow_sign, probe_column_mutant_line,
    probe_column_mutant_plane, probe_column_mutant_open, probe_column_mutant_thin;

#endif
