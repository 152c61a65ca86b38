/* SPDX-License-Identifier: MIT */
/* What probes look at, by the public batches of rays, one for each kind; options and checks, where probes are, and how
   many bytes and rays they take. */
#include "probes/plan.h"

#include <math.h>

#include "core/device.h"
#include "core/struct_size.h"
#include "light/gather.h"
#include "probes/encoding.h"
#include "rays/batch.h"
#include "rays/rays.h"
#include "scene/handle.h"
#include "svocl/plan.h"
#include "svocl/trace.h"

#define COUNT_DEFAULT      4u
#define RESOLUTION_DEFAULT 256u
#define FIELD_DEFAULT      64u
#define MAX_BYTES_DEFAULT  (UINT64_C(1) << 30)
#define TEXEL_BYTES        8u

/* ---- what probes look at ---- */

static bool has_triangles(const svo_i_sight *sight)
{
    return sight->tree != NULL ? svo_i_rays_of_triangles(&sight->tree->info)
                               : (sight->scene->info.need & SVO_NEED_RAYS) != 0 && !sight->scene->is_clear;
}

/* NULL: not on a device. */
static svo_device *device_of(const svo_i_sight *sight)
{
    return sight->tree != NULL ? sight->tree->device : sight->scene->device;
}

/* Refuses what rays cannot be traced against. */
static svo_status check_sight(const svo_i_sight *sight, const char *function)
{
    svo_ray_params unused;
    if (sight->scene != NULL) {
        return svo_i_scene_check(sight->scene, function);
    }
    SVO_I_TRY(svo_i_tree_check(sight->tree, function));
    return svo_i_rays_tree_params(sight->tree, function, &unused);
}

/* Where it lies. */
typedef struct sight_box {
    double low[3], high[3], leaf_edge;
} sight_box;

/* The smallest edge of a leaf among the instances, world units. */
static double leaf_edge_of(const svo_scene *scene)
{
    double least = (double)scene->boxes[0].leaf_edge;
    for (uint32_t i = 1; i < scene->info.instance_count; ++i) {
        const double edge = (double)scene->boxes[i].leaf_edge;
        least = edge < least ? edge : least;
    }
    return least;
}

static void get_box(const svo_i_sight *sight, sight_box *box)
{
    if (sight->scene != NULL) {
        box->leaf_edge = leaf_edge_of(sight->scene);
        for (int axis = 0; axis < 3; ++axis) {
            box->low[axis] = sight->scene->info.low[axis];
            box->high[axis] = sight->scene->info.high[axis];
        }
        return;
    }
    const svo_tree_info *tree = &sight->tree->info;
    const double width = ldexp(1.0 / tree->scale, (int)tree->snap_bits);
    box->leaf_edge = ldexp(width, -(int)tree->depth);
    for (int axis = 0; axis < 3; ++axis) {
        box->low[axis] = tree->origin[axis];
        box->high[axis] = tree->origin[axis] + width;
    }
}

uint32_t svo_i_sight_hit_words(const svo_i_sight *sight)
{
    const size_t bytes = sight->tree != NULL    ? sizeof(svo_hit)
                         : has_triangles(sight) ? sizeof(svo_scene_triangle_hit)
                                                : sizeof(svo_scene_hit);
    return (uint32_t)(bytes / sizeof(cl_uint));
}

_Static_assert(sizeof(svo_hit) == sizeof(svo_voxel_hit) && offsetof(svo_hit, normal) == 4 * sizeof(cl_uint) &&
                   offsetof(svo_voxel_hit, normal) == 4 * sizeof(cl_uint) &&
                   offsetof(svo_scene_hit, normal) == 4 * sizeof(cl_uint) &&
                   offsetof(svo_scene_triangle_hit, normal) == 4 * sizeof(cl_uint),
               "hits have their normals in words 4 .. 6");

/* Trees by their functions, not as targets, of which a program has the kernels of pictures too. */
static svo_status trace_any(svo_probes *probes, cl_mem rays, cl_mem hits, size_t ray_count, const svo_submit *submit)
{
    const svo_i_sight sight = {probes->tree, probes->scene};
    const svo_array from = svo_in_buffer(rays);
    const svo_array to = svo_in_buffer(hits);
    if (probes->tree != NULL) {
        return has_triangles(&sight)
                   ? svo_i_tree_trace_triangles(probes->tree, &from, &to, ray_count, SVO_TRACE_CLOSEST, submit)
                   : svo_i_tree_trace_voxels(probes->tree, &from, &to, ray_count, 0.0F, 0, submit);
    }
    const svo_target target = svo_scene_target(probes->scene);
    return has_triangles(&sight) ? svo_trace_triangles(target, from, to, ray_count, SVO_SCENE_CLOSEST, submit)
                                 : svo_trace_voxels(target, from, to, ray_count, 0.0F, SVO_SCENE_CLOSEST, submit);
}

