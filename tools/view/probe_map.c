/* SPDX-License-Identifier: MIT */
/* Texels to pixels, in the colors of pictures through probes. */
#include "view/probe_map.h"

#include <math.h>
#include <stdlib.h>

#include "support/probe_picture.h"

void probe_map_free(probe_map *map)
{
    free(map->texels);
    free(map->rgba);
    *map = (probe_map){.texels = NULL};
}

static bool make_room(probe_map *map, unsigned edge)
{
    const size_t count = (size_t)edge * edge;
    if (map->edge == edge) {
        return true;
    }
    probe_map_free(map);
    map->texels = malloc(count * 2 * sizeof *map->texels);
    map->rgba = malloc(count * 4);
    map->edge = map->texels != NULL && map->rgba != NULL ? edge : 0;
    return map->edge != 0;
}

static cl_int read_texels(const probe_map *map, const svo_probes *probes, cl_command_queue queue, uint32_t probe)
{
    const size_t bytes = (size_t)map->edge * map->edge * 2 * sizeof *map->texels;
    return clEnqueueReadBuffer(queue, svo_probes_get_buffer(probes, SVO_PROBES_TEXELS), CL_TRUE, probe * bytes, bytes,
                               map->texels, 0, NULL, NULL);
}

/* What a ray along the texel would find. */
static svo_probe_hit hit_of(const svo_probe_info *info, const uint32_t texel[2])
{
    const uint32_t code = texel[0] & SVO_PROBE_NOTHING;
    svo_probe_hit hit = {.t = (float)svo_probe_distance(info, code),
                         .state = code == SVO_PROBE_NOTHING ? SVO_PROBE_MISS : SVO_PROBE_HIT,
                         .normal = texel[0] & ~SVO_PROBE_NOTHING};
    svo_probe_radiance(texel[1], hit.radiance);
    return hit;
}

/* Distances are white at the probe, and nearly black where the farthest surface is that it sees. */
static double farthest_of(const svo_probe_info *info, const probe_map *map)
{
    uint32_t code = 0;
    for (size_t i = 0; i < (size_t)map->edge * map->edge; ++i) {
        const uint32_t other = map->texels[2 * i] & SVO_PROBE_NOTHING;
        code = other != SVO_PROBE_NOTHING && other > code ? other : code;
    }
    return fmax(svo_probe_distance(info, code), (double)info->leaf_edge);
}

static void color(const svo_probe_info *info, probe_map *map)
{
    static const svo_render_view views[VIEW_MAPS] = {SVO_VIEW_SHADED, SVO_VIEW_NORMAL, SVO_VIEW_DEPTH};
    const probe_colors colors = {
        .view = views[map->kind], .farthest = farthest_of(info, map), .exposure = (double)map->exposure};
    for (size_t i = 0; i < (size_t)map->edge * map->edge; ++i) {
        const svo_probe_hit hit = hit_of(info, map->texels + 2 * i);
        probe_colors_pixel(&colors, &hit, map->rgba + 4 * i);
    }
}

int probe_map_update(probe_map *map, program *running, const svo_probes *probes, cl_command_queue queue,
                     unsigned version, view_state *state)
{
    view_probes *shown = &state->probes;
    const svo_probe_info *info = &shown->made;
    const float exposure = state->shown.exposure;
    const bool is_other = map->edge != info->resolution || map->version != version || map->probe != shown->chosen;
    const bool is_recolored = map->kind != shown->map || map->exposure < exposure || map->exposure > exposure;
    map->is_new = false;
    shown->texels = NULL;
    if (!shown->has_map || info->probe_count == 0) {
        return PROGRAM_DONE;
    }
    if (!make_room(map, info->resolution)) {
        return program_fail(running, PROGRAM_FAILED, "out of memory for a map of %u x %u texels", info->resolution,
                            info->resolution);
    }
    if (is_other && read_texels(map, probes, queue, shown->chosen) != CL_SUCCESS) {
        return program_fail(running, PROGRAM_FAILED, "the device does not give the map of a probe");
    }
    shown->texels = map->texels;
    map->probe = shown->chosen;
    map->version = version;
    map->kind = shown->map;
    map->exposure = exposure;
    map->is_new = is_other || is_recolored;
    if (map->is_new) {
        color(info, map);
    }
    return PROGRAM_DONE;
}
