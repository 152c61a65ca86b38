/* SPDX-License-Identifier: MIT */
/* The handle of probes: creation, stage by stage, new radiance, description, hash. */
#include "svocl/probes.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "core/struct_size.h"
#include "light/gather.h"
#include "probes/clear.h"
#include "probes/encoding.h"
#include "probes/place.h"
#include "probes/plan.h"
#include "probes/programs.h"
#include "scene/handle.h"

/* Blocks of a launch. */
#define BAND_BLOCKS (UINT32_C(1) << 20)
/* Pairs of a cell and a probe that a launch looks at, so that none takes long enough for a driver to end it. */
#define BAND_PAIRS (UINT64_C(1) << 27)
/* Moments of a launch. */
#define BAND_MOMENTS (UINT32_C(1) << 16)
/* Fewest cells that irradiance adds up, along a side of a map. */
#define LEAST_CELLS 16u

_Static_assert(sizeof(svo_ray) >= sizeof(cl_float4), "cells fit into the buffer of rays");

/* ---- names ---- */

/* ---- bands of rays ---- */

/* Texel rays of all probes. */
static uint64_t count_texels(const svo_probes *probes)
{
    return (uint64_t)probes->info.probe_count * probes->info.resolution * probes->info.resolution;
}

/* A table of codes as a buffer of the work. */
static svo_status upload_table(svo_i_device_work *work, const char *name, const void *table, size_t entry_bytes,
                               cl_mem *out)
{
    const uint64_t bytes = SVO_I_PROBE_CODES * entry_bytes;
    SVO_I_TRY(svo_i_work_alloc(work, name, bytes, out));
    return svo_i_work_write(work, *out, table, bytes);
}

static svo_status make_thresholds(svo_i_probe_bands *bands)
{
    const svo_probe_info *info = &bands->probes->info;
    svo_i_device_work *work = bands->work;
    uint64_t *thresholds = svo_i_alloc(&work->device->memory, SVO_I_PROBE_CODES * sizeof *thresholds);
    if (thresholds == NULL) {
        return svo_i_device_fail(work->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for codes", work->function);
    }
    svo_i_probe_thresholds(info->farthest, info->leaf_edge, thresholds);
    const svo_status status = upload_table(work, "thresholds", thresholds, sizeof *thresholds, &bands->thresholds);
    svo_i_free(thresholds);
    return status;
}

/* Makes the buffers, which the work owns. with_hits: not for radiance alone. */
static svo_status begin_bands(svo_probes *probes, svo_i_device_work *work, bool with_hits, svo_i_probe_bands *out)
{
    const svo_i_sight sight = {probes->tree, probes->scene};
    *out = (svo_i_probe_bands){.probes = probes,
                               .work = work,
                               .most_rays = svo_i_probes_band_rays(&probes->info),
                               .hit_words = svo_i_sight_hit_words(&sight)};
    const uint64_t hit_bytes = (uint64_t)out->hit_words * sizeof(cl_uint);
    SVO_I_TRY(svo_i_work_alloc(work, "rays", out->most_rays * sizeof(svo_ray), &out->rays));
    if (!with_hits) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_work_alloc(work, "hits", out->most_rays * hit_bytes, &out->hits));
    return make_thresholds(out);
}

/* Launches svo_k_probe_rays for the band that begins with texel ray step->first. Sets step->count and hit_words. */
static svo_status aim_band(const svo_i_probe_bands *bands, svo_probe_step *step)
{
    const svo_probes *probes = bands->probes;
    const uint64_t left = count_texels(probes) - step->first;
    step->count = left < bands->most_rays ? (uint32_t)left : bands->most_rays;
    step->hit_words = bands->hit_words;
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(probes->buffers[SVO_PROBES_PLACES]), SVO_I_ARGUMENT(bands->rays),
                                        SVO_I_ARGUMENT(probes->params), SVO_I_ARGUMENT(*step)};
    SVO_I_TRY(svo_i_work_use(bands->work, &svo_i_program_probes, ""));
    return svo_i_work_launch(bands->work, "svo_k_probe_rays", SVO_I_ARGUMENTS(arguments), step->count);
}

