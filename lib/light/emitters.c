/* SPDX-License-Identifier: MIT */
/*
 * The triangles that emit, with shares by which rays choose one: the brightest emission of their leaves, times the area
 * in these. All of it is computed on the host, so that each device chooses the same.
 */
#include "light/emitters.h"

#include <math.h>
#include <string.h>

#include "core/memory.h"
#include "core/tree.h"
#include "rays/rays.h"

/* Where this share of all area emits, rays find emitters without aiming at them. */
#define MOST_AREA 0.25

/* What a tree has of its triangles, read from its device. NULL where not held. */
typedef struct emitter_tree {
    svo_i_device_work *work;
    const svo_light *light;
    const svo_tree_info *info;
    uint16_t *materials; /* of leaves, or one for all */
    uint32_t *list_begin, *list, *ids, *indices;
    void *positions; /* float, double, or int32_t in grid units */
    float *brightness; /* of each triangle: the brightest of its leaves; 0: it does not emit */
    uint32_t *leaves; /* of each triangle: those that emit */
} emitter_tree;

/* ---- what is read ---- */

/* *out: owned by the caller; NULL after a failure. */
static svo_status read_array(const emitter_tree *tree, svo_tree_buffer buffer, uint64_t first, uint64_t count,
                             size_t element_bytes, void **out)
{
    const svo_light *light = tree->light;
    *out = svo_i_alloc_zeroed(&light->device->memory, count > 0 ? count : 1, element_bytes);
    if (*out == NULL) {
        return svo_i_device_fail(light->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %llu elements of %s",
                                 tree->work->function, (unsigned long long)count,
                                 svo_name(SVO_NAME_TREE_BUFFER, (uint32_t)buffer));
    }
    const svo_status status = count > 0 ? svo_i_work_read(tree->work, light->tree->buffers[buffer],
                                                          first * element_bytes, *out, (size_t)count * element_bytes)
                                        : SVO_OK;
    if (status != SVO_OK) {
        svo_i_free(*out);
        *out = NULL;
    }
    return status;
}

static svo_status read_positions(emitter_tree *tree)
{
    static const svo_tree_buffer buffers[] = {[SVO_POSITIONS_ROUNDED] = SVO_TREE_VERTICES,
                                              [SVO_POSITIONS_FLOAT] = SVO_TREE_POSITIONS,
                                              [SVO_POSITIONS_DOUBLE] = SVO_TREE_POSITIONS_DOUBLE};
    const size_t bytes = tree->info->positions == SVO_POSITIONS_DOUBLE ? 3 * sizeof(double) : 3 * sizeof(float);
    return read_array(tree, buffers[tree->info->positions], 0, tree->info->vertex_count, bytes, &tree->positions);
}

static svo_status read_triangles(emitter_tree *tree)
{
    const svo_tree_info *info = tree->info;
    void *array = NULL;
    SVO_I_TRY(read_array(tree, SVO_TREE_LIST_BEGIN, 0, info->leaf_count + 1, sizeof(uint32_t), &array));
    tree->list_begin = array;
    SVO_I_TRY(read_array(tree, SVO_TREE_LIST, 0, info->list_count, sizeof(uint32_t), &array));
    tree->list = array;
    SVO_I_TRY(read_array(tree, SVO_TREE_TRIANGLE_IDS, 0, info->list_triangle_count, sizeof(uint32_t), &array));
    tree->ids = array;
    SVO_I_TRY(read_array(tree, SVO_TREE_INDICES, 0, info->list_triangle_count, 3 * sizeof(uint32_t), &array));
    tree->indices = array;
    return read_positions(tree);
}

static svo_status read_materials(emitter_tree *tree)
{
    const bool is_one = svo_i_tree_is_constant(tree->info, SVO_TREE_MATERIALS);
    const uint64_t first =
        tree->info->level_begin[tree->info->depth] - tree->info->level_begin[tree->info->payload_level];
    void *array = NULL;
    const svo_status status = read_array(tree, SVO_TREE_MATERIALS, is_one ? 0 : first,
                                         is_one ? 1 : tree->info->leaf_count, sizeof(uint16_t), &array);
    tree->materials = array;
    return status;
}

