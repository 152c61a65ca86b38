/* SPDX-License-Identifier: MIT */
/*
 * Scenes of placed trees: a tree alone is traced as without a scene, many are traced as every instance in turn, bit for
 * bit, and as boxes in double say; moved instances as those of a new scene.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "scene/handle.h"
#include "scene_check.h"
#include "support/suite.h"

/* ---- a tree without a scene ---- */

static void trace_tree(svo_tree *tree, const svo_ray *rays, float footprint, svo_voxel_hit *hits, size_t count)
{
    if (svo_trace_voxels(svo_tree_target(tree), svo_in_host(rays), svo_in_host(hits), count, footprint, 0,
                         &(svo_submit){.queue = opened.queue}) != SVO_OK) {
        fail_msg("%s", svo_device_message(opened.device));
    }
}

/* A scene's hit is the tree's own, with its instance; nothing counts steps where nothing is hit. */
static void assert_same_hit(size_t ray, const svo_scene_hit *hit, const svo_voxel_hit *own)
{
    const bool met = own->node != SVO_NO_NODE;
    svo_voxel_hit expected = *own;
    expected.steps = met ? own->steps : 0;
    /* Bit for bit: 0 and -0 differ. */
    if (memcmp((const unsigned char *)hit, (const unsigned char *)&expected, sizeof expected) != 0 ||
        hit->instance != (met ? 0 : SVO_NO_INSTANCE)) {
        fail_msg("ray %zu: t %a, node %u, level %u, face %u, instance %u; the tree has %a, %u, %u, %u", ray,
                 (double)hit->t, hit->node, hit->level, hit->face, hit->instance, (double)own->t, own->node, own->level,
                 own->face);
    }
}

/* ---- one instance ---- */

static void an_identity_is_the_tree_itself(void **state)
{
    (void)state;
    static svo_ray rays[RAYS];
    static svo_scene_hit hits[RAYS];
    static svo_voxel_hit own[RAYS];
    static svo_scene_triangle_hit triangles[RAYS];
    static svo_hit own_triangles[RAYS];
    uint64_t random = 1;
    for (uint32_t tree = 0; tree < MODELS; ++tree) {
        svo_instance alone = identity;
        alone.tree = tree;
        svo_scene *scene = make_placed_scene(&shapes, &alone, 1, SVO_NEED_RAYS);
        random_scene_rays(&random, &shapes, &alone, 1, rays, RAYS);
        for (int k = 0; k < 2; ++k) {
            const float footprint = k == 0 ? 0.0F : 0.03F;
            trace_scene(scene, rays, hits, RAYS, footprint, SVO_SCENE_CLOSEST);
            trace_tree(shapes.handles[tree], rays, footprint, own, RAYS);
            size_t met = 0;
            for (size_t i = 0; i < RAYS; ++i) {
                assert_same_hit(i, &hits[i], &own[i]);
                met += hits[i].instance == 0;
            }
            assert_in_range(met, RAYS / 8, RAYS);
        }
        assert_int_equal(svo_trace_triangles(svo_scene_target(scene), svo_in_host(rays), svo_in_host(triangles), RAYS,
                                             SVO_SCENE_CLOSEST, &(svo_submit){.queue = opened.queue}),
                         SVO_OK);
        assert_int_equal(svo_trace_triangles(svo_tree_target(shapes.handles[tree]), svo_in_host(rays),
                                             svo_in_host(own_triangles), RAYS, SVO_TRACE_CLOSEST,
                                             &(svo_submit){.queue = opened.queue}),
                         SVO_OK);
        for (size_t i = 0; i < RAYS; ++i) {
            const bool met = own_triangles[i].triangle != SVO_NO_TRIANGLE;
            assert_memory_equal(&triangles[i], &own_triangles[i], offsetof(svo_hit, normal));
            for (int axis = 0; axis < 3; ++axis) { /* 0 and -0 are the same here */
                assert_true(triangles[i].normal[axis] == own_triangles[i].normal[axis]);
            }
            assert_int_equal(triangles[i].instance, met ? 0 : SVO_NO_INSTANCE);
        }
        svo_scene_destroy(&scene);
    }
}

