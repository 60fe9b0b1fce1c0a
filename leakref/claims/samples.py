"""Samples: what the realisations of a sea say at each wavenumber, and the statistics whose means the claims compare.

A comparison is of means over realisations, and always of realisation i with realisation i: seas on one lattice share
their phases, and where they do not the pairing does no harm. A statistic that is no mean is written as one, by the
influence of each realisation, so that every comparison has a standard error.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from typing import Any

import numpy as np

from leakref._base import FloatArray, IntArray, mean_of_known
from leakref.cases import Configuration
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
    "Band",
    "Sample",
    "across",
    "along",
    "bias",
    "deviation",
    "direction",
    "excess",
    "in_resolutions",
    "influence",
    "magnitude",
    "missed",
    "random",
    "ratio",
    "smaller",
    "squared",
    "total",
]

WINDOWS = ("box", "hann")
"""Untapered and tapered, as most statements compare them."""
Band = Callable[[FloatArray], Any]
"""Takes wavenumbers (n,) in `k0` and says of each whether it is inside."""
Mask = Any
_ROUNDING = 1e-9
_HALF = 0.5  # of the realisations must have a number, else the mean of those that do says nothing of the sea


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
    """Values (R, n) at wavenumbers `k` (n,), whose means over the R realisations are in question; NaN where there is no
    number. `sea` says in a few words which sea they are of, or which two are compared.
    """

    k: FloatArray
    values: FloatArray
    sea: str = ""
    __array_ufunc__ = None  # an array times a sample is a sample

    @property
    def count(self) -> IntArray:
        """Realisations with a number, (n,)."""
        return np.isfinite(self.values).sum(axis=0)

    @property
    def lacking(self) -> Mask:
        """Where some realisations have no number, (n,)."""
        return self.count < len(self.values)

    @property
    def mean(self) -> FloatArray:
        """(n,); NaN where no realisation has a number."""
        return mean_of_known(self.values)

    @property
    def error(self) -> FloatArray:
        """Standard error of the mean, (n,); NaN, unknown, where fewer than two realisations or than half of them have a
        number.
        """
        count = self.count
        square = np.nansum((self.values - self.mean) ** 2, axis=0)
        error = np.sqrt(square / np.maximum(count - 1, 1) / np.maximum(count, 1))
        return np.where((count >= 2) & (count >= _HALF * len(self.values)), error, np.nan)

    def __add__(self, other: Sample) -> Sample:
        """At the wavenumbers and in the realisations that both have. Where one of the two has no number, the sum has
        none.
        """
        mine, theirs = np.nonzero(np.abs(self.k[:, None] - other.k) < 1e-6)
        rows = min(len(self.values), len(other.values))
        values = self.values[:rows, mine] + other.values[:rows, theirs]
        return Sample(self.k[mine], values, " against ".join(dict.fromkeys(filter(None, (self.sea, other.sea)))))

    def __sub__(self, other: Sample) -> Sample:
        return self + -1.0 * other

    def __rmul__(self, factor: float | FloatArray) -> Sample:
        return replace(self, values=factor * self.values)

    def at(self, band: Band) -> Sample:
        """Only the wavenumbers of a band."""
        inside = band(self.k)
        return replace(self, k=self.k[inside], values=self.values[:, inside])

    def over(self, band: Band = ALL) -> Sample:
        """The mean over the shells of a band: one value a realisation, (R, 1). NaN where one of the shells has no
        number.
        """
        chosen = self.at(band)
        return Sample(np.zeros(1), chosen.values.mean(axis=1, keepdims=True), self.sea)


_SENSES = {90.0: "following", 0.0: "crossing", -90.0: "opposing"}
"""Of a current, in words that need no angle: where it goes to, and how that lies to waves that go to 90 degrees."""


def _named(c: Configuration) -> str:
    """What a sea is called beside others of its case; a current by where it goes to, seen from waves to 90 degrees."""
    if "speed" not in c.varied or c.current_direction not in _SENSES:
        return c.id.partition("/")[2].replace("=", " ").replace(",", ", ")
    current = f"current {c.speed:g} {_SENSES[c.current_direction]}" if c.speed else "still water"
    return f"{current}, turned by {c.rotation:g}" if c.rotation else current


def _of(e: Ensemble, values: FloatArray) -> Sample:
    """Values (R, n) of an ensemble, under the name of its sea."""
    return Sample(e.wavenumbers, values, _named(e.configuration))


def total(samples: list[Sample]) -> Sample:
    """The sum of several, each in the realisations that all have."""
    return reduce(Sample.__add__, samples)


def bias(e: Ensemble) -> Sample:
    """Its mean is the mean of |c|."""
    return _of(e, e.magnitudes)


def deviation(sample: Sample) -> Sample:
    """Its mean is the standard deviation s of `sample` (n - 1); its values are the jackknife's, n s - (n - 1) s_i with
    s_i that of all but the i-th, moved so that s is their mean. By them the error of s, and of differences between
    paired ones, is that of a mean, also where few realisations make up most of s: to first order in them alone, what
    is far out would count for less than it does. Of two realisations nothing is known.
    """
    n, square = sample.count, sample.count * sample.error**2
    with np.errstate(divide="ignore", invalid="ignore"):
        without = ((n - 1) * square - (sample.values - sample.mean) ** 2 * n / (n - 1)) / (n - 2)
    values = np.asarray(-(n - 1) * np.sqrt(np.maximum(without, 0)), dtype=np.float64)
    return replace(sample, values=np.sqrt(square) + values - mean_of_known(values))


def random(e: Ensemble) -> Sample:
    """Its mean is the random part, the standard deviation of |c|."""
    return replace(deviation(bias(e)), sea=f"{bias(e).sea}, random part".removeprefix(", "))


STATISTICS: dict[str, Callable[[Ensemble], Sample]] = {"bias": bias, "random part": random}
"""The two parts of an error that the paper shows, as samples whose means they are."""


def missed(e: Ensemble) -> Sample:
    """Its mean is that of |c - U|. In `c0`; in still water it is `bias`."""
    return _of(e, np.hypot(*np.moveaxis(e.velocities - e.configuration.current, -1, 0)))


def excess(e: Ensemble) -> Sample:
    """Its mean is how far the mean of |c| is from U, as the paper's figures show it."""
    return magnitude(_of(e, e.magnitudes - np.hypot(*e.configuration.current)))


