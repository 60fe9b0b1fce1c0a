"""Leakage at zero current: what is measured in still water.

Untapered, leakage alone looks like a current; tapered, it must not. What a code measures in still water, beside a
strong swell or under a flicker, is compared with what the paper found and with what the reference measures there.
"""

from __future__ import annotations

import numpy as np

from leakref._base import FloatArray
from leakref.certify.checks import inputs
from leakref.certify.checks.criteria import (
    IN_THE_MEAN,
    ask,
    each_method,
    expected,
    in_the_mean,
    scored_method,
    tapered,
    unflagged,
)
from leakref.certify.checks.draw import drawing
from leakref.certify.checks.exact import EXACT_OR_SCORE, FINE, NOISY, TAPERED, deep_only, judge_exactly, others_in_words
from leakref.certify.checks.inputs import SEA, Cube, polar
from leakref.certify.checks.registry import Case, Outcome, check
from leakref.certify.checks.statistics import excess, share
from leakref.certify.subject.frames import Subject
from leakref.certify.verdict import Unanswered, Verdict
from leakref.currents import UniformCurrent
from leakref.dispersion import DEEP
from leakref.grid import Grid
from leakref.methods import METHODS
from leakref.sea import Components

__all__ = ["MARGIN", "check_aligned", "check_bias", "check_flicker", "check_still", "check_swell"]

MARGIN = 0.5
"""Of the mean smaller resolution: how much larger an error than the reference's may be in the mean."""
WITHIN = IN_THE_MEAN + (
    " The reference stays below half of the tolerance if the cube is tapered, and is above it if not."
)


@check(
    "leakage",
    "sec:leakage",
    WITHIN + " In seas so narrow each make of a method errs in its own way: one of the reference's name that does not "
    "answer as it does (guide protocol, section 3) may err by the larger resolution beside what the reference errs by.",
    [
        Case("narrow", {"direction": 60.0, "spread": 15.0, "peakedness": 7.0, "realization": 4}),
        Case("sharp", {"direction": 60.0, "spread": 20.0, "peakedness": 7.0, "realization": 0}),
        Case("broad", {"direction": 75.0, "spread": 90.0, "peakedness": 3.3, "realization": 1}),
        Case("medium", {"direction": 75.0, "spread": 45.0, "peakedness": 7.0, "realization": 5}, quick=False),
    ],
)
def check_still(subject: Subject, case: Case) -> Outcome:
    """In still water an untapered cube shows a current across a narrow sea, of the order of the phase speed of the
    waves: a window that is missing, or missing along one axis, is seen here."""
    given = case.given
    cube = inputs.sea(
        given["direction"],
        given["spread"],
        None,
        realization=given["realization"],
        peakedness=given["peakedness"],
        wavenumbers=(1.1, 1.25, 1.5, 1.8, 2.15, 2.5),
    )
    return each_method(subject, lambda method: in_the_mean(subject, cube, tapered(subject), method, beside=True))


@check(
    "leakage",
    "sec:leakage",
    IN_THE_MEAN + " The reference stays below half of the tolerance if the cube is "
    "tapered, and is several times above it if not.",
    [Case("low", {"at": (2.5, 1.5, 3.5)}), Case("lower", {"at": (1.5, 0.5, 2.5)}, quick=False)],
)
def check_swell(subject: Subject, case: Case) -> Outcome:
    """A strong swell half-way between bins, far below the waves that are looked at: tapered it is not seen there,
    untapered it is all there is."""
    n = np.arange(1, 41)
    k, angle = 1.2 + 1.6 * (n * np.sqrt(2) % 1), np.radians(70 + 60 * ((n * np.sqrt(3) % 1) - 0.5))
    local = inputs.waves(inputs.drawn(SEA), k * np.cos(angle), k * np.sin(angle), (1.9, 2.1, 2.3, 2.5))
    draw, (i, j, m) = drawing(), case.given["at"]
    kx, ky, omega = (np.array([v]) for v in np.multiply([*draw.turn @ [i, j], m], local.grid.bin_widths))
    swell = Components(kx, ky, omega, np.array([60.0]), draw.phases(np.array([0.3])))
    cube = Cube(inputs.together(local.components, swell), local.grid, local.wavenumbers, local.current)
    return each_method(subject, lambda method: in_the_mean(subject, cube, tapered(subject), method))


