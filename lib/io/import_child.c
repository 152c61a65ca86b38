/* SPDX-License-Identifier: MIT */
/*
 * The import child: sets its own resource limits, reads the file and writes the mesh to its parent. OBJ, PLY, STL,
 * OFF and glTF have readers of their own (import_formats.h), assimp reads the others. On some broken files assimp
 * 5.2.5 crashes, hangs or allocates without end; here that ends this process alone.
 */
#define _POSIX_C_SOURCE 200809L
#include <assimp/cimport.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#include "core/memory.h"
#include "core/message.h"
#include "io/import_file.h"
#include "io/import_formats.h"
#include "io/import_gather.h"
#include "io/import_process.h"
#include "io/import_scene.h"
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

/* A limit that cannot be set is no error: the parent's timeout still holds. */
static void set_limits(uint64_t memory_bytes, uint64_t seconds, bool time_grows)
{
    /* 1 and not 0: with 0 the kernel still pipes a core to a handler, and 1 is too small for any core file. */
    const struct rlimit core = {.rlim_cur = 1, .rlim_max = 1};
    (void)setrlimit(RLIMIT_CORE, &core);
    const struct rlimit processor = {.rlim_cur = seconds, .rlim_max = time_grows ? RLIM_INFINITY : seconds + 1};
    (void)setrlimit(RLIMIT_CPU, &processor);
    if (LIMIT_ADDRESS_SPACE) {
        const struct rlimit space = {.rlim_cur = memory_bytes, .rlim_max = memory_bytes};
        (void)setrlimit(RLIMIT_AS, &space);
    }
}

/* No post-processing that moves, joins or removes geometry: the file's triangles are voxelized as they are. */
static const struct aiScene *read_scene(const char *path, scene_files *files)
{
    struct aiPropertyStore *properties = aiCreatePropertyStore();
    if (properties == NULL) {
        return NULL;
    }
    aiSetImportPropertyInteger(properties, AI_CONFIG_IMPORT_NO_SKELETON_MESHES, 1);
    svo_i_scene_files(IMPORT_CHILD_STREAM, path, files);
    const struct aiScene *scene = aiImportFileExWithProperties(path, aiProcess_Triangulate, &files->io, properties);
    aiReleasePropertyStore(properties);
    return scene;
}

static int report_failure(const char *words, uint64_t memory_bytes)
{
    if (strcmp(words, "out of memory") == 0 || strstr(words, "bad_alloc") != NULL) {
        (void)svo_i_stream_text(IMPORT_CHILD_STREAM, STREAM_FAILURE, "reading needs more than %s of memory",
                                svo_i_bytes(memory_bytes).text);
    } else if (strncmp(words, "No suitable reader found", 24) == 0) {
        (void)svo_i_stream_text(IMPORT_CHILD_STREAM, STREAM_FAILURE, "no mesh format that assimp knows");
    } else {
        (void)svo_i_stream_text(IMPORT_CHILD_STREAM, STREAM_FAILURE, "%s", words);
    }
    return 1;
}

/* Reads with assimp. Returns 0, or the exit code after reporting a failure. */
static int read_with_assimp(const char *path, uint64_t memory_bytes, gather *mesh)
{
    scene_files files = {.trouble = NULL};
    const struct aiScene *scene = read_scene(path, &files);
    if (scene == NULL && files.trouble != NULL) {
        (void)svo_i_stream_text(IMPORT_CHILD_STREAM, STREAM_FAILURE, "cannot be read: %s", files.trouble);
        return 1;
    }
    if (scene == NULL) {
        const char *words = aiGetErrorString();
        return report_failure(words != NULL && words[0] != '\0' ? words : "not understood", memory_bytes);
    }
    const char *failure = svo_i_import_gather_scene(scene, path, IMPORT_CHILD_STREAM, mesh);
    aiReleaseImport(scene);
    return failure != NULL ? report_failure(failure, memory_bytes) : -files.result;
}

/* Reads with one of the library's readers, or with assimp. Returns 0, or the exit code after reporting a failure. */
static int read_file(const char *path, uint64_t memory_bytes, gather *mesh, stream_counts *counts)
{
    file_bytes file;
    svo_message message = {""};
    const char *trouble = svo_i_file_open(path, &file);
    if (trouble != NULL) {
        return report_failure(trouble, memory_bytes);
    }
    const mesh_format format = svo_i_mesh_format(path, file.bytes, file.byte_count);
    svo_status status = SVO_OK;
    if (format != MESH_FORMAT_OTHER) {
        mesh_reader reader = {.path = path,
                              .bytes = file.bytes,
                              .byte_count = file.byte_count,
                              .stream = IMPORT_CHILD_STREAM,
                              .mesh = mesh,
                              .counts = counts,
                              .message = &message};
        status = svo_i_read_mesh(&reader, format);
    }
    svo_i_file_close(&file);
    if (format == MESH_FORMAT_OTHER || counts->reader == STREAM_READER_ASSIMP) {
        return read_with_assimp(path, memory_bytes, mesh);
    }
    return status != SVO_OK ? report_failure(message.text, memory_bytes) : 0;
}

static int read_and_send(const char *path, uint64_t memory_bytes)
{
    gather mesh = {0};
    stream_counts counts = {.reader = STREAM_READER_ASSIMP};
    if (svo_i_stream_write(IMPORT_CHILD_STREAM, STREAM_GREETING, STREAM_GREETING_BYTES) != 0) {
        return 1;
    }
    int result = read_file(path, memory_bytes, &mesh, &counts);
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
    set_limits(memory_bytes, seconds, strcmp(argv[5], IMPORT_CHILD_GROWS) == 0);
    *exit_code = read_and_send(argv[2], memory_bytes);
    return 1;
}
