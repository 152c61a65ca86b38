/* SPDX-License-Identifier: MIT */
/*
 * Known answers of the kernels that make fragments: voxelize.cl in each variant of the overlap test, and decide.cl.
 * What triangles on the grid's units touch, the host finds by the separating axis test in 64 bits, in one plain loop;
 * what triangles of the caller's numbers touch, by the exact test that kernels share with it (shared/exact.clh).
 */
#include <stdlib.h>
#include <string.h>

#include "core/proof.h"
#include "shared/decide.clh"
#include "stages/programs.h"

/* Bits of a key that a triangle takes; its code takes those above. */
#define TRIANGLE_BITS 8

static uint64_t code_of(const uint32_t voxel[3])
{
    uint64_t code = 0;
    for (unsigned bit = 0; bit < 16; ++bit) {
        for (unsigned axis = 0; axis < 3; ++axis) {
            code |= (uint64_t)(voxel[axis] >> bit & 1u) << (3 * bit + axis);
        }
    }
    return code;
}

static uint32_t fragment_words(const svo_i_proof *proof)
{
    return svo_i_proof_defines(proof, "SVO_CODE48") ? SVO_FRAGMENT_WORDS_48 : SVO_FRAGMENT_WORDS_30;
}

static void put_fragment(uint32_t *words, uint32_t word_count, uint64_t code, uint32_t triangle)
{
    words[0] = (uint32_t)code;
    words[1] = (uint32_t)(code >> 32);
    words[word_count - 1] = triangle;
}

static uint32_t below(uint64_t *random, uint32_t end)
{
    return (uint32_t)(svo_i_proof_next(random) % end);
}

/* ---- voxelization ---- */

#define VOXEL_LOG2 8
#define VOXEL      (1 << VOXEL_LOG2)
/* More than a group; the last is larger than a work-item's columns. */
#define TRIANGLES  (SVO_GROUP_ITEMS + 3)
#define LARGE_EDGE 19 /* of the last one, in voxels */
#define SMALL_EDGE 5
#define TILES_MAX  16
#define ROOM       8192 /* for fragments */

typedef struct voxels_case {
    int32_t vertices[TRIANGLES * 9];
    uint32_t indices[TRIANGLES * 3];
    svo_draw_item items[TRIANGLES];
    svo_tile_item tiles[TILES_MAX];
    bool is_exact[TRIANGLES]; /* all coordinates are even: nothing is undecided */
    uint64_t expected[ROOM]; /* keys of the voxels that a triangle touches, as if it were exact, ascending */
    uint32_t expected_count;
    uint64_t found[ROOM]; /* keys, twice; the lowest bit: decided */
    uint32_t words[ROOM * SVO_FRAGMENT_WORDS_48];
    uint32_t word_count;
    int coverage;
    svo_voxelize_params params;
} voxels_case;

static int compare_keys(const void *a, const void *b)
{
    const uint64_t x = *(const uint64_t *)a;
    const uint64_t y = *(const uint64_t *)b;
    return x < y ? -1 : x > y ? 1 : 0;
}

/* Axis 0 to 2 of the box, 3 the normal, 4 to 12 an edge crossed with an axis of the box. at: x, y, z of the corners. */
static void axis_of(const int64_t at[9], int axis, int64_t n[3])
{
    const int edge = axis < 4 ? 0 : (axis - 4) / 3;
    for (int k = 0; k < 3; ++k) {
        const int p = (k + 1) % 3;
        const int q = (k + 2) % 3;
        const int64_t e[2] = {at[(3 * edge + p + 3) % 9] - at[3 * edge + p],
                              at[(3 * edge + q + 3) % 9] - at[3 * edge + q]};
        const int64_t f[2] = {axis == 3 ? at[6 + p] - at[3 + p] : p == (axis - 4) % 3,
                              axis == 3 ? at[6 + q] - at[3 + q] : q == (axis - 4) % 3};
        n[k] = axis < 3 ? k == axis : e[0] * f[1] - e[1] * f[0];
    }
}

