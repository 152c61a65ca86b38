/* SPDX-License-Identifier: MIT */
/* Edits of voxels: a hill, a tunnel, trees that are stamped, and the way back. */
#include <inttypes.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "svocl/svocl.h"

#define WIDTH       480
#define HEIGHT      360
#define PICTURE_OUT "edit.ppm"

static const uint8_t grass[4] = {92, 145, 60, 255};
static const uint8_t earth[4] = {120, 84, 58, 255};
static const uint8_t wood[4] = {96, 64, 40, 255};
static const uint8_t leaves[4] = {52, 110, 44, 255};

static svo_edit_step step_of(svo_edit_verb verb, svo_edit_shape shape, const uint8_t color[4])
{
    svo_edit_step step = SVO_EDIT_STEP_INIT;
    step.verb = verb;
    step.shape = shape;
    if (color != NULL)
        memcpy(step.rgba, color, sizeof step.rgba);
    return step;
}

static bool box(svo_edit *edit, svo_edit_verb verb, const double begin[3], const double end[3], const uint8_t color[4],
                svo_message *message)
{
    svo_edit_step step = step_of(verb, SVO_EDIT_BOX, color);
    memcpy(step.begin, begin, sizeof step.begin);
    memcpy(step.end, end, sizeof step.end);
    return svo_edit_apply(edit, &step, message) == SVO_OK;
}

/* A sphere where both ends are the same. */
static bool capsule(svo_edit *edit, svo_edit_verb verb, const double begin[3], const double end[3], double radius,
                    const uint8_t color[4], svo_message *message)
{
    svo_edit_step step = step_of(verb, SVO_EDIT_CAPSULE, color);
    memcpy(step.begin, begin, sizeof step.begin);
    memcpy(step.end, end, sizeof step.end);
    step.radius = radius;
    return svo_edit_apply(edit, &step, message) == SVO_OK;
}

/* A meadow with a hill of earth under grass, and a tunnel through it. y is up. */
static bool make_land(svo_edit *edit, svo_message *message)
{
    return box(edit, SVO_EDIT_SET, (double[]){0, -8, 0}, (double[]){256, 0, 256}, grass, message) &&
           capsule(edit, SVO_EDIT_ADD, (double[]){90, -20, 128}, (double[]){170, -20, 128}, 80, grass, message) &&
           capsule(edit, SVO_EDIT_PAINT, (double[]){90, -20, 128}, (double[]){170, -20, 128}, 77, earth, message) &&
           box(edit, SVO_EDIT_CLEAR, (double[]){0, -200, 0}, (double[]){256, -8, 256}, NULL, message) &&
           capsule(edit, SVO_EDIT_CLEAR, (double[]){130, 12, 20}, (double[]){120, 12, 240}, 14, NULL, message);
}

/* A tree in an edit of its own, which is a stamp. */
static bool make_stamp(svo_edit *stamp, svo_message *message)
{
    return capsule(stamp, SVO_EDIT_SET, (double[]){0.5, 0, 0.5}, (double[]){0.5, 14, 0.5}, 2, wood, message) &&
           capsule(stamp, SVO_EDIT_ADD, (double[]){0.5, 16, 0.5}, (double[]){0.5, 22, 0.5}, 9, leaves, message);
}

static bool plant(svo_edit *edit, const svo_edit *stamp, svo_message *message)
{
    bool done = true;
    for (int32_t i = 0; i < 12 && done; ++i) {
        svo_edit_step step = step_of(SVO_EDIT_ADD, SVO_EDIT_VOXELS, NULL);
        step.other = stamp;
        step.offset[0] = 20 + 20 * i;
        step.offset[2] = 20 + 6 * (i * i % 5);
        done = svo_edit_apply(edit, &step, message) == SVO_OK;
    }
    return done;
}

/* ---- what it looks like ---- */

static bool write_picture(svo_tree *tree)
{
    static uint8_t rgba[WIDTH * HEIGHT * 4];
    const svo_camera camera = {.eye = {60, 120, -160}, .target = {128, 20, 110}, .up = {0, 1, 0}, .vertical_fov = 0.8F};
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

/* Builds the tree of the edit as it is and prints its hash. picture: whether it is drawn. */
static bool show(const svo_edit *edit, svo_device *device, const char *name, bool picture)
{
    char hash[SVO_HASH_TEXT_BYTES];
    svo_edit_info info = SVO_EDIT_INFO_INIT;
    svo_tree *tree = NULL;
    const bool done = svo_edit_get_info(edit, &info) == SVO_OK &&
                      svo_edit_commit(edit, device, 0, NULL, NULL, &tree, NULL) == SVO_OK &&
                      svo_tree_download(tree, NULL) == SVO_OK && svo_tree_hash(tree, SVO_HASH_ALL, hash) == SVO_OK &&
                      (!picture || write_picture(tree));
    if (done)
        printf("%-12s %8" PRIu64 " voxels: %s\n", name, info.voxel_count, hash);
    svo_tree_destroy(&tree);
    return done;
}

static bool run(svo_device *device, svo_edit *edit, svo_edit *stamp, svo_message *message)
{
    if (!make_land(edit, message) || !show(edit, device, "land", false))
        return false;
    if (!make_stamp(stamp, message) || !plant(edit, stamp, message) || !show(edit, device, "trees", true))
        return false;
    for (int i = 0; i < 12; ++i) {
        if (svo_edit_undo(edit) != SVO_OK)
            return false;
    }
    return show(edit, device, "trees undone", false);
}

int main(void)
{
    svo_message message = {""};
    svo_device *device = NULL;
    svo_edit *edit = NULL;
    svo_edit *stamp = NULL;
    const bool done = svo_device_create_default(NULL, &device, &message) == SVO_OK &&
                      svo_edit_create(NULL, NULL, &edit, &message) == SVO_OK &&
                      svo_edit_create(NULL, NULL, &stamp, &message) == SVO_OK && run(device, edit, stamp, &message);
    if (!done) {
        const char *text = device == NULL || message.text[0] != '\0' ? message.text : svo_device_message(device);
        fprintf(stderr, "%s\n", text[0] != '\0' ? text : "no room for the picture");
    }
    svo_edit_destroy(&stamp);
    svo_edit_destroy(&edit);
    svo_device_destroy(&device);
    return done ? 0 : 1;
}
