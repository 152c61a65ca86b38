/* SPDX-License-Identifier: MIT */
/* Reads placements. */
#include "support/scene_place_read.h"

#include <math.h>

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
