/* SPDX-License-Identifier: MIT */
/* The folder of a tree's parts: names of files, and the file "plan". */
#define _POSIX_C_SOURCE 200809L
#include "parts/folder.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "core/struct_size.h"
#include "io/file_format.h"
#include "output/output.h"
#include "parts/part_file.h"
#include "svocl/version.h"

#define PLAN_NAME    "plan"
#define PLAN_MAGIC   "\x89SVL\r\n\x1a\n"
#define PLAN_VERSION 4 /* with part files of version 4 */
#define NAME_BYTES   48

/* The front of the file "plan"; entries, materials, sizes of textures and their texels follow. hash: of all bytes after
   itself. */
typedef struct plan_head {
    uint8_t magic[8];
    uint64_t hash;
    uint32_t version;
    uint32_t fields;
    uint64_t file_bytes;
    uint64_t max_bytes;
    uint64_t entry_count, material_count, texture_count;
    uint64_t identity[2];
    svo_part_header header;
} plan_head;

typedef struct plan_texture {
    uint32_t width, height, wrap_u, wrap_v;
} plan_texture;

static_assert(sizeof(plan_head) == 56 + 8 + 16 + sizeof(svo_part_header), "no padding");
static_assert(sizeof(svo_material) == 8 && sizeof(svo_i_part_entry) == 32, "no padding");

char *svo_i_folder_path(const svo_parts *parts, const char *name)
{
    return svo_i_path_join(parts->place, name);
}

char *svo_i_part_path(const svo_parts *parts, uint32_t level, uint64_t code, const char *suffix)
{
    char name[NAME_BYTES];
    (void)snprintf(name, sizeof name, "%u-%llx.%s", level, (unsigned long long)code, suffix);
    return svo_i_path_join(strcmp(suffix, "part") == 0 ? parts->folder : parts->place, name);
}

svo_i_triangles_of svo_i_folder_triangles(const svo_parts *parts, uint32_t level, uint64_t code)
{
    svo_i_triangles_of of = {.code = code, .level = level, .fields = parts->fields};
    svo_i_part_identity(&parts->header, of.plan);
    return of;
}

svo_status svo_i_file_find(const char *path, bool *is_there, svo_message *message)
{
    struct stat found;
    *is_there = stat(path, &found) == 0;
    return *is_there || errno == ENOENT
               ? SVO_OK
               : svo_i_fail(message, svo_i_file_status(errno), "%s: cannot be looked up: %s", path, strerror(errno));
}

svo_status svo_i_folder_no_memory(const svo_parts *parts, svo_message *message)
{
    return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: out of memory", parts->folder);
}

static bool ends_in(const char *name, const char *suffix)
{
    const size_t length = strlen(name);
    return length >= strlen(suffix) && strcmp(name + length - strlen(suffix), suffix) == 0;
}

/* Whether a name is that of the place of a plan. */
static bool is_place(const char *name)
{
    return strlen(name) == IDENTITY_BYTES - 1 && strspn(name, "0123456789abcdef") == IDENTITY_BYTES - 1;
}

/* Files of triangles lay beside parts before plans had places. */
bool svo_i_folder_is_of_other_plans(const char *name, const char *kept)
{
    return (is_place(name) && strcmp(name, kept) != 0) || strcmp(name, "mesh") == 0 || ends_in(name, ".tri") ||
           ends_in(name, ".split");
}

/* Also what killed processes have left, of leases and on file systems without O_TMPFILE. */
static bool is_ours(const char *name)
{
    return strcmp(name, PLAN_NAME) == 0 || svo_i_folder_is_of_other_plans(name, "") || ends_in(name, ".part") ||
           ends_in(name, LEASE_SUFFIX) || svo_i_output_is_temporary(name);
}

svo_status svo_i_folder_add(svo_parts *parts, const svo_i_part_entry *entry, svo_message *message)
{
    if (parts->entry_count == parts->entry_capacity) {
        const size_t capacity = parts->entry_capacity * 2 + 64;
        svo_i_part_entry *grown = svo_i_grow(NULL, parts->entries, capacity * sizeof *grown);
        if (grown == NULL) {
            return svo_i_folder_no_memory(parts, message);
        }
        parts->entries = grown;
        parts->entry_capacity = capacity;
    }
    parts->entries[parts->entry_count++] = *entry;
    return SVO_OK;
}

