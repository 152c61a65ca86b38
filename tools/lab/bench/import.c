/* SPDX-License-Identifier: MIT */
/*
 * Reading mesh files. svocl: svo_import_file, with its child process, the joining of equal vertices and the way back
 * through the pipe. assimp: aiImportFile with triangulation in this process, up to its scene.
 */
#include "bench/subjects.h"

#include <assimp/cimport.h>
#include <assimp/postprocess.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "bench/child.h"
#include "measure/spread.h"
#include "support/output.h"

#define PATH_BYTES 512

static const char table_id[] = "import";

static const char note[] =
    "Wall clock. Both run interleaved. svocl: svo_import_file, from the start of its child process to the finished "
    "mesh. assimp: aiImportFile with aiProcess_Triangulate in the measuring process, up to its scene. A generated "
    "scene is written as OBJ, with 9 digits, and as binary PLY.";

static int begin(suite *all)
{
    result_table *table = suite_add_table(all, table_id, "Import of mesh files, compared with assimp", note);
    result_add_column(table, "scene", "");
    result_add_column(table, "format", "");
    result_add_column(table, "triangles", "");
    result_add_column(table, "file", "B");
    spread_add_columns(table, "svocl", "ms");
    spread_add_columns(table, "assimp", "ms");
    result_add_column(table, "svocl rate", "MB/s");
    result_add_column(table, "assimp rate", "MB/s");
    spread_add_columns(table, "svocl/assimp", "");
    return PROGRAM_DONE;
}

/* Milliseconds of one import, below 0 on failure, which is printed. */
static double import_once(program *state, const char *path, uint64_t *triangle_count)
{
    svo_import *import = NULL;
    svo_message message = {""};
    const double start_ms = input_now_ms();
    if (svo_import_file(path, NULL, NULL, NULL, &import, &message) != SVO_OK) {
        (void)program_fail_library(state, message.text);
        return -1;
    }
    const double ms = input_now_ms() - start_ms;
    *triangle_count = svo_import_mesh(import)->triangle_count;
    svo_import_destroy(&import);
    return ms;
}

static double assimp_once(program *state, const char *path)
{
    const double start_ms = input_now_ms();
    const struct aiScene *read = aiImportFile(path, aiProcess_Triangulate);
    const double ms = input_now_ms() - start_ms;
    if (read == NULL) {
        (void)program_fail(state, PROGRAM_FAILED, "%s: assimp: %s", path, aiGetErrorString());
        return -1;
    }
    aiReleaseImport(read);
    return ms;
}

typedef struct import_times {
    double *own, *other, *ratio; /* of each round after the warm-up */
    uint64_t triangle_count;
} import_times;

/* Rounds of both, after a warm-up round. */
static int measure(suite *all, const char *path, import_times *times)
{
    for (size_t round = 0; round <= all->repeats; ++round) {
        const double own_ms = import_once(all->state, path, &times->triangle_count);
        const double other_ms = own_ms >= 0 ? assimp_once(all->state, path) : -1;
        if (other_ms < 0) {
            return PROGRAM_FAILED;
        }
        if (round > 0) {
            times->own[round - 1] = own_ms;
            times->other[round - 1] = other_ms;
            times->ratio[round - 1] = own_ms / other_ms;
        }
    }
    return PROGRAM_DONE;
}

static double megabytes_per_second(double byte_count, spread ms)
{
    return byte_count / 1e6 / (ms.median * 1e-3);
}

static void add_row(suite *all, const input *source, const char *format, double byte_count, const import_times *times)
{
    result_table *table = result_find(all->results, table_id);
    const spread own = spread_of(times->own, all->repeats), other = spread_of(times->other, all->repeats);
    result_add_text(table, "%s", suite_scene_name(source));
    result_add_text(table, "%s", format);
    result_add_number(table, (double)times->triangle_count);
    result_add_number(table, byte_count);
    spread_add(table, own);
    spread_add(table, other);
    result_add_number(table, megabytes_per_second(byte_count, own));
    result_add_number(table, megabytes_per_second(byte_count, other));
    spread_add(table, spread_of(times->ratio, all->repeats));
}

/* Measures one file and adds its row. */
static int run_file(suite *all, const input *source, const char *path, const char *format)
{
    struct stat entry;
    import_times times = {.own = calloc(3 * all->repeats + 1, sizeof *times.own)};
    if (times.own == NULL || stat(path, &entry) != 0) {
        free(times.own);
        return program_fail(all->state, PROGRAM_FAILED, "%s: cannot be measured", path);
    }
    times.other = times.own + all->repeats;
    times.ratio = times.other + all->repeats;
    const int exit_code = measure(all, path, &times);
    if (exit_code == PROGRAM_DONE) {
        add_row(all, source, format, (double)entry.st_size, &times);
    }
    free(times.own);
    return exit_code;
}

/* Writes the scene in one format, measures, and removes the file. */
static int run_scene(suite *all, const input *source, const child_cache *folder, const char *format)
{
    char path[PATH_BYTES];
    (void)snprintf(path, sizeof path, "%s/scene.%s", folder->path, format);
    const int exit_code = mesh_output_write(all->state, source->mesh, path);
    return exit_code == PROGRAM_DONE ? run_file(all, source, path, format) : exit_code;
}

static int run(suite *all, const input *source, unsigned depth)
{
    (void)depth;
    if (source->import != NULL) {
        const char *dot = strrchr(source->name, '.');
        return run_file(all, source, source->name, dot != NULL ? dot + 1 : "");
    }
    child_cache folder = {""};
    if (!child_cache_create(&folder)) {
        return program_fail(all->state, PROGRAM_FAILED, "no folder for the scene's files");
    }
    int exit_code = run_scene(all, source, &folder, "obj");
    if (exit_code == PROGRAM_DONE) {
        exit_code = run_scene(all, source, &folder, "ply");
    }
    child_cache_remove(&folder);
    return exit_code;
}

const suite_subject bench_import = {
    .words = &subject_table[SUBJECT_IMPORT],
    .full = {.scenes = {"terrain:1000000", "atrium:124000"}, .depths = {8}},
    .quick = {.scenes = {"terrain:20000"}, .depths = {8}},
    .begin = begin,
    .run = run,
};
