#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes mesh and voxel files with the traits of other people's models, for tests where no such models are.

FOLDER gets `meshes`, files that are well formed in their way; `nasty`, files that are broken, open, degenerate or torn;
and `voxels`. The same bytes on every machine: no file depends on the time or on a generator of random numbers.

usage: stand_ins.py FOLDER
"""
import base64
import json
import math
import struct
import sys
import zipfile
import zlib
from pathlib import Path

Point = tuple[float, ...]
Face = tuple[int, ...]
Mesh = tuple[list[Point], list[Face]]

# ---- shapes ----


def rounded(number: float) -> float:
    """As float32 has it, so that text and binary files hold the same mesh."""
    return float(struct.unpack("<f", struct.pack("<f", number))[0])


def torus(rings: int = 24, sides: int = 12, bumps: float = 0.1) -> Mesh:
    """Closed, of quads, with bumps: what a scan looks like."""
    points: list[Point] = []
    for i in range(rings):
        around = 2 * math.pi * i / rings
        for k in range(sides):
            along = 2 * math.pi * k / sides
            radius = 0.4 + bumps * math.sin(5 * around) * math.cos(3 * along)
            out = 1 + radius * math.cos(along)
            points.append(
                (rounded(out * math.cos(around)), rounded(radius * math.sin(along)), rounded(out * math.sin(around)))
            )
    faces: list[Face] = []
    for i in range(rings):
        for k in range(sides):
            n, m = (i + 1) % rings, (k + 1) % sides
            faces.append((i * sides + k, i * sides + m, n * sides + m, n * sides + k))
    return points, faces


def box(low: Point = (0, 0, 0), high: Point = (1, 1, 1)) -> Mesh:
    """Six quads."""
    points: list[Point] = [tuple((high if bits >> a & 1 else low)[a] for a in range(3)) for bits in range(8)]
    return points, [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]


def triangles(faces: list[Face]) -> list[Face]:
    return [(face[0], face[i], face[i + 1]) for face in faces for i in range(1, len(face) - 1)]


def join(*meshes: Mesh) -> Mesh:
    points: list[Point] = []
    faces: list[Face] = []
    for more_points, more_faces in meshes:
        faces += [tuple(len(points) + i for i in face) for face in more_faces]
        points += more_points
    return points, faces


def moved(mesh: Mesh, scale: float, offset: Point) -> Mesh:
    return [tuple(scale * x + o for x, o in zip(point, offset)) for point in mesh[0]], mesh[1]


# ---- pictures ----


def png(width: int, height: int, texels: list[tuple[int, ...]]) -> bytes:
    """Gray, RGB or RGBA by the number of channels."""
    kind = {1: 0, 3: 2, 4: 6}[len(texels[0])]

    def chunk(name: bytes, content: bytes) -> bytes:
        return struct.pack(">I", len(content)) + name + content + struct.pack(">I", zlib.crc32(name + content))

    rows = b"".join(b"\0" + b"".join(bytes(t) for t in texels[y * width : (y + 1) * width]) for y in range(height))
    head = struct.pack(">IIBBBBB", width, height, 8, kind, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def checkers(edge: int, first: tuple[int, ...], second: tuple[int, ...]) -> bytes:
    return png(edge, edge, [second if (x // 4 + y // 4) % 2 else first for y in range(edge) for x in range(edge)])


# ---- OBJ ----


def obj(mesh: Mesh, base: int = 1) -> str:
    lines = ["v " + " ".join(f"{x:.9g}" for x in point) for point in mesh[0]]
    lines += ["f " + " ".join(str(i + base) for i in face) for face in mesh[1]]
    return "\n".join(lines) + "\n"


def house() -> dict[str, bytes]:
    """Several materials with textures, one with holes by alpha, one by a map of opacity; quads; names with spaces."""
    walls, fence, roof = (
        box((0, 0, 0), (4, 3, 4)),
        box((-1, 0, -1), (5, 1, -0.9)),
        box((-0.5, 3, -0.5), (4.5, 3.5, 4.5)),
    )
    lines = ["# a house", "mtllib house materials.mtl", "vt 0 0", "vt 2 0", "vt 2 2", "vt 0 2"]
    lines += ["vn 0 0 -1", "vn 0 0 1", "vn 0 -1 0", "vn 0 1 0", "vn -1 0 0", "vn 1 0 0"]
    base = 1
    for name, material, part in (("walls", "brick", walls), ("fence", "mesh wire", fence), ("roof", "slates", roof)):
        lines += [f"o {name}", f"g {name} all", f"usemtl {material}", "s off"]
        lines += ["v " + " ".join(f"{x:g}" for x in point) for point in part[0]]
        for number, face in enumerate(part[1]):
            corners = (f"{base + i}/{1 + k}/{number + 1}" for k, i in enumerate(face))
            lines.append("f " + " ".join(corners))
        base += len(part[0])
    lines += ["usemtl not there", f"f {base - 1} \\", f"  {base - 2} {base - 3}"]
    materials = """newmtl brick
