"""The checks, a module a family. Importing them registers them (`leakref.certify.checks.registry`)."""

from __future__ import annotations

import importlib

from leakref.certify.checks.registry import CHECKS, FAMILIES, Check

__all__ = ["load"]


def load() -> dict[str, Check]:
    """Every check by id, all families imported."""
    for family in FAMILIES:
        importlib.import_module(f"leakref.certify.checks.{family}")
    return CHECKS
