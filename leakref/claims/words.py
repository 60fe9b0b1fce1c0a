"""The vocabulary of the claims: samples, bands of k, comparisons with their sampling error, readings.

Rules, fixed before anything was looked at. A comparison is of means over realisations, and always of realisation
i with realisation i: seas on one lattice share their phases, and where they do not the pairing does no harm. At a
shell it is *shown* if it holds by more than two standard errors, *contradicted* if it fails by as much, else open.
*Most* is over half of the shells; *negligible*, below the smaller resolution; *significant*, over two standard
errors and over 10 % of the smaller resolution; *about*, within 10 %. Where the words leave open whether all shells
are meant (no "all", no "most"), both are readings: every shell, most shells.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from leakref._base import FloatArray, mean_of_known
from leakref.ensemble import Ensemble

__all__ = [
    "ABOVE",
    "ALL",
    "AWAY",
    "BELOW",
    "LEVELS",
    "MEASURES",
    "NEAR",
    "RESOLUTIONS",
    "STATISTICS",
    "WINDOWS",
    "Answer",
    "Band",
    "Reading",
    "Sample",
    "Tally",
    "above",
    "across",
    "alike",
    "along",
    "below",
    "bias",
    "both",
    "deviation",
    "direction",
    "either",
    "every",
    "excess",
    "magnitude",
    "missed",
    "most",
    "pooled",
    "positive",
    "random",
    "ratio",
    "significant",
    "smaller",
    "within",
]

WINDOWS = ("box", "hann")
"""Untapered and tapered, as most statements compare them."""
Answer = bool | None
"""Holds, does not hold, or None: the sampling error does not tell."""
Band = Callable[[FloatArray], Any]
"""Takes wavenumbers (n,) in `k0` and says of each whether it is inside."""
Mask = Any
_ROUNDING = 1e-9


def BELOW(k: FloatArray) -> Mask:
    """k < 1. True or False for each wavenumber, in `k0`, as of all bands; the peak itself belongs to neither side."""
    return k < 1 - _ROUNDING


def ABOVE(k: FloatArray) -> Mask:
    """k > 1."""
    return k > 1 + _ROUNDING


def NEAR(k: FloatArray) -> Mask:
    """k about 1: within 10 %."""
    return np.abs(k - 1) <= 0.1 + _ROUNDING


def AWAY(k: FloatArray) -> Mask:
    """All but k about 1."""
    return ~NEAR(k)


def ALL(k: FloatArray) -> Mask:
    """Every k."""
    return np.isfinite(k)


@dataclass(frozen=True, eq=False)
class Sample:
    """Values (R, n) at wavenumbers `k` (n,), whose means over the R realisations are in question.

    A statistic that is no mean is written as one, by the influence of each realisation (`deviation`, `direction`,
    `ratio`), so that every comparison has a standard error, and a paired one where the seas share phases.
    """

    k: FloatArray
    values: FloatArray
    __array_ufunc__ = None  # an array times a sample is a sample

    @property
    def mean(self) -> FloatArray:
        """(n,); NaN where no realisation has a number."""
        return mean_of_known(self.values)

    @property
    def error(self) -> FloatArray:
        """Standard error of the mean, (n,); NaN with fewer than two realisations."""
        count = np.isfinite(self.values).sum(axis=0)
        square = np.nansum((self.values - self.mean) ** 2, axis=0)
        return np.where(count < 2, np.nan, np.sqrt(square / np.maximum(count - 1, 1) / np.maximum(count, 1)))

    def __add__(self, other: Sample) -> Sample:
        """At the wavenumbers and in the realisations that both have. Where one of the two has no number, the sum has
        none.
        """
        mine, theirs = np.nonzero(np.abs(self.k[:, None] - other.k) < 1e-6)
        rows = min(len(self.values), len(other.values))
        return Sample(self.k[mine], self.values[:rows, mine] + other.values[:rows, theirs])

    def __sub__(self, other: Sample) -> Sample:
        return self + -1.0 * other

    def __rmul__(self, factor: float | FloatArray) -> Sample:
        return Sample(self.k, factor * self.values)

    def at(self, band: Band) -> Sample:
        """Only the wavenumbers of a band."""
        inside = band(self.k)
        return Sample(self.k[inside], self.values[:, inside])

    def over(self, band: Band = ALL) -> Sample:
        """The mean over the shells of a band: one value a realisation, (R, 1). NaN where one of the shells has no
        number.
        """
        chosen = self.at(band)
        return Sample(np.zeros(1), chosen.values.mean(axis=1, keepdims=True))


def bias(e: Ensemble) -> Sample:
    """Its mean is the mean of |c|."""
    return Sample(e.wavenumbers, e.magnitudes)


def deviation(sample: Sample) -> Sample:
    """Its mean is the standard deviation s of `sample` (n - 1): s + ((x - mean)^2 n / (n - 1) - s^2) / 2 s, by which
    the error of s, and of differences between paired ones, is that of a mean. Values are the influence of each
    realisation on s.
    """
    count = np.isfinite(sample.values).sum(axis=0)
    s = sample.error * np.sqrt(count)
    square = (sample.values - sample.mean) ** 2 * count / np.maximum(count - 1, 1)
    return Sample(sample.k, s + np.where(s > 0, (square - s**2) / (2 * np.where(s > 0, s, 1)), 0))


def random(e: Ensemble) -> Sample:
    """Its mean is the random part, the standard deviation of |c|."""
    return deviation(bias(e))


STATISTICS: dict[str, Callable[[Ensemble], Sample]] = {"bias": bias, "random part": random}
"""The two parts of an error that the paper shows, as samples whose means they are."""


def missed(e: Ensemble) -> Sample:
    """Its mean is that of |c - U|. In `c0`; in still water it is `bias`."""
    return Sample(e.wavenumbers, np.hypot(*np.moveaxis(e.velocities - e.configuration.current, -1, 0)))


def excess(e: Ensemble) -> Sample:
    """Its mean is how far the mean of |c| is from U, as the paper's figures show it."""
    return magnitude(Sample(e.wavenumbers, e.magnitudes - np.hypot(*e.configuration.current)))