/* The footprint divides by the longest column: a node is as large in the world as that makes it. */
static void footprints_divide_by_the_longest_column(void **state)
{
    (void)state;
    static svo_ray rays[RAYS];
    static svo_ray inside[RAYS];
    static svo_scene_hit hits[RAYS];
    static svo_voxel_hit own[RAYS];
    const svo_instance stretched = {0, {0, 0, 4, 0, 1, 0, 0, 0, 0, 2, 0, 0}};
    const float footprint = 0.0625F;
    uint64_t random = 2;
    size_t larger = 0;
    svo_scene *scene = make_placed_scene(&shapes, &stretched, 1, SVO_NEED_NONE);
    random_scene_rays(&random, &shapes, &stretched, 1, rays, RAYS);
    trace_scene(scene, rays, hits, RAYS, footprint, SVO_SCENE_CLOSEST);
    for (size_t i = 0; i < RAYS; ++i) {
        inside[i] = ray_in_tree(&stretched, &rays[i]);
        double world = 0;
        double object = 0;
        for (int axis = 0; axis < 3; ++axis) {
            world += (double)rays[i].direction[axis] * (double)rays[i].direction[axis];
            object += (double)inside[i].direction[axis] * (double)inside[i].direction[axis];
        }
        trace_tree(shapes.handles[0], &inside[i], (float)((double)footprint * sqrt(world) / (4 * sqrt(object))),
                   &own[i], 1);
        larger += own[i].node != SVO_NO_NODE && own[i].level < shapes.trees[0].info.depth;
        if (i > 200) { /* one call per ray: enough */
            break;
        }
        /* A node of just the size of the pixel may go either way. */
        if (hits[i].node != own[i].node && hits[i].level == own[i].level) {
            fail_msg("ray %zu: node %u of level %u, not %u of level %u", i, hits[i].node, hits[i].level, own[i].node,
                     own[i].level);
        }
    }
    assert_true(larger > 10);
    svo_scene_destroy(&scene);
}

/* Normals are those of the faces in the world, whatever the matrix: perpendicular to the images of the axes that the
   face has, against the ray, unit. */
static void normals_are_right_when_mirrored_and_scaled(void **state)
{
    (void)state;
    static svo_ray rays[RAYS];
    static svo_scene_hit hits[RAYS];
    static svo_scene_triangle_hit triangles[RAYS];
    svo_instance placed[16];
    uint64_t random = 3;
    size_t met = 0;
    random_instances(&random, PLACE_SHEARED, 1000, placed, 16);
    svo_scene *scene = make_placed_scene(&shapes, placed, 16, SVO_NEED_RAYS);
    random_scene_rays(&random, &shapes, placed, 16, rays, RAYS);
    trace_scene(scene, rays, hits, RAYS, 0, SVO_SCENE_CLOSEST);
    assert_int_equal(svo_trace_triangles(svo_scene_target(scene), svo_in_host(rays), svo_in_host(triangles), RAYS,
                                         SVO_SCENE_CLOSEST, &(svo_submit){.queue = opened.queue}),
                     SVO_OK);
    for (size_t i = 0; i < RAYS; ++i) {
        if (hits[i].instance == SVO_NO_INSTANCE || hits[i].face == SVO_FACE_NONE) {
            continue;
        }
        const float *matrix = placed[hits[i].instance].transform;
        const uint32_t axis = hits[i].face >> 1;
        double length = 0;
        double along = 0;
        for (int row = 0; row < 3; ++row) {
            length += (double)hits[i].normal[row] * (double)hits[i].normal[row];
            along += (double)hits[i].normal[row] * (double)rays[i].direction[row];
        }
        assert_true(fabs(length - 1) < 1e-6);
        assert_true(along <= 0);
        for (uint32_t k = 0; k < 3; ++k) {
            double product = 0;
            double size = 0;
            for (int row = 0; row < 3; ++row) {
                product += (double)hits[i].normal[row] * (double)matrix[4 * row + (int)k];
                size += (double)matrix[4 * row + (int)k] * (double)matrix[4 * row + (int)k];
            }
            if (k == axis) { /* it leads out of the face */
                assert_true((product > 0) == ((hits[i].face & 1) == 1));
            } else if (fabs(product) > 1e-6 * sqrt(size)) {
                fail_msg("ray %zu, instance %u: face %u, its normal is not perpendicular to axis %u", i,
                         hits[i].instance, hits[i].face, k);
            }
        }
        ++met;
    }
    assert_true(met > RAYS / 8);
    svo_scene_destroy(&scene);
}

