# SPDX-License-Identifier: MIT
"""The examples run: scripts as programs, the notebook cell by cell in a kernel of its own, the gallery in this one."""

import importlib.util
import pathlib
import re
import runpy
import subprocess
import sys

import numpy as np
import pytest

import svocl

EXAMPLES = pathlib.Path(__file__).parent.parent / "examples"


@pytest.mark.skipif(not svocl.has_io, reason="built without svocl::io")
def test_occlusion(tmp_path):
    for arguments in ([], ["first.ply", "-o", "second.ply"]):
        command = [sys.executable, str(EXAMPLES / "occlusion.py"), *arguments, "--rays", "16"]
        done = subprocess.run(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        assert done.returncode == 0, done.stdout
        written = tmp_path / (arguments[-1] if arguments else "occlusion.ply")
        assert f"{written.name}: 2304 vertices see " in done.stdout
        mesh = svocl.read_mesh(written)
        assert (mesh.vertex_count, mesh.triangle_count) == (2304, 4608)
        gray = mesh.colors[:, 0].astype(float)
        outside = np.linalg.norm(mesh.positions - [0.5, 0, 0], axis=1) > 1.75  # the far ends of the linked tori
        assert gray[outside].mean() > 200 > gray.mean() > 100
        written.rename(tmp_path / "first.ply")


@pytest.mark.skipif(not svocl.has_io, reason="built without svocl::io")
def test_bake(tmp_path):
    image = pytest.importorskip("PIL.Image")
    command = [sys.executable, str(EXAMPLES / "bake.py"), "--lightmap", "map.png", "--size", "64", "--paths", "16"]
    done = subprocess.run(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    assert done.returncode == 0, done.stdout
    assert "map.png: 100% of the texels lie in charts" in done.stdout
    mesh = svocl.read_mesh(tmp_path / "baked.ply")
    floor = mesh.positions[:, 1] == mesh.positions[:, 1].min()
    gray = mesh.colors[:, 1].astype(float)
    assert floor.sum() >= 129 * 129 and gray[floor].max() > 200 > gray[floor].min() + 40  # the shadow lies on it
    pixels = np.asarray(image.open(tmp_path / "map.png"))
    assert pixels.shape == (64, 64, 3) and pixels[..., 1].max() > 200 > pixels[..., 1].min() + 40
    content = (tmp_path / "map.exr").read_bytes()
    linear = np.frombuffer(content[-64 * (8 + 12 * 64) :], np.uint8).reshape(64, -1)[:, 8:].copy().view("<f4")
    red = 0.7 * linear.reshape(64, 3, 64)[:, 2] / np.pi  # blue, green, red; an albedo of 0.7
    coded = np.where(red <= 0.0031308, 12.92 * red, 1.055 * red ** (1 / 2.4) - 0.055)
    assert np.abs(np.clip(coded, 0, 1) * 255 - pixels[..., 0]).max() <= 1


GALLERY = sorted((EXAMPLES / "gallery").glob("*.py"))


@pytest.mark.parametrize("path", GALLERY, ids=[path.stem for path in GALLERY])
def test_gallery(path):
    """Each script of docs/gallery.md draws something, at a low resolution."""
    picture = runpy.run_path(str(path))["picture"](depth=5, width=64)
    assert picture.shape[:2] == (48, 64) and picture.dtype == np.uint8
    assert len(np.unique(picture.reshape(-1, picture.shape[2]), axis=0)) > 40


def test_gallery_page():
    """docs/gallery.md shows each script as it is, and a picture of it."""
    docs = EXAMPLES.parents[1] / "docs"
    if not (docs / "gallery.md").exists():
        pytest.skip("the tests of a source distribution, without docs/")
    page = (docs / "gallery.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    assert sorted(blocks) == sorted(path.read_text(encoding="utf-8") for path in GALLERY) and len(GALLERY) == 8
    pictures = re.findall(r"!\[[^\]]+\]\((gallery/\w+\.png)\)", page)
    assert sorted(pictures) == [f"gallery/{path.stem}.png" for path in GALLERY]
    assert sum((docs / picture).stat().st_size for picture in pictures) < 400_000


STEPS = ("model", "voxels", "rays", "light", "motion", "kernel")


@pytest.mark.parametrize("step", STEPS)
def test_tutorial(step, tmp_path, monkeypatch, capsys):
    """Each step of docs/tutorial.md runs, and draws something at a low resolution."""
    if step == "kernel":
        pytest.importorskip("pyopencl")
    monkeypatch.chdir(tmp_path)  # where the tree's file goes
    monkeypatch.syspath_prepend(str(EXAMPLES / "tutorial"))  # as for a program that is run there
    picture = runpy.run_path(str(EXAMPLES / "tutorial" / f"{step}.py"))["picture"](depth=5, width=64)
    assert picture.ndim == 3 and picture.dtype == np.uint8
    assert len(np.unique(picture.reshape(-1, picture.shape[2]), axis=0)) > 12
    printed = capsys.readouterr().out
    if step == "voxels":
        assert "depth 5: 2016 voxels" in printed
        assert not svocl.has_io or svocl.Tree.load("voxels.svo").info.leaf_count == 2016
    elif step == "motion":
        assert printed.count("voxels") == 3
    else:
        assert step == "light" or re.search(r"\d", printed)


def test_tutorial_page():
    """docs/tutorial.md shows the steps in their order, each as it is, and a picture of it."""
    docs = EXAMPLES.parents[1] / "docs"
    if not (docs / "tutorial.md").exists():
        pytest.skip("the tests of a source distribution, without docs/")
    page = (docs / "tutorial.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    assert blocks == [(EXAMPLES / "tutorial" / f"{step}.py").read_text(encoding="utf-8") for step in STEPS]
    assert sorted(STEPS) == sorted(path.stem for path in (EXAMPLES / "tutorial").glob("*.py"))
    pictures = re.findall(r"!\[[^\]]+\]\((tutorial/\w+\.png)\)", page)
    assert pictures == [f"tutorial/{step}.png" for step in STEPS]
    assert sum((docs / picture).stat().st_size for picture in pictures) < 200_000


def test_notebook(tmp_path):
    nbclient = pytest.importorskip("nbclient")
    nbformat = pytest.importorskip("nbformat")
    pytest.importorskip("ipykernel")
    pytest.importorskip("PIL")
    notebook = nbformat.read(EXAMPLES / "octree.ipynb", as_version=4)
    assert all(not cell.get("outputs") for cell in notebook.cells), "stored outputs: clear them before a commit"
    nbclient.NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(tmp_path)}}).execute()
    pictures = [
        output.data["image/png"]
        for cell in notebook.cells
        for output in cell.get("outputs", [])
        if "image/png" in output.get("data", {})
    ]
    assert len(pictures) == 4
    pages = [
        output.data["text/html"]
        for cell in notebook.cells
        for output in cell.get("outputs", [])
        if "srcdoc" in str(output.get("data", {}).get("text/html"))
    ]
    assert len(pages) == 1 and "allow-scripts" in pages[0]


def test_readme(tmp_path, monkeypatch, capsys):
    """The Python blocks of README.md run as they stand there, with smaller pictures, one after the other."""
    cl = pytest.importorskip("pyopencl")
    pytest.importorskip("tqdm")
    blocks = re.findall(r"```python\n(.*?)```", (EXAMPLES.parent / "README.md").read_text(), re.DOTALL)
    assert len(blocks) == 10
    assert sum(block.count("(640, 480") for block in blocks) == 5
    blocks = [block.replace("(640, 480", "(160, 120") for block in blocks]  # pictures take most of the time
    names = {}
    monkeypatch.chdir(tmp_path)
    if not svocl.has_io:
        blocks = [re.sub(r"^    (\w+\.save)", r"    # \1", block, flags=re.MULTILINE) for block in blocks]
    exec(blocks[0], names)
    assert names["hits"]["triangle"].tolist() == [0] and names["hits"]["t"] == pytest.approx(1)
    assert not svocl.has_io or svocl.Tree.load("mesh.svo").hash() == names["tree"].hash()
    forms = blocks.pop(1)
    exec(forms, names)
    assert names["solid"].solid_info.open_columns == (0, 0, 0) and names["picture"].shape == (120, 160, 4)
    painting = blocks.pop(1)
    if importlib.util.find_spec("trimesh"):
        exec(painting, names)
        assert (tmp_path / "ball.html").stat().st_size > (tmp_path / "ball.png").stat().st_size > 1000
    exec(blocks.pop(1), names)
    assert names["picture"].any() and names["light"].info.photon_hits > 0
    moving = blocks.pop(1)
    exec(moving, names)
    assert names["moving"].closed and names["angle"] == 0.2
    parts, paged, testing = blocks.pop(1), blocks.pop(1), blocks.pop(1)
    if svocl.has_io:
        exec(parts, names)
        assert svocl.Tree.load("mesh.svo").info.leaf_count == names["tree"].info.leaf_count
        exec(paged, names)
        assert names["picture"].shape == (120, 160, 4) and names["picture"].any() and names["paged"].closed
        exec(testing, names)
    context = cl.create_some_context(interactive=False)
    monkeypatch.setattr(cl, "create_some_context", lambda: context)
    rays, hits = svocl.make_rays([[0.2, 0.2, -1]], [0, 0, 1]), np.zeros(1, svocl.hit_dtype)
    names["rays_buffer"] = cl.Buffer(context, cl.mem_flags.COPY_HOST_PTR, hostbuf=rays)
    names["hits_buffer"] = cl.Buffer(context, cl.mem_flags.READ_WRITE, hits.nbytes)
    names["count"] = 1
    exec(blocks[1], names)
    cl.enqueue_copy(
        names["queue"], hits, names["hits_buffer"], wait_for=[cl.Event.from_int_ptr(names["event"].int_ptr)]
    )
    assert np.array_equal(hits, names["hits"])
    assert names["buffer"].size >= names["tree"].info.inner_count
    capsys.readouterr()
    exec(blocks[2], names)
    printed = capsys.readouterr()
    assert "100%|" in printed.err and re.search(r"^voxelize: \d+%$", printed.out, re.MULTILINE)
    names["deadline"] = 0
    with pytest.raises(svocl.CanceledError):
        names["device"].build(names["mesh"], 8, progress=names["report"])
