/* SPDX-License-Identifier: MIT */
/* Leases of folders of parts: taken, renewed, found stale and broken. */
#define _POSIX_C_SOURCE 200809L
#include "parts/lease.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "core/memory.h"
#include "core/struct_size.h"
#include "parts/part_file.h"

#define PLANNER_NAME   "planner" LEASE_SUFFIX
#define RUN_PREFIX     "run-"
#define OWNER_NAME     "owner"
#define TEXT_BYTES     512
#define TRIES          1000
#define RENEWED_MS     10000 /* planners renew no more often */
#define REMOVAL_LEVELS 4 /* of folders in folders, above what is made here */

/* The process that a lease is of. */
typedef struct owner {
    char machine[64]; /* since it started; "-": unknown */
    char processes[64]; /* which of its numberings of processes */
    char host[128];
    long process;
} owner;

struct svo_parts_lease {
    char *folder;
    char *path;
    bool made_folder;
};

/* ---- paths ---- */

char *svo_i_path_join(const char *folder, const char *name)
{
    const size_t bytes = strlen(folder) + strlen(name) + 2;
    char *path = svo_i_alloc(NULL, bytes);
    if (path != NULL) {
        (void)snprintf(path, bytes, "%s/%s", folder, name);
    }
    return path;
}

static bool is_entry(const char *name)
{
    return strcmp(name, ".") != 0 && strcmp(name, "..") != 0;
}

static bool ends_in(const char *name, const char *suffix)
{
    const size_t length = strlen(name);
    return length >= strlen(suffix) && strcmp(name + length - strlen(suffix), suffix) == 0;
}

/* Calls for each name of a folder, until an errno comes back. No folder is an empty one. */
static int each_name(const char *folder, int (*visit)(void *user, const char *name), void *user)
{
    DIR *opened = opendir(folder);
    if (opened == NULL) {
        return errno == ENOENT ? 0 : errno;
    }
    int error = 0;
    const struct dirent *entry = NULL;
    do {
        errno = 0;
        entry = readdir(opened);
        error = entry == NULL ? errno : 0;
        if (entry != NULL && is_entry(entry->d_name)) {
            error = visit(user, entry->d_name);
        }
    } while (entry != NULL && error == 0);
    (void)closedir(opened);
    return error;
}

/* A path that is being removed. */
typedef struct removal {
    const char *path;
    int levels; /* of folders that it may have below */
} removal;

static int remove_entry(void *user, const char *name)
{
    const removal *above = user;
    char *path = svo_i_path_join(above->path, name);
    removal below = {path, above->levels - 1};
    int error = path == NULL ? ENOMEM : unlink(path) == 0 || errno == ENOENT ? 0 : errno;
    if (error == EISDIR || error == EPERM) {
        error = below.levels > 0 ? each_name(path, remove_entry, &below) : error;
        error = error == 0 && rmdir(path) != 0 && errno != ENOENT ? errno : error;
    }
    svo_i_free(path);
    return error;
}

int svo_i_path_remove(const char *path)
{
    removal all = {path, REMOVAL_LEVELS};
    int error = unlink(path) == 0 || errno == ENOENT ? 0 : errno;
    if (error == EISDIR || error == EPERM) {
        error = each_name(path, remove_entry, &all);
        error = error == 0 && rmdir(path) != 0 && errno != ENOENT ? errno : error;
    }
    return error;
}

/* ---- owners ---- */

/* Reads a line of a file, without blanks; "-" where there is none. */
static void read_word(const char *path, char *word, size_t bytes)
{
    const int file = open(path, O_RDONLY | O_CLOEXEC);
    const ssize_t length = file >= 0 ? read(file, word, bytes - 1) : -1;
    word[length > 0 ? length : 0] = '\0';
    word[strcspn(word, " \n")] = '\0';
    if (word[0] == '\0') {
        (void)snprintf(word, bytes, "-");
    }
    if (file >= 0) {
        (void)close(file);
    }
}

static owner this_process(void)
{
    owner own = {.process = (long)getpid()};
    read_word("/proc/sys/kernel/random/boot_id", own.machine, sizeof own.machine);
    const ssize_t length = readlink("/proc/self/ns/pid", own.processes, sizeof own.processes - 1);
    own.processes[length > 0 ? length : 0] = '\0';
    if (length <= 0) {
        (void)snprintf(own.processes, sizeof own.processes, "-");
    }
    if (gethostname(own.host, sizeof own.host - 1) != 0 || own.host[0] == '\0') {
        (void)snprintf(own.host, sizeof own.host, "localhost");
    }
    for (char *at = own.host; *at != '\0'; ++at) {
        *at = *at == '/' || *at <= ' ' ? '-' : *at;
    }
    return own;
}

