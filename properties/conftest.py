"""Fixtures of the properties: what is examined, and the rooms behind it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings

from leakref.properties.examined import Examined
from leakref.properties.strategies import PROFILES

settings.register_profile("thorough", PROFILES["thorough"][0])  # so that --hypothesis-profile knows the name


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """The checks are run on an implementation that is named; of the reference they are tested elsewhere."""
    return True if collection_path.name == "test_certification.py" and _asked(config) is None else None


def _asked(config: pytest.Config) -> Any:
    return config.pluginmanager.get_plugin("leakref-asked")


@pytest.fixture(scope="session")
def examined(request: pytest.FixtureRequest) -> Iterator[Examined]:
    """The reference, or what --leakref-implementation or --leakref-command names."""
    from leakref.properties.examined import reference

    asked = _asked(request.config)
    return reference() if asked is None else asked.examined()


@pytest.fixture(scope="session")
def rooms(examined: Examined) -> Any:
    """The rooms of the chain, for properties of its inside."""
    if examined.rooms is None:
        pytest.skip("of the inside of the reference")
    return examined.rooms
