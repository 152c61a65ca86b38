/* SPDX-License-Identifier: MIT */
/* Clusters of voxels, and what is made of them. */
#include "light_scene.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "support/attributed_mesh.h"
#include "support/meshes.h"

/* Clusters, so that bricks meet at faces, edges and corners alone; some voxels transparent. */
static void fill_random(uint64_t seed, uint8_t alphas[LIGHT_SCENE_CELLS])
{
    memset(alphas, 0, LIGHT_SCENE_CELLS);
    alphas[0] = 255;
    for (int cluster = 0; cluster < 40; ++cluster) {
        const size_t corner[3] = {random_below(&seed, 29), random_below(&seed, 29), random_below(&seed, 29)};
        for (int k = 0; k < 16; ++k) {
            const size_t x = corner[0] + random_below(&seed, 3);
            const size_t y = corner[1] + random_below(&seed, 3);
            const size_t z = corner[2] + random_below(&seed, 3);
            alphas[x + LIGHT_SCENE_WIDTH * (y + LIGHT_SCENE_WIDTH * z)] =
                (uint8_t)(k % 2 == 0 ? 255 : random_below(&seed, 256));
        }
    }
}

/* The light of out->tree, and the same on a dense grid. leaves: six opacities for each cell; released. */
static void make_light(const fixture *opened, svo_light_form form, uint16_t *leaves, light_scene *out)
{
    out->light = light_of(opened, out->tree, form);
    out->opacity = light_read(opened, out->light, SVO_LIGHT_OPACITY);
    light_levels_make(form, LIGHT_SCENE_DEPTH, leaves, &out->levels);
    free(leaves);
}

void light_scene_open(const fixture *opened, uint64_t seed, svo_light_form form, light_scene *out)
{
    uint16_t *leaves = malloc(LIGHT_SCENE_CELLS * 6 * sizeof *leaves);
    *out = (light_scene){.alphas = malloc(LIGHT_SCENE_CELLS), .info = SVO_TREE_INFO_INIT};
    assert_non_null(leaves);
    assert_non_null(out->alphas);
    fill_random(seed, out->alphas);
    for (size_t k = 0; k < 6 * LIGHT_SCENE_CELLS; ++k) {
        leaves[k] = (uint16_t)(257 * out->alphas[k / 6]);
    }
    out->tree = light_tree_of(opened, LIGHT_SCENE_DEPTH, out->alphas);
    light_succeed(opened, svo_tree_get_info(out->tree, &out->info));
    make_light(opened, form, leaves, out);
}

/* alpha min(1, area). */
static uint16_t opacity_of(uint8_t alpha, uint16_t area)
{
    return (uint16_t)floor(65535 * (alpha / 255.0) * fmin(1, area / 4096.0) + 0.5);
}

void light_scene_open_mesh(const fixture *opened, uint64_t seed, svo_light_form form, light_scene *out)
{
    const svo_plan_options options = {.need = SVO_NEED_COLOR | (unsigned)SVO_NEED_NORMAL |
                                              (unsigned)SVO_NEED_PROJECTED_AREA};
    svo_tree_arrays arrays = SVO_TREE_ARRAYS_INIT;
    attributed_mesh mesh;
    built made;
    uint16_t *leaves = calloc(LIGHT_SCENE_CELLS * 6, sizeof *leaves);
    assert_non_null(leaves);
    attributed_mesh_create(seed, 150, 0, &mesh);
    fixture_build(opened, &mesh.mesh, LIGHT_SCENE_DEPTH, &options, &made);
    attributed_mesh_destroy(&mesh);
    *out = (light_scene){.tree = made.tree, .info = made.info};
    light_succeed(opened, svo_tree_get_arrays(out->tree, &arrays));
    for (uint32_t leaf = 0; leaf < out->info.leaf_count; ++leaf) {
        const uint32_t index = (uint32_t)out->info.inner_count + leaf;
        svo_node node;
        light_succeed(opened, svo_tree_find_node(out->tree, index, &node));
        const size_t cell =
            node.cell[0] + LIGHT_SCENE_WIDTH * (node.cell[1] + LIGHT_SCENE_WIDTH * (size_t)node.cell[2]);
        for (size_t direction = 0; direction < 6; ++direction) {
            leaves[6 * cell + direction] =
                opacity_of(arrays.colors[4 * (size_t)index + 3], arrays.areas[6 * (size_t)leaf + direction]);
        }
    }
    make_light(opened, form, leaves, out);
}

void light_scene_close(light_scene *scene)
{
    light_levels_free(&scene->levels);
    free(scene->opacity);
    free(scene->alphas);
    svo_light_destroy(&scene->light);
    svo_tree_destroy(&scene->tree);
}

void light_scene_place(const svo_node *node, uint32_t sample, int at[3])
{
    at[0] = (int)(2 * node->cell[0] + sample % 3);
    at[1] = (int)(2 * node->cell[1] + sample / 3 % 3);
    at[2] = (int)(2 * node->cell[2] + sample / 9);
}
