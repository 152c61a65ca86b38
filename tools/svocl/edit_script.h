/* SPDX-License-Identifier: MIT */
/* Scripts of svocl edit: a step on each line. docs/edit.md has their words. */
#ifndef SVOCL_TOOLS_SVOCL_EDIT_SCRIPT_H
#define SVOCL_TOOLS_SVOCL_EDIT_SCRIPT_H

#include <stdbool.h>

#include "support/program.h"
#include "svocl/edit.h"
#include "svocl/solid.h"

#define SCRIPT_WORDS_MAX 32

typedef enum script_action {
    SCRIPT_END = 0, /* no further step */
    SCRIPT_APPLY,
    SCRIPT_COPY,
    SCRIPT_UNDO,
    SCRIPT_REDO
} script_action;

/* How a mesh becomes voxels: turned about the origin, scaled, then moved. */
typedef struct script_mesh {
    svo_solid_rule rule;
    double scale;
    double turn[3][3]; /* rows */
    double at[3];
} script_mesh;

typedef struct script_step {
    script_action action;
    svo_edit_step step; /* of apply; of copy, the region */
    const char *file; /* of SVO_EDIT_VOXELS; in the script's text */
    bool is_mesh; /* the file is one of a mesh, whose voxels are those of a step with SVO_EDIT_VOXELS */
    script_mesh mesh;
    bool has_color; /* the line names one */
    int32_t offset[3]; /* of copy */
    uint32_t count; /* of undo and redo */
} script_step;

/* A script that is read. */
typedef struct edit_script {
    const char *path;
    char *text; /* owned */
    char *next; /* the line to come */
    unsigned line; /* the number of the last one, from 1 on */
    char *words[SCRIPT_WORDS_MAX]; /* of it */
    unsigned word_count;
    unsigned word; /* the next one */
} edit_script;

/* Reads the whole file. Returns the exit code. */
int edit_script_open(program *state, const char *path, edit_script *script);
void edit_script_close(edit_script *script);

/* Reads the next step. Returns the exit code. */
int edit_script_next(program *state, edit_script *script, script_step *out);

/* program_fail with the script's name and line in front. */
int edit_script_fail(program *state, const edit_script *script, int exit_code, const char *words);

#endif
