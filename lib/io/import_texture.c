/* SPDX-License-Identifier: MIT */
/*
 * Textures in the import child: found beside or inside the mesh file, decoded and sent. Images are as untrusted as
 * meshes, so the child decodes them and not the parent.
 */
#define _POSIX_C_SOURCE 200809L
#include "io/import_texture.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "io/import_file.h"
#include "io/import_stream.h"

/* Static: a program that links the library may have its own stb_image. */
#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#define STBI_MAX_DIMENSIONS STREAM_TEXTURE_SIDE_MAX
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_image.h>

/* Pixels from malloc and their size, or NULL and the reason. */
static uint8_t *decode_file(const char *path, int *width, int *height, const char **trouble)
{
    struct stat entry;
    FILE *file = stat(path, &entry) == 0 && S_ISREG(entry.st_mode) ? fopen(path, "rb") : NULL;
    if (file == NULL) {
        *trouble = errno != 0 ? strerror(errno) : "not a regular file";
        return NULL;
    }
    int channels = 0;
    uint8_t *pixels = stbi_load_from_file(file, width, height, &channels, 4);
    (void)fclose(file);
    *trouble = pixels == NULL ? stbi_failure_reason() : NULL;
    return pixels;
}

/* The same for an image inside the mesh file: still packed, or already texels in assimp's order. */
static uint8_t *decode_embedded(const struct aiTexture *texture, int *width, int *height, const char **trouble)
{
    if (texture->mHeight == 0 && texture->mWidth <= INT_MAX) {
        int channels = 0;
        uint8_t *pixels =
            stbi_load_from_memory((const uint8_t *)texture->pcData, (int)texture->mWidth, width, height, &channels, 4);
        *trouble = pixels == NULL ? stbi_failure_reason() : NULL;
        return pixels;
    }
    if (texture->mWidth > STREAM_TEXTURE_SIDE_MAX || texture->mHeight > STREAM_TEXTURE_SIDE_MAX) {
        *trouble = "too large";
        return NULL;
    }
    const size_t texel_count = (size_t)texture->mWidth * texture->mHeight;
    uint8_t *pixels = malloc(4 * texel_count);
    *trouble = "out of memory";
    for (size_t i = 0; pixels != NULL && i < texel_count; ++i) {
        const struct aiTexel *texel = &texture->pcData[i];
        memcpy(pixels + 4 * i, (const uint8_t[]){texel->r, texel->g, texel->b, texel->a}, 4);
    }
    *width = (int)texture->mWidth;
    *height = (int)texture->mHeight;
    return pixels;
}

/* The image inside the mesh file that a material names, by "*" and an index or by file name; NULL: none. */
static const struct aiTexture *find_embedded(const struct aiScene *scene, const char *texture_path)
{
    if (texture_path[0] == '*') {
        const unsigned long index = strtoul(texture_path + 1, NULL, 10);
        return index < scene->mNumTextures ? scene->mTextures[index] : NULL;
    }
    for (unsigned i = 0; i < scene->mNumTextures; ++i) {
        const struct aiString *name = &scene->mTextures[i]->mFilename;
        if (name->length > 0 && strcmp(name->data, texture_path) == 0) {
            return scene->mTextures[i];
        }
    }
    return NULL;
}

static uint8_t *decode(const texture_list *textures, const char *texture_path, int *width, int *height,
                       const char **trouble)
{
    const struct aiTexture *embedded = textures->scene != NULL ? find_embedded(textures->scene, texture_path) : NULL;
    if (embedded != NULL) {
        return decode_embedded(embedded, width, height, trouble);
    }
    char *path = svo_i_file_beside(textures->mesh_path, texture_path);
    if (path == NULL) {
        *trouble = "out of memory";
        return NULL;
    }
    (void)svo_i_stream_file(textures->stream, path); /* without a parent the next frame fails too */
    errno = 0;
    uint8_t *pixels = decode_file(path, width, height, trouble);
    free(path);
    return pixels;
}

static int send_pixels(int stream, const texture_entry *entry, const uint8_t *pixels, int width, int height)
{
    const stream_texture header = {
        .width = (uint32_t)width, .height = (uint32_t)height, .wrap_u = entry->wrap_u, .wrap_v = entry->wrap_v};
    const size_t texel_bytes = (size_t)width * (size_t)height * 4;
    const uint64_t payload_bytes = sizeof header + texel_bytes;
    if (svo_i_stream_begin(stream, STREAM_TEXTURE, payload_bytes) != 0 ||
        svo_i_stream_write(stream, &header, sizeof header) != 0 ||
        svo_i_stream_write(stream, pixels, texel_bytes) != 0) {
        return -1;
    }
    return svo_i_stream_pad(stream, payload_bytes);
}

/* Decodes and sends a new entry's image, or a warning. Returns -1 when the parent is gone. */
static int send_texture(texture_list *textures, texture_entry *entry)
{
    int width = 0, height = 0;
    const char *trouble = NULL;
    uint8_t *pixels = decode(textures, entry->path, &width, &height, &trouble);
    if (pixels == NULL) {
        return svo_i_stream_text(textures->stream, STREAM_WARNING, "texture %s cannot be read, white is used: %s",
                                 entry->path, trouble);
    }
    const int result = send_pixels(textures->stream, entry, pixels, width, height);
    free(pixels);
    entry->index = textures->texture_count++;
    return result;
}

bool svo_i_import_texture(texture_list *textures, const char *path, svo_wrap wrap_u, svo_wrap wrap_v, uint32_t *index)
{
    for (size_t i = 0; i < textures->entry_count; ++i) {
        const texture_entry *entry = &textures->entries[i];
        if (strcmp(entry->path, path) == 0 && entry->wrap_u == wrap_u && entry->wrap_v == wrap_v) {
            *index = entry->index;
            return true;
        }
    }
    if (textures->entry_count == textures->entry_capacity) {
        const size_t capacity = 2 * textures->entry_capacity + 16;
        texture_entry *entries = realloc(textures->entries, capacity * sizeof *entries);
        if (entries == NULL) {
            return false;
        }
        textures->entries = entries;
        textures->entry_capacity = capacity;
    }
    texture_entry *entry = &textures->entries[textures->entry_count];
    *entry = (texture_entry){.path = strdup(path), .wrap_u = wrap_u, .wrap_v = wrap_v, .index = SVO_NO_TEXTURE};
    if (entry->path == NULL) {
        return false;
    }
    ++textures->entry_count;
    const bool sent = send_texture(textures, entry) == 0;
    *index = entry->index;
    return sent;
}

void svo_i_texture_list_free(texture_list *textures)
{
    for (size_t i = 0; i < textures->entry_count; ++i) {
        free(textures->entries[i].path);
    }
    free(textures->entries);
    textures->entries = NULL;
}
