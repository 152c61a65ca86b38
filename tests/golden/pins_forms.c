/* SPDX-License-Identifier: MIT */
/* Pins of compact trees and solids. */
#include "pins.h"

#include <setjmp.h>
#include <stdarg.h>

#include <cmocka.h>

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#include "svocl/compact.h"
#include "svocl/solid.h"

#define RAYS 800
#define ALL_NEEDS                                                                                                   \
    ((uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL | (uint32_t)SVO_NEED_RAYS | (uint32_t)SVO_NEED_MATERIAL | \
     (uint32_t)SVO_NEED_FILL)

static void pin_compact_bytes(pins *all, const char *name, const svo_compact_info *info)
{
    char text[PIN_VALUE_BYTES] = "";
    size_t used = 0;
    for (int i = 0; i < SVO_COMPACT_BUFFER_COUNT; ++i) {
        used += (size_t)snprintf(text + used, sizeof text - used, "%s %" PRIu64 ", ",
                                 svo_name(SVO_NAME_COMPACT_BUFFER, (svo_compact_buffer)i), info->bytes[i]);
    }
    pin_text(all, name,
             "%sstored %" PRIu64 " far %" PRIu64 " shared %" PRIu64 " voxels %" PRIu64 " merged %u bounds %x", text,
             info->stored_count, info->far_count, info->shared_count, info->voxel_count, (unsigned)info->minimized,
             (unsigned)info->bounds);
}

/* Hash and sizes of a compact tree, the tree that it unfolds to, and its rays. */
static void pin_made(pins *all, svo_compact *compact, const svo_ray *rays)
{
    svo_compact_info info = SVO_COMPACT_INFO_INIT;
    svo_voxel_hit hits[RAYS];
    char hash[SVO_HASH_TEXT_BYTES];
    svo_tree *tree = NULL;
    pin_succeed(all, svo_compact_download(compact, all->opened.queue));
    pin_succeed(all, svo_compact_hash(compact, hash));
    pin_succeed(all, svo_compact_get_info(compact, &info));
    pin_text(all, "hash", "%s", hash);
    pin_compact_bytes(all, "bytes", &info);
    pin_succeed(all, svo_compact_expand(compact, all->opened.queue, &tree));
    pin_tree(all, "expanded", tree);
    svo_tree_destroy(&tree);
    pin_succeed(all, svo_trace_voxels(svo_compact_target(compact), svo_in_host(rays), svo_in_host(hits), RAYS, 0.01F, 0,
                                      &(svo_submit){.queue = all->opened.queue}));
    char prefix[PIN_NAME_BYTES];
    (void)snprintf(prefix, sizeof prefix, "%s", all->prefix);
    pin_begin(all, "PoCL %.100s", prefix);
    pin_digest(all, "voxels", hits, sizeof hits);
}

static const struct {
    const char *name;
    svo_compact_options options;
} forms[] = {
    {"descriptor", {.form = SVO_FORM_DESCRIPTOR}},
    {"descriptor merged", {.form = SVO_FORM_DESCRIPTOR, .minimize = 1}},
    {"implied 16", {.form = SVO_FORM_IMPLIED, .directory_step_log2 = 4}},
    {"implied 64", {.form = SVO_FORM_IMPLIED, .directory_step_log2 = 6, .leave_out = SVO_NEED_MATERIAL}},
    {"shared", {.form = SVO_FORM_SHARED}},
    {"shared bare", {.form = SVO_FORM_SHARED, .leave_out = ALL_NEEDS}},
    {"mirrored", {.form = SVO_FORM_MIRRORED}},
    {"mirrored bare", {.form = SVO_FORM_MIRRORED, .leave_out = ALL_NEEDS}},
    {"mirrored merged", {.form = SVO_FORM_MIRRORED, .minimize = 1, .leave_out = ALL_NEEDS}},
    {"shared merged within tolerances",
     {.form = SVO_FORM_SHARED,
      .minimize = 1,
      .color_tolerance = {64, 64, 64, 64},
      .normal_tolerance = 16384,
      .fill_tolerance = 30000}},
};

void pin_compact(pins *all)
{
    static svo_ray rays[RAYS];
    for (size_t s = 0; s < PIN_SCENES; ++s) {
        svo_tree *tree = pin_build(all, all->scenes[s].mesh, 5, &(svo_plan_options){.need = ALL_NEEDS});
        pin_make_rays(tree, s + 5, rays, RAYS);
        for (size_t i = 0; i < sizeof forms / sizeof forms[0]; ++i) {
            svo_compact_options options = forms[i].options;
            svo_compact_info planned = SVO_COMPACT_INFO_INIT;
            svo_compact *compact = NULL;
            options.struct_size = sizeof options;
            pin_begin(all, "%s %s", all->scenes[s].name, forms[i].name);
            pin_succeed(all, svo_compact_plan(tree, &options, &planned));
            pin_compact_bytes(all, "planned", &planned);
            pin_succeed(all, svo_compact_create(all->opened.device, tree, &options, all->opened.queue, &compact));
            pin_made(all, compact, rays);
            svo_compact_destroy(&compact);
        }
        svo_tree_destroy(&tree);
    }
}

static void pin_solid_of(pins *all, const char *name, const svo_tree *tree, const svo_ray *rays,
                         const svo_solid_options *options)
{
    svo_solid_info info = SVO_SOLID_INFO_INIT;
    svo_compact *solid = NULL;
    pin_begin(all, "%s", name);
    pin_succeed(all, svo_solid_create(tree, options, all->opened.queue, &solid, &info));
    pin_text(all, "inside",
             "surface %" PRIu64 " voxels %" PRIu64 " leaves %" PRIu64 " tests %" PRIu64 " ambiguous %" PRIu64
             ", %" PRIu64 " open %" PRIu64 " %" PRIu64 " %" PRIu64 " boundary %" PRIu64,
             info.surface_voxels, info.inside_voxels, info.inside_leaves, info.tests, info.ambiguous_cells,
             info.ambiguous_voxels, info.open_columns[0], info.open_columns[1], info.open_columns[2],
             info.boundary_edges);
    pin_made(all, solid, rays);
    svo_compact_destroy(&solid);
}

void pin_solid(pins *all)
{
    static const struct {
        const char *name;
        svo_solid_options options;
    } rules[] = {
        {"winding", {.struct_size = sizeof(svo_solid_options)}},
        {"parity",
         {.struct_size = sizeof(svo_solid_options), .rule = SVO_SOLID_PARITY, .color = {9, 8, 7, 200}, .material = 1}},
        {"generalized", {.struct_size = sizeof(svo_solid_options), .rule = SVO_SOLID_GENERALIZED}},
    };
    static svo_ray rays[RAYS];
    for (size_t s = 0; s < PIN_SCENES; ++s) {
        svo_tree *tree = pin_build(all, all->scenes[s].mesh, 5, &(svo_plan_options){.need = ALL_NEEDS});
        pin_make_rays(tree, s + 8, rays, RAYS);
        for (size_t i = 0; i < sizeof rules / sizeof rules[0]; ++i) {
            char name[64];
            (void)snprintf(name, sizeof name, "%s %s", all->scenes[s].name, rules[i].name);
            pin_solid_of(all, name, tree, rays, &rules[i].options);
        }
        svo_tree_destroy(&tree);
    }
}
