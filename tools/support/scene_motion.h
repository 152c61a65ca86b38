/* SPDX-License-Identifier: MIT */
/*
 * Placements in a scene's file, and how its instances move: placements at times, and between them what lies in
 * between.
 */
#ifndef SVOCL_TOOLS_SUPPORT_SCENE_MOTION_H
#define SVOCL_TOOLS_SUPPORT_SCENE_MOTION_H

#include "support/json_source.h"
#include "support/scene_place.h"

/* The member of that name, three numbers; out stays what it is without one. Returns the exit code. */
int scene_place_read_vector(const json_source *source, const cJSON *object, const char *name, float out[3]);

/* The members translate, rotate and scale, which may be missing. Returns the exit code. */
int scene_place_read(const json_source *source, const cJSON *object, scene_place *out);

typedef struct scene_key {
    float time;
    scene_place place;
} scene_key;

typedef struct scene_motion {
    size_t instance; /* that it moves */
    scene_key *keys; /* owned, by ascending time */
    size_t key_count; /* at least 1 */
} scene_motion;

/* Reads an array of keys. Returns the exit code; on failure nothing is left to free. */
int scene_motion_read(const json_source *source, const cJSON *array, scene_motion *out);
/* The placement at a time; before the first and after the last key it is that of the key. */
scene_place scene_motion_at(const scene_motion *motion, float time);

#endif
