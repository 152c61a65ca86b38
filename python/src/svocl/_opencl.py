# SPDX-License-Identifier: MIT
"""OpenCL objects of the caller's: those of pyopencl, or addresses.

pyopencl is not imported. Its wheels carry an OpenCL loader of their own, svocl uses the system's; objects of one work
with the other, since OpenCL's calls go to the driver through the object itself.
"""

import contextlib
from collections.abc import Iterable, Sequence
from typing import Any, Callable

from . import _arrays
from ._generated import CLError, Status
from ._native import ffi, lib

# By C type: the class of pyopencl, or a base of it.
_CLASSES = {
    "cl_context": "Context",
    "cl_device_id": "Device",
    "cl_command_queue": "CommandQueue",
    "cl_mem": "MemoryObjectHolder",
    "cl_event": "Event",
    "cl_kernel": "Kernel",
}


def pointer(kind: str, value: Any, name: str) -> Any:
    """The C pointer of an OpenCL object; NULL for None.

    Args:
        kind: "cl_context", ...
        value: an object of pyopencl, an address (the object's int_ptr), or None.
        name: of the argument, for messages.
    """
    if value is None:
        return ffi.NULL
    if isinstance(value, int) and not isinstance(value, bool):
        address = value
    elif any(base.__name__ == _CLASSES[kind] for base in type(value).__mro__) and hasattr(value, "int_ptr"):
        address = value.int_ptr
    else:
        raise TypeError(f"{name}: {type(value).__name__}, expected pyopencl.{_CLASSES[kind]} or its int_ptr")
    if not 0 < address < 2 ** (8 * ffi.sizeof("void *")):
        raise ValueError(f"{name}: {address} is not the address of an OpenCL object")
    return ffi.cast(kind, address)


class Event:
    """The event of an enqueued call. It releases itself: keep it, or what pyopencl.Event.from_int_ptr(event.int_ptr)
    makes of it, as long as something waits for it. It can stand in wait_for."""

    def __init__(self, event: Any) -> None:
        self._event = event

    @property
    def int_ptr(self) -> int:
        """The cl_event, which stays this object's: pyopencl.Event.from_int_ptr(event.int_ptr) retains it."""
        return int(ffi.cast("uintptr_t", self._event))

    def wait(self) -> None:
        """Waits until the call's work has ended.

        Raises:
            CLError: it has failed.
        """
        status = int(lib.clWaitForEvents(1, ffi.new("cl_event *", self._event)))
        if status != 0:
            raise CLError(f"Event.wait: clWaitForEvents returns {status}", Status.CL_ERROR)

    def __del__(self) -> None:
        # At the interpreter's end, the loader may be gone, and the process frees the rest.
        with contextlib.suppress(Exception):
            lib.clReleaseEvent(self._event)


def submit_to(queue: Any) -> Any:
    """An svo_submit for a call that waits anyhow; queue: None is the device's own."""
    return ffi.new("svo_submit *", {"queue": pointer("cl_command_queue", queue, "queue")})


def submit(run: Callable[..., None], arguments: Iterable[Any], queue: Any, wait_for: Iterable[Any]) -> Event:
    """Calls run(arguments..., submit), which does not wait.

    Returns:
        The event of its commands.
    """
    cl_queue = pointer("cl_command_queue", queue, "queue")
    number, waits = events(wait_for)
    event = ffi.new("cl_event *")
    run(*arguments, ffi.new("svo_submit *", {"queue": cl_queue, "num_wait": number, "wait": waits, "event": event}))
    return Event(event[0])


def _array(**fields: Any) -> Any:
    """An svo_array. As an argument a dict would not do: cffi leaves the other fields undefined."""
    return ffi.new("svo_array *", fields)[0]


def in_host(memory: Any) -> Any:
    """The svo_array of host memory, which must stay alive."""
    return _array(host=memory)


def enqueue(
    run: Callable[..., None], buffers: Iterable[Any], count: int, flags: Iterable[Any], queue: Any, wait_for: Any
) -> Event:
    """Calls run(arrays..., count, flags..., submit) for a batch in device buffers.

    Returns:
        The event of the batch.
    """
    arrays = [_array(buffer=pointer("cl_mem", buffer, "buffer")) for buffer in buffers]
    return submit(run, (*arrays, _arrays.integer("count", count, 64), *flags), queue, wait_for)


def wait(run: Callable[..., None], arrays: Sequence[_arrays.Array], flags: Iterable[Any], queue: Any) -> None:
    """Calls run(arrays..., count, flags..., submit) for a batch in host arrays, for which it waits."""
    hosts = [in_host(ffi.cast("void *", array.ctypes.data)) for array in arrays]
    run(*hosts, arrays[0].size, *flags, submit_to(queue))


def of_target(target: Callable[..., Any], function: Callable[..., Any]) -> Callable[..., Any]:
    """A function of an svo_target as one of the handle that target makes it of."""
    return lambda handle, *arguments: function(target(handle), *arguments)


def events(wait_for: Iterable[Any]) -> tuple[int, Any]:
    """The number of events and their C array, NULL for none."""
    pointers = [pointer("cl_event", event, "wait_for") for event in wait_for]
    return len(pointers), ffi.new("cl_event[]", pointers) if pointers else ffi.NULL
