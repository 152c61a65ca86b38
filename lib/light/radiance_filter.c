/* SPDX-License-Identifier: MIT */
/* The host side of kernels/light/filter.cl and brick_light.cl. */
#include "light/radiance_filter.h"

#include "light/opacity.h"
#include "light/programs.h"

/* The words of a node or a brick. */
uint64_t svo_i_light_words(svo_light_form form)
{
    switch (form) {
    case SVO_LIGHT_BRICKS:
        return SVO_BRICK_SAMPLES;
    case SVO_LIGHT_VOXELS:
        return 1;
    default:
        return 6;
    }
}

uint64_t svo_i_light_bearers(const svo_tree *tree, svo_light_form form)
{
    return form == SVO_LIGHT_BRICKS ? tree->info.inner_count : tree->info.node_count;
}

/* What the steps have in common. */
typedef struct filter {
    svo_i_device_work *work;
    svo_light *light;
    const svo_i_lit_leaves *from;
    cl_mem masks, children; /* of the tree */
    uint64_t lit_bearers; /* nodes that may have radiance: all, or those with bricks */
    cl_mem origins, fresh, old_lit, old_radiance; /* of SVO_KEPT_LIGHT_PARAMETERS */
    cl_mem marks; /* u32 a node: whether a leaf below is lit */
    cl_mem codes; /* bricks: Morton codes of inner nodes */
    cl_mem values; /* bricks: premultiplied radiance of the lit leaves */
    cl_mem places; /* bricks: u32 a leaf: its place among the lit ones, or SVO_NO_NODE */
} filter;

#define KEPT_LIGHT_ARGUMENTS(f)                                                             \
    SVO_I_ARGUMENT((f)->origins), SVO_I_ARGUMENT((f)->fresh), SVO_I_ARGUMENT((f)->old_lit), \
        SVO_I_ARGUMENT((f)->old_radiance)

static svo_light_step step_of_leaves(const filter *f)
{
    svo_light_step params = svo_i_light_step(f->light, f->light->params.depth);
    params.count = (cl_uint)f->from->lit_count;
    return params;
}

/* ---- marks ---- */

static svo_status mark_level(const filter *f, uint32_t level)
{
    const svo_light_step params = svo_i_light_step(f->light, level);
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(f->masks), SVO_I_ARGUMENT(f->children), SVO_I_ARGUMENT(f->marks),
                                        SVO_I_ARGUMENT(params)};
    return svo_i_work_launch(f->work, "svo_k_light_mark_level", SVO_I_ARGUMENTS(arguments), params.count);
}

/* The nodes that see a lit leaf below. */
static svo_status mark_nodes(filter *f)
{
    const uint64_t bytes = f->light->tree->info.node_count * sizeof(cl_uint);
    const svo_light_step params = step_of_leaves(f);
    SVO_I_TRY(svo_i_work_alloc(f->work, "light_marks", bytes, &f->marks));
    SVO_I_TRY(svo_i_work_fill_zero(f->work, f->marks, bytes));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(f->from->leaves), SVO_I_ARGUMENT(f->marks),
                                        SVO_I_ARGUMENT(params)};
    SVO_I_TRY(svo_i_work_launch(f->work, "svo_k_light_mark_leaves", SVO_I_ARGUMENTS(arguments), params.count));
    for (uint32_t level = params.level; level-- > 0;) {
        SVO_I_TRY(mark_level(f, level));
    }
    return SVO_OK;
}

/* ---- what is kept ---- */

static svo_status find_renewed(const filter *f, uint32_t level)
{
    const svo_light_step params = svo_i_light_step(f->light, level);
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(f->masks),
                                        SVO_I_ARGUMENT(f->children),
                                        SVO_I_ARGUMENT(f->origins),
                                        SVO_I_ARGUMENT(f->codes),
                                        SVO_I_ARGUMENT(f->light->before->renewed),
                                        SVO_I_ARGUMENT(f->fresh),
                                        SVO_I_ARGUMENT(params)};
    return svo_i_work_launch(f->work, "svo_k_light_renewed", SVO_I_ARGUMENTS(arguments), params.count);
}

/* Which nodes need new radiance, where the light before has that of others. Bricks: needs codes. */
static svo_status find_fresh(filter *f)
{
    const svo_i_light_before *before = f->light->before;
    const uint64_t bytes = f->light->tree->info.inner_count * sizeof(cl_uint);
    if (before == NULL || before->renewed == NULL) {
        return SVO_OK;
    }
    f->origins = before->origins;
    f->fresh = before->renewed;
    f->old_lit = before->light->buffers[SVO_LIGHT_LIT];
    f->old_radiance = before->light->buffers[SVO_LIGHT_RADIANCE];
    if (f->light->info.form == SVO_LIGHT_BRICKS) {
        SVO_I_TRY(svo_i_work_alloc(f->work, "light_fresh", bytes, &f->fresh));
        SVO_I_TRY(svo_i_work_fill_zero(f->work, f->fresh, bytes));
    }
    for (uint32_t level = f->light->params.depth; level-- > 0;) {
        SVO_I_TRY(find_renewed(f, level));
    }
    return SVO_OK;
}

