"""Behaviour: input untouched, deterministic, refuses what is not finite.

None of these is about velocities. A code that alters its caller's array, gives another answer to the same question,
takes NaN for a wave or fails at sizes that are odd or prime makes whatever is measured with it doubtful.
"""

from __future__ import annotations

import numpy as np

from leakref._base import FloatArray
from leakref.certify.checks import inputs
from leakref.certify.checks.criteria import (
    FRACTION,
    IN_THE_MEAN,
    NEVER,
    answered,
    ask,
    each_method,
    in_the_mean,
    tapered,
    vector,
    verdict,
)
from leakref.certify.checks.inputs import SEA, Cube
from leakref.certify.checks.registry import Case, Outcome, check
from leakref.certify.subject.frames import Subject
from leakref.certify.verdict import Unanswered, Verdict
from leakref.currents import ExponentialCurrent, UniformCurrent
from leakref.grid import Grid
from leakref.sea import SeaState

__all__ = [
    "check_asked",
    "check_deterministic",
    "check_input",
    "check_order",
    "check_past_nyquist",
    "check_refuses",
    "check_sizes",
]

SIZES = {
    "odd": Grid((47, 45, 75), (0.66, 0.7, 0.84)),
    "prime": Grid((43, 47, 71), (0.7, 0.65, 0.87)),
    "oblong": Grid((36, 60, 50), (0.8, 0.55, 1.1)),
}
ABSOLUTE = "There is no tolerance: it is either so or not."


def _sea(*wavenumbers: float, grid: Grid = SEA) -> Cube:
    """On a sheared current, so that every wavenumber has its own velocity."""
    return inputs.sea(
        30.0,
        150.0,
        ExponentialCurrent((0.1, 0.4), 0.4),
        realization=9,
        grid=grid,
        wavenumbers=wavenumbers or (1.2, 1.7, 2.5),
    )


def _any_window(subject: Subject) -> str:
    """The window it is run under where that does not matter: one that tapers, if it has one."""
    return next(
        (
            name
            for name in ("hann", *subject.declaration.windows)
            if name in subject.declaration.windows and name != "box"
        ),
        subject.declaration.windows[0],
    )


@check("behaviour", "protocol", ABSOLUTE, [Case("all-stages")], watched=True)
def check_input(subject: Subject, case: Case) -> Outcome:
    """A code that tapers its caller's array in place, or leaves anything behind where it was not asked to write, spoils
    whatever is done with the data next; what it did during the whole run is reported here."""
    cube = _sea(1.7)
    for method in subject.methods if subject.offers("extract") else ():
        subject.extract(cube.surface, cube.spacing, cube.wavenumbers, window=_any_window(subject), method=method)
    if subject.offers("spectrum"):
        offered = subject.declaration.can["spectrum"].get("windows", ("hann",))
        for name in offered[:1]:
            subject.spectrum(cube.surface[:12, :10, :14], cube.spacing, name)
    if subject.offers("synthesize"):
        waves = SeaState(30.0, 60.0, length=1.0).components(0)
        subject.synthesize(waves, *(np.arange(n) * 0.8 for n in (5, 4, 6)))
    done = list(dict.fromkeys(subject.violations))
    subject.violations.clear()
    return Outcome(
        NEVER if done else 0.0, "; ".join(done) or "its input came back untouched", figures={"violations": done}
    )


@check("behaviour", "protocol", ABSOLUTE, [Case("twice")], watched=True)
def check_deterministic(subject: Subject, case: Case) -> Outcome:
    """The same input twice gives the same bits: a start drawn at random, or something kept from the call before, makes
    a result that cannot be checked."""
    cube, other = _sea(), inputs.sea(-100.0, 80.0, UniformCurrent((0.3, 0.0)), wavenumbers=(1.2, 1.7, 2.5))
    window = _any_window(subject)

    def judge(method: str) -> Outcome:
        def once(which: Cube) -> FloatArray:
            return subject.extract(which.surface, which.spacing, which.wavenumbers, window=window, method=method).values

        first, _, second = once(cube), once(other), once(cube)
        same = np.array_equal(first, second, equal_nan=True)
        off = float(np.nanmax(np.abs(first - second), initial=0.0))
        return Outcome(
            0.0 if same else NEVER,
            "the same both times" if same else f"the second time, after another cube, it differs by up to {off:.2g} c0",
            figures={"difference": off},
        )

    return each_method(subject, judge)


@check(
    "behaviour",
    "app:numdetails",
    "A velocity in c0 may differ by a tenth of the smaller of the two velocity "
    "resolutions: a search that starts from the answer before may end elsewhere in the last digits.",
    [
        Case("shuffled", {"order": (1, 2, 0)}),
        Case("split", {"order": (0,)}),
        Case("reversed", {"order": (2, 1, 0)}, quick=False),
    ],
)
def check_order(subject: Subject, case: Case) -> Outcome:
    """Each wavenumber has its own answer, in the order asked for: answers that come back sorted, or depend on those
    before, are given to the wrong wavenumber."""
    if "wavenumbers" in subject.declaration.untold or subject.declaration.band:
        raise Unanswered(Verdict.UNSUPPORTED, "cannot be told which wavenumbers, or in which order")
    cube, window, order = _sea(), _any_window(subject), list(case.given["order"])

    def judge(method: str) -> Outcome:
        found, there = ask(subject, cube, window, method)
        part = Cube(cube.components, cube.grid, cube.wavenumbers[order], cube.current)
        other = subject.extract(cube.surface, cube.spacing, part.wavenumbers, window=window, method=method)
        answered(subject, other)
        again = other.values
        over = np.hypot(*(again - found[order]).T) / (FRACTION * part.resolutions[0])
        return verdict(np.where(there[order], over, np.nan), part, again, found[order])

    return each_method(subject, judge)


