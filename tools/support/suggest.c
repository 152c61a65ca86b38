/* SPDX-License-Identifier: MIT */
/*
 * The distance of two names is the number of letters to insert, remove, change or swap with their neighbor (optimal
 * string alignment). The beginning of a name is at distance 1.
 */
#include "support/suggest.h"

#include <stdio.h>
#include <string.h>

#define LENGTH_MAX 31

static size_t smaller(size_t a, size_t b)
{
    return a < b ? a : b;
}

/* Both lengths are at most LENGTH_MAX. */
static size_t measure(const char *a, size_t a_length, const char *b, size_t b_length)
{
    size_t rows[LENGTH_MAX + 1][LENGTH_MAX + 1];
    for (size_t i = 0; i <= a_length; ++i) {
        for (size_t k = 0; k <= b_length; ++k) {
            if (i == 0 || k == 0) {
                rows[i][k] = i + k;
                continue;
            }
            const size_t changed = rows[i - 1][k - 1] + (a[i - 1] != b[k - 1]);
            rows[i][k] = smaller(changed, smaller(rows[i - 1][k], rows[i][k - 1]) + 1);
            if (i > 1 && k > 1 && a[i - 1] == b[k - 2] && a[i - 2] == b[k - 1]) {
                rows[i][k] = smaller(rows[i][k], rows[i - 2][k - 2] + 1);
            }
        }
    }
    return rows[a_length][b_length];
}

suggestion suggestion_begin(const char *wanted, size_t length)
{
    /* A third of the letters may be wrong. */
    return (suggestion){.wanted = wanted, .length = length, .distance = length / 3 + 2};
}

void suggestion_offer(suggestion *near, const char *name)
{
    const size_t length = strlen(name);
    if (near->length < 2 || near->length > LENGTH_MAX || length > LENGTH_MAX) {
        return;
    }
    const size_t distance =
        strncmp(name, near->wanted, near->length) == 0 ? 1 : measure(near->wanted, near->length, name, length);
    if (distance < near->distance && distance < length) {
        near->distance = distance;
        near->best = name;
    }
}

static suggestion_text write_words(const suggestion *near, const char *dashes)
{
    suggestion_text words = {""};
    if (near->best != NULL) {
        (void)snprintf(words.text, sizeof words.text, ", did you mean '%s%s'?", dashes, near->best);
    }
    return words;
}

suggestion_text suggestion_end(const suggestion *near)
{
    return write_words(near, "");
}

suggestion_text suggestion_end_option(const suggestion *near)
{
    return write_words(near, "--");
}
