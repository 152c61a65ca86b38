/* SPDX-License-Identifier: MIT */
/* Reads meshes, voxels and trees, generates scenes, and counts the triangles that will be refused. */
#define _DEFAULT_SOURCE /* mkstemps */
#include "support/input.h"

#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "support/cleanup.h"
#include "support/options_parse.h"
#include "support/output.h"
#include "support/parts_input.h"
#include "support/session.h"

/* ---- temporary files ---- */

int spool_open(program *state, const char *suffix, spool_file *spool)
{
    const char *folder = getenv("TMPDIR");
    *spool = (spool_file){.target = {.descriptor = -1}};
    const int length = snprintf(spool->path, sizeof spool->path, "%s/svocl-XXXXXX%s",
                                folder != NULL && folder[0] != '\0' ? folder : "/tmp", suffix);
    if (length < 0 || (size_t)length >= sizeof spool->path) {
        return program_fail(state, PROGRAM_FAILED, "TMPDIR is too long a path");
    }
    cleanup_add(&spool->entry);
    const svo_i_output_watch *watch = &spool->entry.watch;
    watch->hold(watch->user);
    spool->target.descriptor = mkstemps(spool->path, (int)strlen(suffix));
    const int error = errno;
    watch->release(watch->user, spool->target.descriptor >= 0 ? spool->path : NULL);
    if (spool->target.descriptor < 0) {
        cleanup_remove(&spool->entry);
        return program_fail(state, PROGRAM_FAILED, "a temporary file in %s: %s",
                            folder != NULL && folder[0] != '\0' ? folder : "/tmp", strerror(error));
    }
    return PROGRAM_DONE;
}

static int spool_write(program *state, spool_file *spool, const void *bytes, size_t byte_count)
{
    const int error = svo_i_output_write(&spool->target, bytes, byte_count);
    return error == 0 ? PROGRAM_DONE : program_fail(state, PROGRAM_FAILED, "%s: %s", spool->path, strerror(error));
}

void spool_remove(spool_file *spool)
{
    const svo_i_output_watch *watch = &spool->entry.watch;
    svo_i_output_abandon(&spool->target);
    watch->hold(watch->user);
    (void)unlink(spool->path);
    watch->release(watch->user, NULL);
    cleanup_remove(&spool->entry);
}

/* ---- compact trees: expanded on a device that is open meanwhile, they leave it as the bytes of a .svo file, since the
   command may open another device, or none ---- */

typedef struct byte_list {
    unsigned char *bytes;
    size_t count, capacity;
} byte_list;

static int append(void *user, const void *bytes, size_t byte_count)
{
    byte_list *list = user;
    if (byte_count > list->capacity - list->count) {
        const size_t capacity = 2 * list->capacity + byte_count;
        unsigned char *larger = realloc(list->bytes, capacity);
        if (larger == NULL) {
            return 1;
        }
        list->bytes = larger;
        list->capacity = capacity;
    }
    memcpy(list->bytes + list->count, bytes, byte_count);
    list->count += byte_count;
    return 0;
}

bool compact_input_is_name(const char *name)
{
    const size_t length = strlen(name);
    return strncmp(name, "scene:", 6) != 0 && length >= 4 && strcasecmp(name + length - 4, ".svc") == 0;
}

/* Writes the expanded tree to a list. */
static int expand(program *state, const session *opened, svo_compact *compact, byte_list *list)
{
    svo_tree *tree = NULL;
    svo_message message = {""};
    int exit_code = PROGRAM_DONE;
    if (svo_compact_upload(compact, opened->device, opened->queue) != SVO_OK ||
        svo_compact_expand(compact, opened->queue, &tree) != SVO_OK ||
        svo_tree_download(tree, opened->queue) != SVO_OK) {
        exit_code = program_fail_library(state, svo_device_message(opened->device));
    } else if (svo_tree_save(tree, svo_to_callback(append, list), NULL, &message) != SVO_OK) {
        exit_code = program_fail_library(state, message.text);
    }
    svo_tree_destroy(&tree);
    return exit_code;
}

