/* SPDX-License-Identifier: MIT */
/*
 * The surface of a list as a mesh of rectangles, .ply or .obj. Faces behind which there is no voxel are merged: those
 * of one row first, then rows with the next, as long as plane and color are the same. The sides of a rectangle may end
 * in the middle of another one's (T-junctions).
 *
 * Built on the list's grid, the mesh gives the list's voxels and no others. A voxel has its near faces and not its far
 * ones (half-open coverage). So each voxel is a body that ends a little below its far planes, and a gap between bodies
 * is filled where all voxels around it are there: 2 at a face, 4 at an edge, 8 at a corner. What is written is the
 * surface of that solid. It is closed, and it touches no voxel that is not there.
 */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/voxels_formats.h"

#define INSET           0x1p-20 /* how far below a plane, in voxels */
#define STEPS_MIN       4.0 /* floats between two planes, at least */
#define POSITION_DIGITS 9 /* give every float back */
#define PLY_FACES_MAX   ((uint64_t)INT32_MAX / 4)

/*
 * A cell of a face in its plane. Of direction 2 a + s it is that of axis a on its low (0) or high (1) side; u is axis
 * a + 1 and v is axis a + 2, modulo 3. Along both, the body of voxel k, counted from the list's least, is cell 2 k, and
 * the gap behind it is cell 2 k + 1.
 */
typedef struct cell {
    int32_t plane; /* of the voxel */
    uint32_t v, u;
    uint8_t rgba[4];
} cell;

typedef struct rectangle {
    int32_t plane; /* of its voxels */
    uint32_t low[2], high[2]; /* cells along u and v */
    uint8_t rgba[4];
    uint8_t direction;
} rectangle;

typedef struct faces_writer {
    voxel_writer *out;
    bool is_exact; /* planes are doubles, so that a face may lie on one */
    cell *cells; /* of one direction; owned, as what follows */
    size_t cell_count, cell_capacity;
    size_t *open, *row; /* rectangles of the row before and of this one, by u */
    size_t open_count, row_count, row_capacity;
    rectangle *rectangles;
    size_t rectangle_count, rectangle_capacity;
} faces_writer;

/* Makes room for one more element. */
static svo_status make_room(const faces_writer *w, void **list, size_t count, size_t *capacity, size_t element_bytes)
{
    size_t bytes = 0;
    if (count < *capacity) {
        return SVO_OK;
    }
    const size_t larger = 2 * *capacity + 256;
    void *grown = svo_i_mul_size(larger, element_bytes, &bytes) ? svo_i_grow(w->out->memory, *list, bytes) : NULL;
    if (grown == NULL) {
        return svo_i_voxels_write_fail(w->out, SVO_OUT_OF_HOST_MEMORY, "no memory for %zu parts of faces", larger);
    }
    *list = grown;
    *capacity = larger;
    return SVO_OK;
}

/* ---- cells ---- */

/* The voxels around one whose face is looked at: in its layer, by du, dv + 1; and whether that face of them shows. */
typedef struct layer {
    bool is_filled[3][3];
    bool shows[3][3];
} layer;

static layer look_around(const faces_writer *w, const svo_voxel *voxel, unsigned direction)
{
    layer found;
    const unsigned axis = direction / 2;
    for (int i = 0; i < 9; ++i) {
        int32_t at[3] = {voxel->x, voxel->y, voxel->z};
        at[(axis + 1) % 3] += i / 3 - 1;
        at[(axis + 2) % 3] += i % 3 - 1;
        const bool is_filled = i == 4 || svo_i_voxels_has(w->out, at);
        at[axis] += direction % 2 != 0 ? 1 : -1;
        found.is_filled[i / 3][i % 3] = is_filled;
        found.shows[i / 3][i % 3] = is_filled && !svo_i_voxels_has(w->out, at);
    }
    return found;
}

