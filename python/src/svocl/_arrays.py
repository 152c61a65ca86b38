# SPDX-License-Identifier: MIT
"""numpy arrays that go into the library: their types and shapes are checked here, since C cannot.

An array of the expected type that is C-contiguous is used as it is; any other that converts without a surprise is
copied. So are arrays of other packages in the host's memory, by __array_interface__, __array__ or DLPack. Lists and
tuples are converted by numpy.
"""

import operator
from collections.abc import Sequence
from typing import Any, Optional, Union

import numpy as np
import numpy.typing as npt

from ._native import ffi, lib

Array = npt.NDArray[Any]

ray_dtype: "np.dtype[np.void]" = np.dtype(
    [("origin", "<f4", (3,)), ("direction", "<f4", (3,)), ("t_min", "<f4"), ("t_max", "<f4")]
)
"""svo_ray, 32 bytes: origin + t * direction for t_min <= t <= t_max, in world coordinates."""

hit_dtype: "np.dtype[np.void]" = np.dtype(
    [("t", "<f4"), ("triangle", "<u4"), ("u", "<f4"), ("v", "<f4"), ("normal", "<f4", (3,)), ("count", "<u4")]
)
"""svo_hit, 32 bytes. No hit: t is infinite and triangle is NO_TRIANGLE."""

query_dtype: "np.dtype[np.void]" = np.dtype([("position", "<f4", (3,)), ("max_distance", "<f4")])
"""svo_query_point, 16 bytes."""

nearest_dtype: "np.dtype[np.void]" = np.dtype(
    [("distance", "<f4"), ("triangle", "<u4"), ("position", "<f4", (3,)), ("leaves", "<u4"), ("reserved", "<u4", (2,))]
)
"""svo_nearest, 32 bytes. None within max_distance: distance is infinite and triangle is NO_TRIANGLE."""

voxel_hit_dtype: "np.dtype[np.void]" = np.dtype(
    [("t", "<f4"), ("node", "<u4"), ("level", "<u4"), ("face", "<u4"), ("normal", "<f4", (3,)), ("steps", "<u4")]
)
"""svo_voxel_hit, 32 bytes. No hit: t is infinite and node is NO_NODE. face: 2 * axis, plus 1 for the high side; 6: the
ray begins inside."""

scene_hit_dtype: "np.dtype[np.void]" = np.dtype([*voxel_hit_dtype.descr, ("instance", "<u4")])
"""svo_scene_hit, 36 bytes: the hit in the instance's tree; normal and t are the world's. No hit: instance is
NO_INSTANCE."""

scene_triangle_hit_dtype: "np.dtype[np.void]" = np.dtype(
    [("t", "<f4"), ("triangle", "<u4"), ("u", "<f4"), ("v", "<f4"), ("normal", "<f4", (3,)), ("instance", "<u4")]
)
"""svo_scene_triangle_hit, 32 bytes. No hit: t is infinite, triangle is NO_TRIANGLE and instance is NO_INSTANCE."""

instance_dtype: "np.dtype[np.void]" = np.dtype([("tree", "<u4"), ("transform", "<f4", (3, 4))])
"""svo_instance, 52 bytes: world = transform * (x, y, z, 1), where x, y, z are in the tree's world coordinates."""

gather_point_dtype: "np.dtype[np.void]" = np.dtype(
    [
        ("position", "<f4", (3,)),
        ("normal", "<f4", (3,)),
        ("reflected", "<f4", (3,)),
        ("exponent", "<f4"),
        ("reserved", "<u4", (2,)),
    ]
)
"""svo_gather_point, 48 bytes: world coordinates. reflected: direction of the specular cone, zero for none; exponent: of
its lobe; reserved is 0."""

gather_result_dtype: "np.dtype[np.void]" = np.dtype(
    [
        ("openness", "<f4"),
        ("irradiance", "<f4", (3,)),
        ("specular", "<f4", (3,)),
        ("steps", "<u4"),
        ("direct", "<f4", (3,)),
        ("openness_error", "<f4"),
        ("irradiance_error", "<f4"),
        ("specular_error", "<f4"),
    ]
)
"""svo_gather_result, 56 bytes: ambient occlusion, 1 is open; linear red, green, blue; the steps of all cones or the
rays that were traced; standard errors, which cones do not know."""

