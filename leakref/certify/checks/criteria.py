"""What the checks have in common: which windows and methods to ask for, and what is near enough."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from leakref import fast
from leakref._base import FloatArray
from leakref.certify.checks.inputs import Cube
from leakref.certify.checks.registry import Outcome
from leakref.certify.subject.frames import Subject, Velocities
from leakref.certify.verdict import Unanswered, Verdict
from leakref.dispersion import Water
from leakref.methods import METHODS
from leakref.nsp import WIDTH
from leakref.shell import Extraction, shell_at
from leakref.spectrum import Spectrum, fourier
from leakref.window import WINDOWS

__all__ = [
    "ALONG",
    "DECLINED",
    "FRACTION",
    "HALF_AGAIN",
    "IN_THE_MEAN",
    "NEVER",
    "TOLERANCE",
    "answered",
    "as_array",
    "ask",
    "blind_to_backward_waves",
    "each_method",
    "expected",
    "in_the_mean",
    "like",
    "score",
    "scored_method",
    "spectrum_of",
    "tapered",
    "tolerance",
    "unflagged",
    "untapered",
    "vector",
    "verdict",
    "width",
    "with_the_crests",
    "worst",
]

FRACTION = 0.1
"""Of the smaller resolution (eq:dcdwk): how near answers must be that ought to be the same."""
HALF_AGAIN = 1.5
"""Times the reference's own error in the same cube: what is always allowed, since a method may err in a sea."""
CRESTS, DIRECTED = 0.35, 0.5
"""How near a velocity is to that of the crests, of the way there from the true one, that is called so; and how much
the waves of a sea go one way, as the length of the mean of their directions, that they have one."""
ALONG = ": that is how the crests go, along the waves, and not the water"
"""What is said of such a velocity."""
DECLINED = 1 / 3
"""Of the wavenumbers of a question: a code that gives no velocity at more of them has not answered it."""
NEVER = 1e6
"""The error over tolerance of what is either right or wrong."""
TOLERANCE = (
    "the larger of the two velocity resolutions; for a method other than the NSP, that plus twice the "
    "error of the reference's own least squares in the same cube at the same wavenumber (three times for a method that "
    "the reference does not have)"
)
"""`tolerance` in words."""
IN_THE_MEAN = (
    "The error |c - U| in c0, averaged over the wavenumbers at which the reference has nothing to note, may be as "
    f"large as the average of {TOLERANCE}, or as one and a half times what the reference errs by in the same cube by "
    "the same method, if that is more."
)
"""`in_the_mean` in words."""


def tapered(subject: Subject) -> str:
    """The window for tapered cubes: Hann if it is offered, else any but the box. Raises Unanswered."""
    offered = [name for name in subject.declaration.windows if name != "box"]
    if not offered:
        raise Unanswered(Verdict.UNSUPPORTED, "offers no window that tapers")
    return "hann" if "hann" in offered else offered[0]


def untapered(subject: Subject) -> str:
    """The box, or Unanswered."""
    if "box" not in subject.declaration.windows:
        raise Unanswered(Verdict.UNSUPPORTED, "always tapers, and this holds for untapered cubes only")
    return "box"


def worst(outcomes: Mapping[str, Outcome]) -> Outcome:
    """The outcome furthest beyond its tolerance; with several, the message says whose it is and `figures` hold all."""
    name = max(outcomes, key=lambda key: np.inf if np.isnan(outcomes[key].over) else outcomes[key].over)
    bad = outcomes[name]
    if len(outcomes) == 1:
        return bad
    figures = {key: dict(outcome.figures) for key, outcome in outcomes.items()}
    digits = [outcome.digits for outcome in outcomes.values() if outcome.digits is not None]
    return Outcome(bad.over, f"{name}: {bad.message}", min(digits, default=None), figures)


def each_method(subject: Subject, judge: Callable[[str], Outcome], without: tuple[str, ...] = ()) -> Outcome:
    """The worst outcome of all methods that are offered, but for those that the check is not about."""
    methods = [method for method in subject.methods if method not in without]
    if not methods:
        raise Unanswered(
            Verdict.UNSUPPORTED,
            f"offers no method but {', '.join(subject.methods)}, which this does not hold for",
        )
    outcomes, missing = {}, None
    for method in methods:
        try:
            outcomes[method] = judge(method)
        except Unanswered as nothing:
            if nothing.verdict is not Verdict.MISSING:
                raise
            missing = nothing
    found = worst(outcomes) if outcomes else None
    if missing is not None and (found is None or found.over <= 1):
        raise missing  # a mistake of another method weighs more
    assert found is not None
    return found


