/* SPDX-License-Identifier: MIT */
/* Copies of sources and finishes. */
#include "light/setup.h"

#include <math.h>
#include <string.h>

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

svo_status svo_i_light_keep_setup(svo_light *light, const char *function, const svo_light_setup *setup)
{
    svo_i_light_setup *kept = &light->setup;
    kept->asked = *setup;
    kept->asked.sources = kept->given = NULL;
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
    return SVO_OK;
}

void svo_i_light_forget_setup(svo_light *light)
{
    svo_i_free(light->setup.given);
    svo_i_free(light->setup.sources);
    svo_i_free(light->setup.finishes);
    light->setup = (svo_i_light_setup){.sources = NULL};
}
