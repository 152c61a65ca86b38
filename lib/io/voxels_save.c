/* SPDX-License-Identifier: MIT */
/*
 * Lists of voxels to files. The writers of .binvox, .ply and .obj files are here; voxels_vox_write.c,
 * voxels_svx_write.c, voxels_nvdb_write.c, voxels_vdb_write.c and voxels_faces.c are the others.
 */
#define _POSIX_C_SOURCE 200809L
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "core/struct_size.h"
#include "core/voxel_list.h"
#include "io/voxels_files.h"
#include "io/voxels_formats.h"

#define BITS_MAX        12u /* longer edges would make gigabytes of empty runs */
#define RUN_MAX         255u
#define POSITION_DIGITS 9 /* give every float back */

/* Puts a line of text that is shorter than SVO_MESSAGE_BYTES. */
static svo_status print(voxel_writer *writer, const char *format, ...) __attribute__((format(printf, 2, 3)));
static svo_status print(voxel_writer *writer, const char *format, ...)
{
    svo_message line;
    va_list arguments;
    va_start(arguments, format);
    const int length = vsnprintf(line.text, sizeof line.text, format, arguments);
    va_end(arguments);
    return svo_i_voxels_put(writer, line.text, (size_t)length);
}

/*
 * ---- .binvox ----
 *
 * The occupancy of the smallest cube whose edge is a power of two, as most readers want it.
 */

static svo_status put_header(voxel_writer *writer, uint32_t side)
{
    char text[4][VOXEL_NUMBER_BYTES];
    for (int axis = 0; axis < 3; ++axis) {
        (void)svo_i_voxel_number(text[axis], svo_i_voxels_world(writer, axis, (double)writer->list.low[axis]), 17);
    }
    (void)svo_i_voxel_number(text[3], writer->list.voxel_edge * (double)side, 17);
    return print(writer, "#binvox 1\ndim %u %u %u\ntranslate %s %s %s\nscale %s\ndata\n", side, side, side, text[0],
                 text[1], text[2], text[3]);
}

static svo_status put_run(voxel_writer *writer, uint8_t value, uint64_t count)
{
    while (count > 0) {
        const uint8_t run[2] = {value, (uint8_t)(count < RUN_MAX ? count : RUN_MAX)};
        SVO_I_TRY(svo_i_voxels_put(writer, run, sizeof run));
        count -= run[1];
    }
    return SVO_OK;
}

/* Writes the runs of voxels that are sorted by row. */
static svo_status put_runs(voxel_writer *writer, const svo_voxel *sorted, uint32_t bits)
{
    uint64_t cell = 0; /* the first that is not written */
    uint64_t filled = 0; /* voxels before it that are not written */
    for (uint64_t i = 0; i < writer->list.voxel_count; ++i) {
        const uint64_t x = (uint64_t)(sorted[i].x - writer->list.low[0]);
        const uint64_t y = (uint64_t)(sorted[i].y - writer->list.low[1]);
        const uint64_t z = (uint64_t)(sorted[i].z - writer->list.low[2]);
        const uint64_t at = (x << bits | z) << bits | y;
        if (at != cell + filled) {
            SVO_I_TRY(put_run(writer, 1, filled));
            SVO_I_TRY(put_run(writer, 0, at - cell - filled));
            cell = at;
            filled = 0;
        }
        ++filled;
    }
    SVO_I_TRY(put_run(writer, 1, filled));
    return put_run(writer, 0, (UINT64_C(1) << 3 * bits) - cell - filled);
}

static svo_status write_binvox(voxel_writer *writer)
{
    const uint32_t bits = svo_i_voxel_bits(writer->list.low, writer->list.high);
    svo_voxel *sorted = NULL;
    if (bits > BITS_MAX) {
        return svo_i_voxels_write_fail(writer, SVO_INVALID_ARGUMENT,
                                       "a .binvox grid of %u^3 voxels is above the limit of %u^3", 1u << bits,
                                       1u << BITS_MAX);
    }
    SVO_I_TRY(svo_i_voxels_sorted(writer, writer->list.low, SVO_I_VOXEL_ROWS, &sorted));
    svo_status status = put_header(writer, 1u << bits);
    if (status == SVO_OK) {
        status = put_runs(writer, sorted, bits);
    }
    svo_i_free(sorted);
    return status;
}