/* ---- texels: kernels/probes/texels.cl and least.cl ---- */

static svo_status trace_band(const svo_i_probe_bands *bands, svo_probe_step *step)
{
    svo_probes *probes = bands->probes;
    SVO_I_TRY(aim_band(bands, step));
    if (probes->is_clear) {
        SVO_I_TRY(svo_i_clear_trace(bands, step->count));
        SVO_I_TRY(svo_i_work_use(bands->work, &svo_i_program_probes, ""));
    } else {
        SVO_I_TRY(svo_i_sight_trace(probes, bands->work, bands->rays, bands->hits, step->count));
    }
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(bands->hits), SVO_I_ARGUMENT(bands->thresholds),
                                        SVO_I_ARGUMENT(probes->buffers[SVO_PROBES_TEXELS]),
                                        SVO_I_ARGUMENT(probes->params), SVO_I_ARGUMENT(*step)};
    return svo_i_work_launch(bands->work, "svo_k_probe_texels", SVO_I_ARGUMENTS(arguments), step->count);
}

/* Traces the rays of all texels: SVO_PROBES_TEXELS without radiance. */
static svo_status make_texels(const svo_i_probe_bands *bands)
{
    const uint64_t texels = count_texels(bands->probes);
    for (uint64_t first = 0; first < texels; first += bands->most_rays) {
        svo_probe_step step = {.first = (uint32_t)first};
        SVO_I_TRY(trace_band(bands, &step));
    }
    return SVO_OK;
}

/* SVO_PROBES_LEAST, of the texels. */
static svo_status make_least(const svo_i_probe_bands *bands)
{
    const svo_probes *probes = bands->probes;
    const uint64_t blocks = count_texels(probes) / SVO_PROBE_BLOCK / SVO_PROBE_BLOCK;
    SVO_I_TRY(svo_i_work_use(bands->work, &svo_i_program_probes, ""));
    for (uint64_t first = 0; first < blocks; first += BAND_BLOCKS) {
        const uint64_t left = blocks - first;
        const svo_probe_step step = {.first = (uint32_t)first,
                                     .count = left < BAND_BLOCKS ? (uint32_t)left : BAND_BLOCKS};
        const svo_i_argument arguments[] = {SVO_I_ARGUMENT(probes->buffers[SVO_PROBES_TEXELS]),
                                            SVO_I_ARGUMENT(probes->buffers[SVO_PROBES_LEAST]),
                                            SVO_I_ARGUMENT(probes->params), SVO_I_ARGUMENT(step)};
        SVO_I_TRY(svo_i_work_launch(bands->work, "svo_k_probe_least", SVO_I_ARGUMENTS(arguments), step.count));
    }
    return SVO_OK;
}

/* ---- radiance, by the room light ---- */

static svo_status shade_band(const svo_i_probe_bands *bands, const svo_i_light_shade *shade, cl_mem radiance,
                             svo_probe_step *step)
{
    const svo_probes *probes = bands->probes;
    SVO_I_TRY(aim_band(bands, step));
    SVO_I_TRY(probes->is_clear ? svo_i_clear_reach(bands, step) : SVO_OK);
    SVO_I_TRY(svo_i_light_shade_rays(shade, bands->rays, radiance, step->count));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(radiance), SVO_I_ARGUMENT(probes->buffers[SVO_PROBES_TEXELS]),
                                        SVO_I_ARGUMENT(probes->params), SVO_I_ARGUMENT(*step)};
    return svo_i_work_launch(bands->work, "svo_k_probe_light", SVO_I_ARGUMENTS(arguments), step->count);
}

/* What the light of the probes shows along the rays of all texels. */
static svo_status make_radiance(const svo_i_probe_bands *bands)
{
    const uint64_t texels = count_texels(bands->probes);
    svo_i_light_shade shade = {.gather = {.cones = 0}};
    cl_mem radiance = NULL;
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_i_work_alloc(bands->work, "radiance", bands->most_rays * sizeof(cl_float) * 3, &radiance));
    SVO_I_TRY_CLEANUP(svo_i_light_shade_begin(bands->work, bands->probes->light, bands->probes->cones, &shade));
    for (uint64_t first = 0; first < texels; first += bands->most_rays) {
        svo_probe_step step = {.first = (uint32_t)first};
        SVO_I_TRY_CLEANUP(shade_band(bands, &shade, radiance, &step));
    }

