/* SPDX-License-Identifier: MIT */
/* Voxels that are given, not made from triangles: a castle to a tree, to a picture, to a .vox file, and back. */
#include <inttypes.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "svocl/io.h"
#include "svocl/svocl.h"

#define WIDTH       480
#define HEIGHT      360
#define EDGE        56 /* of the meadow */
#define WALL        10 /* from the meadow's edge to the wall */
#define VOXELS_MAX  (EDGE * EDGE * 48)
#define FILE_OUT    "castle.vox"
#define PICTURE_OUT "castle.ppm"

enum { GRASS = 1, STONE, DARK, ROOF, WATER, MATERIALS };

/* A .vox file holds materials 1 .. 255 with a color each. */
static const uint8_t colors[MATERIALS][4] = {
    {0}, {92, 145, 60, 255}, {176, 170, 158, 255}, {98, 92, 88, 255}, {178, 62, 44, 255}, {58, 110, 170, 255}};

typedef struct castle {
    svo_voxel voxels[VOXELS_MAX];
    size_t count;
} castle;

/* ---- the castle; z is up, as in .vox files ---- */

static int distance(int a, int b)
{
    return a > b ? a - b : b - a;
}

/* The material at a place on the ground: a meadow with a moat. */
static uint16_t ground(int x, int y)
{
    const int dx = distance(2 * x + 1, EDGE);
    const int dy = distance(2 * y + 1, EDGE);
    const int out = ((dx > dy ? dx : dy) - (EDGE - 2 * WALL)) / 2; /* from the wall on */
    const bool bridge = y < EDGE / 2 && distance(2 * x + 1, EDGE) <= 5;
    return out >= 3 && out < 7 ? (bridge ? DARK : WATER) : GRASS;
}

/* Round, 12 voxels high, with a pointed roof. 0: nothing. */
static uint16_t tower(int dx, int dy, int z)
{
    const int squared = dx * dx + dy * dy;
    const int roof = 17 - z;
    if (z < 12)
        return squared <= 16 ? (z % 5 == 4 ? DARK : STONE) : 0;
    return roof > 0 && squared <= roof * roof ? ROOF : 0;
}

/* Two voxels thick, with a gate and with battlements. */
static uint16_t wall(int x, int y, int z)
{
    const int far = EDGE - 1 - WALL;
    const bool within = x >= WALL && x <= far && y >= WALL && y <= far;
    const bool hollow = x >= WALL + 2 && x <= far - 2 && y >= WALL + 2 && y <= far - 2;
    const bool gate = y < EDGE / 2 && distance(2 * x + 1, EDGE) <= 5 && z < 6;
    if (!within || hollow || gate || z > 8)
        return 0;
    return z < 8 || (x + y) / 2 % 2 == 0 ? STONE : 0;
}

/* In the middle, with windows and a pointed roof. */
static uint16_t keep(int x, int y, int z)
{
    const int dx = distance(2 * x + 1, EDGE) / 2;
    const int dy = distance(2 * y + 1, EDGE) / 2;
    const int wide = dx > dy ? dx : dy;
    if (z < 16)
        return wide <= 7 ? (wide == 7 && z % 6 == 3 && (x + y) % 4 == 0 ? DARK : STONE) : 0;
    return wide + z <= 25 ? ROOF : 0;
}

static uint16_t material_at(int x, int y, int z)
{
    const int near = WALL;
    const int far = EDGE - 1 - WALL;
    if (z < 0)
        return ground(x, y);
    const uint16_t round = tower(x - (x < EDGE / 2 ? near : far), y - (y < EDGE / 2 ? near : far), z);
    const uint16_t middle = round != 0 ? round : keep(x, y, z);
    return middle != 0 ? middle : wall(x, y, z);
}

static void make_castle(castle *out)
{
    for (int i = 0; i < VOXELS_MAX; ++i) {
        const int x = i % EDGE;
        const int y = i / EDGE % EDGE;
        const int z = i / (EDGE * EDGE) - 1;
        const uint16_t material = material_at(x, y, z);
        if (material == 0)
            continue;
        svo_voxel *voxel = &out->voxels[out->count++];
        *voxel = (svo_voxel){.x = x, .y = y, .z = z, .material = material};
        memcpy(voxel->rgba, colors[material], sizeof voxel->rgba);
    }
}

/* ---- trees and files ---- */

