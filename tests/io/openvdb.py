# SPDX-License-Identifier: MIT
"""OpenVDB reads the .vdb files that svocl writes, with equal values, and svocl those that OpenVDB writes.

usage: openvdb.py PROGRAM

Files of OpenVDB are made here: they are compressed by BLOSC, with halves, bits, tiles and several grids.
"""

import json
import os
import shutil
import subprocess
import sys
import tempfile

import numpy as np
import pyopenvdb as vdb

PROGRAM = os.path.abspath(sys.argv[1])
SIDE = 48


def svocl(*words):
    done = subprocess.run([PROGRAM, *words], check=False, capture_output=True, text=True)
    assert done.returncode == 0, (words, done.stderr)
    return done


def linear(byte):
    """sRGB's curve, of IEC 61966-2-1."""
    coded = byte / 255
    return coded / 12.92 if coded <= 0.04045 else ((coded + 0.055) / 1.055) ** 2.4


def write_points(path, voxels):
    """A point cloud with a point at the center of each voxel, and its color."""
    with open(path, "w", encoding="ascii") as file:
        file.write(f"ply\nformat ascii 1.0\nelement vertex {len(voxels)}\n")
        file.write("".join(f"property double {axis}\n" for axis in "xyz"))
        file.write("".join(f"property uchar {name}\n" for name in ("red", "green", "blue")))
        file.write("end_header\n")
        for place, color in voxels.items():
            file.write(" ".join(str((at + 0.5) * 0.25) for at in place) + " %d %d %d\n" % color)


def read_points(path):
    """The voxels of a list that svocl writes as .ply: places, and colors with alpha and material."""
    text = svocl("convert", path, "out.ply", "-q") and open("out.ply", "rb").read()
    head, body = text.split(b"end_header\n", 1)
    kinds = {"double": "<f8", "float": "<f4", "uchar": "u1", "ushort": "<u2", "uint": "<u4", "int": "<i4"}
    fields = [line.split()[1:] for line in head.decode().splitlines() if line.startswith("property")]
    return np.frombuffer(body, [(name, kinds[kind]) for kind, name in fields])


def places_of(points, width, first):
    return {tuple(int(round((point[axis] - start) / width)) for axis, start in zip("xyz", first)) for point in points}


def active(grid):
    """The active voxels of a grid, tiles unfolded, with their values."""
    found = {}
    for item in grid.citerOnValues():
        low, high = item.min, item.max
        for x in range(low[0], high[0] + 1):
            for y in range(low[1], high[1] + 1):
                for z in range(low[2], high[2] + 1):
                    found[x, y, z] = item.value
    return found


def check_written_voxels():
    random = np.random.default_rng(5)
    voxels = {}
    for extent in (6, 300, 9000):
        for place in random.integers(-extent, extent, (200, 3)).tolist():
            voxels[tuple(place)] = tuple(random.integers(0, 255, 3).tolist())
    write_points("cloud.ply", voxels)
    svocl("convert", "cloud.ply", "cloud.vdb", "--voxel-size", "0.25", "--axes", "keep", "--counts", "-q")
    density, color = (vdb.read("cloud.vdb", name) for name in ("density", "color"))
    assert density.gridClass == "fog volume" and density.background == 0
    origin = density.transform.indexToWorld((0, 0, 0))
    step = density.transform.indexToWorld((1, 1, 1))
    assert all(b - a == 0.25 for a, b in zip(origin, step)), (origin, step)
    found, colors = active(density), active(color)
    assert found.keys() == colors.keys() and len(found) == len(voxels)
    assert set(found.values()) == {1.0}
    for place, value in colors.items():
        world = [start + 0.25 * at for start, at in zip(origin, place)]
        expected = voxels[tuple(int(np.floor(at / 0.25)) for at in world)]
        assert np.allclose(value, [linear(byte) for byte in expected], rtol=1e-6, atol=0), (place, value, expected)

    if shutil.which("vdb_print") is not None:  # which knows whole numbers too
        lines = subprocess.run(["vdb_print", "cloud.vdb"], check=True, capture_output=True, text=True).stdout
        assert [line.split()[:2] for line in lines.splitlines()] == [
            ["color", "vec3s"],
            ["density", "float"],
            ["material", "int32"],
        ], lines


