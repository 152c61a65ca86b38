/* SPDX-License-Identifier: MIT */
/* Part files to a .svo file by one process, which reads them once, in Morton order. */
#define _POSIX_C_SOURCE 200809L
#include <string.h>

#include "output/output.h"
#include "parts/chunks.h"
#include "svocl/parts.h"

static svo_status fail_errno(const svo_i_stitcher *s, int error)
{
    return svo_i_fail(s->message, svo_i_file_status(error), "%s: cannot be written: %s", s->path, strerror(error));
}

/* One pass over the parts. */
static svo_status put_file(svo_i_stitcher *s)
{
    SVO_I_TRY(svo_i_chunks_put_parts(s));
    SVO_I_TRY(svo_i_chunks_finish(s));
    return svo_i_chunks_put_head(s);
}

static svo_status write_tree(svo_i_stitcher *s)
{
    svo_status status = SVO_OK;
    int error = svo_i_output_open(s->path, NULL, &s->output);
    if (error != 0) {
        return fail_errno(s, error);
    }
    if (s->output.target[0] == '\0') {
        status = svo_i_fail(s->message, SVO_INVALID_ARGUMENT, "svo_parts_stitch: %s is no file", s->path);
        goto cleanup;
    }
    SVO_I_TRY_CLEANUP(put_file(s));
    error = svo_i_output_commit(&s->output);
    status = error == 0 ? SVO_OK : fail_errno(s, error);
cleanup:
    svo_i_output_abandon(&s->output);
    return status;
}

svo_status svo_parts_stitch(const svo_part_header *header, const char *const *paths, size_t part_count,
                            const char *mesh_path, const char *path, svo_message *message)
{
    static const char function[] = "svo_parts_stitch";
    svo_i_stitcher s = {.mesh_path = mesh_path,
                        .path = path,
                        .message = message,
                        .writes = true,
                        .hashes = true,
                        .end = SIZE_MAX,
                        .all = {.message = message}};
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_i_part_header_read(function, header, message, &s.all.header));
    if (path == NULL || (paths == NULL && part_count > 0)) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: %s is NULL", function, path == NULL ? "path" : "paths");
    }
    if ((s.all.header.need & SVO_NEED_RAYS) != 0 && mesh_path == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: mesh_path is NULL, and the tree has SVO_NEED_RAYS",
                          function);
    }
    SVO_I_TRY_CLEANUP(svo_i_pieces_read(&s.all, paths, part_count));
    SVO_I_TRY_CLEANUP(svo_i_chunks_begin(&s));
    status = write_tree(&s);
cleanup:
    svo_i_chunks_free(&s);
    return status;
}
