/* SPDX-License-Identifier: MIT */
/*
 * Edits against a dense array of voxels, which is asked voxel by voxel: lists after every step, trees now and then;
 * undo and redo; shapes far out against distances in double precision; closed meshes; what is refused; and that steps
 * cost their surfaces.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "support/fixture.h"
#include "support/meshes.h"
#include "support/solid_meshes.h"
#include "support/suite.h"

enum {
    EDGE = 48, /* of the array */
    INSET = 8, /* shapes keep from its faces, so that moved ones stay inside */
    CELLS = EDGE * EDGE * EDGE,
    UNDO = 3
};

static const int32_t corner[3] = {-7, 100, 3}; /* of the array; voxels begin where they happen to */

typedef struct dense_cell {
    uint8_t rgba[4];
    uint16_t material;
    int16_t normal[3];
    bool full;
} dense_cell;

/* The array, and those before, for undo; the oldest is forgotten. */
typedef struct dense {
    dense_cell *versions[UNDO + 1];
    int current;
    int count;
} dense;

static void *allocate(size_t bytes)
{
    void *block = calloc(1, bytes);
    assert_non_null(block);
    return block;
}

static void dense_open(dense *all)
{
    for (int i = 0; i <= UNDO; ++i) {
        all->versions[i] = allocate(CELLS * sizeof(dense_cell));
    }
    all->current = 0;
    all->count = 1;
}

static void dense_close(dense *all)
{
    for (int i = 0; i <= UNDO; ++i) {
        free(all->versions[i]);
    }
}

/* A copy of the current array becomes the current one. */
static dense_cell *dense_push(dense *all)
{
    if (all->current == UNDO) {
        dense_cell *oldest = all->versions[0];
        memmove(&all->versions[0], &all->versions[1], UNDO * sizeof oldest);
        all->versions[UNDO] = oldest;
        --all->current;
    }
    memcpy(all->versions[all->current + 1], all->versions[all->current], CELLS * sizeof(dense_cell));
    ++all->current;
    all->count = all->current + 1;
    return all->versions[all->current];
}

static size_t index_of(const int place[3])
{
    return ((size_t)place[2] * EDGE + (size_t)place[1]) * EDGE + (size_t)place[0];
}

static bool is_within(const int place[3])
{
    bool within = true;
    for (int axis = 0; axis < 3; ++axis) {
        within = within && place[axis] >= 0 && place[axis] < EDGE;
    }
    return within;
}

