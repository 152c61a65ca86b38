/* SPDX-License-Identifier: MIT */
/* Files that the program writes: whole or not at all. */
#ifndef SVOCL_TOOLS_SUPPORT_OUTPUT_H
#define SVOCL_TOOLS_SUPPORT_OUTPUT_H

#include <stdbool.h>
#include <stdio.h>

#include "support/cleanup.h"
#include "support/program.h"
#include "svocl/compact.h"
#include "svocl/files.h"
#include "svocl/mesh.h"
#include "svocl/tree.h"

/* Stays where it is while it is open. */
typedef struct output_file {
    FILE *stream;
    const char *path; /* borrowed */
    svo_i_output target;
    cleanup_entry temporary;
    int error; /* errno of the first write that failed; 0: none */
} output_file;

/* What a file of voxels is, by its name and the options. */
typedef enum output_kind {
    OUTPUT_TREE = 0, /* .svo */
    OUTPUT_COMPACT, /* .svc: --tree-form or --solid asks for it */
    OUTPUT_VOXELS /* a format of svo_voxel_format_of_path */
} output_kind;
output_kind output_kind_of(const options *given, const char *path);

/* Whether a name ends in a suffix, in any case, behind something else. */
bool output_has_suffix(const char *path, const char *suffix);

/* What messages call the path: "standard output" for "-". */
const char *output_name(const char *path);

/*
 * To be called once, when the inputs of the command line are protected, with the path after -o: checks it, and that the
 * command writes files of its suffix with these options. Where it is "-" or leads to standard output, keeps that for
 * the file. What the program prints then goes to standard error. Returns the exit code.
 */
int output_begin(program *state, const command *which);

/* Fails where the suffix of a tree's file is that of another kind than the options ask for. needs: the options that the
   command takes for compact trees. */
int output_check_tree(program *state, const char *path, const char *needs);

/* This run reads path, "-" for standard input: no output may be that file. Fails where one is. */
int output_protect(program *state, const char *path);

/* Fails early if no file can be created at path, or if it is one that this run reads or writes: before long work, not
   after it. output_open checks the latter again. */
int output_check(program *state, const char *path);

int output_open(program *state, const char *path, output_file *file);
/* A write that fails shows in output_commit. */
void output_write(output_file *file, const void *bytes, size_t byte_count);
/* For a file that the library writes. */
svo_sink output_sink(output_file *file);
/* Hands all bytes to the system; false after a write that failed. */
bool output_flush(output_file *file);
/* Flushes, closes and gives the file its name; on failure nothing is left. */
int output_commit(program *state, output_file *file);
void output_abandon(output_file *file);

/* ---- trees ---- */

/* Writes compact, or tree where that is NULL, by --compress; both have host arrays. One step of the progress bar.
   Returns the exit code. */
int tree_output_write(program *state, const svo_tree *tree, const svo_compact *compact, const char *path);

/* ---- meshes ---- */

/* Writes a mesh as scenes.h describes, by the suffix in any case: .obj or PLY. An .obj file of a mesh with materials
   gets an .mtl file of the same name beside it. Returns the exit code; after a failure there is no new file. */
int mesh_output_write(program *state, const svo_mesh *mesh, const char *path);

#endif