int compact_input_load(program *state, svo_source source, svo_compact **out)
{
    svo_message message = {""};
    const svo_load_options load_options = {.struct_size = sizeof load_options, .voxels_max = state->options.max_voxels};
    return svo_compact_load(source, &load_options, out, &message) == SVO_OK ? PROGRAM_DONE
                                                                            : program_fail_library(state, message.text);
}

/* The nodes of the expanded tree: those of a level, and those inside the leaves above it. */
static double count_nodes(const svo_compact *compact)
{
    svo_compact_info info = SVO_COMPACT_INFO_INIT;
    double nodes = 0.0, inside = 0.0;
    (void)svo_compact_get_info(compact, &info);
    for (uint32_t level = 0; level <= info.depth; ++level) {
        nodes += (double)info.level_inner[level] + (double)info.level_leaf[level] + inside;
        inside = 8.0 * (inside + (double)info.level_leaf[level]);
    }
    return nodes;
}

/* Expands and destroys a compact tree. *out has host arrays and is on no device; name stands
   for its file in messages. Returns the exit code. */
static int compact_input_expand(program *state, const char *name, svo_compact **compact, svo_tree **out)
{
    session opened = {0};
    byte_list list = {NULL, 0, 0};
    svo_message message = {""};
    const double limit = (double)state->options.max_voxels;
    int exit_code =
        limit > 0.0 && count_nodes(*compact) > limit
            ? program_fail(state, PROGRAM_FAILED, "%s: %.0f voxels are above the limit of %.0f (--max-voxels)", name,
                           count_nodes(*compact), limit)
            : session_open_device(state, &opened);
    if (exit_code == PROGRAM_DONE) {
        exit_code = expand(state, &opened, *compact, &list);
    }
    svo_compact_destroy(compact);
    session_close(&opened);
    if (exit_code == PROGRAM_DONE &&
        svo_tree_load(svo_from_memory(list.bytes, list.count, name), NULL, out, &message) != SVO_OK) {
        exit_code = program_fail_library(state, message.text);
    }
    free(list.bytes);
    return exit_code;
}

/* ---- inputs ---- */

#define PATH_BYTES 4096

static double clock_ms(clockid_t clock)
{
    struct timespec now;
    clock_gettime(clock, &now);
    return (double)now.tv_sec * 1e3 + (double)now.tv_nsec * 1e-6;
}

double input_now_ms(void)
{
    return clock_ms(CLOCK_MONOTONIC);
}

double input_cpu_ms(void)
{
    return clock_ms(CLOCK_PROCESS_CPUTIME_ID);
}

int input_begin(program *state)
{
    options *given = &state->options;
    piped_input *piped = &state->piped;
    if (given->input == NULL || strncmp(given->input, "scene:", 6) == 0 || !piped_is_stream(given->input)) {
        return PROGRAM_DONE;
    }
    const int error = piped_read(given->input, piped);
    given->input = piped->name;
    if (error != 0) {
        return program_fail(state, PROGRAM_FAILED, "%s: %s", piped->name, strerror(error));
    }
    const char *reason = piped_judge(piped);
    return reason == NULL ? PROGRAM_DONE : program_fail(state, PROGRAM_FAILED, "%s: %s", piped->name, reason);
}

/* The name that tells the format. */
static const char *name_of_format(const program *state)
{
    return piped_is(&state->piped, state->options.input) ? state->piped.suffix : state->options.input;
}

bool input_is_compact(const program *state)
{
    return compact_input_is_name(name_of_format(state));
}

bool input_is_parts(const program *state)
{
    const char *name = state->options.input;
    return !piped_is(&state->piped, name) && strncmp(name, "scene:", 6) != 0 && parts_input_is_name(name);
}

bool input_is_tree(const program *state)
{
    const char *name = name_of_format(state);
    const size_t length = strlen(name);
    return input_is_compact(state) || input_is_parts(state) ||
           (strncmp(name, "scene:", 6) != 0 && length >= 4 && strcasecmp(name + length - 4, ".svo") == 0);
}

