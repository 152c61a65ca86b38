/* SPDX-License-Identifier: MIT */
/* Group setup and teardown of tests that need a fixture and a folder for files. */
#ifndef SVOCL_TESTS_FIXTURE_FOLDER_H
#define SVOCL_TESTS_FIXTURE_FOLDER_H

#include "fixture.h"
#include "work_folder.h"

static inline int fixture_folder_setup(void **state)
{
    return work_folder_make(state) == 0 ? fixture_group_setup(state) : -1;
}

static inline int fixture_folder_teardown(void **state)
{
    const int removed = work_folder_remove(state);
    return fixture_group_teardown(state) == 0 ? removed : -1;
}

#endif
