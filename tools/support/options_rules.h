/* SPDX-License-Identifier: MIT */
/* The table of options. The parser, the help, the manual pages and the completion of shells are made from it. */
#ifndef SVOCL_TOOLS_SUPPORT_OPTIONS_RULES_H
#define SVOCL_TOOLS_SUPPORT_OPTIONS_RULES_H

#include <stddef.h>

#include "support/program.h"

typedef struct choice {
    const char *name;
    int value;
} choice;

typedef struct rule rule;
struct rule {
    const char *name;
    char letter; /* '\0': no short form */
    uint64_t group;
    const char *value_name; /* NULL: a flag; FILE and DIR are paths, LIST has commas */
    int (*read)(program *state, const rule *option, const char *value);
    size_t offset; /* of the field in options */
    uint64_t minimum, maximum; /* of a count */
    const choice *choices; /* the names that a value may have: ends with a NULL name; NULL: any value */
    const char *help;
};

/* The options in the order of the help; NULL past the last. */
const rule *options_rule(size_t index);

/* Whether a command takes the option. */
bool options_apply(const rule *option, const command *which);

#endif