static bool build(svo_device *device, const svo_voxels *list, svo_tree **tree, char hash[SVO_HASH_TEXT_BYTES])
{
    return svo_voxels_build(device, list, 0, NULL, NULL, tree, NULL) == SVO_OK &&
           svo_tree_download(*tree, NULL) == SVO_OK && svo_tree_hash(*tree, SVO_HASH_ALL, hash) == SVO_OK;
}

static bool write_picture(svo_tree *tree)
{
    static uint8_t rgba[WIDTH * HEIGHT * 4];
    const svo_camera camera = {.eye = {EDGE * 1.1F, -EDGE * 0.75F, EDGE * 0.85F},
                               .target = {EDGE * 0.5F, EDGE * 0.47F, 6},
                               .up = {0, 0, 1},
                               .vertical_fov = 0.6F};
    const svo_render_options options = {
        .struct_size = sizeof options, .width = WIDTH, .height = HEIGHT, .camera = camera};
    if (svo_render(svo_tree_target(tree), &options, svo_in_host(rgba), NULL) != SVO_OK)
        return false;
    FILE *file = fopen(PICTURE_OUT, "wb");
    if (file == NULL)
        return false;
    bool done = fprintf(file, "P6\n%d %d\n255\n", WIDTH, HEIGHT) > 0;
    for (size_t i = 0; i < (size_t)WIDTH * HEIGHT; ++i) {
        done = fwrite(rgba + 4 * i, 1, 3, file) == 3 && done;
    }
    return fclose(file) == 0 && done;
}

/* The list to a file, the file to a list, and that to a tree, which must be the same. */
static bool there_and_back(svo_device *device, const svo_voxels *list, const char *hash, svo_message *message)
{
    /* z is up in the castle as in .vox files, so nothing is turned. */
    const svo_voxels_load_options as_it_is = {.struct_size = sizeof as_it_is, .axes = SVO_AXES_KEEP};
    svo_voxels_save_info saved = SVO_VOXELS_SAVE_INFO_INIT;
    char again[SVO_HASH_TEXT_BYTES];
    svo_voxels *loaded = NULL;
    svo_tree *tree = NULL;
    const bool done = svo_voxels_save(list, svo_to_path(FILE_OUT), SVO_VOXEL_FORMAT_AUTO, &saved, message) == SVO_OK &&
                      svo_voxels_load(svo_from_path(FILE_OUT), &as_it_is, &loaded, NULL, message) == SVO_OK &&
                      build(device, loaded, &tree, again);
    const bool same = done && strcmp(hash, again) == 0;
    if (done)
        printf("%s: %" PRIu64 " bytes, %" PRIu64 " colors; read again: %s\n", FILE_OUT, saved.bytes, saved.colors,
               same ? "the same tree" : "another tree");
    svo_tree_destroy(&tree);
    svo_voxels_destroy(&loaded);
    return same;
}

static bool run(svo_device *device, const castle *made, svo_message *message)
{
    const svo_voxels_source source = {.struct_size = sizeof source, .voxels = made->voxels, .voxel_count = made->count};
    svo_tree_info info = SVO_TREE_INFO_INIT;
    char hash[SVO_HASH_TEXT_BYTES];
    svo_voxels *list = NULL;
    svo_tree *tree = NULL;
    bool done = svo_voxels_create(&source, &list, message) == SVO_OK &&
                svo_voxels_set_axes(list, SVO_AXES_KEEP) == SVO_OK && build(device, list, &tree, hash) &&
                svo_tree_get_info(tree, &info) == SVO_OK && write_picture(tree);
    if (done)
        printf("castle: %" PRIu64 " voxels, a tree of depth %u with %" PRIu64 " nodes: %s\n", info.leaf_count,
               info.depth, info.node_count, hash);
    done = done && there_and_back(device, list, hash, message);
    svo_tree_destroy(&tree);
    svo_voxels_destroy(&list);
    return done;
}

int main(void)
{
    svo_message message = {""};
    svo_device *device = NULL;
    castle *made = calloc(1, sizeof *made);
    if (made != NULL)
        make_castle(made);
    const bool done =
        made != NULL && svo_device_create_default(NULL, &device, &message) == SVO_OK && run(device, made, &message);
    if (!done) {
        const char *text = device == NULL || message.text[0] != '\0' ? message.text : svo_device_message(device);
        fprintf(stderr, "%s\n", text[0] != '\0' ? text : "no memory, no room for files, or another tree");
    }
    svo_device_destroy(&device);
    free(made);
    return done ? 0 : 1;
}