Ka 0 0 0
Kd 0.8 0.4 0.3
map_Kd -s 1 1 1 textures/brick.png
newmtl mesh wire
Kd 1 1 1
map_Kd textures/wire.png
newmtl slates
Kd 0.2 0.2 0.3
d 0.5
map_Kd textures\\slates.png
map_d textures/holes.png
"""
    holes = png(8, 8, [(255 if (x + y) % 3 else 0,) for y in range(8) for x in range(8)])
    return {
        "house.obj": "\r\n".join(lines).encode() + b"\r\n",
        "house materials.mtl": materials.encode(),
        "textures/brick.png": checkers(16, (180, 80, 60), (200, 190, 180)),
        "textures/wire.png": checkers(16, (90, 90, 90, 255), (0, 0, 0, 0)),
        "textures/slates.png": checkers(16, (60, 60, 80), (40, 40, 60)),
        "textures/holes.png": holes,
    }


def quads_from_the_end() -> str:
    """Quads whose corners count back from the last vertex, part by part, with tabs and a comment behind."""
    lines = []
    for part in (torus(12, 6), box((2, 0, 0), (3, 1, 1))):
        lines += ["v\t" + " ".join(f"{x:.9g}" for x in point) for point in part[0]]
        count = len(part[0])
        lines += ["f " + " ".join(str(i - count) for i in face) + "  # a quad" for face in part[1]]
    return "\n".join(lines)  # no end of line at the end


def star(corners: int) -> Mesh:
    """A face of many corners that is not convex."""
    points: list[Point] = []
    for i in range(corners):
        radius, angle = 1 if i % 2 else 2, 2 * math.pi * i / corners
        points.append((rounded(radius * math.cos(angle)), rounded(radius * math.sin(angle)), 0.25))
    return points, [tuple(range(corners))]


def city() -> Mesh:
    """Faces of blocks that all lie between voxels, where grids tie; neighbors share faces."""
    blocks = []
    for x in range(8):
        for z in range(8):
            height = 1 + (5 * x + 3 * z + x * z) % 4
            blocks.append(box((x, 0, z), (x + 1, height, z + 1)))
    return join(*blocks)


# ---- PLY ----


def ply_head(form: str, lines: list[str]) -> bytes:
    return "\n".join(["ply", f"format {form} 1.0", "comment a stand-in", *lines, "end_header", ""]).encode()


def scan(form: str) -> bytes:
    """What scanners write: no normals, but a confidence; vertices that no face has, and holes."""
    points, faces = torus()
    points = points + [(9.0, 9.0, 9.0)]
    faces = triangles(faces)[:-40]
    head = [f"element vertex {len(points)}", *(f"property float {axis}" for axis in "xyz")]
    head += ["property float confidence", "property uchar intensity"]
    head += [f"element face {len(faces)}", "property list uchar int vertex_indices"]
    out = ply_head(form, head)
    if form == "ascii":
        rows = [" ".join(f"{x:.9g}" for x in point) + " 0.5 7" for point in points]
        rows += [f"{len(face)} " + " ".join(map(str, face)) for face in faces]
        return out + "\n".join(rows).encode() + b"\n"
    order = ">" if form == "binary_big_endian" else "<"
    out += b"".join(struct.pack(order + "4fB", *point, 0.5, 7) for point in points)
    return out + b"".join(struct.pack(order + "B3i", 3, *face) for face in faces)


def scan_in_strips() -> bytes:
    """Triangle strips in one list, as tools of the Stanford repository write them: -1 begins another strip."""
    rings, sides = 16, 8
    points, _ = torus(rings, sides)
    strip: list[int] = []
    for i in range(rings):
        for k in range(sides + 1):
            strip += [i * sides + k % sides, (i + 1) % rings * sides + k % sides]
        strip.append(-1)
    head = [f"element vertex {len(points)}", *(f"property float {axis}" for axis in "xyz")]
    head += ["element tristrips 1", "property list int int vertex_indices"]
    out = ply_head("binary_little_endian", head) + b"".join(struct.pack("<3f", *point) for point in points)
    return out + struct.pack(f"<i{len(strip)}i", len(strip), *strip)


def colored_quads() -> bytes:
    """Double coordinates, colors and normals at vertices, quads, an element that is none of ours between."""
    points, faces = box((-1, -1, -1), (1, 1, 1))
    head = [f"element vertex {len(points)}", *(f"property double {axis}" for axis in "xyz")]
    head += [f"property float n{axis}" for axis in "xyz"] + [f"property uchar {c}" for c in ("red", "green", "blue")]
    head += ["element sample 1", "property int number"]
    head += [f"element face {len(faces)}", "property list uchar uint vertex_index"]
    out = ply_head("binary_little_endian", head)
    for point in points:
        out += struct.pack("<3d3f3B", *point, *(x / math.sqrt(3) for x in point), *(int(127 + 127 * x) for x in point))
    return out + struct.pack("<i", 7) + b"".join(struct.pack("<B4I", 4, *face) for face in faces)


# ---- STL and OFF ----


def stl(mesh: Mesh, head: bytes = b"a stand-in", normal: Point = (0, 0, 0)) -> bytes:
    faces = triangles(mesh[1])
    out = head.ljust(80, b" ") + struct.pack("<I", len(faces))
    for face in faces:
        out += struct.pack("<3f", *normal) + b"".join(struct.pack("<3f", *mesh[0][i]) for i in face) + b"\0\0"
    return out


def stl_text(*meshes: Mesh) -> str:
    lines = []
    for number, mesh in enumerate(meshes):
        lines.append(f"solid part {number}")
        for face in triangles(mesh[1]):
            lines += ["  facet normal 0 0 0", "    outer loop"]
            lines += ["      vertex " + " ".join(f"{x:e}" for x in mesh[0][i]) for i in face]
            lines += ["    endloop", "  endfacet"]
        lines.append(f"endsolid part {number}")
    return "\n".join(lines) + "\n"


def off(mesh: Mesh) -> str:
    lines = ["OFF", "# a stand-in", f"{len(mesh[0])} {len(mesh[1])} 0"]
    lines += [" ".join(f"{x:.9g}" for x in point) for point in mesh[0]]
    return "\n".join(lines + [f"{len(face)} " + " ".join(map(str, face)) for face in mesh[1]]) + "\n"


# ---- glTF ----


def gltf_parts(embed: bool) -> tuple[dict, bytes]:
    """One mesh that four nodes place below one another, turned and scaled, one of them mirrored; a texture that
    repeats, with holes; no normals."""
    points, quads = torus(12, 8)
    faces = triangles(quads)
    data = b"".join(struct.pack("<3f", *point) for point in points)
    texels_at = len(data)
    data += b"".join(struct.pack("<2f", i % 8 / 4, i // 8 / 4) for i in range(len(points)))
    indices_at = len(data)
    data += b"".join(struct.pack("<3H", *face) for face in faces)
    data += b"\0" * (-len(data) % 4)
    picture_at = len(data)
    picture = checkers(16, (200, 60, 60, 255), (0, 0, 0, 0))
    data += picture + b"\0" * (-len(picture) % 4)
    views = [(0, texels_at), (texels_at, indices_at - texels_at), (indices_at, 6 * len(faces))]
    views.append((picture_at, len(picture)))
    low = [min(point[a] for point in points) for a in range(3)]
    high = [max(point[a] for point in points) for a in range(3)]
    half = math.sqrt(0.5)
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [
            {"children": [1, 2], "scale": [2, 2, 2]},
            {"mesh": 0, "children": [3], "rotation": [half, 0, 0, half]},
            {"mesh": 0, "translation": [3, 0, 0], "scale": [-1, 1, 1]},
            {"mesh": 0, "matrix": [0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 0.5, 0, 0, 2, 0, 1], "children": [4]},
            {"mesh": 0, "translation": [0, 3, 0]},
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}]}],
        "materials": [
            {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}, "alphaMode": "MASK", "alphaCutoff": 0.5}
        ],
        "textures": [{"source": 0, "sampler": 0}],
        "samplers": [{"wrapS": 10497, "wrapT": 33071}],
        "images": [{"bufferView": 3, "mimeType": "image/png"}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(points), "type": "VEC3", "min": low, "max": high},
            {"bufferView": 1, "componentType": 5126, "count": len(points), "type": "VEC2"},
            {"bufferView": 2, "componentType": 5123, "count": 3 * len(faces), "type": "SCALAR"},
        ],
        "bufferViews": [{"buffer": 0, "byteOffset": at, "byteLength": size} for at, size in views],
        "buffers": [{"byteLength": len(data)}],
    }
    if embed:
        document["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    return document, data


def glb(document: dict, data: bytes) -> bytes:
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    size = 12 + 8 + len(text) + 8 + len(data)
    head = b"glTF" + struct.pack("<II", 2, size)
    return head + struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data


# ---- voxels ----


def chunk(name: bytes, content: bytes, children: bytes = b"") -> bytes:
    return name + struct.pack("<ii", len(content), len(children)) + content + children


def words(**pairs: str) -> bytes:
    out = struct.pack("<i", len(pairs))
    for text in (text.encode() for pair in pairs.items() for text in pair):
        out += struct.pack("<i", len(text)) + text
    return out


def model(size: tuple[int, int, int], voxels: list[tuple[int, int, int, int]]) -> bytes:
    """MagicaVoxel's axes: z is up."""
    return chunk(b"SIZE", struct.pack("<3i", *size)) + chunk(
        b"XYZI", struct.pack("<i", len(voxels)) + b"".join(bytes(voxel) for voxel in voxels)
    )


