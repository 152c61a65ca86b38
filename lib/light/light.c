/* SPDX-License-Identifier: MIT */
/*
 * Lights: plan, creation, sources, update, destruction.
 *
 * svo_light_update makes the light of a changed tree beside the old one, which it replaces when all has succeeded.
 * Photons are many, and most of them meet what they met: shoot.c shoots the others. Of the nodes, those that boxes do
 * not touch are copied: opacity.c finds them.
 */
#include "light/light.h"

#include <math.h>
#include <string.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "core/compact.h"
#include "core/opencl.h"
#include "core/struct_size.h"
#include "light/emitters.h"
#include "light/mesh.h"
#include "light/opacity.h"
#include "light/programs.h"
#include "light/setup.h"
#include "light/shoot.h"
#include "light/sky.h"
#include "svocl/plan.h"

static const char set_sources[] = "svo_light_set_sources";
static const char update[] = "svo_light_update";

/* ---- plan ---- */

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

/* Checks tree and options, and fills in what the light will be: form, opacity and bytes. asked: receives the options,
   with what the caller's struct leaves out. */
static svo_status plan(const svo_tree *tree, const char *function, const svo_light_options *options,
                       svo_light_options *asked, svo_light_info *info)
{
    SVO_I_TRY(check_tree(tree, function));
    SVO_I_TRY(read_options(tree, function, options, asked));
    const bool has_areas = (tree->info.need & SVO_NEED_PROJECTED_AREA) != 0;
    *info = (svo_light_info){.form = asked->form, .opacity = has_areas ? asked->opacity : SVO_OPACITY_FULL};
    if (asked->no_cones != 0) {
        return SVO_OK;
    }
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
    SVO_I_TRY(plan(tree, function, options, &asked, &planned));
    return svo_i_struct_write(svo_i_device_message(tree->device), function, "info", &planned, info,
                              SVO_I_STRUCT_SIZES(svo_light_info, kept_bytes));
}

/* ---- what is kept ---- */

static void destroy_nodes(svo_i_kept_nodes **nodes)
{
    if (*nodes != NULL) {
        svo_i_buffer_release(&(*nodes)->masks);
        svo_i_buffer_release(&(*nodes)->children);
        svo_i_buffer_release(&(*nodes)->opacities);
        svo_i_free(*nodes);
        *nodes = NULL;
    }
}

/* Bytes of a buffer that is kept; NULL has none. */
static uint64_t kept_buffer_bytes(cl_mem buffer)
{
    size_t bytes = 0;
    if (buffer != NULL) {
        clGetMemObjectInfo(buffer, CL_MEM_SIZE, sizeof bytes, &bytes, NULL);
    }
    return bytes;
}

/* Bytes of the photons and nodes that a light keeps. */
static uint64_t count_kept_bytes(const svo_light *light)
{
    const svo_i_kept_photons none = {.whole = false};
    const svo_i_kept_nodes no_nodes = {.masks = NULL};
    const svo_i_kept_photons *kept = light->kept != NULL ? light->kept : &none;
    const svo_i_kept_nodes *nodes = light->nodes != NULL ? light->nodes : &no_nodes;
    const cl_mem buffers[] = {kept->weights,  kept->ends, kept->spreads, kept->sums,      kept->users,     kept->codes,
                              kept->radiance, kept->bits, nodes->masks,  nodes->children, nodes->opacities};
    uint64_t bytes = 0;
    for (size_t i = 0; i < sizeof buffers / sizeof buffers[0]; ++i) {
        bytes += kept_buffer_bytes(buffers[i]);
    }
    return bytes;
}

/* ---- creation ---- */

static svo_status make_opacity(svo_light *light, const char *function, cl_command_queue queue)
{
    svo_i_device_work work;
    SVO_I_TRY(svo_i_work_begin(light->device, function, queue, &work));
    const svo_status status = svo_i_light_opacity(&work, light);
    svo_i_work_end(&work);
    return status;
}

/* SVO_LIGHT_FLAG_*, by what the tree holds and what was asked. */
static uint32_t find_flags(const svo_tree_info *tree, const svo_light_options *options)
{
    const bool normals = (tree->need & SVO_NEED_NORMAL) != 0;
    const bool colors = (tree->need & SVO_NEED_COLOR) != 0;
    return (normals ? SVO_LIGHT_FLAG_NORMALS : 0) |
           (svo_i_tree_is_constant(tree, SVO_TREE_NORMALS) ? SVO_LIGHT_FLAG_ONE_NORMAL : 0) |
           (colors ? SVO_LIGHT_FLAG_COLORS : 0) |
           (svo_i_tree_is_constant(tree, SVO_TREE_COLORS) ? SVO_LIGHT_FLAG_ONE_COLOR : 0) |
           (options->one_side != 0 ? SVO_LIGHT_FLAG_ONE_SIDE : 0);
}