static void free_arrays(emitter_tree *tree)
{
    svo_i_free(tree->materials);
    svo_i_free(tree->list_begin);
    svo_i_free(tree->list);
    svo_i_free(tree->ids);
    svo_i_free(tree->indices);
    svo_i_free(tree->positions);
    svo_i_free(tree->brightness);
    svo_i_free(tree->leaves);
}

/* ---- which triangles ---- */

static float brightness_of(const svo_i_light_setup *setup, uint16_t material)
{
    if (material >= setup->finish_count) {
        return 0.0F;
    }
    const float *emission = setup->finishes[material].emission;
    return fmaxf(emission[0], fmaxf(emission[1], emission[2]));
}

/* Takes the triangles of the leaves that emit. */
static void mark_triangles(const emitter_tree *tree)
{
    const bool is_one = svo_i_tree_is_constant(tree->info, SVO_TREE_MATERIALS);
    for (uint64_t leaf = 0; leaf < tree->info->leaf_count; ++leaf) {
        const float brightness = brightness_of(&tree->light->setup, tree->materials[is_one ? 0 : leaf]);
        for (uint32_t k = tree->list_begin[leaf]; brightness > 0.0F && k < tree->list_begin[leaf + 1]; ++k) {
            const uint32_t triangle = tree->list[k];
            tree->brightness[triangle] = fmaxf(tree->brightness[triangle], brightness);
            ++tree->leaves[triangle];
        }
    }
}

/* A corner of a triangle, world units. */
static void corner_of(const emitter_tree *tree, uint64_t triangle, int corner, double out[3])
{
    const svo_tree_info *info = tree->info;
    const size_t first = (size_t)3 * tree->indices[3 * triangle + (uint64_t)corner];
    for (int axis = 0; axis < 3; ++axis) {
        const size_t at = first + (size_t)axis;
        out[axis] = info->positions == SVO_POSITIONS_DOUBLE ? ((const double *)tree->positions)[at]
                    : info->positions == SVO_POSITIONS_FLOAT
                        ? (double)((const float *)tree->positions)[at]
                        : ((const int32_t *)tree->positions)[at] / info->scale + info->origin[axis];
    }
}

/* The record of a triangle, without its share. Returns its area. */
static double describe(const emitter_tree *tree, uint64_t triangle, svo_emitter_record *out)
{
    double corners[3][3];
    double edges[2][3];
    for (int corner = 0; corner < 3; ++corner) {
        corner_of(tree, triangle, corner, corners[corner]);
    }
    for (int axis = 0; axis < 3; ++axis) {
        edges[0][axis] = corners[1][axis] - corners[0][axis];
        edges[1][axis] = corners[2][axis] - corners[0][axis];
        out->corner[axis] = (float)corners[0][axis];
        out->first_edge[axis] = (float)edges[0][axis];
        out->second_edge[axis] = (float)edges[1][axis];
    }
    const double x = edges[0][1] * edges[1][2] - edges[0][2] * edges[1][1];
    const double y = edges[0][2] * edges[1][0] - edges[0][0] * edges[1][2];
    const double z = edges[0][0] * edges[1][1] - edges[0][1] * edges[1][0];
    out->triangle = tree->ids[triangle];
    return sqrt(x * x + y * y + z * z) / 2;
}

/* ---- shares ---- */

/* How much a triangle may bring: its brightness, times its area as far as it lies in leaves that emit. */
static double power_of(const emitter_tree *tree, uint64_t triangle, double area)
{
    const double edge = (double)tree->light->params.voxel_edge;
    return (double)tree->brightness[triangle] * fmin(area, tree->leaves[triangle] * edge * edge);
}

typedef struct emitter_sums {
    double power, area; /* area: that emits */
    double whole_area; /* of all triangles */
    uint32_t count;
} emitter_sums;

static emitter_sums sum_emitters(const emitter_tree *tree)
{
    emitter_sums sums = {0, 0, 0, 0};
    for (uint64_t i = 0; i < tree->info->list_triangle_count; ++i) {
        svo_emitter_record unused;
        const double area = describe(tree, i, &unused);
        const double power = power_of(tree, i, area);
        sums.whole_area += area;
        sums.area += power > 0 ? power / (double)tree->brightness[i] : 0;
        sums.power += power;
        sums.count += power > 0 ? 1 : 0;
    }
    return sums;
}

