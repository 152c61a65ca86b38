/* SPDX-License-Identifier: MIT */
/* The handle of probes: creation, new radiance, description, hash. */
#include "svocl/probes.h"

#include <stdio.h>
#include <string.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "core/struct_size.h"
#include "light/handle.h"
#include "probes/field.h"
#include "probes/filter.h"
#include "probes/place.h"
#include "probes/radiance.h"
#include "probes/texels.h"
#include "scene/state.h"

/* ---- names ---- */

const char *svo_probes_buffer_name(svo_probes_buffer buffer)
{
    static const char *const names[SVO_PROBES_BUFFER_COUNT] = {"places", "texels",     "least",
                                                               "field",  "irradiance", "moments"};
    return (unsigned)buffer < SVO_PROBES_BUFFER_COUNT ? names[buffer] : "unknown buffer";
}

const char *svo_probes_stage_name(svo_probes_stage stage)
{
    static const char *const names[SVO_PROBES_STAGE_COUNT] = {"placing", "texels", "radiance",
                                                              "least",   "field",  "prefilter"};
    return (unsigned)stage < SVO_PROBES_STAGE_COUNT ? names[stage] : "unknown stage";
}

/* ---- creation ---- */

/* Waits, takes the time since *start as the stage's, and begins the next. */
static svo_status took(const svo_i_probe_bands *bands, svo_probes_stage stage, double *start)
{
    SVO_I_TRY(svo_i_work_wait(bands->work));
    const double now = svo_i_now_ms();
    bands->probes->info.stage_ms[stage] = now - *start;
    *start = now;
    return SVO_OK;
}

/* Radiance, and what follows from it. */
static svo_status light(const svo_i_probe_bands *bands, double *start)
{
    svo_probes *probes = bands->probes;
    if (probes->light == NULL) {
        return SVO_OK;
    }
    memcpy(probes->params.sky, probes->light->params.sky, sizeof probes->params.sky);
    SVO_I_TRY(svo_i_probes_radiance(bands));
    SVO_I_TRY(took(bands, SVO_PROBES_STAGE_RADIANCE, start));
    if (probes->buffers[SVO_PROBES_IRRADIANCE] == NULL) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_probes_irradiance_maps(bands));
    return took(bands, SVO_PROBES_STAGE_FILTER, start);
}

/* Moments count as a part of the prefilter. */
static svo_status filter_distances(const svo_i_probe_bands *bands)
{
    double *ms = bands->probes->info.stage_ms;
    const double before = ms[SVO_PROBES_STAGE_FILTER];
    double start = svo_i_now_ms();
    if (bands->probes->buffers[SVO_PROBES_MOMENTS] == NULL) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_probes_moments(bands));
    SVO_I_TRY(took(bands, SVO_PROBES_STAGE_FILTER, &start));
    ms[SVO_PROBES_STAGE_FILTER] += before;
    return SVO_OK;
}

static svo_status make_buffers(svo_probes *probes, svo_i_device_work *work)
{
    for (svo_probes_buffer i = 0; i < SVO_PROBES_BUFFER_COUNT; ++i) {
        if (probes->info.bytes[i] > 0) {
            SVO_I_TRY(svo_i_work_result(work, svo_probes_buffer_name(i), probes->info.bytes[i], &probes->buffers[i]));
        }
    }
    return SVO_OK;
}

static svo_status make(svo_probes *probes, svo_i_device_work *work, bool keep_places)
{
    svo_i_probe_bands bands;
    SVO_I_TRY(make_buffers(probes, work));
    SVO_I_TRY(svo_i_probe_bands_begin(probes, work, true, &bands));
    double start = svo_i_now_ms();
    SVO_I_TRY(svo_i_probes_place(&bands, keep_places));
    SVO_I_TRY(took(&bands, SVO_PROBES_STAGE_PLACE, &start));
    SVO_I_TRY(svo_i_probes_texels(&bands));
    SVO_I_TRY(took(&bands, SVO_PROBES_STAGE_TEXELS, &start));
    SVO_I_TRY(svo_i_probes_least(&bands));
    SVO_I_TRY(took(&bands, SVO_PROBES_STAGE_LEAST, &start));
    SVO_I_TRY(svo_i_probes_field(&bands));
    SVO_I_TRY(took(&bands, SVO_PROBES_STAGE_FIELD, &start));
    SVO_I_TRY(light(&bands, &start));
    return filter_distances(&bands);
}