bool input_is_mesh_file(const program *state)
{
    return !piped_is(&state->piped, state->options.input) && strncmp(state->options.input, "scene:", 6) != 0 &&
           !input_is_tree(state) && !voxel_input_is_given(state);
}

static int refuse_voxel_options(program *state)
{
    return (state->options.given_groups & (unsigned)OPTION_VOXELS) == 0
               ? PROGRAM_DONE
               : program_fail(state, PROGRAM_WRONG_USAGE, "%s applies to %s, not to %s",
                              state->options.counts != 0   ? "--counts"
                              : state->options.hidden != 0 ? "--hidden"
                                                           : "--frame",
                              state->options.counts != 0 ? "point clouds" : "voxel files", state->options.input);
}

int input_refuse_build_options(program *state)
{
    if ((state->options.given_groups & (unsigned)OPTION_BUILD) == 0) {
        return refuse_voxel_options(state);
    }
    return program_fail(state, PROGRAM_WRONG_USAGE, "%s is a finished tree, build options do not apply",
                        state->options.input);
}

int input_refuse_device_options(program *state)
{
    const int exit_code = input_refuse_build_options(state);
    return exit_code == PROGRAM_DONE && !input_is_compact(state)
               ? options_refuse_groups(state, OPTION_DEVICE, "to a finished tree, which the host reads")
               : exit_code;
}

static bool is_finite_vertex(const svo_mesh *mesh, size_t vertex)
{
    for (size_t axis = 0; axis < 3; ++axis) {
        const bool finite = mesh->positions_double != NULL ? isfinite(mesh->positions_double[vertex * 3 + axis])
                                                           : isfinite(mesh->positions[vertex * 3 + axis]);
        if (!finite) {
            return false;
        }
    }
    return true;
}

static void note_refused(const svo_mesh *mesh, size_t triangle, refused_triangles *refused)
{
    bool finite = true;
    for (size_t corner = 0; corner < 3; ++corner) {
        const size_t vertex = mesh->indices != NULL ? mesh->indices[triangle * 3 + corner] : triangle * 3 + corner;
        if (vertex >= mesh->vertex_count) {
            if (refused->bad_index_count++ == 0) {
                refused->first_bad_index = triangle;
            }
            return;
        }
        finite = finite && is_finite_vertex(mesh, vertex);
    }
    if (!finite && refused->not_finite_count++ == 0) {
        refused->first_not_finite = triangle;
    }
}

static int open_scene(program *state, input *opened)
{
    svo_message message = {""};
    if (state->options.axes == (int)SVO_AXES_Z_UP) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--axes z-up applies to files, not to %s", opened->name);
    }
    if (state->options.weld > 0.0) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--weld applies to mesh files, not to %s", opened->name);
    }
    const svo_status status = scene_create(opened->name + strlen("scene:"), &opened->made, &message);
    if (status != SVO_OK) {
        return program_fail_scene(state, status, message.text);
    }
    opened->mesh = scene_mesh(opened->made);
    return PROGRAM_DONE;
}

/* A mesh file and the name that messages give it. */
typedef struct mesh_file {
    program *state;
    const char *path, *name;
} mesh_file;

/* A message with the name in place of the path that it begins with. */
static svo_message with_name(const mesh_file *file, const char *text)
{
    svo_message named;
    const char *words = program_words(text);
    const size_t length = strlen(file->path);
    const bool begins = strncmp(words, file->path, length) == 0;
    snprintf(named.text, sizeof named.text, "%s%s", begins ? file->name : "", begins ? words + length : words);
    return named;
}

static void log_with_name(void *user, svo_log_level level, const char *text)
{
    const mesh_file *file = user;
    program_log(file->state, level, with_name(file, text).text);
}

/* An svo_import_progress_callback whose user is the program's bar. */
static int ask_to_go_on(void *user, uint64_t byte_count)
{
    (void)byte_count;
    return progress_stops(user) ? 1 : 0;
}

