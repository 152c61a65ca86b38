/* SPDX-License-Identifier: MIT */
/* The program that reads a mesh file for svocl.read_mesh: svo_import_file starts it, with limits on memory and time. */
#include <stdio.h>

#include "svocl/io.h"

int main(int argc, char **argv)
{
    int exit_code = 2;
    if (svo_import_child_main(argc, argv, &exit_code) == 0)
        fprintf(stderr, "%s is started by svocl.read_mesh\n", argv[0]);
    return exit_code;
}
