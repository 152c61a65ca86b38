/* SPDX-License-Identifier: MIT */
/*
 * Builds the parts of a folder, and divides those that are too large. What is done shows in the folder alone, so any
 * process can go on: a part has a .part file, or a .split file and then its children are built in its place, those that
 * have triangles.
 */
#define _POSIX_C_SOURCE 200809L
#include "parts/job.h"

#include <errno.h>
#include <fcntl.h>
#include <stddef.h>
#include <string.h>
#include <unistd.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "core/device.h"
#include "core/struct_size.h"
#include "io/file_format.h"
#include "output/output.h"
#include "parts/cut.h"
#include "parts/part_file.h"
#include "parts/planning.h"
#include "parts/triangles.h"

/*
 * ---- dividing ----
 *
 * A .split file has the numbers of triangles of the eight children, what the part is of, and the checksum of both.
 */

typedef struct split_file {
    uint64_t counts[8];
    svo_i_triangles_of of;
    uint64_t hash;
} split_file;

/* Divides a part's triangles among files of its children. counts: receives how many each child has. */
static svo_status divide_part(const svo_parts *parts, uint32_t level, uint64_t code, uint64_t counts[8],
                              svo_message *message)
{
    char *paths[8] = {NULL};
    char *path = svo_i_part_path(parts, level, code, "tri");
    const svo_i_triangles_of of = svo_i_folder_triangles(parts, level, code);
    bool whole = path != NULL;
    svo_status status = SVO_OK;
    for (unsigned octant = 0; octant < 8; ++octant) {
        paths[octant] = svo_i_part_path(parts, level + 1, code << 3 | octant, "tri");
        whole = whole && paths[octant] != NULL;
    }
    status = whole ? svo_i_triangles_split(&parts->header, &of, path, paths, counts, message)
                   : svo_i_folder_no_memory(parts, message);
    for (unsigned octant = 0; octant < 8; ++octant) {
        svo_i_free(paths[octant]);
    }
    svo_i_free(path);
    return status;
}

static uint64_t hash_of(const split_file *content)
{
    return XXH3_64bits(content, offsetof(split_file, hash));
}

/* Notes in a .split file that the children of a part stand for it. */
static svo_status save_split(const svo_parts *parts, uint32_t level, uint64_t code, const uint64_t counts[8],
                             svo_message *message)
{
    split_file content = {.of = svo_i_folder_triangles(parts, level, code)};
    memcpy(content.counts, counts, sizeof content.counts);
    content.hash = hash_of(&content);
    char *path = svo_i_part_path(parts, level, code, "split");
    if (path == NULL) {
        return svo_i_folder_no_memory(parts, message);
    }
    svo_i_output output = {.descriptor = -1};
    int error = svo_i_output_open(path, NULL, &output);
    if (error == 0) {
        error = svo_i_output_write(&output, &content, sizeof content);
    }
    if (error == 0) {
        error = svo_i_output_commit_unflushed(&output);
    }
    svo_i_output_abandon(&output);
    const svo_status status =
        error == 0 ? SVO_OK
                   : svo_i_fail(message, svo_i_file_status(error), "%s: cannot be written: %s", path, strerror(error));
    svo_i_free(path);
    return status;
}

/* Reads the file; its bytes may be fewer. Returns an errno. */
static int read_split(const char *path, split_file *content, size_t *byte_count)
{
    const int file = open(path, O_RDONLY | O_CLOEXEC);
    if (file < 0) {
        return errno;
    }
    const int error = svo_i_read_at(file, 0, content, sizeof *content, byte_count);
    (void)close(file);
    return error;
}

/* Whether there is such a file. A damaged one, or one of another plan or part, counts as none, since the part can be
   divided again; the message says whose it is. */
static svo_status find_split(const svo_parts *parts, uint32_t level, uint64_t code, bool *is_split, uint64_t counts[8],
                             svo_message *message)
{
    const svo_i_triangles_of of = svo_i_folder_triangles(parts, level, code);
    split_file content;
    size_t byte_count = 0;
    char *path = svo_i_part_path(parts, level, code, "split");
    if (path == NULL) {
        return svo_i_folder_no_memory(parts, message);
    }
    const int error = read_split(path, &content, &byte_count);
    *is_split = error == 0 && byte_count == sizeof content && content.hash == hash_of(&content) &&
                memcmp(&content.of, &of, sizeof of) == 0;
    if (error == 0 && byte_count == sizeof content && memcmp(content.of.plan, of.plan, sizeof of.plan) != 0) {
        (void)svo_i_part_is_foreign(path, content.of.plan, of.plan, "", message);
    }
    if (*is_split) {
        memcpy(counts, content.counts, sizeof content.counts);
    }
    const svo_status status =
        error == 0 || error == ENOENT
            ? SVO_OK
            : svo_i_fail(message, svo_i_file_status(error), "%s: cannot be read: %s", path, strerror(error));
    svo_i_free(path);
    return status;
}

