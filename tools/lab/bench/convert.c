/* SPDX-License-Identifier: MIT */
/* Time against the number of voxels, for solid spheres: lists, trees, and files in memory. */
#include "bench/subjects.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "measure/spread.h"
#include "svocl/compact.h"
#include "svocl/voxel_files.h"

static const char table_id[] = "convert";

static const char note[] =
    "Wall clock, on solid spheres with a color for each layer. All steps run interleaved. list: svo_voxels_create, "
    "which "
    "sorts; the voxels come row by row. tree: svo_voxels_build. descriptor: svo_compact_create of that tree without "
    "colors; minimized: the same with full nodes merged. Ratio: list, tree and minimized to list, tree and descriptor, "
    "within each round; below 1, merging saves time. leaves: svo_tree_get_voxels. Files are written to and read from "
    "memory. Bytes: of the file, or of the compact tree.";

/* A sphere and what the steps make of it. */
typedef struct sphere {
    suite *all;
    svo_voxel *given; /* owned, row by row */
    uint64_t count;
    svo_voxels *voxels; /* by the first step */
    svo_tree *tree; /* by the second */
    uint8_t *file; /* of the last step that wrote one; owned */
    size_t file_bytes, file_capacity;
    uint64_t bytes; /* set by steps that make or read something whose size is reported */
} sphere;

/* One thing to measure: does its work once. */
typedef struct convert_step {
    const char *name;
    svo_status (*run)(sphere *of, svo_message *message);
} convert_step;

static svo_status make_list(sphere *of, svo_message *message)
{
    const svo_voxels_source source = {.struct_size = sizeof source, .voxels = of->given, .voxel_count = of->count};
    svo_voxels_destroy(&of->voxels);
    return svo_voxels_create(&source, &of->voxels, message);
}

static svo_status make_tree(sphere *of, svo_message *message)
{
    const session *opened = &of->all->opened;
    svo_tree_destroy(&of->tree);
    const svo_status status = svo_voxels_build(opened->device, of->voxels, 0, NULL, opened->queue, &of->tree, NULL);
    if (status != SVO_OK) {
        (void)snprintf(message->text, sizeof message->text, "%s", svo_device_message(opened->device));
    }
    return status;
}

/* Full nodes could not merge where layers of two colors meet. */
static svo_status make_compact(sphere *of, bool minimize, svo_message *message)
{
    const session *opened = &of->all->opened;
    const svo_compact_options asked = {.struct_size = sizeof asked,
                                       .form = SVO_FORM_DESCRIPTOR,
                                       .leave_out = SVO_NEED_COLOR,
                                       .minimize = minimize ? 1 : 0};
    svo_compact_info info = SVO_COMPACT_INFO_INIT;
    svo_compact *compact = NULL;
    svo_status status = svo_compact_create(opened->device, of->tree, &asked, opened->queue, &compact);
    if (status == SVO_OK) {
        status = svo_compact_get_info(compact, &info);
    }
    if (status != SVO_OK) {
        (void)snprintf(message->text, sizeof message->text, "%s", svo_device_message(opened->device));
    }
    of->bytes = info.total_bytes;
    svo_compact_destroy(&compact);
    return status;
}

static svo_status make_descriptor(sphere *of, svo_message *message)
{
    return make_compact(of, false, message);
}

static svo_status make_minimized(sphere *of, svo_message *message)
{
    return make_compact(of, true, message);
}

static svo_status take_leaves(sphere *of, svo_message *message)
{
    svo_voxels *leaves = NULL;
    svo_status status = svo_tree_download(of->tree, of->all->opened.queue);
    if (status == SVO_OK) {
        status = svo_tree_get_voxels(of->tree, &leaves, message);
    }
    svo_voxels_destroy(&leaves);
    return status;
}

static int keep_bytes(void *user, const void *bytes, size_t byte_count)
{
    sphere *of = user;
    if (byte_count > of->file_capacity - of->file_bytes) {
        const size_t capacity = 2 * (of->file_bytes + byte_count);
        uint8_t *larger = realloc(of->file, capacity);
        if (larger == NULL) {
            return 1;
        }
        of->file = larger;
        of->file_capacity = capacity;
    }
    memcpy(of->file + of->file_bytes, bytes, byte_count);
    of->file_bytes += byte_count;
    return 0;
}

static svo_status write_as(sphere *of, svo_voxel_format format, svo_message *message)
{
    of->file_bytes = 0;
    const svo_status status = svo_voxels_save(of->voxels, svo_to_callback(keep_bytes, of), format, NULL, message);
    of->bytes = of->file_bytes;
    return status;
}

static svo_status write_vox(sphere *of, svo_message *message)
{
    return write_as(of, SVO_VOXEL_FORMAT_VOX, message);
}

static svo_status write_binvox(sphere *of, svo_message *message)
{
    return write_as(of, SVO_VOXEL_FORMAT_BINVOX, message);
}

static svo_status read_file(sphere *of, svo_message *message)
{
    svo_voxels *read = NULL;
    of->bytes = of->file_bytes;
    const svo_status status =
        svo_voxels_load(svo_from_memory(of->file, of->file_bytes, "sphere"), NULL, &read, NULL, message);
    svo_voxels_destroy(&read);
    return status;
}

