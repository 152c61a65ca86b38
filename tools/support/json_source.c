/* SPDX-License-Identifier: MIT */
/*
 * cJSON parses; it does not say where a value was. In a document that it accepted, values and the items that cJSON made
 * of them have the same order, so the text is scanned once more, for where values begin, and both are counted.
 */
#include "support/json_source.h"

#include <errno.h>
#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/suggest.h"
#include "support/text.h"

#define TEXT_BYTES_MAX ((size_t)256 << 20)

/* ---- lines ---- */

/* The end of a string: behind its closing quote. */
static const char *skip_string(const char *at)
{
    for (++at; *at != '\0' && *at != '"'; ++at) {
        at += *at == '\\' && at[1] != '\0';
    }
    return *at == '"' ? at + 1 : at;
}

static bool is_key(const char *behind)
{
    return behind[strspn(behind, " \t\r\n")] == ':';
}

static unsigned count_lines(const char *from, const char *to)
{
    unsigned lines = 0;
    for (; from < to; ++from) {
        lines += *from == '\n';
    }
    return lines;
}

/* The lines of at most capacity values, in the order of the text. Returns how many values there are. */
static size_t scan_lines(const char *text, unsigned *lines, size_t capacity)
{
    size_t count = 0;
    unsigned line = 1;
    unsigned key_line = 0; /* of the key before the value; 0: none */
    for (const char *at = text; *at != '\0';) {
        const char *behind = at + 1;
        bool is_value = false;
        if (*at == '"') {
            behind = skip_string(at);
            is_value = !is_key(behind);
            key_line = is_value ? key_line : line;
        } else if (*at == '{' || *at == '[') {
            is_value = true;
        } else if (strchr(" \t\r\n,:]}", *at) == NULL) { /* a number, true, false, null */
            behind = at + strcspn(at, " \t\r\n,:]}");
            is_value = true;
        }
        if (is_value) {
            if (count < capacity) {
                lines[count] = key_line != 0 ? key_line : line;
            }
            ++count;
            key_line = 0;
        }
        line += count_lines(at, behind);
        at = behind;
    }
    return count;
}

/* The items below one, itself included, in the order of the text. Returns the number of values so far. */
static size_t list_items(const cJSON *item, const cJSON **values, size_t count, size_t capacity)
{
    if (count < capacity) {
        values[count] = item;
    }
    ++count;
    for (const cJSON *child = item->child; child != NULL; child = child->next) {
        count = list_items(child, values, count, capacity);
    }
    return count;
}

static unsigned line_of(const json_source *source, const cJSON *value)
{
    for (size_t i = 0; i < source->count; ++i) {
        if (source->values[i] == value) {
            return source->lines[i];
        }
    }
    return 1;
}

int json_source_fail(const json_source *source, const cJSON *value, const char *format, ...)
{
    char text[1024];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return program_fail(source->state, PROGRAM_FAILED, "%s:%u: %s", source->path, line_of(source, value), text);
}

/* ---- opening ---- */

/* The whole file as a text that the caller frees. */
static int read_text(program *state, const char *path, char **out)
{
    FILE *stream = fopen(path, "rb");
    if (stream == NULL) {
        return program_fail(state, PROGRAM_FAILED, "%s: %s", path, strerror(errno));
    }
    int exit_code = PROGRAM_DONE;
    size_t used = 0;
    size_t capacity = 1 << 16;
    char *text = malloc(capacity + 1);
    while (text != NULL) {
        const size_t got = fread(text + used, 1, capacity - used, stream);
        used += got;
        if (got == 0 || used > TEXT_BYTES_MAX) {
            break;
        }
        if (used == capacity) {
            capacity *= 2;
            char *larger = realloc(text, capacity + 1);
            if (larger == NULL) {
                free(text);
            }
            text = larger;
        }
    }
    if (text == NULL || used > TEXT_BYTES_MAX) {
        exit_code =
            program_fail(state, PROGRAM_FAILED, "%s: more than %zu bytes, or out of memory", path, TEXT_BYTES_MAX);
    } else if (ferror(stream) != 0) {
        exit_code = program_fail(state, PROGRAM_FAILED, "%s: %s", path, strerror(errno));
    } else {
        text[used] = '\0';
        if (strlen(text) != used) {
            exit_code = program_fail(state, PROGRAM_FAILED, "%s: not a text: it has a zero byte", path);
        }
    }
    fclose(stream);
    if (exit_code == PROGRAM_DONE) {
        *out = text;
    } else {
        free(text);
    }
    return exit_code;
}

