/* SPDX-License-Identifier: MIT */
/*
 * Photons into leaves, in bands of a view: weights from the host, rays, hits by the batches of lib/rays, the leaf of
 * each hit, and sums. Which leaves get light is not known before, so they claim slots among the sums, which grow. What
 * is kept of photons receives a copy of each band; shoot.c shoots again from it.
 *
 * Where the tree shows in part, photons go on behind what they met as its alpha tells, through voxels at once. With
 * bounces each band goes on from what it met, with what albedos leave of its flux, as often as asked or until too
 * little is left. Photons of triangles that emit come in bands, too: kernels/light/sent_photons.cl.
 */
#include "light/photons.h"

#include <math.h>
#include <string.h>

#include "light/programs.h"
#include "rays/batch.h"
#include "rays/rays.h"
#include "svocl/trace.h"

/* A photon ends where it carries less than this part of what the brightest began with. */
#define LEAST_FLUX_LOG2 12
/* Photons stop at what they meet behind so many layers that show in part. */
#define LAYERS_MAX 64u

/* The first room for slots. */
#define FIRST_SLOTS (UINT32_C(1) << 16)

/* ---- buffers ---- */

/* 64-bit numbers of one slot. */
static uint64_t sums_of_slot(const svo_i_photons *photons)
{
    return photons->has_directions ? SVO_FLUX_SUMS + SVO_FACE_SUMS : SVO_FLUX_SUMS;
}

static uint64_t sum_bytes(const svo_i_photons *photons, uint64_t slots)
{
    return slots * sums_of_slot(photons) * sizeof(cl_ulong);
}

svo_status svo_i_photons_use(const svo_i_photons *photons)
{
    static const char *const defines[2][2] = {
        {" -DSVO_SORT", " -DSVO_SORT -DSVO_LIGHT_LOBES"},
        {" -DSVO_SORT -DSVO_LIGHT_FACES", " -DSVO_SORT -DSVO_LIGHT_FACES -DSVO_LIGHT_LOBES"}};
    return svo_i_work_use(photons->work, &svo_i_program_photons, defines[photons->has_directions][photons->has_lobes]);
}

/* Makes room for slots, or more of it. */
static svo_status make_sums(svo_i_photons *photons, uint64_t room)
{
    svo_i_kept_photons *kept = photons->kept;
    cl_mem larger = NULL;
    if (kept != NULL) {
        SVO_I_TRY(svo_i_kept_grow(kept, photons->work, room, sum_bytes(photons, 1),
                                  svo_i_photons_values_of_leaf(photons) * sizeof(cl_uint)));
        photons->sums = kept->sums;
    } else {
        SVO_I_TRY(svo_i_work_alloc(photons->work, "photon_sums", sum_bytes(photons, room), &larger));
        SVO_I_TRY(svo_i_work_fill_zero(photons->work, larger, sum_bytes(photons, room)));
        SVO_I_TRY(svo_i_work_copy(photons->work, photons->sums, 0, larger, 0, sum_bytes(photons, photons->slot_room)));
        svo_i_work_free(photons->work, &photons->sums);
        photons->sums = larger;
    }
    photons->slot_room = room;
    return SVO_OK;
}

static svo_status begin_sums(svo_i_photons *photons)
{
    const uint64_t leaves = photons->tree->info.leaf_count;
    if (photons->kept != NULL && photons->kept->sums != NULL) {
        photons->sums = photons->kept->sums;
        photons->slot_room = photons->kept->slot_room;
        return SVO_OK;
    }
    return make_sums(photons, leaves < FIRST_SLOTS ? leaves : FIRST_SLOTS);
}

svo_status svo_i_photons_see_alpha(svo_i_photons *photons)
{
    const svo_tree *tree = photons->tree;
    uint8_t root[4] = {255, 255, 255, 255};
    if ((tree->info.need & SVO_NEED_COLOR) != 0) {
        SVO_I_TRY(svo_i_work_read(photons->work, tree->buffers[SVO_TREE_COLORS], 0, root, sizeof root));
    }
    photons->is_clear = photons->of_triangles && root[3] != 255;
    photons->has_clear_voxels = !photons->of_triangles && root[3] != 255 &&
                                (tree->info.payload_level == 0 || svo_i_tree_is_constant(&tree->info, SVO_TREE_COLORS));
    return SVO_OK;
}

