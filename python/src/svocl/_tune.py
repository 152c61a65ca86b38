# SPDX-License-Identifier: MIT
"""Settings that suit a mesh: runs the program's ``svocl tune``."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class TuneSetting:
    """A setting that was found."""

    command: str
    """the command line that does it"""
    c: str
    """the options of the C library"""
    time_ms: float
    """median of its rounds, with queries"""
    time_low_ms: float
    time_high_ms: float
    """95 % interval of the median"""
    memory_bytes: int
    """the most on the device at one time"""
    note: str
    """what the options of C do and the command does not; empty: it does all"""


@dataclass(frozen=True)
class TuneResult:
    """What ``tune`` found out."""

    answer: TuneSetting | None
    """None: no setting keeps the bounds, or none is given"""
    second: TuneSetting | None
    sure: float
    """share of resampled sweeps in which the answer wins"""
    near: float
    """share in which it is within 5 % of what wins"""
    fresh: dict[str, float]
    """measures of the answer on points that chose nothing"""
    document: dict[str, Any]
    """all that was measured, as ``svocl tune --json`` prints it"""


def _join(values: Mapping[str, Sequence[object] | object | None]) -> str:
    """ "depth:7+8,coverage": names with values, and names alone where there are None."""
    parts = []
    for name, value in values.items():
        listed = value if isinstance(value, (list, tuple, range)) else [value]
        parts.append(name if value is None else f"{name}:" + "+".join(str(one) for one in listed))
    return ",".join(parts)


def _setting(found: Mapping[str, Any] | None) -> TuneSetting | None:
    if found is None:
        return None
    return TuneSetting(
        found["command"],
        found["c"],
        found["time_ms"],
        found["time_low_ms"],
        found["time_high_ms"],
        int(found["memory_bytes"]),
        found["note"],
    )


def tune(
    source: str | os.PathLike[str],
    *,
    error: Mapping[str, float | None] | None = None,
    free: Mapping[str, Sequence[object] | object | None] | None = None,
    time_s: float | None = None,
    memory_bytes: int | None = None,
    queries: int | None = None,
    need: Sequence[str] | None = None,
    lights: str | os.PathLike[str] | None = None,
    exhaustive: bool = False,
    page: str | os.PathLike[str] | None = None,
    csv: str | os.PathLike[str] | None = None,
    resume: str | os.PathLike[str] | None = None,
    program: str = "svocl",
    options: Sequence[str] = (),
) -> TuneResult:
    """Finds the settings of least time within bounds, or of least error below a time.

    source: what the program takes as INPUT: a mesh file, or "scene:statue". error: bounds by the names of measures;
    None in place of one number: that measure is to be the least. free: what may vary, {"depth": [7, 8], "coverage":
    None}; None means all values. time_s: seconds; memory_bytes: on the device. queries: gathered points or rays that
    count in times. need: what all trees hold, ["color", "rays"]; None: normals and colors, and what bounds ask for.
    lights: a file, as ``svocl gather`` takes it; None: a sun and a sky. page, csv, resume: files. program: the program
    or its path. options: further ones of the command line. Raises RuntimeError with the program's line on failure.
    """
    path = shutil.which(program)
    if path is None:
        raise RuntimeError(f"tune: {program} is not installed (Debian: apt install svocl svocl-lab)")
    line = [path, "tune", os.fspath(source), "--json", "--quiet", *options]
    named = {
        "--error": _join(error) if error else None,
        "--free": _join(free) if free else None,
        "--time": f"{time_s!r}s" if time_s is not None else None,
        "--memory": str(memory_bytes) if memory_bytes is not None else None,
        "--queries": str(queries) if queries is not None else None,
        "--need": ",".join(need) or "none" if need is not None else None,
        "--lights": lights,
        "--page": page,
        "--csv": csv,
        "--resume": resume,
    }
    for name, value in named.items():
        if value is not None:
            line += [name, os.fspath(value)]
    if exhaustive:
        line.append("--exhaustive")
    done = subprocess.run(line, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(done.stderr.strip() or f"tune: {program} ended with {done.returncode}")
    document = json.loads(done.stdout)
    return TuneResult(
        _setting(document["answer"]),
        _setting(document["second"]),
        document["sure"],
        document["within_5_percent"],
        document["fresh"],
        document,
    )