/* ---- many instances ---- */

static void compare_with_every_instance(svo_scene *scene, uint32_t count, const svo_ray *rays)
{
    static svo_scene_hit hits[RAYS];
    static svo_scene_hit every[RAYS];
    static svo_scene_triangle_hit triangles[RAYS];
    static svo_scene_triangle_hit every_triangle[RAYS];
    for (int k = 0; k < 2; ++k) {
        const float footprint = k == 0 ? 0.0F : 0.02F;
        trace_scene(scene, rays, hits, RAYS, footprint, SVO_SCENE_CLOSEST);
        trace_scene(scene, rays, every, RAYS, footprint, SVO_SCENE_EVERY_INSTANCE);
        assert_same_hits("voxels", count, hits, every, sizeof hits[0]);
    }
    trace_scene(scene, rays, every, RAYS, 0, SVO_SCENE_CLOSEST);
    trace_scene(scene, rays, hits, RAYS, 0, SVO_SCENE_ANY);
    for (size_t i = 0; i < RAYS; ++i) {
        assert_int_equal(hits[i].instance == SVO_NO_INSTANCE, every[i].instance == SVO_NO_INSTANCE);
    }
    memset(triangles, 0x5a, sizeof triangles);
    assert_int_equal(svo_trace_triangles(svo_scene_target(scene), svo_in_host(rays), svo_in_host(triangles), RAYS,
                                         SVO_SCENE_CLOSEST, &(svo_submit){.queue = opened.queue}),
                     SVO_OK);
    assert_int_equal(svo_trace_triangles(svo_scene_target(scene), svo_in_host(rays), svo_in_host(every_triangle), RAYS,
                                         SVO_SCENE_EVERY_INSTANCE, &(svo_submit){.queue = opened.queue}),
                     SVO_OK);
    assert_same_hits("triangles", count, triangles, every_triangle, sizeof triangles[0]);
}

static void hits_are_those_of_every_instance_in_turn(void **state)
{
    (void)state;
    static const uint32_t counts[] = {1, 2, 3, 65, 1000, 10000};
    static svo_instance placed[10000];
    static svo_ray rays[RAYS];
    uint64_t random = 4;
    for (size_t k = 0; k < sizeof counts / sizeof counts[0]; ++k) {
        for (int kind = PLACE_MOVED; kind <= PLACE_SHEARED; ++kind) {
            const double width = kind == PLACE_MOVED ? cbrt(counts[k]) * 2 : 400;
            random_instances(&random, (placement)kind, width, placed, counts[k]);
            /* Some in the same place: the smallest index counts. */
            for (uint32_t i = 8; i < counts[k]; i += 8) {
                placed[i] = placed[i - 7];
            }
            svo_scene *scene = make_placed_scene(&shapes, placed, counts[k], SVO_NEED_RAYS);
            random_scene_rays(&random, &shapes, placed, counts[k], rays, RAYS);
            compare_with_every_instance(scene, counts[k], rays);
            svo_scene_destroy(&scene);
        }
    }
}

/* Whether two values of t name the same point of an instance: a hundred thousandth of its size, and of the way to it,
   is the float's rounding in its tree. */
static bool is_same_point(const svo_instance *instance, const svo_ray *ray, double a, double b)
{
    double size = 0;
    double length = 0;
    for (int row = 0; row < 3; ++row) {
        const float *matrix = instance->transform + (ptrdiff_t)4 * row;
        for (int k = 0; k < 3; ++k) {
            size = fmax(size, fabs((double)matrix[k]));
        }
        length += (double)ray->direction[row] * (double)ray->direction[row];
    }
    for (int row = 0; row < 3; ++row) {
        size = fmax(size, fabs((double)ray->origin[row] - (double)instance->transform[4 * row + 3]));
    }
    return fabs(a - b) * sqrt(length) <= 1e-5 * size;
}

