/* SPDX-License-Identifier: MIT */
/* svo_light_set_sources: checks, and the stages from sources to filtered radiance. */
#include "light/sources.h"

#include <math.h>

#include "core/struct_size.h"
#include "light/again.h"
#include "light/cells.h"
#include "light/exchange.h"
#include "light/kept_nodes.h"
#include "light/photons.h"
#include "light/setup.h"
#include "light/unmet.h"
#include "svocl/plan.h"

static const char function[] = "svo_light_set_sources";

#define SOURCES_MAX  1024u
#define FINISHES_MAX 65535u
#define HALF_PI      1.5707963267948966

/* ---- checks ---- */

/* Refuses a number of a list's entry. what: "sources", ...; field: of the entry. */
static svo_status refuse(const svo_light *light, const char *what, size_t index, const char *field, double value,
                         const char *why)
{
    return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT, "%s: setup.%s[%zu].%s %g %s", function, what, index,
                             field, value, why);
}

/* Numbers that must be finite, and not negative where least is 0. */
static svo_status check_values(const svo_light *light, const char *what, size_t index, const char *field,
                               const float *values, size_t count, bool may_be_negative)
{
    for (size_t i = 0; i < count; ++i) {
        if (!isfinite(values[i])) {
            return refuse(light, what, index, field, (double)values[i], "is not finite");
        }
        if (values[i] < 0.0F && !may_be_negative) {
            return refuse(light, what, index, field, (double)values[i], "is negative");
        }
    }
    return SVO_OK;
}

static svo_status check_angles(const svo_light *light, size_t index, const svo_light_source *source)
{
    SVO_I_TRY(check_values(light, "sources", index, "inner_angle", &source->inner_angle, 1, false));
    SVO_I_TRY(check_values(light, "sources", index, "outer_angle", &source->outer_angle, 1, false));
    if (source->outer_angle <= source->inner_angle) {
        return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT,
                                 "%s: setup.sources[%zu].outer_angle %g is not above inner_angle %g", function, index,
                                 (double)source->outer_angle, (double)source->inner_angle);
    }
    return (double)source->outer_angle < HALF_PI
               ? SVO_OK
               : refuse(light, "sources", index, "outer_angle", (double)source->outer_angle, "is not below pi / 2");
}

static svo_status check_source(const svo_light *light, size_t index, const svo_light_source *source)
{
    const bool has_position = source->kind != SVO_SOURCE_DIRECTIONAL;
    const bool has_direction = source->kind != SVO_SOURCE_POINT;
    if (source->kind > SVO_SOURCE_SPOT) {
        return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT,
                                 "%s: setup.sources[%zu].kind %u is not in 0 .. %u", function, index, source->kind,
                                 SVO_SOURCE_SPOT);
    }
    SVO_I_TRY(check_values(light, "sources", index, "value", source->value, 3, false));
    SVO_I_TRY(check_values(light, "sources", index, "position", source->position, has_position ? 3 : 0, true));
    SVO_I_TRY(check_values(light, "sources", index, "direction", source->direction, has_direction ? 3 : 0, true));
    if (has_direction && source->direction[0] == 0.0F && source->direction[1] == 0.0F && source->direction[2] == 0.0F) {
        return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT, "%s: setup.sources[%zu].direction is zero",
                                 function, index);
    }
    return source->kind == SVO_SOURCE_SPOT ? check_angles(light, index, source) : SVO_OK;
}

static svo_status check_finish(const svo_light *light, size_t index, const svo_finish *finish)
{
    SVO_I_TRY(check_values(light, "finishes", index, "emission", finish->emission, 3, false));
    SVO_I_TRY(check_values(light, "finishes", index, "specular", finish->specular, 3, false));
    SVO_I_TRY(check_values(light, "finishes", index, "exponent", &finish->exponent, 1, false));
    for (int channel = 0; channel < 3; ++channel) {
        if (finish->specular[channel] > 1.0F) {
            return refuse(light, "finishes", index, "specular", (double)finish->specular[channel], "is above 1");
        }
    }
    return SVO_OK;
}