svo_status svo_i_photons_begin(svo_i_device_work *work, svo_tree *tree, bool has_directions, double unit,
                               svo_i_kept_photons *kept, svo_i_photons *out)
{
    const svo_tree_info *info = &tree->info;
    const uint64_t slot_bytes = info->leaf_count * sizeof(cl_uint);
    const uint64_t counters = SVO_PHOTON_COUNTERS + (kept != NULL ? kept->slot_count : 0);
    *out = (svo_i_photons){.work = work,
                           .tree = tree,
                           .has_directions = has_directions,
                           .of_triangles = svo_i_rays_of_triangles(info),
                           .bounces = 1,
                           .unit = unit,
                           .kept = kept};
    SVO_I_TRY(svo_i_work_alloc(work, "photon_slots", slot_bytes, &out->slots));
    SVO_I_TRY(begin_sums(out));
    SVO_I_TRY(svo_i_work_alloc(work, "photon_counters", counters * sizeof(cl_uint), &out->counters));
    SVO_I_TRY(svo_i_work_fill(work, out->slots, SVO_SLOT_NONE, slot_bytes));
    return svo_i_work_fill_zero(work, out->counters, SVO_PHOTON_COUNTERS * sizeof(cl_uint));
}

/* What only some photons need. */
static svo_status make_onward_bands(svo_i_photons *photons, bool is_carried)
{
    svo_i_device_work *work = photons->work;
    const uint64_t list_bytes = SVO_I_BAND_PHOTONS * sizeof(cl_uint);
    if (is_carried && photons->carried == NULL) {
        SVO_I_TRY(svo_i_work_alloc(work, "photons_carried", SVO_I_BAND_PHOTONS * sizeof(svo_carried_photon),
                                   &photons->carried));
    }
    if (!photons->is_clear || photons->behind != NULL) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_work_alloc(work, "photon_lists", list_bytes, &photons->lists[0]));
    SVO_I_TRY(svo_i_work_alloc(work, "photon_lists", list_bytes, &photons->lists[1]));
    SVO_I_TRY(svo_i_work_alloc(work, "photon_found", SVO_I_BAND_PHOTONS * sizeof(svo_hit), &photons->found));
    return svo_i_work_alloc(work, "photon_behind", SVO_I_BAND_PHOTONS * sizeof(svo_ray), &photons->behind);
}

svo_status svo_i_photons_make_bands(svo_i_photons *photons)
{
    SVO_I_TRY(make_onward_bands(photons, photons->bounces > 1));
    if (photons->leaves != NULL) {
        return SVO_OK;
    }
    photons->host_weights =
        svo_i_alloc(&photons->tree->device->memory, SVO_I_BAND_PHOTONS * sizeof *photons->host_weights);
    if (photons->host_weights == NULL) {
        return svo_i_device_fail(photons->tree->device, SVO_OUT_OF_HOST_MEMORY,
                                 "%s: no memory for the weights of %u photons", photons->work->function,
                                 SVO_I_BAND_PHOTONS);
    }
    SVO_I_TRY(svo_i_work_alloc(photons->work, "photon_weights", SVO_I_BAND_PHOTONS * sizeof(svo_photon_weight),
                               &photons->weights));
    SVO_I_TRY(svo_i_work_alloc(photons->work, "photon_rays", SVO_I_BAND_PHOTONS * sizeof(svo_ray), &photons->rays));
    SVO_I_TRY(svo_i_work_alloc(photons->work, "photon_hits", SVO_I_BAND_PHOTONS * sizeof(svo_hit), &photons->met));
    SVO_I_TRY(svo_i_work_alloc(photons->work, "photon_spreads",
                               SVO_I_BAND_PHOTONS / SVO_ITEM_PHOTONS * sizeof(svo_photon_spread), &photons->spreads));
    return svo_i_work_alloc(photons->work, "photon_leaves", SVO_I_BAND_PHOTONS * sizeof(cl_uint), &photons->leaves);
}

