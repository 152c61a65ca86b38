/* SPDX-License-Identifier: MIT */
/* Photons of kept views that are shot again for a changed tree: kernels/light/kept_photons.cl has the steps. */
#include "light/again.h"

#include <math.h>
#include <string.h>

#include "light/kept_photons.h"

/* Times the largest coordinate: more than the error of places along rays in floats, some of 2^-24. */
#define BOX_ERROR 0x1p-18

/* Photons of all views that are shot again. */
typedef struct again {
    svo_i_photons *photons;
    svo_i_kept_photons *kept;
    svo_i_device_work *work;
    cl_mem boxes, counts;
    cl_mem renewed; /* of svo_i_light_before */
    cl_uint *view_counts; /* groups; owned */
    cl_mem groups; /* by view, from the view's first group on */
} again;

/* Which groups of a view the boxes concern. */
static svo_status list_groups(again *a, size_t index, uint32_t box_count)
{
    const svo_i_kept_view *view = &a->kept->views[index];
    const double cells = 1 / svo_grid_cell_edge(&a->kept->tree.grid, a->kept->tree.grid.depth);
    /* A photon's point lies in a cell that what changed may touch, or it takes the leaf of a cell beside its own. */
    const svo_crossing_params params = {.kept_first = view->first,
                                        .group_count = view->photon_count / SVO_ITEM_PHOTONS,
                                        .view = (cl_uint)index,
                                        .box_count = box_count,
                                        .cells = (cl_float)cells,
                                        .beside = 2.5F};
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(a->kept->weights), SVO_I_ARGUMENT(a->kept->ends),
                                        SVO_I_ARGUMENT(a->boxes),         SVO_I_ARGUMENT(a->groups),
                                        SVO_I_ARGUMENT(a->counts),        SVO_I_ARGUMENT(params),
                                        SVO_I_ARGUMENT(view->params)};
    return svo_i_work_launch(a->work, "svo_k_photon_cross", SVO_I_ARGUMENTS(arguments), params.group_count);
}

/* Takes the flux of the listed groups of a view back. */
static svo_status take_back(again *a, size_t index)
{
    const svo_i_kept_view *view = &a->kept->views[index];
    svo_light_view_params params = view->params;
    svo_i_photons *photons = a->photons;
    params.first = view->first;
    params.count = a->view_counts[index] * SVO_ITEM_PHOTONS;
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(a->kept->weights),  SVO_I_ARGUMENT(a->kept->ends),
                                        SVO_I_ARGUMENT(a->kept->spreads),  SVO_I_ARGUMENT(a->kept->sums),
                                        SVO_I_ARGUMENT(a->kept->users),    SVO_I_ARGUMENT(a->kept->bits),
                                        SVO_I_ARGUMENT(photons->counters), SVO_I_ARGUMENT(view->first),
                                        SVO_I_ARGUMENT(a->groups),         SVO_I_ARGUMENT(params)};
    return svo_i_work_launch(a->work, "svo_k_photon_take", SVO_I_ARGUMENTS(arguments), a->view_counts[index]);
}

/* Gives the leaves of the new tree the slots that stay, and lists those that are free. */
static svo_status place_slots(again *a)
{
    svo_i_photons *photons = a->photons;
    const svo_tree *tree = photons->tree;
    cl_uint counted[SVO_PHOTON_COUNTERS] = {0};
    const svo_photon_params params = {.depth = tree->info.depth,
                                      .leaf_begin = (cl_uint)tree->info.inner_count,
                                      .count = (cl_uint)a->kept->slot_count};
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(tree->buffers[SVO_TREE_CHILD_MASK]),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_FIRST_CHILD]),
                                        SVO_I_ARGUMENT(a->kept->users),
                                        SVO_I_ARGUMENT(a->kept->codes),
                                        SVO_I_ARGUMENT(a->kept->bits),
                                        SVO_I_ARGUMENT(photons->slots),
                                        SVO_I_ARGUMENT(a->renewed),
                                        SVO_I_ARGUMENT(photons->counters),
                                        SVO_I_ARGUMENT(params)};
    SVO_I_TRY(svo_i_work_launch(a->work, "svo_k_slot_places", SVO_I_ARGUMENTS(arguments), params.count));
    SVO_I_TRY(svo_i_work_read(a->work, photons->counters, 0, counted, sizeof counted));
    if (counted[SVO_PHOTON_GONE] != 0) {
        return svo_i_device_fail(a->kept->device, SVO_INVALID_ARGUMENT,
                                 "%s: the tree has changed outside the boxes: %u lit leaves there are gone",
                                 a->work->function, counted[SVO_PHOTON_GONE]);
    }
    photons->slot_base = a->kept->slot_count;
    photons->slot_free = counted[SVO_PHOTON_FREE];
    photons->slot_count = photons->slot_base;
    photons->lit_count = photons->slot_base - photons->slot_free;
    photons->hits_before = a->kept->hits - counted[SVO_PHOTON_TAKEN];
    return SVO_OK;
}

