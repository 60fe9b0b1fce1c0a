"""Configurations that the statements need: those of the paper's table, and those it does not list.

A claim names its seas by these functions, so that a sea of the paper's table and one beside it are made alike, and an
ensemble that two claims ask for is computed once. Lengths and durations are in peak wavelengths and periods, angles in
degrees, speeds in `c0`. `EXTRA` lists all that are in no table of the paper.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import product
from typing import Any

from leakref.cases import PAPER_CASES, Configuration

__all__ = [
    "CLEAR_OF_PEAK",
    "CURRENTS",
    "DIRECTIONS",
    "EXTRA",
    "GAMMAS",
    "LENGTHS",
    "ROTATIONS",
    "SPEEDS",
    "SPREADS",
    "WIDER",
    "current",
    "domain",
    "narrow_domain",
    "peaked",
    "sea",
    "turn",
]

DIRECTIONS, SPREADS, WIDER = (60.0, 75.0, 90.0), (15.0, 30.0, 45.0, 60.0), (75.0, 90.0, 120.0)
"""theta0 and spreads of the paper's case, and spreads beyond it, in degrees."""
GAMMAS = (1.0, 3.3, 7.0)
"""Of case-gamma."""
LENGTHS = (5.0, 10.0, 20.0)
"""Of case-L-T, in peak wavelengths."""
SPEEDS = (0.025, 0.075, 0.15)
"""Of case-U in `c0`; the paper names no others within its range (D22)."""
CURRENTS = {"following": 90.0, "crossing": 0.0, "opposing": -90.0}
"""Directions of the current by what they are for waves at 90 degrees."""
ROTATIONS = ((60.0, 15.0), (60.0, 30.0), (75.0, 15.0), (45.0, 45.0))  # theta0 and angle; sums are 75, 90, 90, 90


def _configuration(case: str, varied: tuple[str, ...], **values: float) -> Configuration:
    """Numbers as floats: 60 and 60.0 are one sea, but would be kept as two."""
    as_floats: dict[str, Any] = {name: float(value) for name, value in values.items()}
    return Configuration(case, varied=varied, **as_floats)


def sea(direction: float, spread: float, rotation: float = 0.0) -> Configuration:
    """Of case-theta0-DeltaTheta. Direction, spread and rotation in degrees; gamma 3.3, L = 10, T = 20."""
    turn = ("rotation",) if rotation else ()
    return _configuration(
        "theta0-dtheta", ("direction", "spread", *turn), direction=direction, spread=spread, rotation=rotation
    )


def peaked(spread: float, peakedness: float = 3.3, length: float = 10.0) -> Configuration:
    """Of case-gamma, theta0 = 60 degrees. Spread in degrees; T = 20."""
    side = () if length == 10 else ("length",)
    return _configuration(
        "gamma", ("spread", "peakedness", *side), direction=60, spread=spread, peakedness=peakedness, length=length
    )


def domain(length: float, duration: float) -> Configuration:
    """Of case-L-T. A broad sea (90 degrees, spread 60), in still water."""
    return _configuration("L-T", ("length", "duration"), length=length, duration=duration)


def narrow_domain(length: float, duration: float) -> Configuration:
    """A narrow, strongly directional sea (theta0 = 60, spread 15 degrees) at other resolutions."""
    return _configuration(
        "theta0-dtheta",
        ("direction", "spread", "length", "duration"),
        direction=60,
        spread=15,
        length=length,
        duration=duration,
    )


def current(speed: float, direction: float = 0.0, rotation: float = 0.0) -> Configuration:
    """Of case-U. Waves at 90 degrees with spread 60; a speed of zero has no direction."""
    return _configuration(
        "U",
        ("rotation", "speed", "current_direction") if speed else ("rotation", "speed"),
        speed=speed,
        current_direction=direction if speed else 0,
        rotation=rotation,
    )


def turn(rotation: float, currents: Iterable[float] = CURRENTS.values()) -> Iterator[Configuration]:
    """All of case-U that run, at one angle of rotation. `currents` are directions before the rotation."""
    return (current(speed, direction, rotation) for speed, direction in product(SPEEDS, currents))


CLEAR_OF_PEAK = replace(narrow_domain(20.0, 20.0), direction=45.0)
"""theta0 = 45 at L = 20: no line along an axis from the peak meets the innermost shell (A14)."""

EXTRA: dict[str, tuple[Configuration, ...]] = {
    "theta0-dtheta": (
        *(sea(45.0, spread) for spread in SPREADS),
        *(sea(direction, spread) for direction, spread in product(DIRECTIONS, WIDER)),
        *(sea(*turn[:1], spread, turn[1]) for turn, spread in product(ROTATIONS, (15.0, 60.0))),
        *(narrow_domain(length, 20.0) for length in (5.0, 20.0)),
        *(narrow_domain(10.0, duration) for duration in (10.0, 80.0)),
        CLEAR_OF_PEAK,
        replace(CLEAR_OF_PEAK, direction=90.0),
    ),
    "gamma": tuple(peaked(spread, 3.3, length) for length, spread in product((5.0, 20.0), (45.0, 60.0))),
    "L-T": (*(domain(length, 5.0) for length in LENGTHS), domain(5.0, 40.0)),
    "U": (*turn(15.0), *turn(45.0), *turn(-30.0, (0.0,))),
}
"""What the claims need beside `cases.PAPER_CASES`: theta0 = 45, spreads above 60, seas turned, T = 5, ..."""

_TABLE = {c.id: c for members in PAPER_CASES.values() for c in members}
assert all(c.id not in _TABLE for members in EXTRA.values() for c in members)
