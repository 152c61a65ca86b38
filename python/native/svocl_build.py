# SPDX-License-Identifier: MIT
"""The build backend: scikit-build-core's, whose source distributions carry the library's sources too.

In the repository those lie beside python/. A source distribution has them in source/, and its own build is
scikit-build-core's alone.
"""

import contextlib
import os
import re
import shutil
import tempfile
from collections.abc import Iterator
from typing import Optional, Union

from scikit_build_core import build
from scikit_build_core.build import *  # the other hooks  # noqa: F403

PACKAGE = ("CMakeLists.txt", "README.md", "pyproject.toml", "examples", "native", "src", "tests")
LIBRARY = ("CMakeLists.txt", "LICENSE", "cmake", "include", "kernels", "lib", "tools/web")


def build_sdist(  # type: ignore[no-redef]
    sdist_directory: str, config_settings: Optional[dict[str, Union[str, list[str]]]] = None
) -> str:
    """Writes the source distribution of the current folder, python/ of the repository or one that is unpacked."""
    if os.path.isdir("source"):
        return build.build_sdist(sdist_directory, config_settings)
    target = os.path.abspath(sdist_directory)
    # In a folder of its own: nothing appears in the repository, not even when the process is killed.
    with tempfile.TemporaryDirectory() as folder:
        _copy(PACKAGE, os.curdir, folder)
        _copy(LIBRARY, os.pardir, os.path.join(folder, "source"))
        _read_version_of_copy(os.path.join(folder, "pyproject.toml"))
        with _inside(folder):
            return build.build_sdist(target, config_settings)


def _copy(names: tuple[str, ...], source: str, target: str) -> None:
    """Copies files and folders, without what interpreters, tests and editors leave there."""
    os.makedirs(target, exist_ok=True)
    for name in names:
        start, end = os.path.join(source, name), os.path.join(target, name)
        if os.path.isdir(start):
            shutil.copytree(start, end, ignore=shutil.ignore_patterns(".*", "__pycache__", "*.pyc", "*~"))
        else:
            shutil.copy2(start, end)


def _read_version_of_copy(path: str) -> None:
    """Changes the one path of pyproject.toml that leads out of python/, to the header with the version."""
    with open(path, encoding="utf-8") as file:
        text, count = re.subn(r'^(input = ")\.\./', r"\1source/", file.read(), flags=re.MULTILINE)
    if count != 1:
        raise RuntimeError(f'pyproject.toml: {count} lines input = "../...", expected 1')
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)


@contextlib.contextmanager
def _inside(folder: str) -> Iterator[None]:
    """Makes it the current folder, as the hooks want it."""
    before = os.getcwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)
