/* SPDX-License-Identifier: MIT */
/* A temporary file by mkstemps. */
#define _DEFAULT_SOURCE /* mkstemps */
#include "support/spool.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

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

int spool_write(program *state, spool_file *spool, const void *bytes, size_t byte_count)
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
