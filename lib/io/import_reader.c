/* SPDX-License-Identifier: MIT */
/*
 * What the readers of mesh files share, in the import child: files, failures, warnings, counts and numbers as all word
 * and read them, materials, and textures.
 */
#define _POSIX_C_SOURCE 200809L
#include "io/import_reader.h"

#include <assimp/scene.h>
#include <errno.h>
#include <fcntl.h>
#include <float.h>
#include <inttypes.h>
#include <limits.h>
#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/message.h"
#include "io/import_bump.h"

/* Static: a program that links the library may have its own stb_image. */
#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#define STBI_MAX_DIMENSIONS STREAM_TEXTURE_SIDE_MAX
/* The name by which 2.27 defines what it declares by the other. NOLINTNEXTLINE(readability-identifier-naming) */
#define stbi_set_unpremultiply_on_load_thread stbi__unpremultiply_on_load_thread
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_image.h>
#pragma GCC diagnostic pop

/*
 * ---- files ----
 *
 * One that shrinks while it is mapped ends the child with a signal, as a crash does.
 */

const char *svo_i_file_open(const char *path, file_bytes *file)
{
    *file = (file_bytes){.bytes = "", .byte_count = 0};
    const int descriptor = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (descriptor < 0) {
        return strerror(errno);
    }
    struct stat entry;
    const char *trouble = NULL;
    if (fstat(descriptor, &entry) != 0) {
        trouble = strerror(errno);
    } else if (!S_ISREG(entry.st_mode)) {
        trouble = "not a regular file";
    } else if (entry.st_size > 0) {
        void *bytes = mmap(NULL, (size_t)entry.st_size, PROT_READ, MAP_PRIVATE, descriptor, 0);
        if (bytes == MAP_FAILED) {
            trouble = errno == ENOMEM ? "out of memory" : strerror(errno);
        } else {
            *file = (file_bytes){.bytes = bytes, .byte_count = (size_t)entry.st_size};
        }
    }
    close(descriptor);
    return trouble;
}

/* That name as a path, released by free; NULL: no memory. */
static char *file_beside(const char *path, const char *name)
{
    const char *slash = strrchr(path, '/');
    const int is_absolute = name[0] == '/' || name[0] == '\\';
    const size_t folder_bytes = slash == NULL || is_absolute ? 0 : (size_t)(slash - path) + 1;
    const size_t name_bytes = strlen(name) + 1;
    char *joined = malloc(folder_bytes + name_bytes);
    if (joined == NULL) {
        return NULL;
    }
    memcpy(joined, path, folder_bytes);
    memcpy(joined + folder_bytes, name, name_bytes);
    for (char *c = joined + folder_bytes; *c != '\0'; ++c) {
        if (*c == '\\') {
            *c = '/';
        }
    }
    return joined;
}

const char *svo_i_file_open_beside(const char *path, const char *name, file_bytes *file)
{
    char *joined = file_beside(path, name);
    if (joined == NULL) {
        return "out of memory";
    }
    const char *trouble = svo_i_file_open(joined, file);
    free(joined);
    return trouble;
}

int svo_i_file_tell_beside(int stream, const char *path, const char *name)
{
    char *joined = file_beside(path, name);
    const int result = joined != NULL ? svo_i_stream_file(stream, joined) : -1;
    free(joined);
    return result;
}

void svo_i_file_close(file_bytes *file)
{
    if (file->byte_count > 0) {
        munmap((void *)(uintptr_t)file->bytes, file->byte_count);
    }
    *file = (file_bytes){.bytes = "", .byte_count = 0};
}

/* ---- messages, counts and numbers ---- */

svo_status svo_i_read_out_of_memory(const mesh_reader *reader)
{
    return svo_i_fail(reader->message, SVO_OUT_OF_HOST_MEMORY, "out of memory");
}

void svo_i_read_warn(const mesh_reader *reader, const char *format, ...)
{
    svo_message text;
    va_list arguments;
    va_start(arguments, format);
    svo_i_fail_v(&text, SVO_OK, format, arguments);
    va_end(arguments);
    (void)svo_i_stream_frame(reader->stream, STREAM_WARNING, text.text, strlen(text.text));
}

void svo_i_read_count_vertices(const mesh_reader *reader, uint64_t used_count, uint64_t declared_count)
{
    reader->counts->declared_vertices = declared_count;
    reader->counts->used_vertices = used_count;
    if (used_count < declared_count) {
        svo_i_read_warn(reader, "%" PRIu64 " of %" PRIu64 " vertices belong to no face", declared_count - used_count,
                        declared_count);
    }
}

void svo_i_read_count_faces(const mesh_reader *reader, uint64_t left_out_count, uint64_t declared_count)
{
    reader->counts->declared_faces = declared_count;
    reader->counts->read_faces = declared_count - left_out_count;
    if (left_out_count > 0) {
        svo_i_read_warn(reader, "%" PRIu64 " of %" PRIu64 " faces have fewer than 3 corners and are left out",
                        left_out_count, declared_count);
    }
}

