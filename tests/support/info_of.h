/* SPDX-License-Identifier: MIT */
/* What a handle is, as a value: for tests that want one field of it. */
#ifndef SVOCL_TESTS_INFO_OF_H
#define SVOCL_TESTS_INFO_OF_H

#include "../../tools/support/info_of.h"

#endif
