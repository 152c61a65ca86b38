/* SPDX-License-Identifier: MIT */
/* The colors and markers of ways: the same in every chart and legend. Okabe and Ito, "Color Universal Design", 2008. */
#ifndef SVOCL_TOOLS_REPORT_PALETTE_H
#define SVOCL_TOOLS_REPORT_PALETTE_H

#include <stddef.h>
#include <stdint.h>

/* In the style sheet the colors are --way-0 to --way-7, in that order, once for light and once for dark. */
typedef enum palette_color {
    PALETTE_BLUE = 0,
    PALETTE_SKY,
    PALETTE_GREEN,
    PALETTE_ORANGE,
    PALETTE_VERMILLION,
    PALETTE_PURPLE,
    PALETTE_YELLOW,
    PALETTE_GREY,
    PALETTE_COLOR_COUNT
} palette_color;

/* Filled, by gnuplot's numbers of point types. */
typedef enum palette_marker {
    MARKER_SQUARE = 5,
    MARKER_CIRCLE = 7,
    MARKER_UP = 9,
    MARKER_DOWN = 11,
    MARKER_DIAMOND = 13
} palette_marker;

typedef struct method_style {
    palette_color color;
    palette_marker marker;
} method_style;

/* Known names have their own; others one by their position among the curves. */
method_style palette_of(const char *method, size_t position);

uint32_t palette_rgb(palette_color color); /* 0xrrggbb, as gnuplot is told: the light one */
const char *palette_marker_path(palette_marker marker); /* SVG path of about two units, its middle at 0,0 */

#endif
