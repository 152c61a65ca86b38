# SPDX-License-Identifier: MIT
"""Dask's scheduler and workers as real processes, and the command that uses them, for tests of svocl.distributed."""

import json
import os
import signal
import subprocess
import sys
import time

import pytest
import shapes

import svocl

DEPTH = 6
PART_BYTES = 200 << 10
FAULTS = os.path.join(os.path.dirname(__file__), "worker_faults.py")
SECONDS = 300  # of a busy machine
"""Every wait of the tests ends."""

long = pytest.mark.skipif("SVOCL_LONG_TESTS" not in os.environ, reason="long: run by `tools/dev long`")


def write_torus(path):
    """A mesh file, .obj."""
    positions, indices = shapes.torus(48, 24)
    lines = ["v {} {} {}".format(*place) for place in positions]
    lines += ["f {} {} {}".format(*(triangle + 1)) for triangle in indices]
    path.write_text("\n".join(lines) + "\n")
    return path


class Pool:
    """A scheduler and its workers, ended with the test."""

    def __init__(self, folder, address=None):
        self.folder, self.address, self.processes = folder, address, []
        self.options = []  # of schedulers and workers
        self.environment = dict(os.environ)
        self.environment["DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES"] = "1"
        self.environment["DASK_DISTRIBUTED__SCHEDULER__WORKER_SATURATION"] = "1.0"
        self.environment["DASK_TEMPORARY_DIRECTORY"] = str(folder)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for process in self.processes:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGCONT)
                os.killpg(process.pid, signal.SIGKILL)
            process.wait(SECONDS)

    def _start(self, command, fault="", within=()):
        environment = dict(self.environment, SVOCL_FAULT=fault)
        with open(self.folder / f"log{len(self.processes)}", "w") as log:
            command = [*within, sys.executable, "-m", *command, "--no-dashboard", *self.options]
            self.processes.append(
                subprocess.Popen(
                    command, stdout=log, stderr=log, env=environment, cwd=self.folder, start_new_session=True
                )
            )
        return self.processes[-1]

    def scheduler(self, host="127.0.0.1", ttl="30s"):
        """ttl: after so long without a word from a worker it is given up, but never before 5 s."""
        self.environment["DASK_DISTRIBUTED__SCHEDULER__WORKER_TTL"] = ttl
        file = self.folder / f"scheduler{len(self.processes)}.json"
        command = ["distributed.cli.dask_scheduler", "--host", host, "--port", "0", "--scheduler-file", str(file)]
        process = self._start(command)
        end = time.monotonic() + SECONDS
        while not file.exists() or not file.read_text().endswith("}"):
            assert time.monotonic() < end and process.poll() is None, "the scheduler does not start"
            time.sleep(0.02)
        self.address = json.loads(file.read_text())["address"]
        return process

    def worker(self, fault="", nanny=False, within=()):
        command = ["distributed.cli.dask_worker", self.address, "--nthreads", "1", "--memory-limit", "0"]
        command += ["--preload", FAULTS, "--nanny" if nanny else "--no-nanny"]
        return self._start(command, fault, within)


def start(mesh_file, path, *options):
    """The command; finish() waits for it."""
    command = [sys.executable, "-m", "svocl.distributed", str(mesh_file), "-d", str(DEPTH), "-o", str(path)]
    command += ["--max-memory", str(PART_BYTES), "--json", *options]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def finish(process):
    try:
        output, errors = process.communicate(timeout=SECONDS)
    finally:
        process.kill()
    print(errors)
    return process.returncode, json.loads(output) if output else None, errors


def run(*arguments):
    return finish(start(*arguments))


def expect_tree(path, whole):
    with svocl.Tree.load(path) as tree:
        assert tree.hash() == whole
    assert not os.path.exists(f"{path}.parts")
