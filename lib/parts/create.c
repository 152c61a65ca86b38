/* SPDX-License-Identifier: MIT */
/*
 * Fills a folder of parts: the header from one plan of the whole mesh, the triangles of each part, and the list of
 * parts, which are split until they fit.
 *
 * A mesh file is read in blocks, twice: the first pass finds the grid, the second what else all parts share, and writes
 * the triangles. The mesh is never in memory as a whole.
 */
#define _POSIX_C_SOURCE 200809L
#include <string.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "core/device.h"
#include "core/memory.h"
#include "core/struct_size.h"
#include "parts/blocks.h"
#include "parts/folder.h"
#include "parts/job.h"
#include "parts/part_file.h"
#include "parts/planning.h"
#include "parts/triangles.h"
#include "plan/arrays.h"
#include "plan/part.h"

#define NODES_MAX 4294967294.0
/* Without a limit, parts take at most this share of the whole, or so many bytes, which the least part needs. */
#define PARTS_LEAST      16u
#define PART_BYTES_LEAST ((uint64_t)16 << 20)

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

/* Writes the triangles of the whole tree as those of the part 0-0, and what rays meet. */
static svo_status save_input(svo_parts *parts, svo_plan *plan, const svo_mesh *mesh, svo_message *message)
{
    uint64_t hash = 0;
    XXH3_state_t state;
    svo_i_triangle_file file = {.block = NULL};
    svo_status status = svo_i_plan_copy_to_host(plan);
    if (status != SVO_OK) {
        return svo_i_fail(message, status, "%s", svo_device_message(plan->device));
    }
    char *path = svo_i_part_path(parts, 0, 0, "tri");
    if (path == NULL) {
        return svo_i_folder_no_memory(parts, message);
    }
    parts->fields = svo_i_triangle_fields(mesh);
    SVO_I_TRY_CLEANUP(svo_i_triangles_begin(&file, &state, path, parts->fields, message));
    SVO_I_TRY_CLEANUP(svo_i_triangles_append(&file, mesh, plan->triangle_ids, plan->triangle_count));
    SVO_I_TRY_CLEANUP(svo_i_triangles_hash(&file, &hash));
    parts->header.input_hash = hash_input(parts, hash);
    const svo_i_triangles_of of = svo_i_folder_triangles(parts, 0, 0);
    status = svo_i_triangles_finish(&file, &of);
cleanup:
    svo_i_triangles_end(&file);
    svo_i_free(path);
    return status;
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

static svo_status check_nodes(const svo_parts *parts, svo_message *message)
{
    const svo_part_header *header = &parts->header;
    return header->expected_nodes <= NODES_MAX
               ? SVO_OK
               : svo_i_fail(message, SVO_CAPACITY_EXCEEDED,
                            "svo_parts_create: about %.0f nodes are expected at depth %u, above 2^32 - 2",
                            header->expected_nodes, header->depth);
}

/* A plan of the whole mesh; sets the header and the limit. */
static svo_status plan_whole(svo_parts *parts, svo_device *device, const svo_mesh *mesh, unsigned depth,
                             const svo_plan_options *options, svo_plan **plan, svo_message *message)
{
    const svo_status status = svo_plan_create(device, mesh, depth, options, plan);
    if (status != SVO_OK) {
        return svo_i_fail(message, status, "%s", svo_device_message(device));
    }
    parts->header = (svo_part_header)SVO_PART_HEADER_INIT;
    if (svo_plan_get_part_header(*plan, &parts->header) != SVO_OK) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "svo_parts_create: options.part_header is not NULL");
    }
    SVO_I_TRY(check_nodes(parts, message));
    if (parts->max_bytes == 0) {
        svo_plan_info info = SVO_PLAN_INFO_INIT;
        (void)svo_plan_get_info(*plan, &info);
        const uint64_t share = info.peak_bytes / PARTS_LEAST;
        parts->max_bytes = share > PART_BYTES_LEAST ? share : PART_BYTES_LEAST;
    }
    return SVO_OK;
}

/* Fills a folder from a mesh in memory. */
static svo_status fill_folder(svo_parts *parts, svo_device *device, const svo_mesh *mesh, unsigned depth,
                              const svo_plan_options *options, svo_message *message)
{
    svo_plan *plan = NULL;
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_i_lease_check(parts->folder, message)); /* before work that would be in vain */
    SVO_I_TRY_CLEANUP(plan_whole(parts, device, mesh, depth, options, &plan, message));
    SVO_I_TRY_CLEANUP(svo_i_planning_begin(parts, device, message));
    SVO_I_TRY_CLEANUP(copy_materials(parts, mesh, message));
    SVO_I_TRY_CLEANUP(save_input(parts, plan, mesh, message));
    SVO_I_TRY_CLEANUP(save_mesh(parts, plan, message));
    svo_plan_destroy(&plan);
    SVO_I_TRY_CLEANUP(svo_i_parts_divide(parts, device, message));
    status = svo_i_planning_switch(parts, message);
cleanup:
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

/* ---- from a file ---- */

/* A file on its way to a folder. */
typedef struct passing {
    svo_parts *parts;
    svo_device *device;
    svo_message *message;
    svo_i_blocks *blocks;
    svo_i_survey survey;
    svo_i_triangle_file file;
    XXH3_state_t hash;
    uint32_t *kept; /* BLOCK_TRIANGLES */
} passing;