/* The bricks that a lit cell touches. */
static svo_status mark_bricks(filter *f, cl_mem *brick_marks)
{
    const uint64_t count = f->light->tree->info.inner_count;
    SVO_I_TRY(svo_i_work_alloc(f->work, "light_codes", count * sizeof(cl_ulong), &f->codes));
    SVO_I_TRY(svo_i_work_alloc(f->work, "light_brick_marks", count * sizeof(cl_uint), brick_marks));
    SVO_I_TRY(svo_i_light_place(f->work, f->light, f->codes));
    SVO_I_TRY(find_fresh(f));
    for (uint32_t level = 0; level < f->light->params.depth; ++level) {
        const svo_light_step params = svo_i_light_step(f->light, level);
        const svo_i_argument arguments[] = {
            SVO_I_ARGUMENT(f->masks), SVO_I_ARGUMENT(f->children),  SVO_I_ARGUMENT(f->codes), SVO_I_ARGUMENT(f->marks),
            KEPT_LIGHT_ARGUMENTS(f),  SVO_I_ARGUMENT(*brick_marks), SVO_I_ARGUMENT(params)};
        SVO_I_TRY(svo_i_work_launch(f->work, "svo_k_light_mark_bricks", SVO_I_ARGUMENTS(arguments), params.count));
    }
    return SVO_OK;
}

/* The place of each marked element among them. total: receives how many there are; NULL: not wanted. */
static svo_status find_places(const filter *f, cl_mem marks, uint64_t count, cl_mem places, uint32_t *total)
{
    const svo_light_step params = {.count = (cl_uint)count};
    cl_mem sums = NULL;
    SVO_I_TRY(svo_i_work_alloc(f->work, "light_sums", (count + 1) * sizeof(cl_uint), &sums));
    SVO_I_TRY(svo_i_work_scan(f->work, marks, sums, count));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(marks), SVO_I_ARGUMENT(sums), SVO_I_ARGUMENT(places),
                                        SVO_I_ARGUMENT(params)};
    SVO_I_TRY(svo_i_work_launch(f->work, "svo_k_light_places", SVO_I_ARGUMENTS(arguments), count));
    if (total != NULL) {
        SVO_I_TRY(svo_i_work_read(f->work, sums, count * sizeof(cl_uint), total, sizeof *total));
    }
    svo_i_work_free(f->work, &sums);
    return SVO_OK;
}

/* Makes the buffers: where radiance is stored, and its room. marks: of what has radiance. */
static svo_status make_buffers(filter *f, cl_mem marks)
{
    svo_light *light = f->light;
    uint32_t total = 0;
    light->info.bytes[SVO_LIGHT_LIT] = f->lit_bearers * sizeof(cl_uint);
    SVO_I_TRY(svo_i_light_buffer(f->work, light, SVO_LIGHT_LIT));
    SVO_I_TRY(find_places(f, marks, f->lit_bearers, light->buffers[SVO_LIGHT_LIT], &total));
    light->info.lit_nodes = total;
    light->info.bytes[SVO_LIGHT_RADIANCE] = total * svo_i_light_words(light->info.form) * sizeof(cl_uint);
    return svo_i_light_buffer(f->work, light, SVO_LIGHT_RADIANCE);
}

/* ---- faces and voxels ---- */

static svo_status store_leaves(const filter *f)
{
    const svo_light_step params = step_of_leaves(f);
    const cl_mem *buffers = f->light->buffers;
    const svo_i_argument faces[] = {SVO_I_ARGUMENT(f->from->leaves),
                                    SVO_I_ARGUMENT(f->from->slots),
                                    SVO_I_ARGUMENT(f->from->radiance),
                                    SVO_I_ARGUMENT(buffers[SVO_LIGHT_LIT]),
                                    SVO_I_ARGUMENT(buffers[SVO_LIGHT_RADIANCE]),
                                    SVO_I_ARGUMENT(params)};
    const svo_i_argument voxels[] = {SVO_I_ARGUMENT(f->from->leaves),
                                     SVO_I_ARGUMENT(f->from->slots),
                                     SVO_I_ARGUMENT(f->from->radiance),
                                     SVO_I_ARGUMENT(buffers[SVO_LIGHT_OPACITY]),
                                     SVO_I_ARGUMENT(buffers[SVO_LIGHT_LIT]),
                                     SVO_I_ARGUMENT(buffers[SVO_LIGHT_RADIANCE]),
                                     SVO_I_ARGUMENT(params)};
    return f->light->info.form == SVO_LIGHT_FACES
               ? svo_i_work_launch(f->work, "svo_k_light_lit_faces", SVO_I_ARGUMENTS(faces), params.count)
               : svo_i_work_launch(f->work, "svo_k_light_lit_voxels", SVO_I_ARGUMENTS(voxels), params.count);
}

