/* SPDX-License-Identifier: MIT */
/*
 * All pairs of a mesh as given. Each triangle descends the octree from the smallest node that holds its bounds. An axis
 * is measured in doubles first, in voxels from a cell near the triangle, and its answer is taken where the distance is
 * larger than the bound of the error below; else the axis is decided in integers.
 *
 * The bound. Let u = DBL_EPSILON / 2. A coordinate t = (v - origin) * r with r = 2^depth / edge is rounded three times,
 * which errs by less than 4 u |t|; rounding offsets changes it by less than ROUNDED. From the cell at the base it errs
 * by d <= 4 u T + u L, where T is the largest |t|, and L >= 1 the largest coordinate from there, of vertices and boxes
 * both. So an edge errs by 2 d + 4 u L, and has components of at most 2 L. A projection on an edge crossed with an axis
 * has two products, one on the normal three of components below 8 L^2. Summed over the three terms of a comparison that
 * is at most 32 d L + 64 u L^2, and 336 d L^2 + 960 u L^3 on the normal. The factors in the code are twice that and
 * more, for what rounding does to the bound. FLOOR is above what underflow can add. Nothing is decided in doubles above
 * LENGTH_MAX, long before overflow.
 */
#include "exact_axes.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

#define FLOOR      1e-290
#define LENGTH_MAX 1e60
/* A unit of offsets in voxels is at most 2^(1 + ORACLE_EXACT_DEPTH_MAX - ORACLE_OFFSET_BITS). */
#define ROUNDED 0x1p-53
/* All axes but those of the box, whose extents are known as cells. */
#define MEASURED_MAX (EXACT_AXES - EXACT_NORMAL)

/* An axis in doubles: the triangle's extent, how far a box of one voxel reaches above and below its corner, as a node
   and as a voxel of the coverage. */
typedef struct measured_axis {
    int index;
    double direction[3];
    double low, high;
    double node_above, node_below;
    double voxel_above, voxel_below;
    double error;
} measured_axis;

/* One traversal: the current triangle and the growing list. */
typedef struct walker {
    const oracle_space *space;
    oracle_coverage coverage;
    int64_t first[3], last[3]; /* cells that are wanted */
    double rate; /* voxels per unit; 0 when doubles cannot hold it */
    oracle_exact_triangle triangle;
    uint32_t triangle_index;
    exact_triangle exact;
    bool exact_is_set; /* to the current triangle */
    int64_t low[3], high[3]; /* cells of the triangle's bounds */
    int64_t extent; /* cells, of the longest side */
    measured_axis axes[MEASURED_MAX];
    int axis_count;
    oracle_pair *pairs;
    size_t count, capacity;
} walker;

static exact_triangle *exact_of(walker *walk)
{
    if (!walk->exact_is_set) {
        exact_triangle_set(&walk->exact, &walk->triangle, walk->space);
        walk->exact_is_set = true;
    }
    return &walk->exact;
}

/* ---- bounds ---- */

/* In voxels; not finite where doubles cannot hold it. */
static double coordinate_of(const walker *walk, int vertex, int axis)
{
    return walk->rate > 0.0 ? (walk->triangle.vertices[vertex][axis] - walk->space->origin[axis]) * walk->rate
                            : (double)NAN;
}

static int64_t cell_of(walker *walk, int vertex, int axis, bool *on_plane)
{
    const double coordinate = coordinate_of(walk, vertex, axis);
    const double cell = floor(coordinate);
    const double error = 4.0 * DBL_EPSILON * fabs(coordinate) + FLOOR;
    if (fabs(coordinate) < (double)EXACT_CELL_MAX && coordinate - cell > error && cell + 1.0 - coordinate > error) {
        *on_plane = false;
        return (int64_t)cell;
    }
    return exact_triangle_cell(exact_of(walk), vertex, axis, on_plane);
}

