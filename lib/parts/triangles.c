/* SPDX-License-Identifier: MIT */
/* Files of triangles: written from a mesh, divided among parts, loaded for a build; all but the last by blocks. */
#define _POSIX_C_SOURCE 200809L
#include "parts/triangles.h"

#include <assert.h>
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <math.h>
#include <stddef.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "io/file_format.h"
#include "parts/part_file.h"
#include "shared/snap.clh"
#include "svocl/nodes.h"
#include "svocl/plan.h"

#define BLOCK_RECORDS 2048
#define NAME_BYTES    8 /* name and material, 4 bytes each */
#define MAGIC         "\x89SVT\r\n\x1a\n"
#define MAGIC_BYTES   8
#define VERSION       4 /* 2: the identity of a plan had its limit in it; 3: one hash of all bytes */

/* What follows the records. */
typedef struct triangle_tail {
    uint8_t magic[MAGIC_BYTES];
    uint32_t version;
    uint32_t record_bytes;
    svo_i_triangles_of of;
    uint64_t hash; /* of the tail before, seeded with that of the records */
} triangle_tail;

static_assert(sizeof(triangle_tail) == 56 && offsetof(triangle_tail, hash) == 48, "triangles.h: no padding");

uint32_t svo_i_triangle_fields(const svo_mesh *mesh)
{
    return (mesh->positions_double != NULL ? TRIANGLE_DOUBLES : 0u) | (mesh->normals != NULL ? TRIANGLE_NORMALS : 0u) |
           (mesh->colors != NULL ? TRIANGLE_COLORS : 0u) | (mesh->uvs != NULL ? TRIANGLE_UVS : 0u);
}

/* Bytes of a field of a vertex; 0: records do not have it. */
static size_t position_bytes(uint32_t fields)
{
    return (fields & TRIANGLE_DOUBLES) != 0 ? 3 * sizeof(double) : 3 * sizeof(float);
}

static size_t normal_bytes(uint32_t fields)
{
    return (fields & TRIANGLE_NORMALS) != 0 ? 3 * sizeof(float) : 0;
}

static size_t color_bytes(uint32_t fields)
{
    return (fields & TRIANGLE_COLORS) != 0 ? 4 : 0;
}

static size_t uv_bytes(uint32_t fields)
{
    return (fields & TRIANGLE_UVS) != 0 ? 2 * sizeof(float) : 0;
}

size_t svo_i_triangle_bytes(uint32_t fields)
{
    return NAME_BYTES + 3 * (position_bytes(fields) + normal_bytes(fields) + color_bytes(fields) + uv_bytes(fields));
}

/* ---- writing ---- */

static svo_status fail_errno(const svo_i_triangle_file *file, int error)
{
    return svo_i_fail(file->message, svo_i_file_status(error), "%s: cannot be written: %s", file->path,
                      strerror(error));
}

uint64_t svo_i_triangle_hash_of(const unsigned char *record, size_t record_bytes)
{
    return XXH3_64bits(record + sizeof(uint32_t), record_bytes - sizeof(uint32_t));
}

void svo_i_triangle_hash_append(svo_i_triangle_hash *to, const svo_i_triangle_hash *run)
{
    /* The hash so far moves on by as many records as the run has: a power of the factor, by squares. */
    uint64_t square = TRIANGLE_HASH_FACTOR;
    uint64_t power = 1;
    for (uint64_t left = run->count; left > 0; left >>= 1) {
        power *= (left & 1) != 0 ? square : 1;
        square *= square;
    }
    to->count += run->count;
    to->value = to->value * power + run->value;
}

static triangle_tail make_tail(const svo_i_triangles_of *of, const svo_i_triangle_hash *records)
{
    triangle_tail tail = {.version = VERSION, .record_bytes = (uint32_t)svo_i_triangle_bytes(of->fields), .of = *of};
    memcpy(tail.magic, MAGIC, MAGIC_BYTES);
    tail.hash = XXH3_64bits_withSeed(&tail, offsetof(triangle_tail, hash), records->value);
    return tail;
}

