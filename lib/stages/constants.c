/* SPDX-License-Identifier: MIT */
/* Stores constant payload as one element per buffer. */
#include "stages/constants.h"

#include "stages/surface.h"

/* The payload of a tree without leaves is zero. */
svo_status svo_i_constants_store(svo_i_build *build)
{
    static const unsigned char none[8] = {0};
    const svo_i_work *work = &build->commands.plan->work;
    const struct {
        svo_need bit;
        svo_tree_buffer array;
        const void *value;
    } constants[] = {{SVO_NEED_COLOR, SVO_TREE_COLORS, &work->constant_color},
                     {SVO_NEED_NORMAL, SVO_TREE_NORMALS, work->constant_normal},
                     {SVO_NEED_MATERIAL, SVO_TREE_MATERIALS, &work->constant_material}};
    svo_i_surface_free(build);
    svo_i_stage_begin(&build->commands);
    for (unsigned i = 0; i < sizeof constants / sizeof constants[0]; ++i) {
        const svo_tree_buffer array = constants[i].array;
        if ((work->constant & (uint32_t)constants[i].bit) != 0) {
            SVO_I_TRY(svo_i_commands_upload(&build->commands, svo_tree_buffer_name(array),
                                            build->tree->info.leaf_count > 0 ? constants[i].value : none,
                                            svo_i_tree_element_bytes(array), &build->tree->buffers[array]));
        }
    }
    return svo_i_stage_end(&build->commands, SVO_STAGE_TRANSFER);
}
