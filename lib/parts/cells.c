/* SPDX-License-Identifier: MIT */
/* Histograms of triangles over coarse cells. */
#include "parts/cells.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/memory.h"
#include "plan/estimate.h"
#include "svocl/nodes.h"

#define CAPACITY_LEAST 1024

/* Grid units by which a snapped triangle is off that which it stands for, and more. */
#define PLANE_SLACK 4.0
/* Relative errors of the plane's numbers are far below. */
#define PLANE_ERROR 1e-9

static uint64_t key_of(uint32_t level, uint64_t code)
{
    return code | UINT64_C(1) << 3 * level;
}

static uint32_t level_of(uint64_t key)
{
    uint32_t level = 0;
    for (uint64_t above = key >> 3; above > 0; above >>= 3) {
        ++level;
    }
    return level;
}

/* ---- triangles ---- */

void svo_i_placing_make(const svo_part_header *header, uint32_t level, const int32_t corners[3][3],
                        svo_i_placing *placing)
{
    const int32_t units = (int32_t)(1u << header->snap_bits);
    const uint32_t shift = header->snap_bits - level;
    /* Closed voxels contain their far faces: what lies on a common face meets both. */
    const int32_t closed = header->coverage == SVO_COVERAGE_CLOSED ? 1 : 0;
    uint32_t differing = 0;
    memcpy(placing->corners, corners, sizeof placing->corners);
    placing->level = level;
    placing->has_plane = false;
    for (unsigned axis = 0; axis < 3; ++axis) {
        int32_t low = corners[0][axis];
        int32_t high = low;
        for (unsigned corner = 1; corner < 3; ++corner) {
            const int32_t q = corners[corner][axis];
            low = q < low ? q : low;
            high = q > high ? q : high;
        }
        placing->first[axis] = (uint32_t)(low < closed ? 0 : low - closed) >> shift;
        placing->last[axis] = (uint32_t)(high >= units ? units - 1 : high) >> shift;
        differing |= placing->first[axis] ^ placing->last[axis];
    }
    placing->inside_level = level;
    for (; differing > 0; differing >>= 1) {
        --placing->inside_level;
    }
}

static void make_plane(svo_i_placing *placing)
{
    double edges[2][3];
    placing->plane = 0.0;
    for (unsigned axis = 0; axis < 3; ++axis) {
        for (unsigned i = 0; i < 2; ++i) {
            edges[i][axis] = (double)placing->corners[i + 1][axis] - (double)placing->corners[0][axis];
        }
    }
    for (unsigned axis = 0; axis < 3; ++axis) {
        const unsigned u = (axis + 1) % 3;
        const unsigned v = (axis + 2) % 3;
        placing->normal[axis] = edges[0][u] * edges[1][v] - edges[0][v] * edges[1][u];
        placing->plane += placing->normal[axis] * placing->corners[0][axis];
    }
    placing->has_plane = true;
}

/* Whether the plane of a triangle may meet a cell: the distance of the cell's middle from it against the cell's reach
   along the normal (Akenine-Moller, "Fast 3D Triangle-Box Overlap Testing", 2001). */
static bool plane_meets(const svo_i_placing *placing, uint32_t shift, const uint32_t cell[3])
{
    const double half = ldexp(1.0, (int)shift - 1);
    double distance = -placing->plane;
    double reach = 0.0;
    double size = fabs(placing->plane);
    for (unsigned axis = 0; axis < 3; ++axis) {
        const double middle = (2.0 * cell[axis] + 1.0) * half;
        distance += placing->normal[axis] * middle;
        reach += fabs(placing->normal[axis]) * (half + PLANE_SLACK);
        size += fabs(placing->normal[axis]) * middle;
    }
    return fabs(distance) <= reach + size * PLANE_ERROR;
}

bool svo_i_placing_meets(svo_i_placing *placing, uint32_t snap_bits, uint32_t level, const uint32_t cell[3])
{
    const uint32_t below = placing->level - level;
    for (unsigned axis = 0; axis < 3; ++axis) {
        if (cell[axis] < placing->first[axis] >> below || cell[axis] > placing->last[axis] >> below) {
            return false;
        }
    }
    if (level <= placing->inside_level) {
        return true;
    }
    if (!placing->has_plane) {
        make_plane(placing);
    }
    return plane_meets(placing, snap_bits - level, cell);
}

/* ---- sums ---- */

static uint64_t add_up_to_most(uint64_t a, uint64_t b)
{
    return a + b >= a ? a + b : UINT64_MAX;
}