/* In the order in which they run; a file is read after it was written. */
enum { LIST, TREE, DESCRIPTOR, MINIMIZED, LEAVES, WRITE_VOX, READ_VOX, WRITE_BINVOX, READ_BINVOX, STEPS };
static const convert_step steps[STEPS] = {
    [LIST] = {"list", make_list},
    [TREE] = {"tree", make_tree},
    [DESCRIPTOR] = {"descriptor", make_descriptor},
    [MINIMIZED] = {"minimized", make_minimized},
    [LEAVES] = {"leaves", take_leaves},
    [WRITE_VOX] = {"write .vox", write_vox},
    [READ_VOX] = {"read .vox", read_file},
    [WRITE_BINVOX] = {"write .binvox", write_binvox},
    [READ_BINVOX] = {"read .binvox", read_file},
};

static const int32_t full_radii[] = {12, 25, 50, 100, 0};
static const int32_t quick_radii[] = {6, 12, 0};

/* The voxels whose centers are within the sphere, in rows along x. */
static bool fill_sphere(sphere *of, int32_t radius)
{
    const size_t side = 2 * (size_t)radius;
    of->given = malloc(side * side * side * sizeof *of->given);
    for (int32_t z = -radius; z < radius && of->given != NULL; ++z) {
        for (int32_t y = -radius; y < radius; ++y) {
            for (int32_t x = -radius; x < radius; ++x) {
                const int64_t distance =
                    (2 * x + 1) * (2 * x + 1) + (2 * y + 1) * (2 * y + 1) + (2 * z + 1) * (2 * z + 1);
                if (distance <= 4 * (int64_t)radius * radius) {
                    of->given[of->count++] = (svo_voxel){
                        .x = x, .y = y, .z = z, .rgba = {(uint8_t)(z + radius), 128, 64, 255}, .material = 0};
                }
            }
        }
    }
    return of->given != NULL;
}

/* Runs all steps in turn, the first round for warm-up. times: STEPS rows of the repeats. */
static int measure(sphere *of, double *times, uint64_t bytes[STEPS])
{
    const size_t repeats = of->all->repeats;
    for (size_t round = 0; round <= repeats; ++round) {
        for (size_t i = 0; i < STEPS; ++i) {
            svo_message message = {""};
            of->bytes = 0;
            const double start_ms = input_now_ms();
            if (steps[i].run(of, &message) != SVO_OK) {
                return program_fail_library(of->all->state, message.text);
            }
            if (round > 0) {
                times[i * repeats + round - 1] = input_now_ms() - start_ms;
            }
            bytes[i] = of->bytes;
        }
    }
    return PROGRAM_DONE;
}

/* What minimizing costs on the way from voxels to a compact tree. times: as measure() leaves them; ratios: room for the
   repeats. */
static spread compare_minimized(const double *times, size_t repeats, double *ratios)
{
    for (size_t round = 0; round < repeats; ++round) {
        const double before = times[LIST * repeats + round] + times[TREE * repeats + round];
        ratios[round] = (before + times[MINIMIZED * repeats + round]) / (before + times[DESCRIPTOR * repeats + round]);
    }
    return spread_of(ratios, repeats);
}

/* times: one row more than steps, for ratios. */
static void add_rows(const sphere *of, double *times, const uint64_t bytes[STEPS])
{
    result_table *table = result_find(of->all->results, table_id);
    const size_t repeats = of->all->repeats;
    const spread ratio = compare_minimized(times, repeats, times + STEPS * repeats); /* before times are sorted */
    for (size_t i = 0; i < STEPS; ++i) {
        const spread ms = spread_of(times + i * repeats, repeats);
        result_add_text(table, "%s", steps[i].name);
        result_add_number(table, (double)of->count);
        spread_add(table, ms);
        result_add_number(table, (double)of->count / ms.median * 1e-3);
        if (bytes[i] > 0) {
            result_add_number(table, (double)bytes[i]);
        } else {
            result_add_absent(table);
        }
        spread_add(table, i == MINIMIZED ? ratio : spread_none());
    }
}

static int run_sphere(suite *all, int32_t radius)
{
    uint64_t bytes[STEPS] = {0};
    sphere of = {.all = all};
    double *times = calloc((STEPS + 1) * all->repeats, sizeof *times);
    if (times == NULL || !fill_sphere(&of, radius)) {
        free(times);
        return program_fail(all->state, PROGRAM_FAILED, "out of memory for a sphere of radius %d", radius);
    }
    const int exit_code = measure(&of, times, bytes);
    if (exit_code == PROGRAM_DONE) {
        add_rows(&of, times, bytes);
    }
    svo_tree_destroy(&of.tree);
    svo_voxels_destroy(&of.voxels);
    free(of.given);
    free(of.file);
    free(times);
    return exit_code;
}

static int run_all(suite *all)
{
    result_table *table = suite_add_table(all, table_id, "Voxels to lists, trees and files", note);
    const int32_t *radii = all->quick ? quick_radii : full_radii;
    int exit_code = PROGRAM_DONE;
    result_add_column(table, "step", "");
    result_add_column(table, "voxels", "");
    spread_add_columns(table, "time", "ms");
    result_add_column(table, "rate", "M/s");
    result_add_column(table, "bytes", "B");
    spread_add_columns(table, "ratio", "");
    progress_step(all->state->progress, "converting voxels");
    for (size_t i = 0; radii[i] != 0 && exit_code == PROGRAM_DONE; ++i) {
        exit_code = run_sphere(all, radii[i]);
    }
    return exit_code;
}

const suite_subject bench_convert = {
    .words = &subject_table[SUBJECT_CONVERT],
    .run_all = run_all,
    .step_count = 1,
};
