# SPDX-License-Identifier: MIT
"""What the tests share: one device, so that kernels are compiled once, and two meshes."""

import numpy as np
import pytest
import shapes

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


@pytest.fixture
def random():
    seed = 14
    print(f"seed {seed}")
    return np.random.default_rng(seed)
