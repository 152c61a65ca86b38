/* SPDX-License-Identifier: MIT */
/*
 * A program that uses svocl::io alone: proves that the installed pkg-config file suffices to link and run it. With the
 * paths of a mesh file and of the installed helper it imports: main has no hook for imports through itself.
 */
#include <stdio.h>
#include <string.h>

#include "svocl/io.h"

static int import(const char *path, const char *helper)
{
    svo_import *import = NULL;
    svo_message message = {""};
    char found[4096] = "";
    if (svo_import_helper(found, sizeof found, &message) != SVO_OK || strcmp(found, helper) != 0) {
        printf("the helper is \"%s\", expected \"%s\": %s\n", found, helper, message.text);
        return 1;
    }
    const svo_status status = svo_import_file(path, NULL, NULL, NULL, &import, &message);
    printf("%s %s\n", svo_name(SVO_NAME_STATUS, status), message.text);
    svo_import_destroy(&import);
    return status == SVO_OK ? 0 : 1;
}

int main(int argc, char **argv)
{
    if (argc == 3) {
        return import(argv[1], argv[2]);
    }
    svo_tree *tree = NULL;
    svo_message message = {""};
    const svo_status status = svo_tree_load(svo_from_path("no such file.svo"), NULL, &tree, &message);
    printf("%s\n", svo_name(SVO_NAME_STATUS, status));
    return status == SVO_FILE_ERROR ? 0 : 1;
}