svo_status svo_i_light_new(svo_tree *tree, const char *function, const svo_light_options *options, svo_light **out)
{
    svo_light_options asked;
    svo_light_info info;
    SVO_I_TRY(plan(tree, function, options, &asked, &info));
    if (tree->device == NULL) {
        return SVO_NOT_ON_DEVICE;
    }
    svo_light *light = svo_i_alloc_zeroed(&tree->device->memory, 1, sizeof *light);
    if (light == NULL) {
        return svo_i_device_fail(tree->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for a light", function);
    }
    light->tree = tree;
    light->device = tree->device;
    light->info = info;
    light->options = asked;
    light->options.struct_size = sizeof light->options;
    light->params = (svo_light_params){
        .depth = tree->info.depth,
        .flags = find_flags(&tree->info, &asked),
        .voxel_edge = (float)ldexp(1.0 / tree->info.scale, (int)(tree->info.snap_bits - tree->info.depth))};
    *out = light;
    return SVO_OK;
}

/* Makes a light of a tree with its opacity. before: NULL: from nothing. */
static svo_status create(svo_tree *tree, const char *function, const svo_light_options *options,
                         svo_i_light_before *before, cl_command_queue queue, svo_light **out)
{
    svo_light *light = NULL;
    SVO_I_TRY(svo_i_light_new(tree, function, options, &light));
    light->before = before;
    const svo_status status = light->options.no_cones != 0 ? SVO_OK : make_opacity(light, function, queue);
    if (status != SVO_OK) {
        svo_light_destroy(&light);
        return status;
    }
    *out = light;
    return SVO_OK;
}

svo_status svo_light_create(svo_tree *tree, const svo_light_options *options, cl_command_queue queue, svo_light **out)
{
    static const char function[] = "svo_light_create";
    return tree != NULL && out != NULL ? create(tree, function, options, NULL, queue, out)
                                       : svo_i_device_fail(tree != NULL ? tree->device : NULL, SVO_INVALID_ARGUMENT,
                                                           "%s: %s is NULL", function, tree == NULL ? "tree" : "out");
}

void svo_light_destroy(svo_light **light)
{
    if (light == NULL || *light == NULL) {
        return;
    }
    for (svo_light_buffer i = 0; i < SVO_LIGHT_BUFFER_COUNT; ++i) {
        svo_i_light_release(*light, i);
    }
    svo_i_light_forget_setup(*light);
    svo_i_kept_destroy(&(*light)->kept);
    destroy_nodes(&(*light)->nodes);
    svo_i_light_drop_emitters(*light);
    svo_i_light_drop_sky(*light);
    svo_i_light_drop_mesh(*light);
    svo_i_free(*light);
    *light = NULL;
}

/* ---- sources ---- */

/* Takes away what earlier sources have left. */
static void darken(svo_light *light)
{
    svo_light_info *info = &light->info;
    svo_i_light_darken(light);
    svo_i_light_forget_setup(light);
    svo_i_kept_destroy(&light->kept);
    destroy_nodes(&light->nodes);
    svo_i_light_drop_emitters(light);
    svo_i_light_drop_sky(light);
    svo_i_light_release(light, SVO_LIGHT_FLUX);
    for (int i = SVO_LIGHT_STAGE_VIEW; i < SVO_LIGHT_STAGE_COUNT; ++i) {
        info->stage_ms[i] = 0;
    }
    info->photons = info->photon_hits = info->lit_leaves = info->missed_leaves = 0;
    info->traced_photons = info->kept_bytes = info->sent_photons = 0;
    info->flux[0] = info->flux[1] = info->flux[2] = info->lost_flux = 0;
    light->params.sky[0] = light->params.sky[1] = light->params.sky[2] = 0.0F;
}

static svo_status shine(svo_light *light, const char *name, const svo_light_setup *setup,
                        const svo_i_photon_caster *caster, cl_command_queue queue)
{
    svo_i_device_work work;
    svo_i_lit_leaves lit;
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_i_work_begin(light->device, name, queue, &work));
    SVO_I_TRY_CLEANUP(svo_i_light_shine(&work, light, setup, caster, &lit));
    SVO_I_TRY_CLEANUP(svo_i_light_filter(&work, light, &lit));
    light->info.kept_bytes = light->tree->info.leaf_count > 0 ? count_kept_bytes(light) : 0;
    if (work.peak_bytes > light->info.scratch_bytes) {
        light->info.scratch_bytes = work.peak_bytes;
    }

cleanup:
    svo_i_work_end(&work);
    return status;
}

static svo_status make_sky(svo_light *light, const char *name, const svo_light_setup *setup, cl_command_queue queue)
{
    svo_i_device_work work;
    if (setup->sky_map == NULL) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_work_begin(light->device, name, queue, &work));
    const svo_status status = svo_i_light_make_sky(&work, light, setup);
    svo_i_work_end(&work);
    return status;
}

/* Lights a dark light by a setup that has been checked, and keeps the setup. name: of the public function. The light is
   dark after a failure. */