/* Shoots a launch of listed groups. params: of these. */
static svo_status shoot_groups(again *a, const svo_light_view_params *params)
{
    svo_i_photons *photons = a->photons;
    const svo_i_argument weigh[] = {SVO_I_ARGUMENT(a->kept->weights), SVO_I_ARGUMENT(photons->weights),
                                    SVO_I_ARGUMENT(photons->kept_first), SVO_I_ARGUMENT(photons->groups),
                                    SVO_I_ARGUMENT(*params)};
    SVO_I_TRY(svo_i_kept_use(photons->kept, photons->work));
    SVO_I_TRY(svo_i_work_launch(a->work, "svo_k_photon_weigh", SVO_I_ARGUMENTS(weigh), params->count));
    SVO_I_TRY(svo_i_photons_use(photons));
    return svo_i_photons_shoot_weighed(photons, params);
}

static svo_status shoot_view(again *a, size_t index)
{
    const svo_i_kept_view *view = &a->kept->views[index];
    const uint32_t photons = a->view_counts[index] * SVO_ITEM_PHOTONS;
    svo_light_view_params params = view->params;
    a->photons->groups = a->groups;
    a->photons->kept_first = view->first;
    a->photons->traced += photons;
    for (uint32_t done = 0; done < photons; done += params.count) {
        params.first = view->first + done;
        params.count = photons - done < SVO_I_BAND_PHOTONS ? photons - done : SVO_I_BAND_PHOTONS;
        SVO_I_TRY(shoot_groups(a, &params));
    }
    return SVO_OK;
}

/* What has been lost stays lost; slots that are claimed follow those that there are. */
static svo_status begin_counters(again *a)
{
    cl_uint counters[SVO_PHOTON_COUNTERS] = {0};
    memcpy(&counters[SVO_PHOTON_NO_LEAF], a->kept->lost, sizeof a->kept->lost);
    counters[SVO_PHOTON_FIRST_SLOT] = (cl_uint)a->kept->slot_count;
    return svo_i_work_write(a->work, a->photons->counters, counters, sizeof counters);
}

/* The largest coordinate of what rays and boxes are computed from. */
static double find_largest(const svo_i_kept_photons *kept, const svo_i_light_changes *changes)
{
    double largest = 0;
    for (int axis = 0; axis < 3; ++axis) {
        largest = fmax(largest, fmax(fabs(kept->box.low[axis]), fabs(kept->box.high[axis])));
        for (size_t i = 0; i < kept->view_count; ++i) {
            largest = fmax(largest, fabs((double)kept->views[i].params.base[axis]));
        }
        for (size_t i = 0; i < changes->count; ++i) {
            largest = fmax(largest, fmax(fabs(changes->boxes[i].low[axis]), fabs(changes->boxes[i].high[axis])));
        }
    }
    return largest;
}

/* The boxes for kernels: low x, y, z, high x, y, z, wider by more than the error of floats there. */
static svo_status upload_boxes(again *a, const svo_i_light_changes *changes)
{
    const double wider = find_largest(a->kept, changes) * BOX_ERROR;
    const size_t bytes = changes->count * 6 * sizeof(cl_float);
    cl_float *boxes = svo_i_alloc(&a->kept->device->memory, bytes + 1);
    if (boxes == NULL) {
        return svo_i_device_fail(a->kept->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %zu boxes",
                                 a->work->function, changes->count);
    }
    for (size_t i = 0; i < changes->count; ++i) {
        for (size_t axis = 0; axis < 3; ++axis) {
            boxes[6 * i + axis] = (cl_float)(changes->boxes[i].low[axis] - wider);
            boxes[6 * i + 3 + axis] = (cl_float)(changes->boxes[i].high[axis] + wider);
        }
    }
    svo_status status = svo_i_work_alloc(a->work, "crossing_boxes", bytes, &a->boxes);
    if (status == SVO_OK) {
        status = svo_i_work_write(a->work, a->boxes, boxes, bytes);
    }
    svo_i_free(boxes);
    return status;
}

