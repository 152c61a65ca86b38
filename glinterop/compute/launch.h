/* SPDX-License-Identifier: MIT */
/* Launches of compute shaders, and the time they take. All expect the context current. */
#ifndef SVO_GLINTEROP_COMPUTE_LAUNCH_H
#define SVO_GLINTEROP_COMPUTE_LAUNCH_H

#include "compute/program.h"
#include "stages/build_state.h"

/* One dispatch, ordered after all before it. */
typedef struct svo_i_launch {
    svo_i_entry entry;
    GLuint buffers[SVO_I_COMPUTE_BLOCKS]; /* by binding; 0: the variant does not have it */
    const void *params; /* svo_subdivide_params or svo_filter_params, by entry point */
    uint32_t vertex_count; /* for those that read attributes */
    uint64_t items; /* nothing is launched for none; not read with indirect */
    GLuint indirect; /* not 0: the groups to launch are in this buffer, from word indirect_word on */
    uint32_t indirect_word;
} svo_i_launch;
svo_status svo_i_compute_launch(svo_i_compute *compute, const svo_i_launch *launch);

/* Waits; whether a launch since the last call ended some loop before its time, so that its results are void. */
svo_status svo_i_compute_exhausted(svo_i_compute *compute, bool *exhausted);

/* Work between begin and end is waited for and counted to the stage. */
void svo_i_compute_stage_begin(svo_i_compute *compute);
svo_status svo_i_compute_stage_end(svo_i_compute *compute, svo_i_build *build, svo_stage stage);

#endif
