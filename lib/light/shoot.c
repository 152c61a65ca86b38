/* SPDX-License-Identifier: MIT */
/*
 * From a setup to lit leaves: photons of all its sources are shot or, for a changed tree, those that the changes
 * concern (kernels/light/kept_photons.cl has the steps); exchange.c makes radiance of their sums.
 */
#include "light/shoot.h"

#include <math.h>
#include <string.h>

#include "light/emitters.h"
#include "light/exchange.h"
#include "rays/rays.h"
#include "svocl/plan.h"

/* The most masks that are read for the bounds of the leaves. */
#define BOUNDS_NODES_MAX (UINT32_C(1) << 18)
/* Times the largest coordinate: more than the error of places along rays in floats, some of 2^-24. */
#define BOX_ERROR 0x1p-18
/* Leaves from what photons go through to the leaf whose alpha counts, at most: beside its cell, and its width. */
#define CLEAR_REACH 2.5

/* ---- the bounds of the leaves ---- */

/* Replaces the codes of a level by those of the next one, in place: from the end, since a node's children come no
   earlier in theirs than it does in its own. */
static void descend(const uint8_t *masks, uint64_t parents, uint64_t *codes, uint64_t children)
{
    uint64_t to = children;
    for (uint64_t parent = parents; parent-- > 0;) {
        const uint64_t code = codes[parent];
        for (uint64_t octant = 8; octant-- > 0;) {
            if ((masks[parent] >> octant & 1) != 0) {
                codes[--to] = code << 3 | octant;
            }
        }
    }
}

/* The Morton codes of a level's nodes; released by svo_i_free. Nodes are breadth-first without gaps, so children follow
   in order, and masks alone tell. */
static svo_status find_codes(svo_i_device_work *work, const svo_tree *tree, uint32_t level, uint64_t **codes)
{
    const uint32_t *begin = tree->info.level_begin;
    svo_status status = SVO_OK;
    uint8_t *masks = svo_i_alloc_zeroed(&tree->device->memory, (size_t)begin[level] + 1, 1);
    *codes = svo_i_alloc_zeroed(&tree->device->memory, (size_t)begin[level + 1] - begin[level] + 1, sizeof **codes);
    if (masks == NULL || *codes == NULL) {
        status = svo_i_device_fail(tree->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for the cells of %u nodes",
                                   work->function, begin[level + 1]);
        goto cleanup;
    }
    SVO_I_TRY_CLEANUP(svo_i_work_read(work, tree->buffers[SVO_TREE_CHILD_MASK], 0, masks, begin[level]));
    for (uint32_t l = 0; l < level; ++l) {
        descend(masks + begin[l], begin[l + 1] - begin[l], *codes, begin[l + 2] - begin[l + 1]);
    }

cleanup:
    svo_i_free(masks);
    if (status != SVO_OK) {
        svo_i_free(*codes);
        *codes = NULL;
    }
    return status;
}

static void find_bounds(const uint64_t *codes, uint64_t count, uint32_t low[3], uint32_t high[3])
{
    low[0] = low[1] = low[2] = UINT32_MAX;
    high[0] = high[1] = high[2] = 0;
    for (uint64_t i = 0; i < count; ++i) {
        uint32_t cell[3];
        svo_code_to_cell(codes[i], cell);
        for (int axis = 0; axis < 3; ++axis) {
            low[axis] = cell[axis] < low[axis] ? cell[axis] : low[axis];
            high[axis] = cell[axis] > high[axis] ? cell[axis] : high[axis];
        }
    }
}

/* The deepest level whose cells follow from few enough masks. */
static uint32_t bounds_level(const svo_tree_info *info)
{
    uint32_t level = 0;
    while (level < info->depth && info->level_begin[level + 1] <= BOUNDS_NODES_MAX) {
        ++level;
    }
    return level;
}

/* Bounds of a tree's leaves: exact, or where that would take too many masks, of the nodes of a level above. There is a
   leaf. */
static svo_status find_lit_box(svo_i_device_work *work, const svo_tree *tree, svo_i_lit_box *box)
{
    const svo_tree_info *info = &tree->info;
    const uint32_t level = bounds_level(info);
    svo_grid grid = {.depth = 0};
    uint64_t *codes = NULL;
    uint32_t low[3];
    uint32_t high[3];
    double unused[3];
    SVO_I_TRY(svo_tree_get_grid(tree, &grid));
    SVO_I_TRY(find_codes(work, tree, level, &codes));
    find_bounds(codes, info->level_begin[level + 1] - info->level_begin[level], low, high);
    svo_i_free(codes);
    svo_grid_cell_box(&grid, level, low, box->low, unused);
    svo_grid_cell_box(&grid, level, high, unused, box->high);
    box->leaf_edge = svo_grid_cell_edge(&grid, grid.depth);
    return SVO_OK;
}

