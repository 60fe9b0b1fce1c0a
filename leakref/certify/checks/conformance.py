"""Conformance to the golden values, stage by stage, and to the reference on small seas.

The one family that another algorithm need not pass: it decides between conformant and sound, and rejects no code that
is judged by other families too. Each question is an entry of the golden set, asked in the code's own axes and units;
the answer is compared with what is kept, or with what the reference says now of a few small seas.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from leakref._base import FloatArray
from leakref.certify.checks import inputs
from leakref.certify.checks.criteria import as_array, expected, unflagged, verdict
from leakref.certify.checks.exact import EXACT, as_good
from leakref.certify.checks.inputs import Cube, polar
from leakref.certify.checks.registry import CHECKS, Case, Check, Outcome, check
from leakref.certify.subject.declaration import WATER
from leakref.certify.subject.frames import Subject
from leakref.certify.verdict import Unanswered, Verdict
from leakref.currents import UniformCurrent
from leakref.dispersion import Scales, Water
from leakref.golden.sets import NEWEST, Entry, Golden, agreed_digits, locate
from leakref.grid import Grid
from leakref.methods import DEFAULT, METHODS
from leakref.sea import Components
from leakref.synthesis import synthesize

__all__ = [
    "MORE",
    "NEWEST",
    "PRECISION",
    "check_extract",
    "check_sea",
    "check_spectrum",
    "check_surface",
    "check_window",
    "of_set",
]

MORE = tuple(name for name in METHODS if name not in DEFAULT)
"""Methods beside the paper's: what is of them is asked of those that declare them."""
_RIPPLES = 100.0  # k0 of waves that feel the surface tension, rad/m
PRECISION = 1e-5
"""Of the largest value: a hundred times what single precision rounds, a thousandth of an error of one percent."""
CLOSE = (
    "A value may be off by 1e-5 of the largest one: a hundred times the rounding of single precision, and a "
    "thousandth of what a constant that is a percent off would do. The digits that agree are reported."
)
SCORED = (
    "Each velocity may be off by 2e-4 c0 from the golden one, three times what optimisers with default tolerances "
    "were seen to miss by. The golden one is what the method itself finds, whatever the true current is: for the NSP "
    "the maximum that a search from zero current arrives at. An NSP velocity that is further off passes all the same "
    "if the reference gives it a score within a relative 1e-6 of the golden one's. To how many digits the two agree is "
    "reported beside it."
)


@cache
def _entries(stage: str, number: int) -> dict[str, Entry]:
    """The golden vectors of a stage, in a set, that hold a number; none where the set knows no such stage."""
    golden, name = Golden(locate(number)), f"vectors/{stage}.json"
    there = any(name in one.manifest["files"] for one in golden.chain)
    return {entry.id: entry for entry in golden.file(name) if entry.values} if there else {}


def _vectors(*stages: str, number: int = NEWEST) -> list[Case]:
    """A case for each vector of the stages; those in other water than deep are for codes that are told of it."""
    return [
        Case(
            identifier,
            {"stage": stage, "set": number},
            water=tuple(name for name in WATER if name in entry.record["input"]),
            method=stage if stage in MORE else "",
        )
        for stage in stages
        for identifier, entry in _entries(stage, number).items()
    ]


def _entry(case: Case) -> Entry:
    return _entries(case.given["stage"], case.given["set"])[case.id]


def of_set(number: int) -> dict[str, Check]:
    """The checks by id that compare with golden vectors, on those of another set. Raises LeakrefError."""
    own = [c for c in CHECKS.values() if any("set" in case.given for case in c.cases)]
    stages = {c.id: dict.fromkeys(case.given["stage"] for case in c.cases) for c in own}
    return {c.id: replace(c, cases=tuple(_vectors(*stages[c.id], number=number))) for c in own}


def _waves(entry: Entry) -> Components:
    return Components(*(np.asarray(entry.input[name], dtype=np.float64) for name in Components.__dataclass_fields__))


