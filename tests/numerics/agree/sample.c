/* SPDX-License-Identifier: MIT */
/* Makes a triangle of a given kind in grid units and a voxel near it, then permutes and translates both like the
   library. */
#include "sample.h"

#define GRID_UNITS   (1 << 20)
#define NARROW_UNITS (1 << 14)
#define WIDE_UNITS   ((1 << 29) - 1)

/* A triangle under construction. */
typedef struct draft {
    uint64_t random;
    int64_t low, high; /* allowed coordinates */
    int64_t grid_units; /* voxels lie in [0, grid_units) */
    int64_t w; /* edge of a voxel */
    int64_t corner[3][3];
    bool centered; /* the triangle was made around `center` */
    int64_t center[3];
} draft;

const char *sample_kind_name(sample_kind kind)
{
    static const char *const names[SAMPLE_KINDS] = {"small", "large", "sliver",  "segment",
                                                    "point", "face",  "lattice", "extreme"};
    return names[kind];
}

uint64_t sample_random(uint64_t *state)
{
    uint64_t z = (*state += UINT64_C(0x9e3779b97f4a7c15));
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}

/* low .. high, both inclusive */
static int64_t between(draft *d, int64_t low, int64_t high)
{
    return low + (int64_t)(sample_random(&d->random) % (uint64_t)(high - low + 1));
}

static int64_t clamp(int64_t value, int64_t low, int64_t high)
{
    return value < low ? low : value > high ? high : value;
}

static int64_t floor_divide(int64_t a, int64_t b)
{
    return a / b - (a % b < 0);
}

static void make_small(draft *d)
{
    const int64_t reach = d->w * between(d, 1, 3);
    for (int axis = 0; axis < 3; ++axis) {
        const int64_t center = between(d, 0, d->grid_units - 1);
        for (int i = 0; i < 3; ++i) {
            d->corner[i][axis] = center + between(d, -reach, reach);
        }
    }
}

static void make_anywhere(draft *d)
{
    for (int axis = 0; axis < 3; ++axis) {
        for (int i = 0; i < 3; ++i) {
            d->corner[i][axis] = between(d, d->low, d->high);
        }
    }
}

/* A triangle that reaches out of the grid. A point of the grid is its center or, for triangles to be flattened, lies
   between the first two corners. */
static void make_around(draft *d, bool mirrored)
{
    const int64_t reach = (INT64_C(1) << between(d, 16, 28)) - 1;
    d->centered = true;
    for (int axis = 0; axis < 3; ++axis) {
        const int64_t center = between(d, 0, d->grid_units - 1);
        const int64_t first = center + between(d, -reach, reach);
        const int64_t second = mirrored ? 2 * center - first : center + between(d, -reach, reach);
        d->center[axis] = center;
        d->corner[0][axis] = first;
        d->corner[1][axis] = second;
        d->corner[2][axis] = 3 * center - first - second;
    }
}

/* Moves the third corner onto the segment between the others, then up to slack away from it. */
static void flatten(draft *d, int64_t slack)
{
    const int64_t parts = between(d, 1, 7);
    const int64_t part = between(d, 0, parts);
    for (int axis = 0; axis < 3; ++axis) {
        const int64_t step = (d->corner[1][axis] - d->corner[0][axis]) / parts;
        d->corner[1][axis] = d->corner[0][axis] + step * parts;
        d->corner[2][axis] = d->corner[0][axis] + step * part + between(d, -slack, slack);
    }
}

static void make_point(draft *d)
{
    for (int axis = 0; axis < 3; ++axis) {
        const int64_t at = between(d, 0, d->grid_units - 1);
        const int64_t rounded = between(d, 0, 1) == 0 ? at : at / d->w * d->w;
        d->corner[0][axis] = d->corner[1][axis] = d->corner[2][axis] = rounded;
    }
}

/* Rounds the coordinates along axis to voxel boundaries; all to the same one if together is set. */
static void round_axis(draft *d, int axis, bool together)
{
    for (int i = 0; i < 3; ++i) {
        const int64_t from = d->corner[together ? 0 : i][axis];
        d->corner[i][axis] = floor_divide(from, d->w) * d->w;
    }
}

static void make_extreme(draft *d)
{
    const int64_t edges[] = {d->low,
                             d->low + 1,
                             d->high - 1,
                             d->high,
                             d->grid_units - 1,
                             d->grid_units,
                             d->grid_units - d->w,
                             d->grid_units - d->w - 1,
                             0,
                             1,
                             d->w - 1,
                             d->w};
    for (int i = 0; i < 3; ++i) {
        for (int axis = 0; axis < 3; ++axis) {
            d->corner[i][axis] = edges[between(d, 0, (int64_t)(sizeof edges / sizeof edges[0]) - 1)];
        }
    }
}

