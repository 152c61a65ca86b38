/* SPDX-License-Identifier: MIT */
/* A program that uses svocl::io alone: proves that the installed pkg-config file suffices to link and run it. */
#include <stdio.h>

#include "svocl/io.h"

int main(void)
{
    svo_tree *tree = NULL;
    svo_message message = {""};
    const svo_status status = svo_tree_load("no such file.svo", &tree, &message);
    printf("%s\n", svo_status_name(status));
    return status == SVO_FILE_ERROR ? 0 : 1;
}
