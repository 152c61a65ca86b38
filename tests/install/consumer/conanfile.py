# SPDX-License-Identifier: MIT
"""The test of the Conan package: the project of the README, with the package, builds and makes its octree."""

import os

from conan import ConanFile
from conan.tools.build import can_run
from conan.tools.cmake import CMake
from conan.tools.files import copy


class Consumer(ConanFile):
    settings = "os", "arch", "compiler", "build_type"
    generators = "CMakeDeps", "CMakeToolchain"

    def requirements(self):
        self.requires(self.tested_reference_str)

    def layout(self):
        self.folders.build = self.folders.generators = "build"

    def build(self):
        here, project = self.recipe_folder, os.path.join(self.build_folder, "project")
        copy(self, "CMakeLists.txt", here, project)
        copy(self, "main.c", os.path.join(here, *[os.pardir] * 3, "samples", "01_minimal"), project)
        cmake = CMake(self)
        cmake.configure(build_script_folder=project)
        cmake.build()

    def test(self):
        if can_run(self):
            self.run(os.path.join(self.build_folder, "voxels"), env="conanrun")
