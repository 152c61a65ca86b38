/* SPDX-License-Identifier: MIT */
/* Built by median splits along the longest axis of the centroids' bounds; traversed with a stack, the nearer child
   first. */
#include "errors/bvh.h"

#include <math.h>
#include <stdlib.h>

#include "path/threads.h"
#include "support/input.h"

#define LEAF_TRIANGLES    4u
#define STACK_NODES       64u
#define RAYS_PER_CHUNK    1024u
#define SMALLEST_DIVISOR  1e-200 /* takes the place of 0 */
#define QUOTIENT_ROUNDING 1e-14

typedef struct box {
    double low[3], high[3];
} box;

typedef struct node {
    box bounds;
    uint32_t first; /* of the leaf's triangles in order, or the second child; the first child follows its parent */
    uint32_t triangle_count; /* 0: an inner node */
} node;

struct bvh {
    node *nodes;
    uint32_t node_count;
    uint32_t *order; /* triangles, leaf by leaf */
};

typedef struct item {
    box bounds;
    double centroid[3];
    uint32_t triangle;
} item;

static void grow(box *whole, const box *part)
{
    for (int k = 0; k < 3; ++k) {
        whole->low[k] = fmin(whole->low[k], part->low[k]);
        whole->high[k] = fmax(whole->high[k], part->high[k]);
    }
}

static const box nothing = {{HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}};

static int compare_x(const void *a, const void *b)
{
    const item *left = a;
    const item *right = b;
    return (left->centroid[0] > right->centroid[0]) - (left->centroid[0] < right->centroid[0]);
}

static int compare_y(const void *a, const void *b)
{
    const item *left = a;
    const item *right = b;
    return (left->centroid[1] > right->centroid[1]) - (left->centroid[1] < right->centroid[1]);
}

static int compare_z(const void *a, const void *b)
{
    const item *left = a;
    const item *right = b;
    return (left->centroid[2] > right->centroid[2]) - (left->centroid[2] < right->centroid[2]);
}

static void sort_along_longest(item *items, size_t count)
{
    static int (*const compare[3])(const void *, const void *) = {compare_x, compare_y, compare_z};
    box centroids = nothing;
    for (size_t i = 0; i < count; ++i) {
        box point;
        for (int k = 0; k < 3; ++k) {
            point.low[k] = point.high[k] = items[i].centroid[k];
        }
        grow(&centroids, &point);
    }
    int longest = 0;
    for (int k = 1; k < 3; ++k) {
        longest = centroids.high[k] - centroids.low[k] > centroids.high[longest] - centroids.low[longest] ? k : longest;
    }
    qsort(items, count, sizeof *items, compare[longest]);
}

/* Half of the triangles go to each side: the depth is the logarithm of their number. */
static void build(bvh *tree, item *items, size_t begin, size_t count)
{
    const uint32_t own = tree->node_count++;
    node *here = &tree->nodes[own];
    *here = (node){.bounds = nothing};
    for (size_t i = 0; i < count; ++i) {
        grow(&here->bounds, &items[begin + i].bounds);
    }
    if (count <= LEAF_TRIANGLES) {
        here->first = (uint32_t)begin;
        here->triangle_count = (uint32_t)count;
        for (size_t i = 0; i < count; ++i) {
            tree->order[begin + i] = items[begin + i].triangle;
        }
        return;
    }
    sort_along_longest(items + begin, count);
    build(tree, items, begin, count / 2);
    here->first = tree->node_count;
    build(tree, items, begin + count / 2, count - count / 2);
}

static void measure(const double *vertices, const uint32_t *corners, double slack, item *out)
{
    out->bounds = nothing;
    for (size_t i = 0; i < 9; ++i) {
        const double at = vertices[(size_t)corners[i / 3] * 3 + i % 3];
        out->bounds.low[i % 3] = fmin(out->bounds.low[i % 3], at - slack);
        out->bounds.high[i % 3] = fmax(out->bounds.high[i % 3], at + slack);
    }
    for (int k = 0; k < 3; ++k) {
        out->centroid[k] = 0.5 * (out->bounds.low[k] + out->bounds.high[k]);
    }
}

bvh *bvh_create(const double *vertices, const uint32_t *indices, size_t triangle_count, double slack)
{
    bvh *tree = calloc(1, sizeof *tree);
    item *items = calloc(triangle_count + 1, sizeof *items);
    if (tree != NULL) {
        tree->nodes = calloc(2 * triangle_count + 1, sizeof *tree->nodes);
        tree->order = calloc(triangle_count + 1, sizeof *tree->order);
    }
    if (tree == NULL || items == NULL || tree->nodes == NULL || tree->order == NULL) {
        bvh_destroy(&tree);
    } else {
        for (size_t i = 0; i < triangle_count; ++i) {
            measure(vertices, indices + 3 * i, slack, &items[i]);
            items[i].triangle = (uint32_t)i;
        }
        build(tree, items, 0, triangle_count);
    }
    free(items);
    return tree;
}

