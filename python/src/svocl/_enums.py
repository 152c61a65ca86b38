# SPDX-License-Identifier: MIT
"""Enumerations of the public headers, with the values that the library was compiled with."""

from enum import IntEnum, IntFlag

from ._native import lib


class Status(IntEnum):
    """What a call into the library returned (Error.status)."""

    OK = lib.SVO_OK
    INVALID_ARGUMENT = lib.SVO_INVALID_ARGUMENT
    OUT_OF_HOST_MEMORY = lib.SVO_OUT_OF_HOST_MEMORY
    OUT_OF_DEVICE_MEMORY = lib.SVO_OUT_OF_DEVICE_MEMORY
    NO_DEVICE = lib.SVO_NO_DEVICE
    NO_GL = lib.SVO_NO_GL
    UNSUPPORTED = lib.SVO_UNSUPPORTED
    COMPILE_FAILED = lib.SVO_COMPILE_FAILED
    CL_ERROR = lib.SVO_CL_ERROR
    GL_ERROR = lib.SVO_GL_ERROR
    CAPACITY_EXCEEDED = lib.SVO_CAPACITY_EXCEEDED
    FILE_ERROR = lib.SVO_FILE_ERROR
    FILE_DAMAGED = lib.SVO_FILE_DAMAGED
    IMPORT_FAILED = lib.SVO_IMPORT_FAILED
    INTERNAL = lib.SVO_INTERNAL
    CANCELED = lib.SVO_CANCELED
    NOT_ON_DEVICE = lib.SVO_NOT_ON_DEVICE


class Need(IntFlag):
    """What a tree holds besides its occupancy; flags that combine with |."""

    DEFAULT = lib.SVO_NEED_DEFAULT
    """Normals, and the colors that the mesh has."""
    COLOR = lib.SVO_NEED_COLOR
    """RGBA8 per node."""
    NORMAL = lib.SVO_NEED_NORMAL
    """3 x int16 per node."""
    RAYS = lib.SVO_NEED_RAYS
    """Leaf lists, vertices as given and snapped, and indices: for Tree.trace and Tree.nearest."""
    MATERIAL = lib.SVO_NEED_MATERIAL
    """The material with the largest weight per node."""
    FILL = lib.SVO_NEED_FILL
    """The surface area inside each node, 4096 = a face of the node."""
    PROJECTED_AREA = lib.SVO_NEED_PROJECTED_AREA
    """The surface that rays along each of the six axis directions see in each leaf, 4096 = a face of the leaf."""
    NONE = lib.SVO_NEED_NONE
    """Occupancy alone."""


class Coverage(IntEnum):
    """Which voxels a triangle occupies."""

    HALF_OPEN = lib.SVO_COVERAGE_HALF_OPEN
    CLOSED = lib.SVO_COVERAGE_CLOSED
    THIN = lib.SVO_COVERAGE_THIN


class Place(IntEnum):
    """Where a plan is made. The plan is the same, bit for bit."""

    DEFAULT = lib.SVO_PLACE_DEFAULT
    HOST = lib.SVO_PLACE_HOST
    DEVICE = lib.SVO_PLACE_DEVICE


class Axes(IntEnum):
    """Which axis is up in a file. Where it is z, (x, y, z) is turned to (x, z, -y) when it is read, and back when it is
    written."""

    AUTO = lib.SVO_AXES_AUTO
    """What the format says: z in .vox, y in the others."""
    KEEP = lib.SVO_AXES_KEEP
    """Nothing is turned."""
    Z_UP = lib.SVO_AXES_Z_UP


class Weights(IntEnum):
    """The weight of a triangle in the payload of its voxel."""

    AREA = lib.SVO_WEIGHTS_AREA
    UNIFORM = lib.SVO_WEIGHTS_UNIFORM
    CENTER = lib.SVO_WEIGHTS_CENTER


class Builder(IntEnum):
    """How nodes are made. The tree is the same, bit for bit."""

    CL = lib.SVO_BUILDER_CL
    SORTED = lib.SVO_BUILDER_SORTED


class Certainty(IntEnum):
    """How certain the bytes of a buffer are before a build."""

    EXACT = lib.SVO_BYTES_EXACT
    BOUND = lib.SVO_BYTES_BOUND
    ESTIMATE = lib.SVO_BYTES_ESTIMATE


