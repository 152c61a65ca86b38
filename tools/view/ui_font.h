/* SPDX-License-Identifier: MIT */
/* The panels' font, DejaVu Sans, which the build embeds. */
#ifndef SVOCL_TOOLS_VIEW_UI_FONT_H
#define SVOCL_TOOLS_VIEW_UI_FONT_H

#ifdef __cplusplus
extern "C" {
#endif

extern const unsigned char ui_font_bytes[]; /* a TrueType file */
extern const unsigned ui_font_byte_count;

#ifdef __cplusplus
}
#endif

#endif
