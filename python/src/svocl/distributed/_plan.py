# SPDX-License-Identifier: MIT
"""Planning and stitching by workers: what no worker can do is done here."""

import os
from typing import Any, Callable, Optional

from .._device import Device
from .._parts import Parts, PartsPlanning
from . import _tasks
from ._steps import Clock, Record, do_all


def plan_parts(
    client: Any,
    planning: PartsPlanning,
    device: Device,
    *,
    worker_device: Optional[str] = None,
    patience: float = 900.0,
    report: Optional[Callable[[str], None]] = None,
    record: Optional[Record] = None,
) -> Parts:
    """Does the tasks of a planning by workers that see the mesh and the folder, and finishes it.

    Args:
        client: a distributed.Client.
        planning: of a mesh and a folder whose paths are absolute.
        device: does the tasks that workers cannot do.
        worker_device: a part of "platform: device" for all workers; a worker's environment, SVOCL_DEVICE, goes first.
        patience: seconds in which no task is done, after which the job ends.
        report: called with lines about what happened.
        record: called with each step's times.

    Raises:
        Interrupted: the scheduler is gone, or patience is over.
        Error: what this process cannot do either.
    """
    told = False
    step = 0
    while count := planning.task_count():
        step += 1
        tasks = [(planning.task(index), worker_device) for index in range(count)]
        for index, done in do_all(client, _tasks.plan_range, tasks, patience, planning.task_count):
            result = done.result
            if done.failure:
                if not told and report:
                    report(f"{done.worker}: {done.failure}; this process plans in its place")
                told = True
                result = PartsPlanning.work(device, tasks[index][0])
            elif record:
                record(f"plan {step}", done.seconds, done.cpu_seconds)
            with Clock(record, f"plan {step}"):
                planning.take(index, result)
    with Clock(record, f"plan {step}"):
        return planning.finish()


def stitch_parts(
    client: Any,
    parts: Parts,
    path: str,
    shares: int,
    *,
    patience: float = 900.0,
    report: Optional[Callable[[str], None]] = None,
    record: Optional[Record] = None,
) -> None:
    """Stitches by workers that see the folder, each of which writes shares of the file, and gives it its name.

    Args:
        client: a distributed.Client.
        parts: all of them built.
        path: on the file system of the folder.
        shares: to be written side by side.
        patience, report, record: see plan_parts.

    Raises:
        Interrupted: the scheduler is gone, or patience is over.
        Error: what this process cannot do either.
    """
    told = False
    folder = os.path.abspath(parts.folder)
    with Clock(record, "stitch"):
        parts.begin_shares(shares)
    tasks = [(folder, parts.identity, index, shares) for index in range(shares)]
    for index, done in do_all(client, _tasks.write_share, tasks, patience):
        if done.failure:
            if not told and report:
                report(f"{done.worker}: {done.failure}; this process writes in its place")
            told = True
            parts.write_share(index, shares)
        elif record:
            record("stitch", done.seconds, done.cpu_seconds)
    with Clock(record, "stitch"):
        parts.finish_shares(shares, path)