static void make_triangle(draft *d, sample_kind kind)
{
    const bool small = between(d, 0, 1) == 0;
    const bool flat = kind == SAMPLE_SLIVER || kind == SAMPLE_SEGMENT;
    d->centered = false;
    if (kind == SAMPLE_POINT) {
        make_point(d);
    } else if (kind == SAMPLE_EXTREME) {
        make_extreme(d);
    } else if (kind == SAMPLE_SMALL || (kind != SAMPLE_LARGE && small)) {
        make_small(d);
    } else if (d->low < 0 && between(d, 0, 3) > 0) {
        make_around(d, flat);
    } else {
        make_anywhere(d);
    }
    if (flat) {
        flatten(d, kind == SAMPLE_SLIVER ? INT64_C(1) << between(d, 0, 11) : 0);
    }
    const int face = (int)between(d, 0, 2);
    for (int axis = 0; axis < 3; ++axis) {
        if (kind == SAMPLE_LATTICE || (kind == SAMPLE_FACE && axis == face)) {
            round_axis(d, axis, kind == SAMPLE_FACE);
        }
        for (int i = 0; i < 3; ++i) {
            d->corner[i][axis] = clamp(d->corner[i][axis], d->low, d->high);
        }
    }
}

/* The range of voxels that the triangle's bounds cover along axis, inside the grid; false if it is empty. */
static bool find_bounds(const draft *d, int axis, bool closed, int64_t *first, int64_t *last)
{
    int64_t low = d->corner[0][axis];
    int64_t high = low;
    for (int i = 1; i < 3; ++i) {
        low = d->corner[i][axis] < low ? d->corner[i][axis] : low;
        high = d->corner[i][axis] > high ? d->corner[i][axis] : high;
    }
    *first = floor_divide(closed ? low - 1 : low, d->w);
    *last = floor_divide(high, d->w);
    const bool meets = *last >= 0 && *first < d->grid_units / d->w;
    *first = clamp(*first, 0, d->grid_units / d->w - 1);
    *last = clamp(*last, 0, d->grid_units / d->w - 1);
    return meets;
}

/* A point on or near the triangle, inside the grid, in a few attempts; false if none was found. */
static bool find_point(draft *d, int64_t point[3])
{
    for (int attempt = 0; attempt < 32; ++attempt) {
        double s = (double)between(d, 0, 1024) / 1024.0;
        double r = (double)between(d, 0, 1024) / 1024.0;
        if (s + r > 1.0) {
            s = 1.0 - s;
            r = 1.0 - r;
        }
        bool inside = true;
        for (int axis = 0; axis < 3; ++axis) {
            const double a = (double)d->corner[0][axis];
            const double b = (double)d->corner[1][axis];
            const double c = (double)d->corner[2][axis];
            const int64_t on_triangle = (int64_t)(a + s * (b - a) + r * (c - a) + 0.5);
            point[axis] = d->centered ? d->center[axis] : on_triangle;
            inside = inside && point[axis] >= 0 && point[axis] < d->grid_units;
        }
        if (inside) {
            return true;
        }
    }
    return false;
}

/* The library's axis of projection: the largest component of the normal. */
static int longest_axis(const draft *d)
{
    int longest = 0;
    int64_t largest = -1;
    for (int axis = 0; axis < 3; ++axis) {
        const int p = (axis + 1) % 3;
        const int q = (axis + 2) % 3;
        const int64_t n = (d->corner[1][p] - d->corner[0][p]) * (d->corner[2][q] - d->corner[0][q]) -
                          (d->corner[1][q] - d->corner[0][q]) * (d->corner[2][p] - d->corner[0][p]);
        const int64_t length = n < 0 ? -n : n;
        if (length > largest) {
            largest = length;
            longest = axis;
        }
    }
    return longest;
}

static void start(draft *d, sample_width width, uint64_t seed, uint32_t index)
{
    *d = (draft){.random = seed + (uint64_t)index * UINT64_C(0x100000001b3)};
    d->grid_units = width == SAMPLE_NARROW ? NARROW_UNITS : GRID_UNITS;
    d->low = width == SAMPLE_WIDE ? -WIDE_UNITS : 0;
    d->high = width == SAMPLE_WIDE ? WIDE_UNITS : d->grid_units - 1;
    /* Half of the records use the library's smallest voxels: rounding is largest relative to them. */
    const int64_t w_log2_max = width == SAMPLE_NARROW ? 13 : 19;
    d->w = INT64_C(1) << (between(d, 0, 1) == 0 ? 8 : between(d, 8, w_log2_max));
}

