/* SPDX-License-Identifier: MIT */
#include "light/kept_tree.h"

svo_status svo_i_kept_tree_read(svo_i_device_work *work, const svo_tree *tree, svo_i_kept_tree *out)
{
    static const svo_tree_buffer buffers[3] = {SVO_TREE_COLORS, SVO_TREE_NORMALS, SVO_TREE_MATERIALS};
    const svo_tree_info *info = &tree->info;
    *out = (svo_i_kept_tree){.need = info->need, .constant = info->constant, .weights = info->weights};
    SVO_I_TRY(svo_tree_get_grid(tree, &out->grid));
    for (size_t i = 0; i < 3; ++i) {
        if (svo_i_tree_is_constant(info, buffers[i])) {
            SVO_I_TRY(svo_i_work_read(work, tree->buffers[buffers[i]], 0, &out->constants[i],
                                      svo_i_tree_element_bytes(buffers[i])));
        }
    }
    return SVO_OK;
}

uint64_t svo_i_kept_buffer_bytes(cl_mem buffer)
{
    size_t bytes = 0;
    if (buffer != NULL) {
        clGetMemObjectInfo(buffer, CL_MEM_SIZE, sizeof bytes, &bytes, NULL);
    }
    return bytes;
}

bool svo_i_kept_tree_is_same(const svo_i_kept_tree *a, const svo_i_kept_tree *b)
{
    bool same = a->grid.depth == b->grid.depth && a->grid.snap_bits == b->grid.snap_bits &&
                a->grid.scale == b->grid.scale && a->need == b->need && a->constant == b->constant &&
                a->weights == b->weights;
    for (int i = 0; i < 3; ++i) {
        same = same && a->grid.origin[i] == b->grid.origin[i] && a->constants[i] == b->constants[i];
    }
    return same;
}
