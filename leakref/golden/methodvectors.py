"""The golden vectors of methods beside the paper's two, of set 2: the same seas for each of them.

An input is a row of `_shells`, what a method finds in it an entry named after both. A method that is registered has its
vectors at once.
"""

from __future__ import annotations

from typing import Any

from leakref.decisions import DECISIONS
from leakref.dispersion import DEEP, Water
from leakref.golden.vectors import EASY, HARD, MODERATE, OBLONG, PRIME, SHORT, SQUARE, TALL, Vector, aligned, placed
from leakref.golden.watervectors import BOTTOM, CAPILLARY, FIELD, LAKE, TANK, on, swell_over
from leakref.methods import DEFAULT, METHODS

__all__ = ["VECTORS", "decisions_of"]

_SIGNS = ("negated-current", "flipped-x", "flipped-y", "exchanged-axes")
_SHARED = ("D1", "D2", "D3", "D4", "D5", "D6", "D7", "D18", "D20", "D21", "D26", "D29")


def decisions_of(method: str) -> tuple[str, ...]:
    """The decisions that are taken in the file of a method beside the paper's; of those none."""
    own = METHODS[method].extract.__module__.rpartition(".")[2] if method not in DEFAULT else None
    return tuple(d.id for d in DECISIONS.values() if d.where.partition(".")[0] == own)


def _shells() -> list[tuple[str, str, str, dict[str, Any], tuple[str, ...]]]:
    """Id, difficulty, purpose, input, faults."""
    two = {**on(SQUARE, DEEP, "box"), **aligned(SQUARE, (3, 1, 5), (1, -3, 5), water=DEEP)}
    half = {**on(SQUARE, DEEP), **placed(SQUARE, (2.5, 1.5, 4.5), (-0.5, 3.5, 4.5), (3.5, -1.5, 4.5))}
    swell = {**on(OBLONG, DEEP), **swell_over(DEEP, 10, 1.1, 2.1, 65.0, 80.0, (0.12, -0.07))}
    bare = {**on(TALL, DEEP, "box"), **swell_over(DEEP, 11, 0.9, 1.9, 150.0, 90.0, (0.1, 0.14), first=3)}
    strong = {**on(SHORT, DEEP), **swell_over(DEEP, 9, 1.0, 2.0, -20.0, 140.0, (-0.35, 0.25), first=2)}
    sheared = {**on(OBLONG, DEEP), **swell_over(DEEP, 10, 1.0, 2.2, 20.0, 100.0, (0.15, -0.05), (0.1, 0.08))}
    si = Water(9.81)
    prime = {**on(PRIME, si), **swell_over(si, 8, 0.7, 1.5, 115.0, 100.0, (0.3, 0.2))}
    seven = {**on(OBLONG, BOTTOM[0.7]), **swell_over(BOTTOM[0.7], 10, 1.1, 2.1, 65.0, 90.0, (0.12, -0.07))}
    lake = {**on(FIELD, LAKE), **swell_over(LAKE, 9, 0.3, 0.6, 115.0, 90.0, (0.4, -0.3))}
    tank = {**on(TANK, CAPILLARY), **swell_over(CAPILLARY, 9, 105.0, 210.0, 40.0, 90.0, (0.03, 0.02))}
    return [
        ("on-bin", EASY, "two waves on bins, box: their common current exactly", {**two, "wavenumbers": [1.38]},
         _SIGNS),
        ("half-bin", MODERATE, "three waves half-way between bins, Hann", {**half, "wavenumbers": [1.4]},
         ("no-taper",)),
        ("swell", MODERATE, "a swell under Hann, sides and steps all different",
         {**swell, "wavenumbers": [1.3, 1.5, 1.9]}, _SIGNS),
        ("bare", MODERATE, "another untapered: leaked bins are among those that count",
         {**bare, "wavenumbers": [1.2, 1.5]}, ("no-taper", "negated-current")),
        ("strong", HARD, "a current of 0.43 c0: bins are far from where still water has them",
         {**strong, "wavenumbers": [1.3, 1.6]}, _SIGNS),
        ("sheared", HARD, "a sheared current: each wavenumber has its own", {**sheared, "wavenumbers": [1.2, 1.5, 1.8]},
         _SIGNS),
        ("prime", MODERATE, "gravity 9.81, prime sizes: a width or a lattice fixed in metres and seconds",
         {**prime, "wavenumbers": [1.0, 1.2]}, ("hard-coded-width",)),
        ("depth-0.7", MODERATE, "k0 h = 0.7: whoever takes the water for deep is far off",
         {**seven, "wavenumbers": [1.3, 1.5, 1.9]}, _SIGNS),
        ("lake", MODERATE, "metres and seconds, 4.2 m deep", {**lake, "wavenumbers": [0.4, 0.5]},
         ("hard-coded-width",)),
        ("capillary", MODERATE, "waves of 3 to 6 cm, with tension", {**tank, "wavenumbers": [130.0, 170.0]},
         ("hard-coded-width",)),
    ]  # fmt: skip


VECTORS: dict[str, tuple[Vector, ...]] = {
    "vectors": tuple(
        Vector(f"{m}-{name}", m, difficulty, f"{purpose}; by {METHODS[m].words}", given, faults,
               (*_SHARED, *decisions_of(m)))
        for m in METHODS if m not in DEFAULT for name, difficulty, purpose, given, faults in _shells()
    ),
    "analytic": (),
}  # fmt: skip
"""By part of the set."""
