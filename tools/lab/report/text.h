/* SPDX-License-Identifier: MIT */
/* Text of a report: names of files, and numbers as people read them. text.js has the same rules for numbers and
   units. */
#ifndef SVOCL_TOOLS_REPORT_TEXT_H
#define SVOCL_TOOLS_REPORT_TEXT_H

#include <stddef.h>

#include "measure/result.h"

/* Letters and digits of the text, anything else as '-': for names of files. */
typedef struct text_name {
    char text[96];
} text_name;
text_name text_make_name(const char *text);

/* At least three significant digits; counts in full, with separators; powers of ten for very small and large
   numbers. */
typedef struct text_number {
    char text[64];
} text_number;
text_number text_format_number(double number);

/* The unit that a column is shown in, and the divisor of its numbers: bytes get the one that suits the largest of them,
   other columns keep theirs. */
double text_choose_unit(const result_table *shown, size_t column, const char **unit);

#endif
