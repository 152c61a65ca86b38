/* SPDX-License-Identifier: MIT */
/* svo_solid_create: options and checks, then classify.c, source.c and the encoder of the descriptor form. */
#include <string.h>

#include "compact/form.h"
#include "core/struct_size.h"
#include "solid/source.h"
#include "svocl/plan.h"

static const char function[] = "svo_solid_create";

/* Words of the form and places of payload have 32 bits. */
#define INNER_MAX UINT64_C(0x7fffffff)
#define NODES_MAX UINT64_C(0xfffffffe)

/* Materials have 16 bits, and a mesh has 65535 at most. */
#define MATERIAL_MAX 65534

const char *svo_solid_rule_name(svo_solid_rule rule)
{
    switch (rule) {
    case SVO_SOLID_WINDING:
        return "winding";
    case SVO_SOLID_PARITY:
        return "parity";
    default:
        return "unknown rule";
    }
}

/* ---- checks ---- */

static svo_status read_options(const svo_tree *tree, const svo_solid_options *options, svo_solid_options *out)
{
    static const uint8_t none[4] = {0, 0, 0, 0};
    SVO_I_TRY(svo_i_struct_read(svo_i_device_message(tree->device), function, "options", options, out,
                                SVO_I_STRUCT_SIZES(svo_solid_options, material)));
    if ((unsigned)out->rule > SVO_SOLID_PARITY) {
        return svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT, "%s: options.rule %d is not in 0 .. %d", function,
                                 (int)out->rule, (int)SVO_SOLID_PARITY);
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

/* Why a tree does not say what is inside, for a message; NULL: it does. */
static const char *find_lack(const svo_tree *tree)
{
    if (tree->info.coverage == SVO_COVERAGE_THIN) {
        return "the tree's coverage is thin: the surface passes through cells that it leaves empty, so parts of a cell "
               "may lie on both sides";
    }
    if ((tree->info.need & SVO_NEED_RAYS) == 0) {
        return "the tree holds no leaf lists; build it with SVO_NEED_RAYS";
    }
    if (tree->info.payload_level > 0 && (tree->info.need & SVO_I_PAYLOAD_NEEDS) != 0) {
        return "the tree's payload does not begin at level 0, and interior leaves may lie on any level";
    }
    return NULL;
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
    const char *lack = find_lack(tree);
    if (lack != NULL) {
        return svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT, "%s: %s", function, lack);
    }
    const uint64_t usable = info->triangles - info->refused_triangles;
    if (usable > info->list_triangle_count) {
        return svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT,
                                 "%s: %llu triangles lie outside the tree's grid; a solid needs all of the mesh inside",
                                 function, (unsigned long long)(usable - info->list_triangle_count));
    }
    return check_count(tree, info->inner_count, "inner ", INNER_MAX);
}

/* ---- the solid ---- */

static svo_status encode(svo_i_device_work *work, const svo_tree *tree, const svo_i_inside *inside,
                         const svo_solid_options *options, svo_compact *compact)
{
    svo_i_compact_source source;
    SVO_I_TRY(check_count(tree, tree->info.node_count + inside->count, "", NODES_MAX));
    SVO_I_TRY(svo_i_solid_source(work, tree, inside, options, &source));
    compact->info = source.info;
    compact->device = tree->device;
    return svo_i_form_make(work, &source, compact);
}

static svo_status make(const svo_tree *tree, const svo_solid_options *options, cl_command_queue queue,
                       svo_compact *compact, svo_solid_info *info)
{
    svo_i_device_work work;
    svo_i_inside inside;
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_i_work_begin(tree->device, function, queue, &work));
    SVO_I_TRY_CLEANUP(svo_i_solid_classify(&work, tree, options->rule, &inside, info));
    SVO_I_TRY_CLEANUP(encode(&work, tree, &inside, options, compact));
    SVO_I_TRY_CLEANUP(svo_i_work_wait(&work));

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