/* Whether a voxel at the origin and a triangle are apart along n: svo_exact_apart of shared/exact.clh, in 64 bits. */
static bool is_apart(const int64_t at[9], const int64_t n[3], int coverage)
{
    int64_t lower = 0;
    int64_t upper = 0;
    int64_t largest = 0;
    int64_t leading = 0;
    for (int k = 0; k < 3; ++k) {
        lower += n[k] < 0 ? n[k] : 0;
        upper += n[k] > 0 ? n[k] : 0;
        largest = llabs(n[k]) > largest ? llabs(n[k]) : largest;
        leading = leading != 0 ? leading : n[k];
    }
    const bool is_thin = coverage == SVO_EXACT_THIN;
    const int64_t begin = is_thin ? (lower + upper - largest) * (VOXEL / 2) : lower * VOXEL;
    const int64_t end = is_thin ? (lower + upper + largest) * (VOXEL / 2) : upper * VOXEL;
    int64_t least = INT64_MAX;
    int64_t most = INT64_MIN;
    for (int corner = 0; corner < 9; corner += 3) {
        const int64_t x = n[0] * at[corner] + n[1] * at[corner + 1] + n[2] * at[corner + 2];
        least = x < least ? x : least;
        most = x > most ? x : most;
    }
    const bool open_end = coverage != SVO_EXACT_CLOSED && (is_thin ? leading > 0 : upper > 0);
    const bool open_begin = coverage != SVO_EXACT_CLOSED && (is_thin ? leading < 0 : lower < 0);
    return least > end || most < begin || (open_end && least == end) || (open_begin && most == begin);
}

static bool touches(const int32_t *vertices, const uint32_t voxel[3], int coverage)
{
    int64_t at[9];
    int64_t n[3];
    for (int i = 0; i < 9; ++i) {
        at[i] = (int64_t)vertices[i] - (int64_t)voxel[i % 3] * VOXEL;
    }
    for (int axis = 0; axis < 13; ++axis) {
        axis_of(at, axis, n);
        if (is_apart(at, n, coverage)) {
            return false;
        }
    }
    return true;
}

/* The voxels of a triangle's bounds, with those that touch its far faces. */
static void bounds_of(const int32_t *vertices, uint32_t first[3], uint32_t last[3])
{
    for (unsigned axis = 0; axis < 3; ++axis) {
        const int32_t a = vertices[axis];
        const int32_t b = vertices[3 + axis];
        const int32_t c = vertices[6 + axis];
        const int32_t low = a < b ? (a < c ? a : c) : (b < c ? b : c);
        const int32_t high = a > b ? (a > c ? a : c) : (b > c ? b : c);
        first[axis] = (uint32_t)(low - 1) >> VOXEL_LOG2;
        last[axis] = (uint32_t)high >> VOXEL_LOG2;
    }
}

static void expect_triangle(voxels_case *c, uint32_t triangle)
{
    const int32_t *const vertices = c->vertices + (size_t)triangle * 9;
    uint32_t first[3];
    uint32_t last[3];
    uint32_t at[3];
    bounds_of(vertices, first, last);
    for (at[0] = first[0]; at[0] <= last[0]; ++at[0]) {
        for (at[1] = first[1]; at[1] <= last[1]; ++at[1]) {
            for (at[2] = first[2]; at[2] <= last[2]; ++at[2]) {
                if (c->expected_count < ROOM && touches(vertices, at, c->coverage)) {
                    c->expected[c->expected_count++] = code_of(at) << TRIANGLE_BITS | triangle;
                }
            }
        }
    }
}

/* The axis of the normal's largest component, or without a normal that of the shortest extent; the first of equals. */
static uint32_t projection_of(const int32_t *vertices)
{
    int64_t at[9];
    int64_t n[3];
    uint32_t first[3];
    uint32_t last[3];
    unsigned axis = 0;
    unsigned shortest = 0;
    for (unsigned i = 0; i < 9; ++i) {
        at[i] = vertices[i];
    }
    axis_of(at, 3, n);
    bounds_of(vertices, first, last);
    for (unsigned k = 1; k < 3; ++k) {
        axis = llabs(n[k]) > llabs(n[axis]) ? k : axis;
        shortest = last[k] - first[k] < last[shortest] - first[shortest] ? k : shortest;
    }
    return n[axis] != 0 ? axis : shortest;
}

