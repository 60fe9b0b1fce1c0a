"""Other water for the checks: the same questions of new seas, on new grids, turned or mirrored.

A correct code must pass the checks not only on the seas for which their tolerances were seen to hold. This replaces the
makers of seas and pairs in `checks.inputs` for a while, so that every check is asked its own question of other water;
no check knows. Used by `study` for the variants.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np

from leakref._base import FloatArray
from leakref.certify.checks import inputs
from leakref.currents import Current, ExponentialCurrent, LinearCurrent, UniformCurrent
from leakref.grid import Grid

__all__ = ["fresh"]

_TURNS = [
    np.array(m)
    for m in (
        [[1, 0], [0, 1]],
        [[0, -1], [1, 0]],
        [[-1, 0], [0, -1]],
        [[0, 1], [-1, 0]],
        [[1, 0], [0, -1]],
        [[0, 1], [1, 0]],
        [[-1, 0], [0, 1]],
        [[0, -1], [-1, 0]],
    )
]


def _turned(current: Current | None, turn: FloatArray) -> Any:
    """A current, turned or mirrored with the sea; None is still water."""

    def by(velocity: Sequence[float]) -> tuple[float, float]:
        u, v = (turn @ np.asarray(velocity)).tolist()
        return u, v

    if isinstance(current, LinearCurrent):
        return LinearCurrent(by(current.surface), by(current.shear))
    if isinstance(current, ExponentialCurrent):
        return replace(current, surface=by(current.surface))
    assert current is None or isinstance(current, UniformCurrent)
    return UniformCurrent(by(current.velocity) if current else (0.0, 0.0))


@contextmanager
def fresh(seed: int) -> Iterator[None]:
    """Within it the checks see other water: every sea with new phases, on a new grid, turned or mirrored as a whole.

    Sizes change by up to three samples and lengths by up to 8 %; every pair of waves is turned with the seas, and its
    current moved by up to 0.03 c0 along each axis. The same seed is the same water.

    Not for several threads: the makers are replaced for all of them. They are put back however the block is left. Pairs
    keep their grid, on whose bins they lie.
    """
    rng = np.random.default_rng(seed)
    turn, moved = _TURNS[rng.integers(8)], rng.uniform(-0.03, 0.03, 2)
    grids: dict[Grid, Grid] = {}
    sea, pair = inputs.sea, inputs.pair

    def other(grid: Grid) -> Grid:
        if grid not in grids:
            sizes = [n + int(rng.integers(-3, 4)) for n in grid.shape]
            steps = [d * n / m * rng.uniform(1, 1.08) for d, n, m in zip(grid.spacing, grid.shape, sizes, strict=True)]
            grids[grid] = Grid((sizes[0], sizes[1], sizes[2]), (steps[0], steps[1], steps[2]))
        return grids[grid]

    def fresh_sea(
        direction: float,
        spread: float,
        current: Current | None = None,
        *,
        realization: int = 0,
        grid: Grid = inputs.SEA,
        **rest: Any,
    ) -> inputs.Cube:
        x, y = turn @ np.array(inputs.polar(1.0, direction))
        return sea(
            float(np.degrees(np.arctan2(y, x))),
            spread,
            _turned(current, turn),
            realization=realization + 1000 * (seed + 1),
            grid=other(grid),
            **rest,
        )

    def fresh_pair(
        grid: Grid, first: tuple[int, int], second: tuple[int, int], near: tuple[float, float]
    ) -> inputs.Cube:
        one, two = ((int(i), int(j)) for i, j in (turn @ np.array([first, second]).T).T)
        u, v = (turn @ np.array(near) + moved).tolist()
        return pair(grid, one, two, (u, v))

    vars(inputs).update(sea=fresh_sea, pair=fresh_pair)
    try:
        yield
    finally:
        vars(inputs).update(sea=sea, pair=pair)