MEASURES: dict[str, Callable[[Ensemble], Sample]] = {"mean of |c| against U": excess, "mean of |c - U|": missed}
"""The error with a current; without one the two are the same. The first is what the figures show."""


def _upper(measure: Callable[[Ensemble], Sample]) -> Callable[[Ensemble], Sample]:
    return lambda e: replace(measure(e) + 2 * random(e), sea=measure(e).sea)


LEVELS = {"mean": bias, "mean + 2 sd": _upper(bias)}
"""Readings of how large a spurious velocity is."""
RESOLUTIONS: dict[str, Callable[..., FloatArray]] = {"smaller": np.minimum, "larger": np.maximum}
"""Readings of below the resolution(s): of both, or of one."""


def smaller(e: Ensemble) -> FloatArray:
    """The smaller of the two velocity resolutions, (n,)."""
    return np.minimum(*e.resolutions)


def in_resolutions(sample: Sample, e: Ensemble, *others: Ensemble) -> Sample:
    """In units of the smaller resolution of `e`, of all where there are others: as such, values of several shells may
    be pooled. In `c0` the lowest shell, where the resolution is poorest, would decide.
    """
    unit = np.min([np.interp(sample.k, one.wavenumbers, smaller(one)) for one in (e, *others)], axis=0)
    return (1 / unit) * sample


def along(e: Ensemble, angle: float) -> Sample:
    """Component along `angle` (degrees). In `c0`, positive that way."""
    return _of(e, e.velocities @ [np.cos(np.radians(angle)), np.sin(np.radians(angle))])


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
    values = np.degrees(np.arctan2(y, x) + (x * (v.values - y) - y * (u.values - x)) / length)
    return replace(u, values=values)


def magnitude(sample: Sample) -> Sample:
    """Its mean is the size of the mean of `sample`."""
    return np.where(sample.mean < 0, -1.0, 1.0) * sample


def squared(sample: Sample) -> Sample:
    """Its mean is the square of the mean of `sample`, less what the sampling error alone would make of it: of many
    differences that are nothing the sizes would add up, the squares do not.
    """
    mean = sample.mean
    return replace(sample, values=mean**2 - sample.error**2 + 2 * mean * (sample.values - mean))


def influence(pairs: Sequence[tuple[Ensemble, Ensemble]], of: Callable[[Ensemble], Sample] = bias) -> Sample:
    """Its mean is the mean square of the differences between the two of each pair, in units of the smaller resolution
    of both.
    """
    return 1 / len(pairs) * total([squared(in_resolutions(of(a) - of(b), a, b)).over() for a, b in pairs])


def ratio(part: Sample, whole: Sample) -> Sample:
    """Its mean is that of `part` over that of `whole`; linear in what deviates from the means."""
    p, w = part.mean, whole.mean
    safe = np.where(w == 0, np.nan, w)
    return replace(part, values=p / safe + (part.values - p) / safe - p * (whole.values - w) / safe**2)