void svo_i_photons_release_bands(svo_i_photons *photons)
{
    svo_i_work_free(photons->work, &photons->weights);
    svo_i_work_free(photons->work, &photons->rays);
    svo_i_work_free(photons->work, &photons->met);
    svo_i_work_free(photons->work, &photons->spreads);
    svo_i_work_free(photons->work, &photons->leaves);
    svo_i_work_free(photons->work, &photons->carried);
    svo_i_work_free(photons->work, &photons->behind);
    svo_i_work_free(photons->work, &photons->found);
    svo_i_work_free(photons->work, &photons->lists[0]);
    svo_i_work_free(photons->work, &photons->lists[1]);
    svo_i_free(photons->host_weights);
    photons->host_weights = NULL;
}

void svo_i_photons_release(svo_i_photons *photons)
{
    svo_i_photons_release_bands(photons);
    svo_i_work_free(photons->work, &photons->slots);
    svo_i_work_free(photons->work, &photons->sums);
    svo_i_work_free(photons->work, &photons->counters);
}

svo_status svo_i_photons_make_room(svo_i_photons *photons)
{
    const uint64_t most = photons->tree->info.leaf_count;
    cl_uint counted[2] = {0, 0};
    SVO_I_TRY(svo_i_work_read(photons->work, photons->counters, 0, counted, sizeof counted));
    const uint64_t claimed = counted[SVO_PHOTON_SLOTS];
    const uint64_t free = photons->slot_free;
    photons->slot_count = photons->slot_base + (claimed > free ? claimed - free : 0);
    photons->lit_count = photons->slot_base - free + claimed;
    /* The counter of hits may wrap between many views; a band has fewer. */
    photons->hits += (cl_uint)(counted[SVO_PHOTON_HITS] - (cl_uint)photons->hits);
    if (photons->slot_count <= photons->slot_room) {
        return SVO_OK;
    }
    return make_sums(photons, 2 * photons->slot_count < most ? 2 * photons->slot_count : most);
}

/* ---- a band ---- */

/* What rays meet. */
static svo_status trace_rays(svo_i_photons *photons, cl_mem from, cl_mem hits, uint32_t count)
{
    svo_i_device_work *work = photons->work;
    cl_event done = NULL;
    const svo_array rays = svo_in_buffer(from);
    const svo_array met = svo_in_buffer(hits);
    const svo_submit submit = {.queue = work->queue, .num_wait = 1, .wait = &work->last, .event = &done};
    const svo_status status =
        photons->of_triangles
            ? svo_i_tree_trace_triangles(photons->tree, &rays, &met, count, SVO_TRACE_CLOSEST, &submit)
            : svo_i_tree_trace_voxels(photons->tree, &rays, &met, count, 0.0F, 0, &submit);
    if (status != SVO_OK) {
        svo_i_message_rename(svo_i_device_message(work->device), work->function);
        return status;
    }
    svo_i_work_follow(work, done);
    return SVO_OK;
}

static svo_photon_params make_params(const svo_i_photons *photons, uint32_t count, uint32_t spreads)
{
    const svo_tree *tree = photons->tree;
    const double leaf_edge = ldexp(1 / tree->info.scale, (int)(tree->info.snap_bits - tree->info.depth));
    return (svo_photon_params){.depth = tree->info.depth,
                               .snap_bits = tree->info.snap_bits,
                               .leaf_begin = (cl_uint)tree->info.inner_count,
                               .leaf_count = (cl_uint)tree->info.leaf_count,
                               .triangle_count = (cl_uint)tree->info.list_triangle_count,
                               .count = count,
                               .spreads = spreads,
                               .cells = (cl_float)(1 / leaf_edge)};
}

/* The arguments of a tree with leaf lists. */
#define LIST_ARGUMENTS(tree)                                                                                     \
    SVO_I_ARGUMENT((tree)->buffers[SVO_TREE_CHILD_MASK]), SVO_I_ARGUMENT((tree)->buffers[SVO_TREE_FIRST_CHILD]), \
        SVO_I_ARGUMENT((tree)->buffers[SVO_TREE_LIST_BEGIN]), SVO_I_ARGUMENT((tree)->buffers[SVO_TREE_LIST]),    \
        SVO_I_ARGUMENT((tree)->buffers[SVO_TREE_VERTICES]), SVO_I_ARGUMENT((tree)->buffers[SVO_TREE_INDICES]),   \
        SVO_I_ARGUMENT((tree)->buffers[SVO_TREE_TRIANGLE_IDS])

