# SPDX-License-Identifier: MIT
"""A fixture for pytest. Name it in conftest.py: pytest_plugins = ["svocl.pytest_plugin"]."""

from collections.abc import Iterator

import pytest

from ._device import Device


@pytest.fixture(scope="session")
def svocl_device() -> Iterator[Device]:
    """One device for all tests of a session, so that kernels are compiled once."""
    with Device() as device:
        yield device