static void hits_agree_with_boxes_in_double(void **state)
{
    (void)state;
    static svo_ray rays[RAYS];
    static svo_scene_hit hits[RAYS];
    svo_instance placed[40];
    uint64_t random = 5;
    size_t wrong = 0;
    size_t traced = 0;
    for (int kind = PLACE_MOVED; kind <= PLACE_SHEARED; ++kind) {
        for (int round = 0; round < 8; ++round) {
            random_instances(&random, (placement)kind, kind == PLACE_MOVED ? 6 : 400, placed, 40);
            svo_scene *scene = make_placed_scene(&shapes, placed, 40, SVO_NEED_NONE);
            random_scene_rays(&random, &shapes, placed, 40, rays, RAYS);
            trace_scene(scene, rays, hits, RAYS, 0, SVO_SCENE_CLOSEST);
            for (size_t i = 0; i < RAYS; ++i) {
                const reference_hit expected = reference_closest(&shapes, placed, 40, &rays[i]);
                const bool both = isfinite(expected.t) && isfinite(hits[i].t);
                const bool neither = !isfinite(expected.t) && !isfinite(hits[i].t);
                wrong += !neither &&
                         !(both && is_same_point(&placed[expected.instance], &rays[i], expected.t, (double)hits[i].t));
                ++traced;
            }
            svo_scene_destroy(&scene);
        }
    }
    if (wrong * 10000 > traced) {
        fail_msg("%zu of %zu rays disagree", wrong, traced);
    }
}

/* Cubes in a lattice whose occupied parts touch, with numbers that floats hold, and rays within their faces along each
   axis, in both directions. */
static void rays_in_faces_neither_miss_nor_fail(void **state)
{
    (void)state;
    enum { EDGE = 4 };
    static const double width = 1.25; /* of the occupied part: cells 2 to 6 of 8, each 0.25 wide */
    static svo_ray rays[RAYS];
    static svo_scene_hit hits[RAYS];
    static svo_scene_hit every[RAYS];
    svo_instance placed[EDGE * EDGE * EDGE];
    for (int i = 0; i < EDGE * EDGE * EDGE; ++i) {
        const int cell[3] = {i % EDGE, i / EDGE % EDGE, i / EDGE / EDGE};
        placed[i] = identity;
        placed[i].tree = 1;
        for (int axis = 0; axis < 3; ++axis) {
            placed[i].transform[4 * axis + 3] = (float)(width * cell[axis]);
        }
    }
    svo_scene *scene = make_placed_scene(&shapes, placed, EDGE * EDGE * EDGE, SVO_NEED_NONE);
    size_t count = 0;
    for (int axis = 0; axis < 3; ++axis) {
        for (int k = 0; k < 2 * (EDGE + 1) * (EDGE + 1); ++k) {
            const int plane[2] = {k / 2 % (EDGE + 1), k / 2 / (EDGE + 1)};
            svo_ray *ray = &rays[count++];
            *ray = (svo_ray){.t_max = INFINITY};
            ray->direction[axis] = k % 2 == 0 ? 1.0F : -1.0F;
            ray->origin[axis] = (float)(k % 2 == 0 ? -3.0 : EDGE * width + 3.0);
            for (int side = 0; side < 2; ++side) {
                ray->origin[(axis + 1 + side) % 3] = (float)(width * plane[side]);
            }
        }
    }
    trace_scene(scene, rays, hits, count, 0, SVO_SCENE_CLOSEST);
    trace_scene(scene, rays, every, count, 0, SVO_SCENE_EVERY_INSTANCE);
    for (size_t i = 0; i < count; ++i) {
        /* A face belongs to the voxels above it: the last planes are no instance's. */
        const int k = (int)(i % (size_t)(2 * (EDGE + 1) * (EDGE + 1)));
        const bool met = k / 2 % (EDGE + 1) < EDGE && k / 2 / (EDGE + 1) < EDGE;
        assert_memory_equal(&hits[i], &every[i], sizeof hits[i]);
        if (met ? hits[i].t != 3.0F : !isinf(hits[i].t)) {
            fail_msg("ray %zu along a face: t %g", i, (double)hits[i].t);
        }
    }
    svo_scene_destroy(&scene);
}

