/* SPDX-License-Identifier: MIT */
/*
 * svo_solid_create: options and checks; the tree with the empty children that are inside (inside.h) as leaves, as the
 * encoder of the descriptor form reads it.
 */
#include "svocl/solid.h"

#include <string.h>

#include "compact/form.h"
#include "compact/programs.h"
#include "core/program.h"
#include "core/struct_size.h"
#include "core/tree.h"
#include "shared/solid_layout.h"
#include "solid/inside.h"
#include "solid/programs.h"
#include "svocl/plan.h"

static const char function[] = "svo_solid_create";

/* Words of the form and places of payload have 32 bits. */
#define INNER_MAX UINT64_C(0x7fffffff)
#define NODES_MAX UINT64_C(0xfffffffe)

/* Materials have 16 bits, and a mesh has 65535 at most. */
#define MATERIAL_MAX 65534

/* ---- checks ---- */

static svo_status read_options(const svo_tree *tree, const svo_solid_options *options, svo_solid_options *out)
{
    static const uint8_t none[4] = {0, 0, 0, 0};
    SVO_I_TRY(svo_i_struct_read(svo_i_device_message(tree->device), function, "options", options, out,
                                SVO_I_STRUCT_SIZES(svo_solid_options, material)));
    if ((unsigned)out->rule > SVO_SOLID_GENERALIZED) {
        return svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT, "%s: options.rule %d is not in 0 .. %d", function,
                                 (int)out->rule, (int)SVO_SOLID_GENERALIZED);
    }
    if (out->material > MATERIAL_MAX) {
        return svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT, "%s: options.material %d is above %d", function,
                                 out->material, MATERIAL_MAX);
    }
    if (memcmp(out->color, none, sizeof none) == 0) {
        memset(out->color, 255, sizeof out->color);
    }
    return SVO_OK;
}

/* Refuses more nodes than the form can name. count: of the nodes; kind: "inner " or "". */
static svo_status check_count(const svo_tree *tree, uint64_t count, const char *kind, uint64_t most)
{
    return count <= most ? SVO_OK
                         : svo_i_device_fail(tree->device, SVO_UNSUPPORTED, "%s: %llu %snodes are above %llu", function,
                                             (unsigned long long)count, kind, (unsigned long long)most);
}

static svo_status check_tree(const svo_tree *tree)
{
    const svo_tree_info *info = &tree->info;
    SVO_I_TRY(svo_i_tree_check(tree, function));
    if (tree->device == NULL) {
        return SVO_NOT_ON_DEVICE;
    }
    SVO_I_TRY(svo_i_inside_check(tree, function, "a solid"));
    if (info->payload_level > 0 && (info->need & SVO_I_PAYLOAD_NEEDS) != 0) {
        return svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT,
                                 "%s: the tree's payload does not begin at level 0, and interior leaves may lie on any "
                                 "level",
                                 function);
    }
    return check_count(tree, info->inner_count, "inner ", INNER_MAX);
}

/* ---- interior leaves ---- */

/* The most bytes of a payload element. */
#define ELEMENT_BYTES_MAX 6

/* The element of interior leaves. */

static void fill_element(const svo_solid_options *options, svo_compact_buffer buffer, uint8_t element[8])
{
    memset(element, 0, 8);
    if (buffer == SVO_COMPACT_COLORS) {
        memcpy(element, options->color, sizeof options->color);
    } else if (buffer == SVO_COMPACT_MATERIALS) {
        memcpy(element, &options->material, sizeof options->material);
    }
}

