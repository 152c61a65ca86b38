# SPDX-License-Identifier: MIT
"""Planning by workers: each step's tasks are futures, and what no worker can do is done here."""

import asyncio
import importlib
import time
import uuid
import warnings
from typing import Any, Callable, Optional

from .._device import Device
from .._parts import Parts, PartsPlanning
from . import _tasks
from ._run import Interrupted

RENEW_SECONDS = 10
"""Between two renewals of the planner's lease."""


def plan_parts(
    client: Any,
    planning: PartsPlanning,
    device: Device,
    *,
    worker_device: Optional[str] = None,
    patience: float = 900.0,
    report: Optional[Callable[[str], None]] = None,
) -> Parts:
    """Does the tasks of a planning by workers that see the mesh and the folder, and finishes it.

    Args:
        client: a distributed.Client.
        planning: of a mesh and a folder whose paths are absolute.
        device: does the tasks that workers cannot do.
        worker_device: a part of "platform: device" for all workers; a worker's environment, SVOCL_DEVICE, goes first.
        patience: seconds in which no task is done, after which the job ends.
        report: called with lines about what happened.

    Raises:
        Interrupted: the scheduler is gone, or patience is over.
        Error: what this process cannot do either.
    """
    say = report or (lambda line: None)
    told = False
    while count := planning.task_count():
        tasks = [planning.task(index) for index in range(count)]
        for index, planned in _do_all(client, planning, tasks, worker_device, patience):
            result = planned.result
            if planned.failure:
                if not told:
                    say(f"{planned.worker}: {planned.failure}; this process plans in its place")
                told = True
                result = PartsPlanning.work(device, tasks[index])
            planning.take(index, result)
    return planning.finish()


def _do_all(client: Any, planning: PartsPlanning, tasks: list[bytes], device: Optional[str], patience: float) -> Any:
    """Yields (index, Planned) as they arrive."""
    futures: dict[str, int] = {}
    completed = importlib.import_module("distributed").as_completed(loop=client.loop)
    arrival = renewal = time.monotonic()
    try:
        for index, task in enumerate(tasks):
            with warnings.catch_warnings():
                warnings.filterwarnings("ignore", "Sending large graph")
                key = f"svocl_plan-{index}-{uuid.uuid4().hex}"
                future = client.submit(_tasks.plan_range, task, device, key=key, pure=False)
            futures[future.key] = index
            completed.add(future)
        while futures:
            batch = completed.next_batch(block=False)
            for future in batch:
                if future.status == "cancelled":
                    raise Interrupted("the connection to the scheduler is lost while parts are planned")
                if future.status not in ("finished", "error"):
                    completed.add(future)  # the worker died with the result, and another makes it again
                    continue
                arrival = time.monotonic()
                yield futures.pop(future.key), _result_of(future, patience)
                future.release()
            if time.monotonic() - arrival > patience:
                raise Interrupted(f"no task of the plan was done for {patience:g} s")
            if time.monotonic() - renewal > RENEW_SECONDS:
                renewal = time.monotonic()
                planning.task_count()
            if not batch:
                time.sleep(0.005)
    finally:
        for future in list(completed.futures):
            future.release()


def _result_of(future: Any, patience: float) -> _tasks.Planned:
    try:
        planned: _tasks.Planned = future.result(timeout=patience)
        return planned
    except (asyncio.CancelledError, asyncio.TimeoutError, OSError) as problem:
        raise Interrupted("the connection to the scheduler is lost while parts are planned") from problem
    except Exception as problem:  # Dask's: a task returns its failures
        return _tasks.Planned("Dask", failure=f"{type(problem).__name__}: {problem}")
