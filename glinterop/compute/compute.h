/* SPDX-License-Identifier: MIT */
/*
 * Compute shaders of one context: programs compiled on first use, buffers, launches, and the time they take. What the
 * GL compute builder (build.h) stands on, as the OpenCL stages stand on lib/build.h.
 */
#ifndef SVO_GLINTEROP_COMPUTE_COMPUTE_H
#define SVO_GLINTEROP_COMPUTE_COMPUTE_H

#include "build/build.h"
#include "context/context.h"

/* svo_gl_build's name, for messages. */
#define SVO_I_GL_BUILD "svo_gl_build"

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

typedef struct svo_i_compute {
    svo_device *device;
    svo_gl_context *context;
    const svo_i_gl_functions *gl;
    bool int64; /* the shaders have 64-bit integers */
    bool has_timer; /* the context's timer queries can be believed */
    svo_i_compute_program *programs;
    char defines[SVO_I_DEFINES_BYTES]; /* of the plan being built */
    GLuint queries[2]; /* begin and end of a stage */
    double stage_start_ms;
    GLuint exhausted; /* one word */
} svo_i_compute;

/* no_int64: as if the context had no 64-bit integers. Compiles nothing yet. SVO_GL_ERROR, SVO_OUT_OF_HOST_MEMORY. */
svo_status svo_i_compute_create(svo_device *device, svo_gl_context *context, bool no_int64, svo_i_compute **out);
void svo_i_compute_destroy(svo_i_compute **compute);
/* Why a tree with these needs (svo_need bits) cannot be built by this context: "" if it can. */
void svo_i_compute_reason(const svo_gl_context *context, bool no_int64, uint32_t need, char *reason,
                          size_t reason_bytes);

/* The calls below expect the context current. */

/* Takes the plan's keys and compiles what every build of it needs. */
svo_status svo_i_compute_prepare(svo_i_compute *compute, const svo_plan *plan);
/* compute_program.c: the entry point by the keys of the plan; compiled, and launched once on nothing, on first use. */
svo_status svo_i_compute_program_get(svo_i_compute *compute, svo_i_entry entry, svo_i_compute_program **out);
void svo_i_compute_programs_destroy(svo_i_compute *compute);
/* compute_program.c: sets the parameters' uniforms of the program in use; NULL means zeros. */
void svo_i_compute_program_set(const svo_i_compute *compute, const svo_i_compute_program *program, const void *params);

/* A storage block of bytes, undefined or all zero. SVO_UNSUPPORTED naming it where it is above the context's limit,
   SVO_OUT_OF_DEVICE_MEMORY where OpenGL has no memory left. */
svo_status svo_i_compute_alloc(svo_i_compute *compute, const char *name, uint64_t bytes, GLuint *out);
svo_status svo_i_compute_alloc_zero(svo_i_compute *compute, const char *name, uint64_t bytes, GLuint *out);
svo_status svo_i_compute_upload(svo_i_compute *compute, const char *name, const void *data, uint64_t bytes,
                                GLuint *out);
void svo_i_compute_fill_zero(const svo_i_compute *compute, GLuint buffer);
/* 0 is allowed. */
void svo_i_compute_free(const svo_i_compute *compute, GLuint *buffer);
/* Waits, and reads bytes from the start of the buffer. */
svo_status svo_i_compute_read(svo_i_compute *compute, GLuint buffer, void *to, size_t bytes);
/* Waits, and copies bytes from the start of the buffer into a new buffer of OpenCL, which the plan lists. */
svo_status svo_i_compute_to_cl(svo_i_compute *compute, svo_i_build *build, GLuint buffer, const char *name,
                               uint64_t offset, uint64_t bytes, cl_mem *out);

/* One dispatch, ordered after all before it. */
typedef struct svo_i_launch {
    svo_i_entry entry;
    GLuint buffers[SVO_I_COMPUTE_BLOCKS]; /* by binding; 0: the variant does not have it */
    const void *params; /* svo_subdivide_params or svo_filter_params, by entry point */
    uint32_t vertex_count; /* for those that read attributes */
    uint64_t items; /* nothing is launched for none; not read with indirect */
    GLuint indirect; /* not 0: the groups to launch are in this buffer, from word indirect_word on */
    uint32_t indirect_word;
} svo_i_launch;
svo_status svo_i_compute_launch(svo_i_compute *compute, const svo_i_launch *launch);

/* Waits; whether a launch since the last call ended some loop before its time, so that its results are void. */
svo_status svo_i_compute_exhausted(svo_i_compute *compute, bool *exhausted);

/* Work between begin and end is waited for and counted to the stage. */
void svo_i_compute_stage_begin(svo_i_compute *compute);
svo_status svo_i_compute_stage_end(svo_i_compute *compute, svo_i_build *build, svo_stage stage);

#endif
