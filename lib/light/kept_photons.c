/* SPDX-License-Identifier: MIT */
/*
 * Photons and radiance that are kept on the device, so that few are shot again for a changed tree: photons.c fills
 * them, shoot.c shoots again from them, kernels/light/kept_photons.cl has the steps.
 */
#include "light/kept_photons.h"

#include <string.h>

#include "light/programs.h"

svo_status svo_i_kept_tree_read(svo_i_device_work *work, const svo_tree *tree, svo_i_kept_tree *out)
{
    static const svo_tree_buffer buffers[3] = {SVO_TREE_COLORS, SVO_TREE_NORMALS, SVO_TREE_MATERIALS};
    const svo_tree_info *info = &tree->info;
    *out = (svo_i_kept_tree){.need = info->need, .constant = info->constant, .weights = info->weights};
    SVO_I_TRY(svo_tree_get_grid(tree, &out->grid));
    for (size_t i = 0; i < 3; ++i) {
        if (svo_i_tree_is_constant(info, buffers[i])) {
            SVO_I_TRY(svo_i_work_read(work, tree->buffers[buffers[i]], 0, &out->constants[i],
                                      svo_i_tree_element_bytes(buffers[i])));
        }
    }
    return SVO_OK;
}

bool svo_i_kept_tree_is_same(const svo_i_kept_tree *a, const svo_i_kept_tree *b)
{
    bool same = a->grid.depth == b->grid.depth && a->grid.snap_bits == b->grid.snap_bits &&
                a->grid.scale == b->grid.scale && a->need == b->need && a->constant == b->constant &&
                a->weights == b->weights;
    for (int i = 0; i < 3; ++i) {
        same = same && a->grid.origin[i] == b->grid.origin[i] && a->constants[i] == b->constants[i];
    }
    return same;
}

static bool is_same_box(const svo_i_lit_box *a, const svo_i_lit_box *b)
{
    bool same = a->leaf_edge == b->leaf_edge;
    for (int axis = 0; axis < 3; ++axis) {
        same = same && a->low[axis] == b->low[axis] && a->high[axis] == b->high[axis];
    }
    return same;
}

svo_status svo_i_kept_fits(const svo_i_kept_photons *kept, svo_i_device_work *work, const svo_tree *tree,
                           const svo_i_lit_box *box, bool *fits)
{
    svo_i_kept_tree now;
    SVO_I_TRY(svo_i_kept_tree_read(work, tree, &now));
    *fits = kept->whole && is_same_box(box, &kept->box) && svo_i_kept_tree_is_same(&now, &kept->tree);
    return SVO_OK;
}

static void release_buffers(svo_i_kept_photons *kept)
{
    cl_mem *const buffers[] = {&kept->weights, &kept->ends,  &kept->spreads,  &kept->sums,
                               &kept->users,   &kept->codes, &kept->radiance, &kept->bits};
    for (size_t i = 0; i < sizeof buffers / sizeof buffers[0]; ++i) {
        svo_i_buffer_release(buffers[i]);
    }
    svo_i_free(kept->views);
}

void svo_i_kept_destroy(svo_i_kept_photons **kept)
{
    if (*kept != NULL) {
        release_buffers(*kept);
        svo_i_free(*kept);
        *kept = NULL;
    }
}

/* Lists the views of a setup as svo_i_light_shine shoots them. kept->views: room for them; NULL: they are counted. */
static svo_status list_views(svo_i_kept_photons *kept, svo_i_device_work *work, const svo_light_setup *setup)
{
    svo_i_light_view views[SVO_I_VIEWS_OF_ONE_MAX];
    uint64_t photons = 0;
    kept->view_count = 0;
    for (size_t i = 0; i < setup->source_count; ++i) {
        const svo_light_source *source = &setup->sources[i];
        const uint32_t count =
            svo_i_source_is_dark(source) ? 0 : svo_i_light_views(source, &kept->box, setup->view_resolution, views);
        for (uint32_t k = 0; k < count; ++k) {
            if (kept->views != NULL) {
                kept->views[kept->view_count] =
                    (svo_i_kept_view){.photon_count = views[k].photon_count, .first = (uint32_t)photons};
            }
            photons += views[k].photon_count;
            ++kept->view_count;
        }
    }
    kept->photon_count = (uint32_t)photons;
    return photons <= UINT32_MAX
               ? SVO_OK
               : svo_i_device_fail(kept->device, SVO_UNSUPPORTED, "%s: setup.updatable: %llu photons are above %u",
                                   work->function, (unsigned long long)photons, UINT32_MAX);
}