svo_status svo_i_sight_trace(svo_probes *probes, svo_i_device_work *work, cl_mem rays, cl_mem hits, size_t ray_count)
{
    cl_event done = NULL;
    const svo_submit submit = {.queue = work->queue,
                               .num_wait = work->last != NULL ? 1 : 0,
                               .wait = work->last != NULL ? &work->last : NULL,
                               .event = &done};
    const svo_status status = trace_any(probes, rays, hits, ray_count, &submit);
    if (status != SVO_OK) {
        svo_i_message_rename(svo_i_device_message(work->device), work->function);
        return status;
    }
    svo_i_work_follow(work, done);
    return SVO_OK;
}

/* ---- checks ---- */

static svo_status check_counts(svo_device *device, const char *function, svo_probe_options *asked)
{
    uint64_t count = 1;
    if (asked->counts[0] == 0 && asked->counts[1] == 0 && asked->counts[2] == 0) {
        asked->counts[0] = asked->counts[1] = asked->counts[2] = COUNT_DEFAULT;
    }
    for (int axis = 0; axis < 3; ++axis) {
        if (asked->counts[axis] < 1 || asked->counts[axis] > SVO_PROBES_MAX) {
            return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.counts[%d] %u is not in 1 .. %u",
                                     function, axis, asked->counts[axis], SVO_PROBES_MAX);
        }
        count *= asked->counts[axis];
    }
    return count <= SVO_PROBES_MAX
               ? SVO_OK
               : svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.counts %u x %u x %u are above %u probes",
                                   function, asked->counts[0], asked->counts[1], asked->counts[2], SVO_PROBES_MAX);
}

static svo_status check_places(svo_device *device, const char *function, const svo_probe_options *asked)
{
    for (int axis = 0; axis < 3; ++axis) {
        if (!(asked->step[axis] >= 0.0F) || !isfinite(asked->step[axis])) {
            return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.step[%d] %g is negative or not finite",
                                     function, axis, (double)asked->step[axis]);
        }
        if (asked->step[axis] > 0.0F && !isfinite(asked->start[axis])) {
            return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.start[%d] %g is not finite", function,
                                     axis, (double)asked->start[axis]);
        }
    }
    return SVO_OK;
}

static svo_status check_sizes(svo_device *device, const char *function, svo_probe_options *asked)
{
    const uint32_t resolution = asked->resolution;
    if (resolution != 0 && (resolution < SVO_PROBES_RESOLUTION_MIN || resolution > SVO_PROBES_RESOLUTION_MAX ||
                            resolution % SVO_PROBES_RESOLUTION_STEP != 0)) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                 "%s: options.resolution %u is not a multiple of %u in %u .. %u", function, resolution,
                                 SVO_PROBES_RESOLUTION_STEP, SVO_PROBES_RESOLUTION_MIN, SVO_PROBES_RESOLUTION_MAX);
    }
    if (asked->field_size > SVO_PROBES_FIELD_MAX) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.field_size %u is not in 1 .. %u", function,
                                 asked->field_size, SVO_PROBES_FIELD_MAX);
    }
    asked->field_size = asked->field_size != 0 ? asked->field_size : FIELD_DEFAULT;
    asked->max_bytes = asked->max_bytes != 0 ? asked->max_bytes : MAX_BYTES_DEFAULT;
    return SVO_OK;
}

static svo_status check_light(const svo_i_sight *sight, const char *function, const svo_probe_options *asked)
{
    svo_device *device = device_of(sight);
    if (asked->light == NULL) {
        return asked->diffuse == 0 ? SVO_OK
                                   : svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                                       "%s: options.diffuse %u needs options.light, which is NULL",
                                                       function, asked->diffuse);
    }
    if (sight->tree == NULL || asked->light->tree != sight->tree) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.light is not of the %s", function,
                                 sight->tree == NULL ? "scene; lights are of trees" : "tree");
    }
    return svo_i_light_check_cones(asked->light, function, asked->cones);
}

/* ---- places ---- */

/* The farthest that a probe can see: any of the box from anywhere in it, where moved probes are too, or its far corner
   from a probe outside. */
static float find_farthest(const svo_probe_info *info)
{
    double inside = 0;
    double outside = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double low = (double)info->low[axis];
        const double high = (double)info->high[axis];
        const double first = (double)info->start[axis];
        const double last = first + (info->counts[axis] - 1) * (double)info->step[axis];
        const double reach = fmax(high - first, last - low);
        inside += (high - low) * (high - low);
        outside += fmax(reach, high - low) * fmax(reach, high - low);
    }
    return (float)sqrt(fmax(inside, outside));
}

