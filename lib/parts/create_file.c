/* SPDX-License-Identifier: MIT */
/*
 * Fills a folder of parts from a mesh file that is read in blocks, twice: the first pass finds the grid, the second
 * what else all parts share, and writes the triangles. The mesh is never in memory as a whole.
 */
#define _POSIX_C_SOURCE 200809L
#include "core/device.h"
#include "core/memory.h"
#include "parts/blocks.h"
#include "parts/create.h"
#include "parts/triangles.h"
#include "plan/survey.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

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
    return svo_i_parts_check_nodes(p->parts, p->message);
}

static svo_status run_passes(passing *p, svo_plan *empty)
{
    svo_status status = svo_i_survey_begin(empty, &p->survey);
    if (status != SVO_OK) {
        return fail_device(p, status);
    }
    SVO_I_TRY(find_grid(p));
    SVO_I_TRY(svo_i_folder_make(p->parts->folder, p->message));
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

static svo_status fill_folder(passing *p, const char *path, unsigned depth, const svo_plan_options *options)
{
    SVO_I_TRY(take_file(p, path, depth, options));
    return svo_i_parts_divide(p->parts, p->device, p->message);
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
                                  ? fill_folder(&p, path, depth, options)
                                  : svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: out of memory", function);
    svo_parts_close(&p.parts);
    return status;
}