/* The leaves of that. spreads: SVO_SPREAD_*; view: whose photons they are, for SVO_SPREAD_VIEW. */
static svo_status find_leaves(svo_i_photons *photons, uint32_t spreads, const svo_light_view_params *view,
                              uint32_t count)
{
    static const svo_light_view_params no_view = {.count = 0};
    const svo_photon_params params = make_params(photons, count, spreads);
    const svo_i_argument scratch = SVO_I_LOCAL(SVO_GROUP_ITEMS * sizeof(cl_uint));
    const uint64_t items = (count + SVO_ITEM_PHOTONS - 1) / SVO_ITEM_PHOTONS;
    const svo_i_argument arguments[] = {LIST_ARGUMENTS(photons->tree),
                                        SVO_I_ARGUMENT(photons->met),
                                        SVO_I_ARGUMENT(photons->leaves),
                                        SVO_I_ARGUMENT(photons->spreads),
                                        SVO_I_ARGUMENT(photons->slots),
                                        SVO_I_ARGUMENT(photons->counters),
                                        scratch,
                                        SVO_I_ARGUMENT(params),
                                        SVO_I_ARGUMENT(photons->groups),
                                        SVO_I_ARGUMENT(*(view != NULL ? view : &no_view))};
    const svo_i_argument *of_voxels = &arguments[7]; /* without lists and view */
    const cl_uint argument_count = (cl_uint)(sizeof arguments / sizeof arguments[0]);
    return photons->of_triangles
               ? svo_i_work_launch(photons->work, "svo_k_photon_find", arguments, argument_count, items)
               : svo_i_work_launch(photons->work, "svo_k_voxel_find", of_voxels, argument_count - 9, items);
}

/* ---- photons that go on ---- */

static svo_status use_sent(const svo_i_photons *photons)
{
    return svo_i_work_use(photons->work, &svo_i_program_sent_photons,
                          photons->has_directions ? " -DSVO_LIGHT_FACES" : "");
}

/* What the kernels of photons that go on need to know of the tree. As kernels/light/surface.clh has it, rays leave a
   triangle by 2^-18 of the grid, and voxels by 1.75 of theirs. */
static svo_onward_params make_onward(const svo_i_photons *photons, uint32_t first, uint32_t count, uint32_t flags)
{
    const svo_tree_info *info = &photons->tree->info;
    const double grid = ldexp(1 / info->scale, (int)info->snap_bits);
    const double offset = photons->of_triangles ? ldexp(grid, -18) : 1.75 * ldexp(grid, -(int)info->depth);
    return (svo_onward_params){.count = count,
                               .first = first,
                               .flags = flags | ((info->need & SVO_NEED_COLOR) != 0 ? SVO_ONWARD_COLORS : 0) |
                                        (svo_i_tree_is_constant(info, SVO_TREE_COLORS) ? SVO_ONWARD_ONE_COLOR : 0),
                               .leaf_begin = (cl_uint)(info->inner_count - info->level_begin[info->payload_level]),
                               .offset = (cl_float)offset};
}

/* The seed of the numbers of photons: of a view, a bounce and a layer. */
static uint32_t make_seed(const svo_i_photons *photons, uint32_t bounce, uint32_t layer)
{
    return ((photons->views * 64 + bounce) * LAYERS_MAX + layer) * 4;
}