def figure(height: int) -> list[tuple[int, int, int, int]]:
    """Standing on z = 0, with a face to one side, so that a turn shows."""
    return [
        (x, y, z, 1 + (x + z) % 7)
        for z in range(height)
        for y in range(4)
        for x in range(6)
        if z < height - 3 or (1 <= x <= 4 and 1 <= y)
    ]


def transform(node: int, child: int, layer: int, **frame: str) -> bytes:
    return chunk(b"nTRN", struct.pack("<i", node) + words() + struct.pack("<4i", child, -1, layer, 1) + words(**frame))


def group(node: int, *children: int) -> bytes:
    content = struct.pack("<i", node) + words() + struct.pack(f"<i{len(children)}i", len(children), *children)
    return chunk(b"nGRP", content)


def shape(node: int, index: int) -> bytes:
    return chunk(b"nSHP", struct.pack("<i", node) + words() + struct.pack("<2i", 1, index) + words())


def layer(number: int, **names: str) -> bytes:
    return chunk(b"LAYR", struct.pack("<i", number) + words(**names) + struct.pack("<i", -1))


def palette() -> bytes:
    return chunk(b"RGBA", b"".join(bytes((i, 255 - i, i * 7 % 256, 255)) for i in range(256)))


def vox(content: bytes, version: int = 150) -> bytes:
    return b"VOX " + struct.pack("<i", version) + chunk(b"MAIN", b"", content)


