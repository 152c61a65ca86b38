/* SPDX-License-Identifier: MIT */
/*
 * Planning from a mesh file, by any number of processes (svo_parts_planning). This process makes the tasks of a step,
 * others or itself do them (ranges.c), and it puts their results together in the order of the ranges: so the plan does
 * not depend on how many there are, nor on who is done first.
 *
 * The grid is that of the triangles' vertices. It is taken from all vertices of the file, which are quicker to read; if
 * the count finds that triangles do not use those on the bounds, it is done again on the right grid.
 */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <string.h>

#include "core/device.h"
#include "core/memory.h"
#include "core/struct_size.h"
#include "parts/folder.h"
#include "parts/job.h"
#include "parts/planning.h"
#include "parts/ranges.h"
#include "pipeline/run.h"

#define NAME       "svo_parts_planning_begin"
#define RANGES_MAX 65536u

struct svo_parts_planning {
    svo_parts *parts;
    svo_device *device;
    char *path;
    unsigned depth;
    svo_plan_options options; /* without pointers */
    svo_i_blocks_extent extent;
    svo_i_step step;
    uint32_t range_count; /* that may be read side by side */
    svo_i_bounds bounds; /* of the grid */
    bool any_color;
    uint32_t cells_level;
    svo_plan *empty;
    svo_i_survey survey;
    svo_i_cut cut;
    svo_i_range_task **tasks; /* range_count, of the step */
    svo_i_range_result **results; /* likewise; NULL: not yet */
    svo_i_triangle_hash *kept; /* of each range, from the count */
    size_t taken_count;
};

static svo_status no_memory(const svo_parts_planning *p, svo_message *message)
{
    return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory to plan its parts", p->path);
}

static svo_status fail_device(const svo_parts_planning *p, svo_status status, svo_message *message)
{
    return svo_i_fail(message, status, "%s", svo_device_message(p->device));
}

/* ---- tasks ---- */

static void free_step(svo_parts_planning *p)
{
    for (uint32_t i = 0; i < p->range_count; ++i) {
        svo_i_free(p->tasks[i]);
        svo_i_free(p->results[i]);
        p->tasks[i] = NULL;
        p->results[i] = NULL;
    }
    p->taken_count = 0;
}

/* Makes a task without sections that are filled in. */
static svo_status make_task(svo_parts_planning *p, uint32_t range, size_t section_count, svo_message *message)
{
    const char *place = p->step == STEP_WRITE ? p->parts->place : "";
    const uint64_t items = p->step == STEP_BOUNDS ? p->extent.vertices : p->extent.items;
    const size_t path_bytes = strlen(p->path) + 1;
    const size_t place_bytes = strlen(place) + 1;
    const size_t bytes = sizeof(svo_i_range_task) + section_count * sizeof(svo_i_section) + path_bytes + place_bytes;
    svo_i_range_task *task = svo_i_alloc_zeroed(NULL, 1, bytes);
    if (task == NULL) {
        return no_memory(p, message);
    }
    *task =
        (svo_i_range_task){.bytes = bytes,
                           .version = RANGE_VERSION,
                           .step = (uint32_t)p->step,
                           .range = range,
                           .depth = p->depth,
                           .cells_level = p->cells_level,
                           .fields = p->parts->fields,
                           .section_count = (uint32_t)section_count,
                           .path_bytes = (uint32_t)path_bytes,
                           .place_bytes = (uint32_t)place_bytes,
                           .any_color = p->any_color ? 1 : 0,
                           .file_bytes = p->extent.file_bytes,
                           .begin = items / p->range_count * range + items % p->range_count * range / p->range_count,
                           .bounds = p->bounds,
                           .options = p->options,
                           .header = p->parts->header};
    const uint32_t next = range + 1;
    task->end = items / p->range_count * next + items % p->range_count * next / p->range_count;
    memcpy(task->magic, RANGE_TASK_MAGIC, sizeof task->magic);
    char *paths = (char *)(task + 1) + section_count * sizeof(svo_i_section);
    memcpy(paths, p->path, path_bytes);
    memcpy(paths + path_bytes, place, place_bytes);
    p->tasks[range] = task;
    return SVO_OK;
}

