# SPDX-License-Identifier: MIT
"""How long a job of python -m svocl.distributed takes with other numbers of workers, from the times of one run.

    python -m svocl.distributed model.ply -d 12 -o model.svo --workers 1 --ranges 256 --shares 256 --times times.json
    python -m svocl.distributed.model times.json --workers 1,2,64,1000 --bandwidth 2G

A job is a sequence of steps: what each does by tasks, it does after the step before it, and what the command does
itself, it does alone:

    plan 1    bounds of the vertices                         ranges of the mesh file
    plan 2    triangles by coarse cells                      ranges; then the cut, by the command
    plan 3    triangles to their parts                       ranges; then tails and the switch of plans, by the command
    build     the parts' trees                               parts, the largest first; a worker's first takes longer by
                                                             what it takes to open the device and to load the kernels
    stitch    the file                                       shares; before them the levels above the parts and the
                                                             layout, after them the head, by the command

A worker takes the next task when it is done with one, and waits for it meanwhile: the latency of a task is what the run
took beside its tasks, by their number. The engine hands over tasks one at a time. A storage moves bytes
at a rate that all workers share. So the time of a step is that of its schedule, of the engine or of the storage,
whichever is longest, and then that of the command. Tasks are those of the run: more workers than a step has tasks wait.
"""

import argparse
import heapq
import json
import re
import sys
from collections.abc import Sequence
from typing import Any, NamedTuple

ENGINE_SECONDS = 0.0005
"""Of Dask's scheduler and the command, for a task."""
READS = {
    "plan 1": {"mesh": 0.5},
    "plan 2": {"mesh": 1.0},
    "plan 3": {"mesh": 1.0, "triangles": 1.0},
    "build": {"triangles": 1.0, "parts": 1.0},
    "stitch": {"parts": 2.0, "file": 1.0},
}
"""How many times the bytes of which files a step moves. Vertices are about half of a PLY file, or less."""


class Step(NamedTuple):
    """A step of the job."""

    name: str
    tasks: Sequence[float]
    """Seconds of each."""
    own: float
    """Seconds of the command."""
    bytes: float
    """That are read and written."""
    start: float = 0.0
    """Seconds of each worker, before its first task."""


class Estimate(NamedTuple):
    """The time of a job."""

    seconds: float
    steps: dict[str, float]
    """Seconds of each step."""
    bounds: dict[str, str]
    """What each step waits for: "tasks" that are shared evenly, "one task", the "engine", the "storage", "command"."""


def read_steps(document: dict[str, Any], cpu: bool = False) -> list[Step]:
    """The steps of a run.

    Args:
        document: of the file that --times wrote.
        cpu: CPU seconds in place of seconds: for machines with other work.
    """
    column = 1 if cpu else 0
    found = document["tasks"]
    steps = []
    for name, moved in READS.items():
        tasks = [times[column] for times in found.get(name, [])]
        first = [times[column] for times in found.get(f"first {name}", [])]
        mean = sum(tasks) / len(tasks) if tasks else 0.0
        start = max(0.0, sum(first) / len(first) - mean) if first else 0.0
        tasks += [mean or start] * len(first)
        own = sum(times[column] for times in found.get(f"own {name}", []))
        count = sum(times * document["bytes"].get(kind, 0) for kind, times in moved.items())
        if tasks or own:
            steps.append(Step(name, sorted(tasks, reverse=True) if name == "build" else tasks, own, count, start))
    return steps


def read_latency(document: dict[str, Any]) -> float:
    """Seconds that the worker of a run with one worker waited for a task; 0: it is not known."""
    took: float = sum(document.get("seconds", {}).get(name, 0.0) for name in ("plan", "build", "stitch"))
    found = document["tasks"]
    count = sum(len(times) for name, times in found.items() if not name.startswith("own "))
    used: float = sum(seconds for times in found.values() for seconds, _ in times)
    return max(0.0, took - used) / max(1, count)