cleanup:
    svo_i_light_shade_end(&shade);
    return status;
}

/* ---- the field: kernels/probes/field.cl ---- */

/* Cells of a launch. */
static uint32_t band_cells(const svo_probe_info *info)
{
    const uint64_t cells = BAND_PAIRS / info->probe_count;
    return cells < SVO_GROUP_ITEMS ? SVO_GROUP_ITEMS : (uint32_t)cells;
}

/* SVO_PROBES_FIELD, of places and texels: which probes see a cell. */
static svo_status make_field(const svo_i_probe_bands *bands)
{
    const svo_probes *probes = bands->probes;
    const svo_probe_info *info = &probes->info;
    const uint64_t cells = (uint64_t)info->field_size * info->field_size * info->field_size;
    const uint32_t most = band_cells(info);
    svo_probe_step step = {.scale_log2 = -ilogbf(info->leaf_edge)};
    for (int axis = 0; axis < 3; ++axis) {
        step.half_cell[axis] = (float)(((double)info->high[axis] - (double)info->low[axis]) / (2.0 * info->field_size));
    }
    SVO_I_TRY(svo_i_work_use(bands->work, &svo_i_program_probes, ""));
    for (uint64_t first = 0; first < cells; first += most) {
        step.first = (uint32_t)first;
        step.count = cells - first < most ? (uint32_t)(cells - first) : most;
        const svo_i_argument arguments[] = {SVO_I_ARGUMENT(probes->buffers[SVO_PROBES_PLACES]),
                                            SVO_I_ARGUMENT(probes->buffers[SVO_PROBES_TEXELS]),
                                            SVO_I_ARGUMENT(bands->thresholds),
                                            SVO_I_ARGUMENT(probes->buffers[SVO_PROBES_FIELD]),
                                            SVO_I_ARGUMENT(probes->params),
                                            SVO_I_ARGUMENT(step)};
        SVO_I_TRY(svo_i_work_launch(bands->work, "svo_k_probe_field", SVO_I_ARGUMENTS(arguments), step.count));
    }
    return SVO_OK;
}

/* ---- maps for diffuse light: kernels/probes/filter.cl ---- */

/* The edge of these cells in texels: it divides every resolution. */
static uint32_t cell_edge(uint32_t resolution)
{
    uint32_t edge = SVO_PROBES_RESOLUTION_STEP;
    while (edge > 1 && resolution / edge < LEAST_CELLS) {
        edge /= 2;
    }
    return edge;
}

/* Some probes: cells, in the buffer of rays, then their irradiance. */
static svo_status filter_some(const svo_i_probe_bands *bands, svo_probe_step *step, uint32_t probe_count,
                              uint32_t cells)
{
    const svo_probes *probes = bands->probes;
    step->count = probe_count * cells;
    const svo_i_argument average[] = {SVO_I_ARGUMENT(probes->buffers[SVO_PROBES_TEXELS]), SVO_I_ARGUMENT(bands->rays),
                                      SVO_I_ARGUMENT(probes->params), SVO_I_ARGUMENT(*step)};
    SVO_I_TRY(svo_i_work_launch(bands->work, "svo_k_probe_cells", SVO_I_ARGUMENTS(average), step->count));
    step->count = probe_count * SVO_PROBES_IRRADIANCE_TEXELS * SVO_PROBES_IRRADIANCE_TEXELS;
    const svo_i_argument add[] = {SVO_I_ARGUMENT(bands->rays), SVO_I_ARGUMENT(probes->buffers[SVO_PROBES_IRRADIANCE]),
                                  SVO_I_ARGUMENT(probes->params), SVO_I_ARGUMENT(*step)};
    return svo_i_work_launch(bands->work, "svo_k_probe_irradiance", SVO_I_ARGUMENTS(add), step->count);
}

