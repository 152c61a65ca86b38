"""Step 6: your own kernel. OpenCL C of yours asks the tree for rays, on the device and without a copy. Here each pixel
counts in how many of 16 directions it sees the sky. It needs pyopencl beside svocl."""

import pathlib
import sys

import numpy as np
import pyopencl as cl
from model import load
from rays import eye_rays

import svocl

SOURCE = """
__kernel void openness(SVO_TREE_PARAMETERS, __global const svo_ray *rays, __global float *open)
{
    SVO_TREE_MAKE(tree);
    svo_ray ray = rays[get_global_id(0)];
    svo_hit hit;
    svo_hit blocker;
    float seen = -1.0f; /* the pixel sees nothing */
    if (svo_trace_closest(&tree, &ray, &hit)) {
        const float3 toward = (float3)(ray.direction[0], ray.direction[1], ray.direction[2]);
        float3 normal = (float3)(hit.normal[0], hit.normal[1], hit.normal[2]);
        normal = dot(normal, toward) > 0.0f ? -normal : normal;
        const float3 at = (float3)(ray.origin[0], ray.origin[1], ray.origin[2]) + hit.t * toward;
        seen = 0.0f;
        for (int i = 0; i < 16; ++i) {
            const float height = (float)i / 8.0f - 0.9375f; /* on a spiral round the sphere */
            const float turn = 2.4f * (float)i;
            const float3 step = (float3)(cos(turn), 0.0f, sin(turn)) * sqrt(1.0f - height * height);
            const float3 away = normalize(normal + 0.99f * (step + (float3)(0.0f, height, 0.0f)));
            const svo_ray other = {{at.x, at.y, at.z}, {away.x, away.y, away.z}, 1e-3f, INFINITY};
            seen += svo_trace_any(&tree, &other, &blocker) ? 0.0f : 1.0f / 16.0f;
        }
    }
    open[get_global_id(0)] = seen;
}
"""


def picture(depth=7, width=320, path=None):
    height = width * 3 // 4
    device = svocl.Device()  # or svocl.Device(context=...) of a context that is there already
    context = cl.Context.from_int_ptr(device.context_int_ptr)
    queue = cl.CommandQueue(context)
    tree = device.build(load(path), depth, need=svocl.Need.RAYS, queue=queue)
    rays = eye_rays(tree.frame(width / height), width, height)
    kernel = cl.Program(context, svocl.kernel_source() + SOURCE).build(svocl.kernel_options().split()).openness
    tree.set_kernel_args(kernel, 0)
    batch = cl.Buffer(context, cl.mem_flags.COPY_HOST_PTR, hostbuf=rays)  # a kernel keeps no buffer alive
    kernel.set_arg(svocl.TREE_ARGUMENTS, batch)
    result = cl.Buffer(context, cl.mem_flags.WRITE_ONLY, 4 * rays.size)
    kernel.set_arg(svocl.TREE_ARGUMENTS + 1, result)
    cl.enqueue_nd_range_kernel(queue, kernel, (rays.size,), None)
    seen = np.empty((height, width), np.float32)
    cl.enqueue_copy(queue, seen, result)
    print(f"{(seen >= 0).sum()} pixels see the model, on average {seen[seen >= 0].mean():.2f} open")
    shown = np.full((height, width, 4), 255, np.uint8)
    shown[..., :3] = np.where(seen[..., None] < 0, [24, 26, 32], 255 * seen[..., None].clip(0, 1))
    return shown


if __name__ == "__main__":
    pathlib.Path("kernel.png").write_bytes(svocl.png(picture(path=sys.argv[1] if len(sys.argv) > 1 else None)))
