"""How biased a code is where it is right: bias and random part at each wavenumber, beside the reference with Hann.

The seas are those of the paper at a coarser sampling, and three harder ones; each realisation is shown at two scales,
and to the reference as well, so that the two are compared in pairs.

Checks of leakage say whether a code is worse than the reference allows; this says how large its errors are. It is run
in the full profile only, and nothing it finds changes a grade. The error is `|c - U|`, the distance between the
velocity found and the Doppler-shift velocity that was put in (eq:SnJ), in units of the phase speed `c0` at the spectral
peak.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import t as student

from leakref._base import FloatArray, deviation_of_known, mean_of_known
from leakref.certify.checks import inputs
from leakref.certify.checks.criteria import expected, tapered
from leakref.certify.checks.identity import identify
from leakref.certify.checks.inputs import Cube, polar
from leakref.certify.subject.frames import Subject
from leakref.certify.verdict import Unanswered
from leakref.currents import UniformCurrent
from leakref.grid import Grid

__all__ = ["REALIZATIONS", "SCALES", "SEAS", "Bias", "Sea", "bias", "figure", "own_window"]

SCALES = (1.0, 4.0)
"""Peak wavenumbers, in units of the usual one: in SI waves of 25 m and of 6 m."""
REALIZATIONS = 10
"""Of every sea at every scale."""
_CONFIDENCE = 0.95


@dataclass(frozen=True)
class Sea:
    """A sea to be biased by: what it is in `words`, its waves, its current and its grid.

    - `name`: a short word, the key in `SEAS`; `words`: what stands in the certificate.
    - `direction`: where the waves go to, degrees from the x axis; `spread`: full width of the spreading
      (eq:angularspread), degrees.
    - `peakedness`: gamma of eq:JONSWAP.
    - `current`: in units of `c0`; None is still water.
    - `grid`: samples along x, y, t and their spacing, in `1 / k0` and `1 / omega0`.
    - `wavenumbers`: at which velocities are asked for, in units of `k0`.
    """

    name: str
    words: str
    direction: float
    spread: float
    peakedness: float = 3.3
    current: UniformCurrent | None = None
    grid: Grid = inputs.SEA
    wavenumbers: tuple[float, ...] = (0.8, 1.0, 1.2, 1.5, 1.8, 2.2, 2.6, 3.0)

    def cube(self, realization: int) -> Cube:
        """One realisation.

        `realization` is counted from 0. Its phases are those of realisation 200 and up, which no check uses, so that a
        code tuned to the checks gains nothing here.
        """
        return inputs.sea(
            self.direction,
            self.spread,
            self.current,
            realization=200 + realization,
            peakedness=self.peakedness,
            grid=self.grid,
            wavenumbers=self.wavenumbers,
        )


SEAS = {
    sea.name: sea
    for sea in (
        Sea("broad", "case-NSP-LS: theta0 = 75 degrees, spread 60 degrees, still water", 75.0, 60.0),
        Sea("directional", "case-theta0-DeltaTheta: theta0 = 60 degrees, spread 30 degrees, still water", 60.0, 30.0),
        Sea("peaked", "case-gamma: peakedness 7, spread 45 degrees, still water", 60.0, 45.0, 7.0),
        Sea(
            "following",
            "case-U: a current of 0.15 c0 along the waves, spread 60 degrees",
            90.0,
            60.0,
            current=UniformCurrent((0.0, 0.15)),
        ),
        Sea("narrow", "harder: spread 15 degrees, peakedness 7, still water", 60.0, 15.0, 7.0),
        Sea(
            "crossing",
            "harder: a current of 0.15 c0 across waves of 30 degrees spread, turned by 30 degrees",
            120.0,
            30.0,
            current=UniformCurrent(polar(0.15, 30.0)),
        ),
        Sea(
            "small",
            "harder: three wavelengths by seven periods, spread 30 degrees",
            60.0,
            30.0,
            grid=Grid((34, 30, 56), (0.57, 0.66, 0.79)),
            wavenumbers=(1.5, 1.8, 2.2, 2.6, 3.0),
        ),
    )
}
"""Those of the paper, then the harder ones, by name."""


@dataclass(frozen=True, eq=False)
class Bias:
    """Of one sea at one scale, at n wavenumbers: mean and standard deviation of |c - U|, and the same of the reference.

    `ratio` is mean error over mean error of the reference, over all wavenumbers, and `interval` where it is with a
    confidence of 95 %, both from pairs of one realisation. NaN where there is no answer. All in c0.

    - `sea`, `scale`, `method`: of what; `scale` is the peak wavenumber in units of the usual one.
    - `wavenumbers` (n,): in units of `k0`.
    - `bias`, `random` (n,): mean and standard deviation over the realisations, of the code under test.
    - `reference_bias`, `reference_random` (n,): of the reference chain with Hann and NSP, on the same seas.
    - `resolutions` (2, n): the smaller and the larger of the two of eq:dcdwk.
    - `ratio`, `interval`: see above; the interval is by the delta method for a ratio of means, cut at zero.
    - `realizations`: how many were answered.
    """

    sea: Sea
    scale: float
    method: str
    wavenumbers: FloatArray
    bias: FloatArray
    random: FloatArray
    reference_bias: FloatArray
    reference_random: FloatArray
    resolutions: FloatArray
    ratio: float
    interval: tuple[float, float]
    realizations: int

    @property
    def sub_resolution_from(self) -> float | None:
        """The wavenumber from which on the bias stays below the smaller resolution (eq:dcdwk); None if nowhere."""
        below = np.nan_to_num(self.bias, nan=np.inf) < self.resolutions[0]
        above = np.flatnonzero(~below)
        first = int(above[-1]) + 1 if above.size else 0
        return float(self.wavenumbers[first]) if first < below.size else None

    @property
    def words(self) -> str:
        """In a sentence.

        For instance `sub-resolution from k = 1.2; errors are 1.04 (0.98 to 1.10) times the reference's`.
        """
        k = self.sub_resolution_from
        where = "at no wavenumber" if k is None else f"from k = {k:g}"
        low, high = self.interval
        return f"sub-resolution {where}; errors are {self.ratio:.2f} ({low:.2f} to {high:.2f}) times the reference's"

    def record(self) -> dict[str, Any]:
        """As in the JSON of `leakref certify`. Arrays stay arrays, and `resolutions` is reduced to the smaller one."""
        return {
            "sea": self.sea.name,
            "about": self.sea.words,
            "scale": self.scale,
            "method": self.method,
            "realizations": self.realizations,
            "wavenumbers": self.wavenumbers,
            "bias": self.bias,
            "random": self.random,
            "reference_bias": self.reference_bias,
            "reference_random": self.reference_random,
            "smaller_resolution": self.resolutions[0],
            "sub_resolution_from": self.sub_resolution_from,
            "ratio": self.ratio,
            "interval": list(self.interval),
            "words": self.words,
        }


def bias(
    subject: Subject,
    seas: Sequence[Sea] = tuple(SEAS.values()),
    *,
    realizations: int = REALIZATIONS,
    scales: Sequence[float] = SCALES,
    after_each: Callable[[], object] = lambda: None,
) -> list[Bias]:
    """The bias of an implementation's main method under its own taper, sea by sea and scale by scale.

    A realisation that it does not answer is left out; a sea in which it answers fewer than two is left out. Calls
    `after_each` for every cube.

    The window is `own_window`, the method the first it declares. Every realisation is shown at all `scales`. Returned
    is one `Bias` for each sea and scale, in that order. That a code does not answer is never raised.
    """
    identify(subject)
    method, window, found = subject.methods[0], own_window(subject), []
    for sea in seas:
        for scale in scales:
            pairs = []
            for number in range(realizations):
                with inputs.in_water(subject.still(scale)):
                    pairs.append(_errors(subject, sea.cube(number), window, method, scale))
                after_each()
            answered = [pair for pair in pairs if pair is not None]
            if len(answered) >= 2:
                found.append(_summed(sea, scale, method, np.array(answered)))
    return found


def own_window(subject: Subject) -> str:
    """The taper that the checks of leakage use for this code, or its first window if it offers none of that kind."""
    try:
        return tapered(subject)
    except Unanswered:
        return subject.declaration.windows[0]


def _errors(subject: Subject, cube: Cube, window: str, method: str, scale: float) -> FloatArray | None:
    """|c - U| of the implementation and of the reference, (2, n); None without an answer. The reference is shown the
    same cube, always with Hann and NSP.
    """
    try:
        answer = subject.extract(
            cube.surface, cube.spacing, cube.wavenumbers, window=window, method=method, scale=scale
        )
    except Unanswered:
        return None
    own = expected(cube, "hann", "nsp").velocities
    return np.array([np.hypot(*(c - cube.truth).T) for c in (answer.values, own)])


def _summed(sea: Sea, scale: float, method: str, errors: FloatArray) -> Bias:
    """`errors` (R, 2, n). Mean and deviation are over all answers at a wavenumber; the ratio is over those realisations
    in which both codes have an answer somewhere, each reduced to its mean over the wavenumbers, so that its error
    counts realisations.
    """
    mean, spread = mean_of_known(errors), deviation_of_known(errors)
    both = np.where(np.isfinite(errors).all(axis=1, keepdims=True), errors, np.nan)
    used = np.isfinite(both).any(axis=(1, 2))
    mine, reference = np.nanmean(both[used], axis=2).T
    ratio = float(mine.sum() / reference.sum())
    # of a ratio of means, by its residuals (the delta method)
    residual = (mine - ratio * reference) / reference.mean()
    wide = float(student.isf((1 - _CONFIDENCE) / 2, max(mine.size - 1, 1)) * residual.std(ddof=1) / np.sqrt(mine.size))
    return Bias(
        sea,
        scale,
        method,
        np.array(sea.wavenumbers),
        mean[0],
        spread[0],
        mean[1],
        spread[1],
        sea.cube(0).resolutions,
        ratio,
        (max(ratio - wide, 0.0), ratio + wide),
        len(errors),
    )


def figure(found: Sequence[Bias]) -> bytes:
    """A PNG: error against wavenumber in every sea, beside the reference and the resolutions.

    There is a panel for each sea, with wavenumbers in `k0` and errors in `c0`; error bars are the random part, and grey
    is what lies below the smaller resolution. The bytes are those of a PNG file.
    """
    from io import BytesIO

    from leakref.figures import COLOURS
    from leakref.figures import figure as blank

    names = list(dict.fromkeys(one.sea.name for one in found))
    columns = 2
    rows = -(-len(names) // columns)
    drawing, axes = blank(rows, columns, width=8.0, height=2.3)
    for ax, name in zip(axes.ravel(), names, strict=False):
        parts = [one for one in found if one.sea.name == name]
        for n, one in enumerate(parts):
            shifted = one.wavenumbers + 0.03 * n  # so that equal ones are both seen
            ax.errorbar(
                shifted,
                one.bias,
                one.random,
                color=COLOURS[n],
                marker="os"[n % 2],
                ms=4,
                capsize=2,
                lw=1.2,
                label=f"this code, scale {one.scale:g}",
            )
        first = parts[0]
        ax.plot(first.wavenumbers, first.reference_bias, color="0.25", ls="--", label="the reference, Hann")
        ax.fill_between(first.wavenumbers, 0, first.resolutions[0], color="0.9", label="below the smaller resolution")
        ax.set_title(name, fontsize=10)
        ax.set_xlabel("k / k0")
        ax.set_ylabel("|c - U| / c0")
        ax.set_ylim(bottom=0)
    for ax in axes.ravel()[len(names) :]:
        ax.set_visible(False)
    axes.ravel()[0].legend(fontsize=7)
    stream = BytesIO()
    drawing.savefig(stream, format="png", dpi=110)
    return stream.getvalue()
