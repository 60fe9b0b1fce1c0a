"""The register of claims, and what came of them.

A claim is a function that yields readings, registered with its words by `claim`. **The verdict is that of the first
reading, the one nearest to the words**, which is named before anything is looked at; the others say how robust it is,
and on which choice it turns. The paper shows nothing below k = 0.5, so neither does the nearest reading; every claim is
read a second time with all shells. Modules of claims register on import, in whatever order; `claims.CLAIMS` has them
sorted.

A claim in its module reads:

    @claim("R5", "with Hann every bias is well below the resolutions", "sec:resolution", "Mean of |c| ...")
    def _(see):
        ensembles = [see(domain(length, t), "hann") for length, t in ...]
        yield from every({"level": "mean"}, well_below=pooled(*(below(bias(e), ...) for e in ensembles)))
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from leakref._base import LeakrefError
from leakref.claims.evidence import PLAIN, Evidence, Setting
from leakref.claims.words import Answer, Reading, Tally
from leakref.ensemble import Ensemble

__all__ = ["CLAIMS", "SMALLEST", "Claim", "Finding", "claim", "position", "select"]

REPRODUCED, NOT_REPRODUCED, OPEN = "reproduced", "not reproduced", "open"
Predicate = Callable[[Any], Iterable[Reading]]
SMALLEST = 0.5
"""Smallest wavenumber that the paper's figures show, in k0."""
UNTOLD = "the sampling error"
"""What a verdict turns on where a reading is open."""
_MANY = 100
"""Times as many realisations as nobody will make: what they would not tell is said to be beyond that."""
_VERDICTS: dict[Answer, str] = {True: REPRODUCED, False: NOT_REPRODUCED, None: OPEN}


class _Shown:
    """The evidence as the paper's figures show it: nothing below the `smallest` wavenumber. Where NSP is asked for it
    is the method `nsp`, which is itself unless another start is to be tried.
    """

    def __init__(self, evidence: Evidence, smallest: float, nsp: str = "nsp") -> None:
        self._evidence, self._smallest, self._nsp, self.cut = evidence, smallest, nsp, False

    def __call__(self, configuration: Any, window: str, method: str = "nsp", setting: Setting = PLAIN) -> Ensemble:
        e = self._evidence(configuration, window, self._nsp if method == "nsp" else method, setting)
        shown = e.wavenumbers >= self._smallest - 1e-9
        self.cut |= not shown.all()
        return replace(e, wavenumbers=e.wavenumbers[shown], velocities=e.velocities[:, shown], notes=e.notes[:, shown])

    def __getattr__(self, name: str) -> Any:
        return getattr(self._evidence, name)


@dataclass(frozen=True)
class Claim:
    """A statement of the paper: its `words` in short, the `label` where it stands, how it is tested.

    - `id`: a letter for the group and a number; `label`: the section, figure or abstract of the paper.
    - `test`: how it is tested, in words; `predicate`: takes the Evidence and yields the readings.
    - `smallest`: the least wavenumber of the nearest reading, in k0; `starts`: whether it is read a second time with
      NSP from the best point of a lattice (D6), since in narrow untapered seas the start decides where NSP ends.
    """

    id: str
    words: str
    label: str
    test: str
    predicate: Predicate
    smallest: float = SMALLEST
    starts: bool = False

    def judge(self, evidence: Evidence) -> Finding:
        """Evaluate it, on the ensembles it asks for. Ensembles that are not there are computed now, which may take
        long. The readings with all shells follow those from k = 0.5 on, those from a lattice come last.
        """
        see = _Shown(evidence, self.smallest)
        found = list(self.predicate(see))
        chosen = {"shells": f"from {self.smallest:g}"} if see.cut else {}
        read = [({**chosen, "start (D6)": "rest"} if self.starts else chosen, found)]
        if see.cut:
            read += [({**read[0][0], "shells": "all"}, list(self.predicate(evidence)))]
        if self.starts:
            lattice = list(self.predicate(_Shown(evidence, self.smallest, "nsp-grid")))
            read += [({**chosen, "start (D6)": "best of a lattice"}, lattice)]
        return Finding(self, tuple(replace(r, choices={**r.choices, **c}) for c, some in read for r in some))


@dataclass(frozen=True, eq=False)
class Finding:
    """What came of a claim: its readings, the first of which is the nearest to the words.

    `readings` come in the order in which the predicate yields them.
    """

    claim: Claim
    readings: tuple[Reading, ...]

    @property
    def nearest(self) -> Reading:
        """The reading nearest to the words."""
        return self.readings[0]

    @property
    def verdict(self) -> str:
        """What the nearest reading says: reproduced, not reproduced, or open, where the sampling error hides it."""
        return _VERDICTS[self.nearest.holds]

    @property
    def parts(self) -> dict[str, str]:
        """The verdict of each part, for a statement of several."""
        return {name.replace("_", " "): _VERDICTS[answer] for name, answer in self.nearest.parts.items()}

    @property
    def robust(self) -> bool:
        """Every reading says the same, and says something."""
        return {reading.holds for reading in self.readings} in ({True}, {False})

    @property
    def depends_on(self) -> list[str]:
        """The choices that alone change the answer; the sampling error where it leaves one open. In the order of the
        readings. Two choices that only together change it are not named.
        """
        found = []
        for name in dict.fromkeys(name for reading in self.readings for name in reading.choices):
            answers: dict[str, set[bool | None]] = {}
            for reading in self.readings:
                rest = repr([item for item in reading.choices.items() if item[0] != name])
                answers.setdefault(rest, set()).add(reading.holds)
            if any({True, False} <= group for group in answers.values()):
                found.append(name)
        return found + [UNTOLD] * any(reading.holds is None for reading in self.readings)

    @property
    def would_decide(self) -> str:
        """Of each part that is open: how much of it, and how many more realisations would tell. Else empty."""
        nearest = self.nearest
        parts = [name for name in nearest.tallies if nearest.parts.get(name, nearest.holds) is None]
        said = [(name.replace("_", " "), _would_decide(nearest.tallies[name])) for name in parts]
        return "; ".join(f"{name}: {words}" if nearest.parts else words for name, words in said)

    @property
    def where(self) -> list[dict[str, str]]:
        """At which wavenumbers, in which seas, each part of the nearest reading is shown, contradicted and open."""
        return [line for part, tally in self.nearest.tallies.items() for line in _where(part.replace("_", " "), tally)]

    def record(self) -> dict[str, Any]:
        """As in the JSON of `leakref claims`: the figure is that of the nearest reading; `holds` null is open."""
        return {
            "id": self.claim.id,
            "verdict": self.verdict,
            "robust": self.robust,
            "parts": self.parts,
            "figure": self.nearest.figure,
            "where": self.where,
            "depends_on": self.depends_on,
            "would_decide": self.would_decide,
            "words": self.claim.words,
            "label": self.claim.label,
            "test": self.claim.test,
            "readings": [{"reading": r.words, "holds": r.holds, "figure": r.figure} for r in self.readings],
        }


