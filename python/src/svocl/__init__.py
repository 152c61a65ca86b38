# SPDX-License-Identifier: MIT
"""svocl: exact sparse voxel octrees of triangle meshes with OpenCL.

    device = svocl.Device()
    mesh = svocl.Mesh(positions, indices)                    # numpy arrays
    tree = device.build(mesh, 9, need=svocl.Need.RAYS)
    hits = tree.trace(svocl.make_rays(origins, directions))  # hits["t"], hits["triangle"], ...
    tree.save("mesh.svo")

Log messages of the library go to the logger "svocl".
"""

from ._driver import use_pocl_of_pip as _use_pocl_of_pip

_use_pocl_of_pip()

try:
    from ._native import lib as _lib
except ImportError as _problem:
    if "OpenCL" not in str(_problem):
        raise
    raise ImportError(
        f"{_problem}: svocl needs the system's OpenCL loader (Debian: apt install ocl-icd-libopencl1) and a driver "
        "(without a GPU: apt install pocl-opencl-icd)"
    ) from _problem

from ._arrays import (
    NO_INSTANCE,
    NO_NODE,
    NO_TRIANGLE,
    gather_point_dtype,
    gather_result_dtype,
    hit_dtype,
    instance_dtype,
    nearest_dtype,
    probe_hit_dtype,
    probe_irradiance_dtype,
    query_dtype,
    ray_dtype,
    scene_hit_dtype,
    scene_triangle_hit_dtype,
    voxel_dtype,
    voxel_hit_dtype,
)
from ._bake import (
    BakedVertices,
    Lightmap,
    Texels,
    bake_lightmap,
    bake_vertices,
    lightmap_texels,
    vertex_normals,
)
from ._compact import COMPACT_ARGUMENTS, Compact, CompactArrays, Solid
from ._device import Device
from ._errors import text as _text
from ._generated import (
    Axes,
    Builder,
    BuildReport,
    BvhQuality,
    CanceledError,
    CapacityExceededError,
    Certainty,
    CLError,
    CompactBuffer,
    CompactInfo,
    CompileError,
    Coverage,
    DeviceUnreliableError,
    EditInfo,
    EditVerb,
    Error,
    FileDamagedError,
    FileError,
    Form,
    GLError,
    ImportFailedError,
    ImportInfo,
    InternalError,
    InvalidArgumentError,
    Kernels,
    LeftOut,
    LightBuffer,
    LightForm,
    LightInfo,
    MovingBvhReport,
    MovingInfo,
    MovingObject,
    MovingReport,
    Need,
    NoDeviceError,
    NoGLError,
    NotOnDeviceError,
    Opacity,
    OutOfDeviceMemoryError,
    OutOfHostMemoryError,
    PagedCounts,
    PagedInfo,
    Place,
    PlanBuffer,
    PlanInfo,
    Positions,
    ProbeBuffer,
    ProbeInfo,
    SceneInfo,
    SceneTrace,
    SdfInfo,
    SolidInfo,
    SolidRule,
    SourceKind,
    StageTime,
    Status,
    SurfaceInfo,
    TraceMode,
    TreeBuffer,
    TreeInfo,
    UnavailableError,
    UnsupportedError,
    View,
    VoxelFileInfo,
    VoxelsInfo,
    VoxelsSaveInfo,
    Weights,
    Wrap,
)
from ._edit import Box, Capsule, Edit, Sphere
from ._light import LIGHT_ARGUMENTS, Light, LightSource, light_kernel_source, make_gather_points
from ._mesh import NO_VERTEX, DeviceMesh, Finish, Material, Mesh, Texture, has_io, read_mesh
from ._moving import Moving
from ._opencl import Event
from ._page import png
from ._paged import Paged
from ._parts import Parts, PartEntry
from ._plan import Plan
from ._probes import Probes
from ._scene import Scene, SceneLight, make_instances
from ._sdf import Sdf, sdf
from ._surface import Surface, surface
from ._tree import TREE_ARGUMENTS, Camera, Tree, TreeArrays, kernel_options, kernel_source, make_rays
from ._trimesh import from_trimesh
from ._tune import TuneResult, TuneSetting, tune
from ._voxels import Voxels, make_voxels

__version__: str = _text(_lib.svo_version_string())

__all__ = [
    "COMPACT_ARGUMENTS",
    "LIGHT_ARGUMENTS",
    "NO_INSTANCE",
    "NO_NODE",
    "NO_TRIANGLE",
    "NO_VERTEX",
    "TREE_ARGUMENTS",
    "Axes",
    "BakedVertices",
    "Box",
    "BuildReport",
    "Builder",
    "BvhQuality",
    "CLError",
    "Camera",
    "CanceledError",
    "CapacityExceededError",
    "Capsule",
    "Certainty",
    "Compact",
    "CompactArrays",
    "CompactBuffer",
    "CompactInfo",
    "CompileError",
    "Coverage",
    "Device",
    "DeviceMesh",
    "DeviceUnreliableError",
    "Edit",
    "EditInfo",
    "EditVerb",
    "Error",
    "Event",
    "FileDamagedError",
    "FileError",
    "Finish",
    "Form",
    "GLError",
    "ImportFailedError",
    "ImportInfo",
    "InternalError",
    "InvalidArgumentError",
    "Kernels",
    "LeftOut",
    "Light",
    "LightBuffer",
    "LightForm",
    "LightInfo",
    "LightSource",
    "Lightmap",
    "Material",
    "Mesh",
    "Moving",
    "MovingBvhReport",
    "MovingInfo",
    "MovingObject",
    "MovingReport",
    "Need",
    "NoDeviceError",
    "NoGLError",
    "NotOnDeviceError",
    "Opacity",
    "Place",
    "OutOfDeviceMemoryError",
    "OutOfHostMemoryError",
    "Paged",
    "PagedCounts",
    "PagedInfo",
    "PartEntry",
    "Parts",
    "Plan",
    "PlanBuffer",
    "PlanInfo",
    "Positions",
    "ProbeBuffer",
    "ProbeInfo",
    "Probes",
    "Scene",
    "SceneLight",
    "SceneInfo",
    "SceneTrace",
    "Sdf",
    "SdfInfo",
    "Solid",
    "SolidInfo",
    "SolidRule",
    "SourceKind",
    "Sphere",
    "StageTime",
    "Status",
    "Surface",
    "SurfaceInfo",
    "Texels",
    "Texture",
    "TraceMode",
    "Tree",
    "TreeArrays",
    "TreeBuffer",
    "TreeInfo",
    "TuneResult",
    "TuneSetting",
    "UnavailableError",
    "UnsupportedError",
    "View",
    "VoxelFileInfo",
    "Voxels",
    "VoxelsInfo",
    "VoxelsSaveInfo",
    "Weights",
    "Wrap",
    "bake_lightmap",
    "bake_vertices",
    "from_trimesh",
    "gather_point_dtype",
    "gather_result_dtype",
    "has_io",
    "hit_dtype",
    "instance_dtype",
    "kernel_options",
    "kernel_source",
    "light_kernel_source",
    "lightmap_texels",
    "make_gather_points",
    "make_instances",
    "make_rays",
    "make_voxels",
    "nearest_dtype",
    "png",
    "probe_hit_dtype",
    "probe_irradiance_dtype",
    "query_dtype",
    "ray_dtype",
    "read_mesh",
    "scene_hit_dtype",
    "scene_triangle_hit_dtype",
    "sdf",
    "surface",
    "tune",
    "vertex_normals",
    "voxel_dtype",
    "voxel_hit_dtype",
]
