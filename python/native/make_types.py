# SPDX-License-Identifier: MIT
"""Writes svocl/_generated.py: enumerations, results and errors of the public headers as Python types.

The headers are the one place that says what there is and what it means; enumerators, fields, their types and their
words come from there. The tables here have what C does not say: Python's names, and kinds that C writes as integers.
"""

import argparse
import pathlib
import re
import textwrap
from collections.abc import Iterator
from typing import NamedTuple

COLUMNS = 120

# The enumeration in C and in Python, the prefix of its enumerators, and what the class derives from.
ENUMS = (
    ("svo_status", "Status", "SVO_", "IntEnum"),
    ("svo_need", "Need", "SVO_NEED_", "IntFlag"),
    ("svo_coverage", "Coverage", "SVO_COVERAGE_", "IntEnum"),
    ("svo_place", "Place", "SVO_PLACE_", "IntEnum"),
    ("svo_axes", "Axes", "SVO_AXES_", "IntEnum"),
    ("svo_weights", "Weights", "SVO_WEIGHTS_", "IntEnum"),
    ("svo_builder", "Builder", "SVO_BUILDER_", "IntEnum"),
    ("svo_certainty", "Certainty", "SVO_BYTES_", "IntEnum"),
    ("svo_trace_flags", "TraceMode", "SVO_TRACE_", "IntEnum"),
    ("svo_bvh_quality", "BvhQuality", "SVO_BVH_", "IntEnum"),
    ("svo_render_view", "View", "SVO_VIEW_", "IntEnum"),
    ("svo_wrap", "Wrap", "SVO_WRAP_", "IntEnum"),
    ("svo_tree_buffer", "TreeBuffer", "SVO_TREE_", "IntEnum"),
    ("svo_positions", "Positions", "SVO_POSITIONS_", "IntEnum"),
    ("svo_form", "Form", "SVO_FORM_", "IntEnum"),
    ("svo_compact_buffer", "CompactBuffer", "SVO_COMPACT_", "IntEnum"),
    ("svo_solid_rule", "SolidRule", "SVO_SOLID_", "IntEnum"),
    ("svo_scene_flags", "SceneTrace", "SVO_SCENE_", "IntFlag"),
    ("svo_light_form", "LightForm", "SVO_LIGHT_", "IntEnum"),
    ("svo_opacity", "Opacity", "SVO_OPACITY_", "IntEnum"),
    ("svo_light_buffer", "LightBuffer", "SVO_LIGHT_", "IntEnum"),
    ("svo_source_kind", "SourceKind", "SVO_SOURCE_", "IntEnum"),
    ("svo_probes_buffer", "ProbeBuffer", "SVO_PROBES_", "IntEnum"),
    ("svo_edit_verb", "EditVerb", "SVO_EDIT_", "IntEnum"),
)

# What the headers have as a list and as macros: the pattern of an enumerator and its words, and the words of all.
NOT_ENUMS = {
    "svo_status": (r'X\((SVO_\w+), \d+, "([^"]*)"\)', "What a call into the library returned (Error.status)."),
    "svo_source_kind": (
        r"#define (SVO_SOURCE_\w+) +\d+u /\*\*< svo_light_source\.kind: (.*) \*/",
        "What a source of light is.",
    ),
}

# The struct in C and in Python. A field of type svo_stage_time comes before svo_build_report.
STRUCTS = (
    ("svo_plan_info", "PlanInfo"),
    ("svo_buffer_info", "PlanBuffer"),
    ("svo_import_info", "ImportInfo"),
    ("svo_left_out", "LeftOut"),
    ("svo_kernels_info", "Kernels"),
    ("svo_stage_time", "StageTime"),
    ("svo_build_report", "BuildReport"),
    ("svo_tree_info", "TreeInfo"),
    ("svo_compact_info", "CompactInfo"),
    ("svo_solid_info", "SolidInfo"),
    ("svo_sdf_info", "SdfInfo"),
    ("svo_surface_info", "SurfaceInfo"),
    ("svo_light_info", "LightInfo"),
    ("svo_edit_info", "EditInfo"),
    ("svo_voxels_info", "VoxelsInfo"),
    ("svo_voxel_file_info", "VoxelFileInfo"),
    ("svo_voxels_save_info", "VoxelsSaveInfo"),
    ("svo_points_info", "PointsInfo"),
    ("svo_scene_info", "SceneInfo"),
    ("svo_probe_info", "ProbeInfo"),
    ("svo_paged_info", "PagedInfo"),
    ("svo_paged_counts", "PagedCounts"),
    ("svo_parts_tree_info", "PartsTreeInfo"),
    ("svo_moving_report", "MovingReport"),
    ("svo_moving_bvh_report", "MovingBvhReport"),
    ("svo_moving_info", "MovingInfo"),
    ("svo_moving_object", "MovingObject"),
)

