/* SPDX-License-Identifier: MIT */
/* clip_probe.clh in GLSL: one invocation per record. */
#include "clip_probe.clh"

layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Given
{
    clip_probe_input given[];
};
layout(std430, binding = 1) writeonly buffer Found
{
    clip_probe_output found[];
};
uniform uint item_count;

void main()
{
    uint i = gl_GlobalInvocationID.x;
    if (i < item_count) {
        found[i] = clip_probe(given[i]);
    }
}
