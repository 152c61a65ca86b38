/* SPDX-License-Identifier: MIT */
/*
 * Fuzz target: arbitrary bytes as the script of svocl edit. A line is refused with a message that has its number, or it
 * is a step, and the edit then equals an array of cells to which the step's words were applied one by one, exactly. At
 * the end undo leads back to the first voxels, and a list of the last ones makes the same edit. Files that it names are
 * not opened: those of voxels have a few that are known, those of meshes are left out.
 */
#define _GNU_SOURCE /* memfd_create */
#include <math.h>
#include <stdarg.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "fuzz.h"
#include "svocl/edit_script.h"

#define STEPS_MAX  40u
#define EDGE       20 /* cells along each axis, from LOW on */
#define LOW        (-6)
#define CELLS      (EDGE * EDGE * EDGE)
#define MEMORY_MAX ((uint64_t)8 << 20)
#define LIST_MAX   20000u /* voxels of lists that are compared */

__extension__ typedef __int128 wide;

/* ---- the rest of the program ---- */

int program_fail(program *state, int exit_code, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(state->last_failure, sizeof state->last_failure, format, arguments);
    va_end(arguments);
    return exit_code;
}

/* ---- cells ---- */

/* Unknown: it was copied from where there are no cells. */
typedef enum fill { FILL_EMPTY = 0, FILL_VOXEL, FILL_UNKNOWN } fill;

typedef struct cell {
    uint8_t fill, rgba[4];
    uint16_t material;
} cell;

typedef struct world {
    svo_edit *edit, *other;
    const svo_voxel *others;
    size_t other_count;
    cell *versions[STEPS_MAX + 1];
    unsigned version_count, current;
} world;

static const svo_voxel first_voxels[] = {{0, 0, 0, {9, 8, 7, 255}, 3, 0},
                                         {1, 0, 0, {9, 8, 7, 255}, 3, 0},
                                         {7, 7, 7, {1, 2, 3, 4}, 0, 0},
                                         {-3, 5, 2, {200, 0, 0, 255}, 65534, 0}};
static const svo_voxel other_voxels[] = {
    {0, 0, 0, {50, 60, 70, 80}, 1, 0}, {0, 1, 0, {51, 60, 70, 80}, 2, 0}, {4, 4, 4, {52, 60, 70, 80}, 1, 0}};

static bool is_inside_cells(const int64_t place[3])
{
    for (int axis = 0; axis < 3; ++axis) {
        if (place[axis] < LOW || place[axis] >= LOW + EDGE) {
            return false;
        }
    }
    return true;
}

static size_t index_of(const int64_t place[3])
{
    return (size_t)(((place[2] - LOW) * EDGE + (place[1] - LOW)) * EDGE + (place[0] - LOW));
}

static cell cell_of(const svo_voxel *voxel)
{
    cell made = {.fill = FILL_VOXEL, .material = voxel->material};
    memcpy(made.rgba, voxel->rgba, sizeof made.rgba);
    return made;
}

/* ---- shapes, in units of 1/256 voxel ---- */

static int64_t round_units(double value)
{
    return (int64_t)floor(value * 256.0 + 0.5);
}

static wide dot(const int64_t a[3], const int64_t b[3])
{
    return (wide)a[0] * b[0] + (wide)a[1] * b[1] + (wide)a[2] * b[2];
}

static bool shape_has(const svo_edit_step *step, const int64_t place[3])
{
    const int64_t radius = round_units(step->radius);
    int64_t from[3];
    int64_t along[3];
    bool is_in_box = true;
    for (int axis = 0; axis < 3; ++axis) {
        const int64_t center = 256 * place[axis] + 128;
        const int64_t begin = round_units(step->begin[axis]);
        const int64_t end = round_units(step->end[axis]);
        from[axis] = center - begin;
        along[axis] = end - begin;
        is_in_box = is_in_box && center >= begin && center < end;
    }
    const wide square = (wide)radius * radius;
    const wide length = dot(along, along);
    const wide share = dot(from, along);
    if (step->shape == SVO_EDIT_BOX) {
        return is_in_box;
    }
    if (step->shape == SVO_EDIT_SPHERE || share <= 0) {
        return dot(from, from) <= square;
    }
    if (share >= length) {
        for (int axis = 0; axis < 3; ++axis) {
            from[axis] -= along[axis];
        }
        return dot(from, from) <= square;
    }
    return (dot(from, from) - square) * length <= share * share; /* Pythagoras */
}

/* ---- steps ---- */