static void unsound_rays_hit_nothing(void **state)
{
    (void)state;
    svo_instance placed[5];
    svo_ray rays[6];
    svo_scene_hit hits[6];
    uint64_t random = 6;
    random_instances(&random, PLACE_MOVED, 2, placed, 5);
    svo_scene *scene = make_placed_scene(&shapes, placed, 5, SVO_NEED_NONE);
    random_scene_rays(&random, &shapes, placed, 5, rays, 6);
    rays[0].origin[1] = NAN;
    rays[1].direction[0] = INFINITY;
    rays[2].direction[0] = rays[2].direction[1] = rays[2].direction[2] = 0;
    rays[3].t_min = 2;
    rays[3].t_max = 1;
    rays[4].t_min = NAN;
    rays[5].origin[0] = -INFINITY;
    trace_scene(scene, rays, hits, 6, 0.1F, SVO_SCENE_CLOSEST);
    for (int i = 0; i < 6; ++i) {
        assert_int_equal(hits[i].instance, SVO_NO_INSTANCE);
        assert_int_equal(hits[i].node, SVO_NO_NODE);
        assert_true(isinf(hits[i].t));
    }
    svo_scene_destroy(&scene);
}

/* ---- compact trees ---- */

static void make_compacts(svo_form form, svo_compact *out[MODELS])
{
    const svo_compact_options options = {.struct_size = sizeof options, .form = form};
    for (int i = 0; i < MODELS; ++i) {
        if (svo_compact_create(opened.device, shapes.handles[i], &options, opened.queue, &out[i]) != SVO_OK) {
            fail_msg("%s", svo_device_message(opened.device));
        }
    }
}

static svo_scene *place_compacts(svo_compact *const *compacts, const svo_instance *instances, uint32_t count)
{
    const svo_scene_options options = {.struct_size = sizeof options,
                                       .compacts = compacts,
                                       .tree_count = MODELS,
                                       .instances = instances,
                                       .instance_count = count};
    svo_scene *made = NULL;
    if (svo_scene_create(opened.device, &options, opened.queue, &made) != SVO_OK) {
        fail_msg("%s", svo_device_message(opened.device));
    }
    return made;
}

/* Every form gives the hits of the built trees: all but the place of the payload is the same. */
static void compact_trees_are_placed_as_built_ones(void **state)
{
    (void)state;
    static svo_ray rays[RAYS];
    static svo_scene_hit hits[RAYS];
    static svo_scene_hit expected[RAYS];
    static svo_voxel_hit own[RAYS];
    svo_instance placed[90];
    uint64_t random = 11;
    random_instances(&random, PLACE_SHEARED, 400, placed, 90);
    svo_scene *built_trees = make_placed_scene(&shapes, placed, 90, SVO_NEED_NONE);
    for (int form = SVO_FORM_DESCRIPTOR; form < SVO_FORM_COUNT; ++form) {
        svo_compact *compacts[MODELS];
        make_compacts((svo_form)form, compacts);
        svo_scene *scene = place_compacts(compacts, placed, 90);
        random_scene_rays(&random, &shapes, placed, 90, rays, RAYS);
        for (int k = 0; k < 3; ++k) {
            const float footprint = k == 1 ? 0.02F : 0.0F;
            trace_scene(scene, rays, hits, RAYS, footprint, k == 2 ? SVO_SCENE_EVERY_INSTANCE : SVO_SCENE_CLOSEST);
            trace_scene(built_trees, rays, expected, RAYS, footprint, SVO_SCENE_CLOSEST);
            for (size_t i = 0; i < RAYS; ++i) {
                hits[i].node = expected[i].node;
            }
            assert_same_hits(svo_name(SVO_NAME_FORM, (svo_form)form), 90, hits, expected, sizeof hits[0]);
        }
        svo_scene_destroy(&scene);
        scene = place_compacts(compacts, &identity, 1);
        random_scene_rays(&random, &shapes, &identity, 1, rays, RAYS);
        trace_scene(scene, rays, hits, RAYS, 0.01F, SVO_SCENE_CLOSEST);
        assert_int_equal(svo_trace_voxels(svo_compact_target(compacts[0]), svo_in_host(rays), svo_in_host(own), RAYS,
                                          0.01F, 0, &(svo_submit){.queue = opened.queue}),
                         SVO_OK);
        for (size_t i = 0; i < RAYS; ++i) {
            assert_same_hit(i, &hits[i], &own[i]);
        }
        svo_scene_destroy(&scene);
        for (int i = 0; i < MODELS; ++i) {
            svo_compact_destroy(&compacts[i]);
        }
    }
    svo_scene_destroy(&built_trees);
}

