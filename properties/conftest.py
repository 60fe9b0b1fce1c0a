"""Fixtures of the properties: what is examined, and the modules behind it."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings

from leakref.methods import DEFAULT, METHODS
from leakref.plugin import ASKED

from .examined import Examined, reference
from .strategies import PROFILES

settings.register_profile("thorough", PROFILES["thorough"][0])  # so that --hypothesis-profile knows the name


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """The checks are for an implementation that is named; of the reference they are tested elsewhere."""
    asked = config.pluginmanager.has_plugin(ASKED)
    return True if collection_path.name == "test_certification.py" and not asked else None


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """The reference is examined by the paper's methods; with --slow, or thoroughly, by each of the others as well."""
    asked = metafunc.config.pluginmanager.has_plugin(ASKED)
    if "examined" in metafunc.fixturenames and "modules" not in metafunc.fixturenames and not asked:
        everything = metafunc.config.getoption("--slow", False) or os.environ.get("LEAKREF_PROPERTIES") == "thorough"
        ways = {"paper": DEFAULT} | {name: (name,) for name in METHODS if everything and name not in DEFAULT}
        metafunc.parametrize("examined", list(ways.values()), ids=list(ways), indirect=True, scope="session")


@pytest.fixture(scope="session")
def examined(request: pytest.FixtureRequest) -> Examined:
    """The reference, or what --leakref-implementation or --leakref-command names."""
    asked = request.config.pluginmanager.get_plugin(ASKED)
    return getattr(asked, "examined", None) or reference(getattr(request, "param", DEFAULT))


@pytest.fixture(scope="session")
def modules(examined: Examined) -> Any:
    """The modules of the chain, for properties of its inside."""
    if examined.modules is None:
        pytest.skip("of the inside of the reference")  # which another implementation need not have
    return examined.modules
