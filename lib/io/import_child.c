/* SPDX-License-Identifier: MIT */
/*
 * The import child: sets its own resource limits, finds the reader for the file and writes the mesh to its parent. OBJ,
 * PLY, STL, OFF and glTF have readers of their own, assimp reads the others. On some broken files assimp 5.2.5 crashes,
 * hangs or allocates without end; here that ends this process alone.
 */
#define _POSIX_C_SOURCE 200809L
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/resource.h>
#include <unistd.h>

#include "core/memory.h"
#include "core/message.h"
#include "io/import.h"
#include "io/import_formats.h"
#include "io/import_stream.h"

/* The address sanitizer reserves terabytes of address space, so that space cannot be limited beside it. */
#if defined(__SANITIZE_ADDRESS__)
#define LIMIT_ADDRESS_SPACE 0
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define LIMIT_ADDRESS_SPACE 0
#endif
#endif
#ifndef LIMIT_ADDRESS_SPACE
#define LIMIT_ADDRESS_SPACE 1
#endif

/* ---- formats ---- */

mesh_format svo_i_mesh_format(const char *path, const char *bytes, size_t byte_count)
{
    static const struct {
        const char *suffix;
        mesh_format format;
    } known[] = {{".obj", MESH_FORMAT_OBJ}, {".ply", MESH_FORMAT_PLY},  {".stl", MESH_FORMAT_STL},
                 {".off", MESH_FORMAT_OFF}, {".glb", MESH_FORMAT_GLTF}, {".gltf", MESH_FORMAT_GLTF}};
    const size_t length = strlen(path);
    for (size_t i = 0; i < sizeof known / sizeof known[0]; ++i) {
        const size_t suffix_length = strlen(known[i].suffix);
        if (length > suffix_length && strcasecmp(path + length - suffix_length, known[i].suffix) == 0) {
            return known[i].format;
        }
    }
    if (text_begins_with(bytes, byte_count, "ply\n") || text_begins_with(bytes, byte_count, "ply\r")) {
        return MESH_FORMAT_PLY;
    }
    if (text_begins_with(bytes, byte_count, "glTF")) {
        return MESH_FORMAT_GLTF;
    }
    return text_begins_with(bytes, byte_count, "OFF\n") || text_begins_with(bytes, byte_count, "OFF\r")
               ? MESH_FORMAT_OFF
               : MESH_FORMAT_OTHER;
}

svo_status svo_i_read_mesh(mesh_reader *reader, mesh_format format)
{
    static const stream_reader names[] = {STREAM_READER_ASSIMP, STREAM_READER_OBJ, STREAM_READER_PLY,
                                          STREAM_READER_STL,    STREAM_READER_OFF, STREAM_READER_GLTF};
    *reader->counts = (stream_counts){.reader = names[format]};
    switch (format) {
    case MESH_FORMAT_OBJ:
        SVO_I_TRY(svo_i_read_obj(reader));
        break;
    case MESH_FORMAT_PLY:
        SVO_I_TRY(svo_i_read_ply(reader));
        break;
    case MESH_FORMAT_STL:
        SVO_I_TRY(svo_i_read_stl(reader));
        break;
    case MESH_FORMAT_GLTF:
        SVO_I_TRY(svo_i_read_gltf(reader));
        break;
    default:
        SVO_I_TRY(svo_i_read_off(reader));
        break;
    }
    return reader->mesh->triangle_count > 0 ? SVO_OK : svo_i_fail(reader->message, SVO_IMPORT_FAILED, "no triangles");
}

/* ---- the child ---- */

/* A limit that cannot be set is no error: the parent's timeout still holds. Returns the calling process's limit of
   address space, which no other exceeds. */
static uint64_t set_limits(uint64_t memory_bytes, uint64_t seconds, bool time_grows, bool memory_grows)
{
    struct rlimit given = {.rlim_cur = RLIM_INFINITY, .rlim_max = RLIM_INFINITY};
    /* 1 and not 0: with 0 the kernel still pipes a core to a handler, and 1 is too small for any core file. */
    const struct rlimit core = {.rlim_cur = 1, .rlim_max = 1};
    (void)setrlimit(RLIMIT_CORE, &core);
    const struct rlimit processor = {.rlim_cur = seconds, .rlim_max = time_grows ? RLIM_INFINITY : seconds + 1};
    (void)setrlimit(RLIMIT_CPU, &processor);
    (void)getrlimit(RLIMIT_AS, &given);
    if (LIMIT_ADDRESS_SPACE) {
        const uint64_t least = memory_bytes < given.rlim_cur ? memory_bytes : given.rlim_cur;
        const struct rlimit space = {.rlim_cur = least, .rlim_max = memory_grows ? given.rlim_cur : least};
        (void)setrlimit(RLIMIT_AS, &space);
    }
    return given.rlim_cur;
}