static void mixed_forms_are_refused(void **state)
{
    (void)state;
    svo_compact *some[MODELS];
    svo_compact *others[MODELS];
    svo_scene *scene = NULL;
    make_compacts(SVO_FORM_DESCRIPTOR, some);
    make_compacts(SVO_FORM_IMPLIED, others);
    svo_compact *const mixed[MODELS] = {some[0], some[1], others[2]};
    svo_compact *const with_null[MODELS] = {some[0], NULL, some[2]};
    svo_scene_options options = {.struct_size = sizeof options,
                                 .compacts = mixed,
                                 .instances = &identity,
                                 .tree_count = MODELS,
                                 .instance_count = 1};
    expect_words(svo_scene_create(opened.device, &options, NULL, &scene), SVO_INVALID_ARGUMENT,
                 "compacts[2] differs from the first in form");
    options.compacts = with_null;
    expect_words(svo_scene_create(opened.device, &options, NULL, &scene), SVO_INVALID_ARGUMENT, "compacts[1] is NULL");
    options.compacts = some;
    options.need = SVO_NEED_RAYS;
    expect_words(svo_scene_create(opened.device, &options, NULL, &scene), SVO_INVALID_ARGUMENT,
                 "compacts[0] has no triangles");
    options.trees = shapes.handles;
    expect_words(svo_scene_create(opened.device, &options, NULL, &scene), SVO_INVALID_ARGUMENT, "both given");
    assert_null(scene);
    for (int i = 0; i < MODELS; ++i) {
        svo_compact_destroy(&some[i]);
        svo_compact_destroy(&others[i]);
    }
}

/* ---- the hierarchy ---- */

static svo_scene_node *read_hierarchy(const svo_scene *scene)
{
    const size_t bytes = (scene->info.instance_count - 1) * sizeof(svo_scene_node);
    svo_scene_node *nodes = malloc(bytes);
    assert_non_null(nodes);
    assert_int_equal(clEnqueueReadBuffer(opened.queue, scene->buffers[SVO_I_SCENE_HIERARCHY], CL_TRUE, 0, bytes, nodes,
                                         0, NULL, NULL),
                     CL_SUCCESS);
    return nodes;
}

/* The box below a child; counts its instances. */
static void check_child(const svo_scene *scene, const svo_scene_node *nodes, uint32_t child, uint32_t depth,
                        uint32_t *times, float box[6])
{
    assert_true(depth <= SVO_SCENE_DEPTH_MAX);
    if ((child & SVO_SCENE_LEAF) != 0) {
        const uint32_t instance = child & ~SVO_SCENE_LEAF;
        assert_in_range(instance, 0, scene->info.instance_count - 1);
        ++times[instance];
        memcpy(box, scene->boxes[instance].low, sizeof scene->boxes[instance].low);
        memcpy(box + 3, scene->boxes[instance].high, sizeof scene->boxes[instance].high);
        return;
    }
    const svo_scene_node *node = &nodes[child];
    for (uint32_t side = 0; side < 2; ++side) {
        float below[6];
        check_child(scene, nodes, node->child[side], depth + 1, times, below);
        assert_memory_equal(below, node->box + (size_t)6 * side, sizeof below);
        if ((node->child[side] & SVO_SCENE_LEAF) == 0) {
            assert_int_equal(nodes[node->child[side]].parent, 2 * child + side);
        }
        for (int axis = 0; axis < 3; ++axis) {
            box[axis] = side == 0 || below[axis] < box[axis] ? below[axis] : box[axis];
            box[axis + 3] = side == 0 || below[axis + 3] > box[axis + 3] ? below[axis + 3] : box[axis + 3];
        }
    }
}

