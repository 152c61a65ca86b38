/* SPDX-License-Identifier: MIT */
/* probe.clh in GLSL: one invocation per record. */
#include "probe.clh"

layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Given
{
    probe_input given[];
};
layout(std430, binding = 1) writeonly buffer Found
{
    probe_output found[];
};
uniform uint item_count;

void main()
{
    uint i = gl_GlobalInvocationID.x;
    if (i < item_count) {
        found[i] = probe(given[i]);
    }
}
