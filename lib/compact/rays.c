/* SPDX-License-Identifier: MIT */
/* Rays against the voxels of compact trees: batches, pictures, and kernels of the caller's. */
#include "rays/rays.h"
#include "compact/form.h"
#include "core/device.h"
#include "rays/batch.h"
#include "rays/camera.h"
#include "rays/picture.h"
#include "rays/programs.h"
#include "rays/target.h"
#include "shared/dag.clh"
#include "shared/descriptor.h"
#include "shared/mirrored.clh"
#include "svocl/plan.h"

/* ---- the target ---- */

static svo_status check_target(void *of, const char *function)
{
    const svo_compact *compact = of;
    (void)function;
    return compact->device != NULL ? SVO_OK : SVO_NOT_ON_DEVICE;
}

static svo_grid grid_of(const svo_compact_info *info)
{
    return (svo_grid){.depth = info->depth,
                      .snap_bits = info->snap_bits,
                      .origin = {info->origin[0], info->origin[1], info->origin[2]},
                      .scale = info->scale,
                      .edge = info->edge};
}

static svo_status set_target(void *of, const char *function, cl_kernel kernel, cl_uint first_index)
{
    const svo_compact *compact = of;
    const svo_grid grid = grid_of(&compact->info);
    svo_ray_params params = {.depth = 0};
    SVO_I_TRY(svo_i_rays_params(compact->device, function, &grid, compact->info.edge, &params));
    const svo_i_argument arguments[SVO_COMPACT_ARGUMENTS] = {
        SVO_I_ARGUMENT(compact->buffers[SVO_COMPACT_NODES]), SVO_I_ARGUMENT(compact->buffers[SVO_COMPACT_LINKS]),
        SVO_I_ARGUMENT(compact->buffers[SVO_COMPACT_BASES]), SVO_I_ARGUMENT(params)};
    return svo_i_kernel_set_from(compact->device, function, kernel, first_index, arguments, SVO_COMPACT_ARGUMENTS);
}

static svo_i_ray_target target_of(svo_compact *compact)
{
    return (svo_i_ray_target){compact, SVO_COMPACT_ARGUMENTS, check_target, set_target};
}

/* ---- batches ---- */

static svo_status trace_voxels(void *of, const svo_array *rays, const svo_array *hits, size_t ray_count,
                               float footprint, uint32_t flags, const svo_submit *submit)
{
    svo_compact *compact = of;
    svo_i_batch asked = {.device = compact->device,
                         .function = "svo_trace_voxels",
                         .target = target_of(compact),
                         .program = &svo_i_program_trace_voxels,
                         .defines = svo_i_form_defines(&compact->info)};
    SVO_I_TRY(svo_i_batch_of_voxels(&asked, ray_count, &footprint, flags));
    return svo_i_batch_run(&asked, rays, hits, submit);
}

/* ---- pictures ---- */

static svo_i_picture_source describe(svo_compact *compact, const char *function)
{
    const svo_compact_info *info = &compact->info;
    return (svo_i_picture_source){.device = compact->device,
                                  .function = function,
                                  .grid = grid_of(info),
                                  .form_defines = svo_i_form_defines(info),
                                  .nodes = {compact->buffers[SVO_COMPACT_NODES], compact->buffers[SVO_COMPACT_LINKS],
                                            compact->buffers[SVO_COMPACT_BASES]},
                                  .node_arguments = 3,
                                  .tree = target_of(compact),
                                  .colors = compact->buffers[SVO_COMPACT_COLORS],
                                  .normals = compact->buffers[SVO_COMPACT_NORMALS],
                                  .one_color = svo_i_compact_is_constant(info, SVO_COMPACT_COLORS),
                                  .one_normal = svo_i_compact_is_constant(info, SVO_COMPACT_NORMALS),
                                  .payload_level = info->payload_level,
                                  .packed_colors = (info->packed & SVO_NEED_COLOR) != 0,
                                  .packed_normals = (info->packed & SVO_NEED_NORMAL) != 0};
}

static svo_status render(void *of, const svo_render_options *options, const svo_array *pixels, const svo_submit *submit)
{
    static const char function[] = "svo_render";
    static const svo_i_picture_kind kind = {
        .name = "compact tree", .views = SVO_I_VOXEL_VIEWS, .view_names = SVO_I_VOXEL_VIEW_NAMES};
    svo_compact *compact = of;
    svo_render_options asked;
    SVO_I_TRY(check_target(compact, function));
    SVO_I_TRY(svo_i_picture_options(compact->device, function, &kind, options, &asked));
    const svo_i_picture_source source = describe(compact, function);
    return svo_i_picture_draw(&source, &asked, pixels, submit);
}

/* ---- framing: an svo_i_framed.open of each form, of the arrays on the host; a leaf is SVO_NO_NODE ---- */

