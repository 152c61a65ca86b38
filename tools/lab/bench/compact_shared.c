/* SPDX-License-Identifier: MIT */
/* Sizes of SVO_FORM_SHARED, and the time to make it. */
#include "bench/compact_shared.h"

static const char table_id[] = "compact-shared";

static const char note[] =
    "Without payload. Records: nodes that are stored, out of the inner nodes; the deepest of these have no record. "
    "Merged: full leaves first. Made: from the built tree. Published for other scenes: 0.40 bit per voxel at 128K^3 "
    "(Kampe, Sintorn and Assarsson, High Resolution Sparse Voxel DAGs, 2013), 0.123 at 64K^3 with mirrored subtrees "
    "shared too (Villanueva, Marton and Gobbetti, SSVDAGs, 2016). Bits per voxel fall with depth.";

void compact_shared_begin(suite *all)
{
    result_table *table = suite_add_table(all, table_id, "Shared subtrees: bits per voxel", note);
    result_add_column(table, "scene", "");
    result_add_column(table, "depth", "");
    result_add_column(table, "voxels", "");
    result_add_column(table, "inner nodes", "");
    result_add_column(table, "records", "");
    result_add_column(table, "nodes", "B");
    result_add_column(table, "per voxel", "bit");
    result_add_column(table, "made", "ms");
    result_add_column(table, "merged nodes", "");
    result_add_column(table, "merged leaves", "");
    result_add_column(table, "merged per voxel", "bit");
    result_add_column(table, "merged made", "ms");
}

static svo_status make(const session *opened, const svo_tree *tree, const svo_compact_options *asked,
                       svo_compact_info *info, double *ms)
{
    svo_compact *made = NULL;
    const double start_ms = input_now_ms();
    svo_status status = svo_compact_create(opened->device, tree, asked, opened->queue, &made);
    *ms = input_now_ms() - start_ms;
    if (status == SVO_OK) {
        status = svo_compact_get_info(made, info);
    }
    svo_compact_destroy(&made);
    return status;
}

static double bits_per_voxel(const svo_compact_info *info)
{
    return 8.0 * (double)info->total_bytes / (double)info->voxel_count;
}

svo_status compact_shared_run(suite *all, const input *source, const svo_tree *tree)
{
    svo_compact_info infos[2] = {SVO_COMPACT_INFO_INIT, SVO_COMPACT_INFO_INIT};
    double ms[2] = {0, 0};
    /* Twice: the first turn compiles. */
    for (int turn = 0; turn < 4; ++turn) {
        svo_compact_options asked = SVO_COMPACT_OPTIONS_INIT;
        asked.form = SVO_FORM_SHARED;
        asked.minimize = turn % 2 != 0;
        asked.leave_out = SVO_NEED_ALL;
        const svo_status status = make(&all->opened, tree, &asked, &infos[turn % 2], &ms[turn % 2]);
        if (status != SVO_OK) {
            return status;
        }
    }
    result_table *table = result_find(all->results, table_id);
    result_add_text(table, "%s", suite_scene_name(source));
    result_add_number(table, infos[0].depth);
    result_add_number(table, (double)infos[0].voxel_count);
    result_add_number(table, (double)infos[0].inner_count);
    result_add_number(table, (double)infos[0].shared_count);
    result_add_number(table, (double)infos[0].total_bytes);
    result_add_number(table, bits_per_voxel(&infos[0]));
    result_add_number(table, ms[0]);
    result_add_number(table, (double)infos[1].inner_count);
    result_add_number(table, (double)infos[1].leaf_count);
    result_add_number(table, bits_per_voxel(&infos[1]));
    result_add_number(table, ms[1]);
    return SVO_OK;
}
