# SPDX-License-Identifier: MIT
"""Structs of the library: made, and read as named tuples."""

from enum import EnumMeta
from typing import Any, Optional, TypeVar, get_type_hints

from ._errors import text
from ._generated import BuildReport, CompactInfo, LightInfo, PartsTreeInfo, ProbeInfo, StageTime, TreeInfo
from ._native import ffi, lib

_T = TypeVar("_T")


def new(kind: str) -> Any:
    """A zeroed struct with its struct_size set, as SVO_..._INIT."""
    struct = ffi.new(f"{kind} *")
    struct.struct_size = ffi.sizeof(kind)
    return struct


def read(struct: Any, kind: type[_T]) -> _T:
    """The fields of a struct that a named tuple has."""
    values = []
    kinds = _kinds(kind)
    for name in kind._fields:  # type: ignore[attr-defined]
        value = getattr(struct, name)
        if isinstance(value, ffi.CData):
            value = text(value) if ffi.typeof(value).kind == "pointer" else tuple(value)
        values.append(kinds[name](value) if name in kinds else value)
    return kind(*values)


def _kinds(kind: Any) -> dict[str, Any]:
    """Fields whose numbers are enumerators or truth values, and what makes these."""
    hints = get_type_hints(kind)
    return {name: hint for name, hint in hints.items() if hint is bool or isinstance(hint, EnumMeta)}


def read_tree_info(struct: Any) -> TreeInfo:
    info = read(struct, TreeInfo)
    return info._replace(level_begin=info.level_begin[: info.depth + 2])


def read_parts_tree_info(struct: Any) -> PartsTreeInfo:
    values = {name: getattr(struct, name) for name in PartsTreeInfo._fields}
    values["tree"] = read_tree_info(struct.tree)
    values["level_nodes"] = tuple(struct.level_nodes)[: struct.tree.depth + 1]
    return PartsTreeInfo(**values)


def read_compact_info(struct: Any) -> CompactInfo:
    info = read(struct, CompactInfo)
    levels = info.depth + 1
    return info._replace(level_inner=info.level_inner[:levels], level_leaf=info.level_leaf[:levels])


def read_light_info(struct: Any) -> LightInfo:
    stages = {text(lib.svo_name(lib.SVO_NAME_LIGHT_STAGE, i)): float(ms) for i, ms in enumerate(struct.stage_ms)}
    return read(struct, LightInfo)._replace(stage_ms=stages)


def read_probe_info(struct: Any) -> ProbeInfo:
    stages = {text(lib.svo_name(lib.SVO_NAME_PROBES_STAGE, i)): float(ms) for i, ms in enumerate(struct.stage_ms)}
    return read(struct, ProbeInfo)._replace(stage_ms=stages)


def read_file_info(struct: Any, kind: type[_T]) -> _T:
    """VoxelFileInfo, VoxelsSaveInfo or PointsInfo, with the format's name in place of its number."""
    info: Any = read(struct, kind)
    name = text(lib.svo_name(lib.SVO_NAME_VOXEL_FORMAT, info.format))
    return info._replace(format=name)  # type: ignore[no-any-return]


def read_report(struct: Any) -> BuildReport:
    stages = {}
    time = ffi.new("svo_stage_time *")
    for index in range(lib.svo_build_report_stage(struct, 0, ffi.NULL)):
        lib.svo_build_report_stage(struct, index, time)
        if time.clock != ffi.NULL:
            stages[text(lib.svo_name(lib.SVO_NAME_STAGE, index))] = StageTime(time.ms, text(time.clock))
    names = BuildReport._fields[:-1]
    values: dict[str, Optional[Any]] = {name: getattr(struct, name) for name in names}
    words = {name: text(value) for name, value in values.items() if isinstance(value, ffi.CData)}
    return BuildReport(**{**values, **words}, stages=stages)  # type: ignore[arg-type]
