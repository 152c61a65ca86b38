/* SPDX-License-Identifier: MIT */
/*
 * svo_light_update: the light of a changed tree is made beside the old one, which it replaces when all has succeeded.
 * Photons are many, and most of them meet what they met: again.c shoots the others. Of the nodes, those that boxes do
 * not touch are copied: kept_nodes.c finds them.
 */
#include <math.h>

#include "light/kept_nodes.h"
#include "light/kept_photons.h"
#include "light/light.h"
#include "light/sources.h"

static const char function[] = "svo_light_update";

static svo_status check_box(const svo_light *light, size_t index, const svo_box *box)
{
    for (int axis = 0; axis < 3; ++axis) {
        if (!isfinite(box->low[axis]) || !isfinite(box->high[axis])) {
            return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT, "%s: changed[%zu] is not finite", function,
                                     index);
        }
        if (box->low[axis] > box->high[axis]) {
            return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT,
                                     "%s: changed[%zu].low[%d] %g is above high %g", function, index, axis,
                                     box->low[axis], box->high[axis]);
        }
    }
    return SVO_OK;
}

static svo_status check_changes(const svo_light *light, const svo_box *changed, size_t count)
{
    if (count > SVO_LIGHT_BOXES_MAX) {
        return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT, "%s: %zu boxes are above %u", function, count,
                                 SVO_LIGHT_BOXES_MAX);
    }
    if (count > 0 && changed == NULL) {
        return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT, "%s: changed is NULL", function);
    }
    for (size_t i = 0; changed != NULL && i < count; ++i) {
        SVO_I_TRY(check_box(light, i, &changed[i]));
    }
    return SVO_OK;
}

static svo_status check_tree(const svo_light *light, const svo_tree *tree)
{
    if (tree == NULL) {
        return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT, "%s: tree is NULL", function);
    }
    return tree->device == light->device ? SVO_OK
                                         : svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT,
                                                             "%s: the tree is not on the light's device", function);
}

/* Lights a new light as the old one is, with its photons. */
static svo_status light_up(svo_light *made, svo_light *light, cl_command_queue queue)
{
    if (light->setup.asked.struct_size == 0) {
        return SVO_OK;
    }
    made->kept = light->kept;
    light->kept = NULL;
    return svo_i_light_set(made, function, &light->setup.asked, queue);
}

/* Makes the light of another tree. After a failure light keeps nothing: the next boxes are those of later changes. */
static svo_status make_after(svo_light *light, svo_tree *tree, svo_i_light_before *before, cl_command_queue queue,
                             svo_light **made)
{
    svo_status status = svo_i_light_create(tree, function, &light->options, before, queue, made);
    if (status == SVO_OK) {
        status = light_up(*made, light, queue);
        (*made)->before = NULL;
    }
    svo_i_buffer_release(&before->origins);
    svo_i_buffer_release(&before->renewed);
    svo_i_kept_nodes_destroy(&light->nodes);
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
    SVO_I_TRY(check_tree(light, tree));
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