/* valid, leaf and the places of the children's payload. */
static svo_status make_masks(svo_i_device_work *work, const svo_tree *tree, const svo_i_inside *inside,
                             svo_i_compact_source *out)
{
    const svo_tree_info *info = &tree->info;
    const svo_solid_params params = {.first = info->level_begin[info->depth - 1], .count = (cl_uint)info->inner_count};
    const uint64_t count = info->inner_count;
    cl_mem counts = NULL;
    cl_mem sums = NULL;
    SVO_I_TRY(svo_i_work_alloc(work, "solid_valid", count, &out->valid));
    SVO_I_TRY(svo_i_work_alloc(work, "solid_leaf", count, &out->leaf));
    SVO_I_TRY(svo_i_work_alloc(work, "solid_first", count * sizeof(cl_uint), &out->first_payload));
    SVO_I_TRY(svo_i_work_alloc(work, "solid_counts", (count + 1) * sizeof(cl_uint), &counts));
    SVO_I_TRY(svo_i_work_alloc(work, "solid_sums", (count + 2) * sizeof(cl_uint), &sums));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(tree->buffers[SVO_TREE_CHILD_MASK]),
                                        SVO_I_ARGUMENT(inside->mask),
                                        SVO_I_ARGUMENT(out->valid),
                                        SVO_I_ARGUMENT(out->leaf),
                                        SVO_I_ARGUMENT(counts),
                                        SVO_I_ARGUMENT(params)};
    SVO_I_TRY(svo_i_work_launch(work, "svo_k_solid_masks", SVO_I_ARGUMENTS(arguments), count));
    SVO_I_TRY(svo_i_work_use(work, &svo_i_program_compact, " -DSVO_SORT"));
    SVO_I_TRY(svo_i_work_scan(work, counts, sums, count + 1));
    SVO_I_TRY(svo_i_work_copy(work, sums, sizeof(cl_uint), out->first_payload, 0, count * sizeof(cl_uint)));
    svo_i_work_free(work, &counts);
    svo_i_work_free(work, &sums);
    return svo_i_work_use(work, &svo_i_program_solid, "");
}

/* Whether the tree's payload is the same in every node and that of the interior leaves too. */
static svo_status check_constant(svo_i_device_work *work, const svo_tree *tree, svo_compact_buffer buffer,
                                 const uint8_t element[8], bool *constant)
{
    const svo_tree_buffer of_tree = svo_i_compact_tree_buffer(buffer);
    const size_t bytes = svo_i_tree_element_bytes(of_tree);
    uint8_t held[ELEMENT_BYTES_MAX] = {0};
    *constant = svo_i_tree_is_constant(&tree->info, of_tree);
    if (!*constant) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_work_read(work, tree->buffers[of_tree], 0, held, bytes));
    *constant = memcmp(held, element, bytes) == 0;
    return SVO_OK;
}

/* The payload with that of the interior leaves; the tree's own where it is the same everywhere. */
static svo_status make_payload(svo_i_device_work *work, const svo_tree *tree, const svo_i_inside *inside,
                               const svo_solid_options *options, svo_compact_buffer buffer, svo_i_compact_source *out)
{
    const svo_tree_buffer of_tree = svo_i_compact_tree_buffer(buffer);
    const size_t bytes = svo_i_tree_element_bytes(of_tree);
    const uint64_t nodes = tree->info.node_count + inside->count;
    cl_mem *to = &out->payload[buffer - SVO_I_PAYLOAD_FIRST];
    uint8_t element[8];
    bool constant = false;
    fill_element(options, buffer, element);
    SVO_I_TRY(check_constant(work, tree, buffer, element, &constant));
    *to = tree->buffers[of_tree];
    if (constant) {
        return SVO_OK;
    }
    svo_solid_params params = {.count = (cl_uint)tree->info.inner_count,
                               .element_halves = (cl_uint)(bytes / 2),
                               .repeats = svo_i_tree_is_constant(&tree->info, of_tree)};
    memcpy(params.value, element, sizeof params.value);
    out->info.constant &= ~svo_i_compact_need(buffer);
    SVO_I_TRY(svo_i_work_alloc(work, svo_name(SVO_NAME_COMPACT_BUFFER, buffer), nodes * bytes, to));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(tree->buffers[SVO_TREE_CHILD_MASK]),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_FIRST_CHILD]),
                                        SVO_I_ARGUMENT(inside->mask),
                                        SVO_I_ARGUMENT(out->first_payload),
                                        SVO_I_ARGUMENT(tree->buffers[of_tree]),
                                        SVO_I_ARGUMENT(*to),
                                        SVO_I_ARGUMENT(params)};
    return svo_i_work_launch(work, "svo_k_solid_payload", SVO_I_ARGUMENTS(arguments), params.count);
}

/* Adds the interior leaves to a tree. The tree and the work own its arrays, which must outlive the work. options: read
   and complete. */