static svo_status place(svo_device *device, const char *function, const sight_box *box, const svo_probe_options *asked,
                        svo_probe_info *info)
{
    for (int axis = 0; axis < 3; ++axis) {
        const double width = box->high[axis] - box->low[axis];
        const bool fits = !(asked->step[axis] > 0.0F);
        const double step = fits ? width / asked->counts[axis] : (double)asked->step[axis];
        info->low[axis] = (float)box->low[axis];
        info->high[axis] = (float)box->high[axis];
        info->step[axis] = (float)step;
        info->start[axis] = fits ? (float)(box->low[axis] + 0.5 * step) : asked->start[axis];
        if (!(info->step[axis] > 0.0F) || !(info->high[axis] > info->low[axis]) || !isfinite(info->high[axis])) {
            return svo_i_device_fail(device, SVO_UNSUPPORTED,
                                     "%s: %g wide at %g on axis %d is beyond the range of floats", function, width,
                                     box->low[axis], axis);
        }
    }
    info->leaf_edge = (float)box->leaf_edge;
    info->farthest = find_farthest(info);
    return info->leaf_edge > 0.0F && isfinite(info->farthest)
               ? SVO_OK
               : svo_i_device_fail(device, SVO_UNSUPPORTED,
                                   "%s: leaves of %g that are seen from up to %g away are beyond the range of floats",
                                   function, box->leaf_edge, (double)info->farthest);
}

/* ---- sizes ---- */

/* The resolution that is asked for, or the largest one that fits. 0: none does. */
static uint32_t choose_resolution(const svo_probe_options *asked, uint32_t probe_count)
{
    uint32_t resolution = asked->resolution != 0 ? asked->resolution : RESOLUTION_DEFAULT;
    const uint32_t least = asked->resolution != 0 ? asked->resolution : SVO_PROBES_RESOLUTION_MIN;
    const uint64_t texels = asked->max_bytes / TEXEL_BYTES;
    const uint64_t most = texels < UINT32_MAX ? texels : UINT32_MAX;
    while (resolution >= least) {
        if ((uint64_t)probe_count * resolution * resolution <= most) {
            return resolution;
        }
        resolution -= SVO_PROBES_RESOLUTION_STEP;
    }
    return 0;
}

static svo_status resolve(svo_device *device, const char *function, const svo_probe_options *asked,
                          svo_probe_info *info)
{
    info->resolution = choose_resolution(asked, info->probe_count);
    if (info->resolution != 0) {
        return SVO_OK;
    }
    const uint32_t wanted = asked->resolution != 0 ? asked->resolution : SVO_PROBES_RESOLUTION_MIN;
    const uint64_t texels = (uint64_t)info->probe_count * wanted * wanted;
    return texels > UINT32_MAX
               ? svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                   "%s: %u probes of options.resolution %u have more than %u texels", function,
                                   info->probe_count, wanted, UINT32_MAX)
               : svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                   "%s: %u probes of options.resolution %u take %llu bytes, above "
                                   "options.max_bytes %llu",
                                   function, info->probe_count, wanted, (unsigned long long)texels * TEXEL_BYTES,
                                   (unsigned long long)asked->max_bytes);
}

/* Rays and hits of a launch, tables, and what radiance takes. */
static uint64_t find_scratch(const svo_i_sight *sight, const svo_probe_options *asked, const svo_probe_info *info)
{
    const uint64_t per_ray = sizeof(svo_ray) + svo_i_sight_hit_words(sight) * sizeof(cl_uint) +
                             (asked->light != NULL ? 3 * sizeof(cl_float) : 0);
    const uint64_t per_code = sizeof(cl_ulong) + (asked->diffuse != 0 ? sizeof(cl_uint) : 0);
    return svo_i_probes_band_rays(info) * per_ray + SVO_I_PROBE_CODES * per_code +
           (asked->light != NULL ? svo_i_light_shade_bytes(asked->light) : 0);
}

