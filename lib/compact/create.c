/* SPDX-License-Identifier: MIT */
/* svo_compact_plan and svo_compact_create: options, checks, and the way from a tree to its compact form. */
#include "compact/form.h"
#include "compact/minimize.h"
#include "core/device.h"
#include "core/struct_size.h"
#include "core/tree.h"
#include "svocl/plan.h"

/* With twice as many words every index of a word fits 32 bits. */
#define INNER_MAX 0x7fffffffu

/* The largest tolerances, with which any values are near enough. */
#define COLOR_TOLERANCE_MAX  255u
#define NORMAL_TOLERANCE_MAX 65534u
#define FILL_TOLERANCE_MAX   65535u

static svo_status check_tolerance(svo_device *device, const char *function, const char *name, uint32_t tolerance,
                                  uint32_t most)
{
    return tolerance <= most ? SVO_OK
                             : svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.%s %u is above %u",
                                                 function, name, tolerance, most);
}

static svo_status check_tolerances(svo_device *device, const char *function, const svo_compact_options *options)
{
    for (int channel = 0; channel < 4; ++channel) {
        SVO_I_TRY(check_tolerance(device, function, "color_tolerance", options->color_tolerance[channel],
                                  COLOR_TOLERANCE_MAX));
    }
    SVO_I_TRY(check_tolerance(device, function, "normal_tolerance", options->normal_tolerance, NORMAL_TOLERANCE_MAX));
    return check_tolerance(device, function, "fill_tolerance", options->fill_tolerance, FILL_TOLERANCE_MAX);
}

/* The options with defaults filled in, or what is wrong with them. */
static svo_status read_options(svo_device *device, const char *function, const svo_compact_options *options,
                               svo_compact_options *out)
{
    SVO_I_TRY(svo_i_struct_read(svo_i_device_message(device), function, "options", options, out,
                                SVO_I_STRUCT_SIZES(svo_compact_options, fill_tolerance)));
    if ((unsigned)out->form >= SVO_FORM_COUNT) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.form %d is not in 0 .. %d", function,
                                 (int)out->form, (int)SVO_FORM_COUNT - 1);
    }
    if (out->directory_step_log2 == 0) {
        out->directory_step_log2 = SVO_I_DIRECTORY_LOG2;
    }
    if (out->directory_step_log2 < SVO_I_DIRECTORY_LOG2_MIN || out->directory_step_log2 > SVO_I_DIRECTORY_LOG2_MAX) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                 "%s: options.directory_step_log2 %u is not 0 and not in %u .. %u", function,
                                 out->directory_step_log2, SVO_I_DIRECTORY_LOG2_MIN, SVO_I_DIRECTORY_LOG2_MAX);
    }
    SVO_I_TRY(check_tolerances(device, function, out));
    if ((out->leave_out & ~(uint32_t)SVO_NEED_ALL) != 0) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.leave_out 0x%x has bits outside 0x%x",
                                 function, out->leave_out, (unsigned)SVO_NEED_ALL);
    }
    return SVO_OK;
}

static svo_status check_counts(svo_device *device, const char *function, const svo_tree *tree)
{
    return tree->info.inner_count <= INNER_MAX
               ? SVO_OK
               : svo_i_device_fail(device, SVO_UNSUPPORTED, "%s: %llu inner nodes are above %u", function,
                                   (unsigned long long)tree->info.inner_count, INNER_MAX);
}

/* The arrays whose size is not known before the nodes are looked at. */
static uint32_t find_bounds(const svo_compact_options *options, const svo_compact_info *planned)
{
    uint32_t bounds = 0;
    for (int i = 0; i < SVO_COMPACT_BUFFER_COUNT; ++i) {
        const bool has_nodes = i == SVO_COMPACT_NODES;
        const bool beside_words = i == SVO_COMPACT_BASES && planned->form == SVO_FORM_DESCRIPTOR;
        const bool by_words = (has_nodes || beside_words) && planned->far_count > 0;
        const bool by_subtrees = has_nodes && planned->form == SVO_FORM_SHARED;
        const bool by_leaves = options->minimize != 0 && !svo_i_compact_is_constant(planned, (svo_compact_buffer)i);
        bounds |= planned->bytes[i] > 0 && (by_words || by_subtrees || by_leaves) ? 1u << i : 0;
    }
    return bounds;
}

svo_status svo_compact_plan(const svo_tree *tree, const svo_compact_options *options, svo_compact_info *info)
{
    static const char function[] = "svo_compact_plan";
    svo_compact_options asked;
    svo_compact_info planned;
    SVO_I_TRY(svo_i_tree_check(tree, function));
    SVO_I_TRY(read_options(tree->device, function, options, &asked));
    SVO_I_TRY(check_counts(tree->device, function, tree));
    svo_i_source_describe(&tree->info, &asked, &planned);
    svo_i_form_count(&planned);
    planned.bounds = find_bounds(&asked, &planned);
    return svo_i_struct_write(svo_i_device_message(tree->device), function, "info", &planned, info,
                              SVO_I_STRUCT_SIZES(svo_compact_info, bounds));
}

/* Refuses a tree that is on another device or nowhere. */
static svo_status check_place(svo_device *device, const svo_tree *tree, const char *function)
{
    if (tree->device != NULL && tree->device != device) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: the tree is on another device", function);
    }
    if (tree->buffers[SVO_TREE_CHILD_MASK] == NULL && tree->host[SVO_TREE_CHILD_MASK] == NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: the tree is neither on the device nor on the host",
                                 function);
    }
    return SVO_OK;
}

static svo_status make(svo_device *device, const svo_tree *tree, const svo_compact_options *asked,
                       cl_command_queue queue, svo_compact *compact)
{
    svo_i_compact_source source;
    svo_i_device_work work;
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_i_work_begin(device, "svo_compact_create", queue, &work));
    SVO_I_TRY_CLEANUP(svo_i_source_of_tree(&work, tree, asked, &source));
    if (asked->minimize != 0) {
        SVO_I_TRY_CLEANUP(svo_i_minimize(&work, asked, &source));
    }
    compact->info = source.info;
    compact->device = device;
    SVO_I_TRY_CLEANUP(svo_i_form_make(&work, &source, compact));
    SVO_I_TRY_CLEANUP(svo_i_work_wait(&work));

cleanup:
    svo_i_work_end(&work);
    return status;
}

svo_status svo_compact_create(svo_device *device, const svo_tree *tree, const svo_compact_options *options,
                              cl_command_queue queue, svo_compact **out)
{
    static const char function[] = "svo_compact_create";
    svo_compact_options asked;
    svo_compact *compact = NULL;
    if (device == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    if (tree == NULL || out == NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: %s is NULL", function,
                                 tree == NULL ? "tree" : "out");
    }
    SVO_I_TRY(read_options(device, function, options, &asked));
    const char *undefined = svo_i_tree_undefined(tree);
    if (undefined != NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: %s", function, undefined);
    }
    SVO_I_TRY(check_place(device, tree, function));
    SVO_I_TRY(check_counts(device, function, tree));
    compact = svo_i_compact_new(&device->memory);
    if (compact == NULL) {
        return svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for a compact tree", function);
    }
    const svo_status status = make(device, tree, &asked, queue, compact);
    if (status != SVO_OK) {
        svo_compact_destroy(&compact);
        return status;
    }
    *out = compact;
    return SVO_OK;
}
