"""All golden vectors by the set that has them: `vectors` has those of `v1`, `watervectors` those of `v2`.

A new vector is a row in the table of the newest set. The tables of sets that were released do not change.
"""

from __future__ import annotations

from leakref.golden import vectors, watervectors
from leakref.golden.vectors import Vector

__all__ = ["TABLES", "VECTORS"]

TABLES: dict[int, dict[str, tuple[Vector, ...]]] = {1: vectors.VECTORS, 2: watervectors.VECTORS}
"""By the number of the set, and within it by part."""
VECTORS = {part: tuple(v for table in TABLES.values() for v in table[part]) for part in vectors.VECTORS}
"""Those of all sets, by part."""