/* Refuses a list that is missing or too long. */
static svo_status check_list(const svo_light *light, const char *what, const void *list, size_t count, size_t most)
{
    if (count > most) {
        return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT, "%s: %zu %s are above %zu", function, count, what,
                                 most);
    }
    return count == 0 || list != NULL
               ? SVO_OK
               : svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT, "%s: setup.%s is NULL", function, what);
}

static svo_status check_setup(const svo_light *light, const svo_light_setup *setup)
{
    SVO_I_TRY(check_list(light, "sources", setup->sources, setup->source_count, SOURCES_MAX));
    SVO_I_TRY(check_list(light, "finishes", setup->finishes, setup->finish_count, FINISHES_MAX));
    /* Lists are not NULL here; the conditions say so to static analysis. */
    for (size_t i = 0; setup->sources != NULL && i < setup->source_count; ++i) {
        SVO_I_TRY(check_source(light, i, &setup->sources[i]));
    }
    for (size_t i = 0; setup->finishes != NULL && i < setup->finish_count; ++i) {
        SVO_I_TRY(check_finish(light, i, &setup->finishes[i]));
    }
    for (int channel = 0; channel < 3; ++channel) {
        if (!isfinite(setup->sky[channel]) || setup->sky[channel] < 0.0F) {
            return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT,
                                     "%s: setup.sky[%d] %g is negative or not finite", function, channel,
                                     (double)setup->sky[channel]);
        }
    }
    return setup->view_resolution <= SVO_I_VIEW_PIXELS_MAX
               ? SVO_OK
               : svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT, "%s: setup.view_resolution %u is above %u",
                                   function, setup->view_resolution, SVO_I_VIEW_PIXELS_MAX);
}

/* ---- photons ---- */

/* The flux that all photons can have together, all channels. */
static double bound_flux(const svo_light_setup *setup, const svo_i_lit_box *box)
{
    svo_i_light_view views[SVO_I_VIEWS_OF_ONE_MAX];
    double bound = 0;
    for (size_t i = 0; i < setup->source_count; ++i) {
        const svo_light_source *source = &setup->sources[i];
        const uint32_t count = svo_i_light_views(source, box, setup->view_resolution, views);
        for (uint32_t k = 0; k < count; ++k) {
            bound += svo_i_view_measure(&views[k]) *
                     ((double)source->value[0] + (double)source->value[1] + (double)source->value[2]);
        }
    }
    return bound;
}

static svo_status shoot_all(svo_i_photons *photons, const svo_light_setup *setup, const svo_i_lit_box *box)
{
    svo_i_light_view views[SVO_I_VIEWS_OF_ONE_MAX];
    for (size_t i = 0; i < setup->source_count; ++i) {
        const svo_light_source *source = &setup->sources[i];
        const uint32_t count =
            svo_i_source_is_dark(source) ? 0 : svo_i_light_views(source, box, setup->view_resolution, views);
        for (uint32_t k = 0; k < count; ++k) {
            SVO_I_TRY(svo_i_photons_shoot(photons, &views[k], source->value));
        }
    }
    return SVO_OK;
}

/* The same with the counts that setup.diagnose asks for. */
static svo_status shoot_and_count(svo_i_photons *photons, const svo_light_setup *setup, const svo_i_lit_box *box,
                                  svo_light_info *info)
{
    uint64_t *codes = NULL;
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_i_codes_of_level(photons->work, photons->tree, photons->tree->info.depth, &codes));
    svo_i_node_map map = {.leaf_codes = codes, .depth = photons->tree->info.depth};
    photons->map = &map;
    SVO_I_TRY_CLEANUP(shoot_all(photons, setup, box));
    SVO_I_TRY_CLEANUP(svo_i_photons_count_unmet(photons, setup, &info->missed_leaves));
    info->node_map_items = map.items;

cleanup:
    photons->map = NULL;
    svo_i_free(codes);
    return status;
}