svo_parts *svo_i_folder_new(const char *folder, uint64_t max_bytes)
{
    svo_parts *parts = svo_i_alloc_zeroed(NULL, 1, sizeof *parts);
    char *copy = svo_i_copy_text(NULL, folder);
    if (parts == NULL || copy == NULL) {
        svo_i_free(parts);
        svo_i_free(copy);
        return NULL;
    }
    parts->folder = copy;
    parts->max_bytes = max_bytes;
    return parts;
}

static void free_parts(svo_parts *parts)
{
    for (size_t i = 0; parts->textures != NULL && i < parts->texture_count; ++i) {
        svo_i_free((void *)parts->textures[i].rgba);
    }
    svo_i_free(parts->textures);
    svo_i_free(parts->materials);
    svo_i_free(parts->entries);
    svo_i_planner_release(&parts->planner);
    svo_i_free(parts->place);
    svo_i_free(parts->folder);
    svo_i_free(parts);
}

/* ---- writing ---- */

/* Hashes bytes, and writes them where output is not NULL. Returns an errno. */
static int put(XXH3_state_t *hash, const svo_i_output *output, const void *bytes, size_t byte_count)
{
    XXH3_64bits_update(hash, bytes, byte_count);
    return output != NULL && byte_count > 0 ? svo_i_output_write(output, bytes, byte_count) : 0;
}

static size_t texel_bytes(const svo_texture *texture)
{
    return (size_t)texture->width * texture->height * 4;
}

/* All that follows the checksum. */
static int put_plan(const svo_parts *parts, const plan_head *head, XXH3_state_t *hash, const svo_i_output *output)
{
    const size_t begin = offsetof(plan_head, version);
    XXH3_INITSTATE(hash);
    XXH3_64bits_reset(hash);
    int error = put(hash, output, (const char *)head + begin, sizeof *head - begin);
    error = error != 0 ? error : put(hash, output, parts->entries, parts->entry_count * sizeof *parts->entries);
    error = error != 0 ? error : put(hash, output, parts->materials, parts->material_count * sizeof *parts->materials);
    for (size_t i = 0; i < parts->texture_count && error == 0; ++i) {
        const svo_texture *from = &parts->textures[i];
        const plan_texture size = {from->width, from->height, (uint32_t)from->wrap_u, (uint32_t)from->wrap_v};
        error = put(hash, output, &size, sizeof size);
    }
    for (size_t i = 0; i < parts->texture_count && error == 0; ++i) {
        error = put(hash, output, parts->textures[i].rgba, texel_bytes(&parts->textures[i]));
    }
    return error;
}

static int write_plan(const svo_parts *parts, plan_head *head, const char *path)
{
    svo_i_output output = {.descriptor = -1};
    XXH3_state_t hash;
    (void)put_plan(parts, head, &hash, NULL);
    head->hash = XXH3_64bits_digest(&hash);
    int error = svo_i_output_open(path, NULL, &output);
    if (error == 0) {
        error = svo_i_output_write(&output, head, offsetof(plan_head, version));
    }
    if (error == 0) {
        error = put_plan(parts, head, &hash, &output);
    }
    if (error == 0) {
        error = svo_i_output_commit_unflushed(&output);
    }
    svo_i_output_abandon(&output);
    return error;
}

svo_status svo_i_folder_save(const svo_parts *parts, const char *path, svo_message *message)
{
    plan_head head = {.version = PLAN_VERSION,
                      .fields = parts->fields,
                      .max_bytes = parts->max_bytes,
                      .entry_count = parts->entry_count,
                      .material_count = parts->material_count,
                      .texture_count = parts->texture_count,
                      .identity = {parts->identity[0], parts->identity[1]},
                      .header = parts->header};
    memcpy(head.magic, PLAN_MAGIC, sizeof head.magic);
    head.file_bytes = sizeof head + parts->entry_count * sizeof *parts->entries +
                      parts->material_count * sizeof *parts->materials + parts->texture_count * sizeof(plan_texture);
    for (size_t i = 0; i < parts->texture_count; ++i) {
        head.file_bytes += texel_bytes(&parts->textures[i]);
    }
    const int error = write_plan(parts, &head, path);
    return error == 0
               ? SVO_OK
               : svo_i_fail(message, svo_i_file_status(error), "%s: cannot be written: %s", path, strerror(error));
}

