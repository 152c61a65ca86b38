/* SPDX-License-Identifier: MIT */
/* Launches compute shaders and times them. All functions expect the context current. */
#ifndef SVO_GLINTEROP_COMPUTE_LAUNCH_H
#define SVO_GLINTEROP_COMPUTE_LAUNCH_H

#include "compute/program.h"
#include "stages/build_state.h"

/* One dispatch. It starts after all earlier ones have finished. */
typedef struct svo_i_launch {
    svo_i_entry entry;
    GLuint buffers[SVO_I_COMPUTE_BLOCKS]; /* by binding; 0: not bound, since the variant does not read it */
    const void *params; /* svo_subdivide_params or svo_filter_params, by entry point */
    uint32_t vertex_count; /* for entry points that read attributes */
    uint64_t items; /* 0: launches nothing. Ignored with indirect. */
    GLuint indirect; /* not 0: this buffer has the numbers of groups, from word indirect_word on */
    uint32_t indirect_word;
} svo_i_launch;
svo_status svo_i_compute_launch(svo_i_compute *compute, const svo_i_launch *launch);

/* Waits. *exhausted: whether the driver cut a loop short since the last call, which makes the results invalid. */
svo_status svo_i_compute_exhausted(svo_i_compute *compute, bool *exhausted);

/* Waits for the work between begin and end, and adds its time to the stage. */
void svo_i_compute_stage_begin(svo_i_compute *compute);
svo_status svo_i_compute_stage_end(svo_i_compute *compute, svo_i_build *build, svo_stage stage);

#endif