svo_status svo_i_triangles_write_tail(const char *path, const svo_i_triangles_of *of, const svo_i_triangle_hash *hash,
                                      svo_message *message)
{
    const triangle_tail tail = make_tail(of, hash);
    const svo_i_output output = {.descriptor = open(path, O_WRONLY | O_CLOEXEC)};
    int error = output.descriptor < 0 ? errno : 0;
    if (error == 0) {
        error = svo_i_output_write_at(&output, hash->count * tail.record_bytes, &tail, sizeof tail);
    }
    if (output.descriptor >= 0 && close(output.descriptor) != 0 && error == 0) {
        error = errno;
    }
    return error == 0
               ? SVO_OK
               : svo_i_fail(message, svo_i_file_status(error), "%s: cannot be written: %s", path, strerror(error));
}

/* Begins a file; path must outlive it. To be ended also after a failure. */
static svo_status begin_file(svo_i_triangle_file *file, const char *path, uint32_t fields, svo_message *message)
{
    file->path = path;
    file->message = message;
    file->fields = fields;
    file->record_bytes = svo_i_triangle_bytes(fields);
    file->output.descriptor = -1;
    file->block_bytes = BLOCK_RECORDS * file->record_bytes;
    file->block = svo_i_alloc(NULL, file->block_bytes);
    return file->block != NULL ? SVO_OK
                               : svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for triangles", path);
}

/* The first bytes open the file, since many children of a part have no triangles and so no file. */
static svo_status flush(svo_i_triangle_file *file)
{
    int error = file->output.descriptor < 0 ? svo_i_output_open(file->path, NULL, &file->output) : 0;
    if (error == 0) {
        error = svo_i_output_write(&file->output, file->block, file->filled);
    }
    file->filled = 0;
    return error == 0 ? SVO_OK : fail_errno(file, error);
}

static svo_status append_record(svo_i_triangle_file *file, const unsigned char *record)
{
    uint32_t name = 0;
    if (file->filled + file->record_bytes > file->block_bytes) {
        SVO_I_TRY(flush(file));
    }
    memcpy(file->block + file->filled, record, file->record_bytes);
    memcpy(&name, record, sizeof name);
    file->filled += file->record_bytes;
    svo_i_triangle_hash_add(&file->hash, svo_i_triangle_hash_of(record, file->record_bytes), name);
    return SVO_OK;
}

static svo_status finish_file(svo_i_triangle_file *file, const svo_i_triangles_of *of)
{
    const triangle_tail tail = make_tail(of, &file->hash);
    SVO_I_TRY(flush(file));
    int error = svo_i_output_write(&file->output, &tail, sizeof tail);
    if (error == 0) {
        error = svo_i_output_commit_unflushed(&file->output);
    }
    return error == 0 ? SVO_OK : fail_errno(file, error);
}

static void end_file(svo_i_triangle_file *file)
{
    if (file->block != NULL) {
        svo_i_output_abandon(&file->output);
        svo_i_free(file->block);
        file->block = NULL;
    }
}

/* Appends a field of three corners. */
static unsigned char *put_field(unsigned char *to, const void *field, size_t vertex_bytes, const uint32_t corners[3])
{
    for (unsigned corner = 0; corner < 3 && vertex_bytes > 0; ++corner) {
        memcpy(to, (const unsigned char *)field + corners[corner] * vertex_bytes, vertex_bytes);
        to += vertex_bytes;
    }
    return to;
}

void svo_i_triangle_put(const svo_mesh *mesh, uint32_t fields, uint32_t triangle, uint32_t name, unsigned char *record)
{
    unsigned char *to = record;
    uint32_t corners[3];
    for (uint32_t corner = 0; corner < 3; ++corner) {
        const size_t index = (size_t)triangle * 3 + corner;
        corners[corner] = mesh->indices != NULL ? mesh->indices[index] : (uint32_t)index;
    }
    const uint32_t words[2] = {name, mesh->triangle_materials != NULL ? mesh->triangle_materials[triangle] : 0};
    memcpy(to, words, NAME_BYTES);
    to += NAME_BYTES;
    const void *positions = mesh->positions != NULL ? (const void *)mesh->positions : mesh->positions_double;
    to = put_field(to, positions, position_bytes(fields), corners);
    to = put_field(to, mesh->normals, normal_bytes(fields), corners);
    to = put_field(to, mesh->colors, color_bytes(fields), corners);
    (void)put_field(to, mesh->uvs, uv_bytes(fields), corners);
}

/* ---- reading ---- */

typedef struct triangle_source {
    const char *path;
    svo_message *message;
    int file;
    size_t record_bytes;
    uint64_t count;
    triangle_tail tail;
    svo_i_triangle_hash hash; /* of the records that were read */
    unsigned char *block;
    uint64_t read; /* records */
} triangle_source;

