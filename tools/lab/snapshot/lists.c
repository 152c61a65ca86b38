/* SPDX-License-Identifier: MIT */
/* Lists of voxels to trees and files, and back. */
#include "lists.h"

#include <inttypes.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "compact.h"
#include "digest.h"
#include "random.h"
#include "svocl/io.h"

#define PATH_BYTES   512
#define RAYS         1000 /* for compact trees */
#define VOXELS_COUNT 6000 /* that are given; some are in one place */

/* The random numbers are in [0, 1). */
#define RANDOM_COUNT 4
typedef void list_voxel(size_t index, const float random[RANDOM_COUNT], svo_voxel *out);

/* Around the origin, with 13 materials that have a color each. */
static void scattered(size_t index, const float random[RANDOM_COUNT], svo_voxel *out)
{
    (void)index;
    int32_t *const axes[3] = {&out->x, &out->y, &out->z};
    for (int axis = 0; axis < 3; ++axis) {
        *axes[axis] = (int32_t)(random[axis] * 40) - 20;
    }
    out->material = (uint16_t)(1 + (int)(random[3] * 13));
    for (int i = 0; i < 3; ++i) {
        out->rgba[i] = (uint8_t)(out->material * (7 + 5 * i));
    }
    out->rgba[3] = 255;
}

/* Far apart, which takes several models, with more colors than a palette has. */
static void colorful(size_t index, const float random[RANDOM_COUNT], svo_voxel *out)
{
    out->x = (int32_t)(index % 100) * 7 - 150;
    out->y = (int32_t)(index / 100) * 5;
    out->z = (int32_t)(random[3] * 300);
    for (int i = 0; i < 3; ++i) {
        out->rgba[i] = (uint8_t)(random[i] * 256);
    }
    out->rgba[3] = (uint8_t)(255 - index % 2 * 100);
}

/* A whole block of two colors, whose leaves merge. */
static void block(size_t index, const float random[RANDOM_COUNT], svo_voxel *out)
{
    (void)random;
    out->x = (int32_t)(index % 20);
    out->y = (int32_t)(index / 20 % 20);
    out->z = (int32_t)(index / 400);
    memset(out->rgba, out->x < 8 ? 255 : 90, sizeof out->rgba);
}

static const struct {
    const char *name;
    list_voxel *make;
    double origin[3], edge; /* edge 0: 1 */
} lists[] = {{"voxels scattered", scattered, {0}, 0},
             {"voxels colorful", colorful, {0}, 0},
             {"voxels block", block, {0}, 0},
             {"voxels scattered on a grid of their own", scattered, {0.5, -3, 100}, 0.125}};

static const svo_voxel_property properties[] = {{1, "_type", "_metal"}, {1, "_rough", "0.25"}, {7, "_type", "_glass"}};

/* From beside the grid to points in it. */
static void fill_rays(const svo_tree *tree, svo_ray rays[RAYS])
{
    svo_tree_info info = SVO_TREE_INFO_INIT;
    uint64_t state = 6;
    (void)svo_tree_get_info(tree, &info);
    for (size_t i = 0; i < RAYS; ++i) {
        for (size_t axis = 0; axis < 3; ++axis) {
            const double outside = axis == i % 3 ? 2 : 0;
            const double from = info.origin[axis] + info.edge * ((double)next_random(&state) + outside);
            const double to = info.origin[axis] + info.edge * (double)next_random(&state);
            rays[i].origin[axis] = (float)from;
            rays[i].direction[axis] = (float)(to - from);
        }
        rays[i].t_min = 0;
        rays[i].t_max = INFINITY;
    }
}

/* The tree's leaves as a list again. */
static svo_status print_leaves(const char *name, const char *part, const svo_tree *tree)
{
    char title[LINE_NAME_BYTES];
    svo_voxels_info info = SVO_VOXELS_INFO_INIT;
    svo_voxels *leaves = NULL;
    const svo_status status = svo_tree_get_voxels(tree, &leaves, NULL);
    if (status != SVO_OK) {
        return status;
    }
    (void)svo_voxels_get_info(leaves, &info);
    (void)snprintf(title, sizeof title, "leaves of %s", part);
    line_print_digest(name, title, svo_voxels_get(leaves), (size_t)info.voxel_count * sizeof(svo_voxel));
    svo_voxels_destroy(&leaves);
    return SVO_OK;
}

/* With its compact trees, if asked. */
static void print_tree(const char *name, const char *part, const opened *session, const svo_voxels *list, bool compact)
{
    char hash[SVO_HASH_TEXT_BYTES];
    svo_ray rays[RAYS];
    svo_tree *tree = NULL;
    svo_status status = svo_voxels_build(session->device, list, 0, NULL, session->queue, &tree, NULL);
    if (status == SVO_OK) {
        status = svo_tree_download(tree, session->queue);
    }
    if (status == SVO_OK) {
        status = svo_tree_hash(tree, SVO_HASH_ALL, hash);
    }
    if (status == SVO_OK) {
        line_print(name, part, hash);
        status = print_leaves(name, part, tree);
    }
    if (status != SVO_OK) {
        line_print_status(name, part, status);
    } else if (compact) {
        fill_rays(tree, rays);
        describe_compact(name, session, tree, rays, RAYS);
    }
    svo_tree_destroy(&tree);
}

