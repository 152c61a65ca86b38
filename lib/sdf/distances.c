/* SPDX-License-Identifier: MIT */
/*
 * svo_i_sdf_find: candidates from the root down to bricks, breadth-first (kernels/sdf/refine.cl), then the distances of
 * the bricks' voxels (distance.cl). From a few levels below the root on it goes batch by batch, so that scratch stays
 * bounded: a batch whose candidates are too many is made of half as many cells.
 */
#include "sdf/distances.h"

#include <math.h>
#include <string.h>

#include "sdf/programs.h"
#include "shared/sdf_layout.h"
#include "shared/solid_layout.h"

/* Cells of this level make up batches, or where the grid is large those that are so many levels above the leaves. */
#define BATCH_LEVEL        3
#define BATCH_LEVELS_BELOW 8

/* The margin of the reach over the band. */
#define REACH_MARGIN 0x1p-16F

/* Bytes of a cell or a candidate. */
#define PLACE_BYTES (4 * sizeof(cl_int))

/* Cells of one level and the nodes of that level that may be nearest. Scratch of the work. */
typedef struct cell_list {
    cl_mem cells; /* places */
    cl_mem begin; /* where each one's candidates begin, and where the last one's end */
    cl_mem candidates; /* places and indices of nodes */
    uint32_t count;
} cell_list;

typedef struct maker {
    svo_i_device_work *work;
    const svo_tree *tree;
    const svo_i_sdf_signs *signs;
    svo_sdf *sdf;
    svo_sdf_params params;
    uint64_t batch_bytes;
    uint64_t capacity; /* of the field's buffers */
} maker;

/* ---- lists of cells ---- */

static svo_status allocate_list(maker *m, uint64_t cells, uint64_t candidates, cell_list *out)
{
    *out = (cell_list){.count = (uint32_t)cells};
    SVO_I_TRY(svo_i_work_alloc(m->work, "sdf_cells", cells * PLACE_BYTES, &out->cells));
    SVO_I_TRY(svo_i_work_alloc(m->work, "sdf_begin", (cells + 1) * sizeof(cl_uint), &out->begin));
    return svo_i_work_alloc(m->work, "sdf_candidates", candidates * PLACE_BYTES, &out->candidates);
}

static void free_list(maker *m, cell_list *list)
{
    svo_i_work_free(m->work, &list->cells);
    svo_i_work_free(m->work, &list->begin);
    svo_i_work_free(m->work, &list->candidates);
}

/* The root, which is its own candidate. */
static svo_status begin_list(maker *m, cell_list *out)
{
    static const cl_uint begin[2] = {0, 1};
    SVO_I_TRY(allocate_list(m, 1, 1, out));
    SVO_I_TRY(svo_i_work_fill_zero(m->work, out->cells, PLACE_BYTES));
    SVO_I_TRY(svo_i_work_fill_zero(m->work, out->candidates, PLACE_BYTES));
    return svo_i_work_write(m->work, out->begin, begin, sizeof begin);
}

/* What a division of cells needs until its lists are written. Scratch of the work. */
typedef struct division {
    cl_mem bounds, counts, exist, sums, places;
    cl_uint candidates, cells; /* of the children */
} division;

static void free_division(maker *m, division *d)
{
    svo_i_work_free(m->work, &d->bounds);
    svo_i_work_free(m->work, &d->counts);
    svo_i_work_free(m->work, &d->exist);
    svo_i_work_free(m->work, &d->sums);
    svo_i_work_free(m->work, &d->places);
}

/* Counts the candidates of all children. */
static svo_status count_children(maker *m, const cell_list *from, division *d)
{
    const uint64_t children = UINT64_C(8) * m->params.count;
    SVO_I_TRY(svo_i_work_alloc(m->work, "sdf_bounds", children * sizeof(cl_float), &d->bounds));
    SVO_I_TRY(svo_i_work_alloc(m->work, "sdf_counts", children * sizeof(cl_uint), &d->counts));
    SVO_I_TRY(svo_i_work_alloc(m->work, "sdf_exist", children * sizeof(cl_uint), &d->exist));
    SVO_I_TRY(svo_i_work_alloc(m->work, "sdf_sums", (children + 1) * sizeof(cl_uint), &d->sums));
    SVO_I_TRY(svo_i_work_alloc(m->work, "sdf_places", (children + 1) * sizeof(cl_uint), &d->places));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(m->tree->buffers[SVO_TREE_CHILD_MASK]),
                                        SVO_I_ARGUMENT(from->cells),
                                        SVO_I_ARGUMENT(from->begin),
                                        SVO_I_ARGUMENT(from->candidates),
                                        SVO_I_ARGUMENT(d->bounds),
                                        SVO_I_ARGUMENT(d->counts),
                                        SVO_I_ARGUMENT(d->exist),
                                        SVO_I_ARGUMENT(m->params)};
    SVO_I_TRY(svo_i_work_launch(m->work, "svo_k_sdf_count", SVO_I_ARGUMENTS(arguments), children));
    SVO_I_TRY(svo_i_work_scan(m->work, d->counts, d->sums, children));
    SVO_I_TRY(svo_i_work_scan(m->work, d->exist, d->places, children));
    SVO_I_TRY(svo_i_work_read_later(m->work, d->sums, children * sizeof(cl_uint), &d->candidates, sizeof(cl_uint)));
    return svo_i_work_read(m->work, d->places, children * sizeof(cl_uint), &d->cells, sizeof(cl_uint));
}

