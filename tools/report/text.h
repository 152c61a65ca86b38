/* SPDX-License-Identifier: MIT */
/* Text of pages: characters that mean something there, bytes as letters, and figures as people read them. */
#ifndef SVOCL_TOOLS_REPORT_TEXT_H
#define SVOCL_TOOLS_REPORT_TEXT_H

#include <stddef.h>
#include <stdio.h>

#define PLOT_RULE_COLOR 0xc8c8c8u /* of grid lines, as gnuplot is told */

void text_escape(const char *text, FILE *page);

/* RFC 4648. */
void text_base64(const unsigned char *bytes, size_t byte_count, FILE *page);

/* Letters and digits of the text, others as '-': for names of files, ids and anchors. */
typedef struct text_name {
    char text[96];
} text_name;
text_name text_make_name(const char *text);

/* Three significant digits, more in front of the point; counts whole, with separators; powers of ten where the number
   is very small or large. */
typedef struct text_number {
    char text[48];
} text_number;
text_number text_format_number(double number);
/* "10⁻⁸" */
text_number text_format_power(int exponent);

#endif
