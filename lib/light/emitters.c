/* SPDX-License-Identifier: MIT */
/*
 * The triangles that emit, with shares by which rays choose one: the brightest emission of their leaves, times the area
 * in these. And for photons, which leave where emission is: the pieces of triangles in the leaves that emit, which are
 * clipped at the faces of the cells (Sutherland and Hodgman, "Reentrant Polygon Clipping", 1974). All of it is computed
 * on the host, by + - * / and square root, so that each device chooses the same.
 */
#include "light/emitters.h"

#include <math.h>
#include <string.h>

#include "core/memory.h"
#include "core/tree.h"
#include "rays/rays.h"
#include "svocl/nodes.h"
#include "svocl/plan.h"

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
    uint8_t *colors; /* of leaves, or one for all; NULL: none, they are opaque */
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
    svo_i_free(tree->colors);
}

/* ---- which triangles ---- */

static float brightness_of(const svo_finish *finishes, size_t finish_count, uint16_t material)
{
    if (material >= finish_count) {
        return 0.0F;
    }
    const float *emission = finishes[material].emission;
    return fmaxf(emission[0], fmaxf(emission[1], emission[2]));
}

/* Takes the triangles of the leaves that emit. */
static void mark_triangles(const emitter_tree *tree)
{
    const bool is_one = svo_i_tree_is_constant(tree->info, SVO_TREE_MATERIALS);
    for (uint64_t leaf = 0; leaf < tree->info->leaf_count; ++leaf) {
        const svo_i_light_setup *setup = &tree->light->setup;
        const float brightness =
            brightness_of(setup->finishes, setup->finish_count, tree->materials[is_one ? 0 : leaf]);
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

static bool any_emits(const svo_finish *finishes, size_t finish_count)
{
    bool emits = false;
    for (size_t i = 0; finishes != NULL && i < finish_count; ++i) {
        emits = emits || brightness_of(finishes, finish_count, (uint16_t)i) > 0.0F;
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

bool svo_i_emission_may_be(const svo_tree *tree, const svo_finish *finishes, size_t finish_count)
{
    return any_emits(finishes, finish_count) && svo_i_rays_of_triangles(&tree->info) &&
           tree->buffers[SVO_TREE_MATERIALS] != NULL && tree->info.list_triangle_count > 0;
}

svo_status svo_i_light_list_emitters(svo_light *light, const char *function, const svo_gather_params *gather,
                                     const svo_submit *submit)
{
    svo_i_device_work work;
    if (gather->paths == 0 || gather->with_light == 0 || light->knows_emitters ||
        !svo_i_emission_may_be(light->tree, light->setup.finishes, light->setup.finish_count)) {
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

/* ---- pieces for photons ---- */

#define PI           3.14159265358979323846
#define CORNERS_MAX  9 /* of a triangle that six planes have clipped */
#define FIRST_PIECES 1024u

/* A convex polygon. */
typedef struct polygon {
    double corners[CORNERS_MAX + 1][3];
    int count;
} polygon;

/* Keeps what of a polygon is on one side of a plane across an axis: below a place, or with sign -1 above it. */
static void clip(polygon *shape, int axis, double place, double sign)
{
    polygon kept = {.count = 0};
    for (int i = 0; i < shape->count; ++i) {
        const double *from = shape->corners[i];
        const double *to = shape->corners[(i + 1) % shape->count];
        const double inside = sign * (place - from[axis]);
        const double next_inside = sign * (place - to[axis]);
        if (inside >= 0) {
            memcpy(kept.corners[kept.count++], from, sizeof kept.corners[0]);
        }
        if ((inside > 0 && next_inside < 0) || (inside < 0 && next_inside > 0)) {
            const double share = inside / (inside - next_inside);
            for (int k = 0; k < 3; ++k) {
                kept.corners[kept.count][k] = k == axis ? place : from[k] + share * (to[k] - from[k]);
            }
            ++kept.count;
        }
    }
    *shape = kept;
}

/* Vector product of the edges of a polygon's triangle from corner 0, and the edges. Returns twice its area. */
static double measure(const polygon *shape, int second, double edges[2][3], double normal[3])
{
    for (int k = 0; k < 3; ++k) {
        edges[0][k] = shape->corners[second][k] - shape->corners[0][k];
        edges[1][k] = shape->corners[second + 1][k] - shape->corners[0][k];
    }
    for (int k = 0; k < 3; ++k) {
        const int next = (k + 1) % 3;
        const int last = (k + 2) % 3;
        normal[k] = edges[0][next] * edges[1][last] - edges[0][last] * edges[1][next];
    }
    return sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
}

/* Room for one more. */
static svo_status make_room(const emitter_tree *tree, svo_i_emission *out)
{
    const svo_i_memory *memory = &tree->light->device->memory;
    if (out->count < out->room) {
        return SVO_OK;
    }
    const size_t room = out->room > 0 ? 2 * (size_t)out->room : FIRST_PIECES;
    svo_emitter_piece *pieces = svo_i_grow(memory, out->pieces, room * sizeof *pieces);
    out->pieces = pieces != NULL ? pieces : out->pieces;
    double *powers = svo_i_grow(memory, out->powers, room * sizeof *powers);
    out->powers = powers != NULL ? powers : out->powers;
    uint32_t *finishes = svo_i_grow(memory, out->finishes, room * sizeof *finishes);
    out->finishes = finishes != NULL ? finishes : out->finishes;
    if (pieces == NULL || powers == NULL || finishes == NULL || room > UINT32_MAX / 2) {
        return svo_i_device_fail(tree->light->device, SVO_OUT_OF_HOST_MEMORY,
                                 "%s: no memory for %zu pieces of triangles that emit", tree->work->function, room);
    }
    out->room = (uint32_t)room;
    return SVO_OK;
}

/* Adds a polygon's triangles. power: of a unit of area. */
static svo_status add_pieces(const emitter_tree *tree, const polygon *shape, uint16_t finish, double power,
                             svo_i_emission *out)
{
    for (int second = 1; second + 1 < shape->count; ++second) {
        double edges[2][3];
        double normal[3];
        const double twice = measure(shape, second, edges, normal);
        if (!(twice > 0)) {
            continue;
        }
        SVO_I_TRY(make_room(tree, out));
        svo_emitter_piece *piece = &out->pieces[out->count];
        *piece = (svo_emitter_piece){.end = 0};
        for (int k = 0; k < 3; ++k) {
            piece->corner[k] = (float)shape->corners[0][k];
            piece->first_edge[k] = (float)edges[0][k];
            piece->second_edge[k] = (float)edges[1][k];
            piece->normal[k] = (cl_int)floor(ldexp(normal[k] / twice, SVO_FLUX_UNIT_LOG2) + 0.5);
        }
        out->finishes[out->count] = finish;
        out->powers[out->count++] = twice / 2 * power;
        out->power += twice / 2 * power;
    }
    return SVO_OK;
}

/* The pieces in a leaf. power: of a unit of area there. */
static svo_status add_leaf(const emitter_tree *tree, uint64_t leaf, const svo_box *cell, uint16_t finish, double power,
                           svo_i_emission *out)
{
    for (uint32_t i = tree->list_begin[leaf]; i < tree->list_begin[leaf + 1]; ++i) {
        polygon shape = {.count = 3};
        for (int corner = 0; corner < 3; ++corner) {
            corner_of(tree, tree->list[i], corner, shape.corners[corner]);
        }
        for (int axis = 0; axis < 3; ++axis) {
            clip(&shape, axis, cell->high[axis], 1);
            clip(&shape, axis, cell->low[axis], -1);
        }
        SVO_I_TRY(add_pieces(tree, &shape, finish, power, out));
    }
    return SVO_OK;
}

static svo_status list_pieces(const emitter_tree *tree, const svo_light_setup *setup, const uint64_t *codes,
                              svo_i_emission *out)
{
    const bool is_one = svo_i_tree_is_constant(tree->info, SVO_TREE_MATERIALS);
    const bool is_one_color = svo_i_tree_is_constant(tree->info, SVO_TREE_COLORS);
    svo_grid grid = {.depth = 0};
    SVO_I_TRY(svo_tree_get_grid(tree->light->tree, &grid));
    for (uint64_t leaf = 0; leaf < tree->info->leaf_count; ++leaf) {
        const uint16_t finish = tree->materials[is_one ? 0 : leaf];
        const double brightness = (double)brightness_of(setup->finishes, setup->finish_count, finish);
        const double alpha = tree->colors != NULL ? tree->colors[4 * (is_one_color ? 0 : leaf) + 3] / 255.0 : 1;
        if (brightness > 0 && alpha > 0) {
            uint32_t at[3];
            svo_box cell;
            svo_code_to_cell(codes[leaf], at);
            svo_grid_cell_box(&grid, grid.depth, at, cell.low, cell.high);
            SVO_I_TRY(add_leaf(tree, leaf, &cell, finish, 2 * PI * brightness * alpha, out));
        }
    }
    return SVO_OK;
}

static svo_status read_colors(emitter_tree *tree)
{
    const bool is_one = svo_i_tree_is_constant(tree->info, SVO_TREE_COLORS);
    const uint64_t first =
        tree->info->level_begin[tree->info->depth] - tree->info->level_begin[tree->info->payload_level];
    void *array = NULL;
    if ((tree->info->need & SVO_NEED_COLOR) == 0) {
        return SVO_OK;
    }
    const svo_status status = read_array(tree, SVO_TREE_COLORS, is_one ? 0 : first, is_one ? 1 : tree->info->leaf_count,
                                         4 * sizeof(uint8_t), &array);
    tree->colors = array;
    return status;
}

svo_status svo_i_emission_list(svo_i_device_work *work, const svo_light *light, const svo_light_setup *setup,
                               const uint64_t *codes, svo_i_emission *out)
{
    emitter_tree tree = {.work = work, .light = light, .info = &light->tree->info};
    svo_status status = SVO_OK;
    SVO_I_TRY_CLEANUP(read_materials(&tree));
    SVO_I_TRY_CLEANUP(read_colors(&tree));
    SVO_I_TRY_CLEANUP(read_triangles(&tree));
    SVO_I_TRY_CLEANUP(list_pieces(&tree, setup, codes, out));

cleanup:
    free_arrays(&tree);
    return status;
}

void svo_i_emission_share(svo_i_emission *emission, const svo_light_setup *setup, uint32_t photon_count, double unit,
                          uint64_t *brightest)
{
    const double each = emission->power / photon_count / unit;
    double before = 0;
    *brightest = (uint64_t)(each + 0.5);
    for (uint32_t i = 0; i < emission->count; ++i) {
        svo_emitter_piece *piece = &emission->pieces[i];
        const float *color = setup->finishes[emission->finishes[i]].emission;
        const double most = fmax((double)color[0], fmax((double)color[1], (double)color[2]));
        before += emission->powers[i];
        piece->end = (cl_uint)floor(before / emission->power * photon_count + 0.5);
        for (size_t channel = 0; channel < 3; ++channel) {
            const uint64_t flux = (uint64_t)(each * ((double)color[channel] / most) + 0.5);
            piece->flux[2 * channel] = (cl_uint)flux;
            piece->flux[2 * channel + 1] = (cl_uint)(flux >> 32);
        }
    }
    if (emission->count > 0) {
        emission->pieces[emission->count - 1].end = photon_count;
    }
}

void svo_i_emission_free(svo_i_emission *emission)
{
    svo_i_free(emission->pieces);
    svo_i_free(emission->powers);
    svo_i_free(emission->finishes);
    *emission = (svo_i_emission){.pieces = NULL};
}
