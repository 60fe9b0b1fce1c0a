"""Water with a bottom and a surface tension, for codes that are told of them.

Asked only of a code that declares one of them as given: all others are asked in the one water that they know. Waves on
bins fix the current in every water, so that what is off here is off because of the law of dispersion in the code.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from leakref.certify.checks import inputs
from leakref.certify.checks.criteria import IN_THE_MEAN, each_method, in_the_mean, tapered, vector
from leakref.certify.checks.draw import drawing
from leakref.certify.checks.exact import (
    EXACT_OR_SCORE,
    EXACTLY,
    FINE,
    MORE,
    NOISY,
    TAPERED,
    aligned_window,
    judge_exactly,
    of_its_own,
    others_in_words,
)
from leakref.certify.checks.inputs import GRIDS, Cube, polar
from leakref.certify.checks.registry import Case, Outcome, check
from leakref.certify.subject.declaration import WATER
from leakref.certify.subject.frames import Subject
from leakref.certify.verdict import Unanswered, Verdict
from leakref.currents import ExponentialCurrent, UniformCurrent
from leakref.dispersion import Water
from leakref.grid import Grid

__all__ = [
    "RIPPLES",
    "TENSION",
    "check_aligned",
    "check_change",
    "check_limit",
    "check_ring",
    "check_sea",
    "check_tension",
    "explained",
]

TENSION = 0.12
"""S k0^2 / g: that of clean water, 7.4e-5 m3/s2, where the waves of the peak are 5 cm long."""
RIPPLES = float(np.sqrt(TENSION * 9.81 / 7.4e-5))
"""The peak wavenumber of those, rad/m."""
SAME = 0.05
"""Relative: depths that two waves tell of, as one."""
UNCHANGED = 1e-6
"""In c0: two answers to one cube that are so near are one; none of the questions changes it by less than 0.03."""
NO_BOTTOM = 3e-4
"""Of tanh(k h) from 1: what the rounding of optimisers does to it."""
DEPTH, SURFACE = ("depth",), ("surface_tension",)
"""What a code must be told of the water for a question."""
BINS = {
    "even": ((5, 3), (-2, 5)),
    "odd": ((-4, 4), (5, 2)),
    "prime": ((3, -5), (6, 1)),
}
"""Of a pair of waves on each grid."""


def _case(identifier: str, given: dict[str, Any], *, quick: bool = True, water: tuple[str, ...] = DEPTH) -> Case:
    return Case(identifier, given, quick, water=water)


def _scale(subject: Subject) -> float:
    """At which waves of the peak are those of `RIPPLES`, for a code in SI."""
    return 1.0 if subject.declaration.units == "scaled" else RIPPLES * subject.units(1.0)[0]


def _pair(name: str, near: tuple[float, float], water: Water, scale: float = 1.0) -> Cube:
    with inputs.in_water(water):
        return replace(inputs.pair(GRIDS[name], *BINS[name], near), scale=scale)


def _many(name: str, near: tuple[float, float], water: Water, scale: float = 1.0) -> Cube:
    with inputs.in_water(water):
        return replace(inputs.many(GRIDS[name].shape, near), scale=scale)


def _in_other_water(cube: Cube, water: Water) -> Cube:
    """The same two waves, which in other water are on another current."""
    waves = cube.components
    k = np.stack([waves.kx, waves.ky], axis=1)
    current = np.linalg.solve(k, waves.omega - water.frequency(np.hypot(*k.T)))
    return replace(cube, water=water, current=UniformCurrent((float(current[0]), float(current[1]))))


def explained(subject: Subject, cube: Cube, outcome: Outcome) -> Outcome:
    """With the depth for which an answer that is wrong would be right, if there is one: of two waves both tell it."""
    rows = outcome.figures.get("velocities")
    if outcome.over <= 1 or rows is None or cube.components.kx.size != 2 or aligned_window(subject) != "box":
        return outcome
    waves, k = cube.components, np.hypot(cube.components.kx, cube.components.ky)
    found = np.asarray(rows, dtype=np.float64)[0]
    still = waves.omega - np.stack([waves.kx, waves.ky], axis=1) @ found
    tanh = still**2 / (k + cube.water.surface_tension * k**3)
    if not (np.isfinite(tanh).all() and (still > 0).all()):
        return outcome
    with np.errstate(divide="ignore", invalid="ignore"):
        depth = np.full(2, np.inf) if np.abs(tanh - 1).max() < NO_BOTTOM else np.arctanh(tanh) / k
        if not (depth == np.inf).all() and not np.ptp(depth) < SAME * depth.mean():
            return outcome
    right_in = _in_words(subject, float(depth.mean()), cube.scale)
    plain = outcome.message.partition("; that is within the resolution")[0]  # of no use: it is wrong about the water
    figures = {**outcome.figures, "right_in": right_in}
    return replace(outcome, message=f"{plain}. That is right in {right_in}", figures=figures)


def _in_words(subject: Subject, depth: float, scale: float = 1.0) -> str:
    """A depth, scaled, in the code's own units."""
    length, _, _ = subject.units(scale)
    unit = " m" if subject.declaration.units == "si" else " / k0"
    return "deep water" if depth == np.inf else f"a depth of {depth * length:.3g}{unit}"


