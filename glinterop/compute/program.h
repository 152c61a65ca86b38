/* SPDX-License-Identifier: MIT */
/* The programs of the compute shaders: compiled on first use, one per entry point and set of defines. */
#ifndef SVO_GLINTEROP_COMPUTE_PROGRAM_H
#define SVO_GLINTEROP_COMPUTE_PROGRAM_H

#include "compute/compute.h"

/* The entry points of compute/shaders/, in the order of the table in program.c. */
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
    SVO_I_ENTRY_AREA,
    SVO_I_ENTRY_ROUND_AREAS,
    SVO_I_ENTRIES
} svo_i_entry;

/* The most storage blocks of an entry point. */
#define SVO_I_COMPUTE_BLOCKS 15
/* The binding after them, used by every launch: svo_i_compute.exhausted. */
#define SVO_I_COMPUTE_EXHAUSTED 15
#define SVO_I_COMPUTE_BINDINGS  SVO_I_GL_STATE_STORAGE_BINDINGS
/* Fields of svo_filter_params, the larger of the two parameter records. */
#define SVO_I_COMPUTE_FIELDS 14

/* An entry point compiled for a plan's defines. */
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

/* Takes the plan's defines and compiles the programs that every build of the plan needs. */
svo_status svo_i_compute_prepare(svo_i_compute *compute, const svo_plan *plan);
/* The entry point for the plan's defines. Compiles it on first use and launches it once on zeros. */
svo_status svo_i_compute_program_get(svo_i_compute *compute, svo_i_entry entry, svo_i_compute_program **out);
void svo_i_compute_programs_destroy(svo_i_compute *compute);
/* Sets the parameters' uniforms of the program in use. params: NULL means zeros. */
void svo_i_compute_program_set(const svo_i_compute *compute, const svo_i_compute_program *program, const void *params);

#endif
