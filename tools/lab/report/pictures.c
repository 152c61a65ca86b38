/* SPDX-License-Identifier: MIT */
/* Builds one tree per scene and renders one picture per view. */
#include "report/pictures.h"

#include <math.h>
#include <stb/stb_image_write.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scenes/scenes.h"
#include "support/session.h"

#define WIDEST_ANGLE 1.6f
#define FALL         0.3f

typedef struct view {
    const char *scene, *quick_scene;
    unsigned depth, quick_depth;
    svo_render_view kind;
    unsigned width, height; /* half of them in quick reports */
    float nearness; /* of the camera: 0: the whole scene in view, 1: at its target */
    const char *name, *caption;
} view;

static const view views[PICTURES_MAX] = {
    {"atrium", "atrium:17000", 10, 7, SVO_VIEW_SHADED, 1120, 700, 0.0f, "atrium",
     "The atrium, shaded with each voxel's color and normal and one shadow ray."},
    {"statue:120000", "statue:10000", 9, 7, SVO_VIEW_NORMAL, 520, 620, 0.0f, "normals",
     "The statue's filtered normals; red, green and blue are x, y and z."},
    {"statue:120000", "statue:10000", 9, 7, SVO_VIEW_STEPS, 520, 620, 0.0f, "steps",
     "Cells visited per ray, from blue to red at 64."},
    {"statue:120000", "statue:10000", 11, 9, SVO_VIEW_LEVEL, 520, 620, 0.72f, "levels",
     "The level at which each ray stopped, one color per level: a ray stops at a node smaller than a pixel."},
};

typedef struct studio {
    program *state;
    session opened;
    const char *scene; /* of the tree; NULL: none yet */
    unsigned depth;
    svo_tree *tree;
} studio;

static int fail(const studio *at, const char *what)
{
    const char *words = svo_device_message(at->opened.device);
    return program_fail(at->state, PROGRAM_FAILED, "picture of %s: %s", what,
                        words[0] != '\0' ? program_words(words) : "out of memory");
}

static int build(studio *at, const char *spec, unsigned depth)
{
    scene *made = NULL;
    svo_plan *plan = NULL;
    svo_message message = {""};
    if (at->scene != NULL && strcmp(at->scene, spec) == 0 && at->depth == depth) {
        return PROGRAM_DONE;
    }
    if (scene_create(spec, &made, &message) != SVO_OK) {
        return program_fail_scene(at->state, SVO_OUT_OF_HOST_MEMORY, message.text);
    }
    svo_tree_destroy(&at->tree);
    const bool worked = svo_plan_create(at->opened.device, scene_mesh(made), depth, NULL, &plan) == SVO_OK &&
                        svo_build(plan, at->opened.frontend, at->opened.queue, &at->tree, NULL) == SVO_OK &&
                        svo_tree_download(at->tree, at->opened.queue) == SVO_OK;
    svo_plan_destroy(&plan);
    scene_destroy(&made);
    at->scene = spec;
    at->depth = depth;
    return worked ? PROGRAM_DONE : fail(at, spec);
}

/* Moves the camera towards its target and down, and widens its angle to keep as much in view. */
static void approach(svo_camera *camera, float nearness)
{
    const float away[3] = {camera->eye[0] - camera->target[0], camera->eye[1] - camera->target[1],
                           camera->eye[2] - camera->target[2]};
    const float distance = sqrtf(away[0] * away[0] + away[1] * away[1] + away[2] * away[2]);
    for (int k = 0; k < 3; ++k) {
        camera->eye[k] -= nearness * away[k];
    }
    camera->eye[1] -= nearness * FALL * distance;
    camera->vertical_fov = fminf(WIDEST_ANGLE, 2.0f * atanf(tanf(0.5f * camera->vertical_fov) / (1.0f - nearness)));
}

/* Makes the background transparent: the color of the first pixel. Not for views with a sky. */
static void cut_out(uint8_t *rgba, size_t pixel_count)
{
    uint32_t ground = 0;
    memcpy(&ground, rgba, sizeof ground);
    for (size_t i = 0; i < pixel_count; ++i) {
        uint32_t pixel = 0;
        memcpy(&pixel, rgba + i * 4, sizeof pixel);
        rgba[i * 4 + 3] = pixel == ground ? 0 : rgba[i * 4 + 3];
    }
}

static void keep_bytes(void *user, void *bytes, int byte_count)
{
    fwrite(bytes, 1, (size_t)byte_count, user);
}

static int draw(const studio *at, const view *wanted, unsigned width, unsigned height, picture *out)
{
    svo_render_options render_options = {
        .struct_size = sizeof render_options, .width = width, .height = height, .view = wanted->kind};
    uint8_t *rgba = malloc((size_t)width * height * 4);
    char *png = NULL;
    FILE *stream = open_memstream(&png, &out->png_bytes);
    bool worked =
        svo_camera_fit(svo_tree_target(at->tree), (float)width / (float)height, &render_options.camera) == SVO_OK;
    approach(&render_options.camera, wanted->nearness);
    worked = worked && rgba != NULL && stream != NULL &&
             svo_render(svo_tree_target(at->tree), &render_options, svo_in_host(rgba),
                        &(svo_submit){.queue = at->opened.queue}) == SVO_OK;
    if (worked && (wanted->kind == SVO_VIEW_NORMAL || wanted->kind == SVO_VIEW_LEVEL)) {
        cut_out(rgba, (size_t)width * height);
    }
    worked =
        worked && stbi_write_png_to_func(keep_bytes, stream, (int)width, (int)height, 4, rgba, (int)width * 4) != 0;
    worked = stream != NULL && fclose(stream) == 0 && worked;
    free(rgba);
    if (!worked) {
        free(png);
        return fail(at, wanted->name);
    }
    out->name = wanted->name;
    out->caption = wanted->caption;
    out->width = width;
    out->height = height;
    out->png = (unsigned char *)png;
    return PROGRAM_DONE;
}

int pictures_make(program *state, bool quick, pictures *out)
{
    studio at = {.state = state};
    *out = (pictures){0};
    int exit_code = session_open_device(state, &at.opened);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    if (svo_frontend_create_cl(at.opened.device, &at.opened.cl) != SVO_OK) {
        exit_code = fail(&at, "every scene");
    }
    at.opened.frontend = at.opened.cl;
    for (size_t i = 0; i < PICTURES_MAX && exit_code == PROGRAM_DONE; ++i) {
        progress_step(state->progress, "drawing pictures");
        exit_code =
            build(&at, quick ? views[i].quick_scene : views[i].scene, quick ? views[i].quick_depth : views[i].depth);
        if (exit_code == PROGRAM_DONE) {
            const unsigned part = quick ? 2 : 1;
            exit_code = draw(&at, &views[i], views[i].width / part, views[i].height / part, &out->list[i]);
            out->count += exit_code == PROGRAM_DONE;
        }
    }
    svo_tree_destroy(&at.tree);
    session_close(&at.opened);
    if (exit_code != PROGRAM_DONE) {
        pictures_free(out);
    }
    return exit_code;
}

void pictures_free(pictures *made)
{
    for (size_t i = 0; i < made->count; ++i) {
        free(made->list[i].png);
    }
    *made = (pictures){0};
}