def _agreement(found: FloatArray, golden: FloatArray, allowed: FloatArray, what: str, **figures: Any) -> Outcome:
    """Of arrays, by the largest difference over the largest golden value; all digits if within the golden tolerance."""
    off, scale = np.abs(found - golden), float(np.abs(golden).max())
    worst = np.unravel_index(int(off.argmax()), off.shape)
    difference = float(off.max())
    digits = agreed_digits(0.0 if np.all(off <= allowed) else difference, scale)
    return Outcome(
        difference / (PRECISION * scale),
        f"{what}{list(map(int, worst))} is {found[worst]:.10g}, should be "
        f"{golden[worst]:.10g}; {digits:g} digits agree",
        digits,
        {"difference": difference, **figures},
    )


@check("conformance", "eq:hann", CLOSE, _vectors("window"), stage="window")
def check_window(subject: Subject, case: Case) -> Outcome:
    """The samples of a window: periodic, n / N, and not n / (N - 1); its coefficients to all their digits."""
    entry = _entry(case)
    found = subject.window(entry.input["window"], entry.input["size"])
    return _agreement(found, entry.output["w"], entry.tolerance("w"), "w")


@check("conformance", "sec:spectrum", CLOSE, _vectors("surface"), stage="synthesize")
def check_surface(subject: Subject, case: Case) -> Outcome:
    """The surface of a list of waves, sample by sample: signs and phases, no lattice, frequencies below zero."""
    entry = _entry(case)
    x, y, t = (np.asarray(entry.input[axis], dtype=np.float64) for axis in "xyt")
    return _agreement(subject.synthesize(_waves(entry), x, y, t), entry.output["eta"], entry.tolerance("eta"), "eta")


@check(
    "conformance",
    "sec:leakage",
    CLOSE + " One common factor is fitted first, and a real S is taken for the magnitude.",
    _vectors("spectrum", "transform"),
    stage="spectrum",
)
def check_spectrum(subject: Subject, case: Case) -> Outcome:
    """The spectrum of a surface: order and sign of all three axes, the window along each, waves beyond and near
    Nyquist, frequencies below zero."""
    entry = _entry(case)
    spacing = tuple(entry.input["spacing"])
    golden = entry.output["real"] + 1j * entry.output["imag"]
    surface = (
        np.asarray(entry.input["surface"], dtype=np.float64)
        if "surface" in entry.input
        else synthesize(_waves(entry), *(Grid(tuple(entry.input["shape"]), spacing).samples(axis) for axis in range(3)))
    )
    found = np.asarray(subject.spectrum(surface, spacing, entry.input["window"]))
    if not np.iscomplexobj(found):
        golden = np.abs(golden)
    power = float(np.vdot(found, found).real)
    if not 0 < power < np.inf:
        raise Unanswered(Verdict.FAIL, "S is zero everywhere, or holds values that are not finite")
    factor = np.vdot(found, golden) / power
    return _agreement(found * factor, golden, entry.tolerance("real"), "S", factor=[factor.real, factor.imag])


def _scored(cube: Cube, window: str, method: str, found: FloatArray, golden: FloatArray) -> FloatArray:
    """Error over tolerance at each wavenumber, (n,): by the velocity, or by the score if that is kinder."""
    return as_good(np.hypot(*(found - golden).T) / EXACT, cube, window, method, found, golden)


def _velocities(
    subject: Subject, cube: Cube, surface: FloatArray, window: str, method: str, golden: FloatArray, allowed: FloatArray
) -> Outcome:
    """Compare with `golden` (n, 2), NaN where there is no number; `allowed` (n, 1) is its tolerance."""
    numbers = np.asarray(np.isfinite(golden).all(axis=1))
    asked = cube.spacing, cube.wavenumbers, window, method
    found, there = as_array(subject, surface, *asked, numbers, cube.water, cube.scale)
    known = there & numbers
    over = np.full(known.size, np.nan)
    if known.any():
        part = replace(cube, wavenumbers=cube.wavenumbers[known])
        over[known] = _scored(part, window, method, found[known], golden[known])
    outcome = verdict(over, cube, found, golden)
    off = np.abs(found - golden)[known]
    digits = agreed_digits(0.0 if np.all(off <= allowed[known]) else float(off.max()), 1.0)
    return Outcome(outcome.over, f"{outcome.message}; {digits:g} digits agree", digits, outcome.figures)