static svo_status set(svo_light *light, const char *name, const svo_light_setup *setup,
                      const svo_i_photon_caster *caster, cl_command_queue queue)
{
    svo_light_setup shining = *setup;
    svo_status status = SVO_OK;
    if (setup->no_photons != 0) {
        shining.source_count = 0;
        shining.emission_photons = 0;
    }
    if (light->options.no_cones == 0) {
        SVO_I_TRY_CLEANUP(shine(light, name, &shining, caster, queue));
    }
    SVO_I_TRY_CLEANUP(make_sky(light, name, setup, queue));
    SVO_I_TRY_CLEANUP(svo_i_light_keep_setup(light, name, setup));

cleanup:
    if (status != SVO_OK) {
        darken(light);
    }
    return status;
}

svo_status svo_i_light_take_setup(svo_light *light, const char *function, const svo_light_setup *setup)
{
    SVO_I_TRY(svo_i_light_check_setup(light, setup));
    return svo_i_light_keep_setup(light, function, setup);
}

svo_status svo_i_light_set_sources_by(const svo_i_photon_caster *caster, svo_light *light, const svo_light_setup *setup,
                                      cl_command_queue queue)
{
    svo_light_setup asked;
    if (light == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    darken(light);
    SVO_I_TRY(svo_i_struct_read(svo_i_device_message(light->device), set_sources, "setup", setup, &asked,
                                SVO_I_STRUCT_SIZES(svo_light_setup, updatable)));
    SVO_I_TRY(svo_i_light_check_setup(light, &asked));
    SVO_I_TRY(svo_i_tree_check(light->tree, set_sources));
    return set(light, set_sources, &asked, caster, queue);
}

svo_status svo_light_set_sources(svo_light *light, const svo_light_setup *setup, cl_command_queue queue)
{
    return svo_i_light_set_sources_by(NULL, light, setup, queue);
}

/* ---- update ---- */

static svo_status check_box(const svo_light *light, size_t index, const svo_box *box)
{
    for (int axis = 0; axis < 3; ++axis) {
        if (!isfinite(box->low[axis]) || !isfinite(box->high[axis])) {
            return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT, "%s: changed[%zu] is not finite", update,
                                     index);
        }
        if (box->low[axis] > box->high[axis]) {
            return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT,
                                     "%s: changed[%zu].low[%d] %g is above high %g", update, index, axis,
                                     box->low[axis], box->high[axis]);
        }
    }
    return SVO_OK;
}

static svo_status check_changes(const svo_light *light, const svo_box *changed, size_t count)
{
    if (count > SVO_LIGHT_BOXES_MAX) {
        return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT, "%s: %zu boxes are above %u", update, count,
                                 SVO_LIGHT_BOXES_MAX);
    }
    if (count > 0 && changed == NULL) {
        return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT, "%s: changed is NULL", update);
    }
    for (size_t i = 0; changed != NULL && i < count; ++i) {
        SVO_I_TRY(check_box(light, i, &changed[i]));
    }
    return SVO_OK;
}

static svo_status check_changed_tree(const svo_light *light, const svo_tree *tree)
{
    if (tree == NULL) {
        return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT, "%s: tree is NULL", update);
    }
    return tree->device == light->device ? SVO_OK
                                         : svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT,
                                                             "%s: the tree is not on the light's device", update);
}

/* Lights a new light as the old one is, with its photons. */
static svo_status light_up(svo_light *made, svo_light *light, cl_command_queue queue)
{
    if (light->setup.asked.struct_size == 0) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_light_share_sky(light, update, made));
    made->kept = light->kept;
    light->kept = NULL;
    return set(made, update, &light->setup.asked, NULL, queue);
}

/* Makes the light of another tree. After a failure light keeps nothing: the next boxes are those of later changes. */
static svo_status make_after(svo_light *light, svo_tree *tree, svo_i_light_before *before, cl_command_queue queue,
                             svo_light **made)
{
    svo_status status = create(tree, update, &light->options, before, queue, made);
    if (status == SVO_OK) {
        status = light_up(*made, light, queue);
        (*made)->before = NULL;
    }
    svo_i_buffer_release(&before->origins);
    svo_i_buffer_release(&before->renewed);
    destroy_nodes(&light->nodes);
    if (status != SVO_OK) {
        svo_i_kept_destroy(&light->kept);
        light->info.kept_bytes = 0;
    }
    return status;
}

svo_status svo_light_update(svo_light *light, svo_tree *tree, const svo_box *changed, size_t change_count,
                            cl_command_queue queue)
{
    svo_i_light_before before = {.light = light, .changes = {.boxes = changed, .count = change_count}};
    svo_light *made = NULL;
    if (light == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    SVO_I_TRY(check_changed_tree(light, tree));
    SVO_I_TRY(check_changes(light, changed, change_count));
    const svo_status status = make_after(light, tree, &before, queue, &made);
    if (status == SVO_OK) {
        const svo_light old = *light;
        *light = *made;
        *made = old;
    }
    svo_light_destroy(&made);
    return status;
}
