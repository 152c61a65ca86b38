# SPDX-License-Identifier: MIT
"""Structs of the library as named tuples."""

from typing import Any, NamedTuple, Optional, TypeVar

from ._enums import Certainty, Coverage, Form, LightForm, Need, Opacity, Place, Positions, Weights
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
    """Wall clock of validating, snapping and classifying, milliseconds; without compiling kernels."""
    place: Place
    """Place.HOST or Place.DEVICE."""
    area: float
    """Of the kept triangles' three projections, divided by the square root of 3; square world units."""
    weight_log2: int
    """The weight of a voxel's face, as a power of two; 0 without payload."""
    updatable: int
    """Not 0: the mesh may move."""


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
    """What a mesh file holds and what was read of it. Declared and read counts are 0 for glTF and with assimp."""

    reader: str
    """"obj", "ply", "stl", "off", "gltf": the library's own; or "assimp"."""
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
    """Vertices kept for rays."""
    list_triangle_count: int
    """Accepted triangles kept for rays."""
    level_begin: tuple[int, ...]
    """depth + 2 entries: level l has the nodes level_begin[l] .. level_begin[l + 1] - 1."""
    positions: Positions
    """Which mesh rays meet."""


class CompactInfo(NamedTuple):
    """What describes a compact tree besides its arrays."""

    form: Form
    minimized: bool
    """Leaves may lie above level depth."""
    directory_step_log2: int
    """Form.IMPLIED; else 0."""
    depth: int
    """The grid has 2**depth voxels per axis."""
    snap_bits: int
    """As all down to snap_error: those of the tree."""
    coverage: Coverage
    need: Need
    """The payload that is held."""
    constant: Need
    """Of those, payload that is the same in every node: one element."""
    weights: Weights
    payload_level: int
    """The first level with payload."""
    origin: tuple[float, float, float]
    """Minimum corner of the grid, world coordinates."""
    edge: float
    """World units: as in TreeInfo."""
    scale: float
    """Grid units per world unit."""
    snap_error: float
    """World units: the largest distance along an axis that snapping moved a vertex."""
    triangles: int
    """Of the mesh."""
    refused_triangles: int
    """Of those, not usable."""
    fragments: int
    """(voxel, triangle) pairs."""
    inner_count: int
    """Inner nodes of the tree that the form describes."""
    leaf_count: int
    """Its leaves, on whatever level."""
    voxel_count: int
    """Voxels that these leaves stand for."""
    stored_count: int
    """Elements of nodes."""
    far_count: int
    """Form.DESCRIPTOR: far words among them; else 0."""
    shared_count: int
    """Form.SHARED: records in these words; else 0."""
    payload_count: int
    """Elements of each payload array that is not constant."""
    level_inner: tuple[int, ...]
    """depth + 1 entries: inner nodes on each level."""
    level_leaf: tuple[int, ...]
    """depth + 1 entries: leaves on each level."""
    bytes: tuple[int, ...]
    """Of each array, in the order of CompactBuffer; 0: not held."""
    total_bytes: int
    """Of all arrays."""
    bounds: int
    """Bit b is set where bytes[b] is an upper bound: 0 of what is made."""


class SolidInfo(NamedTuple):
    """What a solid consists of, and where its surface is not closed."""

    surface_voxels: int
    """Leaves of the built tree."""
    inside_voxels: int
    """Voxels inside that no surface touches."""
    inside_leaves: int
    """Leaves that hold them."""
    tests: int
    """Empty children of inner nodes, each decided by one voxel."""
    ambiguous_cells: int
    """Of those, with lines that disagree; two of three decided."""
    ambiguous_voxels: int
    """Voxels of those cells, inside or not."""
    open_columns: tuple[int, int, int]
    """Columns along x, y and z whose crossings do not add up to 0: the surface has a hole there, or a tear."""
    scratch_bytes: int
    """Device memory that finding the inside took; it is released."""


class LightInfo(NamedTuple):
    """What a light holds, and what its last stages did."""

    form: LightForm
    opacity: Opacity
    """Opacity.FULL where the tree holds no areas."""
    photons: int
    """Rays from the sources."""
    photon_hits: int
    """Of those, that met the tree."""
    lit_leaves: int
    """Leaves with light: photons or emission."""
    lit_nodes: int
    """Of all levels."""
    missed_leaves: int
    """Leaves that a source sees, but without a photon; 0 without Light.set_sources(diagnose=True)."""
    flux: tuple[float, float, float]
    """Of all photons that hit: red, green, blue, world units."""
    lost_flux: float
    """Share of it that found no leaf."""
    bytes: tuple[int, ...]
    """Of each buffer, in the order of LightBuffer; 0: not held."""
    total_bytes: int
    """Of all buffers."""
    scratch_bytes: int
    """The most that making it and Light.set_sources took besides at a time; it is released."""
    stage_ms: dict[str, float]
    """Wall-clock milliseconds of the last run of each stage, by name, in order; 0: it did not run."""
    node_map_items: int
    """Items that a node map would start to filter the same photons (Crassin et al., 2011); 0 without
    Light.set_sources(diagnose=True)."""
    traced_photons: int
    """Of photons, those whose rays were traced by the newest call."""
    kept_bytes: int
    """Held for updates, besides total_bytes; 0: nothing is kept."""


