/* SPDX-License-Identifier: MIT */
/*
 * Mesh files, in the calling process: checks the arguments and the file, has a child process read it and parses the
 * child's answer (import_stream.c). import_child.c runs in the child.
 *
 * The child is started with one pipe, which is read until it closes or the time limit passes. Then the child is waited
 * for or killed. A crash, a hang or endless output becomes a status.
 */
#define _GNU_SOURCE /* dladdr; pipe2: no other thread's child can inherit the pipe */
#include "io/import.h"

#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <limits.h>
#include <math.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "core/memory.h"
#include "core/message.h"
#include "core/struct_size.h"
#include "io/import_stream.h"
#include "io/import_weld.h"

#define HELPER_PATH_BYTES    4096
#define DEFAULT_TIME_SECONDS 5
#define FIRST_READ_BYTES     ((size_t)1 << 20)
#define PIPE_BYTES           (1 << 20) /* of the answer on its way: the default is 64 KiB */
#define PROGRESS_MS          100 /* between calls of the progress callback */
#define NOT_STARTED_CODE     127 /* posix_spawn's exit code where exec fails in the child */

/* FROM_LIBRARY and FROM_PROGRAM, the helper's folder from that of libraries and that of programs, and INSTALLED, its
   absolute path, come from the build. */
#define HELPER_NAME "/svocl-import"

/*
 * ---- the helper program ----
 *
 * The installation may have been moved, so the file that holds this code is asked for first: the shared library, or the
 * program that it is linked into.
 */

/* Whether a program is there; its path without links and dots goes to path. */
static bool take_program(const char *candidate, char *path, size_t path_bytes)
{
    char real[PATH_MAX];
    const bool is_there = access(candidate, X_OK) == 0 && realpath(candidate, real) != NULL;
    const int length = is_there ? snprintf(path, path_bytes, "%s", real) : -1;
    return length > 0 && (size_t)length < path_bytes;
}

/* The program at a path relative to the folder of a file. */
static bool take_beside(const char *file, const char *relative, char *path, size_t path_bytes)
{
    char candidate[PATH_MAX];
    char *slash = realpath(file, candidate) != NULL ? strrchr(candidate, '/') : NULL;
    if (slash == NULL) {
        return false;
    }
    const size_t left_bytes = sizeof candidate - (size_t)(slash - candidate);
    const int length = snprintf(slash, left_bytes, "/%s", relative);
    return length > 0 && (size_t)length < left_bytes && take_program(candidate, path, path_bytes);
}

svo_status svo_import_helper(char *path, size_t path_bytes, svo_message *message)
{
    static const char own_address = 0;
    Dl_info info = {0};
    if (path == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "svo_import_helper: path is NULL");
    }
    const bool is_known = dladdr(&own_address, &info) != 0 && info.dli_fname != NULL;
    if ((is_known && take_beside(info.dli_fname, FROM_LIBRARY HELPER_NAME, path, path_bytes)) ||
        take_beside("/proc/self/exe", FROM_PROGRAM HELPER_NAME, path, path_bytes) ||
        take_program(INSTALLED HELPER_NAME, path, path_bytes)) {
        return SVO_OK;
    }
    return svo_i_fail(
        message, SVO_FILE_ERROR,
        "svo_import_helper: no program svocl-import in %s of the library's folder, %s of the program's, or %s",
        FROM_LIBRARY, FROM_PROGRAM, INSTALLED);
}

/*
 * ---- the child ----
 *
 * The default limits grow with what the child says that it reads besides the mesh file, and makes of it.
 */

typedef struct import_child {
    const char *path;
    const svo_import_options *options;
    const svo_i_memory *memory;
    svo_message *message;
    import_growth grows;
    double start_ms, limit_ms;
    stream_work work; /* announced */
    size_t next_frame; /* offset of the first frame of the answer that has not been looked at */
    pid_t process;
    int stream;
} import_child;

/* The parent's environment and IMPORT_CHILD_ENVIRONMENT; the caller frees the array, not the strings. */
static char **child_environment(const svo_i_memory *memory)
{
    static char mark[] = IMPORT_CHILD_ENVIRONMENT "=1";
    size_t count = 0;
    while (environ != NULL && environ[count] != NULL) {
        ++count;
    }
    char **environment = svo_i_alloc(memory, (count + 2) * sizeof *environment);
    if (environment == NULL) {
        return NULL;
    }
    environment[0] = mark;
    for (size_t i = 0; i < count; ++i) {
        environment[i + 1] = environ[i];
    }
    environment[count + 1] = NULL;
    return environment;
}