static bool is_same_machine(const owner *a, const owner *b)
{
    return strcmp(a->machine, "-") != 0 && strcmp(a->machine, b->machine) == 0 &&
           strcmp(a->processes, b->processes) == 0;
}

/* What could not be read may be either. */
static bool may_be(const char *a, const char *b)
{
    return strcmp(a, b) == 0 || strcmp(a, "-") == 0 || strcmp(b, "-") == 0;
}

/* Whether a run's lease is that of this process, or of the one that started it, for which it plans. */
static bool is_ours(const owner *own, const owner *found)
{
    return may_be(own->machine, found->machine) && may_be(own->processes, found->processes) &&
           strcmp(own->host, found->host) == 0 && (found->process == own->process || found->process == (long)getppid());
}

/* Writes the owner into a file, which makes it as new as the file system's clock. Returns an errno. */
static int write_owner(const char *path, int flags, const owner *own)
{
    char text[TEXT_BYTES];
    const int length =
        snprintf(text, sizeof text, "%s %s %s %ld\n", own->machine, own->processes, own->host, own->process);
    const int file = open(path, O_WRONLY | O_CLOEXEC | flags, 0666);
    if (file < 0) {
        return errno;
    }
    const ssize_t written = write(file, text, (size_t)length);
    int error = written == length ? 0 : written < 0 ? errno : ENOSPC;
    error = close(file) != 0 && error == 0 ? errno : error;
    return error;
}

/* Reads who a file is of, and when it was written. What another process is just writing is of nobody. */
static int read_owner(const char *path, owner *found, int64_t *seconds)
{
    struct stat entry;
    char text[TEXT_BYTES] = "";
    const int file = open(path, O_RDONLY | O_CLOEXEC);
    if (file < 0) {
        return errno;
    }
    const ssize_t length = read(file, text, sizeof text - 1);
    const int error = length < 0 || fstat(file, &entry) != 0 ? errno : 0;
    (void)close(file);
    if (error != 0) {
        return error;
    }
    *seconds = (int64_t)entry.st_mtime;
    if (sscanf(text, "%63s %63s %127s %ld", found->machine, found->processes, found->host, &found->process) != 4) {
        *found = (owner){.machine = "-", .processes = "-", .host = "a machine that is not known"};
    }
    return 0;
}

/* Whether a process of this machine has ended; one that its parent has not waited for has, too. */
static bool has_ended(long process)
{
    char path[64];
    char text[TEXT_BYTES] = "";
    if (kill((pid_t)process, 0) != 0) {
        return errno == ESRCH;
    }
    (void)snprintf(path, sizeof path, "/proc/%ld/stat", process);
    const int file = open(path, O_RDONLY | O_CLOEXEC);
    const ssize_t length = file >= 0 ? read(file, text, sizeof text - 1) : 0;
    if (file >= 0) {
        (void)close(file);
    }
    const char *name_end = length > 0 ? strrchr(text, ')') : NULL;
    return name_end != NULL && (strncmp(name_end, ") Z", 3) == 0 || strncmp(name_end, ") X", 3) == 0);
}

/* now: what was written just now is that new. */
static bool is_stale(const owner *own, const owner *found, int64_t now, int64_t seconds)
{
    return now - seconds > SVO_PARTS_LEASE_SECONDS || (is_same_machine(own, found) && has_ended(found->process));
}

static svo_status fail_errno(svo_message *message, const char *path, const char *what, int error)
{
    return svo_i_fail(message, svo_i_file_status(error), "%s: %s: %s", path, what, strerror(error));
}

/* ---- what others have ---- */

/* A look at the leases of a folder. */
typedef struct look {
    const char *folder;
    const svo_device *device; /* is told of what is broken; NULL: nobody is, and nothing is broken */
    svo_message *message;
    owner own;
    int64_t now;
    bool is_refused; /* the message says by whom */
    char entry[TEXT_BYTES]; /* OWNER of the planner */
} look;