MEASURES: dict[str, Callable[[Ensemble], Sample]] = {"mean of |c| against U": excess, "mean of |c - U|": missed}
"""The error with a current; without one the two are the same. The first is what the figures show."""


def _upper(measure: Callable[[Ensemble], Sample]) -> Callable[[Ensemble], Sample]:
    return lambda e: measure(e) + 2 * random(e)


LEVELS = {"mean": bias, "mean + 2 sd": _upper(bias)}
"""Readings of how large a spurious velocity is."""
RESOLUTIONS: dict[str, Callable[..., FloatArray]] = {"smaller": np.minimum, "larger": np.maximum}
"""Readings of below the resolution(s): of both, or of one."""


def smaller(e: Ensemble) -> FloatArray:
    """The smaller of the two velocity resolutions, (n,)."""
    return np.minimum(*e.resolutions)


def along(e: Ensemble, angle: float) -> Sample:
    """Component along `angle` (degrees). In `c0`, positive that way."""
    return Sample(e.wavenumbers, e.velocities @ [np.cos(np.radians(angle)), np.sin(np.radians(angle))])


def across(e: Ensemble, angle: float) -> Sample:
    """Component a quarter turn on from `angle` (degrees)."""
    return along(e, angle + 90)


def direction(e: Ensemble, angle: float) -> Sample:
    """Its mean is the direction of the mean vector, degrees from `angle` in -180 ... 180; linear in what deviates. The
    values are the tangent at the means, so that their standard error is that of the angle to first order.
    """
    u, v = along(e, angle), across(e, angle)
    x, y = u.mean, v.mean
    length = np.maximum(x**2 + y**2, 1e-300)
    return Sample(u.k, np.degrees(np.arctan2(y, x) + (x * (v.values - y) - y * (u.values - x)) / length))


def magnitude(sample: Sample) -> Sample:
    """Its mean is the size of the mean of `sample`."""
    return np.where(sample.mean < 0, -1.0, 1.0) * sample


def ratio(part: Sample, whole: Sample) -> Sample:
    """Its mean is that of `part` over that of `whole`; linear in what deviates from the means."""
    p, w = part.mean, whole.mean
    safe = np.where(w == 0, np.nan, w)
    return Sample(part.k, p / safe + (part.values - p) / safe - p * (whole.values - w) / safe**2)