/* The bytes of the file and, where files of its format are read, the tree of what it holds. .svx files depend on the
   version of libzip. */
static void print_file(const char *name, const opened *session, const svo_voxels *list, svo_voxel_format format,
                       const char *folder)
{
    const char *suffix = svo_name(SVO_NAME_VOXEL_FORMAT, format);
    char path[PATH_BYTES], part[LINE_NAME_BYTES];
    svo_voxels_save_info saved = SVO_VOXELS_SAVE_INFO_INIT;
    line_text line = {.used = 0};
    (void)snprintf(path, sizeof path, "%s/list.%s", folder, suffix);
    (void)snprintf(part, sizeof part, "file .%s", suffix);
    svo_status status = svo_voxels_save(list, svo_to_path(path), format, &saved, NULL);
    if (status != SVO_OK) {
        line_print_status(name, part, status);
        return;
    }
    line_print_file(name, part, path);
    (void)snprintf(part, sizeof part, "report of .%s", suffix);
    line_text_add(&line, "color error %u models %" PRIu64 " colors %" PRIu64 " faces %" PRIu64 " bytes %" PRIu64,
                  (unsigned)saved.color_error, saved.models, saved.colors, saved.faces, saved.bytes);
    line_print(name, part, line.text);
    if (format == SVO_VOXEL_FORMAT_VOX || format == SVO_VOXEL_FORMAT_BINVOX) {
        svo_voxels *loaded = NULL;
        (void)snprintf(part, sizeof part, "tree from .%s", suffix);
        status = svo_voxels_load(svo_from_path(path), NULL, &loaded, NULL, NULL);
        if (status == SVO_OK) {
            print_tree(name, part, session, loaded, false);
        } else {
            line_print_status(name, part, status);
        }
        svo_voxels_destroy(&loaded);
    }
    (void)remove(path);
}

static void describe_list(const char *name, const opened *session, const svo_voxels *list, const char *folder)
{
    static const svo_voxel_format formats[] = {SVO_VOXEL_FORMAT_VOX, SVO_VOXEL_FORMAT_BINVOX, SVO_VOXEL_FORMAT_PLY,
                                               SVO_VOXEL_FORMAT_OBJ};
    svo_voxels_info info = SVO_VOXELS_INFO_INIT;
    line_text line = {.used = 0};
    (void)svo_voxels_get_info(list, &info);
    line_text_add(&line, "%" PRIu64 " of %" PRIu64 " low %d %d %d high %d %d %d depth %u materials %u",
                  info.voxel_count, info.given_count, info.low[0], info.low[1], info.low[2], info.high[0], info.high[1],
                  info.high[2], (unsigned)info.depth, (unsigned)info.material_count);
    line_print(name, "list", line.text);
    line_print_digest(name, "list in order", svo_voxels_get(list), (size_t)info.voxel_count * sizeof(svo_voxel));
    print_tree(name, "tree", session, list, true);
    for (size_t i = 0; i < sizeof formats / sizeof formats[0]; ++i) {
        print_file(name, session, list, formats[i], folder);
    }
}

static svo_status make_list(size_t which, svo_voxel *given, svo_voxels **out, svo_message *message)
{
    uint64_t state = which + 1;
    svo_voxels_source source = {.struct_size = sizeof source,
                                .voxels = given,
                                .voxel_count = VOXELS_COUNT,
                                .properties = properties,
                                .property_count = sizeof properties / sizeof properties[0],
                                .voxel_edge = lists[which].edge};
    memcpy(source.origin, lists[which].origin, sizeof source.origin);
    memset(given, 0, VOXELS_COUNT * sizeof *given);
    for (size_t k = 0; k < VOXELS_COUNT; ++k) {
        float random[RANDOM_COUNT];
        for (int i = 0; i < RANDOM_COUNT; ++i) {
            random[i] = next_random(&state);
        }
        lists[which].make(k, random, &given[k]);
    }
    return svo_voxels_create(&source, out, message);
}

svo_status describe_lists(const opened *session, const char *folder, svo_message *message)
{
    svo_status status = SVO_OK;
    svo_voxel *given = calloc(VOXELS_COUNT, sizeof *given);
    if (given == NULL) {
        return SVO_OUT_OF_HOST_MEMORY;
    }
    for (size_t i = 0; i < sizeof lists / sizeof lists[0]; ++i) {
        svo_voxels *list = NULL;
        status = make_list(i, given, &list, message);
        if (status != SVO_OK) {
            break;
        }
        describe_list(lists[i].name, session, list, folder);
        svo_voxels_destroy(&list);
    }
    free(given);
    return status;
}
