/* SPDX-License-Identifier: MIT */
/* "did you mean": the known name that is nearest to a misspelled one. */
#ifndef SVOCL_TOOLS_SUPPORT_SUGGEST_H
#define SVOCL_TOOLS_SUPPORT_SUGGEST_H

#include <stddef.h>

typedef struct suggestion {
    const char *wanted; /* borrowed; not terminated */
    size_t length;
    const char *best; /* NULL: none is near */
    size_t distance; /* of best */
} suggestion;

typedef struct suggestion_text {
    char text[96];
} suggestion_text;

suggestion suggestion_begin(const char *wanted, size_t length);

/* name: lives as long as the suggestion. Of equally near names the first one counts. */
void suggestion_offer(suggestion *near, const char *name);

/* ", did you mean 'name'?", or "" where none is near; the second: of an option, '--name'. */
suggestion_text suggestion_end(const suggestion *near);
suggestion_text suggestion_end_option(const suggestion *near);

#endif