/* ---- reading ---- */

/* The bytes of "plan" that have not been taken yet. */
typedef struct remainder {
    const unsigned char *at;
    size_t left;
    bool lacks_memory;
} remainder;

/* A copy of the next count elements; NULL: out of memory, or there are not that many. */
static void *take(remainder *from, uint64_t count, size_t element_bytes)
{
    size_t bytes = 0;
    if (!svo_i_mul_size((size_t)count, element_bytes, &bytes) || bytes > from->left) {
        return NULL;
    }
    void *copy = svo_i_alloc(NULL, bytes + 1);
    if (copy != NULL) {
        memcpy(copy, from->at, bytes);
        from->at += bytes;
        from->left -= bytes;
    }
    from->lacks_memory = from->lacks_memory || copy == NULL;
    return copy;
}

static bool take_textures(svo_parts *parts, remainder *from, uint64_t count)
{
    plan_texture *sizes = take(from, count, sizeof *sizes);
    parts->textures = sizes != NULL ? svo_i_alloc_zeroed(NULL, (size_t)count + 1, sizeof *parts->textures) : NULL;
    from->lacks_memory = from->lacks_memory || (sizes != NULL && parts->textures == NULL);
    bool whole = parts->textures != NULL;
    for (size_t i = 0; i < count && whole; ++i) {
        svo_texture *to = &parts->textures[parts->texture_count++];
        *to = (svo_texture){.width = sizes[i].width,
                            .height = sizes[i].height,
                            .wrap_u = (svo_wrap)sizes[i].wrap_u,
                            .wrap_v = (svo_wrap)sizes[i].wrap_v};
        to->rgba = take(from, (uint64_t)to->width * to->height, 4);
        whole = to->rgba != NULL;
    }
    svo_i_free(sizes);
    return whole;
}

/* Takes the front of the file; false: it is not what was written. */
static bool take_head(svo_parts *parts, const unsigned char *bytes, size_t byte_count, plan_head *head)
{
    const size_t begin = offsetof(plan_head, version);
    if (byte_count < sizeof *head) {
        return false;
    }
    memcpy(head, bytes, sizeof *head);
    parts->header = head->header;
    parts->fields = head->fields;
    parts->max_bytes = head->max_bytes;
    memcpy(parts->identity, head->identity, sizeof parts->identity);
    return memcmp(head->magic, PLAN_MAGIC, sizeof head->magic) == 0 && head->version == PLAN_VERSION &&
           head->file_bytes == byte_count && head->hash == XXH3_64bits(bytes + begin, byte_count - begin);
}

/* Identities depend on the version of the library that planned. */
static svo_status check_identity(const svo_parts *parts, const char *path, svo_message *message)
{
    uint64_t own[2];
    svo_i_part_identity(&parts->header, own);
    return memcmp(own, parts->identity, sizeof own) == 0
               ? SVO_OK
               : svo_i_fail(message, SVO_FILE_DAMAGED,
                            "%s: the plan of another version of svocl than %s; planning the parts again writes it",
                            path, SVO_VERSION_STRING);
}