def check_written_distances():
    for band, name in ((3.0, "band"), (0.0, "dense")):
        words = ["scene:cube", "-d", "5", "--band", str(band), "--margin", "5"]
        svocl("sdf", *words, "-o", "ball.vdb", "-q")
        info = json.loads(svocl("sdf", *words, "-o", "ball.npy", "--json").stdout)
        grids, _ = vdb.readAll("ball.vdb")
        assert [grid.name for grid in grids] == ["surface"] and grids[0].gridClass == "level set"
        grid = grids[0]
        field = np.load("ball.npy")
        values = active(grid)
        assert len(values) == info["voxels"], (len(values), info["voxels"])
        side = 1 << info["depth"]
        dense = np.zeros((side, side, side), np.float32)
        grid.copyToArray(dense)
        if band == 0:
            assert np.array_equal(dense, field), name
            signs = dense < 0
        else:
            width = np.float32(band * info["spacing"])
            outer = np.ones_like(dense, bool)
            for place, value in field.tolist():
                outer[tuple(place)] = False
                assert dense[tuple(place)] == value == values[tuple(place)] and abs(value) < width
            assert set(np.abs(dense[outer]).tolist()) == {width.item()}
            signs_of_band = dense < 0
    assert np.array_equal(signs, signs_of_band), "other signs outside of the band"


def ball(dtype, level):
    at = np.indices((SIDE, SIDE, SIDE)).astype(np.float64) - 0.5 * SIDE + 0.3
    distance = np.sqrt((at**2).sum(0)) - 0.4 * SIDE
    return np.clip(distance, -level, level).astype(dtype)


def check_read():
    cases = {}
    shell = ball(np.float32, 3)
    level_set = vdb.FloatGrid(3.0)
    level_set.copyFromArray(shell)
    level_set.signedFloodFill()
    level_set.gridClass = vdb.GridClass.LEVEL_SET
    level_set.name = "surface"
    inside = {tuple(place) for place in np.argwhere(shell < 0).tolist()}
    cases["level"] = ([level_set], inside)
    half = level_set.deepCopy()
    half.saveFloatAsHalf = True
    cases["half"] = ([half], inside)
    bits = vdb.BoolGrid(False)
    bits.copyFromArray(shell < 0)
    cases["bits"] = ([bits], inside)
    fog = vdb.FloatGrid(0.0)
    fog.fill((-9, -9, -9), (150, 8, 8), 1.0)  # tiles of 8 voxels
    fog.pruneInactive()
    cube = {(x, y, z) for x in range(-9, 151) for y in range(-9, 9) for z in range(-9, 9)}
    heat = fog.deepCopy()
    fog.name, heat.name = "density", "heat"
    colors = vdb.Vec3SGrid()
    colors.fill((-9, -9, -9), (150, 8, 8), (linear(17.0), linear(188.0), 1.0))
    colors.name = "Cd"
    cases["several"] = ([fog, colors, heat], cube)
    instance = vdb.createLinearTransform(0.5)
    shared = fog.copy()
    shared.name = "shared"
    shared.transform = instance
    cases["instance"] = ([fog, shared], cube)
    for name, (grids, expected) in cases.items():
        path = name + ".vdb"
        vdb.write(path, grids=grids)
        words = svocl("convert", path, "again.vdb", "-q").stderr
        points = read_points(path)
        found = places_of(points, 1.0, (0, 0, 0))
        assert found == expected, (name, len(found), len(expected))
        again = active(vdb.read("again.vdb", "density"))
        assert again.keys() == expected, name
        if name == "several":
            assert "heat" in svocl("convert", path, "again.vdb").stderr, words
            assert {tuple(point)[-4 if "alpha" in point.dtype.names else -3 :][:3] for point in points} == {
                (17, 188, 255)
            }


with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    check_written_voxels()
    check_written_distances()
    check_read()
