/* SPDX-License-Identifier: MIT */
/* Runs the groups of a test program. CMake defines SUITE_GROUPS and SUITE_NAMED, lists of GROUP(name). */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "suite.h"

#define GROUP(name) int test_group_##name(void);
SUITE_GROUPS
SUITE_NAMED
#undef GROUP

static const struct {
    const char *name;
    int (*run)(void);
    bool named;
} groups[] = {
#define GROUP(name) {#name, test_group_##name, false},
    SUITE_GROUPS
#undef GROUP
#define GROUP(name) {#name, test_group_##name, true},
        SUITE_NAMED
#undef GROUP
};

enum { GROUP_COUNT = sizeof groups / sizeof groups[0] };

bool suite_is_long(void)
{
    return getenv("SVOCL_LONG_TESTS") != NULL;
}

static int usage(const char *program)
{
    (void)fprintf(stderr, "usage: %s [GROUP [CASE]], where GROUP is one of\n", program);
    for (size_t i = 0; i < GROUP_COUNT; ++i) {
        (void)fprintf(stderr, "    %s\n", groups[i].name);
    }
    return 2;
}

int suite_run(int argc, char **argv)
{
    const char *wanted = argc > 1 ? argv[1] : NULL;
    size_t found = 0;
    bool failed = false;
    if (argc == 3) {
        cmocka_set_test_filter(argv[2]);
    }
    for (size_t i = 0; argc <= 3 && i < GROUP_COUNT; ++i) {
        if (wanted != NULL ? strcmp(wanted, groups[i].name) == 0 : !groups[i].named) {
            failed = groups[i].run() != 0 || failed;
            ++found;
        }
    }
    return found == 0 ? usage(argv[0]) : failed ? 1 : 0;
}

#ifndef SUITE_OWN_MAIN
int main(int argc, char **argv)
{
    return suite_run(argc, argv);
}
#endif
