/* SPDX-License-Identifier: MIT */
/* Starts this program as a child process and reads its output. */
#define _XOPEN_SOURCE 700
#include "bench/child.h"

#include <errno.h>
#include <fcntl.h>
#include <ftw.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "support/input.h"

#define OUTPUT_BYTES_MAX ((size_t)1 << 20)
#define ARGUMENTS_MAX    24

bool child_cache_create(child_cache *made)
{
    const char *folder = getenv("TMPDIR");
    *made = (child_cache){.path = ""};
    const int length =
        snprintf(made->path, sizeof made->path, "%s/svocl_bench_XXXXXX", folder != NULL ? folder : "/tmp");
    return length > 0 && (size_t)length < sizeof made->path && mkdtemp(made->path) != NULL;
}

static int remove_one(const char *path, const struct stat *status, int kind, struct FTW *place)
{
    (void)status;
    (void)kind;
    (void)place;
    return remove(path);
}

void child_cache_remove(const child_cache *made)
{
    (void)nftw(made->path, remove_one, 16, FTW_DEPTH | FTW_PHYS);
}

/* In the child: never returns. The variables are those of PoCL, Mesa, NVIDIA's two drivers, and XDG. */
static void become(const char *const arguments[], const child_cache *cache, int output)
{
    static const char *const caches[] = {"POCL_CACHE_DIR",  "MESA_SHADER_CACHE_DIR",       "MESA_GLSL_CACHE_DIR",
                                         "CUDA_CACHE_PATH", "__GL_SHADER_DISK_CACHE_PATH", "XDG_CACHE_HOME"};
    char *list[ARGUMENTS_MAX + 2] = {(char[]){"svocl"}};
    bool ready = true;
    for (size_t i = 0; i < ARGUMENTS_MAX && arguments[i] != NULL; ++i) {
        list[i + 1] = strdup(arguments[i]);
        ready = ready && list[i + 1] != NULL;
    }
    for (size_t i = 0; i < sizeof caches / sizeof caches[0]; ++i) {
        ready = setenv(caches[i], cache->path, 1) == 0 && ready;
    }
    const int nowhere = open("/dev/null", O_WRONLY);
    if (ready && nowhere >= 0 && dup2(output, STDOUT_FILENO) >= 0 && dup2(nowhere, STDERR_FILENO) >= 0) {
        execv("/proc/self/exe", list);
    }
    _exit(127);
}

/* Everything from the pipe, as a text by malloc. NULL when it is too long or memory runs out. */
static char *read_all(int pipe_end)
{
    char *text = malloc(OUTPUT_BYTES_MAX);
    size_t used = 0;
    while (text != NULL && used + 1 < OUTPUT_BYTES_MAX) {
        const ssize_t got = read(pipe_end, text + used, OUTPUT_BYTES_MAX - 1 - used);
        if (got == 0) {
            text[used] = '\0';
            return text;
        }
        if (got < 0 && errno != EINTR) {
            break;
        }
        used += got > 0 ? (size_t)got : 0;
    }
    free(text);
    return NULL;
}

static bool ended_well(pid_t child)
{
    int status = 0;
    while (waitpid(child, &status, 0) < 0) {
        if (errno != EINTR) {
            return false;
        }
    }
    return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

double child_run(const char *const arguments[], const child_cache *cache, cJSON **document)
{
    int ends[2];
    *document = NULL;
    if (pipe(ends) != 0) {
        return -1.0;
    }
    fflush(stdout);
    const double start_ms = input_now_ms();
    const pid_t child = fork();
    if (child == 0) {
        become(arguments, cache, ends[1]);
    }
    close(ends[1]);
    char *text = child > 0 ? read_all(ends[0]) : NULL;
    close(ends[0]);
    const bool well = child > 0 && ended_well(child);
    const double ms = input_now_ms() - start_ms;
    *document = well && text != NULL ? cJSON_Parse(text) : NULL;
    free(text);
    return well ? ms : -1.0;
}
