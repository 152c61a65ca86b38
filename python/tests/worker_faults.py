# SPDX-License-Identifier: MIT
"""Preloaded into workers by test_distributed.py (dask worker --preload): what goes wrong there, and when.

SVOCL_FAULT has key=value pairs. at: the worker's part, from 1 on, or name: the part's name. signal: its number. pid:
the process that gets it, the worker by default. when: before, amid or after the part. once: a file; the first worker
that makes it gets the fault. damage: in place of a signal, the triangles of the part lose a byte. slow: seconds that
every part and every share takes longer. share: in place of at, the worker's share of the file, amid which it strikes.
"""

import glob
import os
import signal
import threading
import time

import svocl
from svocl.distributed import _tasks

_fault = dict(pair.split("=", 1) for pair in os.environ.get("SVOCL_FAULT", "").split())
# Dask loads a preloaded module twice.
_build = getattr(_tasks._build, "faultless", _tasks._build)
_count = 0


def _is_due(work):
    global _count
    _count += 1
    is_chosen = _fault.get("at") == str(_count) or _fault.get("name") == work.name
    if not is_chosen or not {"signal", "damage"} & set(_fault):
        return False
    try:
        if "once" in _fault:
            os.close(os.open(_fault["once"], os.O_CREAT | os.O_EXCL))
    except FileExistsError:
        return False
    return True


def _strike():
    os.kill(int(_fault.get("pid", os.getpid())), signal.Signals(int(_fault["signal"])))


def _faulty_build(work, folder):
    when = _fault.get("when", "before") if _is_due(work) else ""
    if when and "damage" in _fault:
        (path,) = glob.glob(os.path.join(glob.escape(folder), "*", f"{work.name}.tri"))
        os.truncate(path, os.path.getsize(path) - 1)
    elif when == "before":
        _strike()
    elif when == "amid":
        threading.Timer(0.005, _strike).start()
    built = _build(work, folder)
    time.sleep(float(_fault.get("slow", 0)))
    if when == "after":
        _strike()
    return built


_write_share = getattr(svocl.Parts.write_share, "faultless", svocl.Parts.write_share)
_shares = 0


def _faulty_write_share(self, index, count):
    global _shares
    _shares += 1
    if _fault.get("share") == str(_shares):
        threading.Timer(0.001, _strike).start()
        time.sleep(0.0005)
    _write_share(self, index, count)
    time.sleep(float(_fault.get("slow", 0)) + (1 if _fault.get("share") == str(_shares) else 0))


_faulty_write_share.faultless = _write_share
svocl.Parts.write_share = _faulty_write_share
_faulty_build.faultless = _build
_tasks._build = _faulty_build