def ask(subject: Subject, cube: Cube, window: str, method: str) -> tuple[FloatArray, npt.NDArray[np.bool_]]:
    """Velocities (n, 2) of a cube at its wavenumbers, and which of them were answered (n,)."""
    speed = float(np.hypot(*cube.truth.T).max())
    if speed > subject.shown_as.fastest(cube.scale):
        limit = subject.shown_as.waves["fastest"]
        raise Unanswered(Verdict.UNSUPPORTED, f"is made for currents up to {limit:g} m/s")
    found = subject.extract(
        cube.surface,
        cube.spacing,
        cube.wavenumbers,
        window=window,
        method=method,
        scale=cube.scale,
        water=cube.water,
    )
    subject.fastest = max(subject.fastest, speed)
    return found.values, answered(subject, found)


def answered(subject: Subject, found: Velocities, needed: npt.NDArray[np.bool_] | None = None) -> npt.NDArray[np.bool_]:
    """Which of the velocities are there, (n,). What is there is judged.

    Where more than `DECLINED` of those `needed` are not, that is noted in `subject.gaps`, and a pass becomes missing.
    """
    declined = found.declined if needed is None else found.declined[needed]
    if declined.sum() > DECLINED * declined.size:
        subject.gaps = f"gave no velocity at {int(declined.sum())} of {declined.size} wavenumbers"
    return ~found.declined


def as_array(
    subject: Subject,
    surface: FloatArray,
    spacing: tuple[float, float, float],
    wavenumbers: FloatArray,
    window: str,
    method: str,
    needed: npt.NDArray[np.bool_] | None = None,
    water: Water | None = None,
    scale: float = 1.0,
) -> tuple[FloatArray, npt.NDArray[np.bool_]]:
    """As `ask`, but of a surface [x, y, t] taken as an array: an implementation with y downwards sees the same one.

    Its velocities (n, 2) are along the axes of the array; which way up that is, is not the question. It may decline
    those that are not `needed` (n,).
    """
    turn = -1 if subject.declaration.y == "down" else 1
    found = subject.extract(
        surface[:, ::turn], spacing, wavenumbers, window=window, method=method, water=water, scale=scale
    )
    return found.values * [1, turn], answered(subject, found, needed)


def scored_method(subject: Subject, otherwise: str) -> str:
    """A method that maximises a score at each wavenumber, or Unanswered with `otherwise` as the reason."""
    offered = [m for m in subject.methods if m in METHODS and METHODS[m].score]
    if not offered or subject.declaration.band:
        raise Unanswered(Verdict.UNSUPPORTED, otherwise)
    return offered[0]


def blind_to_backward_waves() -> tuple[str, ...]:
    """The methods that cannot see waves which a current sweeps backwards."""
    return tuple(name for name, record in METHODS.items() if not record.backwards)


def vector(values: FloatArray) -> str:
    """(0.12, -0.3) in words."""
    return "(" + ", ".join(f"{v:.4g}" for v in np.asarray(values).ravel()) + ")"


def with_the_crests(cube: Cube, found: FloatArray) -> bool:
    """Whether a velocity (2,) is that of the crests of a sea rather than of its water: along its waves, about as fast
    as they run. So it is where waves are taken for something that drifts.
    """
    waves = cube.components
    k, energy = np.hypot(waves.kx, waves.ky), waves.amplitude**2 / np.sum(waves.amplitude**2)
    way = np.array([np.sum(energy * waves.kx / k), np.sum(energy * waves.ky / k)])
    if np.hypot(*way) < DIRECTED:  # a sea from all sides has no such velocity
        return False
    crests = np.sum(energy * waves.omega / k) * way / np.hypot(*way)
    truth = cube.truth.mean(axis=0)
    return bool(np.hypot(*(found - crests)) < CRESTS * np.hypot(*(crests - truth)))


def verdict(over: FloatArray, cube: Cube, found: FloatArray, should: FloatArray, **figures: object) -> Outcome:
    """The worst of several wavenumbers: `over` (n,), NaN where there is nothing to judge; Unanswered if nowhere."""
    if np.isnan(over).all():
        raise Unanswered(Verdict.MISSING, f"has no answer that can be judged at k = {vector(cube.wavenumbers)}")
    n = int(np.nanargmax(over))
    error = np.hypot(*(found - should).T)
    return Outcome(
        float(over[n]),
        f"at k = {cube.wavenumbers[n]:.4g} got {vector(found[n])}, should be "
        f"{vector(should[n])}: {error[n]:.2g} c0 off, {over[n]:.2g} times what is allowed",
        figures={
            "wavenumbers": cube.wavenumbers.tolist(),
            "velocities": found.tolist(),
            "should_be": should.tolist(),
            "over": over.tolist(),
            **figures,
        },
    )