/* Begins a step whose tasks have no sections. */
static svo_status begin_step(svo_parts_planning *p, svo_i_step step, svo_message *message)
{
    free_step(p);
    p->step = step;
    for (uint32_t i = 0; i < p->range_count; ++i) {
        SVO_I_TRY(make_task(p, i, 0, message));
    }
    return SVO_OK;
}

/* Begins a step again with all of the file in one range. */
static svo_status use_one_range(svo_parts_planning *p, svo_message *message)
{
    const svo_i_step step = p->step;
    free_step(p);
    p->range_count = 1;
    return begin_step(p, step, message);
}

static bool is_uneven(const svo_parts_planning *p)
{
    bool uneven = false;
    for (uint32_t i = 0; i < p->range_count; ++i) {
        uneven = uneven || p->results[i]->is_uneven != 0;
    }
    return uneven;
}

/* ---- the grid ---- */

/* Begins a survey of the whole, with the bounds that all results have. */
static svo_status begin_survey(svo_parts_planning *p, svo_message *message)
{
    const svo_mesh none = {.struct_size = sizeof none};
    svo_plan_destroy(&p->empty);
    svo_status status = svo_i_plan_of_parts(p->device, NAME, &none, p->depth, &p->options, &p->empty);
    if (status == SVO_OK) {
        status = svo_i_survey_begin(p->empty, &p->survey);
    }
    if (status != SVO_OK) {
        return fail_device(p, status, message);
    }
    for (uint32_t i = 0; i < p->range_count && p->results[i] != NULL; ++i) {
        const svo_i_bounds *of_range = &p->results[i]->sums.bounds;
        svo_i_bounds *bounds = &p->survey.bounds;
        bounds->any = bounds->any || of_range->any;
        for (unsigned axis = 0; axis < 3; ++axis) {
            bounds->low[axis] = fmin(bounds->low[axis], of_range->low[axis]);
            bounds->high[axis] = fmax(bounds->high[axis], of_range->high[axis]);
        }
    }
    return SVO_OK;
}

static svo_status begin_count(svo_parts_planning *p, svo_message *message)
{
    p->parts->fields =
        (p->extent.has_normals ? TRIANGLE_NORMALS : 0u) | (p->extent.has_colors || p->any_color ? TRIANGLE_COLORS : 0u);
    p->cells_level = svo_i_cut_level(p->parts, p->depth, p->extent.items);
    return begin_step(p, STEP_COUNT, message);
}

static svo_status end_bounds(svo_parts_planning *p, svo_message *message)
{
    SVO_I_TRY(begin_survey(p, message));
    for (uint32_t i = 0; i < p->range_count; ++i) {
        p->any_color = p->any_color || p->results[i]->any_color != 0;
    }
    p->bounds = p->survey.bounds;
    /* Vertices that no triangle uses may make a grid that there cannot be. */
    return svo_i_survey_fit(&p->survey) == SVO_OK ? begin_count(p, message) : begin_step(p, STEP_USED, message);
}

static svo_status end_used(svo_parts_planning *p, svo_message *message)
{
    SVO_I_TRY(begin_survey(p, message));
    p->bounds = p->survey.bounds;
    const svo_status status = svo_i_survey_fit(&p->survey);
    return status == SVO_OK ? begin_count(p, message) : fail_device(p, status, message);
}

/* ---- the cut ---- */

/* A count's cells. */
static svo_i_cell_list cells_of(svo_i_range_result *result)
{
    return (svo_i_cell_list){
        .cells = (svo_i_cell *)(result + 1), .count = (size_t)result->list_count, .level = result->cells_level};
}

