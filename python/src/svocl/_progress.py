# SPDX-License-Identifier: MIT
"""Progress of plans and builds: what the argument `progress` may be, and how a call gets it.

The library has the callback for the time of one call alone, so that what its user pointer names need not live longer.
"""

import contextlib
import importlib
from collections.abc import Iterator
from typing import Any, Callable, Optional, Union

from ._native import ffi, lib

Function = Callable[[str, float], Optional[bool]]
Progress = Union[bool, Function]


def check(progress: Any) -> None:
    """Raises what `opened` would raise, before any work."""
    if progress is True:
        _tqdm()
    elif progress is not None and progress is not False and not callable(progress):
        raise TypeError(f"progress: {type(progress).__name__}, expected a callable, True or False")


@contextlib.contextmanager
def opened(progress: Optional[Progress]) -> Iterator[Optional[Function]]:
    """The function that a call reports to, or None; a bar of tqdm is closed at the end."""
    check(progress)
    if progress is None or progress is False:
        yield None
    elif progress is True:
        with _tqdm()(total=1.0, miniters=0, bar_format="{desc:<9} {percentage:3.0f}%|{bar}| {elapsed}") as bar:

            def show(stage: str, fraction: float) -> None:
                bar.set_description_str(stage, refresh=False)
                bar.update(fraction - bar.n)

            yield show
    else:
        yield progress


def part(function: Optional[Function], begin: float, end: float) -> Optional[Function]:
    """For one of several calls: 0 .. 1 of it is begin .. end of all."""
    if function is None:
        return None
    whole = function
    return lambda stage, fraction: whole(stage, begin * (1 - fraction) + end * fraction)


def reporting(call: Callable[..., int], function: Optional[Function]) -> Callable[..., int]:
    """A call on a plan that exists, with its progress. Under the guard."""
    if function is None:
        return call
    user = ffi.new_handle(function)

    def reported(plan: Any, *arguments: Any) -> int:
        lib.svo_plan_set_progress(plan, lib.svocl_python_progress, user)
        try:
            return call(plan, *arguments)
        finally:
            lib.svo_plan_set_progress(plan, ffi.NULL, ffi.NULL)

    return reported


def _tqdm() -> Any:
    try:
        return importlib.import_module("tqdm.auto").tqdm
    except ImportError as problem:
        raise ImportError(
            f"progress=True shows a bar of tqdm: {problem}; install it (pip install tqdm), or give a callable"
        ) from problem