static int import(program *state, const char *path, input *opened)
{
    svo_message message = {""};
    mesh_file file = {.state = state, .path = path, .name = opened->name};
    char helper[PATH_BYTES];
    svo_import_options import_options = {.struct_size = sizeof import_options,
                                         .memory_limit_bytes = state->options.import_memory,
                                         .time_limit_seconds = (uint32_t)state->options.import_seconds,
                                         .strict = (uint32_t)state->options.strict,
                                         .progress = ask_to_go_on,
                                         .progress_user = state->progress,
                                         .axes = (uint32_t)state->options.axes,
                                         .normal_maps = state->wants_normal_maps ? 1 : 0,
                                         .weld = state->options.weld};
    if (svo_import_helper(helper, sizeof helper, NULL) != SVO_OK) {
        import_options.child_program = "/proc/self/exe"; /* this program alone, copied out of its installation */
    }
    if (svo_import_file(path, &import_options, log_with_name, &file, &opened->import, &message) != SVO_OK) {
        return program_fail_library(state, with_name(&file, message.text).text);
    }
    opened->mesh = svo_import_mesh(opened->import);
    opened->import_info.struct_size = sizeof opened->import_info;
    (void)svo_import_get_info(opened->import, &opened->import_info);
    int exit_code = output_protect(state, path);
    for (size_t i = 0; svo_import_file_path(opened->import, i) != NULL && exit_code == PROGRAM_DONE; ++i) {
        exit_code = output_protect(state, svo_import_file_path(opened->import, i));
    }
    return exit_code;
}

/* The importer reads files by their suffix, in another process: what came through a pipe becomes a file for it. */
static int import_piped(program *state, input *opened)
{
    spool_file spool;
    int exit_code = spool_open(state, state->piped.suffix, &spool);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = spool_write(state, &spool, state->piped.bytes, state->piped.byte_count);
    piped_release_bytes(&state->piped);
    if (exit_code == PROGRAM_DONE) {
        exit_code = import(state, spool.path, opened);
    }
    spool_remove(&spool);
    return exit_code;
}

static int open_file(program *state, input *opened)
{
    return piped_is(&state->piped, state->options.input) ? import_piped(state, opened)
                                                         : import(state, opened->name, opened);
}

/* A mesh without a valid triangle is an input error, not an empty tree. */
static int check_triangles(program *state, input *opened)
{
    const uint64_t given = opened->mesh->triangle_count;
    if (given == 0) {
        return program_fail(state, PROGRAM_FAILED, "%s: the mesh has no triangles", opened->name);
    }
    for (size_t i = 0; i < opened->mesh->triangle_count; ++i) {
        note_refused(opened->mesh, i, &opened->refused);
    }
    const refused_triangles *refused = &opened->refused;
    if (refused->bad_index_count + refused->not_finite_count < given) {
        return PROGRAM_DONE;
    }
    if (refused->bad_index_count == 0) {
        return program_fail(state, PROGRAM_FAILED,
                            "%s: no valid triangle in it: all %" PRIu64 " have a coordinate that is not finite",
                            opened->name, given);
    }
    return program_fail(state, PROGRAM_FAILED,
                        "%s: no valid triangle in it: %" PRIu64 " of %" PRIu64 " have an index out of range, %" PRIu64
                        " a coordinate that is not finite",
                        opened->name, refused->bad_index_count, given, refused->not_finite_count);
}

static int refuse_levels(program *state)
{
    return state->options.last_level == 0 && state->options.region == NULL
               ? PROGRAM_DONE
               : program_fail(state, PROGRAM_WRONG_USAGE, "--%s applies to %s, not to %s",
                              state->options.last_level != 0 ? "levels" : "region",
                              state->options.last_level != 0 ? ".svo files" : "folders of parts", state->options.input);
}

/* Takes the grid of --voxel-size for that of --origin, --edge and --depth. */
static int take_voxel_size(program *state, const svo_mesh *mesh)
{
    options *given = &state->options;
    unsigned depth = 0;
    svo_message message = {""};
    if (given->voxel_size <= 0.0) {
        return PROGRAM_DONE;
    }
    if (svo_mesh_voxel_grid(mesh, given->voxel_size, given->origin, &given->edge, &depth, &message) != SVO_OK) {
        return program_fail_library(state, message.text);
    }
    given->depth = depth;
    given->has_depth = given->has_origin = true;
    given->voxel_size = 0.0;
    return PROGRAM_DONE;
}