static svo_status run(svo_probes *probes, const char *function, cl_command_queue queue, bool keep_places)
{
    svo_i_device_work work;
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_i_work_begin(probes->device, function, queue, &work));
    SVO_I_TRY_CLEANUP(make(probes, &work, keep_places));
    probes->info.scratch_bytes = work.peak_bytes;

cleanup:
    svo_i_work_end(&work);
    return status;
}

/* probes: tree or scene, and device, are set. */
static svo_status create(const svo_probes *of, const char *function, const svo_probe_options *options,
                         cl_command_queue queue, svo_probes **out)
{
    const svo_i_sight sight = {of->tree, of->scene};
    svo_probe_options asked;
    svo_probe_info info;
    SVO_I_TRY(svo_i_probes_plan(&sight, function, options, &asked, &info));
    if (of->device == NULL) {
        return svo_i_device_fail(NULL, SVO_INVALID_ARGUMENT,
                                 "%s: the tree is not on a device; call svo_tree_upload first", function);
    }
    svo_probes *probes = svo_i_alloc_zeroed(&of->device->memory, 1, sizeof *probes);
    if (probes == NULL) {
        return svo_i_device_fail(of->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for probes", function);
    }
    *probes = *of;
    probes->light = asked.light;
    probes->cones = asked.cones;
    probes->info = info;
    probes->params = svo_i_probes_params(&info);
    probes->params.flags =
        (asked.light != NULL ? SVO_PROBES_FLAG_RADIANCE : 0) | (asked.diffuse != 0 ? SVO_PROBES_FLAG_DIFFUSE : 0);
    const svo_status status = run(probes, function, queue, asked.keep_places != 0);
    if (status != SVO_OK) {
        svo_probes_destroy(&probes);
        return status;
    }
    *out = probes;
    return SVO_OK;
}

svo_status svo_probes_create(svo_tree *tree, const svo_probe_options *options, cl_command_queue queue, svo_probes **out)
{
    static const char function[] = "svo_probes_create";
    if (tree == NULL || out == NULL) {
        return svo_i_device_fail(tree != NULL ? tree->device : NULL, SVO_INVALID_ARGUMENT, "%s: %s is NULL", function,
                                 tree == NULL ? "tree" : "out");
    }
    const svo_probes of = {.tree = tree, .device = tree->device};
    return create(&of, function, options, queue, out);
}

svo_status svo_probes_create_scene(svo_scene *scene, const svo_probe_options *options, cl_command_queue queue,
                                   svo_probes **out)
{
    static const char function[] = "svo_probes_create_scene";
    if (scene == NULL || out == NULL) {
        return svo_i_device_fail(scene != NULL ? scene->device : NULL, SVO_INVALID_ARGUMENT, "%s: %s is NULL", function,
                                 scene == NULL ? "scene" : "out");
    }
    const svo_probes of = {.scene = scene, .device = scene->device};
    return create(&of, function, options, queue, out);
}

svo_status svo_probes_relight(svo_probes *probes, cl_command_queue queue)
{
    static const char function[] = "svo_probes_relight";
    svo_i_device_work work;
    svo_i_probe_bands bands;
    svo_status status = SVO_OK;
    if (probes == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    if (probes->light == NULL) {
        return svo_i_device_fail(probes->device, SVO_INVALID_ARGUMENT, "%s: the probes were made without a light",
                                 function);
    }
    SVO_I_TRY(svo_i_tree_check(probes->tree, function));
    SVO_I_TRY(svo_i_work_begin(probes->device, function, queue, &work));
    SVO_I_TRY_CLEANUP(svo_i_probe_bands_begin(probes, &work, false, &bands));
    double start = svo_i_now_ms();
    SVO_I_TRY_CLEANUP(light(&bands, &start));

cleanup:
    svo_i_work_end(&work);
    return status;
}

void svo_probes_destroy(svo_probes **probes)
{
    if (probes == NULL || *probes == NULL) {
        return;
    }
    for (int i = 0; i < SVO_PROBES_BUFFER_COUNT; ++i) {
        if ((*probes)->buffers[i] != NULL) {
            clReleaseMemObject((*probes)->buffers[i]);
        }
    }
    svo_i_free(*probes);
    *probes = NULL;
}

/* ---- description ---- */

svo_status svo_probes_get_info(const svo_probes *probes, svo_probe_info *info)
{
    return probes != NULL ? svo_i_struct_write(svo_i_device_message(probes->device), "svo_probes_get_info", "info",
                                               &probes->info, info, SVO_I_STRUCT_SIZES(svo_probe_info, stage_ms))
                          : SVO_INVALID_ARGUMENT;
}

cl_mem svo_probes_get_buffer(const svo_probes *probes, svo_probes_buffer buffer)
{
    return probes != NULL && (unsigned)buffer < SVO_PROBES_BUFFER_COUNT ? probes->buffers[buffer] : NULL;
}

/* ---- hash ---- */

/* Bytes that are read at once. */
#define PART_BYTES (UINT64_C(1) << 24)

/* Adds a buffer's length and bytes to a hash. part: PART_BYTES. */
static svo_status hash_buffer(const svo_probes *probes, const char *function, cl_command_queue queue,
                              svo_probes_buffer buffer, void *part, XXH3_state_t *state)
{
    const uint64_t bytes = probes->info.bytes[buffer];
    XXH3_128bits_update(state, &bytes, sizeof bytes);
    for (uint64_t first = 0; first < bytes; first += PART_BYTES) {
        const size_t count = (size_t)(bytes - first < PART_BYTES ? bytes - first : PART_BYTES);
        const cl_int error =
            clEnqueueReadBuffer(queue, probes->buffers[buffer], CL_TRUE, (size_t)first, count, part, 0, NULL, NULL);
        if (error != CL_SUCCESS) {
            return svo_i_device_fail_cl(probes->device, function, "clEnqueueReadBuffer", error);
        }
        XXH3_128bits_update(state, part, count);
    }
    return SVO_OK;
}

static void hash_numbers(const svo_probe_info *info, XXH3_state_t *state)
{
    XXH3_128bits_update(state, info->counts, sizeof info->counts);
    XXH3_128bits_update(state, &info->resolution, sizeof info->resolution);
    XXH3_128bits_update(state, &info->field_size, sizeof info->field_size);
    XXH3_128bits_update(state, info->start, sizeof info->start);
    XXH3_128bits_update(state, info->step, sizeof info->step);
    XXH3_128bits_update(state, info->low, sizeof info->low);
    XXH3_128bits_update(state, info->high, sizeof info->high);
    XXH3_128bits_update(state, &info->leaf_edge, sizeof info->leaf_edge);
    XXH3_128bits_update(state, &info->farthest, sizeof info->farthest);
}

svo_status svo_probes_hash(const svo_probes *probes, cl_command_queue queue, char text[SVO_HASH_TEXT_BYTES])
{
    static const char function[] = "svo_probes_hash";
    XXH3_state_t stack;
    XXH3_state_t *state = &stack;
    svo_status status = SVO_OK;
    if (probes == NULL || text == NULL) {
        return svo_i_device_fail(probes != NULL ? probes->device : NULL, SVO_INVALID_ARGUMENT, "%s: %s is NULL",
                                 function, probes == NULL ? "probes" : "text");
    }
    SVO_I_TRY(svo_i_device_queue(probes->device, function, queue, &queue));
    void *part = svo_i_alloc(&probes->device->memory, PART_BYTES);
    if (part == NULL) {
        return svo_i_device_fail(probes->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %llu bytes", function,
                                 (unsigned long long)PART_BYTES);
    }
    XXH3_INITSTATE(state);
    XXH3_128bits_reset(state);
    hash_numbers(&probes->info, state);
    for (svo_probes_buffer i = 0; i < SVO_PROBES_BUFFER_COUNT; ++i) {
        SVO_I_TRY_CLEANUP(hash_buffer(probes, function, queue, i, part, state));
    }
    const XXH128_hash_t hash = XXH3_128bits_digest(state);
    (void)snprintf(text, SVO_HASH_TEXT_BYTES, "%016llx%016llx", (unsigned long long)hash.high64,
                   (unsigned long long)hash.low64);

cleanup:
    svo_i_free(part);
    return status;
}
