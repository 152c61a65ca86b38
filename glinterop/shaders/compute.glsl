/* SPDX-License-Identifier: MIT */
/*
 * What all compute shaders of the builder share: the group's size, and which item an invocation is. Groups are laid out in
 * rows, since one row of them may be too short for a chunk of the list; those past the last item find nothing to do.
 *
 * Each entry point of a stage, named as its OpenCL twin in kernels/, is a program of its own: the host defines its name
 * in capitals (SVO_K_MARK). Storage blocks are bound in the order of the launch's buffers, as an OpenCL kernel's arguments
 * are; parameters are the records of layout.h as uniforms.
 */
layout(local_size_x = SVO_GROUP_ITEMS) in;

uint svo_item()
{
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    return group * uint(SVO_GROUP_ITEMS) + gl_LocalInvocationID.x;
}
