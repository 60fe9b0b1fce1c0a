"""What is measured in random seas: scalars of a realisation, phases and likeness, and leakref's own seas beside.

A generator is judged by means over realisations (family `sea`). leakref's own seas have waves between the bins and
amplitudes drawn like phases: no right sea scatters more, and what chance does to the mean of theirs it may do to any.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
from scipy.special import gammaincinv, stdtrit

from leakref._base import ComplexArray, FloatArray
from leakref.certify.checks.statistics import FALSE_ALARMS
from leakref.certify.subject.seas import Sea
from leakref.certify.verdict import Unanswered, Verdict
from leakref.currents import UniformCurrent
from leakref.dispersion import DEEP
from leakref.sea import Components, SeaState, directional_spreading, jonswap
from leakref.synthesis import synthesize

__all__ = [
    "BANDS",
    "COUNT",
    "MARGINS",
    "OWN",
    "SEEN",
    "STATEMENTS",
    "STRONG",
    "Measured",
    "added",
    "apart",
    "chance",
    "collected",
    "correlated",
    "measure",
    "own",
    "phase_limit",
    "realizations",
]

COUNT = 32
"""Realisations that a generator is asked for, of each sea."""
OWN = 64
"""Of leakref's own seas."""
STATEMENTS = 30
"""Statements about chance in a whole run: ten of each of two seas and the shares of four bands, two components each."""
BANDS = (0.5, 0.8, 1.2, 1.8, 3.0)
"""Of the peak's wavenumber: the ends of the bands whose shares of the energy are compared."""
SEEN = (0.7, 2.5)
"""Of the peak's wavenumber: the waves whose directions and motion are looked at."""
MARGINS = {
    "energy": 0.07, **{f"band-{n}": 0.03 for n in range(len(BANDS) - 1)}, "turn": 2.0, "width": 0.12, "behind": 0.05,
    "u": 0.02, "v": 0.02,
}  # fmt: skip
"""By how much the mean of each scalar may differ beside what chance does, since generators take choices."""
STRONG = 0.15
"""Of the strongest: the bins whose phases are looked at."""


@dataclass(frozen=True, eq=False)
class Measured:
    """Of R realisations, arrays (R,) by name, and `bins` (R, n), the amplitudes at single bins of the first frame."""

    scalars: Mapping[str, FloatArray]
    bins: ComplexArray
    frames: FloatArray

    def mean(self, name: str) -> float:
        """Over the realisations."""
        return float(self.scalars[name].mean())

    def scatter(self, name: str) -> float:
        """The standard deviation of one realisation."""
        return float(self.scalars[name].std(ddof=1))