/* Whether the gap on a side of the voxel, du and dv, is part of the face and no other voxel's that is looked at: the
   first that shows of those around it has it, by v and then by u. */
static bool has_gap(const layer *around, int du, int dv)
{
    const int low_u = du < 0 ? -1 : 0;
    const int high_u = du > 0 ? 1 : 0;
    const int low_v = dv < 0 ? -1 : 0;
    const int high_v = dv > 0 ? 1 : 0;
    bool is_first = true;
    for (int v = low_v; v <= high_v; ++v) {
        for (int u = low_u; u <= high_u; ++u) {
            const bool is_before = v < 0 || (v == 0 && u < 0);
            if (!around->is_filled[u + 1][v + 1]) {
                return false;
            }
            is_first = is_first && !(is_before && around->shows[u + 1][v + 1]);
        }
    }
    return is_first;
}

/* Adds the cells of a voxel's face, if it shows: its body and gaps around it. */
static svo_status add_face(faces_writer *w, const svo_voxel *voxel, unsigned direction)
{
    const unsigned axis = direction / 2;
    const unsigned u = (axis + 1) % 3;
    const unsigned v = (axis + 2) % 3;
    const int32_t place[3] = {voxel->x, voxel->y, voxel->z};
    int32_t behind[3] = {voxel->x, voxel->y, voxel->z};
    behind[axis] += direction % 2 != 0 ? 1 : -1;
    if (svo_i_voxels_has(w->out, behind)) {
        return SVO_OK;
    }
    const layer around = look_around(w, voxel, direction);
    ++w->out->info.voxel_faces;
    for (int i = 0; i < 9; ++i) {
        const int du = i / 3 - 1;
        const int dv = i % 3 - 1;
        if ((du != 0 || dv != 0) && !has_gap(&around, du, dv)) {
            continue;
        }
        SVO_I_TRY(make_room(w, (void **)&w->cells, w->cell_count, &w->cell_capacity, sizeof *w->cells));
        cell *added = &w->cells[w->cell_count++];
        *added = (cell){.plane = place[axis],
                        .v = (uint32_t)(2 * (place[v] - w->out->list.low[v]) + dv),
                        .u = (uint32_t)(2 * (place[u] - w->out->list.low[u]) + du)};
        memcpy(added->rgba, voxel->rgba, sizeof added->rgba);
    }
    return SVO_OK;
}

static int compare_cells(const void *a, const void *b)
{
    const cell *left = a;
    const cell *right = b;
    return left->plane != right->plane ? (left->plane > right->plane) - (left->plane < right->plane)
           : left->v != right->v       ? (left->v > right->v) - (left->v < right->v)
                                       : (left->u > right->u) - (left->u < right->u);
}

/* The cells of a direction, row by row. */
static svo_status collect_cells(faces_writer *w, unsigned direction)
{
    w->cell_count = 0;
    for (uint64_t i = 0; i < w->out->list.voxel_count; ++i) {
        SVO_I_TRY(add_face(w, &w->out->voxels[i], direction));
    }
    if (w->cell_count > 0) {
        qsort(w->cells, w->cell_count, sizeof *w->cells, compare_cells);
    }
    return SVO_OK;
}

/* ---- rectangles ---- */

/* The cells from the first on that are side by side in its row and have its color. */
static size_t run_length(const faces_writer *w, size_t first)
{
    const cell *begin = &w->cells[first];
    size_t count = 1;
    for (; first + count < w->cell_count; ++count) {
        const cell *next = &begin[count];
        if (next->plane != begin->plane || next->v != begin->v || next->u != begin->u + count ||
            memcmp(next->rgba, begin->rgba, sizeof next->rgba) != 0) {
            break;
        }
    }
    return count;
}