probe_hit_dtype: "np.dtype[np.void]" = np.dtype(
    [
        ("t", "<f4"),
        ("state", "<u4"),
        ("texel", "<u4"),
        ("normal", "<u4"),
        ("radiance", "<f4", (3,)),
        ("visited", "<u4"),
    ]
)
"""svo_probe_hit, 32 bytes: state is 0 of a miss, 1 of a hit, 2 where no probe saw; normal as in a texel's word."""

probe_irradiance_dtype: "np.dtype[np.void]" = np.dtype([("irradiance", "<f4", (3,)), ("weight", "<f4")])
"""svo_probe_irradiance, 16 bytes: linear red, green, blue; weight 0: no probe sees the point."""

voxel_dtype: "np.dtype[np.void]" = np.dtype(
    [("x", "<i4"), ("y", "<i4"), ("z", "<i4"), ("rgba", "u1", (4,)), ("material", "<u2"), ("reserved", "<u2")]
)
"""svo_voxel, 20 bytes: coordinates within 2**30 of 0, color, and a material below 65535; reserved is 0."""

point_dtype: "np.dtype[np.void]" = np.dtype([("at", "<f8", (3,)), ("rgb", "<u2", (3,)), ("intensity", "<u2")])
"""svo_point, 32 bytes: a place, a color, and the intensity of returned light."""

NO_NODE: int = lib.SVO_NO_NODE
NO_INSTANCE: int = lib.SVO_NO_INSTANCE
NO_TRIANGLE: int = lib.SVO_NO_TRIANGLE

Shape = tuple[Union[int, str], ...]
"""An expected shape: a str stands for any length and names it."""


def _words(shape: Sequence[Union[int, str]]) -> str:
    return "(" + ", ".join(map(str, shape)) + ("," if len(shape) == 1 else "") + ")"


def _check_shape(name: str, array: Array, shape: Shape) -> None:
    fits = array.ndim == len(shape) and all(isinstance(e, str) or e == n for e, n in zip(shape, array.shape))
    if not fits:
        raise ValueError(f"{name}: shape {_words(array.shape)}, expected {_words(shape)}")


def taken(name: str, value: Any) -> Any:
    """The array of an object that has one, in its own type and without a copy where it has that; else the value."""
    if isinstance(value, (np.ndarray, np.generic)):
        return value
    try:
        if hasattr(value, "__array_interface__") or hasattr(value, "__array__"):
            return np.asarray(value)
        if hasattr(value, "__dlpack__"):
            return np.from_dlpack(value)
    except (TypeError, ValueError, RuntimeError, BufferError) as problem:
        raise TypeError(f"{name}: {type(value).__name__} is no array in the host's memory: {problem}") from None
    return value


def array(name: str, value: Any) -> Array:
    """As numpy converts it, and by DLPack."""
    return np.asarray(taken(name, value))


def _convert(name: str, value: Any, default: Any) -> Array:
    """value as an array; what is no array gets the default type."""
    value = taken(name, value)
    if isinstance(value, np.ndarray):
        return value
    try:
        array = np.asarray(value)
        if array.dtype.kind in "OUSV" or (array.dtype.kind == "f" and np.dtype(default).kind in "iu" and array.size):
            raise TypeError(f"{array.dtype} is not {np.dtype(default)}")
        return array if array.dtype.kind in "iu" else array.astype(default)
    except (TypeError, ValueError) as problem:
        raise TypeError(f"{name}: {type(value).__name__} is no array of {np.dtype(default)}: {problem}") from None


def floats(name: str, value: Any, shape: Shape, double: bool = False) -> Array:
    """float32 numbers, C-contiguous; float64 numbers are rounded, or stay as they are with double."""
    array = taken(name, value)
    if not isinstance(value, np.ndarray) and getattr(array, "dtype", None) not in (np.float32, np.float64):
        array = _convert(name, array, np.float64).astype(np.float64)
    _check_shape(name, array, shape)
    if array.dtype.kind != "f" or array.dtype.itemsize not in (4, 8):
        raise TypeError(f"{name}: dtype {array.dtype}, expected float32 or float64, of shape {_words(shape)}")
    wanted = np.float64 if double and array.dtype.itemsize == 8 else np.float32
    with np.errstate(over="ignore"):  # a double beyond float becomes infinite, which the library refuses
        return np.ascontiguousarray(array, dtype=wanted)


