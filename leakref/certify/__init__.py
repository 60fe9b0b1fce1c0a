"""Is a code that measures currents right? `parametrize_with_checks` puts the checks into its own tests.

The rooms below: `checks` holds the questions and their tolerances, `subject` the ways to reach a code under test and
its frame, `strength` the study of the checks themselves. `runner` runs checks, `certificate` says what they amount to,
`report` makes pages of it, `commands` is `leakref certify`, and `pytesting` the same inside somebody's own tests.
Nothing here changes the code under test, and nothing needs its source.
"""

from __future__ import annotations

from typing import Any

__all__ = ["parametrize_with_checks"]


def __getattr__(name: str) -> Any:
    """Load it on first use: nothing else here needs pytest."""
    if name != "parametrize_with_checks":
        raise AttributeError(f"module 'leakref.certify' has no attribute {name!r}")
    from leakref.certify.pytesting import parametrize_with_checks

    return parametrize_with_checks
