"""Fixtures of the properties: what is examined, and the modules behind it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings

from leakref.plugin import ASKED

from .examined import Examined, reference
from .strategies import PROFILES

settings.register_profile("thorough", PROFILES["thorough"][0])  # so that --hypothesis-profile knows the name


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """The checks are for an implementation that is named; of the reference they are tested elsewhere."""
    asked = config.pluginmanager.has_plugin(ASKED)
    return True if collection_path.name == "test_certification.py" and not asked else None


@pytest.fixture(scope="session")
def examined(request: pytest.FixtureRequest) -> Examined:
    """The reference, or what --leakref-implementation or --leakref-command names."""
    asked = request.config.pluginmanager.get_plugin(ASKED)
    return getattr(asked, "examined", None) or reference()


@pytest.fixture(scope="session")
def modules(examined: Examined) -> Any:
    """The modules of the chain, for properties of its inside."""
    if examined.modules is None:
        pytest.skip("of the inside of the reference")  # which another implementation need not have
    return examined.modules
