/* SPDX-License-Identifier: MIT */
/* Reads files of lights. */
#include "support/lights_file.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "support/json_source.h"
#include "support/suggest.h"

#define DEGREE 0.017453292519943295
/* Degrees: of a spot, whose angle ends below a right one, and of a camera without its own. */
#define SPOT_ANGLE_MAX 89.9
#define FOV_DEFAULT    60.0
#define FOV_MIN        0.01
#define FOV_MAX        179.0

static const cJSON *member(const cJSON *object, const char *name)
{
    return cJSON_GetObjectItemCaseSensitive(object, name);
}

/* ---- values ---- */

/* A member of three numbers, which must be there. */
static int read_vector(const json_source *source, const cJSON *object, const char *what, const char *name, float out[3])
{
    const cJSON *value = member(object, name);
    return value != NULL ? json_source_floats(source, value, name, 3, out)
                         : json_source_fail(source, object, "%s has no '%s'", what, name);
}

static int read_direction(const json_source *source, const cJSON *object, const char *what, const char *name,
                          float out[3])
{
    const int exit_code = read_vector(source, object, what, name, out);
    const bool is_zero = out[0] == 0.0F && out[1] == 0.0F && out[2] == 0.0F;
    return exit_code == PROGRAM_DONE && is_zero ? json_source_fail(source, member(object, name), "'%s' is zero", name)
                                                : exit_code;
}

/* A member that is an angle within low .. high, degrees; radians go to out. */
static int read_angle(const json_source *source, const cJSON *object, const char *what, const char *name, double low,
                      double high, float *out)
{
    const cJSON *value = member(object, name);
    if (value == NULL) {
        return json_source_fail(source, object, "%s has no '%s'", what, name);
    }
    if (!cJSON_IsNumber(value) || !(value->valuedouble >= low) || !(value->valuedouble <= high)) {
        return json_source_fail(source, value, "'%s' is not a number of degrees within %g .. %g", name, low, high);
    }
    *out = (float)(value->valuedouble * DEGREE);
    return PROGRAM_DONE;
}

/* ---- lights ---- */

/* Of the ball that a light is, world units; 0 where the file has none. */
static int read_radius(const json_source *source, const cJSON *object, float *out)
{
    const cJSON *value = member(object, "radius");
    if (value == NULL) {
        return PROGRAM_DONE;
    }
    if (!cJSON_IsNumber(value) || !(value->valuedouble >= 0) || !isfinite((float)value->valuedouble)) {
        return json_source_fail(source, value, "'radius' is not a number of at least 0");
    }
    *out = (float)value->valuedouble;
    return PROGRAM_DONE;
}

static int read_directional(const json_source *source, const cJSON *object, svo_light_source *out)
{
    static const char *const keys[] = {"kind", "direction", "value", "angular_radius", NULL};
    static const char what[] = "a directional light";
    int exit_code = json_source_check_keys(source, object, what, keys);
    out->kind = SVO_SOURCE_DIRECTIONAL;
    if (exit_code == PROGRAM_DONE) {
        exit_code = read_direction(source, object, what, "direction", out->direction);
    }
    if (exit_code == PROGRAM_DONE && member(object, "angular_radius") != NULL) {
        exit_code = read_angle(source, object, what, "angular_radius", 0, SPOT_ANGLE_MAX, &out->radius);
    }
    return exit_code == PROGRAM_DONE ? sky_file_color(source, object, what, "value", out->value) : exit_code;
}

/* What lights with a place have. turns: a direction too. */
static int read_placed(const json_source *source, const cJSON *object, const char *what, const char *const keys[],
                       bool turns, svo_light_source *out)
{
    int exit_code = json_source_check_keys(source, object, what, keys);
    if (exit_code == PROGRAM_DONE) {
        exit_code = read_vector(source, object, what, "position", out->position);
    }
    if (exit_code == PROGRAM_DONE && turns) {
        exit_code = read_direction(source, object, what, "direction", out->direction);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = read_radius(source, object, &out->radius);
    }
    return exit_code == PROGRAM_DONE ? sky_file_color(source, object, what, "value", out->value) : exit_code;
}

static int read_point(const json_source *source, const cJSON *object, svo_light_source *out)
{
    static const char *const keys[] = {"kind", "position", "value", "radius", NULL};
    out->kind = SVO_SOURCE_POINT;
    return read_placed(source, object, "a point light", keys, false, out);
}

static int read_disk(const json_source *source, const cJSON *object, svo_light_source *out)
{
    static const char *const keys[] = {"kind", "position", "direction", "value", "radius", NULL};
    out->kind = SVO_SOURCE_DISK;
    return read_placed(source, object, "a disk light", keys, true, out);
}

static int read_spot(const json_source *source, const cJSON *object, svo_light_source *out)
{
    static const char *const keys[] = {"kind",   "position",    "direction",   "value",
                                       "radius", "inner_angle", "outer_angle", NULL};
    static const char what[] = "a spot light";
    out->kind = SVO_SOURCE_SPOT;
    int exit_code = read_placed(source, object, what, keys, true, out);
    if (exit_code == PROGRAM_DONE) {
        exit_code = read_angle(source, object, what, "inner_angle", 0, SPOT_ANGLE_MAX, &out->inner_angle);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = read_angle(source, object, what, "outer_angle", 0, SPOT_ANGLE_MAX, &out->outer_angle);
    }
    if (exit_code == PROGRAM_DONE && out->inner_angle >= out->outer_angle) {
        return json_source_fail(source, member(object, "inner_angle"), "'inner_angle' %g is not below 'outer_angle' %g",
                                member(object, "inner_angle")->valuedouble, member(object, "outer_angle")->valuedouble);
    }
    return exit_code;
}

