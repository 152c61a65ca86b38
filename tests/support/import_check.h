/* SPDX-License-Identifier: MIT */
/* Imports of files in the work folder, and what they must say. */
#ifndef SVOCL_TESTS_IMPORT_CHECK_H
#define SVOCL_TESTS_IMPORT_CHECK_H

#include "svocl/io.h"

/* Imports; a failure is the test's. The caller destroys what they return. */
svo_import *import_named(const char *name);
svo_import *import_with(const char *name, const svo_import_options *options);
svo_import *import_text(const char *name, const char *text);

/* Of the last import: this text is in its warnings; there is none. */
void expect_warning(const char *text);
void expect_no_warning(void);

/* The import fails with a message that has this text. options: NULL allowed. */
void expect_refused(const char *name, const svo_import_options *options, const char *text);

#endif
