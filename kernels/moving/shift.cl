/* SPDX-License-Identifier: MIT */
/*
 * The numbers of an object among those of the scene.
 *
 *   svo_k_moving_shift   per word: copies it to its place in a common array, plus what comes before its object
 *   svo_k_moving_number  per pair: the entry of its leaf's list, its triangle among those of the scene
 *
 * Launch: one work-item per word or pair, rounded up to whole groups.
 */
#include "moving/kept.clh"

/* Words from params.first on. firsts: NULL; or the first triangle of each object and the end of all, and the words are
   those of the triangles of the object params.first, params.other_count each. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_moving_shift(__global const uint *from, __global uint *to, __global const uint *firsts, svo_moving_params params)
{
    const uint index = (uint)get_global_id(0);
    uint first = params.first;
    uint count = params.count;
    if (firsts != 0) {
        first = firsts[params.first] * params.other_count;
        count = firsts[params.first + 1u] * params.other_count - first;
    }
    if (index < count) {
        to[(size_t)first + index] = from[index] + params.object;
    }
}

/* counted: see svo_kept_count. firsts: the first triangle of each object. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_moving_number(__global const uint *fragments, __global const uint4 *values, __global const uint *firsts,
                    __global const uint *counted, __global uint *list, svo_moving_params params)
{
    const uint index = (uint)get_global_id(0);
    if (index < svo_kept_count(params.count, counted)) {
        list[index] = firsts[svo_kept_object(values, index)] + svo_fragment_triangle(fragments, index);
    }
}