static svo_status damaged(const triangle_source *source)
{
    return svo_i_fail(source->message, SVO_FILE_DAMAGED,
                      "%s: not the triangles that were written; planning the parts again writes them", source->path);
}

static svo_status read_bytes(const triangle_source *source, uint64_t offset, void *out, size_t byte_count)
{
    size_t got = 0;
    const int error = svo_i_read_at(source->file, offset, out, byte_count, &got);
    if (error != 0) {
        return svo_i_fail(source->message, svo_i_file_status(error), "%s: cannot be read: %s", source->path,
                          strerror(error));
    }
    return got == byte_count ? SVO_OK : damaged(source);
}

/* Whether the file is one of the plan and the part that are asked for. */
static svo_status check_tail(const triangle_source *source, const svo_i_triangles_of *of)
{
    const svo_i_triangles_of *found = &source->tail.of;
    if (memcmp(source->tail.magic, MAGIC, MAGIC_BYTES) != 0 || source->tail.version != VERSION) {
        return svo_i_fail(source->message, SVO_FILE_DAMAGED,
                          "%s: no file of triangles of version %d; planning the parts again writes one", source->path,
                          VERSION);
    }
    if (memcmp(found->plan, of->plan, sizeof of->plan) != 0) {
        return svo_i_part_is_foreign(source->path, found->plan, of->plan, "; planning the parts again writes it",
                                     source->message);
    }
    if (found->fields != of->fields) {
        return damaged(source);
    }
    if (found->level != of->level || found->code != of->code) {
        return svo_i_fail(source->message, SVO_FILE_DAMAGED,
                          "%s: triangles of the part %" PRIu32 "-%" PRIx64 ", not of %" PRIu32 "-%" PRIx64
                          "; planning the parts again writes them",
                          source->path, found->level, found->code, of->level, of->code);
    }
    return SVO_OK;
}

/* Opens a file and finds the number of its records. To be closed also after a failure. */
static svo_status open_source(triangle_source *source, const char *path, const svo_i_triangles_of *of,
                              svo_message *message)
{
    struct stat found;
    *source = (triangle_source){.path = path, .message = message, .record_bytes = svo_i_triangle_bytes(of->fields)};
    source->file = open(path, O_RDONLY | O_CLOEXEC);
    if (source->file < 0 || fstat(source->file, &found) != 0) {
        const int error = errno;
        return svo_i_fail(message, svo_i_file_status(error), "%s: cannot be opened: %s%s", path, strerror(error),
                          error == ENOENT ? "; planning the parts again writes it" : "");
    }
    const uint64_t bytes = (uint64_t)found.st_size;
    if (bytes < sizeof source->tail) {
        return damaged(source);
    }
    const uint64_t records_bytes = bytes - sizeof source->tail;
    SVO_I_TRY(read_bytes(source, records_bytes, &source->tail, sizeof source->tail));
    SVO_I_TRY(check_tail(source, of));
    if (records_bytes % source->record_bytes != 0 || records_bytes / source->record_bytes >= UINT32_MAX) {
        return damaged(source);
    }
    source->count = records_bytes / source->record_bytes;
    source->block = svo_i_alloc(NULL, BLOCK_RECORDS * source->record_bytes);
    return source->block != NULL ? SVO_OK
                                 : svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for triangles", path);
}

static void close_source(triangle_source *source)
{
    if (source->file >= 0) {
        (void)close(source->file);
    }
    svo_i_free(source->block);
}

/* Reads the next block; *count is 0 at the end, where the checksum is compared. */
static svo_status next_block(triangle_source *source, size_t *count)
{
    const uint64_t left = source->count - source->read;
    *count = left < BLOCK_RECORDS ? (size_t)left : BLOCK_RECORDS;
    if (*count == 0) {
        const uint64_t hash = XXH3_64bits_withSeed(&source->tail, offsetof(triangle_tail, hash), source->hash.value);
        return source->tail.hash == hash ? SVO_OK : damaged(source);
    }
    SVO_I_TRY(read_bytes(source, source->read * source->record_bytes, source->block, *count * source->record_bytes));
    for (size_t i = 0; i < *count; ++i) {
        const unsigned char *record = source->block + i * source->record_bytes;
        uint32_t name = 0;
        memcpy(&name, record, sizeof name);
        svo_i_triangle_hash_add(&source->hash, svo_i_triangle_hash_of(record, source->record_bytes), name);
    }
    source->read += *count;
    return SVO_OK;
}