/* What a verb makes of a cell where the shape is, with what the shape brings. */
static cell change(uint32_t verb, cell had, cell with)
{
    const cell unknown = {.fill = FILL_UNKNOWN};
    const cell empty = {.fill = FILL_EMPTY};
    if (with.fill == FILL_EMPTY) {
        return verb == SVO_EDIT_KEEP ? empty : had;
    }
    switch (verb) {
    case SVO_EDIT_SET:
        return with;
    case SVO_EDIT_ADD:
        return had.fill == FILL_EMPTY ? with : had.fill == FILL_VOXEL ? had : unknown;
    case SVO_EDIT_CLEAR:
        return with.fill == FILL_VOXEL || had.fill == FILL_EMPTY ? empty : unknown;
    case SVO_EDIT_KEEP:
        return with.fill == FILL_VOXEL || had.fill == FILL_EMPTY ? had : unknown;
    default: /* paint */
        return had.fill == FILL_VOXEL ? with : had.fill == FILL_EMPTY ? had : unknown;
    }
}

static cell brought(const world *all, const script_step *step, const cell *cells, const int64_t place[3])
{
    const int64_t source[3] = {place[0] - step->offset[0], place[1] - step->offset[1], place[2] - step->offset[2]};
    cell with = {.fill = FILL_EMPTY};
    if (step->action == SCRIPT_COPY) {
        return !shape_has(&step->step, source) ? with
               : is_inside_cells(source)       ? cells[index_of(source)]
                                               : (cell){.fill = FILL_UNKNOWN};
    }
    for (size_t i = 0; i < all->other_count && step->step.shape == SVO_EDIT_VOXELS; ++i) {
        const svo_voxel *voxel = &all->others[i];
        if (voxel->x == place[0] - step->step.offset[0] && voxel->y == place[1] - step->step.offset[1] &&
            voxel->z == place[2] - step->step.offset[2]) {
            with = cell_of(voxel);
        }
    }
    if (step->step.shape != SVO_EDIT_VOXELS && shape_has(&step->step, place)) {
        with.fill = FILL_VOXEL;
        with.material = (uint16_t)step->step.material;
        memcpy(with.rgba, step->step.rgba, sizeof with.rgba);
    }
    return with;
}

static void change_cells(world *all, const script_step *step)
{
    const cell *had = all->versions[all->current];
    while (all->version_count > all->current + 1) {
        free(all->versions[--all->version_count]);
    }
    cell *made = malloc(CELLS * sizeof *made);
    REQUIRE(made != NULL);
    for (int64_t i = 0; i < CELLS; ++i) {
        const int64_t place[3] = {LOW + i % EDGE, LOW + i / EDGE % EDGE, LOW + i / EDGE / EDGE};
        made[i] = change(step->step.verb, had[i], brought(all, step, had, place));
    }
    all->versions[all->version_count++] = made;
    ++all->current;
}

static void check_cells(const world *all)
{
    const cell *cells = all->versions[all->current];
    for (int64_t i = 0; i < CELLS; ++i) {
        const int32_t place[3] = {(int32_t)(LOW + i % EDGE), (int32_t)(LOW + i / EDGE % EDGE),
                                  (int32_t)(LOW + i / EDGE / EDGE)};
        svo_voxel found = {.x = 0};
        const bool is_there = svo_edit_find(all->edit, place, &found) != 0;
        if (cells[i].fill != FILL_UNKNOWN) {
            REQUIRE(is_there == (cells[i].fill == FILL_VOXEL));
            REQUIRE(!is_there ||
                    (memcmp(found.rgba, cells[i].rgba, sizeof found.rgba) == 0 && found.material == cells[i].material));
        }
    }
}

static void go(world *all, const script_step *step)
{
    const bool is_undo = step->action == SCRIPT_UNDO;
    for (uint32_t i = 0; i < step->count; ++i) {
        const bool can = is_undo ? all->current > 0 : all->current + 1 < all->version_count;
        const svo_status status = is_undo ? svo_edit_undo(all->edit) : svo_edit_redo(all->edit);
        REQUIRE(status == (can ? SVO_OK : SVO_INVALID_ARGUMENT));
        if (!can) {
            return;
        }
        all->current = is_undo ? all->current - 1 : all->current + 1;
    }
}

