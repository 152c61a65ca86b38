# SPDX-License-Identifier: MIT
"""The package as installed: what it carries, and that the binding has all that the headers have."""

import ctypes
import glob
import importlib.metadata
import os
import subprocess
import sys
import tarfile
from pathlib import Path

import pytest

import svocl
from svocl import _driver, _generated, _native
from svocl._native import ffi, lib


def test_version():
    assert svocl.__version__ == importlib.metadata.version("svocl")


def test_the_wheel_carries_the_library_and_no_loader():
    names = [str(path) for path in importlib.metadata.files("svocl")]
    assert "svocl/py.typed" in names and any(name.endswith("licenses/LICENSE") for name in names)
    assert not [name for name in names if "OpenCL" in name or name.endswith((".h", ".a", ".cmake", ".pc"))]
    assert [name for name in names if ".so" in name] == ["svocl/_native.abi3.so"]
    needed = subprocess.run(["ldd", _native.__file__], check=True, stdout=subprocess.PIPE, text=True).stdout
    assert "libOpenCL.so.1" in needed and "libsvocl" not in needed
    if svocl.has_io:
        assert os.access(os.path.join(os.path.dirname(_native.__file__), "svocl-import"), os.X_OK)


def test_the_source_distribution_is_whole(tmp_path):
    """It has the library's sources and the wheel's metadata, it is the same bytes in each run and of its own unpacked
    copy, and nothing is left beside what it was made of."""
    pytest.importorskip("scikit_build_core")
    python = Path(__file__).parents[1]
    if not (python / "native").is_dir():
        pytest.skip("the tests of an installed package")
    before = sorted(python.rglob("*"))
    code = "import sys, svocl_build; print(svocl_build.build_sdist(sys.argv[1], {'build-dir': 'build'}))"
    environment = {**os.environ, "PYTHONPATH": "native", "PYTHONDONTWRITEBYTECODE": "1"}

    def make(source, target):
        command = [sys.executable, "-c", code, str(target)]
        done = subprocess.run(command, cwd=source, env=environment, check=True, stdout=subprocess.PIPE, text=True)
        return target / done.stdout.split()[-1]

    archive = make(python, tmp_path / "first")
    assert make(python, tmp_path / "second").read_bytes() == archive.read_bytes()
    with tarfile.open(archive) as tar:
        tar.extractall(tmp_path)
    unpacked = tmp_path / archive.name[: -len(".tar.gz")]
    assert make(unpacked, tmp_path / "third").read_bytes() == archive.read_bytes()
    assert sorted(python.rglob("*")) == before
    for name in (
        "CMakeLists.txt",
        "LICENSE",
        "lib/pipeline/build.c",
        "include/svocl/version.h",
        "kernels/stages/scan.cl",
    ):
        assert (unpacked / "source" / name).is_file(), name
    assert not [path for path in unpacked.rglob("*") if path.name == "__pycache__" or path.name.startswith(".")]
    metadata = importlib.metadata.distribution("svocl").read_text("METADATA")
    assert (unpacked / "PKG-INFO").read_text(encoding="utf-8") == metadata


def test_without_an_opencl_loader():
    """The import fails with what to install; other failures keep their own words."""
    code = """
import sys
class Finder:
    def find_spec(self, name, path, target=None):
        if name == "svocl._native":
            raise ImportError(sys.argv[1])
sys.meta_path.insert(0, Finder())
import svocl
"""

    def last_line(words):
        done = subprocess.run([sys.executable, "-c", code, words], stderr=subprocess.PIPE, text=True)
        assert done.returncode == 1
        return done.stderr.splitlines()[-1]

    missing = "libOpenCL.so.1: cannot open shared object file: No such file or directory"
    assert missing in last_line(missing) and "apt install ocl-icd-libopencl1" in last_line(missing)
    assert last_line("libm.so.6: cannot open") == "ImportError: libm.so.6: cannot open"


