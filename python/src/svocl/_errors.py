# SPDX-License-Identifier: MIT
"""Statuses of the library as exceptions: one class a status, each with .status and the library's words."""

from typing import Any

from ._enums import Status
from ._native import ffi, lib


class Error(Exception):
    """A call into the library failed. str() is the library's message: function, argument, value and limit.

    Attributes:
        status: the Status that the call returned.
    """

    status: Status

    def __init__(self, message: str, status: Status) -> None:
        super().__init__(message)
        self.status = status

    def __reduce__(self) -> Any:
        return type(self), (str(self), self.status)


class InvalidArgumentError(Error, ValueError):
    """An argument is outside its documented range."""


class OutOfHostMemoryError(Error, MemoryError):
    """The host is out of memory."""


class OutOfDeviceMemoryError(Error, MemoryError):
    """A buffer does not fit the device."""


class NoDeviceError(Error):
    """No OpenCL platform or device fits."""


class NoGLError(Error):
    """No OpenGL context of the asked kind can be made."""


class UnsupportedError(Error):
    """The device or the context cannot do what was asked."""


class CompileError(Error):
    """A kernel or a shader does not compile. The build log goes to the logger "svocl"."""


class CLError(Error):
    """An OpenCL call failed."""


class GLError(Error):
    """An OpenGL call failed."""


class CapacityExceededError(Error):
    """A capacity is too small; the message has the exact need."""


class FileError(Error, OSError):
    """A file cannot be opened, read or written."""

    def __str__(self) -> str:
        return Exception.__str__(self)


class FileDamagedError(Error, ValueError):
    """A file is truncated, damaged or of another format."""


class ImportFailedError(Error):
    """A mesh file cannot be read."""


class InternalError(Error):
    """An invariant of the library does not hold."""


class CanceledError(Error):
    """The progress callback stopped the call. What a callback raises comes out itself."""


class NotOnDeviceError(InvalidArgumentError):
    """The tree is not on a device; upload it first."""


_CLASSES: dict[Status, type[Error]] = {
    Status.INVALID_ARGUMENT: InvalidArgumentError,
    Status.OUT_OF_HOST_MEMORY: OutOfHostMemoryError,
    Status.OUT_OF_DEVICE_MEMORY: OutOfDeviceMemoryError,
    Status.NO_DEVICE: NoDeviceError,
    Status.NO_GL: NoGLError,
    Status.UNSUPPORTED: UnsupportedError,
    Status.COMPILE_FAILED: CompileError,
    Status.CL_ERROR: CLError,
    Status.GL_ERROR: GLError,
    Status.CAPACITY_EXCEEDED: CapacityExceededError,
    Status.FILE_ERROR: FileError,
    Status.FILE_DAMAGED: FileDamagedError,
    Status.IMPORT_FAILED: ImportFailedError,
    Status.INTERNAL: InternalError,
    Status.CANCELED: CanceledError,
    Status.NOT_ON_DEVICE: NotOnDeviceError,
}


def error(status: int, message: str = "") -> Error:
    """The exception of a status that is not Status.OK; without a message, with the meaning of the status."""
    known = Status(status)
    return _CLASSES[known](message or text(lib.svo_status_text(status)), known)


def text(chars: Any) -> str:
    """A C string as str. Names of files and devices may be any bytes: those that are not UTF-8 come escaped."""
    return str(ffi.string(chars).decode("utf-8", "backslashreplace")) if chars != ffi.NULL else ""