/* given_bytes: of address space, the calling process's limit. */
static int report_failure(const char *words, uint64_t given_bytes)
{
    struct rlimit space = {.rlim_cur = 0};
    (void)getrlimit(RLIMIT_AS, &space);
    const bool is_short = strstr(words, "out of memory") != NULL || strstr(words, "bad_alloc") != NULL;
    if (is_short && given_bytes != RLIM_INFINITY && space.rlim_cur >= given_bytes) {
        (void)svo_i_stream_text(IMPORT_CHILD_STREAM, STREAM_NO_MEMORY,
                                "reading needs more memory: out of memory: RLIMIT_AS (ulimit -v) is %s",
                                svo_i_bytes(given_bytes).text);
    } else if (is_short) {
        (void)svo_i_stream_text(IMPORT_CHILD_STREAM, STREAM_FAILURE,
                                "reading needs more than %s of memory (memory_limit_bytes)",
                                svo_i_bytes(space.rlim_cur).text);
    } else if (strncmp(words, "No suitable reader found", 24) == 0) {
        (void)svo_i_stream_text(IMPORT_CHILD_STREAM, STREAM_FAILURE, "no mesh format that assimp knows");
    } else {
        (void)svo_i_stream_text(IMPORT_CHILD_STREAM, STREAM_FAILURE, "%s", words);
    }
    return 1;
}

/* What a child does. */
typedef struct child_task {
    const char *path;
    uint64_t given_bytes; /* of address space, the calling process's limit */
    bool normal_maps; /* are read */
} child_task;

/* Reads with one of the library's readers, or with assimp. Returns 0, or the exit code after reporting a failure. */
static int read_file(const child_task *task, gather *mesh, stream_counts *counts)
{
    const char *path = task->path;
    const uint64_t given_bytes = task->given_bytes;
    file_bytes file;
    stream_work work = {0, 0};
    svo_message message = {""};
    const char *trouble = svo_i_file_open(path, &file);
    if (trouble != NULL) {
        return report_failure(trouble, given_bytes);
    }
    mesh_reader reader = {.path = path,
                          .bytes = file.bytes,
                          .byte_count = file.byte_count,
                          .stream = IMPORT_CHILD_STREAM,
                          .work = &work,
                          .mesh = mesh,
                          .normal_maps = task->normal_maps,
                          .counts = counts,
                          .message = &message};
    const mesh_format format = svo_i_mesh_format(path, file.bytes, file.byte_count);
    svo_status status = format != MESH_FORMAT_OTHER ? svo_i_read_mesh(&reader, format) : SVO_OK;
    svo_i_file_close(&file);
    if (format == MESH_FORMAT_OTHER || counts->reader == STREAM_READER_ASSIMP) {
        status = svo_i_read_scene(&reader);
    }
    if (status == SVO_FILE_ERROR) {
        return 1; /* the parent is gone */
    }
    return status != SVO_OK ? report_failure(message.text, given_bytes) : 0;
}

static int read_and_send(const child_task *task)
{
    gather mesh = {0};
    stream_counts counts = {.reader = STREAM_READER_ASSIMP};
    if (svo_i_stream_write(IMPORT_CHILD_STREAM, STREAM_GREETING, STREAM_GREETING_BYTES) != 0) {
        return 1;
    }
    int result = read_file(task, &mesh, &counts);
    if (result == 0 && (svo_i_gather_send(&mesh, IMPORT_CHILD_STREAM) != 0 ||
                        svo_i_stream_frame(IMPORT_CHILD_STREAM, STREAM_COUNTS, &counts, sizeof counts) != 0 ||
                        svo_i_stream_frame(IMPORT_CHILD_STREAM, STREAM_END, NULL, 0) != 0)) {
        result = 1;
    }
    svo_i_gather_free(&mesh);
    return result;
}

int svo_import_child_main(int argc, char **argv, int *exit_code)
{
    if (argc != IMPORT_CHILD_ARGUMENT_COUNT || strcmp(argv[1], IMPORT_CHILD_WORD) != 0 ||
        getenv(IMPORT_CHILD_ENVIRONMENT) == NULL) {
        return 0;
    }
    const uint64_t memory_bytes = strtoull(argv[3], NULL, 10);
    const uint64_t seconds = strtoull(argv[4], NULL, 10);
    const child_task task = {.path = argv[2],
                             .given_bytes = set_limits(memory_bytes, seconds, strcmp(argv[5], IMPORT_CHILD_GROWS) == 0,
                                                       strcmp(argv[6], IMPORT_CHILD_GROWS) == 0),
                             .normal_maps = strcmp(argv[7], IMPORT_CHILD_NORMAL_MAPS) == 0};
    *exit_code = read_and_send(&task);
    return 1;
}