def makespan(tasks: Sequence[float], workers: int, latency: float = 0.0) -> float:
    """The end of tasks that workers take one after the other."""
    ends = [0.0] * min(workers, max(1, len(tasks)))
    for seconds in tasks:
        heapq.heapreplace(ends, ends[0] + seconds + latency)
    return max(ends)


def estimate(
    steps: Sequence[Step],
    workers: int,
    bandwidth: float = 0.0,
    engine: float = ENGINE_SECONDS,
    latency: float = 0.0,
) -> Estimate:
    """The time of a job with a number of workers.

    Args:
        steps: of read_steps.
        workers: of one thread each.
        bandwidth: of the storage, bytes a second; 0: no limit.
        engine: seconds that the scheduler takes for a task.
        latency: seconds that a worker waits for a task.
    """
    seconds, bounds = {}, {}
    for step in steps:
        even = sum(step.tasks) / workers
        waits = {
            "tasks": step.start + makespan(step.tasks, workers, latency),
            "engine": engine * len(step.tasks),
            "storage": step.bytes / bandwidth if bandwidth else 0.0,
        }
        bound = max(waits, key=lambda name: waits[name])
        seconds[step.name] = waits[bound] + step.own
        uneven = bound == "tasks" and waits[bound] > 1.25 * even
        bounds[step.name] = "command" if step.own > waits[bound] else "one task" if uneven else bound
    return Estimate(sum(seconds.values()), seconds, bounds)


def main() -> int:
    options = read_options()
    with open(options.times) as file:
        document = json.load(file)
    steps = read_steps(document, options.cpu)
    latency = read_latency(document) if options.latency is None and not options.cpu else options.latency or 0.0
    alone = estimate(steps, 1, options.bandwidth, options.engine, latency)
    print("| workers | time, s | speedup | " + " | ".join(f"{step.name}, s" for step in steps) + " | waits for |")
    print("| ---: | ---: | ---: |" + " ---: |" * len(steps) + " --- |")
    for workers in options.workers:
        one = estimate(steps, workers, options.bandwidth, options.engine, latency)
        slowest = max(one.steps, key=lambda name: one.steps[name])
        times = " | ".join(f"{one.steps[step.name]:.2f}" for step in steps)
        row = f"{workers:,} | {one.seconds:.2f} | {alone.seconds / one.seconds:.1f} | {times}"
        print(f"| {row} | {slowest}: {one.bounds[slowest]} |")
    return 0


def read_rate(text: str) -> float:
    """65536, 512M, 4G."""
    found = re.fullmatch(r"(\d+)([KMGT]?)", text)
    if not found:
        raise argparse.ArgumentTypeError(f"'{text}' is not a number of bytes such as 65536, 512M or 4G")
    return float(int(found[1]) << 10 * " KMGT".index(found[2] or " "))


def read_workers(text: str) -> list[int]:
    if not re.fullmatch(r"[1-9]\d*(,[1-9]\d*)*", text):
        raise argparse.ArgumentTypeError(f"'{text}' is not a list such as 1,2,64")
    return [int(number) for number in text.split(",")]


def read_options(arguments: Any = None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m svocl.distributed.model", description="Estimates a job with other numbers of workers."
    )
    add = parser.add_argument
    add("times", metavar="FILE", help="of --times of a run of python -m svocl.distributed with one worker")
    add("--workers", type=read_workers, default=[1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1000], metavar="LIST")
    add("--bandwidth", type=read_rate, default=0.0, metavar="BYTES", help="of the storage, a second (no limit)")
    add("--engine", type=float, default=ENGINE_SECONDS, metavar="S", help=f"of a task ({ENGINE_SECONDS:g})")
    add("--latency", type=float, metavar="S", help="of a task (as in the run; with --cpu 0)")
    add("--cpu", action="store_true", help="from CPU seconds, for a run on a machine that had other work")
    return parser.parse_args(arguments)


if __name__ == "__main__":
    sys.exit(main())