/* ---- building ---- */

/* A failure of the device with its message. */
static svo_status fail_device(const svo_device *device, svo_status status, svo_message *message)
{
    return svo_i_fail(message, status, "%s", svo_device_message(device));
}

/* ---- planning ---- */

static svo_status plan_soup(const svo_parts *parts, svo_device *device, uint32_t level, uint64_t code, svo_i_soup *soup,
                            svo_plan **plan)
{
    svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
    options.part_header = &parts->header;
    options.part_level = level;
    options.part_code = code;
    options.part_triangles = soup->names;
    soup->mesh.materials = parts->material_count > 0 ? parts->materials : NULL;
    soup->mesh.material_count = parts->material_count;
    soup->mesh.textures = parts->texture_count > 0 ? parts->textures : NULL;
    soup->mesh.texture_count = parts->texture_count;
    return svo_plan_create(device, &soup->mesh, parts->header.depth, &options, plan);
}

/* Plans a part from its triangles. *expected_bytes: of the buffers and the host's memory of its build. */
static svo_status plan_of_part(const svo_parts *parts, svo_device *device, uint32_t level, uint64_t code,
                               svo_plan **plan, uint64_t *expected_bytes, svo_message *message)
{
    svo_i_soup soup = {.names = NULL};
    svo_plan_info info = SVO_PLAN_INFO_INIT;
    svo_status status = SVO_OK;
    const svo_i_triangles_of of = svo_i_folder_triangles(parts, level, code);
    char *path = svo_i_part_path(parts, level, code, "tri");
    if (path == NULL) {
        return svo_i_folder_no_memory(parts, message);
    }
    SVO_I_TRY_CLEANUP(svo_i_triangles_load(path, &of, &soup, message));
    status = plan_soup(parts, device, level, code, &soup, plan);
    if (status != SVO_OK) {
        status = fail_device(device, status, message);
        goto cleanup;
    }
    (void)svo_plan_get_info(*plan, &info);
    *expected_bytes = info.peak_bytes + svo_i_parts_host_bytes(parts, soup.mesh.triangle_count);
cleanup:
    svo_i_soup_free(&soup);
    svo_i_free(path);
    return status;
}

/* ---- dividing until parts fit ---- */

typedef struct planner {
    svo_parts *parts;
    svo_device *device;
    svo_message *message;
} planner;

/* Whether a part of so many triangles fits, and what it is expected to take. */
static svo_status fits(const planner *p, uint32_t level, uint64_t code, uint64_t triangles, bool *fit, uint64_t *bytes)
{
    svo_plan *plan = NULL;
    *bytes = svo_i_parts_least_bytes(p->parts, triangles);
    *fit = *bytes <= p->parts->max_bytes && level >= svo_i_cut_first_level(&p->parts->header);
    if (!*fit) {
        return SVO_OK; /* too large by its triangles or its levels alone, so it is not planned */
    }
    const svo_status status = plan_of_part(p->parts, p->device, level, code, &plan, bytes, p->message);
    svo_plan_destroy(&plan);
    *fit = *bytes <= p->parts->max_bytes;
    return status;
}

static svo_status plan_part(const planner *p, uint32_t level, uint64_t code, uint64_t triangles);

static svo_status plan_children(const planner *p, uint32_t level, uint64_t code)
{
    uint64_t counts[8];
    if (level + 1 >= p->parts->header.depth) {
        return svo_i_cut_refuse_limit(p->parts, p->message);
    }
    SVO_I_TRY(divide_part(p->parts, level, code, counts, p->message));
    char *path = svo_i_part_path(p->parts, level, code, "tri");
    if (path == NULL) {
        return svo_i_folder_no_memory(p->parts, p->message);
    }
    (void)unlink(path); /* its children have its triangles */
    svo_i_free(path);
    for (uint64_t octant = 0; octant < 8; ++octant) {
        SVO_I_TRY(plan_part(p, level + 1, code << 3 | octant, counts[octant]));
    }
    return SVO_OK;
}

static svo_status plan_part(const planner *p, uint32_t level, uint64_t code, uint64_t triangles)
{
    bool fit = false;
    svo_i_part_entry entry = {.level = level, .code = code, .triangles = triangles};
    if (triangles == 0) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_planning_renew(p->parts, p->message));
    SVO_I_TRY(fits(p, level, code, triangles, &fit, &entry.expected_bytes));
    return fit ? svo_i_folder_add(p->parts, &entry, p->message) : plan_children(p, level, code);
}