/* Adds up the histograms of all ranges. */
static svo_status add_cells(const svo_parts_planning *p, svo_i_cell_list *all, svo_message *message)
{
    all->level = p->cells_level;
    for (uint32_t i = 0; i < p->range_count; ++i) {
        const svo_i_cell_list list = cells_of(p->results[i]);
        if (!svo_i_cell_list_add(all, &list)) {
            return no_memory(p, message);
        }
    }
    return SVO_OK;
}

/* Makes the header of what the ranges have found. */
static svo_status make_header(svo_parts_planning *p, svo_message *message)
{
    svo_i_triangle_hash hash = {.count = 0};
    for (uint32_t i = 0; i < p->range_count; ++i) {
        p->kept[i] = p->results[i]->kept;
        svo_i_triangle_hash_append(&hash, &p->kept[i]);
        svo_i_survey_append(&p->survey, &p->results[i]->sums);
    }
    p->parts->header = (svo_part_header)SVO_PART_HEADER_INIT;
    const svo_status status = svo_i_survey_header(&p->survey, &p->parts->header);
    if (status != SVO_OK) {
        return fail_device(p, status, message);
    }
    p->parts->header.input_hash = hash.value;
    return SVO_OK;
}

/* Makes the task of a range: its section of each part. places: how many triangles the parts have so far. */
static svo_status make_sections(svo_parts_planning *p, uint32_t range, const svo_i_cell_list *list, uint64_t *places,
                                uint64_t first_name, svo_message *message)
{
    SVO_I_TRY(make_task(p, range, p->cut.count, message));
    svo_i_range_task *task = p->tasks[range];
    svo_i_section *sections = (svo_i_section *)(task + 1);
    task->first_name = first_name;
    for (size_t i = 0; i < p->cut.count; ++i) {
        const svo_i_part_entry *entry = &p->cut.parts[i].entry;
        const uint64_t count = svo_i_cell_list_find(list, entry->level, entry->code).count;
        sections[i] = (svo_i_section){.code = entry->code, .level = entry->level, .first = places[i], .count = count};
        places[i] += count;
    }
    return SVO_OK;
}

static svo_status begin_write(svo_parts_planning *p, svo_message *message)
{
    svo_status status = SVO_OK;
    uint64_t first_name = 0;
    uint64_t *places = svo_i_alloc_zeroed(NULL, p->cut.count + 1, sizeof *places);
    if (places == NULL) {
        return no_memory(p, message);
    }
    p->step = STEP_WRITE;
    for (uint32_t i = 0; i < p->range_count; ++i) {
        svo_i_cell_list list = cells_of(p->results[i]);
        svo_i_cell_list_total(&list);
        svo_i_free(p->tasks[i]);
        p->tasks[i] = NULL;
        SVO_I_TRY_CLEANUP(make_sections(p, i, &list, places, first_name, message));
        first_name += p->kept[i].count;
        svo_i_free(p->results[i]);
        p->results[i] = NULL;
    }
    p->taken_count = 0;
cleanup:
    svo_i_free(places);
    return status;
}

static svo_status cut_grid(svo_parts_planning *p, svo_message *message)
{
    svo_i_cell_list all = {.cells = NULL};
    svo_status status = SVO_OK;
    SVO_I_TRY_CLEANUP(make_header(p, message));
    SVO_I_TRY_CLEANUP(add_cells(p, &all, message));
    svo_i_cell_list_total(&all);
    if (p->parts->max_bytes == 0) {
        SVO_I_TRY_CLEANUP(svo_i_cut_choose_limit(p->parts, p->device, &all, message));
    }
    SVO_I_TRY_CLEANUP(svo_i_planning_begin(p->parts, p->device, message));
    SVO_I_TRY_CLEANUP(svo_i_cut_make(p->parts, p->device, &all, &p->cut, message));
    p->cells_level = all.level;
    status = begin_write(p, message);
cleanup:
    svo_i_free(all.cells);
    return status;
}

static bool are_same(const svo_i_bounds *a, const svo_i_bounds *b)
{
    bool same = a->any == b->any;
    for (unsigned axis = 0; axis < 3; ++axis) {
        same = same && a->low[axis] == b->low[axis] && a->high[axis] == b->high[axis];
    }
    return same;
}