/*
 * ---- .ply and .obj ----
 *
 * For programs that show meshes: points at the voxels' centers, and cubes with the faces that show.
 */

/* Whether a voxel has another material than 0, which voxels without materials have. */
static bool has_materials(const voxel_writer *writer)
{
    bool has = writer->list.property_count > 0;
    for (uint64_t i = 0; i < writer->list.voxel_count && !has; ++i) {
        has = writer->voxels[i].material != 0;
    }
    return has;
}

static svo_status write_ply(voxel_writer *writer)
{
    const bool with_materials = has_materials(writer);
    SVO_I_TRY(print(writer,
                    "ply\nformat binary_little_endian 1.0\nelement vertex %" PRIu64
                    "\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n"
                    "property uchar green\nproperty uchar blue\nproperty uchar alpha\n"
                    "%send_header\n",
                    writer->list.voxel_count, with_materials ? "property ushort material\n" : ""));
    for (uint64_t i = 0; i < writer->list.voxel_count; ++i) {
        const svo_voxel *voxel = &writer->voxels[i];
        const float center[3] = {(float)svo_i_voxels_world(writer, 0, (double)voxel->x + 0.5),
                                 (float)svo_i_voxels_world(writer, 1, (double)voxel->y + 0.5),
                                 (float)svo_i_voxels_world(writer, 2, (double)voxel->z + 0.5)};
        SVO_I_TRY(svo_i_voxels_put(writer, center, sizeof center));
        SVO_I_TRY(svo_i_voxels_put(writer, voxel->rgba, sizeof voxel->rgba));
        SVO_I_TRY(svo_i_voxels_put(writer, &voxel->material, with_materials ? sizeof voxel->material : 0));
    }
    return SVO_OK;
}

/* Corner c of a cube is at (c & 1, c >> 1 & 1, c >> 2). The corners of each face, counterclockwise from outside; face
   2 a + s is that of axis a on its low (0) or high (1) side. */
