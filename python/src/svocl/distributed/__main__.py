# SPDX-License-Identifier: MIT
"""python -m svocl.distributed: a mesh to a .svo file by workers of a Dask cluster.

Exit codes are those of `svocl parts`: 0, 1 where no other try can succeed, 2 for wrong usage, 75 where the same command
goes on from what is there, and 130 after Ctrl-C.
"""

import argparse
import contextlib
import errno
import importlib
import json
import logging
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from typing import Any, NoReturn, Optional

import svocl

from .._parts import FILE_DEPTH_MAX, FILE_NODES_MAX
from ._plan import plan_parts, stitch_parts
from ._run import Interrupted, Refused, Summary, build_parts
from ._security import check_address, is_refused, make_security
from ._steps import Clock
from ._store import Places, is_url, without_file_scheme
from ._tasks import PASSING, worker_ttl

DONE, FAILED, WRONG_USAGE, TRY_AGAIN, STOPPED = 0, 1, 2, 75, 130
NAME = "svocl.distributed"
CLOSE_SECONDS = 10
RANGE_BYTES = 16 << 20
"""Of a mesh file, for which a task of planning is worth it."""
SHARE_BYTES = 32 << 20
"""Of parts, for which a share of the file is worth a task."""
PASSING_ERRORS = (errno.ENOSPC, errno.EDQUOT, errno.EIO, errno.ESTALE, errno.ETIMEDOUT, errno.EMFILE, errno.ENFILE)
"""Of files that Python writes: a later try may succeed."""
SETTINGS: dict[str, Any] = {
    "distributed.scheduler.worker-ttl": ("5 minutes", "30s"),
    "distributed.scheduler.worker-saturation": (1.1, 1.0),
}
"""Of schedulers that are started here, after Dask's own: a worker that has stopped is given up sooner, and parts wait
at the scheduler, not at workers that may die."""


class Failed(Exception):
    """A job's end in words, with the exit code."""

    def __init__(self, code: int, words: str) -> None:
        super().__init__(words)
        self.code = code


def main() -> int:
    options = read_options()
    signal.signal(signal.SIGTERM, lambda number, frame: stop())
    try:
        return run(options)
    except Failed as problem:
        return fail(problem.code, str(problem))
    except Interrupted as problem:
        return fail(TRY_AGAIN, str(problem))
    except Refused as problem:
        return fail(FAILED, str(problem))
    except svocl.Error as problem:
        return fail(TRY_AGAIN if isinstance(problem, PASSING) else FAILED, str(problem))
    except OSError as problem:
        return fail(TRY_AGAIN if problem.errno in PASSING_ERRORS else FAILED, str(problem))
    except KeyboardInterrupt:
        return fail(STOPPED, "stopped; the same command goes on from the parts that are there")


def run(options: argparse.Namespace) -> int:
    times: dict[str, float] = {}
    report = Report(options.quiet)
    steps = Steps()
    with contextlib.ExitStack() as opened, contextlib.closing(report):
        pool = Pool(options, opened, report, times)
        places = Places(options.output, options.parts, options.scratch, opened)
        folder = places.folder
        is_new = not os.path.exists(folder)
        opened.enter_context(svocl.Parts.lease(folder))
        with measured(times, "plan"), places.planning(report.line):
            parts = opened.enter_context(plan_all(options, places, pool, report, steps))
            check_nodes(options, parts, is_new)
            places.publish(parts)
        with parts:
            steps.note("triangles", bytes_of_triangles(parts))
            with measured(times, "build"):
                summary = build(options, parts, pool.client(), report, steps, places)
            steps.note("parts", bytes_of_parts(parts))
            with measured(times, "stitch"):
                if not options.parts_only:
                    finish(options, parts, pool.client(), report, steps, places)
                    steps.note("file", os.path.getsize(places.output))
                    places.put_output()
        if not options.keep and not options.parts_only:
            places.remove()
    if options.times:
        steps.save(options.times, times)
    tell(options, summary, times)
    return DONE


# --- the steps --------------------------------------------------------------------------------------------------------


