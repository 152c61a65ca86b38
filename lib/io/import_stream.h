/* SPDX-License-Identifier: MIT */
/*
 * What an import child writes to its parent's pipe: a greeting, then frames, each a header and a payload padded to
 * 8 bytes. The parent keeps the bytes and points into them. It uses none of them before svo_i_stream_parse has checked
 * them, since a corrupted reader may have written anything.
 */
#ifndef SVO_LIB_IO_IMPORT_STREAM_H
#define SVO_LIB_IO_IMPORT_STREAM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "core/memory.h"
#include "svocl/io.h"

#define STREAM_GREETING       "svoimp7\n" /* changes with the frames: parent and child may be different builds */
#define STREAM_GREETING_BYTES 8
#define STREAM_PAYLOAD_ALIGN  8
#define STREAM_BYTES_A_SECOND 1000000 /* of files, that a reader reads at least */

typedef enum stream_kind {
    STREAM_WARNING = 0, /* text for the log callback */
    STREAM_FAILURE, /* text: why there will be no mesh */
    STREAM_NO_MEMORY, /* text: the same, where the calling process's limits left too little */
    STREAM_TEXTURE, /* stream_texture, then its texels; the order of these frames is their index */
    STREAM_MATERIALS, /* svo_material each */
    STREAM_FINISHES, /* svo_finish per material; absent: all zero */
    STREAM_NORMAL_MAPS, /* svo_normal_map per material; absent: none */
    STREAM_POSITIONS, /* 3 floats per vertex */
    STREAM_NORMALS, /* 3 floats per vertex */
    STREAM_COLORS, /* 4 bytes per vertex */
    STREAM_UVS, /* 2 floats per vertex */
    STREAM_INDICES, /* 3 uint32_t per triangle */
    STREAM_TRIANGLE_MATERIALS, /* uint16_t per triangle */
    STREAM_FILE_VERTICES, /* uint32_t per vertex of the file: the mesh's; UINT32_MAX: none. Absent: not known */
    STREAM_COUNTS, /* stream_counts */
    STREAM_WORK, /* stream_work: what the child is about to do, beyond reading the mesh file */
    STREAM_FILE, /* the path, with its zero, of a file besides the mesh file that is read */
    STREAM_END, /* empty: the answer is complete */
    STREAM_KIND_COUNT
} stream_kind;

typedef struct stream_frame {
    uint32_t kind;
    uint32_t zero;
    uint64_t payload_bytes; /* without the padding */
} stream_frame;

typedef struct stream_texture {
    uint32_t width, height, wrap_u, wrap_v;
} stream_texture;

/* Who read the file, and svo_import_info's counts. */
typedef enum stream_reader {
    STREAM_READER_ASSIMP = 0,
    STREAM_READER_OBJ,
    STREAM_READER_PLY,
    STREAM_READER_STL,
    STREAM_READER_OFF,
    STREAM_READER_GLTF,
    STREAM_READER_COUNT
} stream_reader;

typedef struct stream_counts {
    uint64_t reader; /* stream_reader */
    uint64_t declared_vertices, used_vertices, declared_faces, read_faces;
} stream_counts;

/* Work beyond the mesh file. Texels, and corners of meshes that are drawn many times, have no bytes in a file. */
typedef struct stream_work {
    uint64_t read_bytes; /* of files that the mesh file names */
    uint64_t made_bytes; /* of what unfolds */
} stream_work;

/* Memory of a child: STREAM_MEMORY_BYTES, and for each byte of files and of what unfolds so many, but of the latter no
   more than STREAM_MADE_BYTES_MAX: a small file may declare any number. */
#define STREAM_MEMORY_BYTES    (UINT64_C(1) << 30)
#define STREAM_MEMORY_OF_FILES 64
#define STREAM_MEMORY_OF_MADE  16
#define STREAM_MADE_BYTES_MAX  (UINT64_C(8) << 30)

#define STREAM_TEXTURE_SIDE_MAX 16384 /* svo_texture's limit */

/* The parent's result: a mesh that points into the stream's bytes. */
struct svo_import {
    svo_i_memory memory;
    uint8_t *bytes;
    size_t byte_count;
    svo_mesh mesh;
    svo_texture *textures;
    svo_import_info info;
    const uint32_t *file_vertices; /* in bytes; NULL: not known */
    size_t file_vertex_count;
    const char **files; /* paths, in bytes */
    size_t file_count, file_capacity;
};

/* Child side. They return 0, or -1 when the parent is gone. A frame's payload may be written in parts. */
int svo_i_stream_write(int stream, const void *bytes, size_t byte_count);
int svo_i_stream_begin(int stream, stream_kind kind, uint64_t payload_bytes);
int svo_i_stream_pad(int stream, uint64_t payload_bytes); /* after the last part */
int svo_i_stream_frame(int stream, stream_kind kind, const void *payload, size_t payload_bytes);
int svo_i_stream_file(int stream, const char *path);
int svo_i_stream_text(int stream, stream_kind kind, const char *format, ...) __attribute__((format(printf, 3, 4)));

/*
 * Announces work: the parent gives more time and memory for it, and the child allows itself more, unless they are
 * limited for the file as a whole. A parent that is gone is seen at the next write. done: the sum of what was announced
 * before, to which it adds; NULL: no memory is limited.
 */
void svo_i_stream_work(int stream, stream_work *done, stream_work more);

/* Memory for all that was announced, at most UINT64_MAX / 2. */
uint64_t svo_i_stream_memory(const stream_work *work);
/* Adds, up to UINT64_MAX. */
void svo_i_stream_add(stream_work *sum, const stream_work *more);

/*
 * Parent side: checks import->bytes and fills the rest of import. path: the mesh file, for messages and the log.
 * strict: a warning is a failure.
 * Returns SVO_IMPORT_FAILED (the child's own failure, or an answer that is not well formed), SVO_OUT_OF_HOST_MEMORY.
 */
svo_status svo_i_stream_parse(svo_import *import, const char *path, bool strict, svo_log_callback log, void *log_user,
                              svo_message *message);

#endif