static svo_status make_views(svo_i_kept_photons *kept, svo_i_device_work *work, const svo_light_setup *setup)
{
    SVO_I_TRY(list_views(kept, work, setup));
    kept->views = svo_i_alloc_zeroed(&kept->device->memory, kept->view_count + 1, sizeof *kept->views);
    if (kept->views == NULL) {
        return svo_i_device_fail(kept->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %zu views", work->function,
                                 kept->view_count);
    }
    return list_views(kept, work, setup);
}

svo_status svo_i_kept_begin(svo_i_kept_photons *kept, svo_i_device_work *work, const svo_tree *tree,
                            const svo_light_setup *setup, const svo_i_lit_box *box, bool has_directions)
{
    release_buffers(kept);
    *kept = (svo_i_kept_photons){.device = tree->device, .has_directions = has_directions, .box = *box};
    SVO_I_TRY(svo_i_kept_tree_read(work, tree, &kept->tree));
    SVO_I_TRY(make_views(kept, work, setup));
    const uint64_t photons = kept->photon_count;
    SVO_I_TRY(svo_i_work_result(work, "kept_weights", photons * sizeof(svo_photon_weight), &kept->weights));
    SVO_I_TRY(svo_i_work_result(work, "kept_ends", photons * sizeof(cl_float4), &kept->ends));
    return svo_i_work_result(work, "kept_spreads", photons / SVO_ITEM_PHOTONS * sizeof(svo_photon_spread),
                             &kept->spreads);
}

/* Replaces a buffer by a larger one, whose new part is filled with a word. */
static svo_status grow(svo_i_device_work *work, const char *name, uint64_t old_bytes, uint64_t bytes, cl_uint word,
                       cl_mem *buffer)
{
    cl_mem larger = NULL;
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_i_work_result(work, name, bytes, &larger));
    SVO_I_TRY_CLEANUP(svo_i_work_fill(work, larger, word, bytes));
    SVO_I_TRY_CLEANUP(svo_i_work_copy(work, *buffer, 0, larger, 0, old_bytes));
    SVO_I_TRY_CLEANUP(svo_i_work_wait(work));
    svo_i_buffer_release(buffer);
    *buffer = larger;
    return SVO_OK;
cleanup:
    (void)svo_i_work_wait(work);
    svo_i_buffer_release(&larger);
    return status;
}

svo_status svo_i_kept_grow(svo_i_kept_photons *kept, svo_i_device_work *work, uint64_t room, uint64_t slot_bytes,
                           uint64_t radiance_bytes)
{
    const uint64_t old = kept->slot_room;
    SVO_I_TRY(grow(work, "kept_sums", old * slot_bytes, room * slot_bytes, 0, &kept->sums));
    SVO_I_TRY(grow(work, "kept_users", old * sizeof(cl_uint), room * sizeof(cl_uint), 0, &kept->users));
    SVO_I_TRY(grow(work, "kept_codes", old * sizeof(cl_ulong), room * sizeof(cl_ulong), SVO_SLOT_NONE, &kept->codes));
    SVO_I_TRY(grow(work, "kept_radiance", old * radiance_bytes, room * radiance_bytes, 0, &kept->radiance));
    SVO_I_TRY(grow(work, "kept_bits", old * sizeof(cl_uint), room * sizeof(cl_uint), SVO_SLOT_STALE, &kept->bits));
    kept->slot_room = room;
    return SVO_OK;
}

svo_status svo_i_kept_use(const svo_i_kept_photons *kept, svo_i_device_work *work)
{
    return svo_i_work_use(work, &svo_i_program_kept_photons,
                          kept->has_directions ? " -DSVO_SORT -DSVO_LIGHT_FACES" : " -DSVO_SORT");
}

void svo_i_kept_next_view(svo_i_kept_photons *kept, svo_light_view_params *params)
{
    svo_i_kept_view *view = &kept->views[kept->shot_views++];
    params->kept_first = view->first;
    view->params = *params;
}