/* Corners in a cube of so many voxels: on corners of voxels, on their middles, anywhere, or, every fourth triangle, at
   odd places, as vertices are that were rounded. Every eighth has two equal corners. */
static void fill_triangle(voxels_case *c, uint32_t triangle, uint32_t edge, uint64_t *random)
{
    static const int32_t steps[4] = {VOXEL, VOXEL / 2, 2, 2};
    const int32_t step = steps[triangle % 4];
    const uint32_t room = (1u << c->params.depth) - edge - 1;
    int32_t *const vertices = c->vertices + (size_t)triangle * 9;
    for (unsigned axis = 0; axis < 3; ++axis) {
        const int32_t low = (int32_t)(1 + below(random, room - 1)) * VOXEL;
        for (unsigned corner = 0; corner < 3; ++corner) {
            const int32_t x = (int32_t)below(random, edge * VOXEL / (uint32_t)step) * step;
            vertices[3 * corner + axis] = low + x + (triangle % 4 == 3 ? 1 : 0);
        }
        vertices[6 + axis] = triangle % 8 == 5 ? vertices[axis] : vertices[6 + axis];
    }
    c->is_exact[triangle] = triangle % 4 != 3;
    c->items[triangle] = (svo_draw_item){triangle, projection_of(vertices)};
    for (uint32_t corner = 0; corner < 3; ++corner) {
        c->indices[3 * triangle + corner] = 3 * triangle + corner;
    }
}

/* Inside one voxel, and off its faces. */
static void fill_point(voxels_case *c, uint32_t triangle, uint64_t *random)
{
    int32_t *const vertices = c->vertices + (size_t)triangle * 9;
    fill_triangle(c, triangle, 1, random);
    for (unsigned i = 0; i < 9; ++i) {
        vertices[i] = vertices[i % 3] / VOXEL * VOXEL + 1 + (int32_t)below(random, VOXEL - 1);
    }
    c->is_exact[triangle] = true;
}

/* The corners of the last triangle lie far apart. Its tiles cover it. */
static void fill_large(voxels_case *c, uint64_t *random)
{
    const uint32_t triangle = TRIANGLES - 1;
    int32_t *const vertices = c->vertices + (size_t)triangle * 9;
    uint32_t first[3];
    uint32_t last[3];
    fill_triangle(c, triangle, LARGE_EDGE, random);
    for (unsigned axis = 0; axis < 3; ++axis) {
        vertices[3 + axis] = vertices[axis] + (axis == 1 ? 0 : LARGE_EDGE * VOXEL - 2);
        vertices[6 + axis] = vertices[axis] + (axis == 2 ? 0 : LARGE_EDGE * VOXEL / 2);
    }
    const uint32_t axis = projection_of(vertices);
    const uint32_t u = (axis + 1) % 3;
    const uint32_t v = (axis + 2) % 3;
    c->items[triangle].flags = axis;
    bounds_of(vertices, first, last);
    for (uint32_t y = first[v]; y <= last[v]; y += SVO_TILE_EDGE) {
        for (uint32_t x = first[u]; x <= last[u] && c->params.tile_count < TILES_MAX; x += SVO_TILE_EDGE) {
            c->tiles[c->params.tile_count++] = (svo_tile_item){triangle, x | y << 16};
        }
    }
}

static void fill_voxels(const svo_i_proof *proof, voxels_case *c)
{
    const bool has_points = svo_i_proof_defines(proof, "SVO_NO_TEST");
    uint64_t random = 3;
    c->word_count = fragment_words(proof);
    c->params = (svo_voxelize_params){.depth = c->word_count == SVO_FRAGMENT_WORDS_48 ? 11 : 7,
                                      .voxel_log2 = VOXEL_LOG2,
                                      .one_voxel = has_points ? 1 : 0,
                                      .item_count = TRIANGLES,
                                      .first_tile_id = 2 * SVO_GROUP_ITEMS,
                                      .capacity = ROOM,
                                      .most_columns = SVO_TILE_COLUMNS};
    c->params.width = c->params.height = 1u << c->params.depth;
    for (uint32_t triangle = 0; triangle < TRIANGLES; ++triangle) {
        if (has_points) {
            fill_point(c, triangle, &random);
        } else {
            fill_triangle(c, triangle, SMALL_EDGE, &random);
        }
    }
    if (!has_points) {
        fill_large(c, &random);
    }
}

