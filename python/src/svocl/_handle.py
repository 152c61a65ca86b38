# SPDX-License-Identifier: MIT
"""Ownership of the library's handles.

A native handle lives as long as something uses it: the Python object that stands for it, the arrays that look into its
memory, and the handles that were made from it. Nothing depends on the order in which Python collects them.

The library lets one thread at a time use a device and what was made from it. A Guard sees to that, since calls release
the GIL.
"""

import contextlib
import threading
from collections import deque
from collections.abc import Iterator
from typing import Any, Callable, Optional, TypeVar

import numpy as np

from ._callbacks import call
from ._errors import error, text
from ._native import ffi, lib

_Self = TypeVar("_Self", bound="Handle")


class Guard:
    """A lock for a device and all that was made from it.

    Handles are destroyed under the lock too. A collector may find them on any thread, also while that thread holds the
    lock; so `later` never waits: what cannot run at once runs when the lock is released.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._owner: Optional[int] = None
        self._late: deque[Callable[[], None]] = deque()

    def __enter__(self) -> "Guard":
        if self._owner == threading.get_ident():
            raise RuntimeError("svocl: a callback may not use the device whose call it is in")
        self._lock.acquire()
        self._owner = threading.get_ident()
        return self

    def __exit__(self, *_: Any) -> None:
        self._owner = None
        self._lock.release()
        self._run_late()

    def later(self, function: Callable[[], None]) -> None:
        """Runs a function under the lock, now or when the lock is released."""
        self._late.append(function)
        self._run_late()

    def _run_late(self) -> None:
        while self._late and self._lock.acquire(blocking=False):
            self._owner = threading.get_ident()
            try:
                while self._late:
                    self._late.popleft()()
            finally:
                self._owner = None
                self._lock.release()


class Native:
    """A native handle, destroyed when its last holder has dropped it.

    Args:
        stays: arrays in its memory stay as long as the handle, so that numpy may look into them.
    """

    def __init__(
        self,
        pointer: Any,
        destroy: Callable[[Any], None],
        guard: Guard,
        parent: Optional["Native"],
        *,
        stays: bool = True,
    ) -> None:
        self.guard: Guard = guard
        self.stays = stays
        self.parent: Optional[Native] = None
        self._parent_hold: Optional[object] = None
        self._pointer: list[Any] = [pointer]
        self._destroy = destroy
        self._holds: set[object] = set()
        if parent is not None:
            self.set_parent(parent)

    def set_parent(self, parent: "Native") -> None:
        """Keeps the parent alive in place of the one before, and uses its guard from now on."""
        before, hold = self.parent, self._parent_hold
        self.parent = parent
        self._parent_hold = parent.hold()
        self.guard = parent.guard
        if before is not None:
            before.drop(hold)

    def lend(self, pointer: Any) -> "Native":
        """A handle of what this one owns and may replace, on the same device: until end(), it keeps this one alive.
        Under the guard."""
        hold = self.hold()
        return Native(pointer, lambda _: self.drop(hold), self.guard, self.parent, stays=False)

    @property
    def ended(self) -> bool:
        """What it stood for is gone."""
        return not self._pointer

    def end(self) -> None:
        """Destroys what it stands for now, whoever holds it. Under the guard."""
        if self._pointer:
            self._destroy(self._pointer.pop())

    def hold(self) -> object:
        """Keeps the handle alive until drop(); returns what drop() takes. Under the guard, or by the first holder."""
        hold = object()
        self._holds.add(hold)
        return hold

    def drop(self, hold: object) -> None:
        """Ends a hold."""
        self._holds.discard(hold)
        if not self._holds:
            self.guard.later(self._destroy_unheld)

    def _destroy_unheld(self) -> None:
        if self._holds:
            return
        self.end()
        hold, self._parent_hold = self._parent_hold, None
        if self.parent is not None and hold is not None:
            self.parent.drop(hold)

    @contextlib.contextmanager
    def use(self, what: str) -> Iterator[Any]:
        """The pointer, under the guard."""
        while True:
            guard = self.guard
            with guard:
                if guard is self.guard:
                    if not self._pointer:
                        raise ValueError(f"{what} is closed")
                    yield self._pointer[0]
                    return

    def device_message(self) -> str:
        """The message of the last failure; under the guard. "" without a device."""
        device = self
        while device.parent is not None:
            device = device.parent
        if device._pointer and ffi.typeof(device._pointer[0]) is ffi.typeof("svo_device *"):
            return text(lib.svo_device_message(device._pointer[0]))
        return ""


class Handle:
    """Base of Device, Plan, Tree and all others: closed by close(), by `with` or with its last reference."""

    _native: Native
    _hold: Optional[object] = None

    def _open(self, native: Native) -> None:
        self._native = native
        self._hold = native.hold()

    def close(self) -> None:
        """Ends the use of the handle. Its memory is freed once nothing else that was made from it is in use: arrays
        stay valid, and so does a tree whose device is closed. Closing again does nothing."""
        hold, self._hold = self._hold, None
        if hold is not None:
            self._native.drop(hold)

    @property
    def closed(self) -> bool:
        """Whether close() was called, or the owner of what it stands for has replaced it (Moving.tree)."""
        return self._hold is None or self._native.ended

    def __enter__(self: _Self) -> _Self:
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()

    def __del__(self) -> None:
        # At the interpreter's end, what close() needs may be gone, and the process frees the rest.
        with contextlib.suppress(Exception):
            self.close()

    @contextlib.contextmanager
    def _use(self) -> Iterator[Any]:
        what = type(self).__name__
        if self._hold is None:
            raise ValueError(f"{what} is closed")
        with self._native.use(what) as pointer:
            yield pointer

    def _call(self, function: Callable[..., int], *arguments: Any, undo: Optional[Callable[[], Any]] = None) -> None:
        """Calls function(pointer, *arguments), see _callbacks.call; raises the status that it returns."""
        with self._called(function, *arguments, undo=undo):
            pass

    @contextlib.contextmanager
    def _called(self, function: Callable[..., int], *arguments: Any, undo: Any = None) -> Iterator[None]:
        """As _call; under the guard until the end of the block, in which what was made is taken over."""
        with self._use() as pointer:
            status = call(function, pointer, *arguments, undo=undo)
            if status != lib.SVO_OK:
                raise error(status, self._native.device_message())
            yield


class DeviceHandle(Handle):
    """Base of Device alone, for modules that Device itself needs."""


class View:
    """An array in native memory, for numpy.asarray: keeps that memory alive as long as numpy looks into it."""

    def __init__(self, native: Native, address: int, dtype: "np.dtype[Any]", shape: Any) -> None:
        self._native = native
        self._hold = native.hold()
        # The last number is the version of the interface. Native arrays are never written to.
        self.__array_interface__ = {"shape": shape, "typestr": dtype.str, "data": (address, True), "version": 3}

    def __del__(self) -> None:
        with contextlib.suppress(Exception):
            self._native.drop(self._hold)


def view(native: Native, pointer: Any, dtype: Any, shape: Any) -> "Optional[np.ndarray[Any, Any]]":
    """A read-only array over native memory, without a copy where that stays; None for NULL. Under the guard."""
    if pointer == ffi.NULL:
        return None
    kind = np.dtype(dtype)
    if 0 in shape:
        return np.empty(shape, kind)
    if not native.stays:
        count = int(np.prod(shape))
        copy = np.frombuffer(ffi.buffer(pointer, count * kind.itemsize), kind).reshape(shape).copy()
        copy.flags.writeable = False
        return copy
    return np.asarray(View(native, int(ffi.cast("uintptr_t", pointer)), kind, shape))
