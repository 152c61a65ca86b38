# SPDX-License-Identifier: MIT
"""What trees and compact trees have in common: they are on a device, on the host, or both."""

import contextlib
import functools
from collections.abc import Iterable, Iterator
from typing import Any

from . import _opencl, _structs
from ._callbacks import call
from ._errors import error, text
from ._generated import InvalidArgumentError, Status
from ._handle import DeviceHandle, Handle, Native
from ._mesh import Path, need_io, to_path
from ._native import ffi, lib


class Resident(Handle):
    """Base of Tree and Compact."""

    _prefix: str
    """Of the library's functions: "svo_tree"."""
    _noun: str
    """For messages: "tree"."""

    @property
    def on_device(self) -> bool:
        """Whether it is on a device."""
        return self._native.parent is not None

    def upload(self, device: DeviceHandle, *, queue: Any = None) -> None:
        """Copies what is from a file to a device, for rays and pictures, and waits. On that device already: does
        nothing.

        Raises:
            InvalidArgumentError: it is on another device.
            OutOfDeviceMemoryError
        """
        cl_queue = _opencl.pointer("cl_command_queue", queue, "queue")
        if not isinstance(device, DeviceHandle):
            raise TypeError(f"device: {type(device).__name__}, expected svocl.Device")
        with device._use() as at:
            if not self.on_device:
                # Its own guard until now; from here on it is the device's.
                with self._use() as pointer:
                    status = call(self._function("upload"), pointer, at, cl_queue)
                    if status != lib.SVO_OK:
                        raise error(status, device._native.device_message())
                    self._native.set_parent(device._native)
            elif self._native.parent is not device._native:
                raise self._invalid("upload", "is on another device")

    def save(self, path: Path, *, compress: bool = False) -> None:
        """Writes a file, .svo of a tree and .svc of a compact tree, downloading first if need be. An existing file is
        replaced at once, or stays.

        Args:
            path: of the file.
            compress: zstd for each array that becomes smaller.

        Raises:
            FileError: the file cannot be written.
        """
        need_io(f"{type(self).__name__}.save")
        sink, _kept = to_path(path)
        options = _structs.new("svo_save_options")
        options.compress = bool(compress)
        message = ffi.new("svo_message *")
        with self._downloaded(None) as pointer:
            status = call(self._function("save"), pointer, sink, options, message)
            if status != lib.SVO_OK:
                raise error(status, text(message.text))

    def _function(self, name: str) -> Any:
        return getattr(lib, f"{self._prefix}_{name}")

    def _invalid(self, what: str, problem: str) -> InvalidArgumentError:
        message = f"{type(self).__name__}.{what}: the {self._noun} {problem}"
        return InvalidArgumentError(message, Status.INVALID_ARGUMENT)

    def _device_native(self, what: str) -> Native:
        """The device's handle, under the guard."""
        if self._native.parent is None:
            name = type(self).__name__
            raise self._invalid(what, f"is from a file and on no device; call {name}.upload first")
        return self._native.parent

    def _device_pointer(self, what: str) -> Any:
        """The device's pointer, under the guard."""
        return self._device_native(what)._pointer[0]

    def _device_call(self, what: str, function: Any, *arguments: Any) -> None:
        with self._use() as pointer:
            self._device_pointer(what)
            status = call(function, pointer, *arguments)
            if status != lib.SVO_OK:
                raise error(status, self._native.device_message())

    @contextlib.contextmanager
    def _downloaded(self, queue: Any) -> Iterator[Any]:
        """The pointer, under the guard, with host arrays."""
        cl_queue = _opencl.pointer("cl_command_queue", queue, "queue")
        with self._use() as pointer:
            status = call(self._function("download"), pointer, cl_queue) if self.on_device else lib.SVO_OK
            if status != lib.SVO_OK:
                raise error(status, self._native.device_message())
            yield pointer

    def _enqueue(
        self, what: str, function: Any, buffers: Any, count: int, flags: Any, queue: Any, wait_for: Iterable[Any]
    ) -> _opencl.Event:
        run = functools.partial(self._device_call, what, function)
        return _opencl.enqueue(run, buffers, count, flags, queue, wait_for)

    def _wait(self, what: str, function: Any, arrays: Any, flags: Any, queue: Any) -> None:
        run = functools.partial(self._device_call, what, function)
        _opencl.wait(run, arrays, flags, queue)

    def _of_target(self, function: Any) -> Any:
        """A function of an svo_target as one of the handle."""
        return _opencl.of_target(self._function("target"), function)
