/* SPDX-License-Identifier: MIT */
/*
 * .las files, as the LAS Specification 1.4 R15 of the ASPRS has them, with those of 1.0 to 1.3: a header, records of
 * variable length, which are skipped, and point records of one length. Also the window that readers of points share.
 */
#include "io/points_read.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

/* Fields of the header: their places, from the specification's table 3. */
enum {
    LAS_VERSION_MAJOR = 24,
    LAS_VERSION_MINOR = 25,
    LAS_HEADER_BYTES = 94,
    LAS_POINTS_BEGIN = 96,
    LAS_POINT_FORMAT = 104,
    LAS_RECORD_BYTES = 105,
    LAS_COUNT_32 = 107,
    LAS_SCALE = 131,
    LAS_OFFSET = 155,
    LAS_HEADER_1_0 = 227, /* bytes of a header of versions 1.0 to 1.2 */
    LAS_HEADER_1_3 = 235,
    LAS_COUNT_64 = 247, /* version 1.4 */
    LAS_HEADER_1_4 = 375
};

#define LAS_MINOR_MAX       4
#define LAS_FORMAT_MAX      10
#define LAS_FORMAT_PACKED   0xc0u /* bits of the point format that LASzip sets */
#define LAS_FORMAT_BITS     0x3fu
#define LAS_INTENSITY       12u /* bytes from the beginning of a record */
#define LAS_CLASSIFICATION  15u /* formats 0 .. 5: with the flag of withheld points in bit 7, but in version 1.0 */
#define LAS_WITHHELD_OLD    7
#define LAS_FLAGS           15u /* formats 6 .. 10: bit 2 */
#define LAS_WITHHELD_NEW    2
#define LAS_FORMAT_EXTENDED 6u /* the first whose records have the second layout */

/* ---- what readers share ---- */

static void fail(const points_reader *reader, svo_status status, const char *format, va_list arguments)
{
    svo_message detail;
    svo_i_fail_v(&detail, status, format, arguments);
    (void)svo_i_fail(reader->message, status, "%s: %s", reader->name, detail.text);
}

svo_status svo_i_points_damaged(const points_reader *reader, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fail(reader, SVO_FILE_DAMAGED, format, arguments);
    va_end(arguments);
    return SVO_FILE_DAMAGED;
}

svo_status svo_i_points_fail(const points_reader *reader, svo_status status, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fail(reader, status, format, arguments);
    va_end(arguments);
    return status;
}

void svo_i_points_begin(points_reader *reader)
{
    reader->at = 0;
    reader->window_count = reader->window_at = 0;
    reader->window_end = reader->begin;
    reader->line = reader->begin_line;
    reader->info->withheld_count = 0;
}

svo_status svo_i_points_need(points_reader *reader, size_t byte_count)
{
    const size_t ahead = reader->window_count - reader->window_at;
    const uint64_t behind = reader->file.byte_count - reader->window_end;
    if (ahead >= byte_count || behind == 0) {
        return SVO_OK;
    }
    memmove(reader->window, reader->window + reader->window_at, ahead);
    const size_t room = POINTS_WINDOW_BYTES - ahead;
    const size_t more = behind < room ? (size_t)behind : room;
    reader->window_at = 0;
    reader->window_count = ahead;
    SVO_I_TRY(svo_i_source_read(&reader->file, reader->window_end, reader->window + ahead, more));
    reader->window_count += more;
    reader->window_end += more;
    return SVO_OK;
}

svo_status svo_i_points_next_records(points_reader *reader, points_turn turn, svo_point *points, size_t *count)
{
    *count = 0;
    for (; *count < POINTS_AT_A_TIME && reader->at < reader->info->point_count; ++reader->at) {
        SVO_I_TRY(svo_i_points_need(reader, reader->record_bytes));
        *count += turn(reader, reader->window + reader->window_at, &points[*count]) ? 1 : 0;
        reader->window_at += reader->record_bytes;
    }
    return SVO_OK;
}

