# SPDX-License-Identifier: MIT
"""What the tests share: one device, so that kernels are compiled once, and two meshes; and the mesh of the
tests of clusters."""

import numpy as np
import pytest
import shapes
from cluster import DEPTH, write_torus

import svocl


@pytest.fixture(scope="session")
def device():
    with svocl.Device() as made:
        yield made


@pytest.fixture(scope="session")
def cube():
    return svocl.Mesh(shapes.CUBE_POSITIONS, shapes.CUBE_INDICES)


@pytest.fixture(scope="session")
def torus():
    return svocl.Mesh(*shapes.torus())


@pytest.fixture(scope="session")
def tree(device, torus):
    """A torus with everything that rays need."""
    with device.build(torus, 5, need=svocl.Need.RAYS) as made:
        yield made


@pytest.fixture(scope="module")
def mesh_file(tmp_path_factory):
    return write_torus(tmp_path_factory.mktemp("mesh") / "torus.obj")


@pytest.fixture(scope="module")
def mesh(mesh_file):
    return svocl.read_mesh(mesh_file)


@pytest.fixture(scope="module")
def whole(device, mesh):
    """The hash of that tree in one piece."""
    with device.build(mesh, DEPTH) as tree:
        return tree.hash()


@pytest.fixture
def random():
    seed = 14
    print(f"seed {seed}")
    return np.random.default_rng(seed)