static void refuse(look *l, const owner *found, const char *does)
{
    l->is_refused = true;
    (void)svo_i_fail(l->message, SVO_UNAVAILABLE, "%s: process %ld on %s %s; its lease is less than %d s old",
                     l->folder, found->process, found->host, does, SVO_PARTS_LEASE_SECONDS);
}

static void tell_broken(const look *l, const owner *found)
{
    svo_message text;
    svo_i_message_set(&text, "%s: the lease of process %ld on %s is stale, and is broken", l->folder, found->process,
                      found->host);
    svo_i_device_log(l->device, SVO_LOG_WARNING, text.text);
}

static int look_at_run(void *user, const char *name)
{
    look *l = user;
    owner found;
    int64_t seconds = 0;
    if (strncmp(name, RUN_PREFIX, strlen(RUN_PREFIX)) != 0 || !ends_in(name, LEASE_SUFFIX) || l->is_refused) {
        return 0;
    }
    char *path = svo_i_path_join(l->folder, name);
    int error = path != NULL ? read_owner(path, &found, &seconds) : ENOMEM;
    if (error == 0 && !is_ours(&l->own, &found)) {
        if (!is_stale(&l->own, &found, l->now, seconds)) {
            refuse(l, &found, "builds or stitches its parts");
        } else if (l->device != NULL) {
            error = unlink(path) == 0 || errno == ENOENT ? 0 : errno;
            tell_broken(l, &found);
        }
    }
    svo_i_free(path);
    return error == ENOENT ? 0 : error; /* it was released meanwhile */
}

static int note_entry(void *user, const char *name)
{
    look *l = user;
    (void)snprintf(l->entry, sizeof l->entry, "%s", name);
    return 0;
}

/* Moves the planner's folder away; no other planner has one of that name. What it was in is empty then. */
static int break_planner(const look *l, const char *held, const owner *found)
{
    char name[TEXT_BYTES + sizeof "broken-" LEASE_SUFFIX];
    (void)snprintf(name, sizeof name, "broken-%s" LEASE_SUFFIX, l->entry);
    char *own = svo_i_path_join(held, l->entry);
    char *moved = svo_i_path_join(l->folder, name);
    int error = own == NULL || moved == NULL ? ENOMEM : rename(own, moved) == 0 ? 0 : errno;
    if (error == 0) {
        tell_broken(l, found);
        error = svo_i_path_remove(moved);
    }
    svo_i_free(moved);
    svo_i_free(own);
    return error;
}

static int read_planner(const char *held, const char *entry, owner *found, int64_t *seconds)
{
    char *own = svo_i_path_join(held, entry);
    char *path = own != NULL ? svo_i_path_join(own, OWNER_NAME) : NULL;
    const int error = path != NULL ? read_owner(path, found, seconds) : ENOMEM;
    svo_i_free(path);
    svo_i_free(own);
    return error;
}

static int look_at_planner(look *l)
{
    owner found;
    int64_t seconds = 0;
    char *held = svo_i_path_join(l->folder, PLANNER_NAME);
    l->entry[0] = '\0';
    int error = held != NULL ? each_name(held, note_entry, l) : ENOMEM;
    if (error == 0 && l->entry[0] != '\0') {
        error = read_planner(held, l->entry, &found, &seconds);
        if (error == 0 && !is_stale(&l->own, &found, l->now, seconds)) {
            refuse(l, &found, "plans its parts");
        } else if (error == 0 && l->device != NULL) {
            error = break_planner(l, held, &found);
        }
    }
    svo_i_free(held);
    return error == ENOENT ? 0 : error;
}

/* The file system's clock, as a file has it that was just written. */
static int64_t clock_of(const char *path)
{
    struct stat entry;
    return stat(path, &entry) == 0 ? (int64_t)entry.st_mtime : 0;
}

/* Without a file of one's own the time is the host's. */
svo_status svo_i_lease_check(const char *folder, svo_message *message)
{
    struct timespec now;
    (void)clock_gettime(CLOCK_REALTIME, &now);
    look l = {.folder = folder, .message = message, .own = this_process(), .now = (int64_t)now.tv_sec};
    int error = look_at_planner(&l);
    error = error == 0 ? each_name(folder, look_at_run, &l) : error;
    if (error != 0 && error != ENOTDIR) { /* what is no folder has no leases, and is named by what needs one */
        return fail_errno(message, folder, "its leases cannot be read", error);
    }
    return l.is_refused ? SVO_UNAVAILABLE : SVO_OK;
}

