"""Metamorphic relations: a changed input changes the answer in a known way, whatever the answer is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from leakref._base import FloatArray
from leakref.certify.checks import inputs
from leakref.certify.checks.criteria import (
    FRACTION,
    NEVER,
    as_array,
    each_method,
    tapered,
    unflagged,
    untapered,
    verdict,
)
from leakref.certify.checks.inputs import Cube, polar
from leakref.certify.checks.registry import Case, Outcome, check
from leakref.certify.subject.frames import Subject
from leakref.certify.verdict import Unanswered, Verdict
from leakref.currents import UniformCurrent

__all__ = ["check_amplitude", "check_constant", "check_reversal", "check_shift", "check_symmetry"]

SAME, BACK = np.eye(2), -np.eye(2)
MIRROR_X, MIRROR_Y = np.diag([-1.0, 1.0]), np.diag([1.0, -1.0])
EXCHANGE, LEFT = np.array([[0.0, 1.0], [1.0, 0.0]]), np.array([[0.0, -1.0], [1.0, 0.0]])
CLOSE = (
    "The code is asked twice, for the surface as it is and for the changed one. At each wavenumber at which the "
    "reference has nothing to note the second velocity may differ from the first, changed likewise, by a tenth of the "
    "smaller of the two velocity resolutions. The relation is exact, but in a sea the "
    "maximum is flatter than for waves on bins: the tenth is for optimisers that stop early there, and for single "
    "precision."
)
WINDOWS = (("tapered", True), ("untapered", False))

Change = Callable[[FloatArray, int], FloatArray]


def _reverse(surface: FloatArray, axis: int, shift: int) -> FloatArray:
    """Index n to -n modulo the size (`shift` 1), under which a periodic window is even, or the plain flip (0)."""
    return np.roll(np.flip(surface, axis), shift, axis)


SYMMETRIES: dict[str, tuple[Change, FloatArray]] = {
    "mirror-x": (lambda eta, shift: _reverse(eta, 0, shift), MIRROR_X),
    "mirror-y": (lambda eta, shift: _reverse(eta, 1, shift), MIRROR_Y),
    "exchange": (lambda eta, shift: eta.transpose(1, 0, 2), EXCHANGE),
    "quarter-turn": (lambda eta, shift: _reverse(eta.transpose(1, 0, 2), 0, shift), LEFT),
}
"""What is done to a surface, and to a velocity."""


def _cube(window: str) -> Cube:
    if window == "box":  # far from the mirror basin, so that an untapered optimum is sharp
        return inputs.sea(25.0, 150.0, UniformCurrent(polar(0.12, 130.0)), realization=5, wavenumbers=(1.5, 1.9, 2.3))
    return inputs.sea(-50.0, 90.0, UniformCurrent(polar(0.15, 20.0)), realization=5, wavenumbers=(1.3, 1.6, 2.0))


def _related(
    subject: Subject,
    case: Case,
    change: Change,
    matrix: FloatArray,
    exchanged: bool = False,
    always: bool = False,
    cyclic: bool = False,
) -> Outcome:
    """Compare the velocities of a changed array with those of the array itself, `matrix` applied.

    With `always` to give none for the changed one is a failure. A `cyclic` change holds for the cube as a whole: its
    sides are even, for whoever leaves out a sample of an odd one.
    """
    window = tapered(subject) if case.given.get("tapered", False) else untapered(subject)
    cube = _cube(window)
    if cyclic:
        nx, ny, nt = (n - n % 2 for n in cube.grid.shape)
        cube = replace(cube, grid=replace(cube.grid, shape=(nx, ny, nt)))
    dx, dy, dt = cube.spacing
    spacing = (dy, dx, dt) if exchanged else cube.spacing

    def judge(method: str) -> Outcome:
        found, there = as_array(subject, cube.surface, cube.spacing, cube.wavenumbers, window, method)
        should = found @ matrix.T
        known = there & unflagged(cube, window, method)
        attempts = []
        for shift in (1, 0):  # a window sampled symmetrically is even under the plain flip
            try:
                turned, answered = as_array(
                    subject, change(cube.surface, shift), spacing, cube.wavenumbers, window, method
                )
            except Unanswered as nothing:
                if nothing.verdict is not Verdict.MISSING or not always:
                    raise
                return Outcome(NEVER, "answers the surface as it is, and gives no velocity for the changed one")
            over = np.hypot(*(turned - should).T) / (FRACTION * cube.resolutions[0])
            attempts.append(verdict(np.where(known & answered, over, np.nan), cube, turned, should))
            if attempts[-1].over <= 1:
                break
        return min(attempts, key=lambda outcome: np.inf if np.isnan(outcome.over) else outcome.over)

    return each_method(subject, judge)


@check(
    "metamorphic",
    "eq:normSp",
    CLOSE,
    [
        Case(f"{name}-{window}", {"symmetry": name, "tapered": tapered}, quick=tapered or name == "quarter-turn")
        for name in SYMMETRIES
        for window, tapered in WINDOWS
    ],
)
def check_symmetry(subject: Subject, case: Case) -> Outcome:
    """A mirror image, a quarter turn, or x and y exchanged, of a surface has the current so changed: a quadrant left
    out, a window or a step of one axis used for another, half of the plane weighted otherwise all break it."""
    name = case.given["symmetry"]
    return _related(subject, case, *SYMMETRIES[name], exchanged=name in ("exchange", "quarter-turn"))


@check("metamorphic", "eq:SnJ", CLOSE, [Case(window, {"tapered": tapered}) for window, tapered in WINDOWS])
def check_reversal(subject: Subject, case: Case) -> Outcome:
    """Played backwards, waves and current go the other way: where only positive frequencies are kept, or those in
    front of the waves, this fails."""
    return _related(subject, case, lambda eta, shift: _reverse(eta, 2, shift), BACK)


@check(
    "metamorphic",
    "eq:normSp",
    CLOSE + " To give no velocity for the changed surface is a failure.",
    [
        Case(f"{factor:g}-{window}", {"factor": factor, "tapered": tapered}, quick=tapered)
        for factor in (1e6, 1e-6)
        for window, tapered in WINDOWS
    ],
)
def check_amplitude(subject: Subject, case: Case) -> Outcome:
    """Images have grey values in any unit: a floor or a threshold in absolute numbers makes the current depend on
    it."""
    return _related(subject, case, lambda eta, _: eta * case.given["factor"], SAME, always=True)


@check("metamorphic", "eq:hann", CLOSE, [Case(window, {"tapered": tapered}) for window, tapered in WINDOWS])
def check_constant(subject: Subject, case: Case) -> Outcome:
    """The mean grey value is no wave: ten standard deviations added change nothing in shells that keep clear of the
    bins around zero."""
    return _related(subject, case, lambda eta, _: eta + 10 * eta.std(), SAME)


@check(
    "metamorphic",
    "sec:leakage",
    CLOSE + " For a code that does not answer as the reference does the cube is shifted along x and y only: one that "
    "takes the mean over segments in time would look at other segments.",
    [Case("untapered"), Case("untapered-far", {"steps": (23, -17, 41)}, quick=False)],
)
def check_shift(subject: Subject, case: Case) -> Outcome:
    """An untapered cube has no edge: shifted cyclically along all axes it has the same power. Where this fails
    something else than the power gets into the answer, or a window is applied although none was asked for."""
    x, y, t = case.given.get("steps", (7, -5, 11))
    steps = (x, y, t if set(subject.methods) <= (subject.alike or set()) else 0)
    return _related(subject, case, lambda eta, _: np.roll(eta, steps, axis=(0, 1, 2)), SAME, cyclic=True)
