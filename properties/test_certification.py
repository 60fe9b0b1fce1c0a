"""The checks of `leakref certify`, one test for each finding: on an implementation that is named, and on that only."""

from __future__ import annotations

import shlex

import pytest

from leakref.certify.checks.registry import Case, Check
from leakref.certify.pytesting import settle
from leakref.certify.runner import select
from leakref.plugin import ASKED

from .examined import Examined


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """The checks of the profile and the seed that are asked for."""
    asked = metafunc.config.pluginmanager.get_plugin(ASKED)
    pairs = select(profile=asked.profile, seed=asked.seed) if asked else select(profile="quick")
    metafunc.parametrize(("check", "case"), pairs, ids=[f"{check.id}[{case.id}]" for check, case in pairs])


def test_check(examined: Examined, check: Check, case: Case, pytestconfig: pytest.Config) -> None:
    """What the check says of its own tolerance; `leakref explain` prints it."""
    asked = pytestconfig.pluginmanager.get_plugin(ASKED)
    given = shlex.quote(asked.target or asked.command) if asked else None
    settle(check(examined.subject, case), f"--command {given}" if asked and asked.command else given)