class TraceMode(IntEnum):
    """What a batch of rays asks for."""

    CLOSEST = lib.SVO_TRACE_CLOSEST
    """The first triangle along each ray."""
    ANY = lib.SVO_TRACE_ANY
    """Whether there is a hit; the record is that of some triangle."""
    COUNT = lib.SVO_TRACE_COUNT
    """The number of triangles hit, in the field "count"."""


class BvhQuality(IntEnum):
    """How the BVH of rays is made. Hits are the same."""

    BEST = lib.SVO_BVH_BEST
    """The most rays per second."""
    FAST = lib.SVO_BVH_FAST
    """Made in about half the time, for what changes often."""


class View(IntEnum):
    """What a picture shows."""

    SHADED = lib.SVO_VIEW_SHADED
    NORMAL = lib.SVO_VIEW_NORMAL
    DEPTH = lib.SVO_VIEW_DEPTH
    STEPS = lib.SVO_VIEW_STEPS
    LEVEL = lib.SVO_VIEW_LEVEL
    TRIANGLES = lib.SVO_VIEW_TRIANGLES


class Wrap(IntEnum):
    """How texture coordinates outside [0, 1) are mapped into it."""

    REPEAT = lib.SVO_WRAP_REPEAT
    CLAMP = lib.SVO_WRAP_CLAMP
    MIRROR = lib.SVO_WRAP_MIRROR


class TreeBuffer(IntEnum):
    """The arrays of a tree; TreeArrays has them by the same names in lower case."""

    CHILD_MASK = lib.SVO_TREE_CHILD_MASK
    FIRST_CHILD = lib.SVO_TREE_FIRST_CHILD
    COLORS = lib.SVO_TREE_COLORS
    NORMALS = lib.SVO_TREE_NORMALS
    LIST_BEGIN = lib.SVO_TREE_LIST_BEGIN
    LIST = lib.SVO_TREE_LIST
    VERTICES = lib.SVO_TREE_VERTICES
    INDICES = lib.SVO_TREE_INDICES
    TRIANGLE_IDS = lib.SVO_TREE_TRIANGLE_IDS
    MATERIALS = lib.SVO_TREE_MATERIALS
    FILLS = lib.SVO_TREE_FILLS
    AREAS = lib.SVO_TREE_AREAS
    POSITIONS = lib.SVO_TREE_POSITIONS
    POSITIONS_DOUBLE = lib.SVO_TREE_POSITIONS_DOUBLE


class Positions(IntEnum):
    """Which mesh rays and nearest points meet."""

    SNAPPED = lib.SVO_POSITIONS_SNAPPED
    """The snapped one: the tree is from a file of version 1, or has no rays."""
    FLOAT = lib.SVO_POSITIONS_FLOAT
    """The input's, given as float32."""
    DOUBLE = lib.SVO_POSITIONS_DOUBLE
    """The input's, given as float64."""


class Form(IntEnum):
    """How a compact tree stores its nodes; compact.h describes each."""

    DESCRIPTOR = lib.SVO_FORM_DESCRIPTOR
    """A word per inner node, with the distance to its children."""
    IMPLIED = lib.SVO_FORM_IMPLIED
    """Child masks alone, and a directory."""
    SHARED = lib.SVO_FORM_SHARED
    """Equal subtrees are stored once."""


class CompactBuffer(IntEnum):
    """The arrays of a compact tree; CompactArrays has them by the same names in lower case."""

    NODES = lib.SVO_COMPACT_NODES
    LINKS = lib.SVO_COMPACT_LINKS
    BASES = lib.SVO_COMPACT_BASES
    COLORS = lib.SVO_COMPACT_COLORS
    NORMALS = lib.SVO_COMPACT_NORMALS
    MATERIALS = lib.SVO_COMPACT_MATERIALS
    FILLS = lib.SVO_COMPACT_FILLS


class SolidRule(IntEnum):
    """Which sums of crossings mean inside."""

    WINDING = lib.SVO_SOLID_WINDING
    """Other than 0: closed parts that overlap make their union."""
    PARITY = lib.SVO_SOLID_PARITY
    """Odd: where two closed parts overlap it is hollow."""


