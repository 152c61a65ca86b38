/* SPDX-License-Identifier: MIT */
/* Clusters of voxels, and what is made of them. */
#include "light_scene.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "meshes.h"

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

/* Six equal opacities for each voxel. */
static void make_levels(svo_light_form form, uint32_t depth, const uint8_t *alphas, light_levels *out)
{
    const size_t cells = (size_t)1 << 3 * depth;
    uint16_t *leaves = malloc(cells * 6 * sizeof *leaves);
    assert_non_null(leaves);
    for (size_t k = 0; k < 6 * cells; ++k) {
        leaves[k] = (uint16_t)(257 * alphas[k / 6]);
    }
    light_levels_make(form, depth, leaves, out);
    free(leaves);
}

void light_scene_open(const fixture *opened, uint64_t seed, svo_light_form form, light_scene *out)
{
    *out = (light_scene){.alphas = malloc(LIGHT_SCENE_CELLS), .info = SVO_TREE_INFO_INIT};
    assert_non_null(out->alphas);
    fill_random(seed, out->alphas);
    out->tree = light_tree_of(opened, LIGHT_SCENE_DEPTH, out->alphas);
    light_succeed(opened, svo_tree_get_info(out->tree, &out->info));
    out->light = light_of(opened, out->tree, form);
    out->opacity = light_read(opened, out->light, SVO_LIGHT_OPACITY);
    make_levels(form, LIGHT_SCENE_DEPTH, out->alphas, &out->levels);
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