def placed_figures() -> bytes:
    """A scene graph: groups in groups, models that several nodes share, turned ones, layers of which one is hidden."""
    nodes = transform(0, 1, -1) + group(1, 2, 4, 10)
    nodes += transform(2, 3, 0, _t="0 0 6") + shape(3, 0)
    nodes += transform(4, 5, 1, _t="20 5 10", _r="17") + group(5, 6, 8)
    nodes += transform(6, 7, 0, _t="3 -4 0") + shape(7, 0)
    nodes += transform(8, 9, 1, _t="-6 2 1", _r="40") + shape(9, 1)
    nodes += transform(10, 11, 2, _t="0 30 0", _hidden="1") + shape(11, 1)
    layers = layer(0, _name="people") + layer(1, _name="turned") + layer(2, _name="hidden", _hidden="1")
    models = model((6, 4, 12), figure(12)) + model((6, 4, 7), figure(7))
    return vox(models + nodes + layers + palette() + chunk(b"NOTE", b"\1\0\0\0\0\0\0\0"), 200)


def binvox() -> bytes:
    """Lines that are no keywords, and runs of one to 255 voxels."""
    solid = [
        8 <= x < 24 and 4 <= y < 28 and (x + y + z) % 5 > 0 for x in range(32) for z in range(32) for y in range(32)
    ]
    runs = bytearray()
    at = 0
    while at < len(solid):
        end = at
        while end < len(solid) and end - at < 255 and solid[end] == solid[at]:
            end += 1
        runs += bytes((solid[at], end - at))
        at = end
    return b"#binvox 1\ndim 32 32 32\ntranslate -1 -1 -1\nscale 2\ndata\n" + bytes(runs)


