/* SPDX-License-Identifier: MIT */
/* Makes the light of a tree in each form, shines on it, and lights probes by one of them. */
#include "lights.h"

#include <inttypes.h>
#include <stdio.h>

#include "digest.h"
#include "probes.h"

/* A sun, a lamp in the middle of the grid, and a material that emits. */
static svo_status shine(const opened *session, const svo_tree *tree, svo_light *light)
{
    svo_tree_info info = SVO_TREE_INFO_INIT;
    svo_tree_get_info(tree, &info);
    const svo_light_source sources[2] = {
        {.kind = SVO_SOURCE_DIRECTIONAL, .direction = {-0.3F, -1.0F, -0.2F}, .value = {3.0F, 2.5F, 2.0F}},
        {.kind = SVO_SOURCE_POINT,
         .position = {(float)(info.origin[0] + info.edge / 2), (float)(info.origin[1] + info.edge / 2),
                      (float)(info.origin[2] + info.edge / 2)},
         .value = {1.0F, 1.5F, 2.0F}},
    };
    const svo_finish finishes[2] = {{.exponent = 0}, {.emission = {4.0F, 1.0F, 0.25F}}};
    svo_light_setup setup = SVO_LIGHT_SETUP_INIT;
    setup.sources = sources;
    setup.source_count = 2;
    setup.finishes = finishes;
    setup.finish_count = 2;
    setup.view_resolution = 64;
    setup.diagnose = 1;
    return svo_light_set_sources(light, &setup, session->queue);
}

/* What the sources left: hash, counts and flux. */
static void describe_shining(const char *name, const char *part, const opened *session, const svo_tree *tree,
                             svo_light *light)
{
    svo_light_info info = SVO_LIGHT_INFO_INIT;
    char hash[SVO_HASH_TEXT_BYTES];
    line_text line = {.used = 0};
    svo_status status = shine(session, tree, light);
    if (status == SVO_OK) {
        status = svo_light_hash(light, session->queue, hash);
    }
    if (status != SVO_OK) {
        line_print_status(name, part, status);
        return;
    }
    svo_light_get_info(light, &info);
    line_text_add(&line, "%s %" PRIu64 " photons, %" PRIu64 " hits, %" PRIu64 " leaves, %" PRIu64 " nodes", hash,
                  info.photons, info.photon_hits, info.lit_leaves, info.lit_nodes);
    line_text_add(&line, ", %" PRIu64 " missed, flux %a %a %a, lost %a, %" PRIu64 " of scratch", info.missed_leaves,
                  info.flux[0], info.flux[1], info.flux[2], info.lost_flux, info.scratch_bytes);
    line_print(name, part, line.text);
}

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
    (void)snprintf(part, sizeof part, "light %s %s", svo_name(SVO_NAME_LIGHT_FORM, form),
                   opacity == SVO_OPACITY_FULL ? "full" : "area");
    if (status == SVO_OK) {
        svo_light_get_info(light, &info);
        line_text_add(&line, "%s %" PRIu64 " bytes, %" PRIu64 " of scratch", hash, info.total_bytes,
                      info.scratch_bytes);
        line_print(name, part, line.text);
        (void)snprintf(part, sizeof part, "lit %s %s", svo_name(SVO_NAME_LIGHT_FORM, form),
                       opacity == SVO_OPACITY_FULL ? "full" : "area");
        describe_shining(name, part, session, tree, light);
        if (form == SVO_LIGHT_FACES && opacity == SVO_OPACITY_AREA) {
            describe_probes(name, session, tree, light);
        }
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
