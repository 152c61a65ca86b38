/* SPDX-License-Identifier: MIT */
/*
 * The builder's compute shaders in one context: storage blocks, programs, launches, and what the stages share; build.h
 * and payload.h make a tree with them.
 *
 * The files of this room:
 *
 *   compute   storage blocks, programs and launches
 *   decide    what rasterization leaves undecided
 *   windows   windows of arrays that exceed a storage block, exclusive sums
 *   surface   the mesh's attributes, and launches that read them
 *   material  materials
 *   payload   areas, colors, normals and fills, and all payload
 *   build     nodes and lists of leaves, and the whole build
 */
#ifndef SVO_GLINTEROP_COMPUTE_COMPUTE_H
#define SVO_GLINTEROP_COMPUTE_COMPUTE_H

#include "context/context.h"
#include "plan/plan_data.h"
#include "stages/build_state.h"

/* The public function's name, for messages. */
#define SVO_I_GL_BUILD "svo_gl_build"

typedef struct svo_i_compute {
    svo_device *device;
    svo_gl_context *context;
    const svo_i_gl_functions *gl;
    bool has_timer; /* the context's timer queries are reliable */
    struct svo_i_compute_program *programs;
    char defines[SVO_I_DEFINES_BYTES]; /* of the plan being built */
    GLuint queries[2]; /* begin and end of a stage */
    double stage_start_ms;
    GLuint exhausted; /* one word: not 0 after a launch whose loops were cut short (shaders/compute.glsl) */
} svo_i_compute;

/* Storage blocks. All functions expect the context current. */

/* The most bytes of an array that a launch can bind. */
uint64_t svo_i_compute_range_max(const svo_i_compute *compute);
/* Create a storage block: undefined, all zero, or filled from the host. SVO_UNSUPPORTED naming the block when it is
   above the context's limit, SVO_OUT_OF_DEVICE_MEMORY when OpenGL has no memory left. */
svo_status svo_i_compute_alloc(svo_i_compute *compute, const char *name, uint64_t bytes, GLuint *out);
svo_status svo_i_compute_alloc_zero(svo_i_compute *compute, const char *name, uint64_t bytes, GLuint *out);
svo_status svo_i_compute_upload(svo_i_compute *compute, const char *name, const void *data, uint64_t bytes,
                                GLuint *out);
void svo_i_compute_fill_zero(const svo_i_compute *compute, GLuint buffer);
/* Create an array of any size, of which launches bind ranges. */
svo_status svo_i_compute_alloc_array(svo_i_compute *compute, const char *name, uint64_t bytes, GLuint *out);
svo_status svo_i_compute_alloc_array_zero(svo_i_compute *compute, const char *name, uint64_t bytes, GLuint *out);
/* *buffer: 0 allowed; set to 0. */
void svo_i_compute_free(const svo_i_compute *compute, GLuint *buffer);
/* Waits, then reads bytes from the start of the buffer, or from an offset. */
svo_status svo_i_compute_read(svo_i_compute *compute, GLuint buffer, void *to, size_t bytes);
svo_status svo_i_compute_read_at(svo_i_compute *compute, GLuint buffer, uint64_t offset, void *to, size_t bytes);
/* Writes bytes from an offset of the buffer on. */
void svo_i_compute_write_at(svo_i_compute *compute, GLuint buffer, uint64_t offset, const void *from, size_t bytes);
/* Copies bytes from the start of a buffer to an offset of another. */
svo_status svo_i_compute_copy(svo_i_compute *compute, GLuint from, GLuint to, uint64_t offset, uint64_t bytes);
/* Waits, then copies bytes from an offset of the buffer to a new OpenCL buffer, which the plan lists. */
svo_status svo_i_compute_to_cl(svo_i_compute *compute, svo_i_build *build, GLuint buffer, const char *name,
                               uint64_t offset, uint64_t bytes, cl_mem *out);

/* The programs of the compute shaders: compiled on first use, one per entry point and set of defines. */

/* The entry points of compute/shaders/, in the order of the table in compute.c. */
typedef enum svo_i_entry {
    SVO_I_ENTRY_DECIDE,
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
    SVO_I_ENTRY_MATERIAL_ROOM,
    SVO_I_ENTRY_MATERIAL_MERGE,
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
    GLint first[SVO_I_COMPUTE_BLOCKS];
    GLint window_begin, window_count;
    GLint vertex_count, first_triangle, triangle_count, texel_block_log2;
};