static void find_bytes(const svo_probe_options *asked, svo_probe_info *info)
{
    const uint64_t probes = info->probe_count;
    const uint64_t texels = probes * info->resolution * info->resolution;
    const uint64_t cells = (uint64_t)info->field_size * info->field_size * info->field_size;
    const uint64_t blocks = texels / SVO_PROBE_BLOCK / SVO_PROBE_BLOCK;
    info->bytes[SVO_PROBES_PLACES] = probes * sizeof(svo_probe);
    info->bytes[SVO_PROBES_TEXELS] = texels * TEXEL_BYTES;
    info->bytes[SVO_PROBES_LEAST] = blocks * sizeof(cl_ushort);
    info->bytes[SVO_PROBES_FIELD] = cells * SVO_PROBE_FIELD_ENTRIES * sizeof(cl_ushort);
    if (asked->diffuse != 0) {
        info->bytes[SVO_PROBES_IRRADIANCE] =
            probes * SVO_PROBES_IRRADIANCE_TEXELS * SVO_PROBES_IRRADIANCE_TEXELS * sizeof(cl_uint);
        info->bytes[SVO_PROBES_MOMENTS] =
            probes * SVO_PROBES_MOMENT_TEXELS * SVO_PROBES_MOMENT_TEXELS * sizeof(cl_float2);
    }
    for (int i = 0; i < SVO_PROBES_BUFFER_COUNT; ++i) {
        info->total_bytes += info->bytes[i];
    }
    info->rays = texels;
}

/* ---- the search for places ---- */

double svo_i_place_cell_edge(const svo_probe_info *info)
{
    const double widest =
        fmax((double)info->step[0], fmax((double)info->step[1], (double)info->step[2])) / SVO_I_PLACE_CELLS;
    double edge = (double)info->leaf_edge;
    while (edge < widest) {
        edge *= 2;
    }
    return edge;
}

uint64_t svo_i_place_candidates(const svo_probe_info *info)
{
    const double edge = svo_i_place_cell_edge(info);
    uint64_t candidates = 1;
    for (int axis = 0; axis < 3; ++axis) {
        candidates *= (uint64_t)((double)info->step[axis] / edge) + 2; /* one at each end, where rounding wants it */
    }
    return candidates;
}

/* Each probe is judged; each of its candidates is tried, and judged. */
static uint64_t most_place_rays(const svo_probe_info *info)
{
    const uint64_t candidate = SVO_I_PLACE_FIRST_TEXELS + SVO_I_PLACE_TEXELS;
    return info->probe_count * (SVO_I_PLACE_TEXELS + svo_i_place_candidates(info) * candidate);
}

/* ---- plans ---- */

/* Reads options, and which of tree and scene they have. Without either there is no device that keeps a message. */
static svo_status read_options(const char *function, const svo_probe_options *options, svo_probe_options *asked)
{
    SVO_I_TRY(
        svo_i_struct_read(NULL, function, "options", options, asked, SVO_I_STRUCT_SIZES(svo_probe_options, scene)));
    if (asked->tree != NULL && asked->scene != NULL) {
        return svo_i_device_fail(asked->tree->device, SVO_INVALID_ARGUMENT,
                                 "%s: options.tree and options.scene are both given", function);
    }
    return asked->tree != NULL || asked->scene != NULL ? SVO_OK : SVO_INVALID_ARGUMENT;
}

svo_status svo_i_probes_plan(const char *function, const svo_probe_options *options, svo_probe_options *asked,
                             svo_probe_info *info)
{
    sight_box box;
    SVO_I_TRY(read_options(function, options, asked));
    const svo_i_sight seen = {asked->tree, asked->scene};
    const svo_i_sight *sight = &seen;
    svo_device *device = device_of(sight);
    SVO_I_TRY(check_sight(sight, function));
    SVO_I_TRY(check_counts(device, function, asked));
    SVO_I_TRY(check_places(device, function, asked));
    SVO_I_TRY(check_sizes(device, function, asked));
    SVO_I_TRY(check_light(sight, function, asked));
    *info = (svo_probe_info){.counts = {asked->counts[0], asked->counts[1], asked->counts[2]},
                             .probe_count = asked->counts[0] * asked->counts[1] * asked->counts[2],
                             .field_size = asked->field_size};
    get_box(sight, &box);
    SVO_I_TRY(place(device, function, &box, asked, info));
    SVO_I_TRY(resolve(device, function, asked, info));
    find_bytes(asked, info);
    info->scratch_bytes = find_scratch(sight, asked, info);
    info->place_rays = asked->keep_places == 0 ? most_place_rays(info) : 0;
    return SVO_OK;
}

svo_status svo_probes_plan(const svo_probe_options *options, svo_probe_info *info)
{
    static const char function[] = "svo_probes_plan";
    svo_probe_options asked;
    svo_probe_info planned;
    SVO_I_TRY(svo_i_probes_plan(function, options, &asked, &planned));
    svo_device *device = asked.tree != NULL ? asked.tree->device : asked.scene->device;
    return svo_i_struct_write(svo_i_device_message(device), function, "info", &planned, info,
                              SVO_I_STRUCT_SIZES(svo_probe_info, stage_ms));
}