/* ---- all photons ---- */

static svo_status shoot_all(svo_i_photons *photons, const svo_light_setup *setup, const svo_i_lit_box *box)
{
    svo_i_light_view views[SVO_I_VIEWS_OF_ONE_MAX];
    for (size_t i = 0; i < setup->source_count; ++i) {
        const svo_light_source *source = &setup->sources[i];
        const uint32_t count =
            svo_i_source_is_dark(source) ? 0 : svo_i_light_views(source, box, setup->view_resolution, views);
        for (uint32_t k = 0; k < count; ++k) {
            SVO_I_TRY(svo_i_photons_shoot(photons, &views[k], source->value));
        }
    }
    return SVO_OK;
}

/* ---- photons that are shot again ---- */

/* Photons of all views that are shot again. */
typedef struct reshoot {
    svo_i_photons *photons;
    svo_i_kept_photons *kept;
    svo_i_device_work *work;
    cl_mem boxes, counts;
    cl_mem renewed; /* of svo_i_light_before */
    cl_uint *view_counts; /* groups; owned */
    cl_mem groups; /* by view, from the view's first group on */
} reshoot;

/* Which groups of a view the boxes concern. */
static svo_status list_groups(reshoot *a, size_t index, uint32_t box_count)
{
    const svo_i_kept_view *view = &a->kept->views[index];
    const double cells = 1 / svo_grid_cell_edge(&a->kept->tree.grid, a->kept->tree.grid.depth);
    /* A photon's point lies in a cell that what changed may touch, or it takes the leaf of a cell beside its own. */
    const svo_crossing_params params = {.group_count = view->photon_count / SVO_ITEM_PHOTONS,
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
static svo_status take_back(reshoot *a, size_t index)
{
    const svo_i_kept_view *view = &a->kept->views[index];
    svo_light_view_params params = view->params;
    svo_i_photons *photons = a->photons;
    params.first = view->first;
    params.count = a->view_counts[index] * SVO_ITEM_PHOTONS;
    const svo_i_argument arguments[] = {
        SVO_I_ARGUMENT(a->kept->weights),  SVO_I_ARGUMENT(a->kept->ends),  SVO_I_ARGUMENT(a->kept->spreads),
        SVO_I_ARGUMENT(a->kept->sums),     SVO_I_ARGUMENT(a->kept->users), SVO_I_ARGUMENT(a->kept->bits),
        SVO_I_ARGUMENT(photons->counters), SVO_I_ARGUMENT(a->groups),      SVO_I_ARGUMENT(params)};
    return svo_i_work_launch(a->work, "svo_k_photon_take", SVO_I_ARGUMENTS(arguments), a->view_counts[index]);
}

/* Gives the leaves of the new tree the slots that stay, and lists those that are free. */
static svo_status place_slots(reshoot *a)
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
static svo_status shoot_groups(reshoot *a, const svo_light_view_params *params)
{
    svo_i_photons *photons = a->photons;
    const svo_i_argument weigh[] = {SVO_I_ARGUMENT(a->kept->weights), SVO_I_ARGUMENT(photons->weights),
                                    SVO_I_ARGUMENT(photons->groups), SVO_I_ARGUMENT(*params)};
    SVO_I_TRY(svo_i_kept_use(photons->kept, photons->work));
    SVO_I_TRY(svo_i_work_launch(a->work, "svo_k_photon_weigh", SVO_I_ARGUMENTS(weigh), params->count));
    SVO_I_TRY(svo_i_photons_use(photons));
    return svo_i_photons_shoot_weighed(photons, params);
}

static svo_status shoot_groups_of_view(reshoot *a, size_t index)
{
    const svo_i_kept_view *view = &a->kept->views[index];
    const uint32_t photons = a->view_counts[index] * SVO_ITEM_PHOTONS;
    svo_light_view_params params = view->params;
    a->photons->groups = a->groups;
    a->photons->views = (uint32_t)index;
    a->photons->traced += photons;
    for (uint32_t done = 0; done < photons; done += params.count) {
        params.first = view->first + done;
        params.count = photons - done < SVO_I_BAND_PHOTONS ? photons - done : SVO_I_BAND_PHOTONS;
        SVO_I_TRY(shoot_groups(a, &params));
    }
    return SVO_OK;
}

/* What has been lost stays lost; slots that are claimed follow those that there are. */
static svo_status begin_counters(reshoot *a)
{
    cl_uint counters[SVO_PHOTON_COUNTERS] = {0};
    memcpy(&counters[SVO_PHOTON_NO_LEAF], a->kept->lost, sizeof a->kept->lost);
    counters[SVO_PHOTON_FIRST_SLOT] = (cl_uint)a->kept->slot_count;
    return svo_i_work_write(a->work, a->photons->counters, counters, sizeof counters);
}

/* The larger magnitude; NaN counts as none. gcc 12 for arm64 ends with an internal error on fmax in such loops. */
static double larger(double magnitude, double coordinate)
{
    return fabs(coordinate) > magnitude ? fabs(coordinate) : magnitude;
}

/* The largest coordinate of what rays and boxes are computed from. */
static double find_largest(const svo_i_kept_photons *kept, const svo_i_light_changes *changes)
{
    double largest = 0;
    for (int axis = 0; axis < 3; ++axis) {
        largest = larger(larger(largest, kept->box.low[axis]), kept->box.high[axis]);
        for (size_t i = 0; i < kept->view_count; ++i) {
            largest = larger(largest, (double)kept->views[i].params.base[axis]);
        }
        for (size_t i = 0; i < changes->count; ++i) {
            largest = larger(larger(largest, changes->boxes[i].low[axis]), changes->boxes[i].high[axis]);
        }
    }
    return largest;
}

/* The boxes for kernels: low x, y, z, high x, y, z, wider by more than the error of floats there. A leaf that shows in
   part lets photons through by its alpha, which what a box holds of it changes beside the box, too. */
static svo_status upload_boxes(reshoot *a, const svo_i_light_changes *changes)
{
    const double alphas = a->kept->is_clear || a->photons->is_clear ? CLEAR_REACH * a->kept->box.leaf_edge : 0;
    const double wider = find_largest(a->kept, changes) * BOX_ERROR + alphas;
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

static svo_status find_groups(reshoot *a, const svo_i_light_changes *changes)
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

static svo_status shoot_concerned(reshoot *a, const svo_i_light_changes *changes)
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
        SVO_I_TRY(shoot_groups_of_view(a, i));
    }
    svo_i_work_free(a->work, &a->counts);
    svo_i_work_free(a->work, &a->groups);
    svo_i_work_free(a->work, &a->boxes);
    return svo_i_photons_use(a->photons);
}

/* Begins to mark leaves with new radiance, where the light before has what others keep. */
static svo_status begin_renewed(reshoot *a, svo_i_light_before *before)
{
    const uint64_t bytes = a->photons->tree->info.inner_count * sizeof(cl_uint);
    if (before->origins == NULL || before->light->buffers[SVO_LIGHT_LIT] == NULL) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_work_result(a->work, "light_renewed", bytes, &before->renewed));
    a->renewed = before->renewed;
    return svo_i_work_fill_zero(a->work, a->renewed, bytes);
}