static uint64_t key_of(const voxels_case *c, uint32_t place)
{
    const uint32_t *const words = c->words + (size_t)place * c->word_count;
    const uint64_t high = c->word_count == SVO_FRAGMENT_WORDS_48 ? words[1] : 0;
    return (high << 32 | words[0]) << TRIANGLE_BITS | words[c->word_count - 1];
}

/* Whether the fragments are those of the triangles: all that the host expects, and of triangles that are not exact
   perhaps some more, undecided. counters: of the chunk. */
static bool are_right(voxels_case *c, const uint32_t counters[SVO_COUNTER_WORDS])
{
    uint32_t next = 0;
    if ((counters[1] | counters[3]) != 0 || counters[0] > ROOM || counters[2] > ROOM - counters[0]) {
        return false;
    }
    const uint32_t count = counters[0] + counters[2];
    for (uint32_t i = 0; i < count; ++i) {
        const bool decided = i < counters[0];
        c->found[i] = key_of(c, decided ? i : ROOM - 1 - (i - counters[0])) << 1 | (decided ? 1 : 0);
    }
    qsort(c->found, count, sizeof c->found[0], compare_keys);
    for (uint32_t i = 0; i < count; ++i) {
        const uint64_t key = c->found[i] >> 1;
        const uint64_t triangle = key & ((1u << TRIANGLE_BITS) - 1u);
        const bool may_be_undecided = triangle < TRIANGLES && !c->is_exact[triangle];
        const bool is_expected = next < c->expected_count && c->expected[next] == key;
        const bool is_twice = i > 0 && c->found[i - 1] >> 1 == key;
        if (is_twice || (!may_be_undecided && (!is_expected || (c->found[i] & 1u) == 0)) ||
            ((c->found[i] & 1u) != 0 && !is_expected)) {
            return false;
        }
        next += is_expected ? 1 : 0;
    }
    return next == c->expected_count;
}

static svo_status launch_voxelize(svo_i_proof *proof, voxels_case *c, cl_mem counters, cl_mem fragments)
{
    svo_i_device_work *work = &proof->work;
    const bool is_cpu = work->device->cpu_path;
    const size_t words = is_cpu ? SVO_VOXELIZE_STAGE_WORDS : SVO_VOXELIZE_NOTE_WORDS;
    cl_mem vertices = NULL;
    cl_mem indices = NULL;
    cl_mem items = NULL;
    cl_mem tiles = NULL;
    SVO_I_TRY(svo_i_work_constants(work, "proof", c->vertices, sizeof c->vertices, &vertices));
    SVO_I_TRY(svo_i_work_constants(work, "proof", c->indices, sizeof c->indices, &indices));
    SVO_I_TRY(svo_i_work_constants(work, "proof", c->items, sizeof c->items, &items));
    SVO_I_TRY(svo_i_work_constants(work, "proof", c->tiles, sizeof c->tiles, &tiles));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(vertices),
                                        SVO_I_ARGUMENT(indices),
                                        SVO_I_ARGUMENT(items),
                                        SVO_I_ARGUMENT(tiles),
                                        SVO_I_ARGUMENT(counters),
                                        SVO_I_ARGUMENT(fragments),
                                        SVO_I_ARGUMENT(c->params),
                                        SVO_I_LOCAL(sizeof(cl_uint) * words),
                                        SVO_I_LOCAL(sizeof(cl_uint) * SVO_GROUP_ITEMS)};
    return svo_i_proof_launch(proof, "svo_k_voxelize", SVO_I_ARGUMENTS(arguments),
                              c->params.first_tile_id + c->params.tile_count);
}

