/* SPDX-License-Identifier: MIT */
/* Differences of colors as people see them. */
#ifndef SVOCL_TOOLS_TUNE_DELTA_E_H
#define SVOCL_TOOLS_TUNE_DELTA_E_H

/* sRGB's linear light, 0 .. 1, to CIELAB under D65. */
void delta_e_lab(const double linear[3], double lab[3]);

/* CIEDE2000 with all weights 1, as Sharma, Wu and Dalal, "The CIEDE2000 Color-Difference Formula: Implementation Notes,
   Supplementary Test Data, and Mathematical Observations", 2005, have it. */
double delta_e_2000(const double a[3], const double b[3]);

#endif
