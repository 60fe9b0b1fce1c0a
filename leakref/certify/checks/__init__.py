"""The checks, a module a family. Importing them registers them (`leakref.certify.registry`)."""

from __future__ import annotations

import importlib

from leakref.certify.registry import CHECKS, FAMILIES, Check

__all__ = ["load"]


def load() -> dict[str, Check]:
    """Every check by id, all families imported."""
    for family in FAMILIES:
        importlib.import_module(f"leakref.certify.checks.{family}")
    return CHECKS
