/* SPDX-License-Identifier: MIT */
/* The svocl program: finds the command and runs it. */
#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>

#include "scenes/scenes.h"
#include "support/options_parse.h"
#include "support/table.h"
#include "svocl/commands.h"
#include "svocl/io.h"
#include "svocl/version.h"

#define BUILDS (OPTION_DEVICE | OPTION_BUILD | OPTION_JSON)

static const command commands[] = {
    {"devices", command_devices, OPTION_JSON, NULL, false,
     "Lists OpenCL devices, OpenGL renderers and which methods work on each pair."},
    {"scene", command_scene, OPTION_SCENE_COMMAND | OPTION_OUTPUT | OPTION_JSON, "NAME", false,
     "Writes a procedural scene as .obj or .ply; without NAME, lists the scenes."},
    {"build", command_build, BUILDS | OPTION_OUTPUT | OPTION_BUILD_COMMAND, "INPUT", true,
     "Builds the octree of a mesh and reports the time of each stage."},
    {"info", command_info, OPTION_JSON, "FILE.svo", true, "Checks a .svo file and prints what it contains."},
    {"hash", command_hash, BUILDS | OPTION_HASH_COMMAND, "INPUT", true,
     "Prints the hash of a mesh's octree, or of a .svo file."},
    {"verify", command_verify, BUILDS, "INPUT", true, "Builds the octree and compares it with the exact reference."},
    {"render", command_render, BUILDS | OPTION_OUTPUT | OPTION_PICTURE_SIZE | OPTION_RENDER_COMMAND, "INPUT", true,
     "Renders the octree of a mesh, or a .svo file, as a PNG image."},
    {"trace", command_trace, BUILDS | OPTION_OUTPUT | OPTION_PICTURE_SIZE | OPTION_TRACE_COMMAND, "INPUT", true,
     "Traces rays from a file or a camera against the triangles of a mesh or of a .svo file."},
    {"stress", command_stress, OPTION_DEVICE | OPTION_METHODS | OPTION_STRESS_COMMAND | OPTION_JSON, NULL, false,
     "Tests ill-conditioned and extreme inputs, compared with common float32 methods."},
    {"bench", command_bench, BUILDS | OPTION_BENCH_COMMAND | OPTION_MEASURE | OPTION_OUTPUT, "SUBJECT [INPUT]", false,
     "Measures times or errors of one SUBJECT or of all; bench --help lists them."},
    {"report", command_report, OPTION_DEVICE | OPTION_MEASURE | OPTION_REPORT_COMMAND | OPTION_OUTPUT, NULL, false,
     "Writes all measurements as a page with charts, tables and pictures into the folder -o DIR."},
};

#define COMMAND_COUNT (sizeof commands / sizeof commands[0])

static void print_help(void)
{
    printf("svocl %s: exact sparse voxel octrees of triangle meshes\n\nusage: svocl COMMAND [options]\n\n",
           svo_version_string());
    table *rows = table_create("ll");
    for (size_t i = 0; i < COMMAND_COUNT; ++i) {
        table_cell(rows, "%s", commands[i].name);
        table_cell(rows, "%s", commands[i].summary);
    }
    table_print(rows);
    fputs("\nINPUT is a mesh file (OBJ, PLY, STL, glTF, ...), a .svo file where no build is\n"
          "needed, or a generated scene, scene:NAME[:triangles[:seed]], with NAME one of\n ",
          stdout);
    for (size_t i = 0; scene_describe(i) != NULL; ++i) {
        printf("%s%s", i == 0 ? " " : ", ", scene_describe(i)->name);
    }
    puts(".\n\nOptions of a command: svocl COMMAND --help\nExit code: 0 done, 1 failed, 2 wrong usage");
}

static const command *find_command(const char *name)
{
    for (size_t i = 0; i < COMMAND_COUNT; ++i) {
        if (strcmp(commands[i].name, name) == 0) {
            return &commands[i];
        }
    }
    return NULL;
}

static void print_command_help(const command *which)
{
    options_print_help(which);
    if (which->run == command_bench) {
        command_bench_print_subjects();
    }
}

static int run_command(program *state, const command *which, int argument_count, char **arguments)
{
    state->command = which->name;
    int exit_code = options_parse(state, which, argument_count, arguments);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    if (state->options.help) {
        print_command_help(which);
        return PROGRAM_DONE;
    }
    exit_code = which->run(state);
    progress_destroy(&state->progress);
    program_end_warnings(state, exit_code != PROGRAM_DONE);
    return exit_code;
}

static int dispatch(program *state, int argument_count, char **arguments)
{
    const char *name = argument_count > 1 ? arguments[1] : "";
    if (strcmp(name, "--help") == 0 || strcmp(name, "-h") == 0 || (strcmp(name, "help") == 0 && argument_count == 2)) {
        print_help();
        return PROGRAM_DONE;
    }
    if (strcmp(name, "--version") == 0) {
        printf("svocl %s\n", svo_version_string());
        return PROGRAM_DONE;
    }
    if (strcmp(name, "help") == 0) {
        const command *which = find_command(arguments[2]);
        if (which != NULL) {
            print_command_help(which);
            return PROGRAM_DONE;
        }
        name = arguments[2];
    }
    const command *which = find_command(name);
    if (which == NULL) {
        return name[0] == '\0'
                   ? program_fail(state, PROGRAM_WRONG_USAGE, "no command given, see svocl --help")
                   : program_fail(state, PROGRAM_WRONG_USAGE, "unknown command '%s', see svocl --help", name);
    }
    return run_command(state, which, argument_count - 2, arguments + 2);
}

int main(int argument_count, char **arguments)
{
    int exit_code = PROGRAM_DONE;
    if (svo_import_child_main(argument_count, arguments, &exit_code)) {
        return exit_code;
    }
#ifdef SIGXFSZ
    signal(SIGXFSZ, SIG_IGN); /* beyond a file size limit, write() then fails with a message instead of a signal */
#endif
    program state = {0};
    exit_code = dispatch(&state, argument_count, arguments);
    errno = 0;
    if ((fflush(stdout) != 0 || ferror(stdout)) && exit_code == PROGRAM_DONE) {
        exit_code = program_fail(&state, PROGRAM_FAILED, "standard output: %s",
                                 errno != 0 ? strerror(errno) : "a write failed");
    }
    return exit_code;
}