/* Sets the bounds, clamped to the cells that are wanted; false if the triangle is beside them. */
static bool set_bounds(walker *walk)
{
    walk->extent = 0;
    for (int axis = 0; axis < 3; ++axis) {
        int64_t low = EXACT_CELL_MAX;
        int64_t high = -EXACT_CELL_MAX;
        for (int vertex = 0; vertex < 3; ++vertex) {
            bool on_plane;
            const int64_t cell = cell_of(walk, vertex, axis, &on_plane);
            /* What lies on a common face touches both closed voxels. */
            const int64_t first = on_plane && walk->coverage == ORACLE_CLOSED ? cell - 1 : cell;
            low = first < low ? first : low;
            high = cell > high ? cell : high;
        }
        if (high < walk->first[axis] || low > walk->last[axis]) {
            return false;
        }
        walk->low[axis] = low < walk->first[axis] ? walk->first[axis] : low;
        walk->high[axis] = high > walk->last[axis] ? walk->last[axis] : high;
        const int64_t extent = walk->high[axis] - walk->low[axis] + 1;
        walk->extent = extent > walk->extent ? extent : walk->extent;
    }
    return true;
}

/* ---- axes in doubles ---- */

/* The triangle from the base, which is the cell walk->low, and the numbers of the bound. */
typedef struct local_triangle {
    double vertices[3][3];
    double edges[3][3];
    double length; /* L */
    double error; /* d */
} local_triangle;

static double larger(double a, double b)
{
    return a > b ? a : b;
}

static void set_local(const walker *walk, local_triangle *local)
{
    double farthest = 0.0;
    local->length = (double)walk->extent;
    for (int i = 0; i < 9; ++i) {
        const double coordinate = coordinate_of(walk, i / 3, i % 3);
        local->vertices[i / 3][i % 3] = coordinate - (double)walk->low[i % 3];
        farthest = larger(fabs(coordinate), farthest);
        local->length = larger(fabs(local->vertices[i / 3][i % 3]), local->length);
    }
    local->error = local->length > LENGTH_MAX
                       ? (double)INFINITY
                       : 4.0 * DBL_EPSILON * farthest + DBL_EPSILON * local->length + ROUNDED + FLOOR;
    for (int i = 0; i < 9; ++i) {
        local->edges[i / 3][i % 3] = local->vertices[(i / 3 + 1) % 3][i % 3] - local->vertices[i / 3][i % 3];
    }
}

static double project(const double direction[3], const double point[3])
{
    return direction[0] * point[0] + direction[1] * point[1] + direction[2] * point[2];
}

/* Sets the extents of an axis whose direction is set. */
static void measure(const walker *walk, const local_triangle *local, measured_axis *axis)
{
    double sum = 0.0;
    double largest = 0.0;
    axis->low = axis->high = project(axis->direction, local->vertices[0]);
    for (int vertex = 1; vertex < 3; ++vertex) {
        const double projection = project(axis->direction, local->vertices[vertex]);
        axis->low = projection < axis->low ? projection : axis->low;
        axis->high = projection > axis->high ? projection : axis->high;
    }
    axis->node_above = axis->node_below = 0.0;
    for (int k = 0; k < 3; ++k) {
        axis->node_above += larger(axis->direction[k], 0.0);
        axis->node_below += larger(-axis->direction[k], 0.0);
        sum += axis->direction[k];
        largest = larger(fabs(axis->direction[k]), largest);
    }
    const bool is_thin = walk->coverage == ORACLE_THIN;
    axis->voxel_above = is_thin ? 0.5 * (largest + sum) : axis->node_above;
    axis->voxel_below = is_thin ? 0.5 * (largest - sum) : axis->node_below;
}

static bool same(double a, double b)
{
    return !(a < b || a > b);
}

/* Whether vertices a and b differ along the axis. */
static bool differ(const walker *walk, int a, int b, int axis)
{
    return !same(walk->triangle.vertices[a][axis], walk->triangle.vertices[b][axis]);
}

/* An edge crossed with an axis of the box; one with a single component is an axis of the box again. */
static void add_edge_axis(walker *walk, const local_triangle *local, int edge, int axis)
{
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    if (!differ(walk, edge, (edge + 1) % 3, u) || !differ(walk, edge, (edge + 1) % 3, v)) {
        return;
    }
    measured_axis *out = &walk->axes[walk->axis_count++];
    out->index = EXACT_AXIS(edge, axis);
    out->direction[axis] = 0.0;
    out->direction[u] = -local->edges[edge][v];
    out->direction[v] = local->edges[edge][u];
    out->error = 64.0 * local->length * local->error + 64.0 * DBL_EPSILON * local->length * local->length;
    measure(walk, local, out);
}

