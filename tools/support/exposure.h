/* SPDX-License-Identifier: MIT */
/* What the light of a picture is multiplied by: --exposure, or what suits the picture. */
#ifndef SVOCL_TOOLS_SUPPORT_EXPOSURE_H
#define SVOCL_TOOLS_SUPPORT_EXPOSURE_H

#include "support/json.h"
#include "support/session.h"
#include "svocl/trace.h"

typedef struct exposure {
    float value; /* as --exposure prints and takes it: three digits */
    bool is_automatic;
    bool is_dark; /* what is in view has no light; the value is 1 */
} exposure;

/* That of a lit tree's pictures which are asked for, whatever exposure they have: by --exposure or automatic, with
   --turntable one for all of the turn. Linear pictures have the light itself: 1. Returns the exit code. */
int exposure_choose(program *state, svo_target lit, const svo_render_options *asked, const session *opened,
                    exposure *out);
/* The automatic one. */
int exposure_measure(program *state, svo_target lit, const svo_render_options *asked, const session *opened,
                     exposure *out);

/* "; exposure 3.2 (automatic)", after other words of a line. */
typedef struct exposure_words {
    char text[48];
} exposure_words;
exposure_words exposure_describe(const exposure *chosen);

/* A line where a picture is black; else nothing. */
void exposure_report_dark(const exposure *chosen);
void exposure_report_json(cJSON *document, const exposure *chosen);

#endif