# OpenGL's, and those of enqueued builds; stage_times are stages.
LEFT_OUT = {"struct_size", "reserved", "inner_nodes", "renderer", "stage_times"}

# Kinds that neither the type nor the words of a field name.
KINDS = {
    "constant": "Need",
    "packed": "Need",
    "SceneInfo.need": "Need",
    "format": "str",
    "stage_ms": "dict[str, float]",
}

# Fields that Python has besides: those of a C array whose indices have names.
MORE_FIELDS = {"BuildReport": [("stages", "dict[str, StageTime]", "by name, in order; the stages that ran")]}

# Words where the headers' say too little of Python, or point to what it has not.
WORDS = {
    "Need": "what a tree holds besides its occupancy; flags that combine with |",
    "PlanInfo.updatable": "the mesh may move",
    "CompileError": 'a kernel or a shader does not compile; the build log goes to the logger "svocl"',
    "CanceledError": "the progress callback stopped the call; what a callback raises comes out itself",
}

# Names of the headers' words, as Python has them. Types and enumerators follow from the tables above.
NAMES = {
    "svo_plan_create": "Device.plan",
    "svo_plan_options": "Device.plan",
    "svo_plan_count": "Plan.count",
    "svo_plan_get_buffer": "Plan.buffers",
    "svo_plan_get_kernels": "Plan.kernels",
    "svo_plan_get_left_out": "Plan.left_out",
    "svo_tree_arrays": "TreeArrays",
    "svo_compact_plan": "of a plan",
    "svo_pack_options": "Compact.pack",
    "svo_sdf_create": "sdf",
    "svo_surface_create": "surface",
    "svo_light_create": "making it",
    "svo_light_set_sources": "Light.set_sources",
    "svo_light_set_mesh": "Light.set_mesh",
    "svo_light_setup.diagnose": "Light.set_sources(diagnose=True)",
    "svo_light_setup.bounces": "Light.set_sources(bounces=2) or more",
    "svo_light_update": "Light.update",
    "svo_scene_rebuild": "Scene.rebuild",
    "svo_paged_open": "Paged",
    "svo_parts_tree_load": "PartsTree.load",
    "svo_probe": "four floats: position and state",
    "svo_voxel_format": "the format's name",
    "svo_points_color": "0 white, 1 mean of RGB, 2 gray of the mean intensity",
    "the log callback": 'the logger "svocl"',
    "SVO_NO_NODE": "0xffffffff",
    "SVO_DEPTH_MAX": "16",
}

# The class of a status, and what it derives from.
ERRORS = {
    "INVALID_ARGUMENT": ("InvalidArgumentError", "Error, ValueError"),
    "OUT_OF_HOST_MEMORY": ("OutOfHostMemoryError", "Error, MemoryError"),
    "OUT_OF_DEVICE_MEMORY": ("OutOfDeviceMemoryError", "Error, MemoryError"),
    "NO_DEVICE": ("NoDeviceError", "Error"),
    "NO_GL": ("NoGLError", "Error"),
    "UNSUPPORTED": ("UnsupportedError", "Error"),
    "COMPILE_FAILED": ("CompileError", "Error"),
    "CL_ERROR": ("CLError", "Error"),
    "GL_ERROR": ("GLError", "Error"),
    "CAPACITY_EXCEEDED": ("CapacityExceededError", "Error"),
    "FILE_ERROR": ("FileError", "Error, OSError"),
    "FILE_DAMAGED": ("FileDamagedError", "Error, ValueError"),
    "IMPORT_FAILED": ("ImportFailedError", "Error"),
    "INTERNAL": ("InternalError", "Error"),
    "CANCELED": ("CanceledError", "Error"),
    "NOT_ON_DEVICE": ("NotOnDeviceError", "InvalidArgumentError"),
    "DEVICE_UNRELIABLE": ("DeviceUnreliableError", "Error"),
    "UNAVAILABLE": ("UnavailableError", "FileError"),
}

