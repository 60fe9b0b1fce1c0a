"""An implementation under another name."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from leakref.certify.subject.declaration import GIVEN, WATER
from leakref.certify.subject.inprocess import accepts

__all__ = ["Named"]


class Named:
    """An implementation under another name, its stages those of `inner`; with `null` instead of a row of NaN."""

    def __init__(self, inner: Any, name: str, *, null: bool = True, **declared: object) -> None:
        self._inner, self._null, self._said = inner, null, {"name": name, **declared}

    def describe(self) -> Mapping[str, object]:
        """What the code declares of itself (guide protocol, section 3)."""
        extract = getattr(self._inner, "extract", None)
        told = [name for name in WATER if extract and accepts(extract, name, by_name=True)]  # not seen through this one
        return {"water": dict.fromkeys(told, GIVEN), **self._inner.describe(), **self._said}

    def extract(self, *cube: Any, **settings: Any) -> Any:
        """Velocities, (n, 2), masked where there is none."""
        found = self._inner.extract(*cube, **settings)
        return np.ma.masked_where(np.isnan(found), found) if self._null and isinstance(found, np.ndarray) else found

    def __getattr__(self, stage: str) -> Any:
        if stage.startswith("_"):
            raise AttributeError(stage)
        return getattr(self._inner, stage)
