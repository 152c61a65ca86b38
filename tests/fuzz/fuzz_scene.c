/* SPDX-License-Identifier: MIT */
/*
 * Fuzz target: arbitrary bytes as the JSON of a scene (svocl render SCENE.json) and as that of lights (--lights). Each
 * is refused with a message, or all that it holds is in range: indices of trees, numbers
 * that are finite, motions by ascending time. Files that it names are not opened.
 */
#define _GNU_SOURCE /* memfd_create */
#include <math.h>
#include <stdarg.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "fuzz.h"
#include "support/exr_file.h"
#include "support/hdr_file.h"
#include "support/lights_file.h"
#include "support/output.h"
#include "support/scene_file.h"

#define PATH_BYTES 64

/* ---- the rest of the program ---- */

int program_fail(program *state, int exit_code, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(state->last_failure, sizeof state->last_failure, format, arguments);
    va_end(arguments);
    return exit_code;
}

const char *program_words(const char *message)
{
    return message;
}

int output_protect(program *state, const char *path)
{
    (void)state;
    REQUIRE(path[0] != '\0');
    return PROGRAM_DONE;
}

bool exr_file_read(const char *path, uint32_t width_max, uint32_t height_max, hdr_picture *out)
{
    REQUIRE(path[0] != '\0' && width_max > 0 && height_max > 0);
    *out = (hdr_picture){.words = "not read here"};
    return false;
}

bool hdr_file_read(FILE *stream, uint32_t width_max, uint32_t height_max, hdr_picture *out)
{
    REQUIRE(stream != NULL);
    return exr_file_read("picture", width_max, height_max, out);
}

void hdr_file_free(hdr_picture *picture)
{
    REQUIRE(picture->texels == NULL);
}

/* ---- the target ---- */

static void check_failure(const program *state, int exit_code)
{
    REQUIRE(exit_code == PROGRAM_FAILED || exit_code == PROGRAM_WRONG_USAGE);
    REQUIRE(state->last_failure[0] != '\0'); /* the program prints it as one line, whatever names are in it */
}

static void check_camera(const svo_camera *camera)
{
    for (int i = 0; i < 3; ++i) {
        REQUIRE(isfinite(camera->eye[i]) && isfinite(camera->target[i]) && isfinite(camera->up[i]));
    }
    REQUIRE(camera->vertical_fov > 0.0F && camera->vertical_fov < 3.1415927F);
}

static void check_scene(const scene_file *scene)
{
    size_t instance = 0;
    REQUIRE(scene->tree_count > 0 && scene->instance_count > 0 && scene->light_count <= SVO_SCENE_LIGHTS_MAX);
    for (size_t i = 0; i < scene->tree_count; ++i) {
        REQUIRE(scene->trees[i].depth <= 16 && scene->trees[i].path[0] != '\0');
        REQUIRE(memchr(scene->trees[i].path, '\0', SCENE_FILE_PATH_BYTES) != NULL);
    }
    for (size_t i = 0; i < scene->instance_count; ++i) {
        REQUIRE(scene->instances[i].tree < scene->tree_count);
        for (int k = 0; k < 12; ++k) {
            REQUIRE(isfinite(scene->instances[i].transform[k]));
        }
    }
    for (size_t i = 0; i < scene->motion_count; ++i) {
        REQUIRE(scene->motions[i].instance < scene->instance_count && scene->motions[i].instance >= instance);
        instance = scene->motions[i].instance + 1;
        for (size_t k = 1; k < scene->motions[i].key_count; ++k) {
            REQUIRE(scene->motions[i].keys[k - 1].time < scene->motions[i].keys[k].time);
        }
    }
    if (scene->has_camera) {
        check_camera(&scene->camera);
    }
}

static void check_lights(const lights_file *lights)
{
    REQUIRE(lights->source_count <= LIGHTS_FILE_SOURCES_MAX);
    for (size_t i = 0; i < lights->source_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            REQUIRE(isfinite(lights->sources[i].value[k]));
        }
    }
    if (lights->has_camera) {
        check_camera(&lights->camera);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t byte_count)
{
    static program state;
    char path[PATH_BYTES];
    scene_file scene;
    lights_file lights;
    const int file = memfd_create("scene", 0);
    REQUIRE(file >= 0 && (byte_count == 0 || write(file, data, byte_count) == (ssize_t)byte_count));
    (void)snprintf(path, sizeof path, "/proc/self/fd/%d", file);
    int exit_code = scene_file_open(&state, path, &scene);
    if (exit_code == PROGRAM_DONE) {
        check_scene(&scene);
        scene_file_close(&scene);
    } else {
        check_failure(&state, exit_code);
    }
    exit_code = lights_file_open(&state, path, &lights);
    if (exit_code == PROGRAM_DONE) {
        check_lights(&lights);
        lights_file_close(&lights);
    } else {
        check_failure(&state, exit_code);
    }
    (void)close(file);
    return 0;
}