/* Shoots again what the boxes concern, and finds places in the new tree for the rest. */
static svo_status shoot_again(svo_i_photons *photons, svo_i_light_before *before)
{
    const svo_i_light_changes *changes = &before->changes;
    svo_i_kept_photons *kept = photons->kept;
    reshoot a = {.photons = photons, .kept = kept, .work = photons->work};
    kept->whole = false; /* until it is that of the new tree */
    SVO_I_TRY(svo_i_photons_make_bands(photons));
    SVO_I_TRY(begin_renewed(&a, before));
    a.view_counts = svo_i_alloc_zeroed(&kept->device->memory, kept->view_count + 1, sizeof *a.view_counts);
    if (a.view_counts == NULL) {
        return svo_i_device_fail(kept->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %zu views",
                                 photons->work->function, kept->view_count);
    }
    photons->shot = kept->shot;
    const svo_status status = shoot_concerned(&a, changes);
    photons->groups = NULL;
    svo_i_free(a.view_counts);
    return status;
}

/* ---- what is kept ---- */

/* Whether photons are kept: they meet triangles by rays, come from sources, and end there. */
static bool is_kept(const svo_light *light, const svo_light_setup *setup, const svo_i_photon_caster *caster)
{
    return setup->updatable != 0 && setup->diagnose == 0 && setup->bounces <= 1 && setup->emission_photons == 0 &&
           caster == NULL && svo_i_rays_of_triangles(&light->tree->info);
}