@check("conformance", "eq:normSp", SCORED, _vectors("nsp", "ls", "extract", *MORE))
def check_extract(subject: Subject, case: Case) -> Outcome:
    """Velocities of small cubes, each with a purpose of its own: all four signs, uneven sides, prime sizes, gravity in
    SI units, waves swept backwards, bins on a threshold; in water of several depths, waves of centimetres."""
    entry = _entry(case)
    given, k0 = entry.input, _RIPPLES if "surface_tension" in case.water else 1.0
    scales, (dx, dy, dt), waves = Scales(k0, given["gravity"]), given["spacing"], _waves(entry)
    grid = Grid(tuple(given["shape"]), (dx * k0, dy * k0, dt / scales.time))
    scaled = Components(waves.kx / k0, waves.ky / k0, waves.omega / scales.frequency, waves.amplitude * k0, waves.phase)
    water = Water(given["gravity"], given.get("depth", np.inf), given.get("surface_tension", 0.0)).to_scaled(scales)
    scale = k0 * subject.units(1.0)[0] if k0 != 1 and subject.declaration.units == "si" else 1.0  # as long as they are
    cube = Cube(scaled, grid, np.asarray(given["wavenumbers"]) / k0, UniformCurrent(), water, scale)
    surface = np.asarray(given["surface"]) * k0 if "surface" in given else cube.surface
    return _velocities(
        subject,
        cube,
        surface,
        given["window"],
        given.get("method", entry.stage),
        entry.output["velocities"] / scales.velocity,
        entry.tolerance("velocities") / scales.velocity,
    )


SQUARE = Grid((42, 42, 66), (0.72, 0.72, 0.7))


def _sea(name: str) -> Cube:
    """Seas that the reference is asked about now: edge bins on a square domain, odd sizes, a strong current."""
    dk = SQUARE.wavenumber_resolution
    return {
        "edges": lambda: inputs.sea(
            40.0,
            120.0,
            UniformCurrent(polar(0.1, 10.0)),
            realization=21,
            grid=SQUARE,
            wavenumbers=tuple(float(n * dk) for n in (5, 6, 8, 10, 13)),
        ),
        "odd": lambda: inputs.sea(
            -110.0,
            70.0,
            UniformCurrent(polar(0.15, 200.0)),
            realization=22,
            grid=Grid((45, 39, 61), (0.66, 0.74, 0.83)),
            wavenumbers=(1.05, 1.3, 1.7, 2.2, 2.8),
        ),
        "narrow": lambda: inputs.sea(
            65.0, 25.0, UniformCurrent(polar(0.05, 90.0)), realization=23, wavenumbers=(1.1, 1.4, 1.8, 2.3)
        ),
        "strong": lambda: inputs.sea(
            80.0,
            180.0,
            UniformCurrent((-0.5, -0.5)),
            realization=24,
            grid=inputs.BRIEF,
            wavenumbers=(1.3, 1.6, 1.9, 2.2, 2.5),
        ),
    }[name]()


@check(
    "conformance",
    "eq:normSp",
    SCORED.replace("the golden one,", "that of the reference by the same method in the same cube,")
    .replace("The golden one is", "That is")
    .replace("the golden one's", "its own")
    + " Wavenumbers at which the reference has something to note are left out.",
    [
        Case(
            f"{name}-{window}-{method}",
            {"sea": name, "window": window, "method": method},
            quick=name in ("edges", "strong"),
            method=method if method in MORE else "",
        )
        for name in ("edges", "odd", "narrow", "strong")
        for window in ("hann", "box")
        for method in (*DEFAULT, *MORE)
    ],
)
def check_sea(subject: Subject, case: Case) -> Outcome:
    """Whole seas against the reference: which bins belong to a shell, those on its edge too, how they are weighted,
    where the frequencies end, which width the Gaussian has, which bins pass the threshold."""
    cube, window, method = _sea(case.given["sea"]), case.given["window"], case.given["method"]
    reference = expected(cube, window, method)
    known = unflagged(cube, window, method)
    golden = np.where(known[:, None], reference.velocities, np.nan)
    return _velocities(subject, cube, cube.surface, window, method, golden, np.full((known.size, 1), 1e-11))
