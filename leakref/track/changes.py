"""What changed from one version to the next: better, worse, equal within a margin, or undecided.

Errors of two versions are compared in pairs where they have realisations in common, and as two samples (Welch) where
they have none. The mean change has a Student's t interval for each wavenumber, for each band of wavenumbers (the mean
error over its shells), and for the share of velocities that were declined.

**Many comparisons.** All intervals of one run hold together with a confidence of 1 - `ALPHA`: Bonferroni, which needs
nothing known about how they depend on each other (shells overlap, seas share phases). Half of ALPHA is divided among
bands and shares, which are few, half among single wavenumbers. An interval wholly above the margin is worse, wholly
below its negative better, wholly within equal; so if nothing is worse than the margin allows, a whole run says "worse"
with a probability of at most ALPHA / 2.

**What would be seen.** `smallest` is the change that would be called worse with a probability of `POWER`: the margin
and, for intervals of t standard errors, (t + t(POWER)) of them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.stats import t as student

from leakref._base import FloatArray, mean_of_known, positive
from leakref.track.tracking import UNIT, Series

__all__ = [
    "ALPHA",
    "ANSWERS",
    "BANDS",
    "LOST",
    "MARGIN",
    "POWER",
    "VERDICTS",
    "Change",
    "Comparison",
    "compare",
    "in_band",
    "verdict",
]

ALPHA = 0.01
"""Of all comparisons of a run together: how often some interval may miss the true change."""
POWER = 0.9
"""The probability with which a change of the size `smallest` would be called worse."""
MARGIN = 0.01
"""Of the smaller velocity resolution (eq:dcdwk), in the mean over a band: a change within it is none."""
LOST = 0.05
"""The same for the share of velocities declined."""
BANDS = ((0.4, 0.8), (0.8, 1.2), (1.2, 2.0), (2.0, 3.5))
"""In k0, each without its upper end but the last."""
ANSWERS = "answers"
"""The band of the row about velocities that were declined."""
VERDICTS = ("better", "worse", "equal", "undecided")
"""In the order in which they are counted."""


@dataclass(frozen=True)
class Change:
    """One comparison: means `before` and `after` over `count` realisations (the smaller number, if not `paired`).

    `band` is "k = 1.2", "0.8 to 1.2" or `ANSWERS`, with the `wavenumbers` in it. All in c0, except for `ANSWERS`, a
    share. `margin` and `smallest` (module text) are in the same unit, `resolution` is the mean over the band. What
    cannot be known is NaN, an interval then reaches from -inf to inf.

    - `change`: `after` less `before`, so that more is worse; `interval`: of the change.
    - `verdict`: one of `VERDICTS`; `count`: realisations with an answer on both sides. `case`, `window` and `method`
      are those of the series.
    """

    case: str
    window: str
    method: str
    band: str
    wavenumbers: tuple[float, ...]
    before: float
    after: float
    change: float
    interval: tuple[float, float]
    verdict: str
    margin: float
    smallest: float
    resolution: float
    count: int
    paired: bool

    @property
    def single(self) -> bool:
        """Whether it is of one wavenumber."""
        return self.band.startswith("k")

    def record(self) -> dict[str, Any]:
        """As in the JSON of `leakref track compare` (guide protocol, section 14).

        NaN and infinite bounds become null when it is printed.
        """
        return {**vars(self), "interval": list(self.interval), "unit": "share" if self.band == ANSWERS else "c0"}


@dataclass(frozen=True)
class Comparison:
    """All changes of a run, and what was not compared and why: `unlike` because its case is not the same any more,
    `alone` because only one of the two has it.

    - `changes`: one for each wavenumber, band and share of every series that both have.
    """

    changes: tuple[Change, ...]
    unlike: tuple[str, ...] = ()
    alone: tuple[str, ...] = ()

    @property
    def worse(self) -> list[Change]:
        """What is worse beyond the margin. Empty is no proof that nothing is: look at `undecided` ones and at
        `smallest`.
        """
        return [change for change in self.changes if change.verdict == "worse"]

    @property
    def status(self) -> int:
        """Exit status: 1 if something is worse; 3 if nothing was decided or a case is not the same any more; else 0."""
        if self.worse:
            return 1
        decided = any(change.verdict != "undecided" for change in self.changes)
        return 0 if decided and not self.unlike else 3


@dataclass(frozen=True, eq=False)
class _Pair:
    """Two samples (R,) of one quantity, in the same realisations if `paired`."""

    series: Series
    band: str
    wavenumbers: FloatArray
    before: FloatArray
    after: FloatArray
    margin: float
    resolution: float
    paired: bool

    def moments(self) -> tuple[float, float, float, float, float, int]:
        """Both means, the change, its standard error, degrees of freedom, and how many realisations. Paired, the
        variance is that of the differences; unpaired, the degrees of freedom are Welch's. What rounding to `UNIT` adds
        to a variance is included, so that equal errors have no interval of width zero.
        """
        a, b = self.before, self.after
        if self.paired:
            both = np.isfinite(a) & np.isfinite(b)
            a, b = a[both], b[both]
        else:
            a, b = a[np.isfinite(a)], b[np.isfinite(b)]
        count = min(a.size, b.size)
        if count < 2:
            before, after = (float(s.mean()) if s.size else np.nan for s in (a, b))
            return before, after, np.nan, np.inf, 1.0, count
        rounding = UNIT**2 / 12  # of each error, as it is kept
        if self.paired:
            square, degrees = ((b - a).var(ddof=1) + 2 * rounding) / count, count - 1.0
        else:
            parts = [(sample.var(ddof=1) + rounding) / sample.size for sample in (a, b)]
            square = sum(parts)
            degrees = square**2 / sum(part**2 / (s.size - 1) for part, s in zip(parts, (a, b), strict=True))
        return float(a.mean()), float(b.mean()), float(b.mean() - a.mean()), float(np.sqrt(square)), degrees, count

    def change(self, alpha: float) -> Change:
        """With a two-sided interval of confidence 1 - `alpha`."""
        before, after, change, error, degrees, count = self.moments()
        reach = float(student.isf(alpha / 2, degrees))
        low, high = (change - reach * error, change + reach * error) if np.isfinite(error) else (-np.inf, np.inf)
        smallest = self.margin + (reach + float(student.ppf(POWER, degrees))) * error
        return Change(
            *self.series.key,
            self.band,
            tuple(self.wavenumbers.tolist()),
            before,
            after,
            change,
            (low, high),
            verdict(low, high, self.margin),
            self.margin,
            smallest,
            self.resolution,
            count,
            self.paired,
        )


def verdict(low: float, high: float, margin: float) -> str:
    """What an interval says: one of `VERDICTS`.

    All three numbers are in one unit; `margin` is positive. An interval that touches the margin is still equal.
    """
    if low > margin:
        return "worse"
    if high < -margin:
        return "better"
    return "equal" if -margin <= low and high <= margin else "undecided"


def compare(before: Sequence[Series], after: Sequence[Series], *, margin: float = MARGIN) -> Comparison:
    """Compare the series that both have, case by case of the same digest. Raises LeakrefError for a bad margin.

    `margin` is a part of the smaller resolution. Realisations that both have are compared in pairs, and if there are
    none the two are taken as independent samples (Welch). The interval of each change is as wide as the number of
    comparisons demands, so that adding cases makes all of them wider.
    """
    positive("compare", margin=margin)
    old, new = ({one.key: one for one in side} for side in (before, after))
    unlike = [key for key in old if key in new and old[key].digest != new[key].digest]
    alone = sorted(set(old) ^ set(new))
    pairs = [pair for key in old if key in new and key not in unlike for pair in _pairs(old[key], new[key], margin)]
    single = sum(pair.band.startswith("k") for pair in pairs)
    few = len(pairs) - single
    changes = [pair.change(ALPHA / 2 / (single if pair.band.startswith("k") else few)) for pair in pairs]
    return Comparison(
        tuple(changes),
        tuple(
            f"{', '.join(key)}: not compared, the case is not the same any more (digest {old[key].digest[:8]}, now "
            f"{new[key].digest[:8]})"
            for key in unlike
        ),
        tuple(
            f"{', '.join(key)}: not compared, only the {'first' if key in old else 'second'} has it" for key in alone
        ),
    )


def _pairs(a: Series, b: Series, margin: float) -> Iterator[_Pair]:
    """Wavenumbers, bands and the share declined. A pair for each wavenumber, each band that has any, and the share
    declined. In a band a shell counts only where both sides have a number, if they are paired.
    """
    first, last = max(a.first, b.first), min(a.first + len(a.errors), b.first + len(b.errors))
    paired = last > first
    x, y = (s.errors[first - s.first : last - s.first] if paired else s.errors for s in (a, b))
    k, resolution = a.wavenumbers, a.resolution
    for n in range(k.size):
        unit = float(resolution[n])
        yield _Pair(b, f"k = {k[n]:.4g}", k[n : n + 1], x[:, n], y[:, n], margin * unit, unit, paired)
    both = np.isfinite(x) & np.isfinite(y) if paired else None  # the same shells on either side
    for low, high in BANDS:
        inside = in_band(k, low, high)
        if inside.any():
            mean = float(resolution[inside].mean())
            common = (np.where(both, s, np.nan) if both is not None else s for s in (x, y))
            p, q = (mean_of_known(s[:, inside], axis=1) for s in common)
            yield _Pair(b, f"{low:g} to {high:g}", k[inside], p, q, margin * mean, mean, paired)
    declined, still = (np.mean(~np.isfinite(s), axis=1) for s in (x, y))
    yield _Pair(b, ANSWERS, k, declined, still, LOST, np.nan, paired)


def in_band(wavenumbers: FloatArray, low: float, high: float) -> npt.NDArray[np.bool_]:
    """Which wavenumbers (n,) are in one of `BANDS`, (n,).

    Edges are met to 1e-9, and the upper end belongs to the next band, but for the last.
    """
    end = high + (1e-9 if high == BANDS[-1][1] else -1e-9)
    return (wavenumbers > low - 1e-9) & (wavenumbers < end)