static svo_status prove_coverage(svo_i_proof *proof, voxels_case *c, int coverage)
{
    const size_t bytes = (size_t)ROOM * c->word_count * 4;
    uint32_t counts[SVO_COUNTER_WORDS];
    cl_mem counters = NULL;
    cl_mem fragments = NULL;
    c->coverage = coverage;
    c->params.open = coverage == SVO_EXACT_CLOSED ? 0 : 1;
    c->expected_count = 0;
    for (uint32_t triangle = 0; triangle < TRIANGLES; ++triangle) {
        expect_triangle(c, triangle);
    }
    qsort(c->expected, c->expected_count, sizeof c->expected[0], compare_keys);
    SVO_I_TRY(svo_i_work_alloc(&proof->work, "proof", sizeof counts, &counters));
    SVO_I_TRY(svo_i_work_fill_zero(&proof->work, counters, sizeof counts));
    SVO_I_TRY(svo_i_work_alloc(&proof->work, "proof", bytes, &fragments));
    SVO_I_TRY(launch_voxelize(proof, c, counters, fragments));
    SVO_I_TRY(svo_i_work_read(&proof->work, counters, 0, counts, sizeof counts));
    SVO_I_TRY(svo_i_work_read(&proof->work, fragments, 0, c->words, bytes));
    return are_right(c, counts) ? SVO_OK : svo_i_proof_fail(proof, "svo_k_voxelize");
}

static svo_status prove_voxels(svo_i_proof *proof, void *memory)
{
    fill_voxels(proof, memory);
    if (svo_i_proof_defines(proof, "SVO_THIN")) {
        return prove_coverage(proof, memory, SVO_EXACT_THIN);
    }
    SVO_I_TRY(prove_coverage(proof, memory, SVO_EXACT_HALF_OPEN));
    return prove_coverage(proof, memory, SVO_EXACT_CLOSED);
}

svo_status svo_i_prove_voxelize(svo_device *device, const char *function, const svo_i_program_entry *made,
                                const char **wrong)
{
    return svo_i_proof_run(device, function, made, wrong, sizeof(voxels_case), prove_voxels);
}

/* ---- decisions ---- */

#define DECIDE_DEPTH     9
#define DECIDE_TRIANGLES 18
#define CELLS            4 /* of a triangle */
#define UNDECIDED        (DECIDE_TRIANGLES * CELLS)
#define DECIDED          5
#define DECIDE_ROOM      (DECIDED + 7 + UNDECIDED)
#define NEAR             6 /* voxels of a triangle's cube */

typedef struct decide_case {
    double positions[DECIDE_TRIANGLES * 9];
    float floats[DECIDE_TRIANGLES * 9];
    uint32_t indices[DECIDE_TRIANGLES * 3];
    uint32_t
        words[DECIDE_ROOM * SVO_FRAGMENT_WORDS_48]; /* as voxelization leaves them; then as decided; then as kept */
    uint32_t word_count;
    uint32_t counters[SVO_COUNTER_WORDS];
    double origin[3], edge;
    svo_decide_params params;
} decide_case;

static void put_double(double x, uint32_t words[2])
{
    uint64_t bits = 0;
    memcpy(&bits, &x, sizeof bits);
    words[0] = (uint32_t)bits;
    words[1] = (uint32_t)(bits >> 32);
}

/* The number after or before x, or x; of floats where is_double is not set. */
static double nudged(double x, uint32_t choice, bool is_double)
{
    const double towards = choice == 0 ? -INFINITY : choice == 1 ? INFINITY : x;
    return is_double ? nextafter(x, towards) : (double)nextafterf((float)x, (float)towards);
}

/* The cell of a coordinate, which is on no plane between voxels unless the grid is one of whole numbers. */
static uint32_t cell_of(const decide_case *c, double x, unsigned axis)
{
    return (uint32_t)floor((x - c->origin[axis]) / ldexp(c->edge, -DECIDE_DEPTH));
}

/* Corners on the lattice of half voxels, or the last bit of a number beside it. */
static void fill_corners(decide_case *c, uint32_t triangle, uint64_t *random)
{
    const double half = ldexp(c->edge, -DECIDE_DEPTH - 1);
    for (unsigned axis = 0; axis < 3; ++axis) {
        const uint32_t base = 2 * (1 + below(random, (1u << DECIDE_DEPTH) - NEAR - 2));
        for (unsigned corner = 0; corner < 3; ++corner) {
            const size_t i = (size_t)triangle * 9 + (size_t)3 * corner + axis;
            const double place = base + below(random, 2 * NEAR) + (c->edge == 1.0 ? 0.0 : 0.25);
            const double x = nudged(c->origin[axis] + place * half, below(random, 4), c->params.is_double != 0);
            c->floats[i] = (float)x;
            c->positions[i] = c->params.is_double != 0 ? x : (double)c->floats[i];
        }
    }
}

