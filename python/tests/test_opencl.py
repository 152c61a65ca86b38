# SPDX-License-Identifier: MIT
"""pyopencl's contexts, queues, buffers, events and kernels, with PyPI's pyopencl, which has a loader of its own."""

import numpy as np
import pytest

import svocl

cl = pytest.importorskip("pyopencl")

SHADE = """
kernel void shade(SVO_TREE_PARAMETERS, global const svo_ray *rays, global uchar *dark)
{
    SVO_TREE_MAKE(tree);
    const svo_ray ray = rays[get_global_id(0)];
    svo_hit hit;
    dark[get_global_id(0)] = svo_trace_any(&tree, &ray, &hit);
}
"""


@pytest.fixture(scope="module")
def context(device):
    """A context of pyopencl's own, on the device that svocl chose."""
    return cl.Context([cl.Device.from_int_ptr(device.device_int_ptr)])


@pytest.fixture(scope="module")
def queue(context):
    return cl.CommandQueue(context, properties=cl.command_queue_properties.PROFILING_ENABLE)


@pytest.fixture(scope="module")
def shared(context):
    with svocl.Device(context=context) as made:
        yield made


@pytest.fixture(scope="module")
def torus_there(shared, torus, queue):
    with shared.build(torus, 5, need=svocl.Need.RAYS, queue=queue) as made:
        yield made


def test_context_and_queue(context, queue, shared, torus_there, tree):
    assert shared.context_int_ptr == context.int_ptr
    assert torus_there.hash() == tree.hash()
    assert torus_there.report.stages["voxelize"].clock == "cl-event"
    assert tree.report.stages["voxelize"].clock == "wall"
    with svocl.Device(context=context.int_ptr, device=context.devices[0].int_ptr) as by_address:
        assert by_address.name == shared.name


def test_a_context_made_by_svocl(device):
    context = cl.Context.from_int_ptr(device.context_int_ptr)
    assert [f"{d.platform.name}: {d.name}" for d in context.devices] == [device.name]
    assert cl.CommandQueue(context).finish() is None


def test_buffers_of_the_tree(torus_there, queue):
    arrays = torus_there.download(queue=queue)
    for name in ("child_mask", "first_child", "vertices", "list"):
        expected = getattr(arrays, name)
        buffer = cl.Buffer.from_int_ptr(torus_there.buffer_int_ptr(svocl.TreeBuffer[name.upper()]))
        copy = np.empty_like(expected)
        cl.enqueue_copy(queue, copy, buffer)
        assert np.array_equal(copy, expected), name
    assert torus_there.buffer_int_ptr(svocl.TreeBuffer.COLORS) is None


def test_a_buffer_outlives_its_tree(shared, torus, queue):
    tree = shared.build(torus, 3, need=svocl.Need.NONE)
    expected = tree.arrays.child_mask
    buffer = cl.Buffer.from_int_ptr(tree.buffer_int_ptr(svocl.TreeBuffer.CHILD_MASK))
    tree.close()
    copy = np.empty_like(expected)
    cl.enqueue_copy(queue, copy, buffer)
    assert np.array_equal(copy, expected)


def test_rays_in_device_buffers(context, queue, torus_there, random):
    rays = svocl.make_rays(random.uniform(-2, 2, (100, 3)), random.normal(size=(100, 3)))
    source = cl.Buffer(context, cl.mem_flags.COPY_HOST_PTR, hostbuf=rays)
    target = cl.Buffer(context, cl.mem_flags.READ_WRITE, 100 * svocl.hit_dtype.itemsize)
    hits = np.empty(100, svocl.hit_dtype)
    ready = cl.UserEvent(context)
    own = torus_there.trace_enqueue(source, target, 100, queue, wait_for=[ready])
    event = cl.Event.from_int_ptr(own.int_ptr)
    assert event.command_execution_status != cl.command_execution_status.COMPLETE
    ready.set_status(cl.command_execution_status.COMPLETE)
    cl.enqueue_copy(queue, hits, target, wait_for=[event])
    assert np.array_equal(hits, torus_there.trace(rays, queue=queue))

    points = np.zeros(100, svocl.query_dtype)
    points["position"], points["max_distance"] = rays["origin"], np.inf
    source = cl.Buffer(context, cl.mem_flags.COPY_HOST_PTR, hostbuf=points)
    event = cl.Event.from_int_ptr(torus_there.nearest_enqueue(source, target, 100, queue).int_ptr)
    found = np.empty(100, svocl.nearest_dtype)
    cl.enqueue_copy(queue, found, target, wait_for=[event])
    assert np.array_equal(found, torus_there.nearest(points))


