/* SPDX-License-Identifier: MIT */
#include "measure/brickmap.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#include "svocl/nodes.h"

#define BRICK_LOG2  3
#define BRICK_WIDTH (1 << BRICK_LOG2)

/* Bit x + 8 y of word z. */
typedef struct brick {
    uint64_t voxels[BRICK_WIDTH];
} brick;

struct brickmap {
    int width; /* in bricks */
    uint32_t *cells; /* the place of a brick, from 1 on; 0: empty */
    brick *bricks;
    size_t brick_count;
};

static size_t cell_index(const brickmap *map, int x, int y, int z)
{
    return (size_t)x + ((size_t)y + (size_t)z * (size_t)map->width) * (size_t)map->width;
}

static void add_voxel(brickmap *map, const uint32_t *cell)
{
    uint32_t *at = map->cells + cell_index(map, (int)(cell[0] >> BRICK_LOG2), (int)(cell[1] >> BRICK_LOG2),
                                           (int)(cell[2] >> BRICK_LOG2));
    if (*at == 0) {
        *at = (uint32_t)++map->brick_count;
    }
    map->bricks[*at].voxels[cell[2] % BRICK_WIDTH] |= UINT64_C(1)
                                                      << (cell[0] % BRICK_WIDTH + cell[1] % BRICK_WIDTH * 8);
}

brickmap *brickmap_create(const uint64_t *codes, size_t code_count, unsigned depth)
{
    brickmap *map = calloc(1, sizeof *map);
    size_t brick_count = 0;
    for (size_t i = 0; i < code_count; ++i) { /* the voxels of a brick follow each other */
        brick_count += i == 0 || codes[i] >> 3 * BRICK_LOG2 != codes[i - 1] >> 3 * BRICK_LOG2 ? 1 : 0;
    }
    if (map != NULL) {
        map->width = 1 << (depth - BRICK_LOG2);
        map->cells = calloc((size_t)1 << 3 * (depth - BRICK_LOG2), sizeof *map->cells);
        map->bricks = calloc(brick_count + 1, sizeof *map->bricks);
    }
    if (map == NULL || map->cells == NULL || map->bricks == NULL) {
        brickmap_destroy(&map);
        return NULL;
    }
    for (size_t i = 0; i < code_count; ++i) {
        uint32_t cell[3];
        svo_code_to_cell(codes[i], cell);
        add_voxel(map, cell);
    }
    return map;
}

void brickmap_destroy(brickmap **map)
{
    if (*map != NULL) {
        free((*map)->cells);
        free((*map)->bricks);
        free(*map);
        *map = NULL;
    }
}

uint64_t brickmap_bytes(const brickmap *map)
{
    const uint64_t width = (uint64_t)map->width;
    return width * width * width * sizeof *map->cells + map->brick_count * sizeof *map->bricks;
}

/* ---- rays ---- */

/* A walk through cells of one width. */
typedef struct walk {
    int cell[3], step[3];
    float next[3], delta[3]; /* distances to the next face on each axis, and between faces */
} walk;

static void walk_begin(const voxel_ray *ray, const float *inverse, float t, float width, const int *low, int count,
                       walk *out)
{
    for (int k = 0; k < 3; ++k) {
        const int at = (int)floorf((ray->origin[k] + t * ray->direction[k]) / width);
        const int cell = at < low[k] ? low[k] : at > low[k] + count - 1 ? low[k] + count - 1 : at;
        out->cell[k] = cell;
        out->step[k] = inverse[k] > 0.0F ? 1 : -1;
        out->next[k] = ((float)(cell + (inverse[k] > 0.0F ? 1 : 0)) * width - ray->origin[k]) * inverse[k];
        out->delta[k] = fabsf(inverse[k]) * width;
    }
}

/* Goes on to the next cell; returns the distance to it. */
static float walk_on(walk *w)
{
    const int k = w->next[0] < w->next[1] ? (w->next[0] < w->next[2] ? 0 : 2) : (w->next[1] < w->next[2] ? 1 : 2);
    const float t = w->next[k];
    w->cell[k] += w->step[k];
    w->next[k] += w->delta[k];
    return t;
}

static bool is_inside(const walk *w, const int *low, int count)
{
    return (unsigned)(w->cell[0] - low[0]) < (unsigned)count && (unsigned)(w->cell[1] - low[1]) < (unsigned)count &&
           (unsigned)(w->cell[2] - low[2]) < (unsigned)count;
}

static float trace_brick(const brick *b, const voxel_ray *ray, const float *inverse, float t, const int *brick_cell)
{
    const int low[3] = {brick_cell[0] << BRICK_LOG2, brick_cell[1] << BRICK_LOG2, brick_cell[2] << BRICK_LOG2};
    walk w;
    walk_begin(ray, inverse, t, 1.0F, low, BRICK_WIDTH, &w);
    while (is_inside(&w, low, BRICK_WIDTH) && t <= ray->range) {
        const int bit = w.cell[0] - low[0] + (w.cell[1] - low[1]) * BRICK_WIDTH;
        if ((b->voxels[w.cell[2] - low[2]] >> bit & 1) != 0) {
            return t;
        }
        t = walk_on(&w);
    }
    return INFINITY;
}

static float trace_ray(const brickmap *map, const voxel_ray *ray)
{
    static const int origin[3] = {0, 0, 0};
    const float width = (float)(map->width * BRICK_WIDTH);
    float inverse[3];
    float entry = 0.0F;
    float leave = ray->range;
    for (int k = 0; k < 3; ++k) {
        const float along = fabsf(ray->direction[k]) < 1e-20F ? 1e-20F : ray->direction[k];
        inverse[k] = 1.0F / along;
        const float low = -ray->origin[k] * inverse[k];
        const float high = (width - ray->origin[k]) * inverse[k];
        entry = fmaxf(entry, fminf(low, high));
        leave = fminf(leave, fmaxf(low, high));
    }
    if (!(entry <= leave)) {
        return INFINITY;
    }
    walk w;
    float t = entry;
    walk_begin(ray, inverse, t, BRICK_WIDTH, origin, map->width, &w);
    while (is_inside(&w, origin, map->width) && t <= ray->range) {
        const uint32_t place = map->cells[cell_index(map, w.cell[0], w.cell[1], w.cell[2])];
        const float found = place != 0 ? trace_brick(&map->bricks[place], ray, inverse, t, w.cell) : INFINITY;
        if (found < INFINITY) {
            return found;
        }
        t = walk_on(&w);
    }
    return INFINITY;
}

BRICKMAP_ALL_ISAS
void brickmap_trace(const brickmap *map, const voxel_ray *rays, float *distances, size_t ray_count)
{
    for (size_t i = 0; i < ray_count; ++i) {
        distances[i] = trace_ray(map, &rays[i]);
    }
}
