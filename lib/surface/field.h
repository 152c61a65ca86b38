/* SPDX-License-Identifier: MIT */
/*
 * The field of a surface, read in bricks of 8 cubes along each axis. Cubes have the name of their lowest center: -1 ..
 * size - 1 along each axis, as beyond the field is a layer of outside. Brick b has the cubes 8 b - 8 .. 8 b - 1.
 */
#ifndef SVO_LIB_SURFACE_FIELD_H
#define SVO_LIB_SURFACE_FIELD_H

#include <stdbool.h>
#include <stdint.h>

#include "core/memory.h"
#include "svocl/surface.h"

#define SVO_I_SURFACE_BRICK 8 /* cubes along an axis */
#define SVO_I_SURFACE_SIDE  (SVO_I_SURFACE_BRICK + 1) /* centers */
#define SVO_I_SURFACE_SITES ((size_t)SVO_I_SURFACE_SIDE * SVO_I_SURFACE_SIDE * SVO_I_SURFACE_SIDE)

/* What a center is. */
typedef enum svo_i_surface_state {
    SVO_I_SURFACE_ABSENT = 0, /* not in the band */
    SVO_I_SURFACE_OUTSIDE,
    SVO_I_SURFACE_INSIDE
} svo_i_surface_state;

/* The voxels of a band that lie in eight along each axis. */
typedef struct svo_i_surface_run {
    uint64_t code; /* Morton code of all of them over 512 */
    uint64_t begin; /* of the first */
} svo_i_surface_run;

typedef struct svo_i_surface_reader {
    svo_surface_field field;
    float level;
    float beyond; /* what the layer around the field holds */
    svo_i_surface_run *runs; /* of a band, ascending, and one behind them; owned. NULL: dense */
    uint64_t run_count;
    uint64_t *bricks; /* Morton codes of bricks that may have cubes, ascending; owned */
    uint64_t brick_count;
} svo_i_surface_reader;

/* The centers of a brick: x + 9 (y + 9 z). */
typedef struct svo_i_surface_window {
    int32_t low[3]; /* the first center */
    float values[SVO_I_SURFACE_SITES]; /* undefined where they are absent */
    uint8_t states[SVO_I_SURFACE_SITES]; /* svo_i_surface_state */
    bool is_mixed; /* there are some inside and others */
} svo_i_surface_window;

/* Checks the field but for its numbers, and lists its bricks. To be closed also after a failure. */
svo_status svo_i_surface_open(const svo_surface_field *field, float level, const svo_i_memory *memory,
                              svo_message *message, svo_i_surface_reader *reader);
void svo_i_surface_close(svo_i_surface_reader *reader);

/* Reads a brick. Returns SVO_INVALID_ARGUMENT for a number that is not finite. */
svo_status svo_i_surface_read(const svo_i_surface_reader *reader, uint64_t brick, svo_message *message,
                              svo_i_surface_window *window);

/* What a center is that a window may not have. */
svo_i_surface_state svo_i_surface_look(const svo_i_surface_reader *reader, const int32_t place[3]);

#endif
