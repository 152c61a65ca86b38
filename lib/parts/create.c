/* SPDX-License-Identifier: MIT */
/*
 * Fills a folder of parts: the header from one plan of the whole mesh, the cut into parts from a histogram of the
 * triangles, and then the triangles of each part, which are written once. Of a mesh in memory; division.c has files.
 */
#define _POSIX_C_SOURCE 200809L
#include <string.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "core/device.h"
#include "core/memory.h"
#include "core/struct_size.h"
#include "parts/folder.h"
#include "parts/job.h"
#include "parts/part_file.h"
#include "parts/planning.h"
#include "parts/sections.h"
#include "pipeline/run.h"
#include "plan/arrays.h"

/* Triangles between two renewals of the lease. */
#define TRIANGLES_RENEWED 65536u

static svo_status copy_materials(svo_parts *parts, const svo_mesh *mesh, svo_message *message)
{
    parts->materials = svo_i_alloc(NULL, mesh->material_count * sizeof *parts->materials + 1);
    parts->textures = svo_i_alloc_zeroed(NULL, mesh->texture_count + 1, sizeof *parts->textures);
    if (parts->materials == NULL || parts->textures == NULL) {
        return svo_i_folder_no_memory(parts, message);
    }
    if (mesh->material_count > 0) {
        memcpy(parts->materials, mesh->materials, mesh->material_count * sizeof *parts->materials);
    }
    parts->material_count = mesh->material_count;
    for (size_t i = 0; i < mesh->texture_count; ++i) {
        const size_t bytes = (size_t)mesh->textures[i].width * mesh->textures[i].height * 4;
        uint8_t *copy = svo_i_alloc(NULL, bytes + 1);
        if (copy == NULL) {
            return svo_i_folder_no_memory(parts, message);
        }
        memcpy(copy, mesh->textures[i].rgba, bytes);
        parts->textures[i] = mesh->textures[i];
        parts->textures[i].rgba = copy;
        parts->texture_count = i + 1;
    }
    return SVO_OK;
}

/* Adds the materials to the hash of the triangles. */
static uint64_t hash_input(const svo_parts *parts, uint64_t hash)
{
    hash = XXH3_64bits_withSeed(parts->materials, parts->material_count * sizeof *parts->materials, hash);
    for (size_t i = 0; i < parts->texture_count; ++i) {
        const svo_texture *texture = &parts->textures[i];
        const uint32_t words[4] = {texture->width, texture->height, (uint32_t)texture->wrap_u,
                                   (uint32_t)texture->wrap_v};
        hash = XXH3_64bits_withSeed(words, sizeof words, hash);
        hash = XXH3_64bits_withSeed(texture->rgba, (size_t)texture->width * texture->height * 4, hash);
    }
    return hash;
}

/* The triangles of a plan of the whole mesh on their way to files. */
typedef struct division {
    svo_parts *parts;
    svo_device *device;
    const svo_plan *plan;
    const svo_mesh *mesh;
    svo_message *message;
    svo_i_cells cells;
    svo_i_cell_list list;
    svo_i_cut cut;
    svo_i_section *sections;
    svo_i_triangle_hash *hashes;
    svo_i_sections *writer;
    unsigned char *record;
} division;

static void find_corners(const svo_plan *plan, uint32_t triangle, int32_t corners[3][3])
{
    for (unsigned corner = 0; corner < 3; ++corner) {
        const uint32_t vertex = plan->indices[(size_t)triangle * 3 + corner];
        memcpy(corners[corner], plan->vertices + (size_t)vertex * 3, sizeof corners[corner]);
    }
}

/* Makes the histogram, and the hash of the input. */
static svo_status count_triangles(division *d, uint32_t level)
{
    const svo_part_header *header = &d->parts->header;
    const size_t record_bytes = svo_i_triangle_bytes(d->parts->fields);
    svo_i_triangle_hash hash = {.count = 0};
    d->cells.level = level;
    for (uint32_t i = 0; i < d->plan->triangle_count; ++i) {
        int32_t corners[3][3];
        svo_i_placing placing;
        svo_i_triangle_put(d->mesh, d->parts->fields, d->plan->triangle_ids[i], 0, d->record);
        svo_i_triangle_hash_add(&hash, svo_i_triangle_hash_of(d->record, record_bytes), 0);
        find_corners(d->plan, i, corners);
        svo_i_placing_make(header, level, (const int32_t(*)[3])corners, &placing);
        if (!svo_i_cells_add(&d->cells, header->snap_bits, &placing)) {
            return svo_i_folder_no_memory(d->parts, d->message);
        }
        if (i % TRIANGLES_RENEWED == 0) {
            SVO_I_TRY(svo_i_planning_renew(d->parts, d->message));
        }
    }
    svo_i_cell_list_take(&d->cells, &d->list);
    svo_i_cell_list_total(&d->list);
    d->parts->header.input_hash = hash_input(d->parts, hash.value);
    return SVO_OK;
}

static svo_status write_triangles(division *d)
{
    const svo_parts *parts = d->parts;
    const size_t record_bytes = svo_i_triangle_bytes(parts->fields);
    SVO_I_TRY(svo_i_sections_begin(&parts->header, d->list.level, parts->fields, parts->place, d->sections,
                                   d->cut.count, d->message, &d->writer));
    for (uint32_t i = 0; i < d->plan->triangle_count; ++i) {
        int32_t corners[3][3];
        svo_i_triangle_put(d->mesh, parts->fields, d->plan->triangle_ids[i], i, d->record);
        find_corners(d->plan, i, corners);
        SVO_I_TRY(svo_i_sections_add(d->writer, (const int32_t(*)[3])corners, d->record,
                                     svo_i_triangle_hash_of(d->record, record_bytes), i));
        if (i % TRIANGLES_RENEWED == 0) {
            SVO_I_TRY(svo_i_planning_renew(d->parts, d->message));
        }
    }
    SVO_I_TRY(svo_i_sections_finish(d->writer, d->hashes));
    return svo_i_cut_write_tails(parts, &d->cut, d->hashes, d->message);
}