HEAD = '''# SPDX-License-Identifier: MIT
"""Enumerations, results and errors of the library. Written by native/make_types.py from the public headers."""

from enum import IntEnum, IntFlag
from typing import Any, NamedTuple

from ._native import lib
'''

ERROR = '''

class Error(Exception):
    """A call into the library failed. str() is the library's message: function, argument, value and limit.

    Attributes:
        status: the Status that the call returned.
    """

    status: Status

    def __init__(self, message: str, status: Status) -> None:
        super().__init__(message)
        self.status = status

    def __str__(self) -> str:
        return Exception.__str__(self)

    def __reduce__(self) -> Any:
        return type(self), (str(self), self.status)
'''

COMMENT = r"/\*\*(?!<)((?:[^*]|\*(?!/))*)\*/\s*"  # before what it is of
COMMENT_BEHIND = r"\s*/\*\*<((?:[^*]|\*(?!/))*)\*/"


class Item(NamedTuple):
    """An enumerator or a field."""

    name: str
    kind: str
    """Of a field: its type in C, with "*" of a pointer."""
    length: str
    """Of a field that is an array."""
    words: str


class Headers:
    """The public headers' text, and how their words are Python's."""

    def __init__(self, folder: pathlib.Path) -> None:
        self.text = "\n".join(path.read_text(encoding="utf-8") for path in sorted(folder.glob("svocl/*.h")))
        self.enums = {c_name: name for c_name, name, _, _ in ENUMS}
        self.types = {**self.enums, **dict(STRUCTS)}
        self.members = {
            item.name: f"{name}.{item.name[len(prefix):]}"
            for c_name, name, prefix, _ in ENUMS
            for item in self.enumerators(c_name)
        }

    def find(self, kind: str, name: str) -> tuple[str, str]:
        """The comment of an enumeration or a struct, and its body."""
        found = re.search(
            rf"(?:{COMMENT})?typedef {kind} {name} \{{\n(.*?)^\}} {name};", self.text, re.DOTALL | re.MULTILINE
        )
        if found is None:
            raise RuntimeError(f"the headers have no {kind} {name}")
        return found.group(1) or "", found.group(2)

    def enumerators(self, name: str) -> Iterator[Item]:
        if name in NOT_ENUMS:
            for found in re.finditer(NOT_ENUMS[name][0], self.text):
                yield Item(found.group(1), "", "", found.group(2))
            return
        pattern = rf"(?:{COMMENT})?\b(SVO_\w+)(?:\s*=\s*\w+)?,?(?:{COMMENT_BEHIND})?"
        for found in re.finditer(pattern, self.find("enum", name)[1]):
            if not found.group(2).endswith("_COUNT") or name == "svo_trace_flags":
                yield Item(found.group(2), "", "", found.group(1) or found.group(3) or "")

    def fields(self, name: str) -> Iterator[Item]:
        pattern = rf"(?:{COMMENT})?(?:const )?(\w+) (\*?)(\w+)(?:\[(\w+)\])?;(?:{COMMENT_BEHIND})?"
        for found in re.finditer(pattern, self.find("struct", name)[1]):
            before, kind, star, field, length, behind = found.groups()
            if field not in LEFT_OUT:
                yield Item(field, kind + star, length or "", before or behind or "")

    def words(self, comment: str) -> str:
        """A comment as a sentence with Python's names; "" if it has only a name in it."""
        text = " ".join(re.sub(r"^\s*\*", "", line).strip() for line in comment.strip().splitlines())
        text = re.sub(r'^"[\w-]+"(?:: |$)', "", text)
        text = re.sub(r"^not 0: ", "", text)
        text = re.sub(r"\bSVO_\w+\b", lambda match: self.members.get(match.group(), match.group()), text)
        for name, python_name in NAMES.items():
            text = re.sub(rf"\b{name}\b", python_name, text)
        text = re.sub(r"\bsvo_\w+\b", lambda match: self.types.get(match.group(), match.group()), text)
        if not text or text in self.types.values():
            return ""
        if re.match(r"(?:a(?= )|[a-z]{2,})(?![\w.]*[_(\[])", text):
            text = text[0].upper() + text[1:]
        return text if text[-1] in ".:" else text + "."