static svo_status fail_device(const passing *p, svo_status status)
{
    return svo_i_fail(p->message, status, "%s", svo_device_message(p->device));
}

/* The first pass. */
static svo_status find_grid(passing *p)
{
    uint64_t triangles = 0;
    svo_mesh block;
    do {
        SVO_I_TRY(svo_i_blocks_next(p->blocks, &block));
        svo_i_survey_bounds(&p->survey, &block);
        triangles += block.triangle_count;
    } while (block.triangle_count > 0);
    if (triangles == 0) {
        return svo_i_fail(p->message, SVO_IMPORT_FAILED, "svo_parts_create_from_file: the file has no triangles");
    }
    const svo_status status = svo_i_survey_fit(&p->survey);
    return status == SVO_OK ? SVO_OK : fail_device(p, status);
}

/* The second pass: writes the triangles that the tree keeps. */
static svo_status write_triangles(passing *p, const char *path)
{
    svo_mesh block;
    uint64_t hash = 0;
    bool begun = false;
    svo_i_blocks_rewind(p->blocks);
    do {
        uint32_t kept_count = 0;
        SVO_I_TRY(svo_i_blocks_next(p->blocks, &block));
        if (!begun) {
            p->parts->fields = svo_i_triangle_fields(&block);
            SVO_I_TRY(svo_i_triangles_begin(&p->file, &p->hash, path, p->parts->fields, p->message));
            begun = true;
        }
        const svo_status status = svo_i_survey_add(&p->survey, &block, p->kept, &kept_count);
        if (status != SVO_OK) {
            return fail_device(p, status);
        }
        SVO_I_TRY(svo_i_triangles_append(&p->file, &block, p->kept, kept_count));
        SVO_I_TRY(svo_i_planning_renew(p->parts, p->message));
    } while (block.triangle_count > 0);
    SVO_I_TRY(svo_i_triangles_hash(&p->file, &hash));
    p->parts->header = (svo_part_header)SVO_PART_HEADER_INIT;
    const svo_status status = svo_i_survey_header(&p->survey, &p->parts->header);
    if (status != SVO_OK) {
        return fail_device(p, status);
    }
    p->parts->header.input_hash = hash;
    const svo_i_triangles_of of = svo_i_folder_triangles(p->parts, 0, 0);
    SVO_I_TRY(svo_i_triangles_finish(&p->file, &of));
    return check_nodes(p->parts, p->message);
}

static svo_status run_passes(passing *p, svo_plan *empty)
{
    svo_status status = svo_i_survey_begin(empty, &p->survey);
    if (status != SVO_OK) {
        return fail_device(p, status);
    }
    SVO_I_TRY(find_grid(p));
    SVO_I_TRY(svo_i_planning_begin(p->parts, p->device, p->message));
    char *path = svo_i_part_path(p->parts, 0, 0, "tri");
    p->kept = svo_i_alloc(NULL, BLOCK_TRIANGLES * sizeof *p->kept);
    status = path != NULL && p->kept != NULL ? write_triangles(p, path) : svo_i_folder_no_memory(p->parts, p->message);
    svo_i_triangles_end(&p->file);
    svo_i_free(p->kept);
    svo_i_free(path);
    return status;
}

/* Reads the file. */
static svo_status take_file(passing *p, const char *path, unsigned depth, const svo_plan_options *options)
{
    const svo_mesh none = {.struct_size = sizeof none};
    svo_plan *empty = NULL;
    svo_status status = SVO_OK;
    SVO_I_TRY_CLEANUP(svo_i_blocks_open(path, &p->blocks, p->message));
    status = svo_plan_create(p->device, &none, depth, options, &empty);
    if (status != SVO_OK) {
        status = fail_device(p, status);
        goto cleanup;
    }
    status = run_passes(p, empty);
cleanup:
    svo_plan_destroy(&empty);
    svo_i_blocks_close(&p->blocks);
    return status;
}

static svo_status fill_from_file(passing *p, const char *path, unsigned depth, const svo_plan_options *options)
{
    SVO_I_TRY(svo_i_lease_check(p->parts->folder, p->message)); /* before work that would be in vain */
    SVO_I_TRY(take_file(p, path, depth, options));
    SVO_I_TRY(svo_i_parts_divide(p->parts, p->device, p->message));
    return svo_i_planning_switch(p->parts, p->message);
}

svo_status svo_parts_create_from_file(svo_device *device, const char *path, unsigned depth,
                                      const svo_plan_options *options, uint64_t max_bytes, const char *folder,
                                      svo_message *message)
{
    static const char function[] = "svo_parts_create_from_file";
    if (device == NULL || path == NULL || folder == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: %s is NULL", function,
                          device == NULL ? "device"
                          : path == NULL ? "path"
                                         : "folder");
    }
    if (max_bytes == 0) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: max_bytes is 0", function);
    }
    passing p = {.parts = svo_i_folder_new(folder, max_bytes), .device = device, .message = message};
    const svo_status status = p.parts != NULL
                                  ? fill_from_file(&p, path, depth, options)
                                  : svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: out of memory", function);
    svo_parts_close(&p.parts);
    return status;
}