static svo_status end_count(svo_parts_planning *p, svo_message *message)
{
    uint64_t triangles = 0;
    SVO_I_TRY(begin_survey(p, message));
    for (uint32_t i = 0; i < p->range_count; ++i) {
        triangles += p->results[i]->sums.triangles;
    }
    if (triangles == 0) {
        return svo_i_fail(message, SVO_IMPORT_FAILED, "svo_parts_create_from_file: the file has no triangles");
    }
    if (triangles >= UINT32_MAX) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT,
                          "svo_parts_create_from_file: the mesh has 2^32 - 1 triangles or more");
    }
    if (p->options.edge == 0.0 && !are_same(&p->survey.bounds, &p->bounds)) {
        p->bounds = p->survey.bounds;
        return begin_step(p, STEP_COUNT, message);
    }
    const svo_status status = svo_i_survey_fit(&p->survey);
    return status == SVO_OK ? cut_grid(p, message) : fail_device(p, status, message);
}

/* ---- the end ---- */

/* Completes the parts' files. */
static svo_status end_write(svo_parts_planning *p, svo_message *message)
{
    svo_i_triangle_hash *hashes = svo_i_alloc_zeroed(NULL, p->cut.count + 1, sizeof *hashes);
    svo_status status = SVO_OK;
    if (hashes == NULL) {
        return no_memory(p, message);
    }
    for (uint32_t i = 0; i < p->range_count; ++i) {
        const svo_i_triangle_hash *of_range = (const svo_i_triangle_hash *)(p->results[i] + 1);
        if (memcmp(&p->results[i]->kept, &p->kept[i], sizeof p->kept[i]) != 0) {
            status = svo_i_fail(message, SVO_FILE_ERROR, "%s: has changed while its parts were planned", p->path);
            goto cleanup;
        }
        for (size_t k = 0; k < p->cut.count; ++k) {
            svo_i_triangle_hash_append(&hashes[k], &of_range[k]);
        }
    }
    status = svo_i_cut_write_tails(p->parts, &p->cut, hashes, message);
    p->step = STEP_DONE;
cleanup:
    svo_i_free(hashes);
    return status;
}

static svo_status end_step(svo_parts_planning *p, svo_message *message)
{
    if (is_uneven(p)) {
        return use_one_range(p, message);
    }
    switch (p->step) {
    case STEP_BOUNDS:
        return end_bounds(p, message);
    case STEP_USED:
        return end_used(p, message);
    case STEP_COUNT:
        return end_count(p, message);
    default:
        return end_write(p, message);
    }
}

/* ---- the handle ---- */

static svo_status check_begin(const svo_device *device, const char *path, const char *folder, unsigned ranges,
                              svo_message *message)
{
    if (device == NULL || path == NULL || folder == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, NAME ": %s is NULL",
                          device == NULL ? "device"
                          : path == NULL ? "path"
                                         : "folder");
    }
    return ranges >= 1 && ranges <= RANGES_MAX
               ? SVO_OK
               : svo_i_fail(message, SVO_INVALID_ARGUMENT, NAME ": ranges %u is not in 1 .. %u", ranges, RANGES_MAX);
}

/* Finds what the file has, and whether the request can be served from a file. */
static svo_status look_at_file(svo_parts_planning *p, svo_message *message)
{
    svo_i_blocks *blocks = NULL;
    SVO_I_TRY(svo_i_blocks_open(p->path, &blocks, message));
    p->extent = svo_i_blocks_get_extent(blocks);
    svo_i_blocks_close(&blocks);
    p->range_count = p->extent.is_even ? p->range_count : 1;
    SVO_I_TRY(begin_survey(p, message));
    return begin_step(p, STEP_BOUNDS, message);
}