static svo_status take_plan(svo_parts *parts, const char *path, const unsigned char *bytes, size_t byte_count,
                            svo_message *message)
{
    plan_head head = {.version = PLAN_VERSION};
    if (!take_head(parts, bytes, byte_count, &head)) {
        return head.version == PLAN_VERSION
                   ? svo_i_fail(message, SVO_FILE_DAMAGED, "%s: not the plan that was written", path)
                   : svo_i_fail(message, SVO_FILE_DAMAGED,
                                "%s: version %" PRIu32 " is not known, only %d; planning the parts again writes it",
                                path, head.version, PLAN_VERSION);
    }
    SVO_I_TRY(check_identity(parts, path, message));
    remainder from = {bytes + sizeof head, byte_count - sizeof head, false};
    parts->entries = take(&from, head.entry_count, sizeof *parts->entries);
    parts->materials = take(&from, head.material_count, sizeof *parts->materials);
    parts->entry_count = (size_t)head.entry_count;
    parts->material_count = (size_t)head.material_count;
    const bool whole = parts->entries != NULL && parts->materials != NULL &&
                       take_textures(parts, &from, head.texture_count) && from.left == 0;
    if (from.lacks_memory) {
        return svo_i_folder_no_memory(parts, message);
    }
    return whole ? SVO_OK : svo_i_fail(message, SVO_FILE_DAMAGED, "%s: not the plan that was written", path);
}

svo_status svo_i_file_read_all(const char *path, unsigned char **bytes, size_t *byte_count, svo_message *message)
{
    struct stat found;
    const int file = open(path, O_RDONLY | O_CLOEXEC);
    if (file < 0 || fstat(file, &found) != 0) {
        const int error = errno;
        if (file >= 0) {
            (void)close(file);
        }
        return svo_i_fail(message, svo_i_file_status(error), "%s: cannot be opened: %s", path, strerror(error));
    }
    *byte_count = (size_t)found.st_size;
    *bytes = svo_i_alloc(NULL, *byte_count + 1);
    size_t got = 0;
    const int error = *bytes != NULL ? svo_i_read_at(file, 0, *bytes, *byte_count, &got) : 0;
    (void)close(file);
    if (*bytes == NULL) {
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %zu bytes", path, *byte_count);
    }
    return got == *byte_count
               ? SVO_OK
               : svo_i_fail(message, error != 0 ? svo_i_file_status(error) : SVO_FILE_ERROR, "%s: cannot be read: %s",
                            path, error != 0 ? strerror(error) : "it has become shorter");
}

svo_status svo_i_file_read_found(const char *path, unsigned char **bytes, size_t *byte_count, svo_message *message)
{
    bool is_there = false;
    SVO_I_TRY(svo_i_file_find(path, &is_there, message));
    const svo_status status = is_there ? svo_i_file_read_all(path, bytes, byte_count, message) : SVO_OK;
    if (status == SVO_FILE_ERROR && access(path, F_OK) != 0 && errno == ENOENT) {
        return SVO_OK; /* it was removed meanwhile */
    }
    return status;
}

static svo_status open_plan(svo_parts *parts, const char *path, svo_message *message)
{
    unsigned char *bytes = NULL;
    size_t byte_count = 0;
    svo_status status = svo_i_file_read_all(path, &bytes, &byte_count, message);
    if (status == SVO_OK) {
        status = take_plan(parts, path, bytes, byte_count, message);
    }
    svo_i_free(bytes);
    return status;
}

static svo_status find_place(svo_parts *parts, svo_message *message)
{
    svo_i_identity_text name;
    svo_i_identity_write(parts->identity, name);
    parts->place = svo_i_path_join(parts->folder, name);
    return parts->place != NULL ? SVO_OK : svo_i_folder_no_memory(parts, message);
}

svo_status svo_parts_open(const char *folder, svo_parts **out, svo_message *message)
{
    if (folder == NULL || out == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "svo_parts_open: %s is NULL",
                          folder == NULL ? "folder" : "out");
    }
    svo_parts *parts = svo_i_alloc_zeroed(NULL, 1, sizeof *parts);
    char *path = NULL;
    svo_status status = SVO_OK;
    if (parts != NULL) {
        parts->folder = svo_i_copy_text(NULL, folder);
        path = parts->folder != NULL ? svo_i_path_join(folder, PLAN_NAME) : NULL;
    }
    if (path == NULL) {
        status = svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "svo_parts_open: out of memory");
        goto cleanup;
    }
    SVO_I_TRY_CLEANUP(open_plan(parts, path, message));
    SVO_I_TRY_CLEANUP(find_place(parts, message));
    *out = parts;
    parts = NULL;
