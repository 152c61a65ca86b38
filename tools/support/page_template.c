/* SPDX-License-Identifier: MIT */
/* A page's template names its style sheet and scripts as a page does that loads them; here each such reference gives
   way to the text of the file. */
#include "support/page_template.h"

#include <string.h>

/* '<' is escaped, so that no text ends the element, and U+2028 and U+2029, which end lines in older JavaScript. */
static void write_json(const char *json, FILE *page)
{
    for (const char *c = json; *c != '\0'; ++c) {
        if (*c == '<') {
            fputs("\\u003c", page);
        } else if (strncmp(c, "\xe2\x80\xa8", 3) == 0 || strncmp(c, "\xe2\x80\xa9", 3) == 0) {
            fputs(c[2] == '\xa8' ? "\\u2028" : "\\u2029", page);
            c += 2;
        } else {
            fputc(*c, page);
        }
    }
}

static void write_part(const page_part *part, FILE *page)
{
    fputs(part->open, page);
    if (part->is_json) {
        write_json(part->text, page);
    } else {
        fputs(part->text, page);
    }
    fputs(part->close, page);
}

int page_template_write(program *state, const char *text, const page_part *parts, size_t part_count, FILE *page)
{
    const char *rest = text + strspn(text, "\n");
    for (size_t i = 0; i < part_count; ++i) {
        const char *found = strstr(rest, parts[i].reference);
        if (found == NULL) {
            return program_fail(state, PROGRAM_FAILED, "the page's template lacks %s", parts[i].reference);
        }
        fwrite(rest, 1, (size_t)(found - rest), page);
        write_part(&parts[i], page);
        rest = found + strlen(parts[i].reference);
    }
    fputs(rest, page);
    return PROGRAM_DONE;
}

void page_template_base64(const unsigned char *bytes, size_t byte_count, FILE *page)
{
    static const char letters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < byte_count; i += 3) {
        const size_t left = byte_count - i;
        const unsigned group = (unsigned)bytes[i] << 16 | (left > 1 ? (unsigned)bytes[i + 1] << 8 : 0u) |
                               (left > 2 ? (unsigned)bytes[i + 2] : 0u);
        fputc(letters[group >> 18], page);
        fputc(letters[group >> 12 & 63u], page);
        fputc(left > 1 ? letters[group >> 6 & 63u] : '=', page);
        fputc(left > 2 ? letters[group & 63u] : '=', page);
    }
}
