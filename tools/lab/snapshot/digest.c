/* SPDX-License-Identifier: MIT */
/* Prints the lines of a snapshot. */
#include "digest.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#define READ_BYTES 65536

void line_text_add(line_text *line, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    const int length = vsnprintf(line->text + line->used, sizeof line->text - line->used, format, arguments);
    va_end(arguments);
    line->used += length > 0 ? (size_t)length : 0;
    if (line->used >= sizeof line->text) {
        line->used = sizeof line->text - 1;
    }
}

/* A tab or a newline in the value would break the line. */
void line_print(const char *name, const char *part, const char *value)
{
    printf("%s: %s\t", name, part);
    for (const char *c = value; *c != '\0'; ++c) {
        putchar(*c == '\t' || *c == '\n' ? ' ' : *c);
    }
    putchar('\n');
}

static void print_hash(const char *name, const char *part, XXH128_hash_t hash)
{
    printf("%s: %s\t%016" PRIx64 "%016" PRIx64 "\n", name, part, (uint64_t)hash.high64, (uint64_t)hash.low64);
}

void line_print_digest(const char *name, const char *part, const void *bytes, size_t byte_count)
{
    print_hash(name, part, XXH3_128bits(bytes, byte_count));
}

void line_print_status(const char *name, const char *part, svo_status status)
{
    printf("%s: %s\tstatus %d\n", name, part, (int)status);
}

void line_print_file(const char *name, const char *part, const char *path)
{
    XXH3_state_t *state = XXH3_createState();
    unsigned char *bytes = malloc(READ_BYTES);
    FILE *file = fopen(path, "rb");
    if (state == NULL || bytes == NULL || file == NULL) {
        line_print(name, part, "cannot be read");
        goto cleanup;
    }
    XXH3_128bits_reset(state);
    size_t count = 0;
    while ((count = fread(bytes, 1, READ_BYTES, file)) > 0) {
        XXH3_128bits_update(state, bytes, count);
    }
    print_hash(name, part, XXH3_128bits_digest(state));
cleanup:
    if (file != NULL) {
        fclose(file);
    }
    free(bytes);
    XXH3_freeState(state);
}