svo_status svo_i_parts_divide(svo_parts *parts, const svo_i_cut *cut, svo_device *device, svo_message *message)
{
    const planner p = {parts, device, message};
    for (size_t i = 0; i < cut->count; ++i) {
        const svo_i_part_entry *entry = &cut->parts[i].entry;
        SVO_I_TRY(cut->parts[i].fits ? svo_i_folder_add(parts, entry, message)
                                     : plan_part(&p, entry->level, entry->code, entry->triangles));
    }
    return SVO_OK;
}

/* ---- what is there ---- */

/* How a part's file stands. */
typedef enum standing { PART_MISSING, PART_WHOLE, PART_SPLIT, PART_WRONG } standing;

static svo_status find_file(const svo_parts *parts, uint32_t level, uint64_t code, const char *suffix, bool *is_there,
                            svo_message *message)
{
    char *path = svo_i_part_path(parts, level, code, suffix);
    const svo_status status =
        path != NULL ? svo_i_file_find(path, is_there, message) : svo_i_folder_no_memory(parts, message);
    svo_i_free(path);
    return status;
}

/* Whether a part's file is whole; the message says why not. */
static svo_status check_file(const svo_parts *parts, uint32_t level, uint64_t code, bool reads_all, bool *is_whole,
                             svo_message *message)
{
    svo_part_info info;
    char *path = svo_i_part_path(parts, level, code, "part");
    if (path == NULL) {
        return svo_i_folder_no_memory(parts, message);
    }
    const svo_status status = svo_i_part_check(&parts->header, path, reads_all, &info, message);
    *is_whole = status == SVO_OK && info.level == level && info.code == code;
    if (status == SVO_OK && !*is_whole) {
        (void)svo_i_fail(message, SVO_FILE_DAMAGED, "%s: the part of another place", path);
    }
    svo_i_free(path);
    return status == SVO_FILE_DAMAGED ? SVO_OK : status;
}

/* A look at the parts that stand for one of the list: itself, or those that it was split into. */
typedef struct tour {
    const svo_parts *parts;
    svo_status (*visit)(void *user, uint32_t level, uint64_t code, standing found);
    void *user;
    svo_message *message;
    bool reads_all; /* every byte of the files, not the heads alone */
} tour;

/* counts: of the children's triangles where it is split. */
static svo_status find_standing(const tour *t, uint32_t level, uint64_t code, standing *found, uint64_t counts[8])
{
    bool is_there = false;
    bool is_whole = false;
    SVO_I_TRY(find_file(t->parts, level, code, "part", &is_there, t->message));
    if (is_there) {
        SVO_I_TRY(check_file(t->parts, level, code, t->reads_all, &is_whole, t->message));
        *found = is_whole ? PART_WHOLE : PART_WRONG;
        return SVO_OK;
    }
    SVO_I_TRY(find_split(t->parts, level, code, &is_there, counts, t->message));
    *found = is_there ? PART_SPLIT : PART_MISSING;
    return SVO_OK;
}

static svo_status visit_part(const tour *t, uint32_t level, uint64_t code)
{
    standing found = PART_MISSING;
    uint64_t counts[8];
    SVO_I_TRY(find_standing(t, level, code, &found, counts));
    if (found != PART_SPLIT) {
        return t->visit(t->user, level, code, found);
    }
    for (uint64_t octant = 0; octant < 8; ++octant) {
        if (counts[octant] > 0) {
            SVO_I_TRY(visit_part(t, level + 1, code << 3 | octant));
        }
    }
    return SVO_OK;
}

static svo_status check_index(const svo_parts *parts, const char *function, size_t index, svo_message *message)
{
    if (parts == NULL || index >= parts->entry_count) {
        return parts == NULL ? svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: parts is NULL", function)
                             : svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: index %zu is not below %zu", function,
                                          index, parts->entry_count);
    }
    return SVO_OK;
}

static svo_status note_missing(void *user, uint32_t level, uint64_t code, standing found)
{
    int *is_built = user;
    (void)level;
    (void)code;
    *is_built = *is_built != 0 && found == PART_WHOLE ? 1 : 0;
    return SVO_OK;
}

svo_status svo_parts_is_built(const svo_parts *parts, size_t index, int *is_built, svo_message *message)
{
    static const char function[] = "svo_parts_is_built";
    SVO_I_TRY(check_index(parts, function, index, message));
    if (is_built == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: is_built is NULL", function);
    }
    *is_built = 1;
    svo_i_message_set(message, "%s", "");
    const tour t = {parts, note_missing, is_built, message, true};
    return visit_part(&t, parts->entries[index].level, parts->entries[index].code);
}