/* Which photons of a launch go on behind what they met. view: whose photons they are. */
static svo_status list_through(svo_i_photons *photons, const svo_light_view_params *view, uint32_t bounce,
                               uint32_t layer, uint32_t count, uint32_t *listed)
{
    const svo_photon_params params = make_params(photons, count, SVO_SPREAD_NOTHING);
    svo_onward_params onward =
        make_onward(photons, view->first, count,
                    (layer > 0 ? SVO_ONWARD_LISTED : 0) | (layer + 1 == LAYERS_MAX ? SVO_ONWARD_LAST : 0));
    onward.seed = make_seed(photons, bounce, layer);
    onward.through = photons->through;
    const svo_i_argument arguments[] = {LIST_ARGUMENTS(photons->tree),
                                        SVO_I_ARGUMENT(photons->tree->buffers[SVO_TREE_COLORS]),
                                        SVO_I_ARGUMENT(photons->rays),
                                        SVO_I_ARGUMENT(photons->met),
                                        SVO_I_ARGUMENT(photons->found),
                                        SVO_I_ARGUMENT(photons->behind),
                                        SVO_I_ARGUMENT(photons->lists[layer % 2]),
                                        SVO_I_ARGUMENT(photons->lists[(layer + 1) % 2]),
                                        SVO_I_ARGUMENT(photons->counters),
                                        SVO_I_ARGUMENT(photons->groups),
                                        SVO_I_ARGUMENT(params),
                                        SVO_I_ARGUMENT(onward),
                                        SVO_I_ARGUMENT(*view)};
    cl_uint counted = 0;
    SVO_I_TRY(use_sent(photons));
    SVO_I_TRY(svo_i_work_launch(photons->work, "svo_k_photon_through", SVO_I_ARGUMENTS(arguments), count));
    SVO_I_TRY(svo_i_work_read(photons->work, photons->counters, SVO_PHOTON_THROUGH * sizeof counted, &counted,
                              sizeof counted));
    *listed = counted - photons->through;
    photons->through = counted;
    return SVO_OK;
}

/* The voxels that a band's rays meet, as their alpha tells. */
static svo_status trace_clear_voxels(svo_i_photons *photons, const svo_light_view_params *view, uint32_t bounce,
                                     uint32_t count)
{
    const svo_tree *tree = photons->tree;
    const cl_mem none = NULL;
    svo_ray_params grid = {.depth = 0};
    svo_onward_params onward = make_onward(photons, view->first, count, 0);
    onward.seed = make_seed(photons, bounce, 0);
    SVO_I_TRY(svo_i_rays_tree_params(tree, photons->work->function, &grid));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(tree->buffers[SVO_TREE_CHILD_MASK]),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_FIRST_CHILD]),
                                        SVO_I_ARGUMENT(none),
                                        SVO_I_ARGUMENT(none),
                                        SVO_I_ARGUMENT(grid),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_COLORS]),
                                        SVO_I_ARGUMENT(photons->rays),
                                        SVO_I_ARGUMENT(photons->met),
                                        SVO_I_ARGUMENT(photons->groups),
                                        SVO_I_ARGUMENT(onward),
                                        SVO_I_ARGUMENT(*view)};
    SVO_I_TRY(svo_i_work_use(photons->work, &svo_i_program_voxel_photons, " -DSVO_CLEAR_NODES"));
    SVO_I_TRY(svo_i_work_launch(photons->work, "svo_k_photon_voxel", SVO_I_ARGUMENTS(arguments), count));
    return svo_i_photons_use(photons);
}

/* What a band's rays meet, through what shows in part. bounce: of the photons; view: whose they are. */
static svo_status trace_band(svo_i_photons *photons, const svo_light_view_params *view, uint32_t bounce, uint32_t count)
{
    if (photons->has_clear_voxels) {
        return trace_clear_voxels(photons, view, bounce, count);
    }
    SVO_I_TRY(trace_rays(photons, photons->rays, photons->met, count));
    if (!photons->is_clear) {
        return SVO_OK;
    }
    uint32_t listed = count;
    for (uint32_t layer = 0; layer < LAYERS_MAX && listed > 0; ++layer) {
        SVO_I_TRY(list_through(photons, view, bounce, layer, listed, &listed));
        SVO_I_TRY(listed > 0 ? trace_rays(photons, photons->behind, photons->found, listed) : SVO_OK);
    }
    return svo_i_photons_use(photons);
}

/* Photons of a band that carry their flux come to leaves. */
static svo_status land(svo_i_photons *photons, const svo_onward_params *onward, uint32_t spreads)
{
    SVO_I_TRY(svo_i_photons_use(photons));
    SVO_I_TRY(find_leaves(photons, spreads, NULL, onward->count));
    SVO_I_TRY(svo_i_photons_make_room(photons));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(photons->carried), SVO_I_ARGUMENT(photons->met),
                                        SVO_I_ARGUMENT(photons->leaves),  SVO_I_ARGUMENT(photons->slots),
                                        SVO_I_ARGUMENT(photons->sums),    SVO_I_ARGUMENT(photons->counters),
                                        SVO_I_ARGUMENT(*onward)};
    SVO_I_TRY(use_sent(photons));
    return svo_i_work_launch(photons->work, "svo_k_photon_land", SVO_I_ARGUMENTS(arguments), onward->count);
}