svo_status svo_i_read_begin_text(const mesh_reader *reader, text_cursor *cursor)
{
    const char *bytes = reader->bytes;
    const size_t byte_count = reader->byte_count;
    *cursor = (text_cursor){.at = bytes, .end = bytes + byte_count, .line = 1};
    if (text_begins_with(bytes, byte_count, "\xff\xfe") || text_begins_with(bytes, byte_count, "\xfe\xff")) {
        return svo_i_fail(reader->message, SVO_IMPORT_FAILED, "byte 0: UTF-16 text; UTF-8 or ASCII is needed");
    }
    cursor->at += text_begins_with(bytes, byte_count, "\xef\xbb\xbf") ? 3 : 0;
    return SVO_OK;
}

static svo_status no_number(const number_reader *numbers, const text_cursor *cursor)
{
    if (text_at_line_end(cursor)) {
        return svo_i_fail(numbers->reader->message, SVO_IMPORT_FAILED,
                          "line %" PRIu64 ": the line ends where a number is needed", cursor->line);
    }
    return svo_i_fail(numbers->reader->message, SVO_IMPORT_FAILED, "line %" PRIu64 ": '%s' is not a number",
                      cursor->line, text_copy_word(cursor).text);
}

svo_status svo_i_read_float(number_reader *numbers, text_cursor *cursor, float *value)
{
    (void)text_skip_blanks(cursor);
    const char *behind = svo_i_number_float(cursor->at, cursor->end, value);
    if (behind == NULL) {
        return no_number(numbers, cursor);
    }
    const text_cursor word = *cursor;
    cursor->at = behind;
    if (!text_at_word_end(cursor)) {
        if (numbers->odd_count++ == 0) {
            numbers->first_odd = text_copy_word(&word);
            numbers->first_odd_line = cursor->line;
        }
        text_skip_word(cursor);
    }
    return SVO_OK;
}

void svo_i_read_warn_odd(const number_reader *numbers)
{
    if (numbers->odd_count > 0) {
        svo_i_read_warn(numbers->reader,
                        "%" PRIu64
                        " words are numbers only in part, which was read; the first is '%s' in line %" PRIu64,
                        numbers->odd_count, numbers->first_odd.text, numbers->first_odd_line);
    }
}

/* ---- materials ---- */

uint8_t svo_i_import_color_byte(float value)
{
    if (!(value > 0)) {
        return 0;
    }
    return value < 1 ? (uint8_t)(value * 255.0f + 0.5f) : 255;
}

static float tame(float value, float most)
{
    return !isfinite(value) || value < 0 ? 0 : value > most ? most : value;
}

void svo_i_import_tame_finish(svo_finish *finish)
{
    bool shines = false;
    for (int i = 0; i < 3; ++i) {
        finish->emission[i] = tame(finish->emission[i], FLT_MAX);
        finish->specular[i] = tame(finish->specular[i], 1);
        shines = shines || finish->specular[i] > 0;
    }
    finish->exponent = shines ? tame(finish->exponent, FLT_MAX) : 0;
}

/*
 * ---- textures ----
 *
 * Found beside or inside the mesh file, decoded and sent. Images are as untrusted as meshes, so the child decodes them
 * and not the parent.
 */

/* Tells the parent what an image takes: its bytes, of a file of its own or in another, and its texels where it is
   understood. */
static void announce(const texture_list *textures, uint64_t read_bytes, uint64_t packed_bytes, int width, int height)
{
    svo_i_stream_work(textures->stream, textures->work,
                      (stream_work){read_bytes, packed_bytes + (uint64_t)width * (uint64_t)height * 4});
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
    announce(textures, (uint64_t)entry.st_size, 0, *width, *height);
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
    announce(textures, 0, byte_count, *width, *height);
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
    char *path = file_beside(textures->mesh_path, source->name);
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
    if (entry->is_bump) {
        uint8_t *normals =
            svo_i_import_normals_of_bump(pixels, (size_t)width, (size_t)height, entry->wrap_u, entry->wrap_v);
        free(pixels);
        pixels = normals;
        if (pixels == NULL) {
            return svo_i_stream_text(textures->stream, STREAM_WARNING,
                                     "texture %s cannot be read, white is used: out of memory", entry->name);
        }
    }
    const int result = send_pixels(textures->stream, entry, pixels, width, height);
    free(pixels);
    entry->index = textures->texture_count++;
    return result;
}

static bool is_same(const texture_entry *entry, const texture_source *source)
{
    return strcmp(entry->name, source->name) == 0 && entry->wrap_u == source->wrap_u &&
           entry->wrap_v == source->wrap_v && entry->alpha_from == source->alpha_from &&
           entry->is_bump == source->is_bump;
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
                             .is_bump = source->is_bump,
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
