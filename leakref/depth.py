"""A depth inferred along with the current from the same spectrum: N over (cx, cy, h), of a shell or of a whole band.

The paper knows its depth; it leaves open what leakage does to one that is inferred (Introduction). This is the smallest
step beyond it. In eq:normSp (equation 16) omega0 is that of water of a depth h that is searched for as well,

    N(c, h) = <G F> / (<G> <F>),    G(c, h) = the sum over both signs of exp(-2 ((omega -+ omega0(k; h) - k.c) / a)^2),

and <.> is the mean over the bins of one shell, | |k| - k_i | <= 2 dk, or of a band, k_1 <= |k| <= k_2, with one current
and one depth for all of it. That is eq:normSp as it stands: app:numdetails already extends its integrals over the
wavenumbers of a shell, and a band is a wide shell. Every bin counts once, by its own magnitude, so that the answer is
that of the strongest waves. The other way of pooling, the sum of N_i over shells, gives every wavenumber the same say,
weak ones too: with F over its mean at each wavenumber in place of F it is the same equation (`levelled`).

A shell tells h from a current along the waves by its width alone: omega0(k; h) changes across it otherwise than k.c.
How well is the curvature of N over ln h at its maximum, the current following,

    -(N_hh - N_hc N_cc^-1 N_ch) / N,        4 (d omega0 / d ln h / a)^2 for one wave of a known current,

and where it is below `FLAT` there is no number. d omega0 / d ln h = omega0 k h / sinh(2 k h) falls like exp(-2 k h).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.signal import find_peaks

from leakref._base import FloatArray, IntArray, LeakrefError, positive, vector
from leakref.depthscore import Score
from leakref.dispersion import Water, law, velocity_unit
from leakref.nsp import UNKNOWN, WIDTH
from leakref.shell import HALF_WIDTH, Note, Shell, checked_wavenumbers, shell_at
from leakref.spectrum import Spectrum

__all__ = [
    "FLAT",
    "RANGE",
    "Inferred",
    "band",
    "gathered",
    "infer",
    "infer_band",
    "infer_shells",
    "levelled",
    "reasons",
]

FLAT = 0.05
"""Curvature of N over ln h, over N: below, h cannot be told apart. The same number as for a current, where ln h is the
unit in place of c0: N falls by 2.5 % where h is wrong by a factor of e."""
RANGE = (np.pi / 10, np.pi)
"""k h between which h is searched for, of the shortest and of the longest waves. In water shallower than a twentieth of
a wavelength waves are no longer dispersive, so that a depth is as good as a current along them; deeper than half of one
they are those of deep water. These are the usual limits."""
_STARTS = 3
_FEW = 8
_SAME = 1e-6  # in ln h
_CLOSE = 0.02  # widths: a current that is as near to its maximum as this lowers N by less than
_LEAST = 1e-3  # parts of it
_REACH = 1.2  # in c0: the fastest current that is looked for, as where h is known


@dataclass(frozen=True, eq=False)
class Inferred:
    """Depths and velocities inferred together, n of them; NaN where there is no number, and `notes` say why.

    `depths` h in lengths (n,), `velocities` (n, 2) in lengths per time (the given ones, where the current was known),
    `score` N there (n,), `curvature` of N over ln h with the current following, over N (n,): kept where there is no
    number as well, since it says how far h can be told apart; `evaluations` of the score (n,).
    """

    depths: FloatArray
    velocities: FloatArray
    score: FloatArray
    curvature: FloatArray
    evaluations: IntArray
    notes: tuple[Note, ...]


def reasons(note: Note) -> str:
    """Why there is no depth, in words; empty if there is nothing to say."""
    words = {
        Note.NO_SIGNAL: "there are no waves",
        Note.FLAT: "these waves hardly feel the bottom, or cannot tell it from a current: any depth fits as well",
        Note.EDGE: "the best depth lies outside of the range that was searched",
        Note.UNCONVERGED: "no maximum was reached",
        Note.TOO_FEW_BINS: "the shell has fewer than 8 bins",
    }
    return "; ".join(said for one, said in words.items() if one in note)


def infer(
    shell: Shell,
    water: Water,
    *,
    width: float,
    unit: float,
    current: npt.ArrayLike | None = None,
    depths: tuple[float, float] | None = None,
) -> Inferred:
    """The depth, and the current with it, at which N is largest on the bins of `shell`: one of n = 1.

    For every h of a scan the current is searched for from zero current, as where h is known; from the best of them all
    three are climbed together until the gradient vanishes. `water` gives gravity and tension (its depth does not
    matter), `width` is a in rad per time, `unit` c0; a `current` (2,) that is known is held. `depths` are the limits of
    the search (RANGE). Raises LeakrefError for a current or limits that are none.
    """
    if shell.is_empty:
        return _nothing(Note.NO_SIGNAL)
    if current is not None:
        vector("infer", current=current)
    score, held = Score(shell, water, width, unit), current is not None
    felt = score.k[score.k > 1e-9 * score.k.max()]
    low, high = np.log(_limits(depths, float(felt.min()), float(felt.max())))
    rest = np.zeros(2) if current is None else np.asarray(current, dtype=np.float64) / unit
    ends = []
    for start in _starts(score, rest, low, high, held):
        x, _, arrived = score.climb(start, slice(2 if held else 0, 3))
        n, _, bend = score.at(x)
        ends.append(_End(x, n, bend, arrived, held))
    if not ends:
        return _nothing(Note.NO_SIGNAL, score.evaluations)
    inside = [end for end in ends if end.excuse(low, high) is Note.NONE]
    best = max(inside or ends, key=lambda end: end.score)
    note = best.excuse(low, high) | (Note.TOO_FEW_BINS if score.k.size < _FEW else Note.NONE)
    if not inside:
        return _nothing(note, score.evaluations, best.curvature)
    others = [end for end in ends if abs(end.place[2] - best.place[2]) > _SAME]  # three waves may have two depths
    if any(end.score > best.score * (1 - 1e-9) for end in others):
        note |= Note.ANOTHER_BASIN
    h, c = float(np.exp(best.place[2])), best.place[:2] * unit
    return _row(h, c, best.score, best.curvature, score.evaluations, note)


def _starts(score: Score, rest: FloatArray, low: float, high: float, held: bool) -> list[FloatArray]:
    """Where to climb from, (cx, cy, ln h) each: the highest maxima over h of what the current reaches from `rest`.

    Where the current is free its search is on the strongest columns only, which chooses and decides nothing.
    """
    few, trials, values = score.strongest(), [], []
    for log_depth in score.scan(low, high, 0.5 if held else 2.0):  # a current follows most of the way
        x = np.array([*rest, log_depth])
        if held:
            value = score.at(x)[0]
        else:
            x, value, _ = few.climb(x, slice(0, 2), _CLOSE)
            value = value if np.hypot(*x[:2]) <= _REACH else 0.0
        trials.append(x)
        values.append(value)
    score.evaluations += few.evaluations if few is not score else 0
    # the range ends in low ground, so that a maximum at an end is one; what rises less than the scan knows N is none
    peaks = find_peaks([0.0, *values, 0.0], prominence=_LEAST * max(values))[0] - 1
    order = sorted(peaks.tolist(), key=lambda n: -values[n] if held else -score.at(trials[n])[0])
    return [trials[n] for n in order[:_STARTS]]


@dataclass(frozen=True, eq=False)
class _End:
    """Where a climb ended: (cx, cy, ln h), N and its Hessian there, and whether that is a maximum of what was free;
    `held` says that the current was not."""

    place: FloatArray
    score: float
    hessian: FloatArray
    arrived: bool
    held: bool

    @property
    def curvature(self) -> float:
        """Of N over ln h, over N: the current follows (the module's second equation), or is held."""
        h = -self.hessian / max(self.score, 1e-300)
        if self.held:
            return float(h[2, 2])
        return float(h[2, 2] - h[2, :2] @ np.linalg.pinv(h[:2, :2], rcond=UNKNOWN, hermitian=True) @ h[:2, 2])

    def excuse(self, low: float, high: float) -> Note:
        """Why there is no number here, if there is none."""
        if abs(self.curvature) < FLAT:
            return Note.FLAT
        if not low <= self.place[2] <= high or (not self.held and np.hypot(*self.place[:2]) > _REACH):
            return Note.EDGE
        return Note.NONE if self.arrived else Note.UNCONVERGED


def _limits(depths: tuple[float, float] | None, longest: float, shortest: float) -> tuple[float, float]:
    if depths is None:
        return RANGE[0] / shortest, RANGE[1] / longest
    positive("infer", depths=depths)
    if len(depths) != 2 or not depths[0] < depths[1]:
        raise LeakrefError("infer", f"depths = {depths}", "give the shallowest and the deepest, in this order")
    return depths


def _row(depth: float, velocity: FloatArray, score: float, curvature: float, count: int, note: Note) -> Inferred:
    each = np.array([depth]), velocity[None], np.array([score]), np.array([curvature]), np.array([count])
    return Inferred(*each, notes=(note,))


def _nothing(note: Note, count: int = 0, curvature: float = np.nan) -> Inferred:
    return _row(np.nan, np.full(2, np.nan), np.nan, curvature, count, note)


def band(spectrum: Spectrum, smallest: float, largest: float, *, water: Water) -> Shell:
    """All bins with `smallest` <= |k| <= `largest` (rad per length): a shell as wide as the band. Raises LeakrefError
    for limits that are none, or where the bins are not there."""
    positive("band", smallest=smallest, largest=largest)
    if not smallest < largest:
        raise LeakrefError("band", f"it goes from {smallest} to {largest}", "give the smaller wavenumber first")
    half = (largest - smallest) / 2 / spectrum.grid.wavenumber_resolution
    return shell_at(spectrum, (smallest + largest) / 2, water=water, half_width=half)


def levelled(shell: Shell, wavenumber_resolution: float) -> Shell:
    """With F over its mean at each wavenumber, in rings of `wavenumber_resolution`: every wavenumber has one say.

    The numerator of N is then the sum over rings of theirs, each over its own <F>: what the sum of N over shells pools.
    """
    ring = np.rint(np.hypot(shell.kx, shell.ky) / wavenumber_resolution).astype(np.int64)
    mean = np.bincount(ring, shell.magnitude @ shell.weight) / np.maximum(np.bincount(ring), 1)
    return replace(shell, magnitude=shell.magnitude / np.where(mean > 0, mean, 1.0)[ring][:, None])


def infer_band(
    spectrum: Spectrum,
    smallest: float,
    largest: float,
    *,
    gravity: float | None = None,
    water: Water | None = None,
    peak_wavenumber: float | None = None,
    width: float = WIDTH,
    each_alike: bool = False,
    **how: Any,
) -> Inferred:
    """One depth and one current for all wavenumbers from `smallest` to `largest`, rad per length: one of n = 1.

    As `infer_shells`; with `each_alike` every wavenumber has the same say (`levelled`). Raises LeakrefError.
    """
    water = law("infer_band", gravity, water)
    shell = band(spectrum, smallest, largest, water=water)
    if each_alike and not shell.is_empty:
        shell = levelled(shell, spectrum.grid.wavenumber_resolution)
    deep = replace(water, depth=np.inf)
    unit = velocity_unit(shell.wavenumber, deep, peak_wavenumber)
    return infer(shell, water, width=width * spectrum.grid.frequency_resolution, unit=unit, **how)


def infer_shells(
    spectrum: Spectrum,
    wavenumbers: npt.ArrayLike,
    *,
    gravity: float | None = None,
    water: Water | None = None,
    peak_wavenumber: float | None = None,
    width: float = WIDTH,
    half_width: float = HALF_WIDTH,
    **how: Any,
) -> Inferred:
    """A depth, and a current with it, from the shell around each of `wavenumbers` (n,), rad per length.

    `gravity` or `water` as in `nsp.extract`; the depth of `water` is not used. `width` in domega, `half_width` in dk.
    `how`: `current` and `depths` of `infer`. Raises LeakrefError.
    """
    k, water = checked_wavenumbers(wavenumbers, "infer_shells"), law("infer_shells", gravity, water)
    positive("infer_shells", width=width, half_width=half_width)
    a, deep = width * spectrum.grid.frequency_resolution, replace(water, depth=np.inf)
    shell = partial(shell_at, spectrum, water=water, half_width=half_width)
    rows = [infer(shell(k_i), water, width=a, unit=velocity_unit(k_i, deep, peak_wavenumber), **how) for k_i in k]
    return gathered(rows)


def gathered(rows: list[Inferred]) -> Inferred:
    """One record of several."""
    return Inferred(
        np.concatenate([row.depths for row in rows]),
        np.concatenate([row.velocities for row in rows]),
        np.concatenate([row.score for row in rows]),
        np.concatenate([row.curvature for row in rows]),
        np.concatenate([row.evaluations for row in rows]),
        tuple(note for row in rows for note in row.notes),
    )