def svx(path: Path) -> None:
    """Densities of a ball, a slice of pixels for each y."""
    edge = 16
    manifest = f"""<?xml version="1.0"?>
<grid version="1.0" gridSizeX="{edge}" gridSizeY="{edge}" gridSizeZ="{edge}" voxelSize="0.1" subvoxelBits="8"
      slicesOrientation="Y">
  <channels><channel type="DENSITY" bits="8" slices="density/slice%04d.png"/></channels>
</grid>
"""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(zipfile.ZipInfo("manifest.xml"), manifest)
        for y in range(edge):
            texels = [
                (255 if (x - 7.5) ** 2 + (y - 7.5) ** 2 + (z - 7.5) ** 2 < 50 else 0,)
                for z in range(edge)
                for x in range(edge)
            ]
            archive.writestr(zipfile.ZipInfo(f"density/slice{y:04d}.png"), png(edge, edge, texels))


# ---- the files ----


def meshes() -> dict[str, bytes | str]:
    document, data = gltf_parts(False)
    return {
        **house(),
        "quads_from_the_end.obj": quads_from_the_end(),
        "star.obj": obj(star(66)),
        "city.obj": obj(city()),
        "colored.obj": "".join(f"v {x} {y} {z} {x} {y} {z}\n" for x, y, z in box()[0]) + obj(([], box()[1])),
        "far_away.obj": obj(moved(torus(), 0.25, (25400, -12700, 6350))),
        "scan_text.ply": scan("ascii"),
        "scan_big_endian.ply": scan("binary_big_endian"),
        "scan_little_endian.ply": scan("binary_little_endian"),
        "scan_in_strips.ply": scan_in_strips(),
        "colored_quads.ply": colored_quads(),
        "part.stl": stl(torus()),
        "part_solid.stl": stl(torus(), b"solid but binary"),
        "two_solids.stl": stl_text(torus(8, 6), box((3, 0, 0), (4, 1, 1))),
        "part.off": off(torus()),
        "placed.gltf": json.dumps(gltf_parts(True)[0]),
        "placed.glb": glb(document, data),
    }


