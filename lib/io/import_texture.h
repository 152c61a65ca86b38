/* SPDX-License-Identifier: MIT */
/* The textures an import child has met. */
#ifndef SVO_LIB_IO_IMPORT_TEXTURE_H
#define SVO_LIB_IO_IMPORT_TEXTURE_H

#include <assimp/scene.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "svocl/io.h"

/* One image with its wrapping, found, sent to the parent and numbered; or looked for in vain, once. */
typedef struct texture_entry {
    char *path; /* as the material says it */
    svo_wrap wrap_u, wrap_v;
    uint32_t index; /* SVO_NO_TEXTURE: it cannot be read */
} texture_entry;

typedef struct texture_list {
    const struct aiScene *scene;
    const char *mesh_path;
    int stream;
    texture_entry *entries;
    size_t entry_count, entry_capacity;
    uint32_t texture_count; /* sent */
} texture_list;

/*
 * The number of the texture a material names; *index is SVO_NO_TEXTURE if it cannot be read.
 * Sends the image when it is new, or a warning. Returns false when memory runs out or the parent is gone.
 */
bool svo_i_import_texture(texture_list *textures, const char *path, svo_wrap wrap_u, svo_wrap wrap_v, uint32_t *index);
void svo_i_texture_list_free(texture_list *textures);

#endif