/* Those that stay from the light before. */
static svo_status store_leaves_again(const filter *f)
{
    const cl_mem *buffers = f->light->buffers;
    svo_light_step params = svo_i_light_step(f->light, f->light->params.depth - 1);
    params.elements = (cl_uint)svo_i_light_words(f->light->info.form);
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(f->masks),
                                        SVO_I_ARGUMENT(f->children),
                                        SVO_I_ARGUMENT(f->light->before->light->nodes->children),
                                        SVO_I_ARGUMENT(f->from->slots),
                                        SVO_I_ARGUMENT(f->from->radiance),
                                        SVO_I_ARGUMENT(buffers[SVO_LIGHT_OPACITY]),
                                        SVO_I_ARGUMENT(buffers[SVO_LIGHT_LIT]),
                                        KEPT_LIGHT_ARGUMENTS(f),
                                        SVO_I_ARGUMENT(buffers[SVO_LIGHT_RADIANCE]),
                                        SVO_I_ARGUMENT(params)};
    return svo_i_work_launch(f->work, "svo_k_light_leaves_again", SVO_I_ARGUMENTS(arguments), params.count);
}

static svo_status filter_nodes(const filter *f, uint32_t level)
{
    const svo_light_step params = svo_i_light_step(f->light, level);
    const cl_mem *buffers = f->light->buffers;
    const svo_i_argument faces[] = {SVO_I_ARGUMENT(f->masks),
                                    SVO_I_ARGUMENT(f->children),
                                    SVO_I_ARGUMENT(buffers[SVO_LIGHT_OPACITY]),
                                    SVO_I_ARGUMENT(buffers[SVO_LIGHT_LIT]),
                                    KEPT_LIGHT_ARGUMENTS(f),
                                    SVO_I_ARGUMENT(buffers[SVO_LIGHT_RADIANCE]),
                                    SVO_I_ARGUMENT(params)};
    const svo_i_argument voxels[] = {SVO_I_ARGUMENT(f->masks),
                                     SVO_I_ARGUMENT(f->children),
                                     SVO_I_ARGUMENT(buffers[SVO_LIGHT_LIT]),
                                     KEPT_LIGHT_ARGUMENTS(f),
                                     SVO_I_ARGUMENT(buffers[SVO_LIGHT_RADIANCE]),
                                     SVO_I_ARGUMENT(params)};
    return f->light->info.form == SVO_LIGHT_FACES
               ? svo_i_work_launch(f->work, "svo_k_light_face_light", SVO_I_ARGUMENTS(faces), params.count)
               : svo_i_work_launch(f->work, "svo_k_light_voxel_light", SVO_I_ARGUMENTS(voxels), params.count);
}

static svo_status filter_all_nodes(filter *f)
{
    SVO_I_TRY(mark_nodes(f));
    SVO_I_TRY(find_fresh(f));
    SVO_I_TRY(make_buffers(f, f->marks));
    SVO_I_TRY(f->fresh != NULL ? store_leaves_again(f) : store_leaves(f));
    for (uint32_t level = f->light->params.depth; level-- > 0;) {
        SVO_I_TRY(filter_nodes(f, level));
    }
    return SVO_OK;
}

/* ---- bricks ---- */

/* Radiance times opacity of the lit leaves, and where each leaf is among them. */
static svo_status premultiply(filter *f)
{
    const svo_tree_info *tree = &f->light->tree->info;
    const cl_mem areas = svo_i_light_areas(f->light);
    const svo_light_step params = step_of_leaves(f);
    cl_mem marks = NULL;
    SVO_I_TRY(svo_i_work_alloc(f->work, "light_values", f->from->lit_count * 3 * sizeof(cl_uint), &f->values));
    SVO_I_TRY(svo_i_work_alloc(f->work, "light_places", tree->leaf_count * sizeof(cl_uint), &f->places));
    SVO_I_TRY(svo_i_work_alloc(f->work, "light_leaf_marks", tree->leaf_count * sizeof(cl_uint), &marks));
    SVO_I_TRY(svo_i_work_copy(f->work, f->marks, tree->inner_count * sizeof(cl_uint), marks, 0,
                              tree->leaf_count * sizeof(cl_uint)));
    SVO_I_TRY(find_places(f, marks, tree->leaf_count, f->places, NULL));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(f->light->tree->buffers[SVO_TREE_COLORS]),
                                        SVO_I_ARGUMENT(areas),
                                        SVO_I_ARGUMENT(f->from->leaves),
                                        SVO_I_ARGUMENT(f->from->slots),
                                        SVO_I_ARGUMENT(f->from->radiance),
                                        SVO_I_ARGUMENT(f->values),
                                        SVO_I_ARGUMENT(params)};
    return svo_i_work_launch(f->work, "svo_k_light_lit_bricks", SVO_I_ARGUMENTS(arguments), params.count);
}