/* The calls below expect the context current. */

/* Takes the plan's defines and compiles the programs that every build of the plan needs. */
svo_status svo_i_compute_prepare(svo_i_compute *compute, const svo_plan *plan);
/* The entry point for the plan's defines. Compiles it on first use and launches it once on zeros. */
svo_status svo_i_compute_program_get(svo_i_compute *compute, svo_i_entry entry, svo_i_compute_program **out);

/* Launches compute shaders and times them. All functions expect the context current. */

/* What a launch binds of an array. bytes 0: the whole buffer. */
typedef struct svo_i_range {
    uint64_t begin_bytes, bytes;
    bool local; /* the buffer holds this range alone, with room for SVO_I_RANGE_SLACK more bytes */
} svo_i_range;
#define SVO_I_RANGE_SLACK 256

/* The elements from begin to end. */
svo_i_range svo_i_range_of(uint64_t begin, uint64_t end, unsigned element_bytes);

/* A part of the mesh, for entry points that read its attributes. */
typedef struct svo_i_launch_mesh {
    uint32_t vertex_count;
    uint32_t first_triangle, triangle_count;
    uint32_t texel_block_log2;
} svo_i_launch_mesh;

/* One dispatch. It starts after all earlier ones have finished. */
typedef struct svo_i_launch {
    svo_i_entry entry;
    GLuint buffers[SVO_I_COMPUTE_BLOCKS]; /* by binding; 0: not bound, since the variant does not read it */
    svo_i_range ranges[SVO_I_COMPUTE_BLOCKS];
    const void *params; /* svo_subdivide_params or svo_filter_params, by entry point */
    svo_i_launch_mesh mesh;
    uint32_t window_begin, window_count; /* the nodes or leaves whose elements the ranges hold */
    uint64_t items; /* 0: launches nothing. Ignored with indirect. */
    GLuint indirect; /* not 0: this buffer has the numbers of groups, from word indirect_word on */
    uint32_t indirect_word;
} svo_i_launch;
svo_status svo_i_compute_launch(svo_i_compute *compute, const svo_i_launch *launch);

/* Waits. *exhausted: whether the driver cut a loop short since the last call, which makes the results invalid. */
svo_status svo_i_compute_exhausted(svo_i_compute *compute, bool *exhausted);

/* Waits for the work between begin and end, and adds its time to the stage. */
void svo_i_compute_stage_begin(svo_i_compute *compute);
svo_status svo_i_compute_stage_end(svo_i_compute *compute, svo_i_build *build, svo_stage stage);

/*
 * What the stages of one build by compute shaders share. Each stage is the twin of the OpenCL stage of the same name in
 * lib/stages. build.c runs them in order.
 */

typedef struct svo_i_gl_build {
    svo_i_build *build;
    svo_i_compute *compute;
    /* Scratch. */
    GLuint *cursors; /* one per chunk */
    GLuint state, partials;
    /* The tree being built; 0 for an array that it does not have. */
    GLuint arrays[SVO_TREE_BUFFER_COUNT];
} svo_i_gl_build;

/* The OpenGL buffer of a chunk of the list. */
GLuint svo_i_gl_chunk(const svo_i_gl_build *gl_build, uint32_t chunk);

/* SVO_UNSUPPORTED when the driver has cut a loop short since the last check. what: the work, for the message. */
svo_status svo_i_gl_check_loops(svo_i_gl_build *gl_build, const char *what);

/* Creates and destroys the builder, and reports whether a context can build. */

/* Compiles nothing yet. Returns SVO_GL_ERROR or SVO_OUT_OF_HOST_MEMORY on failure. */
svo_status svo_i_compute_create(svo_device *device, svo_gl_context *context, svo_i_compute **out);
void svo_i_compute_destroy(svo_i_compute **compute);
/* Writes to reason why this context cannot build a tree with these needs (svo_need bits), or "" if it can. no_int64: as
   if the context had no 64-bit integers. */
void svo_i_compute_reason(const svo_gl_context *context, bool no_int64, uint32_t need, char *reason,
                          size_t reason_bytes);

#endif
