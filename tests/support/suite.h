/* SPDX-License-Identifier: MIT */
/*
 * A test program of several files. A file's cases are a group, TEST_GROUP(name), whose body is what main() would be: it
 * runs the group by cmocka and returns the number of failures. svocl_test in tests/CMakeLists.txt lists the groups of a
 * program. Without arguments it runs them all; arguments select one group, and of that one case:
 *
 *     test_rays [GROUP [CASE]]
 *
 * In the name of a case, * stands for any letters. Groups after NAMED in svocl_test run only when they are named.
 */
#ifndef SVOCL_TESTS_SUITE_H
#define SVOCL_TESTS_SUITE_H

#include <stdbool.h>

#define TEST_GROUP(name)         \
    int test_group_##name(void); \
    int test_group_##name(void)

/* Whether tests run in their long forms: SVOCL_LONG_TESTS, of tools/dev long. */
bool suite_is_long(void);

/* The program's main(), for those that do something before it; they have SUITE_OWN_MAIN in CMake. */
int suite_run(int argc, char **argv);

#endif
