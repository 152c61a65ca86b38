/* SPDX-License-Identifier: MIT */
/* What lights a tree, as the caller describes it: checked, and kept for pictures and updates. */
#include "light/setup.h"

#include <math.h>
#include <string.h>

#include "core/memory.h"
#include "light/sky.h"

#define HALF_PI 1.5707963267948966

static const char set_sources[] = "svo_light_set_sources";

/* ---- checks ---- */

/* Refuses a number of a list's entry. what: "sources", ...; field: of the entry. */
static svo_status refuse(const svo_light *light, const char *what, size_t index, const char *field, double value,
                         const char *why)
{
    return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT, "%s: setup.%s[%zu].%s %g %s", set_sources, what,
                             index, field, value, why);
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
                                 "%s: setup.sources[%zu].outer_angle %g is not above inner_angle %g", set_sources,
                                 index, (double)source->outer_angle, (double)source->inner_angle);
    }
    return (double)source->outer_angle < HALF_PI
               ? SVO_OK
               : refuse(light, "sources", index, "outer_angle", (double)source->outer_angle, "is not below pi / 2");
}

static svo_status check_source(const svo_light *light, size_t index, const svo_light_source *source)
{
    const bool has_position = source->kind != SVO_SOURCE_DIRECTIONAL;
    const bool has_direction = source->kind != SVO_SOURCE_POINT;
    if (source->kind > SVO_SOURCE_DISK) {
        return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT,
                                 "%s: setup.sources[%zu].kind %u is not in 0 .. %u", set_sources, index, source->kind,
                                 SVO_SOURCE_DISK);
    }
    SVO_I_TRY(check_values(light, "sources", index, "value", source->value, 3, false));
    SVO_I_TRY(check_values(light, "sources", index, "position", source->position, has_position ? 3 : 0, true));
    SVO_I_TRY(check_values(light, "sources", index, "direction", source->direction, has_direction ? 3 : 0, true));
    if (has_direction && source->direction[0] == 0.0F && source->direction[1] == 0.0F && source->direction[2] == 0.0F) {
        return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT, "%s: setup.sources[%zu].direction is zero",
                                 set_sources, index);
    }
    SVO_I_TRY(check_values(light, "sources", index, "radius", &source->radius, 1, false));
    if (!has_position && (double)source->radius >= HALF_PI) {
        return refuse(light, "sources", index, "radius", (double)source->radius, "is not below pi / 2");
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
        return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT, "%s: %zu %s are above %zu", set_sources, count,
                                 what, most);
    }
    return count == 0 || list != NULL
               ? SVO_OK
               : svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT, "%s: setup.%s is NULL", set_sources, what);
}

static svo_status check_most(const svo_light *light, const char *field, uint32_t value, uint32_t most)
{
    return value <= most ? SVO_OK
                         : svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT, "%s: setup.%s %u is above %u",
                                             set_sources, field, value, most);
}

svo_status svo_i_light_check_setup(const svo_light *light, const svo_light_setup *setup)
{
    SVO_I_TRY(check_list(light, "sources", setup->sources, setup->source_count, SVO_I_LIGHT_SOURCES_MAX));
    SVO_I_TRY(check_list(light, "finishes", setup->finishes, setup->finish_count, SVO_I_LIGHT_FINISHES_MAX));
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
                                     "%s: setup.sky[%d] %g is negative or not finite", set_sources, channel,
                                     (double)setup->sky[channel]);
        }
    }
    SVO_I_TRY(svo_i_light_check_sky(light, set_sources, setup));
    SVO_I_TRY(check_most(light, "emission_photons", setup->emission_photons, SVO_EMISSION_PHOTONS_MAX));
    SVO_I_TRY(check_most(light, "bounces", setup->bounces, SVO_LIGHT_BOUNCES_MAX));
    return check_most(light, "view_resolution", setup->view_resolution, SVO_I_VIEW_PIXELS_MAX);
}

/* ---- keeping ---- */

/* The direction in unit length, however long it is. */
static void make_unit(float direction[3])
{
    const double x = (double)direction[0];
    const double y = (double)direction[1];
    const double z = (double)direction[2];
    const double length = sqrt(x * x + y * y + z * z);
    if (length > 0) {
        direction[0] = (float)(x / length);
        direction[1] = (float)(y / length);
        direction[2] = (float)(z / length);
    }
}

static void *copy(const svo_light *light, const void *from, size_t count, size_t element_bytes)
{
    void *to = svo_i_alloc_zeroed(&light->device->memory, count, element_bytes);
    if (to != NULL) {
        memcpy(to, from, count * element_bytes);
    }
    return to;
}

void svo_i_light_forget_setup(svo_light *light)
{
    svo_i_free(light->setup.given);
    svo_i_free(light->setup.sources);
    svo_i_free(light->setup.finishes);
    light->setup = (svo_i_light_setup){.sources = NULL};
}

svo_status svo_i_light_keep_setup(svo_light *light, const char *function, const svo_light_setup *setup)
{
    svo_i_light_setup *kept = &light->setup;
    kept->asked = *setup;
    kept->asked.sources = kept->given = NULL;
    kept->asked.sky_map = NULL;
    kept->asked.sky_width = kept->asked.sky_height = 0;
    kept->source_count = setup->source_count;
    kept->finish_count = setup->finish_count;
    if (setup->source_count > 0) {
        kept->given = copy(light, setup->sources, setup->source_count, sizeof *kept->given);
        kept->sources = copy(light, setup->sources, setup->source_count, sizeof *kept->sources);
    }
    if (setup->finish_count > 0) {
        kept->finishes = copy(light, setup->finishes, setup->finish_count, sizeof *kept->finishes);
    }
    if ((setup->source_count > 0 && (kept->given == NULL || kept->sources == NULL)) ||
        (setup->finish_count > 0 && kept->finishes == NULL)) {
        svo_i_light_forget_setup(light);
        return svo_i_device_fail(light->device, SVO_OUT_OF_HOST_MEMORY,
                                 "%s: no memory for %zu sources and %zu finishes", function, setup->source_count,
                                 setup->finish_count);
    }
    kept->asked.sources = kept->given;
    kept->asked.finishes = kept->finishes;
    for (size_t i = 0; i < kept->source_count; ++i) {
        make_unit(kept->sources[i].direction);
    }
    for (int channel = 0; channel < 3; ++channel) {
        light->params.sky[channel] = setup->sky[channel];
    }
    return SVO_OK;
}
