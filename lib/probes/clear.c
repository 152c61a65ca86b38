/* SPDX-License-Identifier: MIT */
/* What probes see of trees that show in part: launches of kernels/probes/clear.cl, and of a scene's kernel. */
#include "probes/clear.h"

#include <math.h>

#include "probes/plan.h"
#include "probes/programs.h"
#include "rays/rays.h"
#include "scene/handle.h"
#include "shared/light_layout.h"
#include "svocl/plan.h"

/* Layers that a ray goes through at most. */
#define LAYERS_MAX 64u

svo_status svo_i_probes_find_clear(svo_probes *probes, svo_i_device_work *work)
{
    const svo_tree *tree = probes->tree;
    uint8_t root[4] = {255, 255, 255, 255};
    if (tree == NULL) {
        probes->is_clear = probes->scene->is_clear;
        return SVO_OK;
    }
    if (tree->buffers[SVO_TREE_COLORS] != NULL && tree->info.leaf_count > 0 &&
        (tree->info.payload_level == 0 || svo_i_tree_is_constant(&tree->info, SVO_TREE_COLORS))) {
        SVO_I_TRY(svo_i_work_read(work, tree->buffers[SVO_TREE_COLORS], 0, root, sizeof root));
    }
    probes->is_clear = root[3] != 255;
    return SVO_OK;
}

static const char *defines_of(const svo_probes *probes)
{
    return svo_i_rays_of_triangles(&probes->tree->info) ? "" : " -DSVO_CLEAR_NODES";
}

/* What the kernels need to know of colors, and of the rays that go on: whole directions are as long as the map is wide,
   along the axes. */
static svo_onward_params make_onward(const svo_probes *probes, uint32_t ray_count)
{
    const svo_tree_info *info = &probes->tree->info;
    const double grid = ldexp(1 / info->scale, (int)info->snap_bits);
    return (svo_onward_params){.count = ray_count,
                               .flags = svo_i_tree_is_constant(info, SVO_TREE_COLORS) ? SVO_ONWARD_ONE_COLOR : 0,
                               .leaf_begin = (cl_uint)info->inner_count,
                               .offset = (cl_float)(ldexp(grid, -18) / probes->info.resolution)};
}

/* Lets rays begin behind what they met and do not see. *through: how many did so, in all launches. */
static svo_status go_through(const svo_i_probe_bands *bands, cl_mem counter, uint32_t ray_count, uint32_t *through)
{
    const svo_tree *tree = bands->probes->tree;
    svo_i_device_work *work = bands->work;
    const svo_onward_params onward = make_onward(bands->probes, ray_count);
    const svo_photon_params lists = {.depth = tree->info.depth,
                                     .snap_bits = tree->info.snap_bits,
                                     .leaf_begin = (cl_uint)tree->info.inner_count,
                                     .leaf_count = (cl_uint)tree->info.leaf_count,
                                     .triangle_count = (cl_uint)tree->info.list_triangle_count};
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(tree->buffers[SVO_TREE_CHILD_MASK]),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_FIRST_CHILD]),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_LIST_BEGIN]),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_LIST]),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_VERTICES]),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_INDICES]),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_TRIANGLE_IDS]),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_COLORS]),
                                        SVO_I_ARGUMENT(bands->hits),
                                        SVO_I_ARGUMENT(bands->rays),
                                        SVO_I_ARGUMENT(counter),
                                        SVO_I_ARGUMENT(lists),
                                        SVO_I_ARGUMENT(onward)};
    SVO_I_TRY(svo_i_work_use(work, &svo_i_program_probe_clear, defines_of(bands->probes)));
    SVO_I_TRY(svo_i_work_launch(work, "svo_k_probe_through", SVO_I_ARGUMENTS(arguments), ray_count));
    return svo_i_work_read(work, counter, 0, through, sizeof *through);
}

/* All rays of the band are traced for each layer; those that have found theirs reach nothing else any more. */
static svo_status trace_triangles(const svo_i_probe_bands *bands, uint32_t ray_count)
{
    svo_i_device_work *work = bands->work;
    cl_mem counter = NULL;
    uint32_t through = 0;
    SVO_I_TRY(svo_i_work_alloc(work, "probe_through", sizeof(cl_uint), &counter));
    SVO_I_TRY(svo_i_work_fill_zero(work, counter, sizeof(cl_uint)));
    for (uint32_t layer = 0; layer <= LAYERS_MAX; ++layer) {
        const uint32_t before = through;
        SVO_I_TRY(svo_i_sight_trace(bands->probes, work, bands->rays, bands->hits, ray_count));
        SVO_I_TRY(layer < LAYERS_MAX ? go_through(bands, counter, ray_count, &through) : SVO_OK);
        if (through == before) {
            break;
        }
    }
    svo_i_work_free(work, &counter);
    return SVO_OK;
}

static svo_status trace_voxels(const svo_i_probe_bands *bands, uint32_t ray_count)
{
    const svo_tree *tree = bands->probes->tree;
    svo_i_device_work *work = bands->work;
    const cl_mem none = NULL;
    svo_ray_params grid = {.depth = 0};
    SVO_I_TRY(svo_i_rays_tree_params(tree, work->function, &grid));
    const svo_onward_params onward = make_onward(bands->probes, ray_count);
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(tree->buffers[SVO_TREE_CHILD_MASK]),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_FIRST_CHILD]),
                                        SVO_I_ARGUMENT(none),
                                        SVO_I_ARGUMENT(none),
                                        SVO_I_ARGUMENT(grid),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_COLORS]),
                                        SVO_I_ARGUMENT(bands->rays),
                                        SVO_I_ARGUMENT(bands->hits),
                                        SVO_I_ARGUMENT(onward)};
    SVO_I_TRY(svo_i_work_use(work, &svo_i_program_probe_clear, defines_of(bands->probes)));
    return svo_i_work_launch(work, "svo_k_probe_see", SVO_I_ARGUMENTS(arguments), ray_count);
}

svo_status svo_i_clear_trace(const svo_i_probe_bands *bands, uint32_t ray_count)
{
    const svo_probes *probes = bands->probes;
    if (probes->scene != NULL) {
        return svo_i_scene_see(probes->scene, bands->work, bands->rays, bands->hits, ray_count);
    }
    return svo_i_rays_of_triangles(&probes->tree->info) ? trace_triangles(bands, ray_count)
                                                        : trace_voxels(bands, ray_count);
}

svo_status svo_i_clear_reach(const svo_i_probe_bands *bands, const svo_probe_step *step)
{
    const svo_probes *probes = bands->probes;
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(probes->buffers[SVO_PROBES_TEXELS]), SVO_I_ARGUMENT(bands->rays),
                                        SVO_I_ARGUMENT(probes->params), SVO_I_ARGUMENT(*step)};
    SVO_I_TRY(svo_i_work_use(bands->work, &svo_i_program_probe_clear, defines_of(probes)));
    SVO_I_TRY(svo_i_work_launch(bands->work, "svo_k_probe_reach", SVO_I_ARGUMENTS(arguments), step->count));
    return svo_i_work_use(bands->work, &svo_i_program_probes, "");
}
