"""Is a code that measures currents right? `parametrize_with_checks` puts the checks into its own tests."""

from __future__ import annotations

from typing import Any

__all__ = ["parametrize_with_checks"]


def __getattr__(name: str) -> Any:
    """Load it on first use: nothing else here needs pytest."""
    if name != "parametrize_with_checks":
        raise AttributeError(f"module 'leakref.certify' has no attribute {name!r}")
    from leakref.certify.pytesting import parametrize_with_checks

    return parametrize_with_checks
