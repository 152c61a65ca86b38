# SPDX-License-Identifier: MIT
"""Trees as pages and pictures: those that notebooks show, and that of the program."""

import base64
import html
import json
import os
import re
import struct
import subprocess
import zlib

import numpy as np
import pytest

import svocl
from svocl import _page

NEED = svocl.Need.COLOR | svocl.Need.NORMAL


@pytest.fixture(scope="module", params=["varied", "constant", "none"])
def shown(request, device, torus):
    """Trees with colors and normals, with colors that are constant, and without both."""
    colors = np.full((torus.vertex_count, 4), 255, np.uint8)
    if request.param == "varied":
        colors[:, :3] = (127 + 60 * torus.positions).astype(np.uint8)
    mesh = svocl.Mesh(torus.positions, torus.indices, colors=colors)
    need = svocl.Need.NONE if request.param == "none" else NEED
    with device.build(mesh, 7, need=need) as tree:
        yield tree


def parts(page):
    """What stands around the tree's data, its description, and its data unpacked, after each of its blocks."""
    around, begin, ends = page, "", []
    found = re.search(r'<script id="tree" type="application/json">(.*?)</script>', page)
    data, unpack = b"", zlib.decompressobj(31)
    for block in re.findall(r'<script type="application/octet-stream">(.*?)</script>', page):
        data += unpack.decompress(base64.b64decode(block))
        ends.append(len(data))
    around = re.sub(r'<script type="application/octet-stream">.*?</script>', "", page.replace(found[1], begin))
    assert unpack.eof
    return around, json.loads(found[1]), data, ends


@pytest.mark.skipif(not svocl.has_io, reason="built without svocl::io")
@pytest.mark.parametrize("max_bytes", [1 << 25, 95_000])
def test_the_page_is_that_of_the_program(shown, tmp_path, max_bytes):
    program = os.environ.get("SVOCL_PROGRAM")
    if not program:
        pytest.skip("SVOCL_PROGRAM names no program")
    shown.save(tmp_path / "tree.svo")
    command = [program, "export-web", "tree.svo", "-o", "tree.html", "--max-bytes", str(max_bytes)]
    done = subprocess.run(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    page = shown.to_html(name="tree.svo", max_bytes=max_bytes)
    assert done.returncode == 0, done.stdout
    expected = parts((tmp_path / "tree.html").read_text(encoding="utf-8"))
    made = parts(page)
    for description in (expected[1], made[1]):
        description.pop("packed")  # zlib's version decides
    assert made == expected
    assert len(page.encode()) <= max_bytes
    assert made[1]["level"] == 7 or max_bytes < 1 << 25


def test_pages_have_a_limit(shown):
    with pytest.raises(ValueError, match="max_bytes: 5000 is too small for a page of the first level alone"):
        shown.to_html(max_bytes=5000)


def test_names_end_no_element(device, cube):
    with device.build(cube, 2) as tree:
        page = tree.to_html(name="</script><b>\u2028")
    assert "</script><b>" not in page and parts(page)[1]["name"] == "</script><b>\u2028"


def test_trees_from_files_have_pages(shown, tmp_path):
    if svocl.has_io:
        shown.save(tmp_path / "tree.svo")
        loaded = svocl.Tree.load(tmp_path / "tree.svo")
        assert loaded.to_html() == shown.to_html() and loaded._repr_png_() is None


def test_notebooks_show_the_page(shown, monkeypatch):
    shown_page = re.search(r'srcdoc="([^"]*)"', shown._repr_html_())[1]
    assert html.unescape(shown_page) == shown.to_html(max_bytes=4 << 20)
    assert "are left out" not in shown._repr_html_()
    monkeypatch.setattr(_page, "NOTEBOOK_BYTES", 95_000)
    cut = shown._repr_html_()
    level = parts(html.unescape(re.search(r'srcdoc="([^"]*)"', cut)[1]))[1]["level"]
    assert level == 7 or f"<p>Levels {level + 1} to 7 are left out: " in cut


def test_closed_trees_show_nothing(device, cube):
    tree = device.build(cube, 2)
    tree.close()
    assert tree._repr_html_() is None and tree._repr_png_() is None


def unpacked(content):
    """The pixels of a PNG with the filter "up"."""
    assert content[:8] == b"\x89PNG\r\n\x1a\n"
    at, chunks = 8, {}
    while at < len(content):
        (count,) = struct.unpack(">I", content[at : at + 4])
        kind, data = content[at + 4 : at + 8], content[at + 8 : at + 8 + count]
        assert struct.unpack(">I", content[at + 8 + count : at + 12 + count])[0] == zlib.crc32(kind + data)
        chunks[kind], at = data, at + 12 + count
    width, height, bits, color = struct.unpack(">IIBB", chunks[b"IHDR"][:10])
    rows = np.frombuffer(zlib.decompress(chunks[b"IDAT"]), np.uint8).reshape(height, -1)
    assert bits == 8 and (rows[:, 0] == 2).all()
    return np.cumsum(rows[:, 1:], axis=0, dtype=np.uint8).reshape(height, width, 4 if color == 6 else 3)


def test_png(tree, random):
    picture = tree.render(64, 48)
    assert np.array_equal(unpacked(svocl.png(picture)), picture)
    assert unpacked(tree._repr_png_()).shape == (480, 640, 4)
    noise = random.integers(0, 256, (5, 7, 3), np.uint8)
    assert np.array_equal(unpacked(svocl.png(noise)), noise)
    with pytest.raises(ValueError, match=r"picture: expected an array of shape \(height, width, 3\) or"):
        svocl.png(noise[0])
    with pytest.raises(TypeError, match="picture: dtype float64, expected uint8"):
        svocl.png(noise / 255)