@check("behaviour", "eq:dcdwk", IN_THE_MEAN, [Case(name, quick=name != "odd") for name in SIZES])
def check_sizes(subject: Subject, case: Case) -> Outcome:
    """Odd, prime and very unequal numbers of samples: no Nyquist bin, no bin at -N/2, a shell that is cut off on one
    side if the coarser axis sets its width."""
    cube = _sea(1.25, 1.5, 2.1, grid=SIZES[case.id])
    return each_method(subject, lambda method: in_the_mean(subject, cube, tapered(subject), method))


@check(
    "behaviour",
    "eq:maskedSpec",
    "There is no tolerance: in a sea that changes with wavenumber two different questions have the same answer, to a "
    "relative 1e-9, at each of three pairs of wavenumbers within one bin, or they have not.",
    [Case("within-a-bin")],
)
def check_asked(subject: Subject, case: Case) -> Outcome:
    """Asked at two wavenumbers of which one is nearly a bin above the other, a code that answers the same to the last
    digit has cut both to the same whole number of bins: what it returns belongs to another wavenumber than asked, by
    up to a whole bin. If it has wavenumbers of its own, it should say which (`fixed`)."""
    if "wavenumbers" in subject.declaration.untold or subject.declaration.band:
        raise Unanswered(Verdict.UNSUPPORTED, "cannot be told which wavenumbers")
    side = 2 * np.pi / 0.2
    grid = Grid((50, 46, 80), (side / 50, side / 46, 0.78))
    bins = np.array([5, 7, 9])[:, None] + [0.15, 0.85]
    cube = _sea(*(0.2 * bins).ravel().tolist(), grid=grid)
    # drawn grids have unequal sides; this one, whose questions are of no family that is drawn, keeps them

    def judge(method: str) -> Outcome:
        found, there = ask(subject, cube, _any_window(subject), method)
        pairs = found.reshape(3, 2, 2)
        both = there.reshape(3, 2).all(axis=1)
        if not both.any():
            raise Unanswered(Verdict.MISSING, "has no two answers within a bin")
        same = np.abs(pairs[:, 0] - pairs[:, 1]).max(axis=1) <= 1e-9 * np.abs(pairs).max(axis=(1, 2))
        apart = float(np.ptp(pairs[both], axis=0).max()) > 1e-9 * float(np.abs(pairs[both]).max())  # not one for all
        cut = bool(both.sum() > 1 and same[both].all() and apart)
        return Outcome(
            NEVER if cut else 0.0,
            "at k = 5.15 and 5.85 dk (and so on) the answers are "
            + ("the same: k is cut to whole bins" if cut else "different"),
            figures={"wavenumbers": cube.wavenumbers.tolist(), "velocities": found.tolist()},
        )

    return each_method(subject, judge)


def _refused(subject: Subject, cube: Cube, surface: FloatArray, method: str) -> tuple[bool, str]:
    """Whether it refused, by an error or by declining all, and in words what it did."""
    try:
        answer = subject.extract(
            surface, cube.spacing, cube.wavenumbers, window=_any_window(subject), method=method, raw=True
        )
    except Unanswered as nothing:
        if nothing.verdict not in (Verdict.ERROR, Verdict.MISSING):
            raise
        return True, f"refused: {nothing.message}"
    if answer.declined.all():
        return True, "declined all"
    given = answer.values[~answer.declined]
    numbers = bool(np.isfinite(given).all())
    return False, f"answered {vector(given[0])}" if numbers else "answered NaN or infinity as if it were a number"


@check(
    "behaviour",
    "protocol",
    ABSOLUTE,
    [
        Case("nan", {"value": np.nan}),
        Case("infinity", {"value": np.inf}),
        Case("nan-frame", {"value": np.nan, "frame": True}, quick=False),
    ],
)
def check_refuses(subject: Subject, case: Case) -> Outcome:
    """A gap in the images is no wave: a cube that holds NaN or infinity must be refused, by an error or by null. A
    transform spreads one of them over all bins, and an optimiser then returns where it started."""
    cube, surface = _sea(1.7, 2.1), _sea(1.7, 2.1).surface.copy()
    if case.given.get("frame"):
        surface[:, :, 31] = case.given["value"]
    else:
        surface[17, 23, 31] = case.given["value"]

    def judge(method: str) -> Outcome:
        ask(subject, cube, _any_window(subject), method)  # what refuses everything does not pass
        refused, told = _refused(subject, cube, surface, method)
        return Outcome(0.0 if refused else NEVER, f"a cube with {case.id} in it: {told}")

    return each_method(subject, judge)


@check(
    "behaviour",
    "eq:g",
    "No number is compared. An error, or no answer (null) for that wavenumber, passes. A finite number passes too, "
    "since it does no harm elsewhere, and is reported. NaN or infinity fails: neither says that there is no answer.",
    [Case("past")],
)
def check_past_nyquist(subject: Subject, case: Case) -> Outcome:
    """Past the Nyquist wavenumber, pi / dx, there is nothing to measure, and a code should say so: by an error, or by
    null for that wavenumber."""
    if "wavenumbers" in subject.declaration.untold or subject.declaration.band:
        raise Unanswered(Verdict.UNSUPPORTED, "cannot be told which wavenumbers")
    cube = _sea(1.15 * SEA.nyquist[0])

    def judge(method: str) -> Outcome:
        refused, told = _refused(subject, cube, cube.surface, method)
        return Outcome(
            NEVER if "NaN" in told and not refused else 0.0,
            f"at 1.15 of the Nyquist wavenumber: {told}",
            figures={"refused": refused},
        )

    return each_method(subject, judge)