@check(
    "leakage",
    "sec:leakage",
    WITHIN + " A code that is as far off where the texture is on a bin, and so does not leak, is not judged: it is the "
    "texture that it cannot take, because of a threshold or a search that goes far.",
    [Case("fast"), Case("strong", {"strength": 200.0}, quick=False)],
)
def check_flicker(subject: Subject, case: Case) -> Outcome:
    """A texture that flickers far faster than the waves and many times as strong: tapered along time it stays at its
    own frequency; if not, it is smeared over all of them."""
    method = scored_method(subject, "offers no NSP; what fits the strongest bins may well fit these")
    n = np.arange(1, 41)
    k, angle = 1.0 + 1.2 * (n * np.sqrt(2) % 1), 2 * np.pi * (n * np.sqrt(3) % 1)
    current = UniformCurrent((0.1, 0.05))
    drawn = inputs.drawn(SEA)  # but for its frequencies, since the texture is near Nyquist
    grid = Grid((*drawn.shape[:2], SEA.shape[2]), (*drawn.spacing[:2], SEA.spacing[2]))
    local = inputs.waves(grid, k * np.cos(angle), k * np.sin(angle), (1.4, 1.6, 1.8), current)
    waves, strength = local.components, np.full(n.size, case.given.get("strength", 100.0))

    def judge(bin_: float) -> Outcome:
        flicker = np.full(n.size, bin_ * local.grid.frequency_resolution)
        texture = Components(waves.kx, waves.ky, flicker, strength, waves.phase)
        cube = Cube(inputs.together(waves, texture), local.grid, local.wavenumbers, local.current)
        return in_the_mean(subject, cube, tapered(subject), method)

    outcome = judge(38.5)
    if outcome.over > 1 and judge(38.0).over > 1:
        raise Unanswered(Verdict.UNSUPPORTED, "is as far off where the texture is on a bin: it is not for leaking")
    return outcome


@check(
    "leakage",
    "eq:normSp",
    EXACT_OR_SCORE + others_in_words("a tenth of ") + TAPERED + NOISY + " The exact velocity is zero.",
    [Case("rings")],
)
def check_aligned(subject: Subject, case: Case) -> Outcome:
    """Waves of still water that lie on bins do not leak: whatever current is found comes from the code and not from
    the window, as when the dispersion relation is taken at the shell's wavenumber for all its bins."""
    deep_only()
    side = 2 * np.pi / 0.12
    duration = 2 * np.pi * 10 / float(DEEP.frequency(0.6))
    grid = inputs.fitting(Grid((56, 60, 72), (side / 56, side / 60, duration / 72)))
    rings = np.array([(5, 0), (3, 4), (-4, 3), (4, -3), (20, 0), (12, 16), (16, -12), (-12, 16), (0, -20)]) * 0.12
    cube = inputs.waves(grid, rings[:, 0], rings[:, 1], (0.6, 2.4))
    return each_method(subject, lambda method: judge_exactly(subject, cube, method, others=FINE))


def _means(errors: FloatArray) -> list[float | None]:
    """Over realisations (R, n) that have a number, for each wavenumber."""
    return [
        float(column[there].mean()) if there.any() else None
        for column, there in zip(errors.T, np.isfinite(errors.T), strict=True)
    ]


@check(
    "leakage",
    "sec:leakage",
    "In each sea the error |c - U| in c0, averaged over wavenumbers, is compared with that of the reference by the "
    "same method. In the mean over the seas it may be larger by half of the smaller of the two velocity resolutions, "
    "below which no user would see it; for a method that the reference does not have, or one velocity for the whole "
    "band, by the whole larger one. As there are few seas, the check fails only if a one-sided Student's t-test over "
    "them finds the mean excess above that: all such tests of a run together reject a code at the limit once in a "
    "thousand runs.",
    [
        Case(f"{name}-{count}", {**given, "count": count}, quick=count == 6)
        for name, given in (
            ("broad", {"direction": 75.0, "spread": 60.0, "speed": 0.0}),
            ("narrow", {"direction": 60.0, "spread": 20.0, "speed": 0.0}),
            ("moving", {"direction": 30.0, "spread": 45.0, "speed": 0.1}),
        )
        for count in (6, 20)
    ],
)
def check_bias(subject: Subject, case: Case) -> Outcome:
    """The mean error from leakage, sea by sea beside the reference's: a code that is sound in one sea may be
    worse than need be in the mean of many."""
    given, window = case.given, tapered(subject)
    current = UniformCurrent(polar(given["speed"], given["direction"] + 70))
    seas = [
        inputs.sea(given["direction"], given["spread"], current, realization=100 + n) for n in range(given["count"])
    ]
    resolutions = seas[0].resolutions.mean(axis=1)

    def judge(method: str) -> Outcome:
        pairs, bias = [], []
        for cube in seas:
            found, there = ask(subject, cube, window, method)
            error, own = (np.hypot(*(c - cube.truth).T) for c in (found, expected(cube, window, method).velocities))
            bias.append(error)
            known = there & unflagged(cube, window, method)
            if known.any():
                pairs.append(float((error - own)[known].mean()))
        if len(pairs) < 2:
            raise Unanswered(Verdict.MISSING, f"has answers that can be judged in {len(pairs)} of {len(seas)} seas")
        other = method not in METHODS or subject.declaration.band
        margin = float(resolutions[1] if other else MARGIN * resolutions[0])
        test = excess(pairs, margin, share(len(subject.methods)))
        return Outcome(
            test.over,
            f"|c - U| is {test.mean:+.3g} c0 beside the reference's in the mean of {len(pairs)} "
            f"seas, the limit is {test.limit:.3g}",
            figures={
                "wavenumbers": seas[0].wavenumbers.tolist(),
                "differences": pairs,
                "margin": margin,
                "bias": _means(np.array(bias)),
                "limit": test.limit,
            },
        )

    return each_method(subject, judge)