class VoxelsInfo(NamedTuple):
    """What a list of voxels holds."""

    voxel_count: int
    """Places, each with one voxel."""
    given_count: int
    """Voxels that were given, before those in one place became one."""
    low: tuple[int, int, int]
    """Least coordinates; 0 without voxels."""
    high: tuple[int, int, int]
    """Greatest coordinates plus 1; 0 without voxels."""
    depth: int
    """Of the smallest tree that holds them: at least 1; 0 when that is deeper than 16."""
    material_count: int
    """The greatest material of a voxel plus 1; 0 without voxels."""
    origin: tuple[float, float, float]
    """World position of the least corner of voxel (0, 0, 0)."""
    voxel_edge: float
    """Width of a voxel, world units."""
    property_count: int
    """Properties of materials."""


class VoxelFileInfo(NamedTuple):
    """What a voxel file holds."""

    format: str
    """"vox", "svx" or "binvox"."""
    version: int
    """.vox: 150 or 200; .binvox: 1 or 2; .svx: 0."""
    models: int
    """.vox: models in the file; else 1."""
    instances: int
    """Models placed."""
    rotated_instances: int
    """Of those, with a rotation or a mirror."""
    hidden_instances: int
    """Left out since they or their layer are hidden."""
    instance_voxels: int
    """Voxels of all instances."""
    warnings: int
    """Given to the logger "svocl"."""


class VoxelsSaveInfo(NamedTuple):
    """What was written to a voxel file."""

    format: str
    """"vox", "svx", "binvox", "ply" or "obj"."""
    color_error: int
    """.vox: the largest difference between a component of a voxel's color and that of its palette entry."""
    models: int
    """.vox: models; else 1."""
    colors: int
    """.vox: different pairs of a color and a material; else 0."""
    faces: int
    """.obj: faces; else 0."""
    bytes: int
    """Of the file."""


class SceneInfo(NamedTuple):
    """A scene in numbers."""

    tree_count: int
    instance_count: int
    need: Need
    """What is copied of the trees."""
    tree_bytes: int
    """Of device memory: the trees."""
    instance_bytes: int
    """The instances' matrices, normals and boxes."""
    hierarchy_bytes: int
    sort_bytes: int
    """Morton codes and what sorts them, kept for Scene.rebuild."""
    total_bytes: int
    """All of these."""
    low: tuple[float, float, float]
    """Least corner of the box around all instances, world coordinates."""
    high: tuple[float, float, float]
    """Its greatest corner."""


class ProbeInfo(NamedTuple):
    """What probes are."""

    counts: tuple[int, int, int]
    """Along x, y and z."""
    resolution: int
    """Texels along a side of a probe's map."""
    start: tuple[float, float, float]
    """Of the first probe, world coordinates, before it was moved."""
    step: tuple[float, float, float]
    """Between probes, world units."""
    low: tuple[float, float, float]
    """Least corner of what the field spans."""
    high: tuple[float, float, float]
    """Its greatest corner."""
    leaf_edge: float
    """World units; of a scene, the smallest of its instances."""
    farthest: float
    """That a probe sees, world units."""
    probe_count: int
    moved: int
    """Of those."""
    off: int
    """Of those, switched off."""
    field_size: int
    """Cells of the field along an axis."""
    rays: int
    """Of texels."""
    place_rays: int
    """Of the search for places."""
    bytes: tuple[int, ...]
    """Of each buffer, in the order of ProbeBuffer; 0: not held."""
    total_bytes: int
    """Of all buffers."""
    scratch_bytes: int
    """What making them took besides; it is released."""
    stage_ms: dict[str, float]
    """Wall-clock milliseconds of the last run of each stage, by name, in order; 0: it did not run."""


class PagedInfo(NamedTuple):
    """What Paged opened."""

    depth: int
    """The grid has 2**depth voxels per axis."""
    top_level: int
    """Levels 0 to this one are always there: the more, the greater budget_bytes is."""
    page_levels: int
    """Of a page."""
    need: Need
    """What of colors and normals the file has."""
    page_count: int
    """Of all levels below top_level."""
    file_bytes: int
    """Length of the file."""
    device_bytes: int
    """Of all buffers on the device: at most what was given."""
    least_bytes: int
    """Of the buffers with these upper levels and room for the largest page alone; a smaller budget has fewer levels."""
    whole_bytes: int
    """Of the buffers with these upper levels and room for all pages."""
    open_read_bytes: int
    """Read when the file was opened."""