/* Cells inside the triangle's bounds: on each axis that of a corner, or one between two. */
static void put_cells(decide_case *c, uint32_t triangle, uint64_t *random)
{
    const double *const at = c->positions + (size_t)triangle * 9;
    for (uint32_t k = 0; k < CELLS; ++k) {
        uint32_t cell[3];
        for (unsigned axis = 0; axis < 3; ++axis) {
            const uint32_t a = cell_of(c, at[3 * below(random, 3) + axis], axis);
            const uint32_t b = cell_of(c, at[3 * below(random, 3) + axis], axis);
            cell[axis] = (a + b) / 2;
        }
        const uint32_t place = DECIDE_ROOM - 1 - (triangle * CELLS + k);
        put_fragment(c->words + (size_t)place * c->word_count, c->word_count, code_of(cell), triangle);
    }
}

/* grid: 0: whole numbers, where corners meet planes; 1: numbers that round. */
static void fill_decide(decide_case *c, int coverage, bool is_double, unsigned grid)
{
    static const double origins[2][3] = {{0.0, 0.0, 0.0}, {0.1, -3.7, 1e3}};
    uint64_t random = 4 + 8 * (uint64_t)coverage + UINT64_C(2) * grid + (is_double ? 1 : 0);
    memcpy(c->origin, origins[grid], sizeof c->origin);
    c->edge = grid == 0 ? 1.0 : 5.3;
    c->params = (svo_decide_params){
        .capacity = DECIDE_ROOM, .coverage = (cl_uint)coverage, .is_double = is_double ? 1 : 0, .depth = DECIDE_DEPTH};
    put_double(c->edge, c->params.edge);
    memset(c->words, 0, sizeof c->words);
    for (unsigned axis = 0; axis < 3; ++axis) {
        put_double(c->origin[axis], c->params.origin + (size_t)2 * axis);
    }
    for (uint32_t triangle = 0; triangle < DECIDE_TRIANGLES; ++triangle) {
        fill_corners(c, triangle, &random);
        put_cells(c, triangle, &random);
        for (uint32_t corner = 0; corner < 3; ++corner) {
            c->indices[3 * triangle + corner] = 3 * triangle + corner;
        }
    }
    for (uint32_t i = 0; i < DECIDED; ++i) {
        put_fragment(c->words + (size_t)i * c->word_count, c->word_count, 77 * (uint64_t)i, i);
    }
    memcpy(c->counters, (const uint32_t[]){DECIDED, 0, UNDECIDED, 0}, sizeof c->counters);
}

static uint32_t coordinate_of(const uint32_t *words, uint32_t word_count, unsigned axis)
{
    const uint64_t code = (word_count == SVO_FRAGMENT_WORDS_48 ? (uint64_t)words[1] << 32 : 0) | words[0];
    uint32_t coordinate = 0;
    for (unsigned bit = 0; bit < 16; ++bit) {
        coordinate |= (uint32_t)(code >> (3 * bit + axis) & 1u) << bit;
    }
    return coordinate;
}

/* Marks the undecided fragments that do not touch, in integers alone. */
static void decide_on_host(decide_case *c)
{
    const void *const positions = c->params.is_double != 0 ? (const void *)c->positions : c->floats;
    for (uint32_t i = 0; i < UNDECIDED; ++i) {
        uint32_t *const words = c->words + (size_t)(DECIDE_ROOM - 1 - i) * c->word_count;
        uint32_t cell[3];
        for (unsigned axis = 0; axis < 3; ++axis) {
            cell[axis] = coordinate_of(words, c->word_count, axis);
        }
        svo_decided_pair pair;
        svo_load_pair(positions, c->indices, words[c->word_count - 1], cell, &c->params, &pair);
        if (!svo_pair_touches(&pair, &c->params, SVO_EXACT_ALL)) {
            words[c->word_count - 1] = SVO_NO_TRIANGLE;
        }
    }
}

