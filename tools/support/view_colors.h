/* SPDX-License-Identifier: MIT */
/* Colors of numbers as kernels/rays/view.cl has them, for pictures and scales that the host colors. */
#ifndef SVOCL_TOOLS_SUPPORT_VIEW_COLORS_H
#define SVOCL_TOOLS_SUPPORT_VIEW_COLORS_H

/* The steps that the last color stands for in pictures of the library. */
#define VIEW_COLORS_STEPS_HOT 64.0F

/* From dark blue over green and yellow to red. share: 0 .. 1 of that. */
void view_colors_steps(float share, float rgb[3]);

#endif
