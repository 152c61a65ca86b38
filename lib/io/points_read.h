/* SPDX-License-Identifier: MIT */
/* Readers of point clouds: each opens a file and gives its points in blocks, as often as it is begun. */
#ifndef SVO_LIB_IO_POINTS_READ_H
#define SVO_LIB_IO_POINTS_READ_H

#include "core/memory.h"
#include "core/message.h"
#include "io/files.h"
#include "io/import_ply_file.h"
#include "svocl/points.h"

#define POINTS_WINDOW_BYTES ((size_t)1 << 20) /* of a file, read at a time; a header is no longer */
#define POINTS_AT_A_TIME    ((size_t)4096)

#define LAS_MAGIC "LASF"

/* What a value is for: components of svo_point. */
typedef enum point_slot {
    POINT_X = 0,
    POINT_RED = POINT_X + 3,
    POINT_INTENSITY = POINT_RED + 3,
    POINT_SLOTS,
    POINT_NO_SLOT = POINT_SLOTS
} point_slot;

/* Where a value is in a record, or in a line. */
typedef struct point_value {
    size_t offset; /* bytes, of binary files */
    ply_type type; /* PLY_NO_TYPE: none */
} point_value;

typedef struct points_reader points_reader;

/* Gives the next points, at most POINTS_AT_A_TIME; *count 0: there are no more. */
typedef svo_status (*points_next)(points_reader *reader, svo_point *points, size_t *count);

struct points_reader {
    svo_i_source file; /* not of a caller's points */
    const char *name; /* begins messages */
    svo_message *message;
    const svo_i_memory *memory;
    svo_points_info *info; /* format and version, point_count, withheld_count; the rest is the caller's */
    uint32_t rgb_max; /* 0: judged by the greatest */
    bool is_z_up; /* by the format */
    points_next next;
    uint64_t at; /* points that were given since the beginning */

    /* Files: a window moves over them. */
    uint64_t begin; /* of the first record */
    uint8_t *window; /* POINTS_WINDOW_BYTES, or as many as the file has; owned */
    size_t window_count, window_at; /* bytes in it, and those that have been read */
    uint64_t window_end; /* its end, in the file */

    /* Records of one length, of .las and binary .ply. */
    size_t record_bytes;
    bool is_big_endian;
    point_value values[POINT_SLOTS];
    bool has_withheld; /* .las: bit withheld_bit of byte withheld_at */
    size_t withheld_at;
    uint8_t withheld_bit;
    double scale[3], offset[3]; /* .las: of coordinates, which are whole numbers */

    /* Text .ply. */
    uint64_t begin_line, line; /* of the first vertex, and where the window is; from 1 on */
    uint64_t lines_before; /* lines of elements before the vertices */
    uint8_t slots[PLY_PROPERTIES_MAX]; /* a point_slot of each value of a line */
    ply_type types[PLY_PROPERTIES_MAX];
    size_t value_count;

    /* A caller's points. */
    const svo_points_source *given;
};

/* Fails with SVO_FILE_DAMAGED: "NAME: " and what the format says, which names the byte. */
svo_status svo_i_points_damaged(const points_reader *reader, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
/* The same with another status. */
svo_status svo_i_points_fail(const points_reader *reader, svo_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Opens a file of a format, whose first bytes are in the window. */
svo_status svo_i_points_open_las(points_reader *reader);
svo_status svo_i_points_open_ply(points_reader *reader);
/* Whether the window begins a .laz file, of those that begin as .las files do. */
bool svo_i_las_is_packed(const points_reader *reader);

/* Goes to the first point again. */
void svo_i_points_begin(points_reader *reader);

/* Moves the window on until it has so many bytes ahead, at most POINTS_WINDOW_BYTES, or the rest of the file. */
svo_status svo_i_points_need(points_reader *reader, size_t byte_count);

/* Reads records of one length; turn makes a point of one, and says whether it is one that is taken. */
typedef bool (*points_turn)(const points_reader *reader, const uint8_t *record, svo_point *point);
svo_status svo_i_points_next_records(points_reader *reader, points_turn turn, svo_point *points, size_t *count);

/* An unsigned number of at most 8 bytes. */
static inline uint64_t point_bits(const uint8_t *bytes, size_t byte_count, bool is_big_endian)
{
    uint64_t value = 0;
    for (size_t i = 0; i < byte_count; ++i) {
        value = value << 8 | bytes[is_big_endian ? i : byte_count - 1 - i];
    }
    return value;
}

#endif