/* Whether so many cells and candidates are too many for a batch. A cell's voxels, if it is a brick, have distances. */
static bool is_too_large(const maker *m, const division *d)
{
    const bool is_last = m->params.level + 1 == m->params.depth - m->params.brick_log2;
    const uint64_t voxels = is_last && m->params.is_dense == 0 ? UINT64_C(1) << 3 * m->params.brick_log2 : 0;
    const uint64_t cell_bytes = PLACE_BYTES + sizeof(cl_uint) + voxels * 2 * sizeof(cl_float);
    return d->cells * cell_bytes + d->candidates * (uint64_t)PLACE_BYTES > m->batch_bytes;
}

static svo_status write_children(maker *m, const cell_list *from, const division *d, cell_list *out)
{
    SVO_I_TRY(allocate_list(m, d->cells, d->candidates, out));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(m->tree->buffers[SVO_TREE_CHILD_MASK]),
                                        SVO_I_ARGUMENT(m->tree->buffers[SVO_TREE_FIRST_CHILD]),
                                        SVO_I_ARGUMENT(from->cells),
                                        SVO_I_ARGUMENT(from->begin),
                                        SVO_I_ARGUMENT(from->candidates),
                                        SVO_I_ARGUMENT(d->bounds),
                                        SVO_I_ARGUMENT(d->sums),
                                        SVO_I_ARGUMENT(d->places),
                                        SVO_I_ARGUMENT(out->cells),
                                        SVO_I_ARGUMENT(out->begin),
                                        SVO_I_ARGUMENT(out->candidates),
                                        SVO_I_ARGUMENT(m->params)};
    return svo_i_work_launch(m->work, "svo_k_sdf_refine", SVO_I_ARGUMENTS(arguments), UINT64_C(8) * m->params.count);
}

/* Divides the cells first .. first + count - 1 of a level's list. too_large: receives whether they have too many
   children; then there is no new list. NULL: they may have any number. */
static svo_status divide(maker *m, const cell_list *from, uint32_t level, uint32_t first, uint32_t count,
                         bool *too_large, cell_list *out)
{
    division d = {.bounds = NULL};
    *out = (cell_list){.count = 0};
    m->params.level = level;
    m->params.first = first;
    m->params.count = count;
    SVO_I_TRY(count_children(m, from, &d));
    if (too_large != NULL) {
        *too_large = count > 1 && is_too_large(m, &d);
    }
    if (d.cells > 0 && (too_large == NULL || !*too_large)) {
        SVO_I_TRY(write_children(m, from, &d, out));
    }
    free_division(m, &d);
    return SVO_OK;
}

/* ---- the field ---- */

/* Makes the field's buffers of another size and keeps what they hold. */
static svo_status resize(maker *m, uint64_t voxels)
{
    static const size_t bytes[SVO_SDF_BUFFER_COUNT] = {SVO_I_SDF_DISTANCE_BYTES, SVO_I_SDF_CODE_BYTES};
    static const char *const names[SVO_SDF_BUFFER_COUNT] = {"sdf_distances", "sdf_codes"};
    const int count = m->params.is_dense != 0 ? 1 : SVO_SDF_BUFFER_COUNT;
    for (int i = 0; i < count && voxels > 0; ++i) {
        cl_mem held = m->sdf->buffers[i];
        cl_mem made = NULL;
        SVO_I_TRY(svo_i_work_result(m->work, names[i], voxels * bytes[i], &made));
        m->sdf->buffers[i] = made;
        const svo_status status =
            held == NULL ? SVO_OK : svo_i_work_copy(m->work, held, 0, made, 0, m->sdf->info.voxel_count * bytes[i]);
        svo_i_buffer_release(&held);
        SVO_I_TRY(status);
    }
    m->capacity = voxels;
    return SVO_OK;
}

