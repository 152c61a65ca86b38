/* SPDX-License-Identifier: MIT */
/* Reads placements and keys of motions; placements between keys. */
#include "support/scene_motion.h"

#include <math.h>
#include <stdlib.h>

int scene_place_read_vector(const json_source *source, const cJSON *object, const char *name, float out[3])
{
    const cJSON *value = cJSON_GetObjectItemCaseSensitive(object, name);
    return value != NULL ? json_source_floats(source, value, name, 3, out) : PROGRAM_DONE;
}

/* A number for all axes, or one for each. */
static int read_scale(const json_source *source, const cJSON *object, float out[3])
{
    const cJSON *value = cJSON_GetObjectItemCaseSensitive(object, "scale");
    if (cJSON_IsNumber(value)) {
        if (!(fabs(value->valuedouble) <= 1e30)) {
            return json_source_fail(source, value, "'scale' is not within 1e30");
        }
        out[0] = out[1] = out[2] = (float)value->valuedouble;
    } else {
        const int exit_code = scene_place_read_vector(source, object, "scale", out);
        if (exit_code != PROGRAM_DONE) {
            return exit_code;
        }
    }
    return out[0] != 0.0F && out[1] != 0.0F && out[2] != 0.0F
               ? PROGRAM_DONE
               : json_source_fail(source, value, "'scale' is 0 along an axis");
}

int scene_place_read(const json_source *source, const cJSON *object, scene_place *out)
{
    *out = (scene_place){{0, 0, 0}, {0, 0, 0}, {1, 1, 1}};
    int exit_code = scene_place_read_vector(source, object, "translate", out->translate);
    if (exit_code == PROGRAM_DONE) {
        exit_code = scene_place_read_vector(source, object, "rotate", out->rotate);
    }
    return exit_code == PROGRAM_DONE ? read_scale(source, object, out->scale) : exit_code;
}

static int read_key(const json_source *source, const cJSON *object, scene_key *out)
{
    static const char *const keys[] = {"time", "translate", "rotate", "scale", NULL};
    const cJSON *time = cJSON_GetObjectItemCaseSensitive(object, "time");
    const int exit_code = json_source_check_keys(source, object, "a key of 'motion'", keys);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    if (!cJSON_IsNumber(time) || !(time->valuedouble >= -1e30 && time->valuedouble <= 1e30)) {
        return json_source_fail(source, time != NULL ? time : object, "'time' is missing or not a number within 1e30");
    }
    out->time = (float)time->valuedouble;
    return scene_place_read(source, object, &out->place);
}

int scene_motion_read(const json_source *source, const cJSON *array, scene_motion *out)
{
    const int count = cJSON_IsArray(array) ? cJSON_GetArraySize(array) : 0;
    int exit_code = PROGRAM_DONE;
    if (count < 1) {
        return json_source_fail(source, array, "'motion' is not an array of keys");
    }
    *out = (scene_motion){.keys = calloc((size_t)count, sizeof *out->keys)};
    if (out->keys == NULL) {
        return program_fail(source->state, PROGRAM_FAILED, "out of memory for %d keys", count);
    }
    for (const cJSON *key = array->child; key != NULL && exit_code == PROGRAM_DONE; key = key->next) {
        scene_key *read = &out->keys[out->key_count];
        exit_code = read_key(source, key, read);
        if (exit_code == PROGRAM_DONE && out->key_count > 0 && !(read->time > read[-1].time)) {
            exit_code = json_source_fail(source, key, "'time' is not above that of the key before");
        }
        ++out->key_count;
    }
    if (exit_code != PROGRAM_DONE) {
        free(out->keys);
        *out = (scene_motion){.keys = NULL};
    }
    return exit_code;
}

scene_place scene_motion_at(const scene_motion *motion, float time)
{
    const scene_key *keys = motion->keys;
    size_t next = 0;
    while (next < motion->key_count && keys[next].time <= time) {
        ++next;
    }
    if (next == 0 || next == motion->key_count) {
        return keys[next == 0 ? 0 : next - 1].place;
    }
    const scene_place *from = &keys[next - 1].place;
    const scene_place *to = &keys[next].place;
    const float part = (time - keys[next - 1].time) / (keys[next].time - keys[next - 1].time);
    scene_place place;
    for (int axis = 0; axis < 3; ++axis) {
        place.translate[axis] = from->translate[axis] + part * (to->translate[axis] - from->translate[axis]);
        place.rotate[axis] = from->rotate[axis] + part * (to->rotate[axis] - from->rotate[axis]);
        place.scale[axis] = from->scale[axis] + part * (to->scale[axis] - from->scale[axis]);
    }
    return place;
}