static svo_status find_groups(again *a, const svo_i_light_changes *changes)
{
    const size_t views = a->kept->view_count;
    SVO_I_TRY(upload_boxes(a, changes));
    SVO_I_TRY(svo_i_work_alloc(a->work, "crossing_counts", views * sizeof(cl_uint), &a->counts));
    SVO_I_TRY(svo_i_work_alloc(a->work, "crossing_groups", a->kept->photon_count / SVO_ITEM_PHOTONS * sizeof(cl_uint),
                               &a->groups));
    SVO_I_TRY(svo_i_work_fill_zero(a->work, a->counts, views * sizeof(cl_uint)));
    for (size_t i = 0; i < views; ++i) {
        SVO_I_TRY(list_groups(a, i, (uint32_t)changes->count));
    }
    return svo_i_work_read(a->work, a->counts, 0, a->view_counts, views * sizeof(cl_uint));
}

static svo_status shoot_again(again *a, const svo_i_light_changes *changes)
{
    const double start = svo_i_now_ms();
    SVO_I_TRY(svo_i_kept_use(a->kept, a->work));
    SVO_I_TRY(find_groups(a, changes));
    a->photons->view_ms += svo_i_now_ms() - start;
    SVO_I_TRY(begin_counters(a));
    for (size_t i = 0; i < a->kept->view_count; ++i) {
        SVO_I_TRY(take_back(a, i));
    }
    SVO_I_TRY(place_slots(a));
    for (size_t i = 0; i < a->kept->view_count; ++i) {
        SVO_I_TRY(shoot_view(a, i));
    }
    svo_i_work_free(a->work, &a->counts);
    svo_i_work_free(a->work, &a->groups);
    svo_i_work_free(a->work, &a->boxes);
    return svo_i_photons_use(a->photons);
}

/* Begins to mark leaves with new radiance, where the light before has what others keep. */
static svo_status begin_renewed(again *a, svo_i_light_before *before)
{
    const uint64_t bytes = a->photons->tree->info.inner_count * sizeof(cl_uint);
    if (before->origins == NULL || before->light->buffers[SVO_LIGHT_LIT] == NULL) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_work_result(a->work, "light_renewed", bytes, &before->renewed));
    a->renewed = before->renewed;
    return svo_i_work_fill_zero(a->work, a->renewed, bytes);
}

svo_status svo_i_photons_shoot_again(svo_i_photons *photons, svo_i_light_before *before)
{
    const svo_i_light_changes *changes = &before->changes;
    svo_i_kept_photons *kept = photons->kept;
    again a = {.photons = photons, .kept = kept, .work = photons->work};
    kept->whole = false; /* until it is that of the new tree */
    SVO_I_TRY(svo_i_photons_make_bands(photons));
    SVO_I_TRY(begin_renewed(&a, before));
    a.view_counts = svo_i_alloc_zeroed(&kept->device->memory, kept->view_count + 1, sizeof *a.view_counts);
    if (a.view_counts == NULL) {
        return svo_i_device_fail(kept->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %zu views",
                                 photons->work->function, kept->view_count);
    }
    photons->shot = kept->shot;
    const svo_status status = shoot_again(&a, changes);
    photons->groups = NULL;
    svo_i_free(a.view_counts);
    return status;
}

/* ---- the end ---- */

/* The codes of slots that have been claimed, and which leaves have new radiance. */
static svo_status name_slots(svo_i_photons *photons, cl_mem renewed)
{
    const svo_tree *tree = photons->tree;
    const svo_photon_params params = {.depth = tree->info.depth,
                                      .leaf_begin = (cl_uint)tree->info.inner_count,
                                      .leaf_count = (cl_uint)tree->info.leaf_count};
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(tree->buffers[SVO_TREE_CHILD_MASK]),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_FIRST_CHILD]),
                                        SVO_I_ARGUMENT(photons->slots),
                                        SVO_I_ARGUMENT(photons->kept->codes),
                                        SVO_I_ARGUMENT(photons->kept->bits),
                                        SVO_I_ARGUMENT(renewed),
                                        SVO_I_ARGUMENT(params)};
    SVO_I_TRY(svo_i_kept_use(photons->kept, photons->work));
    return svo_i_work_launch(photons->work, "svo_k_slot_codes", SVO_I_ARGUMENTS(arguments), params.leaf_count);
}

svo_status svo_i_photons_finish_kept(svo_i_photons *photons, const svo_i_flux_totals *totals, cl_mem renewed)
{
    svo_i_kept_photons *kept = photons->kept;
    SVO_I_TRY(name_slots(photons, renewed));
    kept->slot_count = photons->slot_count;
    kept->shot = photons->shot;
    kept->hits = photons->hits_before + photons->hits;
    for (size_t channel = 0; channel < 3; ++channel) {
        kept->lost[2 * channel] = (cl_uint)totals->lost[channel];
        kept->lost[2 * channel + 1] = (cl_uint)(totals->lost[channel] >> 32);
    }
    kept->whole = true;
    return SVO_OK;
}