static uint32_t open_word(const void *subject, uint32_t node, uint32_t level, uint32_t child[8])
{
    const svo_compact *compact = subject;
    const uint32_t *words = compact->host[SVO_COMPACT_NODES];
    (void)level;
    if (node == SVO_NO_NODE) {
        return 0;
    }
    const uint32_t distance = words[node] >> SVO_WORD_DISTANCE_SHIFT;
    uint32_t next = node + ((words[node] & SVO_WORD_FAR) != 0 ? words[node + distance] : distance);
    for (uint32_t octant = 0; octant < 8; ++octant) {
        const bool is_inner = (words[node] >> octant & ~(words[node] >> SVO_WORD_LEAF_SHIFT >> octant) & 1u) != 0;
        child[octant] = is_inner ? next++ : SVO_NO_NODE;
    }
    return words[node] & 0xffu;
}

static uint32_t open_mask(const void *subject, uint32_t node, uint32_t level, uint32_t child[8])
{
    const svo_compact *compact = subject;
    const uint8_t *masks = compact->host[SVO_COMPACT_NODES];
    if (level == compact->info.depth) {
        return 0;
    }
    const uint32_t entry = node >> compact->info.directory_step_log2;
    uint32_t next = ((const uint32_t *)compact->host[SVO_COMPACT_LINKS])[entry];
    for (uint32_t at = entry << compact->info.directory_step_log2; at < node; ++at) {
        next += svo_count_bits(masks[at]);
    }
    for (uint32_t octant = 0; octant < 8; ++octant) {
        child[octant] = next;
        next += masks[node] >> octant & 1u;
    }
    return masks[node];
}

static uint32_t open_record(const void *subject, uint32_t node, uint32_t level, uint32_t child[8])
{
    const svo_compact *compact = subject;
    const uint32_t *words = compact->host[SVO_COMPACT_NODES];
    const uint32_t levels = compact->info.depth - level;
    const uint32_t places = svo_i_compact_has_places(&compact->info) ? 1 : 0;
    if (node == SVO_NO_NODE || levels == 0) {
        return 0;
    }
    const svo_shared_node at = level == 0 ? svo_shared_root(words, levels) : (svo_shared_node){.record = node};
    const uint32_t masks = svo_shared_masks(words, levels, at.record);
    for (uint32_t octant = 0; octant < 8; ++octant) {
        const bool is_inner = (masks >> octant & ~(masks >> 8 >> octant) & 1u) != 0;
        child[octant] = is_inner ? svo_shared_child(words, levels, levels, places, at, octant).record : SVO_NO_NODE;
    }
    return masks & 0xffu;
}

static uint32_t open_mirrored(const void *subject, uint32_t node, uint32_t level, uint32_t child[8])
{
    const svo_compact *compact = subject;
    const uint32_t *words = compact->host[SVO_COMPACT_NODES];
    const uint32_t levels = compact->info.depth - level;
    const uint32_t places = svo_i_compact_has_places(&compact->info) ? 1 : 0;
    if (node == SVO_NO_NODE || levels == 0) {
        return 0;
    }
    const svo_shared_node at = level == 0 ? svo_mirrored_root(words, levels) : (svo_shared_node){.record = node};
    for (uint32_t octant = 0; octant < 8; ++octant) {
        svo_shared_node found = {.record = 0};
        const uint32_t kind =
            svo_mirrored_child(words, compact->host[SVO_COMPACT_LINKS], levels, places, at, octant, &found);
        child[octant] = kind == SVO_MIRRORED_INNER ? found.record : SVO_NO_NODE;
    }
    return svo_mirrored_valid(words, levels, at.record);
}

static svo_status fit_camera(const void *of, float aspect, svo_camera *camera)
{
    static uint32_t (*const opens[SVO_FORM_COUNT])(const void *, uint32_t, uint32_t,
                                                   uint32_t *) = {[SVO_FORM_DESCRIPTOR] = open_word,
                                                                  [SVO_FORM_IMPLIED] = open_mask,
                                                                  [SVO_FORM_SHARED] = open_record,
                                                                  [SVO_FORM_MIRRORED] = open_mirrored};
    const svo_compact *compact = of;
    const svo_compact_info *info = &compact->info;
    const bool is_known = compact->downloaded && info->leaf_count > 0;
    const svo_i_framed framed = {.subject = compact,
                                 .open = is_known ? opens[info->form] : NULL,
                                 .depth = info->depth,
                                 .origin = {info->origin[0], info->origin[1], info->origin[2]},
                                 .edge = info->edge};
    const svo_i_fitted fitted = {&framed, svo_i_framed_reach};
    return svo_i_camera_fit(&fitted, aspect, camera) ? SVO_OK : SVO_INVALID_ARGUMENT;
}

/* ---- the class ---- */

static svo_device *device_of(const void *compact)
{
    return ((const svo_compact *)compact)->device;
}

static const char *kernel_options(const void *of)
{
    const svo_compact *compact = of;
    return compact != NULL ? svo_i_form_options(&compact->info) : NULL;
}

static const struct svo_target_class compact_class = {.name = "compact tree",
                                                      .device = device_of,
                                                      .trace_voxels = trace_voxels,
                                                      .render = render,
                                                      .fit_camera = fit_camera,
                                                      .kernel_source = svo_i_tree_kernel_source,
                                                      .kernel_options = kernel_options,
                                                      .set_kernel_arguments = set_target};

svo_target svo_compact_target(svo_compact *compact)
{
    return (svo_target){&compact_class, compact};
}
