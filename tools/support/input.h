/* SPDX-License-Identifier: MIT */
/* INPUT of a command: a mesh file, a generated scene, a voxel file, or the file of a tree. */
#ifndef SVOCL_TOOLS_SUPPORT_INPUT_H
#define SVOCL_TOOLS_SUPPORT_INPUT_H

#include <stdbool.h>

#include "scenes/scenes.h"
#include "support/cleanup.h"
#include "support/program.h"
#include "support/voxel_input.h"
#include "svocl/compact.h"
#include "svocl/io.h"

/* ---- temporary files ---- */

/* A temporary file with a name of a given suffix, for readers and writers that need one. A signal that ends the program
   removes it. Stays where it is while it exists. */
typedef struct spool_file {
    char path[4096];
    svo_i_output target;
    cleanup_entry entry;
} spool_file;

/* Makes an empty file in $TMPDIR, or in /tmp. Returns the exit code; after a failure there is nothing to remove. */
int spool_open(program *state, const char *suffix, spool_file *spool);
void spool_remove(spool_file *spool);

/* ---- compact trees ---- */

/* Whether a name, or the suffix that the bytes of a pipe are given, is that of a compact tree. */
bool compact_input_is_name(const char *name);

/* Loads the compact tree of a file. *out has host arrays and is on no device. Returns the exit code. */
int compact_input_load(program *state, svo_source source, svo_compact **out);

/* ---- inputs ---- */

/* Triangles that the library refuses, and why. */
typedef struct refused_triangles {
    uint64_t bad_index_count, first_bad_index; /* an index out of range; the first such triangle */
    uint64_t not_finite_count, first_not_finite; /* a coordinate that is infinite or not a number */
} refused_triangles;

typedef struct input {
    const char *name;
    const svo_mesh *mesh; /* has at least one triangle; NULL: voxels are given */
    voxel_input voxels; /* of a voxel file */
    double import_ms; /* wall-clock time of reading or generating */
    refused_triangles refused;
    svo_import *import; /* of a mesh file, else NULL */
    svo_import_info import_info; /* of a mesh file */
    scene *made; /* of scene:..., else NULL */
} input;

/* Reads INPUT if it is standard input or a pipe, to its end; messages then call it by piped.name. To be called once,
   before the command. Returns the exit code. */
int input_begin(program *state);

/* Whether INPUT is a finished tree, judged by its suffix .svo or .svc or, from a pipe, by its bytes. Build options are
   then wrong usage. */
bool input_is_tree(const program *state);
/* Whether it is a folder of parts, which counts as a finished tree. */
bool input_is_parts(const program *state);
/* Whether that tree is a compact one. */
bool input_is_compact(const program *state);
int input_refuse_build_options(program *state);
/* The same where the tree is read on the host: options of the device neither, unless a compact one is expanded
   there. */
int input_refuse_device_options(program *state);

/* Whether INPUT is a mesh file: no scene, pipe, tree or voxel file. */
bool input_is_mesh_file(const program *state);

/* Reads or generates the mesh; one step of the progress bar. Returns the exit code; on failure nothing stays open. */
int input_open(program *state, input *opened);
/* The same, or reads the voxels of a voxel file, whose tree can have need (svo_need bits). */
int input_open_any(program *state, uint32_t need, input *opened);
void input_close(input *opened);

/* Loads the tree that input names; a compact one is expanded. Returns the exit code. */
int input_load_tree(program *state, svo_tree **out);

/* Loads the compact tree that input names, as it is. Returns the exit code. */
int input_load_compact(program *state, svo_compact **out);

/* The length of INPUT, a file or a pipe that was read. Returns the exit code. */
int input_measure(program *state, uint64_t *byte_count);

/* Milliseconds of a monotonic clock. */
double input_now_ms(void);
/* Milliseconds of the process on all processors, which others that use the machine change little. */
double input_cpu_ms(void);

#endif