static svo_status make_source(svo_i_device_work *work, const svo_tree *tree, const svo_i_inside *inside,
                              const svo_solid_options *options, svo_i_compact_source *out)
{
    const svo_compact_options form = {.struct_size = sizeof form, .form = SVO_FORM_DESCRIPTOR};
    if (inside->count == 0) {
        return svo_i_source_of_tree(work, tree, &form, out);
    }
    *out = (svo_i_compact_source){.first_inner = tree->buffers[SVO_TREE_FIRST_CHILD]};
    svo_i_source_describe(&tree->info, &form, &out->info);
    for (uint32_t level = 1; level <= tree->info.depth; ++level) {
        out->info.level_leaf[level] += (uint32_t)inside->level_count[level];
        out->info.minimized |= level < tree->info.depth && inside->level_count[level] > 0;
    }
    SVO_I_TRY(make_masks(work, tree, inside, out));
    for (int i = SVO_I_PAYLOAD_FIRST; i < SVO_COMPACT_BUFFER_COUNT; ++i) {
        if ((out->info.need & svo_i_compact_need((svo_compact_buffer)i)) != 0) {
            SVO_I_TRY(make_payload(work, tree, inside, options, (svo_compact_buffer)i, out));
        }
    }
    return SVO_OK;
}

/* ---- the solid ---- */

static svo_status encode(svo_i_device_work *work, const svo_tree *tree, const svo_i_inside *inside,
                         const svo_solid_options *options, svo_compact *compact)
{
    svo_i_compact_source source;
    SVO_I_TRY(check_count(tree, tree->info.node_count + inside->count, "", NODES_MAX));
    SVO_I_TRY(make_source(work, tree, inside, options, &source));
    compact->info = source.info;
    compact->device = tree->device;
    return svo_i_form_make(work, &source, compact);
}

static svo_status make(const svo_tree *tree, const svo_solid_options *options, cl_command_queue queue,
                       svo_compact *compact, svo_solid_info *info)
{
    const svo_i_solid_progress progress = {options->progress, options->progress_user};
    svo_i_device_work work;
    svo_i_inside inside;
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_i_work_begin(tree->device, function, queue, &work));
    SVO_I_TRY_CLEANUP(svo_i_solid_tell(&progress, tree->device, 0.0));
    SVO_I_TRY_CLEANUP(svo_i_inside_find(&work, tree, options->rule, false, &progress, &inside, info));
    SVO_I_TRY_CLEANUP(svo_i_solid_tell(&progress, tree->device, SVO_I_INSIDE_END));
    SVO_I_TRY_CLEANUP(encode(&work, tree, &inside, options, compact));
    SVO_I_TRY_CLEANUP(svo_i_work_wait(&work));
    SVO_I_TRY_CLEANUP(svo_i_solid_tell(&progress, tree->device, 1.0));

cleanup:
    svo_i_work_end(&work);
    return status;
}

svo_status svo_solid_create(const svo_tree *tree, const svo_solid_options *options, cl_command_queue queue,
                            svo_compact **out, svo_solid_info *info)
{
    const svo_i_struct_sizes sizes = SVO_I_STRUCT_SIZES(svo_solid_info, scratch_bytes);
    svo_solid_options asked;
    svo_solid_info found = SVO_SOLID_INFO_INIT;
    if (tree == NULL || out == NULL) {
        return svo_i_device_fail(tree != NULL ? tree->device : NULL, SVO_INVALID_ARGUMENT, "%s: %s is NULL", function,
                                 tree == NULL ? "tree" : "out");
    }
    SVO_I_TRY(check_tree(tree));
    SVO_I_TRY(read_options(tree, options, &asked));
    if (info != NULL) {
        SVO_I_TRY(svo_i_struct_check(svo_i_device_message(tree->device), function, "info", info, sizes));
    }
    svo_compact *compact = svo_i_compact_new(&tree->device->memory);
    if (compact == NULL) {
        return svo_i_device_fail(tree->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for a compact tree", function);
    }
    const svo_status status = make(tree, &asked, queue, compact, &found);
    if (status != SVO_OK) {
        svo_compact_destroy(&compact);
        return status;
    }
    *out = compact;
    return info != NULL ? svo_i_struct_write(svo_i_device_message(tree->device), function, "info", &found, info, sizes)
                        : SVO_OK;
}
