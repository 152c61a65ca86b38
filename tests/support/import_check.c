/* SPDX-License-Identifier: MIT */
#include "import_check.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdio.h>
#include <string.h>

#include "work_folder.h"

#define WARNINGS_BYTES 4096

static char warnings[WARNINGS_BYTES]; /* of the last import, one a line */

static void keep_warning(void *user, svo_log_level level, const char *text)
{
    (void)user;
    assert_int_equal(level, SVO_LOG_WARNING);
    const size_t used = strlen(warnings);
    (void)snprintf(warnings + used, sizeof warnings - used, "%s\n", text);
}

svo_import *import_with(const char *name, const svo_import_options *options)
{
    svo_import *import = NULL;
    svo_message message = {""};
    warnings[0] = '\0';
    if (svo_import_file(path_of(name), options, keep_warning, NULL, &import, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    return import;
}

svo_import *import_named(const char *name)
{
    return import_with(name, NULL);
}

svo_import *import_text(const char *name, const char *text)
{
    write_text(name, text);
    return import_named(name);
}

void expect_warning(const char *text)
{
    if (strstr(warnings, text) == NULL) {
        fail_msg("warnings are \"%s\", expected \"%s\" among them", warnings, text);
    }
}

void expect_no_warning(void)
{
    assert_string_equal(warnings, "");
}

void expect_refused(const char *name, const svo_import_options *options, const char *text)
{
    svo_import *import = NULL;
    svo_message message = {""};
    const svo_status status = svo_import_file(path_of(name), options, NULL, NULL, &import, &message);
    if (status != SVO_IMPORT_FAILED || strstr(message.text, text) == NULL) {
        fail_msg("%s: %s \"%s\", expected \"%s\"", name, svo_name(SVO_NAME_STATUS, status), message.text, text);
    }
    assert_null(import);
}
