"""All golden vectors by the set: `vectors` has those of `v1`, `watervectors` and `methodvectors` those of `v2`.

A new vector is a row in the table of the newest set. The tables of sets that were released do not change.
"""

from __future__ import annotations

from leakref.golden import methodvectors, vectors, watervectors
from leakref.golden.vectors import Vector

__all__ = ["TABLES", "VECTORS"]

TABLES: dict[int, dict[str, tuple[Vector, ...]]] = {
    1: vectors.VECTORS,
    2: {part: (*found, *methodvectors.VECTORS[part]) for part, found in watervectors.VECTORS.items()},
}
"""By the number of the set, and within it by part."""
VECTORS = {part: tuple(v for table in TABLES.values() for v in table[part]) for part in vectors.VECTORS}
"""Those of all sets, by part."""