def tolerance(cube: Cube, window: str, method: str) -> FloatArray:
    """How far off the truth an answer in a tapered sea may be, (n,): the larger resolution (eq:dcdwk).

    Least squares, and what else fits strong bins, depends on which bins pass a threshold, and errs by as much and more
    from one sea to the next: it may be off by twice as much more as the reference's least squares is in this one. Other
    methods have other bins, weights and widths, and with them errors that are drawn anew in each sea: three times.
    """
    own = like(cube, window, method)
    times = 2 if method in METHODS else 3
    return cube.resolutions[1] + (0.0 if own is None else times * np.nan_to_num(np.hypot(*(own - cube.truth).T)))


def like(cube: Cube, window: str, method: str) -> FloatArray | None:
    """What the reference finds in a cube (n, 2) by a method that errs with the sea; None for those that do not.

    For a method that it does not have that is least squares.
    """
    if method in METHODS and not METHODS[method].errs_with_the_sea:
        return None
    return expected(cube, window, method if method in METHODS else "ls").velocities


def in_the_mean(subject: Subject, cube: Cube, window: str, method: str, *, beside: bool = False) -> Outcome:
    """Mean error over the mean `tolerance`, over wavenumbers of which the reference notes nothing.

    With `beside` a method of the reference's name that is made otherwise may err by that tolerance beside what the
    reference errs by.
    """
    found, there = ask(subject, cube, window, method)
    there &= unflagged(cube, window, method)
    if not there.any():
        raise Unanswered(Verdict.MISSING, f"has no answer that can be judged at k = {vector(cube.wavenumbers)}")
    error = np.hypot(*(found - cube.truth).T)
    mean, allowed = float(error[there].mean()), float(tolerance(cube, window, method)[there].mean())
    if mean > allowed and method in METHODS:  # a sea in which the method itself errs by as much
        own = np.hypot(*(expected(cube, window, method).velocities - cube.truth).T)
        allowed = max(allowed, HALF_AGAIN * float(own[there].mean()))
        if beside and method not in (subject.alike or ()):
            allowed = max(allowed, float((cube.resolutions[1] + own)[there].mean()))
    crests = mean > allowed and with_the_crests(cube, found[there].mean(axis=0))
    return Outcome(
        mean / allowed,
        f"{mean:.3g} c0 off in the mean of {int(there.sum())} wavenumbers, should be below {allowed:.3g}"
        + ALONG.replace("that", "its velocity") * crests,
        figures={
            "wavenumbers": cube.wavenumbers.tolist(),
            "velocities": found.tolist(),
            "should_be": cube.truth.tolist(),
            "errors": error.tolist(),
            "crests": crests,
        },
    )


@lru_cache(maxsize=256)
def expected(cube: Cube, window: str, method: str) -> Extraction:
    """The reference's answer. A window or method that it does not know stands for Hann and the NSP."""
    window, method = window if window in WINDOWS else "hann", method if method in METHODS else "nsp"
    return fast.realize(
        cube.components, cube.grid, cube.wavenumbers, windows=(window,), methods=(method,), water=cube.water
    )[window, method]


def unflagged(cube: Cube, window: str, method: str) -> npt.NDArray[np.bool_]:
    """The shells (n,) of which the reference has a number and nothing to note."""
    return np.array([not note for note in expected(cube, window, method).notes])


@lru_cache(maxsize=8)
def spectrum_of(cube: Cube, window: str) -> Spectrum:
    """What the reference makes of the cube."""
    return fourier(cube.surface, cube.grid, window, workers=1)


def score(cube: Cube, window: str, wavenumber: float, velocity: FloatArray, method: str = "nsp") -> float:
    """What a method maximises, N of eq:normSp for the NSP, at a velocity (2,), as the reference sees the cube."""
    maximised = METHODS[method].score
    assert maximised is not None
    shell = shell_at(spectrum_of(cube, window), wavenumber, water=cube.water)
    return maximised(shell, velocity, width(cube, wavenumber, method))


def width(cube: Cube, wavenumber: float, method: str) -> float:
    """a of eq:DSVkernel of a method that maximises N, in rad per time."""
    return WIDTH * cube.grid.frequency_resolution * METHODS[method].spread(cube.grid, cube.water, wavenumber)