/* ---- the header ---- */

static uint64_t bits_of(const points_reader *reader, size_t offset, size_t byte_count)
{
    return point_bits(reader->window + offset, byte_count, false);
}

static double double_of(const points_reader *reader, size_t offset)
{
    double value = 0.0;
    const uint64_t bits = bits_of(reader, offset, sizeof bits);
    memcpy(&value, &bits, sizeof value);
    return value;
}

static svo_status read_version(points_reader *reader)
{
    if (reader->window_count < LAS_HEADER_1_0) {
        return svo_i_points_damaged(reader, "the file ends in the header, at byte %zu", reader->window_count);
    }
    const unsigned major = reader->window[LAS_VERSION_MAJOR];
    const unsigned minor = reader->window[LAS_VERSION_MINOR];
    if (major != 1 || minor > LAS_MINOR_MAX) {
        return svo_i_points_damaged(reader, "version %u.%u is not in 1.0 .. 1.%d, at byte %d", major, minor,
                                    LAS_MINOR_MAX, LAS_VERSION_MAJOR);
    }
    const uint64_t header_bytes = bits_of(reader, LAS_HEADER_BYTES, 2);
    const uint64_t least = minor == 4 ? LAS_HEADER_1_4 : minor == 3 ? LAS_HEADER_1_3 : LAS_HEADER_1_0;
    if (header_bytes < least || header_bytes > reader->window_count) {
        return svo_i_points_damaged(reader,
                                    "a header of %" PRIu64 " bytes, where %" PRIu64 " to %zu are possible, at "
                                    "byte %d",
                                    header_bytes, least, reader->window_count, LAS_HEADER_BYTES);
    }
    reader->info->version = 10 * major + minor;
    return SVO_OK;
}

static svo_status read_format(points_reader *reader)
{
    static const uint8_t least_bytes[] = {20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};
    static const uint8_t color_at[] = {0, 0, 20, 28, 0, 28, 0, 30, 30, 0, 30}; /* 0: none */
    const unsigned byte = reader->window[LAS_POINT_FORMAT];
    const unsigned format = byte & LAS_FORMAT_BITS;
    if ((byte & LAS_FORMAT_PACKED) != 0) {
        return svo_i_points_fail(reader, SVO_UNSUPPORTED,
                                 "a compressed file (LAZ), which svocl does not read; LASzip, PDAL and laspy make .las "
                                 "files of it");
    }
    if (format > LAS_FORMAT_MAX) {
        return svo_i_points_damaged(reader, "point format %u is above %d, at byte %d", format, LAS_FORMAT_MAX,
                                    LAS_POINT_FORMAT);
    }
    reader->record_bytes = (size_t)bits_of(reader, LAS_RECORD_BYTES, 2);
    if (reader->record_bytes < least_bytes[format]) {
        return svo_i_points_damaged(reader, "points of %zu bytes, where format %u has %d, at byte %d",
                                    reader->record_bytes, format, least_bytes[format], LAS_RECORD_BYTES);
    }
    for (size_t axis = 0; axis < 3; ++axis) {
        reader->values[POINT_X + axis] = (point_value){4 * axis, PLY_INT32};
        reader->values[POINT_RED + axis] =
            (point_value){color_at[format] + 2 * axis, color_at[format] > 0 ? PLY_UINT16 : PLY_NO_TYPE};
    }
    reader->values[POINT_INTENSITY] = (point_value){LAS_INTENSITY, PLY_UINT16};
    const bool is_extended = format >= LAS_FORMAT_EXTENDED;
    reader->has_withheld = is_extended || reader->info->version > 10;
    reader->withheld_at = is_extended ? LAS_FLAGS : LAS_CLASSIFICATION;
    reader->withheld_bit = is_extended ? LAS_WITHHELD_NEW : LAS_WITHHELD_OLD;
    reader->info->point_format = format;
    return SVO_OK;
}

