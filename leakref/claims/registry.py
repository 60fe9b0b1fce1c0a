"""The register of claims, and what came of them.

A claim is a function that yields readings, registered with its words by `claim`. The verdict follows from the readings
and from nothing else. Modules of claims register on import, in whatever order; `claims.CLAIMS` has them sorted.

A claim in its module reads:

    @claim("R5", "with Hann every bias is well below the resolutions", "sec:resolution", "Mean of |c| ...")
    def _(see):
        ensembles = [see(domain(length, t), "hann") for length, t in ...]
        yield from every({"level": "mean"}, well_below=pooled(*(below(bias(e), ...) for e in ensembles)))
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from leakref._base import LeakrefError
from leakref.claims.evidence import Evidence
from leakref.claims.words import Reading

__all__ = ["CLAIMS", "Claim", "Finding", "claim", "position", "select"]

REPRODUCED, NOT_REPRODUCED, DEPENDS = "reproduced", "not reproduced", "depends on"
Predicate = Callable[[Evidence], Iterable[Reading]]


@dataclass(frozen=True)
class Claim:
    """A statement of the paper: its `words` in short, the `label` where it stands, how it is tested.

    - `id`: a letter for the group and a number; `label`: the section, figure or abstract of the paper.
    - `test`: how it is tested, in words; `predicate`: takes the Evidence and yields the readings.
    """

    id: str
    words: str
    label: str
    test: str
    predicate: Predicate

    def judge(self, evidence: Evidence) -> Finding:
        """Evaluate it, on the ensembles it asks for. Ensembles that are not there are computed now, which may take
        long.
        """
        return Finding(self, tuple(self.predicate(evidence)))


@dataclass(frozen=True, eq=False)
class Finding:
    """What came of a claim: its readings, the first of which is the nearest to the words.

    `readings` come in the order in which the predicate yields them. The verdict is one of `reproduced`, `not
    reproduced` and `depends on`.
    """

    claim: Claim
    readings: tuple[Reading, ...]

    @property
    def verdict(self) -> str:
        """Reproduced if every reading holds, not reproduced if none does, else it depends. A reading that is open makes
        it depend, on the sampling error.
        """
        answers = {reading.holds for reading in self.readings}
        return REPRODUCED if answers == {True} else NOT_REPRODUCED if answers == {False} else DEPENDS

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
            if any(len(group) > 1 for group in answers.values()):
                found.append(name)
        return found + ["the sampling error"] * any(reading.holds is None for reading in self.readings)

    def record(self) -> dict[str, Any]:
        """As in the JSON of `leakref claims`: the figure is that of the first reading; `holds` null is open."""
        return {
            "id": self.claim.id,
            "verdict": self.verdict,
            "figure": self.readings[0].figure,
            "depends_on": self.depends_on,
            "words": self.claim.words,
            "label": self.claim.label,
            "test": self.claim.test,
            "readings": [{"reading": r.words, "holds": r.holds, "figure": r.figure} for r in self.readings],
        }


CLAIMS: dict[str, Claim] = {}
"""Every claim by its id, as their modules are imported."""


def claim(id: str, words: str, label: str, test: str) -> Callable[[Predicate], Predicate]:
    """Register the function below as the predicate of a claim.

    `words` are the statement in short, `label` where it stands. Two claims of one id are a fault of ours, an assertion.
    """

    def register(predicate: Predicate) -> Predicate:
        assert id not in CLAIMS, id
        CLAIMS[id] = Claim(id, words, label, test, predicate)
        return predicate

    return register


def position(id: str) -> tuple[int, int]:
    """Where a claim stands in the paper's list: its group, its number."""
    return "WNAPRUGB".index(id[0]), int(id[1:])


def select(ids: Sequence[str]) -> list[Claim]:
    """The claims named, one by one or by the letter of their group; all in order if none is. Raises LeakrefError.
    Letters may be small.
    """
    found: dict[str, Claim] = {}
    for name in ids or sorted(CLAIMS, key=position):
        matching = {key: CLAIMS[key] for key in sorted(CLAIMS, key=position) if name.upper() in (key, key[0])}
        if not matching:
            raise LeakrefError("claims", f"no claim is called {name!r}", f"choose from {', '.join(CLAIMS)}")
        found |= matching
    return list(found.values())
