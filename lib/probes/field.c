/* SPDX-License-Identifier: MIT */
/* The host side of kernels/probes/field.cl. */
#include "probes/field.h"

#include "probes/programs.h"

#include <math.h>

/* Pairs of a cell and a probe that a launch looks at, so that none takes long enough for a driver to end it. */
#define BAND_PAIRS (UINT64_C(1) << 27)

/* Cells of a launch. */
static uint32_t band_cells(const svo_probe_info *info)
{
    const uint64_t cells = BAND_PAIRS / info->probe_count;
    return cells < SVO_GROUP_ITEMS ? SVO_GROUP_ITEMS : (uint32_t)cells;
}

svo_status svo_i_probes_field(const svo_i_probe_bands *bands)
{
    const svo_probes *probes = bands->probes;
    const svo_probe_info *info = &probes->info;
    const uint64_t cells = (uint64_t)info->field_size * info->field_size * info->field_size;
    const uint32_t most = band_cells(info);
    svo_probe_step step = {.scale_log2 = -ilogbf(info->leaf_edge)};
    for (int axis = 0; axis < 3; ++axis) {
        step.half_cell[axis] = (float)(((double)info->high[axis] - (double)info->low[axis]) / (2.0 * info->field_size));
    }
    SVO_I_TRY(svo_i_work_use(bands->work, &svo_i_program_probes, ""));
    for (uint64_t first = 0; first < cells; first += most) {
        step.first = (uint32_t)first;
        step.count = cells - first < most ? (uint32_t)(cells - first) : most;
        const svo_i_argument arguments[] = {SVO_I_ARGUMENT(probes->buffers[SVO_PROBES_PLACES]),
                                            SVO_I_ARGUMENT(probes->buffers[SVO_PROBES_TEXELS]),
                                            SVO_I_ARGUMENT(bands->thresholds),
                                            SVO_I_ARGUMENT(probes->buffers[SVO_PROBES_FIELD]),
                                            SVO_I_ARGUMENT(probes->params),
                                            SVO_I_ARGUMENT(step)};
        SVO_I_TRY(svo_i_work_launch(bands->work, "svo_k_probe_field", SVO_I_ARGUMENTS(arguments), step.count));
    }
    return SVO_OK;
}
