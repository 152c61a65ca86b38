/* SPDX-License-Identifier: MIT */
/* Makes the probes of a tree. */
#include "probes.h"

#include <inttypes.h>

#include "digest.h"

static void describe_grid(const char *name, const char *part, const opened *session, const svo_probe_options *options)
{
    svo_probe_info info = SVO_PROBE_INFO_INIT;
    svo_probes *probes = NULL;
    char hash[SVO_HASH_TEXT_BYTES];
    line_text line = {.used = 0};
    svo_status status = svo_probes_create(options, session->queue, &probes);
    if (status == SVO_OK) {
        status = svo_probes_hash(probes, session->queue, hash);
    }
    if (status == SVO_OK) {
        svo_probes_get_info(probes, &info);
        line_text_add(&line, "%s %" PRIu32 " moved, %" PRIu32 " off, %" PRIu64 " rays, %" PRIu64 " for places", hash,
                      info.moved, info.off, info.rays, info.place_rays);
        line_text_add(&line, ", %" PRIu64 " bytes, %" PRIu64 " of scratch", info.total_bytes, info.scratch_bytes);
        line_print(name, part, line.text);
    } else {
        line_print_status(name, part, status);
    }
    svo_probes_destroy(&probes);
}

void describe_probes(const char *name, const opened *session, svo_tree *tree, svo_light *light)
{
    svo_probe_options options = SVO_PROBE_OPTIONS_INIT;
    options.counts[0] = 3;
    options.counts[1] = options.counts[2] = 2;
    options.resolution = 64;
    options.field_size = 16;
    options.tree = tree;
    describe_grid(name, "probes", session, &options);
    options.keep_places = 1;
    options.light = light;
    options.diffuse = 1;
    describe_grid(name, "lit probes", session, &options);
}