static int index_values(json_source *source, const char *text)
{
    static const char byte_order_mark[] = "\xef\xbb\xbf";
    text += strncmp(text, byte_order_mark, 3) == 0 ? 3 : 0;
    source->count = list_items(source->root, NULL, 0, 0);
    source->values = calloc(source->count, sizeof *source->values);
    source->lines = calloc(source->count, sizeof *source->lines);
    if (source->values == NULL || source->lines == NULL) {
        return program_fail(source->state, PROGRAM_FAILED, "%s: out of memory", source->path);
    }
    (void)list_items(source->root, source->values, 0, source->count);
    if (scan_lines(text, source->lines, source->count) != source->count) {
        return program_fail(source->state, PROGRAM_FAILED, "%s: not JSON", source->path);
    }
    return PROGRAM_DONE;
}

static int parse(json_source *source, const char *text)
{
    const char *end = text;
    source->root = cJSON_ParseWithLengthOpts(text, strlen(text) + 1, &end, 1);
    if (source->root == NULL) {
        const json_error error = json_error_at(text, end);
        return program_fail(source->state, PROGRAM_FAILED, "%s:%u: %s", source->path, error.line, error.text);
    }
    return index_values(source, text);
}

static int check_members(const json_source *source, const cJSON *object)
{
    const cJSON *a = NULL;
    cJSON_ArrayForEach(a, object)
    {
        if (cJSON_GetObjectItemCaseSensitive(object, a->string) != a) {
            return json_source_fail(source, a, "a second '%s' in the same object", a->string);
        }
    }
    return PROGRAM_DONE;
}

static int check_names(const json_source *source)
{
    int exit_code = PROGRAM_DONE;
    for (size_t i = 0; i < source->count && exit_code == PROGRAM_DONE; ++i) {
        exit_code = cJSON_IsObject(source->values[i]) ? check_members(source, source->values[i]) : PROGRAM_DONE;
    }
    return exit_code;
}

int json_source_open(program *state, const char *path, json_source *out)
{
    char *text = NULL;
    *out = (json_source){.state = state, .path = path};
    int exit_code = read_text(state, path, &text);
    if (exit_code == PROGRAM_DONE) {
        exit_code = parse(out, text);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = check_names(out);
    }
    free(text);
    if (exit_code != PROGRAM_DONE) {
        json_source_close(out);
    }
    return exit_code;
}

void json_source_close(json_source *source)
{
    cJSON_Delete(source->root);
    free(source->values);
    free(source->lines);
    *source = (json_source){.root = NULL};
}

/* ---- checks ---- */

static bool is_among(const char *key, const char *const *keys)
{
    for (; *keys != NULL; ++keys) {
        if (strcmp(*keys, key) == 0) {
            return true;
        }
    }
    return false;
}

static int fail_key(const json_source *source, const cJSON *member, const char *what, const char *const *keys)
{
    char known[256] = "";
    size_t used = 0;
    suggestion near = suggestion_begin(member->string, strlen(member->string));
    for (size_t i = 0; keys[i] != NULL && used < sizeof known; ++i) {
        used += (size_t)snprintf(known + used, sizeof known - used, "%s%s", i > 0 ? ", " : "", keys[i]);
        suggestion_offer(&near, keys[i]);
    }
    return json_source_fail(source, member, "key '%s' of %s is none of %s%s", member->string, what, known,
                            suggestion_end(&near).text);
}

int json_source_check_keys(const json_source *source, const cJSON *object, const char *what, const char *const *keys)
{
    if (!cJSON_IsObject(object)) {
        return json_source_fail(source, object, "%s is not an object", what);
    }
    for (const cJSON *member = object->child; member != NULL; member = member->next) {
        if (!is_among(member->string, keys)) {
            return fail_key(source, member, what, keys);
        }
    }
    return PROGRAM_DONE;
}

int json_source_floats(const json_source *source, const cJSON *array, const char *what, size_t count, float *out)
{
    if (!cJSON_IsArray(array) || (size_t)cJSON_GetArraySize(array) != count) {
        return json_source_fail(source, array, "'%s' is not an array of %zu numbers", what, count);
    }
    const cJSON *number = array->child;
    for (size_t i = 0; i < count; ++i, number = number->next) {
        if (!cJSON_IsNumber(number) || !(fabs(number->valuedouble) <= (double)FLT_MAX)) {
            return json_source_fail(source, number, "number %zu of '%s' is not a number within the range of floats",
                                    i + 1, what);
        }
        out[i] = (float)number->valuedouble;
    }
    return PROGRAM_DONE;
}

int json_source_count(const json_source *source, const cJSON *number, const char *what, unsigned low, unsigned high,
                      unsigned *out)
{
    const double value = cJSON_IsNumber(number) ? number->valuedouble : -1;
    if (!(value >= low) || !(value <= high) || floor(value) != value) {
        return json_source_fail(source, number, "'%s' is not a whole number in %u .. %u", what, low, high);
    }
    *out = (unsigned)value;
    return PROGRAM_DONE;
}