@dataclass(frozen=True, eq=False)
class Tally:
    """A comparison at each shell: it holds by `margin` (n,), known to one standard `error` (n,).

    `margin` is in the unit of what is compared, positive where it holds. What is neither `shown` nor `contradicted` is
    open. Shells without a number are left out.
    """

    k: FloatArray
    margin: FloatArray
    error: FloatArray
    shown: Mask
    contradicted: Mask

    @property
    def size(self) -> int:
        """How many shells."""
        return self.margin.size

    @property
    def every(self) -> Answer:
        """At every shell: None if it is contradicted at none but not shown at all."""
        return False if self.contradicted.any() or not self.size else True if self.shown.all() else None

    @property
    def most(self) -> Answer:
        """At over half of the shells: None if the open ones decide."""
        if 2 * self.shown.sum() > self.size:
            return True
        return False if 2 * (self.size - self.contradicted.sum()) <= self.size else None

    @property
    def figure(self) -> dict[str, Any]:
        """In JSON: counts of shells, and the mean margin."""
        mean = float(f"{np.mean(self.margin):.3g}") if self.size else None
        return {
            "shown": int(self.shown.sum()),
            "contradicted": int(self.contradicted.sum()),
            "of": self.size,
            "mean_margin": mean,
        }


def _tally(k: FloatArray, margin: FloatArray, error: FloatArray, shown: Mask, contradicted: Mask) -> Tally:
    known = np.isfinite(margin)
    return Tally(k[known], margin[known], error[known], shown[known], contradicted[known])


def positive(k: FloatArray, margin: FloatArray, error: FloatArray) -> Tally:
    """The margin is positive; one that is exactly zero, and surely so, is not."""
    shown = margin > 2 * error
    return _tally(k, margin, error, shown, ~shown & (margin <= -2 * error))


def above(sample: Sample, limit: float | FloatArray = 0.0) -> Tally:
    """The mean is above the limit."""
    return positive(sample.k, sample.mean - limit, np.nan_to_num(sample.error))


def below(sample: Sample, limit: float | FloatArray = 0.0) -> Tally:
    """The mean is below the limit."""
    return above(-1.0 * sample, -np.asarray(limit))


def significant(difference: Sample, resolution: FloatArray) -> Tally:
    """The mean difference, of either sign, is over two standard errors and over 10 % of `resolution`. Both are tested:
    what is not significant is contradicted, there is nothing open.
    """
    size, error = np.abs(difference.mean), np.nan_to_num(difference.error)
    limit = np.maximum(2 * error, 0.1 * resolution)
    return _tally(difference.k, size - limit, error, size > limit, size <= limit)


def alike(difference: Sample, resolution: FloatArray) -> Tally:
    """The mean difference is not significant."""
    other = significant(difference, resolution)
    return Tally(other.k, -other.margin, other.error, other.contradicted, other.shown)


def within(difference: Sample, limit: float | FloatArray) -> Tally:
    """The mean difference, of either sign, is at most `limit`. As `below` it may be open."""
    return below(magnitude(difference), limit)


def pooled(*tallies: Tally) -> Tally:
    """The shells of all of them."""
    return Tally(*(np.concatenate([getattr(t, name) for t in tallies]) for name in Tally.__dataclass_fields__))


@dataclass(frozen=True, eq=False)
class Reading:
    """One way to read a statement: what is chosen, whether it then holds, the figure, and the comparisons behind.
    `holds` None is open.

    - `choices`: by name what was chosen where the words leave it open, for instance `window: hann`.
    - `figure`: plain values for the JSON, counts of shells as `Tally.figure` has them.
    - `tallies`: the comparisons by name, for the picture.
    """

    choices: Mapping[str, str]
    holds: Answer
    figure: Any
    tallies: Mapping[str, Tally] = field(default_factory=dict)

    @property
    def words(self) -> str:
        """The choices in a line."""
        return ", ".join(f"{name}: {chosen}" for name, chosen in self.choices.items()) or "as it stands"


def both(*answers: Answer) -> Answer:
    """All of them hold."""
    return False if False in answers else None if None in answers else True


def _reading(choices: Mapping[str, str], holds: Answer, parts: Mapping[str, Tally]) -> Reading:
    figures = {name: part.figure for name, part in parts.items()}
    return Reading(choices, holds, figures if len(parts) > 1 else next(iter(figures.values())), parts)


def every(choices: Mapping[str, str], **parts: Tally) -> Iterator[Reading]:
    """For a statement that says all: every part at every shell."""
    yield _reading(choices, both(*(part.every for part in parts.values())), parts)


def most(choices: Mapping[str, str], **parts: Tally) -> Iterator[Reading]:
    """For a statement that says most: every part at over half of the shells."""
    yield _reading(choices, both(*(part.most for part in parts.values())), parts)


def either(choices: Mapping[str, str], **parts: Tally) -> Iterator[Reading]:
    """For a statement that does not say: a reading for each. So the verdict depends on that choice if the answers
    differ.
    """
    yield from every({**choices, "holds at": "every shell"}, **parts)
    yield from most({**choices, "holds at": "most shells"}, **parts)