/* ---- runs ---- */

static int make_folder(const char *folder, bool *made)
{
    *made = mkdir(folder, 0777) == 0;
    return *made || errno == EEXIST ? 0 : errno;
}

/* A name that no other lease has, nor an earlier one of this process. */
static void name_token(const owner *own, const char *prefix, const char *suffix, char token[OWNER_BYTES])
{
    struct timespec now;
    (void)clock_gettime(CLOCK_REALTIME, &now);
    (void)snprintf(token, OWNER_BYTES, "%s%.64s-%ld-%llx%08lx%s", prefix, own->host, own->process,
                   (unsigned long long)now.tv_sec, (unsigned long)now.tv_nsec, suffix);
}

void svo_i_owner_name(char name[OWNER_BYTES])
{
    const owner own = this_process();
    name_token(&own, "", "", name);
}

/* A new file of the owner; *path is the caller's. */
static int make_run(const char *folder, const owner *own, char **path)
{
    int error = EEXIST;
    for (int i = 0; error == EEXIST && i < TRIES; ++i) {
        char token[OWNER_BYTES];
        name_token(own, RUN_PREFIX, LEASE_SUFFIX, token);
        svo_i_free(*path);
        *path = svo_i_path_join(folder, token);
        error = *path != NULL ? write_owner(*path, O_CREAT | O_EXCL, own) : ENOMEM;
    }
    if (error == EEXIST) {
        svo_i_free(*path);
        *path = NULL;
    }
    return error;
}

/* Takes the lease first and looks then, as planners do, so one of two that come at once sees the other. */
svo_status svo_parts_lease_take(const char *folder, svo_parts_lease **out, svo_message *message)
{
    if (folder == NULL || out == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "svo_parts_lease_take: %s is NULL",
                          folder == NULL ? "folder" : "out");
    }
    svo_parts_lease *lease = svo_i_alloc_zeroed(NULL, 1, sizeof *lease);
    look l = {.folder = folder, .message = message, .own = this_process()};
    int error = ENOMEM;
    if (lease != NULL) {
        lease->folder = svo_i_copy_text(NULL, folder);
        error = lease->folder != NULL ? make_folder(folder, &lease->made_folder) : ENOMEM;
        error = error == 0 ? make_run(folder, &l.own, &lease->path) : error;
        l.now = error == 0 ? clock_of(lease->path) : 0;
        error = error == 0 ? look_at_planner(&l) : error;
    }
    if (error == 0 && !l.is_refused) {
        *out = lease;
        return SVO_OK;
    }
    svo_parts_lease_release(&lease);
    return error == 0 ? SVO_UNAVAILABLE : fail_errno(message, folder, "no lease can be taken", error);
}

svo_status svo_parts_lease_renew(svo_parts_lease *lease, svo_message *message)
{
    if (lease == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "svo_parts_lease_renew: lease is NULL");
    }
    const owner own = this_process();
    const int error = write_owner(lease->path, 0, &own);
    return error == 0        ? SVO_OK
           : error == ENOENT ? svo_i_fail(message, SVO_UNAVAILABLE, "%s: the lease was broken", lease->path)
                             : fail_errno(message, lease->path, "cannot be renewed", error);
}

void svo_parts_lease_release(svo_parts_lease **lease)
{
    if (lease == NULL || *lease == NULL) {
        return;
    }
    if ((*lease)->path != NULL) {
        (void)unlink((*lease)->path);
    }
    if ((*lease)->made_folder) {
        (void)rmdir((*lease)->folder); /* stays where something is in it */
    }
    svo_i_free((*lease)->path);
    svo_i_free((*lease)->folder);
    svo_i_free(*lease);
    *lease = NULL;
}

/* ---- planners ---- */

static int64_t monotonic_ms(void)
{
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (int64_t)now.tv_sec * 1000 + now.tv_nsec / 1000000;
}

