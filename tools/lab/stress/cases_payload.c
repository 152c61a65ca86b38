/* SPDX-License-Identifier: MIT */
/* T14 averages, T15 repeatability, T16 sums that reach every level without intermediate rounding. */
#include <stdlib.h>
#include <string.h>

#include "stress/cases.h"
#include "stress/stress.h"

/* Sums of the colors below each node: red, green and blue times alpha, alpha, then the number of samples. */
typedef uint64_t color_sum[5];

static void add_leaves(const stress_tree *built, const triangle_set *made, color_sum *sums)
{
    const svo_tree_arrays *arrays = &built->arrays;
    for (uint64_t leaf = 0; leaf < built->info.leaf_count; ++leaf) {
        uint64_t *sum = sums[built->info.inner_count + leaf];
        for (uint32_t i = arrays->list_begin[leaf]; i < arrays->list_begin[leaf + 1]; ++i) {
            const uint8_t *color = made->colors + (size_t)arrays->triangle_ids[arrays->list[i]] * 12;
            for (int channel = 0; channel < 4; ++channel) {
                sum[channel] += (uint64_t)color[channel] * (channel < 3 ? color[3] : 1U);
            }
            ++sum[4];
        }
    }
}

static void add_inner(const stress_tree *built, color_sum *sums)
{
    const svo_tree_arrays *arrays = &built->arrays;
    for (uint64_t node = built->info.inner_count; node-- > 0;) {
        uint32_t child = arrays->first_child[node];
        for (unsigned mask = arrays->child_mask[node]; mask != 0; mask &= mask - 1) {
            for (int i = 0; i < 5; ++i) {
                sums[node][i] += sums[child][i];
            }
            ++child;
        }
    }
}

/* Checks that every node has the mean of its samples, rounded half up. All pairs of the mesh must have the same
   weight. */
static void check_colors(const stress_tree *built, const triangle_set *made, stress_case *one)
{
    color_sum *sums = calloc((size_t)built->info.node_count, sizeof *sums);
    if (sums == NULL) {
        stress_fail(one, "out of memory");
        return;
    }
    add_leaves(built, made, sums);
    add_inner(built, sums);
    for (uint64_t node = 0; node < built->info.node_count; ++node) {
        for (int channel = 0; channel < 4; ++channel) {
            const uint64_t weight = channel < 3 && sums[node][3] > 0 ? sums[node][3] : sums[node][4];
            const uint64_t by = weight > 0 ? weight : 1;
            const uint64_t rounded = (2 * sums[node][channel] + by) / (2 * by);
            const bool is_between = channel == 3 && sums[node][3] > 0 && sums[node][3] < 255 * by;
            const uint64_t exact = is_between && rounded == 0 ? 1 : is_between && rounded == 255 ? 254 : rounded;
            if (built->arrays.colors[node * 4 + (unsigned)channel] != exact) {
                stress_fail(one, "node %llu, channel %d: %u instead of %llu", (unsigned long long)node, channel,
                            built->arrays.colors[node * 4 + (unsigned)channel], (unsigned long long)exact);
            }
        }
    }
    one->figure += (double)built->info.fragments;
    free(sums);
}

/* Triangles of one shape inside voxels of depth 6, so that all have the same weight, each of one random color. */
static bool make_samples(uint64_t seed, size_t count, bool in_one_voxel, triangle_set *out)
{
    static const double shape[9] = {1000, 2000, 3000, 9000, 2500, 4000, 5000, 12000, 6000};
    random_stream random = {seed};
    if (!triangle_set_empty(count, out)) {
        return false;
    }
    for (size_t t = 0; t < count; ++t) {
        double corner[3] = {32, 32, 32};
        for (int k = 0; k < 3 && !in_one_voxel; ++k) {
            corner[k] = random_index(&random, 64);
        }
        for (size_t i = 0; i < 9; ++i) {
            out->positions[t * 9 + i] = shape[i] + corner[i % 3] * 16384;
        }
        const uint32_t color = (uint32_t)(random_bits(&random) >> 32);
        for (size_t i = 0; i < 12; ++i) {
            out->colors[t * 12 + i] = (uint8_t)(color >> 8 * (i % 4));
        }
    }
    out->mesh.colors = out->colors;
    return true;
}

static const svo_plan_options colored = {.edge = TRIANGLE_SET_UNITS, .need = SVO_NEED_RAYS | SVO_NEED_COLOR};

