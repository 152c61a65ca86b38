/* SPDX-License-Identifier: MIT */
/* The programs of the compute shaders: compiled on first use, one per entry point and set of defines. */
#ifndef SVO_GLINTEROP_COMPUTE_PROGRAM_H
#define SVO_GLINTEROP_COMPUTE_PROGRAM_H

#include "compute/compute.h"

/* The entry points of glinterop/shaders/, in the order of the table in compute_program.c. */
typedef enum svo_i_entry {
    SVO_I_ENTRY_MARK,
    SVO_I_ENTRY_DESCEND,
    SVO_I_ENTRY_SCAN_MASKS_REDUCE,
    SVO_I_ENTRY_SCAN_MASKS_PARTIALS,
    SVO_I_ENTRY_SCAN_MASKS_ADD,
    SVO_I_ENTRY_COUNT,
    SVO_I_ENTRY_SCAN_LISTS_REDUCE,
    SVO_I_ENTRY_SCAN_LISTS_PARTIALS,
    SVO_I_ENTRY_SCAN_LISTS_ADD,
    SVO_I_ENTRY_SCATTER,
    SVO_I_ENTRY_SORT_SHORT,
    SVO_I_ENTRY_SORT_LONG,
    SVO_I_ENTRY_MATERIAL_SCATTER,
    SVO_I_ENTRY_MATERIAL_LEAVES,
    SVO_I_ENTRY_MATERIAL_PASS,
    SVO_I_ENTRY_MATERIAL_MERGE,
    SVO_I_ENTRY_LINK,
    SVO_I_ENTRY_GATHER_LEVEL,
    SVO_I_ENTRY_GATHER,
    SVO_I_ENTRY_FILTER,
    SVO_I_ENTRIES
} svo_i_entry;

/* Storage blocks an entry point has at most. */
#define SVO_I_COMPUTE_BLOCKS 15
/* The binding after them, which every launch has: whether loops were cut short (shaders/compute.glsl). */
#define SVO_I_COMPUTE_EXHAUSTED 15
#define SVO_I_COMPUTE_BINDINGS  SVO_I_GL_STATE_STORAGE_BINDINGS
/* Fields of the larger of the two kinds of parameters that shaders read. */
#define SVO_I_COMPUTE_FIELDS 13

/* An entry point compiled for a plan's keys. */
typedef struct svo_i_compute_program svo_i_compute_program;
struct svo_i_compute_program {
    svo_i_compute_program *next;
    svo_i_entry entry;
    char defines[SVO_I_DEFINES_BYTES];
    GLuint name;
    GLint fields[SVO_I_COMPUTE_FIELDS]; /* uniform locations; -1: not read */
    GLint vertex_count;
};

/* The calls below expect the context current. */

/* Takes the plan's keys and compiles what every build of it needs. */
svo_status svo_i_compute_prepare(svo_i_compute *compute, const svo_plan *plan);
/* The entry point by the keys of the plan; compiled, and launched once on nothing, on first use. */
svo_status svo_i_compute_program_get(svo_i_compute *compute, svo_i_entry entry, svo_i_compute_program **out);
void svo_i_compute_programs_destroy(svo_i_compute *compute);
/* Sets the parameters' uniforms of the program in use; NULL means zeros. */
void svo_i_compute_program_set(const svo_i_compute *compute, const svo_i_compute_program *program, const void *params);

#endif
