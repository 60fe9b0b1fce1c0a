"""The checks, a module a family. Importing them registers them (`leakref.certify.registry`)."""

from __future__ import annotations

import importlib

__all__ = ["load"]


def load() -> None:
    """Import every family."""
    from leakref.certify.registry import FAMILIES

    for family in FAMILIES:
        importlib.import_module(f"leakref.certify.checks.{family}")
