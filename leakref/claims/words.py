"""The vocabulary of the claims: comparisons with their sampling error, and readings of a statement.

Rules, fixed before anything was looked at. At a shell a comparison is *shown* if it holds by more than two standard
errors, *contradicted* if it fails by as much, else open; with few realisations, or where half of them have no number,
two become more, or no error is known and nothing is told. *Most* is over half of the shells. *Negligible* is below the
smaller resolution; *significant*, over two standard errors and over 10 % of the smaller resolution; *alike* the
reverse of it, shown only where the whole interval lies within these 10 %, so that few realisations leave it open;
*about*, within 10 %. Where the words leave open whether all shells are meant, the nearest reading is every shell.

*At every shell* has a level for the family: one shell of fifty is beyond two standard errors by chance, and does not
contradict. What contradicts it does so with a chance of 5 % or less that all of them agree.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from scipy import stats

from leakref._base import FloatArray
from leakref.claims.samples import Sample, magnitude

__all__ = [
    "Answer",
    "Mask",
    "Reading",
    "Tally",
    "above",
    "alike",
    "below",
    "both",
    "either",
    "every",
    "most",
    "pooled",
    "positive",
    "significant",
    "within",
]

Answer = bool | None
"""Holds, does not hold, or None: the sampling error does not tell."""
Mask = Any
_LEVEL = float(stats.norm.sf(2))
"""One-sided, of a shell by itself: two standard errors of a normal variable."""
_FEWEST = 5
"""With fewer realisations the width of an interval is a guess, and nothing is called alike."""
_FAMILY = 0.05
"""The chance, at most, that a statement which holds at every shell is contradicted."""


@dataclass(frozen=True, eq=False)
class Tally:
    """A comparison at each shell: it holds by `margin` (n,), known to one standard `error` (n,), NaN where it is not.

    `margin` is in the unit of what is compared, positive where it holds. `shown` says where it holds for sure,
    `against` is the chance (n,) of so much against it if it held. What is neither shown nor contradicted is open: also
    a shell without a number. `lacking` are the shells where some realisation has none. `sea` names the sea of each.
    """

    k: FloatArray
    margin: FloatArray
    error: FloatArray
    shown: Mask
    against: FloatArray
    lacking: Mask
    sea: Any

    @property
    def contradicted(self) -> Mask:
        """Where it fails for sure, (n,): each shell by itself."""
        return ~self.shown & (self.against <= _LEVEL)

    @property
    def size(self) -> int:
        """How many shells."""
        return self.margin.size

    @property
    def family_level(self) -> float:
        """Standard errors by which one shell contradicts them all: of the family of all, and of both sides of each."""
        return float(stats.norm.isf(min(_LEVEL, _FAMILY / (2 * max(self.size, 1)))))

    def _refuted(self) -> bool:
        """At one shell or more, at the level of the family."""
        return bool((self.against[~self.shown] <= stats.norm.sf(self.family_level)).any())

    @property
    def every(self) -> Answer:
        """At every shell: None if it is contradicted at none but not shown at all."""
        return False if not self.size or self._refuted() else True if self.shown.all() else None

    @property
    def most(self) -> Answer:
        """At over half of the shells: None if the open ones decide."""
        if 2 * self.shown.sum() > self.size:
            return True
        return False if 2 * (self.size - self.contradicted.sum()) <= self.size else None

    @property
    def some(self) -> Answer:
        """At one shell at least: None if none shows it and not all contradict it."""
        return True if self.shown.any() else False if self.contradicted.all() else None

    @property
    def figure(self) -> dict[str, Any]:
        """In JSON: counts of shells, and the mean margin."""
        known = self.margin[np.isfinite(self.margin)]
        found = {
            "shown": int(self.shown.sum()),
            "contradicted": int(self.contradicted.sum()),
            "of": self.size,
            "mean_margin": float(f"{known.mean():.3g}") if known.size else None,
        }
        return found | ({"lacking_numbers": int(self.lacking.sum())} if self.lacking.any() else {})


def _tally(sample: Sample, margin: FloatArray, shown: Mask, against: FloatArray) -> Tally:
    """A comparison that tells nothing, for or against, where the margin or its error is not known."""
    unknown = np.isnan(margin) | np.isnan(sample.error)  # nothing is told there, for or against
    return Tally(
        sample.k,
        margin,
        sample.error,
        shown & ~unknown,
        np.where(unknown, 1.0, against),
        sample.lacking,
        np.full(sample.k.size, sample.sea, dtype=object),
    )


def _chance(margin: FloatArray, sample: Sample) -> FloatArray:
    """Of a mean that is larger by `margin` or more if the true one is not, by Student's t; where there is no scatter, 0
    or 1.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        t = np.where(sample.error > 0, margin / sample.error, np.where(margin > 0, np.inf, -np.inf))
    return stats.t.sf(t, np.maximum(sample.count - 1, 1))