svo_status svo_parts_get(const svo_parts *parts, size_t index, svo_parts_entry *entry, svo_message *message)
{
    static const char function[] = "svo_parts_get";
    SVO_I_TRY(check_index(parts, function, index, message));
    const svo_i_part_entry *from = &parts->entries[index];
    const svo_parts_entry made = {
        .level = from->level, .code = from->code, .triangles = from->triangles, .expected_bytes = from->expected_bytes};
    return svo_i_struct_write(message, function, "entry", &made, entry,
                              SVO_I_STRUCT_SIZES(svo_parts_entry, expected_bytes));
}

/* ---- building ---- */

typedef struct builder {
    const svo_parts *parts;
    svo_device *device;
    svo_frontend *frontend;
    cl_command_queue queue;
    svo_message *message;
    uint32_t listed_level; /* of the part of the list that is built, which has triangles of its own */
} builder;

static svo_status save_tree(const builder *b, svo_tree *tree, uint32_t level, uint64_t code)
{
    svo_status status = svo_tree_download(tree, b->queue);
    if (status != SVO_OK) {
        return fail_device(b->device, status, b->message);
    }
    SVO_I_TRY(svo_i_folder_is_current(b->parts, b->message));
    char *path = svo_i_part_path(b->parts, level, code, "part");
    if (path == NULL) {
        return svo_i_folder_no_memory(b->parts, b->message);
    }
    status = svo_part_save(tree, path, b->message);
    svo_i_free(path);
    return status;
}

/* Whether a build failed for lack of memory, so that a smaller part may succeed. */
static bool lacks_memory(svo_status status)
{
    return status == SVO_OUT_OF_DEVICE_MEMORY || status == SVO_OUT_OF_HOST_MEMORY;
}

/* Makes the triangles of a part anew by splitting the part of the list once more, and those in between. */
static svo_status restore_triangles(const builder *b, uint32_t level, uint64_t code)
{
    uint64_t counts[8];
    for (uint32_t above = level - b->listed_level; above > 0; --above) {
        SVO_I_TRY(divide_part(b->parts, level - above, code >> 3 * above, counts, b->message));
    }
    return SVO_OK;
}

/* Plans one part. A worker without the folder sends parts alone, so a part that it split may have no triangles here. */
static svo_status plan_one(const builder *b, uint32_t level, uint64_t code, svo_plan **plan, uint64_t *expected_bytes)
{
    const svo_status status = plan_of_part(b->parts, b->device, level, code, plan, expected_bytes, b->message);
    const bool lacks_triangles = status == SVO_FILE_ERROR || status == SVO_FILE_DAMAGED;
    if (!lacks_triangles || level == b->listed_level) {
        return status;
    }
    SVO_I_TRY(restore_triangles(b, level, code));
    return plan_of_part(b->parts, b->device, level, code, plan, expected_bytes, b->message);
}

/* Builds one part in one piece. *too_large: it is expected to take, or took, more memory than there is. */
static svo_status build_one(const builder *b, uint32_t level, uint64_t code, bool *too_large)
{
    svo_plan *plan = NULL;
    svo_tree *tree = NULL;
    uint64_t expected_bytes = 0;
    svo_status status = plan_one(b, level, code, &plan, &expected_bytes);
    *too_large = lacks_memory(status) || (status == SVO_OK && expected_bytes > b->parts->max_bytes);
    if (status != SVO_OK || *too_large) {
        goto cleanup;
    }
    status = svo_build(plan, b->frontend, b->queue, &tree, NULL);
    if (status != SVO_OK) {
        *too_large = lacks_memory(status);
        status = fail_device(b->device, status, b->message);
        goto cleanup;
    }
    svo_plan_destroy(&plan);
    status = save_tree(b, tree, level, code);
cleanup:
    svo_tree_destroy(&tree);
    svo_plan_destroy(&plan);
    return status;
}

static svo_status build_visited(void *user, uint32_t level, uint64_t code, standing found);

/* Builds what stands for a part and is missing or damaged. */
static svo_status build_at(builder *b, uint32_t level, uint64_t code)
{
    const tour t = {b->parts, build_visited, b, b->message, true};
    return visit_part(&t, level, code);
}

