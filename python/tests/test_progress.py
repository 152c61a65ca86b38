# SPDX-License-Identifier: MIT
"""Progress of plans and builds: what is reported, and that True, an exception or Ctrl-C stops the call."""

import gc
import signal
import sys
import threading
import traceback
import weakref

import numpy as np
import pytest

import svocl
from svocl import _plan
from svocl._native import ffi, lib

STAGES = [ffi.string(lib.svo_name(lib.SVO_NAME_STAGE, stage)).decode() for stage in range(lib.SVO_STAGE_COUNT)]


class Watch:
    """Keeps what is reported; answers as told once a stage is reached."""

    def __init__(self, stage=None, answer=None):
        self.stage, self.answer = stage, answer
        self.calls, self.threads = [], set()

    def __call__(self, stage, fraction):
        self.calls.append((stage, fraction))
        self.threads.add(threading.get_ident())
        if stage == self.stage:
            return self.answer() if callable(self.answer) else self.answer
        return None

    @property
    def stages(self):
        return list(dict.fromkeys(stage for stage, _ in self.calls))

    def check(self):
        """A call that succeeded: types, from 0 to 1, stages in their order, on this thread. Data is transferred at any
        time."""
        assert {tuple(map(type, call)) for call in self.calls} == {(str, float)}
        fractions = [fraction for _, fraction in self.calls]
        assert fractions[0] == 0 and fractions[-1] == 1 and fractions == sorted(fractions), fractions
        stages = [stage for stage in self.stages if stage != "transfer"]
        assert stages == [stage for stage in STAGES if stage in stages]
        assert self.threads == {threading.get_ident()}


@pytest.fixture
def plan(device, torus):
    with device.plan(torus, 5, need=svocl.Need.RAYS) as made:
        yield made


def test_plans_counts_and_builds_report(device, torus, tree):
    watch = Watch()
    with device.plan(torus, 5, need=svocl.Need.RAYS, progress=watch) as plan:
        watch.check()
        assert watch.stages == ["grid"]
        watch.calls.clear()
        assert plan.count(progress=False) > 0 and watch.calls == []
        fragments = plan.count()  # the plan's own, as no other is given
        watch.check()
        assert "voxelize" in watch.stages and "subdivide" not in watch.stages
        watch.calls.clear()
        with plan.build() as built:
            assert built.hash() == tree.hash() and built.info.fragments <= fragments
        watch.check()
        assert {"voxelize", "subdivide", "pack"} <= set(watch.stages) and "grid" not in watch.stages

        watch.calls.clear()
        other = Watch()
        plan.build(progress=other).close()
        other.check()
        plan.build(progress=False).close()
        plan.count(progress=False)
        assert watch.calls == []


def test_device_build_reports_as_one_call(device, torus):
    watch = Watch()
    need = svocl.Need.RAYS | svocl.Need.NORMAL
    with device.build(torus, 5, need=need, progress=watch) as tree, device.build(torus, 5, need=need) as silent:
        assert tree.hash() == silent.hash()
    watch.check()
    assert watch.stages[0] == "grid" and {"voxelize", "subdivide", "pack", "filter"} <= set(watch.stages)
    assert {fraction for stage, fraction in watch.calls if stage == "grid"} >= {0.0, 0.1}


def test_the_function_is_kept_as_long_as_it_is_needed(device, torus):
    """For the call, or with its plan; and the library has no callback between calls."""
    watch, other = Watch(), Watch()
    kept, gone = weakref.ref(watch), weakref.ref(other)
    plan = device.plan(torus, 3, need=svocl.Need.NONE, progress=watch)
    del watch
    gc.collect()
    plan.build(progress=other).close()
    calls = len(other.calls)
    with plan._use() as pointer:
        assert lib.svo_build(pointer, ffi.NULL, ffi.NULL, out := ffi.new("svo_tree **"), ffi.NULL) == lib.SVO_OK
        lib.svo_tree_destroy(out)
    assert len(other.calls) == calls
    del other
    gc.collect()
    assert gone() is None and kept() is not None
    kept().calls.clear()
    plan.build().close()
    kept().check()
    plan.close()
    del plan
    gc.collect()
    assert kept() is None


@pytest.mark.parametrize("stage", ["compile", "voxelize", "subdivide", "pack"])
def test_true_cancels(plan, tree, stage):
    watch = Watch(stage, True)
    with pytest.raises(svocl.CanceledError, match=f"^svo_build: .* stopped the call in stage {stage} at ") as caught:
        plan.build(progress=watch)
    assert caught.value.status == svocl.Status.CANCELED
    assert [called for called, _ in watch.calls].count(stage) == 1 and watch.calls[-1][0] == stage
    with plan.build() as built:
        assert built.hash() == tree.hash()


def test_true_cancels_plans_and_counts(device, torus, plan):
    with pytest.raises(svocl.CanceledError, match="^svo_plan_create: the progress callback stopped"):
        device.plan(torus, 5, progress=Watch("grid", np.bool_(True)))
    with pytest.raises(svocl.CanceledError, match="^svo_plan_count: the progress callback stopped"):
        plan.count(progress=Watch("voxelize", np.bool_(True)))
    with pytest.raises(svocl.CanceledError, match="^svo_plan_create: "):
        device.build(torus, 5, progress=Watch("grid", True))
    with pytest.raises(svocl.CanceledError, match="^svo_build: "):
        device.build(torus, 5, progress=Watch("voxelize", True))
    for answer in (None, False, np.bool_(False)):
        device.plan(torus, 2, progress=Watch("grid", answer)).close()


class Stop(Exception):
    pass


