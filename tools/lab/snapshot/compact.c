/* SPDX-License-Identifier: MIT */
/* Makes, expands and traces compact trees. */
#include "compact.h"

#include <stdio.h>
#include <stdlib.h>

#include "digest.h"

#define FOOTPRINT 0.01f

static const struct {
    const char *name; /* after that of the form */
    uint32_t minimize, color, other; /* other: of normals and fills */
} merges[] = {{"", 0, 0, 0}, {" merged", 1, 0, 0}, {" merged within tolerances", 1, 16, 4096}};

static svo_status hash_compact(const opened *session, svo_compact *compact, char hash[SVO_HASH_TEXT_BYTES])
{
    const svo_status status = svo_compact_download(compact, session->queue);
    return status != SVO_OK ? status : svo_compact_hash(compact, hash);
}

static svo_status hash_expanded(const opened *session, svo_compact *compact, char hash[SVO_HASH_TEXT_BYTES])
{
    svo_tree *tree = NULL;
    svo_status status = svo_compact_expand(compact, session->queue, &tree);
    if (status == SVO_OK) {
        status = svo_tree_download(tree, session->queue);
    }
    if (status == SVO_OK) {
        status = svo_tree_hash(tree, SVO_HASH_ALL, hash);
    }
    svo_tree_destroy(&tree);
    return status;
}

static void print_hash(const char *name, const char *part, svo_status status, const char *hash)
{
    if (status == SVO_OK) {
        line_print(name, part, hash);
    } else {
        line_print_status(name, part, status);
    }
}

static void trace_compact(const char *name, const char *part, const opened *session, svo_compact *compact,
                          const svo_ray *rays, size_t ray_count)
{
    svo_voxel_hit *hits = calloc(ray_count, sizeof *hits);
    const svo_status status = hits == NULL
                                  ? SVO_OUT_OF_HOST_MEMORY
                                  : svo_trace_voxels(svo_compact_target(compact), svo_in_host(rays), svo_in_host(hits),
                                                     ray_count, FOOTPRINT, 0, &(svo_submit){.queue = session->queue});
    if (status == SVO_OK) {
        line_print_digest(name, part, hits, ray_count * sizeof *hits);
    } else {
        line_print_status(name, part, status);
    }
    free(hits);
}

static void describe_one(const char *name, const opened *session, const svo_tree *tree,
                         const svo_compact_options *asked, const char *title, const svo_ray *rays, size_t ray_count)
{
    char part[LINE_NAME_BYTES];
    char hash[SVO_HASH_TEXT_BYTES] = "";
    svo_compact *compact = NULL;
    const svo_status made = svo_compact_create(session->device, tree, asked, session->queue, &compact);
    (void)snprintf(part, sizeof part, "compact %s", title);
    if (made != SVO_OK) {
        line_print_status(name, part, made);
        return;
    }
    const svo_status hashed = hash_compact(session, compact, hash);
    print_hash(name, part, hashed, hash);
    (void)snprintf(part, sizeof part, "expanded from %s", title);
    const svo_status expanded = hash_expanded(session, compact, hash);
    print_hash(name, part, expanded, hash);
    (void)snprintf(part, sizeof part, "voxels along rays, %s", title);
    trace_compact(name, part, session, compact, rays, ray_count);
    svo_compact_destroy(&compact);
}

void describe_compact(const char *name, const opened *session, const svo_tree *tree, const svo_ray *rays,
                      size_t ray_count)
{
    for (int form = 0; form < SVO_FORM_COUNT; ++form) {
        for (size_t i = 0; i < sizeof merges / sizeof merges[0]; ++i) {
            const uint32_t color = merges[i].color;
            const svo_compact_options asked = {.struct_size = sizeof asked,
                                               .form = (svo_form)form,
                                               .minimize = merges[i].minimize,
                                               .color_tolerance = {color, color, color, color},
                                               .normal_tolerance = merges[i].other,
                                               .fill_tolerance = merges[i].other};
            char title[64];
            (void)snprintf(title, sizeof title, "%s%s", svo_name(SVO_NAME_FORM, (svo_form)form), merges[i].name);
            describe_one(name, session, tree, &asked, title, rays, ray_count);
        }
    }
}