/* The rectangle of the row before that a run continues, or NULL. *at: the first open one that may be it. */
static rectangle *find_open(faces_writer *w, const rectangle *run, size_t *at)
{
    while (*at < w->open_count && w->rectangles[w->open[*at]].low[0] < run->low[0]) {
        ++*at;
    }
    rectangle *before = *at < w->open_count ? &w->rectangles[w->open[*at]] : NULL;
    const bool continues = before != NULL && before->plane == run->plane && before->high[1] == run->low[1] &&
                           before->low[0] == run->low[0] && before->high[0] == run->high[0] &&
                           memcmp(before->rgba, run->rgba, sizeof run->rgba) == 0;
    return continues ? before : NULL;
}

/* Makes a rectangle of a run, or adds it to the one of the row before. */
static svo_status place_run(faces_writer *w, const rectangle *run, size_t *at)
{
    rectangle *before = find_open(w, run, at);
    if (before != NULL) {
        before->high[1] = run->high[1];
        w->row[w->row_count++] = w->open[*at];
        return SVO_OK;
    }
    SVO_I_TRY(make_room(w, (void **)&w->rectangles, w->rectangle_count, &w->rectangle_capacity, sizeof *w->rectangles));
    w->row[w->row_count++] = w->rectangle_count;
    w->rectangles[w->rectangle_count++] = *run;
    return SVO_OK;
}

/* Makes room for a row of so many runs; rows of earlier directions are over. */
static svo_status make_rows(faces_writer *w, size_t count)
{
    w->open_count = w->row_count = 0;
    if (count <= w->row_capacity) {
        return SVO_OK;
    }
    svo_i_free(w->open);
    svo_i_free(w->row);
    w->open = svo_i_alloc(w->out->memory, count * sizeof *w->open);
    w->row = svo_i_alloc(w->out->memory, count * sizeof *w->row);
    w->row_capacity = count;
    return w->open != NULL && w->row != NULL
               ? SVO_OK
               : svo_i_voxels_write_fail(w->out, SVO_OUT_OF_HOST_MEMORY, "no memory for rows of %zu rectangles", count);
}

/* The most cells of one row. */
static size_t longest_row(const faces_writer *w)
{
    size_t longest = 0;
    for (size_t first = 0, i = 0; i < w->cell_count; ++i) {
        first = w->cells[i].v != w->cells[first].v || w->cells[i].plane != w->cells[first].plane ? i : first;
        longest = i - first + 1 > longest ? i - first + 1 : longest;
    }
    return longest;
}

static void end_row(faces_writer *w)
{
    size_t *swapped = w->open;
    w->open = w->row;
    w->open_count = w->row_count;
    w->row = swapped;
    w->row_count = 0;
}

static svo_status merge_cells(faces_writer *w, unsigned direction)
{
    size_t at = 0;
    SVO_I_TRY(make_rows(w, longest_row(w)));
    for (size_t first = 0; first < w->cell_count;) {
        const uint32_t count = (uint32_t)run_length(w, first);
        const cell *begin = &w->cells[first];
        rectangle run = {.plane = begin->plane,
                         .low = {begin->u, begin->v},
                         .high = {begin->u + count, begin->v + 1},
                         .direction = (uint8_t)direction};
        memcpy(run.rgba, begin->rgba, sizeof run.rgba);
        SVO_I_TRY(place_run(w, &run, &at));
        first += count;
        if (first == w->cell_count || w->cells[first].v != begin->v || w->cells[first].plane != begin->plane) {
            end_row(w);
            at = 0;
        }
    }
    return SVO_OK;
}

static svo_status find_rectangles(faces_writer *w)
{
    for (unsigned direction = 0; direction < 6; ++direction) {
        SVO_I_TRY(collect_cells(w, direction));
        SVO_I_TRY(merge_cells(w, direction));
    }
    w->out->info.faces = w->rectangle_count;
    return SVO_OK;
}

/* ---- places ---- */

/* The sum of two doubles: sum + rest is exactly it (Knuth, "The Art of Computer Programming", volume 2). */
static double add_exactly(double a, double b, double *rest)
{
    const double sum = a + b;
    const double of_b = sum - a;
    *rest = (a - (sum - of_b)) + (b - of_b);
    return sum;
}