def docstring(text: str, indent: str) -> str:
    if len(indent + text) + 6 <= COLUMNS:
        return f'{indent}"""{text}"""\n'
    lines = textwrap.wrap(text, COLUMNS - len(indent) - 3, break_long_words=False)
    return indent + '"""' + f"\n{indent}".join(lines) + '"""\n'


def write_enum(headers: Headers, c_name: str, name: str, prefix: str, base: str) -> str:
    code = f"\n\nclass {name}({base}):\n"
    comment = NOT_ENUMS[c_name][1] if c_name in NOT_ENUMS else headers.find("enum", c_name)[0]
    code += docstring(headers.words(WORDS.get(name, comment)), "    ") + "\n"
    for item in headers.enumerators(c_name):
        code += f"    {item.name[len(prefix):]} = lib.{item.name}\n"
        words = headers.words(item.words)
        code += docstring(words, "    ") if words else ""
    return code


def kind_of(headers: Headers, struct: str, item: Item) -> str:
    """The Python type of a field."""
    for name in (f"{struct}.{item.name}", item.name):
        if name in KINDS:
            return KINDS[name]
    if item.kind == "char*":
        return "str"
    if item.kind in headers.types:
        return headers.types[item.kind]
    number = "float" if item.kind in ("float", "double") else "int"
    if item.length:
        return f"tuple[{', '.join([number] * int(item.length))}]" if item.length.isdigit() else f"tuple[{number}, ...]"
    if item.words.strip().startswith("not 0:"):
        return "bool"
    named = [headers.enums[word] for word in re.findall(r"\bsvo_\w+\b", item.words) if word in headers.enums]
    return named[0] if named and number == "int" else number


def write_struct(headers: Headers, c_name: str, name: str) -> str:
    code = f"\n\nclass {name}(NamedTuple):\n"
    code += docstring(headers.words(headers.find("struct", c_name)[0]), "    ") + "\n"
    fields = [(item.name, kind_of(headers, name, item), item.words) for item in headers.fields(c_name)]
    for field, kind, comment in fields + MORE_FIELDS.get(name, []):
        # A tuple has methods of these names.
        code += f"    {field}: {kind}" + ("  # type: ignore[assignment]\n" if field in ("count", "index") else "\n")
        words = headers.words(WORDS.get(f"{name}.{field}", comment))
        code += docstring(words, "    ") if words else ""
    return code


def write_errors(headers: Headers) -> str:
    code = ERROR
    for item in headers.enumerators("svo_status"):
        status = item.name[len("SVO_") :]
        if status != "OK":
            name, bases = ERRORS[status]
            code += f"\n\nclass {name}({bases}):\n"
            code += docstring(headers.words(WORDS.get(name, item.words)), "    ")
    code += "\n\nERRORS: dict[Status, type[Error]] = {\n"
    for status, (name, _) in ERRORS.items():
        code += f"    Status.{status}: {name},\n"
    return code + "}\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--include", required=True, type=pathlib.Path, help="the folder of svocl/svocl.h")
    parser.add_argument("--output", required=True, type=pathlib.Path, help="the Python file to write")
    arguments = parser.parse_args()
    headers = Headers(arguments.include)
    code = HEAD
    code += "".join(write_enum(headers, *names) for names in ENUMS)
    code += "".join(write_struct(headers, *names) for names in STRUCTS)
    code += write_errors(headers)
    arguments.output.write_text(code, encoding="utf-8")


if __name__ == "__main__":
    main()