static void do_step(world *all, script_step *step)
{
    svo_message message = {""};
    if (step->action == SCRIPT_UNDO || step->action == SCRIPT_REDO) {
        go(all, step);
        return;
    }
    if (step->is_mesh) {
        return;
    }
    step->step.other = step->file != NULL ? all->other : NULL;
    const svo_status status = step->action == SCRIPT_COPY
                                  ? svo_edit_copy(all->edit, &step->step, step->offset, &message)
                                  : svo_edit_apply(all->edit, &step->step, &message);
    if (status == SVO_OK) {
        change_cells(all, step);
    } else {
        REQUIRE(status == SVO_INVALID_ARGUMENT || status == SVO_CAPACITY_EXCEEDED);
        REQUIRE(strstr(message.text, "svo_edit_") == message.text);
    }
}

/* ---- scripts ---- */

static void run_script(world *all, edit_script *script, program *state)
{
    script_step step;
    for (unsigned i = 0; i < STEPS_MAX; ++i) {
        const int exit_code = edit_script_next(state, script, &step);
        if (exit_code != PROGRAM_DONE) {
            char begin[96];
            (void)snprintf(begin, sizeof begin, "%s:%u: ", script->path, script->line);
            REQUIRE(exit_code == PROGRAM_FAILED && strncmp(state->last_failure, begin, strlen(begin)) == 0);
            return;
        }
        if (step.action == SCRIPT_END) {
            return;
        }
        do_step(all, &step);
        check_cells(all);
    }
}

static svo_edit *make_edit(const svo_voxel *voxels, size_t count)
{
    const svo_voxels_source source = {.struct_size = sizeof source, .voxels = voxels, .voxel_count = count};
    const svo_edit_options asked = {.struct_size = sizeof asked, .max_bytes = MEMORY_MAX};
    svo_voxels *list = NULL;
    svo_edit *made = NULL;
    REQUIRE(svo_voxels_create(&source, &list, NULL) == SVO_OK);
    REQUIRE(svo_edit_create(list, &asked, &made, NULL) == SVO_OK);
    svo_voxels_destroy(&list);
    return made;
}

/* An edit of the list of these voxels has the same. */
static void check_list(const world *all)
{
    svo_edit_info had = SVO_EDIT_INFO_INIT;
    svo_edit_info has = SVO_EDIT_INFO_INIT;
    svo_voxels *list = NULL;
    world again = *all;
    REQUIRE(svo_edit_get_info(all->edit, &had) == SVO_OK);
    if (had.voxel_count > LIST_MAX) {
        return;
    }
    REQUIRE(svo_edit_get_voxels(all->edit, &list, NULL) == SVO_OK);
    REQUIRE(svo_edit_create(list, NULL, &again.edit, NULL) == SVO_OK);
    svo_voxels_destroy(&list);
    REQUIRE(svo_edit_get_info(again.edit, &has) == SVO_OK && has.voxel_count == had.voxel_count);
    check_cells(&again);
    svo_edit_destroy(&again.edit);
}

static void begin(world *all)
{
    const size_t count = sizeof first_voxels / sizeof *first_voxels;
    all->others = other_voxels;
    all->other_count = sizeof other_voxels / sizeof *other_voxels;
    all->edit = make_edit(first_voxels, count);
    all->other = make_edit(all->others, all->other_count);
    all->versions[0] = calloc(CELLS, sizeof *all->versions[0]);
    all->version_count = 1;
    REQUIRE(all->versions[0] != NULL);
    for (size_t i = 0; i < count; ++i) {
        const int64_t place[3] = {first_voxels[i].x, first_voxels[i].y, first_voxels[i].z};
        all->versions[0][index_of(place)] = cell_of(&first_voxels[i]);
    }
    check_cells(all);
}

static void end(world *all)
{
    while (all->current > 0) {
        REQUIRE(svo_edit_undo(all->edit) == SVO_OK);
        --all->current;
    }
    check_cells(all);
    while (all->version_count > 0) {
        free(all->versions[--all->version_count]);
    }
    svo_edit_destroy(&all->edit);
    svo_edit_destroy(&all->other);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t byte_count)
{
    static program state;
    char path[64];
    edit_script script;
    world all = {.edit = NULL};
    const int file = memfd_create("script", 0);
    REQUIRE(file >= 0);
    REQUIRE(write(file, data, byte_count) == (ssize_t)byte_count);
    (void)snprintf(path, sizeof path, "/proc/self/fd/%d", file);
    const int exit_code = edit_script_open(&state, path, &script);
    if (exit_code == PROGRAM_DONE) {
        begin(&all);
        run_script(&all, &script, &state);
        check_list(&all);
        end(&all);
    } else {
        REQUIRE(exit_code == PROGRAM_FAILED && state.last_failure[0] != '\0');
    }
    edit_script_close(&script);
    (void)close(file);
    return 0;
}