static svo_status begin(svo_parts_planning *p, const char *path, const svo_plan_options *options, unsigned ranges,
                        svo_message *message)
{
    svo_plan_options given;
    SVO_I_TRY(
        svo_i_struct_read(message, NAME, "options", options, &given, SVO_I_STRUCT_SIZES(svo_plan_options, coverage)));
    if (given.part_header != NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, NAME ": options.part_header is not NULL");
    }
    p->options = given;
    p->options.progress = NULL;
    p->options.progress_user = NULL;
    p->options.part_triangles = NULL;
    p->path = svo_i_copy_text(NULL, path);
    p->range_count = ranges;
    p->tasks = svo_i_alloc_zeroed(NULL, ranges, sizeof *p->tasks);
    p->results = svo_i_alloc_zeroed(NULL, ranges, sizeof *p->results);
    p->kept = svo_i_alloc_zeroed(NULL, ranges, sizeof *p->kept);
    if (p->path == NULL || p->tasks == NULL || p->results == NULL || p->kept == NULL) {
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, NAME ": out of memory");
    }
    SVO_I_TRY(svo_i_lease_check(p->parts->folder, message)); /* before work that would be in vain */
    return look_at_file(p, message);
}

svo_status svo_parts_planning_begin(svo_device *device, const char *path, unsigned depth,
                                    const svo_plan_options *options, uint64_t max_bytes, const char *folder,
                                    unsigned ranges, svo_parts_planning **out, svo_message *message)
{
    SVO_I_TRY(check_begin(device, path, folder, ranges, message));
    if (out == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, NAME ": out is NULL");
    }
    svo_parts_planning *p = svo_i_alloc_zeroed(NULL, 1, sizeof *p);
    svo_status status = SVO_OUT_OF_HOST_MEMORY;
    if (p != NULL) {
        p->device = device;
        p->depth = depth;
        p->parts = svo_i_folder_new(folder, max_bytes);
    }
    if (p == NULL || p->parts == NULL) {
        status = svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, NAME ": out of memory");
    } else {
        status = begin(p, path, options, ranges, message);
    }
    if (status != SVO_OK) {
        svo_parts_planning_end(&p);
        return status;
    }
    *out = p;
    return SVO_OK;
}

svo_status svo_parts_planning_tasks(svo_parts_planning *planning, size_t *count, svo_message *message)
{
    if (planning == NULL || count == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "svo_parts_planning_tasks: %s is NULL",
                          planning == NULL ? "planning" : "count");
    }
    *count = planning->step == STEP_DONE ? 0 : planning->range_count;
    return svo_i_planning_renew(planning->parts, message);
}

static svo_status check_task(const svo_parts_planning *planning, const char *function, size_t index,
                             svo_message *message)
{
    if (planning == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: planning is NULL", function);
    }
    const size_t count = planning->step == STEP_DONE ? 0 : planning->range_count;
    return index < count && planning->tasks[index] != NULL
               ? SVO_OK
               : svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: index %zu is not below %zu", function, index, count);
}

svo_status svo_parts_planning_task(const svo_parts_planning *planning, size_t index, const void **task,
                                   size_t *byte_count, svo_message *message)
{
    static const char function[] = "svo_parts_planning_task";
    SVO_I_TRY(check_task(planning, function, index, message));
    if (task == NULL || byte_count == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: %s is NULL", function,
                          task == NULL ? "task" : "byte_count");
    }
    *task = planning->tasks[index];
    *byte_count = (size_t)planning->tasks[index]->bytes;
    return SVO_OK;
}

svo_status svo_parts_planning_work(svo_device *device, const void *task, size_t byte_count, void **result,
                                   size_t *result_bytes, svo_message *message)
{
    static const char function[] = "svo_parts_planning_work";
    svo_i_range_result *made = NULL;
    if (device == NULL || task == NULL || result == NULL || result_bytes == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: %s is NULL", function,
                          device == NULL   ? "device"
                          : task == NULL   ? "task"
                          : result == NULL ? "result"
                                           : "result_bytes");
    }
    void *aligned = svo_i_alloc(NULL, byte_count + 1);
    if (aligned == NULL) {
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: out of memory", function);
    }
    memcpy(aligned, task, byte_count);
    const svo_status status =
        svo_i_range_is_task(aligned, byte_count)
            ? svo_i_range_run(device, aligned, NULL, NULL, &made, message)
            : svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: task is none of this version of svocl", function);
    svo_i_free(aligned);
    if (status == SVO_OK) {
        *result = made;
        *result_bytes = (size_t)made->bytes;
    }
    return status;
}