/* SVO_PROBES_IRRADIANCE, of the radiance of texels. */
static svo_status make_irradiance(const svo_i_probe_bands *bands)
{
    const svo_probe_info *info = &bands->probes->info;
    svo_probe_step step = {.cell_edge = cell_edge(info->resolution)};
    const uint32_t across = info->resolution / step.cell_edge;
    const uint32_t cells = across * across;
    const uint32_t most = bands->most_rays / cells;
    SVO_I_TRY(svo_i_work_use(bands->work, &svo_i_program_probe_filter, ""));
    for (uint32_t first = 0; first < info->probe_count; first += most) {
        const uint32_t left = info->probe_count - first;
        step.first = first;
        SVO_I_TRY(filter_some(bands, &step, left < most ? left : most, cells));
    }
    return SVO_OK;
}

static svo_status make_lengths(const svo_i_probe_bands *bands, cl_mem *out)
{
    const svo_probe_info *info = &bands->probes->info;
    svo_i_device_work *work = bands->work;
    uint32_t *lengths = svo_i_alloc(&work->device->memory, SVO_I_PROBE_CODES * sizeof *lengths);
    if (lengths == NULL) {
        return svo_i_device_fail(work->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for codes", work->function);
    }
    svo_i_probe_lengths(info->farthest, info->leaf_edge, lengths);
    const svo_status status = upload_table(work, "lengths", lengths, sizeof *lengths, out);
    svo_i_free(lengths);
    return status;
}

/* SVO_PROBES_MOMENTS, of the distances of texels. */
static svo_status make_moments(const svo_i_probe_bands *bands)
{
    const svo_probes *probes = bands->probes;
    const uint64_t moments = (uint64_t)probes->info.probe_count * SVO_PROBES_MOMENT_TEXELS * SVO_PROBES_MOMENT_TEXELS;
    cl_mem lengths = NULL;
    SVO_I_TRY(make_lengths(bands, &lengths));
    SVO_I_TRY(svo_i_work_use(bands->work, &svo_i_program_probe_filter, ""));
    for (uint64_t first = 0; first < moments; first += BAND_MOMENTS) {
        const uint64_t left = moments - first;
        const svo_probe_step step = {.first = (uint32_t)first,
                                     .count = left < BAND_MOMENTS ? (uint32_t)left : BAND_MOMENTS};
        const svo_i_argument arguments[] = {SVO_I_ARGUMENT(probes->buffers[SVO_PROBES_TEXELS]), SVO_I_ARGUMENT(lengths),
                                            SVO_I_ARGUMENT(probes->buffers[SVO_PROBES_MOMENTS]),
                                            SVO_I_ARGUMENT(probes->params), SVO_I_ARGUMENT(step)};
        SVO_I_TRY(svo_i_work_launch(bands->work, "svo_k_probe_moments", SVO_I_ARGUMENTS(arguments), step.count));
    }
    return SVO_OK;
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

/* Takes the sky of the light as it is now. */
static svo_status take_sky(svo_probes *probes, const char *function)
{
    const svo_light *light = probes->light;
    const cl_int error = light->sky_map != NULL ? clRetainMemObject(light->sky_map) : CL_SUCCESS;
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(probes->device, function, "clRetainMemObject", error);
    }
    svo_i_buffer_release(&probes->sky_map);
    probes->sky_map = light->sky_map;
    probes->params.sky_size = light->params.sky_size;
    memcpy(probes->params.sky, light->params.sky, sizeof probes->params.sky);
    return SVO_OK;
}

/* Radiance, and what follows from it. */
static svo_status light(const svo_i_probe_bands *bands, double *start)
{
    svo_probes *probes = bands->probes;
    if (probes->light == NULL) {
        return SVO_OK;
    }
    SVO_I_TRY(take_sky(probes, bands->work->function));
    SVO_I_TRY(make_radiance(bands));
    SVO_I_TRY(took(bands, SVO_PROBES_STAGE_RADIANCE, start));
    if (probes->buffers[SVO_PROBES_IRRADIANCE] == NULL) {
        return SVO_OK;
    }
    SVO_I_TRY(make_irradiance(bands));
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
    SVO_I_TRY(make_moments(bands));
    SVO_I_TRY(took(bands, SVO_PROBES_STAGE_FILTER, &start));
    ms[SVO_PROBES_STAGE_FILTER] += before;
    return SVO_OK;
}

static svo_status make_buffers(svo_probes *probes, svo_i_device_work *work)
{
    for (svo_probes_buffer i = 0; i < SVO_PROBES_BUFFER_COUNT; ++i) {
        if (probes->info.bytes[i] > 0) {
            SVO_I_TRY(svo_i_work_result(work, svo_name(SVO_NAME_PROBES_BUFFER, i), probes->info.bytes[i],
                                        &probes->buffers[i]));
        }
    }
    return SVO_OK;
}

static svo_status make(svo_probes *probes, svo_i_device_work *work, bool keep_places)
{
    svo_i_probe_bands bands;
    SVO_I_TRY(make_buffers(probes, work));
    SVO_I_TRY(begin_bands(probes, work, true, &bands));
    double start = svo_i_now_ms();
    SVO_I_TRY(svo_i_probes_place(&bands, keep_places));
    SVO_I_TRY(took(&bands, SVO_PROBES_STAGE_PLACE, &start));
    SVO_I_TRY(make_texels(&bands));
    SVO_I_TRY(took(&bands, SVO_PROBES_STAGE_TEXELS, &start));
    SVO_I_TRY(make_least(&bands));
    SVO_I_TRY(took(&bands, SVO_PROBES_STAGE_LEAST, &start));
    SVO_I_TRY(make_field(&bands));
    SVO_I_TRY(took(&bands, SVO_PROBES_STAGE_FIELD, &start));
    SVO_I_TRY(light(&bands, &start));
    return filter_distances(&bands);
}

static svo_status run(svo_probes *probes, const char *function, cl_command_queue queue, bool keep_places)
{
    svo_i_device_work work;
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_i_work_begin(probes->device, function, queue, &work));
    SVO_I_TRY_CLEANUP(svo_i_probes_find_clear(probes, &work));
    SVO_I_TRY_CLEANUP(make(probes, &work, keep_places));
    probes->info.scratch_bytes = work.peak_bytes;

cleanup:
    svo_i_work_end(&work);
    return status;
}

