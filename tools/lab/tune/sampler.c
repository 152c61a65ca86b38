/* SPDX-License-Identifier: MIT */
/* The reference of the mesh, and errors of nodes: distances, faces, volume. */
#include "tune/sampler.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "path/surface_points.h"
#include "scenes/maths.h"
#include "support/info_of.h"
#include "support/lighting.h"
#include "tune/nearest_leaf.h"
#include "tune/payload_errors.h"

#define FIRST_POINTS 2048u
#define SUN          3.0F
#define SKY          0.4F

size_t sampler_points(unsigned rung)
{
    return rung < 2 ? FIRST_POINTS : (size_t)FIRST_POINTS << (rung - 1);
}

static int fail_device(const sampler *made)
{
    return program_fail_library(made->state, svo_device_message(made->opened->device));
}

/* ---- the mesh ---- */

/* Area, and the volume by signed tetrahedra from the grid's corner. */
static void measure_mesh(sampler *made)
{
    svo_tree_arrays arrays = SVO_TREE_ARRAYS_INIT;
    svo_tree_get_arrays(made->truth, &arrays);
    double sixfold = 0;
    for (size_t t = 0; t < (size_t)made->grid.list_triangle_count; ++t) {
        double p[3][3];
        for (size_t i = 0; i < 9; ++i) {
            const size_t at = (size_t)arrays.indices[3 * t + i / 3] * 3 + i % 3;
            p[i / 3][i % 3] =
                (arrays.positions_double != NULL ? arrays.positions_double[at] : (double)arrays.positions[at]) -
                made->grid.origin[i % 3];
        }
        const vector3 first = vector(p[0][0], p[0][1], p[0][2]);
        const vector3 cross = vector_cross(vector_subtract(vector(p[1][0], p[1][1], p[1][2]), first),
                                           vector_subtract(vector(p[2][0], p[2][1], p[2][2]), first));
        made->area += vector_length(cross) / 2;
        sixfold += vector_dot(first, cross);
    }
    made->volume = fabs(sixfold) / 6;
}

/* Enclosed voxels, those of the surface counted half, in voxels; below 0 where the mesh is not closed. */
static double enclosed_voxels(const sampler *made, svo_tree *tree)
{
    svo_solid_info info = SVO_SOLID_INFO_INIT;
    svo_compact *solid = NULL;
    const svo_status status = svo_solid_create(tree, NULL, made->opened->queue, &solid, &info);
    svo_compact_destroy(&solid);
    return status == SVO_OK && info.open_columns[0] + info.open_columns[1] + info.open_columns[2] == 0
               ? (double)info.inside_voxels + (double)info.surface_voxels / 2
               : -1;
}

static svo_status build(const sampler *made, unsigned depth, const svo_plan_options *asked, svo_tree **out)
{
    svo_plan *plan = NULL;
    svo_status status = svo_plan_create(made->opened->device, made->source->mesh, depth, asked, &plan);
    if (status == SVO_OK) {
        status = svo_build(plan, made->opened->cl, made->opened->queue, out, NULL);
    }
    if (status == SVO_OK) {
        status = svo_tree_download(*out, made->opened->queue);
    }
    svo_plan_destroy(&plan);
    return status;
}

static svo_plan_options grid_options(const sampler *made)
{
    const options *given = &made->state->options;
    svo_plan_options asked = {.struct_size = sizeof asked, .need = SVO_NEED_RAYS, .edge = given->edge};
    memcpy(asked.origin, given->origin, sizeof asked.origin);
    return asked;
}

static unsigned ray_depth(const sampler *made, const svo_plan_options *asked)
{
    svo_plan *plan = NULL;
    unsigned depth = 0;
    if (svo_plan_create(made->opened->device, made->source->mesh, 6, asked, &plan) == SVO_OK) {
        depth = info_of_plan(plan).ray_depth;
    }
    svo_plan_destroy(&plan);
    return depth;
}

/* Lights of --lights, or a sun and a sky; finishes of the mesh, which may shine. */
static int set_lights(sampler *out)
{
    const char *path = out->state->options.lights_path;
    const svo_mesh *mesh = out->source->mesh;
    if (path != NULL) {
        const int exit_code = lights_file_open(out->state, path, &out->lights);
        if (exit_code != PROGRAM_DONE) {
            return exit_code;
        }
        out->setup = lights_file_setup(&out->lights);
    } else {
        out->sun = (svo_light_source){
            .kind = SVO_SOURCE_DIRECTIONAL, .direction = {-0.5F, -1.0F, -0.35F}, .value = {SUN, SUN, SUN}};
        out->setup.sources = &out->sun;
        out->setup.source_count = 1;
        out->setup.sky[0] = out->setup.sky[1] = out->setup.sky[2] = SKY;
    }
    out->setup.finishes = mesh->finishes;
    out->setup.finish_count = mesh->finishes != NULL ? mesh->material_count : 0;
    out->setup.photon_alpha = 1; /* as svocl gather */
    return PROGRAM_DONE;
}

