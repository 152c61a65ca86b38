/* SPDX-License-Identifier: MIT */
/* Colors and distances that both toolkits share. */
#ifndef SVOCL_TOOLS_VIEW_UI_THEME_H
#define SVOCL_TOOLS_VIEW_UI_THEME_H

#include "view/ui_drawing.h"

#define UI_COLOR_PANEL   UI_RGBA(22, 25, 31, 226)
#define UI_COLOR_EDGE    UI_RGBA(255, 255, 255, 24)
#define UI_COLOR_TEXT    UI_RGBA(226, 230, 236, 255)
#define UI_COLOR_DIM     UI_RGBA(150, 158, 170, 255)
#define UI_COLOR_ACCENT  UI_RGBA(94, 176, 239, 255)
#define UI_COLOR_CHOSEN  UI_RGBA(42, 98, 148, 255)
#define UI_COLOR_FIELD   UI_RGBA(54, 61, 74, 255)
#define UI_COLOR_HOVER   UI_RGBA(68, 78, 95, 255)
#define UI_COLOR_PRESSED UI_RGBA(84, 97, 118, 255)
#define UI_COLOR_WARNING UI_RGBA(242, 178, 92, 255)

/* Probes by their state. */
#define UI_COLOR_PROBE_OFF      UI_RGBA(235, 87, 130, 255)
#define UI_COLOR_PROBE_IN_PLACE UI_RGBA(94, 176, 239, 255)
#define UI_COLOR_PROBE_MOVED    UI_RGBA(248, 186, 84, 255)

/* Axes of the world. */
#define UI_COLOR_AXIS_X UI_RGBA(240, 96, 104, 255)
#define UI_COLOR_AXIS_Y UI_RGBA(108, 205, 108, 255)
#define UI_COLOR_AXIS_Z UI_RGBA(104, 156, 255, 255)

/* Pixel sizes of text. */
#define UI_TEXT_SMALL 13.0F
#define UI_TEXT_LARGE 16.0F

#define UI_PADDING      8.0F /* between a panel's edge and what it holds */
#define UI_GAP          4.0F /* between rows, and between widgets of a row */
#define UI_INSET_X      5.0F /* between a widget's edge and its text */
#define UI_INSET_Y      2.0F
#define UI_LABEL_SHARE  0.36F /* of a panel's width: labels */
#define UI_ROUNDING     3.0F
#define UI_SCROLL_WIDTH 6.0F

#endif
