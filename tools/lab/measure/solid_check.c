/* SPDX-License-Identifier: MIT */
/* The reference's solid beside the library's. */
#include "measure/solid_check.h"

#include <stdlib.h>

static bool counts_differ(const svo_solid_info *info, const oracle_solid *reference,
                          const oracle_solid_difference *found)
{
    return info->surface_voxels != found->surface_voxels || info->inside_voxels != found->inside_voxels ||
           info->inside_leaves != found->inside_leaves || info->ambiguous_cells != found->ambiguous_cells ||
           info->ambiguous_voxels != found->ambiguous_voxels || info->open_columns[0] != reference->open_columns[0] ||
           info->open_columns[1] != reference->open_columns[1] || info->open_columns[2] != reference->open_columns[2];
}

bool solid_check(const svo_tree_info *tree, const svo_tree_arrays *arrays, const svo_compact *solid,
                 const svo_solid_info *info, svo_solid_rule rule, solid_differences *found)
{
    const oracle_mesh mesh = {arrays->vertices, arrays->indices, NULL, (size_t)tree->list_triangle_count};
    const oracle_request request = {.depth = tree->depth, .snap_bits = tree->snap_bits};
    svo_compact_info form = SVO_COMPACT_INFO_INIT;
    svo_compact_arrays words = SVO_COMPACT_ARRAYS_INIT;
    oracle_solid reference = {.depth = 0};
    uint8_t *levels = malloc((size_t)1 << 3 * tree->depth);
    *found = (solid_differences){.counts_differ = false};
    (void)svo_compact_get_info(solid, &form);
    (void)svo_compact_get_arrays(solid, &words);
    const bool good = levels != NULL && words.nodes != NULL &&
                      oracle_descriptor_levels(words.nodes, (size_t)form.stored_count, tree->depth, levels) &&
                      oracle_solid_make(&mesh, &request, (oracle_rule)rule, &reference);
    if (good) {
        oracle_solid_compare(&reference, arrays->child_mask, arrays->first_child, levels, &found->voxels);
        found->counts_differ = counts_differ(info, &reference, &found->voxels);
        for (int axis = 0; axis < 3; ++axis) {
            found->open_columns[axis] = reference.open_columns[axis];
        }
    }
    oracle_solid_free(&reference);
    free(levels);
    return good;
}

bool solid_check_is_exact(const solid_differences *found)
{
    const bool closed = found->open_columns[0] + found->open_columns[1] + found->open_columns[2] == 0;
    return found->voxels.wrong_voxels == 0 && !found->counts_differ && (!closed || found->voxels.split_voxels == 0);
}