def _bins(sea: Sea) -> tuple[FloatArray, FloatArray]:
    """Bins (i, j), each (n,), at which there is much energy."""
    i, j = (index.ravel() for index in np.meshgrid(*(np.arange(2 - n // 2, n // 2) for n in sea.grid.shape[:2])))
    kx, ky = i * sea.grid.bin_widths[0], j * sea.grid.bin_widths[1]
    k = np.maximum(np.hypot(kx, ky), 1e-9)
    density = jonswap(sea.water.frequency(k) / sea.water.frequency(1.0), sea.peakedness)
    density *= directional_spreading(np.degrees(np.arctan2(ky, kx)), sea.direction, sea.spread) * DEEP.density_factor(k)
    strong = density >= STRONG * density.max()
    return i[strong], j[strong]


def measure(sea: Sea, eta: FloatArray) -> tuple[dict[str, float], ComplexArray, FloatArray]:
    """What one realisation shows: scalars, amplitudes at single bins, and its first frame with variance 1. Raises
    Unanswered (fail) where it shows no waves.
    """
    grid, (nx, ny, nt) = sea.grid, sea.grid.shape
    wx, wy, wt = (0.5 - 0.5 * np.cos(2 * np.pi * np.arange(n) / n) for n in grid.shape)
    power = np.abs(np.fft.rfftn(eta * (wx[:, None, None] * wy[:, None] * wt))) ** 2
    power[..., 0] = 0
    # the transform goes forwards in time, which puts a wave that goes along k at -k
    kx = -2 * np.pi * np.fft.fftfreq(nx, grid.spacing[0])[:, None]
    ky = -2 * np.pi * np.fft.fftfreq(ny, grid.spacing[1])[None, :]
    k, omega = np.hypot(kx, ky), 2 * np.pi * np.fft.rfftfreq(nt, grid.spacing[2])
    at = power.sum(axis=2)
    found = {"energy": float(np.mean(eta**2)) / sea.variance}
    total = 1e-300 + at[(k >= BANDS[0]) & (k < BANDS[-1])].sum()
    for n, (low, high) in enumerate(pairwise(BANDS)):
        found[f"band-{n}"] = float(at[(k >= low) & (k < high)].sum() / total)
    seen = (k >= SEEN[0]) & (k < SEEN[1])
    if not at[seen].sum() > 0:
        raise Unanswered(Verdict.FAIL, "makes a surface without waves in the band that was asked for")
    weight, kx, ky = at[seen] / at[seen].sum(), np.broadcast_to(kx, k.shape)[seen], np.broadcast_to(ky, k.shape)[seen]
    off = np.angle(np.exp(1j * (np.arctan2(ky, kx) - np.radians(sea.direction))))
    found["turn"] = float(np.degrees(np.angle(np.sum(weight * np.exp(1j * off)))))
    behind = float(weight[np.abs(off) > np.pi / 2].sum())
    found["behind"] = min(behind, 1 - behind)  # that all of it is turned round is told by `turn`
    about = np.degrees(np.angle(np.exp(1j * (off - np.radians(found["turn"])))))
    front = np.abs(about) < 90
    found["width"] = float(np.sqrt(np.sum(weight[front] * about[front] ** 2) / weight[front].sum())) / sea.deviation
    shift = (power[seen] @ omega) / np.maximum(at[seen], 1e-300) - sea.water.frequency(np.hypot(kx, ky))
    rows = np.stack([kx, ky], axis=1)
    u, v = np.linalg.pinv((rows * weight[:, None]).T @ rows) @ ((rows * weight[:, None]).T @ shift)
    found |= {"u": float(u), "v": float(v)}
    frame = np.asarray(eta[:, :, 0])
    i, j = _bins(sea)
    amplitudes = np.fft.fft2(frame)[i, j]
    return found, amplitudes, frame.ravel() / max(float(np.sqrt(np.mean(frame**2))), 1e-300)


def collected(rows: list[tuple[dict[str, float], ComplexArray, FloatArray]]) -> Measured:
    """What several realisations show."""
    scalars = {name: np.array([row[0][name] for row in rows]) for name in rows[0][0]}
    turns = np.exp(1j * np.radians(scalars["turn"]))  # angles, which have a mean on the circle only
    middle = np.angle(turns.mean())
    scalars["turn"] = np.degrees(middle + np.angle(turns * np.exp(-1j * middle)))
    return Measured(scalars, np.array([row[1] for row in rows]), np.array([row[2] for row in rows]))


@lru_cache(maxsize=8)
def own(sea: Sea) -> Measured:
    """leakref's own realisations of it."""
    return realizations(sea, range(OWN))


def realizations(sea: Sea, numbers: Iterable[int]) -> Measured:
    """leakref's own seas of those numbers: waves between the bins, the energy of each drawn anew."""
    state = SeaState(sea.direction, sea.spread, sea.peakedness, 4.0, UniformCurrent(sea.current), sea.water)
    rows, axes = [], [sea.grid.samples(axis) for axis in range(3)]
    for n in numbers:
        waves = state.components(n)
        drawn = np.random.Generator(np.random.Philox(key=n)).exponential(size=waves.kx.size)
        height = np.sqrt(drawn * sea.variance / waves.variance)
        lot = Components(waves.kx, waves.ky, waves.omega, waves.amplitude * height, waves.phase)
        rows.append(measure(sea, synthesize(lot, *axes)))
    return collected(rows)


def chance(found: Measured, other: Measured, name: str) -> float:
    """How far two means may be apart by chance: Student's t, of the larger of the two scatters."""
    t = -float(stdtrit(COUNT - 1, FALSE_ALARMS / STATEMENTS / 2))
    return t * max(found.scatter(name), other.scatter(name)) * float(np.sqrt(1 / COUNT + 1 / OWN))


def apart(found: Measured, other: Measured, name: str) -> float:
    """Over: how far the mean of a scalar is from that of leakref's own seas, of what it may be."""
    return abs(found.mean(name) - other.mean(name)) / (MARGINS[name] + chance(found, other, name))


def phase_limit(count: float) -> float:
    """Of the mean of `count` squares of resultants, each 1 in the mean for phases that are independent."""
    return float(gammaincinv(count, 1 - FALSE_ALARMS / STATEMENTS) / count)


def added(bins: ComplexArray) -> tuple[float, float, str]:
    """What phases (R, n) add up to over seas or over waves, whichever is worse: over, how many times what independent
    ones do, and which of the two it is.
    """
    unit = bins / np.maximum(np.abs(bins), 1e-300)
    count, waves = unit.shape
    over_seas = float(np.mean(np.abs(unit.sum(axis=0)) ** 2)) / count
    over_waves = float(np.mean(np.abs(unit.sum(axis=1)) ** 2)) / waves
    return max(
        (over_seas / phase_limit(waves / 4), over_seas, "from one sea to the next"),
        (over_waves / phase_limit(count / 4), over_waves, "from wave to wave"),
    )


def correlated(frames: FloatArray) -> tuple[float, float]:
    """The largest correlation of two of the frames (R, n), and the deviation of all of them from zero."""
    matrix = frames @ frames.T / frames.shape[1]
    pairs = matrix[np.triu_indices(len(frames), 1)]
    return float(np.abs(pairs).max()), float(np.sqrt(np.mean(pairs**2)))