static const uint8_t face_corners[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                           {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};

/* A bit for each face behind which there is no voxel. */
static unsigned outer_faces(const voxel_writer *writer, const svo_voxel *voxel)
{
    unsigned faces = 0;
    for (unsigned face = 0; face < 6; ++face) {
        int32_t place[3] = {voxel->x, voxel->y, voxel->z};
        place[face / 2] += face % 2 != 0 ? 1 : -1;
        faces |= svo_i_voxels_has(writer, place) ? 0u : 1u << face;
    }
    return faces;
}

static svo_status put_corner(voxel_writer *writer, const svo_voxel *voxel, unsigned corner)
{
    char text[6][VOXEL_NUMBER_BYTES];
    const int32_t place[3] = {voxel->x, voxel->y, voxel->z};
    for (int axis = 0; axis < 3; ++axis) {
        const double at = (double)place[axis] + (double)(corner >> axis & 1u);
        (void)svo_i_voxel_number(text[axis], svo_i_voxels_world(writer, axis, at), POSITION_DIGITS);
        (void)svo_i_voxel_number(text[3 + axis], voxel->rgba[axis] / 255.0, POSITION_DIGITS);
    }
    return print(writer, "v %s %s %s %s %s %s\n", text[0], text[1], text[2], text[3], text[4], text[5]);
}

/* Writes the outer faces of a cube and their corners. *corners: how many the file has. */
static svo_status put_cube(voxel_writer *writer, const svo_voxel *voxel, uint64_t *corners)
{
    uint64_t index[8] = {0};
    const unsigned faces = outer_faces(writer, voxel);
    for (unsigned corner = 0; corner < 8; ++corner) {
        bool used = false;
        for (unsigned face = 0; face < 6; ++face) {
            used = used || ((faces >> face & 1u) != 0 && memchr(face_corners[face], (int)corner, 4) != NULL);
        }
        if (used) {
            index[corner] = ++*corners;
            SVO_I_TRY(put_corner(writer, voxel, corner));
        }
    }
    for (unsigned face = 0; face < 6; ++face) {
        const uint8_t *c = face_corners[face];
        if ((faces >> face & 1u) != 0) {
            ++writer->info.faces;
            SVO_I_TRY(print(writer, "f %" PRIu64 " %" PRIu64 " %" PRIu64 " %" PRIu64 "\n", index[c[0]], index[c[1]],
                            index[c[2]], index[c[3]]));
        }
    }
    return SVO_OK;
}

static svo_status write_obj(voxel_writer *writer)
{
    uint64_t corners = 0;
    SVO_I_TRY(print(writer, "# %" PRIu64 " voxels; v x y z red green blue\n", writer->list.voxel_count));
    for (uint64_t i = 0; i < writer->list.voxel_count; ++i) {
        SVO_I_TRY(put_cube(writer, &writer->voxels[i], &corners));
    }
    return SVO_OK;
}

/* ---- saving ---- */

static svo_status write_format(voxel_writer *writer, svo_voxel_format format)
{
    if (writer->as_faces) {
        return svo_i_voxels_write_faces(writer, format);
    }
    switch (format) {
    case SVO_VOXEL_FORMAT_VOX:
        return svo_i_voxels_write_vox(writer);
    case SVO_VOXEL_FORMAT_SVX:
        return svo_i_voxels_write_svx(writer);
    case SVO_VOXEL_FORMAT_BINVOX:
        return write_binvox(writer);
    case SVO_VOXEL_FORMAT_NVDB:
        return svo_i_voxels_write_nvdb(writer);
    case SVO_VOXEL_FORMAT_VDB:
        return svo_i_voxels_write_vdb(writer);
    case SVO_VOXEL_FORMAT_BT:
        return svo_i_voxels_write_bt(writer);
    case SVO_VOXEL_FORMAT_PLY:
        return write_ply(writer);
    default:
        return write_obj(writer);
    }
}

/* Makes a list with z up of one with y up. */
static svo_status turn(const voxel_writer *writer, svo_voxels **out)
{
    const svo_memory_callbacks memory = {.struct_size = sizeof memory,
                                         .allocate = writer->memory->allocate,
                                         .release = writer->memory->release,
                                         .user = writer->memory->user};
    svo_voxels_source source = {.struct_size = sizeof source,
                                .voxel_count = writer->list.voxel_count,
                                .properties = writer->properties,
                                .property_count = (size_t)writer->list.property_count,
                                .origin = {writer->list.origin[0], -writer->list.origin[2], writer->list.origin[1]},
                                .voxel_edge = writer->list.voxel_edge,
                                .memory = memory.allocate != NULL ? &memory : NULL};
    svo_voxel *turned = svo_i_alloc(writer->memory, (size_t)source.voxel_count * sizeof *turned + 1);
    if (turned == NULL) {
        return svo_i_voxels_write_fail(writer, SVO_OUT_OF_HOST_MEMORY, "no memory for %llu voxels",
                                       (unsigned long long)source.voxel_count);
    }
    for (uint64_t i = 0; i < source.voxel_count; ++i) {
        turned[i] = writer->voxels[i];
        turned[i].y = -1 - writer->voxels[i].z;
        turned[i].z = writer->voxels[i].y;
    }
    source.voxels = turned;
    const svo_status status = svo_voxels_create(&source, out, writer->sink.message);
    if (status != SVO_OK) {
        svo_i_message_rename(writer->sink.message, writer->sink.name);
    }
    svo_i_free(turned);
    return status;
}

static svo_status take_list(voxel_writer *writer, const svo_voxels *voxels)
{
    writer->voxels = svo_voxels_get(voxels);
    writer->properties = svo_voxels_get_properties(voxels);
    writer->list = (svo_voxels_info)SVO_VOXELS_INFO_INIT;
    return svo_voxels_get_info(voxels, &writer->list);
}

/* Writes a list whose format is known; then fills info, which may be NULL. */
static svo_status write_list(voxel_writer *writer, const svo_voxels *voxels, svo_voxel_format format,
                             svo_voxels_save_info *info)
{
    svo_status status = SVO_OK;
    svo_voxels *turned = NULL;
    writer->memory = &voxels->memory;
    SVO_I_TRY(take_list(writer, voxels));
    if (svo_i_voxels_are_turned(voxels->axes, format)) {
        SVO_I_TRY(turn(writer, &turned));
        writer->is_turned = true;
        (void)take_list(writer, turned);
    }
    writer->info = (svo_voxels_save_info){.struct_size = sizeof writer->info, .format = format, .models = 1};
    writer->buffer = svo_i_alloc(writer->memory, VOXEL_BUFFER_BYTES);
    if (writer->buffer == NULL) {
        SVO_I_TRY_CLEANUP(svo_i_voxels_write_fail(writer, SVO_OUT_OF_HOST_MEMORY, "no memory for a buffer"));
    }
    SVO_I_TRY_CLEANUP(write_format(writer, format));
    SVO_I_TRY_CLEANUP(svo_i_voxels_flush(writer));
    if (info != NULL) {
        (void)svo_i_struct_write(NULL, "", "info", &writer->info, info,
                                 SVO_I_STRUCT_SIZES(svo_voxels_save_info, bytes));
    }
cleanup:
    svo_i_free(writer->buffer);
    svo_voxels_destroy(&turned);
    return status;
}

svo_status svo_i_voxels_save_by(const char *function, const svo_voxels *voxels, svo_sink sink, svo_voxel_format format,
                                voxel_writer *writer, svo_voxels_save_info *info, svo_message *message)
{
    SVO_I_TRY(info == NULL ? SVO_OK
                           : svo_i_struct_check(message, function, "info", info,
                                                SVO_I_STRUCT_SIZES(svo_voxels_save_info, bytes)));
    SVO_I_TRY(svo_i_sink_open(function, sink, message, &writer->sink));
    return svo_i_sink_close(&writer->sink, write_list(writer, voxels, format, info));
}

static bool is_written(svo_voxel_format format)
{
    return ((unsigned)format >= SVO_VOXEL_FORMAT_VOX && (unsigned)format <= SVO_VOXEL_FORMAT_NVDB) ||
           format == SVO_VOXEL_FORMAT_BT || format == SVO_VOXEL_FORMAT_VDB;
}

svo_status svo_voxels_save(const svo_voxels *voxels, svo_sink sink, svo_voxel_format format, svo_voxels_save_info *info,
                           svo_message *message)
{
    static const char function[] = "svo_voxels_save";
    voxel_writer writer = {.used = 0};
    if (voxels == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: voxels is NULL", function);
    }
    if (format == SVO_VOXEL_FORMAT_AUTO) {
        format = svo_voxel_format_of_path(sink.path);
    }
    if (!is_written(format)) {
        return sink.path != NULL
                   ? svo_i_fail(
                         message, SVO_INVALID_ARGUMENT,
                         "%s: the suffix of '%s' is not vox, svx, binvox, ply, obj, nvdb, bt or vdb, and format is %d",
                         function, sink.path, (int)format)
                   : svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: format %d is neither in %d .. %d nor %d nor %d",
                                function, (int)format, SVO_VOXEL_FORMAT_VOX, SVO_VOXEL_FORMAT_NVDB, SVO_VOXEL_FORMAT_BT,
                                SVO_VOXEL_FORMAT_VDB);
    }
    return svo_i_voxels_save_by(function, voxels, sink, format, &writer, info, message);
}

svo_status svo_voxels_save_faces(const svo_voxels *voxels, svo_sink sink, svo_voxel_format format,
                                 svo_voxels_save_info *info, svo_message *message)
{
    static const char function[] = "svo_voxels_save_faces";
    voxel_writer writer = {.as_faces = true};
    if (voxels == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: voxels is NULL", function);
    }
    if (format == SVO_VOXEL_FORMAT_AUTO) {
        format = svo_voxel_format_of_path(sink.path);
    }
    if (format != SVO_VOXEL_FORMAT_PLY && format != SVO_VOXEL_FORMAT_OBJ) {
        return sink.path != NULL ? svo_i_fail(message, SVO_INVALID_ARGUMENT,
                                              "%s: the suffix of '%s' is neither ply nor obj, and format is %d",
                                              function, sink.path, (int)format)
                                 : svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: format %d is neither %d nor %d",
                                              function, (int)format, SVO_VOXEL_FORMAT_PLY, SVO_VOXEL_FORMAT_OBJ);
    }
    return svo_i_voxels_save_by(function, voxels, sink, format, &writer, info, message);
}