/* ---- loading ---- */

void svo_i_soup_free(svo_i_soup *soup)
{
    svo_i_free(soup->names);
    svo_i_free(soup->positions);
    svo_i_free(soup->normals);
    svo_i_free(soup->colors);
    svo_i_free(soup->uvs);
    svo_i_free(soup->materials);
    *soup = (svo_i_soup){.names = NULL};
}

static bool alloc_soup(svo_i_soup *soup, uint32_t fields, size_t count)
{
    const size_t vertices = 3 * count + 1;
    soup->names = svo_i_alloc(NULL, (count + 1) * sizeof *soup->names);
    soup->materials = svo_i_alloc(NULL, (count + 1) * sizeof *soup->materials);
    soup->positions = svo_i_alloc(NULL, vertices * position_bytes(fields));
    bool whole = soup->names != NULL && soup->materials != NULL && soup->positions != NULL;
    if ((fields & TRIANGLE_NORMALS) != 0) {
        soup->normals = svo_i_alloc(NULL, vertices * normal_bytes(fields));
        whole = whole && soup->normals != NULL;
    }
    if ((fields & TRIANGLE_COLORS) != 0) {
        soup->colors = svo_i_alloc(NULL, vertices * color_bytes(fields));
        whole = whole && soup->colors != NULL;
    }
    if ((fields & TRIANGLE_UVS) != 0) {
        soup->uvs = svo_i_alloc(NULL, vertices * uv_bytes(fields));
        whole = whole && soup->uvs != NULL;
    }
    return whole;
}

/* Takes a field of three corners. */
static const unsigned char *take_field(const unsigned char *from, void *field, size_t vertex_bytes, size_t triangle)
{
    if (vertex_bytes > 0) {
        memcpy((unsigned char *)field + 3 * triangle * vertex_bytes, from, 3 * vertex_bytes);
    }
    return from + 3 * vertex_bytes;
}

static void take_triangle(svo_i_soup *soup, uint32_t fields, const unsigned char *from, size_t triangle)
{
    uint32_t words[2];
    memcpy(words, from, NAME_BYTES);
    from += NAME_BYTES;
    soup->names[triangle] = words[0];
    soup->materials[triangle] = (uint16_t)words[1];
    from = take_field(from, soup->positions, position_bytes(fields), triangle);
    from = take_field(from, soup->normals, normal_bytes(fields), triangle);
    from = take_field(from, soup->colors, color_bytes(fields), triangle);
    (void)take_field(from, soup->uvs, uv_bytes(fields), triangle);
}

static void make_mesh(svo_i_soup *soup, uint32_t fields, size_t count)
{
    const bool is_double = (fields & TRIANGLE_DOUBLES) != 0;
    soup->mesh = (svo_mesh){.struct_size = sizeof soup->mesh,
                            .positions = is_double ? NULL : soup->positions,
                            .positions_double = is_double ? soup->positions : NULL,
                            .vertex_count = 3 * count,
                            .triangle_count = count,
                            .normals = soup->normals,
                            .colors = soup->colors,
                            .uvs = soup->uvs,
                            .triangle_materials = soup->materials};
}

svo_status svo_i_triangles_load(const char *path, const svo_i_triangles_of *of, svo_i_soup *soup, svo_message *message)
{
    const uint32_t fields = of->fields;
    triangle_source source;
    svo_status status = SVO_OK;
    *soup = (svo_i_soup){.names = NULL};
    SVO_I_TRY_CLEANUP(open_source(&source, path, of, message));
    if (!alloc_soup(soup, fields, (size_t)source.count)) {
        status = svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %llu triangles", path,
                            (unsigned long long)source.count);
        goto cleanup;
    }
    size_t count = 0;
    size_t first = 0;
    do {
        SVO_I_TRY_CLEANUP(next_block(&source, &count));
        for (size_t i = 0; i < count; ++i) {
            take_triangle(soup, fields, source.block + i * source.record_bytes, first + i);
        }
        first += count;
    } while (count > 0);
    make_mesh(soup, fields, first);
cleanup:
    close_source(&source);
    if (status != SVO_OK) {
        svo_i_soup_free(soup);
    }
    return status;
}

/* ---- dividing ---- */

