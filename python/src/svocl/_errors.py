# SPDX-License-Identifier: MIT
"""Statuses of the library as exceptions: one class a status, each with .status and the library's words."""

import importlib
from typing import Any

from ._generated import ERRORS, Error, Status
from ._native import ffi, lib


def error(status: int, message: str = "") -> Error:
    """The exception of a status that is not Status.OK; without a message, with the meaning of the status."""
    known = Status(status)
    return ERRORS[known](message or text(lib.svo_name(lib.SVO_NAME_STATUS_TEXT, status)), known)


def text(chars: Any) -> str:
    """A C string as str. Names of files and devices may be any bytes: those that are not UTF-8 come escaped."""
    return str(ffi.string(chars).decode("utf-8", "backslashreplace")) if chars != ffi.NULL else ""


def optional(module: str, what: str, package: str) -> Any:
    """A module of a package that svocl does without, for what it is needed for."""
    try:
        return importlib.import_module(module)
    except ImportError as problem:
        raise ImportError(f"{what} needs {package}: {problem} (pip install {package})") from problem