/* Moves the fragments that touch to the end of the decided ones. */
static void keep_on_host(decide_case *c)
{
    for (uint32_t place = DECIDE_ROOM - UNDECIDED; place < DECIDE_ROOM; ++place) {
        const uint32_t *const words = c->words + (size_t)place * c->word_count;
        if (words[c->word_count - 1] != SVO_NO_TRIANGLE) {
            memcpy(c->words + (size_t)c->counters[0]++ * c->word_count, words, (size_t)c->word_count * 4);
        }
    }
}

static svo_status prove_decisions(svo_i_proof *proof, decide_case *c)
{
    svo_i_device_work *work = &proof->work;
    const void *const positions = c->params.is_double != 0 ? (const void *)c->positions : c->floats;
    const size_t bytes = (size_t)DECIDE_ROOM * c->word_count * 4;
    cl_mem given = NULL;
    cl_mem indices = NULL;
    cl_mem counters = NULL;
    cl_mem fragments = NULL;
    SVO_I_TRY(svo_i_work_constants(work, "proof", positions,
                                   c->params.is_double != 0 ? sizeof c->positions : sizeof c->floats, &given));
    SVO_I_TRY(svo_i_work_constants(work, "proof", c->indices, sizeof c->indices, &indices));
    SVO_I_TRY(svo_i_proof_buffer(proof, c->counters, sizeof c->counters, &counters));
    SVO_I_TRY(svo_i_proof_buffer(proof, c->words, bytes, &fragments));
    const svo_i_argument decides[] = {SVO_I_ARGUMENT(given), SVO_I_ARGUMENT(indices), SVO_I_ARGUMENT(counters),
                                      SVO_I_ARGUMENT(fragments), SVO_I_ARGUMENT(c->params)};
    const svo_i_argument keeps[] = {SVO_I_ARGUMENT(counters), SVO_I_ARGUMENT(fragments), SVO_I_ARGUMENT(c->params),
                                    SVO_I_LOCAL(sizeof(cl_uint) * SVO_GROUP_ITEMS)};
    SVO_I_TRY(svo_i_work_launch(work, "svo_k_decide", SVO_I_ARGUMENTS(decides), UINT64_C(2) * SVO_GROUP_ITEMS));
    decide_on_host(c);
    SVO_I_TRY(svo_i_proof_expect(proof, "svo_k_decide", fragments, c->words, bytes));
    SVO_I_TRY(svo_i_work_launch(work, "svo_k_keep_decided", SVO_I_ARGUMENTS(keeps), SVO_GROUP_ITEMS));
    keep_on_host(c);
    SVO_I_TRY(svo_i_proof_expect(proof, "svo_k_keep_decided", fragments, c->words, bytes));
    SVO_I_TRY(svo_i_proof_expect(proof, "svo_k_keep_decided", counters, c->counters, sizeof c->counters));
    svo_i_work_free(work, &fragments);
    svo_i_work_free(work, &counters);
    svo_i_work_free(work, &indices);
    svo_i_work_free(work, &given);
    return SVO_OK;
}

static svo_status prove_decide(svo_i_proof *proof, void *memory)
{
    static const struct {
        int coverage;
        bool is_double;
        unsigned grid;
    } rows[] = {{SVO_EXACT_HALF_OPEN, false, 0},
                {SVO_EXACT_HALF_OPEN, true, 1},
                {SVO_EXACT_CLOSED, true, 0},
                {SVO_EXACT_THIN, true, 0}};
    ((decide_case *)memory)->word_count = fragment_words(proof);
    for (unsigned i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
        fill_decide(memory, rows[i].coverage, rows[i].is_double, rows[i].grid);
        SVO_I_TRY(prove_decisions(proof, memory));
    }
    return SVO_OK;
}

svo_status svo_i_prove_decide(svo_device *device, const char *function, const svo_i_program_entry *made,
                              const char **wrong)
{
    return svo_i_proof_run(device, function, made, wrong, sizeof(decide_case), prove_decide);
}
