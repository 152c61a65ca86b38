/* SPDX-License-Identifier: MIT */
/*
 * Cuts the grid into parts that fit the limit. What a part takes follows from its number of triangles and the terms of
 * the fragment estimate, by the same measuring build that predicts the buffers of plans: it runs on a plan of one
 * triangle, whose counts are those of the part. Only what the shapes of single triangles add is left out, such as tiles
 * of large ones; a part that takes more is divided when it is built.
 */
#include "parts/cut.h"

#include <string.h>

#include "core/device.h"
#include "pipeline/run.h"
#include "plan/estimate.h"

/* Bytes that a triangle and a column of voxels take at least, roughly: the level is a guess, and what a cell of it
   lacks is divided. */
#define TRIANGLE_BYTES 320u
#define COLUMN_BYTES   400u

/* Without a limit, parts take at most this share of the whole, or so many bytes, which the least part needs. */
#define PARTS_LEAST      16u
#define PART_BYTES_LEAST ((uint64_t)16 << 20)

/* Lists have room for more fragments than are expected. */
#define LIST_SLACK 1.25

typedef struct cutter {
    const svo_parts *parts;
    svo_device *device;
    svo_message *message;
    const svo_i_cell_list *list;
    svo_i_cut *cut;
    svo_plan *plans[SVO_PARTS_DEPTH_MAX + 1]; /* of one triangle, by level; made when they are asked for */
    bool is_usable[SVO_PARTS_DEPTH_MAX + 1]; /* the triangle is in the part */
} cutter;

uint32_t svo_i_cut_first_level(const svo_part_header *header)
{
    return header->depth > SVO_DEPTH_MAX ? header->depth - SVO_DEPTH_MAX : 0;
}

static uint64_t share_of(uint64_t whole_bytes)
{
    const uint64_t share = whole_bytes / PARTS_LEAST;
    return share > PART_BYTES_LEAST ? share : PART_BYTES_LEAST;
}

uint32_t svo_i_cut_level(const svo_parts *parts, unsigned depth, uint64_t triangles)
{
    const uint64_t most = parts->max_bytes != 0 ? parts->max_bytes : PART_BYTES_LEAST;
    uint32_t by_triangles = 1;
    uint32_t by_columns = depth;
    for (uint64_t left = triangles / (most / TRIANGLE_BYTES + 1); left > 0; left >>= 2) {
        ++by_triangles;
    }
    for (uint64_t columns = most / COLUMN_BYTES; columns >= 4 && by_columns > 0; columns >>= 2) {
        --by_columns;
    }
    uint32_t level = by_triangles > by_columns + 1 ? by_triangles : by_columns + 1;
    level = level < CELLS_LEVEL_MAX ? level : CELLS_LEVEL_MAX;
    return level < depth ? level : depth - 1;
}

/* ---- what a part takes ---- */

/* Host bytes of a plan per triangle with corners of its own: snapped vertices, indices, names twice, draw items, the
   estimate, classes, flags, records, and a sorted copy of the items. */
#define PLAN_BYTES (36u + 12u + 8u + 8u + 4u + 4u + 16u + 12u)

/* The least that the buffers of a build take per triangle: its corners, indices, draw item and one fragment. */
#define BUFFER_BYTES (36u + 12u + 8u + 8u)

/* While a part is planned: its triangles and what the plan makes of them. */
uint64_t svo_i_parts_host_bytes(const svo_parts *parts, uint64_t triangles)
{
    return triangles * (svo_i_triangle_bytes(parts->fields) + PLAN_BYTES);
}

uint64_t svo_i_parts_least_bytes(const svo_parts *parts, uint64_t triangles)
{
    return svo_i_parts_host_bytes(parts, triangles) + triangles * BUFFER_BYTES;
}

