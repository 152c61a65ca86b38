/* SPDX-License-Identifier: MIT */
/*
 * Links the fragments of each leaf into a list: kernels/stages/link.cl in GLSL. heads[k] is the first fragment of leaf
 * k plus one, 0 for none. Cursors stay unchanged, because they are needed again when a list is too long for one
 * invocation.
 *
 * Launch: one invocation per fragment of a chunk.
 */
uniform svo_filter_params params;

layout(std430, binding = 0) readonly buffer Cursors
{
    uint cursors[];
};
layout(std430, binding = 1) buffer Heads
{
    uint heads[];
};
layout(std430, binding = 2) writeonly buffer Links
{
    uint links[];
};

void main()
{
    uint index = svo_item();
    if (index < params.fragment_count) {
        links[index] = atomicExchange(heads[cursors[index] - params.leaf_begin], index + 1u);
    }
}
