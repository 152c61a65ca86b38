# SPDX-License-Identifier: MIT
"""svocl as a Conan 2 package, from the folder that this file is in: a clone, or an unpacked archive of one.

    conan create . --build=missing

makes the libraries svocl::svocl, svocl::io (option io) and svocl::gl (option gl), and tests them by the program of the
README. svocl::gl takes the headers of OpenGL, EGL and OSMesa that the system has.
"""

import os
import re

from conan import ConanFile
from conan.tools.cmake import CMake, CMakeDeps, CMakeToolchain
from conan.tools.files import copy, load, rmdir
from conan.tools.gnu import PkgConfigDeps

# What svocl::svocl and svocl::io need, with the library that is linked where the platform has it (platform_requires);
# without one: headers alone.
BASE = {
    "opencl-headers": ("[>=2022.01.04]", None),
    "opencl-icd-loader": ("[>=2022.01.04]", "OpenCL"),
    "xxhash": ("[>=0.8 <0.9]", None),
}
IO = {
    "assimp": ("[>=5.2 <7]", "assimp"),
    "c-blosc": ("[>=1.21 <2]", "blosc"),
    "cjson": ("[>=1.7 <2]", "cjson"),
    "expat": ("[>=2.4 <3]", "expat"),
    "fast_float": ("[>=3.4 <9]", None),
    "libzip": ("[>=1.7 <2]", "zip"),
    "stb": ("[>=cci.20220000]", None),
    "zlib": ("[>=1.2.11 <2]", "z"),
    "zstd": ("[>=1.5 <2]", "zstd"),
}


class Svocl(ConanFile):
    name = "svocl"
    description = "exact sparse voxel octrees of triangle meshes with OpenCL"
    license = "MIT"
    topics = ("voxel", "octree", "opencl", "mesh", "ray-tracing")
    package_type = "library"
    settings = "os", "arch", "compiler", "build_type"
    options = {"shared": [True, False], "fPIC": [True, False], "io": [True, False], "gl": [True, False]}
    default_options = {"shared": False, "fPIC": True, "io": True, "gl": False}
    implements = ["auto_shared_fpic"]
    exports_sources = "CMakeLists.txt", "LICENSE", "cmake/*", "glinterop/*", "include/*", "kernels/*", "lib/*"
    test_package_folder = "tests/install/consumer"

    def set_version(self):
        header = load(self, os.path.join(self.recipe_folder, "include", "svocl", "version.h"))
        self.version = re.search(r'SVO_VERSION_STRING "([^"]+)"', header).group(1)

    def config_options(self):
        if self.settings.os == "Windows":  # svocl::io and svocl::gl call POSIX
            self.options.rm_safe("fPIC")
            self.options.io = False

    def configure(self):
        if not self.options.io:  # C alone
            self.settings.rm_safe("compiler.cppstd")
            self.settings.rm_safe("compiler.libcxx")

    def requirements(self):
        for name, (versions, _) in {**BASE, **(IO if self.options.io else {})}.items():
            is_public = name.startswith("opencl")
            self.requires(f"{name}/{versions}", transitive_headers=is_public, transitive_libs=is_public)

    def generate(self):
        toolchain = CMakeToolchain(self)
        for part in ("TOOLS", "TESTS", "SAMPLES"):
            toolchain.cache_variables[f"SVOCL_{part}"] = False
        toolchain.cache_variables["SVOCL_IO"] = bool(self.options.io)
        toolchain.cache_variables["SVOCL_GL"] = bool(self.options.gl)
        toolchain.cache_variables["SVOCL_INSTALL"] = True
        toolchain.generate()
        packages = CMakeDeps(self)
        packages.set_property("opencl-icd-loader", "cmake_file_name", "OpenCL")
        packages.set_property("opencl-icd-loader", "cmake_target_name", "OpenCL::OpenCL")
        packages.generate()
        PkgConfigDeps(self).generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        copy(self, "LICENSE", self.source_folder, os.path.join(self.package_folder, "licenses"))
        CMake(self).install()
        rmdir(self, os.path.join(self.package_folder, "lib", "cmake"))
        rmdir(self, os.path.join(self.package_folder, "lib", "pkgconfig"))

    def package_info(self):
        self._describe("svocl", BASE)
        if self.options.io:
            self._describe("io", IO)
        if self.options.gl:
            self._describe("gl", {})

    def _describe(self, name, needed):
        """The component of a library, with the names that CMake and pkg-config know from other installations."""
        component = self.cpp_info.components[name]
        component.libs = ["svocl" if name == "svocl" else f"svocl_{name}"]
        component.set_property("cmake_target_name", f"svocl::{name}")
        component.set_property("pkg_config_name", "svocl" if name == "svocl" else f"svocl-{name}")
        packages = {dependency.ref.name for dependency in self.dependencies.host.values()}
        component.requires = [f"{package}::{package}" for package in needed if package in packages]
        component.system_libs = [
            library for package, (_, library) in needed.items() if library and package not in packages
        ]
        if name != "svocl":
            component.requires.append("svocl")
        if not self.options.shared:
            component.defines = ["SVO_STATIC"]
        if self.settings.os in ("Linux", "FreeBSD"):
            component.system_libs += ["m"] if name == "svocl" else ["m", "dl"]
