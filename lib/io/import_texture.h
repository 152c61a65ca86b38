/* SPDX-License-Identifier: MIT */
/* The textures that an import child has sent. */
#ifndef SVO_LIB_IO_IMPORT_TEXTURE_H
#define SVO_LIB_IO_IMPORT_TEXTURE_H

#include <assimp/scene.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "svocl/io.h"

#define TEXTURE_KEEP_ALPHA (-1)

/* What a material asks for. */
typedef struct texture_source {
    const char *name; /* of a file beside the mesh file, or of an image inside */
    const void *bytes; /* the packed image inside the mesh file, where its reader knows it; else NULL */
    size_t byte_count;
    svo_wrap wrap_u, wrap_v;
    int alpha_from; /* texels of at least this alpha (0 .. 256) are opaque, others transparent; or TEXTURE_KEEP_ALPHA */
} texture_source;

/* An image as a material asks for it. Each is decoded and sent once, also where that fails. */
typedef struct texture_entry {
    char *name;
    svo_wrap wrap_u, wrap_v;
    int alpha_from;
    uint32_t index; /* SVO_NO_TEXTURE: it could not be read */
} texture_entry;

typedef struct texture_list {
    const struct aiScene *scene; /* may have images in it; NULL: all are files */
    const char *mesh_path;
    int stream;
    texture_entry *entries;
    size_t entry_count, entry_capacity;
    uint32_t texture_count; /* sent */
} texture_list;

/*
 * The index of the texture that a material names; *index is SVO_NO_TEXTURE if it cannot be read.
 * Sends a new image, or a warning. Returns false when memory runs out or the parent has closed the pipe.
 */
bool svo_i_import_texture(texture_list *textures, const texture_source *source, uint32_t *index);
void svo_i_texture_list_free(texture_list *textures);

#endif