static svo_status build_visited(void *user, uint32_t level, uint64_t code, standing found)
{
    builder *b = user;
    bool too_large = false;
    if (found == PART_WHOLE) {
        return SVO_OK;
    }
    const svo_status status = build_one(b, level, code, &too_large);
    if (!too_large) {
        return status;
    }
    if (level + 1 >= b->parts->header.depth) {
        return status != SVO_OK ? status
                                : svo_i_fail(b->message, SVO_CAPACITY_EXCEEDED,
                                             "svo_parts_build: max_bytes %llu is too small for the least part",
                                             (unsigned long long)b->parts->max_bytes);
    }
    uint64_t counts[8];
    SVO_I_TRY(divide_part(b->parts, level, code, counts, b->message));
    SVO_I_TRY(save_split(b->parts, level, code, counts, b->message));
    return build_at(b, level, code);
}

svo_status svo_i_parts_tell_cause(const svo_parts *parts, svo_status status, svo_message *message)
{
    if (status == SVO_FILE_ERROR || status == SVO_FILE_DAMAGED) {
        SVO_I_TRY(svo_i_folder_is_current(parts, message));
    }
    return status;
}

svo_status svo_parts_build(const svo_parts *parts, size_t index, svo_device *device, svo_frontend *frontend,
                           cl_command_queue queue, svo_message *message)
{
    static const char function[] = "svo_parts_build";
    SVO_I_TRY(check_index(parts, function, index, message));
    if (device == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: device is NULL", function);
    }
    const svo_i_part_entry *listed = &parts->entries[index];
    builder b = {parts, device, frontend, queue, message, listed->level};
    SVO_I_TRY(svo_i_folder_is_current(parts, message));
    const svo_status status = svo_i_device_check_compiler(device, function);
    if (status != SVO_OK) {
        return fail_device(device, status, message); /* no smaller part would succeed */
    }
    return svo_i_parts_tell_cause(parts, build_at(&b, listed->level, listed->code), message);
}

/* ---- stitching ---- */

/* A look for the files of all parts. */
typedef struct gathering {
    const svo_parts *parts;
    svo_i_part_files *files;
    svo_message *message;
} gathering;

static svo_status gather_path(void *user, uint32_t level, uint64_t code, standing found)
{
    const gathering *g = user;
    svo_i_part_files *files = g->files;
    if (found == PART_MISSING) {
        return svo_i_fail(g->message, SVO_FILE_ERROR, "%s: the part %u-%llx is missing", g->parts->folder, level,
                          (unsigned long long)code);
    }
    if (found == PART_WRONG) {
        return SVO_FILE_DAMAGED; /* the message says why */
    }
    if (files->count == files->capacity) {
        const size_t capacity = files->capacity * 2 + 64;
        char **grown = svo_i_grow(NULL, files->paths, capacity * sizeof *grown);
        if (grown == NULL) {
            return svo_i_folder_no_memory(g->parts, g->message);
        }
        files->paths = grown;
        files->capacity = capacity;
    }
    char *path = svo_i_part_path(g->parts, level, code, "part");
    if (path == NULL) {
        return svo_i_folder_no_memory(g->parts, g->message);
    }
    files->paths[files->count++] = path;
    return SVO_OK;
}

svo_status svo_i_parts_gather(const svo_parts *parts, svo_i_part_files *files, svo_message *message)
{
    gathering g = {parts, files, message};
    const tour t = {parts, gather_path, &g, message, false}; /* the stitcher reads all of them */
    for (size_t i = 0; i < parts->entry_count; ++i) {
        SVO_I_TRY(visit_part(&t, parts->entries[i].level, parts->entries[i].code));
    }
    if ((parts->header.need & SVO_NEED_RAYS) != 0) {
        files->mesh = svo_i_folder_path(parts, "mesh");
        return files->mesh != NULL ? SVO_OK : svo_i_folder_no_memory(parts, message);
    }
    return SVO_OK;
}

void svo_i_part_files_free(svo_i_part_files *files)
{
    for (size_t i = 0; i < files->count; ++i) {
        svo_i_free(files->paths[i]);
    }
    svo_i_free(files->paths);
    svo_i_free(files->mesh);
}

svo_status svo_parts_finish(const svo_parts *parts, const char *path, svo_message *message)
{
    svo_i_part_files files = {.paths = NULL};
    if (parts == NULL || path == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "svo_parts_finish: %s is NULL",
                          parts == NULL ? "parts" : "path");
    }
    svo_status status = svo_i_parts_gather(parts, &files, message);
    if (status == SVO_OK) {
        status =
            svo_parts_stitch(&parts->header, (const char *const *)files.paths, files.count, files.mesh, path, message);
    }
    svo_i_part_files_free(&files);
    return svo_i_parts_tell_cause(parts, status, message);
}
