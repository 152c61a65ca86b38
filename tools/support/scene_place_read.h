/* SPDX-License-Identifier: MIT */
/* Placements in a scene's file. */
#ifndef SVOCL_TOOLS_SUPPORT_SCENE_PLACE_READ_H
#define SVOCL_TOOLS_SUPPORT_SCENE_PLACE_READ_H

#include "support/json_source.h"
#include "support/scene_place.h"

/* The member of that name, three numbers; out stays what it is without one. Returns the exit code. */
int scene_place_read_vector(const json_source *source, const cJSON *object, const char *name, float out[3]);

/* The members translate, rotate and scale, which may be missing. Returns the exit code. */
int scene_place_read(const json_source *source, const cJSON *object, scene_place *out);

#endif