/* Begins what is kept, or goes on with it. fits: receives whether few photons need to be shot. */
static svo_status begin_kept(svo_i_device_work *work, svo_light *light, const svo_light_setup *setup,
                             const svo_i_lit_box *box, bool *fits)
{
    *fits = false;
    if (light->kept != NULL && light->before != NULL) {
        SVO_I_TRY(svo_i_kept_fits(light->kept, work, light->tree, box, fits));
    }
    if (*fits) {
        return SVO_OK;
    }
    svo_i_kept_destroy(&light->kept);
    if (!svo_i_kept_is_possible(light, setup)) {
        return SVO_OK;
    }
    light->kept = svo_i_alloc_zeroed(&light->device->memory, 1, sizeof *light->kept);
    if (light->kept == NULL) {
        return svo_i_device_fail(light->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for kept photons",
                                 work->function);
    }
    return svo_i_kept_begin(light->kept, work, light->tree, setup, box, light->info.form == SVO_LIGHT_FACES);
}

/* Shoots all photons, or those that changes concern. */
static svo_status shoot(svo_i_photons *photons, svo_light *light, const svo_light_setup *setup,
                        const svo_i_lit_box *box, bool again)
{
    svo_status status = SVO_OK;
    if (again) {
        status = svo_i_photons_shoot_again(photons, light->before);
    } else if (setup->diagnose != 0) {
        status = shoot_and_count(photons, setup, box, &light->info);
    } else {
        status = shoot_all(photons, setup, box);
    }
    svo_i_photons_release_bands(photons);
    return status;
}

/* What became of the flux. */
static svo_status describe_flux(svo_i_photons *photons, svo_light_info *info, svo_i_flux_totals *totals)
{
    double all = 0;
    double lost = 0;
    SVO_I_TRY(svo_i_photons_total(photons, totals));
    for (int channel = 0; channel < 3; ++channel) {
        info->flux[channel] = (double)(totals->in_leaves[channel] + totals->lost[channel]) * photons->unit;
        all += (double)totals->in_leaves[channel] + (double)totals->lost[channel];
        lost += (double)totals->lost[channel];
    }
    info->lost_flux = all > 0 ? lost / all : 0;
    info->photons = photons->shot;
    info->photon_hits = photons->hits_before + photons->hits;
    info->traced_photons = photons->traced;
    return SVO_OK;
}

/* The unit of flux: a power of two with which no sum overflows. */
static double flux_unit(double bound)
{
    int exponent = 0;
    (void)frexp(bound, &exponent); /* bound < 2^exponent */
    return bound > 0 ? ldexp(1.0, exponent - SVO_FLUX_TOTAL_LOG2 + 1) : 1;
}

/* Whether a leaf may reflect a lobe: a material shines, and where radiance has directions there are normals. */
static bool has_lobes(const svo_light *light, const svo_light_setup *setup)
{
    const uint32_t need = light->tree->info.need;
    bool shines = false;
    for (size_t i = 0; setup->finishes != NULL && i < setup->finish_count; ++i) {
        const float *specular = setup->finishes[i].specular;
        shines = shines || specular[0] > 0.0F || specular[1] > 0.0F || specular[2] > 0.0F;
    }
    return shines && (need & SVO_NEED_MATERIAL) != 0 &&
           (light->info.form != SVO_LIGHT_FACES || (need & SVO_NEED_NORMAL) != 0);
}

