# SPDX-License-Identifier: MIT
"""Trees as pages for browsers and notebooks, and pictures as PNG.

The page is that of `svocl export-web`: its template, scripts and shaders are files in the folder page/ beside this
one, and docs/web.md describes what stands in it. Here the tree's arrays become its data.
"""

import base64
import html
import json
import pathlib
import re
import struct
import zlib
from collections.abc import Iterator
from typing import Any, NamedTuple, Optional

import numpy as np
import numpy.typing as npt

from . import _arrays
from ._errors import text
from ._generated import Need, TreeInfo
from ._native import lib

NOTEBOOK_BYTES = 4 << 20
"""Of a page in a notebook, which is saved with the notebook."""

_FILES = pathlib.Path(__file__).parent / "page"
_STEP = 16  # nodes of an entry of the directory
_BLOCK_BYTES = 3 << 18  # of the data in an element: a megabyte of base64
_LEVEL_BYTES_MIN = 1 << 14  # levels of fewer bytes share an end of the compressed data
_BOUNDS_LEVEL = 6  # the deepest that is searched for what is occupied
_SHORT = np.float32(0.04)  # the length of a normal, squared, up to which the face's is shown


class _Payload(NamedTuple):
    """Colors or normals: the element of a node is at (node - first) * stride."""

    rows: npt.NDArray[np.uint8]
    first: int
    stride: int

    def count(self, nodes: int) -> int:
        """Of so many nodes from the root on."""
        return max(nodes - self.first, 0) if self.stride else 1

    def words(self, nodes: int) -> Optional[dict[str, int]]:
        count = self.count(nodes)
        return {"count": count, "first": self.first, "stride": self.stride} if count else None


class _Data(NamedTuple):
    """What a page has of a tree."""

    info: TreeInfo
    masks: npt.NDArray[np.uint8]
    directory: npt.NDArray[np.uint32]
    colors: Optional[_Payload]
    normals: Optional[_Payload]
    low: list[int]
    """The box of what is occupied, in voxels."""
    high: list[int]


def page(tree: Any, name: str, max_bytes: int) -> tuple[str, int]:
    """The page of a tree, and the deepest level in it: the last with which the page has at most max_bytes."""
    data = _data(tree)
    for level in range(data.info.depth, 0, -1):
        packed = _pack(data, level, max_bytes)
        if packed is not None:
            made = _fill(_description(data, level, name, packed), packed)
            if len(made.encode()) <= max_bytes:
                return made, level
    raise ValueError(f"max_bytes: {max_bytes} is too small for a page of the first level alone")


def inline(tree: Any) -> str:
    """The page in a frame, for a notebook; what is left out of it is said below."""
    made, level = page(tree, "tree", NOTEBOOK_BYTES)
    frame = (
        f'<iframe srcdoc="{html.escape(made)}" title="svocl: tree" sandbox="allow-scripts allow-pointer-lock" '
        'style="width: 100%; height: 560px; border: 0"></iframe>'
    )
    depth = tree.info.depth
    if level == depth:
        return frame
    return (
        f"{frame}\n<p>Levels {level + 1} to {depth} are left out: with them the page would exceed "
        f"{NOTEBOOK_BYTES >> 20} MiB. Tree.to_html takes another limit.</p>"
    )


def png(picture: npt.NDArray[np.uint8]) -> bytes:
    """A picture, (height, width, 4) or (height, width, 3) uint8, as the bytes of a PNG file.

    Args:
        picture: as Tree.render returns it.
    """
    channels = picture.shape[2] if isinstance(picture, np.ndarray) and picture.ndim == 3 else 0
    if channels not in (3, 4):
        raise ValueError("picture: expected an array of shape (height, width, 3) or (height, width, 4)")
    pixels = _arrays.integers("picture", picture, np.uint8, ("height", "width", channels))
    height, width = pixels.shape[:2]
    rows = pixels.reshape(height, width * channels)
    above = np.concatenate([np.zeros((1, width * channels), np.uint8), rows[:-1]])
    filtered = np.concatenate([np.full((height, 1), 2, np.uint8), rows - above], axis=1)  # the filter "up"
    head = struct.pack(">IIBBBBB", width, height, 8, 2 if channels == 3 else 6, 0, 0, 0)
    chunks = ((b"IHDR", head), (b"IDAT", zlib.compress(filtered.tobytes(), 9)), (b"IEND", b""))
    made = b"\x89PNG\r\n\x1a\n"
    for kind, content in chunks:
        made += struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
    return made


# --- the tree -------------------------------------------------------------------------------------------------------


def _data(tree: Any) -> _Data:
    info, arrays = tree.info, tree.arrays
    first = info.level_begin[info.payload_level]

    def payload(need: Need, rows: Any) -> Optional[_Payload]:
        if rows is None or len(rows) == 0:
            return None
        constant = bool(info.constant & need)
        return _Payload(rows[:1] if constant else rows, 0 if constant else first, 0 if constant else 1)

    normals = None if arrays.normals is None else _octahedral(arrays.normals)
    level = min(info.depth, _BOUNDS_LEVEL)
    cells = tree.voxels(level).astype(np.int64)
    width = 2 ** (info.depth - level)
    low, high = ([0] * 3, [0] * 3) if len(cells) == 0 else (cells.min(axis=0) * width, (cells.max(axis=0) + 1) * width)
    return _Data(
        info,
        arrays.child_mask,
        arrays.first_child[::_STEP],
        payload(Need.COLOR, arrays.colors),
        payload(Need.NORMAL, normals),
        [int(value) for value in low],
        [int(value) for value in high],
    )