/* Cuts the grid, and writes the triangles of all parts. */
static svo_status divide(division *d)
{
    d->parts->fields = svo_i_triangle_fields(d->mesh);
    d->record = svo_i_alloc(NULL, svo_i_triangle_bytes(d->parts->fields));
    if (d->record == NULL) {
        return svo_i_folder_no_memory(d->parts, d->message);
    }
    SVO_I_TRY(count_triangles(d, svo_i_cut_level(d->parts, d->parts->header.depth, d->parts->header.kept_triangles)));
    if (d->parts->max_bytes == 0) {
        SVO_I_TRY(svo_i_cut_choose_limit(d->parts, d->device, &d->list, d->message));
    }
    SVO_I_TRY(svo_i_cut_make(d->parts, d->device, &d->list, &d->cut, d->message));
    d->sections = svo_i_alloc_zeroed(NULL, d->cut.count + 1, sizeof *d->sections);
    d->hashes = svo_i_alloc_zeroed(NULL, d->cut.count + 1, sizeof *d->hashes);
    if (d->sections == NULL || d->hashes == NULL) {
        return svo_i_folder_no_memory(d->parts, d->message);
    }
    for (size_t i = 0; i < d->cut.count; ++i) {
        const svo_i_part_entry *entry = &d->cut.parts[i].entry;
        d->sections[i] = (svo_i_section){.code = entry->code, .level = entry->level, .count = entry->triangles};
    }
    return write_triangles(d);
}

static void free_division(division *d)
{
    svo_i_sections_free(&d->writer);
    svo_i_cells_free(&d->cells);
    svo_i_free(d->list.cells);
    svo_i_free(d->sections);
    svo_i_free(d->hashes);
    svo_i_free(d->record);
    svo_i_cut_free(&d->cut);
}

static svo_status save_mesh(const svo_parts *parts, svo_plan *plan, svo_message *message)
{
    if ((parts->header.need & SVO_NEED_RAYS) == 0) {
        return SVO_OK;
    }
    char *path = svo_i_folder_path(parts, "mesh");
    if (path == NULL) {
        return svo_i_folder_no_memory(parts, message);
    }
    const svo_status status = svo_i_part_save_mesh(plan, &parts->header, path, message);
    svo_i_free(path);
    return status;
}

/* ---- all together ---- */

/* A plan of the whole mesh; sets the header. */
static svo_status plan_whole(svo_parts *parts, svo_device *device, const svo_mesh *mesh, unsigned depth,
                             const svo_plan_options *options, svo_plan **plan, svo_message *message)
{
    svo_status status = svo_i_plan_of_parts(device, "svo_parts_create", mesh, depth, options, plan);
    if (status == SVO_OK) {
        parts->header = (svo_part_header)SVO_PART_HEADER_INIT;
        status = svo_plan_get_part_header(*plan, &parts->header);
    }
    return status == SVO_OK ? SVO_OK : svo_i_fail(message, status, "%s", svo_device_message(device));
}

/* Fills a folder from a mesh in memory. */
static svo_status fill_folder(svo_parts *parts, svo_device *device, const svo_mesh *mesh, unsigned depth,
                              const svo_plan_options *options, svo_message *message)
{
    svo_plan *plan = NULL;
    division d = {.parts = parts, .device = device, .mesh = mesh, .message = message};
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_i_lease_check(parts->folder, message)); /* before work that would be in vain */
    SVO_I_TRY_CLEANUP(plan_whole(parts, device, mesh, depth, options, &plan, message));
    SVO_I_TRY_CLEANUP(svo_i_planning_begin(parts, device, message));
    SVO_I_TRY_CLEANUP(copy_materials(parts, mesh, message));
    status = svo_i_plan_copy_to_host(plan);
    if (status != SVO_OK) {
        status = svo_i_fail(message, status, "%s", svo_device_message(device));
        goto cleanup;
    }
    d.plan = plan;
    SVO_I_TRY_CLEANUP(divide(&d));
    SVO_I_TRY_CLEANUP(save_mesh(parts, plan, message));
    svo_plan_destroy(&plan);
    SVO_I_TRY_CLEANUP(svo_i_parts_divide(parts, &d.cut, device, message));
    status = svo_i_planning_switch(parts, message);
cleanup:
    free_division(&d);
    svo_plan_destroy(&plan);
    return status;
}

svo_status svo_parts_create(svo_device *device, const svo_mesh *mesh, unsigned depth, const svo_plan_options *options,
                            uint64_t max_bytes, const char *folder, svo_message *message)
{
    static const char function[] = "svo_parts_create";
    if (device == NULL || mesh == NULL || folder == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: %s is NULL", function,
                          device == NULL ? "device"
                          : mesh == NULL ? "mesh"
                                         : "folder");
    }
    svo_mesh given;
    SVO_I_TRY(svo_i_struct_read(message, function, "mesh", mesh, &given, SVO_I_STRUCT_SIZES(svo_mesh, triangle_count)));
    svo_parts *parts = svo_i_folder_new(folder, max_bytes);
    const svo_status status = parts != NULL
                                  ? fill_folder(parts, device, &given, depth, options, message)
                                  : svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: out of memory", function);
    svo_parts_close(&parts);
    return status;
}