/* Makes room for more voxels: at first for just these, then for as many again. */
static svo_status reserve(maker *m, uint64_t voxels)
{
    const uint64_t needed = m->sdf->info.voxel_count + voxels;
    if (needed > UINT32_MAX) {
        return svo_i_device_fail(m->tree->device, SVO_UNSUPPORTED, "%s: the band has more than %u voxels",
                                 m->work->function, UINT32_MAX);
    }
    return needed <= m->capacity ? SVO_OK : resize(m, m->capacity == 0 ? needed : needed + needed / 2);
}

/* Puts the voxels in the band after those of the batches before. counts: of each cell of a brick. */
static svo_status gather(maker *m, const cell_list *bricks, cl_mem distances, cl_mem counts, uint64_t cells)
{
    const cl_uint first = (cl_uint)m->sdf->info.voxel_count;
    cl_mem sums = NULL;
    cl_uint found = 0;
    SVO_I_TRY(svo_i_work_alloc(m->work, "sdf_sums", (cells + 1) * sizeof(cl_uint), &sums));
    SVO_I_TRY(svo_i_work_scan(m->work, counts, sums, cells));
    SVO_I_TRY(svo_i_work_read(m->work, sums, cells * sizeof(cl_uint), &found, sizeof found));
    SVO_I_TRY(reserve(m, found));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(bricks->cells),
                                        SVO_I_ARGUMENT(distances),
                                        SVO_I_ARGUMENT(sums),
                                        SVO_I_ARGUMENT(m->sdf->buffers[SVO_SDF_CODES]),
                                        SVO_I_ARGUMENT(m->sdf->buffers[SVO_SDF_DISTANCES]),
                                        SVO_I_ARGUMENT(first),
                                        SVO_I_ARGUMENT(m->params)};
    if (found > 0) {
        SVO_I_TRY(svo_i_work_launch(m->work, "svo_k_sdf_gather", SVO_I_ARGUMENTS(arguments), cells));
    }
    m->sdf->info.voxel_count += found;
    svo_i_work_free(m->work, &sums);
    return SVO_OK;
}

/* The distances of all voxels of bricks. */
static svo_status measure(maker *m, const cell_list *bricks)
{
    const svo_tree *tree = m->tree;
    const uint64_t cells = (uint64_t)bricks->count << 3 * (m->params.brick_log2 - 1);
    const cl_mem positions = tree->buffers[m->params.positions == SVO_SOLID_DOUBLES  ? SVO_TREE_POSITIONS_DOUBLE
                                           : m->params.positions == SVO_SOLID_FLOATS ? SVO_TREE_POSITIONS
                                                                                     : SVO_TREE_VERTICES];
    const bool is_dense = m->params.is_dense != 0;
    cl_mem distances = m->sdf->buffers[SVO_SDF_DISTANCES];
    cl_mem counts = NULL;
    m->params.count = bricks->count;
    if (!is_dense) {
        SVO_I_TRY(svo_i_work_alloc(m->work, "sdf_band", cells * 8 * sizeof(cl_float), &distances));
        SVO_I_TRY(svo_i_work_alloc(m->work, "sdf_counts", cells * sizeof(cl_uint), &counts));
    }
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(tree->buffers[SVO_TREE_CHILD_MASK]),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_FIRST_CHILD]),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_INDICES]),
                                        SVO_I_ARGUMENT(positions),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_LIST_BEGIN]),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_LIST]),
                                        SVO_I_ARGUMENT(m->signs->cells),
                                        SVO_I_ARGUMENT(m->signs->leaves),
                                        SVO_I_ARGUMENT(bricks->cells),
                                        SVO_I_ARGUMENT(bricks->begin),
                                        SVO_I_ARGUMENT(bricks->candidates),
                                        SVO_I_ARGUMENT(distances),
                                        SVO_I_ARGUMENT(counts),
                                        SVO_I_ARGUMENT(m->params)};
    SVO_I_TRY(svo_i_work_launch(m->work, "svo_k_sdf_distance", SVO_I_ARGUMENTS(arguments), cells));
    if (!is_dense) {
        SVO_I_TRY(gather(m, bricks, distances, counts, cells));
        svo_i_work_free(m->work, &distances);
        svo_i_work_free(m->work, &counts);
    }
    return SVO_OK;
}

/* ---- batches ---- */

/* Makes the distances below some cells of a list. too_large: receives whether they are too many; then nothing is
   made. */