def test_pocl_of_pip(tmp_path, monkeypatch):
    """Where the system has no driver, the loader gets that of pip; without a compiler, with the linker of pip alone,
    which is spared the compiler's libraries."""
    for file in ("pocl_binary_distribution/__init__.py", "pyopencl/.libs/libpocl-1.so"):
        (tmp_path / file).parent.mkdir(parents=True)
        (tmp_path / file).touch()
    monkeypatch.syspath_prepend(tmp_path)
    found = glob.glob
    drivers = ["/etc/OpenCL/vendors/some.icd"]
    monkeypatch.setattr(glob, "glob", lambda at: drivers if at.startswith("/etc/") else found(at))
    for name, value in (("PATH", "/nowhere"), ("OCL_ICD_VENDORS", ""), ("OPENCL_VENDOR_PATH", "")):
        monkeypatch.setenv(name, value)  # and back to what it was
        if not value:
            del os.environ[name]
    _driver.use_pocl_of_pip()
    assert "OCL_ICD_VENDORS" not in os.environ
    drivers.clear()
    with pytest.warns(RuntimeWarning, match=r"PoCL of pip links kernels by ld and libgcc.*svocl\[linker\]"):
        _driver.use_pocl_of_pip()
    assert "OCL_ICD_VENDORS" not in os.environ
    (tmp_path / "ziglang").mkdir()
    (tmp_path / "ziglang" / "__init__.py").touch()
    zig = tmp_path / "ziglang" / "zig"
    zig.write_text('#!/bin/sh\necho "$@"\n')
    zig.chmod(0o755)
    importlib.invalidate_caches()
    _driver.use_pocl_of_pip()
    assert os.environ["OCL_ICD_VENDORS"] == str(tmp_path / "pyopencl/.libs/libpocl-1.so")
    command = ["ld", "-shared", "-lgcc", "kernel.o", "-lc", "-o", "a b.so"]
    linked = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout
    assert linked == "ld.lld -shared kernel.o -o a b.so\n"


def test_the_module_exports_nothing_of_the_library():
    """Another svocl in the process neither sees nor changes this one."""
    module = ctypes.CDLL(_native.__file__)
    assert hasattr(module, "PyInit__native") and not hasattr(module, "svo_build")


def test_enumerations_are_complete():
    """Each enumerator that cffi finds in the headers is in Python, under its name without the prefix."""
    enumerations = {
        "svo_status": (_generated.Status, "SVO_"),
        "svo_need": (_generated.Need, "SVO_NEED_"),
        "svo_axes": (_generated.Axes, "SVO_AXES_"),
        "svo_coverage": (_generated.Coverage, "SVO_COVERAGE_"),
        "svo_place": (_generated.Place, "SVO_PLACE_"),
        "svo_weights": (_generated.Weights, "SVO_WEIGHTS_"),
        "svo_builder": (_generated.Builder, "SVO_BUILDER_"),
        "svo_certainty": (_generated.Certainty, "SVO_BYTES_"),
        "svo_trace_flags": (_generated.TraceMode, "SVO_TRACE_"),
        "svo_render_view": (_generated.View, "SVO_VIEW_"),
        "svo_wrap": (_generated.Wrap, "SVO_WRAP_"),
        "svo_positions": (_generated.Positions, "SVO_POSITIONS_"),
        "svo_tree_buffer": (_generated.TreeBuffer, "SVO_TREE_"),
        "svo_form": (_generated.Form, "SVO_FORM_"),
        "svo_compact_buffer": (_generated.CompactBuffer, "SVO_COMPACT_"),
        "svo_solid_rule": (_generated.SolidRule, "SVO_SOLID_"),
        "svo_scene_flags": (_generated.SceneTrace, "SVO_SCENE_"),
        "svo_light_form": (_generated.LightForm, "SVO_LIGHT_"),
        "svo_probes_buffer": (_generated.ProbeBuffer, "SVO_PROBES_"),
        "svo_opacity": (_generated.Opacity, "SVO_OPACITY_"),
        "svo_light_buffer": (_generated.LightBuffer, "SVO_LIGHT_"),
    }
    counts = {"svo_form": "COUNT", "svo_light_form": "FORM_COUNT"}
    for name, (kind, prefix) in enumerations.items():
        expected = {text[len(prefix) :]: value for text, value in ffi.typeof(name).relements.items()}
        expected.pop(counts.get(name, "BUFFER_COUNT"), None)
        assert {member: int(value) for member, value in kind.__members__.items()} == expected, name