/* The normal, unless it is that of a face of the box or 0 for two equal vertices. */
static void add_normal(walker *walk, const local_triangle *local)
{
    const double squared = local->length * local->length;
    for (int k = 0; k < 3; ++k) {
        const int next = (k + 1) % 3;
        const bool has_edge = differ(walk, k, next, 0) || differ(walk, k, next, 1) || differ(walk, k, next, 2);
        if (!has_edge || (!differ(walk, 0, 1, k) && !differ(walk, 0, 2, k))) {
            return;
        }
    }
    measured_axis *out = &walk->axes[walk->axis_count++];
    out->index = EXACT_NORMAL;
    for (int k = 0; k < 3; ++k) {
        const double *e = local->edges[0];
        const double *f = local->edges[1];
        out->direction[k] = e[(k + 1) % 3] * f[(k + 2) % 3] - e[(k + 2) % 3] * f[(k + 1) % 3];
    }
    out->error = 1024.0 * squared * local->error + 1024.0 * DBL_EPSILON * squared * local->length;
    measure(walk, local, out);
}

static void set_axes(walker *walk)
{
    local_triangle local;
    set_local(walk, &local);
    walk->axis_count = 0;
    add_normal(walk, &local);
    for (int i = 0; i < 9; ++i) {
        add_edge_axis(walk, &local, i / 3, i % 3);
    }
}

/* ---- the traversal ---- */

/* Whether the triangle meets a box inside its bounds. Boxes larger than the bounds are not measured. */
static bool meets(walker *walk, const exact_box *box)
{
    double corner[3];
    unsigned undecided = 0; /* a bit for each axis */
    if (box->size > walk->extent) {
        return true;
    }
    for (int k = 0; k < 3; ++k) {
        corner[k] = (double)(box->corner[k] - walk->low[k]);
    }
    for (int i = 0; i < walk->axis_count; ++i) {
        const measured_axis *axis = &walk->axes[i];
        const double size = (double)box->size;
        const double shift = project(axis->direction, corner);
        const double over = axis->low - shift - (box->size == 1 ? axis->voxel_above : axis->node_above * size);
        const double under = axis->high - shift + (box->size == 1 ? axis->voxel_below : axis->node_below * size);
        if (over > axis->error || under < -axis->error) {
            return false;
        }
        undecided |= over < -axis->error && under > axis->error ? 0u : 1u << i;
    }
    /* Thin coverage does not nest: nodes are those of half-open coverage, a superset. */
    const bool is_node = walk->coverage == ORACLE_THIN && box->size > 1;
    const oracle_coverage coverage = is_node ? ORACLE_HALF_OPEN : walk->coverage;
    for (int i = 0; undecided != 0; ++i, undecided >>= 1) {
        if ((undecided & 1u) != 0 && exact_triangle_is_apart(exact_of(walk), walk->axes[i].index, box, coverage)) {
            return false;
        }
    }
    return true;
}

static bool add_pair(walker *walk, uint64_t code)
{
    if (walk->count == walk->capacity) {
        const size_t capacity = walk->capacity != 0 ? 2 * walk->capacity : 4096;
        oracle_pair *pairs =
            capacity <= SIZE_MAX / sizeof *pairs ? realloc(walk->pairs, capacity * sizeof *pairs) : NULL;
        if (pairs == NULL) {
            return false;
        }
        walk->pairs = pairs;
        walk->capacity = capacity;
    }
    walk->pairs[walk->count++] = (oracle_pair){code, walk->triangle_index};
    return true;
}

