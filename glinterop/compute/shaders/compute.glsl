/* SPDX-License-Identifier: MIT */
/*
 * What all compute shaders of the builder share: the group's size, and which item an invocation is. Groups are laid
 * out in rows, since one row of them may be too short for a chunk of the list; those past the last item find nothing
 * to do.
 *
 * Each entry point of a stage, named as its OpenCL twin in kernels/, is a program of its own: the host defines its name
 * in capitals (SVO_K_MARK). Storage blocks are bound in the order of the launch's buffers, as an OpenCL kernel's
 * arguments are; parameters are the records of layout.h as uniforms.
 */
#include "shared/layout.h"

layout(local_size_x = SVO_GROUP_ITEMS) in;

layout(std430, binding = 15) buffer Exhausted
{
    uint exhausted; /* not 0: an invocation's loops were cut short */
};

/* llvmpipe allows the loops of one invocation 65535 turns in all, and then ends each at its first, without a word.
   Called after loops whose turns grow with a voxel's triangles, this notices by a loop of two turns, a number that no
   compiler knows. */
void svo_check_loops()
{
    uint turns = 0u;
    while (turns < gl_NumWorkGroups.z + 1u) {
        ++turns;
    }
    if (turns < 2u) {
        exhausted = 1u;
    }
}

uint svo_item()
{
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    return group * uint(SVO_GROUP_ITEMS) + gl_LocalInvocationID.x;
}