/* A plan of one triangle in the middle of a part. */
static svo_status make_plan(cutter *c, uint32_t level)
{
    const svo_part_header *header = &c->parts->header;
    const uint32_t fields = c->parts->fields;
    const double width = header->edge / (double)(UINT64_C(1) << level);
    static const double places[9] = {0.3, 0.4, 0.5, 0.6, 0.4, 0.5, 0.4, 0.6, 0.5};
    static const float zeros[9] = {0.0f};
    static const uint8_t white[12] = {0};
    static const uint32_t name = 0;
    /* Trees for rays store positions in the mesh's type; doubles fit between the floats of any mesh. */
    const bool is_wide = (fields & TRIANGLE_DOUBLES) != 0 || (header->need & SVO_NEED_RAYS) == 0;
    double wide[9];
    float narrow[9];
    for (unsigned i = 0; i < 9; ++i) {
        wide[i] = header->origin[i % 3] + places[i] * width;
        narrow[i] = (float)wide[i];
    }
    const svo_mesh mesh = {.struct_size = sizeof mesh,
                           .positions = is_wide ? NULL : narrow,
                           .positions_double = is_wide ? wide : NULL,
                           .vertex_count = 3,
                           .triangle_count = 1,
                           .normals = (fields & TRIANGLE_NORMALS) != 0 ? zeros : NULL,
                           .colors = (fields & TRIANGLE_COLORS) != 0 ? white : NULL,
                           .materials = c->parts->texture_count == 0 ? c->parts->materials : NULL,
                           .material_count = c->parts->texture_count == 0 ? c->parts->material_count : 0};
    svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
    options.part_header = header;
    options.part_level = level;
    options.part_triangles = &name;
    const svo_status status = svo_plan_create(c->device, &mesh, header->depth, &options, &c->plans[level]);
    return status == SVO_OK ? SVO_OK : svo_i_fail(c->message, status, "%s", svo_device_message(c->device));
}

/* Gives a plan the counts of a part, as grid.c would. */
static void set_counts(svo_plan *plan, const svo_i_cell_sums *sums)
{
    plan->triangle_count = (uint32_t)sums->count;
    plan->vertex_count = (uint32_t)(3 * sums->count);
    for (unsigned c = 0; c <= SVO_I_CLASS_COUNT; ++c) {
        plan->class_begin[c] = c > SVO_I_CLASS_NARROW ? plan->triangle_count : 0;
    }
    plan->estimate[0] = (double)sums->count;
    plan->estimate[1] = (double)sums->widths;
    plan->estimate[2] = 0.5 * (double)sums->doubled_areas;
    plan->info.expected_fragments = svo_i_plan_expected(plan, plan->info.depth);
}

/* The buffers of a part of a level. 0: they cannot be told, since the fragment list is cut into chunks by triangles,
   which are not here, or the part is smaller than the distance of two floats. */
static svo_status predict(cutter *c, uint32_t level, const svo_i_cell_sums *sums, uint64_t *bytes)
{
    *bytes = 0;
    if (c->plans[level] == NULL) {
        SVO_I_TRY(make_plan(c, level));
        c->is_usable[level] = c->plans[level]->triangle_count == 1;
    }
    svo_plan *plan = c->plans[level];
    if (!c->is_usable[level]) {
        return SVO_OK;
    }
    set_counts(plan, sums);
    if (plan->info.expected_fragments * LIST_SLACK * svo_i_plan_fragment_bytes(plan) >
        (double)plan->device->max_allocation_bytes) {
        return SVO_OK;
    }
    const svo_status status = svo_i_predict(plan);
    *bytes = plan->peak_bytes;
    return status == SVO_OK ? SVO_OK : svo_i_fail(c->message, status, "%s", svo_device_message(c->device));
}

/* Whether a part fits, and what it is expected to take. */
static svo_status fits(cutter *c, uint32_t level, const svo_i_cell_sums *sums, bool *fit, uint64_t *bytes)
{
    const uint64_t most = c->parts->max_bytes;
    uint64_t buffer_bytes = 0;
    *bytes = svo_i_parts_least_bytes(c->parts, sums->count);
    *fit = false;
    if (*bytes > most || level < svo_i_cut_first_level(&c->parts->header) || level >= c->parts->header.depth) {
        return SVO_OK;
    }
    SVO_I_TRY(predict(c, level, sums, &buffer_bytes));
    if (buffer_bytes > 0) {
        *bytes = buffer_bytes + svo_i_parts_host_bytes(c->parts, sums->count);
        *fit = *bytes <= most;
    }
    return SVO_OK;
}

/* ---- the cut ---- */

static svo_status add_part(cutter *c, const svo_i_cut_part *part)
{
    svo_i_cut *cut = c->cut;
    if (cut->count == cut->capacity) {
        const size_t capacity = cut->capacity * 2 + 64;
        svo_i_cut_part *grown = svo_i_grow(NULL, cut->parts, capacity * sizeof *grown);
        if (grown == NULL) {
            return svo_i_folder_no_memory(c->parts, c->message);
        }
        cut->parts = grown;
        cut->capacity = capacity;
    }
    cut->parts[cut->count++] = *part;
    return SVO_OK;
}