static int read_light(const json_source *source, const cJSON *object, svo_light_source *out)
{
    static const struct {
        const char *name;
        int (*read)(const json_source *source, const cJSON *object, svo_light_source *out);
    } kinds[] = {{"directional", read_directional}, {"point", read_point}, {"spot", read_spot}, {"disk", read_disk}};
    if (!cJSON_IsObject(object)) {
        return json_source_fail(source, object, "a light is not an object");
    }
    const cJSON *kind = member(object, "kind");
    if (!cJSON_IsString(kind)) {
        return json_source_fail(source, kind != NULL ? kind : object,
                                "'kind' of a light is missing or not a text: directional, point, spot or disk");
    }
    suggestion near = suggestion_begin(kind->valuestring, strlen(kind->valuestring));
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; ++i) {
        if (strcmp(kind->valuestring, kinds[i].name) == 0) {
            return kinds[i].read(source, object, out);
        }
        suggestion_offer(&near, kinds[i].name);
    }
    return json_source_fail(source, kind, "kind '%s' of a light is none of directional, point, spot, disk%s",
                            kind->valuestring, suggestion_end(&near).text);
}

static int read_lights(const json_source *source, lights_file *file)
{
    const cJSON *lights = member(source->root, "lights");
    if (lights == NULL) {
        return PROGRAM_DONE;
    }
    if (!cJSON_IsArray(lights) || cJSON_GetArraySize(lights) > LIGHTS_FILE_SOURCES_MAX) {
        return json_source_fail(source, lights, "'lights' is not an array of at most %d lights",
                                LIGHTS_FILE_SOURCES_MAX);
    }
    const size_t count = (size_t)cJSON_GetArraySize(lights);
    file->sources = calloc(count + 1, sizeof *file->sources);
    if (file->sources == NULL) {
        return program_fail(source->state, PROGRAM_FAILED, "out of memory for %zu lights", count);
    }
    int exit_code = PROGRAM_DONE;
    for (const cJSON *light = lights->child; light != NULL && exit_code == PROGRAM_DONE; light = light->next) {
        exit_code = read_light(source, light, &file->sources[file->source_count++]);
    }
    return exit_code;
}

/* ---- sky and camera ---- */

static int read_sky(const json_source *source, lights_file *file)
{
    const cJSON *value = member(source->root, "sky");
    return value != NULL ? sky_file_read(source, value, &file->sky) : PROGRAM_DONE;
}

static int read_camera(const json_source *source, lights_file *file)
{
    static const char *const keys[] = {"eye", "at", "up", "fov", NULL};
    static const char what[] = "'camera'";
    const cJSON *object = member(source->root, "camera");
    if (object == NULL) {
        return PROGRAM_DONE;
    }
    file->camera = (svo_camera){.up = {0, 1, 0}, .vertical_fov = (float)(FOV_DEFAULT * DEGREE)};
    file->has_camera = true;
    int exit_code = json_source_check_keys(source, object, what, keys);
    if (exit_code == PROGRAM_DONE) {
        exit_code = read_vector(source, object, what, "eye", file->camera.eye);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = read_vector(source, object, what, "at", file->camera.target);
    }
    if (exit_code == PROGRAM_DONE && member(object, "up") != NULL) {
        exit_code = read_direction(source, object, what, "up", file->camera.up);
    }
    if (exit_code == PROGRAM_DONE && member(object, "fov") != NULL) {
        exit_code = read_angle(source, object, what, "fov", FOV_MIN, FOV_MAX, &file->camera.vertical_fov);
    }
    return exit_code;
}

/* ---- files ---- */

static int read_file(const json_source *source, lights_file *file)
{
    static const char *const keys[] = {"lights", "sky", "camera", NULL};
    int exit_code = json_source_check_keys(source, source->root, "the file", keys);
    if (exit_code == PROGRAM_DONE) {
        exit_code = read_lights(source, file);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = read_sky(source, file);
    }
    return exit_code == PROGRAM_DONE ? read_camera(source, file) : exit_code;
}

void lights_file_close(lights_file *file)
{
    free(file->sources);
    sky_file_close(&file->sky);
    *file = (lights_file){.sources = NULL};
}

int lights_file_open(program *state, const char *path, lights_file *out)
{
    json_source source;
    *out = (lights_file){.sources = NULL};
    int exit_code = json_source_open(state, path, &source);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = read_file(&source, out);
    json_source_close(&source);
    if (exit_code != PROGRAM_DONE) {
        lights_file_close(out);
    }
    return exit_code;
}

svo_light_setup lights_file_setup(const lights_file *file)
{
    svo_light_setup setup = SVO_LIGHT_SETUP_INIT;
    setup.sources = file->sources;
    setup.source_count = file->source_count;
    memcpy(setup.sky, file->sky.radiance, sizeof setup.sky);
    setup.sky_map = file->sky.texels;
    setup.sky_width = file->sky.width;
    setup.sky_height = file->sky.height;
    return setup;
}
