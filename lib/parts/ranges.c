/* SPDX-License-Identifier: MIT */
/* What is done with one range of a mesh file while its parts are planned. */
#include "parts/ranges.h"

#include <math.h>
#include <string.h>

#include "core/memory.h"
#include "core/message.h"
#include "parts/triangles.h"
#include "pipeline/run.h"

/* A range on its way. */
typedef struct passing {
    svo_device *device;
    svo_message *message;
    const svo_i_range_task *task;
    svo_i_range_alive *alive;
    void *user;
    svo_i_blocks *blocks;
    svo_plan *empty;
    svo_i_survey survey;
    svo_i_cells cells;
    svo_i_sections *sections;
    uint32_t *kept; /* BLOCK_TRIANGLES */
    int32_t (*corners)[3][3]; /* likewise */
    unsigned char *record;
    svo_i_range_result result;
    svo_i_cell_list list;
    svo_i_triangle_hash *hashes;
} passing;

const svo_i_section *svo_i_range_sections(const svo_i_range_task *task)
{
    return (const svo_i_section *)(task + 1);
}

const char *svo_i_range_path(const svo_i_range_task *task)
{
    return (const char *)(svo_i_range_sections(task) + task->section_count);
}

static const char *place_of(const svo_i_range_task *task)
{
    return svo_i_range_path(task) + task->path_bytes;
}

bool svo_i_range_is_task(const void *bytes, size_t byte_count)
{
    const svo_i_range_task *task = bytes;
    if (byte_count < sizeof *task || memcmp(task->magic, RANGE_TASK_MAGIC, sizeof task->magic) != 0 ||
        task->version != RANGE_VERSION || task->bytes != byte_count || task->step >= STEP_DONE) {
        return false;
    }
    const uint64_t needed = sizeof *task + (uint64_t)task->section_count * sizeof(svo_i_section) +
                            (uint64_t)task->path_bytes + task->place_bytes;
    return needed == byte_count && task->path_bytes > 0 && task->place_bytes > 0 &&
           svo_i_range_path(task)[task->path_bytes - 1] == '\0' && place_of(task)[task->place_bytes - 1] == '\0';
}

static size_t element_bytes(uint32_t step)
{
    return step == STEP_COUNT ? sizeof(svo_i_cell) : sizeof(svo_i_triangle_hash);
}

bool svo_i_range_is_result(const void *bytes, size_t byte_count, const svo_i_range_task *task)
{
    const svo_i_range_result *result = bytes;
    if (byte_count < sizeof *result || memcmp(result->magic, RANGE_RESULT_MAGIC, sizeof result->magic) != 0 ||
        result->version != RANGE_VERSION || result->bytes != byte_count || result->step != task->step ||
        result->range != task->range || result->list_count > byte_count) {
        return false;
    }
    const size_t expected = result->is_uneven != 0 || task->step != STEP_WRITE ? 0 : task->section_count;
    return byte_count == sizeof *result + result->list_count * element_bytes(result->step) &&
           (task->step == STEP_COUNT || result->list_count == expected);
}