int sampler_open(program *state, const input *source, session *opened, sampler *out)
{
    const long online = sysconf(_SC_NPROCESSORS_ONLN);
    const options *given = &state->options;
    svo_gather_point probe;
    *out = (sampler){.state = state, .source = source, .opened = opened, .setup = SVO_LIGHT_SETUP_INIT};
    if (!surface_points(source->mesh, 1, 1, &probe)) {
        return program_fail(state, PROGRAM_FAILED, "%s: no triangle has an area", source->name);
    }
    out->threads = given->threads != 0 ? (unsigned)given->threads : online > 0 ? (unsigned)online : 1;
    out->has_colors = source->mesh->colors != NULL || source->mesh->material_count > 0;
    const int lights_code = set_lights(out);
    if (lights_code != PROGRAM_DONE) {
        return lights_code;
    }
    const svo_plan_options asked = grid_options(out);
    const unsigned depth = ray_depth(out, &asked);
    if (depth == 0 || build(out, depth, &asked, &out->truth) != SVO_OK) {
        const int exit_code = fail_device(out);
        sampler_close(out);
        return exit_code;
    }
    out->grid = info_of_tree(out->truth);
    out->rays = (ray_truth){.opened = opened, .tree = out->truth, .threads = out->threads};
    out->range = lighting_occlusion_range(given, out->truth);
    measure_mesh(out);
    out->volume = enclosed_voxels(out, out->truth) >= 0 ? out->volume : 0;
    return PROGRAM_DONE;
}

void sampler_close(sampler *made)
{
    svo_tree_destroy(&made->truth);
    ray_truth_clear(&made->rays);
    lights_file_close(&made->lights);
    free(made->points);
    free(made->lit);
    free(made->twice_lit);
    *made = (sampler){0};
}

/* ---- points and faces ---- */

typedef struct shape_work {
    sampler *made;
    svo_tree *tree;
    svo_tree_info info;
    svo_tree_arrays arrays;
    svo_grid grid;
    tune_errors *errors;
    random_stream random;
    size_t count;
} shape_work;

static void sample_cell(const shape_work *work, random_stream *random, uint32_t cell[3])
{
    svo_node node;
    const uint64_t leaf = random_bits(random) % work->info.leaf_count;
    (void)svo_tree_find_node(work->tree, (uint32_t)(work->info.inner_count + leaf), &node);
    memcpy(cell, node.cell, sizeof node.cell);
}

static bool is_leaf(const shape_work *work, const uint32_t cell[3], unsigned face)
{
    uint32_t beside[3] = {cell[0], cell[1], cell[2]};
    const uint32_t last = (1u << work->info.depth) - 1;
    svo_node node;
    if (beside[face / 2] == (face % 2 == 0 ? 0 : last)) {
        return false;
    }
    beside[face / 2] += face % 2 == 0 ? UINT32_MAX : 1u;
    return svo_tree_find_cell(work->tree, work->info.depth, beside, &node) == SVO_OK && node.level == work->info.depth;
}

static void place(const shape_work *work, const uint32_t cell[3], const double part[3], svo_query_point *point)
{
    double low[3];
    double high[3];
    svo_grid_cell_box(&work->grid, work->info.depth, cell, low, high);
    point->max_distance = INFINITY;
    for (int axis = 0; axis < 3; ++axis) {
        point->position[axis] = (float)(low[axis] + part[axis] * (high[axis] - low[axis]));
    }
}

/* A center and, where one of the faces that are tried is exposed, a point of it. */
static void sample_voxel(shape_work *work, size_t index, svo_query_point *center, svo_query_point *on_face)
{
    static const double middle[3] = {0.5, 0.5, 0.5};
    uint32_t cell[3];
    double part[3];
    unsigned exposed = 0;
    sample_cell(work, &work->random, cell);
    place(work, cell, middle, center);
    for (unsigned face = 0; face < 6; ++face) {
        exposed += !is_leaf(work, cell, face);
    }
    samples_add(&work->errors->of[QUANTITY_EXPOSED], index, exposed);
    on_face->max_distance = -1; /* none */
    for (int i = 0; i < 3; ++i) {
        part[i] = random_between(&work->random, 0, 1);
    }
    const unsigned face = random_index(&work->random, 6);
    part[face / 2] = face % 2;
    if (!is_leaf(work, cell, face)) {
        place(work, cell, part, on_face);
    }
}

static bool add_distances(shape_work *work)
{
    svo_query_point *points = calloc(2 * work->count, sizeof *points);
    svo_nearest *found = calloc(2 * work->count, sizeof *found);
    bool worked = points != NULL && found != NULL;
    for (size_t i = 0; i < work->count && worked; ++i) {
        sample_voxel(work, i, &points[2 * i], &points[2 * i + 1]);
    }
    worked = worked && svo_tree_nearest(work->made->truth, svo_in_host(points), svo_in_host(found), 2 * work->count,
                                        &(svo_submit){.queue = work->made->opened->queue}) == SVO_OK;
    for (size_t i = 0; i < 2 * work->count && worked; ++i) {
        samples_add(&work->errors->of[i % 2 == 0 ? QUANTITY_VOXEL : QUANTITY_FACE], i / 2,
                    (double)found[i].distance / work->errors->voxel);
    }
    free(points);
    free(found);
    return worked;
}