static void add_sums(svo_i_cell_sums *to, const svo_i_cell_sums *from)
{
    to->count += from->count;
    to->widths = add_up_to_most(to->widths, from->widths);
    to->doubled_areas = add_up_to_most(to->doubled_areas, from->doubled_areas);
}

/* What a triangle is in a cell. */
static svo_i_cell_sums sums_in(const svo_i_placing *placing, uint32_t snap_bits, uint32_t level, const uint32_t cell[3])
{
    svo_i_cell_sums sums = {.count = 1};
    int32_t corners[3][3];
    const uint32_t shift = snap_bits - level;
    for (unsigned i = 0; i < 9; ++i) {
        corners[i / 3][i % 3] = placing->corners[i / 3][i % 3] - (int32_t)(cell[i % 3] << shift);
    }
    svo_i_estimate_sums((const int32_t(*)[3])corners, shift, &sums.widths, &sums.doubled_areas);
    return sums;
}

/* ---- the table ---- */

static svo_i_cell *slot_of(const svo_i_cells *cells, uint64_t key)
{
    size_t at = (size_t)(key * UINT64_C(0x9e3779b97f4a7c15) >> 32) & (cells->capacity - 1);
    while (cells->slots[at].key != 0 && cells->slots[at].key != key) {
        at = (at + 1) & (cells->capacity - 1);
    }
    return &cells->slots[at];
}

/* Moves the cells to another table. level: the deepest that stays, or the one above it. */
static bool rehash(svo_i_cells *cells, size_t capacity, uint32_t level)
{
    const svo_i_cells old = *cells;
    svo_i_cells made = {
        .slots = svo_i_alloc_zeroed(NULL, capacity, sizeof *made.slots), .capacity = capacity, .level = level};
    if (made.slots == NULL) {
        return false;
    }
    for (size_t i = 0; i < old.capacity; ++i) {
        if (old.slots[i].key != 0 && level_of(old.slots[i].key) <= level) {
            *slot_of(&made, old.slots[i].key) = old.slots[i];
            ++made.count;
        }
    }
    for (size_t i = 0; i < old.capacity; ++i) {
        if (old.slots[i].key != 0 && level_of(old.slots[i].key) > level) {
            add_sums(&slot_of(&made, old.slots[i].key >> 3)->inside, &old.slots[i].inside);
        }
    }
    svo_i_free(old.slots);
    *cells = made;
    return true;
}

/* The cell, which is made with those above it where it is not there. NULL: out of memory. */
static svo_i_cell *cell_of(svo_i_cells *cells, uint64_t key)
{
    if (2 * cells->count >= cells->capacity) {
        if (!rehash(cells, cells->capacity == 0 ? CAPACITY_LEAST : 2 * cells->capacity, cells->level)) {
            return NULL;
        }
    }
    svo_i_cell *found = slot_of(cells, key);
    if (found->key == 0) {
        found->key = key;
        ++cells->count;
        if (key > 1 && cell_of(cells, key >> 3) == NULL) {
            return NULL;
        }
        found = slot_of(cells, key); /* the table may have grown */
    }
    return found;
}

/* Adds a triangle to the cells below one that it meets. */
static bool add_across(svo_i_cells *cells, uint32_t snap_bits, svo_i_placing *placing, uint32_t level,
                       const uint32_t above[3])
{
    for (uint32_t octant = 0; octant < 8; ++octant) {
        const uint32_t cell[3] = {2 * above[0] + (octant & 1u), 2 * above[1] + (octant >> 1 & 1u),
                                  2 * above[2] + (octant >> 2 & 1u)};
        if (!svo_i_placing_meets(placing, snap_bits, level, cell)) {
            continue;
        }
        svo_i_cell *found = cell_of(cells, key_of(level, svo_cell_to_code(cell)));
        if (found == NULL) {
            return false;
        }
        const svo_i_cell_sums sums = sums_in(placing, snap_bits, level, cell);
        add_sums(&found->across, &sums);
        if (level < cells->level && !add_across(cells, snap_bits, placing, level + 1, cell)) {
            return false;
        }
    }
    return true;
}

bool svo_i_cells_add(svo_i_cells *cells, uint32_t snap_bits, svo_i_placing *placing)
{
    uint32_t cell[3];
    uint32_t level = placing->inside_level < cells->level ? placing->inside_level : cells->level;
    for (unsigned axis = 0; axis < 3; ++axis) {
        cell[axis] = placing->first[axis] >> (placing->level - level);
    }
    svo_i_cell *found = cell_of(cells, key_of(level, svo_cell_to_code(cell)));
    if (found == NULL) {
        return false;
    }
    static const uint32_t whole[3] = {0};
    const svo_i_cell_sums sums = sums_in(placing, snap_bits, 0, whole);
    add_sums(&found->inside, &sums);
    if (level < cells->level && !add_across(cells, snap_bits, placing, level + 1, cell)) {
        return false;
    }
    while (cells->count > CELLS_MAX && cells->level > 0) {
        if (!rehash(cells, cells->capacity, cells->level - 1)) {
            return false;
        }
    }
    return true;
}