/* The child starts with default signal handlers and none blocked, whatever the calling program has set. */
static int fill_attributes(posix_spawnattr_t *attributes)
{
    sigset_t none, all;
    sigemptyset(&none);
    sigfillset(&all);
    int error = posix_spawnattr_setsigmask(attributes, &none);
    if (error == 0) {
        error = posix_spawnattr_setsigdefault(attributes, &all);
    }
    if (error == 0) {
        error = posix_spawnattr_setflags(attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
    }
    return error;
}

static int fill_actions(posix_spawn_file_actions_t *actions, int stream)
{
    int error = posix_spawn_file_actions_adddup2(actions, stream, IMPORT_CHILD_STREAM);
    for (int descriptor = 0; descriptor < 3 && error == 0; ++descriptor) {
        error = posix_spawn_file_actions_addopen(actions, descriptor, "/dev/null", O_RDWR, 0);
    }
    return error;
}

static int spawn(import_child *child, char *const *arguments, char *const *environment, int stream)
{
    posix_spawnattr_t attributes;
    posix_spawn_file_actions_t actions;
    int error = posix_spawnattr_init(&attributes);
    if (error != 0) {
        return error;
    }
    error = posix_spawn_file_actions_init(&actions);
    if (error == 0) {
        error = fill_attributes(&attributes);
        if (error == 0) {
            error = fill_actions(&actions, stream);
        }
        if (error == 0) {
            error = posix_spawn(&child->process, arguments[0], &actions, &attributes, arguments, environment);
        }
        posix_spawn_file_actions_destroy(&actions);
    }
    posix_spawnattr_destroy(&attributes);
    return error;
}

static svo_status start(import_child *child)
{
    char memory[24], seconds[16], word[] = IMPORT_CHILD_WORD, time_grows[8], memory_grows[8], maps[16];
    (void)snprintf(memory, sizeof memory, "%" PRIu64, child->options->memory_limit_bytes);
    (void)snprintf(seconds, sizeof seconds, "%" PRIu32, child->options->time_limit_seconds);
    (void)snprintf(time_grows, sizeof time_grows, "%s", child->grows.time ? IMPORT_CHILD_GROWS : IMPORT_CHILD_FIXED);
    (void)snprintf(memory_grows, sizeof memory_grows, "%s",
                   child->grows.memory ? IMPORT_CHILD_GROWS : IMPORT_CHILD_FIXED);
    (void)snprintf(maps, sizeof maps, "%s",
                   child->options->normal_maps != 0 ? IMPORT_CHILD_NORMAL_MAPS : IMPORT_CHILD_NO_NORMAL_MAPS);
    char *program = svo_i_copy_text(child->memory, child->options->child_program);
    char *path = svo_i_copy_text(child->memory, child->path);
    char **environment = child_environment(child->memory);
    int ends[2] = {-1, -1};
    svo_status status = SVO_OK;
    if (program == NULL || path == NULL || environment == NULL) {
        status = svo_i_fail(child->message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory to start the reader", child->path);
    } else if (pipe2(ends, O_CLOEXEC) != 0) {
        status = svo_i_fail(child->message, SVO_IMPORT_FAILED, "%s: no pipe to the reader: %s", child->path,
                            strerror(errno));
    } else {
        char *const arguments[IMPORT_CHILD_ARGUMENT_COUNT + 1] = {program,    word,         path, memory, seconds,
                                                                  time_grows, memory_grows, maps, NULL};
        (void)fcntl(ends[0], F_SETPIPE_SZ, PIPE_BYTES); /* refused: more turns of both processes */
        const int error = spawn(child, arguments, environment, ends[1]);
        close(ends[1]);
        if (error == 0) {
            child->stream = ends[0];
        } else {
            close(ends[0]);
            status = svo_i_fail(child->message, error == ENOMEM ? SVO_OUT_OF_HOST_MEMORY : SVO_IMPORT_FAILED,
                                "%s: the reader %s cannot be started: %s", child->path, program, strerror(error));
        }
    }
    svo_i_free(program);
    svo_i_free(path);
    svo_i_free(environment);
    return status;
}

static svo_status too_slow(const import_child *child)
{
    return svo_i_fail(child->message, SVO_IMPORT_FAILED, "%s: reading took longer than %.0f s", child->path,
                      floor(child->limit_ms * 1e-3));
}

/* Milliseconds until the deadline, rounded up; 0: over. */
static int remaining_ms(const import_child *child)
{
    const double left_ms = child->start_ms + child->limit_ms - svo_i_now_ms();
    if (left_ms <= 0) {
        return 0;
    }
    return left_ms < 1e6 ? (int)left_ms + 1 : 1000000;
}

/* Milliseconds until something has to be looked at again, above 0. */
static int pause_ms(const import_child *child)
{
    const int left_ms = remaining_ms(child);
    return child->options->progress != NULL && left_ms > PROGRESS_MS ? PROGRESS_MS : left_ms;
}

static svo_status ask_progress(const import_child *child, const svo_import *import)
{
    const svo_import_options *options = child->options;
    return options->progress == NULL || options->progress(options->progress_user, import->byte_count) == 0
               ? SVO_OK
               : svo_i_fail(child->message, SVO_CANCELED, "%s: the progress callback stopped the import", child->path);
}

static uint64_t memory_bytes(const import_child *child)
{
    const uint64_t given = child->options->memory_limit_bytes;
    const uint64_t more = child->grows.memory ? svo_i_stream_memory(&child->work) : 0;
    return given > UINT64_MAX - more ? UINT64_MAX : given + more;
}

/* Room for at least one more byte, up to the child's memory limit. */
static svo_status make_room(const import_child *child, svo_import *import, size_t *capacity)
{
    if (import->byte_count < *capacity) {
        return SVO_OK;
    }
    if (*capacity >= memory_bytes(child)) {
        return svo_i_fail(child->message, SVO_IMPORT_FAILED, "%s: the mesh needs more than %s (memory_limit_bytes)",
                          child->path, svo_i_bytes(memory_bytes(child)).text);
    }
    const size_t larger = *capacity == 0 ? FIRST_READ_BYTES : 2 * *capacity;
    uint8_t *bytes = larger > *capacity ? svo_i_grow(child->memory, import->bytes, larger) : NULL;
    if (bytes == NULL) {
        return svo_i_fail(child->message, SVO_OUT_OF_HOST_MEMORY, "%s: the mesh needs more than %s", child->path,
                          svo_i_bytes(*capacity).text);
    }
    import->bytes = bytes;
    *capacity = larger;
    return SVO_OK;
}

/* Gives the child what the work takes that it has announced so far. Frames are judged when the answer is complete. */
static void take_work(import_child *child, const svo_import *import)
{
    stream_frame frame;
    stream_work work;
    while (child->next_frame < import->byte_count &&
           import->byte_count - child->next_frame >= sizeof frame + sizeof work) {
        memcpy(&frame, import->bytes + child->next_frame, sizeof frame);
        if (frame.kind == STREAM_WORK) {
            memcpy(&work, import->bytes + child->next_frame + sizeof frame, sizeof work);
            svo_i_stream_add(&child->work, &work);
            if (child->grows.time) {
                child->limit_ms += 1e3 * ((double)work.read_bytes + (double)work.made_bytes) / STREAM_BYTES_A_SECOND;
            }
        }
        const uint64_t most_bytes = SIZE_MAX - child->next_frame - sizeof frame - STREAM_PAYLOAD_ALIGN;
        const uint64_t payload_bytes = frame.payload_bytes < most_bytes ? frame.payload_bytes : most_bytes;
        child->next_frame += sizeof frame + (size_t)payload_bytes + (size_t)(-payload_bytes % STREAM_PAYLOAD_ALIGN);
    }
}

/* Reads until the child closes the pipe, which it does at the latest by ending. */
static svo_status collect(import_child *child, svo_import *import)
{
    size_t capacity = 0;
    for (;;) {
        struct pollfd wait_for = {.fd = child->stream, .events = POLLIN};
        if (remaining_ms(child) == 0) {
            return too_slow(child);
        }
        SVO_I_TRY(ask_progress(child, import));
        if (poll(&wait_for, 1, pause_ms(child)) <= 0) {
            continue; /* interrupted, a pause, or the deadline, which is checked above */
        }
        SVO_I_TRY(make_room(child, import, &capacity));
        const ssize_t got = read(child->stream, import->bytes + import->byte_count, capacity - import->byte_count);
        if (got == 0) {
            return SVO_OK;
        }
        if (got > 0) {
            import->byte_count += (size_t)got;
            take_work(child, import);
        } else if (errno != EINTR) {
            return svo_i_fail(child->message, SVO_IMPORT_FAILED, "%s: the reader's pipe cannot be read: %s",
                              child->path, strerror(errno));
        }
    }
}

/* Waits for a child that has closed its pipe to end. *known is false where the calling program reaps its children
   itself, so that the exit code is lost. */
static svo_status wait_for_end(const import_child *child, const svo_import *import, int *exit_state, bool *known)
{
    for (;;) {
        const pid_t ended = waitpid(child->process, exit_state, WNOHANG);
        if (ended == child->process) {
            *known = true;
            return SVO_OK;
        }
        if (ended < 0 && errno != EINTR) {
            *known = false;
            return SVO_OK;
        }
        if (remaining_ms(child) == 0) {
            return too_slow(child);
        }
        SVO_I_TRY(ask_progress(child, import));
        const struct timespec moment = {.tv_nsec = 200000};
        nanosleep(&moment, NULL);
    }
}

static svo_status check_exit(const import_child *child, int exit_state, const svo_import *import)
{
    if (WIFSIGNALED(exit_state)) {
        const int signal_number = WTERMSIG(exit_state);
        if (signal_number == SIGXCPU) {
            return too_slow(child);
        }
        return svo_i_fail(child->message, SVO_IMPORT_FAILED, "%s: the reader %s (signal %d)", child->path,
                          signal_number == SIGKILL ? "was killed" : "crashed", signal_number);
    }
    if (import->byte_count > 0) {
        return SVO_OK; /* a failure is in its answer */
    }
    if (WEXITSTATUS(exit_state) == NOT_STARTED_CODE) {
        return svo_i_fail(child->message, SVO_IMPORT_FAILED, "%s: the reader %s cannot be started", child->path,
                          child->options->child_program);
    }
    return svo_i_fail(child->message, SVO_IMPORT_FAILED, "%s: the reader ended without an answer, exit code %d",
                      child->path, WEXITSTATUS(exit_state));
}

static void kill_and_reap(const import_child *child)
{
    (void)kill(child->process, SIGKILL);
    while (waitpid(child->process, NULL, 0) < 0 && errno == EINTR) {
    }
}

svo_status svo_i_import_run_child(const char *path, const svo_import_options *options, import_growth grows,
                                  svo_import *import, svo_message *message)
{
    import_child child = {.path = path,
                          .options = options,
                          .memory = &import->memory,
                          .message = message,
                          .grows = grows,
                          .start_ms = svo_i_now_ms(),
                          .limit_ms = 1e3 * options->time_limit_seconds,
                          .next_frame = STREAM_GREETING_BYTES,
                          .process = -1,
                          .stream = -1};
    svo_status status = SVO_OK;
    int exit_state = 0;
    bool known = false;
    bool ended = false;
    SVO_I_TRY(start(&child));
    SVO_I_TRY_CLEANUP(collect(&child, import));
    SVO_I_TRY_CLEANUP(wait_for_end(&child, import, &exit_state, &known));
    ended = true;
    if (known) {
        status = check_exit(&child, exit_state, import);
    }
cleanup:
    close(child.stream);
    if (!ended) {
        kill_and_reap(&child);
    }
    return status;
}

/* ---- import ---- */

/* Errors for which the system has a better message than a reader: missing, a directory, no permission. */
static svo_status check_file(const char *path, uint64_t *byte_count, svo_message *message)
{
    const int file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (file < 0) {
        return svo_i_fail(message, SVO_FILE_ERROR, "%s: cannot be read: %s", path, strerror(errno));
    }
    struct stat entry;
    svo_status status = SVO_OK;
    if (fstat(file, &entry) != 0) {
        status = svo_i_fail(message, SVO_FILE_ERROR, "%s: cannot be read: %s", path, strerror(errno));
    } else if (!S_ISREG(entry.st_mode)) {
        status = svo_i_fail(message, SVO_FILE_ERROR, "%s: cannot be read: %s", path,
                            S_ISDIR(entry.st_mode) ? strerror(EISDIR) : "not a regular file");
    } else {
        *byte_count = (uint64_t)entry.st_size;
    }
    close(file);
    return status;
}

/* Options without zeros. helper: room for the path of the helper program. Time and memory for other files than the mesh
   file are added when the child announces them. */
static svo_status fill_options(svo_import_options *options, uint64_t byte_count, char *helper, size_t helper_bytes,
                               svo_message *message)
{
    if (options->memory_limit_bytes == 0) {
        options->memory_limit_bytes = STREAM_MEMORY_BYTES + svo_i_stream_memory(&(stream_work){byte_count, 0});
    }
    if (options->time_limit_seconds == 0) {
        const uint64_t seconds = DEFAULT_TIME_SECONDS + byte_count / STREAM_BYTES_A_SECOND;
        options->time_limit_seconds = seconds < UINT32_MAX ? (uint32_t)seconds : UINT32_MAX;
    }
    if (options->child_program == NULL) {
        const svo_status status = svo_import_helper(helper, helper_bytes, message);
        if (status != SVO_OK) {
            return status == SVO_FILE_ERROR ? SVO_IMPORT_FAILED : status;
        }
        options->child_program = helper;
    }
    return SVO_OK;
}

/* From z up to y up. */
static void turn_floats(const float *vectors, size_t count)
{
    float *turned = (float *)vectors; /* in import->bytes */
    for (size_t i = 0; i < count && turned != NULL; ++i, turned += 3) {
        const float y = turned[1];
        turned[1] = turned[2];
        turned[2] = -y;
    }
}

static void turn_mesh(const svo_mesh *mesh)
{
    double *doubles = (double *)mesh->positions_double;
    turn_floats(mesh->positions, mesh->vertex_count);
    turn_floats(mesh->normals, mesh->vertex_count);
    for (size_t i = 0; i < mesh->vertex_count && doubles != NULL; ++i, doubles += 3) {
        const double y = doubles[1];
        doubles[1] = doubles[2];
        doubles[2] = -y;
    }
}

static svo_status check_arguments(const char *path, svo_import *const *out, svo_message *message)
{
    if (path == NULL || out == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "svo_import_file: %s is NULL", path == NULL ? "path" : "out");
    }
    if (getenv(IMPORT_CHILD_ENVIRONMENT) != NULL) {
        return svo_i_fail(
            message, SVO_IMPORT_FAILED,
            "svo_import_file: called in an import child; svo_import_child_main must come first in main()");
    }
    return SVO_OK;
}

svo_status svo_import_file(const char *path, const svo_import_options *options, svo_log_callback log, void *log_user,
                           svo_import **out, svo_message *message)
{
    svo_status status = SVO_OK;
    svo_import_options filled;
    char helper[HELPER_PATH_BYTES];
    uint64_t byte_count = 0;
    SVO_I_TRY(check_arguments(path, out, message));
    SVO_I_TRY(svo_i_struct_read(message, "svo_import_file", "options", options, &filled,
                                SVO_I_STRUCT_SIZES(svo_import_options, time_limit_seconds)));
    if (filled.axes > SVO_AXES_Z_UP) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "svo_import_file: options.axes %u is not in 0 .. %d",
                          filled.axes, SVO_AXES_Z_UP);
    }
    if (!isfinite(filled.weld) || filled.weld < 0.0) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT,
                          "svo_import_file: options.weld %g is not a finite number of at least 0", filled.weld);
    }
    SVO_I_TRY(check_file(path, &byte_count, message));
    const import_growth grows = {filled.time_limit_seconds == 0, filled.memory_limit_bytes == 0};
    SVO_I_TRY(fill_options(&filled, byte_count, helper, sizeof helper, message));
    svo_i_memory memory;
    SVO_I_TRY(svo_i_memory_read(message, "svo_import_file", "options.memory", filled.memory, &memory));
    svo_import *import = svo_i_alloc_zeroed(&memory, 1, sizeof *import);
    if (import == NULL) {
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for the mesh", path);
    }
    import->memory = memory;
    SVO_I_TRY_CLEANUP(svo_i_import_run_child(path, &filled, grows, import, message));
    SVO_I_TRY_CLEANUP(svo_i_stream_parse(import, path, filled.strict != 0, log, log_user, message));
    SVO_I_TRY_CLEANUP(svo_i_import_weld(import, filled.weld, path, message));
    if (filled.axes == SVO_AXES_Z_UP) {
        turn_mesh(&import->mesh);
    }
    *out = import;
    import = NULL;
cleanup:
    svo_import_destroy(&import);
    return status;
}

svo_status svo_import_get_info(const svo_import *import, svo_import_info *info)
{
    return svo_i_struct_write(NULL, "svo_import_get_info", "info", &import->info, info,
                              SVO_I_STRUCT_SIZES(svo_import_info, warnings));
}

const svo_mesh *svo_import_mesh(const svo_import *import)
{
    return &import->mesh;
}

const uint32_t *svo_import_file_vertices(const svo_import *import, size_t *vertex_count)
{
    *vertex_count = import->file_vertex_count;
    return import->file_vertices;
}

const char *svo_import_file_path(const svo_import *import, size_t index)
{
    return index < import->file_count ? import->files[index] : NULL;
}

void svo_import_destroy(svo_import **import)
{
    if (import == NULL || *import == NULL) {
        return;
    }
    svo_i_free((void *)(*import)->files);
    svo_i_free((*import)->textures);
    svo_i_free((*import)->bytes);
    svo_i_free(*import);
    *import = NULL;
}
