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

/* Tells the parent what an image takes: its bytes, and its texels where it is understood. */
static void announce(const texture_list *textures, uint64_t packed_bytes, int width, int height)
{
    svo_i_stream_work(textures->stream, packed_bytes + (uint64_t)width * (uint64_t)height * 4);
}

/* Pixels from malloc and their size, or NULL and the reason. */
static uint8_t *decode_file(const texture_list *textures, const char *path, int *width, int *height,
                            const char **trouble)
{
    struct stat entry;
    FILE *file = stat(path, &entry) == 0 && S_ISREG(entry.st_mode) ? fopen(path, "rb") : NULL;
    if (file == NULL) {
        *trouble = errno != 0 ? strerror(errno) : "not a regular file";
        return NULL;
    }
    int channels = 0;
    (void)stbi_info_from_file(file, width, height, &channels);
    announce(textures, (uint64_t)entry.st_size, *width, *height);
    uint8_t *pixels = stbi_load_from_file(file, width, height, &channels, 4);
    (void)fclose(file);
    *trouble = pixels == NULL ? stbi_failure_reason() : NULL;
    return pixels;
}

/* The same for a packed image in memory. */
static uint8_t *decode_packed(const texture_list *textures, const void *bytes, size_t byte_count, int *width,
                              int *height, const char **trouble)
{
    int channels = 0;
    if (byte_count > INT_MAX) {
        *trouble = "too large";
        return NULL;
    }
    (void)stbi_info_from_memory(bytes, (int)byte_count, width, height, &channels);
    announce(textures, byte_count, *width, *height);
    uint8_t *pixels = stbi_load_from_memory(bytes, (int)byte_count, width, height, &channels, 4);
    *trouble = pixels == NULL ? stbi_failure_reason() : NULL;
    return pixels;
}

/* The same for an image inside assimp's scene: still packed, or already texels in assimp's order. */
static uint8_t *decode_embedded(const texture_list *textures, const struct aiTexture *texture, int *width, int *height,
                                const char **trouble)
{
    if (texture->mHeight == 0) {
        return decode_packed(textures, texture->pcData, texture->mWidth, width, height, trouble);
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

static uint8_t *decode(const texture_list *textures, const texture_source *source, int *width, int *height,
                       const char **trouble)
{
    if (source->bytes != NULL) {
        return decode_packed(textures, source->bytes, source->byte_count, width, height, trouble);
    }
    const struct aiTexture *embedded = textures->scene != NULL ? find_embedded(textures->scene, source->name) : NULL;
    if (embedded != NULL) {
        return decode_embedded(textures, embedded, width, height, trouble);
    }
    char *path = svo_i_file_beside(textures->mesh_path, source->name);
    if (path == NULL) {
        *trouble = "out of memory";
        return NULL;
    }
    errno = 0;
    uint8_t *pixels = decode_file(textures, path, width, height, trouble);
    free(path);
    return pixels;
}

/* Makes texels opaque or transparent, as their alpha says. */
static void cut_out(uint8_t *pixels, size_t texel_count, int alpha_from)
{
    for (size_t i = 0; i < texel_count; ++i) {
        pixels[4 * i + 3] = pixels[4 * i + 3] >= alpha_from ? 255 : 0;
    }
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
static int send_texture(texture_list *textures, const texture_source *source, texture_entry *entry)
{
    int width = 0, height = 0;
    const char *trouble = NULL;
    const bool is_file =
        source->bytes == NULL && (textures->scene == NULL || find_embedded(textures->scene, source->name) == NULL);
    if (is_file && svo_i_file_tell_beside(textures->stream, textures->mesh_path, source->name) != 0) {
        return -1;
    }
    uint8_t *pixels = decode(textures, source, &width, &height, &trouble);
    if (pixels == NULL) {
        return svo_i_stream_text(textures->stream, STREAM_WARNING, "texture %s cannot be read, white is used: %s",
                                 entry->name, trouble);
    }
    if (entry->alpha_from != TEXTURE_KEEP_ALPHA) {
        cut_out(pixels, (size_t)width * (size_t)height, entry->alpha_from);
    }
    const int result = send_pixels(textures->stream, entry, pixels, width, height);
    free(pixels);
    entry->index = textures->texture_count++;
    return result;
}

static bool is_same(const texture_entry *entry, const texture_source *source)
{
    return strcmp(entry->name, source->name) == 0 && entry->wrap_u == source->wrap_u &&
           entry->wrap_v == source->wrap_v && entry->alpha_from == source->alpha_from;
}

bool svo_i_import_texture(texture_list *textures, const texture_source *source, uint32_t *index)
{
    for (size_t i = 0; i < textures->entry_count; ++i) {
        if (is_same(&textures->entries[i], source)) {
            *index = textures->entries[i].index;
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
    *entry = (texture_entry){.name = strdup(source->name),
                             .wrap_u = source->wrap_u,
                             .wrap_v = source->wrap_v,
                             .alpha_from = source->alpha_from,
                             .index = SVO_NO_TEXTURE};
    if (entry->name == NULL) {
        return false;
    }
    ++textures->entry_count;
    const bool sent = send_texture(textures, source, entry) == 0;
    *index = entry->index;
    return sent;
}

void svo_i_texture_list_free(texture_list *textures)
{
    for (size_t i = 0; i < textures->entry_count; ++i) {
        free(textures->entries[i].name);
    }
    free(textures->entries);
    textures->entries = NULL;
}