/* Surfaces send the photons of a band on. going: receives how many. */
static svo_status send(svo_i_photons *photons, const svo_light_view_params *view, const svo_onward_params *onward,
                       uint32_t *going)
{
    const svo_i_argument scratch = SVO_I_LOCAL(SVO_GROUP_ITEMS * sizeof(cl_uint));
    const svo_i_argument arguments[] = {
        SVO_I_ARGUMENT(photons->weights),  SVO_I_ARGUMENT(photons->met),
        SVO_I_ARGUMENT(photons->leaves),   SVO_I_ARGUMENT(photons->tree->buffers[SVO_TREE_COLORS]),
        SVO_I_ARGUMENT(photons->rays),     SVO_I_ARGUMENT(photons->carried),
        SVO_I_ARGUMENT(photons->counters), scratch,
        SVO_I_ARGUMENT(*onward),           SVO_I_ARGUMENT(*view)};
    cl_uint counted = 0;
    SVO_I_TRY(use_sent(photons));
    SVO_I_TRY(svo_i_work_launch(photons->work, "svo_k_photon_send", SVO_I_ARGUMENTS(arguments), onward->count));
    SVO_I_TRY(
        svo_i_work_read(photons->work, photons->counters, SVO_PHOTON_ON * sizeof counted, &counted, sizeof counted));
    *going = counted - (cl_uint)photons->sent;
    photons->sent += *going;
    return SVO_OK;
}

/* Sends a band on from what it met, until no photon is left. brightest: the most that one began with; of_view: they
   carry nothing yet. */
static svo_status send_on(svo_i_photons *photons, const svo_light_view_params *view, uint64_t brightest, bool of_view)
{
    const uint64_t least = brightest >> LEAST_FLUX_LOG2;
    uint32_t going = view->count;
    for (uint32_t bounce = 1; bounce < photons->bounces && going > 0; ++bounce) {
        const double start = svo_i_now_ms();
        svo_onward_params onward =
            make_onward(photons, view->first, view->count, of_view && bounce == 1 ? SVO_ONWARD_VIEW : 0);
        onward.seed = make_seed(photons, bounce, 0) + 1;
        onward.least[0] = (cl_uint)least;
        onward.least[1] = (cl_uint)(least >> 32);
        SVO_I_TRY(send(photons, view, &onward, &going));
        SVO_I_TRY(going > 0 ? trace_band(photons, view, bounce, view->count) : SVO_OK);
        SVO_I_TRY(svo_i_work_wait(photons->work));
        const double seen = svo_i_now_ms();
        SVO_I_TRY(going > 0 ? land(photons, &onward, SVO_SPREAD_ON) : SVO_OK);
        SVO_I_TRY(svo_i_work_wait(photons->work));
        photons->view_ms += seen - start;
        photons->sum_ms += svo_i_now_ms() - seen;
    }
    return svo_i_photons_use(photons);
}

static svo_status emit_band(svo_i_photons *photons, cl_mem pieces, uint32_t piece_count,
                            const svo_light_view_params *view)
{
    const double start = svo_i_now_ms();
    svo_onward_params onward = make_onward(photons, view->first, view->count, 0);
    onward.seed = make_seed(photons, 0, 0) + 1;
    onward.piece_count = piece_count;
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(pieces), SVO_I_ARGUMENT(photons->rays),
                                        SVO_I_ARGUMENT(photons->carried), SVO_I_ARGUMENT(onward)};
    SVO_I_TRY(use_sent(photons));
    SVO_I_TRY(svo_i_work_launch(photons->work, "svo_k_photon_emit", SVO_I_ARGUMENTS(arguments), view->count));
    SVO_I_TRY(trace_band(photons, view, 0, view->count));
    SVO_I_TRY(svo_i_work_wait(photons->work));
    const double seen = svo_i_now_ms();
    SVO_I_TRY(land(photons, &onward, SVO_SPREAD_WHOLE));
    SVO_I_TRY(svo_i_work_wait(photons->work));
    photons->view_ms += seen - start;
    photons->sum_ms += svo_i_now_ms() - seen;
    return SVO_OK;
}