static svo_status no_memory(const passing *p)
{
    return svo_i_fail(p->message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory to plan its parts", svo_i_range_path(p->task));
}

static svo_status fail_device(const passing *p, svo_status status)
{
    return svo_i_fail(p->message, status, "%s", svo_device_message(p->device));
}

static svo_status next_block(passing *p, svo_mesh *block)
{
    SVO_I_TRY(svo_i_blocks_next(p->blocks, block));
    return p->alive != NULL ? p->alive(p->user, p->message) : SVO_OK;
}

/* ---- bounds ---- */

static svo_status find_bounds(passing *p)
{
    bool any_color = false;
    svo_i_bounds *bounds = &p->survey.bounds;
    SVO_I_TRY(svo_i_blocks_bounds(p->blocks, p->task->begin, p->task->end, bounds, &any_color));
    p->result.any_color = any_color ? 1 : 0;
    return SVO_OK;
}

static svo_status find_used(passing *p)
{
    svo_mesh block;
    do {
        SVO_I_TRY(next_block(p, &block));
        svo_i_survey_bounds(&p->survey, &block);
    } while (block.triangle_count > 0);
    return SVO_OK;
}

/* ---- counting ---- */

/* Adds the kept triangles of a block to the histogram and the hash. */
static svo_status count_block(passing *p, const svo_mesh *block, uint32_t kept_count)
{
    const svo_part_header grid = {.snap_bits = p->empty->info.snap_bits, .coverage = p->empty->info.coverage};
    const uint32_t fields = svo_i_triangle_fields(block);
    const size_t record_bytes = svo_i_triangle_bytes(fields);
    for (uint32_t i = 0; i < kept_count; ++i) {
        svo_i_placing placing;
        svo_i_triangle_put(block, fields, p->kept[i], 0, p->record);
        svo_i_triangle_hash_add(&p->result.kept, svo_i_triangle_hash_of(p->record, record_bytes), 0);
        svo_i_placing_make(&grid, p->task->cells_level, (const int32_t(*)[3])p->corners[i], &placing);
        if (!svo_i_cells_add(&p->cells, grid.snap_bits, &placing)) {
            return no_memory(p);
        }
    }
    return SVO_OK;
}

/* Makes the grid; the survey's bounds are then to be those of what triangles use. */
static svo_status take_grid(passing *p)
{
    p->survey.bounds = p->task->bounds;
    const svo_status status = svo_i_survey_fit(&p->survey);
    p->survey.bounds = svo_i_survey_no_bounds();
    return status == SVO_OK ? SVO_OK : fail_device(p, status);
}

static svo_status count(passing *p)
{
    svo_mesh block;
    SVO_I_TRY(take_grid(p));
    p->cells.level = p->task->cells_level;
    do {
        uint32_t kept_count = 0;
        SVO_I_TRY(next_block(p, &block));
        svo_i_survey_bounds(&p->survey, &block);
        const svo_status status = svo_i_survey_add(&p->survey, &block, p->kept, p->corners, &kept_count);
        if (status != SVO_OK) {
            return fail_device(p, status);
        }
        SVO_I_TRY(count_block(p, &block, kept_count));
    } while (block.triangle_count > 0);
    svo_i_cell_list_take(&p->cells, &p->list);
    p->result.cells_level = p->list.level;
    p->result.list_count = p->list.count;
    return SVO_OK;
}

/* ---- writing ---- */

static svo_status write_block(passing *p, const svo_snap *snap, const svo_mesh *block)
{
    const uint32_t fields = p->task->fields;
    const size_t record_bytes = svo_i_triangle_bytes(fields);
    for (size_t t = 0; t < block->triangle_count; ++t) {
        int32_t corners[3][3];
        if (!svo_i_survey_places(&p->task->header, snap, block, t, corners)) {
            continue;
        }
        const uint32_t name = (uint32_t)(p->task->first_name + p->result.kept.count);
        svo_i_triangle_put(block, fields, (uint32_t)t, name, p->record);
        const uint64_t hash = svo_i_triangle_hash_of(p->record, record_bytes);
        svo_i_triangle_hash_add(&p->result.kept, hash, 0);
        SVO_I_TRY(svo_i_sections_add(p->sections, (const int32_t(*)[3])corners, p->record, hash, name));
    }
    return SVO_OK;
}

static svo_status write_sections(passing *p)
{
    const svo_i_range_task *task = p->task;
    const svo_part_header *header = &task->header;
    const svo_snap snap = svo_make_snap(header->scale, header->edge, (int32_t)header->snap_bits);
    svo_mesh block;
    p->hashes = svo_i_alloc(NULL, ((size_t)task->section_count + 1) * sizeof *p->hashes);
    if (p->hashes == NULL) {
        return no_memory(p);
    }
    SVO_I_TRY(svo_i_sections_begin(header, task->cells_level, task->fields, place_of(task), svo_i_range_sections(task),
                                   task->section_count, p->message, &p->sections));
    do {
        SVO_I_TRY(next_block(p, &block));
        SVO_I_TRY(write_block(p, &snap, &block));
    } while (block.triangle_count > 0);
    p->result.list_count = task->section_count;
    return svo_i_sections_finish(p->sections, p->hashes);
}

/* ---- all steps ---- */

static svo_status open_mesh(passing *p)
{
    const svo_i_range_task *task = p->task;
    SVO_I_TRY(svo_i_blocks_open(svo_i_range_path(task), &p->blocks, p->message));
    const svo_i_blocks_extent extent = svo_i_blocks_get_extent(p->blocks);
    const uint64_t most = task->step == STEP_BOUNDS ? extent.vertices : extent.items;
    if (extent.file_bytes != task->file_bytes || task->begin > task->end || task->end > most) {
        return svo_i_fail(p->message, SVO_FILE_ERROR, "%s: has changed while its parts were planned",
                          svo_i_range_path(task));
    }
    if (task->step != STEP_BOUNDS) {
        svo_i_blocks_select(p->blocks, task->begin, task->end, task->any_color != 0);
    }
    p->kept = svo_i_alloc(NULL, BLOCK_TRIANGLES * sizeof *p->kept);
    p->corners = svo_i_alloc(NULL, BLOCK_TRIANGLES * sizeof *p->corners);
    p->record = svo_i_alloc(NULL, svo_i_triangle_bytes(UINT32_MAX));
    return p->kept != NULL && p->corners != NULL && p->record != NULL ? SVO_OK : no_memory(p);
}

static svo_status run_step(passing *p)
{
    switch ((svo_i_step)p->task->step) {
    case STEP_BOUNDS:
        return find_bounds(p);
    case STEP_USED:
        return find_used(p);
    case STEP_COUNT:
        return count(p);
    default:
        return write_sections(p);
    }
}

static svo_status run(passing *p)
{
    const svo_mesh none = {.struct_size = sizeof none};
    svo_status status =
        svo_i_plan_of_parts(p->device, "svo_parts_planning_work", &none, p->task->depth, &p->task->options, &p->empty);
    if (status == SVO_OK) {
        status = svo_i_survey_begin(p->empty, &p->survey);
    }
    if (status != SVO_OK) {
        return fail_device(p, status);
    }
    SVO_I_TRY(open_mesh(p));
    status = run_step(p);
    if (status != SVO_OK && svo_i_blocks_is_uneven(p->blocks)) {
        p->result.is_uneven = 1;
        p->result.list_count = 0;
        status = SVO_OK;
    }
    svo_i_survey_get(&p->survey, &p->result.sums);
    return status;
}

static svo_status make_result(const passing *p, svo_i_range_result **out)
{
    const void *list = p->task->step == STEP_COUNT ? (const void *)p->list.cells : (const void *)p->hashes;
    const size_t list_bytes = p->result.list_count * element_bytes(p->task->step);
    svo_i_range_result *result = svo_i_alloc(NULL, sizeof *result + list_bytes);
    if (result == NULL) {
        return no_memory(p);
    }
    *result = p->result;
    memcpy(result->magic, RANGE_RESULT_MAGIC, sizeof result->magic);
    result->version = RANGE_VERSION;
    result->step = p->task->step;
    result->range = p->task->range;
    result->bytes = sizeof *result + list_bytes;
    if (list_bytes > 0) {
        memcpy(result + 1, list, list_bytes);
    }
    *out = result;
    return SVO_OK;
}

svo_status svo_i_range_run(svo_device *device, const svo_i_range_task *task, svo_i_range_alive *alive, void *user,
                           svo_i_range_result **result, svo_message *message)
{
    passing p = {.device = device, .message = message, .task = task, .alive = alive, .user = user};
    svo_status status = run(&p);
    if (status == SVO_OK) {
        status = make_result(&p, result);
    }
    svo_i_blocks_close(&p.blocks);
    svo_plan_destroy(&p.empty);
    svo_i_sections_free(&p.sections);
    svo_i_cells_free(&p.cells);
    svo_i_free(p.list.cells);
    svo_i_free(p.hashes);
    svo_i_free(p.record);
    svo_i_free(p.corners);
    svo_i_free(p.kept);
    return status;
}
