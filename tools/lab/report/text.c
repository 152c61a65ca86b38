/* SPDX-License-Identifier: MIT */
/* Text in the forms that summaries and file names need. */
#include "report/text.h"

#include <ctype.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "support/table.h"

text_name text_make_name(const char *text)
{
    text_name name = {""};
    size_t used = 0;
    for (const char *c = text; *c != '\0' && used + 1 < sizeof name.text; ++c) {
        const bool plain = isalnum((unsigned char)*c) != 0;
        if (plain || (used > 0 && name.text[used - 1] != '-')) {
            name.text[used++] = plain ? *c : '-';
        }
    }
    while (used > 0 && name.text[used - 1] == '-') {
        --used;
    }
    name.text[used] = '\0';
    return name;
}

/* "10⁻⁸" */
static text_number format_power(int exponent)
{
    static const char *const digits[10] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
    text_number result;
    char plain[16];
    size_t used = (size_t)snprintf(result.text, sizeof result.text, "10%s", exponent < 0 ? "⁻" : "");
    snprintf(plain, sizeof plain, "%d", exponent < 0 ? -exponent : exponent);
    for (const char *c = plain; *c != '\0' && used < sizeof result.text; ++c) {
        used += (size_t)snprintf(result.text + used, sizeof result.text - used, "%s", digits[*c - '0']);
    }
    return result;
}

/* "2.2×10⁻⁸" */
static void write_scientific(double number, text_number *out)
{
    int exponent = (int)floor(log10(fabs(number)));
    double mantissa = number / pow(10.0, exponent);
    if (fabs(mantissa) >= 9.95) {
        mantissa /= 10.0;
        ++exponent;
    }
    snprintf(out->text, sizeof out->text, "%.1f×%.40s", mantissa, format_power(exponent).text);
}

text_number text_format_number(double number)
{
    text_number result = {""};
    const double size = fabs(number);
    if (number >= 0.0 && size < 1e15 && number == floor(number)) {
        snprintf(result.text, sizeof result.text, "%s", figure_count((uint64_t)number).text);
    } else if (size >= 1e15 || (size < 1e-3 && size > 0.0)) {
        write_scientific(number, &result);
    } else if (size >= 1000.0) {
        snprintf(result.text, sizeof result.text, "%s%s", number < 0.0 ? "-" : "",
                 figure_count((uint64_t)rint(size)).text);
    } else {
        const int decimals = 2 - (int)floor(log10(size));
        snprintf(result.text, sizeof result.text, "%.*f", decimals, number);
    }
    return result;
}

double text_choose_unit(const result_table *shown, size_t column, const char **unit)
{
    double most = 0.0;
    *unit = shown->columns[column].unit;
    if (strcmp(*unit, "B") != 0) {
        return 1.0;
    }
    for (size_t row = 0; row < result_row_count(shown); ++row) {
        const result_cell *cell = result_cell_at(shown, row, column);
        most = cell->kind == RESULT_NUMBER && cell->number > most ? cell->number : most;
    }
    *unit = most >= 0x1p20 ? "MiB" : most >= 0x1p13 ? "KiB" : "bytes";
    return most >= 0x1p20 ? 0x1p20 : most >= 0x1p13 ? 0x1p10 : 1.0;
}