int input_open(program *state, input *opened)
{
    *opened = (input){.name = state->options.input};
    state->reads_mesh = true;
    const bool is_scene = strncmp(opened->name, "scene:", 6) == 0;
    progress_step(state->progress, is_scene ? "generating the scene" : "reading the mesh");
    if (input_is_tree(state)) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "%s is a finished tree, a mesh is needed here", opened->name);
    }
    if (voxel_input_is_given(state)) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "%s holds voxels, a mesh is needed here", opened->name);
    }
    int result = refuse_levels(state);
    if (result == PROGRAM_DONE) {
        const double started_ms = input_now_ms();
        result = is_scene ? open_scene(state, opened) : open_file(state, opened);
        opened->import_ms = input_now_ms() - started_ms;
    }
    if (result == PROGRAM_DONE) {
        result = check_triangles(state, opened);
    }
    if (result == PROGRAM_DONE) {
        result = take_voxel_size(state, opened->mesh);
    }
    if (result != PROGRAM_DONE) {
        input_close(opened);
    }
    return result;
}

int input_open_any(program *state, uint32_t need, input *opened)
{
    if (!voxel_input_is_given(state)) {
        const int refused = refuse_voxel_options(state);
        return refused == PROGRAM_DONE ? input_open(state, opened) : refused;
    }
    *opened = (input){.name = state->options.input};
    progress_step(state->progress, "reading the voxels");
    int exit_code = refuse_levels(state);
    if (exit_code == PROGRAM_DONE) {
        exit_code = voxel_input_check_options(state, need);
    }
    const double started_ms = input_now_ms();
    if (exit_code == PROGRAM_DONE) {
        exit_code = voxel_input_open(state, &opened->voxels);
    }
    opened->import_ms = input_now_ms() - started_ms;
    return exit_code;
}

void input_close(input *opened)
{
    voxel_input_close(&opened->voxels);
    svo_import_destroy(&opened->import);
    scene_destroy(&opened->made);
    *opened = (input){0};
}

int input_load_compact(program *state, svo_compact **out)
{
    if (state->options.last_level != 0) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--levels reads a .svo file; compact trees are read whole");
    }
    return compact_input_load(state, piped_source(&state->piped, state->options.input), out);
}

int input_load_tree(program *state, svo_tree **out)
{
    svo_message message = {""};
    const svo_load_options load_options = {.struct_size = sizeof load_options,
                                           .voxels_max = state->options.max_voxels,
                                           .last_level = (uint32_t)state->options.last_level};
    progress_step(state->progress, "reading the tree");
    if (input_is_parts(state)) {
        return parts_input_load(state, out);
    }
    if (state->options.region != NULL) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--region applies to folders of parts, not to %s",
                            state->options.input);
    }
    if (input_is_compact(state)) {
        svo_compact *compact = NULL;
        const int exit_code = input_load_compact(state, &compact);
        return exit_code == PROGRAM_DONE ? compact_input_expand(state, state->options.input, &compact, out) : exit_code;
    }
    return svo_tree_load(piped_source(&state->piped, state->options.input), &load_options, out, &message) == SVO_OK
               ? PROGRAM_DONE
               : program_fail_library(state, message.text);
}

int input_measure(program *state, uint64_t *byte_count)
{
    struct stat status;
    if (piped_is(&state->piped, state->options.input)) {
        *byte_count = state->piped.byte_count;
    } else if (input_is_parts(state)) {
        return parts_input_measure(state, byte_count);
    } else if (stat(state->options.input, &status) != 0) {
        return program_fail(state, PROGRAM_FAILED, "%s: %s", state->options.input, strerror(errno));
    } else {
        *byte_count = (uint64_t)status.st_size;
    }
    return PROGRAM_DONE;
}