/* Repeats until the triangle meets the grid. */
static void make_inside(draft *d, sample_kind kind, bool closed, int64_t first[3], int64_t last[3])
{
    bool meets = false;
    for (int attempt = 0; !meets; ++attempt) {
        make_triangle(d, attempt < 64 ? kind : SAMPLE_POINT);
        meets = true;
        for (int axis = 0; axis < 3; ++axis) {
            meets = find_bounds(d, axis, closed, &first[axis], &last[axis]) && meets;
        }
    }
}

/* A voxel of the bounds: near a point of the triangle if one was found, else any. */
static void choose_voxel(draft *d, const int64_t first[3], const int64_t last[3], int64_t voxel[3])
{
    int64_t point[3];
    const bool near = find_point(d, point) && between(d, 0, 7) > 0;
    for (int axis = 0; axis < 3; ++axis) {
        const int64_t offset = between(d, 0, 1) == 0 ? between(d, -1, 1) : 0;
        const int64_t wanted = near ? point[axis] / d->w + offset : between(d, first[axis], last[axis]);
        voxel[axis] = clamp(wanted, first[axis], last[axis]);
    }
}

/* A triangle with the voxels of its bounds and the voxel to test. */
typedef struct placed {
    int64_t first[3], last[3], voxel[3];
} placed;

/* Writes the record in coordinates relative to the first voxel's corner, permuted so that axis comes last. */
static void write_record(const draft *d, const placed *p, int axis, sample *out)
{
    const bool thin = out->coverage == ORACLE_THIN;
    int32_t *words = out->record.words;
    int32_t extent = 0;
    for (int k = 0; k < 3; ++k) {
        const int from = (axis + 1 + k) % 3;
        for (int i = 0; i < 3; ++i) {
            const int32_t local = (int32_t)(d->corner[i][from] - p->first[from] * d->w);
            const int32_t distance = local < 0 ? -local : local;
            extent = distance > extent ? distance : extent;
            words[3 * i + k] = local;
            out->triangle.vertex[i][thin ? from : k] = local;
        }
        words[11 + k] = (int32_t)((p->voxel[from] - p->first[from]) * d->w);
        out->box.corner[thin ? from : k] = words[11 + k];
    }
    out->box.width = d->w;
    words[9] = (int32_t)d->w;
    words[10] = thin ? axis : out->coverage == ORACLE_CLOSED ? 0 : 1;
    words[14] = (int32_t)(p->last[axis] - p->first[axis]);
    words[15] = extent;
}

static void make(sample_width width, bool thin, uint64_t seed, uint32_t index, sample *out)
{
    draft d;
    placed p = {.first = {0}};
    start(&d, width, seed, index);
    const sample_kind kind = (sample_kind)(index % SAMPLE_KINDS);
    const bool closed = between(&d, 0, 3) == 0 && !thin;
    make_inside(&d, kind, closed, p.first, p.last);
    choose_voxel(&d, p.first, p.last, p.voxel);
    const int longest = longest_axis(&d);
    const int axis = between(&d, 0, 3) > 0 ? longest : (int)between(&d, 0, 2);
    const oracle_coverage coverage = thin ? ORACLE_THIN : closed ? ORACLE_CLOSED : ORACLE_HALF_OPEN;
    *out = (sample){.kind = kind, .coverage = coverage, .axis_is_longest = axis == longest};
    write_record(&d, &p, axis, out);
}

void sample_make(sample_width width, uint64_t seed, uint32_t index, sample *out)
{
    make(width, false, seed, index, out);
}

void sample_make_thin(sample_width width, uint64_t seed, uint32_t index, sample *out)
{
    make(width, true, seed, index, out);
}

bool sample_may_touch(const probe_output *found)
{
    return found->words[PROBE_COLUMN] != SVO_TOUCHES_NOT && found->words[PROBE_VOXEL] != SVO_TOUCHES_NOT;
}

bool sample_is_wrong(const sample *given, const probe_output *found, bool touches)
{
    int32_t odd = 0;
    for (unsigned i = 0; i < 9; ++i) {
        odd |= given->record.words[i] & 1;
    }
    const bool is_undecided = found->words[PROBE_COLUMN] == SVO_UNDECIDED || found->words[PROBE_VOXEL] == SVO_UNDECIDED;
    return sample_may_touch(found) && is_undecided ? odd == 0 : sample_may_touch(found) != touches;
}