def ranges_of(options: argparse.Namespace) -> int:
    """How many ranges of the mesh are worth a task; the library says whether the file can be read by ranges."""
    if options.no_shared_folder or not options.mesh.lower().endswith((".ply", ".stl")):
        return 1
    try:
        bytes_of_mesh = os.path.getsize(options.mesh)
    except OSError:
        return 1  # it is said by who reads it
    return options.ranges or max(1, bytes_of_mesh // RANGE_BYTES)


def plan_options(options: argparse.Namespace) -> dict[str, Any]:
    need = svocl.Need.DEFAULT
    for name in options.need or ():
        need |= svocl.Need[name.upper().replace("-", "_")]
    return {
        "need": need,
        "coverage": svocl.Coverage[options.coverage.upper().replace("-", "_")],
        "weights": svocl.Weights[options.weights.upper()],
    }


def plan_all(
    options: argparse.Namespace, places: Places, pool: "Pool", report: "Report", steps: "Steps"
) -> svocl.Parts:
    """Fills the folder: by workers, where it is worth it and they can see it, else in this process."""
    most_ranges = 1 if places.stored else ranges_of(options)
    parts = None
    if most_ranges > 1:
        parts = plan_by_workers(options, places.folder, pool.client(), most_ranges, report, steps)
    if parts is None:
        with Clock(steps.add, "plan 1"):
            parts = plan(options, places.folder)
    return parts


def plan(options: argparse.Namespace, folder: str) -> svocl.Parts:
    """Fills the folder in this process. Generated meshes are the program's."""
    if options.mesh.startswith("scene:"):
        plan_by_program(options, folder)
        return svocl.Parts(folder)
    with svocl.Device(options.device) as device:
        return svocl.Parts.create_from_file(
            device, options.mesh, options.depth, folder, max_bytes=options.max_memory, **plan_options(options)
        )


def plan_by_workers(
    options: argparse.Namespace, folder: str, client: Any, most_ranges: int, report: "Report", steps: "Steps"
) -> Optional[svocl.Parts]:
    """Fills the folder by workers, where the mesh can be read by ranges; None: it cannot."""
    threads = sum(client.ncores().values())
    ranges = options.ranges or max(1, min(most_ranges, 2 * threads))
    places = (os.path.abspath(options.mesh), options.depth, os.path.abspath(folder))
    with svocl.Device(options.device) as device:
        try:
            planning = svocl.PartsPlanning(device, *places, options.max_memory, ranges, **plan_options(options))
        except svocl.UnsupportedError:
            return None
        steps.note("mesh", os.path.getsize(options.mesh))
        with planning:
            return plan_parts(
                client,
                planning,
                device,
                worker_device=options.device,
                patience=options.patience,
                report=report.line,
                record=steps.add,
            )


def plan_by_program(options: argparse.Namespace, folder: str) -> None:
    program = shutil.which(options.program)
    if not folder.endswith(".parts"):
        raise Failed(WRONG_USAGE, f"{folder}: the folder of parts of a generated mesh has a name that ends in .parts")
    if program is None:
        raise Failed(WRONG_USAGE, f"{options.mesh}: generated meshes need the program {options.program}; see --program")
    command = [program, "parts", "plan", options.mesh, "-d", str(options.depth), "-o", folder[:-6], "--quiet"]
    command += ["--coverage", options.coverage, "--weights", options.weights]
    command += ["--max-memory", str(options.max_memory)] if options.max_memory else []
    command += ["--need", ",".join(options.need)] if options.need else []
    command += ["--device", options.device] if options.device else []
    done = subprocess.run(command, stdin=subprocess.DEVNULL)
    if done.returncode != 0:
        raise Failed(done.returncode if done.returncode > 0 else FAILED, f"this failed: {' '.join(command)}")


def check_nodes(options: argparse.Namespace, parts: svocl.Parts, is_new: bool) -> None:
    """A tree that cannot be stitched is refused before its parts are built."""
    if options.parts_only or (parts.expected_nodes <= FILE_NODES_MAX and options.depth <= FILE_DEPTH_MAX):
        return
    if is_new:
        svocl.Parts.remove(parts.folder)
    raise Failed(
        FAILED,
        f"{options.mesh}: about {parts.expected_nodes:.0f} nodes are expected at depth {options.depth}; a .svo file "
        f"has at most 2^32 - 2 nodes and depth {FILE_DEPTH_MAX}; --parts-only builds a folder, which svocl.PartsTree "
        "reads as a tree in itself",
    )


def bytes_of_parts(parts: svocl.Parts) -> int:
    return sum(entry.stat().st_size for entry in os.scandir(parts.folder) if entry.name.endswith(".part"))


def bytes_of_triangles(parts: svocl.Parts) -> int:
    place = os.path.join(parts.folder, parts.identity)
    return sum(entry.stat().st_size for entry in os.scandir(place) if entry.name.endswith(".tri"))


def shares_of(options: argparse.Namespace, parts: svocl.Parts, client: Any, places: Places) -> int:
    """How many shares of the file workers write; 1: this process writes all."""
    is_beside = os.stat(parts.folder).st_dev == os.stat(os.path.dirname(os.path.realpath(places.output))).st_dev
    if options.no_shared_folder or places.stored or not is_beside:
        return 1
    threads = sum(client.ncores().values())
    return int(options.shares or max(1, min(bytes_of_parts(parts) // SHARE_BYTES, 2 * threads)))


def finish(
    options: argparse.Namespace,
    parts: svocl.Parts,
    client: Any,
    report: "Report",
    steps: "Steps",
    places: Places,
) -> None:
    """Stitches. What is missing or damaged by then is built by the next try."""
    try:
        shares = shares_of(options, parts, client, places)
        if shares == 1:
            with Clock(steps.add, "stitch"):
                parts.finish(places.output)
        else:
            stitch_parts(
                client,
                parts,
                places.output,
                shares,
                patience=options.patience,
                report=report.line,
                record=steps.add,
            )
    except (svocl.FileError, svocl.FileDamagedError) as problem:
        missing = [index for index in range(len(parts)) if not parts.is_built(index)]
        if not missing:
            raise
        places.discard(parts, missing)
        raise Interrupted(f"{problem}; the same command builds it") from problem


def build(
    options: argparse.Namespace,
    parts: svocl.Parts,
    client: Any,
    report: "Report",
    steps: "Steps",
    places: Places,
) -> Summary:
    """Builds. Triangles that are damaged or missing by then are written by the next try."""
    try:
        return build_parts(
            client,
            parts,
            shared_folder=not options.no_shared_folder,
            device=options.device,
            patience=options.patience,
            report=report.parts,
            record=steps.add,
            stored=places.stored,
        )
    except Refused as problem:
        if "planning the parts again" not in str(problem):
            raise
        raise Interrupted(f"{problem}; the same command does so") from problem


@contextlib.contextmanager
def measured(times: dict[str, float], name: str) -> Iterator[None]:
    begin = time.perf_counter()
    yield
    times[name] = time.perf_counter() - begin


class Steps:
    """The times of all tasks by steps of the job, and bytes of its files: what svocl.distributed.model reads."""

    def __init__(self) -> None:
        self.tasks: dict[str, list[tuple[float, float]]] = {}
        self.bytes: dict[str, int] = {}

    def add(self, name: str, seconds: float, cpu_seconds: float) -> None:
        self.tasks.setdefault(name, []).append((seconds, cpu_seconds))

    def note(self, name: str, count: int) -> None:
        self.bytes[name] = count

    def save(self, path: str, times: dict[str, float]) -> None:
        with open(path, "w") as file:
            json.dump({"tasks": self.tasks, "bytes": self.bytes, "seconds": times}, file)


# --- the cluster ------------------------------------------------------------------------------------------------------


class Pool:
    """The client of the workers, which are there from when it is first asked for until the job's end."""

    def __init__(
        self, options: argparse.Namespace, opened: contextlib.ExitStack, report: "Report", times: dict[str, float]
    ) -> None:
        self.options, self.opened, self.report, self.times = options, opened, report, times
        self.security = security_of(options)
        self.connected: Any = None

    def client(self) -> Any:
        if self.connected is None:
            with measured(self.times, "start"):
                self.connected = self.opened.enter_context(connected(self.options, self.security))
            self.connected.subscribe_topic("all", self.report.event)
            self.opened.callback(self.connected.unsubscribe_topic, "all")
            warn_of_ttl(self.connected, self.report)
        return self.connected


@contextlib.contextmanager
def connected(options: argparse.Namespace, security: Any) -> Iterator[Any]:
    """A client of the scheduler that was given, or of one with workers on this machine."""
    distributed = import_extra("distributed")
    with contextlib.ExitStack() as opened:
        address = options.scheduler
        if address is None:
            cluster = start_cluster(distributed, options, security)
            opened.callback(cluster.close, timeout=CLOSE_SECONDS)
            address = cluster.scheduler_address
        try:
            client = distributed.Client(
                address, timeout=options.connect_timeout, set_as_default=False, security=security
            )
        except (OSError, ValueError) as problem:
            code = FAILED if is_refused(problem) else TRY_AGAIN
            raise Failed(code, f"no scheduler answers at {address}: {problem}") from problem
        opened.callback(client.close, timeout=CLOSE_SECONDS)
        yield client


def security_of(options: argparse.Namespace) -> Any:
    """The distributed.Security of all connections; None: there are no certificates."""
    import_extra("distributed")
    try:
        if options.scheduler is not None:
            check_address(options.scheduler, options.insecure)
        return make_security(options.tls_ca, options.tls_cert, options.tls_key, options.scheduler)
    except ValueError as problem:
        raise Failed(WRONG_USAGE, str(problem)) from problem


def start_cluster(distributed: Any, options: argparse.Namespace, security: Any) -> Any:
    """Workers as processes. Dask's limit of memory would kill workers in the midst of parts; --max-memory bounds
    those."""
    config = import_extra("dask.config")
    for name, (usual, value) in SETTINGS.items():
        if config.get(name) == usual:  # else someone chose it
            config.set({name: value})
    return distributed.LocalCluster(
        n_workers=options.workers or max(1, (os.cpu_count() or 1) // options.threads),
        threads_per_worker=options.threads,
        processes=True,
        memory_limit=0,
        dashboard_address=options.dashboard or "127.0.0.1:0",  # not 8787, which another scheduler may have
        silence_logs=logging.CRITICAL,
        security=security,
        protocol="tls://" if security else "tcp://",
    )


def warn_of_ttl(client: Any, report: "Report") -> None:
    """A scheduler of others keeps its settings; what they mean here is said."""
    seconds = client.run_on_scheduler(worker_ttl)
    if seconds is None or seconds > 60:
        after = "never gives up a worker" if seconds is None else f"gives up a worker after {seconds:g} s"
        report.line(f"the scheduler {after} that has stopped; DASK_DISTRIBUTED__SCHEDULER__WORKER_TTL=30s sets that")


# --- what is shown ----------------------------------------------------------------------------------------------------


class Report:
    """A bar on standard error, and lines above it."""

    def __init__(self, quiet: bool) -> None:
        self.quiet = quiet
        self.bar: Any = None

    def line(self, text: str) -> None:
        if not self.quiet:
            tqdm().write(f"{NAME}: {text}", file=sys.stderr)

    def parts(self, there: int, count: int, line: str) -> None:
        if line:
            self.line(line)
        if self.bar is None and not self.quiet:
            # The parts that are there before the first is built tell nothing about the speed.
            self.bar = tqdm()(total=count, initial=there, unit="part", file=sys.stderr, dynamic_ncols=True)
        if self.bar is not None:
            self.bar.update(there - self.bar.n)

    def event(self, event: Any) -> None:
        """What the scheduler says of its workers."""
        message = event[1]
        if isinstance(message, dict) and message.get("action") == "remove-worker" and message.get("processing-tasks"):
            self.line(f"the worker {message.get('worker')} is gone; what it had is built by others")

    def close(self) -> None:
        if self.bar is not None:
            self.bar.close()


def tqdm() -> Any:
    return import_extra("tqdm").tqdm


def import_extra(name: str) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError as problem:
        raise Failed(FAILED, f"{problem}; pip install 'svocl[distributed]'") from problem


def tell(options: argparse.Namespace, summary: Summary, times: dict[str, float]) -> None:
    busiest = max((share.seconds for share in summary.workers.values()), default=0.0)
    model = times["plan"] + busiest + times["stitch"]
    if options.json:
        workers = [{"worker": name, **share._asdict()} for name, share in sorted(summary.workers.items())]
        document = {"parts": summary.parts, "kept": summary.kept, "workers": workers}
        document.update({f"{name}_seconds": seconds for name, seconds in times.items()})
        print(json.dumps({**document, "model_seconds": model}))
    elif not options.quiet:
        took = ", ".join(f"{name} {seconds:.2f} s" for name, seconds in times.items())
        made = options.parts if options.parts_only else options.output
        print(f"{made}: {summary.parts} parts, {summary.kept} of them kept, {len(summary.workers)} workers")
        print(f"{took}; plan, busiest worker and stitch {model:.2f} s")


def fail(code: int, words: str) -> int:
    for line in words.splitlines():
        print(f"{NAME}: {line}", file=sys.stderr)
    return code


def stop() -> NoReturn:
    raise KeyboardInterrupt


# --- options ----------------------------------------------------------------------------------------------------------


def read_bytes(text: str) -> int:
    """65536, 512M, 4G."""
    found = re.fullmatch(r"(\d+)([KMGT]?)", text)
    if not found:
        raise argparse.ArgumentTypeError(f"'{text}' is not a number of bytes such as 65536, 512M or 4G")
    return int(found[1]) << 10 * " KMGT".index(found[2] or " ")


def read_needs(text: str) -> list[str]:
    known = [need.name.lower().replace("_", "-") for need in svocl.Need if need.name not in (None, "DEFAULT")]
    for name in text.split(","):
        if name not in known:
            raise argparse.ArgumentTypeError(f"'{name}' is none of {', '.join(known)}")
    return text.split(",")


def read_count(text: str) -> int:
    if not text.isdecimal() or int(text) == 0:
        raise argparse.ArgumentTypeError(f"'{text}' is not a number from 1 on")
    return int(text)


def read_options(arguments: Optional[list[str]] = None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog=f"python -m {NAME}",
        description="Builds a sparse voxel octree in parts on Dask's distributed scheduler.",
        epilog="exit code 75: the same command goes on from the parts that are there",
    )
    add = parser.add_argument
    add("mesh", metavar="MESH", help="mesh file, or scene:NAME[:SIZE] where the program svocl is installed")
    add("-d", "--depth", type=read_count, required=True, help="of the tree, 1 to 16; 20 with --parts-only")
    add("-o", "--output", required=True, metavar="OUT.svo", help="the file, by name or by URL: s3://BUCKET/OUT.svo")
    add("--parts", metavar="FOLDER", help="where parts lie until the end, by name or by URL (OUT.svo.parts)")
    add("--scratch", metavar="FOLDER", help="on a disk, for this machine's copy of what has a URL ($TMPDIR)")
    add("--scheduler", metavar="ADDRESS", help="tls://HOST:8786 (workers are started on this machine)")
    add("--tls-ca", metavar="FILE", help="PEM file of who signs the certificates of all (Dask's settings)")
    add("--tls-cert", metavar="FILE", help="PEM file with this command's certificate, and maybe its key")
    add("--tls-key", metavar="FILE", help="PEM file with the certificate's key")
    add("--insecure", action="store_true", help="accept a scheduler beyond this machine without certificates")
    add(
        "--workers",
        type=read_count,
        metavar="N",
        help="without --scheduler: workers to start (as threads fit the cores)",
    )
    add("--threads", type=read_count, default=1, metavar="N", help="without --scheduler: threads of each worker (1)")
    add("--dashboard", metavar=":PORT", help="without --scheduler: Dask's dashboard (none); needs bokeh")
    add("--max-memory", type=read_bytes, default=0, metavar="BYTES", help="of one part: 65536, 512M, 4G")
    add("--ranges", type=read_count, default=0, metavar="N", help="ranges of the mesh file that workers plan by "
        "(as its size and the workers ask for)")  # fmt: skip
    add("--shares", type=read_count, default=0, metavar="N", help="shares of the file that workers write side by side "
        "(as its size and the workers ask for)")  # fmt: skip
    add("--times", metavar="FILE", help="write the times of all tasks, for python -m svocl.distributed.model")
    add("--no-shared-folder", action="store_true", help="send triangles to workers and take parts back as bytes, "
        "also where a worker sees the folder")  # fmt: skip
    add("--need", type=read_needs, metavar="LIST", help="comma-separated: color, normal, rays, material, fill, ...")
    add("--coverage", choices=("half-open", "closed", "thin"), default="half-open")
    add("--weights", choices=("area", "uniform", "center"), default="area")
    add("--device", metavar="NAME", help="a part of 'platform: device'; SVOCL_DEVICE of a worker goes first")
    add(
        "--patience",
        type=float,
        default=900.0,
        metavar="S",
        help="seconds without a part after which the job ends (900)",
    )
    add("--connect-timeout", type=float, default=30.0, metavar="S", help="seconds to wait for the scheduler (30)")
    add("--program", default="svocl", metavar="SVOCL", help="the program that makes scene:NAME")
    add("--keep", action="store_true", help="keep OUT.svo.parts")
    add("--parts-only", action="store_true", help="build OUT.svo.parts, which is a tree in itself, and no OUT.svo; for "
        "trees of more than 2^32 - 2 nodes")  # fmt: skip
    add("--json", action="store_true", help="print times and workers as JSON")
    add("-q", "--quiet", action="store_true", help="no bar and no lines but errors")
    options = parser.parse_args(arguments)
    options.output = without_file_scheme(options.output)
    options.parts = without_file_scheme(options.parts or f"{options.output}.parts")
    for url in (options.output, options.parts):
        if url.startswith("memory://"):
            parser.error(f"{url}: workers are other processes, which do not see this one's memory")
    if options.parts_only and is_url(options.parts):
        parser.error(f"{options.parts}: a folder that is to be read as a tree must be on a disk")
    return options


if __name__ == "__main__":
    sys.exit(main())