svo_status svo_i_photons_emit(svo_i_photons *photons, cl_mem pieces, uint32_t piece_count, uint32_t photon_count,
                              uint64_t brightest)
{
    svo_light_view_params view = {.count = 0};
    SVO_I_TRY(make_onward_bands(photons, true));
    SVO_I_TRY(svo_i_photons_make_bands(photons));
    for (; view.first < photon_count; view.first += view.count) {
        view.count = photon_count - view.first < SVO_I_BAND_PHOTONS ? photon_count - view.first : SVO_I_BAND_PHOTONS;
        SVO_I_TRY(emit_band(photons, pieces, piece_count, &view));
        SVO_I_TRY(send_on(photons, &view, brightest, false));
    }
    photons->shot += photon_count;
    photons->traced += photon_count;
    ++photons->views;
    return svo_i_photons_use(photons);
}

/* ---- a band of a view ---- */

/* What a band's photons meet. */
static svo_status see_band(svo_i_photons *photons, const svo_light_view_params *params)
{
    svo_i_device_work *work = photons->work;
    const svo_i_argument rays[] = {SVO_I_ARGUMENT(photons->weights), SVO_I_ARGUMENT(photons->rays),
                                   SVO_I_ARGUMENT(photons->groups), SVO_I_ARGUMENT(*params)};
    if (photons->caster == NULL || photons->bounces > 1) {
        SVO_I_TRY(svo_i_work_launch(work, "svo_k_light_rays", SVO_I_ARGUMENTS(rays), params->count));
    }
    if (photons->caster != NULL) {
        SVO_I_TRY(svo_i_work_wait(work));
        return photons->caster->cast(photons->caster->self, params, photons->host_weights, work->queue, photons->met);
    }
    SVO_I_TRY(trace_band(photons, params, 0, params->count));
    return svo_i_work_wait(work);
}

static svo_status keep_band(const svo_i_photons *photons, const svo_light_view_params *params)
{
    const svo_i_kept_photons *kept = photons->kept;
    const svo_i_argument arguments[] = {
        SVO_I_ARGUMENT(photons->weights), SVO_I_ARGUMENT(photons->met),  SVO_I_ARGUMENT(photons->spreads),
        SVO_I_ARGUMENT(photons->slots),   SVO_I_ARGUMENT(kept->weights), SVO_I_ARGUMENT(kept->ends),
        SVO_I_ARGUMENT(kept->spreads),    SVO_I_ARGUMENT(kept->users),   SVO_I_ARGUMENT(kept->bits),
        SVO_I_ARGUMENT(photons->groups),  SVO_I_ARGUMENT(*params)};
    SVO_I_TRY(svo_i_kept_use(kept, photons->work));
    SVO_I_TRY(svo_i_work_launch(photons->work, "svo_k_photon_keep", SVO_I_ARGUMENTS(arguments),
                                params->count / SVO_ITEM_PHOTONS));
    return svo_i_photons_use(photons);
}

/* The most that a photon of a view has in a channel. */
static uint64_t brightest_of(const svo_light_view_params *params)
{
    uint64_t most = 0;
    for (size_t channel = 0; channel < 3; ++channel) {
        const uint64_t flux = (uint64_t)params->flux[2 * channel + 1] << 32 | params->flux[2 * channel];
        most = flux > most ? flux : most;
    }
    return most;
}

svo_status svo_i_photons_shoot_weighed(svo_i_photons *photons, const svo_light_view_params *params)
{
    svo_i_device_work *work = photons->work;
    const double start = svo_i_now_ms();
    const svo_i_argument add[] = {
        SVO_I_ARGUMENT(photons->weights),  SVO_I_ARGUMENT(photons->met),    SVO_I_ARGUMENT(photons->leaves),
        SVO_I_ARGUMENT(photons->spreads),  SVO_I_ARGUMENT(photons->slots),  SVO_I_ARGUMENT(photons->sums),
        SVO_I_ARGUMENT(photons->counters), SVO_I_ARGUMENT(photons->groups), SVO_I_ARGUMENT(*params)};
    SVO_I_TRY(see_band(photons, params));
    const double seen = svo_i_now_ms();
    SVO_I_TRY(find_leaves(photons, SVO_SPREAD_VIEW, params, params->count));
    SVO_I_TRY(svo_i_photons_make_room(photons));
    SVO_I_TRY(svo_i_work_launch(work, "svo_k_photon_add", SVO_I_ARGUMENTS(add),
                                (params->count + SVO_ITEM_PHOTONS - 1) / SVO_ITEM_PHOTONS));
    SVO_I_TRY(photons->kept != NULL ? keep_band(photons, params) : SVO_OK);
    SVO_I_TRY(svo_i_work_wait(work));
    photons->view_ms += seen - start;
    photons->sum_ms += svo_i_now_ms() - seen;
    return photons->bounces > 1 ? send_on(photons, params, brightest_of(params), true) : SVO_OK;
}