static void samples(stress *run, size_t count, bool in_one_voxel, stress_case *one)
{
    triangle_set made;
    if (!make_samples(run->seed + count, count, in_one_voxel, &made)) {
        run->failed = true;
        return;
    }
    for (unsigned order = 0; order < (run->count > 0 ? 2u : 1u); ++order) {
        stress_tree built;
        if (stress_build(run, NULL, &made.mesh, 6, &colored, one, &built)) {
            check_colors(&built, &made, one);
            stress_tree_free(&built);
        }
        triangle_set_shuffle(&made, run->seed);
    }
    triangle_set_free(&made);
}

static void averages(stress *run)
{
    static const size_t counts[] = {1, 15, 16, 17, 63, 64, 255, 256, 257};
    stress_case one = stress_begin("T14 averages in one voxel");
    one.unit = "samples";
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; ++i) {
        samples(run, counts[i], true, &one);
    }
    samples(run, stress_amount(run, 2000, 20), true, &one);
    stress_end(run, &one);
    stress_case sums = stress_begin("T16 sums at every level");
    sums.unit = "samples";
    samples(run, stress_amount(run, 2000, 20), false, &sums);
    stress_end(run, &sums);
}

static void expect_hash(stress_case *one, const char *what, const char *expected, const char *found)
{
    one->figure += 1.0;
    if (strcmp(expected, found) != 0) {
        stress_fail(one, "%s: hash %s instead of %s", what, found, expected);
    }
}

/* The same tree by another front end. NULL: not available. */
static void compare_frontend(stress *run, const triangle_set *made, svo_frontend *other, const char *hash,
                             stress_case *one)
{
    stress_tree again;
    if (other != NULL && stress_build(run, other, &made->mesh, 6, &colored, one, &again)) {
        expect_hash(one, svo_frontend_name(other), hash, again.hash);
        stress_tree_free(&again);
    }
}

/* Builds again, with the other front ends, with the triangles in a different order, and without lists. */
static void compare_runs(stress *run, triangle_set *made, svo_frontend *copying, stress_case *one)
{
    const svo_plan_options no_lists = {.edge = TRIANGLE_SET_UNITS, .need = SVO_NEED_COLOR | SVO_NEED_NORMAL};
    stress_tree with_lists;
    stress_tree first;
    stress_tree again;
    if (!stress_build(run, NULL, &made->mesh, 6, &colored, one, &with_lists)) {
        return;
    }
    if (stress_build(run, NULL, &made->mesh, 6, &colored, one, &again)) {
        expect_hash(one, "second run", with_lists.hash, again.hash);
        stress_tree_free(&again);
    }
    compare_frontend(run, made, copying, with_lists.hash, one);
    compare_frontend(run, made, run->opened.cl, with_lists.hash, one);
    if (stress_build(run, NULL, &made->mesh, 6, &no_lists, one, &first)) {
        triangle_set_shuffle(made, run->seed);
        if (stress_build(run, NULL, &made->mesh, 6, &no_lists, one, &again)) {
            expect_hash(one, "shuffled triangles", first.hash, again.hash);
            expect_hash(one, "shuffled triangles, nodes", with_lists.nodes_hash, again.nodes_hash);
            stress_tree_free(&again);
        }
        stress_tree_free(&first);
    }
    stress_tree_free(&with_lists);
}

static void repeatability(stress *run)
{
    stress_case one = stress_begin("T15 repeatability");
    one.unit = "hashes";
    svo_message reason = {""};
    svo_frontend *copying = run->opened.gl != NULL ? opengl_further_frontend(run->opened.gl, OPTION_FRONTEND_AUTO,
                                                                             SVO_GL_SHARE_COPY, &reason)
                                                   : NULL;
    if (run->opened.gl != NULL && copying == NULL) {
        stress_fail(&one, "share copy: %s", reason.text);
    }
    const int step = run->count > 0 ? 1 : 3;
    for (int shape = 0; shape < TRIANGLE_SHAPE_COUNT; shape += step) {
        triangle_set made;
        if (!triangle_set_create((triangle_shape)shape, run->seed,
                                 shape == TRIANGLES_HUGE ? stress_amount(run, 1, 1) : stress_amount(run, 50, 5),
                                 &made)) {
            run->failed = true;
            break;
        }
        made.mesh.colors = made.colors;
        for (size_t i = 0; i < made.mesh.triangle_count * 12; ++i) {
            made.colors[i] = (uint8_t)(i * 37);
        }
        compare_runs(run, &made, copying, &one);
        triangle_set_free(&made);
    }
    stress_end(run, &one);
}

void stress_cases_payload(stress *run)
{
    averages(run);
    repeatability(run);
}
