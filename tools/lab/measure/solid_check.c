/* SPDX-License-Identifier: MIT */
/* The reference's solid beside the library's. */
#include "measure/solid_check.h"

#include <math.h>
#include <stdlib.h>

#include "reference/oracle_exact.h"

/* Coordinate i of the vertices of a tree's mesh; in grid units if its voxels are those of the rounded one. */
static double coordinate(const svo_tree_info *info, const svo_tree_arrays *arrays, size_t i)
{
    return info->is_exact == 0                ? (double)arrays->vertices[i]
           : arrays->positions_double != NULL ? arrays->positions_double[i]
                                              : (double)arrays->positions[i];
}

/* The reference's solid of that mesh. */
static bool make_reference(const svo_tree_info *info, const svo_tree_arrays *arrays, svo_solid_rule rule,
                           oracle_solid *out)
{
    oracle_space space = {{info->origin[0], info->origin[1], info->origin[2]}, info->edge, info->depth};
    if (info->is_exact == 0) {
        space = (oracle_space){.edge = ldexp(1.0, (int)info->snap_bits), .depth = info->depth};
    }
    const size_t count = (size_t)info->vertex_count * 3;
    double *positions = malloc(count * sizeof *positions + 1);
    for (size_t i = 0; positions != NULL && i < count; ++i) {
        positions[i] = coordinate(info, arrays, i);
    }
    const oracle_positions mesh = {positions, (size_t)info->vertex_count, arrays->indices,
                                   (size_t)info->list_triangle_count};
    const bool good = positions != NULL && oracle_exact_solid_make(&mesh, &space, (oracle_rule)rule, out);
    free(positions);
    return good;
}

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
    svo_compact_info form = SVO_COMPACT_INFO_INIT;
    svo_compact_arrays words = SVO_COMPACT_ARRAYS_INIT;
    oracle_solid reference = {.depth = 0};
    uint8_t *levels = malloc((size_t)1 << 3 * tree->depth);
    *found = (solid_differences){.counts_differ = false};
    (void)svo_compact_get_info(solid, &form);
    (void)svo_compact_get_arrays(solid, &words);
    const bool good = levels != NULL && words.nodes != NULL &&
                      oracle_descriptor_levels(words.nodes, (size_t)form.stored_count, tree->depth, levels) &&
                      make_reference(tree, arrays, rule, &reference);
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