def _would_decide(tally: Tally) -> str:
    """What the comparisons that are open need, and how many they are.

    A comparison is shown at two standard errors, which fall with the root of the number; to contradict *every* takes
    the family's level.
    """
    undecided = ~tally.shown & ~tally.contradicted
    undecided = undecided if undecided.any() else ~tally.shown
    margin, error = tally.margin[undecided], tally.error[undecided]
    seldom = ~np.isfinite(margin + error)
    with np.errstate(divide="ignore", invalid="ignore"):
        needed = np.where(margin > 0, 2.0, tally.family_level) * error / np.abs(margin)
        times = np.where(seldom, 0.0, np.where(error > 0, needed**2, np.inf))
    late, lacking, known = int((times > _MANY).sum()), int(seldom.sum()), int((~seldom).sum())
    comparisons = f"{known} of {tally.size} comparisons that {'is' if known == 1 else 'are'} undecided"
    words = []
    if late:
        lie = f"{'lies' if late == 1 else 'lie'} on the limit"
        which = f"the {comparisons} {lie}" if late == known else f"of the {comparisons} {late} {lie}"
        words.append(f"no number of realisations that can be made: {which}")
    elif known:
        factor = max(1.1, float(f"{times.max():.2g}"))
        words.append(f"{factor:g} times as many realisations, with the same means, would settle the {comparisons}")
    if lacking:
        words.append(f"seas with more numbers: in {lacking} of {tally.size} comparisons most realisations have none")
    return "; ".join(words)


def _where(part: str, tally: Tally) -> list[dict[str, str]]:
    """A line for each sea: the wavenumbers as ranges of neighbours, in k0. Pooled values (k = 0) have none."""
    states = {"shown": tally.shown, "contradicted": tally.contradicted, "open": ~tally.shown & ~tally.contradicted}
    lines = []
    for sea in dict.fromkeys(tally.sea):
        own = tally.sea == sea
        here = sorted(set(np.round(tally.k[own], 3)))
        spans = {name: _ranges(here, set(np.round(tally.k[own & mask], 3))) for name, mask in states.items()}
        lines.append({"part": part, "sea": sea, **{name: words for name, words in spans.items() if words}})
    return lines


def _ranges(all_of_them: Sequence[float], chosen: set[float]) -> str:
    """Those chosen, neighbours in the list as a range: 0.5 to 0.9, 1.2."""
    if not any(chosen):
        return "all shells together" if chosen else ""
    runs: list[list[float]] = []
    follows = False
    for k in all_of_them:
        if k in chosen:
            runs = [*runs[:-1], [*runs[-1], k]] if follows else [*runs, [k]]
        follows = k in chosen
    return ", ".join(f"{run[0]:g}" if len(run) == 1 else f"{run[0]:g} to {run[-1]:g}" for run in runs)


CLAIMS: dict[str, Claim] = {}
"""Every claim by its id, as their modules are imported."""


def claim(
    id: str, words: str, label: str, test: str, smallest: float = SMALLEST, starts: bool = False
) -> Callable[[Predicate], Predicate]:
    """Register the function below as the predicate of a claim.

    `words` are the statement in short, `label` where it stands; `smallest` is the least wavenumber of the nearest
    reading; `starts` asks for readings with NSP from a lattice as well. Two claims of one id are a fault of ours, an
    assertion.
    """

    def register(predicate: Predicate) -> Predicate:
        assert id not in CLAIMS, id
        CLAIMS[id] = Claim(id, words, label, test, predicate, smallest, starts)
        return predicate

    return register


def position(id: str) -> tuple[int, int]:
    """Where a claim stands in the paper's list: its group, its number."""
    return "WNAPRUGMB".index(id[0]), int(id[1:])


def select(ids: Sequence[str]) -> list[Claim]:
    """The claims named, one by one or by the letter of their group; all in order if none is. Raises LeakrefError.
    Letters may be small.
    """
    found: dict[str, Claim] = {}
    for name in ids or sorted(CLAIMS, key=position):
        matching = {key: CLAIMS[key] for key in sorted(CLAIMS, key=position) if name.upper() in (key, key[0])}
        if not matching:
            raise LeakrefError(
                "claims", f"no claim is called {name!r}", f"choose from {', '.join(sorted(CLAIMS, key=position))}"
            )
        found |= matching
    return list(found.values())