static svo_status shoot_band(svo_i_photons *photons, const svo_i_light_view *view, const svo_light_view_params *params)
{
    const double start = svo_i_now_ms();
    svo_photon_weight *weights = photons->host_weights;
    const uint32_t shot = svo_i_view_weights(view, params->first, params->count, weights);
    photons->shot += shot;
    photons->traced += shot;
    SVO_I_TRY(svo_i_work_write(photons->work, photons->weights, weights, params->count * sizeof *weights));
    photons->view_ms += svo_i_now_ms() - start;
    return svo_i_photons_shoot_weighed(photons, params);
}

/* All bands of a view. */
static svo_status shoot_bands(svo_i_photons *photons, const svo_i_light_view *view, svo_light_view_params *params)
{
    for (uint32_t first = 0; first < view->photon_count; first += SVO_I_BAND_PHOTONS) {
        params->first = first;
        params->count =
            view->photon_count - first < SVO_I_BAND_PHOTONS ? view->photon_count - first : SVO_I_BAND_PHOTONS;
        SVO_I_TRY(shoot_band(photons, view, params));
    }
    return SVO_OK;
}

svo_status svo_i_photons_shoot(svo_i_photons *photons, const svo_i_light_view *view, const float value[3])
{
    svo_light_view_params params = view->params;
    SVO_I_TRY(svo_i_photons_make_bands(photons));
    SVO_I_TRY(svo_i_photons_use(photons));
    for (size_t channel = 0; channel < 3; ++channel) {
        const uint64_t flux = (uint64_t)((double)value[channel] * view->pixel / photons->unit + 0.5);
        params.flux[2 * channel] = (cl_uint)flux;
        params.flux[2 * channel + 1] = (cl_uint)(flux >> 32);
    }
    if (photons->kept != NULL) {
        svo_i_kept_next_view(photons->kept, &params);
    }
    SVO_I_TRY(shoot_bands(photons, view, &params));
    ++photons->views;
    return SVO_OK;
}

/* ---- totals ---- */

svo_status svo_i_photons_total(svo_i_photons *photons, svo_i_flux_totals *totals)
{
    const svo_photon_params params = {.count = (cl_uint)photons->slot_count};
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(photons->sums), SVO_I_ARGUMENT(photons->counters),
                                        SVO_I_ARGUMENT(params)};
    cl_uint counters[SVO_PHOTON_COUNTERS] = {0};
    SVO_I_TRY(svo_i_work_launch(photons->work, "svo_k_photon_total", SVO_I_ARGUMENTS(arguments),
                                (photons->slot_count + SVO_GROUP_ITEMS - 1) / SVO_GROUP_ITEMS));
    SVO_I_TRY(svo_i_work_read(photons->work, photons->counters, 0, counters, sizeof counters));
    for (size_t channel = 0; channel < 3; ++channel) {
        const cl_uint *in_leaves = &counters[SVO_PHOTON_IN_LEAF + 2 * channel];
        const cl_uint *lost = &counters[SVO_PHOTON_NO_LEAF + 2 * channel];
        totals->in_leaves[channel] = (uint64_t)in_leaves[1] << 32 | in_leaves[0];
        totals->lost[channel] = (uint64_t)lost[1] << 32 | lost[0];
    }
    return SVO_OK;
}

/* ---- leaves that no photon met ---- */

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
    SVO_I_TRY(trace_rays(photons, photons->rays, photons->met, params->count));
    SVO_I_TRY(find_leaves(photons, SVO_SPREAD_NOTHING, NULL, params->count));
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
