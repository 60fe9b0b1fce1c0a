"""Clues: the questions that a code failed, with what it answered and what it should have, for whoever explains them.

Used by `replays`, which asks the reference with a fault the same, and by `cure`, which asks the code itself again.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from leakref._base import FloatArray
from leakref.certify.checks.registry import Case, Check
from leakref.certify.runner import select
from leakref.certify.verdict import WRONG, Finding

__all__ = [
    "EXACT_FOR_ALL",
    "FULL",
    "OTHERWISE",
    "TRUE",
    "TWICE",
    "USUAL",
    "Clue",
    "Hypothesis",
    "digits",
    "gather",
    "parts",
    "velocities",
    "worst",
]

EXACT_FOR_ALL = (
    "recovery.pair",
    "recovery.ring",
    "signs.aligned",
    "currents.aligned",
    "depth.aligned",
    "depth.change",
    "depth.ring",
    "depth.tension",
    "leakage.aligned",
)
"""Checks of so few waves that other algorithms with the same mistake give the same answers."""
TRUE = ("signs", "recovery", "currents", "shear", "depth", "leakage")
"""Families in which what an answer should be does not depend on the code's other answers."""
FULL = 15.6
"""Digits of float64."""
USUAL = 0.3
"""In c0: digits of slower velocities are counted from here, since optimisers stop at so much of c0."""
OTHERWISE = 0.1
"""Of the answers may be other ones: a shell in another basin does not refute an explanation."""
TWICE = "behaviour.deterministic"
"""The check that a code fails whose numbers are no evidence."""


@dataclass(frozen=True, eq=False)
class Clue:
    """A question: a check on a case, and what came of it."""

    check: Check
    case: Case
    finding: Finding

    @property
    def cost(self) -> float:
        """Of asking it again: samples of the cube times wavenumbers, on any machine the same."""
        return float(
            sum(
                np.prod(call.asked.get("shape", (1,))) * np.size(call.asked.get("wavenumbers", 1))
                for call in self.finding.calls
            )
        )


def gather(findings: Sequence[Finding], seed: int, golden: int, most: int | None = None) -> list[Clue]:
    """What failed, from cheap to dear, each family once before any twice; `most` of them.

    `seed` and `golden` are those of the run, so that the same questions are asked again. A family that fails in many
    ways is not to hide another: a wrong sign fails dozens of questions, a missing window a few.
    """
    by_id = {f"{c.id}[{case.id}]": (c, case) for c, case in select(seed=seed, golden=golden)}
    found = sorted(
        (Clue(*by_id[f.id], f) for f in findings if f.verdict in WRONG and f.id in by_id), key=lambda clue: clue.cost
    )
    rank: dict[str, int] = {}
    order = []
    for clue in found:
        rank[clue.check.family] = rank.get(clue.check.family, -1) + 1
        order.append((rank[clue.check.family], clue.cost))
    return [found[n] for n in sorted(range(len(found)), key=order.__getitem__)][:most]


def velocities(figures: Mapping[str, Any]) -> tuple[FloatArray, FloatArray]:
    """Velocities of a finding and what they should be, (m, 2) each, of all its methods; none where it has none."""
    rows = [np.empty((0, 2)), np.empty((0, 2))]
    for one in parts(figures):
        found = np.atleast_2d(np.asarray(one.get("velocities", one.get("velocity")), dtype=np.float64))
        should = np.atleast_2d(np.asarray(one["should_be"], dtype=np.float64))
        if found.shape == should.shape and found.shape[1] == 2:
            there = np.isfinite(found).all(axis=1)
            rows = [np.concatenate([rows[0], found[there]]), np.concatenate([rows[1], should[there]])]
    return rows[0], rows[1]


def parts(figures: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
    """The figures of each method: they are within those of the finding where there are several."""
    if "should_be" in figures and ("velocities" in figures or "velocity" in figures):
        yield figures
    for value in figures.values():
        if isinstance(value, Mapping):
            yield from parts(value)


def digits(found: FloatArray, should: FloatArray) -> FloatArray:
    """Of agreement, (m,), of velocities (m, 2), those slower than `USUAL` counted from there."""
    scale = np.abs(should).max(initial=USUAL)
    off = np.abs(found - should).max(axis=1) / scale
    return np.clip(-np.log10(np.maximum(off, 10**-FULL)), 0.0, FULL)


def worst(digits: Sequence[float]) -> float:
    """What nine answers in ten agree to."""
    return float(np.quantile(digits, OTHERWISE, method="lower")) if len(digits) else 0.0


@dataclass(frozen=True)
class Hypothesis:
    """What explains failures: its id, what it is in `words`, and to how many `digits` the answers are right with it.

    `kind`: a `fault` that makes the reference give the same answers, a `repair` that makes the code's own come right,
    or a `symptom`, which stands in the findings. `digits` are None where no numbers were compared.
    """

    fault: str
    words: str
    digits: float | None
    kind: str = "fault"

    def record(self) -> dict[str, Any]:
        """As in the JSON of `leakref certify`."""
        return {"fault": self.fault, "digits": self.digits, "words": self.words, "kind": self.kind}
