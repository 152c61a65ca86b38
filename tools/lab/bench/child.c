/* SPDX-License-Identifier: MIT */
/* Starts svocl as a child process and reads its output. */
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
#include "support/sibling.h"
#include "svocl/device.h"

#define OUTPUT_BYTES_MAX ((size_t)1 << 26)

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

void child_add(child_arguments *arguments, const char *text)
{
    if (arguments->count < CHILD_ARGUMENTS_MAX) {
        arguments->list[arguments->count++] = text;
        arguments->list[arguments->count] = NULL;
    }
}

static void add_option(child_arguments *arguments, const char *option, const char *value)
{
    child_add(arguments, option);
    child_add(arguments, value);
}

void child_add_device(child_arguments *arguments, const options *given, bool in_gl)
{
    static const char *const contexts[] = {"surfaceless", "egl-device", "osmesa"};
    if (given->device_name != NULL) {
        add_option(arguments, "--device", given->device_name);
    }
    if (given->path != SVO_PATH_AUTO) {
        add_option(arguments, "--path", svo_name(SVO_NAME_PATH, (svo_path)given->path));
    }
    if (in_gl && given->gl_device != NULL) {
        add_option(arguments, "--gl-device", given->gl_device);
    } else if (in_gl && given->context != OPTION_CONTEXT_AUTO) {
        add_option(arguments, "--context", contexts[given->context]);
    }
}

/* The variables are those of PoCL, Mesa, NVIDIA's two drivers, and XDG. */
static bool use_cache(const child_cache *cache)
{
    static const char *const caches[] = {"POCL_CACHE_DIR",  "MESA_SHADER_CACHE_DIR",       "MESA_GLSL_CACHE_DIR",
                                         "CUDA_CACHE_PATH", "__GL_SHADER_DISK_CACHE_PATH", "XDG_CACHE_HOME"};
    bool ready = true;
    for (size_t i = 0; i < sizeof caches / sizeof caches[0]; ++i) {
        ready = setenv(caches[i], cache->path, 1) == 0 && ready;
    }
    return ready;
}

/* In the child: never returns. */
static void become(const char *const arguments[], int output, int errors)
{
    char *list[CHILD_ARGUMENTS_MAX + 2] = {(char[]){"svocl"}};
    bool ready = true;
    for (size_t i = 0; i < CHILD_ARGUMENTS_MAX && arguments[i] != NULL; ++i) {
        list[i + 1] = strdup(arguments[i]);
        ready = ready && list[i + 1] != NULL;
    }
    if (ready && errors >= 0 && dup2(output, STDOUT_FILENO) >= 0 && dup2(errors, STDERR_FILENO) >= 0) {
        sibling_become("svocl", list);
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

/* waitpid, until it says something. */
static pid_t wait_through(pid_t child, int *status)
{
    pid_t ended = -1;
    do {
        ended = waitpid(child, status, 0);
    } while (ended < 0 && errno == EINTR);
    return ended;
}

/* The status of waitpid; -1 where there is none. */
static int wait_for(pid_t child)
{
    int status = 0;
    return wait_through(child, &status) < 0 ? -1 : status;
}

static bool ended_well(int status)
{
    return status >= 0 && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

pid_t child_start(const child_arguments *arguments, const child_cache *cache)
{
    fflush(stdout);
    const pid_t child = fork();
    if (child == 0) {
        const int nowhere = use_cache(cache) ? open("/dev/null", O_WRONLY) : -1;
        become(arguments->list, nowhere, nowhere);
    }
    return child;
}

pid_t child_wait(bool *well)
{
    int status = 0;
    const pid_t ended = wait_through(-1, &status);
    *well = ended >= 0 && ended_well(status);
    return ended;
}

/* "svocl: build: words": the words. */
static const char *words_of(const char *line)
{
    static const char prefix[] = "svocl: ";
    const bool is_ours = strncmp(line, prefix, strlen(prefix)) == 0;
    const char *command_end = is_ours ? strstr(line + strlen(prefix), ": ") : NULL;
    return command_end != NULL ? command_end + 2 : line;
}

/* The last line of the file that is not empty. */
static void keep_last_line(FILE *errors, char *reason, size_t reason_bytes)
{
    char line[CHILD_REASON_BYTES];
    rewind(errors);
    while (fgets(line, sizeof line, errors) != NULL) {
        line[strcspn(line, "\n")] = '\0';
        if (line[0] != '\0') {
            snprintf(reason, reason_bytes, "%s", words_of(line));
        }
    }
}

static void explain(int status, unsigned seconds, FILE *errors, child_answer *out)
{
    if (status >= 0 && WIFSIGNALED(status) && WTERMSIG(status) == SIGALRM) {
        snprintf(out->reason, sizeof out->reason, "ended after %u seconds", seconds);
    } else if (status >= 0 && WIFSIGNALED(status)) {
        snprintf(out->reason, sizeof out->reason, "ended by signal %d", WTERMSIG(status));
    } else {
        snprintf(out->reason, sizeof out->reason, "exit status %d", status >= 0 ? WEXITSTATUS(status) : -1);
        keep_last_line(errors, out->reason, sizeof out->reason);
    }
}

static void ask(const char *const arguments[], const child_cache *cache, unsigned seconds, child_answer *out)
{
    int ends[2];
    *out = (child_answer){.reason = "no process could be started"};
    FILE *errors = tmpfile();
    if (errors == NULL || pipe(ends) != 0) {
        if (errors != NULL) {
            fclose(errors);
        }
        return;
    }
    fflush(stdout);
    const double start_ms = input_now_ms();
    const pid_t child = fork();
    if (child == 0) {
        (void)alarm(seconds); /* outlives execv */
        become(arguments, ends[1], cache == NULL || use_cache(cache) ? fileno(errors) : -1);
    }
    close(ends[1]);
    char *text = child > 0 ? read_all(ends[0]) : NULL;
    close(ends[0]);
    if (child > 0) {
        const int status = wait_for(child);
        out->ms = input_now_ms() - start_ms;
        out->well = ended_well(status);
        out->document = text != NULL ? cJSON_Parse(text) : NULL;
        out->reason[0] = '\0';
        if (!out->well) {
            explain(status, seconds, errors, out);
        }
    }
    free(text);
    fclose(errors);
}

void child_ask(const child_arguments *arguments, const child_cache *cache, unsigned seconds, child_answer *out)
{
    ask(arguments->list, cache, seconds, out);
}

double child_run(const char *const arguments[], const child_cache *cache, cJSON **document)
{
    child_answer answer;
    ask(arguments, cache, 0, &answer);
    *document = answer.well ? answer.document : NULL;
    if (!answer.well) {
        cJSON_Delete(answer.document);
    }
    return answer.well ? answer.ms : -1.0;
}
