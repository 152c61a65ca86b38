/* SPDX-License-Identifier: MIT */
/*
 * Reads each file with the library's own reader and with assimp, each in a process with a time limit, and compares:
 * triangles, materials, colors and which vertices have normals and texture coordinates are equal; numbers are at most
 * an ulp apart (assimp rounds text less exactly, and cuts it after 15 decimals). Triangles may begin at another corner.
 *
 * usage: compare_readers FILE...; prints a line per file: what came out, a tab, the file, a tab, figures.
 */
#define _XOPEN_SOURCE 700
#include <fcntl.h>
#include <float.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "sanitizer.h"

#include "core/message.h"
#include "io/import_formats.h"

#define SECONDS         60
#define ULPS_MAX        1
#define ASSIMP_DECIMALS 1e-15 /* assimp cuts a number after 15 decimals */
#define WORDS_MAX       1024

/* What a child reports of one file, through a pipe. */
typedef struct outcome {
    int own_read, assimp_read, equal;
    double own_ms, assimp_ms;
    uint64_t triangle_count, number_count, off_count; /* off_count: numbers that differ by an ulp */
    char words[WORDS_MAX]; /* the refusal of the own reader, or the first difference */
} outcome;

static int read_own(const char *path, gather *mesh, int stream, char words[WORDS_MAX])
{
    file_bytes file;
    svo_message message = {""};
    stream_counts counts;
    const char *trouble = svo_i_file_open(path, &file);
    if (trouble != NULL) {
        (void)snprintf(words, WORDS_MAX, "%s", trouble);
        return 0;
    }
    mesh_reader reader = {.path = path,
                          .bytes = file.bytes,
                          .byte_count = file.byte_count,
                          .stream = stream,
                          .mesh = mesh,
                          .counts = &counts,
                          .message = &message};
    const mesh_format format = svo_i_mesh_format(path, file.bytes, file.byte_count);
    const int done = format != MESH_FORMAT_OTHER && svo_i_read_mesh(&reader, format) == SVO_OK;
    svo_i_file_close(&file);
    (void)snprintf(words, WORDS_MAX, "%s", message.text);
    return done;
}

static int read_assimp(const char *path, gather *mesh, int stream)
{
    svo_message message;
    const mesh_reader reader = {.path = path, .stream = stream, .mesh = mesh, .message = &message};
    return svo_i_read_scene(&reader) == SVO_OK;
}

/* Floats in their order, as whole numbers; both zeros are 0. */
static int64_t ordered(float value)
{
    int32_t bits = 0;
    memcpy(&bits, &value, sizeof bits);
    return bits < 0 ? -(int64_t)(bits & INT32_MAX) : bits;
}

/* Whether two lists of numbers are close; counts those that differ. */
static int are_close(const float *a, const float *b, size_t count, uint64_t *off_count)
{
    for (size_t i = 0; i < count; ++i) {
        const int64_t ulps = llabs(ordered(a[i]) - ordered(b[i]));
        const int close = ulps <= ULPS_MAX || fabs((double)a[i] - (double)b[i]) <= ASSIMP_DECIMALS;
        if (isnan(a[i]) != isnan(b[i]) || (!isnan(a[i]) && !close)) {
            return 0;
        }
        *off_count += !isnan(a[i]) && ulps != 0 ? 1 : 0;
    }
    return 1;
}

/* The file's coordinate is 1 minus this one, and it is the file's that may be an ulp off. */
static int are_rows_close(float a, float b, uint64_t *off_count)
{
    *off_count += a != b ? 1 : 0;
    return a == b || fabs((double)a - (double)b) <= FLT_EPSILON * fmax(1, fabs(1 - (double)a));
}

static int vertices_equal(const gather *a, uint32_t i, const gather *b, uint32_t k, uint64_t *off_count)
{
    if (i == GATHER_NO_VERTEX || k == GATHER_NO_VERTEX) {
        return i == k;
    }
    const gather_vertex *v = &a->vertices[i], *w = &b->vertices[k];
    return are_close(v->position, w->position, 3, off_count) && are_close(v->normal, w->normal, 3, off_count) &&
           are_close(v->uv, w->uv, 1, off_count) && are_rows_close(v->uv[1], w->uv[1], off_count) &&
           memcmp(v->color, w->color, 4) == 0;
}

static int triangles_equal(const gather *a, const gather *b, size_t t, uint64_t *off_count)
{
    for (size_t turn = 0; turn < 3; ++turn) {
        uint64_t off = 0;
        size_t corner = 0;
        while (corner < 3 &&
               vertices_equal(a, a->indices[3 * t + corner], b, b->indices[3 * t + (corner + turn) % 3], &off)) {
            ++corner;
        }
        if (corner == 3) {
            *off_count += off;
            return 1;
        }
    }
    return 0;
}

