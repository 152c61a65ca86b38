/* SPDX-License-Identifier: MIT */
/* The work of one call, which the steps share. */
#ifndef SVO_LIB_SURFACE_WORK_H
#define SVO_LIB_SURFACE_WORK_H

#include "surface/cases.h"
#include "surface/field.h"
#include "surface/handle.h"

/* A cube that the surface passes. */
typedef struct svo_i_surface_cube {
    uint32_t vertex; /* of its first piece; those of the others follow */
    uint16_t place; /* in its brick: x + 8 (y + 8 z) */
    uint8_t inside; /* its corners: bits */
    uint8_t is_joined; /* its pieces are those of cases.joined */
} svo_i_surface_cube;

/* A brick with such cubes. */
typedef struct svo_i_surface_brick {
    uint64_t code;
    size_t begin; /* its first cube; they ascend by place */
} svo_i_surface_brick;

/* The work of one call. Arrays grow by doubling; all but the mesh's are released in the end. */
typedef struct svo_i_surface_work {
    svo_surface *surface;
    svo_message *message; /* NULL allowed */
    svo_i_surface_cases cases;
    svo_i_surface_reader reader;
    bool with_normals; /* of the field */
    svo_i_surface_brick *bricks; /* ascending by code, and one behind them */
    size_t brick_count;
    size_t brick_capacity;
    svo_i_surface_cube *cubes;
    size_t cube_count;
    size_t cube_capacity;
    size_t vertex_count;
    size_t vertex_capacity;
    size_t normal_capacity;
    size_t triangle_count;
    size_t triangle_capacity;
} svo_i_surface_work;

/* Makes room for more elements in an array. */
svo_status svo_i_surface_grow(svo_i_surface_work *work, void **array, size_t needed, size_t *capacity,
                              size_t element_bytes);

/* A surface that goes on where the band does not. */
svo_status svo_i_surface_fail_open(const svo_i_surface_work *work, const int32_t place[3]);

#endif