/* The least float at or above value + rest; the greatest at or below it. */
static float float_above(double value, double rest)
{
    const float nearest = (float)value;
    const bool is_below = (double)nearest < value || ((double)nearest == value && rest > 0.0);
    return is_below ? nextafterf(nearest, INFINITY) : nearest;
}

static float float_below(double value, double rest)
{
    return -float_above(-value, -rest);
}

/* Whether a coordinate of the file is turned round when it is read with the axes that the file was written for. */
static bool is_turned_round(const faces_writer *w, int axis)
{
    return w->out->is_turned && axis == 1;
}

/* A coordinate in the world: of the plane at the low side of the voxels at that place. is_below: below the plane, so
   that it belongs to the voxels before. */
static float world_place(const faces_writer *w, int axis, int32_t place, bool is_below)
{
    const svo_voxels_info *list = &w->out->list;
    const bool moves = !w->is_exact || is_below != is_turned_round(w, axis);
    const double inset = moves ? list->voxel_edge * INSET : 0.0;
    double rest = 0.0;
    const double plane = add_exactly(list->origin[axis], (double)place * list->voxel_edge, &rest);
    return is_below ? float_below(plane - inset, rest) : float_above(plane + inset, rest);
}

/* Fails where floats cannot tell the planes apart. */
static svo_status check_places(const faces_writer *w)
{
    const svo_voxels_info *list = &w->out->list;
    double farthest = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
        farthest = fmax(farthest, fabs(svo_i_voxels_world(w->out, axis, (double)list->low[axis])));
        farthest = fmax(farthest, fabs(svo_i_voxels_world(w->out, axis, (double)list->high[axis])));
    }
    const float at = (float)farthest;
    const double step = (double)nextafterf(at, INFINITY) - (double)at;
    return isfinite(step) && step * STEPS_MIN <= list->voxel_edge
               ? SVO_OK
               : svo_i_voxels_write_fail(w->out, SVO_INVALID_ARGUMENT,
                                         "voxels of width %g lie at up to %g, where floats are %g apart",
                                         list->voxel_edge, farthest, step);
}

/* Where a cell begins: bodies on the plane of their voxel, gaps below the plane of the next. */
static float cell_place(const faces_writer *w, int axis, uint32_t index)
{
    return world_place(w, axis, w->out->list.low[axis] + (int32_t)((index + 1) / 2), index % 2 != 0);
}

/* The corners, counterclockwise from outside. */
static void find_corners(const faces_writer *w, const rectangle *r, float corners[4][3])
{
    static const uint8_t sides[2][4] = {{0, 2, 3, 1}, {0, 1, 3, 2}}; /* bit 0: of u, bit 1: of v */
    const int axis = r->direction / 2;
    const bool is_far = r->direction % 2 != 0;
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    for (int i = 0; i < 4; ++i) {
        const uint8_t side = sides[is_far ? 1 : 0][i];
        corners[i][axis] = world_place(w, axis, is_far ? r->plane + 1 : r->plane, is_far);
        corners[i][u] = cell_place(w, u, (side & 1u) != 0 ? r->high[0] : r->low[0]);
        corners[i][v] = cell_place(w, v, (side & 2u) != 0 ? r->high[1] : r->low[1]);
    }
}

/* ---- files ---- */

