/* SPDX-License-Identifier: MIT */
/* What lights a picture without --lights: a sky and a sun that reaches what is in view, or a lamp in closed rooms. */
#ifndef SVOCL_TOOLS_SUPPORT_DEFAULT_LIGHTS_H
#define SVOCL_TOOLS_SUPPORT_DEFAULT_LIGHTS_H

#include <stdbool.h>

#include "support/job.h"
#include "svocl/light_types.h"
#include "svocl/trace.h"

typedef enum default_light {
    DEFAULT_LIGHT_NONE = 0, /* lights are given */
    DEFAULT_LIGHT_SUN_BEHIND, /* high over the right shoulder of the viewer */
    DEFAULT_LIGHT_SUN_ELSEWHERE, /* since that one hardly reaches what is in view */
    DEFAULT_LIGHT_EMITTERS, /* none: a closed room is lit by what shines in it */
    DEFAULT_LIGHT_LAMP /* at the camera: no sun reaches what is in view, and it sees no sky */
} default_light;

typedef struct default_lights {
    default_light kind;
    svo_light_source source; /* the sun or the lamp */
    size_t source_count; /* 1; 0 with DEFAULT_LIGHT_EMITTERS */
} default_lights;

/* Radiance from outside, with all of them. */
extern const float default_lights_sky[3];

/* Chooses by rays into the job's tree, which is on the device: of the camera of a picture of so many pixels, and on to
   lights. The same on every run. Returns the exit code. */
int default_lights_choose(program *state, const job *done, const svo_camera *camera, uint32_t width, uint32_t height,
                          default_lights *out);

/* For JSON: "sun behind the camera", "sun", "emitters", "lamp"; of lights that are given "". */
const char *default_lights_name(default_light kind);

/* "lit by a sun along 0.1,-0.9,0.2, ...": of lights that are given "". */
typedef struct default_lights_words {
    char text[160];
} default_lights_words;
default_lights_words default_lights_describe(const default_lights *chosen);

#endif