svo_status svo_i_light_shine(svo_i_device_work *work, svo_light *light, const svo_light_setup *setup,
                             svo_i_lit_leaves *lit)
{
    svo_i_lit_box box = {.leaf_edge = 0};
    svo_i_photons photons;
    svo_i_flux_totals totals;
    *lit = (svo_i_lit_leaves){.unit = 1};
    if (light->tree->info.leaf_count == 0) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_lit_box_of_tree(work, light->tree, &box));
    const double unit = flux_unit(bound_flux(setup, &box));
    const bool faces = light->info.form == SVO_LIGHT_FACES;
    bool again = false;
    SVO_I_TRY(begin_kept(work, light, setup, &box, &again));
    SVO_I_TRY(svo_i_photons_begin(work, light->tree, faces, unit, light->kept, &photons));
    photons.has_lobes = has_lobes(light, setup);
    photons.viewer = light->viewer;
    SVO_I_TRY(shoot(&photons, light, setup, &box, again));
    double *const stage_ms = light->info.stage_ms;
    stage_ms[SVO_LIGHT_STAGE_VIEW] = photons.view_ms;
    SVO_I_TRY(describe_flux(&photons, &light->info, &totals));
    stage_ms[SVO_LIGHT_STAGE_PHOTONS] = photons.sum_ms;
    const double start = svo_i_now_ms();
    SVO_I_TRY(svo_i_light_exchange(&photons, light, setup->finishes, setup->finish_count, lit));
    if (light->kept != NULL) {
        SVO_I_TRY(svo_i_photons_finish_kept(&photons, &totals, again ? light->before->renewed : NULL));
        lit->slots = photons.slots;
        photons.slots = NULL; /* the work releases them at its end */
    }
    light->info.lit_leaves = lit->lit_count;
    light->info.kept_bytes = svo_i_kept_bytes(light->kept) + svo_i_kept_nodes_bytes(light->nodes);
    svo_i_photons_release(&photons);
    return svo_i_light_took(work, light, SVO_LIGHT_STAGE_EXCHANGE, start);
}

/* ---- the light ---- */

/* Takes away what earlier sources have left. */
static void darken(svo_light *light)
{
    svo_light_info *info = &light->info;
    svo_i_light_darken(light);
    svo_i_light_forget_setup(light);
    svo_i_kept_destroy(&light->kept);
    svo_i_kept_nodes_destroy(&light->nodes);
    svo_i_light_release(light, SVO_LIGHT_FLUX);
    for (int i = SVO_LIGHT_STAGE_VIEW; i < SVO_LIGHT_STAGE_COUNT; ++i) {
        info->stage_ms[i] = 0;
    }
    info->photons = info->photon_hits = info->lit_leaves = info->missed_leaves = info->node_map_items = 0;
    info->traced_photons = info->kept_bytes = 0;
    info->flux[0] = info->flux[1] = info->flux[2] = info->lost_flux = 0;
    light->params.sky[0] = light->params.sky[1] = light->params.sky[2] = 0.0F;
}

static svo_status shine(svo_light *light, const char *name, const svo_light_setup *setup, cl_command_queue queue)
{
    svo_i_device_work work;
    svo_i_lit_leaves lit;
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_i_work_begin(light->device, name, queue, &work));
    SVO_I_TRY_CLEANUP(svo_i_light_shine(&work, light, setup, &lit));
    SVO_I_TRY_CLEANUP(svo_i_light_filter(&work, light, &lit));
    if (work.peak_bytes > light->info.scratch_bytes) {
        light->info.scratch_bytes = work.peak_bytes;
    }

cleanup:
    svo_i_work_end(&work);
    return status;
}

svo_status svo_i_light_set(svo_light *light, const char *name, const svo_light_setup *setup, cl_command_queue queue)
{
    svo_light_setup shining = *setup;
    shining.source_count = setup->no_photons != 0 ? 0 : setup->source_count;
    svo_status status = shine(light, name, &shining, queue);
    if (status == SVO_OK) {
        status = svo_i_light_keep_setup(light, name, setup);
    }
    if (status != SVO_OK) {
        darken(light);
        return status;
    }
    for (int channel = 0; channel < 3; ++channel) {
        light->params.sky[channel] = setup->sky[channel];
    }
    return SVO_OK;
}

svo_status svo_light_set_sources(svo_light *light, const svo_light_setup *setup, cl_command_queue queue)
{
    svo_light_setup asked;
    if (light == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    darken(light);
    SVO_I_TRY(svo_i_struct_read(svo_i_device_message(light->device), function, "setup", setup, &asked,
                                SVO_I_STRUCT_SIZES(svo_light_setup, updatable)));
    SVO_I_TRY(check_setup(light, &asked));
    SVO_I_TRY(svo_i_tree_check(light->tree, function));
    return svo_i_light_set(light, function, &asked, queue);
}
