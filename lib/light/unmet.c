/* SPDX-License-Identifier: MIT */
/* The host's part of svo_k_unmet_rays and svo_k_unmet_count, in bands of leaves. */
#include "light/unmet.h"

#include "svocl/nodes.h"

static svo_status look_at_band(svo_i_photons *photons, const svo_light_source *source, cl_mem unmet,
                               const svo_unmet_params *params)
{
    const cl_mem *tree = photons->tree->buffers;
    const svo_i_argument rays[] = {SVO_I_ARGUMENT(tree[SVO_TREE_CHILD_MASK]),
                                   SVO_I_ARGUMENT(tree[SVO_TREE_FIRST_CHILD]),
                                   SVO_I_ARGUMENT(photons->slots),
                                   SVO_I_ARGUMENT(photons->rays),
                                   SVO_I_ARGUMENT(*source),
                                   SVO_I_ARGUMENT(*params)};
    const svo_i_argument count[] = {SVO_I_ARGUMENT(photons->leaves), SVO_I_ARGUMENT(unmet),
                                    SVO_I_ARGUMENT(photons->counters), SVO_I_ARGUMENT(params->first),
                                    SVO_I_ARGUMENT(params->count)};
    SVO_I_TRY(svo_i_work_launch(photons->work, "svo_k_unmet_rays", SVO_I_ARGUMENTS(rays), params->count));
    SVO_I_TRY(svo_i_photons_trace(photons, params->count));
    SVO_I_TRY(svo_i_photons_find(photons, NULL, params->count));
    return svo_i_work_launch(photons->work, "svo_k_unmet_count", SVO_I_ARGUMENTS(count), params->count);
}

static svo_status look_at_leaves(svo_i_photons *photons, const svo_light_source *source, cl_mem unmet)
{
    const uint32_t leaf_count = (uint32_t)photons->tree->info.leaf_count;
    svo_grid grid = {.depth = 0};
    SVO_I_TRY(svo_tree_get_grid(photons->tree, &grid));
    svo_unmet_params params = {
        .origin = {(float)grid.origin[0], (float)grid.origin[1], (float)grid.origin[2]},
        .edge = (float)svo_grid_cell_edge(&grid, grid.depth),
        .inner_count = (cl_uint)photons->tree->info.inner_count,
        .reach = (float)(2 * svo_grid_cell_edge(&grid, 0)), /* the grid's diagonal is shorter */
        .outer_cosine = source->kind == SVO_SOURCE_SPOT ? (float)svo_i_plain_cosine(source->outer_angle) : 0};
    for (; params.first < leaf_count; params.first += params.count) {
        params.count = leaf_count - params.first < SVO_I_BAND_PHOTONS ? leaf_count - params.first : SVO_I_BAND_PHOTONS;
        SVO_I_TRY(look_at_band(photons, source, unmet, &params));
    }
    return SVO_OK;
}

svo_status svo_i_photons_count_unmet(svo_i_photons *photons, const svo_light_setup *setup, uint64_t *count)
{
    const uint64_t bytes = photons->tree->info.leaf_count * sizeof(cl_uint);
    cl_uint found = 0;
    cl_mem unmet = NULL;
    SVO_I_TRY(svo_i_photons_make_bands(photons));
    SVO_I_TRY(svo_i_photons_use(photons));
    SVO_I_TRY(svo_i_work_alloc(photons->work, "photon_unmet", bytes, &unmet));
    SVO_I_TRY(svo_i_work_fill_zero(photons->work, unmet, bytes));
    for (size_t i = 0; i < setup->source_count; ++i) {
        if (!svo_i_source_is_dark(&setup->sources[i])) {
            SVO_I_TRY(look_at_leaves(photons, &setup->sources[i], unmet));
        }
    }
    SVO_I_TRY(svo_i_work_read(photons->work, photons->counters, SVO_PHOTON_UNMET * sizeof found, &found, sizeof found));
    svo_i_work_free(photons->work, &unmet);
    *count = found;
    return SVO_OK;
}
