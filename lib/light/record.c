/* SPDX-License-Identifier: MIT */
/* Lights to records and arrays, and back. A light from a file keeps no photons: its first update shoots all of them. */
#include "light/record.h"

#include <math.h>
#include <string.h>

#include "light/light.h"
#include "light/radiance_filter.h"
#include "light/sky.h"
#include "svocl/plan.h"

/* ---- to a record ---- */

void svo_i_light_describe(const svo_light *light, svo_i_stored_light *stored)
{
    const svo_light_info *info = &light->info;
    const svo_light_setup *asked = &light->setup.asked;
    *stored = (svo_i_stored_light){.record = {.form = (uint32_t)info->form,
                                              .opacity = (uint32_t)info->opacity,
                                              .one_side = light->options.one_side != 0 ? 1 : 0,
                                              .has_setup = asked->struct_size != 0 ? 1 : 0,
                                              .unit = light->params.unit,
                                              .view_resolution = asked->view_resolution,
                                              .diagnose = asked->diagnose != 0 ? 1 : 0,
                                              .no_photons = asked->no_photons != 0 ? 1 : 0,
                                              .updatable = asked->updatable != 0 ? 1 : 0,
                                              .source_count = light->setup.source_count,
                                              .finish_count = light->setup.finish_count,
                                              .photons = info->photons,
                                              .photon_hits = info->photon_hits,
                                              .lit_leaves = info->lit_leaves,
                                              .lit_nodes = info->lit_nodes,
                                              .missed_leaves = info->missed_leaves,
                                              .lost_flux = info->lost_flux},
                                   .photons = {.emission_photons = asked->emission_photons,
                                               .bounces = asked->bounces,
                                               .photon_alpha = asked->photon_alpha != 0 ? 1 : 0},
                                   .sources = light->setup.given,
                                   .finishes = light->setup.finishes,
                                   .sky_width = light->params.sky_size & 0xffffu,
                                   .sky_height = light->params.sky_size >> 16};
    memcpy(stored->record.sky, light->params.sky, sizeof stored->record.sky);
    memcpy(stored->record.flux, info->flux, sizeof stored->record.flux);
}

static svo_status read_bytes(const svo_light *light, const char *function, cl_command_queue queue, cl_mem buffer,
                             uint64_t bytes, void *to)
{
    SVO_I_TRY(svo_i_device_queue(light->device, function, queue, &queue));
    const cl_int error = clEnqueueReadBuffer(queue, buffer, CL_TRUE, 0, (size_t)bytes, to, 0, NULL, NULL);
    return error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(light->device, function, "clEnqueueReadBuffer", error);
}

svo_status svo_i_light_read_array(const svo_light *light, const char *function, cl_command_queue queue,
                                  svo_light_buffer buffer, void *array)
{
    return read_bytes(light, function, queue, light->buffers[buffer], light->info.bytes[buffer], array);
}

uint64_t svo_i_light_sky_bytes(const svo_light *light)
{
    return svo_i_sky_map_bytes(light->params.sky_size & 0xffffu, light->params.sky_size >> 16);
}

svo_status svo_i_light_read_sky(const svo_light *light, const char *function, cl_command_queue queue, float *map)
{
    return read_bytes(light, function, queue, light->sky_map, svo_i_light_sky_bytes(light), map);
}

/* ---- what a record's light has ---- */

/* A light without sources has nothing of theirs. */
static bool counts_fit(const svo_tree *tree, const svo_i_light_record *record)
{
    if (record->has_setup == 0 &&
        (record->source_count != 0 || record->finish_count != 0 || record->lit_nodes != 0 || record->lit_leaves != 0)) {
        return false;
    }
    return record->source_count <= SVO_I_LIGHT_SOURCES_MAX && record->finish_count <= SVO_I_LIGHT_FINISHES_MAX &&
           record->lit_leaves <= tree->info.leaf_count && record->lit_nodes <= tree->info.node_count;
}

static bool values_fit(const svo_tree *tree, const svo_i_light_record *record)
{
    const bool has_areas = (tree->info.need & SVO_NEED_PROJECTED_AREA) != 0;
    const uint32_t switches =
        record->one_side | record->has_setup | record->diagnose | record->no_photons | record->updatable;
    return record->form < SVO_LIGHT_FORM_COUNT && record->opacity <= SVO_OPACITY_FULL &&
           (has_areas || record->opacity == SVO_OPACITY_FULL) && switches <= 1 && isfinite(record->unit) &&
           record->unit >= 0.0F;
}

bool svo_i_light_count_arrays(const svo_tree *tree, const svo_i_light_record *record,
                              uint64_t bytes[SVO_LIGHT_BUFFER_COUNT])
{
    svo_light_info info = {.struct_size = sizeof info};
    svo_light_options options = {.struct_size = sizeof options};
    if (!values_fit(tree, record) || !counts_fit(tree, record)) {
        return false;
    }
    options.form = (svo_light_form)record->form;
    options.opacity = (svo_opacity)record->opacity;
    if (svo_light_plan(tree, &options, &info) != SVO_OK) {
        return false;
    }
    memcpy(bytes, info.bytes, sizeof info.bytes);
    if (record->lit_nodes > 0) {
        bytes[SVO_LIGHT_LIT] = svo_i_light_bearers(tree, options.form) * sizeof(cl_uint);
        bytes[SVO_LIGHT_RADIANCE] = record->lit_nodes * svo_i_light_words(options.form) * sizeof(cl_uint);
    }
    bytes[SVO_LIGHT_FLUX] = record->lit_leaves * SVO_FLUX_SUMS * sizeof(cl_ulong);
    return true;
}