typedef struct divider {
    const svo_part_header *header;
    svo_snap snap;
    uint32_t fields;
    int32_t middle[3]; /* of the parent, in units of the whole grid */
    svo_i_triangle_file files[8];
} divider;

/* A corner's coordinate in units of the whole grid, as plan/grid.c snaps it. */
static int32_t snapped(const divider *d, const unsigned char *record, unsigned corner, unsigned axis)
{
    const unsigned char *at = record + NAME_BYTES + corner * position_bytes(d->fields);
    double wide[3];
    float narrow[3];
    if ((d->fields & TRIANGLE_DOUBLES) != 0) {
        memcpy(wide, at, sizeof wide);
    } else {
        memcpy(narrow, at, sizeof narrow);
        wide[axis] = (double)narrow[axis];
    }
    return svo_snap_coordinate(&d->snap, wide[axis], d->header->origin[axis]);
}

/* The halves of the parent along each axis that a triangle's bounds meet: bit 0 the lower, bit 1 the upper one. Closed
   voxels also contain what lies on their upper faces. */
static void find_halves(const divider *d, const unsigned char *record, unsigned halves[3])
{
    for (unsigned axis = 0; axis < 3; ++axis) {
        int32_t low = INT32_MAX;
        int32_t high = INT32_MIN;
        for (unsigned corner = 0; corner < 3; ++corner) {
            const int32_t q = snapped(d, record, corner, axis);
            low = q < low ? q : low;
            high = q > high ? q : high;
        }
        const bool lower =
            low < d->middle[axis] || (d->header->coverage == SVO_COVERAGE_CLOSED && low <= d->middle[axis]);
        halves[axis] = (lower ? 1u : 0u) | (high >= d->middle[axis] ? 2u : 0u);
    }
}

static svo_status divide_record(divider *d, const unsigned char *record)
{
    unsigned halves[3];
    find_halves(d, record, halves);
    for (unsigned octant = 0; octant < 8; ++octant) {
        bool meets = true;
        for (unsigned axis = 0; axis < 3; ++axis) {
            meets = meets && (halves[axis] >> (octant >> axis & 1u) & 1u) != 0;
        }
        if (meets) {
            SVO_I_TRY(append_record(&d->files[octant], record));
        }
    }
    return SVO_OK;
}

static void find_middle(divider *d, uint32_t level, uint64_t code)
{
    uint32_t cell[3];
    const uint32_t half = 1u << (d->header->snap_bits - level - 1);
    svo_code_to_cell(code, cell);
    for (unsigned axis = 0; axis < 3; ++axis) {
        d->middle[axis] = (int32_t)((2 * cell[axis] + 1) * half);
    }
}

svo_status svo_i_triangles_split(const svo_part_header *header, const svo_i_triangles_of *of, const char *path,
                                 char *const paths[8], uint64_t counts[8], svo_message *message)
{
    triangle_source source = {.file = -1};
    svo_status status = SVO_OK;
    divider *d = svo_i_alloc_zeroed(NULL, 1, sizeof *d);
    if (d == NULL) {
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory to divide triangles", path);
    }
    d->header = header;
    d->snap = svo_make_snap(header->scale, header->edge, (int32_t)header->snap_bits);
    d->fields = of->fields;
    find_middle(d, of->level, of->code);
    SVO_I_TRY_CLEANUP(open_source(&source, path, of, message));
    for (unsigned octant = 0; octant < 8; ++octant) {
        SVO_I_TRY_CLEANUP(begin_file(&d->files[octant], paths[octant], of->fields, message));
    }
    size_t count = 0;
    do {
        SVO_I_TRY_CLEANUP(next_block(&source, &count));
        for (size_t i = 0; i < count; ++i) {
            SVO_I_TRY_CLEANUP(divide_record(d, source.block + i * source.record_bytes));
        }
    } while (count > 0);
    for (unsigned octant = 0; octant < 8; ++octant) {
        counts[octant] = d->files[octant].hash.count;
        if (counts[octant] > 0) {
            const svo_i_triangles_of child = {.plan = {of->plan[0], of->plan[1]},
                                              .code = of->code << 3 | octant,
                                              .level = of->level + 1,
                                              .fields = of->fields};
            SVO_I_TRY_CLEANUP(finish_file(&d->files[octant], &child));
        }
    }
cleanup:
    for (unsigned octant = 0; octant < 8; ++octant) {
        end_file(&d->files[octant]);
    }
    close_source(&source);
    svo_i_free(d);
    return status;
}
