/* SPDX-License-Identifier: MIT */
/* What the writers of voxel files share: a buffer before the callback, messages, and voxels in other orders. */
#ifndef SVO_LIB_IO_VOXELS_WRITER_H
#define SVO_LIB_IO_VOXELS_WRITER_H

#include "core/memory.h"
#include "core/message.h"
#include "core/voxel_list.h"
#include "svocl/voxel_files.h"

#define VOXEL_BUFFER_BYTES ((size_t)1 << 16)

/* A file that is being written. */
typedef struct voxel_writer {
    const char *name; /* of the file or of the function, for messages */
    svo_message *message;
    svo_voxels_write_callback write;
    void *user;
    const svo_i_memory *memory; /* of the list */
    const svo_voxel *voxels;
    svo_voxels_info list;
    const svo_voxel_property *properties;
    svo_voxels_save_info info;
    uint8_t *buffer; /* VOXEL_BUFFER_BYTES; owned */
    size_t used; /* bytes in it */
} voxel_writer;

/* Fails: "NAME: " and what the format says. */
svo_status svo_i_voxels_write_fail(const voxel_writer *writer, svo_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Puts bytes, or a line of text that is shorter than SVO_MESSAGE_BYTES, behind those before. */
svo_status svo_i_voxels_put(voxel_writer *writer, const void *bytes, size_t byte_count);
svo_status svo_i_voxels_print(voxel_writer *writer, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* Gives what is in the buffer to the callback. */
svo_status svo_i_voxels_flush(voxel_writer *writer);

/* A copy of the voxels in another order, for svo_i_free. */
svo_status svo_i_voxels_sorted(const voxel_writer *writer, svo_i_voxel_order order, svo_voxel **out);

/* The world position of a corner: of the voxel at that place, or between voxels. */
double svo_i_voxels_world(const voxel_writer *writer, int axis, double place);

#endif
