/* SPDX-License-Identifier: MIT */
/* Makes a solid, compares it, and says what differs. */
#include "support/solid_verdict.h"

#include <inttypes.h>

#include "support/table.h"

int solid_verdict_check_depth(program *state)
{
    return !solid_is_wanted(state) || state->options.depth <= SOLID_CHECK_DEPTH_MAX
               ? PROGRAM_DONE
               : program_fail(state, PROGRAM_WRONG_USAGE, "--solid is compared up to depth %d, not at depth %" PRIu64,
                              SOLID_CHECK_DEPTH_MAX, state->options.depth);
}

int solid_verdict_find(program *state, const session *opened, const svo_tree *tree, solid_verdict *out)
{
    svo_tree_info info = SVO_TREE_INFO_INIT;
    svo_tree_arrays arrays = SVO_TREE_ARRAYS_INIT;
    svo_tree_get_info(tree, &info);
    svo_tree_get_arrays(tree, &arrays);
    *out = (solid_verdict){.made = {.solid = NULL}};
    const int exit_code = solid_make(state, opened->device, tree, &out->made);
    if (exit_code != PROGRAM_DONE || out->made.solid == NULL) {
        return exit_code;
    }
    progress_step(state->progress, "comparing the inside with the reference");
    if (svo_compact_download(out->made.solid, NULL) != SVO_OK) {
        return program_fail_library(state, svo_device_message(opened->device));
    }
    return solid_check(&info, &arrays, out->made.solid, &out->made.info, solid_rule(state), &out->found)
               ? PROGRAM_DONE
               : program_fail(state, PROGRAM_FAILED,
                              "%s: the comparison of the inside ran out of memory or the solid is malformed",
                              state->options.input);
}

void solid_verdict_release(solid_verdict *verdict)
{
    solid_release(&verdict->made);
}

bool solid_verdict_is_exact(const solid_verdict *verdict)
{
    return verdict->made.solid == NULL || solid_check_is_exact(&verdict->found);
}

void solid_verdict_print(const program *state, const solid_verdict *verdict)
{
    const oracle_solid_difference *voxels = &verdict->found.voxels;
    if (verdict->made.solid == NULL) {
        return;
    }
    solid_print(state, &verdict->made);
    table_line("%s voxels are not as the reference says, of %s inside", figure_count(voxels->wrong_voxels).text,
               figure_count(voxels->inside_voxels).text);
    if (voxels->split_voxels > 0) {
        table_line("%s voxels lie on the other side than the one that decides their cell, for the surface is open",
                   figure_count(voxels->split_voxels).text);
    }
}

void solid_verdict_add_json(cJSON *document, const program *state, const solid_verdict *verdict)
{
    if (verdict->made.solid == NULL) {
        return;
    }
    cJSON *object = solid_add_json(document, state, &verdict->made);
    json_add_count(object, "wrong_voxels", verdict->found.voxels.wrong_voxels);
    json_add_count(object, "split_voxels", verdict->found.voxels.split_voxels);
    cJSON_AddBoolToObject(object, "exact", solid_verdict_is_exact(verdict));
}
