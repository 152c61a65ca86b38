/* SPDX-License-Identifier: MIT */
/* The helper program of imports, svocl-import: does what svo_import_file asks it for, and nothing without that. */
#include <stdio.h>

#include "svocl/io.h"

int main(int argc, char **argv)
{
    int exit_code = 2;
    if (svo_import_child_main(argc, argv, &exit_code) == 0) {
        (void)fputs("svocl-import: reads a mesh file for svo_import_file, which starts it\n", stderr);
    }
    return exit_code;
}
