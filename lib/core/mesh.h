/* SPDX-License-Identifier: MIT */
/* Checks of meshes, and reading them from buffers: shared by OpenCL (mesh.c) and OpenGL (glinterop/share/buffer.c). */
#ifndef SVO_LIB_CORE_MESH_H
#define SVO_LIB_CORE_MESH_H

#include <stdbool.h>

#include "core/message.h"
#include "svocl/mesh.h"

typedef struct svo_i_mesh_reader {
    const char *function; /* for messages */
    void *self;
    bool (*has)(const svo_mesh_view *view); /* whether the view names a buffer */
    /* How many bytes the buffer holds. name: of the view, for messages. */
    svo_status (*size)(void *self, const char *name, const svo_mesh_view *view, size_t *bytes, svo_message *message);
    svo_status (*read)(void *self, const svo_mesh_view *view, size_t offset_bytes, size_t bytes, void *to,
                       svo_message *message);
} svo_i_mesh_reader;

/* Refuses buffers whose counts or views do not fit, without reading them. buffers: complete. */
svo_status svo_i_mesh_check(const char *function, cl_context context, const svo_mesh_buffers *buffers,
                            svo_message *message);

/* Refuses counts, materials and textures that do not fit. */
svo_status svo_i_mesh_check_counts(svo_device *device, const char *function, const svo_mesh *mesh);
/* The same and, of a mesh on the host, positions. */
svo_status svo_i_mesh_check_host(svo_device *device, const char *function, const svo_mesh *mesh);

SVO_I_SHARED_BEGIN

/* Checks the views, reads the arrays and packs them. Returns what the reader does, SVO_INVALID_ARGUMENT, or
   SVO_OUT_OF_HOST_MEMORY. */
svo_status svo_i_mesh_read(const svo_mesh_buffers *given, const svo_i_mesh_reader *reader, svo_mesh_copy **out,
                           svo_message *message);

SVO_I_SHARED_END

#endif
