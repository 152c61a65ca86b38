# SPDX-License-Identifier: MIT
"""Structs of the library as named tuples."""

from typing import Any, NamedTuple, Optional, TypeVar

from ._enums import Certainty, Coverage, Need, Weights
from ._errors import text
from ._native import ffi, lib

_T = TypeVar("_T")


class PlanInfo(NamedTuple):
    """What a plan found out."""

    depth: int
    """The grid has 2**depth voxels per axis."""
    snap_bits: int
    """The grid is 2**snap_bits units wide."""
    coverage: Coverage
    need: Need
    """Resolved: what the tree will hold; 0 means occupancy alone."""
    constant: Need
    """Of those, payload that is the same in every node and stored once on the device."""
    triangles: int
    """Of the mesh."""
    refused_triangles: int
    """Index out of range, not finite, or too far from the grid."""
    outside_triangles: int
    """Accepted, but with bounds that miss the caller's grid."""
    origin: tuple[float, float, float]
    """Minimum corner of the grid, world coordinates."""
    edge: float
    """Width of the grid, world units."""
    scale: float
    """Grid units per world unit."""
    snap_error: float
    """World units: the largest distance along an axis that snapping moved a vertex."""
    expected_fragments: float
    """The fragment estimate."""
    fragments: int
    """The exact number after Plan.count; 0 before."""
    grid_ms: float
    """Wall clock of validating, snapping and classifying, milliseconds."""


class PlanBuffer(NamedTuple):
    """A buffer that a build allocates."""

    name: str
    bytes: int
    """Of all its cl_mems."""
    count: int  # type: ignore[assignment]
    """cl_mems it is split into."""
    certainty: Certainty
    """Certainty.EXACT after a build."""
    persistent: bool
    """Part of the tree; else released before the build ends."""


class ImportInfo(NamedTuple):
    """What a mesh file holds and what was read of it. Declared and read counts are 0 where assimp is the reader."""

    reader: str
    """"obj", "ply", "stl", "off": the library's own; or "assimp"."""
    declared_vertices: int
    used_vertices: int
    """Of those, the ones that a triangle has."""
    declared_faces: int
    read_faces: int
    """Of those, the ones that became triangles."""
    triangles: int
    warnings: int
    """Given to the logger "svocl"."""


class LeftOut(NamedTuple):
    """Something that a build does without."""

    what: str
    reason: str


class Kernels(NamedTuple):
    """A program of kernels that a build compiles."""

    name: str
    defines: str


class StageTime(NamedTuple):
    """The time of a stage."""

    ms: float
    """Milliseconds."""
    clock: str
    """"wall", "cl-event" or "gl-timer"."""


class BuildReport(NamedTuple):
    """What a build did."""

    fragments: int
    """(voxel, triangle) pairs."""
    list_chunks: int
    """Buffers of the fragment list."""
    reruns: int
    """How often a capacity was too small and a stage ran again."""
    frontend: str
    builder: str
    share: str
    stages: dict[str, StageTime]
    """By name, in order; the stages that ran."""


class TreeInfo(NamedTuple):
    """What describes a tree besides its arrays."""

    depth: int
    """The grid has 2**depth voxels per axis."""
    snap_bits: int
    """The grid is 2**snap_bits units wide."""
    coverage: Coverage
    need: Need
    """What the tree holds."""
    constant: Need
    """Of those, payload that is one element in device buffers and files."""
    weights: Weights
    payload_level: int
    """The first level with payload; payload arrays begin with that level's first node."""
    origin: tuple[float, float, float]
    """Minimum corner of the grid, world coordinates."""
    edge: float
    """Width of the grid, world units."""
    scale: float
    """Grid units per world unit: q = rint((v - origin) * scale)."""
    snap_error: float
    """World units: the largest distance along an axis that snapping moved a vertex."""
    triangles: int
    """Of the mesh."""
    refused_triangles: int
    """Of those, not usable."""
    fragments: int
    """(voxel, triangle) pairs."""
    node_count: int
    """inner_count + leaf_count."""
    inner_count: int
    """Nodes above level depth."""
    leaf_count: int
    """Nodes of level depth."""
    list_count: int
    """Entries of all leaf lists."""
    vertex_count: int
    """Snapped vertices kept for rays."""
    list_triangle_count: int
    """Accepted triangles kept for rays."""
    level_begin: tuple[int, ...]
    """depth + 2 entries: level l has the nodes level_begin[l] .. level_begin[l + 1] - 1."""


_KINDS: dict[str, Any] = {
    "coverage": Coverage,
    "need": Need,
    "constant": Need,
    "weights": Weights,
    "certainty": Certainty,
    "persistent": bool,
}


def new(kind: str) -> Any:
    """A zeroed struct with its struct_size set, as SVO_..._INIT."""
    struct = ffi.new(f"{kind} *")
    struct.struct_size = ffi.sizeof(kind)
    return struct


def read(struct: Any, kind: type[_T]) -> _T:
    """The fields of a struct that a named tuple has."""
    values = []
    for name in kind._fields:  # type: ignore[attr-defined]
        value = getattr(struct, name)
        if isinstance(value, ffi.CData):
            value = text(value) if ffi.typeof(value).kind == "pointer" else tuple(value)
        values.append(_KINDS[name](value) if name in _KINDS else value)
    return kind(*values)


def read_tree_info(struct: Any) -> TreeInfo:
    info = read(struct, TreeInfo)
    return info._replace(level_begin=info.level_begin[: info.depth + 2])


def read_report(struct: Any) -> BuildReport:
    stages = {}
    time = ffi.new("svo_stage_time *")
    for index in range(lib.svo_build_report_stage(struct, 0, ffi.NULL)):
        lib.svo_build_report_stage(struct, index, time)
        if time.clock != ffi.NULL:
            stages[text(lib.svo_stage_name(index))] = StageTime(time.ms, text(time.clock))
    names = BuildReport._fields[:-1]
    values: dict[str, Optional[Any]] = {name: getattr(struct, name) for name in names}
    words = {name: text(value) for name, value in values.items() if isinstance(value, ffi.CData)}
    return BuildReport(**{**values, **words}, stages=stages)  # type: ignore[arg-type]