cleanup:
    svo_i_free(path);
    if (parts != NULL) {
        free_parts(parts);
    }
    return status;
}

/* Reads the front of a folder's plan, and says whether all of it is there. */
static bool read_identity(const char *folder, uint64_t identity[2])
{
    plan_head head = {.version = 0};
    size_t got = 0;
    char *path = svo_i_path_join(folder, PLAN_NAME);
    const int file = path != NULL ? open(path, O_RDONLY | O_CLOEXEC) : -1;
    if (file >= 0) {
        (void)svo_i_read_at(file, 0, &head, sizeof head, &got);
        (void)close(file);
    }
    svo_i_free(path);
    memcpy(identity, head.identity, sizeof head.identity);
    return got == sizeof head && head.version == PLAN_VERSION;
}

/* A plan that cannot be read now is taken for the one that was opened: what is made is checked where it is used. */
svo_status svo_i_folder_is_current(const svo_parts *parts, svo_message *message)
{
    uint64_t found[2];
    svo_i_identity_text own_name, found_name;
    if (!read_identity(parts->folder, found) || memcmp(found, parts->identity, sizeof found) == 0) {
        return SVO_OK;
    }
    svo_i_identity_write(parts->identity, own_name);
    svo_i_identity_write(found, found_name);
    return svo_i_fail(message, SVO_UNAVAILABLE,
                      "%s: planned anew meanwhile: this run belongs to plan %s, the folder's plan is %s", parts->folder,
                      own_name, found_name);
}

svo_status svo_parts_get_identity(const svo_parts *parts, char text[SVO_PARTS_IDENTITY_BYTES], svo_message *message)
{
    if (parts == NULL || text == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "svo_parts_get_identity: %s is NULL",
                          parts == NULL ? "parts" : "text");
    }
    svo_i_identity_write(parts->identity, text);
    return SVO_OK;
}

void svo_parts_close(svo_parts **parts)
{
    if (parts != NULL && *parts != NULL) {
        free_parts(*parts);
        *parts = NULL;
    }
}

size_t svo_parts_count(const svo_parts *parts)
{
    return parts->entry_count;
}

svo_status svo_parts_get_header(const svo_parts *parts, svo_part_header *header, svo_message *message)
{
    return svo_i_struct_write(message, "svo_parts_get_header", "header", &parts->header, header,
                              SVO_I_STRUCT_SIZES(svo_part_header, expected_nodes));
}

/* ---- removing ---- */

/* Only leases and places of plans are folders. */
static int remove_entry(const char *path, const char *name)
{
    const bool is_folder = is_place(name) || ends_in(name, LEASE_SUFFIX);
    return is_folder ? svo_i_path_remove(path) : unlink(path) == 0 || errno == ENOENT ? 0 : errno;
}

/* Removes what is ours in a folder. Returns the errno of the last that failed. */
static int remove_files(const char *folder)
{
    DIR *opened = opendir(folder);
    if (opened == NULL) {
        return errno;
    }
    int last_error = 0;
    const struct dirent *entry = NULL;
    do {
        errno = 0;
        entry = readdir(opened);
        int error = entry == NULL ? errno : 0;
        if (entry != NULL && is_ours(entry->d_name)) {
            char *path = svo_i_path_join(folder, entry->d_name);
            error = path == NULL ? ENOMEM : remove_entry(path, entry->d_name);
            svo_i_free(path);
        }
        last_error = error != 0 ? error : last_error;
    } while (entry != NULL);
    (void)closedir(opened);
    return last_error;
}

svo_status svo_parts_remove(const char *folder, svo_message *message)
{
    if (folder == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "svo_parts_remove: folder is NULL");
    }
    SVO_I_TRY(svo_i_lease_check(folder, message));
    int error = remove_files(folder);
    if (error == 0 && rmdir(folder) != 0 && errno != ENOTEMPTY && errno != EEXIST && errno != ENOENT) {
        error = errno;
    }
    return error == 0
               ? SVO_OK
               : svo_i_fail(message, svo_i_file_status(error), "%s: cannot be emptied: %s", folder, strerror(error));
}
