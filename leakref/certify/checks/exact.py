"""What is known exactly: under which window it is asked, what the answer is, and how near is near enough.

Waves on bins of an untapered cube do not leak, and the answer is their current. Tapered, each becomes the lobe of the
window, over which the dispersion relation bends: then the closed form of the leakage tells what the reference's methods
find, to all digits. Digits are asked of codes that work as the reference does, of others the resolution.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from leakref._base import FloatArray
from leakref.certify.checks import inputs
from leakref.certify.checks.criteria import ask, expected, score, spectrum_of, tapered, verdict, width
from leakref.certify.checks.identity import identify
from leakref.certify.checks.inputs import Cube
from leakref.certify.checks.registry import Outcome
from leakref.certify.subject.frames import Subject
from leakref.certify.verdict import Unanswered, Verdict
from leakref.dispersion import DEEP
from leakref.grid import Grid
from leakref.methods import DEFAULT, METHODS
from leakref.nsp import score_range
from leakref.shell import shell_at
from leakref.window import WINDOWS

__all__ = [
    "EXACT",
    "EXACTLY",
    "EXACT_OR_SCORE",
    "FINE",
    "FLATTER",
    "MORE",
    "NOISY",
    "OTHERS",
    "TAPERED",
    "TRACE",
    "WITHIN_A_TENTH",
    "aligned_window",
    "answers",
    "as_good",
    "deep_only",
    "exactly",
    "exactly_in_words",
    "held_to_digits",
    "judge_exactly",
    "of_its_own",
    "others_in_words",
    "right",
]

EXACT = 2e-4
"""In c0: three times by how much optimisers at default tolerances were seen to miss what is exact."""
FLATTER = 1e-6
"""Relative: a velocity whose score is this near the best one is as good as it; 1.4e-3 c0 at unit curvature."""
FINE = 0.1
"""Of the smaller resolution: what other algorithms may be off by where nothing about the question favours one."""


def exactly_in_words(allowed: str) -> str:
    """`exactly` in words: how much is `allowed`, and why, and what passes beyond it."""
    return (
        f"Each velocity may be off by {allowed}. An NSP velocity that is further off passes all the same if the "
        "reference gives it a score within a relative 1e-6 of that of the exact velocity: the maximum is then so flat "
        "that no optimiser tells the two apart. An answer to the cube without its last or first sample along axes of "
        "an odd number of them passes as well."
    )


EXACT_OR_SCORE = exactly_in_words(
    "2e-4 c0 (the length of the error), three times what optimisers with default tolerances were seen to miss by"
)


WITHIN_A_TENTH = exactly_in_words(
    "a tenth of the smaller of the two velocity resolutions (the length of the error): in a strong current the "
    "branches of G reach omega = 0 somewhere in the shell, and whether bins there count half, whole or not at all "
    "(decision D5) moves the maximum by up to half of that"
)


def others_in_words(part: str) -> str:
    """What is allowed to those who are not held to digits: a `part` of the smaller resolution."""
    return (
        " A method that the reference does not have, an NSP whose velocities of a broad sea are not those of the "
        "reference's, such as one on the interpolated cylinder of eq:maskedSpec, or one velocity for the whole band, "
        f"may be off by {part}the smaller of the two velocity resolutions."
    )


OTHERS = others_in_words("")
TAPERED = (
    " A code that always tapers is asked under its window; the answer is then what the reference finds in the closed "
    "form of the leakage, and who is not held to digits may be off by that whole resolution."
)
TRACE = 1e-3
"""Of the standard deviation of the waves: the noise that a clean cube is shown with again; a camera has more."""
NOISY = (
    " A method of another name, or one velocity for the band, that is off is asked again with a trace of noise, a "
    "thousandth of the waves, as every camera has it. Where that moves its answer by more than a tenth of the "
    "resolution it is no code for cubes so clean, as one that divides by what there is at each frequency and sees "
    "nothing but rounding: it is shown twelve waves with such noise, and may be off by the resolution."
)
"""What comes after a clean cube that a code was off in."""
MORE = " A code that gives no velocity where two waves are all there is, is shown twelve."
EXACTLY = EXACT_OR_SCORE + OTHERS + TAPERED + NOISY
"""`exactly` in words."""


def aligned_window(subject: Subject) -> str:
    """The window under which waves on bins are asked for: the box, or for what always tapers its taper."""
    return "box" if "box" in subject.declaration.windows else tapered(subject)


def deep_only() -> None:
    """Raises Unanswered in other water than deep: there, waves of two lengths are not on bins of one cube."""
    if inputs.still() != DEEP:
        raise Unanswered(Verdict.UNSUPPORTED, "has a depth or a surface tension of its own, and this holds without")


def answers(cube: Cube, window: str, method: str) -> list[FloatArray]:
    """What is right, (n, 2) each: untapered the current, tapered what the methods of the reference find. Of a method
    that it does not have either will do, and so untapered of one whose G is wider than the branches are apart.
    """
    if window == "box" or window not in WINDOWS:
        wider = method in METHODS and METHODS[method].spread(cube.grid, cube.water, float(cube.wavenumbers[0])) > 1
        return [cube.truth, expected(cube, window, method).velocities] if wider else [cube.truth]
    found = [expected(cube, window, name).velocities for name in ([method] if method in METHODS else DEFAULT)]
    return found if method in METHODS else [cube.truth, *found]


def held_to_digits(subject: Subject, window: str, method: str) -> bool:
    """Whether a code is to find what the reference finds: one whose answers in a broad sea are the reference's, or by
    a method for which waves on bins give the current whatever the make.
    """
    if method not in METHODS or subject.declaration.band or (window != "box" and window not in WINDOWS):
        return False
    return (window == "box" and METHODS[method].exact_on_bins) or method in identify(subject)


def of_its_own(subject: Subject, method: str) -> bool:
    """Whether a method has another name than those of the reference, or answers once for the whole band."""
    return method not in METHODS or subject.declaration.band


def exactly(
    subject: Subject,
    cube: Cube,
    window: str,
    method: str,
    found: FloatArray,
    should: FloatArray,
    allowed: FloatArray | float = EXACT,
    others: float = 1.0,
) -> FloatArray:
    """Error over tolerance at each wavenumber, (n,), of velocities (n, 2) that are known exactly.

    `allowed` in c0, or for the NSP a score within `FLATTER` of that of the exact velocity, whichever is kinder. Who is
    not held to digits may be off by `others` times the smaller resolution.
    """
    error = np.hypot(*(found - should).T)
    if not held_to_digits(subject, window, method):
        return error / (others * cube.resolutions[0])
    return as_good(error / allowed, cube, window, method, found, should)


def as_good(
    over: FloatArray, cube: Cube, window: str, method: str, found: FloatArray, should: FloatArray
) -> FloatArray:
    """Error over tolerance (n,) by the score, where that is kinder: of methods that maximise one.

    No answer passes by its score that lies beyond the range in which a score means anything (`nsp.score_range`).
    """
    if method in METHODS and METHODS[method].score:
        for n in np.flatnonzero(over > 1):
            shell = shell_at(spectrum_of(cube, window), float(cube.wavenumbers[n]), water=cube.water)
            a = width(cube, float(cube.wavenumbers[n]), method)
            if not np.hypot(*found[n]) <= score_range(shell, a, 1.0):
                continue
            best, own = (score(cube, window, float(cube.wavenumbers[n]), c[n], method) for c in (should, found))
            over[n] = min(over[n], max((1 - own / best) / FLATTER, 0.0))
    return over


def judge_exactly(
    subject: Subject,
    cube: Cube,
    method: str,
    allowed: FloatArray | float = EXACT,
    others: float = 1.0,
    more: Cube | None = None,
    noisy: Cube | None = None,
) -> Outcome:
    """The outcome of asking for waves on bins: the worst of the wavenumbers, of the kindest of what is right.

    `more` is a cube of more waves, for a code to which those of `cube` are too few; `noisy` the one that is shown with
    a trace of noise (default: `more`, or the same) to one that is no code for clean cubes (`_wants_noise`).
    """
    try:
        outcome = _judged(subject, cube, method, allowed, others)
    except Unanswered as nothing:
        if more is None or nothing.verdict is not Verdict.MISSING:
            raise
        cube, subject.gaps = more, ""
        outcome = _judged(subject, more, method, allowed, others)
    if outcome.over <= 1 or not of_its_own(subject, method) or not subject.followed:
        return outcome
    asked = len(subject.calls)
    try:
        if not _wants_noise(subject, cube, method, outcome):
            return outcome
        again = _judged(subject, replace(noisy or more or cube, noise=TRACE), method, allowed, max(1.0, others))
        return replace(again, message=f"of waves with a trace of noise, {again.message}")
    except Unanswered:  # what it gave no answer to is no excuse
        return outcome
    finally:
        del subject.calls[asked:]  # a diagnosis puts the clean cube to the reference


def _wants_noise(subject: Subject, cube: Cube, method: str, outcome: Outcome) -> bool:
    """Whether a trace of noise moves its answer by more than `FINE`."""
    found, there = ask(subject, replace(cube, noise=TRACE), aligned_window(subject), method)
    moved = np.hypot(*(found - np.asarray(outcome.figures["velocities"])).T)
    return bool((moved > FINE * cube.resolutions[0])[there].any())


def _judged(subject: Subject, cube: Cube, method: str, allowed: FloatArray | float, others: float) -> Outcome:
    """Of all that is right of such a cube, the one to which the answer is nearest decides; where none is near enough,
    what is told is the distance from the first.
    """
    window = aligned_window(subject)
    if window != "box":
        others = max(1.0, others)  # what a lobe does to an algorithm is its own affair, up to the resolution
    found, there = ask(subject, cube, window, method)
    outcomes = (
        verdict(
            np.where(there, exactly(subject, cube, window, method, found, c, allowed, others), np.nan), cube, found, c
        )
        for c in right(cube, window, method)
    )
    first = next(outcomes)
    if not first.over <= 1:  # what fails is told beside what is right of the cube as it is
        first = next((outcome for outcome in outcomes if outcome.over <= 1), first)
    off = np.hypot(*(found - answers(cube, window, method)[0]).T) / cube.resolutions[0]
    if first.over > 1 and held_to_digits(subject, window, method) and off[there].max() <= 1:
        return replace(
            first,
            message=f"{first.message}; that is within the resolution: if this is not the {METHODS[method].words} of "
            "guide protocol, section 3, declare a method of another name, which is not held to digits",
        )
    return first


def right(cube: Cube, window: str, method: str) -> Iterator[FloatArray]:
    """What is right, and then what is right of a cube that somebody has made even."""
    yield from answers(cube, window, method)
    if method in METHODS and any(n % 2 for n in cube.grid.shape):
        for part in _made_even(cube):
            yield expected(part, window, method).velocities


def _made_even(cube: Cube) -> Iterator[Cube]:
    """The cube without its last or its first samples along time, or all axes, that have an odd number of them."""
    waves, (nx, ny, nt), spacing = cube.components, cube.grid.shape, cube.spacing
    for odd in {(0, 0, nt % 2), (nx % 2, ny % 2, nt % 2)} - {(0, 0, 0)}:
        grid = Grid((nx - odd[0], ny - odd[1], nt - odd[2]), spacing)
        yield replace(cube, grid=grid)
        dx, dy, dt = (n * d for n, d in zip(odd, spacing, strict=True))
        yield replace(
            cube,
            grid=grid,
            components=replace(waves, phase=waves.phase + waves.kx * dx + waves.ky * dy - waves.omega * dt),
        )