static bool add_surface(shape_work *work, uint32_t seed)
{
    svo_gather_point *points = calloc(work->count, sizeof *points);
    const bool worked = points != NULL && surface_points(work->made->source->mesh, work->count, seed, points);
    for (size_t i = 0; i < work->count && worked; ++i) {
        const double at[3] = {(double)points[i].position[0], (double)points[i].position[1],
                              (double)points[i].position[2]};
        samples_add(&work->errors->of[QUANTITY_SURFACE], i, nearest_leaf(&work->info, &work->arrays, at));
    }
    free(points);
    return worked;
}

/* ---- a rung ---- */

static void add_volume(shape_work *work, svo_tree *lists)
{
    const double voxel = work->errors->voxel;
    const bool is_first = work->errors->of[QUANTITY_ENCLOSED].blocks[0].count == 0;
    if (work->made->volume > 0 && work->info.coverage != SVO_COVERAGE_THIN && is_first) {
        const double share = enclosed_voxels(work->made, lists) * voxel * voxel * voxel / work->made->volume;
        for (size_t i = 0; i < SAMPLE_BLOCKS && share > 0; ++i) {
            samples_add(&work->errors->of[QUANTITY_ENCLOSED], i, share);
        }
    }
}

static bool add_shape(sampler *made, svo_tree *tree, unsigned rung, uint32_t seed, tune_errors *errors)
{
    shape_work work = {.made = made,
                       .tree = tree,
                       .info = info_of_tree(tree),
                       .arrays = SVO_TREE_ARRAYS_INIT,
                       .errors = errors,
                       .random = {.state = seed},
                       .count = sampler_points(rung)};
    svo_tree_get_arrays(tree, &work.arrays);
    svo_tree_get_grid(tree, &work.grid);
    if (work.info.leaf_count == 0) {
        return true;
    }
    errors->voxel = ldexp(work.info.edge, -(int)work.info.depth);
    errors->voxels = work.info.leaf_count;
    errors->faces = 3 * errors->voxel * errors->voxel * (double)errors->voxels / made->area;
    add_volume(&work, tree);
    return add_distances(&work) && add_surface(&work, seed);
}

static svo_plan_options errors_options(const sampler *made, const tune_setting *setting)
{
    svo_plan_options asked = grid_options(made);
    const uint32_t payload = SVO_NEED_NORMAL | (made->has_colors ? (uint32_t)SVO_NEED_COLOR : 0);
    asked.need = SVO_NEED_RAYS | (made->measured & payload); /* payload needs the lists, too */
    asked.coverage = (svo_coverage)setting->values[DIMENSION_COVERAGE];
    asked.weights = (svo_weights)setting->values[DIMENSION_WEIGHTS];
    asked.drop_alpha = made->state->options.drop_alpha;
    return asked;
}

int sampler_add(sampler *made, const tune_setting *setting, unsigned rung, uint32_t seed,
                const sampler_targets *targets)
{
    const unsigned depth = (unsigned)setting->values[DIMENSION_DEPTH];
    const uint32_t own_seed = seed * 1000003u + rung * 7919u + 1u;
    svo_plan_options asked = errors_options(made, setting);
    svo_tree *tree = NULL;
    svo_tree *lists = NULL;
    int exit_code = build(made, depth, &asked, &tree) == SVO_OK ? PROGRAM_DONE : fail_device(made);
    if (exit_code == PROGRAM_DONE && targets->of[KIND_SHAPE] != NULL &&
        !add_shape(made, tree, rung, own_seed, targets->of[KIND_SHAPE])) {
        exit_code = fail_device(made);
    }
    if (exit_code == PROGRAM_DONE && targets->of[KIND_RAYS] != NULL &&
        !ray_errors_add(&made->rays, setting, tree, made->measured, sampler_points(rung), own_seed,
                        targets->of[KIND_RAYS])) {
        exit_code = fail_device(made);
    }
    if (exit_code == PROGRAM_DONE && targets->of[KIND_PAYLOAD] != NULL) {
        if (asked.coverage == SVO_COVERAGE_THIN) { /* its own lists lack surface that its voxels hold */
            asked.coverage = SVO_COVERAGE_HALF_OPEN;
            exit_code = build(made, depth, &asked, &lists) == SVO_OK ? PROGRAM_DONE : fail_device(made);
        }
        if (exit_code == PROGRAM_DONE) {
            payload_errors_add(made->source->mesh, tree, lists != NULL ? lists : tree, sampler_points(rung), own_seed,
                               targets->of[KIND_PAYLOAD]);
        }
    }
    svo_tree_destroy(&lists);
    svo_tree_destroy(&tree);
    return exit_code;
}
