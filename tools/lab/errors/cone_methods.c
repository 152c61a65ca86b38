/* SPDX-License-Identifier: MIT */
/* Ambient occlusion ends at the truth's range; light has none, so the two are gathered apart. */
#include "errors/cone_methods.h"

#include <stdlib.h>

#include "support/input.h"

/* ---- trees and lights ---- */

static bool share_light(const cone_way *a, const cone_way *b)
{
    return a->depth == b->depth && a->coverage == b->coverage && a->form == b->form && a->opacity == b->opacity;
}

svo_tree *cone_lights_tree(cone_lights *lights, unsigned depth, svo_coverage coverage)
{
    const session *opened = &lights->run->opened;
    const svo_plan_options plan_options = {.struct_size = sizeof plan_options,
                                           .need = SVO_NEED_COLOR | SVO_NEED_NORMAL | SVO_NEED_RAYS |
                                                   SVO_NEED_PROJECTED_AREA,
                                           .coverage = coverage};
    for (size_t i = 0; i < lights->tree_count; ++i) {
        if (lights->trees[i].depth == depth && lights->trees[i].coverage == coverage) {
            return lights->trees[i].tree;
        }
    }
    svo_plan *plan = NULL;
    svo_tree *tree = NULL;
    if (svo_plan_create(opened->device, lights->truth->opened.source.mesh, depth, &plan_options, &plan) == SVO_OK &&
        svo_build(plan, opened->cl != NULL ? opened->cl : opened->frontend, opened->queue, &tree, NULL) == SVO_OK) {
        lights->trees[lights->tree_count].depth = depth;
        lights->trees[lights->tree_count].coverage = coverage;
        lights->trees[lights->tree_count++].tree = tree;
    }
    svo_plan_destroy(&plan);
    return tree;
}

static svo_light *find_light(cone_lights *lights, const cone_way *way)
{
    const svo_light_options stored = {.struct_size = sizeof stored, .form = way->form, .opacity = way->opacity};
    for (size_t i = 0; i < lights->light_count; ++i) {
        if (share_light(&lights->lights[i].made_for, way)) {
            return lights->lights[i].light;
        }
    }
    svo_tree *tree = cone_lights_tree(lights, way->depth, way->coverage);
    svo_light *light = NULL;
    if (tree != NULL && svo_light_create(tree, &stored, lights->run->opened.queue, &light) == SVO_OK) {
        lights->lights[lights->light_count].made_for = *way;
        lights->lights[lights->light_count++].light = light;
        if (svo_light_set_sources(light, &lights->truth->setup, lights->run->opened.queue) != SVO_OK) {
            return NULL;
        }
    }
    return light;
}

void cone_lights_free(cone_lights *lights)
{
    for (size_t i = 0; i < lights->light_count; ++i) {
        svo_light_destroy(&lights->lights[i].light);
    }
    for (size_t i = 0; i < lights->tree_count; ++i) {
        svo_tree_destroy(&lights->trees[i].tree);
    }
    lights->light_count = lights->tree_count = 0;
}

/* ---- gathering ---- */

static double gather(const cone_gather *work, bool with_light)
{
    const cone_truth *truth = work->lights->truth;
    const svo_gather_options asked = {.struct_size = sizeof asked,
                                      .cones = work->way.cones,
                                      .march = work->way.march,
                                      .step = work->way.step,
                                      .range = with_light ? 0 : (float)truth->range,
                                      .no_light = !with_light};
    const double started_ms = input_now_ms();
    const svo_status status =
        svo_gather(work->light, truth->points, work->results, truth->count, &asked, work->lights->run->opened.queue);
    return status == SVO_OK ? input_now_ms() - started_ms : -1.0;
}

double cone_gather_occlusion(void *user)
{
    return gather(user, false);
}

double cone_gather_light(void *user)
{
    return gather(user, true);
}

bool cone_gather_make(cone_lights *lights, const cone_way *way, cone_gather *out)
{
    *out = (cone_gather){.lights = lights, .way = *way, .info = SVO_LIGHT_INFO_INIT};
    out->light = find_light(lights, way);
    out->results = calloc(lights->truth->count, sizeof *out->results);
    return out->light != NULL && out->results != NULL && svo_light_get_info(out->light, &out->info) == SVO_OK;
}

void cone_gather_free(cone_gather *work)
{
    free(work->results);
    work->results = NULL;
}

bool cone_gather_compare(cone_gather *work, truth_error *openness, truth_error *irradiance)
{
    const cone_truth *truth = work->lights->truth;
    double *measured = calloc(3 * truth->count, sizeof *measured);
    bool worked = measured != NULL && gather(work, false) >= 0;
    for (size_t i = 0; i < truth->count && worked; ++i) {
        measured[i] = (double)work->results[i].openness;
    }
    if (worked) {
        *openness = cone_truth_openness_error(truth, measured);
        worked = gather(work, true) >= 0;
    }
    for (size_t i = 0; i < 3 * truth->count && worked; ++i) {
        measured[i] = (double)work->results[i / 3].irradiance[i % 3];
    }
    if (worked) {
        *irradiance = cone_truth_irradiance_error(truth, measured);
    }
    free(measured);
    return worked;
}