def test_an_exception_stops_the_call_and_comes_out_of_it(device, torus, plan, tree):
    def raise_stop():
        raise Stop("enough")

    for call in (
        lambda watch: plan.build(progress=watch),
        lambda watch: plan.count(progress=watch),
        lambda watch: device.build(torus, 5, progress=watch),
    ):
        watch = Watch("voxelize", raise_stop)
        with pytest.raises(Stop, match="^enough$") as caught:
            call(watch)
        assert [stage for stage, _ in watch.calls].count("voxelize") == 1 and watch.calls[-1][0] == "voxelize"
        assert "raise_stop" in [frame.name for frame in traceback.extract_tb(caught.value.__traceback__)]
    with pytest.raises(Stop):
        device.plan(torus, 5, progress=Watch("grid", raise_stop))
    with plan.build() as built:
        assert built.hash() == tree.hash()


def test_a_tree_that_was_built_nevertheless_is_destroyed(plan, monkeypatch):
    """The last report is that of a finished build; what it raises must not leave the tree behind."""
    destroyed = []

    class Counting:
        def __getattr__(self, name):
            if name == "svo_tree_destroy":
                return lambda out: (destroyed.append(1), lib.svo_tree_destroy(out))
            return getattr(lib, name)

    def last(_stage, fraction):
        if fraction == 1:
            raise Stop

    monkeypatch.setattr(_plan, "lib", Counting())
    with pytest.raises(Stop):
        plan.build(progress=last)
    assert destroyed == [1]


@pytest.mark.skipif(sys.platform == "win32", reason="POSIX signals")
def test_ctrl_c_stops_the_call(plan):
    watch = Watch("voxelize", lambda: signal.raise_signal(signal.SIGINT))
    previous = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            plan.build(progress=watch)
    finally:
        signal.signal(signal.SIGINT, previous)
    assert watch.calls[-1] == watch.calls[[stage for stage, _ in watch.calls].index("voxelize")]


def test_a_callback_may_not_use_its_device_but_may_close_its_plan(device, torus):
    with device.plan(torus, 3, need=svocl.Need.NONE) as plan:
        for use in (lambda: device.name, lambda: plan.info, lambda: plan.build()):
            with pytest.raises(RuntimeError, match="a callback may not use the device whose call it is in"):
                plan.build(progress=Watch("voxelize", use))
        with svocl.Device() as other:
            watch = Watch("voxelize", lambda: bool(other.plan(torus, 2, progress=Watch("grid", False)).close()))
            plan.build(progress=watch).close()
            watch.check()
        with plan.build(progress=Watch("voxelize", plan.close)) as tree:
            assert tree.info.leaf_count > 0
    assert plan.closed and not plan._native._pointer


def test_threads_keep_their_exceptions_apart(torus):
    meet = threading.Barrier(2, timeout=60)
    caught = {}

    def work(name):
        def report(_stage, _fraction):
            meet.wait()  # both are in their calls: each has given the GIL back
            raise Stop(name)

        with svocl.Device() as device:
            try:
                device.plan(torus, 2, progress=report)
            except Exception as problem:
                caught[name] = problem

    threads = [threading.Thread(target=work, args=(name,)) for name in ("one", "two")]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert {name: (type(problem), str(problem)) for name, problem in caught.items()} == {
        "one": (Stop, "one"),
        "two": (Stop, "two"),
    }


def test_what_is_no_progress_is_refused(device, torus, plan):
    for wrong in (1, "tqdm", []):
        words = f"progress: {type(wrong).__name__}, expected a callable, True or False"
        for call in (
            lambda: device.plan(torus, 3, progress=wrong),
            lambda: device.build(torus, 3, progress=wrong),
            lambda: plan.build(progress=wrong),
            lambda: plan.count(progress=wrong),
        ):
            with pytest.raises(TypeError, match=words):
                call()
    with pytest.raises(TypeError, match="progress: the callable returned str, expected None or bool"):
        device.plan(torus, 3, progress=lambda stage, fraction: "go on")
    with pytest.raises(TypeError, match="positional argument"):
        device.plan(torus, 3, progress=lambda fraction: None)


def test_a_bar_of_tqdm(device, torus, plan, capsys):
    pytest.importorskip("tqdm")
    with device.build(torus, 4, progress=True) as tree:
        assert tree.info.leaf_count > 0
    printed = capsys.readouterr()
    lines = printed.err.replace("\n", "\r").split("\r")
    bars = [line for line in lines if line.strip()]
    assert printed.out == "" and "  0%|" in bars[0] and "100%|" in bars[-1], bars
    assert bars[-1].split()[0] in STAGES and printed.err.count("\n") == 1  # one bar for both calls
    with device.plan(torus, 4, progress=True) as own:
        own.build().close()
        assert capsys.readouterr().err.count("100%|") >= 2
    with pytest.raises(svocl.InvalidArgumentError):
        device.plan(torus, 17, progress=True)
    assert "100%|" not in capsys.readouterr().err


def test_without_tqdm(device, torus, plan, monkeypatch):
    for name in ("tqdm", "tqdm.auto"):
        monkeypatch.setitem(sys.modules, name, None)
    words = r"progress=True shows a bar of tqdm: .*; install it \(pip install tqdm\), or give a callable"
    for call in (
        lambda: device.plan(torus, 3, progress=True),
        lambda: device.build(torus, 3, progress=True),
        lambda: plan.build(progress=True),
    ):
        with pytest.raises(ImportError, match=words):
            call()
    watch = Watch()
    device.plan(torus, 3, progress=watch).close()
    watch.check()