/* normals: NULL: none */
static svo_voxels *make_list_with(const svo_voxel *voxels, const int16_t *normals, uint64_t count)
{
    svo_voxels *made = NULL;
    svo_message message = {""};
    svo_voxels_source source = SVO_VOXELS_SOURCE_INIT;
    source.voxels = voxels;
    source.voxel_count = count;
    source.normals = normals;
    if (svo_voxels_create(&source, &made, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    return made;
}

static svo_voxels *make_list(const svo_voxel *voxels, uint64_t count)
{
    return make_list_with(voxels, NULL, count);
}

static svo_voxels *list_of_dense(const dense_cell *cells, bool has_normals)
{
    svo_voxel *voxels = allocate(CELLS * sizeof *voxels);
    int16_t *normals = allocate(CELLS * 3 * sizeof *normals);
    uint64_t count = 0;
    for (int z = 0; z < EDGE; ++z) {
        for (int y = 0; y < EDGE; ++y) {
            for (int x = 0; x < EDGE; ++x) {
                const int place[3] = {x, y, z};
                const dense_cell *cell = &cells[index_of(place)];
                if (cell->full) {
                    voxels[count] = (svo_voxel){
                        .x = x + corner[0], .y = y + corner[1], .z = z + corner[2], .material = cell->material};
                    memcpy(normals + 3 * count, cell->normal, sizeof cell->normal);
                    memcpy(voxels[count++].rgba, cell->rgba, 4);
                }
            }
        }
    }
    svo_voxels *made = make_list_with(voxels, has_normals ? normals : NULL, count);
    free(voxels);
    free(normals);
    return made;
}

static svo_edit *make_edit(const svo_voxels *voxels, const svo_edit_options *options)
{
    svo_edit *made = NULL;
    svo_message message = {""};
    if (svo_edit_create(voxels, options, &made, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    return made;
}

static svo_edit_info info_of(const svo_edit *edit)
{
    svo_edit_info info = SVO_EDIT_INFO_INIT;
    assert_int_equal(svo_edit_get_info(edit, &info), SVO_OK);
    return info;
}

static svo_voxels *list_of_edit(const svo_edit *edit)
{
    svo_voxels *made = NULL;
    svo_message message = {""};
    if (svo_edit_get_voxels(edit, &made, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    return made;
}

static void assert_same_lists(const svo_voxels *found, const svo_voxels *expected)
{
    svo_voxels_info left = SVO_VOXELS_INFO_INIT;
    svo_voxels_info right = SVO_VOXELS_INFO_INIT;
    assert_int_equal(svo_voxels_get_info(found, &left), SVO_OK);
    assert_int_equal(svo_voxels_get_info(expected, &right), SVO_OK);
    assert_int_equal(left.voxel_count, right.voxel_count);
    assert_memory_equal(&left, &right, sizeof left);
    assert_memory_equal(svo_voxels_get(found), svo_voxels_get(expected), left.voxel_count * sizeof(svo_voxel));
    const int16_t *normals[2] = {svo_voxels_get_normals(found), svo_voxels_get_normals(expected)};
    assert_int_equal(normals[0] != NULL, normals[1] != NULL);
    if (normals[0] != NULL) {
        assert_memory_equal(normals[0], normals[1], left.voxel_count * 3 * sizeof(int16_t));
    }
}

static void succeed(const fixture *opened, svo_status status)
{
    if (status != SVO_OK) {
        fail_msg("%s", svo_device_message(opened->device));
    }
}

/* What the edit commits is what a build of the list makes. */
static void assert_same_trees(const fixture *opened, const svo_edit *edit, const svo_voxels *list, unsigned depth,
                              const svo_plan_options *options)
{
    svo_tree *trees[2] = {NULL, NULL};
    svo_tree_info infos[2] = {SVO_TREE_INFO_INIT, SVO_TREE_INFO_INIT};
    char hashes[2][SVO_HASH_TEXT_BYTES];
    succeed(opened, svo_edit_commit(edit, opened->device, depth, options, opened->queue, &trees[0], NULL));
    succeed(opened, svo_voxels_build(opened->device, list, depth, options, opened->queue, &trees[1], NULL));
    for (int i = 0; i < 2; ++i) {
        assert_int_equal(svo_tree_get_info(trees[i], &infos[i]), SVO_OK);
        succeed(opened, svo_tree_download(trees[i], opened->queue));
        assert_int_equal(svo_tree_hash(trees[i], SVO_HASH_ALL, hashes[i]), SVO_OK);
        svo_tree_destroy(&trees[i]);
    }
    assert_memory_equal(&infos[0], &infos[1], sizeof infos[0]);
    assert_string_equal(hashes[0], hashes[1]);
}

/* The edit's list is the array's, and with a device so are the bytes of the tree. */
static void assert_is_dense(const svo_edit *edit, const dense_cell *cells, const fixture *opened)
{
    svo_voxels *found = list_of_edit(edit);
    svo_voxels *expected = list_of_dense(cells, svo_voxels_get_normals(found) != NULL);
    assert_same_lists(found, expected);
    svo_voxels_info list = SVO_VOXELS_INFO_INIT;
    assert_int_equal(svo_voxels_get_info(found, &list), SVO_OK);
    assert_int_equal(info_of(edit).voxel_count, list.voxel_count);
    if (opened != NULL) {
        assert_same_trees(opened, edit, expected, 0, NULL);
    }
    svo_voxels_destroy(&found);
    svo_voxels_destroy(&expected);
}

/* ---- shapes, voxel by voxel ---- */

static int64_t dot(const int64_t a[3], const int64_t b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Whether the center of a voxel of the array is inside; numbers of the step are multiples of 1/256. */
static bool is_inside(const svo_edit_step *step, const int place[3])
{
    int64_t from[3];
    int64_t to[3];
    int64_t along[3];
    const int64_t radius = (int64_t)(step->radius * 256.0);
    bool in_box = true;
    for (int axis = 0; axis < 3; ++axis) {
        const int64_t center = (place[axis] + corner[axis]) * 256 + 128;
        from[axis] = center - (int64_t)floor(step->begin[axis] * 256.0);
        to[axis] = center - (int64_t)floor(step->end[axis] * 256.0);
        along[axis] = from[axis] - to[axis];
        in_box = in_box && from[axis] >= 0 && to[axis] < 0;
    }
    if (step->shape == SVO_EDIT_BOX) {
        return in_box;
    }
    const int64_t length = step->shape == SVO_EDIT_SPHERE ? 0 : dot(along, along);
    const int64_t projection = length > 0 ? dot(from, along) : 0;
    if (projection <= 0) {
        return dot(from, from) <= radius * radius;
    }
    if (projection >= length) {
        return dot(to, to) <= radius * radius;
    }
    return dot(from, from) * length - projection * projection <= radius * radius * length; /* below 2^62 here */
}

/* A voxel inside, one of whose six neighbors is outside, has the direction from the nearest point of the line between
   the ends, which is rounded to 1/256; of a box that of the faces that it is at, together. */
static void find_normal(const svo_edit_step *step, const int place[3], int16_t normal[3])
{
    double direction[3] = {0.0, 0.0, 0.0};
    bool at_surface = false;
    for (int axis = 0; axis < 3; ++axis) {
        for (int side = -1; side <= 1; side += 2) {
            int neighbor[3] = {place[0], place[1], place[2]};
            neighbor[axis] += side;
            const bool outside = !is_inside(step, neighbor);
            at_surface = at_surface || outside;
            direction[axis] += step->shape == SVO_EDIT_BOX && outside ? side : 0;
        }
    }
    memset(normal, 0, 3 * sizeof *normal);
    if (!at_surface) {
        return;
    }
    if (step->shape != SVO_EDIT_BOX) {
        double from[3];
        double along[3];
        double share = 0.0;
        double length = 0.0;
        for (int axis = 0; axis < 3; ++axis) {
            from[axis] = (place[axis] + corner[axis]) * 256 + 128 - step->begin[axis] * 256.0;
            along[axis] = step->shape == SVO_EDIT_CAPSULE ? (step->end[axis] - step->begin[axis]) * 256.0 : 0.0;
            share += from[axis] * along[axis];
            length += along[axis] * along[axis];
        }
        share = share <= 0.0 ? 0.0 : share >= length ? 1.0 : share / length;
        for (int axis = 0; axis < 3; ++axis) {
            direction[axis] = from[axis] - rint(share * along[axis]);
        }
    }
    const double size = sqrt(direction[0] * direction[0] + direction[1] * direction[1] + direction[2] * direction[2]);
    for (int axis = 0; axis < 3 && size > 0.0; ++axis) {
        normal[axis] = (int16_t)rint(direction[axis] / size * 32767.0);
    }
}

static void paint_cell(dense_cell *cell, const dense_cell *with)
{
    memcpy(cell->rgba, with->rgba, sizeof cell->rgba);
    cell->material = with->material;
}

static void change_cell(dense_cell *cell, svo_edit_verb verb, bool inside, const dense_cell *with)
{
    static const dense_cell empty = {.full = false};
    switch (verb) {
    case SVO_EDIT_SET:
        *cell = inside ? *with : *cell;
        break;
    case SVO_EDIT_ADD:
        *cell = inside && !cell->full ? *with : *cell;
        break;
    case SVO_EDIT_CLEAR:
        *cell = inside ? empty : *cell;
        break;
    case SVO_EDIT_KEEP:
        *cell = inside ? *cell : empty;
        break;
    default:
        if (inside && cell->full) {
            paint_cell(cell, with);
        }
    }
}

static void change_by_shape(dense_cell *cells, const svo_edit_step *step)
{
    dense_cell with = {.material = (uint16_t)step->material, .full = true};
    memcpy(with.rgba, step->rgba, 4);
    for (int i = 0; i < CELLS; ++i) {
        const int place[3] = {i % EDGE, i / EDGE % EDGE, i / EDGE / EDGE};
        const bool inside = is_inside(step, place);
        if (inside) {
            find_normal(step, place, with.normal);
        }
        change_cell(&cells[i], (svo_edit_verb)step->verb, inside, &with);
    }
}

/* By the voxels of another array, or of the part of it inside region, which are moved. */
static void change_by_voxels(dense_cell *cells, svo_edit_verb verb, const dense_cell *others,
                             const svo_edit_step *region, const int32_t offset[3])
{
    dense_cell *copy = allocate(CELLS * sizeof *copy);
    memcpy(copy, others, CELLS * sizeof *copy);
    for (int i = 0; i < CELLS; ++i) {
        const int place[3] = {i % EDGE, i / EDGE % EDGE, i / EDGE / EDGE};
        const int source[3] = {place[0] - offset[0], place[1] - offset[1], place[2] - offset[2]};
        const bool inside =
            is_within(source) && copy[index_of(source)].full && (region == NULL || is_inside(region, source));
        change_cell(&cells[i], verb, inside, inside ? &copy[index_of(source)] : NULL);
    }
    free(copy);
}

/* ---- random steps ---- */

/* A multiple of grain / 256 below limit / 256. */
static double random_length(uint64_t *seed, uint32_t limit, uint32_t grain)
{
    const uint32_t whole = random_below(seed, limit);
    return (whole - whole % grain) / 256.0;
}

static svo_edit_step random_shape(uint64_t *seed)
{
    static const uint8_t colors[3][4] = {{200, 10, 30, 255}, {1, 2, 3, 128}, {255, 255, 255, 255}};
    svo_edit_step step = SVO_EDIT_STEP_INIT;
    step.verb = random_below(seed, 10);
    step.verb = step.verb > SVO_EDIT_PAINT ? SVO_EDIT_SET : step.verb == SVO_EDIT_KEEP ? SVO_EDIT_ADD : step.verb;
    step.verb = random_below(seed, 12) == 0 ? SVO_EDIT_KEEP : step.verb;
    step.shape = random_below(seed, 3);
    step.material = random_below(seed, 3) * 7;
    memcpy(step.rgba, colors[random_below(seed, 3)], 4);
    /* Whole numbers are as likely as fractions: their faces and their distances are the ties. */
    const uint32_t grain = random_below(seed, 2) == 0 ? 256 : 1;
    step.radius = step.shape == SVO_EDIT_BOX ? 0.0 : random_length(seed, 11 * 256, grain);
    const double room = EDGE - 2 * INSET - 2 * step.radius;
    for (int axis = 0; axis < 3; ++axis) {
        const double low = corner[axis] + INSET + step.radius;
        step.begin[axis] = low + random_length(seed, (uint32_t)(room * 256.0) + 1, grain);
        step.end[axis] = low + random_length(seed, (uint32_t)(room * 256.0) + 1, grain);
    }
    return step;
}

static void random_offset(uint64_t *seed, int32_t offset[3])
{
    const uint32_t grain = random_below(seed, 3) == 0 ? 4 : 1; /* whole blocks are shared */
    for (int axis = 0; axis < 3; ++axis) {
        offset[axis] = (int32_t)(random_below(seed, 2 * INSET + 1) / grain * grain) - INSET;
    }
}

/* What the program of a random test has. */
typedef struct random_edit {
    uint64_t seed;
    svo_edit *edit;
    svo_edit *other;
    dense_cell *other_cells;
    dense all;
} random_edit;

static svo_edit *edit_of_dense(const dense_cell *cells, bool has_normals)
{
    const svo_edit_options options = {.struct_size = sizeof options, .undo_count = UNDO};
    svo_voxels *list = list_of_dense(cells, has_normals);
    svo_edit *made = make_edit(list, &options);
    svo_voxels_destroy(&list);
    return made;
}

/* Normals of any length up to 1, and none of each eighth voxel; or none at all. */
static void random_normals(uint64_t *seed, dense_cell *cells, bool has_normals)
{
    for (int i = 0; i < CELLS; ++i) {
        for (int axis = 0; axis < 3; ++axis) {
            const int32_t component = (int32_t)random_below(seed, 37001) - 18500;
            cells[i].normal[axis] = cells[i].full && has_normals && i % 8 != 0 ? (int16_t)component : 0;
        }
    }
}

/* has_normals: of the edit, and of the other one. */
static void random_open(uint64_t seed, bool has_normals, bool other_has_normals, random_edit *r)
{
    *r = (random_edit){.seed = seed, .other_cells = allocate(CELLS * sizeof(dense_cell))};
    dense_open(&r->all);
    for (int i = 0; i < 6; ++i) {
        svo_edit_step step = random_shape(&r->seed);
        step.verb = SVO_EDIT_SET;
        change_by_shape(i < 3 ? r->all.versions[0] : r->other_cells, &step);
    }
    random_normals(&r->seed, r->all.versions[0], has_normals);
    random_normals(&r->seed, r->other_cells, other_has_normals);
    r->edit = edit_of_dense(r->all.versions[0], has_normals);
    r->other = edit_of_dense(r->other_cells, other_has_normals);
}

static void random_close(random_edit *r)
{
    svo_edit_destroy(&r->edit);
    svo_edit_destroy(&r->other);
    dense_close(&r->all);
    free(r->other_cells);
}

static void apply_voxels(random_edit *r, svo_message *message)
{
    svo_edit_step step = SVO_EDIT_STEP_INIT;
    const bool is_self = random_below(&r->seed, 4) == 0;
    step.verb = random_below(&r->seed, 5);
    step.verb = is_self && step.verb <= SVO_EDIT_ADD ? SVO_EDIT_PAINT : step.verb; /* others might leave the array */
    step.shape = SVO_EDIT_VOXELS;
    step.other = is_self ? r->edit : r->other;
    random_offset(&r->seed, step.offset);
    if (svo_edit_apply(r->edit, &step, message) == SVO_OK) {
        const dense_cell *others = is_self ? r->all.versions[r->all.current] : r->other_cells;
        change_by_voxels(dense_push(&r->all), (svo_edit_verb)step.verb, others, NULL, step.offset);
    }
}

static void apply_shape(random_edit *r, bool copies, svo_message *message)
{
    int32_t offset[3];
    const svo_edit_step step = random_shape(&r->seed);
    random_offset(&r->seed, offset);
    const svo_status status =
        copies ? svo_edit_copy(r->edit, &step, offset, message) : svo_edit_apply(r->edit, &step, message);
    if (status != SVO_OK) {
        return;
    }
    dense_cell *cells = dense_push(&r->all);
    if (copies) {
        change_by_voxels(cells, (svo_edit_verb)step.verb, cells, &step, offset);
    } else {
        change_by_shape(cells, &step);
    }
}

/* A step, or back or forth by one, or a collection. */
static void random_step(random_edit *r)
{
    svo_message message = {""};
    const uint32_t kind = random_below(&r->seed, 20);
    if (kind < 3) {
        const bool can = r->all.current > 0;
        assert_int_equal(svo_edit_undo(r->edit), can ? SVO_OK : SVO_INVALID_ARGUMENT);
        r->all.current -= can ? 1 : 0;
    } else if (kind < 5) {
        const bool can = r->all.current + 1 < r->all.count;
        assert_int_equal(svo_edit_redo(r->edit), can ? SVO_OK : SVO_INVALID_ARGUMENT);
        r->all.current += can ? 1 : 0;
    } else if (kind < 7) {
        svo_edit_collect(r->edit);
    } else if (kind < 10) {
        apply_voxels(r, &message);
    } else {
        apply_shape(r, kind < 13, &message);
    }
    if (message.text[0] != '\0') {
        fail_msg("%s", message.text);
    }
    const svo_edit_info info = info_of(r->edit);
    assert_int_equal(info.undo_count, r->all.current);
    assert_int_equal(info.redo_count, r->all.count - 1 - r->all.current);
}

static void steps_are_those_of_a_dense_array(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    for (uint64_t seed = 1; seed <= 4; ++seed) {
        random_edit r;
        print_message("seed %d\n", (int)seed);
        random_open(seed, (seed & 1) == 0, (seed & 2) != 0, &r);
        for (int i = 0; i < 80; ++i) {
            random_step(&r);
            assert_is_dense(r.edit, r.all.versions[r.all.current], i % 20 == 0 ? &opened : NULL);
        }
        random_close(&r);
    }
}

static void places_are_found(void **state)
{
    (void)state;
    random_edit r;
    random_open(11, true, true, &r);
    const dense_cell *cells = r.all.versions[0];
    for (int i = 0; i < CELLS; ++i) {
        svo_voxel voxel;
        const int32_t place[3] = {i % EDGE + corner[0], i / EDGE % EDGE + corner[1], i / EDGE / EDGE + corner[2]};
        const int found = svo_edit_find(r.edit, place, &voxel);
        assert_int_equal(found != 0, cells[i].full);
        if (found != 0) {
            assert_int_equal(voxel.y, place[1]);
            assert_int_equal(voxel.material, cells[i].material);
            assert_memory_equal(voxel.rgba, cells[i].rgba, 4);
        }
    }
    const int32_t outside[3] = {INT32_MAX, INT32_MIN, 0};
    assert_int_equal(svo_edit_find(r.edit, outside, NULL), 0);
    random_close(&r);
}

/* ---- far out, and large ---- */

/* A line of a million voxels from corner to corner of what an edit can fill, against distances in doubles; scattered
   voxels that are too near its surface for these are left out. */
static void long_capsules_keep_what_is_near(void **state)
{
    (void)state;
    enum { COUNT = 20000 };
    svo_voxel *voxels = allocate(COUNT * sizeof *voxels);
    bool *near = allocate(COUNT * sizeof *near);
    uint64_t seed = 5;
    size_t count = 0;
    const double from[3] = {60.25, 1000.0, 900000.5};
    const double to[3] = {1000000.0, 7000.75, 50.0};
    const double radius = 50.125;
    while (count < COUNT) {
        const double t = random_unit(&seed);
        double squares[2] = {0.0, 0.0}; /* of the distance from the first end, and of its part along the line */
        double length = 0.0;
        double along = 0.0;
        int32_t place[3];
        for (int axis = 0; axis < 3; ++axis) {
            place[axis] = (int32_t)(from[axis] + (to[axis] - from[axis]) * t) + (int32_t)random_below(&seed, 101) - 50;
            const double away = place[axis] + 0.5 - from[axis];
            squares[0] += away * away;
            along += away * (to[axis] - from[axis]);
            length += (to[axis] - from[axis]) * (to[axis] - from[axis]);
        }
        squares[1] = along * along / length;
        const double distance = sqrt(squares[0] - squares[1] > 0.0 ? squares[0] - squares[1] : 0.0);
        if (along < 0.0 || along > length || fabs(distance - radius) < 0.01) {
            continue;
        }
        near[count] = distance < radius;
        voxels[count++] = (svo_voxel){.x = place[0], .y = place[1], .z = place[2], .rgba = {1, 2, 3, 4}};
    }
    svo_voxels *list = make_list(voxels, COUNT);
    svo_edit *edit = make_edit(list, NULL);
    svo_edit_step step = SVO_EDIT_STEP_INIT;
    step.verb = SVO_EDIT_KEEP;
    step.shape = SVO_EDIT_CAPSULE;
    memcpy(step.begin, from, sizeof from);
    memcpy(step.end, to, sizeof to);
    step.radius = radius;
    assert_int_equal(svo_edit_apply(edit, &step, NULL), SVO_OK);
    for (size_t i = 0; i < COUNT; ++i) {
        const int32_t place[3] = {voxels[i].x, voxels[i].y, voxels[i].z};
        assert_int_equal(svo_edit_find(edit, place, NULL) != 0, near[i]);
    }
    svo_edit_destroy(&edit);
    svo_voxels_destroy(&list);
    free(voxels);
    free(near);
}

/* Half of the cube in a few nodes; and a sphere of twice the radius in about four times as many. */
static void steps_cost_their_surface(void **state)
{
    (void)state;
    svo_edit *edit = make_edit(NULL, NULL);
    const svo_edit_info before = info_of(edit);
    svo_edit_step step = SVO_EDIT_STEP_INIT;
    step.end[0] = 1 << 20;
    step.end[1] = 1 << 20;
    step.end[2] = 1 << 20;
    assert_int_equal(svo_edit_apply(edit, &step, NULL), SVO_OK);
    assert_int_equal(info_of(edit).voxel_count, UINT64_C(1) << 60);
    assert_in_range(info_of(edit).step_nodes, 1, 64);
    step.end[0] = (1 << 20) - 1; /* a million voxels of a face's inside */
    step.end[1] = 1000;
    step.end[2] = 1000;
    step.begin[0] = (1 << 20) - 2;
    step.verb = SVO_EDIT_CLEAR;
    assert_int_equal(svo_edit_apply(edit, &step, NULL), SVO_OK);
    assert_int_equal(info_of(edit).voxel_count, (UINT64_C(1) << 60) - 1000000);
    svo_voxels *list = NULL;
    assert_int_equal(svo_edit_get_voxels(edit, &list, NULL), SVO_INVALID_ARGUMENT);
    uint64_t nodes[2];
    for (int i = 0; i < 2; ++i) {
        step = (svo_edit_step)SVO_EDIT_STEP_INIT;
        step.shape = SVO_EDIT_SPHERE;
        step.begin[0] = -500000.0;
        step.radius = 64 << i;
        assert_int_equal(svo_edit_apply(edit, &step, NULL), SVO_OK);
        nodes[i] = info_of(edit).step_nodes;
        assert_int_equal(svo_edit_undo(edit), SVO_OK);
    }
    assert_in_range(nodes[1], 3 * nodes[0], 5 * nodes[0]);
    assert_in_range(nodes[1], 1, 4 * 4 * 128 * 128);
    assert_int_equal(before.low[0], -(1 << 20));
    assert_int_equal(before.high[0], 1 << 20);
    svo_edit_destroy(&edit);
}

/* The solid of a box mesh with a box-shaped hole, as voxels one unit wide. */
static svo_edit *edit_of_mesh(const fixture *opened)
{
    const svo_plan_options options = {.struct_size = sizeof options, .need = SVO_NEED_RAYS, .edge = 32.0};
    const svo_solid_options filling = {.struct_size = sizeof filling, .rule = SVO_SOLID_PARITY};
    parts made = {NULL, NULL, 0, 0};
    built surface;
    svo_compact *solid = NULL;
    svo_tree *tree = NULL;
    svo_voxels *list = NULL;
    parts_add_cube(&made, 2.5, 20.5, false, -1);
    parts_add_cube(&made, 7.5, 14.5, true, -1);
    const svo_mesh mesh = parts_mesh(&made);
    fixture_build(opened, &mesh, 5, &options, &surface);
    succeed(opened, svo_solid_create(surface.tree, &filling, opened->queue, &solid, NULL));
    succeed(opened, svo_compact_expand(solid, opened->queue, &tree));
    succeed(opened, svo_tree_download(tree, opened->queue));
    assert_int_equal(svo_tree_get_voxels(tree, &list, NULL), SVO_OK);
    svo_edit *edit = make_edit(list, NULL);
    svo_voxels_destroy(&list);
    svo_tree_destroy(&tree);
    svo_compact_destroy(&solid);
    built_destroy(&surface);
    parts_free(&made);
    return edit;
}

/* Where the mesh passes through a voxel or around its center: those from 2 to 20, but the hole's from 8 to 13. */
static void closed_meshes_are_shapes(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    svo_edit *mesh = edit_of_mesh(&opened);
    svo_edit *edit = make_edit(NULL, NULL);
    svo_edit_step step = SVO_EDIT_STEP_INIT;
    step.end[0] = step.end[1] = step.end[2] = 40.0;
    assert_int_equal(svo_edit_apply(edit, &step, NULL), SVO_OK);
    step.verb = SVO_EDIT_CLEAR;
    step.shape = SVO_EDIT_VOXELS;
    step.other = mesh;
    step.offset[1] = 17;
    assert_int_equal(svo_edit_apply(edit, &step, NULL), SVO_OK);
    assert_int_equal(info_of(edit).voxel_count, 40 * 40 * 40 - (19 * 19 * 19 - 6 * 6 * 6));
    for (int i = 0; i < 40 * 40 * 40; ++i) {
        const int32_t place[3] = {i % 40, i / 40 % 40, i / 1600};
        bool inside = true;
        bool in_hole = true;
        for (int axis = 0; axis < 3; ++axis) {
            const int32_t at = place[axis] - step.offset[axis];
            inside = inside && at >= 2 && at <= 20;
            in_hole = in_hole && at >= 8 && at <= 13;
        }
        assert_int_equal(svo_edit_find(edit, place, NULL) != 0, !inside || in_hole);
    }
    svo_edit_destroy(&edit);
    svo_edit_destroy(&mesh);
}

/* ---- lists ---- */

static void lists_keep_their_place_and_properties(void **state)
{
    (void)state;
    const svo_voxel voxels[] = {{.x = 1 << 30, .y = -(1 << 30), .z = 5, .material = 3},
                                {.x = (1 << 30) - 9, .y = 3 - (1 << 30), .z = 5, .rgba = {1, 2, 3, 4}}};
    const svo_voxel_property property = {.material = 3, .key = "name", .value = "stone"};
    const svo_voxels_source source = {.struct_size = sizeof source,
                                      .voxels = voxels,
                                      .voxel_count = 2,
                                      .properties = &property,
                                      .property_count = 1,
                                      .origin = {0.5, -2.0, 1e6},
                                      .voxel_edge = 0.125};
    svo_voxels *list = NULL;
    assert_int_equal(svo_voxels_create(&source, &list, NULL), SVO_OK);
    svo_edit *edit = make_edit(list, NULL);
    svo_voxels *again = list_of_edit(edit);
    assert_same_lists(again, list);
    assert_string_equal(svo_voxels_get_properties(again)->value, "stone");
    assert_int_equal(info_of(edit).high[0], (1 << 30) + 1);
    assert_int_equal(info_of(edit).low[1], -(1 << 30));
    svo_voxels_destroy(&again);
    svo_voxels_destroy(&list);
    svo_edit_destroy(&edit);
    svo_edit_destroy(&edit);
    svo_edit_destroy(NULL);
}

static void empty_edits_have_lists_and_trees(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    svo_edit *edit = make_edit(NULL, NULL);
    svo_voxels *empty = make_list(NULL, 0);
    svo_voxels *found = list_of_edit(edit);
    assert_same_lists(found, empty);
    svo_voxels_destroy(&found);
    svo_voxels_destroy(&empty);
    svo_edit_collect(edit);
    svo_edit_step step = SVO_EDIT_STEP_INIT;
    step.shape = SVO_EDIT_SPHERE; /* of radius 0, at no center */
    assert_int_equal(svo_edit_apply(edit, &step, NULL), SVO_OK);
    assert_int_equal(info_of(edit).voxel_count, 0);
    step.begin[0] = step.begin[1] = step.begin[2] = -2.5; /* at one */
    assert_int_equal(svo_edit_apply(edit, &step, NULL), SVO_OK);
    assert_int_equal(info_of(edit).voxel_count, 1);
    svo_tree *tree = NULL;
    succeed(&opened, svo_edit_commit(edit, opened.device, 3, NULL, NULL, &tree, NULL));
    svo_tree_info info = SVO_TREE_INFO_INIT;
    assert_int_equal(svo_tree_get_info(tree, &info), SVO_OK);
    assert_int_equal(info.leaf_count, 1);
    assert_int_equal(info.depth, 3);
    assert_true(info.origin[1] == -3.0);
    svo_tree_destroy(&tree);
    svo_edit_destroy(&edit);
}

/* ---- trees ---- */

/* How the colors and materials of random voxels differ. */
typedef enum variety { ONE_OF_EACH, MATERIALS_DIFFER, ALL_DIFFER } variety;

/* Voxels in and around a full cube, so that nodes are of all kinds; some do not show. */
static svo_voxels *random_list(uint64_t seed, variety differs)
{
    enum { COUNT = 3000 };
    svo_voxel *voxels = allocate(COUNT * sizeof *voxels);
    for (uint32_t i = 0; i < COUNT; ++i) {
        svo_voxel *one = &voxels[i];
        const bool in_cube = i < 16 * 16 * 8;
        one->x = in_cube ? (int32_t)(i & 15u) : (int32_t)random_below(&seed, 50) - 3;
        one->y = in_cube ? (int32_t)(i >> 4 & 15u) : (int32_t)random_below(&seed, 40);
        one->z = in_cube ? (int32_t)(i >> 8) : (int32_t)random_below(&seed, 30) - 9;
        one->material = differs >= MATERIALS_DIFFER && !in_cube ? (uint16_t)random_below(&seed, 40) : 7;
        memcpy(one->rgba, (const uint8_t[4]){9, 200, 31, 128}, 4);
        for (int k = 0; k < 4 && differs == ALL_DIFFER && !in_cube; ++k) {
            one->rgba[k] = (uint8_t)(k == 3 && i % 3 == 0 ? 0 : random_below(&seed, 256));
        }
    }
    svo_voxels *made = make_list(voxels, COUNT);
    free(voxels);
    return made;
}

static int count_calls(void *user, svo_stage stage, double fraction)
{
    uint32_t *left = user;
    (void)stage;
    assert_true(fraction >= 0.0 && fraction <= 1.0);
    return (*left)-- == 0 ? 1 : 0;
}

/* Of lists as they were given, and after their least corner has moved; deeper than they need, with payload of a few
   levels, and by a build where there are options that need one. */
static void commits_are_builds(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    for (variety differs = ONE_OF_EACH; differs <= ALL_DIFFER; ++differs) {
        svo_voxels *list = random_list(5 + (uint64_t)differs, differs);
        svo_edit *edit = make_edit(list, NULL);
        svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
        assert_same_trees(&opened, edit, list, 0, NULL);
        assert_same_trees(&opened, edit, list, 9, &options);
        options.payload_level = 4;
        assert_same_trees(&opened, edit, list, 0, &options);
        options.fragment_capacity = 100;
        assert_same_trees(&opened, edit, list, 0, &options);
        svo_edit_step step = SVO_EDIT_STEP_INIT;
        step.begin[0] = -30.0;
        step.end[0] = step.end[1] = step.end[2] = 9.0;
        memcpy(step.rgba, (const uint8_t[4]){9, 200, 31, 128}, 4);
        step.material = 7;
        assert_int_equal(svo_edit_apply(edit, &step, NULL), SVO_OK);
        svo_voxels *moved = list_of_edit(edit);
        assert_same_trees(&opened, edit, moved, 0, NULL);
        svo_voxels_destroy(&moved);
        svo_edit_destroy(&edit);
        svo_voxels_destroy(&list);
    }
}

/* ---- normals ---- */

static void hash_build(const fixture *opened, const svo_voxels *list, svo_place place, char hash[SVO_HASH_TEXT_BYTES])
{
    const svo_plan_options options = {.struct_size = sizeof options, .place = place};
    svo_tree *tree = NULL;
    succeed(opened, svo_voxels_build(opened->device, list, 0, &options, opened->queue, &tree, NULL));
    succeed(opened, svo_tree_download(tree, opened->queue));
    assert_int_equal(svo_tree_hash(tree, SVO_HASH_ALL, hash), SVO_OK);
    svo_tree_destroy(&tree);
}

/* Normals of voxels: none, one for all that is no unit vector, as far as rounding goes the same, or all different. */
static void commits_have_the_normals_of_builds(void **state)
{
    enum { NONE, ONE, NEAR, DIFFERENT, KINDS, COUNT = 5000 };
    const fixture opened = fixture_cl_of_group(state);
    svo_voxel *voxels = allocate(COUNT * sizeof *voxels);
    int16_t *normals = allocate(3 * COUNT * sizeof *normals);
    for (int kind = NONE; kind < KINDS; ++kind) {
        uint64_t seed = 77;
        for (size_t i = 0; i < COUNT; ++i) {
            voxels[i] = (svo_voxel){.x = (int32_t)random_below(&seed, 40),
                                    .y = (int32_t)random_below(&seed, 30),
                                    .z = (int32_t)random_below(&seed, 20),
                                    .rgba = {9, 200, 31, 255}};
            for (size_t axis = 0; axis < 3; ++axis) {
                normals[3 * i + axis] = (int16_t)(kind == NONE   ? 0
                                                  : kind == ONE  ? 5000
                                                  : kind == NEAR ? 5000 + (int)(i % 2)
                                                                 : (int)random_below(&seed, 37000) - 18500);
            }
        }
        svo_voxels *list = make_list_with(voxels, normals, COUNT);
        svo_edit *edit = make_edit(list, NULL);
        svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
        char hashes[2][SVO_HASH_TEXT_BYTES];
        assert_same_trees(&opened, edit, list, 0, NULL);
        options.need = SVO_NEED_NORMAL;
        options.payload_level = 4;
        assert_same_trees(&opened, edit, list, 8, &options);
        options.need = SVO_NEED_COLOR;
        assert_same_trees(&opened, edit, list, 0, &options);
        options.fragment_capacity = 100;
        options.need = SVO_NEED_DEFAULT;
        assert_same_trees(&opened, edit, list, 0, &options);
        hash_build(&opened, list, SVO_PLACE_HOST, hashes[0]);
        hash_build(&opened, list, SVO_PLACE_DEVICE, hashes[1]);
        assert_string_equal(hashes[0], hashes[1]);
        svo_edit_destroy(&edit);
        svo_voxels_destroy(&list);
    }
    free(voxels);
    free(normals);
}

static svo_tree *commit(const fixture *opened, const svo_edit *edit, svo_tree_arrays *arrays, svo_tree_info *info)
{
    svo_tree *tree = NULL;
    succeed(opened, svo_edit_commit(edit, opened->device, 0, NULL, opened->queue, &tree, NULL));
    succeed(opened, svo_tree_download(tree, opened->queue));
    assert_int_equal(svo_tree_get_arrays(tree, arrays), SVO_OK);
    assert_int_equal(svo_tree_get_info(tree, info), SVO_OK);
    return tree;
}

/* The tree of a mesh, from which a sphere is cleared and to which a box of two voxels is added, against a list that is
   made by hand: leaf by leaf, and the mean at the root. The mesh reaches the grid's least voxels, where both lists
   begin. */
static void voxels_of_meshes_keep_their_normals(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_plan_options options = {
        .struct_size = sizeof options, .need = (uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL, .edge = 32.0};
    parts made = {NULL, NULL, 0, 0};
    built surface;
    svo_voxels *leaves = NULL;
    svo_voxels_info list = SVO_VOXELS_INFO_INIT;
    parts_add_cube(&made, 0.5, 20.5, false, -1);
    const svo_mesh mesh = parts_mesh(&made);
    fixture_build(&opened, &mesh, 5, &options, &surface);
    assert_int_equal(svo_tree_get_voxels(surface.tree, &leaves, NULL), SVO_OK);
    assert_int_equal(svo_voxels_get_info(leaves, &list), SVO_OK);
    const size_t count = (size_t)list.voxel_count;
    const int16_t *of_leaves = surface.arrays.normals + 3 * surface.info.inner_count;
    assert_memory_equal(svo_voxels_get_normals(leaves), of_leaves, 3 * count * sizeof(int16_t));
    svo_edit *edit = make_edit(leaves, NULL);
    svo_edit_step step = SVO_EDIT_STEP_INIT;
    step.verb = SVO_EDIT_CLEAR;
    step.shape = SVO_EDIT_SPHERE;
    step.begin[0] = step.begin[1] = step.begin[2] = 3.0;
    step.radius = 9.0;
    assert_int_equal(svo_edit_apply(edit, &step, NULL), SVO_OK);
    step = (svo_edit_step)SVO_EDIT_STEP_INIT; /* at the high end, so that it comes last in Morton order */
    step.begin[0] = 30.0;
    step.begin[1] = step.begin[2] = 31.0;
    step.end[0] = step.end[1] = step.end[2] = 32.0;
    assert_int_equal(svo_edit_apply(edit, &step, NULL), SVO_OK);
    svo_voxel *voxels = allocate((count + 2) * sizeof *voxels);
    int16_t *normals = allocate(3 * (count + 2) * sizeof *normals);
    size_t kept = 0;
    for (size_t i = 0; i < count; ++i) {
        const svo_voxel *one = &svo_voxels_get(leaves)[i];
        const double away[3] = {one->x - 2.5, one->y - 2.5, one->z - 2.5};
        if (away[0] * away[0] + away[1] * away[1] + away[2] * away[2] > 81.0) {
            memcpy(normals + 3 * kept, of_leaves + 3 * i, 3 * sizeof *normals);
            voxels[kept++] = *one;
        }
    }
    for (int32_t x = 30; x < 32; ++x) { /* y and z are thin: faces of both sides cancel */
        normals[3 * kept] = x == 30 ? -32767 : 32767;
        voxels[kept++] = (svo_voxel){.x = x, .y = 31, .z = 31};
    }
    svo_tree_arrays arrays = SVO_TREE_ARRAYS_INIT;
    svo_tree_info info = SVO_TREE_INFO_INIT;
    svo_tree *tree = commit(&opened, edit, &arrays, &info);
    assert_int_equal(info.need, SVO_NEED_COLOR | SVO_NEED_NORMAL | SVO_NEED_MATERIAL);
    assert_in_range(kept, 100, count);
    assert_int_equal(info.leaf_count, kept);
    assert_memory_equal(arrays.normals + 3 * info.inner_count, normals, 3 * kept * sizeof *normals);
    for (size_t axis = 0; axis < 3; ++axis) {
        int64_t sum = 0;
        for (size_t i = 0; i < kept; ++i) {
            sum += normals[3 * i + axis];
        }
        assert_int_equal(arrays.normals[axis], (int)floor((double)sum / (double)kept + 0.5));
    }
    svo_voxels *expected = make_list_with(voxels, normals, kept);
    assert_same_trees(&opened, edit, expected, 0, NULL);
    svo_voxels_destroy(&expected);
    svo_tree_destroy(&tree);
    svo_edit_destroy(&edit);
    svo_voxels_destroy(&leaves);
    built_destroy(&surface);
    parts_free(&made);
    free(voxels);
    free(normals);
}

/* ---- compact trees ---- */

static void assert_same_compact(const fixture *opened, const svo_edit *edit, unsigned depth,
                                const svo_plan_options *options, const svo_compact_options *asked)
{
    svo_tree *tree = NULL;
    svo_compact *made[2] = {NULL, NULL};
    svo_compact_info infos[2] = {SVO_COMPACT_INFO_INIT, SVO_COMPACT_INFO_INIT};
    char hashes[2][SVO_HASH_TEXT_BYTES];
    succeed(opened, svo_edit_commit_compact(edit, opened->device, depth, options, asked, opened->queue, &made[0]));
    succeed(opened, svo_edit_commit(edit, opened->device, depth, options, opened->queue, &tree, NULL));
    succeed(opened, svo_compact_create(opened->device, tree, asked, opened->queue, &made[1]));
    for (int i = 0; i < 2; ++i) {
        assert_int_equal(svo_compact_get_info(made[i], &infos[i]), SVO_OK);
        succeed(opened, svo_compact_download(made[i], opened->queue));
        assert_int_equal(svo_compact_hash(made[i], hashes[i]), SVO_OK);
        svo_compact_destroy(&made[i]);
    }
    assert_memory_equal(&infos[0], &infos[1], sizeof infos[0]);
    assert_string_equal(hashes[0], hashes[1]);
    svo_tree_destroy(&tree);
}

/* Whether payload differs between nodes decides about places; full cubes are written as one; with what is left out,
   with payload of a few levels, and where the way goes by a tree. */
static void compact_trees_are_those_of_trees(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    for (variety differs = ONE_OF_EACH; differs <= ALL_DIFFER; ++differs) {
        svo_voxels *list = random_list(5 + (uint64_t)differs, differs);
        svo_edit *edit = make_edit(list, NULL);
        svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
        svo_compact_options asked = {.struct_size = sizeof asked, .form = SVO_FORM_SHARED};
        assert_same_compact(&opened, edit, 0, NULL, &asked);
        options.payload_level = 5; /* within the cube of 16 * 16 * 8 */
        assert_same_compact(&opened, edit, 8, &options, &asked);
        asked.leave_out = SVO_NEED_COLOR;
        assert_same_compact(&opened, edit, 0, NULL, &asked);
        asked.leave_out = (uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_MATERIAL;
        assert_same_compact(&opened, edit, 0, &options, &asked);
        options.fragment_capacity = 100;
        assert_same_compact(&opened, edit, 0, &options, &asked);
        asked.minimize = 1;
        assert_same_compact(&opened, edit, 0, NULL, &asked);
        asked = (svo_compact_options){.struct_size = sizeof asked, .form = SVO_FORM_DESCRIPTOR};
        assert_same_compact(&opened, edit, 0, NULL, &asked);
        svo_edit_destroy(&edit);
        svo_voxels_destroy(&list);
    }
    random_edit r; /* with normals */
    const svo_compact_options asked = {.struct_size = sizeof asked, .form = SVO_FORM_SHARED};
    random_open(21, true, true, &r);
    assert_same_compact(&opened, r.edit, 0, NULL, &asked);
    svo_compact *compact = NULL;
    const svo_compact_options wrong = {.struct_size = sizeof wrong, .form = SVO_FORM_COUNT};
    assert_int_equal(svo_edit_commit_compact(r.edit, opened.device, 0, NULL, &wrong, NULL, &compact),
                     SVO_INVALID_ARGUMENT);
    assert_non_null(strstr(svo_device_message(opened.device), "svo_edit_commit_compact: options.form"));
    assert_int_equal(svo_edit_commit_compact(r.edit, opened.device, 3, NULL, &asked, NULL, &compact),
                     SVO_INVALID_ARGUMENT);
    assert_non_null(strstr(svo_device_message(opened.device), "svo_edit_commit_compact: depth 3 is not in"));
    random_close(&r);
}

static void commits_can_be_stopped(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    svo_edit *edit = make_edit(NULL, NULL);
    svo_tree *tree = NULL;
    uint32_t left = 3;
    const svo_plan_options options = {.struct_size = sizeof options, .progress = count_calls, .progress_user = &left};
    svo_edit_step step = SVO_EDIT_STEP_INIT;
    step.end[0] = step.end[1] = step.end[2] = 300.0;
    assert_int_equal(svo_edit_apply(edit, &step, NULL), SVO_OK);
    assert_int_equal(svo_edit_commit(edit, opened.device, 0, &options, NULL, &tree, NULL), SVO_CANCELED);
    assert_non_null(strstr(svo_device_message(opened.device), "svo_edit_commit: the progress callback stopped"));
    assert_null(tree);
    left = 1000;
    svo_build_report report = SVO_BUILD_REPORT_INIT;
    succeed(&opened, svo_edit_commit(edit, opened.device, 0, &options, NULL, &tree, &report));
    assert_int_equal(report.fragments, UINT64_C(300) * 300 * 300);
    assert_string_equal(report.builder, "edit");
    assert_in_range(left, 0, 998);
    svo_tree_destroy(&tree);
    svo_edit_destroy(&edit);
}

/* ---- mirrors ---- */

enum { PICTURE_WIDTH = 96, PICTURE_HEIGHT = 64, PICTURE_BYTES = PICTURE_WIDTH * PICTURE_HEIGHT * 4 };

/* Where the pictures of a tree are seen from. away: the distance, as a multiple of the fitted one. */
static svo_camera camera_of(svo_tree *tree, float away)
{
    svo_camera camera = {.eye = {1.0F, 0.7F, 1.5F}};
    assert_int_equal(svo_camera_fit(svo_tree_target(tree), 1.5F, &camera), SVO_OK);
    for (int axis = 0; axis < 3; ++axis) {
        camera.eye[axis] = camera.target[axis] + (camera.eye[axis] - camera.target[axis]) * away;
    }
    return camera;
}

static void draw(const fixture *opened, svo_target target, const svo_camera *camera, uint8_t *rgba)
{
    svo_render_options options = SVO_RENDER_OPTIONS_INIT;
    options.camera = *camera;
    options.width = PICTURE_WIDTH;
    options.height = PICTURE_HEIGHT;
    succeed(opened, svo_render(target, &options, svo_in_host(rgba), NULL));
}

/* How much pictures of the mirror, which is updated, and of the tree that the edit commits differ: the mean of all
   bytes' differences. away: the camera's distance from the fitted one, as a multiple. */
static double difference_of_pictures(const fixture *opened, const svo_edit *edit, svo_edit_mirror *mirror, float away)
{
    static uint8_t pictures[2][PICTURE_BYTES];
    svo_tree *tree = NULL;
    uint64_t sum = 0;
    succeed(opened, svo_edit_commit(edit, opened->device, 0, NULL, opened->queue, &tree, NULL));
    succeed(opened, svo_edit_mirror_update(mirror, opened->queue));
    const svo_camera camera = camera_of(tree, away);
    draw(opened, svo_tree_target(tree), &camera, pictures[0]);
    draw(opened, svo_edit_mirror_target(mirror), &camera, pictures[1]);
    svo_tree_destroy(&tree);
    for (int i = 0; i < PICTURE_BYTES; ++i) {
        sum += (uint64_t)abs(pictures[0][i] - pictures[1][i]);
    }
    return (double)sum / PICTURE_BYTES;
}

static uint64_t written_by(const svo_edit_mirror *mirror)
{
    svo_edit_mirror_info info = SVO_EDIT_MIRROR_INFO_INIT;
    assert_int_equal(svo_edit_mirror_get_info(mirror, &info), SVO_OK);
    assert_true(info.device_bytes >= info.written_bytes);
    return info.written_bytes;
}

/* Pictures of a mirror are those of the tree, by bytes where voxels are met, and nearly where whole nodes are or where
   the grid begins elsewhere; and a step copies what it wrote alone. */
static void mirrors_show_what_is_committed(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    svo_voxels *list = random_list(11, ALL_DIFFER);
    svo_edit *edit = make_edit(list, NULL);
    svo_edit_mirror *mirror = NULL;
    svo_voxels_destroy(&list);
    succeed(&opened, svo_edit_mirror_create(opened.device, edit, opened.queue, &mirror));
    const uint64_t all_bytes = written_by(mirror);
    assert_true(difference_of_pictures(&opened, edit, mirror, 1.0F) == 0.0);
    assert_int_equal(written_by(mirror), 0);
    assert_true(difference_of_pictures(&opened, edit, mirror, 6.0F) < 0.5);
    svo_edit_step step = SVO_EDIT_STEP_INIT;
    step.shape = SVO_EDIT_SPHERE;
    step.begin[0] = step.begin[1] = step.begin[2] = 12.0;
    step.radius = 9.0;
    memcpy(step.rgba, (const uint8_t[4]){250, 20, 30, 255}, 4);
    assert_int_equal(svo_edit_apply(edit, &step, NULL), SVO_OK);
    assert_true(difference_of_pictures(&opened, edit, mirror, 1.0F) == 0.0);
    assert_in_range(written_by(mirror), info_of(edit).step_bytes, info_of(edit).step_bytes + 64);
    assert_true(written_by(mirror) < all_bytes);
    step.begin[0] = -20.0; /* the grid begins elsewhere */
    assert_int_equal(svo_edit_apply(edit, &step, NULL), SVO_OK);
    assert_true(difference_of_pictures(&opened, edit, mirror, 1.0F) < 0.5);
    succeed(&opened, svo_edit_mirror_update(mirror, NULL));
    assert_int_equal(written_by(mirror), 0); /* nor are nodes above the edit's made again */
    assert_int_equal(svo_edit_undo(edit), SVO_OK);
    assert_int_equal(svo_edit_undo(edit), SVO_OK);
    svo_edit_forget(edit);
    svo_edit_collect(edit);
    assert_true(difference_of_pictures(&opened, edit, mirror, 1.0F) == 0.0);
    assert_in_range(written_by(mirror), all_bytes / 2, all_bytes);
    svo_edit_mirror_destroy(&mirror);
    svo_edit_mirror_destroy(&mirror);
    svo_edit_destroy(&edit);
}

/* Opaque voxels, of a few to all in a block of 4 x 4 x 4, whose colors are near each other in a block alone. */
enum { BLOCKS = 16, BLOCK_RANGE = 40 };

static svo_voxels *list_of_blocks(uint64_t seed)
{
    const uint32_t room = BLOCKS * BLOCKS * BLOCKS * 64 / 4;
    svo_voxel *voxels = allocate(room * sizeof *voxels);
    uint32_t count = 0;
    for (uint32_t block = 0; block < BLOCKS * BLOCKS * BLOCKS; ++block) {
        const bool is_full = block == 0; /* both grids begin at its corner */
        const uint32_t share = is_full ? 32 : random_below(&seed, 4) == 0 ? 1 + random_below(&seed, 32) : 0;
        uint32_t base[3];
        for (int k = 0; k < 3; ++k) {
            base[k] = random_below(&seed, 256 - BLOCK_RANGE);
        }
        for (uint32_t cell = 0; cell < 64 && share > 0; ++cell) {
            if (count < room && random_below(&seed, 32) < share) {
                svo_voxel *one = &voxels[count++];
                one->x = (int32_t)(4 * (block % BLOCKS) + cell % 4);
                one->y = (int32_t)(4 * (block / BLOCKS % BLOCKS) + cell / 4 % 4);
                one->z = (int32_t)(4 * (block / BLOCKS / BLOCKS) + cell / 16);
                for (int k = 0; k < 3; ++k) {
                    one->rgba[k] = (uint8_t)(base[k] + random_below(&seed, BLOCK_RANGE + 1));
                }
                one->rgba[3] = 255;
            }
        }
    }
    svo_voxels *made = make_list(voxels, count);
    free(voxels);
    return made;
}

typedef float numbers[PICTURE_WIDTH * PICTURE_HEIGHT][4];

/* One ray for each pixel, as numbers; nothing where it meets nothing. */
static void draw_numbers(const fixture *opened, svo_target target, const svo_camera *camera, svo_render_view view,
                         numbers pixels)
{
    svo_render_options options = SVO_RENDER_OPTIONS_INIT;
    options.camera = *camera;
    options.width = PICTURE_WIDTH;
    options.height = PICTURE_HEIGHT;
    options.view = view;
    options.output.format = SVO_PIXELS_LINEAR;
    options.output.background = SVO_BACKGROUND_TRANSPARENT;
    options.output.samples = 1;
    succeed(opened, svo_render(target, &options, svo_in_host(pixels), NULL));
}

/* The most that a color of a mirror's node of 2^up voxels along each axis may differ from the tree's (docs/edit.md). */
static int most_of_level(int up)
{
    return up == 0 ? 0 : up == 1 ? BLOCK_RANGE : (up - 1) / 2;
}

/* A pixel is light times the square of color / 255, and a white node shows the light. Returns whether they differ. */
static bool check_pixel(const float *of_tree, const float *of_mirror, const float *white, int up)
{
    const float most = (float)most_of_level(up) / 255.0F;
    bool differs = false;
    for (int k = 0; k < 3; ++k) {
        const float difference = fabsf(of_tree[k] - of_mirror[k]);
        const float limit = white[k] * (2.0F * most - most * most) * 1.0001F;
        differs = differs || difference > 0.0F;
        if (!(difference <= limit)) {
            fail_msg("a node of 2^%d voxels: %g and %g differ by %g, above %g", up, (double)of_tree[k],
                     (double)of_mirror[k], (double)difference, (double)limit);
        }
    }
    return differs;
}

/* Blocks have the tree's colors, what is in them that of the block, and each two levels above round by one more. */
static void nodes_of_mirrors_differ_by_their_level(void **state)
{
    static numbers of_tree, of_mirror, white, levels;
    const fixture opened = fixture_cl_of_group(state);
    svo_voxels *list = list_of_blocks(3);
    svo_edit *edit = make_edit(list, NULL);
    svo_edit_mirror *mirror = NULL;
    svo_tree *tree = NULL;
    svo_edit_step paint = SVO_EDIT_STEP_INIT;
    size_t seen[8] = {0}, differing[8] = {0}; /* pixels by level */
    svo_voxels_destroy(&list);
    paint.verb = SVO_EDIT_PAINT;
    paint.shape = SVO_EDIT_BOX;
    paint.end[0] = paint.end[1] = paint.end[2] = 4 * BLOCKS;
    memset(paint.rgba, 255, sizeof paint.rgba);
    succeed(&opened, svo_edit_mirror_create(opened.device, edit, opened.queue, &mirror));
    succeed(&opened, svo_edit_commit(edit, opened.device, 0, NULL, opened.queue, &tree, NULL));
    for (float away = 1.0F; away < 50.0F; away *= 2.0F) {
        const svo_camera camera = camera_of(tree, away);
        draw_numbers(&opened, svo_tree_target(tree), &camera, SVO_VIEW_LEVEL, levels);
        draw_numbers(&opened, svo_tree_target(tree), &camera, SVO_VIEW_SHADED, of_tree);
        draw_numbers(&opened, svo_edit_mirror_target(mirror), &camera, SVO_VIEW_SHADED, of_mirror);
        assert_int_equal(svo_edit_apply(edit, &paint, NULL), SVO_OK);
        succeed(&opened, svo_edit_mirror_update(mirror, opened.queue));
        draw_numbers(&opened, svo_edit_mirror_target(mirror), &camera, SVO_VIEW_SHADED, white);
        assert_int_equal(svo_edit_undo(edit), SVO_OK);
        succeed(&opened, svo_edit_mirror_update(mirror, opened.queue));
        for (size_t i = 0; i < (size_t)PICTURE_WIDTH * PICTURE_HEIGHT; ++i) {
            const int up = 6 - (int)levels[i][0]; /* of 64 voxels */
            assert_true(levels[i][3] == of_tree[i][3] && levels[i][3] == of_mirror[i][3]);
            if (levels[i][3] > 0.0F) {
                ++seen[up];
                differing[up] += check_pixel(of_tree[i], of_mirror[i], white[i], up);
            }
        }
    }
    assert_true(seen[0] > 0 && seen[2] > 0 && differing[1] > 0 && differing[3] > 0 && seen[5] > 0);
    svo_tree_destroy(&tree);
    svo_edit_mirror_destroy(&mirror);
    svo_edit_destroy(&edit);
}

/* Nothing is background everywhere; what is too wide is refused. */
static void mirrors_have_limits(void **state)
{
    static uint8_t picture[PICTURE_BYTES];
    const fixture opened = fixture_cl_of_group(state);
    svo_edit *edit = make_edit(NULL, NULL);
    svo_edit_mirror *mirror = NULL;
    succeed(&opened, svo_edit_mirror_create(opened.device, edit, NULL, &mirror));
    svo_camera camera = {.vertical_fov = 0.0F};
    camera.eye[2] = 3.0F;
    assert_int_equal(svo_camera_fit(svo_edit_mirror_target(mirror), 1.5F, &camera), SVO_OK);
    draw(&opened, svo_edit_mirror_target(mirror), &camera, picture);
    assert_memory_equal(&picture[0], &picture[4], 4);
    svo_edit_step step = SVO_EDIT_STEP_INIT;
    step.end[0] = 1 << 17;
    step.end[1] = step.end[2] = 1.0;
    assert_int_equal(svo_edit_apply(edit, &step, NULL), SVO_OK);
    assert_int_equal(svo_edit_mirror_update(mirror, NULL), SVO_UNSUPPORTED);
    assert_string_equal(svo_device_message(opened.device),
                        "svo_edit_mirror_update: the voxels span 131072 x 1 x 1, more than about 2^16 along an axis");
    svo_edit_mirror *refused = NULL;
    assert_int_equal(svo_edit_mirror_create(opened.device, NULL, NULL, &refused), SVO_INVALID_ARGUMENT);
    assert_string_equal(svo_device_message(opened.device), "svo_edit_mirror_create: edit is NULL");
    assert_int_equal(svo_edit_mirror_update(NULL, NULL), SVO_INVALID_ARGUMENT);
    assert_int_equal(
        svo_trace_voxels(svo_edit_mirror_target(mirror), svo_in_host(picture), svo_in_host(picture), 1, 0.0F, 0, NULL),
        SVO_UNSUPPORTED);
    svo_edit_mirror_destroy(&mirror);
    svo_edit_destroy(&edit);
}

/* ---- refusals ---- */

static void expect_refused(svo_edit *edit, const svo_edit_step *step, const char *words)
{
    svo_message message = {""};
    const svo_status status = svo_edit_apply(edit, step, &message);
    if (status != SVO_INVALID_ARGUMENT || strcmp(message.text, words) != 0) {
        fail_msg("%s '%s', expected '%s'", svo_name(SVO_NAME_STATUS, status), message.text, words);
    }
    assert_int_equal(info_of(edit).undo_count, 0);
}

static void wrong_steps_are_refused(void **state)
{
    (void)state;
    svo_edit *edit = make_edit(NULL, NULL);
    const svo_edit_step good = SVO_EDIT_STEP_INIT;
    svo_edit_step step = good;
    step.verb = 5;
    expect_refused(edit, &step, "svo_edit_apply: step.verb 5 is not in 0 .. 4");
    step = good;
    step.shape = 4;
    expect_refused(edit, &step, "svo_edit_apply: step.shape 4 is not in 0 .. 3");
    step = good;
    step.material = 65535;
    expect_refused(edit, &step, "svo_edit_apply: step.material 65535 is above 65534");
    step = good;
    step.end[1] = NAN;
    expect_refused(edit, &step, "svo_edit_apply: step.end.y nan with radius 0 is not within -1048576 .. 1048576");
    step = good;
    step.shape = SVO_EDIT_SPHERE;
    step.radius = -1.0;
    expect_refused(edit, &step, "svo_edit_apply: step.radius -1 is not at least 0");
    step.radius = 2.0;
    step.begin[2] = 1048575.0;
    expect_refused(edit, &step,
                   "svo_edit_apply: step.begin.z 1.04858e+06 with radius 2 is not within -1048576 .. 1048576");
    step = good;
    step.shape = SVO_EDIT_VOXELS;
    expect_refused(edit, &step, "svo_edit_apply: step.other is NULL");
    step = good;
    step.reserved = 1;
    expect_refused(edit, &step, "svo_edit_apply: step.reserved 1 is not 0");
    expect_refused(edit, NULL, "svo_edit_apply: step is NULL");
    assert_int_equal(svo_edit_undo(edit), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_edit_redo(edit), SVO_INVALID_ARGUMENT);
    svo_edit_destroy(&edit);
}

static void what_leaves_the_cube_is_refused(void **state)
{
    (void)state;
    svo_message message = {""};
    svo_edit *edit = make_edit(NULL, NULL);
    svo_edit_step step = SVO_EDIT_STEP_INIT;
    step.end[0] = step.end[1] = step.end[2] = 10.0;
    assert_int_equal(svo_edit_apply(edit, &step, NULL), SVO_OK);
    const int32_t too_far[3] = {0, (1 << 20) - 9, 0};
    const int32_t far[3] = {0, (1 << 20) - 10, 0};
    assert_int_equal(svo_edit_copy(edit, &step, too_far, &message), SVO_INVALID_ARGUMENT);
    assert_string_equal(message.text, "svo_edit_copy: voxels moved by 0, 1048567, 0 are not within -1048576, -1048576, "
                                      "-1048576 .. 1048576, 1048576, 1048576");
    assert_int_equal(info_of(edit).voxel_count, 1000);
    assert_int_equal(svo_edit_copy(edit, &step, far, &message), SVO_OK);
    assert_int_equal(info_of(edit).voxel_count, 2000);
    const int32_t beyond[3] = {0, 0, (1 << 21) + 1};
    assert_int_equal(svo_edit_copy(edit, &step, beyond, &message), SVO_INVALID_ARGUMENT);
    step.shape = SVO_EDIT_VOXELS;
    step.other = edit;
    assert_int_equal(svo_edit_copy(edit, &step, far, &message), SVO_INVALID_ARGUMENT);
    assert_string_equal(message.text, "svo_edit_copy: region.shape is not a box, sphere or capsule");
    step.offset[2] = INT32_MAX; /* what is out of the cube is nowhere: nothing is kept */
    step.verb = SVO_EDIT_KEEP;
    assert_int_equal(svo_edit_apply(edit, &step, &message), SVO_OK);
    assert_int_equal(info_of(edit).voxel_count, 0);
    svo_edit_destroy(&edit);
}

static void expect_not_created(const svo_voxels *voxels, const svo_edit_options *options, svo_status expected,
                               const char *words)
{
    svo_edit *edit = NULL;
    svo_message message = {""};
    assert_int_equal(svo_edit_create(voxels, options, &edit, &message), expected);
    assert_string_equal(message.text, words);
    assert_null(edit);
}

static void wrong_edits_are_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    svo_edit_options options = SVO_EDIT_OPTIONS_INIT;
    options.max_bytes = SVO_EDIT_BYTES_MIN - 1;
    expect_not_created(NULL, &options, SVO_INVALID_ARGUMENT,
                       "svo_edit_create: options.max_bytes 2097151 is below 2097152");
    options.max_bytes = 0;
    options.undo_count = SVO_EDIT_UNDO_MAX + 1;
    expect_not_created(NULL, &options, SVO_INVALID_ARGUMENT,
                       "svo_edit_create: options.undo_count 1048577 is above 1048576");
    options.undo_count = 0;
    options.reserved = 2;
    expect_not_created(NULL, &options, SVO_INVALID_ARGUMENT, "svo_edit_create: options.reserved 2 is not 0");
    const svo_voxel ends[] = {{.x = -1}, {.x = 1 << 20}};
    svo_voxels *list = make_list(ends, 2);
    expect_not_created(list, NULL, SVO_INVALID_ARGUMENT,
                       "svo_edit_create: x coordinates -1 .. 1048576 span more than 1048576 voxels");
    svo_voxels_destroy(&list);
    assert_int_equal(svo_edit_create(NULL, NULL, NULL, NULL), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_edit_get_info(NULL, NULL), SVO_INVALID_ARGUMENT);
    svo_tree *tree = NULL;
    assert_int_equal(svo_edit_commit(NULL, opened.device, 0, NULL, NULL, &tree, NULL), SVO_INVALID_ARGUMENT);
    assert_string_equal(svo_device_message(opened.device), "svo_edit_commit: edit is NULL");
    svo_edit *edit = make_edit(NULL, NULL);
    svo_edit_step step = SVO_EDIT_STEP_INIT;
    step.end[0] = 1 << 17;
    step.end[1] = step.end[2] = 1.0;
    assert_int_equal(svo_edit_apply(edit, &step, NULL), SVO_OK);
    assert_int_equal(svo_edit_commit(edit, opened.device, 0, NULL, NULL, &tree, NULL), SVO_INVALID_ARGUMENT);
    assert_string_equal(svo_device_message(opened.device),
                        "svo_edit_commit: the voxels span 131072 x 1 x 1, more than 2^16 along an axis");
    svo_edit_destroy(&edit);
}

TEST_GROUP(edit)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(steps_are_those_of_a_dense_array),
        cmocka_unit_test(places_are_found),
        cmocka_unit_test(long_capsules_keep_what_is_near),
        cmocka_unit_test(steps_cost_their_surface),
        cmocka_unit_test(closed_meshes_are_shapes),
        cmocka_unit_test(lists_keep_their_place_and_properties),
        cmocka_unit_test(empty_edits_have_lists_and_trees),
        cmocka_unit_test(commits_are_builds),
        cmocka_unit_test(commits_have_the_normals_of_builds),
        cmocka_unit_test(voxels_of_meshes_keep_their_normals),
        cmocka_unit_test(compact_trees_are_those_of_trees),
        cmocka_unit_test(commits_can_be_stopped),
        cmocka_unit_test(mirrors_show_what_is_committed),
        cmocka_unit_test(nodes_of_mirrors_differ_by_their_level),
        cmocka_unit_test(mirrors_have_limits),
        cmocka_unit_test(wrong_steps_are_refused),
        cmocka_unit_test(what_leaves_the_cube_is_refused),
        cmocka_unit_test(wrong_edits_are_refused),
    };
    return cmocka_run_group_tests_name("edit", tests, fixture_group_setup, fixture_group_teardown);
}