void svo_parts_planning_free(void *result)
{
    svo_i_free(result);
}

/* Takes a result that the planning owns from now on. */
static svo_status take(svo_parts_planning *p, size_t index, svo_i_range_result *result, svo_message *message)
{
    svo_i_free(p->results[index]);
    p->taken_count += p->results[index] == NULL ? 1u : 0u;
    p->results[index] = result;
    return p->taken_count == p->range_count ? end_step(p, message) : SVO_OK;
}

svo_status svo_parts_planning_take(svo_parts_planning *planning, size_t index, const void *result, size_t byte_count,
                                   svo_message *message)
{
    static const char function[] = "svo_parts_planning_take";
    SVO_I_TRY(check_task(planning, function, index, message));
    if (result == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: result is NULL", function);
    }
    void *copy = svo_i_alloc(NULL, byte_count + 1);
    if (copy == NULL) {
        return no_memory(planning, message);
    }
    memcpy(copy, result, byte_count);
    bool is_right = svo_i_range_is_result(copy, byte_count, planning->tasks[index]);
    if (is_right && planning->step == STEP_COUNT) {
        const svo_i_cell_list list = cells_of(copy);
        is_right = svo_i_cell_list_is_whole(&list);
    }
    if (!is_right) {
        svo_i_free(copy);
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: result is none of task %zu", function, index);
    }
    return take(planning, index, copy, message);
}

svo_status svo_parts_planning_finish(svo_parts_planning *planning, svo_message *message)
{
    if (planning == NULL || planning->step != STEP_DONE) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "svo_parts_planning_finish: %s",
                          planning == NULL ? "planning is NULL" : "not all tasks are done");
    }
    SVO_I_TRY(svo_i_parts_divide(planning->parts, &planning->cut, planning->device, message));
    return svo_i_planning_switch(planning->parts, message);
}

void svo_parts_planning_end(svo_parts_planning **planning)
{
    svo_parts_planning *p = planning != NULL ? *planning : NULL;
    if (p == NULL) {
        return;
    }
    if (p->tasks != NULL && p->results != NULL) {
        free_step(p);
    }
    svo_i_free(p->tasks);
    svo_i_free(p->results);
    svo_i_free(p->kept);
    svo_i_cut_free(&p->cut);
    svo_plan_destroy(&p->empty);
    svo_parts_close(&p->parts);
    svo_i_free(p->path);
    svo_i_free(p);
    *planning = NULL;
}

/* ---- all in this process ---- */

static svo_status stay_alive(void *user, svo_message *message)
{
    const svo_parts_planning *p = user;
    return svo_i_planning_renew(p->parts, message);
}

static svo_status do_all(svo_parts_planning *p, svo_message *message)
{
    while (p->step != STEP_DONE) {
        svo_i_range_result *result = NULL;
        SVO_I_TRY(svo_i_range_run(p->device, p->tasks[0], stay_alive, p, &result, message));
        SVO_I_TRY(take(p, 0, result, message));
    }
    return svo_parts_planning_finish(p, message);
}

svo_status svo_parts_create_from_file(svo_device *device, const char *path, unsigned depth,
                                      const svo_plan_options *options, uint64_t max_bytes, const char *folder,
                                      svo_message *message)
{
    svo_parts_planning *planning = NULL;
    SVO_I_TRY(svo_parts_planning_begin(device, path, depth, options, max_bytes, folder, 1, &planning, message));
    const svo_status status = do_all(planning, message);
    svo_parts_planning_end(&planning);
    return status;
}