static svo_status cut_at(cutter *c, uint32_t level, uint64_t code)
{
    const svo_i_cell_sums sums = svo_i_cell_list_find(c->list, level, code);
    svo_i_cut_part part = {.entry = {.level = level, .code = code, .triangles = sums.count}};
    if (sums.count == 0) {
        return SVO_OK;
    }
    SVO_I_TRY(fits(c, level, &sums, &part.fits, &part.entry.expected_bytes));
    if (part.fits || level == c->list->level) {
        part.fits = part.fits && c->parts->texture_count == 0; /* which texels a part has, its plan knows */
        return add_part(c, &part);
    }
    for (uint64_t octant = 0; octant < 8; ++octant) {
        SVO_I_TRY(cut_at(c, level + 1, code << 3 | octant));
    }
    return SVO_OK;
}

static void free_plans(cutter *c)
{
    for (size_t level = 0; level < sizeof c->plans / sizeof c->plans[0]; ++level) {
        svo_plan_destroy(&c->plans[level]);
    }
}

svo_status svo_i_cut_refuse_limit(const svo_parts *parts, svo_message *message)
{
    return svo_i_fail(message, SVO_CAPACITY_EXCEEDED,
                      "svo_parts_create: max_bytes %llu is too small for the least part",
                      (unsigned long long)parts->max_bytes);
}

/* Whether a part of eight voxels fits with one triangle. Otherwise no division ends, and each of them writes files. */
static svo_status check_limit(cutter *c)
{
    const svo_i_cell_sums one = {.count = 1};
    uint64_t bytes = 0;
    bool fit = false;
    SVO_I_TRY(fits(c, c->parts->header.depth - 1, &one, &fit, &bytes));
    return bytes <= c->parts->max_bytes ? SVO_OK : svo_i_cut_refuse_limit(c->parts, c->message);
}

svo_status svo_i_cut_make(const svo_parts *parts, svo_device *device, const svo_i_cell_list *list, svo_i_cut *cut,
                          svo_message *message)
{
    cutter c = {.parts = parts, .device = device, .message = message, .list = list, .cut = cut};
    svo_status status = check_limit(&c);
    if (status == SVO_OK) {
        status = cut_at(&c, 0, 0);
    }
    free_plans(&c);
    return status;
}

/* A whole that is too large to be predicted is so many times as large as what can be. */
svo_status svo_i_cut_choose_limit(svo_parts *parts, svo_device *device, const svo_i_cell_list *list,
                                  svo_message *message)
{
    cutter c = {.parts = parts, .device = device, .message = message, .list = list};
    svo_i_cell_sums sums = svo_i_cell_list_find(list, 0, 0);
    uint64_t bytes = 0;
    uint64_t times = 1;
    const uint32_t level = svo_i_cut_first_level(&parts->header);
    svo_status status = predict(&c, level, &sums, &bytes);
    while (status == SVO_OK && bytes == 0 && sums.count > 1) {
        sums = (svo_i_cell_sums){sums.count / 2, sums.widths / 2, sums.doubled_areas / 2};
        times *= 2;
        status = predict(&c, level, &sums, &bytes);
    }
    parts->max_bytes = share_of(bytes * times);
    free_plans(&c);
    return status;
}

svo_status svo_i_cut_write_tails(const svo_parts *parts, const svo_i_cut *cut, const svo_i_triangle_hash *hashes,
                                 svo_message *message)
{
    for (size_t i = 0; i < cut->count; ++i) {
        const svo_i_part_entry *entry = &cut->parts[i].entry;
        const svo_i_triangles_of of = svo_i_folder_triangles(parts, entry->level, entry->code);
        char *path = svo_i_part_path(parts, entry->level, entry->code, "tri");
        const svo_status status = path != NULL ? svo_i_triangles_write_tail(path, &of, &hashes[i], message)
                                               : svo_i_folder_no_memory(parts, message);
        svo_i_free(path);
        SVO_I_TRY(status);
    }
    return SVO_OK;
}

void svo_i_cut_free(svo_i_cut *cut)
{
    svo_i_free(cut->parts);
    *cut = (svo_i_cut){.parts = NULL};
}