class SceneTrace(IntFlag):
    """What a batch of rays asks a scene for; flags that combine with |."""

    CLOSEST = lib.SVO_SCENE_CLOSEST
    """The first hit along each ray."""
    ANY = lib.SVO_SCENE_ANY
    """Whether there is a hit; the record is that of some instance."""
    EVERY_INSTANCE = lib.SVO_SCENE_EVERY_INSTANCE
    """Asks every instance in turn, without the hierarchy: the same hits, to check them."""


class LightForm(IntEnum):
    """How a light stores opacity and radiance; light.h describes each."""

    FACES = lib.SVO_LIGHT_FACES
    """Six directions a node."""
    BRICKS = lib.SVO_LIGHT_BRICKS
    """27 samples an inner node, without direction."""
    VOXELS = lib.SVO_LIGHT_VOXELS
    """One value a node, without interpolation."""


class Opacity(IntEnum):
    """How opaque the leaves of a light are."""

    AREA = lib.SVO_OPACITY_AREA
    """Alpha times min(1, projected area), by direction, for trees with Need.PROJECTED_AREA."""
    FULL = lib.SVO_OPACITY_FULL
    """Alpha."""


class LightBuffer(IntEnum):
    """The buffers of a light; light.h describes what each form has in them."""

    OPACITY = lib.SVO_LIGHT_OPACITY
    COVER = lib.SVO_LIGHT_COVER
    LIT = lib.SVO_LIGHT_LIT
    RADIANCE = lib.SVO_LIGHT_RADIANCE
    FLUX = lib.SVO_LIGHT_FLUX


class SourceKind(IntEnum):
    """What a source of light is."""

    DIRECTIONAL = lib.SVO_SOURCE_DIRECTIONAL
    """Parallel light; its value is an irradiance."""
    POINT = lib.SVO_SOURCE_POINT
    """Its value is an intensity, per unit of solid angle."""
    SPOT = lib.SVO_SOURCE_SPOT
    """A point source within a cone; its value is the intensity on the axis."""


class March(IntEnum):
    """How cones march."""

    STEPS = lib.SVO_MARCH_STEPS
    """Steps in proportion to the cone's width, blended between two levels."""
    PUBLISHED = lib.SVO_MARCH_PUBLISHED
    """Node to node, as published by Crassin et al. 2011, for comparison; needs LightForm.BRICKS and 5 cones."""


class LightView(IntEnum):
    """What a picture of a light shows."""

    FULL = lib.SVO_LIGHT_VIEW_FULL
    """Direct, indirect and specular light and emission."""
    AO = lib.SVO_LIGHT_VIEW_AO
    """Ambient occlusion: open is white."""
    DIRECT = lib.SVO_LIGHT_VIEW_DIRECT
    """The sources alone, with exact shadows."""
    INDIRECT = lib.SVO_LIGHT_VIEW_INDIRECT
    """What cones bring, on the surfaces' colors."""
    SPECULAR = lib.SVO_LIGHT_VIEW_SPECULAR
    """Specular cones."""


class ProbeBuffer(IntEnum):
    """Device buffers of Probes. The index of a probe is x + counts[0] * (y + counts[1] * z)."""

    PLACES = lib.SVO_PROBES_PLACES
    """A record of four floats each: position and state."""
    TEXELS = lib.SVO_PROBES_TEXELS
    """Two words each: distance and normal, radiance."""
    LEAST = lib.SVO_PROBES_LEAST
    """The least distances of 16 x 16 texels."""
    FIELD = lib.SVO_PROBES_FIELD
    """Which probes see a cell, four each."""
    IRRADIANCE = lib.SVO_PROBES_IRRADIANCE
    """With diffuse."""
    MOMENTS = lib.SVO_PROBES_MOMENTS
    """Mean distance and its square; with diffuse."""


class ProbeChoice(IntEnum):
    """How rays choose their probes."""

    FIELD = lib.SVO_PROBE_CHOICE_FIELD
    """Those that see the cell where the ray is."""
    EIGHT = lib.SVO_PROBE_CHOICE_EIGHT
    """Those around the ray's origin, as published."""