class PagedCounts(NamedTuple):
    """What the last picture, the last update and all of them did."""

    pictures: int
    """Drawn so far."""
    used_pages: int
    """By the last picture."""
    missed_pages: int
    """Absent ones that the last picture asked for; 0: it was complete."""
    read_pages: int
    """By the last update."""
    read_bytes: int
    """By the last update."""
    evicted_pages: int
    """By the last update."""
    waiting_pages: int
    """Missed, and not read by the last update: no room, or update_bytes were read."""
    held_pages: int
    """Now."""
    all_missed_pages: int
    """Sum over all pictures."""
    all_read_pages: int
    """By all updates."""
    all_read_bytes: int
    """By all updates."""
    all_evicted_pages: int
    """By all updates."""


class MovingReport(NamedTuple):
    """What an update of a moving scene did. Times are wall clock, milliseconds; stages are told apart by waiting after
    each."""

    changed_objects: int
    """Voxelized, hidden or removed."""
    changed_fragments: int
    """(voxel, triangle) pairs that went and that came."""
    fragments: int
    """Pairs of the scene."""
    move_ms: float
    """The objects' vertices: to the device, snapped, classified."""
    voxelize_ms: float
    """Their pairs, in Morton order."""
    weigh_ms: float
    """What their pairs contribute to the payload."""
    merge_ms: float
    """The lists merged."""
    nodes_ms: float
    """Nodes, leaf lists and their triangles."""
    payload_ms: float
    total_ms: float
    """All of it."""


class MovingBvhReport(NamedTuple):
    """What became of the BVHs of a moving scene's objects. The static mesh counts as an object."""

    kept: int
    """Objects that had not changed."""
    refit: int
    """Objects that moved or got new vertices."""
    made: int
    """Objects that had no BVH, or whose BVH was made anew."""
    total_ms: float
    """Wall clock, milliseconds."""


class MovingInfo(NamedTuple):
    """A moving scene after its newest update."""

    need: Need
    """Resolved: what the tree holds."""
    weight_log2: int
    """The weight of a voxel's face, as a power of two: for Device.plan."""
    object_count: int
    """Objects that exist, now."""
    fragments: int
    """(voxel, triangle) pairs."""
    list_bytes: int
    """Device memory of the lists, what merging needs included."""
    area: float
    """Inside the grid, as PlanInfo.area."""


class MovingObject(NamedTuple):
    """An object of a moving scene after the newest update."""

    triangles: int
    """Of its mesh."""
    refused_triangles: int
    """As in PlanInfo."""
    outside_triangles: int
    """Those whose bounds miss the grid."""
    fragments: int
    """(voxel, triangle) pairs; 0 while it is hidden."""
    first_triangle: int
    """Where its triangles begin in the scene's mesh; unused while it is hidden."""
    visible: bool
    """It is part of the scene."""


_KINDS: dict[str, Any] = {
    "form": Form,
    "minimized": bool,
    "coverage": Coverage,
    "need": Need,
    "constant": Need,
    "weights": Weights,
    "place": Place,
    "certainty": Certainty,
    "positions": Positions,
    "persistent": bool,
    "visible": bool,
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


def read_compact_info(struct: Any) -> CompactInfo:
    info = read(struct, CompactInfo)
    levels = info.depth + 1
    return info._replace(level_inner=info.level_inner[:levels], level_leaf=info.level_leaf[:levels])


def read_light_info(struct: Any) -> LightInfo:
    values = {name: getattr(struct, name) for name in LightInfo._fields}
    stages = {text(lib.svo_light_stage_name(i)): float(ms) for i, ms in enumerate(struct.stage_ms)}
    own = {
        "form": LightForm(struct.form),
        "opacity": Opacity(struct.opacity),
        "flux": tuple(struct.flux),
        "bytes": tuple(struct.bytes),
        "stage_ms": stages,
    }
    return LightInfo(**{**values, **own})


def read_probe_info(struct: Any) -> ProbeInfo:
    stages = {text(lib.svo_probes_stage_name(i)): float(ms) for i, ms in enumerate(struct.stage_ms)}
    return read(struct, ProbeInfo)._replace(stage_ms=stages)


def read_file_info(struct: Any, kind: type[_T]) -> _T:
    """VoxelFileInfo or VoxelsSaveInfo, with the format's name in place of its number."""
    info: Any = read(struct, kind)
    return info._replace(format=text(lib.svo_voxel_format_name(info.format)))  # type: ignore[no-any-return]


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