def test_structs_are_complete():
    """Each field that cffi finds in the headers' results is in Python, but for those named here."""
    structs = {
        "svo_plan_info": (_generated.PlanInfo, set()),
        "svo_import_info": (_generated.ImportInfo, set()),
        "svo_buffer_info": (_generated.PlanBuffer, set()),
        "svo_left_out": (_generated.LeftOut, set()),
        "svo_kernels_info": (_generated.Kernels, set()),
        "svo_tree_info": (_generated.TreeInfo, set()),
        "svo_tree_arrays": (svocl.TreeArrays, set()),
        "svo_camera": (svocl.Camera, set()),
        "svo_compact_info": (_generated.CompactInfo, set()),
        "svo_compact_arrays": (svocl.CompactArrays, set()),
        "svo_solid_info": (_generated.SolidInfo, set()),
        "svo_voxels_info": (_generated.VoxelsInfo, set()),
        "svo_voxel_file_info": (_generated.VoxelFileInfo, set()),
        "svo_voxels_save_info": (_generated.VoxelsSaveInfo, set()),
        "svo_points_info": (_generated.PointsInfo, set()),
        "svo_scene_info": (_generated.SceneInfo, {"reserved"}),
        "svo_light_info": (_generated.LightInfo, set()),
        "svo_light_source": (svocl.LightSource, {"reserved"}),
        "svo_moving_report": (_generated.MovingReport, set()),
        "svo_moving_bvh_report": (_generated.MovingBvhReport, {"reserved"}),
        "svo_moving_info": (_generated.MovingInfo, {"reserved"}),
        "svo_moving_object": (_generated.MovingObject, set()),
        "svo_probe_info": (_generated.ProbeInfo, set()),
        "svo_paged_info": (_generated.PagedInfo, set()),
        "svo_paged_counts": (_generated.PagedCounts, set()),
        "svo_parts_tree_info": (_generated.PartsTreeInfo, {"reserved"}),
        "svo_scene_light": (svocl.SceneLight, {"reserved"}),
        # OpenGL's, and those of enqueued builds; stage_times are stages.
        "svo_build_report": (_generated.BuildReport, {"inner_nodes", "renderer", "stage_times"}),
    }
    for name, (kind, left_out) in structs.items():
        fields = {field for field, _ in ffi.typeof(name).fields} - {"struct_size"} - left_out
        assert set(kind._fields) - {"stages"} == fields, name


def test_records_have_the_layout_of_the_headers():
    for name, dtype in {
        "svo_ray": svocl.ray_dtype,
        "svo_hit": svocl.hit_dtype,
        "svo_query_point": svocl.query_dtype,
        "svo_nearest": svocl.nearest_dtype,
        "svo_voxel_hit": svocl.voxel_hit_dtype,
        "svo_scene_hit": svocl.scene_hit_dtype,
        "svo_scene_triangle_hit": svocl.scene_triangle_hit_dtype,
        "svo_instance": svocl.instance_dtype,
        "svo_voxel": svocl.voxel_dtype,
        "svo_point": svocl.point_dtype,
        "svo_gather_point": svocl.gather_point_dtype,
        "svo_gather_result": svocl.gather_result_dtype,
        "svo_probe_hit": svocl.probe_hit_dtype,
        "svo_probe_irradiance": svocl.probe_irradiance_dtype,
    }.items():
        offsets = {field: description.offset for field, description in ffi.typeof(name).fields}
        assert {field: dtype.fields[field][1] for field in dtype.names} == offsets
        assert dtype.itemsize == ffi.sizeof(name)
    assert lib.SVO_TREE_ARGUMENTS == svocl.TREE_ARGUMENTS
    assert lib.SVO_COMPACT_ARGUMENTS == svocl.COMPACT_ARGUMENTS
    assert lib.SVO_LIGHT_ARGUMENTS == svocl.LIGHT_ARGUMENTS


def test_all_names_exist_and_are_documented():
    for name in svocl.__all__:
        value = getattr(svocl, name)
        assert not callable(value) or value.__doc__, name


TYPED = """
import numpy as np
import svocl

mesh = svocl.Mesh(np.zeros((3, 3), np.float32))
with svocl.Device() as device:
    tree = device.plan(mesh, 3, need=svocl.Need.RAYS, progress=True).build(progress=lambda stage, part: part > 0.5)
    reveal_type(tree.arrays.child_mask.dtype)
    tree.trace(svocl.make_rays([0, 0, 0], [0, 0, 1]), mode=%s)
"""


def test_type_hints(tmp_path):
    """mypy takes the package in its strictest mode, sees its hints from outside (py.typed), and finds a mistake."""
    pytest.importorskip("mypy")
    (tmp_path / "right.py").write_text(TYPED % "svocl.TraceMode.ANY")
    (tmp_path / "wrong.py").write_text(TYPED % '"any"')
    command = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(tmp_path / "cache")]
    command += ["-m", "right", "-m", "wrong", "-p", "svocl"]
    done = subprocess.run(command, cwd=tmp_path, stdout=subprocess.PIPE, text=True)
    assert 'right.py:8: note: Revealed type is "numpy.dtype[numpy.unsignedinteger' in done.stdout, done.stdout
    errors = [line for line in done.stdout.splitlines() if "error:" in line]
    assert len(errors) == 1 and errors[0].startswith('wrong.py:9: error: Argument "mode"'), done.stdout