static void fill_records(const emitter_tree *tree, const emitter_sums *sums, svo_emitter_record *records)
{
    double before = 0;
    uint32_t count = 0;
    for (uint64_t i = 0; i < tree->info->list_triangle_count; ++i) {
        svo_emitter_record record;
        const double area = describe(tree, i, &record);
        const double power = power_of(tree, i, area);
        if (power > 0) {
            const uint32_t begin = count > 0 ? records[count - 1].end : 0;
            before += power;
            record.end = (uint32_t)(before / sums->power * SVO_EMITTER_SHARES);
            record.density = (float)((record.end - begin) / (double)SVO_EMITTER_SHARES / area);
            records[count++] = record;
        }
    }
    records[count - 1].end = SVO_EMITTER_SHARES;
}

static svo_status upload(const emitter_tree *tree, const emitter_sums *sums, svo_light *light)
{
    svo_emitter_record *records = svo_i_alloc_zeroed(&light->device->memory, sums->count, sizeof *records);
    const uint64_t bytes = (uint64_t)sums->count * sizeof *records;
    svo_status status = SVO_OK;
    if (records == NULL) {
        return svo_i_device_fail(light->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %u emitters",
                                 tree->work->function, sums->count);
    }
    fill_records(tree, sums, records);
    SVO_I_TRY_CLEANUP(svo_i_work_result(tree->work, "emitters", bytes, &light->emitters));
    SVO_I_TRY_CLEANUP(svo_i_work_write(tree->work, light->emitters, records, bytes));
    light->emitter_count = sums->count;
    light->info.emitter_bytes = bytes;

cleanup:
    svo_i_free(records);
    return status;
}

/* ---- all of it ---- */

static bool any_emits(const svo_i_light_setup *setup)
{
    bool emits = false;
    for (size_t i = 0; i < setup->finish_count; ++i) {
        emits = emits || brightness_of(setup, (uint16_t)i) > 0.0F;
    }
    return emits;
}

static svo_status make_sums(emitter_tree *tree)
{
    const svo_light *light = tree->light;
    const uint64_t count = tree->info->list_triangle_count;
    tree->brightness = svo_i_alloc_zeroed(&light->device->memory, count, sizeof *tree->brightness);
    tree->leaves = svo_i_alloc_zeroed(&light->device->memory, count, sizeof *tree->leaves);
    return tree->brightness != NULL && tree->leaves != NULL
               ? SVO_OK
               : svo_i_device_fail(light->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for sums of %llu triangles",
                                   tree->work->function, (unsigned long long)count);
}

static svo_status list(svo_i_device_work *work, svo_light *light)
{
    emitter_tree tree = {.work = work, .light = light, .info = &light->tree->info};
    svo_status status = SVO_OK;
    SVO_I_TRY_CLEANUP(read_materials(&tree));
    SVO_I_TRY_CLEANUP(read_triangles(&tree));
    SVO_I_TRY_CLEANUP(make_sums(&tree));
    mark_triangles(&tree);
    const emitter_sums sums = sum_emitters(&tree);
    if (sums.count > 0 && sums.area <= MOST_AREA * sums.whole_area) {
        status = upload(&tree, &sums, light);
    }

cleanup:
    free_arrays(&tree);
    return status;
}

/* Whether the tree has triangles in leaves that may emit. */
static bool may_emit(const svo_light *light)
{
    const svo_tree *tree = light->tree;
    return any_emits(&light->setup) && svo_i_rays_of_triangles(&tree->info) &&
           tree->buffers[SVO_TREE_MATERIALS] != NULL && tree->info.list_triangle_count > 0;
}

svo_status svo_i_light_list_emitters(svo_light *light, const char *function, const svo_gather_params *gather,
                                     const svo_submit *submit)
{
    svo_i_device_work work;
    if (gather->paths == 0 || gather->with_light == 0 || light->knows_emitters || !may_emit(light)) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_work_begin(light->device, function, submit != NULL ? submit->queue : NULL, &work));
    const svo_status status = list(&work, light);
    svo_i_work_end(&work);
    if (status != SVO_OK) {
        svo_i_light_drop_emitters(light);
        return status;
    }
    light->knows_emitters = true;
    return SVO_OK;
}

void svo_i_light_drop_emitters(svo_light *light)
{
    svo_i_buffer_release(&light->emitters);
    light->emitter_count = 0;
    light->knows_emitters = false;
    light->info.emitter_bytes = 0;
}
