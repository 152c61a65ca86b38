/* SPDX-License-Identifier: MIT */
/* svo_light_plan: options and checks, and how many bytes a light takes. */
#include "light/plan.h"

#include "core/compact.h"
#include "core/device.h"
#include "core/struct_size.h"
#include "shared/light_layout.h"
#include "svocl/plan.h"

static svo_status read_options(const svo_tree *tree, const char *function, const svo_light_options *options,
                               svo_light_options *out)
{
    SVO_I_TRY(svo_i_struct_read(svo_i_device_message(tree->device), function, "options", options, out,
                                SVO_I_STRUCT_SIZES(svo_light_options, opacity)));
    if ((unsigned)out->form >= SVO_LIGHT_FORM_COUNT) {
        return svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT, "%s: options.form %d is not in 0 .. %d", function,
                                 (int)out->form, (int)SVO_LIGHT_FORM_COUNT - 1);
    }
    if ((unsigned)out->opacity > SVO_OPACITY_FULL) {
        return svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT, "%s: options.opacity %d is not in 0 .. %d",
                                 function, (int)out->opacity, (int)SVO_OPACITY_FULL);
    }
    return SVO_OK;
}

/* Cones read the normals of all levels. */
static svo_status check_tree(const svo_tree *tree, const char *function)
{
    SVO_I_TRY(svo_i_tree_check(tree, function));
    return tree->info.payload_level == 0 || (tree->info.need & SVO_I_PAYLOAD_NEEDS) == 0
               ? SVO_OK
               : svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT,
                                   "%s: the tree's payload begins at level %u; light needs it from level 0 on",
                                   function, tree->info.payload_level);
}

/* ---- bytes ---- */

static uint64_t opacity_bytes(const svo_tree_info *tree, svo_light_form form)
{
    switch (form) {
    case SVO_LIGHT_BRICKS:
        return tree->inner_count * SVO_BRICK_SAMPLES * sizeof(uint16_t);
    case SVO_LIGHT_VOXELS:
        return tree->node_count * sizeof(uint16_t);
    default:
        return tree->node_count * 6 * sizeof(uint16_t);
    }
}

/* Bricks: a Morton code for each inner node, and the opacities of the leaves. */
static uint64_t scratch_bytes(const svo_tree_info *tree, svo_light_form form)
{
    return form == SVO_LIGHT_BRICKS ? tree->inner_count * sizeof(uint64_t) + tree->leaf_count * sizeof(uint16_t) : 0;
}

svo_status svo_i_light_plan(const svo_tree *tree, const char *function, const svo_light_options *options,
                            svo_light_options *asked, svo_light_info *info)
{
    SVO_I_TRY(check_tree(tree, function));
    SVO_I_TRY(read_options(tree, function, options, asked));
    const bool has_areas = (tree->info.need & SVO_NEED_PROJECTED_AREA) != 0;
    *info = (svo_light_info){.form = asked->form, .opacity = has_areas ? asked->opacity : SVO_OPACITY_FULL};
    info->bytes[SVO_LIGHT_OPACITY] = opacity_bytes(&tree->info, asked->form);
    if (asked->form == SVO_LIGHT_FACES) {
        info->bytes[SVO_LIGHT_COVER] = info->bytes[SVO_LIGHT_OPACITY];
    }
    info->total_bytes = info->bytes[SVO_LIGHT_OPACITY] + info->bytes[SVO_LIGHT_COVER];
    info->scratch_bytes = scratch_bytes(&tree->info, asked->form);
    return SVO_OK;
}

svo_status svo_light_plan(const svo_tree *tree, const svo_light_options *options, svo_light_info *info)
{
    static const char function[] = "svo_light_plan";
    svo_light_options asked;
    svo_light_info planned;
    if (tree == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    SVO_I_TRY(svo_i_light_plan(tree, function, options, &asked, &planned));
    return svo_i_struct_write(svo_i_device_message(tree->device), function, "info", &planned, info,
                              SVO_I_STRUCT_SIZES(svo_light_info, kept_bytes));
}
