/* SPDX-License-Identifier: MIT */
/* Pictures of built trees. */
#include "core/device.h"
#include "core/tree.h"
#include "rays/picture.h"
#include "rays/rays.h"

static svo_status check_tree(svo_device *device, const svo_tree *tree, const char *function)
{
    if (tree->device != NULL && tree->device != device) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: the tree is on another device", function);
    }
    if (tree->buffers[SVO_TREE_CHILD_MASK] == NULL || tree->buffers[SVO_TREE_FIRST_CHILD] == NULL) {
        return svo_i_device_fail(device, SVO_NOT_ON_DEVICE,
                                 "%s: the tree is not on a device; call svo_tree_upload first", function);
    }
    return SVO_OK;
}

static svo_status describe(svo_device *device, svo_tree *tree, const char *function, svo_i_picture_source *out)
{
    *out = (svo_i_picture_source){.device = device,
                                  .function = function,
                                  .form_defines = "",
                                  .nodes = {tree->buffers[SVO_TREE_CHILD_MASK], tree->buffers[SVO_TREE_FIRST_CHILD]},
                                  .node_arguments = 2,
                                  .tree = svo_i_rays_target(tree),
                                  .colors = tree->buffers[SVO_TREE_COLORS],
                                  .normals = tree->buffers[SVO_TREE_NORMALS],
                                  .one_color = svo_i_tree_is_constant(&tree->info, SVO_TREE_COLORS),
                                  .one_normal = svo_i_tree_is_constant(&tree->info, SVO_TREE_NORMALS),
                                  .payload_level = tree->info.payload_level};
    return svo_tree_get_grid(tree, &out->grid);
}

/* Checks what is asked for and describes what is drawn. */
static svo_status begin(svo_device *device, svo_tree *tree, const char *function, const svo_render_options *options,
                        svo_render_options *asked, svo_i_picture_source *source)
{
    if (tree == NULL || options == NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: %s is NULL", function,
                                 tree == NULL ? "tree" : "options");
    }
    SVO_I_TRY(svo_i_picture_options(device, function, options, asked));
    SVO_I_TRY(svo_i_tree_check(tree, function));
    SVO_I_TRY(check_tree(device, tree, function));
    if (asked->view == SVO_VIEW_TRIANGLES) {
        SVO_I_TRY(svo_i_rays_check(tree, function));
    }
    return describe(device, tree, function, source);
}

svo_status svo_tree_render_enqueue(svo_device *device, svo_tree *tree, const svo_render_options *options, cl_mem pixels,
                                   cl_command_queue queue, cl_uint num_wait, const cl_event *wait, cl_event *event)
{
    svo_i_pixels to = {pixels, queue, num_wait, wait, event};
    svo_render_options asked;
    svo_i_picture_source source;
    if (device == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    SVO_I_TRY(begin(device, tree, "svo_tree_render_enqueue", options, &asked, &source));
    return svo_i_picture_enqueue(&source, &asked, &to);
}

svo_status svo_tree_render(svo_device *device, svo_tree *tree, const svo_render_options *options,
                           cl_command_queue queue, uint8_t *rgba)
{
    static const char function[] = "svo_tree_render";
    svo_render_options asked;
    svo_i_picture_source source;
    if (device == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    if (rgba == NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: rgba is NULL", function);
    }
    SVO_I_TRY(begin(device, tree, function, options, &asked, &source));
    return svo_i_picture_draw(&source, &asked, queue, rgba);
}
