# SPDX-License-Identifier: MIT
"""Steps of many tasks: each is a future, and their results come as they arrive."""

import asyncio
import importlib
import time
import uuid
import warnings
from collections.abc import Iterator
from typing import Any, Callable, Optional

from . import _tasks
from ._run import Interrupted

RENEW_SECONDS = 10
"""Between two calls that keep a lease alive."""

Record = Callable[[str, float, float], None]
"""Called with a step of the job, and the seconds and CPU seconds of one of its tasks. What this process does itself has
a name that begins with "own "."""


class Clock:
    """Measures what this process does itself in a step."""

    def __init__(self, record: Optional[Record], name: str) -> None:
        self.record, self.name = record, name

    def __enter__(self) -> None:
        self.begin, self.begin_cpu = time.perf_counter(), time.thread_time()

    def __exit__(self, *_: Any) -> None:
        if self.record is not None:
            self.record(f"own {self.name}", time.perf_counter() - self.begin, time.thread_time() - self.begin_cpu)


def do_all(
    client: Any,
    function: Callable[..., _tasks.Done],
    arguments: list[tuple[Any, ...]],
    patience: float,
    renew: Optional[Callable[[], Any]] = None,
) -> Iterator[tuple[int, _tasks.Done]]:
    """Yields the results of function for each of the arguments, with their indices, in any order. A result whose worker
    died is made again by another.

    Args:
        client: a distributed.Client.
        patience: seconds in which no task is done, after which the job ends.
        renew: called now and then.

    Raises:
        Interrupted: the scheduler is gone, or patience is over.
    """
    futures: dict[str, int] = {}
    completed = importlib.import_module("distributed").as_completed(loop=client.loop)
    arrival = renewal = time.monotonic()
    try:
        for index, values in enumerate(arguments):
            with warnings.catch_warnings():
                warnings.filterwarnings("ignore", "Sending large graph")
                key = f"svocl_{function.__name__}-{index}-{uuid.uuid4().hex}"
                future = client.submit(function, *values, key=key, pure=False)
            futures[future.key] = index
            completed.add(future)
        while futures:
            batch = completed.next_batch(block=False)
            for future in batch:
                if future.status == "cancelled":
                    raise lost()
                if future.status not in ("finished", "error"):
                    completed.add(future)  # the worker died with the result, and another makes it again
                    continue
                arrival = time.monotonic()
                yield futures.pop(future.key), result_of(future, patience)
                future.release()
            if time.monotonic() - arrival > patience:
                raise Interrupted(f"no task was done for {patience:g} s; the same command goes on")
            if renew is not None and time.monotonic() - renewal > RENEW_SECONDS:
                renewal = time.monotonic()
                renew()
            if not batch:
                time.sleep(0.005)
    finally:
        for future in list(completed.futures):
            future.release()


def lost() -> Interrupted:
    return Interrupted("the connection to the scheduler is lost; the same command goes on from what is there")


def result_of(future: Any, patience: float) -> _tasks.Done:
    try:
        done: _tasks.Done = future.result(timeout=patience)
        return done
    except (asyncio.CancelledError, asyncio.TimeoutError, OSError) as problem:
        raise lost() from problem
    except Exception as problem:  # Dask's: a task returns its failures
        return _tasks.Done("Dask", failure=f"{type(problem).__name__}: {problem}")
