# SPDX-License-Identifier: MIT
"""Lifetimes and threads: nothing dangles, whatever is closed or collected first; calls release the GIL."""

import gc
import subprocess
import sys
import threading
import time
import weakref

import numpy as np
import pytest

import svocl
from svocl._handle import Guard


def test_closed_handles_are_refused(cube):
    with svocl.Device() as device:
        with device.plan(cube, 3, need=svocl.Need.NONE) as plan:
            with plan.build() as tree:
                assert not (device.closed or plan.closed or tree.closed)
    assert device.closed and plan.closed and tree.closed
    for name, use in {
        "Device": lambda: device.name,
        "Plan": lambda: plan.build(),
        "Tree": lambda: tree.hash(),
    }.items():
        with pytest.raises(ValueError, match=f"^{name} is closed$"):
            use()
        assert "closed" in repr({"Device": device, "Plan": plan, "Tree": tree}[name])
    tree.close()


def test_arrays_and_trees_outlive_what_they_were_made_from(cube):
    device = svocl.Device()
    tree = device.build(cube, 3, need=svocl.Need.NONE)
    device.close()
    digest = tree.hash()  # its device lives on
    native = weakref.ref(tree._native)
    masks = tree.arrays.child_mask
    copy = masks.copy()
    part = masks[3:][::2]
    tree.close()
    del tree, masks
    gc.collect()
    assert native() is not None and np.array_equal(part, copy[3:][::2])
    del part
    gc.collect()
    assert native() is None
    assert len(digest) == 32


def test_native_handles_are_destroyed_once_and_children_first(monkeypatch, cube):
    from svocl import _device, _plan, _tree

    order = []
    for module, name in ((_device, "_destroy_device"), (_plan, "_destroy_plan"), (_tree, "_destroy_tree")):
        destroy = getattr(module, name)
        monkeypatch.setattr(module, name, lambda pointer, n=name, d=destroy: (order.append(n), d(pointer)))
    device = svocl.Device()
    plan = device.plan(cube, 3, need=svocl.Need.NONE)
    tree = plan.build()
    masks = tree.arrays.child_mask
    device.close()
    plan.close()
    assert order == ["_destroy_plan"]
    tree.close()
    assert order == ["_destroy_plan"]
    del masks
    assert order == ["_destroy_plan", "_destroy_tree", "_destroy_device"]
    del device, plan, tree
    gc.collect()
    assert len(order) == 3


def test_garbage_in_cycles(cube):
    """The collector finalizes a device and its tree in any order."""
    for names in (("device", "tree"), ("tree", "device")):
        made = {"device": svocl.Device()}
        made["tree"] = made["device"].build(cube, 2, need=svocl.Need.NONE)
        cycle = [made[name] for name in names]
        cycle.append(cycle)
        natives = [weakref.ref(handle._native) for handle in made.values()]
        del made, cycle
        gc.collect()
        assert [native() for native in natives] == [None, None]


def test_nothing_is_left_at_exit():
    """An interpreter that ends with open handles ends well."""
    code = """
import numpy, svocl
device = svocl.Device()
plan = device.plan(svocl.Mesh(numpy.eye(3)), 3, need=svocl.Need.NONE)
tree = plan.build()
masks = tree.arrays.child_mask
"""
    done = subprocess.run([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    assert (done.returncode, done.stdout) == (0, b"")


def test_a_guard_refuses_its_own_thread_and_runs_late_work():
    guard = Guard()
    done = []
    with guard:
        guard.later(lambda: done.append(1))
        assert done == []
        with pytest.raises(RuntimeError, match="a callback may not use the device"):
            with guard:
                pass
    assert done == [1]
    guard.later(lambda: guard.later(lambda: done.append(2)))
    assert done == [1, 2]


def test_calls_release_the_gil(device, torus):
    """Python only switches threads by itself every 1000 s here, so that the other thread runs if a call lets it."""
    ticks, stop = [0], threading.Event()

    def tick():
        while not stop.is_set():
            ticks[0] += 1
            time.sleep(0.0001)  # gives the GIL back

    interval = sys.getswitchinterval()
    thread = threading.Thread(target=tick)
    plan = device.plan(torus, 7, need=svocl.Need.NONE)
    thread.start()
    try:
        sys.setswitchinterval(1000)
        before = ticks[0]
        plan.build().close()
        after = ticks[0]
    finally:
        sys.setswitchinterval(interval)
        stop.set()
        thread.join()
        plan.close()
    assert after > before


def test_threads(cube):
    """Threads on one device take turns, threads on devices of their own do not wait; the trees are the same."""
    with svocl.Device() as device:
        digests, problems = [], []

        def work(own):
            try:
                with svocl.Device() if own else device.plan(cube, 2) as handle:
                    used = handle if own else device
                    for _ in range(5):
                        with used.build(cube, 4, need=svocl.Need.RAYS) as tree:
                            hits = tree.trace(svocl.make_rays([[0.3, 0.4, -1]], [0, 0, 1]))
                            digests.append((tree.hash(), hits["triangle"].item()))
            except Exception as problem:
                problems.append(problem)

        threads = [threading.Thread(target=work, args=(own,)) for own in (False, False, True)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    assert problems == [] and len(digests) == 15 and len(set(digests)) == 1


def test_closing_while_another_thread_builds(torus):
    """close() never waits, and the handle goes when the build is done."""
    device = svocl.Device()
    plan = device.plan(torus, 6, need=svocl.Need.NONE)
    spare = device.plan(torus, 3, need=svocl.Need.NONE)
    result = []
    thread = threading.Thread(target=lambda: result.append(plan.build()))
    thread.start()
    while not device._native.guard._lock.locked() and thread.is_alive():
        time.sleep(0)
    spare.close()
    device.close()
    thread.join()
    assert not spare._native._pointer
    assert result[0].info.leaf_count > 0
    result[0].close()
    plan.close()
    assert not device._native._pointer
