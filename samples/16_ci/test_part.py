# SPDX-License-Identifier: MIT
"""The tree of part.obj is the one of part.svo. Run by: pytest samples/16_ci"""

import pathlib

import svocl
from svocl.testing import assert_trees_equal

pytest_plugins = ["svocl.pytest_plugin"]
HERE = pathlib.Path(__file__).parent


def test_part(svocl_device):
    with svocl_device.build(svocl.read_mesh(HERE / "part.obj"), 5) as tree:
        assert_trees_equal(HERE / "part.svo", tree)
