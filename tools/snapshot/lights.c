/* SPDX-License-Identifier: MIT */
/* Makes the light of a tree in each form. */
#include "lights.h"

#include <inttypes.h>
#include <stdio.h>

#include "digest.h"

static void describe_light(const char *name, const opened *session, svo_tree *tree, svo_light_form form,
                           svo_opacity opacity)
{
    svo_light_options options = SVO_LIGHT_OPTIONS_INIT;
    svo_light_info info = SVO_LIGHT_INFO_INIT;
    svo_light *light = NULL;
    char hash[SVO_HASH_TEXT_BYTES];
    char part[LINE_NAME_BYTES];
    line_text line = {.used = 0};
    options.form = form;
    options.opacity = opacity;
    svo_status status = svo_light_create(tree, &options, session->queue, &light);
    if (status == SVO_OK) {
        status = svo_light_hash(light, session->queue, hash);
    }
    (void)snprintf(part, sizeof part, "light %s %s", svo_light_form_name(form),
                   opacity == SVO_OPACITY_FULL ? "full" : "area");
    if (status == SVO_OK) {
        svo_light_get_info(light, &info);
        line_text_add(&line, "%s %" PRIu64 " bytes, %" PRIu64 " of scratch", hash, info.total_bytes,
                      info.scratch_bytes);
        line_print(name, part, line.text);
    } else {
        line_print_status(name, part, status);
    }
    svo_light_destroy(&light);
}

void describe_lights(const char *name, const opened *session, svo_tree *tree)
{
    for (int form = 0; form < SVO_LIGHT_FORM_COUNT; ++form) {
        describe_light(name, session, tree, (svo_light_form)form, SVO_OPACITY_AREA);
        describe_light(name, session, tree, (svo_light_form)form, SVO_OPACITY_FULL);
    }
}