def integers(name: str, value: Any, dtype: Any, shape: Shape) -> Array:
    """Integers of one type, C-contiguous; those of another type are checked and copied."""
    array = _convert(name, value, dtype)
    wanted = np.dtype(dtype)
    _check_shape(name, array, shape)
    if array.dtype.kind not in "iu":
        raise TypeError(f"{name}: dtype {array.dtype}, expected {wanted}, of shape {_words(shape)}")
    if array.dtype != wanted and array.size:
        low, high = int(array.min()), int(array.max())
        least, limit = int(np.iinfo(wanted).min), int(np.iinfo(wanted).max)
        if low < least or high > limit:
            raise ValueError(f"{name}: {low if low < least else high} is not in {least} .. {limit}")
    return np.ascontiguousarray(array, dtype=wanted)


def records(name: str, value: Any, dtype: "np.dtype[Any]") -> Array:
    """Records of ray_dtype, query_dtype or gather_point_dtype, C-contiguous, from such an array or one of float32
    (..., numbers)."""
    value = np.asarray(value) if isinstance(value, np.void) else taken(name, value)  # void: one element of an array
    if not isinstance(value, np.ndarray):
        raise TypeError(f"{name}: {type(value).__name__}, expected an array of svocl.{_record_name(dtype)}")
    numbers = dtype.itemsize // 4
    if value.dtype == dtype:
        return np.ascontiguousarray(value) if value.ndim else value
    if value.dtype != np.float32:
        raise TypeError(
            f"{name}: dtype {value.dtype}, expected svocl.{_record_name(dtype)}, or float32 of shape (..., {numbers})"
        )
    if value.ndim < 1 or value.shape[-1] != numbers:
        raise ValueError(f"{name}: shape {_words(value.shape)}, expected (..., {numbers}) for float32")
    return np.ascontiguousarray(value).view(dtype)[..., 0]


def exact_records(name: str, value: Any, dtype: "np.dtype[Any]", what: str) -> Array:
    """Records of one type in a row, C-contiguous. what: the type's name in svocl."""
    if not isinstance(value, np.ndarray) or value.dtype != dtype:
        kind = f"dtype {value.dtype}" if isinstance(value, np.ndarray) else type(value).__name__
        raise TypeError(f"{name}: {kind}, expected an array of svocl.{what}")
    _check_shape(name, value, (f"{name}_count",))
    return np.ascontiguousarray(value)


def _record_name(dtype: "np.dtype[Any]") -> str:
    names = {"ray_dtype": ray_dtype, "query_dtype": query_dtype, "gather_point_dtype": gather_point_dtype}
    return next(name for name, known in names.items() if known == dtype)


def output(name: str, value: Optional[Array], dtype: "np.dtype[Any]", shape: tuple[int, ...]) -> Array:
    """The array that receives a result: the caller's, or a new one."""
    if value is None:
        return np.empty(shape, dtype)
    if not isinstance(value, np.ndarray) or value.dtype != dtype:
        kind = value.dtype if isinstance(value, np.ndarray) else type(value).__name__
        raise TypeError(f"{name}: {kind}, expected an array of {dtype}")
    _check_shape(name, value, shape)
    if not (value.flags.c_contiguous and value.flags.writeable):
        raise ValueError(f"{name}: not C-contiguous and writable")
    return value


def integer(name: str, value: Any, bits: int = 32) -> int:
    """A number for an unsigned field of that many bits."""
    number = operator.index(value)
    if not 0 <= number < 2**bits:
        raise ValueError(f"{name}: {number} is not in 0 .. {2**bits - 1}")
    return number


def three(name: str, value: Any) -> tuple[float, float, float]:
    """Three numbers as floats."""
    array = floats(name, value, (3,), double=True)
    return float(array[0]), float(array[1]), float(array[2])


def pointer(array: Optional[Array], kind: str) -> Any:
    """The address of a contiguous array's first element; the result keeps the array alive. NULL for None."""
    if array is None:
        return ffi.NULL
    return ffi.from_buffer(f"{kind}[]", array)
