# SPDX-License-Identifier: MIT
"""Calls into the library, and the Python functions that the library calls back meanwhile.

Callbacks run on the thread that made the call. cffi releases the GIL for the call and takes it for each callback. An
exception cannot pass through C: it is kept and raised when the call returns. A further callback is a declaration in
native/make_binding.py and a function here, decorated with _callback; what belongs to one call reaches it through the
callback's user pointer (ffi.new_handle). Functions for host memory (svo_memory_callbacks) are left out: drivers may
call them on threads of their own, and a Python function for each block would cost more than the block.
"""

import logging
import threading
from typing import Any, Callable, Optional

import numpy as np

from ._errors import text
from ._native import ffi, lib

logger = logging.getLogger("svocl")
logger.addHandler(logging.NullHandler())

_LEVELS = {
    lib.SVO_LOG_ERROR: logging.ERROR,
    lib.SVO_LOG_WARNING: logging.WARNING,
    lib.SVO_LOG_INFO: logging.INFO,
}


class _Raised(threading.local):
    """The first exception of a callback during this thread's call."""

    exception: Any = None


_raised = _Raised()


def _keep(_kind: Any, exception: Any, traceback: Any) -> None:
    if _raised.exception is None:
        _raised.exception = exception.with_traceback(traceback)


def _callback(after_exception: Any = None) -> Callable[[Callable[..., Any]], Any]:
    """Makes a function that native/make_binding.py declares `extern "Python"`.

    Args:
        after_exception: what the function returns to the library when it raises.
    """
    decorator: Callable[[Callable[..., Any]], Any] = ffi.def_extern(onerror=_keep, error=after_exception)
    return decorator


@_callback()
def svocl_python_log(_user: Any, level: int, message: Any) -> None:
    logger.log(_LEVELS.get(level, logging.INFO), "%s", text(message))


@_callback(after_exception=1)
def svocl_python_progress(user: Any, stage: int, fraction: float) -> int:
    return _stops(ffi.from_handle(user)(text(lib.svo_name(lib.SVO_NAME_STAGE, stage)), fraction))


@_callback(after_exception=1)
def svocl_python_fraction(user: Any, fraction: float) -> int:
    return _stops(ffi.from_handle(user)(fraction))


if hasattr(lib, "svo_voxels_load_parts"):  # of svocl::io

    @_callback(after_exception=lib.SVO_CANCELED)
    def svocl_python_voxel_part(user: Any, part: Any) -> int:
        ffi.from_handle(user)(part)
        return int(lib.SVO_OK)


def _stops(stop: Any) -> int:
    if stop is not None and not isinstance(stop, (bool, np.bool_)):
        raise TypeError(f"progress: the callable returned {type(stop).__name__}, expected None or bool")
    return int(stop is not None and bool(stop))


def call(function: Callable[..., Any], *arguments: Any, undo: Optional[Callable[[], Any]] = None) -> Any:
    """Calls a function of the library; raises what a callback raised meanwhile.

    Args:
        undo: called before that, to destroy a handle that the function has made nevertheless.
    """
    outer, _raised.exception = _raised.exception, None  # a callback may be in a call of its own
    try:
        result = function(*arguments)
    finally:
        inner, _raised.exception = _raised.exception, outer
    if inner is not None:
        if undo is not None:
            undo()
        raise inner
    return result