static int materials_equal(const gather *a, const gather *b, size_t t)
{
    static const svo_material white = {.rgba = {255, 255, 255, 255}, .texture_index = SVO_NO_TEXTURE};
    const svo_material *m = a->material_count > 0 ? &a->materials[a->triangle_materials[t]].base : &white;
    const svo_material *n = b->material_count > 0 ? &b->materials[b->triangle_materials[t]].base : &white;
    return memcmp(m->rgba, n->rgba, 4) == 0 && m->texture_index == n->texture_index;
}

/* The corners of a triangle by both readers. */
static void describe(const gather *own, const gather *other, size_t t, int same, char words[WORDS_MAX])
{
    const gather *const meshes[2] = {own, other};
    size_t used = (size_t)snprintf(words, WORDS_MAX, "%s of triangle %zu:", same ? "the material" : "a corner", t);
    for (size_t i = 0; i < 6 && used < WORDS_MAX; ++i) {
        const uint32_t index = meshes[i / 3]->indices[3 * t + i % 3];
        const float *p = index != GATHER_NO_VERTEX ? meshes[i / 3]->vertices[index].position : (const float[]){0, 0, 0};
        used += (size_t)snprintf(words + used, WORDS_MAX - used, "%s (%.9g, %.9g, %.9g)", i == 3 ? " | assimp" : "",
                                 (double)p[0], (double)p[1], (double)p[2]);
    }
}

static void compare(const gather *own, const gather *other, outcome *result)
{
    result->triangle_count = own->triangle_count;
    result->number_count = 9 * own->triangle_count;
    if (own->has_normals != other->has_normals || own->has_uvs != other->has_uvs ||
        own->has_colors != other->has_colors) {
        (void)snprintf(result->words, WORDS_MAX, "normals, texture coordinates, colors: %d %d %d, assimp's %d %d %d",
                       own->has_normals, own->has_uvs, own->has_colors, other->has_normals, other->has_uvs,
                       other->has_colors);
        return;
    }
    if (own->triangle_count != other->triangle_count) {
        (void)snprintf(result->words, WORDS_MAX, "%zu triangles, assimp's %zu", own->triangle_count,
                       other->triangle_count);
        return;
    }
    for (size_t t = 0; t < own->triangle_count; ++t) {
        const int same = triangles_equal(own, other, t, &result->off_count);
        if (!same || !materials_equal(own, other, t)) {
            describe(own, other, t, same, result->words);
            return;
        }
    }
    result->equal = 1;
}

static void run_file(const char *path, int answer)
{
    outcome result = {.own_read = 0};
    gather own = {0}, other = {0};
    const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
    double start_ms = svo_i_now_ms();
    result.own_read = read_own(path, &own, nowhere, result.words);
    result.own_ms = svo_i_now_ms() - start_ms;
    /* assimp may crash: what is known goes first. */
    (void)!write(answer, &result, sizeof result);
    start_ms = svo_i_now_ms();
    result.assimp_read = read_assimp(path, &other, nowhere);
    result.assimp_ms = svo_i_now_ms() - start_ms;
    if (result.own_read && result.assimp_read) {
        compare(&own, &other, &result);
    }
    (void)!write(answer, &result, sizeof result);
    svo_i_gather_free(&own);
    svo_i_gather_free(&other);
}

static const char *verdict(const outcome *result, int code)
{
    if (!result->own_read && !result->assimp_read) {
        return code != 0 ? "refused, assimp fails" : "refused by both";
    }
    if (!result->own_read) {
        return "only assimp";
    }
    if (!result->assimp_read) {
        return code != 0 ? "only own, assimp fails" : "only own";
    }
    return result->equal ? "equal" : "different";
}

static void report(const char *path, int answer, int code)
{
    outcome result = {.own_read = 0};
    while (read(answer, &result, sizeof result) == (ssize_t)sizeof result) {
    }
    printf("%s\t%s\t%" PRIu64 " triangles, %" PRIu64 " of %" PRIu64
           " numbers an ulp off, %.1f ms, assimp %.1f ms. %s\n",
           verdict(&result, code), path, result.triangle_count, result.off_count, result.number_count, result.own_ms,
           result.assimp_ms, result.words);
    (void)fflush(stdout);
}

int main(int argc, char **argv)
{
    for (int i = 1; i < argc; ++i) {
        int ends[2], state = 0;
        if (pipe(ends) != 0) {
            return 1;
        }
        const pid_t child = fork();
        if (child == 0) {
            const struct rlimit space = {.rlim_cur = (rlim_t)8 << 30, .rlim_max = (rlim_t)8 << 30};
            if (!WITH_ADDRESS_SANITIZER) {
                (void)setrlimit(RLIMIT_AS, &space);
            }
            (void)alarm(SECONDS);
            run_file(argv[i], ends[1]);
            _exit(0);
        }
        close(ends[1]);
        (void)waitpid(child, &state, 0);
        report(argv[i], ends[0], state);
        close(ends[0]);
    }
    return 0;
}
