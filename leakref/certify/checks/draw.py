"""What a seed makes of the questions: the same ones of other water.

Seed 1 leaves the published questions as they are. Any other turns or mirrors the seas, gives them other phases, a
slightly weaker current and a grid of other sizes and lengths; pairs of waves are turned with them, on another current.
So a tolerance that holds for one holds for all, and answers learnt by heart are of no use.

Numbers are raw words of Philox, keyed by the seed and by what they are for: a question is the same whatever was asked
before it, on every machine and under every version of numpy (as decision D11 has it for phases).
"""

from __future__ import annotations

from collections.abc import Sequence
from contextvars import ContextVar
from dataclasses import dataclass, replace
from typing import Any
from zlib import crc32

import numpy as np

from leakref._base import FloatArray, LeakrefError
from leakref.currents import Current, ExponentialCurrent, LinearCurrent, UniformCurrent
from leakref.grid import Grid

__all__ = ["DRAWN", "PUBLISHED", "Draw", "asked_fastest", "asked_seed", "drawing"]

PUBLISHED = 1
"""The seed of the questions as they are written down."""
DRAWN = ("signs", "recovery", "leakage", "currents", "sea")
"""The families whose questions follow the seed; of the others a run asks what is published."""
_TURNS = np.array(
    [
        [[1, 0], [0, 1]],
        [[0, -1], [1, 0]],
        [[-1, 0], [0, -1]],
        [[0, 1], [-1, 0]],
        [[1, 0], [0, -1]],
        [[0, 1], [1, 0]],
        [[-1, 0], [0, 1]],
        [[0, -1], [-1, 0]],
    ]
)
_WEAKER = 0.06  # by how much of itself at most; stronger ones may leave the basin that a search from zero finds
_MOVED = 0.03  # in c0: the current of a pair, along each axis
_STRONG = 0.4  # in c0: near the edge of what a search from zero finds a hundredth decides, so such a pair is not moved
_SIZES = 3  # samples more or less
_LONGER = 0.08  # of a length


@dataclass(frozen=True)
class Draw:
    """What one seed makes of questions. Of the published ones nothing.

    Raises LeakrefError for a seed that is no whole number from 0 to 2^63.
    """

    seed: int = PUBLISHED
    fastest: float = np.inf
    """In c0: currents that are faster are made as slow, for a code that is made for no others."""

    def __post_init__(self) -> None:
        if isinstance(self.seed, bool) or not isinstance(self.seed, int) or not 0 <= self.seed < 2**63:
            raise LeakrefError("certify", f"the seed is {self.seed!r}", "give a whole number from 0 on, or fresh")

    @property
    def published(self) -> bool:
        """Whether the questions stay as they are."""
        return self.seed == PUBLISHED

    def numbers(self, count: int, *purpose: object) -> FloatArray:
        """Uniform in [0, 1), (count,), the same for the same purpose whenever it is asked."""
        key = np.array([self.seed, crc32(repr(purpose).encode())], dtype=np.uint64)
        return np.asarray(np.random.Philox(key=key).random_raw(count) >> np.uint64(11), dtype=np.float64) * 2.0**-53

    @property
    def turn(self) -> FloatArray:
        """One of the eight turns and mirrors of the square, (2, 2)."""
        return np.asarray(_TURNS[0 if self.published else int(8 * self.numbers(1, "turn")[0])], dtype=np.float64)

    def direction(self, degrees: float) -> float:
        """Where a direction is turned to, in degrees."""
        if self.published:
            return degrees
        x, y = self.turn @ [np.cos(np.radians(degrees)), np.sin(np.radians(degrees))]
        return float(np.degrees(np.arctan2(y, x)))

    def current(self, current: Current | None) -> Any:
        """A current turned with the sea, and made weaker by up to 6 %; None is still water."""
        factor = self._slowed(getattr(current, "velocity", getattr(current, "surface", (0.0, 0.0))))
        if self.published and factor == 1:
            return current or UniformCurrent()
        factor *= 1 - _WEAKER * float(self.numbers(1, "current")[0]) if not self.published else 1

        def by(velocity: Sequence[float]) -> tuple[float, float]:
            u, v = (factor * self.turn @ np.asarray(velocity)).tolist()
            return u, v

        if isinstance(current, LinearCurrent):
            return LinearCurrent(by(current.surface), by(current.shear))
        if isinstance(current, ExponentialCurrent):
            return replace(current, surface=by(current.surface))
        assert current is None or isinstance(current, UniformCurrent)
        return UniformCurrent(by(current.velocity) if current else (0.0, 0.0))

    def realization(self, number: int) -> int:
        """Which phases a sea gets: those of another realisation, for each seed its own thousand."""
        return number if self.published else number + 1000 * (self.seed % 2**40 + 1)

    def grid(self, grid: Grid) -> Grid:
        """Up to three samples more or less along each axis, up to 8 % longer."""
        if self.published:
            return grid
        drawn = self.numbers(6, "grid", grid.shape)
        sizes = [n + int((2 * _SIZES + 1) * u) - _SIZES for n, u in zip(grid.shape, drawn, strict=False)]
        steps = [
            d * n / m * (1 + _LONGER * u) for d, n, m, u in zip(grid.spacing, grid.shape, sizes, drawn[3:], strict=True)
        ]
        return Grid((sizes[0], sizes[1], sizes[2]), (steps[0], steps[1], steps[2]))

    def bins(self, *pairs: tuple[int, int]) -> list[tuple[int, int]]:
        """Bins (i, j), turned with the seas."""
        return [(int(i), int(j)) for i, j in np.rint(np.array(pairs) @ self.turn.T)]

    def near(self, velocity: tuple[float, float]) -> tuple[float, float]:
        """The current of a pair of waves, turned and, if it is not strong, moved by up to 0.03 c0 along each axis."""
        slower = self._slowed(velocity)
        velocity = (slower * velocity[0], slower * velocity[1]) if slower < 1 else velocity
        if self.published:
            return velocity
        moved = _MOVED * (2 * self.numbers(2, "near") - 1) * (np.hypot(*velocity) < _STRONG)
        u, v = (self.turn @ np.array(velocity) + moved).tolist()
        return u, v

    def _slowed(self, velocity: Sequence[float]) -> float:
        """What a current of that velocity is multiplied by, 1 if it is slow enough: a twentieth less than the fastest,
        since pairs of waves are moved onto bins.
        """
        speed = float(np.hypot(velocity[0], velocity[1]))
        return min(1.0, 0.95 * self.fastest / speed) if speed else 1.0

    def phases(self, phase: FloatArray) -> FloatArray:
        """Other phases (n,) for as many waves."""
        return phase if self.published else 2 * np.pi * self.numbers(phase.size, "phases", phase.size)


asked_seed: ContextVar[int] = ContextVar("asked_seed", default=PUBLISHED)
"""Whose questions are asked now; set by each check for the time that it runs."""
asked_fastest: ContextVar[float] = ContextVar("asked_fastest", default=np.inf)
"""The strongest current that is shown, in c0; likewise."""


def drawing() -> Draw:
    """What is made of the questions that are asked now."""
    return Draw(asked_seed.get(), asked_fastest.get())