/* A folder with OWNER, a folder with the owner's file. *path is the caller's. */
static int make_planner(look *l, char **path, char token[OWNER_BYTES])
{
    char name[OWNER_BYTES + sizeof "plan-" LEASE_SUFFIX];
    name_token(&l->own, "", "", token);
    (void)snprintf(name, sizeof name, "plan-%s" LEASE_SUFFIX, token);
    *path = svo_i_path_join(l->folder, name);
    char *own = *path != NULL ? svo_i_path_join(*path, token) : NULL;
    char *file = own != NULL ? svo_i_path_join(own, OWNER_NAME) : NULL;
    int error = file == NULL ? ENOMEM : mkdir(*path, 0777) == 0 ? 0 : errno;
    if (error == 0) {
        error = mkdir(own, 0777) == 0 ? write_owner(file, O_CREAT | O_EXCL, &l->own) : errno;
        l->now = error == 0 ? clock_of(file) : 0;
        if (error != 0) {
            (void)svo_i_path_remove(*path);
        }
    }
    svo_i_free(file);
    svo_i_free(own);
    return error;
}

/* Gives it the name that one planner can have. A stale one of that name is broken. */
static int hold(look *l, const char *made, const char *held)
{
    int error = EEXIST;
    for (int i = 0; i < TRIES && !l->is_refused && (error == EEXIST || error == ENOTEMPTY); ++i) {
        error = rename(made, held) == 0 ? 0 : errno;
        if (error == EEXIST || error == ENOTEMPTY) {
            const int failed = look_at_planner(l);
            error = failed != 0 ? failed : error;
        }
    }
    return error;
}

static int take_planner(look *l, svo_i_planner *planner)
{
    char token[OWNER_BYTES];
    char *made = NULL;
    planner->folder = svo_i_copy_text(NULL, l->folder);
    char *all = svo_i_path_join(l->folder, PLANNER_NAME);
    int error = planner->folder != NULL && all != NULL ? make_folder(l->folder, &planner->made_folder) : ENOMEM;
    error = error == 0 ? make_planner(l, &made, token) : error;
    if (error == 0) {
        char *own = svo_i_path_join(all, token);
        planner->owner = own != NULL ? svo_i_path_join(own, OWNER_NAME) : NULL;
        error = planner->owner != NULL ? hold(l, made, all) : ENOMEM;
        if (error != 0) {
            (void)svo_i_path_remove(made);
            svo_i_free(own);
        } else {
            planner->held = own;
            planner->renewed_ms = monotonic_ms();
            error = each_name(l->folder, look_at_run, l);
        }
    }
    svo_i_free(made);
    svo_i_free(all);
    return error;
}

svo_status svo_i_planner_take(const char *folder, const svo_device *device, svo_i_planner *planner,
                              svo_message *message)
{
    look l = {.folder = folder, .device = device, .message = message, .own = this_process()};
    const int error = take_planner(&l, planner);
    if (l.is_refused) {
        return SVO_UNAVAILABLE;
    }
    return error == 0 ? SVO_OK : fail_errno(message, folder, "cannot be made", error);
}

svo_status svo_i_planner_renew(svo_i_planner *planner, svo_message *message)
{
    const int64_t now = monotonic_ms();
    if (now - planner->renewed_ms < RENEWED_MS) {
        return SVO_OK;
    }
    const owner own = this_process();
    const int error = write_owner(planner->owner, 0, &own);
    planner->renewed_ms = now;
    return error == 0        ? SVO_OK
           : error == ENOENT ? svo_i_fail(message, SVO_UNAVAILABLE,
                                          "%s: the lease was broken, since it had not been renewed for %d s",
                                          planner->folder, SVO_PARTS_LEASE_SECONDS)
                             : fail_errno(message, planner->owner, "cannot be renewed", error);
}

/* What is left in planner.lease is empty then, which is as good as not there. */
void svo_i_planner_release(svo_i_planner *planner)
{
    if (planner->held != NULL) {
        char token[OWNER_BYTES + sizeof "done-" LEASE_SUFFIX];
        (void)snprintf(token, sizeof token, "done-%s" LEASE_SUFFIX, strrchr(planner->held, '/') + 1);
        char *moved = svo_i_path_join(planner->folder, token);
        const bool is_moved = moved != NULL && rename(planner->held, moved) == 0;
        (void)svo_i_path_remove(is_moved ? moved : planner->held);
        svo_i_free(moved);
        char *all = svo_i_path_join(planner->folder, PLANNER_NAME);
        if (all != NULL) {
            (void)rmdir(all);
        }
        svo_i_free(all);
    }
    if (planner->made_folder) {
        (void)rmdir(planner->folder);
    }
    svo_i_free(planner->held);
    svo_i_free(planner->owner);
    svo_i_free(planner->folder);
    *planner = (svo_i_planner){.held = NULL};
}