static svo_status filter_deepest(const filter *f)
{
    const svo_light_step params = svo_i_light_step(f->light, f->light->params.depth - 1);
    const svo_i_argument arguments[] = {
        SVO_I_ARGUMENT(f->masks),  SVO_I_ARGUMENT(f->children),
        SVO_I_ARGUMENT(f->codes),  SVO_I_ARGUMENT(f->places),
        SVO_I_ARGUMENT(f->values), SVO_I_ARGUMENT(f->light->buffers[SVO_LIGHT_LIT]),
        KEPT_LIGHT_ARGUMENTS(f),   SVO_I_ARGUMENT(f->light->buffers[SVO_LIGHT_RADIANCE]),
        SVO_I_ARGUMENT(params),    SVO_I_BRICK_ROOM};
    return svo_i_light_launch_bricks(f->work, "svo_k_light_brick_deep", SVO_I_ARGUMENTS(arguments), params.count);
}

static svo_status filter_bricks(const filter *f, uint32_t level)
{
    const svo_light_step params = svo_i_light_step(f->light, level);
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(f->masks), SVO_I_ARGUMENT(f->children),
                                        SVO_I_ARGUMENT(f->codes), SVO_I_ARGUMENT(f->light->buffers[SVO_LIGHT_LIT]),
                                        KEPT_LIGHT_ARGUMENTS(f),  SVO_I_ARGUMENT(f->light->buffers[SVO_LIGHT_RADIANCE]),
                                        SVO_I_ARGUMENT(params),   SVO_I_BRICK_ROOM};
    return svo_i_light_launch_bricks(f->work, "svo_k_light_brick_light", SVO_I_ARGUMENTS(arguments), params.count);
}

static svo_status filter_all_bricks(filter *f)
{
    cl_mem brick_marks = NULL;
    SVO_I_TRY(mark_nodes(f));
    SVO_I_TRY(mark_bricks(f, &brick_marks));
    SVO_I_TRY(make_buffers(f, brick_marks));
    SVO_I_TRY(premultiply(f));
    SVO_I_TRY(filter_deepest(f));
    for (uint32_t level = f->light->params.depth - 1; level-- > 0;) {
        SVO_I_TRY(filter_bricks(f, level));
    }
    return SVO_OK;
}

/* ---- all forms ---- */

static svo_status make_light(svo_i_device_work *work, svo_light *light, const svo_i_lit_leaves *lit)
{
    const svo_tree *tree = light->tree;
    const bool bricks = light->info.form == SVO_LIGHT_BRICKS;
    const double start = svo_i_now_ms();
    filter f = {.work = work,
                .light = light,
                .from = lit,
                .masks = tree->buffers[SVO_TREE_CHILD_MASK],
                .children = tree->buffers[SVO_TREE_FIRST_CHILD],
                .lit_bearers = svo_i_light_bearers(tree, light->info.form)};
    SVO_I_TRY(svo_i_work_use(work, &svo_i_program_light, svo_i_light_defines(light)));
    SVO_I_TRY(bricks ? filter_all_bricks(&f) : filter_all_nodes(&f));
    light->params.unit = lit->unit;
    light->params.flags |= SVO_LIGHT_FLAG_LIT;
    SVO_I_TRY(svo_i_light_took(work, light, SVO_LIGHT_STAGE_FILTER, start));
    svo_i_work_free(work, &f.marks);
    svo_i_work_free(work, &f.codes);
    svo_i_work_free(work, &f.values);
    svo_i_work_free(work, &f.places);
    return SVO_OK;
}

svo_status svo_i_light_filter(svo_i_device_work *work, svo_light *light, const svo_i_lit_leaves *lit)
{
    svo_i_light_darken(light);
    if (lit->lit_count == 0) {
        light->info.stage_ms[SVO_LIGHT_STAGE_FILTER] = 0;
        return SVO_OK;
    }
    const svo_status status = make_light(work, light, lit);
    if (status != SVO_OK) {
        svo_i_light_darken(light);
    }
    return status;
}
