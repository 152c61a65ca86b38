/* SPDX-License-Identifier: MIT */
/*
 * What all compute shaders of the builder share: the group size and the item of an invocation. A launch arranges its
 * groups in rows, since one row may be too short for a chunk of the list. Invocations past the last item do nothing.
 *
 * Each entry point of a stage has the name of its OpenCL twin in kernels/ and is a program of its own: the host defines
 * its name in capitals (SVO_K_MARK). Storage blocks are bound in the order of the launch's buffers, like the arguments
 * of an OpenCL kernel. Parameters are the records of layout.h, as uniforms.
 *
 * An array may exceed a storage block. Then a launch binds ranges of its arrays, and works on a window: on consecutive
 * nodes or leaves, whose elements the ranges hold. Fragments of other leaves wait for another launch.
 */
#include "shared/layout.h"

layout(local_size_x = SVO_GROUP_ITEMS) in;

layout(std430, binding = 15) buffer Exhausted
{
    uint exhausted; /* not 0: an invocation's loops were cut short, or would have been long */
};

uniform uint svo_first[15]; /* by binding: the first word of the array that is bound */
uniform uint window_begin; /* nodes from the first of their level on, or leaves */
uniform uint window_count;

bool svo_in_window(uint index)
{
    return index - window_begin < window_count;
}

/* llvmpipe silently stops an invocation after 65535 loop iterations: every later loop ends after one iteration. Call
   this after loops whose length grows with a voxel's triangles. It runs a loop of two iterations, a number that is
   unknown to the compiler, and detects when fewer run. */
void svo_check_loops()
{
    uint iterations = 0u;
    while (iterations < gl_NumWorkGroups.z + 1u) {
        ++iterations;
    }
    if (iterations < 2u) {
        exhausted = 1u;
    }
}

/* Whether a leaf has too many triangles for one invocation, since drivers of GPUs stop long launches; then the host is
   told in the same way. */
bool svo_is_long(uint triangles)
{
    if (triangles > uint(SVO_LONG_LEAF)) {
        exhausted = 1u;
    }
    return triangles > uint(SVO_LONG_LEAF);
}

uint svo_item()
{
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    return group * uint(SVO_GROUP_ITEMS) + gl_LocalInvocationID.x;
}