@check(
    "depth",
    "sec:theory",
    EXACTLY + MORE,
    [
        _case("0.7", {"grid": "even", "depth": 0.7, "near": (0.11, -0.13)}),
        _case("1.2", {"grid": "odd", "depth": 1.2, "near": (0.05, 0.2)}),
        _case("2", {"grid": "prime", "depth": 2.0, "near": (-0.15, 0.05)}),
        _case("0.7-2", {"grid": "prime", "depth": 0.7, "near": (0.0, 0.0)}, quick=False),
        _case("1.2-2", {"grid": "even", "depth": 1.2, "near": (-0.2, 0.1)}, quick=False),
    ],
)
def check_aligned(subject: Subject, case: Case) -> Outcome:
    """Two waves on bins, in water as deep as the id says, k0 h: a tanh outside the root, k h in cycles, a depth in
    feet, counted negative or not used at all gives another current, and the paper's deep water is an eighth off where
    k0 h is 1."""
    grid, near = case.given["grid"], case.given["near"]
    water = replace(inputs.still(), depth=case.given["depth"])
    cube, more = _pair(grid, near, water), _many(grid, near, water)
    return each_method(
        subject, lambda method: explained(subject, cube, judge_exactly(subject, cube, method, more=more))
    )


@check(
    "depth",
    "sec:theory",
    EXACT_OR_SCORE + others_in_words("a tenth of ") + TAPERED + NOISY,
    [
        _case("0.9", {"depth": 0.9, "current": (5, -5)}),
        _case("1.6", {"depth": 1.6, "current": (-5, 0)}, quick=False),
        _case("tension", {"surface_tension": TENSION, "current": (0, -5)}, water=SURFACE),
        _case("film", {"depth": 0.8, "surface_tension": TENSION, "current": (5, 0)}, water=DEPTH + SURFACE),
    ],
)
def check_ring(subject: Subject, case: Case) -> Outcome:
    """Four waves of one length within a quarter of the circle, on bins, asked for at just their wavenumber, in other
    water: nothing is there to interpolate or to weigh, so that every algorithm is right to a few digits, and what is
    off is off because of the law of dispersion."""
    law = {name: value for name, value in case.given.items() if name in WATER}
    scale = _scale(subject) if "surface_tension" in law else 1.0
    water = replace(subject.still(scale), **law)
    with inputs.in_water(water):
        grid, draw = inputs.ring(5, 1.4, 24, (30, 33, 100)), drawing()
        u, v = (grid.frequency_resolution / 1.4 * draw.turn @ np.array(case.given["current"])).tolist()
        bins = np.array(draw.bins((5, 0), (4, 3), (3, 4), (0, 5)))
        cube, twelve = (
            replace(inputs.on_bins(grid, some, np.array([1.4]), UniformCurrent((u, v))), scale=scale)
            for some in (bins, inputs.TWELVE)
        )
    return each_method(subject, lambda method: judge_exactly(subject, cube, method, others=FINE, noisy=twelve))


@check(
    "depth",
    "sec:theory",
    EXACTLY + " No truth about the sea is needed: what the law of dispersion takes from the waves, the current gives.",
    [
        _case("1.2-for-0.8", {"grid": "even", "made": 0.8, "told": 1.2, "near": (0.08, -0.1)}),
        _case("deep-for-1", {"grid": "odd", "made": 1.0, "told": np.inf, "near": (0.12, 0.1)}),
        _case("0.9-for-deep", {"grid": "prime", "made": np.inf, "told": 0.9, "near": (-0.1, 0.0)}),
    ],
)
def check_change(subject: Subject, case: Case) -> Outcome:
    """One and the same cube, and another depth handed over: the answer must change by what the law of dispersion says.
    A depth that is not used, or only where it was never tried, that of the tile before or a default changes nothing."""
    given, still = case.given, inputs.still()
    cube = _pair(given["grid"], given["near"], replace(still, depth=given["made"]))
    other = _in_other_water(cube, replace(still, depth=given["told"]))

    def judge(method: str) -> Outcome:
        try:
            both = [judge_exactly(subject, one, method) for one in (cube, other)]
        except Unanswered as nothing:
            if nothing.verdict is not Verdict.MISSING:
                raise
            raise Unanswered(Verdict.UNSUPPORTED, "gives no velocity where two waves are all there is") from None
        first, second = (np.asarray(one.figures["velocities"])[0] for one in both)
        worse = max(range(2), key=lambda n: np.inf if np.isnan(both[n].over) else both[n].over)
        outcome = explained(subject, (cube, other)[worse], both[worse])
        if outcome.over <= 1:
            return outcome
        told, before = (_in_words(subject, one.water.depth) for one in (other, cube))
        words = f"handed {told} instead of {before} its answer changes by {vector(second - first)}, should change by "
        words += vector((other.truth - cube.truth)[0])
        unused = bool(np.hypot(*(second - first)) < UNCHANGED)
        if both[0].over > 1 and not unused and of_its_own(subject, method):
            raise Unanswered(Verdict.UNSUPPORTED, "is as far off in the water that the two waves were made in")
        words += ": the depth it is handed is not used" * unused
        return replace(outcome, message=f"{words}; {outcome.message}", figures={**outcome.figures, "unused": unused})

    return each_method(subject, judge)