/* Adds the voxels below the node of a code, whose box is given. False: out of memory. */
static bool descend(walker *walk, uint64_t code, const exact_box *box)
{
    for (int k = 0; k < 3; ++k) {
        if (walk->high[k] < box->corner[k] || walk->low[k] >= box->corner[k] + box->size) {
            return true;
        }
    }
    if (!meets(walk, box)) {
        return true;
    }
    if (box->size == 1) {
        return add_pair(walk, code);
    }
    for (unsigned octant = 0; octant < 8; ++octant) {
        exact_box child = {.size = box->size / 2};
        for (unsigned k = 0; k < 3; ++k) {
            child.corner[k] = box->corner[k] + (int64_t)(octant >> k & 1) * child.size;
        }
        if (!descend(walk, code << 3 | octant, &child)) {
            return false;
        }
    }
    return true;
}

/* False: out of memory. */
static bool add_triangle(walker *walk)
{
    unsigned level_log2 = 0;
    walk->exact_is_set = false;
    if (!set_bounds(walk)) {
        return true;
    }
    set_axes(walk);
    for (int k = 0; k < 3; ++k) {
        while (walk->low[k] >> level_log2 != walk->high[k] >> level_log2) {
            ++level_log2;
        }
    }
    exact_box box = {.size = INT64_C(1) << level_log2};
    uint32_t node[3];
    for (int k = 0; k < 3; ++k) {
        node[k] = (uint32_t)(walk->low[k] >> level_log2);
        box.corner[k] = (int64_t)node[k] << level_log2;
    }
    return descend(walk, oracle_voxel_code(node[0], node[1], node[2], walk->space->depth - level_log2), &box);
}

static bool is_in_range(const oracle_space *space, unsigned level, uint64_t code)
{
    bool good = isfinite(space->edge) && space->edge > 0.0 && level <= space->depth && code >> 3 * level == 0;
    for (int k = 0; k < 3; ++k) {
        good = good && isfinite(space->origin[k]);
    }
    return good && space->depth <= ORACLE_EXACT_DEPTH_MAX;
}

/* One rounding, or 0: out of the range of normal doubles. */
static double rate_of(const oracle_space *space)
{
    const double rate = ldexp(1.0, (int)space->depth) / space->edge;
    return isnormal(rate) ? rate : 0.0;
}

/* Wants the cells below a node. */
static void set_wanted(walker *walk, unsigned level, uint64_t code)
{
    const unsigned below = walk->space->depth - level;
    for (unsigned axis = 0; axis < 3; ++axis) {
        int64_t cell = 0;
        for (unsigned i = level; i-- > 0;) {
            cell = cell << 1 | (int64_t)(code >> (3 * i + axis) & 1);
        }
        walk->first[axis] = cell << below;
        walk->last[axis] = ((cell + 1) << below) - 1;
    }
}

bool oracle_exact_enumerate(const oracle_positions *mesh, const oracle_space *space, oracle_coverage coverage,
                            oracle_pairs *out)
{
    return oracle_exact_enumerate_below(mesh, space, coverage, 0, 0, out);
}

bool oracle_exact_enumerate_below(const oracle_positions *mesh, const oracle_space *space, oracle_coverage coverage,
                                  unsigned level, uint64_t code, oracle_pairs *out)
{
    walker walk = {.space = space, .coverage = coverage};
    *out = (oracle_pairs){NULL, 0};
    if (!is_in_range(space, level, code)) {
        return false;
    }
    set_wanted(&walk, level, code);
    walk.rate = rate_of(space);
    exact_triangle_init(&walk.exact);
    bool good = true;
    for (size_t t = 0; good && t < mesh->triangle_count; ++t) {
        uint32_t vertices[3];
        if (!oracle_triangle_accepted(mesh, t, vertices)) {
            continue;
        }
        for (int i = 0; i < 9; ++i) {
            walk.triangle.vertices[i / 3][i % 3] = mesh->positions[3 * (size_t)vertices[i / 3] + (size_t)(i % 3)];
        }
        walk.triangle_index = (uint32_t)t;
        good = add_triangle(&walk);
    }
    exact_triangle_clear(&walk.exact);
    good = good && oracle_pairs_sort(walk.pairs, walk.count);
    if (!good) {
        free(walk.pairs);
        return false;
    }
    *out = (oracle_pairs){walk.pairs, walk.count};
    return true;
}
