# SPDX-License-Identifier: MIT
"""Prints the package's version and folder, and the hash of a mesh file's octree: hash.py FILE DEPTH."""

import importlib.metadata
import os
import sys

import svocl

tree = svocl.Device().build(svocl.read_mesh(sys.argv[1]), int(sys.argv[2]))
print(importlib.metadata.version("svocl"), os.path.dirname(svocl.__file__), tree.hash())