def test_a_kernel_of_the_callers(context, queue, torus_there):
    rays = svocl.make_rays([-3, 0, 0], [[1, 0.1, 0], [-1, 0, 0], [1, 0, 0.1]])
    kernel = cl.Program(context, svocl.kernel_source() + SHADE).build(svocl.kernel_options().split()).shade
    batch = cl.Buffer(context, cl.mem_flags.COPY_HOST_PTR, hostbuf=rays)
    dark = cl.Buffer(context, cl.mem_flags.WRITE_ONLY, 3)
    torus_there.set_kernel_args(kernel, 0)
    kernel.set_arg(svocl.TREE_ARGUMENTS, batch)
    kernel.set_arg(svocl.TREE_ARGUMENTS + 1, dark)
    cl.enqueue_nd_range_kernel(queue, kernel, (3,), None)
    found = np.empty(3, np.uint8)
    cl.enqueue_copy(queue, found, dark)
    assert found.tolist() == np.isfinite(torus_there.trace(rays)["t"]).astype(int).tolist() == [1, 0, 1]


def test_wrong_objects(context, queue, shared, torus, tree):
    with pytest.raises(TypeError, match="context: CommandQueue, expected pyopencl.Context or its int_ptr"):
        svocl.Device(context=queue, device=context.devices[0])
    with pytest.raises(ValueError, match="device: needed with the address of a context"):
        svocl.Device(context=context.int_ptr)
    with pytest.raises(ValueError, match="device: given without its context"):
        svocl.Device(device=context.devices[0])
    with pytest.raises(ValueError, match="name: a context was given"):
        svocl.Device("GPU", context=context)
    with pytest.raises(ValueError, match="queue: 0 is not the address of an OpenCL object"):
        tree.download(queue=0)
    with shared.plan(torus, 3) as plan:
        with pytest.raises(TypeError, match="queue: Context, expected pyopencl.CommandQueue or its int_ptr"):
            plan.build(queue=context)
        other = cl.CommandQueue(cl.Context([context.devices[0]]))
        with pytest.raises(svocl.InvalidArgumentError, match="svo_build: .*context"):
            plan.build(queue=other)


def test_meshes_in_device_buffers(context, queue, shared, random):
    """Arrays of pyopencl, also strided ones, give the tree of the same arrays on the host."""
    arrays = pytest.importorskip("pyopencl.array")
    positions = random.random((300, 3), np.float32)
    indices = random.integers(0, 300, (500, 3), dtype=np.uint32)
    expected = shared.build(svocl.Mesh(positions, indices), 5, need=svocl.Need.RAYS).hash()
    on_device = arrays.to_device(queue, positions), arrays.to_device(queue, indices)
    mesh = svocl.DeviceMesh(*on_device)
    assert (mesh.vertex_count, mesh.triangle_count) == (300, 500)
    assert shared.build(mesh, 5, need=svocl.Need.RAYS, queue=queue).hash() == expected

    wide = np.zeros((300, 5), np.float32)
    wide[:, 1:4] = positions

    class Strided:
        shape, dtype, strides, offset = (300, 3), np.float32, (20, 4), 4
        kept = arrays.to_device(queue, wide)
        __cl_mem__ = kept.base_data.int_ptr

    assert shared.build(svocl.DeviceMesh(Strided(), on_device[1]), 5, need=svocl.Need.RAYS).hash() == expected
    with pytest.raises(TypeError, match="wait_for: str"):  # those of an array are waited for
        Strided.events = ["event"]
        shared.build(svocl.DeviceMesh(Strided()), 5)
    short = arrays.to_device(queue, indices.astype(np.uint16))
    assert shared.build(svocl.DeviceMesh(on_device[0], short), 5, need=svocl.Need.RAYS).hash() == expected
    for wrong, message in [
        ((positions, None), "positions: ndarray has neither __cl_mem__ nor base_data"),
        ((on_device[0], arrays.to_device(queue, indices.astype(np.int64))), "indices: dtype int64, expected uint32"),
        ((arrays.to_device(queue, positions.astype(np.float64)), None), "positions: dtype float64, expected float32"),
        ((None, None), "positions: NoneType, expected an array in a device buffer"),
    ]:
        with pytest.raises(TypeError, match=message):
            svocl.DeviceMesh(*wrong)
    with pytest.raises(ValueError, match=r"colors: shape \(300, 3\), expected \(300, 4\)"):
        svocl.DeviceMesh(*on_device, colors=on_device[0])


def test_events_release_themselves(context, queue, torus_there):
    rays = svocl.make_rays([-3, 0, 0], [[1, 0, 0]])
    source = cl.Buffer(context, cl.mem_flags.COPY_HOST_PTR, hostbuf=rays)
    target = cl.Buffer(context, cl.mem_flags.READ_WRITE, svocl.hit_dtype.itemsize)
    event = torus_there.trace_enqueue(source, target, 1, queue)
    kept = cl.Event.from_int_ptr(event.int_ptr)
    event.wait()
    assert kept.reference_count >= 2
    before = kept.reference_count
    later = torus_there.trace_enqueue(source, target, 1, queue, wait_for=[event])
    later.wait()
    del event, later
    assert kept.reference_count < before