/* The number of points, which the file must have. */
static svo_status read_count(points_reader *reader)
{
    const bool is_new = reader->info->version == 14;
    const size_t count_at = is_new ? LAS_COUNT_64 : LAS_COUNT_32;
    const uint64_t count = bits_of(reader, count_at, is_new ? 8 : 4);
    const uint64_t old = bits_of(reader, LAS_COUNT_32, 4);
    reader->begin = bits_of(reader, LAS_POINTS_BEGIN, 4);
    if (reader->begin < bits_of(reader, LAS_HEADER_BYTES, 2) || reader->begin > reader->file.byte_count) {
        return svo_i_points_damaged(reader,
                                    "points begin at %" PRIu64 ", which is in the header or behind the file's "
                                    "%" PRIu64 " bytes, at byte %d",
                                    reader->begin, reader->file.byte_count, LAS_POINTS_BEGIN);
    }
    if (is_new && old != 0 && old != count) {
        return svo_i_points_damaged(reader,
                                    "%" PRIu64 " points, and %" PRIu64 " in the field of older versions, at "
                                    "byte %d",
                                    count, old, LAS_COUNT_32);
    }
    const uint64_t room = (reader->file.byte_count - reader->begin) / reader->record_bytes;
    if (count > room || count > SVO_POINTS_MAX) {
        return svo_i_points_damaged(
            reader, "%" PRIu64 " points of %zu bytes, where the file has room for %" PRIu64 ", at byte %zu", count,
            reader->record_bytes, room, count_at);
    }
    reader->info->point_count = count;
    return SVO_OK;
}

static svo_status read_scale(points_reader *reader)
{
    for (size_t axis = 0; axis < 3; ++axis) {
        reader->scale[axis] = double_of(reader, LAS_SCALE + 8 * axis);
        reader->offset[axis] = double_of(reader, LAS_OFFSET + 8 * axis);
        if (!isfinite(reader->scale[axis]) || reader->scale[axis] == 0.0 || !isfinite(reader->offset[axis])) {
            return svo_i_points_damaged(reader,
                                        "scale %g or offset %g of %c is not a finite number, or scale is 0, at "
                                        "byte %zu",
                                        reader->scale[axis], reader->offset[axis], "xyz"[axis], LAS_SCALE + 8 * axis);
        }
    }
    return SVO_OK;
}

/* ---- points ---- */

static bool turn_record(const points_reader *reader, const uint8_t *record, svo_point *point)
{
    if (reader->has_withheld && (record[reader->withheld_at] >> reader->withheld_bit & 1u) != 0) {
        ++reader->info->withheld_count;
        return false;
    }
    for (size_t axis = 0; axis < 3; ++axis) {
        const point_value *color = &reader->values[POINT_RED + axis];
        const int32_t whole = (int32_t)(uint32_t)point_bits(record + 4 * axis, 4, false);
        point->at[axis] = (double)whole * reader->scale[axis] + reader->offset[axis];
        point->rgb[axis] = color->type != PLY_NO_TYPE ? (uint16_t)point_bits(record + color->offset, 2, false) : 0;
    }
    point->intensity = (uint16_t)point_bits(record + LAS_INTENSITY, 2, false);
    return true;
}

static svo_status next_points(points_reader *reader, svo_point *points, size_t *count)
{
    return svo_i_points_next_records(reader, turn_record, points, count);
}

bool svo_i_las_is_packed(const points_reader *reader)
{
    return reader->window_count > LAS_POINT_FORMAT && (reader->window[LAS_POINT_FORMAT] & LAS_FORMAT_PACKED) != 0;
}

svo_status svo_i_points_open_las(points_reader *reader)
{
    reader->info->format = SVO_VOXEL_FORMAT_LAS;
    reader->is_z_up = true;
    reader->next = next_points;
    SVO_I_TRY(read_version(reader));
    SVO_I_TRY(read_format(reader));
    SVO_I_TRY(read_count(reader));
    return read_scale(reader);
}
