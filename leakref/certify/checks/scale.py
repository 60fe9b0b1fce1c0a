"""Scale invariance: the same dimensionless sea at two peak wavenumbers, under two gravities, over two durations."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from leakref.certify.checks import inputs
from leakref.certify.checks.criteria import (
    FRACTION,
    IN_THE_MEAN,
    answered,
    ask,
    each_method,
    in_the_mean,
    tapered,
    unflagged,
    untapered,
    verdict,
)
from leakref.certify.checks.inputs import BRIEF, SEA, Cube, polar
from leakref.certify.checks.registry import Case, Outcome, check
from leakref.certify.subject.frames import Subject
from leakref.certify.verdict import Unanswered, Verdict
from leakref.currents import UniformCurrent
from leakref.grid import Grid

__all__ = ["ENDS", "RIPPLING", "check_duration", "check_gravity", "check_peak", "shown_at"]

LONG = Grid((40, 42, 144), (0.72, 0.7, 0.8))


RIPPLING = 0.3
"""S k0^2 / g: a code whose surface tension stands in it is shown no waves that feel it more."""
ENDS = (16.0, 1 / 16)
"""The scales of the shortest and of the longest waves that a code is shown which says nothing of its waves."""
CLOSE = (
    "A velocity in units of c0 may differ by a tenth of the smaller of the two velocity resolutions, at wavenumbers at "
    "which the reference has nothing to note. In scaled units the two seas are one computation."
)


def _another(
    subject: Subject, cube: Cube, window: str, method: str, *, scale: float = 1.0, gravity: float = 1.0
) -> Outcome:
    """The same sea shown at another `scale`, or under another `gravity`, beside what was found of it as it is."""
    found, there = ask(subject, cube, window, method)
    other = subject.extract(
        cube.surface, cube.spacing, cube.wavenumbers, window=window, method=method, scale=scale, gravity=gravity
    )
    there &= answered(subject, other)
    over = np.hypot(*(other.values - found).T) / (FRACTION * cube.resolutions[0])
    known = there & unflagged(cube, window, method)
    return verdict(np.where(known, over, np.nan), cube, other.values, found)


@check(
    "scale",
    "sec:dimensions",
    CLOSE + " For a code that knows one depth only the other sea is in other water, and one that declares the waves it "
    "is made for is shown those: " + IN_THE_MEAN,
    [
        Case(name + ("" if tapered else "-untapered"), {"scale": scale, "tapered": tapered}, quick=quick)
        for name, scale, quick in (
            ("4", 4.0, True),
            ("sixteenth", 1 / 16, True),
            ("quarter", 0.25, False),
            ("16", 16.0, True),
        )
        for tapered in (True, False)
    ],
)
def check_peak(subject: Subject, case: Case) -> Outcome:
    """The same sea with waves four times shorter or sixteen times longer, or at the ends of those that a code declares:
    a width in rad/s, a gravity, a search range or a threshold that was set for one sea state gives another current, and
    is as sure of it."""
    window = tapered(subject) if case.given["tapered"] else untapered(subject)
    shown = subject.shown_as
    scale = shown.scale(case.given["scale"])
    if abs(np.log(scale)) < 1e-6:
        raise Unanswered(Verdict.UNSUPPORTED, "is made for no such waves")
    if subject.still(scale).surface_tension > RIPPLING:
        raise Unanswered(Verdict.UNSUPPORTED, "knows one surface tension, which makes such waves too fast for the cube")
    if subject.still(scale) == subject.still() and not shown.waves:
        cube = shown_at(subject, 1.0)
        return each_method(subject, lambda method: _another(subject, cube, window, method, scale=scale))
    if window == "box":
        raise Unanswered(Verdict.UNSUPPORTED, "knows one water or some waves only; untapered they are compared in all")
    return each_method(subject, lambda method: in_the_mean(subject, shown_at(subject, scale), window, method))


def shown_at(subject: Subject, scale: float) -> Cube:
    """The sea of the family, in the water and on a current that the code knows there."""
    with inputs.in_water(subject.still(scale), subject.shown_as.fastest(scale)):
        current = UniformCurrent(polar(0.2, -30.0))
        cube = inputs.sea(70.0, 100.0, current, realization=11, wavenumbers=(1.3, 1.6, 2.0, 2.5))
    return replace(cube, scale=scale)


@check(
    "scale",
    "eq:g",
    CLOSE,
    [Case("moon", {"gravity": 0.165}), Case("jupiter", {"gravity": 2.53}, quick=False)],
)
def check_gravity(subject: Subject, case: Case) -> Outcome:
    """The same sea under another gravity, which is handed over with it: a gravity that stands in the code, in metres
    and seconds or as 1 or 10, is wrong by a large factor then."""
    if "gravity" in subject.declaration.untold:
        raise Unanswered(Verdict.UNSUPPORTED, "cannot be told the gravity")
    if subject.still().surface_tension:
        raise Unanswered(Verdict.UNSUPPORTED, "knows one surface tension, beside which another gravity is other water")
    window = tapered(subject)
    cube = inputs.sea(70.0, 100.0, UniformCurrent(polar(0.2, -30.0)), realization=11, wavenumbers=(1.3, 1.6, 2.0))

    def judge(method: str) -> Outcome:
        outcome = _another(subject, cube, window, method, gravity=case.given["gravity"])
        hint = "; what cannot be told the gravity declares it as fixed" if outcome.over > 1 else ""
        return replace(outcome, message=f"under {case.given['gravity']:g} of the usual gravity {outcome.message}{hint}")

    return each_method(subject, judge)


@check(
    "scale",
    "eq:DSVkernel",
    IN_THE_MEAN,
    [Case("brief", {"grid": BRIEF}), Case("ten-periods", {"grid": SEA}, quick=False), Case("long", {"grid": LONG})],
)
def check_duration(subject: Subject, case: Case) -> Outcome:
    """The same current seen for three periods of the peak (brief), ten, or eighteen (long): a width of the band around
    the dispersion relation that does not follow the frequency bins is too narrow for some or too wide for others."""
    cube = inputs.sea(
        70.0,
        100.0,
        UniformCurrent(polar(0.3, 150.0)),
        realization=2,
        grid=case.given["grid"],
        wavenumbers=(1.3, 1.6, 2.0, 2.4),
    )
    return each_method(subject, lambda method: in_the_mean(subject, cube, tapered(subject), method))
