"""Ensembles: what holds in the mean over seas, paired by realisation, and what a rotation may change."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from leakref import Grid, SeaState, UniformCurrent
from leakref._base import FloatArray
from leakref.certify.checks.inputs import Cube, polar
from leakref.certify.checks.statistics import excess

from .examined import Examined
from .strategies import examples

SMALL = Grid((36, 40, 56), (0.72, 0.70, 0.80))
"""Four wavelengths by seven periods: enough for k > 1.2."""
LARGER = Grid((50, 44, 80), (0.63, 0.68, 0.78))
WAVENUMBERS = np.array([1.3, 1.6, 2.0])
ALARMS = 1e-3
"""How often a test may be wrong of a code that is within the margin."""


def sea(
    direction: float,
    spread: float,
    current: tuple[float, float],
    realization: int,
    turn: float = 0.0,
    grid: Grid = SMALL,
) -> Cube:
    """A realisation, `turn` degrees about the centre of the domain, current and all (decision D13)."""
    length = min(grid.lengths[:2]) / (2 * np.pi)
    waves = SeaState(direction, spread, length=length, current=UniformCurrent(current)).components(realization)
    angle = np.degrees(np.arctan2(current[1], current[0])) + turn
    centre = [n / 2 for n in grid.lengths[:2]]
    return Cube(
        waves.rotated(turn, centre) if turn else waves,
        grid,
        WAVENUMBERS,
        UniformCurrent(polar(float(np.hypot(*current)), float(angle))),
    )


def taper(examined: Examined) -> str:
    """Hann, or another window that is offered and not the box."""
    if (window := examined.windows()[0]) == "box":
        pytest.skip("offers no window that tapers")
    return window


def errors(examined: Examined, cube: Cube, window: str, method: str) -> FloatArray:
    """c - U, (n, 2), NaN where it is declined or the reference has something to note."""
    return examined.velocities(cube.surface, cube, window, method) - cube.truth


def mean_sizes(examined: Examined, cubes: list[Cube], window: str, method: str) -> FloatArray:
    """Mean |c - U| over the wavenumbers of each cube, NaN if there is none."""
    sizes = [np.hypot(*errors(examined, cube, window, method).T) for cube in cubes]
    return np.array([np.nan if np.isnan(s).all() else np.nanmean(s) for s in sizes])


def turned(
    examined: Examined,
    spread: float,
    window: str,
    method: str,
    angle: float,
    first: int,
    count: int,
    grid: Grid = SMALL,
) -> FloatArray:
    """How much velocities change beyond turning, over the larger resolution, in `count` seas, (count, n)."""
    back = np.array(polar(1.0, -angle))
    back = np.array([[back[0], -back[1]], [back[1], back[0]]])
    found = []
    for n in range(first, first + count):
        pair = [sea(90.0, spread, (0.08, 0.06), n, turn, grid) for turn in (0.0, angle)]
        one, other = (errors(examined, cube, window, method) for cube in pair)
        found.append(np.hypot(*(other @ back.T - one).T) / pair[0].resolutions[1])
    return np.array(found)


@examples(2)
@given(angle=st.floats(15.0, 345.0), first=st.integers(0, 1000))
def test_a_turned_sea_has_the_turned_current_tapered(examined: Examined, angle: float, first: int) -> None:
    """The same components turned by any angle about the centre, tapered, several seas pooled: at 60 degrees spread an
    NSP changes by less than 0.5 of the larger resolution (eq:dcdwk; measured 0.26), the mean of any other method by
    less than 2 (measured for LS: 1.43)."""
    window = taper(examined)
    for method in examined.methods():
        changes = turned(examined, 60.0, window, method, angle, first, 4)
        worst, allowed = (np.nanmax(changes), 0.5) if method == "nsp" else (np.nanmean(changes), 2.0)
        assert worst <= allowed, f"{method}: turned by {angle:.4g} degrees it changes by {worst:.2g} resolutions"


@examples(1)
@given(first=st.integers(0, 1000))
def test_untapered_a_turned_sea_has_another_current(examined: Examined, first: int) -> None:
    """The violation itself: untapered at 15 degrees spread, some of twelve seas turned by 45 degrees has an NSP changed
    by more than 2 larger resolutions (measured: every second one): what leaks does not turn with the sea. Of the
    reference only: a code that knows how to avoid it is welcome."""
    if examined.modules is None:
        pytest.skip("of the reference only")
    changes = (turned(examined, 15.0, "box", "nsp", 45.0, n, 1, LARGER) for n in range(first, first + 12))
    assert any(np.nanmax(change) > 2 for change in changes)


@examples(1)
@given(direction=st.floats(-180.0, 180.0), first=st.integers(0, 1000))
def test_a_wider_spread_is_not_worse(examined: Examined, direction: float, first: int) -> None:
    """Tapered, k > 1.2, in the mean over 30 paired realisations: |c - U| at 60 degrees spread exceeds that at 15 by no
    more than a tenth of the smaller resolution, by Student's t at a rate of 1e-3. Seed by seed, 39 % do
    so."""
    window = taper(examined)
    for method in examined.methods():
        seas = (
            [sea(direction, spread, polar(0.1, direction + 50), n) for n in range(first, first + 30)]
            for spread in (15.0, 60.0)
        )
        narrow, wide = (mean_sizes(examined, cubes, window, method) for cubes in seas)
        worse = (wide - narrow)[np.isfinite(wide - narrow)]
        margin = 0.1 * float(sea(direction, 60.0, (0.0, 0.0), 0).resolutions[0].mean())
        test = excess(worse, margin, ALARMS)
        assert test.over <= 1, f"{method}: {test.mean:.3g} c0 worse in the mean, should be at most {test.limit:.3g}"


@examples(1)
@given(direction=st.floats(-180.0, 180.0), first=st.integers(0, 1000))
def test_with_a_following_or_opposing_current_errors_are_those_without(
    examined: Examined, direction: float, first: int
) -> None:
    """Tapered, in the mean over 12 paired realisations: |c - U| at 0.15 c0 along and against the waves differs from
    that in still water by no more than a half of the smaller resolution (measured in 25 such means: at most 0.08 by
    NSP; 0.66 by LS, half of what its scatter then allows), by Student's t at 1e-3 either way."""
    window = taper(examined)
    for method in examined.methods():
        still, with_it, against = (
            mean_sizes(
                examined,
                [sea(direction, 60.0, polar(speed, direction), n) for n in range(first, first + 12)],
                window,
                method,
            )
            for speed in (0.0, 0.15, -0.15)
        )
        margin = 0.5 * float(sea(direction, 60.0, (0.0, 0.0), 0).resolutions[0].mean())
        for name, sizes in (("following", with_it), ("opposing", against)):
            change = (sizes - still)[np.isfinite(sizes - still)]
            for sign in (1, -1):
                test = excess(sign * change, margin, ALARMS)
                assert test.over <= 1, f"{method}, {name}: differs by {sign * test.mean:.3g} c0 in the mean"