void svo_i_cells_free(svo_i_cells *cells)
{
    svo_i_free(cells->slots);
    *cells = (svo_i_cells){.slots = NULL};
}

/* ---- lists ---- */

static int compare_keys(const void *a, const void *b)
{
    const svo_i_cell *first = a;
    const svo_i_cell *second = b;
    return first->key < second->key ? -1 : first->key > second->key;
}

void svo_i_cell_list_take(svo_i_cells *cells, svo_i_cell_list *list)
{
    size_t count = 0;
    for (size_t i = 0; i < cells->capacity; ++i) {
        if (cells->slots[i].key != 0) {
            cells->slots[count++] = cells->slots[i];
        }
    }
    if (count > 0) {
        qsort(cells->slots, count, sizeof *cells->slots, compare_keys);
    }
    *list = (svo_i_cell_list){.cells = cells->slots, .count = count, .level = cells->level};
    *cells = (svo_i_cells){.slots = NULL};
}

static svo_i_cell *find(const svo_i_cell_list *list, uint64_t key)
{
    const svo_i_cell asked = {.key = key};
    return list->count > 0 ? bsearch(&asked, list->cells, list->count, sizeof asked, compare_keys) : NULL;
}

/* Drops the cells below a level; what lies in them lies in those above. */
static void cut_list(svo_i_cell_list *list, uint32_t level)
{
    for (; list->count > 0 && level_of(list->cells[list->count - 1].key) > level; --list->count) {
        const svo_i_cell *last = &list->cells[list->count - 1];
        svo_i_cell *above = find(list, last->key >> 3);
        if (above != NULL) {
            add_sums(&above->inside, &last->inside);
        }
    }
    list->level = list->level < level ? list->level : level;
}

bool svo_i_cell_list_add(svo_i_cell_list *to, const svo_i_cell_list *from)
{
    svo_i_cell_list sum = {.level = to->level > from->level ? to->level : from->level};
    const uint32_t least = to->level < from->level ? to->level : from->level;
    sum.cells = svo_i_alloc(NULL, (to->count + from->count + 1) * sizeof *sum.cells);
    if (sum.cells == NULL) {
        return false;
    }
    for (size_t i = 0, k = 0; i < to->count || k < from->count;) {
        const bool takes_own = k == from->count || (i < to->count && to->cells[i].key <= from->cells[k].key);
        const bool takes_other = i == to->count || (k < from->count && from->cells[k].key <= to->cells[i].key);
        svo_i_cell *cell = &sum.cells[sum.count++];
        *cell = takes_own ? to->cells[i] : from->cells[k];
        if (takes_own && takes_other) {
            add_sums(&cell->inside, &from->cells[k].inside);
            add_sums(&cell->across, &from->cells[k].across);
        }
        i += takes_own ? 1u : 0u;
        k += takes_other ? 1u : 0u;
    }
    svo_i_free(to->cells);
    *to = sum;
    cut_list(to, least);
    while (to->count > CELLS_MAX && to->level > 0) {
        cut_list(to, to->level - 1);
    }
    return true;
}

/* Cells come after those above, so the last is complete when it is added to the one above. */
void svo_i_cell_list_total(svo_i_cell_list *list)
{
    for (size_t i = list->count; i-- > 1;) {
        svo_i_cell *above = find(list, list->cells[i].key >> 3);
        if (above != NULL) {
            add_sums(&above->inside, &list->cells[i].inside);
        }
    }
}

svo_i_cell_sums svo_i_cell_list_find(const svo_i_cell_list *list, uint32_t level, uint64_t code)
{
    svo_i_cell_sums sums = {.count = 0};
    const svo_i_cell *found = find(list, key_of(level, code));
    if (found != NULL) {
        sums = found->inside;
        add_sums(&sums, &found->across);
    }
    return sums;
}

bool svo_i_cell_list_is_whole(const svo_i_cell_list *list)
{
    if (list->level > CELLS_LEVEL_MAX || list->count > CELLS_MAX || (list->count > 0 && list->cells[0].key != 1)) {
        return false;
    }
    for (size_t i = 1; i < list->count; ++i) {
        const uint64_t key = list->cells[i].key;
        if (key <= list->cells[i - 1].key || level_of(key) > list->level || find(list, key >> 3) == NULL) {
            return false;
        }
    }
    return true;
}
