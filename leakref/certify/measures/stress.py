"""What makes a code's errors larger: seas as poor sensors see them, each a little worse from level to level.

Noise, grey values, slopes, only crests, frames that jump: each such `Stress` is a plain function of a sea, applied at a
few levels to the same four seas, of which the current is known. Measured is the mean of `|c - U|` over seas and
wavenumbers, beside that of the reference (Hann, NSP), and where a code *breaks down*: at which level its error has
doubled, and at which it passes the smaller velocity resolution (eq:dcdwk). It is run in the full profile only, and
changes no grade.

All that is drawn comes from Philox (`checks.draw`) under one seed, whatever that of the questions. In deep water and
with oblong pixels the seas are always the same, and the reference's velocities are kept in `golden/stress.json`
(`regenerate` makes it); for a code that is shown other seas they are computed along with it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.special import ndtri

from leakref._base import FloatArray
from leakref.certify.checks import inputs
from leakref.certify.checks.criteria import unflagged
from leakref.certify.checks.draw import PUBLISHED, Draw
from leakref.certify.checks.identity import identify
from leakref.certify.checks.inputs import Cube, polar
from leakref.certify.measures.bias import own_window
from leakref.certify.subject.frames import Subject
from leakref.certify.verdict import Unanswered
from leakref.chain import extract
from leakref.currents import UniformCurrent
from leakref.dispersion import DEEP
from leakref.golden import beside
from leakref.synthesis import synthesize

__all__ = ["CUBES", "SEAS", "STRESSES", "Breakdown", "Curve", "Found", "Stress", "regenerate", "seas", "stress"]

SEAS: tuple[tuple[float, float, tuple[float, float] | None], ...] = (
    (75.0, 60.0, None),
    (20.0, 75.0, polar(0.1, 110.0)),
    (100.0, 60.0, polar(0.15, 100.0)),
    (165.0, 45.0, polar(0.1, -15.0)),
)
"""Direction and spread of the waves, degrees, and their current, c0: still water, then one across, one along, one
against them. None is its own image where x and y are exchanged."""
_PHASES = 400  # their realisations are from here on, which no check uses
_COURSE = 200.0  # degrees: where the platform goes to, along none of the seas


def seas() -> list[Cube]:
    """The seas as they are, asked for at `inputs.SHELLS`."""
    return [
        inputs.sea(direction, spread, velocity and UniformCurrent(velocity), realization=_PHASES + n)
        for n, (direction, spread, velocity) in enumerate(SEAS)
    ]


# ---- what is done to a sea: functions of a cube, of a level, and of the number of the sea, by which chance is drawn


def _chance(number: int, purpose: str, count: int) -> FloatArray:
    """Uniform in (0, 1), (count,), the same at every level: a higher one is more of the same."""
    return Draw(PUBLISHED).numbers(count, "stress", purpose, number) + 2.0**-54


def _again(cube: Cube, **waves: FloatArray) -> FloatArray:
    """The surface of the same waves with something about them replaced."""
    return Cube(replace(cube.components, **waves), cube.grid, cube.wavenumbers, cube.current).surface


def noise(cube: Cube, decibels: float, number: int) -> FloatArray:
    """White normal noise, at a ratio of variances (signal to noise) in decibels."""
    normal = ndtri(_chance(number, "noise", cube.surface.size)).reshape(cube.surface.shape)
    return np.asarray(cube.surface + cube.surface.std() * 10 ** (-decibels / 20) * normal)


def grey(cube: Cube, bits: float, number: int) -> FloatArray:
    """Whole numbers from 0, the lowest trough, to 2^bits - 1, the highest crest."""
    low, high = cube.surface.min(), cube.surface.max()
    return np.asarray(np.rint((cube.surface - low) / (high - low) * (2**bits - 1)))


def slope(cube: Cube, percent: float, number: int) -> FloatArray:
    """So much of the slope along x beside what is left of the elevation, both with a standard deviation of one."""
    waves = cube.components
    along = _again(cube, amplitude=waves.amplitude * waves.kx, phase=waves.phase + np.pi / 2)
    share = percent / 100
    return np.asarray((1 - share) * cube.surface / cube.surface.std() + share * along / along.std())


def crests(cube: Cube, threshold: float, number: int) -> FloatArray:
    """What stands above a threshold, in standard deviations of the elevation; all else is flat."""
    return np.asarray(np.maximum(cube.surface - threshold * cube.surface.std(), 0.0))


def harmonics(cube: Cube, percent: float, number: int) -> FloatArray:
    """With second harmonics bound to the waves, of so much of their standard deviation.

    With z = sum a exp(i (k.x - omega t + phi)), whose real part is the sea, that of z^2 has every pair of waves at the
    sum of their wave vectors and of their frequencies, as waves have it that steepen at their crests.
    """
    quadrature = _again(cube, phase=cube.components.phase - np.pi / 2)
    bound = cube.surface**2 - quadrature**2
    return np.asarray(cube.surface + percent / 100 * cube.surface.std() / bound.std() * bound)


def jitter(cube: Cube, pixels: float, number: int) -> FloatArray:
    """Every frame displaced on its own, by a normal number along x and y with this standard deviation."""
    x, y, t = (cube.grid.samples(axis) for axis in range(3))
    off = ndtri(_chance(number, "jitter", 2 * t.size)).reshape(2, -1) * np.array(cube.spacing[:2])[:, None] * pixels
    frames = [synthesize(cube.components, x + a, y + b, t[[n]]) for n, (a, b) in enumerate(off.T)]
    return np.concatenate(frames, axis=2)


def column(cube: Cube, brightness: float, number: int) -> FloatArray:
    """One column of the sensor, of one x, that flickers as a whole by so many standard deviations of the elevation."""
    seen = cube.surface.copy()
    seen[seen.shape[0] // 3] = brightness * seen.std() * ndtri(_chance(number, "column", seen.shape[2]))
    return seen


def lost(cube: Cube, frames: float, number: int) -> FloatArray:
    """So many frames lost without a word within the video, which goes on in their place to its full number."""
    nt, gone = cube.grid.shape[2], int(frames)
    x, y = cube.grid.samples(0), cube.grid.samples(1)
    order = 1 + np.argsort(_chance(number, "lost", nt - 1), kind="stable")
    kept = np.delete(np.arange(nt + gone), order[:gone])
    return synthesize(cube.components, x, y, kept * cube.spacing[2])


def platform(cube: Cube, speed: float, number: int) -> FloatArray:
    """From a platform that goes at such a speed, in c0, towards 200 degrees: there every current is less by its
    velocity (Galileo).
    """
    u, v = polar(speed, _COURSE)
    waves = cube.components
    return _again(cube, omega=waves.omega - waves.kx * u - waves.ky * v)


@dataclass(frozen=True)
class Stress:
    """One thing that sensors do.

    - `name`, `words`: as in the JSON and for a reader; `unit` is that of the levels, as it is written after one.
    - `levels`: in the order in which they grow worse.
    - `shown`: the surface (nx, ny, nt) of a cube at a level; the last argument is the number of the sea.
    - `moves`: whether the level is a speed with which the sensor moves (`platform`).
    """

    name: str
    words: str
    unit: str
    levels: tuple[float, ...]
    shown: Callable[[Cube, float, int], FloatArray]
    moves: bool = False

    def velocity(self, level: float) -> FloatArray:
        """Of the sensor, (2,), in c0."""
        return np.array(polar(level, _COURSE)) if self.moves else np.zeros(2)


STRESSES = (
    Stress("noise", "white noise, signal to noise", " dB", (20, 10, 5, 0, -5, -10, -15), noise),
    Stress("grey", "grey values in whole numbers", " bits", (16, 12, 8, 6, 4, 3, 2), grey),
    Stress("slope", "slope along x in place of elevation", " %", (25, 50, 75, 100), slope),
    Stress("crests", "only crests are seen, above a threshold", " sigma", (-1, 0, 1, 1.5, 2), crests),
    Stress("harmonics", "bound second harmonics", " %", (5, 10, 20, 30), harmonics),
    Stress("jitter", "every frame displaced at random", " pixels", (0.25, 0.5, 1, 2), jitter),
    Stress("column", "a bad column, which flickers", " sigma", (0.3, 1, 3, 10, 30), column),
    Stress("lost", "frames lost without a word, of 80", " frames", (1, 2, 4, 8, 16), lost),
    Stress("platform", "a moving platform", " c0", (0.1, 0.2, 0.3, 0.4, 0.5), platform, moves=True),
)
"""All of them; the eight bits of usual cameras, one pixel and harmonics of 5 to 30 % are among their levels."""
CUBES = len(SEAS) * (1 + sum(len(one.levels) for one in STRESSES))
"""Seas that a code is shown in all."""


# ---- what came of it


@dataclass(frozen=True)
class Breakdown:
    """At which level something happens, between those that were tried: NaN where it does not, with `words` for it."""

    level: float
    words: str


@dataclass(frozen=True, eq=False)
class Curve:
    """Errors of one code under one stress: |c - U| in c0, (1 + levels, seas, n), those of the sea as it is first.

    NaN where there is no answer, or where the reference notes something of the sea as it is. `resolutions` (seas, n)
    are the smaller ones; `galilean` (1 + levels, seas, n) is how far answers are from those as it is, less the velocity
    of the sensor.
    """

    stress: Stress
    errors: FloatArray
    resolutions: FloatArray
    galilean: FloatArray

    @property
    def mean(self) -> FloatArray:
        """Mean error over seas and wavenumbers, (1 + levels,); NaN without an answer."""
        return _mean(self.errors)

    @property
    def answered(self) -> FloatArray:
        """The part of what it answered of the sea as it is that it answers at each level, (levels,)."""
        there = np.isfinite(self.errors)
        return np.asarray((there[1:] & there[0]).sum(axis=(1, 2)) / max(1, there[0].sum()))

    @property
    def doubles(self) -> Breakdown:
        """Where the mean error is twice that of the sea as it is, over what was answered in both."""
        both = np.isfinite(self.errors) & np.isfinite(self.errors[0])
        before = _mean(np.where(both, self.errors[0], np.nan))
        return self._where(_mean(np.where(both, self.errors, np.nan)) / (2 * np.maximum(before, 1e-12)))

    @property
    def passes(self) -> Breakdown:
        """Where the mean error is the mean of the smaller resolution."""
        return self._where(self.mean / _mean(np.where(np.isfinite(self.errors), self.resolutions, np.nan)))

    def _where(self, ratio: FloatArray) -> Breakdown:
        """The level at which a ratio (1 + levels,) passes one, linear in between. Levels without an answer are passed
        over; where none from some level on has any, that is said.
        """
        levels, unit = (np.nan, *self.stress.levels), self.stress.unit
        there = np.flatnonzero(np.isfinite(ratio))
        over = there[ratio[there] > 1]
        if not over.size and there[-1] < ratio.size - 1:  # there is one of the sea as it is, or no curve
            return Breakdown(np.nan, f"no answer from {levels[there[-1] + 1]:g}{unit} on")
        if not over.size or over[0] == 0:
            return Breakdown(np.nan, "already in the seas as they are" if over.size else "not within what was tried")
        n, before = int(over[0]), int(there[there < over[0]][-1])
        if before == 0:
            return Breakdown(float(levels[n]), f"already at {levels[n]:g}{unit}, the mildest")
        part = (1 - ratio[before]) / (ratio[n] - ratio[before])
        level = float(levels[before] + part * (levels[n] - levels[before]))
        return Breakdown(level, f"at {level:.2g}{unit}")

    def holds_to(self, tolerance: float) -> float:
        """The speed up to which answers follow that of the sensor to within a tolerance, in the mean; 0 if at none."""
        held = np.nan_to_num(_mean(self.galilean)[1:], nan=np.inf) <= tolerance
        n = int(np.argmin([*held, False]))
        return self.stress.levels[n - 1] if n else 0.0


def _mean(each: FloatArray) -> FloatArray:
    """Over seas and wavenumbers, (m, seas, n) to (m,), of what is there; NaN if nothing is."""
    there = np.isfinite(each)
    count = there.sum(axis=(1, 2))
    return np.asarray(np.where(count > 0, np.where(there, each, 0).sum(axis=(1, 2)) / np.maximum(count, 1), np.nan))


@dataclass(frozen=True, eq=False)
class Found:
    """A code under one stress beside the reference. `tolerance` is the mean of the larger resolution, for Galileo."""

    own: Curve
    reference: Curve
    tolerance: float

    @property
    def words(self) -> str:
        """In a line, such as `white noise, signal to noise: error doubled: at 3.5 dB (reference: at 3.5 dB); ...`."""
        own, other = self.own, self.reference
        told = (
            f"{own.stress.words}: error doubled: {own.doubles.words} (reference: {other.doubles.words}); smaller "
            f"resolution passed: {own.passes.words} (reference: {other.passes.words})"
        )
        return f"{told}; {self.followed}" if own.stress.moves else told

    @property
    def followed(self) -> str:
        """The relation of Galileo, in words: up to which speed answers follow that of the platform."""
        own, other = (f"up to {s:g} c0" if s else "at no speed" for s in self._held)
        return f"answers follow the platform to within the larger resolution {own} (reference: {other})"

    @property
    def _held(self) -> tuple[float, float]:
        return self.own.holds_to(self.tolerance), self.reference.holds_to(self.tolerance)

    def record(self) -> dict[str, Any]:
        """As in the JSON of `leakref certify`. Errors begin with that of the seas as they are."""
        own, other = self.own, self.reference
        found: dict[str, Any] = {
            "stress": own.stress.name,
            "about": own.stress.words,
            "unit": own.stress.unit.strip(),
            "levels": list(own.stress.levels),
            "error": own.mean,
            "reference_error": other.mean,
            "answered": own.answered,
            "smaller_resolution": float(np.nanmean(own.resolutions)),
        }
        for prefix, curve in (("", own), ("reference_", other)):
            for name in ("doubles", "passes"):
                where: Breakdown = getattr(curve, name)
                found[f"{prefix}{name}"] = {"level": where.level, "words": where.words}
        if own.stress.moves:
            held = dict(zip(("holds_to", "reference_holds_to"), self._held, strict=True))
            found["galilean"] = {"off": _mean(own.galilean)[1:], "tolerance": self.tolerance, **held}
        return {**found, "words": self.words}


def stress(
    subject: Subject, stresses: Sequence[Stress] = STRESSES, *, after_each: Callable[[], object] = lambda: None
) -> list[Found]:
    """What an implementation's main method under its own taper makes of the seas at every level of every stress.

    Calls `after_each` for every cube. A code that answers none of the seas as they are is not looked at further: the
    list is empty then. That a code does not answer is never raised.
    """
    identify(subject)
    square, water, scale = "dy" in subject.declaration.untold, subject.still(), _whole(subject)
    with inputs.asked(subject, PUBLISHED), inputs.in_water(subject.still(scale)):
        cubes = seas()
    judged = np.array([unflagged(cube, "hann", "nsp") for cube in cubes])
    method, window, unit = subject.methods[0], own_window(subject), subject.units(scale)[0]

    def answer(cube: Cube, seen: FloatArray) -> FloatArray:
        after_each()
        try:
            found = subject.extract(
                seen / unit if (seen == np.rint(seen)).all() else seen,  # grey values are no lengths
                cube.spacing, cube.wavenumbers, window=window, method=method, scale=scale, water=cube.water, raw=True,
            ).values  # fmt: skip
        except Unanswered:
            return np.full((cube.wavenumbers.size, 2), np.nan)
        return np.where(np.isfinite(found).all(axis=1, keepdims=True), found, np.nan)  # one NaN is no answer there

    plain = np.array([answer(cube, cube.surface) for cube in cubes])
    if np.isnan(plain[judged]).all():
        return []
    kept = {} if square or water != DEEP or subject.shown_as.cube or subject.shown_as.waves else _kept()
    theirs = kept.get("none") or [_reference(cube, cube.surface) for cube in cubes]
    tolerance, found = float(np.mean([cube.resolutions[1] for cube in cubes])), []
    for one in stresses:
        own, other = [plain], [theirs]
        for level in one.levels:
            shown = [(cube, one.shown(cube, level, n)) for n, cube in enumerate(cubes)]
            own.append(np.array([answer(*each) for each in shown]))
            other.append(kept.get(f"{one.name} {level:g}") or [_reference(*each) for each in shown])
        first, second = (_curve(one, cubes, judged, each) for each in (own, other))
        found.append(Found(first, second, tolerance))
    return found


def _whole(subject: Subject) -> float:
    """The scale, the nearest to one, at which the unit of length of a code is a power of two: only then do grey values
    reach a code in metres as whole numbers.
    """
    length = subject.units(1.0)[0]
    return float(length / 2.0 ** np.rint(np.log2(length)))


def _reference(cube: Cube, seen: FloatArray) -> FloatArray:
    """What the plain chain finds, (n, 2)."""
    return extract(seen, cube.spacing, cube.wavenumbers, water=cube.water, window="hann", method="nsp").velocities


def _curve(one: Stress, cubes: Sequence[Cube], judged: FloatArray, found: Sequence[Any]) -> Curve:
    """Of velocities (1 + levels, seas, n, 2), null or NaN where there is none."""
    velocities = np.array(found, dtype=np.float64)
    moved = np.array([one.velocity(level) for level in (0.0, *one.levels)])[:, None, None]
    truth = np.array([cube.truth for cube in cubes])

    def off(should: FloatArray) -> FloatArray:
        return np.where(judged, np.hypot(*np.moveaxis(velocities - should, -1, 0)), np.nan)

    smaller = np.where(judged, [cube.resolutions[0] for cube in cubes], np.nan)
    return Curve(one, off(truth - moved), smaller, off(velocities[0] - moved))


# ---- what is kept of the reference


def _kept() -> dict[str, list[Any]]:
    """Its velocities (seas, n, 2) in `golden/stress.json`, by stress and level; `none` is the sea as it is."""
    return {row["stress"]: row["velocities"] for row in beside.read("stress.json")["rows"]}


def regenerate(path: Path) -> Path:
    """Compute what is kept of the reference and write it, with its digest if it is `golden/stress.json`: a minute."""
    from leakref.claims.stored import write

    cubes = seas()
    rows = [{"stress": "none", "velocities": [_reference(cube, cube.surface) for cube in cubes]}]
    for one in STRESSES:
        for level in one.levels:
            each = [_reference(cube, one.shown(cube, level, n)) for n, cube in enumerate(cubes)]
            rows.append({"stress": f"{one.name} {level:g}", "velocities": each})
    about = {"schema": "leakref/stress/1", "window": "hann", "method": "nsp", "wavenumbers": list(inputs.SHELLS)}
    return write(path, {**about, "seas": list(SEAS), "rows": rows}, ["rows"])
