/* SPDX-License-Identifier: MIT */
/* Draws the file of a tree page by page. */
#include "paged.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#include "digest.h"
#include "svocl/io.h"
#include "svocl/paged.h"

#define PATH_BYTES     512
#define PICTURE_WIDTH  160
#define PICTURE_HEIGHT 120
#define PICTURE_BYTES  ((size_t)PICTURE_WIDTH * PICTURE_HEIGHT * 4)
#define PICTURES_MAX   40 /* at a stop */

/* Distances from the middle of the picture, as shares of where the camera frames the tree. */
static const float stops[] = {1.0f, 0.6f, 0.3f};
#define STOP_COUNT (sizeof stops / sizeof stops[0])

/* room: as a share of the file. */
static const struct {
    const char *name;
    double room;
    uint32_t page_levels;
} ways[] = {{"all", 1.2, 3}, {"a third", 0.33, 3}, {"a tenth", 0.1, 3}, {"a third in small pages", 0.33, 2}};

typedef struct paged_case {
    const char *name, *way;
    const opened *session;
    const char *path;
    svo_render_options view;
    uint8_t *rgba;
} paged_case;

/* Pictures until one misses nothing, or nothing more finds room. */
static svo_status refine(const paged_case *of, svo_paged *paged, const svo_render_options *view)
{
    svo_paged_counts counts = SVO_PAGED_COUNTS_INIT;
    for (int i = 0; i < PICTURES_MAX; ++i) {
        svo_status status = svo_paged_render(paged, view, of->rgba);
        (void)svo_paged_get_counts(paged, &counts);
        if (status != SVO_OK || counts.missed_pages == 0) {
            return status;
        }
        status = svo_paged_update(paged);
        (void)svo_paged_get_counts(paged, &counts);
        if (status != SVO_OK || counts.read_pages == 0) {
            return status;
        }
    }
    return SVO_OK;
}

static void print_counts(const paged_case *of, const char *part, const svo_paged *paged)
{
    svo_paged_counts counts = SVO_PAGED_COUNTS_INIT;
    line_text line = {.used = 0};
    (void)svo_paged_get_counts(paged, &counts);
    line_text_add(&line, "pictures %" PRIu64 " missed %" PRIu64 " held %" PRIu64, counts.pictures, counts.missed_pages,
                  counts.held_pages);
    line_text_add(&line, " all missed %" PRIu64 " read %" PRIu64 " bytes %" PRIu64 " evicted %" PRIu64,
                  counts.all_missed_pages, counts.all_read_pages, counts.all_read_bytes, counts.all_evicted_pages);
    line_print(of->name, part, line.text);
}

static void fly(const paged_case *of, svo_paged *paged)
{
    for (size_t stop = 0; stop < STOP_COUNT; ++stop) {
        char part[LINE_NAME_BYTES];
        svo_render_options view = of->view;
        for (int axis = 0; axis < 3; ++axis) {
            const float target = view.camera.target[axis];
            view.camera.eye[axis] = target + stops[stop] * (view.camera.eye[axis] - target);
        }
        (void)snprintf(part, sizeof part, "paged, room for %s, stop %zu", of->way, stop);
        const svo_status status = refine(of, paged, &view);
        if (status == SVO_OK) {
            line_print_digest(of->name, part, of->rgba, PICTURE_BYTES);
        } else {
            line_print_status(of->name, part, status);
        }
        (void)snprintf(part, sizeof part, "paged, room for %s, counts at stop %zu", of->way, stop);
        print_counts(of, part, paged);
    }
}

static void fly_in(const paged_case *of, size_t way, uint64_t file_bytes)
{
    svo_paged_options options = SVO_PAGED_OPTIONS_INIT;
    svo_paged *paged = NULL;
    options.page_levels = ways[way].page_levels;
    const uint64_t budget_bytes = (uint64_t)(ways[way].room * (double)file_bytes);
    const svo_status status = svo_paged_open(of->session->device, of->path, budget_bytes, &options, &paged);
    if (status == SVO_OK) {
        fly(of, paged);
    } else {
        line_print_status(of->name, of->way, status);
    }
    svo_paged_close(&paged);
}

static svo_status measure_file(const paged_case *of, uint64_t *file_bytes)
{
    svo_paged_info info = SVO_PAGED_INFO_INIT;
    svo_paged *paged = NULL;
    const svo_status status = svo_paged_open(of->session->device, of->path, UINT64_MAX, NULL, &paged);
    if (status == SVO_OK) {
        (void)svo_paged_get_info(paged, &info);
        *file_bytes = info.file_bytes;
    }
    svo_paged_close(&paged);
    return status;
}

static void fly_all(paged_case *of, svo_tree *tree, uint64_t file_bytes)
{
    of->view = (svo_render_options){.struct_size = sizeof of->view, .width = PICTURE_WIDTH, .height = PICTURE_HEIGHT};
    (void)svo_camera_fit(svo_tree_target(tree), (float)PICTURE_WIDTH / PICTURE_HEIGHT, &of->view.camera);
    for (size_t way = 0; way < sizeof ways / sizeof ways[0]; ++way) {
        of->way = ways[way].name;
        fly_in(of, way, file_bytes);
    }
}

void describe_paged(const char *name, const opened *session, svo_tree *tree, const char *folder)
{
    char path[PATH_BYTES];
    uint64_t file_bytes = 0;
    paged_case of = {.name = name, .session = session, .path = path, .rgba = malloc(PICTURE_BYTES)};
    (void)snprintf(path, sizeof path, "%s/paged.svo", folder);
    svo_status status = of.rgba != NULL ? svo_tree_save(tree, svo_to_path(path), NULL, NULL) : SVO_OUT_OF_HOST_MEMORY;
    if (status == SVO_OK) {
        status = measure_file(&of, &file_bytes);
    }
    if (status == SVO_OK) {
        fly_all(&of, tree, file_bytes);
    } else {
        line_print_status(name, "paged", status);
    }
    (void)remove(path);
    free(of.rgba);
}
