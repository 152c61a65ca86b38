/* SPDX-License-Identifier: MIT */
/*
 * Links the fragments of each leaf into a list (Yang et al., "Real-Time Concurrent Linked List Construction on the
 * GPU", 2010). heads[k] is the first fragment of leaf k plus one, 0 for none. A fragment's link replaces its cursor,
 * which no later stage reads. Lists never leave their chunk. For CPUs, as the gather kernels of filter.cl are.
 *
 * Launch: one work-item per fragment of a chunk, rounded up to whole groups. Reads and writes cursors and heads.
 * Atomics: one exchange per fragment suffices, since lists are only read after the launch. The order inside a list
 * differs from run to run; sums over it do not.
 */
#include "shared/state.clh"

#ifdef SVO_PAIR_LANES

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_link(__global uint *cursors, volatile __global uint *heads, __global const svo_build_state *state,
           svo_filter_params params)
{
    svo_make_current(&params, state);
    const uint index = (uint)get_global_id(0);
    if (index < params.fragment_count) {
        cursors[index] = atomic_xchg(heads + (cursors[index] - params.leaf_begin), index + 1u);
    }
}

#endif