static void the_hierarchy_holds_each_instance_once(void **state)
{
    (void)state;
    static const uint32_t counts[] = {2, 3, 64, 129, 3000};
    static svo_instance placed[3000];
    uint64_t random = 7;
    for (size_t k = 0; k < 2 * sizeof counts / sizeof counts[0]; ++k) {
        const uint32_t count = counts[k / 2];
        random_instances(&random, PLACE_SCALED, 50, placed, count);
        for (uint32_t i = 1; i < count && k % 2 == 1; ++i) {
            placed[i] = placed[0]; /* equal codes: their order decides */
        }
        svo_scene *scene = make_placed_scene(&shapes, placed, count, SVO_NEED_NONE);
        svo_scene *again = make_placed_scene(&shapes, placed, count, SVO_NEED_NONE);
        svo_scene_node *nodes = read_hierarchy(scene);
        svo_scene_node *same = read_hierarchy(again);
        uint32_t *times = calloc(count, sizeof *times);
        float box[6];
        assert_non_null(times);
        assert_memory_equal(nodes, same, (count - 1) * sizeof *nodes);
        check_child(scene, nodes, scene->params.root, 1, times, box);
        for (uint32_t i = 0; i < count; ++i) {
            assert_int_equal(times[i], 1);
        }
        free(times);
        free(nodes);
        free(same);
        svo_scene_destroy(&scene);
        svo_scene_destroy(&again);
    }
}

/* Along each axis in turn an instance far away: the scene's box, the largest coordinate, and the Morton codes over the
   widest axis follow it, wherever it is. */
static void a_scene_knows_how_far_it_reaches(void **state)
{
    (void)state;
    for (int axis = 0; axis < 3; ++axis) {
        const double away = axis == 1 ? -1000 : 1000;
        svo_instance placed[2] = {identity, identity};
        svo_scene_info info = SVO_SCENE_INFO_INIT;
        placed[1].transform[4 * axis + 3] = (float)away;
        svo_scene *scene = make_placed_scene(&shapes, placed, 2, SVO_NEED_NONE);
        assert_int_equal(svo_scene_get_info(scene, &info), SVO_OK);
        double farthest = 0;
        for (int k = 0; k < 3; ++k) {
            farthest = fmax(farthest, fmax(fabs(info.low[k]), fabs(info.high[k])));
        }
        assert_true(farthest > 990);
        assert_true(fabs((double)scene->params.reach - farthest) <= farthest * 0x1p-23);
        const double cells = (double)(1u << SVO_SCENE_CODE_BITS) / 1000;
        assert_true(fabs((double)scene->params.code_scale - cells) <= cells * 0x1p-16);
        svo_scene_destroy(&scene);
    }
}

/* Without a leaf a tree is as large as its grid. */
static void an_empty_tree_has_the_box_of_its_grid(void **state)
{
    (void)state;
    const svo_mesh none = {.struct_size = sizeof none};
    const svo_plan_options options = {
        .struct_size = sizeof options, .need = SVO_NEED_NONE, .origin = {-3, 4, 5}, .edge = 16};
    const svo_instance placed = identity;
    svo_scene_info info = SVO_SCENE_INFO_INIT;
    svo_scene *scene = NULL;
    built made;
    fixture_build(&opened, &none, 4, &options, &made);
    assert_int_equal(made.info.leaf_count, 0);
    const svo_scene_options asked = {.struct_size = sizeof asked,
                                     .trees = &made.tree,
                                     .tree_count = 1,
                                     .instances = &placed,
                                     .instance_count = 1,
                                     .need = SVO_NEED_NONE};
    expect_words(svo_scene_create(opened.device, &asked, opened.queue, &scene), SVO_OK, "");
    assert_int_equal(svo_scene_get_info(scene, &info), SVO_OK);
    for (int axis = 0; axis < 3; ++axis) {
        assert_true(fabs(info.low[axis] - options.origin[axis]) < 1e-3);
        assert_true(fabs(info.high[axis] - options.origin[axis] - options.edge) < 1e-3);
    }
    svo_scene_destroy(&scene);
    built_destroy(&made);
}