/* Begins what is kept, or goes on with it. fits: receives whether few photons need to be shot. */
static svo_status begin_kept(svo_i_device_work *work, svo_light *light, const svo_light_setup *setup,
                             const svo_i_photon_caster *caster, const svo_i_lit_box *box, bool *fits)
{
    *fits = false;
    if (light->kept != NULL && light->before != NULL) {
        SVO_I_TRY(svo_i_kept_fits(light->kept, work, light->tree, box, fits));
    }
    if (*fits) {
        return SVO_OK;
    }
    svo_i_kept_destroy(&light->kept);
    if (!is_kept(light, setup, caster)) {
        return SVO_OK;
    }
    light->kept = svo_i_alloc_zeroed(&light->device->memory, 1, sizeof *light->kept);
    if (light->kept == NULL) {
        return svo_i_device_fail(light->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for kept photons",
                                 work->function);
    }
    return svo_i_kept_begin(light->kept, work, light->tree, setup, box, light->info.form == SVO_LIGHT_FACES);
}

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

/* All photons have been shot, or shot again, and leaves that emit have slots: what is kept is whole. totals: of
   photons. renewed: of svo_i_light_before; NULL: not wanted. */
static svo_status finish_kept(svo_i_photons *photons, const svo_i_flux_totals *totals, cl_mem renewed)
{
    svo_i_kept_photons *kept = photons->kept;
    SVO_I_TRY(name_slots(photons, renewed));
    kept->is_clear = photons->is_clear;
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

/* ---- flux ---- */

/* The flux that leaves can get from all photons together, all channels. */
static double bound_flux(const svo_light_setup *setup, const svo_i_lit_box *box, const svo_i_emission *emission)
{
    svo_i_light_view views[SVO_I_VIEWS_OF_ONE_MAX];
    double bound = 3 * emission->power;
    for (size_t i = 0; i < setup->source_count; ++i) {
        const svo_light_source *source = &setup->sources[i];
        const uint32_t count = svo_i_light_views(source, box, setup->view_resolution, views);
        for (uint32_t k = 0; k < count; ++k) {
            bound += svo_i_view_measure(&views[k]) *
                     ((double)source->value[0] + (double)source->value[1] + (double)source->value[2]);
        }
    }
    return bound * (setup->bounces > 1 ? setup->bounces : 1);
}

/* The unit of flux: a power of two with which no sum overflows. */
static double flux_unit(double bound)
{
    int exponent = 0;
    (void)frexp(bound, &exponent); /* bound < 2^exponent */
    return bound > 0 ? ldexp(1.0, exponent - SVO_FLUX_TOTAL_LOG2 + 1) : 1;
}

/* What became of the flux. */
static svo_status describe_flux(svo_i_photons *photons, svo_light_info *info, svo_i_flux_totals *totals)
{
    double all = 0;
    double lost = 0;
    SVO_I_TRY(svo_i_photons_total(photons, totals));
    for (int channel = 0; channel < 3; ++channel) {
        info->flux[channel] = (double)(totals->in_leaves[channel] + totals->lost[channel]) * photons->unit;
        all += (double)totals->in_leaves[channel] + (double)totals->lost[channel];
        lost += (double)totals->lost[channel];
    }
    info->lost_flux = all > 0 ? lost / all : 0;
    info->photons = photons->shot;
    info->photon_hits = photons->hits_before + photons->hits;
    info->traced_photons = photons->traced;
    info->sent_photons = photons->sent;
    return SVO_OK;
}

/* Whether a leaf may reflect a lobe: a material shines, and where radiance has directions there are normals. */
static bool has_lobes(const svo_light *light, const svo_light_setup *setup)
{
    const uint32_t need = light->tree->info.need;
    bool shines = false;
    for (size_t i = 0; setup->finishes != NULL && i < setup->finish_count; ++i) {
        const float *specular = setup->finishes[i].specular;
        shines = shines || specular[0] > 0.0F || specular[1] > 0.0F || specular[2] > 0.0F;
    }
    return shines && (need & SVO_NEED_MATERIAL) != 0 &&
           (light->info.form != SVO_LIGHT_FACES || (need & SVO_NEED_NORMAL) != 0);
}

/* ---- from sources to lit leaves ---- */

/* Lists what emits for photons, if any are asked for. emission: all zero. */
static svo_status list_emission(svo_i_device_work *work, const svo_light *light, const svo_light_setup *setup,
                                svo_i_emission *emission)
{
    uint64_t *codes = NULL;
    if (setup->emission_photons == 0 || !svo_i_emission_may_be(light->tree, setup->finishes, setup->finish_count)) {
        return SVO_OK;
    }
    SVO_I_TRY(find_codes(work, light->tree, light->tree->info.depth, &codes));
    const svo_status status = svo_i_emission_list(work, light, setup, codes, emission);
    svo_i_free(codes);
    return status;
}

/* Shoots the photons of what emits. */
static svo_status shoot_emission(svo_i_photons *photons, const svo_light_setup *setup, svo_i_emission *emission)
{
    svo_i_device_work *work = photons->work;
    const size_t bytes = emission->count * sizeof *emission->pieces;
    uint64_t brightest = 0;
    cl_mem pieces = NULL;
    if (emission->count == 0) {
        return SVO_OK;
    }
    svo_i_emission_share(emission, setup, setup->emission_photons, photons->unit, &brightest);
    SVO_I_TRY(svo_i_work_alloc(work, "emitter_pieces", bytes, &pieces));
    SVO_I_TRY(svo_i_work_write(work, pieces, emission->pieces, bytes));
    SVO_I_TRY(svo_i_photons_emit(photons, pieces, emission->count, setup->emission_photons, brightest));
    svo_i_work_free(work, &pieces);
    return SVO_OK;
}

/* Shoots all photons, or those that changes concern. */
static svo_status shoot(svo_i_photons *photons, svo_light *light, const svo_light_setup *setup,
                        const svo_i_lit_box *box, svo_i_emission *emission, bool again)
{
    svo_status status = again ? shoot_again(photons, light->before) : shoot_all(photons, setup, box);
    if (status == SVO_OK) {
        status = shoot_emission(photons, setup, emission);
    }
    if (status == SVO_OK && !again && setup->diagnose != 0) {
        status = svo_i_photons_count_unmet(photons, setup, &light->info.missed_leaves);
    }
    svo_i_photons_release_bands(photons);
    return status;
}

/* The same with what emits, all of which is known now. */
static svo_status shine(svo_i_device_work *work, svo_light *light, const svo_light_setup *setup,
                        const svo_i_photon_caster *caster, const svo_i_lit_box *box, svo_i_emission *emission,
                        svo_i_lit_leaves *lit)
{
    svo_i_photons photons;
    svo_i_flux_totals totals;
    const double unit = flux_unit(bound_flux(setup, box, emission));
    const bool faces = light->info.form == SVO_LIGHT_FACES;
    bool again = false;
    SVO_I_TRY(begin_kept(work, light, setup, caster, box, &again));
    SVO_I_TRY(svo_i_photons_begin(work, light->tree, faces, unit, light->kept, &photons));
    photons.has_lobes = has_lobes(light, setup);
    photons.bounces = setup->bounces > 1 ? setup->bounces : 1;
    photons.caster = caster;
    SVO_I_TRY(setup->photon_alpha != 0 ? svo_i_photons_see_alpha(&photons) : SVO_OK);
    SVO_I_TRY(shoot(&photons, light, setup, box, emission, again));
    double *const stage_ms = light->info.stage_ms;
    stage_ms[SVO_LIGHT_STAGE_VIEW] = photons.view_ms;
    SVO_I_TRY(describe_flux(&photons, &light->info, &totals));
    stage_ms[SVO_LIGHT_STAGE_PHOTONS] = photons.sum_ms;
    const double start = svo_i_now_ms();
    SVO_I_TRY(svo_i_light_exchange(&photons, light, setup->finishes, setup->finish_count, lit));
    if (light->kept != NULL) {
        SVO_I_TRY(finish_kept(&photons, &totals, again ? light->before->renewed : NULL));
        lit->slots = photons.slots;
        photons.slots = NULL; /* the work releases them at its end */
    }
    light->info.lit_leaves = lit->lit_count;
    svo_i_photons_release(&photons);
    return svo_i_light_took(work, light, SVO_LIGHT_STAGE_EXCHANGE, start);
}

svo_status svo_i_light_shine(svo_i_device_work *work, svo_light *light, const svo_light_setup *setup,
                             const svo_i_photon_caster *caster, svo_i_lit_leaves *lit)
{
    svo_i_lit_box box = {.leaf_edge = 0};
    svo_i_emission emission = {.pieces = NULL};
    *lit = (svo_i_lit_leaves){.unit = 1};
    if (light->tree->info.leaf_count == 0) {
        return SVO_OK;
    }
    SVO_I_TRY(find_lit_box(work, light->tree, &box));
    svo_status status = list_emission(work, light, setup, &emission);
    if (status == SVO_OK) {
        status = shine(work, light, setup, caster, &box, &emission, lit);
    }
    svo_i_emission_free(&emission);
    return status;
}
