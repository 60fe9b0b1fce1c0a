"""Strong and opposing currents, up to where omega0 + k.U is negative.

Most codes are tried in weak currents. Near the phase speed of the waves a search that stays close to zero, bounds in
metres per second or a band of frequencies show; where waves are swept backwards, so does a missing branch of G.
"""

from __future__ import annotations

import numpy as np

from leakref._base import FloatArray
from leakref.certify.checks import inputs
from leakref.certify.checks.criteria import (
    FRACTION,
    TOLERANCE,
    ask,
    blind_to_backward_waves,
    each_method,
    tapered,
    tolerance,
    unflagged,
    verdict,
)
from leakref.certify.checks.exact import MORE, NOISY, OTHERS, TAPERED, WITHIN_A_TENTH, judge_exactly
from leakref.certify.checks.inputs import BRIEF, GRIDS
from leakref.certify.checks.registry import Case, Outcome, check
from leakref.certify.subject.frames import Subject
from leakref.currents import UniformCurrent
from leakref.dispersion import DEEP
from leakref.methods import METHODS

__all__ = ["check_aligned", "check_backwards", "check_strong"]

WITHIN = (
    "The error |c - U| in c0 is compared, at each wavenumber at which the reference has nothing to note, with "
    f"{TOLERANCE}. The median of these ratios may be 1: one wavenumber at which a code settles on another maximum of "
    "the score does not decide. The reference's NSP stays below a third."
)
FAST = (2.05, 2.06, 2.08, 2.1)
"""Where waves are swept backwards, and a search from zero current still finds it: above 2.15 some end in its mirror
image."""


def _median(over: FloatArray) -> FloatArray:
    """The one in the middle alone, or the larger of two: one wavenumber may have its optimum in another basin."""
    order = np.argsort(over)  # NaN last
    middle = order[np.isfinite(over).sum() // 2]
    return np.where(np.arange(over.size) == middle, over, np.nan)


def _judged(subject: Subject, case: Case, without: tuple[str, ...] = ()) -> Outcome:
    """One sea with a current that is as fast, beside its waves, as in deep water; a method that is left out is not
    judged.
    """
    given = case.given
    slower = float(inputs.still().phase_velocity(1.5) / DEEP.phase_velocity(1.5))  # than in deep water
    u, v = given["current"]
    cube = inputs.sea(
        given["direction"],
        given.get("spread", 180.0),
        UniformCurrent((slower * u, slower * v)),
        grid=BRIEF,
        wavenumbers=given.get("wavenumbers", (1.3, 1.6, 1.9, 2.2)),
    )
    window = tapered(subject)

    def judge(method: str) -> Outcome:
        found, there = ask(subject, cube, window, method)
        over = np.hypot(*(found - cube.truth).T) / tolerance(cube, window, method)
        over = np.where(there & unflagged(cube, window, method), over, np.nan)
        return verdict(_median(over), cube, found, cube.truth)

    return each_method(subject, judge, without)


@check(
    "currents",
    "eq:SnJ",
    WITHIN,
    [
        Case("following", {"direction": 80.0, "current": (0.1, 0.6)}),
        # above k = 2 it sweeps part of the waves backwards, and least squares takes omega >= 0 only (decision D19)
        Case("crossing", {"direction": 80.0, "current": (0.7, -0.2), "backwards": True}),
        Case("opposing", {"direction": 80.0, "current": (-0.1, -0.3)}),
        Case("diagonal", {"direction": -35.0, "current": (0.45, -0.4)}, quick=False),
    ],
)
def check_strong(subject: Subject, case: Case) -> Outcome:
    """Currents near the phase speed of the waves: an optimiser that only looks around zero current, a range of
    frequencies cut off above the peak, or a first guess taken from the waves' own direction loses them."""
    return _judged(subject, case, blind_to_backward_waves() if case.given.get("backwards") else ())


@check(
    "currents",
    "eq:DSVkernel",
    WITHIN
    + " Least squares is left out: it takes omega >= 0 only (decision D19). So may any method that the reference "
    "does not have, of which this is not asked.",
    [
        Case(
            "opposing",
            {"direction": 80.0, "spread": 40.0, "current": (-0.1, -0.75), "wavenumbers": (1.2, 1.3, 1.4, 1.5, 1.65)},
        ),
        Case(
            "broad", {"direction": 80.0, "current": (-0.1, -0.85), "wavenumbers": (1.2, 1.25, 1.3, 1.35)}, quick=False
        ),
        Case("oblique", {"direction": 80.0, "current": (-0.5, -0.5), "wavenumbers": FAST}),
        Case("oblique-2", {"direction": -100.0, "current": (0.5, 0.5), "wavenumbers": FAST}, quick=False),
    ],
)
def check_backwards(subject: Subject, case: Case) -> Outcome:
    """On an opposing current omega0 + k.U is negative for part of the waves: they are swept backwards, and without the
    second branch of G they are lost."""
    unknown = tuple(method for method in subject.methods if method not in METHODS)
    return _judged(subject, case, (*blind_to_backward_waves(), *unknown))


@check(
    "currents",
    "eq:normSp",
    WITHIN_A_TENTH + OTHERS + TAPERED + NOISY + MORE,
    [
        Case("following", {"grid": "even", "near": (0.1, 0.55)}),
        Case("crossing", {"grid": "odd", "near": (0.4, -0.1)}),
        Case("opposing", {"grid": "prime", "near": (-0.15, -0.3)}),
        Case("following-2", {"grid": "prime", "near": (0.3, 0.3)}, quick=False),
    ],
)
def check_aligned(subject: Subject, case: Case) -> Outcome:
    """A strong current, known exactly by two waves on bins of an untapered cube, which do not leak: what is off here
    comes from the code alone."""
    grid, near = GRIDS[case.given["grid"]], case.given["near"]
    cube = inputs.pair(grid, (3, 5), (-4, 4), near)
    more, allowed = inputs.many(grid.shape, near), FRACTION * cube.resolutions[0]
    return each_method(subject, lambda method: judge_exactly(subject, cube, method, allowed, more=more))
