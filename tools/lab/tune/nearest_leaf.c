/* SPDX-License-Identifier: MIT */
/* Branch and bound. Coordinates are in voxels, from the grid's corner. */
#include "tune/nearest_leaf.h"

#include <math.h>

typedef struct search {
    const svo_tree_info *info;
    const svo_tree_arrays *arrays;
    double point[3];
    double best; /* squared */
} search;

typedef struct visit {
    uint32_t node;
    double corner[3];
    double distance; /* squared, to the box of the centers of the voxels in it */
} visit;

static double squared_distance(const double point[3], const double corner[3], double width)
{
    double sum = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double low = corner[axis] + 0.5 - point[axis];
        const double high = point[axis] - (corner[axis] + width - 0.5);
        const double apart = fmax(fmax(low, high), 0);
        sum += apart * apart;
    }
    return sum;
}

/* The children in ascending distance. */
static unsigned list_children(const search *work, const visit *of, double width, visit children[8])
{
    const unsigned mask = work->arrays->child_mask[of->node];
    unsigned count = 0;
    uint32_t next = work->arrays->first_child[of->node];
    for (unsigned octant = 0; octant < 8; ++octant) {
        if ((mask >> octant & 1u) == 0) {
            continue;
        }
        visit one = {.node = next++};
        for (unsigned axis = 0; axis < 3; ++axis) {
            one.corner[axis] = of->corner[axis] + (double)(octant >> axis & 1u) * width;
        }
        one.distance = squared_distance(work->point, one.corner, width);
        unsigned place = count++;
        for (; place > 0 && children[place - 1].distance > one.distance; --place) {
            children[place] = children[place - 1];
        }
        children[place] = one;
    }
    return count;
}

static void descend(search *work, const visit *at, unsigned level) /* NOLINT(misc-no-recursion): 16 levels */
{
    visit children[8];
    const double width = ldexp(1, (int)(work->info->depth - level - 1));
    const unsigned count = list_children(work, at, width, children);
    for (unsigned i = 0; i < count && children[i].distance < work->best; ++i) {
        if (level + 1 == work->info->depth) {
            work->best = children[i].distance;
        } else {
            descend(work, &children[i], level + 1);
        }
    }
}

double nearest_leaf(const svo_tree_info *info, const svo_tree_arrays *arrays, const double point[3])
{
    search work = {.info = info, .arrays = arrays, .best = INFINITY};
    for (int axis = 0; axis < 3; ++axis) {
        work.point[axis] = ldexp((point[axis] - info->origin[axis]) / info->edge, (int)info->depth);
    }
    if (info->inner_count > 0) {
        descend(&work, &(visit){.node = 0}, 0);
    }
    return sqrt(work.best);
}