static svo_status put_ply(faces_writer *w)
{
    char head[512];
    const uint64_t count = w->rectangle_count;
    if (count > PLY_FACES_MAX) {
        return svo_i_voxels_write_fail(w->out, SVO_INVALID_ARGUMENT,
                                       "%" PRIu64 " rectangles are above the limit of %" PRIu64 " for .ply", count,
                                       PLY_FACES_MAX);
    }
    const int length = snprintf(head, sizeof head,
                                "ply\nformat binary_little_endian 1.0\nelement vertex %" PRIu64
                                "\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n"
                                "property uchar green\nproperty uchar blue\nproperty uchar alpha\nelement face %" PRIu64
                                "\nproperty list uchar int vertex_indices\nend_header\n",
                                4 * count, count);
    SVO_I_TRY(svo_i_voxels_put(w->out, head, (size_t)length));
    for (size_t i = 0; i < count; ++i) {
        float corners[4][3];
        find_corners(w, &w->rectangles[i], corners);
        for (int corner = 0; corner < 4; ++corner) {
            SVO_I_TRY(svo_i_voxels_put(w->out, corners[corner], sizeof corners[corner]));
            SVO_I_TRY(svo_i_voxels_put(w->out, w->rectangles[i].rgba, sizeof w->rectangles[i].rgba));
        }
    }
    for (uint32_t i = 0; i < count; ++i) {
        const uint8_t corner_count = 4;
        const uint32_t indices[4] = {4 * i, 4 * i + 1, 4 * i + 2, 4 * i + 3};
        SVO_I_TRY(svo_i_voxels_put(w->out, &corner_count, sizeof corner_count));
        SVO_I_TRY(svo_i_voxels_put(w->out, indices, sizeof indices));
    }
    return SVO_OK;
}

static svo_status put_obj_corner(faces_writer *w, const float corner[3], const uint8_t rgba[4])
{
    char line[6 * VOXEL_NUMBER_BYTES + 8];
    char text[6][VOXEL_NUMBER_BYTES];
    for (int i = 0; i < 3; ++i) {
        (void)svo_i_voxel_number(text[i], (double)corner[i], POSITION_DIGITS);
        (void)svo_i_voxel_number(text[3 + i], rgba[i] / 255.0, POSITION_DIGITS);
    }
    const int length =
        snprintf(line, sizeof line, "v %s %s %s %s %s %s\n", text[0], text[1], text[2], text[3], text[4], text[5]);
    return svo_i_voxels_put(w->out, line, (size_t)length);
}

static svo_status put_obj(faces_writer *w)
{
    char line[160];
    const uint64_t count = w->rectangle_count;
    int length = snprintf(line, sizeof line, "# %" PRIu64 " voxels; %" PRIu64 " rectangles; v x y z red green blue\n",
                          w->out->list.voxel_count, count);
    SVO_I_TRY(svo_i_voxels_put(w->out, line, (size_t)length));
    for (uint64_t i = 0; i < count; ++i) {
        float corners[4][3];
        find_corners(w, &w->rectangles[i], corners);
        for (int corner = 0; corner < 4; ++corner) {
            SVO_I_TRY(put_obj_corner(w, corners[corner], w->rectangles[i].rgba));
        }
        length = snprintf(line, sizeof line, "f %" PRIu64 " %" PRIu64 " %" PRIu64 " %" PRIu64 "\n", 4 * i + 1,
                          4 * i + 2, 4 * i + 3, 4 * i + 4);
        SVO_I_TRY(svo_i_voxels_put(w->out, line, (size_t)length));
    }
    return SVO_OK;
}

svo_status svo_i_voxels_write_faces(voxel_writer *writer, svo_voxel_format format)
{
    int exponent = 0;
    svo_status status = SVO_OK;
    faces_writer w = {.out = writer, .is_exact = frexp(writer->list.voxel_edge, &exponent) == 0.5};
    SVO_I_TRY_CLEANUP(check_places(&w));
    SVO_I_TRY_CLEANUP(find_rectangles(&w));
    SVO_I_TRY_CLEANUP(format == SVO_VOXEL_FORMAT_PLY ? put_ply(&w) : put_obj(&w));
cleanup:
    svo_i_free(w.cells);
    svo_i_free(w.open);
    svo_i_free(w.row);
    svo_i_free(w.rectangles);
    return status;
}