def _octahedral(normals: npt.NDArray[np.int16]) -> npt.NDArray[np.uint8]:
    """(count, 2): each coordinate 128 + round(127 p) (Meyer et al., "On Floating-Point Normal Vectors", 2010). 0, 0 of
    short ones."""
    n = normals.astype(np.float32) / np.float32(32767)
    x, y, z = n.T
    total = np.abs(x) + np.abs(y) + np.abs(z)
    is_long = x * x + y * y + z * z > _SHORT
    total[~is_long] = 1
    u, v = x / total, y / total
    below = z < 0
    one = np.float32(1)
    folded_u = (one - np.abs(v)) * np.where(u >= 0, one, -one)
    v = np.where(below, (one - np.abs(u)) * np.where(v >= 0, one, -one), v)
    u = np.where(below, folded_u, u)
    coded = np.float32(128) + np.rint(np.float32(127) * np.stack([u, v], axis=1))
    return np.where(is_long[:, None], coded, 0).astype(np.uint8)


# --- the data -------------------------------------------------------------------------------------------------------


def _mask_counts(data: _Data, level: int) -> tuple[int, int]:
    """Masks and entries of the directory down to a level."""
    masks = data.info.level_begin[level]
    return masks, -(-masks // _STEP)


def _byte_count(data: _Data, level: int) -> int:
    """Of the unpacked data down to a level."""
    nodes = data.info.level_begin[level + 1]
    parts = ((data.colors, 4), (data.normals, 2))
    payload = sum(part.count(nodes) * size for part, size in parts if part is not None)
    return (_STEP + 4) * _mask_counts(data, level)[1] + payload


def _additions(data: _Data, level: int, last: int) -> Iterator[bytes]:
    """What a level adds to those above it, in a page whose deepest one is last."""
    above = _mask_counts(data, level - 1)[1] if level > 1 else 0
    here = _mask_counts(data, level)[1]
    masks = data.masks[: data.info.level_begin[last]][_STEP * above : _STEP * here].tobytes()
    yield masks.ljust(_STEP * (here - above), b"\0")
    yield data.directory[above:here].astype("<u4").tobytes()
    nodes = data.info.level_begin
    for part in (data.colors, data.normals):
        if part is not None:
            yield part.rows[part.count(nodes[level]) if level > 1 else 0 : part.count(nodes[level + 1])].tobytes()


class _Packed(NamedTuple):
    """The data as gzip (RFC 1952), which can be unpacked up to each end."""

    content: bytes
    ends: list[int]


def _pack(data: _Data, last: int, limit: int) -> Optional[_Packed]:
    """None: more than limit bytes, in base64."""
    stream = zlib.compressobj(9, zlib.DEFLATED, 31)
    made, ends, ended = bytearray(), [], 0
    for level in range(1, last + 1):
        for part in _additions(data, level, last):
            made += stream.compress(part)
        if level == last:
            made += stream.flush()
        elif _byte_count(data, level) - ended >= _LEVEL_BYTES_MIN:
            made += stream.flush(zlib.Z_SYNC_FLUSH)
        else:
            continue
        ended = _byte_count(data, level)
        ends.append(len(made))
        if 4 * len(made) > 3 * limit:
            return None
    return _Packed(bytes(made), ends)


# --- the page -------------------------------------------------------------------------------------------------------


def _description(data: _Data, level: int, name: str, packed: _Packed) -> dict[str, Any]:
    """The JSON that the scripts find."""
    info = data.info
    nodes = info.level_begin[level + 1]
    scale = 2 ** (info.depth - level)
    return {
        "version": text(lib.svo_version_string()),
        "name": name,
        "depth": info.depth,
        "level": level,
        "voxels": info.leaf_count,
        "leaves": nodes - info.level_begin[level],
        "nodes": list(info.level_begin[1 : level + 2]),
        "bytes": _byte_count(data, level),
        "packed": len(packed.content),
        "colors": data.colors and data.colors.words(nodes),
        "normals": data.normals and data.normals.words(nodes),
        "light": None,
        "low": [value / scale for value in data.low],
        "high": [value / scale for value in data.high],
        "origin": list(info.origin),
        "edge": info.edge / 2**level,
        "view": 0,
        "camera": {"up": [0, 1, 0], "fov": 0},
    }


def _fill(description: dict[str, Any], packed: _Packed) -> str:
    """The template, in which the files stand in place of the elements that name them."""
    written = json.dumps(description, separators=(",", ":"), ensure_ascii=False)
    for character in "<\u2028\u2029":  # which end elements, and lines in older JavaScript
        written = written.replace(character, f"\\u{ord(character):04x}")

    def read(name: str) -> str:
        return "\n" + (_FILES / name).read_text(encoding="utf-8")

    made = read("page.html").lstrip("\n")
    made = made.replace('<link rel="stylesheet" href="page.css">', f"<style>{read('page.css')}</style>")
    made = made.replace('type="application/json">null<', f'type="application/json">{written}<')
    shader = r'(<script id="(\w+)(?:-shader)?" type="x-shader/x-glsl">)(</script>)'
    made = re.sub(shader, lambda found: f"{found[1]}{read(f'{found[2]}.glsl')}{found[3]}", made)
    made = re.sub(r'<script src="(\w+\.js)"></script>', lambda found: f"<script>{read(found[1])}</script>", made)
    return made.replace('<script id="data"></script>', "".join(_blocks(packed)))


def _blocks(packed: _Packed) -> Iterator[str]:
    """The data in elements, each of which is handed over as soon as the parser is there."""
    begin = 0
    for end in packed.ends:
        for at in range(begin, end, _BLOCK_BYTES):
            coded = base64.b64encode(packed.content[at : min(at + _BLOCK_BYTES, end)]).decode()
            yield f'<script type="application/octet-stream">{coded}</script><script>take()</script>\n'
        begin = end
