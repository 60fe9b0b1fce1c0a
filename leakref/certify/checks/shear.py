"""Sheared currents: each wavenumber sees the depth-weighted current of eq:SJ.

With a current that changes with depth the answers at different wavenumbers differ, and by how much is known. A code
that smooths over wavenumbers, reads a shell at another one, or gives one answer for all is told apart here.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from leakref._base import FloatArray
from leakref.certify.checks import inputs
from leakref.certify.checks.criteria import (
    HALF_AGAIN,
    IN_THE_MEAN,
    ask,
    each_method,
    in_the_mean,
    like,
    tapered,
    unflagged,
    vector,
)
from leakref.certify.checks.inputs import Cube
from leakref.certify.checks.registry import Case, Outcome, check
from leakref.certify.subject.frames import Subject
from leakref.certify.verdict import Unanswered, Verdict
from leakref.currents import ExponentialCurrent, LinearCurrent
from leakref.grid import Grid

__all__ = ["check_band", "check_profile", "check_slope"]

GRID = Grid((50, 44, 104), (0.63, 0.68, 0.6))
"""A shorter step in time than elsewhere: the waves are fast."""
WAVENUMBERS = (1.0, 1.25, 1.6, 2.0, 2.5, 2.9)
PROFILES: dict[str, tuple[ExponentialCurrent | LinearCurrent, float]] = {
    "exponential": (ExponentialCurrent((0.9, 0.4), 0.25), 60.0),
    "linear": (LinearCurrent((0.25, -0.15), (0.75, -0.4)), -20.0),
    "exponential-2": (ExponentialCurrent((-0.3, 1.0), 0.25), 150.0),
    "linear-2": (LinearCurrent((0.2, 0.2), (0.6, 0.6)), 60.0),
}
"""Currents (eq:SJ) and the direction of the waves on them."""
CASES = [Case(name, quick=not name.endswith("2")) for name in PROFILES]


def _cube(case: Case) -> Cube:
    current, direction = PROFILES[case.id]
    return inputs.sea(direction, 180.0, current, grid=GRID, wavenumbers=WAVENUMBERS)


def _each_wavenumber(subject: Subject) -> None:
    if subject.declaration.band:
        raise Unanswered(Verdict.UNSUPPORTED, "gives one velocity for the whole band: see shear.band")


@check(
    "shear",
    "eq:SJ",
    IN_THE_MEAN + " The reference stays below half of the tolerance; a code that gives the same "
    "velocity at all wavenumbers is a third above it.",
    CASES,
)
def check_profile(subject: Subject, case: Case) -> Outcome:
    """Under a sheared current every wavenumber has a Doppler shift velocity of its own: a shell read at another
    wavenumber, or a current averaged over all of them, is off by more than the resolution at the ends."""
    _each_wavenumber(subject)
    return each_method(subject, lambda method: in_the_mean(subject, _cube(case), tapered(subject), method))


def _slope(cube: Cube, velocities: FloatArray, there: npt.NDArray[np.bool_]) -> FloatArray:
    """d c / d log k by least squares, (2,)."""
    return np.polyfit(np.log(cube.wavenumbers[there]), velocities[there], 1)[0]


@check(
    "shear",
    "eq:SJ",
    "The slope of a straight line through the velocities against the natural logarithm of k, a vector in c0, may be "
    "off by six tenths of the length of the true one. A code that finds no change is off by ten tenths, one with the "
    "profile upside down by twenty; the reference's least squares is off by three. Where that is off by more than four "
    "in a sea, least squares and methods that the reference does not have may be off by half as much again.",
    CASES,
)
def check_slope(subject: Subject, case: Case) -> Outcome:
    """Shorter waves feel the current nearer to the surface: the change with wavenumber must have the right sign and
    about the right size, not that of a profile upside down, nor none."""
    _each_wavenumber(subject)
    cube, window = _cube(case), tapered(subject)

    def judge(method: str) -> Outcome:
        found, there = ask(subject, cube, window, method)
        there &= unflagged(cube, window, method)
        if there.sum() < 4:  # of six: fewer are a matter of a bin or two
            raise Unanswered(Verdict.MISSING, f"answers {int(there.sum())} wavenumbers, four show a change")
        own, should = _slope(cube, found, there), _slope(cube, cube.truth, there)
        allowed = 0.6 * float(np.hypot(*should))
        if (least_squares := like(cube, window, method)) is not None:
            allowed = max(allowed, HALF_AGAIN * float(np.hypot(*(_slope(cube, least_squares, there) - should))))
        return Outcome(
            float(np.hypot(*(own - should))) / allowed,
            f"with log k it changes by {vector(own)}, should be {vector(should)}",
            figures={"slope": own.tolist(), "should_be": should.tolist()},
        )

    return each_method(subject, judge)


@check(
    "shear",
    "eq:SJ",
    "Each component, in c0, may be outside the range of the true velocities by the smaller of the "
    "two velocity resolutions.",
    CASES,
)
def check_band(subject: Subject, case: Case) -> Outcome:
    """One current for the whole band must lie within the range of those of its wavenumbers."""
    if not subject.declaration.band:
        raise Unanswered(Verdict.UNSUPPORTED, "gives a velocity for each wavenumber: see shear.profile")
    cube, window = _cube(case), tapered(subject)

    def judge(method: str) -> Outcome:
        found, _ = ask(subject, cube, window, method)
        low, high = cube.truth.min(axis=0), cube.truth.max(axis=0)
        outside = float(np.maximum(np.maximum(low - found[0], found[0] - high), 0).max())
        return Outcome(
            outside / float(cube.resolutions[0].mean()),
            f"{vector(found[0])}, should be between {vector(low)} and {vector(high)}",
            figures={"velocity": found[0].tolist()},
        )

    return each_method(subject, judge)
