/* SPDX-License-Identifier: MIT */
/*
 * What the readers and the writers of voxel files share: the file in memory, messages with their place in it, and
 * growing lists; a buffer before the sink, and voxels in other orders; numbers as text.
 */
#ifndef SVO_LIB_IO_VOXELS_FILES_H
#define SVO_LIB_IO_VOXELS_FILES_H

#include <stdbool.h>
#include <stddef.h>

#include "core/memory.h"
#include "core/message.h"
#include "core/voxel_list.h"
#include "io/files.h"
#include "svocl/voxel_files.h"

/* Whether z is up in a file of that format. */
bool svo_i_voxels_are_turned(svo_axes axes, svo_voxel_format format);

/* ---- numbers, the same in every locale ---- */

#define VOXEL_NUMBER_BYTES 48 /* holds every number, with its terminator */

/* Writes a finite number in decimal, with so many significant digits; 17 give every double back. Returns text. */
const char *svo_i_voxel_number(char text[VOXEL_NUMBER_BYTES], double value, int digits);

/* ---- reading ---- */

/* What a voxel takes while its tree is built: 20 in the list, 140 in the plan (voxels.h), and buffers. */
#define BUILT_VOXEL_BYTES 200

/* A property of a material, whose texts lie in the reader's. */
typedef struct voxel_property {
    uint32_t material;
    size_t key, value; /* offsets into texts */
} voxel_property;

/* Takes a model, whose voxels the reader has, and where it is: 3 x 4 numbers each, in the axes of the list. */
struct voxel_reader;
typedef svo_status (*voxel_take_part)(struct voxel_reader *reader, uint64_t model, const double *transforms,
                                      uint64_t count);

/* A file that is being read, and what was found in it. */
typedef struct voxel_reader {
    const char *name;
    const uint8_t *bytes;
    size_t byte_count;
    svo_voxels_load_options options; /* voxels_max is not 0 */
    bool limit_is_default; /* voxels_max comes from memory */
    svo_i_memory memory; /* of options.memory */
    svo_message *message;
    svo_voxel_file_info info;

    svo_voxel *voxels; /* owned, as the arrays below */
    uint64_t voxel_count, voxel_capacity;
    voxel_property *properties;
    size_t property_count, property_capacity;
    char *texts;
    size_t text_bytes, text_capacity;
    double origin[3]; /* of the list */
    double voxel_edge; /* 0: 1 */

    voxel_take_part take_part; /* of .vox: by models; NULL: as a list */
    svo_voxel_part_callback callback; /* of the caller, for take_part */
    void *user;
} voxel_reader;

/* Fails with SVO_FILE_DAMAGED: "NAME: " and what the format says, which names the part of the file and the byte. */
svo_status svo_i_voxels_damaged(const voxel_reader *reader, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
/* The same with another status. */
svo_status svo_i_voxels_fail(const voxel_reader *reader, svo_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Counts a warning and gives it to the log callback: "NAME: " and what the format says. */
void svo_i_voxels_warn(voxel_reader *reader, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Fails where so many voxels are above the limit. */
svo_status svo_i_voxels_limit(const voxel_reader *reader, uint64_t voxel_count);
/* Makes room for so many voxels in all, after a check of the limit. */
svo_status svo_i_voxels_reserve(voxel_reader *reader, uint64_t voxel_count);
/* Adds a voxel, for which there is room. */
void svo_i_voxels_add(voxel_reader *reader, svo_voxel voxel);
/* The same where the number was not known before: makes room as it goes. */
svo_status svo_i_voxels_append(voxel_reader *reader, svo_voxel voxel);

/* Adds a property. key, value: of those lengths, without a terminator. */
svo_status svo_i_voxels_add_property(voxel_reader *reader, uint32_t material, const char *key, size_t key_bytes,
                                     const char *value, size_t value_bytes);

/* ---- checksums ---- */

/* The sums of single bytes for CRC-32 (polynomial 0xedb88320), as PNG images and .nvdb files have it. */
void svo_i_voxels_byte_sums(uint32_t sums[256]);

/* ---- writing ---- */

#define VOXEL_BUFFER_BYTES ((size_t)1 << 16)

/* A file that is being written. */
typedef struct voxel_writer {
    svo_i_sink sink;
    const svo_i_memory *memory; /* of the list */
    const svo_voxel *voxels;
    svo_voxels_info list;
    bool is_turned; /* the list is the caller's with z up */
    bool as_faces; /* .ply and .obj: as merged faces */
    float background; /* .nvdb, .vdb: above 0, colors are floats, distances, and this is the greatest; else 0 */
    const svo_voxel_property *properties;
    svo_voxels_save_info info;
    uint8_t *buffer; /* VOXEL_BUFFER_BYTES; owned */
    size_t used; /* bytes in it */
} voxel_writer;

/* Fails: "NAME: " and what the format says. */
svo_status svo_i_voxels_write_fail(const voxel_writer *writer, svo_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Puts bytes behind those before. */
svo_status svo_i_voxels_put(voxel_writer *writer, const void *bytes, size_t byte_count);
/* Gives what is in the buffer to the sink. */
svo_status svo_i_voxels_flush(voxel_writer *writer);

/* A copy of the voxels in another order, for svo_i_free. low: a corner from which on codes are made, at most that of
   the list. */
svo_status svo_i_voxels_sorted(const voxel_writer *writer, const int32_t low[3], svo_i_voxel_order order,
                               svo_voxel **out);

/* Whether the list has a voxel there, by its Morton code. */
bool svo_i_voxels_has(const voxel_writer *writer, const int32_t place[3]);

/* The world position of a corner: of the voxel at that place, or between voxels. */
double svo_i_voxels_world(const voxel_writer *writer, int axis, double place);

#endif