def _reach(sample: Sample) -> FloatArray:
    """Two standard errors, or what they become with few realisations."""
    return stats.t.isf(_LEVEL, np.maximum(sample.count - 1, 1)) * sample.error


def positive(k: FloatArray, margin: FloatArray, error: FloatArray) -> Tally:
    """The margin is positive, with an error that was found otherwise; one that is zero, and surely so, is not."""
    with np.errstate(divide="ignore", invalid="ignore"):
        t = np.where(error > 0, margin / error, np.where(margin > 0, np.inf, -np.inf))
    no = np.zeros(margin.size, dtype=bool)
    return Tally(k, margin, error, t > 2, stats.norm.cdf(t), no, np.full(k.size, "", dtype=object))


def above(sample: Sample, limit: float | FloatArray = 0.0) -> Tally:
    """The mean is above the limit; one that is on it, and surely so, is not."""
    margin = sample.mean - limit
    exactly = (margin == 0) & (sample.error == 0)
    return _tally(sample, margin, _chance(margin, sample) < _LEVEL, np.where(exactly, 0.0, _chance(-margin, sample)))


def below(sample: Sample, limit: float | FloatArray = 0.0) -> Tally:
    """The mean is below the limit."""
    return above(-1.0 * sample, -np.asarray(limit))


def significant(difference: Sample, resolution: FloatArray) -> Tally:
    """The mean difference, of either sign, is over two standard errors and over 10 % of `resolution`. It is
    contradicted where it surely lies within these 10 %, as in `alike`.
    """
    size, limit = np.abs(difference.mean), 0.1 * resolution
    reach = _reach(difference)
    shown = (size > reach) & (size > limit)
    return _tally(difference, size - np.maximum(limit, reach), shown, _chance(limit - size, difference))


def alike(difference: Sample, resolution: FloatArray) -> Tally:
    """The mean difference lies within 10 % of `resolution`, and so does the interval of two standard errors about it,
    of five realisations or more. It is contradicted where it is `significant`.
    """
    size, limit = np.abs(difference.mean), 0.1 * resolution
    against = np.where(size > limit, _chance(size, difference), 1.0)
    shown = (size + _reach(difference) < limit) & (difference.count >= _FEWEST)
    return _tally(difference, limit - size, shown, against)


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
    - `parts`: of a statement of several parts, what became of each.
    """

    choices: Mapping[str, str]
    holds: Answer
    figure: Any
    tallies: Mapping[str, Tally] = field(default_factory=dict)
    parts: Mapping[str, Answer] = field(default_factory=dict)

    @property
    def words(self) -> str:
        """The choices in a line."""
        return ", ".join(f"{name}: {chosen}" for name, chosen in self.choices.items()) or "as it stands"

    def figured(self, **more: Any) -> Reading:
        """With more in its figure."""
        return replace(self, figure={**self.figure, **more})


def both(*answers: Answer) -> Answer:
    """All of them hold."""
    return False if False in answers else None if None in answers else True


def _reading(choices: Mapping[str, str], parts: Mapping[str, Tally], answer: Callable[[Tally], Answer]) -> Reading:
    figures = {name: part.figure for name, part in parts.items()}
    answers = {name: answer(part) for name, part in parts.items()}
    several = len(parts) > 1
    figure = figures if several else next(iter(figures.values()))
    return Reading(choices, both(*answers.values()), figure, parts, answers if several else {})


def every(choices: Mapping[str, str], **parts: Tally) -> Iterator[Reading]:
    """For a statement that says all: every part at every shell."""
    yield _reading(choices, parts, lambda part: part.every)


def most(choices: Mapping[str, str], **parts: Tally) -> Iterator[Reading]:
    """For a statement that says most: every part at over half of the shells."""
    yield _reading(choices, parts, lambda part: part.most)


def either(choices: Mapping[str, str], **parts: Tally) -> Iterator[Reading]:
    """For a statement that does not say: a reading for each, every shell first. So the verdict turns on that choice if
    the answers differ.
    """
    yield from every({**choices, "holds at": "every shell"}, **parts)
    yield from most({**choices, "holds at": "most shells"}, **parts)
