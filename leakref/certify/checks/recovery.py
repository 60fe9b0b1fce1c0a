"""Exact recovery: what is known exactly is returned exactly.

Waves with whole numbers of wavelengths and periods in the cube do not leak, and two of them fix the current: the right
answer is known to all digits, without a reference. What is off here is off because of the code, not of the method.
"""

from __future__ import annotations

import numpy as np

from leakref.certify.checks import inputs
from leakref.certify.checks.criteria import (
    EXACT,
    EXACT_OR_SCORE,
    EXACTLY,
    IN_THE_MEAN,
    ask,
    each_method,
    exactly,
    in_the_mean,
    scored_method,
    tapered,
    untapered,
    vector,
    verdict,
)
from leakref.certify.checks.draw import drawing
from leakref.certify.checks.inputs import GRIDS, polar
from leakref.certify.checks.registry import Case, Outcome, check
from leakref.certify.subject.frames import Subject
from leakref.currents import UniformCurrent
from leakref.dispersion import DEEP
from leakref.sea import aligned_waves

__all__ = ["check_pair", "check_sea", "check_single", "check_two_shells"]

PAIRS = [
    Case(f"{grid}-{n}", {"grid": grid, "bins": bins, "near": near}, quick=quick)
    for grid, n, bins, near, quick in (
        ("even", 1, ((5, 3), (-2, 5)), (0.21, -0.13), True),
        ("even", 2, ((6, -1), (4, 4)), (-0.1, 0.02), True),
        ("odd", 1, ((-4, 4), (5, 2)), (0.05, 0.3), True),
        ("odd", 2, ((0, -6), (6, 0)), (-0.2, -0.15), True),
        ("prime", 1, ((3, -5), (6, 1)), (0.0, 0.0), True),
        ("prime", 2, ((-6, -2), (-1, 6)), (0.15, 0.1), True),
        ("even", 3, ((5, 3), (-2, 5)), (-0.3, -0.2), False),
        ("odd", 3, ((1, 6), (-5, 2)), (0.33, -0.02), False),
        ("prime", 3, ((7, 0), (0, -6)), (-0.02, -0.3), False),
        ("prime", 4, ((4, 5), (7, -1)), (0.1, 0.25), False),
    )
]


@check("recovery", "eq:normSp", EXACTLY, PAIRS)
def check_pair(subject: Subject, case: Case) -> Outcome:
    """Two waves on bins of an untapered cube fix a uniform current exactly: lengths of (n - 1) d instead of n d, the
    gravity or the root of the dispersion relation, a wrong bin or a wrong branch all show."""
    first, second = case.given["bins"]
    cube, window = inputs.pair(GRIDS[case.given["grid"]], first, second, case.given["near"]), untapered(subject)

    def judge(method: str) -> Outcome:
        found, there = ask(subject, cube, window, method)
        over = np.where(there, exactly(subject, cube, window, method, found, cube.truth), np.nan)
        return verdict(over, cube, found, cube.truth)

    return each_method(subject, judge)


@check(
    "recovery",
    "eq:SnJ",
    "The velocity along the wave may be off by 2e-4 c0, three times what optimisers with "
    "default tolerances were seen to miss by.",
    [
        Case("even", {"grid": "even", "bin": (5, 2), "shift": 2}),
        Case("odd", {"grid": "odd", "bin": (-3, 5), "shift": -2}),
        Case("prime", {"grid": "prime", "bin": (1, -6), "shift": 3}, quick=False),
    ],
)
def check_single(subject: Subject, case: Case) -> Outcome:
    """One wave fixes the component of the current along it and no more: what is returned along it must be right."""
    method = scored_method(subject, "offers no NSP; other methods may decline where one wave is all there is")
    draw, window, grid = drawing(), untapered(subject), inputs.sampling(GRIDS[case.given["grid"]])
    ((i, j),) = draw.bins(case.given["bin"])
    k = np.array([i, j]) * grid.bin_widths[:2]
    size = float(np.hypot(*k))
    m = round(float(DEEP.frequency(size)) / grid.frequency_resolution) + case.given["shift"]
    waves, current = aligned_waves(grid, [(i, j, m)], phase=draw.phases(np.array([0.3])).tolist())
    cube = inputs.Cube(waves, grid, np.array([size]), UniformCurrent((float(current[0]), float(current[1]))))
    found, _ = ask(subject, cube, window, method)
    along, should = float(found[0] @ k) / size, float(current @ k) / size
    return Outcome(
        abs(along - should) / EXACT,
        f"along the wave got {along:.6g}, should be {should:.6g} (its velocity is {vector(found[0])})",
        figures={"along": along, "should_be": should},
    )


@check(
    "recovery",
    "eq:g",
    EXACT_OR_SCORE + " A method that the reference does not have may be off by the smaller of "
    "the two velocity resolutions. One velocity for the whole band may be anywhere between the two currents, or "
    "outside by that resolution or half the distance between them: each wave fixes no more than one component.",
    [Case("even", {"grid": "even"}), Case("prime", {"grid": "prime"}, quick=False)],
)
def check_two_shells(subject: Subject, case: Case) -> Outcome:
    """Two pairs of waves, each with its own current, in shells that do not touch: a shell that is too wide, an answer
    at the wrong wavenumber or one answer for all mixes them up."""
    grid, window = GRIDS[case.given["grid"]], untapered(subject)
    low = inputs.pair(grid, (4, 1), (-2, 4), (0.2, -0.1))
    high = inputs.pair(grid, (9, -4), (5, 8), (-0.15, 0.1))
    both = inputs.Cube(
        inputs.together(low.components, high.components),
        low.grid,
        np.concatenate([low.wavenumbers, high.wavenumbers]),
        UniformCurrent(),
    )
    should = np.concatenate([low.truth, high.truth])

    def judge(method: str) -> Outcome:
        found, there = ask(subject, both, window, method)
        if subject.declaration.band:
            outside = np.maximum(should.min(axis=0) - found, found - should.max(axis=0)).max(axis=1)
            allowed = np.maximum(both.resolutions[0], np.hypot(*(should[1] - should[0])) / 2)
            return verdict(np.maximum(outside, 0) / allowed, both, found, should)
        over = np.where(there, exactly(subject, both, window, method, found, should), np.nan)
        return verdict(over, both, found, should)

    return each_method(subject, judge)


@check(
    "recovery",
    "eq:dcdwk",
    IN_THE_MEAN + " The reference stays below a third of the tolerance.",
    [
        Case("broad", {"direction": 40.0, "spread": 180.0, "current": polar(0.2, 75.0)}),
        Case("all-round", {"direction": 0.0, "spread": 360.0, "current": polar(0.25, -160.0)}),
        Case("broad-2", {"direction": -80.0, "spread": 120.0, "current": polar(0.15, 20.0)}, quick=False),
    ],
)
def check_sea(subject: Subject, case: Case) -> Outcome:
    """A broad sea, tapered, as in the field: whatever the algorithm, it is right within the resolution."""
    given = case.given
    cube = inputs.sea(given["direction"], given["spread"], UniformCurrent(given["current"]), realization=3)
    return each_method(subject, lambda method: in_the_mean(subject, cube, tapered(subject), method))