static svo_status make_batch(maker *m, const cell_list *from, uint32_t level, uint32_t first, uint32_t count,
                             bool *too_large)
{
    const uint32_t last = m->params.depth - m->params.brick_log2;
    cell_list list;
    *too_large = false;
    SVO_I_TRY(divide(m, from, level, first, count, count > 1 ? too_large : NULL, &list));
    while (++level < last && list.count > 0) {
        cell_list below;
        SVO_I_TRY(divide(m, &list, level, 0, list.count, count > 1 ? too_large : NULL, &below));
        free_list(m, &list);
        list = below;
    }
    if (list.count > 0) {
        SVO_I_TRY(measure(m, &list));
        free_list(m, &list);
    }
    return SVO_OK;
}

static svo_status make_batches(maker *m, const cell_list *from, uint32_t level)
{
    uint32_t count = from->count;
    for (uint32_t first = 0; first < from->count;) {
        bool too_large = false;
        count = count < from->count - first ? count : from->count - first;
        SVO_I_TRY(make_batch(m, from, level, first, count, &too_large));
        if (too_large) {
            count = (count + 1) / 2;
        } else {
            first += count;
        }
    }
    return SVO_OK;
}

static svo_status make_all(maker *m)
{
    const uint32_t depth = m->params.depth;
    const uint32_t last = depth - m->params.brick_log2;
    const uint32_t whole =
        depth > BATCH_LEVEL + BATCH_LEVELS_BELOW ? depth - BATCH_LEVELS_BELOW : (uint32_t)BATCH_LEVEL;
    cell_list list;
    uint32_t level = 0;
    SVO_I_TRY(begin_list(m, &list));
    for (; level < whole && level < last && list.count > 0; ++level) {
        cell_list below;
        SVO_I_TRY(divide(m, &list, level, 0, list.count, NULL, &below));
        free_list(m, &list);
        list = below;
    }
    if (list.count == 0) {
        return SVO_OK;
    }
    const svo_status status = level < last ? make_batches(m, &list, level) : measure(m, &list);
    free_list(m, &list);
    return status;
}

/* ---- parameters ---- */

static void put_double(cl_uint words[2], double number)
{
    memcpy(words, &number, sizeof number);
}

static void set_params(maker *m)
{
    const svo_tree_info *info = &m->tree->info;
    const svo_sdf_info *asked = &m->sdf->info;
    const bool is_given = info->is_exact != 0 && info->positions != SVO_POSITIONS_ROUNDED;
    const bool is_dense = asked->band == 0.0F;
    m->params =
        (svo_sdf_params){.positions = !is_given                                   ? SVO_SOLID_SNAPPED
                                      : (info->positions == SVO_POSITIONS_DOUBLE) ? SVO_SOLID_DOUBLES
                                                                                  : SVO_SOLID_FLOATS,
                         .depth = info->depth,
                         .brick_log2 = info->depth < SVO_SDF_BRICK_LOG2_MAX ? info->depth : SVO_SDF_BRICK_LOG2_MAX,
                         .leaf_begin = (cl_uint)info->inner_count,
                         .is_signed = m->signs->cells != NULL,
                         .is_dense = is_dense,
                         .reach = is_dense ? INFINITY : asked->band * (1.0F + REACH_MARGIN),
                         .band = is_dense ? INFINITY : (float)(asked->spacing * (double)asked->band)};
    memcpy(m->params.origin, info->origin, sizeof m->params.origin);
    int exponent = 0;
    (void)frexp(asked->spacing, &exponent);
    put_double(m->params.voxel, asked->spacing);
    put_double(m->params.unit, ldexp(info->edge, -(int)info->snap_bits));
    put_double(m->params.raise, ldexp(1.0, 1 - exponent));
}

svo_status svo_i_sdf_find(svo_i_device_work *work, const svo_tree *tree, const svo_i_sdf_signs *signs,
                          uint64_t batch_bytes, svo_sdf *sdf)
{
    maker m = {.work = work, .tree = tree, .signs = signs, .sdf = sdf, .batch_bytes = batch_bytes};
    set_params(&m);
    SVO_I_TRY(svo_i_work_use(work, &svo_i_program_sdf, " -DSVO_SORT"));
    if (m.params.is_dense != 0) {
        SVO_I_TRY(resize(&m, UINT64_C(1) << 3 * m.params.depth));
        sdf->info.voxel_count = m.capacity;
        return make_all(&m);
    }
    SVO_I_TRY(make_all(&m));
    return m.capacity > sdf->info.voxel_count ? resize(&m, sdf->info.voxel_count) : SVO_OK;
}