/* What kernels know of probes. */
static svo_probes_params params_of(const svo_probe_info *info)
{
    svo_probes_params params = {.resolution = info->resolution,
                                .probe_count = info->probe_count,
                                .field_size = info->field_size,
                                .leaf_edge = info->leaf_edge,
                                .code_scale = 1.0F / info->leaf_edge,
                                .farthest = info->farthest};
    params.code_log2 = (float)log2(svo_i_probe_growth(info->farthest, info->leaf_edge));
    for (int axis = 0; axis < 3; ++axis) {
        params.start[axis] = info->start[axis];
        params.step[axis] = info->step[axis];
        params.counts[axis] = info->counts[axis];
        params.low[axis] = info->low[axis];
        params.field_scale[axis] = (float)(info->field_size / ((double)info->high[axis] - (double)info->low[axis]));
    }
    return params;
}

svo_status svo_probes_create(const svo_probe_options *options, cl_command_queue queue, svo_probes **out)
{
    static const char function[] = "svo_probes_create";
    svo_probe_options asked;
    svo_probe_info info;
    SVO_I_TRY(svo_i_probes_plan(function, options, &asked, &info));
    svo_device *device = asked.tree != NULL ? asked.tree->device : asked.scene->device;
    if (device == NULL) {
        return SVO_NOT_ON_DEVICE;
    }
    if (out == NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: out is NULL", function);
    }
    svo_probes *probes = svo_i_alloc_zeroed(&device->memory, 1, sizeof *probes);
    if (probes == NULL) {
        return svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for probes", function);
    }
    *probes = (svo_probes){.tree = asked.tree,
                           .scene = asked.scene,
                           .light = asked.light,
                           .device = device,
                           .info = info,
                           .params = params_of(&info),
                           .cones = asked.cones};
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
    SVO_I_TRY_CLEANUP(begin_bands(probes, &work, false, &bands));
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
    svo_i_buffer_release(&(*probes)->sky_map);
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
