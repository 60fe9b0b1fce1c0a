"""Tools that some tests need beside Python."""

from __future__ import annotations

import os
import shutil

import pytest


def requires(tool: str, name: str | None = None) -> str:
    """The path of a program, or a skip; a failure if LEAKREF_REQUIRE holds `name` (default: the program's)."""
    found = shutil.which(tool)
    if found is None and (name or tool) in os.environ.get("LEAKREF_REQUIRE", ""):
        pytest.fail(f"{tool} is required (LEAKREF_REQUIRE) and not installed")
    if found is None:
        pytest.skip(f"{tool} is not installed")
    return found