def nasty() -> dict[str, bytes | str]:
    whole = torus(12, 8)
    open_box = (box()[0], box()[1][:-1])
    torn = join(open_box, moved(torus(8, 6), 0.3, (0.5, 0.5, 0.5)))
    needles = join(*(([(i, 0, 0), (i + 1, 1e-6, 0), (i + 1, 0, 1e-6)], [(0, 1, 2)]) for i in range(50)))
    soup = join(
        *(
            (
                [(math.sin(i), math.cos(3 * i), i / 40), (math.cos(i), i / 50, math.sin(2 * i)), (0.1, i / 60, 0.3)],
                [(0, 1, 2)],
            )
            for i in range(60)
        )
    )
    flat = ([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [(0, 1, 2, 3)])
    text = obj(whole)
    big = scan("binary_big_endian")
    cycle = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}]}
    return {
        "empty.obj": "",
        "empty.ply": b"",
        "empty.stl": b"",
        "points.obj": obj((whole[0], [])),
        "utf16.obj": text.encode("utf-16-be"),
        "no_number.obj": "v nan 0 0\n" + text,
        "infinite.obj": text.replace("v ", "v inf 0 0\nv ", 1),
        "index_zero.obj": text + "f 0 1 2\n",
        "index_beyond.obj": text + "f 1 2 999999\n",
        "index_overflow.obj": text + "f 1 2 99999999999999999999\n",
        "before_the_first.obj": "f -1 -2 -3\n" + text,
        "two_corners.obj": text + "f 1\nf 1 2\n",
        "same_corners.obj": text + "f 1 1 2\nf 3 3 3\n",
        "no_area.obj": obj(([(0, 0, 0), (1, 1, 1), (2, 2, 2)], [(0, 1, 2), (0, 0, 1)])),
        "twice.obj": obj((whole[0], whole[1] + whole[1])),
        "both_sides.stl": stl((whole[0], whole[1] + [face[::-1] for face in whole[1]])),
        "open_box.obj": obj(open_box),
        "torn.obj": obj(torn),
        "crossing.obj": obj(join(whole, moved(whole, 1, (0.3, 0.2, 0.1)))),
        "three_at_an_edge.obj": obj((box()[0] + [(0.5, 0.5, 2)], box()[1] + [(4, 5, 8)])),
        "concave_quads.obj": obj(([(0, 0, 0), (2, 0, 0), (0.5, 0.5, 0.2), (0, 2, 0)], [(0, 1, 2, 3), (3, 2, 1, 0)])),
        "long_line.obj": obj((star(900)[0], [tuple(range(900)) + tuple(range(0, 900, 2))])),
        "flat.obj": obj(flat),
        "large_and_tiny.obj": obj(join(flat, moved(flat, 1e-9, (0.1, 0.2, 0.3)))),
        "huge.obj": obj(moved(whole, 1e30, (0, 0, 0))),
        "tiny.obj": obj(moved(whole, 1e-42, (0, 0, 0))),
        "needles.stl": stl(needles),
        "soup.stl": stl(soup),
        "no_normals.stl": stl(whole, normal=(math.nan, math.nan, math.nan)),
        "count_too_large.stl": stl(whole)[:80] + struct.pack("<I", 99999) + stl(whole)[84:],
        "cut.stl": stl(whole)[:-20],
        "head_alone.stl": b" " * 83,
        "cut_vertices.ply": big[: len(big) // 4],
        "cut_faces.ply": big[:-7],
        "count_below_zero.ply": big.replace(b"element face ", b"element face -", 1),
        "count_of_millions.ply": big.replace(b"element vertex ", b"element vertex 9999999", 1),
        "no_ply.ply": b"plz" + big[3:],
        "grid.ply": ply_head("ascii", ["element range_grid 2", "property list uchar int vertex_indices"]) + b"0\n1 0\n",
        "out_of_memory.off": "OFF\n353535235358 6 0\n0 0 0\n",
        "no_area.off": off(([(0, 0, 0), (1, 0, 0), (2, 0, 0)], [(0, 1, 2), (2, 1, 0)])),
        "cycle.gltf": json.dumps({**cycle, "nodes": [{"children": [1]}, {"children": [0]}]}),
    }


def voxels() -> dict[str, bytes]:
    frames = chunk(b"PACK", struct.pack("<i", 2)) + model((6, 4, 12), figure(12)) + model((6, 4, 9), figure(9))
    sponge = [
        (x, y, z, 1 + (x * y + z) % 255)
        for z in range(27)
        for y in range(27)
        for x in range(27)
        if all((x // s % 3 == 1) + (y // s % 3 == 1) + (z // s % 3 == 1) < 2 for s in (1, 3, 9))
    ]
    return {
        "figure.vox": vox(model((6, 4, 12), figure(12)) + palette()),
        "default_palette.vox": vox(model((27, 27, 27), sponge)),
        "frames.vox": vox(frames + palette()),
        "placed.vox": placed_figures(),
        "twice.vox": vox(model((6, 4, 12), figure(12) + figure(12)[:20]) + palette()),
        "ball.binvox": binvox(),
    }


def write(folder: Path, files: dict) -> None:
    for name, content in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content if isinstance(content, bytes) else content.encode())


def main() -> int:
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    folder = Path(sys.argv[1])
    write(folder / "meshes", meshes())
    write(folder / "nasty", nasty())
    write(folder / "voxels", voxels())
    svx(folder / "voxels" / "ball.svx")
    return 0


if __name__ == "__main__":
    sys.exit(main())