/* ---- moving ---- */

static void move_all(svo_instance *placed, uint32_t count, float *transforms, uint32_t step)
{
    for (uint32_t i = 0; i < count; ++i) {
        const double angle = 0.01 * (1 + i % 7);
        float *matrix = placed[i].transform;
        for (int row = 0; row < 3; ++row) {
            const float u = matrix[4 * row];
            const float v = matrix[4 * row + 1];
            matrix[4 * row] = (float)(cos(angle) * (double)u - sin(angle) * (double)v);
            matrix[4 * row + 1] = (float)(sin(angle) * (double)u + cos(angle) * (double)v);
            matrix[4 * row + 3] += 0.01F * (float)((int)((i + step + (uint32_t)row) % 5) - 2);
        }
        memcpy(transforms + (size_t)12 * i, matrix, sizeof placed[i].transform);
    }
}

/* A thousand steps leave nothing behind: hits are those of a new scene, and so is a rebuilt hierarchy, byte by byte. */
static void a_thousand_moves_are_a_new_scene(void **state)
{
    (void)state;
    enum { COUNT = 150 };
    static svo_ray rays[RAYS];
    svo_instance placed[COUNT];
    float transforms[12 * COUNT];
    uint64_t random = 8;
    random_instances(&random, PLACE_MOVED, 10, placed, COUNT);
    svo_scene *scene = make_placed_scene(&shapes, placed, COUNT, SVO_NEED_NONE);
    for (uint32_t step = 0; step < 1000; ++step) {
        const uint32_t first = step % 10;
        move_all(placed, COUNT, transforms, step);
        /* In two parts: the order of the calls does not matter. */
        assert_int_equal(
            svo_scene_set_transforms(scene, first, COUNT - first, transforms + (size_t)12 * first, opened.queue),
            SVO_OK);
        assert_int_equal(svo_scene_set_transforms(scene, 0, first, transforms, opened.queue), SVO_OK);
        if (step % 250 == 249) {
            random_scene_rays(&random, &shapes, placed, COUNT, rays, RAYS);
            compare_with_new_scene(scene, placed, COUNT, rays);
        }
    }
    assert_int_equal(svo_scene_rebuild(scene, opened.queue), SVO_OK);
    svo_scene *fresh = make_placed_scene(&shapes, placed, COUNT, SVO_NEED_NONE);
    svo_scene_node *nodes = read_hierarchy(scene);
    svo_scene_node *expected = read_hierarchy(fresh);
    assert_memory_equal(nodes, expected, (COUNT - 1) * sizeof *nodes);
    free(nodes);
    free(expected);
    svo_scene_destroy(&fresh);
    svo_scene_destroy(&scene);
}

TEST_GROUP(scene)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_identity_is_the_tree_itself),
        cmocka_unit_test(footprints_divide_by_the_longest_column),
        cmocka_unit_test(normals_are_right_when_mirrored_and_scaled),
        cmocka_unit_test(hits_are_those_of_every_instance_in_turn),
        cmocka_unit_test(hits_agree_with_boxes_in_double),
        cmocka_unit_test(rays_in_faces_neither_miss_nor_fail),
        cmocka_unit_test(unsound_rays_hit_nothing),
        cmocka_unit_test(compact_trees_are_placed_as_built_ones),
        cmocka_unit_test(mixed_forms_are_refused),
        cmocka_unit_test(the_hierarchy_holds_each_instance_once),
        cmocka_unit_test(a_scene_knows_how_far_it_reaches),
        cmocka_unit_test(an_empty_tree_has_the_box_of_its_grid),
        cmocka_unit_test(a_thousand_moves_are_a_new_scene),
    };
    return cmocka_run_group_tests_name("scene", tests, scene_group_open, scene_group_close);
}