void bvh_destroy(bvh **tree)
{
    if (*tree != NULL) {
        free((*tree)->nodes);
        free((*tree)->order);
        free(*tree);
        *tree = NULL;
    }
}

/* ---- rays ---- */

typedef struct traversal {
    double origin[3], inverse[3];
    double t_min;
} traversal;

/* The slab test of Kay and Kajiya, widened by more than rounding can narrow it. */
static bool enters(const traversal *ray, const box *bounds, double t_max, double *entry)
{
    double first = ray->t_min;
    double last = t_max;
    for (int k = 0; k < 3; ++k) {
        const double a = (bounds->low[k] - ray->origin[k]) * ray->inverse[k];
        const double b = (bounds->high[k] - ray->origin[k]) * ray->inverse[k];
        const double near = a < b ? a : b;
        const double far = a < b ? b : a;
        first = near > first ? near : first;
        last = far < last ? far : last;
    }
    *entry = first;
    return first - QUOTIENT_ROUNDING * fabs(first) <= last + QUOTIENT_ROUNDING * fabs(last);
}

static void test_leaf(const bvh *tree, const node *leaf, bvh_test *test, const void *triangles, const svo_ray *ray,
                      svo_hit *best)
{
    for (uint32_t i = 0; i < leaf->triangle_count; ++i) {
        const uint32_t triangle = tree->order[leaf->first + i];
        svo_hit hit = *best;
        if (test(triangles, triangle, ray, &hit) &&
            (hit.t < best->t || (hit.t == best->t && triangle < best->triangle))) {
            *best = hit;
            best->triangle = triangle;
        }
    }
}

static void trace_one(const bvh *tree, bvh_test *test, const void *triangles, const svo_ray *ray, svo_hit *best)
{
    traversal along = {.t_min = (double)ray->t_min};
    uint32_t stack[STACK_NODES] = {0};
    unsigned height = 1;
    for (int k = 0; k < 3; ++k) {
        const double component = (double)ray->direction[k];
        along.origin[k] = (double)ray->origin[k];
        along.inverse[k] = 1.0 / (component != 0.0 ? component : SMALLEST_DIVISOR);
    }
    *best = (svo_hit){.t = ray->t_max, .triangle = SVO_NO_TRIANGLE};
    while (height > 0) {
        const uint32_t own = stack[--height];
        const node *here = &tree->nodes[own];
        const double t_max =
            (double)best->t * (1.0 + 1e-6); /* beyond the rounding of a float, so that ties are found */
        double entry = 0.0;
        if (!enters(&along, &here->bounds, t_max, &entry)) {
            continue;
        }
        if (here->triangle_count > 0) {
            test_leaf(tree, here, test, triangles, ray, best);
            continue;
        }
        double first = 0.0;
        double second = 0.0;
        const bool to_first = enters(&along, &tree->nodes[own + 1].bounds, t_max, &first);
        const bool to_second = enters(&along, &tree->nodes[here->first].bounds, t_max, &second);
        const bool first_is_nearer = first <= second;
        if (to_first && to_second) {
            stack[height++] = first_is_nearer ? here->first : own + 1;
            stack[height++] = first_is_nearer ? own + 1 : here->first;
        } else if (to_first || to_second) {
            stack[height++] = to_first ? own + 1 : here->first;
        }
    }
    best->t = best->triangle != SVO_NO_TRIANGLE ? best->t : INFINITY;
}

typedef struct batch {
    const bvh *tree;
    bvh_test *test;
    const void *triangles;
    const svo_ray *rays;
    svo_hit *hits;
} batch;

static void trace_chunk(void *user, unsigned thread_index, size_t begin, size_t end)
{
    const batch *all = user;
    (void)thread_index;
    for (size_t i = begin; i < end; ++i) {
        trace_one(all->tree, all->test, all->triangles, &all->rays[i], &all->hits[i]);
    }
}

double bvh_trace(const bvh *tree, bvh_test *test, const void *triangles, const svo_ray *rays, svo_hit *hits,
                 size_t ray_count, unsigned thread_count)
{
    batch all = {tree, test, triangles, rays, hits};
    const double started_ms = input_now_ms();
    threads_run(thread_count, ray_count, RAYS_PER_CHUNK, trace_chunk, &all);
    return input_now_ms() - started_ms;
}
