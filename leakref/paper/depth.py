"""What it costs to take water for deep that is not: case depth, measured with the depth known and with none.

The waves of case depth are in water of k0 h = 0.7 to 2, the sea and the domain are the paper's own (decision D31), and
there is no current: whatever velocity is found is an error. With the depth known it is that of leakage, as in deep
water. Taken for deep the water is thought to carry waves faster than it does, and the difference, omega0(k) / k times
(1 - 1 / sqrt(tanh(k h))), is seen as a current against the waves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from leakref._tables import Table
from leakref.ensemble import Ensemble

__all__ = ["AT", "CASE", "Mistake", "mistakes", "mistakes_table"]

CASE = "depth"
"""The id of the case."""
AT = (1.0, 1.4, 1.8)
"""Wavenumbers of the table, in k0."""


@dataclass(frozen=True)
class Mistake:
    """Mean errors |c| in c0 at one depth k0 h, by one method under one window, with the depth known and with none.

    - `wavenumbers`: those of the shells nearest to `AT`, in k0; `known`, `deep`: the errors at each of them.
    - `resolution`: the smaller of the two velocity resolutions there.
    """

    kh: float
    window: str
    method: str
    wavenumbers: tuple[float, ...]
    known: tuple[float, ...]
    deep: tuple[float, ...]
    resolution: tuple[float, ...]

    def record(self) -> dict[str, Any]:
        """For JSON."""
        return asdict(self)


def mistakes(ensembles: Sequence[Ensemble]) -> list[Mistake]:
    """A row for each depth, window and method of case depth that was measured both ways, in the order of the first."""
    by_key = {
        (e.configuration.depth, e.window, e.method, e.configuration.assumed is None): e
        for e in ensembles
        if e.configuration.case == CASE
    }
    rows = []
    for (kh, window, method, is_known), known in by_key.items():
        deep = by_key.get((kh, window, method, False))
        if not is_known or deep is None:
            continue
        at = [int(np.abs(known.wavenumbers - k).argmin()) for k in AT]
        columns = known.wavenumbers, known.bias, deep.bias, np.minimum(*known.resolutions)
        k, error, mistaken, finest = (tuple(float(values[n]) for n in at) for values in columns)
        rows.append(Mistake(kh, window, method, k, error, mistaken, finest))
    return rows


def mistakes_table(rows: Sequence[Mistake], realizations: int) -> Table:
    """Errors with the depth known and, after an arrow, with deep water assumed; those beyond the resolution in red."""
    result = Table(
        title="Mean error in c0: depth known -> deep water assumed",
        caption=f"{realizations} realisations; red: beyond the smaller resolution",
        caption_justify="left",
        title_justify="left",
    )
    for heading in ("k0 h", "window", "method", *(f"k = {k:g}" for k in rows[0].wavenumbers)):
        result.add_column(heading, justify="right" if heading[:2] in ("k0", "k ") else "left")
    for row in rows:
        cells = [
            f"{known:.3f} -> " + (f"[red]{deep:.3f}[/red]" if deep > finest else f"{deep:.3f}")
            for known, deep, finest in zip(row.known, row.deep, row.resolution, strict=True)
        ]
        result.add_row(f"{row.kh:g}", row.window, row.method, *cells)
    return result