@check(
    "depth",
    "sec:theory",
    EXACTLY + MORE,
    [
        _case("30", {"grid": "even", "depth": 30.0, "near": (0.1, 0.15)}),
        _case("ten-thousand", {"grid": "odd", "depth": 1e4, "near": (-0.12, 0.1)}),
    ],
)
def check_limit(subject: Subject, case: Case) -> Outcome:
    """Water so deep that no wave feels the bottom, k0 h of 30 and of ten thousand (the ocean under waves of a few
    metres): the answer is that of deep water, and no sinh or cosh of k h overflows on the way."""
    grid, near = case.given["grid"], case.given["near"]
    water = replace(inputs.still(), depth=case.given["depth"])
    return each_method(
        subject,
        lambda method: judge_exactly(subject, _pair(grid, near, water), method, more=_many(grid, near, water)),
    )


@check(
    "depth",
    "eq:dcdwk",
    IN_THE_MEAN,
    [
        _case("0.7", {"depth": 0.7, "direction": 40.0, "current": polar(0.15, 75.0)}),
        _case("1.2", {"depth": 1.2, "direction": -70.0, "current": polar(0.2, 160.0)}),
        _case("2", {"depth": 2.0, "direction": 120.0, "current": polar(0.2, -60.0)}, quick=False),
        _case("sheared", {"depth": 1.0, "direction": 60.0, "shear": True}),
    ],
)
def check_sea(subject: Subject, case: Case) -> Outcome:
    """A broad sea in water of finite depth, tapered, as in the field; in one the current decays with depth, and each
    wavenumber feels what the bottom leaves of it (eq:SJ with the weight of finite depth)."""
    given = case.given
    if given.get("shear") and subject.declaration.band:
        raise Unanswered(Verdict.UNSUPPORTED, "gives one velocity for the whole band")
    current = ExponentialCurrent((0.5, 0.25), 0.4) if given.get("shear") else UniformCurrent(given["current"])
    with inputs.in_water(replace(inputs.still(), depth=given["depth"])):
        cube = inputs.sea(given["direction"], 180.0, current, realization=31)
    return each_method(subject, lambda method: in_the_mean(subject, cube, tapered(subject), method))


TANK = Grid((36, 40, 90), (0.68, 0.62, 0.5))
"""A shorter step in time: surface tension makes short waves fast."""


@check(
    "depth",
    "sec:theory",
    EXACTLY + MORE + " In the sea: " + IN_THE_MEAN,
    [
        _case("aligned", {"grid": "even", "near": (0.1, -0.1)}, water=SURFACE),
        _case("tank", {"grid": "prime", "near": (-0.08, 0.12), "depth": 1.0}, water=DEPTH + SURFACE),
        _case("sea", {"current": polar(0.2, 30.0)}, water=SURFACE),
    ],
)
def check_tension(subject: Subject, case: Case) -> Outcome:
    """Waves of a few centimetres, which surface tension makes faster, in a tank in water of finite depth as well: left
    out, divided by the density twice, or with k squared for k cubed the current is another one."""
    given = case.given
    scale = _scale(subject)
    water = replace(subject.still(scale), surface_tension=TENSION)
    water = replace(water, depth=given.get("depth", water.depth))
    if "current" in given:
        with inputs.in_water(water):
            sea = inputs.sea(100.0, 180.0, UniformCurrent(given["current"]), realization=32, grid=TANK)
        sea = replace(sea, scale=scale)
        return each_method(subject, lambda method: in_the_mean(subject, sea, tapered(subject), method))
    cube, more = (make(given["grid"], given["near"], water, scale) for make in (_pair, _many))
    return each_method(subject, lambda method: judge_exactly(subject, cube, method, more=more))