/* ---- from a record ---- */

/* Kernels follow places without looking. */
static bool places_fit(const svo_i_stored_light *stored, uint64_t lit_bytes)
{
    const uint32_t *places = stored->arrays[SVO_LIGHT_LIT];
    for (uint64_t i = 0; i < lit_bytes / sizeof *places; ++i) {
        if (places[i] != SVO_NO_NODE && places[i] >= stored->record.lit_nodes) {
            return false;
        }
    }
    return true;
}

static void fill_info(const svo_i_light_record *record, svo_light *light)
{
    svo_light_info *info = &light->info;
    info->photons = record->photons;
    info->photon_hits = record->photon_hits;
    info->lit_leaves = record->lit_leaves;
    info->lit_nodes = record->lit_nodes;
    info->missed_leaves = record->missed_leaves;
    memcpy(info->flux, record->flux, sizeof info->flux);
    info->lost_flux = record->lost_flux;
    light->params.unit = record->unit;
    light->params.flags |= record->lit_nodes > 0 ? SVO_LIGHT_FLAG_LIT : 0;
}

/* setup: receives what the record says; all zero without one. */
static svo_status take_setup(svo_light *light, const char *function, const svo_i_stored_light *stored,
                             svo_light_setup *setup)
{
    const svo_i_light_record *record = &stored->record;
    *setup = (svo_light_setup){.struct_size = 0};
    if (record->has_setup == 0) {
        return SVO_OK;
    }
    *setup = (svo_light_setup){.struct_size = sizeof *setup,
                               .sources = record->source_count > 0 ? stored->sources : NULL,
                               .source_count = (size_t)record->source_count,
                               .finishes = record->finish_count > 0 ? stored->finishes : NULL,
                               .finish_count = (size_t)record->finish_count,
                               .view_resolution = record->view_resolution,
                               .diagnose = record->diagnose,
                               .no_photons = record->no_photons,
                               .updatable = record->updatable,
                               .emission_photons = stored->photons.emission_photons,
                               .bounces = stored->photons.bounces,
                               .photon_alpha = stored->photons.photon_alpha,
                               .sky_map = stored->sky_map,
                               .sky_width = stored->sky_width,
                               .sky_height = stored->sky_height};
    memcpy(setup->sky, record->sky, sizeof setup->sky);
    const svo_status status = svo_i_light_take_setup(light, function, setup);
    return status == SVO_INVALID_ARGUMENT ? SVO_FILE_DAMAGED : status;
}

static svo_status upload_arrays(svo_i_device_work *work, svo_light *light, const svo_i_stored_light *stored,
                                const uint64_t bytes[SVO_LIGHT_BUFFER_COUNT])
{
    for (svo_light_buffer i = 0; i < SVO_LIGHT_BUFFER_COUNT; ++i) {
        light->info.bytes[i] = bytes[i];
        if (bytes[i] > 0) {
            SVO_I_TRY(svo_i_light_buffer(work, light, i));
            SVO_I_TRY(svo_i_work_write(work, light->buffers[i], stored->arrays[i], bytes[i]));
        }
    }
    return svo_i_work_wait(work);
}

static svo_status fill(svo_light *light, const char *function, const svo_i_stored_light *stored,
                       const uint64_t bytes[SVO_LIGHT_BUFFER_COUNT], cl_command_queue queue)
{
    svo_i_device_work work;
    svo_light_setup setup;
    svo_status status = SVO_OK;
    SVO_I_TRY(take_setup(light, function, stored, &setup));
    SVO_I_TRY(svo_i_work_begin(light->device, function, queue, &work));
    SVO_I_TRY_CLEANUP(upload_arrays(&work, light, stored, bytes));
    SVO_I_TRY_CLEANUP(setup.sky_map != NULL ? svo_i_light_make_sky(&work, light, &setup) : SVO_OK);

cleanup:
    svo_i_work_end(&work);
    fill_info(&stored->record, light);
    return status;
}

svo_status svo_i_light_restore(svo_tree *tree, const char *function, const svo_i_stored_light *stored,
                               cl_command_queue queue, svo_light **out)
{
    const svo_i_light_record *record = &stored->record;
    const svo_light_options options = {.struct_size = sizeof options,
                                       .form = (svo_light_form)record->form,
                                       .opacity = (svo_opacity)record->opacity,
                                       .one_side = record->one_side};
    uint64_t bytes[SVO_LIGHT_BUFFER_COUNT];
    svo_light *light = NULL;
    if (!svo_i_light_count_arrays(tree, record, bytes) || !places_fit(stored, bytes[SVO_LIGHT_LIT])) {
        return svo_i_device_fail(tree->device, SVO_FILE_DAMAGED, "%s: lit: a place is not below %llu", function,
                                 (unsigned long long)record->lit_nodes);
    }
    SVO_I_TRY(svo_i_light_new(tree, function, &options, &light));
    const svo_status status = fill(light, function, stored, bytes, queue);
    if (status != SVO_OK) {
        svo_light_destroy(&light);
        return status;
    }
    *out = light;
    return SVO_OK;
}
